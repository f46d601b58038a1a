//! Touch, release and slip: a table and a plot.

use shared::events::Kind;

use super::{name_of, unit_of};
use palpate_analysis::events::{Events, Judged, happened, judge, name};
use palpate_report::number::significant;
use palpate_report::{
    Axis, Callout, Colour, Column, Dash, Legend, Panels, Plot, Section, Series, Table,
};
use palpate_trace::Trace;

/// The events of a trace, what they are found by, and how they compare with what is known to have happened.
#[must_use]
pub fn events_sections(trace: &Trace, events: &Events) -> Section {
    let known = happened(trace);
    let judged = judge(&known, &events.found);
    let mut section =
        Section::new(trace.label()).paragraph(looked_for(events)).table(event_table(events));
    if !known.is_empty() {
        section = section.table(judged_table(&known, &judged, events));
    }
    if events.found.is_empty() {
        let words = "Nothing was touched, let go of or slipped, as far as FA shows.";
        section = section.callout(Callout::Finding, "No event", words);
    }
    section.figure(
        figure(trace, events),
        "Marked: when an event was reported. Dashed lines: FA beyond them is a burst.",
    )
}

/// The levels in words.
fn looked_for(events: &Events) -> String {
    let unit = unit(events);
    let settings = &events.settings;
    let level = |value: f64| format!("{} {unit}", significant(value, 3));
    let noise = events.noise.map_or("is not known".into(), |noise| format!("is {}", level(noise)));
    let slip = if settings.jolts > 0 {
        format!(
            "{} jolts of {} above {} Hz within {} s are a slip",
            settings.jolts,
            level(settings.jolt),
            significant(settings.corner_hz, 3),
            significant(settings.within_s, 3)
        )
    } else {
        format!(
            "slip is not looked for: a corner of {} Hz asks for {} samples a second, and there are {}",
            significant(settings.corner_hz, 3),
            significant(4.0 * settings.corner_hz, 3),
            significant(events.rate_hz, 3)
        )
    };
    format!(
        "The noise of a sample {noise}. FA beyond {} is a burst; {slip}.",
        level(settings.burst)
    )
}

fn unit(events: &Events) -> &str {
    events.channels.first().map_or("", |channel| unit_of(&channel.signal))
}

fn signal_of(events: &Events, index: usize) -> &str {
    events.channels.get(index).map_or("", |channel| &channel.signal)
}

fn event_table(events: &Events) -> Table {
    let columns = vec![
        Column::text("event"),
        Column::number("reported at", "s"),
        Column::number("began at", "s"),
        Column::number("reported after", "ms"),
        Column::text("by"),
    ];
    let mut table = Table::new("Events", columns);
    for found in &events.found {
        table = table.row([
            name(found.kind).to_owned(),
            format!("{:.3}", found.told_s),
            format!("{:.3}", found.began_s),
            format!("{:.0}", 1e3 * (found.told_s - found.began_s)),
            name_of(signal_of(events, found.channel)),
        ]);
    }
    table.note("Began: when the burst left its resting band, or at the first of the jolts.")
}

/// What happened beside what was told.
fn judged_table(known: &[(Kind, f64)], judged: &Judged, events: &Events) -> Table {
    let columns = vec![
        Column::text("happened"),
        Column::number("at", "s"),
        Column::number("reported after", "ms"),
    ];
    let mut table = Table::new("What the simulation says happened", columns);
    for ((kind, at), (_, delay)) in known.iter().zip(&judged.delay_s) {
        let delay = delay.map_or("missed".into(), |delay| format!("{:.0}", 1e3 * delay));
        table = table.row([name(*kind).to_owned(), format!("{at:.3}"), delay]);
    }
    let false_alarms: Vec<String> = judged
        .false_alarms
        .iter()
        .filter_map(|place| events.found.get(*place))
        .map(|found| format!("{} at {:.3} s", name(found.kind), found.told_s))
        .collect();
    table.note(if false_alarms.is_empty() {
        "No false alarm.".into()
    } else {
        format!("False alarms: {}.", false_alarms.join(", "))
    })
}

fn figure(trace: &Trace, events: &Events) -> Panels {
    let time = || Axis::new("Time", "s");
    let unit = unit(events);
    let mut reading = Plot::new("", time(), Axis::new("Reading", unit));
    let mut fa = Plot::new("", time(), Axis::new("FA", unit)).legend(Legend::Hidden);
    for (k, channel) in events.channels.iter().enumerate() {
        let line = |values: &[f64]| {
            Series::line(name_of(&channel.signal), &trace.time[..], values)
                .colour(Colour::Hue(k))
                .dash(Dash::Solid)
        };
        reading = reading.series(line(&channel.input));
        fa = fa.series(line(&channel.fa));
    }
    for found in &events.found {
        reading = reading.mark(found.told_s, name(found.kind));
        fa = fa.mark(found.told_s, "");
    }
    let burst = events.settings.burst;
    fa = fa.level(burst, "").level(-burst, "");
    Panels::new("Touch, release and slip")
        .summary("Readings and their fast adapting part over time, with events marked")
        .plot(reading)
        .plot(fa)
}
