//! The device as the host sees it.

use shared::events;
use shared::pipeline::{Config, GAUGES, Pipeline};
use shared::wire::{
    self, Answer, Capabilities, ClockSource, ConverterFault, Counters, Done, FRAME_MAX, Formats,
    Head, Hello, Kept, PerGauge, Refusal, ResetCause, Settings, SettingsByRatio, SettingsError,
    Source, Status, StoreFault, ToDevice, ToHost,
};

use crate::board::{Board, Log, Restart};
use crate::front_end::Found;
use crate::lamp::Lamp;
use crate::outgoing::{Due, Outgoing};
use crate::room::Room;
use crate::self_test::SelfTest;
use crate::stream::{Lost, Sample, Stream};

/// Status messages of a stream are this far apart, µs.
const STATUS_US: u64 = 1_000_000;
/// Longest piece of log in one frame.
const LOG_PIECE: usize = 192;

/// What does not change before the next reset.
#[derive(Clone, Copy, Debug)]
pub struct Identity<'a> {
    /// Version of the firmware.
    pub version: &'a str,
    /// Git state it was made from.
    pub git: &'a str,
    /// The board.
    pub board: &'a str,
    /// 96 bits that no other device has.
    pub serial: [u32; 3],
    /// Clock of the converter, Hz.
    pub converter_clock_hz: u32,
    /// The converter, by the name of its part.
    pub converter: &'a str,
    /// What it can do.
    pub capabilities: Capabilities,
    /// Where the processor's clock comes from.
    pub clock: ClockSource,
    /// Why it began.
    pub reset: ResetCause,
    /// What the last panic said; empty without.
    pub panic: &'a str,
}

/// What a device begins with.
#[derive(Clone, Copy, Debug)]
pub struct Beginning {
    pub(crate) settings: Settings,
    /// What the pipeline makes of them.
    pub(crate) config: Config,
    pub(crate) kept: Kept,
}

impl Beginning {
    /// The settings as the pipeline takes them.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }
}

/// Settings to begin with, as near as the converter can follow them: those of the record that was kept, or the defaults where there
/// is none or it is out of range.
///
/// # Errors
/// [`SettingsError`] if even the defaults are out of range with this converter.
#[inline(never)]
pub fn begin_with(
    record: Option<&[u8]>,
    capabilities: &Capabilities,
) -> Result<Beginning, SettingsError> {
    let (settings, kept) = match record.map(Settings::from_record) {
        None => (capabilities.defaults(), Kept::None),
        Some((_, kept @ (Kept::None | Kept::Discarded))) => (capabilities.defaults(), kept),
        Some((settings, kept)) => (capabilities.suited(settings), kept),
    };
    begin(&settings, kept).or_else(|_| begin(&capabilities.defaults(), Kept::Discarded))
}

/// Not in line, because the stack of whoever begins has no room for copies.
#[inline(never)]
fn begin(settings: &Settings, kept: Kept) -> Result<Beginning, SettingsError> {
    let config = settings.config(settings.interval_s())?;
    Ok(Beginning { settings: *settings, config, kept })
}

/// A fingertip: takes samples and the host's frames, gives frames for the host.
#[derive(Debug)]
pub struct Device<'a> {
    pub(crate) identity: Identity<'a>,
    pub(crate) settings: Settings,
    kept: Kept,
    pub(crate) stream: Stream<'a>,
    pub(crate) outgoing: Outgoing,
    pub(crate) counters: Counters,
    pub(crate) test: Option<SelfTest>,
    pub(crate) restart: Option<Restart>,
    pub(crate) stopping: Option<Stopping>,
    pub(crate) exchange: Option<Exchange>,
    host: Host,
    /// The last command and its answer.
    last: Option<Answer>,
    heard: Option<u32>,
    sequence: u32,
    pub(crate) temperature: Option<i16>,
    converter: Option<ConverterFault>,
    stack_used: u32,
    queue_most: u8,
    status_at_us: u64,
    /// When the shared line last rose, µs.
    pulse_us: u64,
}

/// What is known of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Host {
    /// Nothing, before its `Hello`.
    Unknown,
    /// It speaks this schema, and so do we.
    Speaks(u64),
    /// It speaks another.
    Foreign,
}

