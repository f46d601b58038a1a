//! Device, line and recorder through whatever happens: what was sent is what was received and what was counted.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::time::Instant;

use device::{Device, Lost, Sample};
use palpate::device::heard::{Heard, Said};
use palpate::device::line::Arrival;
use palpate::device::stream::{Mark, Stream};
use palpate::recording::{Entry, Gap, Note, Opened, Reader, Writer};
use palpate_tests::fuzz::{Desk, desk};
use proptest::prelude::*;
use shared::pipeline::GAUGES;
use shared::wire::{
    Accumulated, Accumulator, Columns, FRAME_MAX, Head, HelloToDevice, INJECT_ROWS, Inject,
    Oversampling, Rows, SCHEMA, Source, Start, ToDevice, ToHost, encode, pack,
};

/// Something that happens.
#[derive(Clone, Debug)]
enum Event {
    /// So many conversions; between interrupt and filter so many were lost.
    Samples { count: u16, lost: u8 },
    /// Rows from the host.
    Injected { rows: u8 },
    /// The device does what it does a thousand times a second.
    Ticks { count: u8 },
    /// The line takes so many frames; each with this wrong: 0 none, 1 not sent, 2 a bit, 3 cut, 4 noise before it.
    Listened { frames: u8, wrong: Vec<u8> },
    /// Another rate of the converter.
    Rate { fast: bool },
    /// The host begins the stream anew.
    Started { injected: bool, all: bool },
    /// Another zero of the gauges, in the middle of a stream.
    Tared,
    /// A command comes damaged.
    Garbled { bytes: Vec<u8> },
    /// The device begins anew, whatever it was doing.
    Reset,
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        4 => (1..400_u16, 0..4_u8).prop_map(|(count, lost)| Event::Samples { count, lost }),
        2 => (1..=INJECT_ROWS as u8).prop_map(|rows| Event::Injected { rows }),
        2 => (1..5_u8).prop_map(|count| Event::Ticks { count }),
        6 => (1..40_u8, prop::collection::vec(0..8_u8, 1..6))
            .prop_map(|(frames, wrong)| Event::Listened { frames, wrong }),
        1 => any::<bool>().prop_map(|fast| Event::Rate { fast }),
        1 => any::<(bool, bool)>().prop_map(|(injected, all)| Event::Started { injected, all }),
        1 => prop::collection::vec(any::<u8>(), 0..80).prop_map(|bytes| Event::Garbled { bytes }),
        1 => Just(Event::Tared),
        1 => Just(Event::Reset),
    ]
}

/// A file in memory.
#[derive(Clone, Default)]
struct Memory(Rc<RefCell<Vec<u8>>>);

impl io::Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The host's end of the line, with its recorder.
struct Host {
    line: Accumulator,
    stream: Stream,
    writer: Writer<Memory>,
    sequence: u32,
    /// Rows that the device made, by the status that came last.
    rows_made: u64,
    /// Rows that had come, and were missing by their numbers, when the stream began.
    before: (u64, u64),
}

impl Host {
    fn new(file: Memory) -> Self {
        Self {
            line: Accumulator::new(),
            stream: Stream::default(),
            writer: Writer::new(file, &Opened::timeless("desk")).unwrap(),
            sequence: 0,
            rows_made: 0,
            before: (0, 0),
        }
    }

    fn hear(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let arrival = match self.line.push(*byte) {
                Accumulated::Frame(frame) => Arrival::Frame(Instant::now(), frame.to_vec()),
                Accumulated::TooLong => Arrival::TooLong(Instant::now()),
                Accumulated::Nothing => continue,
            };
            self.take(&Heard::of(arrival).expect("the line is there"));
        }
    }

    fn take(&mut self, heard: &Heard) {
        for mark in self.stream.take(heard) {
            let gap = match mark {
                Mark::RowsLost { count, .. } => Gap::RowsLost(count),
                Mark::FramesLost(frames) => Gap::FramesLost(frames),
                Mark::Reset => panic!("this device was not reset"),
                Mark::Damaged(_) | Mark::Settings { .. } => continue,
            };
            self.writer.note(0, &Note::Gap(gap)).unwrap();
        }
        let Ok((_, said)) = &heard.said else { return };
        self.writer.frame(0, &heard.frame).unwrap();
        if let Said::Status(status) = said {
            self.rows_made = status.rows;
        }
    }
}

/// A stream from its beginning to its end: rows made by the device's own word, received, and counted as lost.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Count {
    made: u64,
    received: u64,
    lost: u64,
}

/// One life of a device, with a host.
struct Life<'a, 'd> {
    device: &'a mut Device<'d>,
    board: &'a mut Desk,
    host: &'a mut Host,
    now_us: u64,
    counts: Vec<Count>,
}

impl Life<'_, '_> {
    /// A command that arrives.
    fn say(&mut self, command: &ToDevice<'_>) {
        self.host.sequence += 1;
        let mut frame = [0; FRAME_MAX];
        let head = Head { sequence: self.host.sequence, time_us: 0 };
        let length = encode(head, command, &mut frame).unwrap().len();
        self.device.receive(&mut frame[..length - 1], self.now_us, self.board);
    }

    /// The next frame that the device gives.
    fn next_frame(&mut self) -> Option<Vec<u8>> {
        while self.device.process_injected() {}
        let mut out = [0; FRAME_MAX];
        self.device.next_frame(self.now_us, &mut (), &mut out).map(<[u8]>::to_vec)
    }

    /// All that the device has to say comes through.
    fn hear_all(&mut self) {
        while let Some(bytes) = self.next_frame() {
            self.host.hear(&bytes);
        }
    }

