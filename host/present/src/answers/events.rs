//! `palpate events`: touch, release and slip in recordings.

use palpate_analysis::events::{Events, Found, happened, judge};
use palpate_trace::Trace;
use serde::Serialize;
use shared::events::{Kind, Settings};

use crate::summary::unit_of;

/// The events of recordings.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct EventsAnswer {
    /// Version of this answer.
    pub palpate_events: u32,
    /// Each recording.
    pub traces: Vec<TraceEvents>,
}

/// The events of one recording.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct TraceEvents {
    /// Name of the trace.
    pub trace: String,
    /// The columns that feel one contact.
    pub signals: Vec<String>,
    /// Unit of the signals.
    pub unit: String,
    /// Largest standard deviation of the noise of one sample among the signals, in their unit; null where it cannot be estimated.
    pub noise: Option<f64>,
    /// Samples per second, by the median interval, Hz.
    #[serde(rename = "rate_Hz")]
    pub rate_hz: f64,
    /// What was looked for.
    pub settings: EventSettings,
    /// The events, in the order in which they were reported.
    pub events: Vec<EventAnswer>,
    /// What happened according to the simulation; null for a recording that is not simulated.
    pub happened: Option<Vec<HappenedAnswer>>,
}

/// Levels by which events are found, in the unit of the signals.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct EventSettings {
    /// FA at or beyond which there is a burst.
    pub burst: f64,
    /// Vibration of FA at or beyond which there is a jolt.
    pub jolt: f64,
    /// Jolts that make a slip, 2 to 8; 0 where slip is not looked for.
    pub jolts: u8,
    /// Time within which these jolts come, s.
    pub within_s: f64,
    /// Frequency above which FA counts as vibration, Hz.
    #[serde(rename = "corner_Hz")]
    pub corner_hz: f64,
}

/// One event.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct EventAnswer {
    /// What happened.
    pub kind: EventKind,
    /// Time at which it was reported, s.
    pub told_s: f64,
    /// Time at which it began by hindsight, s.
    pub began_s: f64,
    /// From its beginning to the report, s.
    pub delay_s: f64,
    /// The column that showed it.
    pub signal: String,
    /// Whether nothing happened there; null for a recording that is not simulated.
    pub false_alarm: Option<bool>,
}

/// Something that happened in a simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct HappenedAnswer {
    /// What happened.
    pub kind: EventKind,
    /// Time at which it happened, s.
    pub time_s: f64,
    /// From there to the report, s; null where it was missed.
    pub told_after_s: Option<f64>,
}

/// A kind of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// Contact began.
    Touch,
    /// Contact ended.
    Release,
    /// The contact begins to slip.
    Slip,
}

impl EventsAnswer {
    /// The events of each recording.
    #[must_use]
    pub fn of(traces: &[(&Trace, Events)]) -> Self {
        let one = |(trace, events): &(&Trace, Events)| TraceEvents::of(trace, events);
        Self { palpate_events: 1, traces: traces.iter().map(one).collect() }
    }
}

impl TraceEvents {
    /// The events of a recording.
    #[must_use]
    pub fn of(trace: &Trace, events: &Events) -> Self {
        let known = happened(trace);
        let judged = judge(&known, &events.found);
        let simulated = !known.is_empty();
        let event = |(place, found): (usize, &Found)| {
            let signal = events.channels.get(found.channel);
            EventAnswer {
                kind: found.kind.into(),
                told_s: found.told_s,
                began_s: found.began_s,
                delay_s: found.told_s - found.began_s,
                signal: signal.map_or(String::new(), |channel| channel.signal.clone()),
                false_alarm: simulated.then(|| judged.false_alarms.contains(&place)),
            }
        };
        let happened = known.iter().zip(&judged.delay_s).map(|((kind, at), (_, delay))| {
            HappenedAnswer { kind: (*kind).into(), time_s: *at, told_after_s: *delay }
        });
        let signals: Vec<String> =
            events.channels.iter().map(|channel| channel.signal.clone()).collect();
        Self {
            trace: trace.label(),
            unit: signals.first().map_or("", |signal| unit_of(signal)).to_owned(),
            signals,
            noise: events.noise,
            rate_hz: events.rate_hz,
            settings: (&events.settings).into(),
            events: events.found.iter().enumerate().map(event).collect(),
            happened: simulated.then(|| happened.collect()),
        }
    }
}

impl From<&Settings> for EventSettings {
    fn from(settings: &Settings) -> Self {
        let Settings { burst, jolt, jolts, within_s, corner_hz, .. } = *settings;
        Self { burst, jolt, jolts, within_s, corner_hz }
    }
}

impl From<Kind> for EventKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Touch => Self::Touch,
            Kind::Release => Self::Release,
            Kind::Slip => Self::Slip,
        }
    }
}
