//! A device in words.

use shared::wire::{ClockSource, Counters, Felt, Kept, ResetCause};

use super::heard::Identity;
use super::record::View;
use palpate_analysis::events::name;
use palpate_trace::recording::parts;

/// Why a device began.
#[must_use]
pub const fn reset_in_words(reset: ResetCause) -> &'static str {
    match reset {
        ResetCause::PowerOn => "power-on",
        ResetCause::BrownOut => "brown-out: the supply was low",
        ResetCause::Pin => "reset button",
        ResetCause::Software => "software: asked for, or after a panic",
        ResetCause::Watchdog => "watchdog: a part of the program stood still",
    }
}

/// What a device takes its time from.
#[must_use]
pub const fn clock_in_words(clock: ClockSource) -> &'static str {
    match clock {
        ClockSource::Crystal => "crystal",
        ClockSource::Internal => "internal oscillator, 1 %: the crystal did not start",
        ClockSource::Simulated => "simulated",
    }
}

/// Who a device is, in one line.
#[must_use]
pub fn one_line(identity: &Identity) -> String {
    let Identity { board, version, git, .. } = identity;
    let git = if git.is_empty() { String::new() } else { format!(" ({git})") };
    format!("{board}, firmware {version}{git}, serial {}", identity.serial_number())
}

/// What a user must know of the settings that were kept.
#[must_use]
pub const fn kept_in_words(kept: Kept) -> Option<&'static str> {
    match kept {
        Kept::None | Kept::All => None,
        Kept::Calibration => Some(
            "saved by firmware of another release: gains, calibration and tare are as they were saved, the rest is at its \
             defaults; set it anew and save it",
        ),
        Kept::Discarded => Some(
            "those that were saved cannot be read or are out of range, calibration and tare too; all are at their defaults",
        ),
    }
}

/// The counters by name.
#[must_use]
pub fn named(counters: &Counters) -> [(&'static str, u32); 8] {
    [
        ("conversions_missed", counters.conversions_missed),
        ("conversions_damaged", counters.conversions_damaged),
        ("queue_full", counters.queue_full),
        ("link_full", counters.link_full),
        ("log_full", counters.log_full),
        ("bytes_lost", counters.bytes_lost),
        ("frames_damaged", counters.frames_damaged),
        ("frames_missed", counters.frames_missed),
    ]
}

/// How a recording goes, in one line.
#[must_use]
pub fn live_line(view: &View) -> String {
    let time = view.passed.as_secs_f64();
    if !view.linked {
        return format!("{time:7.1} s  the device is gone; waiting for it");
    }
    let gauges = view.row.as_ref().map_or(String::new(), |row| {
        let words = parts(row).map(|(fa, sa)| format!("{fa:7.1} {sa:7.1}"));
        format!("  FA SA µε {}", words.join(" |"))
    });
    format!(
        "{time:7.1} s {:6.1} Hz {:9} rows  {} gaps {} drops{gauges}",
        view.rate_hz, view.tally.rows, view.gaps, view.drops
    )
}

/// How a recording of several devices goes, in one line.
#[must_use]
pub fn live_line_of_all(views: &[View]) -> String {
    let time = views.first().map_or(0.0, |view| view.passed.as_secs_f64());
    let devices = views.iter().map(|view| match view.linked {
        true => format!(
            "{:6.1} Hz {:9} rows {} gaps {} drops",
            view.rate_hz, view.tally.rows, view.gaps, view.drops
        ),
        false => "gone; waiting for it".into(),
    });
    format!("{time:7.1} s  {}", devices.collect::<Vec<_>>().join("  | "))
}

/// An event that a device tells: what, when by its clock, and on which gauge.
#[must_use]
pub fn felt_in_words(felt: &Felt) -> String {
    let (time_s, gauge) = (felt.time_us as f64 * 1e-6, felt.event.channel + 1);
    format!("{} at {time_s:.3} s of the device, gauge {gauge}", name(felt.event.kind))
}
