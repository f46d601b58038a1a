//! What is known of a session: its rows, what happened, and how the device is.

use std::collections::VecDeque;
use std::time::{Instant, SystemTime};

use serde_json::{Value, json};
use shared::fixed::microstrain;
use shared::phase::{Region, RelaxationType};
use shared::pipeline::GAUGES;
use shared::wire::{Row, Settings, Status};

use super::bench::Bench;
use super::pyramid::{Pyramid, SIGNALS, Values};
use palpate_analysis::regions::{code, name, numeral};
use palpate_link::device::answers::{IdentityAnswer, SettingsAnswer, StatusAnswer};
use palpate_link::device::heard::Identity;
use palpate_link::device::stream::Tally;
use palpate_present::answers;

/// Events kept; older ones are forgotten first.
const EVENTS: usize = 16_384;

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// From then on a gauge is in another region, or relaxes in another way.
    State {
        /// Session time, s.
        time_s: f64,
        /// The gauge, from 0.
        gauge: usize,
        /// Region of the grasp.
        region: Region,
        /// Type of relaxation.
        relaxation: RelaxationType,
    },
    /// Nothing is known of this stretch.
    Gap {
        /// From here, s.
        from_s: f64,
        /// To here, s.
        to_s: f64,
        /// Why, and how much.
        words: String,
    },
    /// A line of the log.
    Said {
        /// Session time, s.
        time_s: f64,
        /// What was said.
        words: String,
    },
}

impl Event {
    /// As the page reads it.
    #[must_use]
    pub fn json(&self) -> Value {
        match self {
            Self::State { time_s, gauge, region, relaxation } => {
                let (points, words) = name(*region);
                json!({
                    "kind": "state", "time_s": time_s, "gauge": gauge, "region": code(*region),
                    "points": points, "name": words, "type": numeral(*relaxation),
                })
            }
            Self::Gap { from_s, to_s, words } => {
                json!({ "kind": "gap", "from_s": from_s, "to_s": to_s, "words": words })
            }
            Self::Said { time_s, words } => {
                json!({ "kind": "said", "time_s": time_s, "words": words })
            }
        }
    }

    fn reaches(&self, from_s: f64, to_s: f64) -> bool {
        match self {
            Self::State { time_s, .. } | Self::Said { time_s, .. } => {
                (from_s..=to_s).contains(time_s)
            }
            Self::Gap { from_s: begin, to_s: end, .. } => *begin <= to_s && *end >= from_s,
        }
    }
}

/// How device and session are.
#[derive(Clone, Debug, Default)]
pub struct Health {
    /// Whether the device is there.
    pub linked: bool,
    /// Whether a stream is on.
    pub streaming: bool,
    /// Why the device is not there.
    pub trouble: Option<String>,
    /// The file that is being written, and its rows.
    pub recording: Option<(String, u64)>,
    /// What came and what did not.
    pub tally: Tally,
    /// Times that something was missing.
    pub gaps: u64,
    /// Frames that wait to be taken: now, and the most that ever did.
    pub backlog: (usize, usize),
    /// Progress of a replay, 0 to 1.
    pub replayed: Option<f64>,
    /// How the device's own log stands, in words.
    pub log: String,
    device: Value,
    settings: Value,
    status: Value,
}

impl Health {
    /// Who the device is, as the page reads it.
    #[must_use]
    pub fn device(&self) -> Value {
        self.device.clone()
    }

    /// Who the device is.
    pub fn identify(&mut self, identity: &Identity) {
        self.device = answers::json(&IdentityAnswer::from(identity));
    }

    /// Its settings.
    pub fn set(&mut self, settings: &Settings) {
        self.settings = answers::json(&SettingsAnswer::of(settings));
    }

    /// What it last said of itself.
    pub fn status(&mut self, status: &Status) {
        self.status = answers::json(&StatusAnswer::from(status));
    }
}

/// A session.
pub struct Store {
    /// Its rows.
    pub pyramid: Pyramid,
    /// How it is.
    pub health: Health,
    /// What else is shown of it.
    pub bench: Bench,
    began: Instant,
    /// Device time is so far behind that of the session, s; none before the first row of a stream.
    offset_s: Option<f64>,
    /// When the last rows arrived, ms since 1970.
    arrived_ms: f64,
    states: [Option<(Region, RelaxationType)>; GAUGES],
    events: VecDeque<Event>,
    happened: u64,
    rate: Rate,
}