/// A stream that ends when the samples on their way have come.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stopping {
    /// Command that asked for it.
    pub(crate) number: u32,
    /// What was lost after the last sample.
    pub(crate) lost: Lost,
}

/// What the pipeline is to take with the first sample of other gains or of another rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exchange {
    pub(crate) config: Config,
    /// What is an event at the new rate.
    pub(crate) events: Option<events::Config>,
    /// Whether strain means what it did.
    pub(crate) same_strain: bool,
}

impl Identity<'_> {
    /// Gauges of its rows.
    pub(crate) fn gauges(&self) -> u8 {
        self.capabilities.channels.min(GAUGES as u8)
    }
}

impl<'a> Device<'a> {
    /// A device that begins with these settings and what [`begin_with`] made of them.
    #[must_use]
    pub fn new(
        identity: Identity<'a>,
        Beginning { settings, config, kept }: &Beginning,
        room: &'a mut Room,
    ) -> Self {
        Self {
            identity,
            settings: *settings,
            kept: *kept,
            stream: Stream::new(Pipeline::new(config), room),
            outgoing: Outgoing::new(),
            counters: Counters::default(),
            test: None,
            restart: None,
            stopping: None,
            exchange: None,
            host: Host::Unknown,
            last: None,
            heard: None,
            sequence: 0,
            temperature: None,
            converter: None,
            stack_used: 0,
            queue_most: 0,
            status_at_us: 0,
            pulse_us: 0,
        }
    }

    /// Notes that the line that the fingers of a hand share rose at this device time, µs. It is told while samples of the converter
    /// are sent; pulses are to be further apart than frames.
    pub fn note_pulse(&mut self, time_us: u64) {
        if self.stream.source() == Some(Source::Converter) && self.host_is_of_this_release() {
            self.pulse_us = time_us;
            self.outgoing.ask(Due::Pulse);
        }
    }

    /// Notes a temperature, 2^-8 °C.
    pub fn set_temperature(&mut self, temperature: Option<i16>) {
        self.temperature = temperature;
        if self.stream.source() == Some(Source::Converter) {
            self.stream.set_temperature(temperature);
        }
    }

    /// Notes what is wrong with the converter.
    pub const fn set_converter(&mut self, fault: Option<ConverterFault>) {
        self.converter = fault;
    }

    /// Notes what a look at the front end found, which listens to the converter or does not; whether that is news of a fault.
    pub fn look(&mut self, found: Found, listens: bool) -> bool {
        if found.lost != Lost::NONE {
            self.count_lost(found.lost);
        }
        let is_news = listens && self.converter != found.fault;
        if is_news {
            self.converter = found.fault;
        }
        is_news && found.fault.is_some()
    }

    /// What is known to be wrong with the converter.
    #[must_use]
    pub const fn converter(&self) -> Option<ConverterFault> {
        self.converter
    }

    /// How it shows how it is.
    #[must_use]
    pub fn lamp(&self) -> Lamp {
        match (self.converter, self.stream.source()) {
            (Some(_), _) => Lamp::Faulty,
            (None, Some(_)) => Lamp::Streaming,
            (None, None) => Lamp::Waiting,
        }
    }

    /// Notes the most bytes of stack that were used.
    pub const fn set_stack_used(&mut self, bytes: u32) {
        self.stack_used = bytes;
    }

    /// Notes how many rows wait between interrupt and filter.
    pub fn note_queue(&mut self, rows: u8) {
        self.queue_most = self.queue_most.max(rows);
    }

    /// Counts bytes from the host that were lost.
    pub const fn count_bytes_lost(&mut self, bytes: u32) {
        self.counters.bytes_lost = self.counters.bytes_lost.saturating_add(bytes);
    }

    /// Counts bytes of log that found no room.
    pub const fn count_log_lost(&mut self, bytes: u32) {
        self.counters.log_full = self.counters.log_full.saturating_add(bytes);
    }

