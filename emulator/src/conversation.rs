//! The host's side of the talk: commands that are asked again until they are answered, and what the stream says.

use shared::calibration::{Calibration, Sheet};
use shared::pipeline::GAUGES;
use shared::wire::{
    Accumulated, Accumulator, Columns, Done, FRAME_MAX, Head, HelloToDevice, Oversampling, Refusal,
    Row, Rows, SCHEMA, Settings, Source, Start, Status, ToDevice, ToHost, decode, encode,
};

use crate::{Board, MS};

/// A board at 168 MHz has begun after this: most of it goes to looking through the sectors of the settings.
pub const BOOT_MS: u64 = 50;
/// How often a host asks before it gives up, as `palpate` does.
const TRIES: u32 = 10;

/// What the device has said so far.
#[derive(Debug, Default)]
pub struct Heard {
    accumulator: Accumulator,
    bytes: usize,
    sequence: u32,
    /// Frames that were none.
    pub damaged: u64,
    /// Rows that came.
    pub rows: Vec<Row>,
    /// Rows that were counted as lost: numbers that were left out.
    pub left_out: u64,
    next_row: u64,
    /// Answers.
    pub answers: Vec<(u32, Result<Done, Refusal>)>,
    /// The last status.
    pub status: Option<Status>,
    /// The last settings.
    pub settings: Option<Settings>,
    /// Words of the last panic.
    pub last_words: String,
    /// When the shared line rose, µs of the device.
    pub pulses: Vec<u64>,
    /// Why it began, clock and board, as its last `Hello` said.
    pub hello: Option<String>,
}

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// How often it was asked.
    pub tries: u32,
    /// The answer.
    pub outcome: Result<Done, Refusal>,
}

/// A calibration that reads about 0.9 µε per thousand counts.
#[must_use]
pub fn sheet() -> Sheet {
    let [sheet, ..] = Settings::DEFAULT.calibration;
    sheet
}

impl Board {
    /// Sends a command once; its number.
    pub fn tell(&mut self, command: &ToDevice<'_>) -> u32 {
        self.heard.sequence += 1;
        self.repeat(self.heard.sequence, command)
    }

    fn repeat(&mut self, sequence: u32, command: &ToDevice<'_>) -> u32 {
        let mut room = [0; FRAME_MAX];
        let head = Head { sequence, time_us: 0 };
        let bytes = encode(head, command, &mut room).unwrap();
        self.send(bytes);
        sequence
    }

    /// Asks until there is an answer, again after so many ms.
    ///
    /// # Panics
    /// If none ever comes.
    pub fn ask(&mut self, command: &ToDevice<'_>, patience_ms: u64) -> Asked {
        self.try_to_ask(command, patience_ms).unwrap_or_else(|| panic!("no answer to {command:?}"))
    }

    /// Asks until there is an answer; none if it never comes.
    pub fn try_to_ask(&mut self, command: &ToDevice<'_>, patience_ms: u64) -> Option<Asked> {
        let number = self.tell(command);
        for tries in 1..=TRIES {
            if tries > 1 {
                self.repeat(number, command);
            }
            for _ in 0..4 * patience_ms {
                self.run_ns(MS / 4);
                self.listen();
                let answer = self.heard.answers.iter().find(|(to, _)| *to == number);
                if let Some((_, outcome)) = answer {
                    return Some(Asked { tries, outcome: *outcome });
                }
            }
        }
        None
    }

    /// Introduces the host, as often as it takes until the device has said who it is: its first frame after a reset may follow half
    /// of one from before.
    ///
    /// # Panics
    /// If no answer ever comes.
    pub fn hello(&mut self) -> Asked {
        self.heard.hello = None;
        let hello = ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "0.1.0" });
        let mut tries = 0;
        loop {
            // It ends whatever was on the line before.
            self.send(&[0]);
            let asked = self.ask(&hello, 20);
            tries += asked.tries;
            if self.heard.hello.is_some() || tries > TRIES {
                return Asked { tries, ..asked };
            }
        }
    }

    /// A board that was given time to begin, and a host that introduced itself.
    #[must_use]
    pub fn started(setup: &crate::Setup) -> Self {
        let mut board = Self::new(setup);
        board.run_ns(BOOT_MS * MS);
        board.hello();
        board
    }

    /// Starts a stream of the converter.
    ///
    /// # Panics
    /// If it is refused.
    pub fn stream(&mut self, rate: Oversampling) {
        self.ask(&ToDevice::SetRatio(rate), 40).outcome.unwrap();
        let start = Start { source: Source::Converter, columns: Columns::Parts };
        self.ask(&ToDevice::Start(start), 100).outcome.unwrap();
    }

    /// Time passes and what comes is heard, ms.
    pub fn listen_ms(&mut self, ms: u64) {
        for _ in 0..ms.div_ceil(10) {
            self.run_ns(ms.min(10) * MS);
            self.listen();
        }
    }

    /// Status of now.
    ///
    /// # Panics
    /// If none comes.
    pub fn status(&mut self) -> Status {
        self.heard.status = None;
        self.ask(&ToDevice::Status, 20);
        self.listen_ms(10);
        self.heard.status.expect("a status")
    }

    /// Hears what came since the last call.
    pub fn listen(&mut self) {
        let new = self.came(self.heard.bytes);
        self.heard.bytes += new.len();
        let mut accumulator = std::mem::take(&mut self.heard.accumulator);
        for byte in new {
            match accumulator.push(byte) {
                Accumulated::Frame(frame) => match decode::<ToHost<'_>>(frame) {
                    Ok((head, message)) => self.heard.take(head, message),
                    Err(_) => self.heard.damaged += 1,
                },
                Accumulated::TooLong => self.heard.damaged += 1,
                Accumulated::Nothing => {}
            }
        }
        self.heard.accumulator = accumulator;
    }
}

impl Heard {
    /// Listens to a line from one of its bytes on.
    pub(crate) fn begin_at(&mut self, bytes: usize) {
        (self.accumulator, self.bytes) = (Accumulator::new(), bytes);
    }

    /// Forgets rows and answers.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.answers.clear();
        self.left_out = 0;
    }

    fn take(&mut self, head: Head, message: ToHost<'_>) {
        match message {
            ToHost::Samples(block) => {
                let calibration = [Calibration::new(&sheet()).unwrap(); GAUGES];
                let rows = Rows::decode(head, &block).unwrap();
                if block.first < self.next_row {
                    // Another stream, of which the first rows may be lost.
                    self.next_row = 0;
                }
                self.left_out += block.first - self.next_row;
                self.rows.extend(rows.iter(&calibration));
                self.next_row = self.rows.last().map_or(block.first, |row| row.number + 1);
            }
            ToHost::Answer(answer) => self.answers.push((answer.to, answer.outcome)),
            ToHost::Status(status) => self.status = Some(status),
            ToHost::Settings { settings, .. } => self.settings = Some(settings),
            ToHost::Hello(hello) => {
                self.last_words = hello.panic.to_owned();
                self.hello = Some(format!("{} {:?} {:?}", hello.board, hello.clock, hello.reset));
            }
            ToHost::Converter { .. } => {}
            // To release 0.1 only.
            ToHost::SettingsByRatio { .. } | ToHost::StatusOfFour(_) | ToHost::SamplesOfFour(_) => {
            }
            ToHost::Pulse { time_us } => self.pulses.push(time_us),
            ToHost::Log(_) | ToHost::Kept(_) | ToHost::Event(_) => {}
        }
    }
}
