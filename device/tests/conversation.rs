//! What a host may rely on, command by command.

use palpate_device::{
    Board, Device, INJECTED_ROWS, Identity, Lost, Restart, Sample, Setting, begin_with,
};
use proptest::prelude::*;
use shared::adaptation;
use shared::calibration::Sheet;
use shared::events;
use shared::pipeline::{GAUGES, Pipeline};
use shared::wire::{
    self, Accumulated, Accumulator, Capabilities, ClockSource, Columns, ConverterFault, Done,
    EARLIER, FRAME_MAX, Felt, Head, HelloToDevice, INJECT_ROWS, Inject, Inputs, Kept, Oversampling,
    PerGauge, Refusal, ResetCause, Row, Rows, SCHEMA, Settings, Source, Start, Status, StoreFault,
    ToDevice, ToHost,
};

const IDENTITY: Identity<'static> = Identity {
    version: "1.2.3",
    git: "abcdef0",
    board: "none",
    serial: [1, 2, 3],
    converter_clock_hz: 8_000_000,
    converter: "ADS131M04",
    capabilities: Capabilities::ads131m04(8_000_000),
    clock: ClockSource::Simulated,
    reset: ResetCause::PowerOn,
    panic: "",
};

#[derive(Default)]
struct Bench {
    converter: Option<ConverterFault>,
    set: Option<Setting>,
    listening: bool,
    /// Lost after the last sample.
    untold: Lost,
    stored: Vec<u8>,
    store_fault: Option<StoreFault>,
}

impl Board for Bench {
    fn configure(&mut self, setting: Setting) -> Result<(), ConverterFault> {
        self.set = Some(setting);
        self.converter.map_or(Ok(()), Err)
    }
    fn listen(&mut self, to_converter: bool) -> Lost {
        self.listening = to_converter;
        std::mem::take(&mut self.untold)
    }
    fn store(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        self.stored = record.to_vec();
        self.store_fault.map_or(Ok(()), Err)
    }
    fn can_restart(&self, into: Restart) -> bool {
        into == Restart::Firmware
    }
}

/// Whether a message is one that a host of release 0.1 does not know.
fn is_of_today(message: &ToHost<'_>) -> bool {
    match message {
        ToHost::Hello(_) | ToHost::Log(_) => false,
        ToHost::Answer(answer) => matches!(answer.outcome, Ok(Done::Tested(_))),
        _ => message.clone().in_words_of_today() == *message,
    }
}

/// A host that speaks to a device on the same desk.
struct Host {
    device: Device<'static>,
    board: Bench,
    sequence: u32,
    now_us: u64,
    rows: Vec<Row>,
    generations: Vec<u32>,
    answers: Vec<(u32, Result<Done, Refusal>)>,
    settings: Option<(u32, Settings)>,
    status: Option<Status>,
    hello: Option<(u64, String)>,
    kept: Option<Kept>,
    /// Intervals that the converter can be set to, ns.
    intervals_ns: Vec<u32>,
    felt: Vec<Felt>,
    /// When the shared line rose, µs.
    pulses: Vec<u64>,
}

impl Host {
    fn new() -> Self {
        Self::beginning_with(None)
    }

    fn beginning_with(record: Option<&[u8]>) -> Self {
        Self::of(IDENTITY, record)
    }

    fn of(identity: Identity<'static>, record: Option<&[u8]>) -> Self {
        Self {
            device: Device::new(
                identity,
                &begin_with(record, &identity.capabilities).unwrap(),
                Box::leak(Box::default()),
            ),
            board: Bench::default(),
            sequence: 0,
            now_us: 0,
            rows: Vec::new(),
            generations: Vec::new(),
            answers: Vec::new(),
            settings: None,
            status: None,
            hello: None,
            kept: None,
            intervals_ns: Vec::new(),
            felt: Vec::new(),
            pulses: Vec::new(),
        }
    }

    fn is_older(&self) -> bool {
        self.hello.as_ref().is_some_and(|(schema, _)| *schema != SCHEMA)
    }

