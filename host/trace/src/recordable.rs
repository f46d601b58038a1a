//! A trace as the recording that a device would have made of it, to try without hardware what needs a recording.
//!
//! The strain of the gauges is what the device measures: as counts, under a calibration of 1/256 µε per count, so that one
//! count is one LSB of strain. The pipeline of the device gives everything else. The stream is that of injected rows, and
//! the clocks of device and host are the same.

use std::io::{self, Write};

use shared::calibration::Sheet;
use shared::fixed::{strain_from_microstrain, temperature_from_celsius};
use shared::pipeline::{Config, GAUGES, Pipeline};
use shared::wire::{
    ClockSource, Columns, Counters, FRAME_MAX, Formats, Head, Hello, PerGauge, ResetCause, Rows,
    SCHEMA, Settings, SettingsByRatio, SettingsError, Source, Status, ToHost, encode,
};

use super::{GAUGES as NAMES, TEMPERATURE, Trace, recorded, sampling};
use crate::recording::{Opened, Writer};

/// What stands where a recording of a device names its port, if palpate computed it; the command follows.
pub const COMPUTED: &str = "computed by ";
/// Board of the device that a trace is taken to come from.
pub const BOARD: &str = "trace";
/// Time between two messages of status, µs.
const STATUS_US: u64 = 1_000_000;
/// Largest deviation of an interval from the usual one, relative: with more a recording is uneven.
const MAX_UNEVENNESS: f64 = 0.05;
/// An interval of so many usual ones is a gap.
const GAP_INTERVALS: f64 = 1.9;
/// Shortest and longest interval, s: device times are whole microseconds, and an interval fits 32 bits of nanoseconds.
const INTERVAL_S: std::ops::RangeInclusive<f64> = 1e-5..=4.0;

/// Why no device can have recorded a trace.
#[derive(Debug, thiserror::Error)]
pub enum RecordableError {
    /// Nothing a device would measure.
    #[error(
        "{trace}: no gauge (`gauge1_ustrain` … `gauge4_ustrain`), so there is nothing a device could have recorded."
    )]
    NoGauge {
        /// The trace's label.
        trace: String,
    },
    /// A device samples evenly.
    #[error(
        "{trace}: unevenly sampled at {at_s} s; a device samples evenly. Give it an even clock with `palpate import`."
    )]
    Uneven {
        /// The trace's label.
        trace: String,
        /// Where, s.
        at_s: f64,
    },
    /// Too fast or too slow.
    #[error(
        "{trace}: a sample each {interval_s} s; a device takes one each {} s to {} s.",
        INTERVAL_S.start(), INTERVAL_S.end()
    )]
    Interval {
        /// The trace's label.
        trace: String,
        /// Its interval, s.
        interval_s: f64,
    },
    /// Settings that do not suit the rate.
    #[error("{trace}: a device cannot run so: {source}.")]
    Settings {
        /// The trace's label.
        trace: String,
        /// What is out of range.
        source: SettingsError,
    },
    /// The file system, or what else takes the bytes.
    #[error(transparent)]
    Write(#[from] io::Error),
}

/// The settings in the head of a trace that came from a device, else those a device is made with.
#[must_use]
pub fn settings_of(trace: &Trace) -> Settings {
    let device = trace.head.other.get("device").and_then(|device| device.get(recorded::SETTINGS));
    device.and_then(read).unwrap_or(Settings::DEFAULT)
}

/// Settings in the words of this release, or of 0.1.
fn read(settings: &toml::Value) -> Option<Settings> {
    let by_ratio = |settings: SettingsByRatio| settings.settings(SettingsByRatio::CLOCK_HZ);
    let of_release_0_1 = || settings.clone().try_into().ok().map(by_ratio);
    settings.clone().try_into().ok().or_else(of_release_0_1)
}

/// The same settings, but one count is one LSB of strain.
fn with_unit_calibration(settings: &Settings) -> Settings {
    let sheet = Sheet {
        gain: 1.0 / 256.0,
        offset: 0,
        temperature_coefficient: 0.0,
        reference_celsius: 25.0,
    };
    Settings { calibration: [sheet; GAUGES], tare: [0; GAUGES], gain: [1; GAUGES], ..*settings }
}

