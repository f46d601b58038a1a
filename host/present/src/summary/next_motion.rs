//! The next experiment as a motion: a file, a figure, words.

use std::path::Path;

use super::unit_of;
use palpate_diagnose::criticism::diagnose::{Diagnosis, Verdict};
use palpate_diagnose::criticism::next_motion::{Informing, NextMotion, Proposed, Rig, SEED};
use palpate_report::number::significant;
use palpate_report::{Axis, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::{Control, DISPLACEMENT, Head, TEMPERATURE, Trace};

/// The recording that is proposed, with a column of what each effect predicts for it; none where there is none.
#[must_use]
pub fn motion_file(proposed: &Proposed, signal: &str) -> Option<Trace> {
    let NextMotion { trace, foreseen, .. } = proposed.motion.as_ref()?;
    let what = format!("distinguishes {}", listed(&proposed.members));
    let members = proposed.members.iter().zip(&foreseen.predicted);
    let columns = members.map(|(member, predicted)| (member.replace('-', "_"), &predicted[..]));
    Some(recording(trace, &what, signal, columns))
}

/// The recording that is proposed for wanted parameters, with a column of what the model predicts for it.
#[must_use]
pub fn informing_file(found: &Informing, signal: &str) -> Trace {
    let what = format!("tells {}", listed(&names(found)));
    let predicted = [("predicted".to_owned(), &found.predicted[..])];
    recording(&found.trace, &what, signal, predicted.into_iter())
}

/// A recording as it is to be made, with columns of what is predicted for it.
fn recording<'a>(
    trace: &Trace,
    what: &str,
    signal: &str,
    columns: impl Iterator<Item = (String, &'a [f64])>,
) -> Trace {
    let (_, unit) = signal.rsplit_once('_').unwrap_or(("", "N"));
    let head = Head {
        version: Some(1),
        name: Some(format!("next experiment: {what}")),
        control: Some(Control::Displacement),
        ..Head::default()
    };
    let mut file = Trace { path: None, head, ..trace.clone() };
    file.columns.retain(|column| column.name != TEMPERATURE);
    for (name, predicted) in columns {
        // Plus zero: minus zero is written `-0`.
        let rounded = predicted.iter().map(|value| (value * 1e6).round() / 1e6 + 0.0).collect();
        file.set_column(format!("{name}_{unit}"), rounded);
    }
    file
}

fn names(found: &Informing) -> Vec<String> {
    found.parameters.iter().map(|it| it.name.clone()).collect()
}

/// Why no motion is proposed.
#[must_use]
pub fn no_motion(proposed: &Proposed, diagnosis: &Diagnosis) -> String {
    match (diagnosis.verdict, proposed.members.len()) {
        (Verdict::Adequate, _) => "nothing is missing, so there is nothing to decide".into(),
        (_, 0 | 1) => "these traces distinguish all effects that are left".into(),
        _ => format!(
            "no motion within the limits distinguishes {} beyond the noise; wider limits may (--rig)",
            listed(&proposed.members)
        ),
    }
}

/// `mullins and drift`, `mullins, drift and backlash`.
fn listed(names: &[String]) -> String {
    match names {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => names.concat(),
    }
}

/// The motion for wanted parameters: how well they are known now and then, and what is predicted for it.
#[must_use]
pub fn informing_section(found: &Informing, path: &Path, signal: &str) -> Section {
    let (unit, rig) = (unit_of(signal), limits(&found.rig, unit_of(signal)));
    let words = format!(
        "{} holds {} s of motion after which {} {} known best. Weighed: {} motions (seed {SEED}), {rig}.",
        path.display(),
        significant(found.trace.duration(), 3),
        listed(&names(found)),
        if found.parameters.len() == 1 { "is" } else { "are" },
        found.weighed,
    );
    let columns = vec![
        Column::text("parameter"),
        Column::number("value", ""),
        Column::number("standard error now", ""),
        Column::number("with this motion", ""),
        Column::number("with the best of the menu", ""),
        Column::text("unit"),
    ];
    let mut table = Table::new("How well they are known", columns);
    let error = |error: Option<f64>| error.map_or_else(|| "–".into(), |it| significant(it, 2));
    for it in &found.parameters {
        let errors = [it.now, it.then, it.of_menu].map(error);
        let cells = [it.name.clone(), significant(it.value, 4)].into_iter().chain(errors);
        table = table.row(cells.chain([it.unit.clone()]).collect::<Vec<_>>());
    }
    let time = || Axis::new("time", "s");
    let at = &found.trace.time[..];
    let place = found.trace.column(DISPLACEMENT).unwrap_or_default();
    let motion = Plot::new("", time(), Axis::new("displacement", "mm"))
        .series(Series::line("displacement", at, place).colour(Colour::MEASURED))
        .height(130.0);
    let predicted = Plot::new("", time(), Axis::new("predicted signal", unit))
        .series(Series::line("predicted", at, &found.predicted[..]).colour(Colour::Hue(0)))
        .height(190.0);
    let panels = Panels::new("The motion, and what the model predicts for it");
    Section::new("The next experiment as a motion").paragraph(words).table(table).figure(
        panels.plot(motion).plot(predicted),
        "Record it after a minute of rest, then fit old and new recordings together.",
    )
}

/// The limits of a rig in words.
fn limits(rig: &Rig, unit: &str) -> String {
    let Rig { displacement_mm, off_mm, speed_mm_per_s, signal, time_s, .. } = *rig;
    let [off, deep, speed, signal, time] =
        [off_mm, displacement_mm, speed_mm_per_s, signal, time_s].map(|it| significant(it, 3));
    format!(
        "from {off} mm off to {deep} mm deep, at most {speed} mm/s, {signal} {unit} and {time} s"
    )
}

/// The motion with what each effect predicts for it.
#[must_use]
pub fn next_motion_section(proposed: &Proposed, path: &Path, signal: &str) -> Section {
    let section = Section::new("The next experiment as a motion");
    let Some(NextMotion { trace, foreseen, of_menu, weighed }) = &proposed.motion else {
        return section.paragraph("None is proposed.");
    };
    let unit = unit_of(signal);
    let rig = limits(&proposed.rig, unit);
    let menu = of_menu.as_ref().map_or_else(
        || "no motion of the menu lies within the limits".to_owned(),
        |menu| format!("on the best motion of the menu {}", significant(menu.separates(), 3)),
    );
    let pairs = foreseen.apart.len();
    let told = match foreseen.told() {
        told if told == pairs => String::new(),
        told => format!(
            " Of {pairs} pairs it distinguishes {told}; the others need something else than another motion."
        ),
    };
    let words = format!(
        "{} holds {} s of motion that distinguish {}: if one of them is right, each other, refitted, leaves at least {} squares of \
         the noise ({menu}; more than 10 distinguish them).{told} Weighed: {weighed} motions (seed {SEED}), {rig}.",
        path.display(),
        significant(trace.duration(), 3),
        listed(&proposed.members),
        significant(foreseen.separates(), 3),
    );
    section.paragraph(words).figure(
        panels(proposed, trace, &foreseen.predicted, unit),
        "Record it after a minute of rest, then diagnose old and new recordings together.",
    )
}

fn panels(proposed: &Proposed, trace: &Trace, predicted: &[Vec<f64>], unit: &str) -> Panels {
    let time = || Axis::new("time", "s");
    let place = trace.column(DISPLACEMENT).unwrap_or_default();
    let motion = Plot::new("", time(), Axis::new("displacement", "mm"))
        .series(Series::line("displacement", &trace.time[..], place).colour(Colour::MEASURED))
        .height(130.0);
    let line = |index: usize, label: &str, values: &[f64]| {
        Series::line(label, &trace.time[..], values).colour(Colour::Hue(index))
    };
    let members = || proposed.members.iter().zip(predicted).enumerate();
    let foreseen = members().fold(
        Plot::new("", time(), Axis::new("predicted signal", unit)).height(190.0),
        |plot, (index, (member, values))| plot.series(line(index, member, values)),
    );
    let first = proposed.members.first().map_or("", String::as_str);
    let apart = members().skip(1).fold(
        Plot::new("", time(), Axis::new("difference", unit)).height(150.0),
        |plot, (index, (member, values))| {
            let difference: Vec<f64> =
                values.iter().zip(&predicted[0]).map(|(value, first)| value - first).collect();
            plot.series(line(index, &format!("{member} − {first}"), &difference))
        },
    );
    Panels::new("The motion, and what each effect predicts for it")
        .plot(motion)
        .plot(foreseen)
        .plot(apart)
}
