//! What was done to the traces before anything was computed from them.

use std::collections::BTreeMap;

use palpate_trace::Outlier;
use serde::Serialize;

use crate::summary::Preparation;

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
    /// What was taken off the signal of each trace, by its name, in the unit of the signal.
    pub tared: BTreeMap<String, f64>,
    /// How good a fit is without the outliers; absent where none was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_outliers: Option<WithoutOutliers>,
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

/// A fit without the impossible samples.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct WithoutOutliers {
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Root mean square of the residual, in the unit of the signal.
    pub residual_rms: f64,
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
        let without = |refit: crate::summary::Refit| WithoutOutliers {
            r_squared: refit.r_squared[1],
            residual_rms: refit.residual_rms[1],
        };
        Self {
            outliers: preparation.outliers.iter().map(OutlierAnswer::from).collect(),
            outliers_dropped: preparation.dropped,
            tared: preparation.tared.iter().cloned().collect(),
            without_outliers: preparation.refit.map(without),
        }
    }
}

impl From<&Outlier> for OutlierAnswer {
    fn from(out: &Outlier) -> Self {
        let Outlier { trace, row, time_s, column, value, expected, .. } = out.clone();
        Self { trace, row, time_s, column, value, expected }
    }
}