    fn introduced() -> Self {
        let mut host = Self::new();
        host.say(&ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "1" })).unwrap();
        host
    }

    fn send(&mut self, sequence: u32, command: &ToDevice<'_>) {
        let mut frame = [0; FRAME_MAX];
        let bytes = wire::encode(Head { sequence, time_us: 0 }, command, &mut frame).unwrap().len();
        self.device.receive(&mut frame[..bytes - 1], self.now_us, &mut self.board);
    }

    /// Sends a command and hears everything until nothing is left to hear.
    fn say(&mut self, command: &ToDevice<'_>) -> Result<Done, Refusal> {
        self.sequence += 1;
        self.send(self.sequence, command);
        self.device.drained();
        self.hear();
        let (to, outcome) = *self.answers.last().expect("an answer");
        assert_eq!(to, self.sequence);
        outcome
    }

    fn hear(&mut self) {
        let mut line = Accumulator::new();
        let mut frame = [0; FRAME_MAX];
        while let Some(bytes) = self.device.next_frame(self.now_us, &mut (), &mut frame) {
            for byte in bytes {
                if let Accumulated::Frame(frame) = line.push(*byte) {
                    let (head, message) = wire::decode::<ToHost<'_>>(frame).unwrap();
                    let (said, told_less) = (message.clone(), self.is_older());
                    assert!(told_less || said.in_words_of_today() == message, "{message:?}");
                    assert!(!told_less || !is_of_today(&message), "{message:?}");
                    if let ToHost::Answer(answer) = message {
                        self.answers.push((answer.to, answer.outcome));
                        continue;
                    }
                    match message.in_words_of_today() {
                        ToHost::Hello(hello) => {
                            self.hello = Some((hello.schema, hello.version.into()));
                        }
                        ToHost::Settings { generation, settings } => {
                            self.settings = Some((generation, settings));
                        }
                        ToHost::Status(status) => self.status = Some(status),
                        ToHost::Samples(block) => {
                            let rows = Rows::decode(head, &block).unwrap();
                            let (generation, settings) = self.settings.unwrap();
                            assert_eq!(generation, block.generation, "told before its first block");
                            let calibration = settings.config(1e-3).unwrap().calibration;
                            self.generations.extend((0..rows.len()).map(|_| generation));
                            self.rows.extend(rows.iter(&calibration));
                        }
                        ToHost::Kept(kept) => self.kept = Some(kept),
                        ToHost::Event(felt) => self.felt.push(felt),
                        ToHost::Pulse { time_us } => self.pulses.push(time_us),
                        ToHost::Converter { part, capabilities } => {
                            assert_eq!(part, IDENTITY.converter);
                            self.intervals_ns = capabilities.intervals_ns().collect();
                        }
                        other => unreachable!("{other:?}"),
                    }
                }
            }
        }
    }

    fn start(&mut self, source: Source) {
        self.say(&ToDevice::Start(Start { source, columns: Columns::All })).unwrap();
    }

    fn inject(&mut self, rows: &[[i32; GAUGES]]) -> Result<Done, Refusal> {
        let mut room = [0; 300];
        let counts = packed(rows, &mut room);
        self.say(&ToDevice::Inject(Inject { temperature: None, counts }))
    }

    /// Lets the device process what was injected, and hears what it says meanwhile.
    fn process(&mut self) {
        while self.device.has_injected() {
            while self.device.process_injected() {}
            self.hear();
        }
    }

    fn sample(&mut self, counts: [i32; GAUGES], lost: Lost) {
        self.now_us += 1_024;
        self.device.sample(&Sample { time_us: self.now_us, counts, lost });
    }

    fn status(&mut self) -> Status {
        self.say(&ToDevice::Status).unwrap();
        self.status.unwrap()
    }
}

fn packed<'b>(rows: &[[i32; GAUGES]], room: &'b mut [u8]) -> &'b [u8] {
    wire::pack(rows, GAUGES as u8, room).unwrap()
}

const LINK: Source = Source::Link { interval_ns: 5_000_000 };

fn press(row: usize) -> [i32; GAUGES] {
    let t = row as f64 / 200.0;
    let up = (t.clamp(0.3, 0.6) - 0.3) / 0.3 - 0.6 * (t.clamp(1.5, 1.8) - 1.5) / 0.3;
    std::array::from_fn(|gauge| {
        (1e6 * up) as i32 + 1_000 * gauge as i32 + (row * 7_919 % 101) as i32
    })
}

#[test]
fn a_host_of_our_schema_is_told_who_we_are_and_how_we_are_set() {
    let host = Host::introduced();
    assert_eq!(host.hello, Some((SCHEMA, "1.2.3".into())));
    assert_eq!(host.settings, Some((0, Settings::DEFAULT)));
}

/// A touch, a knock and a release as counts of all gauges: 2.4 s at 1 kHz.
fn touch_and_release() -> Vec<[i32; GAUGES]> {
    let up = |t: f64| ((t - 0.5) / 0.02).clamp(0.0, 1.0) - ((t - 1.5) / 0.02).clamp(0.0, 1.0);
    (0..2_400).map(|row| [(2e6 * up(f64::from(row) * 1e-3)) as i32; GAUGES]).collect()
}

