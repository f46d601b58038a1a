//! The next experiment as a motion: a file, a figure, words.

use std::path::Path;

use super::unit_of;
use palpate_diagnose::criticism::diagnose::{Diagnosis, Verdict};
use palpate_diagnose::criticism::next_motion::{NextMotion, Proposed, Rig, SEED};
use palpate_report::number::significant;
use palpate_report::{Axis, Colour, Panels, Plot, Section, Series};
use palpate_trace::{Control, DISPLACEMENT, Head, TEMPERATURE, Trace};

/// The recording that is proposed, with a column of what each effect predicts for it; none where there is none.
#[must_use]
pub fn motion_file(proposed: &Proposed, signal: &str) -> Option<Trace> {
    let NextMotion { trace, foreseen, .. } = proposed.motion.as_ref()?;
    let (_, unit) = signal.rsplit_once('_').unwrap_or(("", "N"));
    let head = Head {
        version: Some(1),
        name: Some(format!("next experiment: distinguishes {}", listed(&proposed.members))),
        control: Some(Control::Displacement),
        ..Head::default()
    };
    let mut file = Trace { path: None, head, ..trace.clone() };
    file.columns.retain(|column| column.name != TEMPERATURE);
    for (member, predicted) in proposed.members.iter().zip(&foreseen.predicted) {
        // Plus zero: minus zero is written `-0`.
        let rounded = predicted.iter().map(|value| (value * 1e6).round() / 1e6 + 0.0).collect();
        file.set_column(format!("{}_{unit}", member.replace('-', "_")), rounded);
    }
    Some(file)
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

/// The motion with what each effect predicts for it.
#[must_use]
pub fn next_motion_section(proposed: &Proposed, path: &Path, signal: &str) -> Section {
    let section = Section::new("The next experiment as a motion");
    let Some(NextMotion { trace, foreseen, of_menu, weighed }) = &proposed.motion else {
        return section.paragraph("None is proposed.");
    };
    let Rig { displacement_mm, off_mm, speed_mm_per_s, signal: most, time_s, .. } = proposed.rig;
    let unit = unit_of(signal);
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
         the noise ({menu}; more than 10 distinguish them).{told} Weighed: {weighed} motions (seed {SEED}), from {} mm off to {} mm deep, at most {} mm/s, {} {unit} and {} s.",
        path.display(),
        significant(trace.duration(), 3),
        listed(&proposed.members),
        significant(foreseen.separates(), 3),
        significant(off_mm, 3),
        significant(displacement_mm, 3),
        significant(speed_mm_per_s, 3),
        significant(most, 3),
        significant(time_s, 3),
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
