//! A device in words, and as JSON.

use serde_json::{Value, json};
use shared::fixed::{celsius, microstrain};
use shared::wire::{ClockSource, Counters, Felt, Kept, ResetCause, Settings, Source, Status};

use super::change::{Threshold, rate_hz};
use super::heard::Identity;
use super::record::View;
use super::refusal::Fault;
use palpate_analysis::events::name;
use palpate_trace::recording::parts;

/// Why a device began.
#[must_use]
pub const fn reset_in_words(reset: ResetCause) -> &'static str {
    match reset {
        ResetCause::PowerOn => "power came",
        ResetCause::BrownOut => "the supply was low",
        ResetCause::Pin => "the reset button",
        ResetCause::Software => "it was told to, or panicked",
        ResetCause::Watchdog => "a part of the program stood still",
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

/// Who a device is.
#[must_use]
pub fn identity_json(identity: &Identity) -> Value {
    json!({
        "board": identity.board,
        "version": identity.version,
        "git": identity.git,
        "serial": identity.serial_number(),
        "channels": identity.channels,
        "converter_clock_hz": identity.converter_clock_hz,
        "clock": clock_in_words(identity.clock),
        "reset": reset_in_words(identity.reset),
        "panic": identity.panic,
        "settings": identity.kept.and_then(kept_in_words),
    })
}

/// Settings.
#[must_use]
pub fn settings_json(settings: &Settings, converter_clock_hz: u32) -> Value {
    let gauge = |gauge: usize| {
        let sheet = &settings.calibration[gauge];
        json!({
            "gain": settings.gain[gauge],
            "ustrain_per_count": sheet.gain,
            "offset_counts": sheet.offset,
            "temperature_coefficient_ustrain_per_celsius": sheet.temperature_coefficient,
            "reference_celsius": sheet.reference_celsius,
            "tare_ustrain": microstrain(settings.tare[gauge]),
        })
    };
    let thresholds = Threshold::ALL.map(|(threshold, name, _)| (name, threshold.of(settings)));
    let relaxation = settings.relaxation;
    json!({
        "rate_hz": rate_hz(settings.oversampling, converter_clock_hz),
        "relaxation": {
            "c1": relaxation.c1, "v1": relaxation.v1, "c2": relaxation.c2, "v2": relaxation.v2,
        },
        "thresholds": thresholds.into_iter().map(|(name, value)| (name.to_owned(), json!(value)))
            .collect::<serde_json::Map<_, _>>(),
        "gauges": [gauge(0), gauge(1), gauge(2), gauge(3)],
    })
}

/// How a device is.
#[must_use]
pub fn status_json(status: &Status) -> Value {
    let counters = named(&status.counters).map(|(name, count)| (name.to_owned(), json!(count)));
    json!({
        "counters": counters.into_iter().collect::<serde_json::Map<_, _>>(),
        "rows": status.rows,
        "streaming": status.streaming.map(|source| match source {
            Source::Converter => "converter",
            Source::Link { .. } => "link",
        }),
        "temperature_celsius": status.temperature.map(celsius),
        "converter": status.converter.map(|fault| Fault(fault).to_string()),
        "stack_used_bytes": status.stack_used,
    })
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

/// An event that a device tells: what, when by its clock, and on which gauge.
#[must_use]
pub fn felt_in_words(felt: &Felt) -> String {
    let (time_s, gauge) = (felt.time_us as f64 * 1e-6, felt.event.channel + 1);
    format!("{} at {time_s:.3} s of the device, gauge {gauge}", name(felt.event.kind))
}

/// An event that a device tells, for programs.
#[must_use]
pub fn felt_json(felt: &Felt) -> Value {
    json!({
        "event": name(felt.event.kind),
        "number": felt.number,
        "row": felt.row,
        "device_time_s": felt.time_us as f64 * 1e-6,
        "began_rows_before": felt.event.began_samples_ago,
        "gauge": u32::from(felt.event.channel) + 1,
    })
}

/// How a recording goes.
#[must_use]
pub fn view_json(view: &View) -> Value {
    let gauges = view.row.as_ref().map(|row| {
        parts(row).map(|(fa, sa)| json!({ "fa_ustrain": fa, "sa_ustrain": sa })).to_vec()
    });
    json!({
        "time_s": view.passed.as_secs_f64(),
        "linked": view.linked,
        "rate_hz": view.rate_hz,
        "rows": view.tally.rows,
        "rows_lost": view.tally.rows_lost,
        "frames_lost": view.tally.frames_lost,
        "frames_damaged": view.tally.damaged,
        "bytes": view.tally.bytes,
        "gaps": view.gaps,
        "drops": view.drops,
        "backlog_frames": view.backlog.0,
        "backlog_frames_most": view.backlog.1,
        "gauges": gauges,
    })
}