/// Rows, one millisecond apart, through a device whose host speaks a schema.
fn felt_by_a_host_of(schema: u64) -> (Host, u64) {
    let mut host = Host::new();
    host.say(&ToDevice::Hello(HelloToDevice { schema, version: "1" })).unwrap();
    host.start(Source::Link { interval_ns: 1_000_000 });
    for rows in touch_and_release().chunks(INJECT_ROWS) {
        host.inject(rows).unwrap();
        host.process();
    }
    let rows = host.rows.len() as u64;
    (host, rows)
}

#[test]
fn a_touch_and_a_release_are_told_at_the_row_at_which_the_same_code_finds_them() {
    let (host, rows) = felt_by_a_host_of(SCHEMA);
    assert_eq!(rows, 2_400);
    let settings = events::Settings::DEFAULT.at_interval(1e-3);
    let config = events::Config::new(&settings, 1.0 / 256.0, 1e-3).unwrap();
    let outputs = |row: &Row| {
        let (elastic, equilibrium) = row.rest.unwrap();
        let channel = |gauge: usize| adaptation::Output {
            signal: row.fa[gauge] + row.sa[gauge],
            fa: row.fa[gauge],
            equilibrium: equilibrium[gauge],
            elastic: elastic[gauge],
        };
        std::array::from_fn(channel)
    };
    let first = outputs(&host.rows[0]).map(|out| out.equilibrium);
    let mut state = events::State::<GAUGES>::at_rest(first);
    let step = |row: &Row| state.step(&config, &outputs(row)).map(|event| (row.number, event));
    let expected: Vec<_> = host.rows.iter().filter_map(step).collect();
    let told: Vec<_> = host.felt.iter().map(|felt| (felt.row, felt.event)).collect();
    assert_eq!(told, expected);
    let kinds: Vec<_> = told.iter().map(|(_, event)| event.kind).collect();
    assert_eq!(kinds, [events::Kind::Touch, events::Kind::Release]);
    assert!((500..520).contains(&told[0].0) && (1_500..1_550).contains(&told[1].0), "{told:?}");
    for (number, felt) in (0..).zip(&host.felt) {
        assert_eq!((felt.number, felt.time_us), (number, felt.row * 1_000));
    }
}

#[test]
fn a_host_of_release_0_1_is_told_no_event_and_misses_no_row() {
    let (host, rows) = felt_by_a_host_of(EARLIER[0]);
    assert_eq!((host.felt.len(), rows), (0, 2_400));
}

#[test]
fn a_pulse_of_the_shared_line_is_told_while_the_converter_is_streamed_to_a_host_that_knows_it() {
    let pulses_of = |schema, source| {
        let mut host = Host::new();
        host.say(&ToDevice::Hello(HelloToDevice { schema, version: "1" })).unwrap();
        host.device.note_pulse(1_000_000);
        host.start(source);
        for time_us in [2_000_003, 3_000_005] {
            host.device.note_pulse(time_us);
            host.hear();
        }
        host.say(&ToDevice::Stop).unwrap();
        host.device.note_pulse(4_000_000);
        host.hear();
        host.pulses
    };
    assert_eq!(pulses_of(SCHEMA, Source::Converter), [2_000_003, 3_000_005]);
    // Injected rows have a time of their own.
    assert_eq!(pulses_of(SCHEMA, Source::Link { interval_ns: 1_000_000 }), []);
    assert_eq!(pulses_of(EARLIER[0], Source::Converter), []);
}

#[test]
fn a_tare_under_load_is_no_touch() {
    let mut host = Host::introduced();
    host.start(Source::Link { interval_ns: 1_000_000 });
    for rows in vec![[1_000_000; GAUGES]; 640].chunks(INJECT_ROWS) {
        host.inject(rows).unwrap();
        host.process();
    }
    host.say(&ToDevice::Tare).unwrap();
    for rows in vec![[1_000_000; GAUGES]; 640].chunks(INJECT_ROWS) {
        host.inject(rows).unwrap();
        host.process();
    }
    assert_eq!(host.felt, []);
}

#[test]
fn a_host_of_another_schema_is_told_so_and_nothing_is_done_for_it() {
    let mut host = Host::new();
    let hello = ToDevice::Hello(HelloToDevice { schema: SCHEMA ^ 1, version: "0" });
    assert_eq!(host.say(&hello), Err(Refusal::Schema(SCHEMA)));
    assert_eq!(host.hello, Some((SCHEMA, "1.2.3".into())));
    assert_eq!(host.say(&ToDevice::LoadDefaults), Err(Refusal::Schema(SCHEMA)));
}

