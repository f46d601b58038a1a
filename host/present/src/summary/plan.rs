//! A planned recording, as tables.

use palpate_fit::exponentials::plan::{Experiment, Plan, Recording};
use palpate_fit::exponentials::{Bound, Parameter};
use palpate_report::number::{percent, significant};
use palpate_report::{Callout, Column, Section, Table};

/// What a recording would tell of each parameter, and the recordings that tell what is wanted.
#[must_use]
pub fn plan_section(
    experiment: &Experiment,
    recording: Recording,
    bound: &Bound,
    plans: &[Plan],
) -> Section {
    let columns = vec![
        Column::text("parameter"),
        Column::number("value", ""),
        Column::number("least standard error", ""),
        Column::number("relative", ""),
    ];
    let title =
        format!("What {} would determine, with noise of {}", words(recording), experiment.noise);
    let mut table = Table::new(title, columns);
    for parameter in Parameter::all(experiment.sum.terms.len()) {
        let known = |value: Option<f64>, show: fn(f64) -> String| value.map_or("–".into(), show);
        table = table.row([
            parameter.to_string(),
            known(experiment.sum.value(parameter), |value| significant(value, 4)),
            known(bound.standard_error(parameter), |error| significant(error, 3)),
            known(bound.relative(&experiment.sum, parameter), |share| percent(share, 2)),
        ]);
    }
    let table = table.note("Cramér–Rao bound: no unbiased fit does better.");
    let mut section = Section::new("Plan").table(table);
    for (plan, instead) in plans.iter().zip(["at this rate", "in this time"]) {
        section = match plan {
            Plan::Enough { recording, .. } => section.callout(
                Callout::Finding,
                "Enough",
                format!("{instead}, {} reaches what is wanted", words(*recording)),
            ),
            Plan::OutOfReach { recording, parameter, relative } => section.callout(
                Callout::Warning,
                "Out of reach",
                format!(
                    "{instead}, even {} leaves {parameter} {}",
                    words(*recording),
                    relative
                        .map_or("undetermined".into(), |share| format!("at {}", percent(share, 2)))
                ),
            ),
        };
    }
    section
}

fn words(recording: Recording) -> String {
    format!(
        "a hold of {} s at {} Hz ({} samples)",
        significant(recording.duration(), 3),
        significant(recording.rate, 4),
        recording.samples
    )
}