/// Rows in a second, over the last second.
struct Rate {
    since: Instant,
    rows: u64,
    hz: f64,
}

impl Store {
    /// An empty session that begins now.
    #[must_use]
    pub fn new() -> Self {
        let now = Instant::now();
        Self {
            pyramid: Pyramid::default(),
            health: Health::default(),
            bench: Bench::default(),
            began: now,
            offset_s: None,
            arrived_ms: 0.0,
            states: [None; GAUGES],
            events: VecDeque::new(),
            happened: 0,
            rate: Rate { since: now, rows: 0, hz: 0.0 },
        }
    }

    /// Session time, s: that of the last row, or of the host where none has come for long.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.pyramid.last_s().unwrap_or_else(|| self.began.elapsed().as_secs_f64())
    }

    /// A stream begins: its device time starts anew, and so do its regions.
    pub fn begin_stream(&mut self) {
        self.offset_s = None;
        self.states = [None; GAUGES];
    }

    /// Takes the rows of a block, `interval_s` apart.
    pub fn take(&mut self, rows: &[Row], interval_s: f64) {
        self.arrived_ms = SystemTime::now()
            .duration_since(SystemTime::UNIX_EPOCH)
            .map_or(0.0, |since| since.as_secs_f64() * 1e3);
        for row in rows {
            let device_s = row.time_us as f64 * 1e-6;
            let offset_s = match self.offset_s {
                Some(offset_s) => offset_s,
                None => self.join(device_s, interval_s),
            };
            // A clock that goes back, as after a reset nobody told of, does not take the session with it.
            let time_s = self.pyramid.last_s().map_or(f64::MIN, |s| s).max(device_s + offset_s);
            self.note_states(row, time_s, interval_s);
            self.pyramid.push(time_s, interval_s, &values(row));
        }
    }

    /// The first row of a stream comes now, or behind the last row; what lies between is a gap.
    fn join(&mut self, device_s: f64, interval_s: f64) -> f64 {
        let passed_s = self.began.elapsed().as_secs_f64();
        let last_s = self.pyramid.last_s();
        let to_s = last_s.map_or(passed_s, |last_s| passed_s.max(last_s + interval_s));
        if let Some(from_s) = last_s {
            self.happen(Event::Gap { from_s, to_s, words: "another stream".into() });
        }
        let offset_s = to_s - device_s;
        self.offset_s = Some(offset_s);
        offset_s
    }

    fn note_states(&mut self, row: &Row, time_s: f64, interval_s: f64) {
        for gauge in 0..GAUGES {
            let now = (row.states[gauge].region, row.states[gauge].relaxation);
            if self.states[gauge] == Some(now) {
                continue;
            }
            self.states[gauge] = Some(now);
            // A region that was recognised late is put back to where it was entered.
            let late_s = row.entered[gauge].map_or(0.0, |samples| f64::from(samples) * interval_s);
            let (region, relaxation) = now;
            self.happen(Event::State { time_s: time_s - late_s, gauge, region, relaxation });
        }
    }

    /// Something happened.
    pub fn happen(&mut self, event: Event) {
        if self.events.len() >= EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
        self.happened += 1;
    }

    /// A line for the log of the session.
    pub fn say(&mut self, words: impl Into<String>) {
        self.happen(Event::Said { time_s: self.now_s(), words: words.into() });
    }

    /// Number of the event that comes next.
    #[must_use]
    pub const fn happened(&self) -> u64 {
        self.happened
    }

    /// The events from a number on, those that are not forgotten.
    pub fn events_after(&self, from: u64) -> impl Iterator<Item = &Event> {
        let first = self.happened - self.events.len() as u64;
        let skip = (from.max(first) - first).min(self.events.len() as u64) as usize;
        self.events.range(skip..)
    }

    /// The events of a stretch of time, s, and the state of each gauge when it begins.
    #[must_use]
    pub fn events_of(&self, from_s: f64, to_s: f64) -> Vec<&Event> {
        let mut before: [Option<&Event>; GAUGES] = [None; GAUGES];
        for event in &self.events {
            if let Event::State { time_s, gauge, .. } = event
                && *time_s < from_s
            {
                before[*gauge] = Some(event);
            }
        }
        let within = self.events.iter().filter(|event| event.reaches(from_s, to_s));
        before.into_iter().flatten().chain(within).collect()
    }

    /// When the last rows arrived, ms since 1970.
    #[must_use]
    pub const fn arrived_ms(&self) -> f64 {
        self.arrived_ms
    }

    /// How all of it is, as the page reads it.
    pub fn health_json(&mut self) -> Value {
        let passed = self.rate.since.elapsed().as_secs_f64();
        if passed >= 1.0 {
            let rows = self.pyramid.count();
            self.rate.hz = (rows - self.rate.rows) as f64 / passed;
            (self.rate.since, self.rate.rows) = (Instant::now(), rows);
        }
        let Health { tally, .. } = &self.health;
        json!({
            "linked": self.health.linked,
            "streaming": self.health.streaming,
            "trouble": self.health.trouble,
            "recording": self.health.recording.as_ref().map(|(file, rows)| {
                json!({ "file": file, "rows": rows })
            }),
            "replayed": self.health.replayed,
            "log": self.health.log,
            "rate_hz": self.rate.hz,
            "rows": tally.rows,
            "rows_lost": tally.rows_lost,
            "frames_lost": tally.frames_lost,
            "frames_damaged": tally.damaged,
            "gaps": self.health.gaps,
            "backlog_frames": self.health.backlog.0,
            "backlog_frames_most": self.health.backlog.1,
            "device": self.health.device,
            "settings": self.health.settings,
            "status": self.health.status,
            "now_s": self.now_s(),
            "since_s": self.pyramid.since_s(),
        })
    }
}