#[test]
fn a_host_of_any_release_may_stop_restart_and_ask_for_the_status() {
    let mut host = Host::new();
    let hello = ToDevice::Hello(HelloToDevice { schema: SCHEMA ^ 1, version: "77.0.0" });
    host.say(&hello).unwrap_err();
    host.status();
    assert_eq!(host.say(&ToDevice::Stop), Err(Refusal::NotStreaming));
    host.sequence += 1;
    host.send(host.sequence, &ToDevice::Reboot);
    host.hear();
    assert_eq!(host.device.restart_due(), Some(Restart::Firmware));
    assert_eq!(
        host.say(&ToDevice::Bootloader),
        Err(Refusal::NotHere),
        "asked, not refused unheard"
    );
}

#[test]
fn a_host_of_an_earlier_release_is_spoken_to_in_its_own_schema() {
    for schema in EARLIER {
        let mut host = Host::new();
        let hello = ToDevice::Hello(HelloToDevice { schema, version: "0.1.0" });
        host.say(&hello).unwrap();
        assert_eq!(host.hello, Some((schema, "1.2.3".into())));
        host.start(LINK);
        host.say(&ToDevice::Stop).unwrap();
        // Words that its release does not have.
        host.board.store_fault = Some(StoreFault::Supply);
        let refused = host.say(&ToDevice::Save);
        assert_eq!(refused, Err(Refusal::Store(StoreFault::NotWritten)));
    }
}

#[test]
fn a_host_must_introduce_itself_first() {
    assert_eq!(Host::new().say(&ToDevice::Stop), Err(Refusal::NoHello));
}

#[test]
fn injected_rows_come_back_as_the_pipeline_makes_them_bit_for_bit() {
    let mut host = Host::introduced();
    host.start(LINK);
    let config = Settings::DEFAULT.config(0.005).unwrap();
    let mut pipeline = Pipeline::new(&config);
    let rows: Vec<_> = (0..600).map(press).collect();
    for chunk in rows.chunks(INJECT_ROWS) {
        assert!(matches!(host.inject(chunk), Ok(Done::Injected { lost: 0, .. })));
        host.process();
    }
    host.say(&ToDevice::Stop).unwrap();
    assert_eq!(host.rows.len(), rows.len());
    for (number, (row, counts)) in host.rows.iter().zip(rows).enumerate() {
        assert_eq!(
            (row.number, row.time_us, row.counts),
            (number as u64, 5_000 * number as u64, counts)
        );
        pipeline.process(&counts, 25 * 256);
        let outputs = pipeline.outputs();
        assert_eq!(row.fa, outputs.map(|out| out.fa));
        assert_eq!(row.sa, outputs.map(|out| out.sa()));
        assert_eq!(
            row.rest,
            Some((outputs.map(|out| out.elastic), outputs.map(|out| out.equilibrium)))
        );
        assert_eq!(row.states.map(|state| state.region), outputs.map(|out| out.region));
        assert_eq!(row.entered, outputs.map(|out| out.entered_samples_ago));
    }
}

#[test]
fn in_a_flood_what_was_sent_is_what_came_back_and_what_was_counted() {
    let mut host = Host::introduced();
    host.start(LINK);
    let mut sent = 0;
    for i in 0..50 {
        let rows = vec![press(i); INJECT_ROWS];
        host.inject(&rows).unwrap();
        sent += rows.len();
        if i % 7 == 0 {
            host.process();
        }
    }
    host.say(&ToDevice::Stop).unwrap();
    let counted = host.status().counters;
    assert!(counted.queue_full > 0, "a queue of {INJECTED_ROWS} rows must have been full");
    assert_eq!(sent, host.rows.len() + (counted.queue_full + counted.link_full) as usize);
    assert_eq!(host.status.unwrap().rows, sent as u64);
    let numbers: Vec<_> = host.rows.iter().map(|row| row.number).collect();
    assert!(numbers.is_sorted_by(|a, b| a < b), "numbers grow");
}