/// A trace as the samples of a device's converter, to be put into a device.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// Settings under which a count is one LSB of strain.
    pub settings: Settings,
    /// Time between two samples, s.
    pub interval_s: f64,
    /// Counts of the gauges, stretch by stretch between gaps; never empty.
    pub stretches: Vec<Vec<[i32; GAUGES]>>,
}

/// The samples a device would have taken. Gauges that the trace does not have rest at 0.
///
/// # Errors
/// [`RecordableError`].
pub fn samples(trace: &Trace) -> Result<Samples, RecordableError> {
    let label = || trace.label();
    let signals = NAMES.map(|name| trace.column(name));
    if signals.iter().all(Option::is_none) {
        return Err(RecordableError::NoGauge { trace: label() });
    }
    let interval_s = interval_s(trace)?;
    let settings = with_unit_calibration(&settings_of(trace));
    settings
        .config(interval_s)
        .map_err(|source| RecordableError::Settings { trace: label(), source })?;
    let numbers = row_numbers(trace, interval_s)?;
    let mut stretches: Vec<Vec<[i32; GAUGES]>> = Vec::new();
    for (index, number) in numbers.iter().enumerate() {
        let strain = |values: &[f64]| strain_from_microstrain(values[index]);
        let counts = signals.map(|signal| signal.map_or(0, strain));
        match stretches.last_mut() {
            Some(stretch) if *number == numbers[index - 1] + 1 => stretch.push(counts),
            _ => stretches.push(vec![counts]),
        }
    }
    Ok(Samples { settings, interval_s, stretches })
}

/// Writes the recording: `Hello`, settings, all rows with all columns, and a status each second. Calibration and tare of the
/// settings are replaced. Gauges that the trace does not have rest at 0. A gap in time becomes rows that were lost.
///
/// # Errors
/// [`RecordableError`].
pub fn write_recording(
    trace: &Trace,
    settings: &Settings,
    out: impl Write,
) -> Result<(), RecordableError> {
    let label = || trace.label();
    let signals = NAMES.map(|name| trace.column(name));
    if signals.iter().all(Option::is_none) {
        return Err(RecordableError::NoGauge { trace: label() });
    }
    let interval_s = interval_s(trace)?;
    let numbers = row_numbers(trace, interval_s)?;
    let settings = with_unit_calibration(settings);
    let config = settings
        .config(interval_s)
        .map_err(|source| RecordableError::Settings { trace: label(), source })?;
    let source = Source::Link { interval_ns: (interval_s * 1e9).round() as u32 };
    let mut device = Device::begin(out, trace, settings, &config, source)?;
    let temperature = trace.column(TEMPERATURE);
    for (index, (time, number)) in trace.time.iter().zip(numbers).enumerate() {
        let strain = |values: &[f64]| strain_from_microstrain(values[index]);
        let counts = signals.map(|signal| signal.map_or(0, strain));
        let temperature = temperature.map(|values| temperature_from_celsius(values[index]));
        let time_us = ((time - trace.time[0]) * 1e6).round() as u64;
        device.sample(number, time_us, counts, temperature)?;
    }
    device.end()
}

/// The usual interval, s.
fn interval_s(trace: &Trace) -> Result<f64, RecordableError> {
    let sampling = sampling(&trace.time);
    let interval_s = sampling.map_or(0.0, |s| s.interval_s.unwrap_or(s.median_s));
    match INTERVAL_S.contains(&interval_s) {
        true => Ok(interval_s),
        false => Err(RecordableError::Interval { trace: trace.label(), interval_s }),
    }
}

