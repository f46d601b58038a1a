//! Results in words, tables and plots: the same sections go to the terminal and into a report.

mod decomposition;
mod holds;
mod plan;
mod press;
mod recording;
mod whole_motion;

pub use decomposition::{
    decomposed_trace, decomposition_json, decomposition_sections, part_panels, region_spans, region_table,
};
pub use holds::{hold_json, hold_sections};
pub use plan::plan_section;
pub use press::press_sections;
pub use recording::{loops, overview, trace_panels};
pub use whole_motion::FitSummary;

use crate::report::number::{significant, with_error};
use crate::trace::units;

/// A value with its standard error, or alone with a word on why it has none.
fn estimate(value: f64, standard_error: Option<f64>) -> String {
    match standard_error {
        Some(error) if error > 0.0 && error.is_finite() => with_error(value, error),
        _ => significant(value, 4),
    }
}

/// The unit of a column, as its name gives it, in print.
#[must_use]
pub fn unit_of(column: &str) -> &str {
    match units::of_column(column).map(|unit| unit.name) {
        Some("ustrain") => "µε",
        Some("C") => "°C",
        Some(unit) => unit.strip_prefix("per_").map_or(unit, |_| "1/Pa"),
        None => "",
    }
}

/// A column's name in words: `gauge1_ustrain` is gauge 1.
#[must_use]
pub fn name_of(column: &str) -> String {
    let unit = units::of_column(column).map_or(0, |unit| unit.name.len() + 1);
    let name = &column[..column.len() - unit];
    match name.strip_prefix("gauge") {
        Some(number) if number.parse::<u32>().is_ok() => format!("gauge {number}"),
        _ => name.replace('_', " "),
    }
}