#[test]
fn injected_rows_wait_for_a_host_that_is_slow_to_listen() {
    let mut host = Host::introduced();
    host.start(LINK);
    let mut room = [0; 300];
    for _ in 0..2 {
        host.sequence += 1;
        // Such rows take much room.
        let rows: [_; INJECT_ROWS] =
            std::array::from_fn(|row| [row as i32 % 2 * 8_000_000; GAUGES]);
        let counts = packed(&rows, &mut room);
        host.send(host.sequence, &ToDevice::Inject(Inject { temperature: None, counts }));
        while host.device.process_injected() {}
    }
    assert!(host.device.has_injected(), "all blocks found room");
    host.process();
    host.say(&ToDevice::Stop).unwrap();
    assert_eq!(host.rows.len(), 2 * INJECT_ROWS);
    assert_eq!(host.status().counters.link_full, 0);
}

#[test]
fn a_host_that_does_not_listen_costs_rows_that_are_counted_and_nothing_else() {
    let mut host = Host::introduced();
    host.start(Source::Converter);
    for row in 0..1_000 {
        host.sample(press(row), Lost::NONE);
    }
    host.say(&ToDevice::Stop).unwrap();
    let lost = host.status().counters.link_full;
    assert!(lost > 800);
    assert_eq!(host.rows.len() + lost as usize, 1_000);
}

#[test]
fn what_the_interrupt_lost_is_a_gap_in_the_numbers_and_counted_by_cause() {
    let mut host = Host::introduced();
    host.start(Source::Converter);
    assert!(host.board.listening);
    host.sample([0; GAUGES], Lost::NONE);
    host.sample([1; GAUGES], Lost { missed: 2, damaged: 1, queue_full: 4, exchanged: false });
    host.say(&ToDevice::Stop).unwrap();
    assert_eq!(host.rows.iter().map(|row| row.number).collect::<Vec<_>>(), [0, 8]);
    let counted = host.status().counters;
    assert_eq!(
        (counted.conversions_missed, counted.conversions_damaged, counted.queue_full),
        (2, 1, 4)
    );
}

#[test]
fn what_was_lost_before_a_stop_is_counted_and_what_waited_for_the_filter_is_sent() {
    let mut host = Host::introduced();
    host.start(Source::Converter);
    host.sample(press(0), Lost::NONE);
    host.board.untold = Lost { missed: 7, ..Lost::NONE };
    host.sequence += 1;
    host.send(host.sequence, &ToDevice::Stop);
    host.hear();
    assert!(host.answers.iter().all(|(to, _)| *to != host.sequence), "not before it has ended");
    assert!(!host.board.listening);
    // It was read before the stop and waited for its turn.
    host.sample(press(1), Lost::NONE);
    host.device.drained();
    host.hear();
    assert_eq!(host.answers.last(), Some(&(host.sequence, Ok(Done::Carried))));
    assert_eq!(host.rows.len(), 2);
    let status = host.status();
    assert_eq!((status.counters.conversions_missed, status.streaming), (7, None));
}

#[test]
fn losses_that_no_sample_follows_are_counted_and_are_a_gap_in_the_numbers() {
    let mut host = Host::introduced();
    host.start(Source::Converter);
    host.sample(press(0), Lost::NONE);
    host.device.count_lost(Lost { damaged: 5_000, ..Lost::NONE });
    let status = host.status();
    assert_eq!((status.rows, status.counters.conversions_damaged), (5_001, 5_000));
}

#[test]
fn a_change_of_gain_while_streaming_makes_no_press_and_samples_on_their_way_keep_their_gain() {
    let mut host = Host::introduced();
    host.start(Source::Converter);
    for _ in 0..600 {
        host.sample([1_000_000; GAUGES], Lost::NONE);
        host.hear();
    }
    let before = *host.rows.last().unwrap();
    host.say(&ToDevice::SetGain(PerGauge([64; GAUGES]))).unwrap();
    assert_eq!(host.board.set.unwrap().gain, [64; GAUGES]);
    // One of the old gain was on its way.
    host.sample([1_000_000; GAUGES], Lost::NONE);
    host.sample([500_000; GAUGES], Lost { missed: 5, exchanged: true, ..Lost::NONE });
    for _ in 0..40 {
        host.sample([500_000; GAUGES], Lost::NONE);
    }
    host.say(&ToDevice::Stop).unwrap();
    assert_eq!(host.settings.unwrap().1.gain, [64; GAUGES]);
    for row in &host.rows[600..] {
        assert!((row.fa[0] - before.fa[0]).abs() < 256, "{row:?}");
        assert!((row.fa[0] + row.sa[0] - before.fa[0] - before.sa[0]).abs() <= 2, "{row:?}");
        assert_eq!(row.states[0].region, before.states[0].region);
    }
}

