//! The time of the device in terms of the time of the host.

use shared::wire::{Block, Head, Rows, Source, ToHost};

/// Device time that lies further back than this, µs, is that of a device that began anew. Frames wait their turn on the
/// device, so smaller steps back are usual.
const BACKWARDS_US: u64 = 1_000_000;
/// Most anchors that are kept.
const ANCHORS: usize = 4_096;

/// A message with device time `device_us` was heard at host time `host_us`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Anchor {
    device_us: u64,
    host_us: u64,
}

/// Relates the clock of the device to that of the host by when its messages arrive. For any ratio of the two.
///
/// A message may be late, never early: host time of arrival = offset + device time / rate + delay, with a delay that is not
/// negative, often near its least and sometimes long. A line through the middle of the points would follow the load of the
/// computer; so it is laid under them: of all lines that no point lies below, the one with the least sum of delays. That is
/// the line of greatest likelihood for exponential delays (Moon, Skelly and Towsley, 1999), and an edge of the lower convex
/// hull: the one that spans the mean device time. Single late messages do not touch it.
///
/// What cannot be told is the least delay itself: all host times are late by it.
///
/// The clock begins again where the device does: at a `Hello`, which the device says only when asked who it is, and
/// where its time goes back. It keeps up to 4096 anchors; beyond that, of any two neighbours the one that was less late.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    anchors: Vec<Anchor>,
    window_us: Option<u64>,
    /// Latest device time.
    latest_us: u64,
    /// Source of the rows and the first row of the last block: rows that were injected count time on their own.
    source: Option<Source>,
    row: u64,
}

/// The relation as it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockFit {
    /// Device time of a point of the line, µs.
    pub device_us: u64,
    /// Host time of that point, µs.
    pub host_us: f64,
    /// Seconds of the device in one second of the host.
    pub rate: f64,
    /// Standard error of the rate, relative, in parts per million: that of an ordinary regression with the same scatter, more
    /// than the line has. Infinite with two anchors.
    pub standard_error_ppm: f64,
    /// How much later than the least delay messages came on average, µs.
    pub mean_delay_us: f64,
    /// Anchors the line rests on.
    pub anchors: usize,
}

impl ClockFit {
    /// How fast the clock of the device runs against that of the host, parts per million; 0 if the same.
    #[must_use]
    pub fn ppm(&self) -> f64 {
        (self.rate - 1.0) * 1e6
    }

    /// Host time of a device time, µs.
    #[must_use]
    pub fn host_us(&self, device_us: u64) -> f64 {
        self.host_us + difference(device_us, self.device_us) / self.rate
    }
}

impl Clock {
    /// A clock that has heard nothing and forgets nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A clock that forgets what was heard more than `window_us` µs of the host ago, to follow a rate that drifts.
    #[must_use]
    pub fn with_window(window_us: u64) -> Self {
        Self { window_us: Some(window_us), ..Self::default() }
    }

    /// Takes note of a message that arrived at `host_us`. Returns whether the device began anew.
    pub fn hear(&mut self, head: Head, message: &ToHost<'_>, host_us: u64) -> bool {
        match message {
            ToHost::Hello(_) => {
                self.restart();
                self.anchor(head.time_us, host_us);
                true
            }
            ToHost::Status(status) => {
                let reset = self.anchor(head.time_us, host_us);
                self.source = status.streaming;
                reset
            }
            ToHost::Samples(block) => self.hear_rows(head, block, host_us),
            ToHost::Answer(_)
            | ToHost::Settings { .. }
            | ToHost::Converter { .. }
            | ToHost::Log(_)
            | ToHost::Kept(_)
            | ToHost::Event(_)
            | ToHost::Pulse { .. } => self.anchor(head.time_us, host_us),
            // What hears the device gives these in the words of this release.
            ToHost::SettingsByRatio { .. } | ToHost::StatusOfFour(_) | ToHost::SamplesOfFour(_) => {
                false
            }
        }
    }

    /// Takes note of a message of which it is not known when it arrived: what it says of those that follow.
    pub fn overhear(&mut self, message: &ToHost<'_>) {
        match message {
            ToHost::Status(status) => self.source = status.streaming,
            ToHost::Samples(block) => self.see(block),
            _ => {}
        }
    }

    fn see(&mut self, block: &Block<'_>) {
        if block.first < self.row {
            // Another stream; the next status tells its source.
            self.source = None;
        }
        self.row = block.first;
    }

    fn hear_rows(&mut self, head: Head, block: &Block<'_>, host_us: u64) -> bool {
        self.see(block);
        match (self.source, Rows::decode(head, block)) {
            // A block is sent with its last row, not with its first.
            (Some(Source::Converter), Ok(rows)) => self.anchor(rows.last_us(), host_us),
            _ => false,
        }
    }

