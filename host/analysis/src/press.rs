//! One press of a fingertip, from the signals to what they say: the whole path in one place.

use shared::adaptation::Relaxation;
use shared::phase::Region;

use crate::decomposition::{Channel, DecompositionError, decompose, relaxation_of, signals};
use crate::regions::{Regions, RegionsError, regions};
use palpate_fit::data::{Data, DataError};
use palpate_fit::exponentials::{self, ExponentialSum, Fit, Options, Prepared};
use palpate_fit::hold::{HoldError, HoldFit, Terms, fit_holds};
use palpate_fit::whole_motion::{self, MotionFit};
use palpate_model::{BaseLaw, Model, Separation, TERMS};
use palpate_trace::{FORCE, Trace};

/// What one press says.
#[derive(Debug)]
pub struct Press<'a> {
    /// The recording, as a set of one for the fits.
    pub data: Data<'a>,
    /// Fung's law fitted to the force over the whole motion.
    pub fit: MotionFit,
    /// Its relaxation function, which the filter runs with.
    pub relaxation: Relaxation,
    /// Every gauge with its parts and the regions of the grasp.
    pub channels: Vec<(Channel, Regions)>,
    /// Relaxation of the force in each hold.
    pub force_holds: Vec<HoldFit>,
    /// Relaxation of each gauge in each hold.
    pub gauge_holds: Vec<HoldFit>,
    /// How each gauge recovers after the release.
    pub recoveries: Vec<Recovery>,
}

/// Creep of a gauge signal back to rest after the release (3.4.1.6).
#[derive(Clone, Debug)]
pub struct Recovery {
    /// The gauge's column.
    pub signal: String,
    /// When contact was lost, s.
    pub from_s: f64,
    /// How long it was watched, s.
    pub duration_s: f64,
    /// A sum of exponentials through it.
    pub fit: Fit,
}

impl Recovery {
    /// The fitted course.
    #[must_use]
    pub fn course(&self) -> &ExponentialSum {
        &self.fit.sum
    }
}

/// Why a press cannot be analysed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PressError {
    #[error(transparent)]
    Data(#[from] DataError),
    #[error(transparent)]
    Hold(#[from] HoldError),
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
    #[error(transparent)]
    Regions(#[from] RegionsError),
    #[error("the recovery of {signal}: {source}")]
    Recovery { signal: String, source: exponentials::Error },
}

/// Fits the force, runs every gauge through the filter with the fitted relaxation function, finds the
/// regions, and fits what relaxes in each. `each` is called after every filtered sample.
///
/// # Errors
/// When the recording lacks force, motion or gauges, or a part of it cannot be fitted.
pub fn analyse(trace: &Trace, mut each: impl FnMut()) -> Result<Press<'_>, PressError> {
    let data = Data::of(std::slice::from_ref(trace), FORCE)?;
    let fit = whole_motion::fit(BaseLaw::fung(TERMS, Separation::Free), &data)?;
    let model = Model::of(&fit.chain.base, FORCE, &fit.values, &fit.standard_errors);
    let relaxation = relaxation_of(&model)?;
    let terms = Terms::Fixed(TERMS);
    let force_holds = fit_holds(trace, FORCE, terms, true)?.holds;
    let mut press = Press {
        data,
        fit,
        relaxation,
        channels: Vec::new(),
        force_holds,
        gauge_holds: Vec::new(),
        recoveries: Vec::new(),
    };
    for signal in signals(trace)? {
        let channel = decompose(trace, &signal, &relaxation, &mut each)?;
        let found = regions(trace, &channel)?;
        press.gauge_holds.extend(fit_holds(trace, &signal, terms, true)?.holds);
        press.recoveries.extend(recovery(trace, &channel, &found)?);
        press.channels.push((channel, found));
    }
    Ok(press)
}

/// The creep of a channel after the release, once the motion has left the specimen behind.
fn recovery(
    trace: &Trace,
    channel: &Channel,
    regions: &Regions,
) -> Result<Option<Recovery>, PressError> {
    let Some(last) = regions.stretches().into_iter().rfind(|s| s.region == Region::Recovery) else {
        return Ok(None);
    };
    let (time, values) =
        (&trace.elapsed(last.range.clone())[..], &channel.input[last.range.clone()]);
    // What is left decays from the largest value on.
    let highest = (0..values.len()).max_by(|&a, &b| values[a].abs().total_cmp(&values[b].abs()));
    let start = highest.unwrap_or(0);
    let failed = |source| PressError::Recovery { signal: channel.signal.clone(), source };
    let options = Options { terms: 1, ..Options::relaxation() };
    let prepared = Prepared::new(&time[start..], &options).map_err(failed)?;
    let fit = prepared.fit(&values[start..]).map_err(failed)?;
    let from_s = trace.time[last.range.start + start];
    let duration_s = time[time.len() - 1] - time[start];
    Ok(Some(Recovery { signal: channel.signal.clone(), from_s, duration_s, fit }))
}