    fn begin(&mut self, injected: bool, all: bool) {
        let link = Source::Link { interval_ns: 1_000_000 };
        let source = if injected { link } else { Source::Converter };
        let columns = if all { Columns::All } else { Columns::Parts };
        self.say(&ToDevice::Start(Start { source, columns }));
        let tally = self.host.stream.tally();
        self.host.before = (tally.rows, tally.rows_lost);
        self.host.stream.start();
    }

    /// Ends the stream in order: its last rows come, and the status that says how many there were.
    fn end(&mut self) {
        // What was cut on the line ends here.
        self.host.hear(&[0]);
        self.hear_all();
        self.say(&ToDevice::Stop);
        // Every sample that was let through is there: the stream may end.
        self.device.drained();
        self.hear_all();
        self.say(&ToDevice::Status);
        self.hear_all();
        let (tally, made) = (self.host.stream.tally(), self.host.rows_made);
        // Rows that were lost behind the last that came are known by the status alone.
        let behind = made.saturating_sub(self.host.stream.next_row());
        let (received, lost) =
            (tally.rows - self.host.before.0, tally.rows_lost - self.host.before.1);
        self.counts.push(Count { made, received, lost: lost + behind });
    }

    fn live(&mut self, event: &Event) {
        match event {
            Event::Samples { count, lost } => {
                for k in 0..*count {
                    self.now_us += 1_000;
                    let counts = [i32::from(k) * 1_000, -7, i32::from(k % 13), 8_000_000];
                    let missed = if k == 0 { u32::from(*lost) } else { 0 };
                    let sample = Sample {
                        time_us: self.now_us,
                        counts,
                        lost: Lost { missed, ..Lost::default() },
                    };
                    if self.board.listening {
                        self.device.sample(&sample);
                    }
                }
            }
            Event::Injected { rows } => {
                let rows = vec![[5, -6, 70_000, 8]; usize::from(*rows)];
                let mut room = [0; FRAME_MAX];
                let counts = pack(&rows, GAUGES as u8, &mut room).unwrap();
                self.say(&ToDevice::Inject(Inject { temperature: None, counts }));
            }
            Event::Ticks { count } => {
                for _ in 0..*count {
                    self.now_us += 1_000;
                    self.device.tick(self.now_us, self.board);
                }
            }
            Event::Listened { frames, wrong } => {
                for (_, wrong) in (0..*frames).zip(wrong.iter().cycle()) {
                    let Some(mut bytes) = self.next_frame() else { break };
                    let middle = bytes.len() / 2;
                    match wrong {
                        1 => bytes.clear(),
                        2 => bytes[middle] ^= 0x10,
                        3 => bytes.truncate(middle),
                        4 => drop(bytes.splice(..0, [3, 1, 4, 1, 5])),
                        _ => {}
                    }
                    self.host.hear(&bytes);
                }
            }
            Event::Rate { fast } => {
                self.end();
                let rate = if *fast { Oversampling::X1024 } else { Oversampling::X4096 };
                self.say(&ToDevice::SetRatio(rate));
                self.begin(false, false);
            }
            Event::Started { injected, all } => {
                self.end();
                self.begin(*injected, *all);
            }
            Event::Tared => self.say(&ToDevice::Tare),
            Event::Garbled { bytes } => {
                self.device.receive(&mut bytes.clone(), self.now_us, self.board);
            }
            Event::Reset => {}
        }
    }
}

/// Rows that were received, and rows that a recording holds.
struct Kept {
    received: u64,
    recorded: u64,
}

fn run(events: &[Event]) -> (Vec<Count>, Kept) {
    let file = Memory::default();
    let mut host = Host::new(file.clone());
    let mut counts = Vec::new();
    let lives: Vec<&[Event]> = events.split(|event| matches!(event, Event::Reset)).collect();
    for (number, events) in lives.iter().enumerate() {
        desk(|device, board| {
            let mut life = Life { device, board, host: &mut host, now_us: 0, counts: Vec::new() };
            life.say(&ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "1" }));
            life.hear_all();
            life.begin(false, false);
            life.hear_all();
            events.iter().for_each(|event| life.live(event));
            if number + 1 == lives.len() {
                life.end();
            }
            counts.append(&mut life.counts);
        });
        // What was on the line is gone; the host notices that the device begins anew.
        host.line = Accumulator::new();
        host.stream.restart();
        host.writer.note(0, &Note::Gap(Gap::Reset)).unwrap();
    }
    let received = host.stream.tally().rows;
    host.writer.close(0).unwrap();
    let bytes = file.0.borrow();
    let mut reader = Reader::new(&bytes[..]).unwrap();
    let mut recorded = 0;
    while let Some(entry) = reader.next_entry().unwrap() {
        if let Entry::Frame { head, message: ToHost::Samples(block), .. } = entry {
            recorded += Rows::decode(head, &block).unwrap().len() as u64;
        }
    }
    (counts, Kept { received, recorded })
}

proptest! {
    #[test]
    fn what_was_sent_is_what_was_received_and_what_was_counted(
        events in prop::collection::vec(event(), 1..40)
    ) {
        let (counts, kept) = run(&events);
        prop_assert!(!counts.is_empty());
        for count in &counts {
            prop_assert_eq!(count.made, count.received + count.lost, "{:?}", counts);
        }
        prop_assert_eq!(kept.recorded, kept.received);
    }
}

#[test]
fn a_clean_line_loses_nothing() {
    let listened = Event::Listened { frames: 39, wrong: vec![0] };
    let samples = Event::Samples { count: 20, lost: 0 };
    let events: Vec<Event> = (0..50).flat_map(|_| [samples.clone(), listened.clone()]).collect();
    let (counts, kept) = run(&events);
    assert_eq!(counts, [Count { made: 1_000, received: 1_000, lost: 0 }]);
    assert_eq!(kept.recorded, 1_000);
}