    /// Takes note that a message of device time `device_us` arrived at `host_us`. Returns whether the device began anew.
    pub fn anchor(&mut self, device_us: u64, host_us: u64) -> bool {
        let reset = device_us.saturating_add(BACKWARDS_US) < self.latest_us;
        if reset {
            self.restart();
        }
        // An older message that arrived later says less than the one before it.
        if self.anchors.last().is_some_and(|last| device_us <= last.device_us) {
            return reset;
        }
        self.latest_us = device_us;
        self.anchors.push(Anchor { device_us, host_us });
        if let Some(window_us) = self.window_us {
            let old = host_us.saturating_sub(window_us);
            let kept = self.anchors.partition_point(|anchor| anchor.host_us < old);
            // All at once now and then, so that each costs little.
            if kept * 2 > self.anchors.len() {
                self.anchors.drain(..kept);
            }
        }
        if self.anchors.len() > ANCHORS {
            self.thin();
        }
        reset
    }

    /// Forgets everything.
    pub fn restart(&mut self) {
        *self = Self { window_us: self.window_us, ..Self::default() };
    }

    /// Keeps of every two neighbours the one that was less late.
    fn thin(&mut self) {
        let Some(fit) = self.fit() else { return };
        let late = |anchor: &Anchor| delay(&fit, anchor);
        let pairs = self.anchors.chunks(2);
        let best = pairs.filter_map(|pair| pair.iter().min_by(|a, b| late(a).total_cmp(&late(b))));
        self.anchors = best.copied().collect();
    }

    /// The line, once two messages were heard.
    #[must_use]
    pub fn fit(&self) -> Option<ClockFit> {
        let heard = self.within_window();
        let origin = heard.first()?;
        let x: Vec<f64> = heard.iter().map(|a| difference(a.device_us, origin.device_us)).collect();
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let hull = lower_hull(heard);
        let after = hull
            .partition_point(|anchor| difference(anchor.device_us, origin.device_us) < mean)
            .max(1);
        let (from, to) = (hull.get(after - 1)?, hull.get(after)?);
        let device = difference(to.device_us, from.device_us);
        let host = difference(to.host_us, from.host_us);
        if host <= 0.0 {
            return None;
        }
        let mut fit = ClockFit {
            device_us: from.device_us,
            host_us: from.host_us as f64,
            rate: device / host,
            standard_error_ppm: f64::INFINITY,
            mean_delay_us: 0.0,
            anchors: heard.len(),
        };
        let late: Vec<f64> = heard.iter().map(|anchor| delay(&fit, anchor)).collect();
        let count = late.len() as f64;
        fit.mean_delay_us = late.iter().sum::<f64>() / count;
        if late.len() > 2 {
            let scatter: f64 = late.iter().map(|delay| (delay - fit.mean_delay_us).powi(2)).sum();
            let spread: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
            // The slope of the line is 1 / rate, so the relative error of the rate is that of the slope times the rate.
            fit.standard_error_ppm = (scatter / (count - 2.0) / spread).sqrt() * fit.rate * 1e6;
        }
        Some(fit)
    }

    /// Anchors that are not too old.
    fn within_window(&self) -> &[Anchor] {
        let Some((window_us, last)) = self.window_us.zip(self.anchors.last()) else {
            return &self.anchors;
        };
        let old = last.host_us.saturating_sub(window_us);
        &self.anchors[self.anchors.partition_point(|anchor| anchor.host_us < old)..]
    }
}

/// How much later than on the line a message came, µs.
fn delay(fit: &ClockFit, anchor: &Anchor) -> f64 {
    anchor.host_us as f64 - fit.host_us(anchor.device_us)
}

/// a − b of two times, µs.
fn difference(a: u64, b: u64) -> f64 {
    (i128::from(a) - i128::from(b)) as f64
}

/// The lower convex hull of points in order of device time.
fn lower_hull(anchors: &[Anchor]) -> Vec<Anchor> {
    let mut hull: Vec<Anchor> = Vec::new();
    for &next in anchors {
        while let [.., a, b] = hull[..]
            && !turns_up(a, b, next)
        {
            hull.pop();
        }
        hull.push(next);
    }
    hull
}

