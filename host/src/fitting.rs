//! A base law fitted to a data set.

use palpate_diagnose::criticism::noise::noise_of;
use palpate_fit::data::Data;
use palpate_fit::least_squares::Stop;
use palpate_fit::warning::{Warning, warnings};
use palpate_fit::watch::Stage;
use palpate_fit::whole_motion::{self, MotionFit, over_traces};
use palpate_model::{BaseLaw, Model, Separation};
#[cfg(feature = "report")]
use palpate_present::answers::FitAnswer;
#[cfg(feature = "report")]
use palpate_present::summary::FitSummary;
use palpate_trace::{FORCE, Noise};

use crate::work::Work;
use crate::{Cancel, DataSet, Error};

/// Fits a base law to the whole motion of every trace of a data set at once.
///
/// ```
/// # fn main() -> Result<(), palpate::Error> {
/// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/traces/press.csv");
/// let set = palpate::DataSet::read(folder)?;
/// let fit = palpate::fit(palpate::Law::fung().terms(2), &set).run()?;
/// for (parameter, value) in fit.fitted().parameters().iter().zip(&fit.fitted().values) {
///     println!("{} = {value} {}", parameter.name, parameter.unit);
/// }
/// assert!(fit.fitted().r_squared > 0.99);
/// # Ok(())
/// # }
/// ```
pub fn fit(law: impl Into<BaseLaw>, set: &DataSet) -> Fitting<'_> {
    Fitting { law: law.into(), set, signal: FORCE.into(), work: Work::default() }
}

/// A fit that is about to be made.
#[must_use = "nothing is fitted before `run`"]
pub struct Fitting<'a> {
    law: BaseLaw,
    set: &'a DataSet,
    signal: String,
    work: Work<'a>,
}

impl<'a> Fitting<'a> {
    /// Fits this column instead of `force_N`, such as `gauge1_ustrain`.
    pub fn signal(mut self, column: &str) -> Self {
        self.signal = column.into();
        self
    }

    /// What happens when contact breaks.
    pub fn separation(mut self, separation: Separation) -> Self {
        self.law.separation = separation;
        self
    }

    /// Tells how far the work has come, ten times a second, from a thread of its own.
    pub fn on_progress(mut self, tell: impl FnMut(Stage) + Send + 'a) -> Self {
        self.work.tell = Some(Box::new(tell));
        self
    }

    /// Lets another thread end the work.
    pub fn cancel(mut self, cancel: &Cancel) -> Self {
        self.work.cancel = Some(cancel.clone());
        self
    }

    /// Fits it, and each trace left out in turn where there are several.
    ///
    /// # Errors
    /// When the law does not have these options, the traces cannot be fitted, nothing better than a constant was found, or the
    /// work was cancelled.
    pub fn run(self) -> Result<Fit, Error> {
        self.law.check()?;
        let (law, signal, set) = (self.law, self.signal, self.set);
        let traces = set.traces();
        self.work.run(|| {
            let data = Data::of(traces, &signal)?;
            let fitted = whole_motion::fit(law, &data)?;
            if fitted.stop == Stop::NoBetter {
                return Err(Error::NoBetter { r_squared: fitted.r_squared });
            }
            let single = data.labels.len() == 1;
            let held_out = if single { Vec::new() } else { whole_motion::held_out(&fitted, &data) };
            let noise = noise_of(&data, traces);
            let deviation = noise.map(|noise| noise.standard_deviation);
            Ok(Fit {
                set: set.clone(),
                model: fitted.model(&data, deviation, &held_out),
                warnings: warnings(&fitted, &data, noise.as_ref()),
                held_out_rms: over_traces(&held_out, &data),
                held_out,
                noise,
                fitted,
            })
        })?
    }
}

/// A base law fitted to a data set.
#[derive(Clone, Debug)]
pub struct Fit {
    #[cfg_attr(not(feature = "report"), allow(dead_code, reason = "what the answer rests on"))]
    set: DataSet,
    model: Model,
    fitted: MotionFit,
    held_out_rms: Option<f64>,
    held_out: Vec<f64>,
    noise: Option<Noise>,
    warnings: Vec<Warning>,
}

impl Fit {
    /// The model, as the command writes it to a file.
    #[must_use]
    pub const fn model(&self) -> &Model {
        &self.model
    }

    /// Root mean square error on each trace left out in turn, in the unit of the signal; empty for a single trace.
    #[must_use]
    pub fn held_out(&self) -> &[f64] {
        &self.held_out
    }

    /// The fit as `palpate fit --json` prints it.
    ///
    /// # Panics
    /// Never: the signal of the data set was fitted before.
    #[must_use]
    #[cfg(feature = "report")]
    pub fn answer(&self) -> FitAnswer {
        let signal = &self.model.base.signal;
        let data = Data::of(self.set.traces(), signal).expect("this signal was fitted");
        FitAnswer::from(&FitSummary {
            fit: &self.fitted,
            data: &data,
            signal,
            noise: self.noise,
            held_out: &self.held_out,
            candidates: &[],
        })
    }

    /// Parameters with standard errors and correlations, residuals, and how the search ended.
    #[must_use]
    pub const fn fitted(&self) -> &MotionFit {
        &self.fitted
    }

    /// Root mean square error on traces left out in turn, in the unit of the signal; none for a single trace.
    #[must_use]
    pub const fn held_out_rms(&self) -> Option<f64> {
        self.held_out_rms
    }

    /// The noise of the signal, where the recordings show it without a model.
    #[must_use]
    pub const fn noise(&self) -> Option<&Noise> {
        self.noise.as_ref()
    }

    /// What to be careful about, most serious first.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}