impl Default for Store {
    fn default() -> Self {
        Self::new()
    }
}

/// Calibrated strain, FA, SA, elastic input and equilibrium, µε, each of four gauges.
fn values(row: &Row) -> Values {
    let (elastic, equilibrium) = row.rest.unwrap_or_default();
    let strain: [i32; GAUGES] = std::array::from_fn(|gauge| row.fa[gauge] + row.sa[gauge]);
    let mut values = [0.0; SIGNALS];
    let all = [strain, row.fa, row.sa, elastic, equilibrium];
    for (value, lsb) in values.iter_mut().zip(all.iter().flatten()) {
        *value = microstrain(*lsb) as f32;
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::pipeline::Pipeline;
    use shared::wire::{Columns, Rows};

    const INTERVAL_S: f64 = 1e-3;

    /// Rows of a device that is pressed at once and held.
    fn press(count: u64) -> Vec<Row> {
        let config = Settings::DEFAULT.config(INTERVAL_S).unwrap();
        let calibration = config.calibration;
        let mut pipeline = Pipeline::new(&config);
        let mut all = Vec::new();
        for number in 0..count {
            let counts = [if number < count / 4 { 0 } else { 60_000 }; GAUGES];
            pipeline.process(&counts, 25 * 256);
            let mut rows = Rows::new();
            rows.begin(Columns::All, number, number * 1_000, number * 1_000);
            assert!(rows.push(number * 1_000, &counts, &pipeline));
            all.extend(rows.iter(&calibration));
        }
        all
    }

    #[test]
    fn regions_are_marked_as_they_are_found_and_fa_and_sa_make_the_signal() {
        let mut store = Store::new();
        store.take(&press(2_000), INTERVAL_S);
        let found = |wanted| {
            store
                .events_after(0)
                .any(|event| matches!(event, Event::State { region, .. } if *region == wanted))
        };
        assert!(found(Region::Rest) && found(Region::Loading) && found(Region::Relaxation));
        let (_, rows) = store.pyramid.after(0);
        for row in rows {
            assert_eq!(row.values[0], row.values[4] + row.values[8]);
        }
    }

    #[test]
    fn time_goes_on_when_a_device_begins_anew() {
        let mut store = Store::new();
        store.take(&press(100), INTERVAL_S);
        store.begin_stream();
        store.take(&press(100), INTERVAL_S);
        let (_, rows) = store.pyramid.after(0);
        let times: Vec<f64> = rows.map(|row| row.time_s).collect();
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn a_stretch_of_time_knows_the_state_it_begins_in_and_old_events_are_forgotten() {
        let mut store = Store::new();
        for index in 0..2 * EVENTS {
            let (region, relaxation) = (Region::Loading, RelaxationType::None);
            store.happen(Event::State { time_s: index as f64, gauge: 2, region, relaxation });
        }
        assert_eq!(store.events_after(0).count(), EVENTS);
        let end = 2.0 * EVENTS as f64;
        assert_eq!(store.events_of(end - 1.5, end).len(), 2);
    }
}
