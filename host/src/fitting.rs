//! A base law fitted to a data set.

use palpate_diagnose::criticism::noise::noise_of;
use palpate_fit::data::Data;
use palpate_fit::least_squares::Stop;
use palpate_fit::warning::{Warning, warnings};
use palpate_fit::whole_motion::{self, MotionFit, over_traces};
use palpate_model::{BaseLaw, Model, Separation};
#[cfg(feature = "report")]
use palpate_present::answers::FitAnswer;
#[cfg(feature = "report")]
use palpate_present::summary::FitSummary;
use palpate_trace::{FORCE, Noise};

use crate::work::{Asked, Question};
use crate::{DataSet, Error};

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
pub fn fit(law: impl Into<BaseLaw>, set: &DataSet) -> Asked<'_, Fitting> {
    Asked::new(Fitting { law: law.into(), signal: FORCE.into() }, set)
}

/// A base law, fitted to whole motions; each trace is left out in turn where there are several.
pub struct Fitting {
    law: BaseLaw,
    signal: String,
}

impl Asked<'_, Fitting> {
    /// Fits this column instead of `force_N`, such as `gauge1_ustrain`.
    pub fn signal(mut self, column: &str) -> Self {
        self.question.signal = column.into();
        self
    }

    /// What happens when contact breaks.
    pub fn separation(mut self, separation: Separation) -> Self {
        self.question.law.separation = separation;
        self
    }
}

impl Question for Fitting {
    type Answer = Fit;

    fn of(self, set: &DataSet) -> Result<Fit, Error> {
        self.law.check()?;
        let data = Data::of(set.traces(), &self.signal)?;
        let data = data.with_separation(self.law.separation);
        let fitted = whole_motion::fit(self.law, &data)?;
        if fitted.stop == Stop::NoBetter {
            return Err(Error::NoBetter { r_squared: fitted.r_squared });
        }
        let single = data.labels.len() == 1;
        let held_out = if single { Vec::new() } else { whole_motion::held_out(&fitted, &data) };
        let noise = noise_of(&data, set.traces());
        let deviation = noise.map(|noise| noise.standard_deviation);
        let fitted = fitted.allowing_for_misfit(&data, deviation);
        Ok(Fit {
            set: set.clone(),
            model: fitted.model(&data, deviation, &held_out),
            warnings: warnings(&fitted, &data, noise.as_ref()),
            held_out_rms: over_traces(&held_out, &data),
            held_out,
            noise,
            fitted,
        })
    }
}

/// A base law fitted to a data set.
#[derive(Clone, Debug)]
pub struct Fit {
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

    /// The data set to which it was fitted.
    #[must_use]
    pub const fn data_set(&self) -> &DataSet {
        &self.set
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
        let data = data.with_separation(self.fitted.chain.base.separation);
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
