//! A comparison as the page draws it.

use serde_json::{Value, json};

use palpate_diagnose::criticism::compare::Comparison;
use palpate_diagnose::criticism::dependence::{Bin, Dependence};
use palpate_present::answers::{self, ComparisonAnswer};
use palpate_present::summary::{Preparation, unit_of};

/// The comparison as the command gives it, with the means that each dependence is drawn from.
#[must_use]
pub fn comparison_json(comparison: &Comparison, preparation: &Preparation) -> Value {
    let mut found = answers::json(&preparation.with(ComparisonAnswer::from(comparison)));
    let unit = unit_of(&comparison.signal);
    let bin = |bin: &Bin| json!([bin.at, bin.mean, bin.standard_error]);
    let drawn = |dependence: &Dependence| {
        json!({
            "covariate": dependence.covariate.symbol(),
            "name": dependence.covariate.name(),
            "unit": dependence.covariate.unit(unit),
            "bins": dependence.bins.iter().map(bin).collect::<Vec<_>>(),
        })
    };
    found["labels"] = json!(comparison.labels);
    found["trace_rms"] = json!(comparison.trace_rms);
    found["drawn"] = comparison.dependences.iter().map(drawn).collect();
    found
}