/// The number of each sample in the stream, those counted that a gap leaves out.
fn row_numbers(trace: &Trace, interval_s: f64) -> Result<Vec<u64>, RecordableError> {
    let mut numbers = vec![0];
    for pair in trace.time.windows(2) {
        let steps = (pair[1] - pair[0]) / interval_s;
        if (steps - 1.0).abs() > MAX_UNEVENNESS && steps < GAP_INTERVALS {
            return Err(RecordableError::Uneven { trace: trace.label(), at_s: pair[1] });
        }
        numbers.push(numbers[numbers.len() - 1] + steps.round() as u64);
    }
    Ok(numbers)
}

/// What stands for the port: the trace, or what computed it.
fn origin(trace: &Trace) -> String {
    let computed = trace.head.computed_by.as_ref().map(|command| format!("{COMPUTED}{command}"));
    computed.unwrap_or_else(|| trace.label())
}

/// A device on its way through a trace.
struct Device<W: Write> {
    writer: Writer<W>,
    sequence: u32,
    pipeline: Pipeline,
    source: Source,
    rows: Rows,
    /// Number and device time, µs, of the next row, as far as is known.
    next: u64,
    now_us: u64,
    status_us: u64,
}

impl<W: Write> Device<W> {
    fn begin(
        out: W,
        trace: &Trace,
        settings: Settings,
        config: &Config,
        source: Source,
    ) -> Result<Self, RecordableError> {
        let mut device = Self {
            writer: Writer::new(out, &Opened::timeless(&origin(trace)))?,
            sequence: 0,
            pipeline: Pipeline::new(config),
            source,
            rows: Rows::new(),
            next: 0,
            now_us: 0,
            status_us: 0,
        };
        device.say(&ToHost::Hello(Hello {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            git: "",
            board: BOARD,
            serial: [0; 3],
            channels: GAUGES as u8,
            converter_clock_hz: 8_000_000,
            clock: ClockSource::Simulated,
            formats: Formats::OURS,
            reset: ResetCause::PowerOn,
            panic: "",
            counters: Counters::default(),
        }))?;
        device.say(&ToHost::Settings { generation: 1, settings })?;
        Ok(device)
    }

    fn sample(
        &mut self,
        number: u64,
        time_us: u64,
        counts: [i32; GAUGES],
        temperature: Option<i16>,
    ) -> io::Result<()> {
        self.pipeline.process(&counts, temperature.unwrap_or(0));
        let goes_on = !self.rows.is_empty() && number == self.next;
        if !(goes_on && self.rows.push(time_us, &counts, &self.pipeline)) {
            self.send_rows()?;
            self.rows.begin(Columns::All, number, time_us, self.now_us);
            (self.rows.generation, self.rows.temperature) = (1, temperature);
            // The first row of a block always fits.
            let _ = self.rows.push(time_us, &counts, &self.pipeline);
        }
        (self.next, self.now_us) = (number + 1, time_us);
        if time_us >= self.status_us {
            self.status_us = time_us + STATUS_US;
            self.send_rows()?;
            self.say_status()?;
        }
        Ok(())
    }

    /// Sends the rows that wait.
    fn send_rows(&mut self) -> io::Result<()> {
        if !self.rows.is_empty() {
            let mut frame = [0; FRAME_MAX];
            let bytes = self.rows.encode(self.sequence, &mut frame).map_err(io::Error::other)?;
            self.sequence = self.sequence.wrapping_add(1);
            self.writer.frame(self.now_us, &bytes[..bytes.len() - 1])?;
            self.rows.clear();
        }
        Ok(())
    }

    fn say_status(&mut self) -> io::Result<()> {
        self.say(&ToHost::Status(Status {
            gauges: PerGauge(self.pipeline.counters()),
            rows: self.next,
            streaming: Some(self.source),
            temperature: self.rows.temperature,
            ..Status::default()
        }))
    }

    fn say(&mut self, message: &ToHost<'_>) -> io::Result<()> {
        let head = Head { sequence: self.sequence, time_us: self.now_us };
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = [0; FRAME_MAX];
        let bytes = encode(head, message, &mut frame).map_err(io::Error::other)?;
        self.writer.frame(self.now_us, &bytes[..bytes.len() - 1])
    }