    /// Takes a sample of the converter.
    #[inline]
    pub fn sample(&mut self, sample: &Sample) {
        if sample.lost != Lost::NONE {
            self.count_lost(sample.lost);
        }
        if let Some(test) = &mut self.test {
            test.take(sample);
        }
        if self.stream.source() == Some(Source::Converter) {
            self.stream.row(&sample.counts, sample.time_us);
        }
    }

    /// Counts conversions that were lost after the last sample, and notes that the next is of other gains or another rate.
    #[cold]
    pub fn count_lost(&mut self, lost: Lost) {
        let counters = &mut self.counters;
        counters.conversions_missed = counters.conversions_missed.saturating_add(lost.missed);
        counters.conversions_damaged = counters.conversions_damaged.saturating_add(lost.damaged);
        counters.queue_full = counters.queue_full.saturating_add(lost.queue_full);
        if self.stream.source() == Some(Source::Converter) && lost.all() > 0 {
            self.stream.lose(lost.all());
        }
        if lost.exchanged {
            self.exchange();
        }
    }

    /// Processes one injected row, unless blocks are held up on their way to the link; whether there was one.
    pub fn process_injected(&mut self) -> bool {
        self.stream.injected()
    }

    /// Whether injected rows wait for [`Self::process_injected`].
    #[must_use]
    pub fn has_injected(&self) -> bool {
        self.stream.has_injected()
    }

    /// To be called every 10 ms or so.
    pub fn tick(&mut self, now_us: u64, board: &mut impl Board) {
        self.stream.tick();
        if self.stream.source().is_some() && now_us.saturating_sub(self.status_at_us) >= STATUS_US {
            self.status_at_us = now_us;
            self.outgoing.ask(Due::Status);
        }
        if let Some(test) = &self.test
            && let Some(result) = test.result(now_us)
        {
            let to = test.to;
            self.test = None;
            self.count_lost(board.listen(false));
            self.answer(to, Ok(Done::Tested(result)));
        }
    }

    /// Whether a frame may be given to [`Self::receive`]: its answer would find room.
    #[must_use]
    pub fn can_receive(&self) -> bool {
        self.outgoing.has_room()
    }

    /// Takes a frame of the host, as [`wire::Accumulator`] cuts it; it is decoded in place. Whether it was one: what comes over a
    /// line without a host is none.
    pub fn receive(&mut self, frame: &mut [u8], now_us: u64, board: &mut impl Board) -> bool {
        let Ok((head, message)) = wire::open(frame) else {
            self.count_damaged();
            return false;
        };
        self.hear(head, message, now_us, board);
        true
    }