/// Whether the line from a over b to c turns upwards at b.
fn turns_up(a: Anchor, b: Anchor, c: Anchor) -> bool {
    let d = |p: u64, q: u64| i128::from(q) - i128::from(p);
    let rise = d(a.host_us, b.host_us).saturating_mul(d(b.device_us, c.device_us));
    rise < d(b.host_us, c.host_us).saturating_mul(d(a.device_us, b.device_us))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Messages every 20 ms of the host for `seconds`, from a device whose clock runs at `rate` from `from_us`, each late by
    /// at least 300 µs, 1 ms more on average, and one in fifty by up to 80 ms more.
    fn heard(clock: &mut Clock, seconds: u32, from_us: u64, rate: impl Fn(f64) -> f64) -> f64 {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut device_us = from_us as f64;
        for message in 0..seconds * 50 {
            let sent_us = f64::from(message) * 20_000.0;
            let jitter = -1_000.0 * (1.0 - random.random::<f64>()).ln();
            let stall =
                if random.random_bool(0.02) { random.random_range(0.0..80_000.0) } else { 0.0 };
            clock.anchor(device_us as u64, 1_000_000 + (sent_us + 300.0 + jitter + stall) as u64);
            device_us += 20_000.0 * rate(sent_us * 1e-6);
        }
        device_us - 20_000.0 * rate(f64::from(seconds))
    }

    #[test]
    fn any_rate_is_found_to_a_few_parts_per_million_within_a_minute() {
        for rate in [1.0, 1.0 + 25e-6, 1.0 - 40e-6, 62.137, 1e-3] {
            let mut clock = Clock::new();
            heard(&mut clock, 60, 5_000_000, |_| rate);
            let fit = clock.fit().unwrap();
            let error = (fit.rate / rate - 1.0) * 1e6;
            assert!(error.abs() < 5.0, "{rate}: {error} ppm");
            assert!(fit.standard_error_ppm < 10.0 && error.abs() < 3.0 * fit.standard_error_ppm);
            // 1 ms of jitter and 80 ms / 2 in one of fifty.
            assert!((fit.mean_delay_us - 1_800.0).abs() < 300.0, "{}", fit.mean_delay_us);
        }
    }

    #[test]
    fn host_times_are_right_but_for_the_least_delay_even_behind_32_bits() {
        let mut clock = Clock::new();
        let from_us = u64::from(u32::MAX) - 3_000_000;
        heard(&mut clock, 30, from_us, |_| 62.0);
        let fit = clock.fit().unwrap();
        for second in [0, 10, 29, 600] {
            let host = fit.host_us(from_us + 62_000_000 * second);
            let late = host - (1_000_000 + 1_000_000 * second) as f64;
            assert!((late - 300.0).abs() < 300.0, "{late} at {second} s");
        }
    }

    #[test]
    fn late_messages_do_not_bend_the_line_as_they_bend_a_mean() {
        let (mut quiet, mut busy) = (Clock::new(), Clock::new());
        for second in 0..60 {
            let time = second * 1_000_000;
            quiet.anchor(time, time + 500);
            busy.anchor(time, time + if second > 40 && second % 3 > 0 { 90_000 } else { 500 });
        }
        let (quiet, busy) = (quiet.fit().unwrap(), busy.fit().unwrap());
        assert_eq!((quiet.rate, busy.rate), (1.0, 1.0));
        assert_eq!(quiet.mean_delay_us, 0.0);
        assert!(busy.mean_delay_us > 10_000.0);
    }

    #[test]
    fn a_clock_with_a_window_follows_a_rate_that_drifts() {
        let rate = |second: f64| 1.0 + 1e-6 * second / 6.0;
        let mut clock = Clock::with_window(30_000_000);
        let last_us = heard(&mut clock, 600, 0, rate);
        let fit = clock.fit().unwrap();
        assert!((fit.ppm() - 97.5).abs() < 5.0, "{} ppm", fit.ppm());
        let late = fit.host_us(last_us as u64) - 601_000_000.0 + 20_000.0;
        assert!((late - 300.0).abs() < 300.0, "{late}");
    }

    #[test]
    fn a_device_that_began_anew_is_noticed_and_what_came_before_forgotten() {
        let mut clock = Clock::new();
        let last = heard(&mut clock, 20, 0, |_| 1.0) as u64;
        assert!(!clock.anchor(last - 900_000, 30_000_000), "frames wait their turn");
        assert!(clock.anchor(5, 40_000_000));
        assert_eq!(clock.fit(), None);
        assert!(!clock.anchor(2_000_005, 41_000_000));
        assert_eq!(clock.fit().unwrap().rate, 2.0);
    }

    #[test]
    fn hours_take_no_more_memory_than_minutes_and_lose_no_precision() {
        let mut clock = Clock::new();
        heard(&mut clock, 3_600, 0, |_| 1.0 + 12e-6);
        assert!(clock.anchors.len() <= ANCHORS);
        assert!((clock.fit().unwrap().ppm() - 12.0).abs() < 0.2, "{:?}", clock.fit());
    }

    #[test]
    fn without_two_times_there_is_no_relation() {
        let mut clock = Clock::new();
        clock.anchor(7, 100);
        clock.anchor(7, 200);
        assert_eq!(clock.fit(), None);
        clock.anchor(8, 100);
        assert_eq!(clock.fit(), None);
    }

    proptest! {
        #[test]
        fn no_message_is_ever_early_on_the_line(
            steps in prop::collection::vec((1..100_000_u64, 1..5_000_u64), 2..60),
        ) {
            let mut clock = Clock::new();
            let (mut device, mut host) = (0, 0);
            for (device_us, host_us) in steps {
                (device, host) = (device + device_us, host + host_us);
                clock.anchor(device, host);
            }
            let fit = clock.fit().unwrap();
            for anchor in &clock.anchors {
                prop_assert!(delay(&fit, anchor) > -1e-3, "{} µs", delay(&fit, anchor));
            }
        }

        #[test]
        fn any_times_are_taken(times in prop::collection::vec(any::<(u64, u64)>(), 0..60), window: Option<u64>) {
            let mut clock = Clock { window_us: window, ..Clock::new() };
            for (device_us, host_us) in times {
                clock.anchor(device_us, host_us);
                let _ = clock.fit();
            }
        }
    }
}
