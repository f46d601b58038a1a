//! More than a device can take.

use std::path::Path;
use std::time::{Duration, Instant};

use palpate::device::heard::{Heard, Said};
use palpate::device::line::Line;
use palpate::device::replay::message;
use palpate::device::stream::Stream;
use shared::pipeline::GAUGES;
use shared::wire::{
    Columns, Done, FRAME_MAX, Head, HelloToDevice, INJECT_ROWS, SCHEMA, Source, Start, Status,
    ToDevice, encode,
};

use super::{Checked, PATIENCE, Report, require};

/// Frames in one go, without waiting for an answer.
const FRAMES: u32 = 400;
/// Nothing more comes after so long.
const QUIET: Duration = Duration::from_millis(700);

/// Rows are sent as fast as the line takes them, with no regard for the answers. Every frame and every row is either
/// received or counted where it was lost, and the device still answers.
///
/// # Errors
/// What does not add up.
pub fn check_flooding(port: &Path) -> Checked {
    let mut host = Flood {
        line: Line::open(port)?,
        sequence: 1_000_000,
        stream: None,
        taken: 0,
        lost: 0,
        answered: 0,
    };
    host.greet()?;
    let before = host.status()?;
    if before.streaming.is_some() {
        host.ask(&ToDevice::Stop)?;
    }
    let source = Source::Link { interval_ns: 1_000_000 };
    host.ask(&ToDevice::Start(Start { source, columns: Columns::All }))?;
    host.stream = Some(Stream::default());
    let rows = [[1_000_003, -77_777, 123_456, 8_388_607]; INJECT_ROWS];
    let mut packed = [0; FRAME_MAX];
    let flood = ToDevice::Inject(message(&rows, GAUGES as u8, None, &mut packed)?);
    let began = Instant::now();
    for _ in 0..FRAMES {
        host.send(&flood)?;
    }
    let flooded = began.elapsed();
    host.hear_all()?;
    // It still answers; and this frame shows it the last that it missed.
    let after = host.status()?;
    host.ask(&ToDevice::Stop)?;
    let last = host.status()?;

    let (was, now) = (before.counters, after.counters);
    let missed = u64::from(now.frames_missed - was.frames_missed);
    require(host.answered + missed == u64::from(FRAMES), || {
        format!("{FRAMES} frames sent, {} answered, {missed} counted as missed", host.answered)
    })?;
    let queue_full = u64::from(last.counters.queue_full - was.queue_full);
    let link_full = u64::from(last.counters.link_full - was.link_full);
    let reached = host.answered * INJECT_ROWS as u64;
    require(host.taken + host.lost == reached && host.lost == queue_full, || {
        format!("of {reached} rows {} taken, {} lost, {queue_full} counted", host.taken, host.lost)
    })?;
    let received = host.stream.as_ref().map_or(0, |stream| stream.tally().rows);
    require(last.rows == reached && received + queue_full + link_full == reached, || {
        format!(
            "of {reached} rows (the device says {}) {received} received, {queue_full} found the queue full and \
             {link_full} the link",
            last.rows
        )
    })?;
    Ok(Report::new("flooding")
        .with("frames", FRAMES)
        .with("ms", flooded.as_millis())
        .with("frames missed and counted", missed)
        .with("rows reached it", reached)
        .with("received", received)
        .with("lost at its queue", queue_full)
        .with("lost at its link", link_full))
}

struct Flood {
    line: Line,
    sequence: u32,
    /// Followed from the start of the stream.
    stream: Option<Stream>,
    taken: u64,
    lost: u64,
    answered: u64,
}

impl Flood {
    fn send(&mut self, command: &ToDevice<'_>) -> Result<(), String> {
        self.sequence += 1;
        let mut frame = [0; FRAME_MAX];
        let head = Head { sequence: self.sequence, time_us: 0 };
        let frame = encode(head, command, &mut frame).map_err(|error| error.to_string())?;
        self.line.send(frame).map_err(|error| error.to_string())
    }

    /// Says `Hello` until it is heard: an emulated device may be booting.
    fn greet(&mut self) -> Result<(), String> {
        let hello = ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "flood" });
        let until = Instant::now() + PATIENCE;
        loop {
            match self.ask_within(&hello, QUIET) {
                Err(_) if Instant::now() < until => {}
                done => return done,
            }
        }
    }

    /// The next message, if one comes in time.
    fn hear(&mut self, patience: Duration) -> Result<Option<Said>, String> {
        let arrival = self.line.receive(Instant::now() + patience);
        let Some(heard) = arrival.map_err(|error| error.to_string())?.and_then(Heard::of) else {
            return Ok(None);
        };
        if let Some(stream) = &mut self.stream {
            stream.take(&heard);
        }
        let (_, said) = heard.said.map_err(|error| format!("a damaged frame: {error}"))?;
        if let Said::Answer(answer) = &said
            && let Ok(Done::Injected { taken, lost, .. }) = answer.outcome
        {
            self.answered += 1;
            self.taken += u64::from(taken);
            self.lost += u64::from(lost);
        }
        Ok(Some(said))
    }

    /// Hears until nothing comes any more but the status, which an emulated device, whose clock is fast, says often.
    fn hear_all(&mut self) -> Result<(), String> {
        let mut until = Instant::now() + QUIET;
        while Instant::now() < until {
            match self.hear(QUIET)? {
                None => return Ok(()),
                Some(Said::Status(_)) => {}
                Some(_) => until = Instant::now() + QUIET,
            }
        }
        Ok(())
    }

    fn ask(&mut self, command: &ToDevice<'_>) -> Result<(), String> {
        self.ask_within(command, PATIENCE)
    }

    fn ask_within(&mut self, command: &ToDevice<'_>, patience: Duration) -> Result<(), String> {
        self.send(command)?;
        let to = self.sequence;
        while let Some(said) = self.hear(patience)? {
            match said {
                Said::Answer(answer) if answer.to == to => {
                    return answer
                        .outcome
                        .map(drop)
                        .map_err(|refusal| format!("{command:?} was refused: {refusal:?}"));
                }
                _ => {}
            }
        }
        Err(format!("no answer to {command:?}"))
    }

    fn status(&mut self) -> Result<Status, String> {
        self.ask(&ToDevice::Status)?;
        // It follows its answer, and every row before it.
        while let Some(said) = self.hear(PATIENCE)? {
            if let Said::Status(status) = said {
                return Ok(*status);
            }
        }
        Err("no status".into())
    }
}