    fn hear(&mut self, head: Head, message: &[u8], now_us: u64, board: &mut impl Board) {
        if let Some(who) = wire::introduction(message) {
            return self.hello(head.sequence, who.schema);
        }
        let refusal = match self.host {
            Host::Unknown => Some(Refusal::NoHello),
            Host::Foreign if !wire::is_of_core(message) => Some(Refusal::Schema(wire::SCHEMA)),
            Host::Foreign | Host::Speaks(_) => None,
        };
        if let Some(refusal) = refusal {
            return self.outgoing.answer(Answer { to: head.sequence, outcome: Err(refusal) });
        }
        if let Some(answer) = self.last.filter(|answer| answer.to == head.sequence) {
            return self.outgoing.answer(answer);
        }
        let under_way = self.test.as_ref().map(|test| test.to);
        let ending = self.stopping.map(|stopping| stopping.number);
        if [under_way, ending].contains(&Some(head.sequence)) {
            return; // Its answer comes later.
        }
        let Ok(command) = wire::read::<ToDevice<'_>>(message) else {
            return self.count_damaged();
        };
        self.count_missed(head.sequence);
        if let Some(outcome) = self.carry_out(&command, head.sequence, now_us, board).transpose() {
            self.answer(head.sequence, outcome);
        }
    }

    /// Counts bytes that were no frame.
    pub const fn count_damaged(&mut self) {
        self.counters.frames_damaged = self.counters.frames_damaged.saturating_add(1);
    }

    fn hello(&mut self, sequence: u32, schema: u64) {
        let understood = wire::is_understood(schema);
        self.host = if understood { Host::Speaks(schema) } else { Host::Foreign };
        (self.last, self.heard) = (None, Some(sequence));
        self.outgoing = Outgoing::new();
        // Release 0.1 takes every row for one of four gauges.
        let all = GAUGES as u8;
        self.stream.set_gauges(if self.is_told_less() { all } else { self.identity.gauges() });
        self.outgoing.ask(Due::Hello);
        if understood {
            if self.host_is_of_this_release() {
                self.outgoing.ask(Due::Kept);
                self.outgoing.ask(Due::Capabilities);
            }
            self.outgoing.ask(Due::Settings);
            self.answer(sequence, Ok(Done::Carried));
        } else {
            self.answer(sequence, Err(Refusal::Schema(wire::SCHEMA)));
        }
    }

    /// Whether the host knows all messages.
    fn host_is_of_this_release(&self) -> bool {
        self.host == Host::Speaks(wire::SCHEMA)
    }

    /// Whether the host is of an earlier release.
    fn is_told_less(&self) -> bool {
        matches!(self.host, Host::Speaks(schema) if schema != wire::SCHEMA)
    }

    /// The settings, in words that the host's release has.
    fn told_settings(&self) -> ToHost<'static> {
        let (generation, settings) = (self.stream.generation, self.settings);
        if self.is_told_less() {
            let settings = SettingsByRatio::of(&settings, self.identity.converter_clock_hz);
            ToHost::SettingsByRatio { generation, settings }
        } else {
            ToHost::Settings { generation, settings }
        }
    }

    /// That there is no such rate, in words that the host's release has.
    pub(crate) fn without_rate(&self) -> Refusal {
        if self.is_told_less() { Refusal::Interval } else { Refusal::Rate }
    }

    /// What is wrong with the memory, in words that the host's release has.
    pub(crate) fn as_told(&self, fault: StoreFault) -> StoreFault {
        if self.is_told_less() && fault == StoreFault::Supply {
            StoreFault::NotWritten
        } else {
            fault
        }
    }

    pub(crate) fn answer(&mut self, to: u32, outcome: Result<Done, Refusal>) {
        let answer = Answer { to, outcome };
        self.last = Some(answer);
        self.outgoing.answer(answer);
    }

    fn count_missed(&mut self, sequence: u32) {
        let missed = self.heard.map_or(0, |heard| sequence.wrapping_sub(heard).wrapping_sub(1));
        // Numbers that go back are a host that began anew.
        if missed < 1 << 31 {
            self.counters.frames_missed = self.counters.frames_missed.saturating_add(missed);
        }
        self.heard = Some(sequence);
    }

    /// Whether there may be a message for [`Self::next_frame`]: asked after every sample, so that it costs little.
    #[inline]
    pub fn has_frame(&mut self, log: &impl Log) -> bool {
        !self.outgoing.is_empty()
            || !self.stream.room.feeling.is_empty()
            || !self.stream.room.blocks.is_empty()
            || log.is_waiting()
    }

    /// Puts the next message into `frame`, if there is one; the bytes to send. What was logged comes last.
    #[inline]
    pub fn next_frame<'f>(
        &mut self,
        now_us: u64,
        log: &mut impl Log,
        frame: &'f mut [u8; FRAME_MAX],
    ) -> Option<&'f [u8]> {
        if self.has_frame(log) { self.encode_next(now_us, log, frame) } else { None }
    }

    fn encode_next<'f>(
        &mut self,
        now_us: u64,
        log: &mut impl Log,
        frame: &'f mut [u8; FRAME_MAX],
    ) -> Option<&'f [u8]> {
        let head = Head { sequence: self.sequence, time_us: now_us };
        let is_told_less = self.is_told_less();
        let sent = if self.outgoing.take(Due::Hello) {
            wire::encode(head, &ToHost::Hello(self.introduction()), frame)
        } else if self.outgoing.take(Due::Kept) {
            wire::encode(head, &ToHost::Kept(self.kept), frame)
        } else if self.outgoing.take(Due::Capabilities) {
            let Identity { converter: part, capabilities, .. } = self.identity;
            wire::encode(head, &ToHost::Converter { part, capabilities }, frame)
        } else if self.outgoing.is_due(Due::Settings) && self.settings_are_next() {
            self.outgoing.take(Due::Settings);
            wire::encode(head, &self.told_settings(), frame)
        } else if let Some(answer) = self.outgoing.next_answer() {
            wire::encode(head, &ToHost::Answer(self.told_answer(answer)), frame)
        } else if let Some(felt) = self.next_felt() {
            wire::encode(head, &ToHost::Event(felt), frame)
        } else if self.outgoing.take(Due::Pulse) {
            wire::encode(head, &ToHost::Pulse { time_us: self.pulse_us }, frame)
        } else if let Some(rows) = self.stream.room.blocks.next() {
            let sent = if is_told_less {
                rows.encode_of_four(self.sequence, frame)
            } else {
                rows.encode(self.sequence, frame)
            };
            self.stream.room.blocks.sent();
            sent
        } else if self.outgoing.take(Due::Status) {
            wire::encode(head, &self.told_status(), frame)
        } else if matches!(self.host, Host::Speaks(_)) && log.is_waiting() {
            let mut piece = [0; LOG_PIECE];
            let length = log.take(&mut piece);
            let bytes = piece.get(..length).filter(|bytes| !bytes.is_empty())?;
            wire::encode(head, &ToHost::Log(wire::Log { bytes }), frame)
        } else {
            return None;
        };
        self.sequence = self.sequence.wrapping_add(1);
        sent.ok()
    }

    /// The next event, for a host whose release knows events.
    fn next_felt(&mut self) -> Option<wire::Felt> {
        let felt = self.stream.room.feeling.next();
        felt.filter(|_| self.host_is_of_this_release())
    }

    /// Blocks of older settings go before the new ones, so that a host always has those of the block it hears.
    fn settings_are_next(&mut self) -> bool {
        if self.exchange.is_some() {
            // They are told with the first block that they made.
            return false;
        }
        let generation = self.stream.generation;
        self.stream.room.blocks.next().is_none_or(|rows| rows.generation == generation)
    }

    /// What to do now that everything was sent, if the host asked for it.
    #[must_use]
    pub fn restart_due(&self) -> Option<Restart> {
        self.restart.filter(|_| self.outgoing.is_empty())
    }

    fn introduction(&self) -> Hello<'a> {
        let identity = self.identity;
        Hello {
            // To an older host we are of its release, as far as it goes.
            schema: if let Host::Speaks(schema) = self.host { schema } else { wire::SCHEMA },
            version: identity.version,
            git: identity.git,
            board: identity.board,
            serial: identity.serial,
            channels: identity.gauges(),
            converter_clock_hz: identity.converter_clock_hz,
            clock: identity.clock,
            formats: Formats::OURS,
            reset: identity.reset,
            panic: identity.panic,
            counters: self.counters(),
        }
    }

    fn counters(&self) -> Counters {
        Counters { link_full: self.stream.link_full, ..self.counters }
    }

    /// The status in the words of the host.
    fn told_status(&self) -> ToHost<'static> {
        let status = self.status();
        if self.is_told_less() {
            ToHost::StatusOfFour(status.into())
        } else {
            ToHost::Status(status)
        }
    }

    /// An answer in the words of the host.
    fn told_answer(&self, answer: Answer) -> Answer {
        match answer.outcome {
            Ok(Done::Tested(test)) if self.is_told_less() => {
                Answer { outcome: Ok(Done::TestedOfFour(test.into())), ..answer }
            }
            _ => answer,
        }
    }

    fn status(&self) -> Status {
        Status {
            counters: self.counters(),
            gauges: PerGauge(self.stream.gauges()),
            rows: self.stream.rows(),
            streaming: self.stream.source(),
            temperature: self.temperature,
            converter: self.converter,
            stack_used: self.stack_used,
            queue_most: self.queue_most,
        }
    }

    /// Time between two rows, s, with some settings.
    pub(crate) fn interval_s(&self, settings: &Settings) -> f64 {
        match self.stream.source() {
            Some(Source::Link { interval_ns }) => f64::from(interval_ns) * 1e-9,
            _ => settings.interval_s(),
        }
    }
}
