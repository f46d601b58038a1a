//! The margin over a recording.

use super::margin_words;
use palpate_contact::grasp::History;
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};
use palpate_trace::Trace;

/// Share above which the plot is cut off: far beyond slip.
const MAX_DRAWN_SHARE: f64 = 3.0;

/// Slips shown of one trace at most.
const MAX_SHOWN_SLIPS: usize = 10;

/// Smallest margin and slips of every trace, and the share used over time.
#[must_use]
pub fn history_sections(histories: &[(&Trace, &History)]) -> Vec<Section> {
    let columns = vec![
        Column::text("trace"),
        Column::number("smallest margin", ""),
        Column::number("at", "s"),
        Column::number("slips for", "% of contact"),
        Column::number("contact above", "N"),
    ];
    let mut table = Table::new("Margin until slip", columns);
    for (trace, history) in histories {
        table = table.row([
            trace.label(),
            margin_words(history.smallest_margin()),
            format!("{:.4}", history.most_used.1),
            significant(100.0 * history.slipping, 3),
            significant(history.threshold, 3),
        ]);
    }
    let table =
        table.note("The load could have been so many times as large; at 1 the contact slips.");
    let mut section = Section::new("Margin until slip").table(table);
    for (trace, history) in histories {
        let kind = if history.slips.is_empty() { Callout::Finding } else { Callout::Warning };
        section = section.callout(kind, "Slip", slip_sentence(trace, history));
        if !history.slips.is_empty() {
            section = section.table(slip_table(trace, history));
        }
        section = section.figure(plot(trace, history), "");
    }
    vec![section]
}

fn slip_sentence(trace: &Trace, history: &History) -> String {
    let name = trace.label();
    let at_touch = history.slips.iter().any(|slip| slip.from_touch);
    match (history.first_slip(), at_touch) {
        (None, false) => format!(
            "{name} never slips: its load could always have been {} times as large.",
            margin_words(history.smallest_margin())
        ),
        (None, true) => {
            format!("{name} slips from the touch on; once it holds, it does not give way.")
        }
        (Some(first), false) => format!("{name} slips first at {first:.4} s."),
        (Some(first), true) => {
            format!(
                "{name} slips from the touch on; once it holds, it slips first at {first:.4} s."
            )
        }
    }
}

fn slip_table(trace: &Trace, history: &History) -> Table {
    let columns = vec![
        Column::text(""),
        Column::number("from", "s"),
        Column::number("to", "s"),
        Column::text("before"),
    ];
    let mut table = Table::new(format!("Slips of {}", trace.label()), columns);
    for (index, slip) in history.slips.iter().take(MAX_SHOWN_SLIPS).enumerate() {
        table = table.row([
            (index + 1).to_string(),
            format!("{:.4}", slip.from),
            format!("{:.4}", slip.to),
            if slip.from_touch { "no contact" } else { "held" }.to_owned(),
        ]);
    }
    match history.slips.len().saturating_sub(MAX_SHOWN_SLIPS) {
        0 => table,
        more => table.note(format!("{more} more")),
    }
}

fn plot(trace: &Trace, history: &History) -> Plot {
    let cut = |used: &[f64]| used.iter().map(|used| used.min(MAX_DRAWN_SHARE)).collect::<Vec<_>>();
    let drawn = |used: &[f64]| -> Vec<f64> {
        // `min` would take the number where there is none.
        used.iter()
            .zip(cut(used))
            .map(|(&used, cut)| if used.is_nan() { used } else { cut })
            .collect()
    };
    let mut plot = Plot::new(
        trace.label(),
        Axis::new("time", "s"),
        Axis::new("share of the grip in use, 1/margin", ""),
    )
    .level(1.0, "slip");
    if let Some(settled) = &history.settled {
        let series = Series::line("once settled", &trace.time[..], drawn(settled));
        plot = plot.series(series.colour(Colour::Muted));
    }
    plot = plot.series(
        Series::line("now", &trace.time[..], drawn(&history.used)).colour(Colour::MEASURED),
    );
    if let Some(time) = history.first_slip() {
        plot = plot.mark(time, "first slip");
    }
    plot.summary(format!(
        "At most {} of the grip is in use, at {} s",
        percent(history.most_used.0, 3),
        significant(history.most_used.1, 4)
    ))
}

/// Beginning of the header row of [`history_csv`].
pub const HISTORY_HEADER: &str = "time_s,used";

/// Time and share used of every sample as CSV; empty where there is no contact.
#[must_use]
pub fn history_csv(trace: &Trace, history: &History) -> String {
    let mut text = String::from(HISTORY_HEADER);
    if history.settled.is_some() {
        text += ",used_once_settled";
    }
    text.push('\n');
    let cell = |used: f64| if used.is_nan() { String::new() } else { used.to_string() };
    for (k, time) in trace.time.iter().enumerate() {
        text += &format!("{time},{}", cell(history.used[k]));
        if let Some(settled) = &history.settled {
            text += &format!(",{}", cell(settled[k]));
        }
        text.push('\n');
    }
    text
}
