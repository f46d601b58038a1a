//! A recording through the very filter that runs on the device.
//!
//! Each channel is put into the device's 24-bit numbers, run through [`shared::adaptation`] sample by
//! sample, and put back into its own unit. Gauges use the device's own step of 2⁻⁸ µε; any other
//! signal gets the finest step, a power of two, that leaves a factor of two to full scale.

use shared::adaptation::{Config, ConfigError, Output, Relaxation, State};
use shared::fixed::{STRAIN_FRACTION_BITS, STRAIN_MAX};

use palpate_model::{EQUATION_3_6, Model};
use palpate_trace::{FORCE, GAUGES, Trace, runs};

/// One channel of a recording, decomposed. Every vector is as long as the recording and in the
/// channel's own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The column it came from.
    pub signal: String,
    /// One LSB of the 24-bit numbers, in the unit of the signal.
    pub lsb: f64,
    /// The signal as the filter took it: rounded to its LSB.
    pub input: Vec<f64>,
    /// Fast adapting part c1 x1; FA + SA is `input`.
    pub fa: Vec<f64>,
    /// Slow adapting part c0 u + c2 x2.
    pub sa: Vec<f64>,
    /// Elastic input u: the response without memory to the same motion.
    pub elastic: Vec<f64>,
    /// Where the signal will settle if the motion stops: c0 u.
    pub equilibrium: Vec<f64>,
    /// What is still to relax: signal − equilibrium.
    pub latent: Vec<f64>,
    /// How many samples were beyond full scale.
    pub saturated: u32,
}

impl Channel {
    fn empty(signal: &str, lsb: f64, samples: usize) -> Self {
        let column = || Vec::with_capacity(samples);
        Self {
            signal: signal.into(),
            lsb,
            input: column(),
            fa: column(),
            sa: column(),
            elastic: column(),
            equilibrium: column(),
            latent: column(),
            saturated: 0,
        }
    }

    fn push(&mut self, output: &Output) {
        let value = |lsb_count: i32| f64::from(lsb_count) * self.lsb;
        self.input.push(value(output.signal));
        self.fa.push(value(output.fa));
        self.sa.push(value(output.sa()));
        self.elastic.push(value(output.elastic));
        self.equilibrium.push(value(output.equilibrium));
        self.latent.push(value(output.latent()));
    }
}

/// Why a recording cannot be decomposed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum DecompositionError {
    #[error("{trace} has no gauge and no force to decompose; name a column with --signal")]
    NoSignal { trace: String },
    #[error("{trace} has no column `{column}`")]
    NoColumn { trace: String, column: String },
    #[error(
        "the device's filter has two exponentials; the model has {terms}: fit it with --terms 2"
    )]
    Terms { terms: usize },
    #[error("{trace}: the filter cannot run with this relaxation function: {source}")]
    Filter { trace: String, source: ConfigError },
    #[error("{trace}: `{column}` reaches {value:e}, too large for the filter: choose another unit")]
    TooLarge { trace: String, column: String, value: f64 },
    #[error("{0}")]
    Model(String),
}

/// The relaxation function of eq. 3.6, for when nothing better is known of the specimen.
#[must_use]
pub fn default_relaxation() -> Relaxation {
    let ([_, c1, c2], [v1, v2]) = EQUATION_3_6;
    Relaxation { c1, v1, c2, v2 }
}

/// The relaxation function of a fitted model, as the device takes it.
///
/// # Errors
/// When the model has another number of exponentials than two (one will do).
pub fn relaxation_of(model: &Model) -> Result<Relaxation, DecompositionError> {
    let (law, parameters) = model.law().map_err(DecompositionError::Model)?;
    let relaxation = law.relaxation(&parameters).ok_or_else(|| {
        let law = law.in_words();
        DecompositionError::Model(format!("a hold of {law} is no sum of exponentials"))
    })?;
    let mut branches = relaxation.branches;
    branches.sort_by(|a, b| b.rate.total_cmp(&a.rate));
    match branches[..] {
        [only] => Ok(Relaxation { c1: only.share, v1: only.rate, c2: 0.0, v2: only.rate }),
        [fast, slow] => {
            Ok(Relaxation { c1: fast.share, v1: fast.rate, c2: slow.share, v2: slow.rate })
        }
        _ => Err(DecompositionError::Terms { terms: branches.len() }),
    }
}

/// The columns to decompose when none is named: the gauges, or else the force.
///
/// # Errors
/// When there is neither.
pub fn signals(trace: &Trace) -> Result<Vec<String>, DecompositionError> {
    let gauges = trace.gauges();
    if !gauges.is_empty() {
        return Ok(gauges.into_iter().map(String::from).collect());
    }
    match trace.force() {
        Some(_) => Ok(vec![FORCE.into()]),
        None => Err(DecompositionError::NoSignal { trace: trace.label() }),
    }
}

