//! A recording of a device as traces.
//!
//! One trace for each stretch of a stream: it ends where the device began anew, the link was lost, another stream was
//! started, or the settings changed, for a trace has one head. Rows that were lost within it are a gap in its time; nothing
//! is put in their place. The time is that of the device since the first row of the stretch, unless that of the host is
//! asked for. A region that the device recognised late is put back to where it was entered.
//!
//! SA is the calibrated strain less FA, so a block can be read only with the settings that made it, which the device says
//! before. Rows whose settings were lost on the line are left out and counted.
//!
//! Where several devices share the recording, each has stretches of its own, and the time of all is the host's since the recording
//! was opened: the clock of each device is fitted under the arrival of its frames, and where they share a line, by when it rose.

mod columns;
mod pulses;
mod stream;

use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;

use toml::Value;

use self::pulses::{HostTime, Timing};
use self::stream::Stream;
use super::{Error, Trace};
use crate::recording::{self, Entry, Note, Reader};

/// Key of the settings in the head's table `device`.
pub(super) const SETTINGS: &str = "settings";

/// How to make traces of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Give time in seconds of the host's clock instead of the device's. Only the rate differs: every trace begins at 0.
    pub host_time: bool,
    /// Leave damaged frames out and count them, instead of refusing the recording.
    pub skip_damaged: bool,
}

/// What a recording holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recorded {
    /// One for each stretch of at least two rows; never empty.
    pub traces: Vec<Trace>,
    /// Rows that were lost within them.
    pub rows_lost: u64,
    /// Rows that were left out because their settings are not in the recording.
    pub rows_unknown: u64,
    /// Damaged frames that were left out.
    pub damaged: u64,
    /// Whether the recording was ended in order; if not, something may be missing at its end.
    pub closed: bool,
}

/// Reads the stretches of a recording; they are named after the file.
///
/// # Errors
/// [`Error::Recording`]; [`Error::NoStream`] if there is not one; [`Error::NoClock`] if the time of the host is asked for
/// and cannot be told.
pub fn read_recording(path: &Path, options: &Options) -> Result<Recorded, Error> {
    let failed = |source| Error::Recording { path: path.into(), source };
    let reader = Reader::open(path).map_err(failed)?;
    to_traces(path, reader, options)
}

/// As [`read_recording`], from anything that is read; `path` is what errors and names are made of.
///
/// # Errors
/// As [`read_recording`].
pub fn to_traces(
    path: &Path,
    mut reader: Reader<impl BufRead>,
    options: &Options,
) -> Result<Recorded, Error> {
    let mut devices = Devices::default();
    let mut recorded = Recorded::default();
    loop {
        match reader.next_entry() {
            Ok(Some(entry)) => devices.take(&entry),
            Ok(None) => break,
            Err(recording::Error::Damaged { .. }) if options.skip_damaged => {
                recorded.damaged += 1;
                devices.lose_track();
            }
            Err(source) => return Err(Error::Recording { path: path.into(), source }),
        }
    }
    recorded.closed = reader.closed();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let shared = devices.shared;
    devices.streams.values_mut().for_each(Stream::end);
    let (reference, told) = devices.most_pulses();
    for (number, stream) in devices.streams {
        recorded.rows_unknown += stream.rows_unknown;
        let device = shared.then(|| u32::from(number) + 1);
        let name =
            device.map_or_else(|| stem.to_string(), |device| format!("{stem}-device{device}"));
        let several = stream.ended.len() > 1;
        for (index, (stretch, clock)) in stream.ended.into_iter().enumerate() {
            let name = if several { format!("{name}-{}", index + 1) } else { name.clone() };
            recorded.rows_lost += stretch.rows_lost;
            let first_us = stretch.first_us();
            let fit = clock.as_ref().ok().map(|timing| &timing.fit);
            let mut trace = stretch.into_trace(name, fit, device);
            if options.host_time || shared {
                let no_clock = |reason| Error::NoClock { path: path.into(), reason };
                let timing = clock.map_err(no_clock)?;
                if shared {
                    let others = if number == reference { &[][..] } else { &told };
                    in_shared_time(&mut trace, first_us, &timing.beside(others));
                } else {
                    trace.time.iter_mut().for_each(|time| *time /= timing.fit.rate);
                }
            }
            recorded.traces.push(trace);
        }
    }
    if recorded.traces.is_empty() {
        return Err(Error::NoStream { path: path.into() });
    }
    if shared {
        begin_when_opened(&mut recorded.traces);
    }
    Ok(recorded)
}