    fn end(mut self) -> Result<(), RecordableError> {
        self.send_rows()?;
        self.say_status()?;
        self.writer.close(self.now_us)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Reader;
    use crate::{recorded::Options, recorded::to_traces};
    use std::path::Path;

    fn trace(time: Vec<f64>, strain: impl Fn(f64) -> f64) -> Trace {
        let values = time.iter().map(|time| strain(*time)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column("gauge2_ustrain", values);
        trace
    }

    fn back(trace: &Trace) -> Trace {
        let mut bytes = Vec::new();
        write_recording(trace, &settings_of(trace), &mut bytes).unwrap();
        let reader = Reader::new(&bytes[..]).unwrap();
        let found = to_traces(Path::new("t.palpate"), reader, &Options::default()).unwrap();
        assert!(found.closed);
        let [trace] = &found.traces[..] else { panic!("{} traces", found.traces.len()) };
        trace.clone()
    }

    #[test]
    fn strain_and_time_come_back_and_the_recording_begins_at_zero() {
        let time: Vec<f64> = (0..300).map(|i| 3.0 + f64::from(i) * 0.005).collect();
        let given = trace(time, |time| ((time * 7.0).sin() * 5_000.0).round() / 256.0);
        let found = back(&given);
        assert_eq!(found.column("gauge2_ustrain"), given.column("gauge2_ustrain"));
        assert!(found.column("gauge1_ustrain").unwrap().iter().all(|strain| *strain == 0.0));
        for (found, given) in found.time.iter().zip(&given.time) {
            assert!((found - (given - 3.0)).abs() < 1e-9);
        }
        // And again, now with the settings of its head.
        let again = back(&found);
        assert_eq!((again.time, again.columns), (found.time, found.columns));
    }

    #[test]
    fn a_gap_becomes_lost_rows_and_a_gap_again() {
        let time = (0..300).filter(|i| !(100..150).contains(i)).map(|i| f64::from(i) * 0.005);
        let found = back(&trace(time.collect(), |time| time));
        assert_eq!(found.head.other["recording"]["rows_lost"].as_integer(), Some(50));
        assert_eq!(crate::gaps(&found.time).len(), 1);
    }

    #[test]
    fn settings_that_release_0_1_wrote_into_a_trace_are_read() {
        let fast = Settings { interval_ns: 256_000, ..Settings::DEFAULT }.with_gain([64; GAUGES]);
        let head = |settings| {
            let device = toml::Table::from_iter([(recorded::SETTINGS.into(), settings)]);
            let mut trace = Trace::default();
            trace.head.other.insert("device".into(), device.into());
            settings_of(&trace)
        };
        let by_ratio = SettingsByRatio::of(&fast, SettingsByRatio::CLOCK_HZ);
        assert_eq!(head(toml::Value::try_from(by_ratio).unwrap()), fast);
        assert_eq!(head(toml::Value::try_from(fast).unwrap()), fast);
    }

    #[test]
    fn a_trace_that_no_device_could_have_recorded_is_refused_by_name() {
        let refused = |trace: &Trace| {
            write_recording(trace, &Settings::DEFAULT, io::sink()).unwrap_err().to_string()
        };
        let even = |interval: f64| (0..20).map(|i| f64::from(i) * interval).collect::<Vec<_>>();
        let mut force = Trace { time: even(0.01), ..Trace::default() };
        force.set_column("force_N", vec![0.0; 20]);
        assert!(refused(&force).contains("no gauge"));
        let uneven = (0..20).map(|i| f64::from(i) + 0.2 * f64::from(i % 2)).collect();
        assert!(refused(&trace(uneven, |time| time)).contains("unevenly sampled at"));
        assert!(refused(&trace(even(1e-7), |time| time)).contains("a sample each"));
        let mut settings = Settings::DEFAULT;
        settings.relaxation.c1 = 2.0;
        let slow = trace(even(0.01), |time| time);
        let error = write_recording(&slow, &settings, io::sink()).unwrap_err().to_string();
        assert!(error.contains("a device cannot run so: relaxation function"), "{error}");
    }
}