/// Runs one column of a recording through the filter; `each` is called after every sample.
///
/// The filter takes the interval of each sample from the recording, so uneven sampling is exact. It
/// starts settled at the first sample, and anew after a gap. A recording that begins pressed counts as
/// having just arrived there, from zero.
///
/// # Errors
/// When there is no such column, or the filter refuses the relaxation function or an interval.
pub fn decompose(
    trace: &Trace,
    signal: &str,
    relaxation: &Relaxation,
    mut each: impl FnMut(),
) -> Result<Channel, DecompositionError> {
    let values = trace.column(signal).ok_or_else(|| DecompositionError::NoColumn {
        trace: trace.label(),
        column: signal.into(),
    })?;
    let largest = values.iter().fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()));
    let lsb = lsb(signal, largest).ok_or_else(|| DecompositionError::TooLarge {
        trace: trace.label(),
        column: signal.into(),
        value: largest,
    })?;
    tracing::info!("{}: {signal} through the filter, one LSB is {lsb:e}", trace.label());
    let mut channel = Channel::empty(signal, lsb, trace.len());
    let refused = |source| DecompositionError::Filter { trace: trace.label(), source };
    let mut configs = Configs::new(*relaxation);
    for run in runs(&trace.time) {
        let before = if run.start == 0 && begins_pressed(trace, signal, values) {
            0.0
        } else {
            values[run.start]
        };
        let mut state = State::at_rest(counts(before, lsb));
        // The first sample of a run has no interval before it; the next one's does as well as any.
        let first = trace.time.get(run.start + 1).map_or(1.0, |next| next - trace.time[run.start]);
        for index in run.clone() {
            let interval =
                if index == run.start { first } else { trace.time[index] - trace.time[index - 1] };
            let config = configs.at(interval).map_err(refused)?;
            let output = state.step(config, counts(values[index], lsb));
            channel.push(&output);
            each();
        }
        channel.saturated = channel.saturated.saturating_add(state.saturations());
    }
    Ok(channel)
}

/// Whether a recording begins with the specimen just pressed: its displacement begins above zero, or it
/// has none and its largest value comes within its first twentieth, as the answer to a step. A gauge
/// has an offset of its own, so without a displacement it is taken as it is.
fn begins_pressed(trace: &Trace, signal: &str, values: &[f64]) -> bool {
    if let Some(displacement) = trace.displacement() {
        return displacement.first().is_some_and(|x| *x > 0.0);
    }
    let size = |k: &usize| values[*k].abs();
    let largest = (0..values.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
    !GAUGES.contains(&signal) && largest.is_some_and(|largest| largest <= values.len() / 20)
}

/// A value in LSB; beyond the range of `i32` it stays at its end, and the filter counts it.
fn counts(value: f64, lsb: f64) -> i32 {
    (value / lsb).round() as i32
}

/// One LSB of the device's 24-bit numbers, in the unit of the signal; none where twice the largest value is no number.
fn lsb(signal: &str, largest: f64) -> Option<f64> {
    if GAUGES.contains(&signal) {
        return Some(2f64.powi(-(STRAIN_FRACTION_BITS as i32)));
    }
    let lsb = 2f64.powi((2.0 * largest / f64::from(STRAIN_MAX)).log2().ceil() as i32);
    lsb.is_finite().then_some(lsb)
}

/// One configuration for each interval that occurs.
struct Configs {
    relaxation: Relaxation,
    last: Option<(f64, Config)>,
}

impl Configs {
    /// Intervals are printed with few digits: closer than this, relatively, they are the same.
    const SAME_INTERVAL: f64 = 1e-6;

    fn new(relaxation: Relaxation) -> Self {
        Self { relaxation, last: None }
    }

    fn at(&mut self, interval: f64) -> Result<&Config, ConfigError> {
        let known = |(before, _): &(f64, Config)| {
            (interval - before).abs() <= Self::SAME_INTERVAL * interval
        };
        if !self.last.as_ref().is_some_and(known) {
            self.last = None;
        }
        match self.last {
            Some(ref last) => Ok(&last.1),
            ref mut empty => {
                let config = Config::new(&self.relaxation, interval)?;
                Ok(&empty.insert((interval, config)).1)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::{Column, Head, TIME};

    fn trace(force: [f64; 3]) -> Trace {
        let column =
            |name: &str, values: [f64; 3]| Column { name: name.into(), values: values.into() };
        let columns = vec![column(TIME, [0.0, 0.005, 0.01]), column(FORCE, force)];
        Trace::from_columns(Head::default(), columns).unwrap()
    }

    #[test]
    fn a_signal_too_large_to_scale_is_refused_and_not_made_nan() {
        let decomposed = |force| decompose(&trace(force), FORCE, &default_relaxation(), || {});
        let refused = decomposed([0.0, 1.0, 1e308]).unwrap_err().to_string();
        assert!(refused.contains("1e308") && refused.contains(FORCE), "{refused}");
        let large = decomposed([0.0, 1.0, 8e307]).unwrap();
        assert!(large.lsb.is_finite() && large.fa.iter().all(|value| value.is_finite()));
        assert_eq!(decomposed([0.0; 3]).unwrap().input, [0.0; 3]);
    }
}