/// Gives a trace of one of several devices, with the device time of its first row, µs, the host's time since the recording was opened.
fn in_shared_time(trace: &mut Trace, first_us: u64, host: &HostTime) {
    for time in &mut trace.time {
        *time = host.of(first_us + (*time * 1e6).round() as u64) * 1e-6;
    }
    let pulses = i64::try_from(host.pulses()).unwrap_or(i64::MAX);
    if let Some(Value::Table(recording)) =
        trace.head.other.get_mut("recording").filter(|_| pulses > 0)
    {
        recording.insert("pulses".into(), pulses.into());
    }
}

/// Nothing was recorded before the recording was opened. Where the lines under the times of arrival, of a short recording say, have
/// it a little earlier, all traces are moved alike.
fn begin_when_opened(traces: &mut [Trace]) {
    let first =
        traces.iter().filter_map(|trace| trace.time.first()).fold(0.0, |a: f64, b| a.min(*b));
    for trace in traces {
        trace.time.iter_mut().for_each(|time| *time -= first);
    }
}

/// The devices of a recording: one, or several that share it.
#[derive(Default)]
struct Devices {
    shared: bool,
    opened_ns: u64,
    /// Whose frames follow; nobody's that is known behind damage, where a note of that may be missing.
    now: Option<u8>,
    streams: BTreeMap<u8, Stream>,
}

impl Devices {
    fn take(&mut self, entry: &Entry<'_>) {
        match entry {
            Entry::Note { note: Note::Opened(opened), .. } => self.opened_ns = opened.unix_ns,
            Entry::Note { note: Note::Device(device), .. } => {
                (self.shared, self.now) = (true, Some(*device));
            }
            _ if self.shared => {
                if let Some(device) = self.now {
                    self.stream(device).take(entry);
                }
            }
            _ => self.stream(0).take(entry),
        }
    }

    /// The device that heard the shared line most often, the first of those that did as often, and the clocks of its stretches.
    fn most_pulses(&self) -> (u8, Vec<Timing>) {
        let timings = |stream: &Stream| -> Vec<Timing> {
            stream.ended.iter().filter_map(|(_, timing)| timing.clone().ok()).collect()
        };
        let heard = |stream: &Stream| -> usize {
            timings(stream).iter().map(|timing| timing.pulses_us.len()).sum()
        };
        let most = self.streams.iter().rev().max_by_key(|(_, stream)| heard(stream));
        most.map_or((0, Vec::new()), |(number, stream)| (*number, timings(stream)))
    }

    fn lose_track(&mut self) {
        self.now = None;
    }