#[test]
fn rows_that_nothing_follows_are_sent_soon() {
    let mut host = Host::introduced();
    host.start(Source::Converter);
    host.sample(press(0), Lost::NONE);
    host.hear();
    assert!(host.rows.is_empty());
    for _ in 0..2 {
        host.device.tick(0, &mut host.board);
    }
    host.hear();
    assert_eq!(host.rows.len(), 1);
}

#[test]
fn injected_rows_are_sent_when_no_more_wait() {
    let mut host = Host::introduced();
    host.start(LINK);
    host.inject(&[press(0); 2]).unwrap();
    host.process();
    host.hear();
    assert_eq!(host.rows.len(), 2);
}

#[test]
fn a_command_that_comes_again_is_answered_again_and_not_carried_out_again() {
    let mut host = Host::introduced();
    host.start(LINK);
    host.inject(&[press(0); 3]).unwrap();
    let (again, said) = (host.sequence, host.answers.len());
    let mut room = [0; 100];
    let counts = packed(&[press(0); 3], &mut room);
    host.send(again, &ToDevice::Inject(Inject { temperature: None, counts }));
    host.hear();
    assert_eq!(host.answers.len(), said + 1);
    assert_eq!(host.answers[said], host.answers[said - 1]);
    host.say(&ToDevice::Stop).unwrap();
    assert_eq!(host.rows.len(), 3);
}

#[test]
fn commands_that_never_came_and_frames_that_were_damaged_are_counted() {
    let mut host = Host::introduced();
    host.sequence += 3;
    host.device.receive(&mut [1, 2, 3], 0, &mut host.board);
    let counters = host.status().counters;
    assert_eq!((counters.frames_missed, counters.frames_damaged), (3, 1));
}

#[test]
fn settings_change_between_two_rows_and_blocks_say_which_made_them() {
    let mut host = Host::introduced();
    host.start(LINK);
    host.inject(&[press(0); 5]).unwrap();
    host.process();
    let filter = adaptation::Relaxation { c1: 0.3, v1: 10.0, c2: 0.1, v2: 1.0 };
    host.say(&ToDevice::SetFilter(filter)).unwrap();
    assert_eq!(host.settings.unwrap().0, 1);
    host.inject(&[press(1); 5]).unwrap();
    host.say(&ToDevice::Stop).unwrap();
    assert_eq!(host.generations, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]);
}

#[test]
fn a_tare_reads_zero_leaves_the_counts_alone_and_can_be_taken_back() {
    let mut host = Host::introduced();
    assert_eq!(host.say(&ToDevice::Tare), Err(Refusal::NotStreaming));
    host.start(Source::Converter);
    assert_eq!(host.say(&ToDevice::Tare), Err(Refusal::NoSample));
    let counts = [100_000, -50_000, 7, 0];
    for command in [ToDevice::Status, ToDevice::Tare, ToDevice::Untare] {
        host.say(&command).unwrap();
        host.sample(counts, Lost::NONE);
    }
    host.say(&ToDevice::Stop).unwrap();
    let strain = |row: &Row| -> [i32; GAUGES] { std::array::from_fn(|i| row.fa[i] + row.sa[i]) };
    let [before, tared, after] = &host.rows[..] else { panic!("{:?}", host.rows) };
    assert_eq!(strain(tared), [0; GAUGES]);
    assert_eq!((strain(before), before.counts, tared.counts), (strain(after), counts, counts));
    assert_ne!(strain(before), [0; GAUGES]);
}

#[test]
fn settings_are_kept_on_request_and_only_then() {
    let mut host = Host::introduced();
    let sheet =
        Sheet { gain: 0.01, offset: 5, temperature_coefficient: 0.0, reference_celsius: 20.0 };
    host.say(&ToDevice::SetCalibration { gauge: 2, sheet }).unwrap();
    assert!(host.board.stored.is_empty());
    host.start(Source::Converter);
    assert_eq!(host.say(&ToDevice::Save), Err(Refusal::Streaming));
    host.say(&ToDevice::Stop).unwrap();
    host.say(&ToDevice::Save).unwrap();
    let (kept, _) = Settings::from_record(&host.board.stored);
    assert_eq!(kept.calibration[2], sheet);
    host.say(&ToDevice::LoadDefaults).unwrap();
    assert_eq!(host.settings.unwrap().1, Settings::DEFAULT);
}

