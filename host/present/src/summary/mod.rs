//! Results in words, tables and plots: the same sections go to the terminal and into a report.

mod afm;
mod change;
mod compare;
mod contract;
mod creep;
mod decomposition;
mod dependence;
mod device;
mod diagnosis;
mod discovery;
mod dissertation;
mod effects;
mod events;
mod grasp;
mod holds;
mod ladder;
mod markers;
mod next_motion;
mod outliers;
mod plan;
mod practice;
mod press;
mod pull_off;
mod ranking;
mod rates;
mod recording;
mod relaxation;
mod segment;
mod segment_run;
mod sensor;
mod strain_rate;
mod survey;
mod terms;
mod whole_motion;

pub use afm::{FittedCurve, afm_sections, rough_sections};
pub(crate) use afm::{curve_remarks, hold_figure};
pub(crate) use change::declared as changed_parameters;
pub use change::{change_report, change_sections};
pub use compare::{compare_report, compare_sections, overlays};
pub use contract::contract_section;
pub use creep::{Conditioning, creep_sections};
pub use decomposition::{
    decomposed_trace, decomposition_sections, part_panels, region_spans, region_table, shaded,
};
pub use device::{device_sections, self_test_sections, settings_blocks};
pub(crate) use diagnosis::Ranked;
pub use diagnosis::{DiagnosisSummary, NextCommand};
pub use discovery::DiscoverySummary;
pub use dissertation::{
    COMPARISONS_HEADER, comparisons_csv, dissertation_overview, dissertation_report,
};
pub use effects::{effect_figures, effect_pages, effect_section, library_section};
pub(crate) use effects::{how_many, needs};
pub use events::events_sections;
pub use grasp::{
    Forecast, HISTORY_HEADER, HandPlan, SURFACE_HEADER, SurfaceSummary, friction_sections,
    growth_sections, history_csv, history_sections, plan_sections, pressure_plot, reading_line,
    surface_csv,
};
pub use holds::hold_sections;
pub(crate) use holds::{NO_BETTER, warnings as hold_warnings};
pub use ladder::ladder;
pub use markers::{markers_figure, markers_sections};
pub use next_motion::{
    informing_file, informing_section, motion_file, next_motion_section, no_motion,
};
pub use outliers::{Moved, Preparation, Refit, RobustRefit};
pub use plan::plan_section;
pub use practice::{practice_sections, truth_sections};
pub use press::press_sections;
pub use pull_off::growth_section;
pub use ranking::ranking_sections;
pub use rates::rates_sections;
pub(crate) use rates::warnings as rates_warnings;
pub use recording::{loops, overview, trace_panels};
pub use relaxation::relaxation_sections;
pub use segment::segment_sections;
pub(crate) use segment::{region_of, type_of, warnings as segment_warnings};
pub use segment_run::segment_run_section;
pub use sensor::{
    sensor_press_sections, sensor_shake_sections, sensor_slide_sections, sensor_slip_sections,
    sensor_tones_sections,
};
pub(crate) use sensor::{spectrum_figure, tones_figure};
pub use strain_rate::strain_rate_sections;
pub use survey::{population_sections, survey_sections};
pub use terms::number_table;
pub use whole_motion::FitSummary;

pub use palpate_trace::units::printed as unit_of;

use palpate_analysis::derivative::Derivative;
use palpate_report::number::{significant, with_error};
use palpate_trace::units;

/// A value with its standard error, or alone with a word on why it has none.
fn estimate(value: f64, standard_error: Option<f64>) -> String {
    match standard_error {
        Some(error) if error > 0.0 && error.is_finite() => with_error(value, error),
        _ => significant(value, 4),
    }
}

/// A value with its standard error in the last digits in parentheses, for tables with many columns:
/// 0.5978(10) is 0.5978 ± 0.0010.
fn concise(value: f64, standard_error: Option<f64>) -> String {
    let long = estimate(value, standard_error);
    match long.split_once(" ± ") {
        Some((value, error)) if !long.starts_with('(') && error.parse::<f64>().is_ok() => {
            let digits: String = error.chars().filter(char::is_ascii_digit).collect();
            // An error of one or more keeps its point: 53.2(1.4).
            let error = if error.starts_with('0') { digits.trim_start_matches('0') } else { error };
            format!("{value}({error})")
        }
        _ => long,
    }
}

/// The note below a table of concise values.
const CONCISE: &str = "In parentheses: the standard error in units of the last digits.";

/// What a derivative in a figure can show.
fn bandwidth_words(found: &Derivative) -> String {
    let width = significant(found.half_width_s, 3);
    let bandwidth =
        found.bandwidth_hz.map_or("not known from so few samples".into(), |bandwidth| {
            format!("{} Hz", significant(bandwidth, 3))
        });
    let quiet = if found.quiet { "" } else { ", still above 5 % of the fastest rate" };
    format!(
        "The derivative is the slope of parabolas fitted within ±{width} s: bandwidth (−3 dB) {bandwidth}; noise of 1 in a sample makes {} 1/s{quiet}.",
        significant(found.noise_gain, 2)
    )
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_error_stands_in_units_of_the_last_digits() {
        assert_eq!(concise(0.59781, Some(0.00104)), "0.5978(10)");
        assert_eq!(concise(53.21, Some(1.42)), "53.2(1.4)");
        assert_eq!(concise(504.7, Some(12.1)), "505(12)");
        assert_eq!(concise(-0.891, Some(0.0171)), "-0.891(17)");
        assert_eq!(concise(2.0, None), "2.000");
    }

    #[test]
    fn columns_are_named_in_words_with_their_unit() {
        assert_eq!((&*name_of("gauge1_ustrain"), unit_of("gauge1_ustrain")), ("gauge 1", "µε"));
        assert_eq!((&*name_of("force_N"), unit_of("force_N")), ("force", "N"));
        let modulus = "relaxation_modulus_Pa";
        assert_eq!((&*name_of(modulus), unit_of(modulus)), ("relaxation modulus", "Pa"));
        let compliance = "creep_compliance_per_Pa";
        assert_eq!((&*name_of(compliance), unit_of(compliance)), ("creep compliance", "1/Pa"));
        assert_eq!((&*name_of("status"), unit_of("status")), ("status", ""));
    }
}
