//! What was done to the traces before anything was computed from them.

use std::collections::BTreeMap;

use palpate_trace::{Cause, MotionNoise, Outlier, Repeats, Stairs};
use serde::Serialize;

use super::finite;
use crate::summary::{Moved, Preparation, Refit, RobustRefit};

/// An answer with the state of the traces that it rests on.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Prepared<A> {
    /// The answer.
    #[serde(flatten)]
    pub answer: A,
    /// What was impossible in the traces, and what was done about it.
    #[serde(flatten)]
    pub preparation: PreparationAnswer,
}

/// What was found impossible in the traces, and what was done about it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PreparationAnswer {
    /// Samples that jump away and back faster than the motion or the signal ever goes.
    pub outliers: Vec<OutlierAnswer>,
    /// Whether they were left out.
    pub outliers_dropped: bool,
    /// Traces whose signal was recorded more slowly than their rows.
    pub signal_repeats: Vec<RepeatsAnswer>,
    /// Whether the rows that only repeat it were left out.
    pub signal_repeats_dropped: bool,
    /// Traces whose displacement goes in steps beside a signal that does not.
    pub displacement_steps: Vec<StairsAnswer>,
    /// Whether the motion was taken as straight between the steps.
    pub displacement_steps_joined: bool,
    /// Traces whose displacement was taken without its noise: the signal would show it, and does not follow it.
    pub displacement_noise: Vec<MotionNoiseAnswer>,
    /// What was taken off the signal of each trace, by its name, in the unit of the signal.
    pub tared: BTreeMap<String, f64>,
    /// How good a fit is without the outliers; absent where none was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_outliers: Option<WithoutOutliers>,
    /// The fit where no sample has more than a bounded say; absent where none was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robust_refit: Option<RobustAnswer>,
}

/// One impossible sample.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct OutlierAnswer {
    /// Name of its trace.
    pub trace: String,
    /// Row of the file's table, from 1.
    pub row: usize,
    /// Its time, s.
    pub time_s: f64,
    /// Its column.
    pub column: String,
    /// Its value, in the unit of the column.
    pub value: f64,
    /// What its neighbours let expect.
    pub expected: f64,
}

/// A signal that was recorded more slowly than the rows that hold it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RepeatsAnswer {
    /// Name of the trace.
    pub trace: String,
    /// Rows for which each value stays, on average.
    pub rows: f64,
}

/// A displacement that goes in steps.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct StairsAnswer {
    /// Name of the trace.
    pub trace: String,
    /// Why.
    pub cause: StairsCause,
    /// The usual step, mm.
    pub step_mm: f64,
    /// Samples that the displacement usually stays for where it moves.
    pub samples: f64,
}

/// Noise of a displacement.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct MotionNoiseAnswer {
    /// Name of the trace.
    pub trace: String,
    /// Standard deviation of one sample, mm.
    pub standard_deviation_mm: f64,
}

/// Why a displacement goes in steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum StairsCause {
    /// It was recorded more slowly than the signal, each value held until the next.
    Held,
    /// It was rounded to multiples of the step.
    Rounded,
}

/// A fit without the impossible samples.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct WithoutOutliers {
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Root mean square of the residual, in the unit of the signal.
    pub residual_rms: f64,
}

/// A refit in which no sample has more than a bounded say (Huber's weights): far off the fit where the impossible samples matter.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RobustAnswer {
    /// The parameters by name.
    pub parameters: BTreeMap<String, RobustParameter>,
    /// Number of impossible samples that it weighs less than half.
    pub light_outliers: usize,
    /// Number of other samples that it weighs less than half: where the law is off, or noise has heavy tails.
    pub light_others: usize,
}

/// A parameter of a robust refit.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RobustParameter {
    /// The value, in `unit`.
    pub value: f64,
    /// Its standard error, in `unit`; null where the data do not determine it.
    pub standard_error: Option<f64>,
    /// Unit, empty for a pure number.
    pub unit: String,
    /// By how many of these standard errors the fit lies off the value; null where the data do not determine it.
    pub fit_is_off: Option<f64>,
}

impl From<&RobustRefit> for RobustAnswer {
    fn from(refit: &RobustRefit) -> Self {
        let parameter = |moved: &Moved| {
            let parameter = RobustParameter {
                value: moved.value,
                standard_error: moved.standard_error.and_then(finite),
                unit: moved.unit.clone(),
                fit_is_off: moved.fit_is_off.and_then(finite),
            };
            (moved.name.clone(), parameter)
        };
        Self {
            parameters: refit.parameters.iter().map(parameter).collect(),
            light_outliers: refit.light_outliers,
            light_others: refit.light_others,
        }
    }
}

impl Preparation {
    /// An answer with the state of the traces that it rests on.
    #[must_use]
    pub fn with<A>(&self, answer: A) -> Prepared<A> {
        Prepared { answer, preparation: self.into() }
    }
}

impl From<&Preparation> for PreparationAnswer {
    fn from(preparation: &Preparation) -> Self {
        let refit = preparation.refit.as_ref();
        let without = |refit: &Refit| WithoutOutliers {
            r_squared: refit.r_squared[1],
            residual_rms: refit.residual_rms[1],
        };
        Self {
            outliers: preparation.outliers.iter().map(OutlierAnswer::from).collect(),
            outliers_dropped: preparation.dropped,
            signal_repeats: preparation.repeats.iter().map(RepeatsAnswer::from).collect(),
            signal_repeats_dropped: preparation.repeats_dropped,
            displacement_steps: preparation.stairs.iter().map(StairsAnswer::from).collect(),
            displacement_steps_joined: preparation.joined,
            displacement_noise: preparation
                .motion_noise
                .iter()
                .map(MotionNoiseAnswer::from)
                .collect(),
            tared: preparation.tared.iter().cloned().collect(),
            without_outliers: refit.map(without),
            robust_refit: refit.and_then(|refit| refit.robust.as_ref()).map(RobustAnswer::from),
        }
    }
}

impl From<&Stairs> for StairsAnswer {
    fn from(stairs: &Stairs) -> Self {
        let cause = match stairs.cause {
            Cause::Held => StairsCause::Held,
            Cause::Rounded => StairsCause::Rounded,
        };
        Self {
            trace: stairs.trace.clone(),
            cause,
            step_mm: stairs.step_mm,
            samples: stairs.samples,
        }
    }
}

impl From<&MotionNoise> for MotionNoiseAnswer {
    fn from(own: &MotionNoise) -> Self {
        Self { trace: own.trace.clone(), standard_deviation_mm: own.standard_deviation_mm }
    }
}

impl From<&Repeats> for RepeatsAnswer {
    fn from(own: &Repeats) -> Self {
        Self { trace: own.trace.clone(), rows: own.rows }
    }
}

impl From<&Outlier> for OutlierAnswer {
    fn from(out: &Outlier) -> Self {
        let Outlier { trace, row, time_s, column, value, expected, .. } = out.clone();
        Self { trace, row, time_s, column, value, expected }
    }
}