#[test]
fn what_became_of_kept_settings_is_told_after_hello() {
    let (mut record, length) = Settings::DEFAULT.record();
    let mut wrong = Settings::DEFAULT;
    wrong.calibration[0].gain = 7.0;
    let (out_of_range, _) = wrong.record();
    let told = |record: Option<&[u8]>| {
        let mut host = Host::beginning_with(record);
        host.say(&ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "1" })).unwrap();
        assert_eq!(host.settings, Some((0, Settings::DEFAULT)));
        host.kept.unwrap()
    };
    assert_eq!(told(None), Kept::None);
    assert_eq!(told(Some(&record[..length])), Kept::All);
    assert_eq!(told(Some(&out_of_range[..length])), Kept::Discarded);
    record[0] = 0;
    assert_eq!(told(Some(&record[..length])), Kept::Discarded);
}

#[test]
fn what_is_out_of_range_is_refused_by_kind_and_changes_nothing() {
    let mut host = Host::introduced();
    let sheet = Sheet { gain: 0.0, ..Settings::DEFAULT.calibration[0] };
    let filter = adaptation::Relaxation { c1: 2.0, ..Settings::DEFAULT.relaxation };
    for (command, refusal) in [
        (ToDevice::SetCalibration { gauge: 0, sheet }, Refusal::Calibration),
        (ToDevice::SetCalibration { gauge: 4, sheet }, Refusal::Gauge(4)),
        (ToDevice::SetFilter(filter), Refusal::Filter),
        (ToDevice::SetGain(PerGauge([1, 2, 3, 4])), Refusal::Gain),
        (ToDevice::Stop, Refusal::NotStreaming),
        (
            ToDevice::Start(Start {
                source: Source::Link { interval_ns: 0 },
                columns: Columns::All,
            }),
            Refusal::Interval,
        ),
        (ToDevice::Bootloader, Refusal::NotHere),
    ] {
        assert_eq!(host.say(&command), Err(refusal), "{command:?}");
    }
    host.say(&ToDevice::Settings).unwrap();
    assert_eq!(host.settings, Some((0, Settings::DEFAULT)));
}

#[test]
fn a_rate_that_the_converter_does_not_have_is_refused_in_the_hosts_words() {
    let mut host = Host::introduced();
    assert_eq!(host.intervals_ns, [256_000, 512_000, 772_000, 1_024_000, 2_048_000, 4_096_000]);
    host.say(&ToDevice::SetInterval { ns: 512_000 }).unwrap();
    assert_eq!(host.board.set.unwrap().interval_ns, 512_000);
    assert_eq!(host.say(&ToDevice::SetInterval { ns: 513_000 }), Err(Refusal::Rate));
    assert_eq!(host.settings.unwrap().1.interval_ns, 512_000);
}

#[test]
fn a_host_of_release_0_1_sets_the_rate_by_its_ratio_and_reads_it_back() {
    let mut host = Host::new();
    host.say(&ToDevice::Hello(HelloToDevice { schema: EARLIER[0], version: "0.1.0" })).unwrap();
    assert_eq!((host.settings, host.intervals_ns.len()), (Some((0, Settings::DEFAULT)), 0));
    host.say(&ToDevice::SetRatio(Oversampling::X16384)).unwrap();
    assert_eq!(host.board.set.unwrap().interval_ns, 4_096_000);
    assert_eq!(host.settings.unwrap().1.interval_ns, 4_096_000);
}

#[test]
fn without_a_converter_streaming_is_refused_but_rows_can_be_injected_and_rates_set() {
    let mut host = Host::introduced();
    host.board.converter = Some(ConverterFault::Missing);
    let start = |source| ToDevice::Start(Start { source, columns: Columns::Parts });
    let missing = Err(Refusal::Converter(ConverterFault::Missing));
    assert_eq!(host.say(&start(Source::Converter)), missing);
    assert_eq!(host.say(&ToDevice::SelfTest), missing);
    assert_eq!(host.status().converter, Some(ConverterFault::Missing));
    host.say(&ToDevice::SetInterval { ns: 256_000 }).unwrap();
    host.say(&start(LINK)).unwrap();
}

#[test]
fn a_self_test_is_answered_when_it_has_its_samples() {
    let mut host = Host::introduced();
    host.sequence += 1;
    host.send(host.sequence, &ToDevice::SelfTest);
    for row in 0..256 {
        host.sample([row, 0, 0, 0], Lost::NONE);
    }
    host.hear();
    let said = host.answers.len();
    host.device.tick(host.now_us, &mut host.board);
    host.hear();
    let (to, Ok(Done::Tested(test))) = host.answers[said] else { panic!("{:?}", host.answers) };
    assert_eq!((to, test.converter, test.samples), (host.sequence, Ok(()), 256));
    assert!(!host.board.listening);
}

