//! A number with its uncertainty.

use palpate_contact::afm::Estimate;
use serde::Serialize;

use super::finite;

/// A number with its standard error, in the unit that its key names.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct Uncertain {
    /// The value.
    pub value: f64,
    /// Its standard error; null where the data do not determine it.
    pub standard_error: Option<f64>,
}

impl From<(f64, Option<f64>)> for Uncertain {
    fn from((value, standard_error): (f64, Option<f64>)) -> Self {
        Self { value, standard_error }
    }
}

impl From<(f64, f64)> for Uncertain {
    fn from((value, standard_error): (f64, f64)) -> Self {
        Self { value, standard_error: Some(standard_error) }
    }
}

impl From<Estimate> for Uncertain {
    fn from(found: Estimate) -> Self {
        Self { value: found.value, standard_error: finite(found.standard_error) }
    }
}