    fn stream(&mut self, device: u8) -> &mut Stream {
        let opened_ns = self.opened_ns;
        self.streams.entry(device).or_insert_with(|| Stream::begin(opened_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Gap, Opened, Writer};
    use proptest::prelude::*;
    use shared::flags::Flags;
    use shared::phase::{Region, RelaxationType};
    use shared::pipeline::{GAUGES, Output};
    use shared::wire::{
        Columns, FRAME_MAX, Head as FrameHead, Hello, Rows, Settings, Source, Status, ToHost,
        encode,
    };

    const QUIET: Output = Output {
        strain: 512,
        fa: 256,
        elastic: 600,
        equilibrium: 300,
        region: Region::Loading,
        entered_samples_ago: None,
        relaxation: RelaxationType::TypeI,
        flags: Flags::STRAIN_SATURATED,
    };

    /// The frame of a block, as it is recorded.
    fn block(
        first: u64,
        time_us: u64,
        generation: u32,
        rows: u64,
        outputs: &[Output; GAUGES],
    ) -> Vec<u8> {
        let mut block = Rows::new();
        block.begin(Columns::Parts, first, time_us, time_us.saturating_sub(1_000));
        (block.generation, block.temperature) = (generation, Some(23 * 256));
        for row in 0..rows {
            assert!(block.push(time_us + 1_000 * row, &[1, -2, 3, -4], outputs));
        }
        let mut frame = [0; FRAME_MAX];
        let bytes = block.encode(0, &mut frame).unwrap();
        bytes[..bytes.len() - 1].to_vec()
    }

    fn said(time_us: u64, message: &ToHost<'_>) -> Vec<u8> {
        let mut frame = [0; FRAME_MAX];
        let bytes = encode(FrameHead { sequence: 0, time_us }, message, &mut frame).unwrap();
        bytes[..bytes.len() - 1].to_vec()
    }

    /// Settings with a calibration of 1/2 µε per count and a gauge that rests at −6 counts.
    fn set() -> Settings {
        let mut settings = Settings::DEFAULT;
        for sheet in &mut settings.calibration {
            (sheet.gain, sheet.offset) = (0.125, -18);
        }
        settings
    }

    fn settings(generation: u32) -> Vec<u8> {
        said(0, &ToHost::Settings { generation, settings: set() })
    }

    fn recorded(
        entries: &[Result<Vec<u8>, Note<'_>>],
        options: &Options,
    ) -> Result<Recorded, Error> {
        let mut bytes = Vec::new();
        let opened = Opened { unix_ns: 5_000_000_000, ..Opened::timeless("tty") };
        let mut writer = Writer::new(&mut bytes, &opened).unwrap();
        for (entry, arrived_us) in entries.iter().zip((1_u64..).map(|step| 500_000 * step)) {
            match entry {
                Ok(frame) => writer.frame(arrived_us, frame).unwrap(),
                Err(note) => writer.note(arrived_us, note).unwrap(),
            }
        }
        drop(writer);
        to_traces(Path::new("a/take.palpate"), Reader::new(&bytes[..]).unwrap(), options)
    }

    fn traces(entries: &[Result<Vec<u8>, Note<'_>>]) -> Vec<Trace> {
        recorded(entries, &Options::default()).unwrap().traces
    }

    #[test]
    fn gauges_that_the_device_does_not_have_are_no_columns() {
        let hello = ToHost::Hello(Hello {
            schema: shared::wire::SCHEMA,
            version: "1",
            git: "",
            board: "",
            serial: [0; 3],
            channels: 1,
            converter_clock_hz: 0,
            clock: shared::wire::ClockSource::Crystal,
            formats: shared::wire::Formats::OURS,
            reset: shared::wire::ResetCause::PowerOn,
            panic: "",
            counters: shared::wire::Counters::default(),
        });
        let rows = block(10, 2_000_000, 7, 3, &[QUIET; GAUGES]);
        let found = traces(&[Ok(said(0, &hello)), Ok(settings(7)), Ok(rows)]);
        let [trace] = &found[..] else { panic!("{} traces", found.len()) };
        assert!(trace.column("gauge1_ustrain").is_some());
        assert_eq!(trace.columns.iter().filter(|it| it.name.starts_with("gauge2")).count(), 0);
    }

    #[test]
    fn a_stretch_is_a_trace_with_its_columns_and_its_head() {
        let found = traces(&[Ok(settings(7)), Ok(block(10, 2_000_000, 7, 3, &[QUIET; GAUGES]))]);
        let [trace] = &found[..] else { panic!("{} traces", found.len()) };
        assert_eq!(trace.label(), "take");
        assert_eq!(trace.time, [0.0, 0.001, 0.002]);
        let column = |name: &str| trace.column(name).unwrap()[0];
        let names =
            ["ustrain", "fa_ustrain", "sa_ustrain", "counts", "region", "relaxation", "flags"];
        let values = names.map(|name| column(&format!("gauge2_{name}")));
        assert_eq!(values, [2.0, 1.0, 1.0, -2.0, 2.0, 1.0, 2.0]);
        assert_eq!(column("temperature_C"), 23.0);
        assert_eq!(trace.columns.len(), 4 * names.len() + 1);
        assert_eq!(trace.head.setup.other["rate_Hz"].as_float(), Some(1000.0));
        assert_eq!(trace.head.setup.start_s, Some(6.0));
        let settings = trace.head.other["device"][SETTINGS].clone().try_into::<Settings>();
        assert_eq!(settings, Ok(set()));
    }

    #[test]
    fn lost_rows_leave_a_gap_and_are_counted() {
        let quiet = &[QUIET; GAUGES];
        let entries =
            [Ok(settings(1)), Ok(block(0, 0, 1, 8, quiet)), Ok(block(40, 40_000, 1, 8, quiet))];
        let found = recorded(&entries, &Options::default()).unwrap();
        assert_eq!((found.traces.len(), found.rows_lost), (1, 32));
        assert_eq!(crate::gaps(&found.traces[0].time).len(), 1);
        assert_eq!(found.traces[0].head.other["recording"]["rows_lost"].as_integer(), Some(32));
        assert!(!found.closed);
    }

    #[test]
    fn a_reset_a_lost_link_another_stream_and_other_settings_begin_another_trace() {
        let quiet = &[QUIET; GAUGES];
        for (between, after) in [
            (Some(Err(Note::Gap(Gap::Reset))), block(8, 8_000, 1, 8, quiet)),
            (Some(Err(Note::Gap(Gap::LinkLost))), block(8, 8_000, 1, 8, quiet)),
            (Some(Ok(settings(2))), block(8, 8_000, 2, 8, quiet)),
            (None, block(0, 8_000, 1, 8, quiet)),
            (None, block(8, 0, 1, 8, quiet)),
        ] {
            let mut entries = vec![Ok(settings(1)), Ok(block(0, 0, 1, 8, quiet))];
            entries.extend(between);
            entries.push(Ok(after));
            let found = traces(&entries);
            assert_eq!(found.iter().map(Trace::label).collect::<Vec<_>>(), ["take-1", "take-2"]);
            assert!(found.iter().all(|trace| trace.len() == 8 && trace.time[0] == 0.0));
        }
    }

    #[test]
    fn a_region_found_late_is_put_back_to_where_it_was_entered() {
        let late = Output { region: Region::Relaxation, entered_samples_ago: Some(3), ..QUIET };
        let quiet = &[QUIET; GAUGES];
        let found = traces(&[
            Ok(settings(1)),
            Ok(block(0, 0, 1, 6, quiet)),
            Ok(block(6, 6_000, 1, 1, &[late; GAUGES])),
        ]);
        assert_eq!(found[0].column("gauge1_region").unwrap(), [2.0, 2.0, 2.0, 4.0, 4.0, 4.0, 4.0]);
    }

    #[test]
    fn the_time_of_the_host_is_given_where_the_clock_is_known_and_refused_where_not() {
        let quiet = &[QUIET; GAUGES];
        let options = Options { host_time: true, ..Options::default() };
        // Messages arrive half a second apart; on the device that is a whole one.
        let entries = [
            Ok(settings(1)),
            Ok(said(1_000_000, &ToHost::Log(shared::wire::Log { bytes: &[] }))),
            Ok(block(0, 2_000_000, 1, 3, quiet)),
        ];
        let found = recorded(&entries, &options).unwrap();
        assert_eq!(found.traces[0].time, [0.0, 0.0005, 0.001]);
        let unclear = [entries[0].clone(), entries[2].clone()];
        let error = recorded(&unclear, &options).unwrap_err().to_string();
        assert!(error.contains("clock of the device cannot be estimated"), "{error}");
    }

    #[test]
    fn a_status_whose_arrival_was_not_noted_says_whose_rows_follow_all_the_same() {
        let mut bytes = Vec::new();
        let mut writer = Writer::new(&mut bytes, &Opened::timeless("tty")).unwrap();
        let status = Status { streaming: Some(Source::Converter), ..Status::default() };
        writer.frame(0, &settings(1)).unwrap();
        // Too soon after another frame for a note of its own.
        writer.frame(1, &said(0, &ToHost::Status(status))).unwrap();
        for block_number in 1..20 {
            let (first, time_us) = (10 * block_number, 25_000 * block_number);
            writer.frame(time_us, &block(first, time_us, 1, 3, &[QUIET; GAUGES])).unwrap();
        }
        drop(writer);
        let options = Options { host_time: true, ..Options::default() };
        let reader = Reader::new(&bytes[..]).unwrap();
        let found = to_traces(Path::new("take.palpate"), reader, &options).unwrap();
        assert_eq!(found.traces[0].len(), 57);
    }

    /// A block of a device whose clock reads `at_us(t)` when the host's reads t µs, with its first row then.
    fn of_device(device: u8, at_us: impl Fn(u64) -> u64, bytes: &mut Writer<&mut Vec<u8>>) {
        for second in 1..30_u64 {
            let host_us = second * 1_000_000;
            bytes.of_device(host_us, device).unwrap();
            if second == 1 {
                bytes.frame(host_us, &settings(1)).unwrap();
            }
            let rows = block(10 * second, at_us(host_us), 1, 3, &[QUIET; GAUGES]);
            // When the last row was there, and as it came from the line.
            let arrives_us = host_us + 2_000 + 500;
            bytes
                .frame(
                    arrives_us,
                    &said(at_us(host_us) + 2_000, &ToHost::Log(shared::wire::Log { bytes: &[] })),
                )
                .unwrap();
            bytes.frame(arrives_us, &rows).unwrap();
        }
    }

    #[test]
    fn what_several_devices_saw_at_one_instant_has_one_time() {
        let mut bytes = Vec::new();
        let opened = Opened { unix_ns: 5_000_000_000, ..Opened::timeless("two") };
        let mut writer = Writer::for_several(&mut bytes, &opened).unwrap();
        of_device(0, |host_us| 70_000_000 + host_us, &mut writer);
        // A clock that runs fast by a hundredth, and began later.
        of_device(1, |host_us| host_us + host_us / 100 - 900_000, &mut writer);
        drop(writer);
        let reader = Reader::new(&bytes[..]).unwrap();
        let found = to_traces(Path::new("a/hand.palpate"), reader, &Options::default()).unwrap();
        let [first, second] = &found.traces[..] else { panic!("{} traces", found.traces.len()) };
        assert_eq!([first.label(), second.label()], ["hand-device1", "hand-device2"]);
        assert_eq!(second.head.other["recording"]["device"].as_integer(), Some(2));
        for (a, b) in first.time.iter().zip(&second.time).step_by(3) {
            // Both late by as much as frames take.
            assert!((a - b).abs() < 1e-4 && (a % 1.0 - 5e-4).abs() < 1e-4, "{a} {b}");
        }
        let rows = first.time.iter().chain(&second.time);
        assert!(rows.clone().count() == 2 * 87 && rows.copied().all(|time| time > 0.9));
    }

    #[test]
    fn what_devices_that_share_a_line_saw_at_one_instant_has_one_time_to_a_microsecond() {
        let mut bytes = Vec::new();
        let mut writer = Writer::for_several(&mut bytes, &Opened::timeless("two")).unwrap();
        let at_us = |device: u8, host_us: u64| match device {
            0 => 70_000_000 + host_us,
            // 40 ppm fast.
            _ => host_us + host_us * 40 / 1_000_000,
        };
        for second in 1..30_u64 {
            for device in [0, 1] {
                // The line of the second is slower by 3 ms.
                let (host_us, late_us) = (1_000_000 * second, 3_000 * u64::from(device));
                let now_us = at_us(device, host_us);
                let pulse = ToHost::Pulse { time_us: now_us - 500 };
                writer.of_device(host_us + late_us, device).unwrap();
                if second == 1 {
                    writer.frame(host_us + late_us, &settings(1)).unwrap();
                }
                writer.frame(host_us + late_us, &said(now_us, &pulse)).unwrap();
                let rows = block(10 * second, now_us + 10, 1, 3, &[QUIET; GAUGES]);
                writer.frame(host_us + late_us + 5_000, &rows).unwrap();
            }
        }
        drop(writer);
        let reader = Reader::new(&bytes[..]).unwrap();
        let found = to_traces(Path::new("hand.palpate"), reader, &Options::default()).unwrap();
        let [first, second] = &found.traces[..] else { panic!("{} traces", found.traces.len()) };
        for (a, b) in first.time.iter().zip(&second.time) {
            assert!((a - b).abs() < 2e-6, "{a} {b}");
        }
        let pulses = |trace: &Trace| trace.head.other["recording"].get("pulses").cloned();
        assert_eq!((pulses(first), pulses(second)), (None, Some(Value::Integer(29))));
    }

    #[test]
    fn no_row_of_several_devices_is_earlier_than_the_opening() {
        let trace = |time: &[f64]| Trace { time: time.to_vec(), ..Trace::default() };
        let begun = |first: &[f64], second: &[f64]| {
            let mut traces = [trace(first), trace(second)];
            begin_when_opened(&mut traces);
            traces.map(|trace| trace.time)
        };
        assert_eq!(begun(&[-0.25, 0.5], &[0.25, 1.0]), [[0.0, 0.75], [0.5, 1.25]]);
        assert_eq!(begun(&[0.25, 0.5], &[0.5, 1.0]), [[0.25, 0.5], [0.5, 1.0]]);
    }

    #[test]
    fn behind_damage_no_frame_is_taken_for_that_of_another_device() {
        let mut bytes = Vec::new();
        let mut writer = Writer::for_several(&mut bytes, &Opened::timeless("two")).unwrap();
        of_device(0, |host_us| host_us, &mut writer);
        let whole = {
            writer.flush().unwrap();
            writer.bytes() as usize
        };
        of_device(1, |host_us| host_us, &mut writer);
        drop(writer);
        // The note that the second device follows.
        bytes[whole + 6] ^= 0x40;
        let options = Options { skip_damaged: true, ..Options::default() };
        let reader = Reader::new(&bytes[..]).unwrap();
        let found = to_traces(Path::new("hand.palpate"), reader, &options).unwrap();
        assert_eq!((found.traces.len(), found.damaged), (1, 1));
        assert_eq!(found.traces[0].len(), 87);
    }

    #[test]
    fn a_recording_without_rows_is_refused() {
        for entries in [&[][..], &[Ok(settings(1)), Ok(block(0, 0, 1, 1, &[QUIET; GAUGES]))]] {
            assert!(matches!(recorded(entries, &Options::default()), Err(Error::NoStream { .. })));
        }
    }

    #[test]
    fn rows_whose_settings_were_lost_are_left_out_and_counted() {
        let quiet = &[QUIET; GAUGES];
        let entries =
            [Ok(block(0, 0, 1, 8, quiet)), Ok(settings(2)), Ok(block(8, 8_000, 2, 8, quiet))];
        let found = recorded(&entries, &Options::default()).unwrap();
        assert_eq!((found.rows_unknown, found.traces.len(), found.traces[0].len()), (8, 1, 8));
    }

    proptest! {
        #[test]
        fn whatever_a_device_says_makes_traces_that_can_be_written(
            blocks in prop::collection::vec((0..30_u64, 0..30_000_u64, 1..3_u32, 1..5_u64, any::<Option<u32>>()), 1..20),
        ) {
            let frames = blocks.into_iter().map(|(first, time_us, generation, rows, entered)| {
                let output = Output { entered_samples_ago: entered.map(|ago| ago / 2), ..QUIET };
                Ok(block(first, time_us, generation, rows, &[output; GAUGES]))
            });
            let entries: Vec<_> = [Ok(settings(1)), Ok(settings(2))].into_iter().chain(frames).collect();
            if let Ok(found) = recorded(&entries, &Options::default()) {
                for trace in &found.traces {
                    crate::write_to(Vec::new(), trace).unwrap();
                }
            }
        }
    }
}