#[test]
fn a_host_of_release_0_1_sets_four_gains_and_reads_status_test_and_rows_in_its_own_words() {
    let mut host = Host::new();
    host.say(&ToDevice::Hello(HelloToDevice { schema: EARLIER[0], version: "0.1.0" })).unwrap();
    host.say(&ToDevice::SetGainOfFour([64, 32, 16, 8])).unwrap();
    assert_eq!(host.board.set.unwrap().gain, [64, 32, 16, 8]);
    assert_eq!(host.status().rows, 0);
    host.sequence += 1;
    host.send(host.sequence, &ToDevice::SelfTest);
    for _ in 0..256 {
        host.sample([5; GAUGES], Lost::NONE);
    }
    host.device.tick(host.now_us, &mut host.board);
    host.hear();
    let Some((_, Ok(Done::TestedOfFour(test)))) = host.answers.last() else {
        panic!("{:?}", host.answers)
    };
    assert_eq!(test.mean_counts, [5; GAUGES]);
    host.start(Source::Converter);
    host.sample([7; GAUGES], Lost::NONE);
    host.say(&ToDevice::Stop).unwrap();
    assert_eq!(host.rows[0].counts, [7; GAUGES]);
}

#[test]
fn a_device_of_one_gauge_sends_one_and_four_to_release_0_1_and_counts_what_a_change_costs() {
    let capabilities = Capabilities { channels: 1, ..IDENTITY.capabilities };
    let mut host = Host::of(Identity { capabilities, ..IDENTITY }, None);
    let hello = |schema| ToDevice::Hello(HelloToDevice { schema, version: "1" });
    host.say(&hello(EARLIER[0])).unwrap();
    host.start(Source::Converter);
    let mut sent = 0;
    for schema in [SCHEMA, EARLIER[0], SCHEMA] {
        for _ in 0..30 {
            host.sample([sent, 0, 0, 0], Lost::NONE);
            sent += 1;
            if sent % 20 == 0 {
                host.hear();
            }
        }
        // Another host, while blocks wait.
        host.say(&hello(schema)).unwrap();
    }
    host.say(&ToDevice::Stop).unwrap();
    for row in &host.rows {
        assert_eq!(row.counts, [row.number as i32, 0, 0, 0]);
    }
    let counters = host.status().counters;
    assert!(counters.link_full > 0);
    assert_eq!(host.rows.len() + counters.link_full as usize, 90);
}

#[test]
fn inputs_of_the_converter_are_tested_and_the_next_stream_is_of_the_gauges() {
    let mut host = Host::introduced();
    for inputs in [Inputs::Shorted, Inputs::TestSignal] {
        host.sequence += 1;
        host.send(host.sequence, &ToDevice::TestInputs(inputs));
        assert_eq!(host.board.set.unwrap().inputs, inputs);
        for _ in 0..256 {
            host.sample([5; GAUGES], Lost::NONE);
        }
        host.device.tick(host.now_us, &mut host.board);
        host.hear();
        let (to, Ok(Done::Tested(test))) = host.answers[host.answers.len() - 1] else {
            panic!("{:?}", host.answers)
        };
        assert_eq!((to, test.mean_counts), (host.sequence, PerGauge([5; GAUGES])));
    }
    host.start(Source::Converter);
    assert_eq!(host.board.set.unwrap().inputs, Inputs::Gauges);
}

#[test]
fn a_restart_is_answered_before_it_is_done() {
    let mut host = Host::introduced();
    host.sequence += 1;
    host.send(host.sequence, &ToDevice::Reboot);
    assert_eq!(host.device.restart_due(), None);
    host.hear();
    assert_eq!(host.answers.last(), Some(&(host.sequence, Ok(Done::Carried))));
    assert_eq!(host.device.restart_due(), Some(Restart::Firmware));
}

proptest! {
    #[test]
    fn no_frame_and_no_sample_makes_it_panic(
        frames in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..80), 0..40),
        counts in prop::collection::vec(prop::array::uniform4(any::<i32>()), 0..40),
    ) {
        let mut host = Host::introduced();
        host.start(Source::Converter);
        for (mut frame, counts) in frames.into_iter().zip(counts) {
            host.device.receive(&mut frame, host.now_us, &mut host.board);
            // Also what is a whole frame, but no sensible message.
            let mut whole = [0; FRAME_MAX];
            let bytes = wire::encode(Head::default(), &frame[..], &mut whole).unwrap().len();
            host.device.receive(&mut whole[..bytes - 1], host.now_us, &mut host.board);
            host.sample(counts, Lost { missed: frame.len() as u32, ..Lost::NONE });
            host.device.tick(host.now_us, &mut host.board);
            host.hear();
        }
    }
}
