//! From a device into a file, through whatever happens to the line.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use shared::wire::{BAUD, ClockSource, Columns, Counters, Felt, Row, Start, ToDevice};

use super::heard::{Heard, Identity, Said};
use super::session::{LinkError, Session};
use super::share::{File, Share};
use super::stream::{Mark, Stream, Tally};
use palpate_trace::recording::{Gap, Note, Opened};

/// A stream that says nothing for so long has ended: a status comes every second.
const SILENCE: Duration = Duration::from_millis(2_500);
/// How long to listen before looking at the clock.
const SLICE: Duration = Duration::from_millis(50);
/// The rate is that of at least so long.
const RATE_OVER: Duration = Duration::from_millis(500);
/// Time between two views.
const WATCH: Duration = Duration::from_millis(100);
/// A device may take so long to answer when it is there again.
const ANSWER_WITHIN: Duration = Duration::from_millis(750);
/// Between two attempts to open a port that went away.
const PAUSE: Duration = Duration::from_millis(100);

/// Bytes that a row takes on the line, as measured at 976 Hz with the noise of the simulated fingertip.
const fn bytes_per_row(columns: Columns) -> f64 {
    match columns {
        Columns::Parts => 11.0,
        Columns::All => 37.6,
    }
}

/// Whether a real line carries such a stream: if not, why not and what to do.
#[must_use]
pub fn overload(identity: &Identity, interval_s: f64, columns: Columns) -> Option<String> {
    let (rate_hz, carried) = (1.0 / interval_s, f64::from(BAUD) / 10.0);
    let made = rate_hz * bytes_per_row(columns);
    (identity.clock != ClockSource::Simulated && made > carried).then(|| {
        format!(
            "{rate_hz:.0} rows a second of these columns make about {:.0} kB/s, and the line carries {:.0}: rows will be lost, \
             and counted. Leave --all away, or set a lower rate with `palpate device set --rate`.",
            made / 1e3,
            carried / 1e3
        )
    })
}

/// What to record.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The port, to open it again.
    pub port: PathBuf,
    /// What the device is to stream.
    pub start: Start,
    /// When to end, if not when told.
    pub duration: Option<Duration>,
}

/// Why a recording ended before its time. What was recorded until then is in the file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum RecordError {
    #[error("{} is there already; give --force to write over it", .0.display())]
    Exists(PathBuf),
    #[error("{}: another recording is being written to it", .0.display())]
    Busy(PathBuf),
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    #[error(transparent)]
    Link(#[from] LinkError),
    #[error("another device answers now: {now} in place of {before}")]
    AnotherDevice { before: String, now: String },
}

/// How a recording goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Time since it began.
    pub passed: Duration,
    /// Rows in a second, over the last second.
    pub rate_hz: f64,
    /// What came and what did not.
    pub tally: Tally,
    /// Times that something was missing.
    pub gaps: u64,
    /// What the device itself lost since the recording began.
    pub drops: u64,
    /// The last row.
    pub row: Option<Row>,
    /// Frames that wait for the disk: now, and the most that ever did.
    pub backlog: (usize, usize),
    /// Whether the device is there.
    pub linked: bool,
}

/// What goes on beside a recording.
pub trait Beside {
    /// Whether the recording shall end.
    fn ended(&mut self) -> bool;

    /// Sees the recording about ten times in a second, and at the end.
    fn watch(&mut self, view: &View);

    /// Sees the rows of each block, whose last byte was read `at`.
    fn rows(&mut self, _: &[Row], _at: Instant) {}

    /// Hears of a touch, a release or a slip as soon as the device reports it.
    fn feel(&mut self, _: &Felt) {}

    /// May give commands, as to inject rows; about twenty times in a second.
    ///
    /// # Errors
    /// Those of the session.
    fn command(&mut self, _: &mut Session) -> Result<(), LinkError> {
        Ok(())
    }
}

/// Records until the plan or `beside` says so.
///
/// # Errors
/// [`RecordError`].
pub fn record(
    mut session: Session,
    plan: &Plan,
    file: &Path,
    overwrite: bool,
    beside: &mut dyn Beside,
) -> Result<View, RecordError> {
    let port = plan.port.to_string_lossy();
    let began = Instant::now();
    check_absent(file, overwrite)?;
    // A device that refuses leaves no file, and an older one as it is.
    begin(&mut session, plan.start)?;
    let shared = File::create(file, overwrite, &Opened::now(&port), false);
    let shared = shared.map_err(|error| {
        let _ = session.command(&ToDevice::Stop);
        not_created(file, error)
    })?;
    let mut recorder = Recorder::new(plan, shared.alone(), began, session.identity().clone());
    let outcome = recorder.run(session, beside);
    let view = recorder.view();
    let closed = shared.close(since_us(began, Instant::now()));
    beside.watch(&view);
    outcome.map_err(|stop| recorder.failed(stop, file))?;
    closed.map_err(|source| RecordError::File { path: file.into(), source })?;
    Ok(view)
}

/// Refuses to write over a recording that nobody allowed to.
pub(super) fn check_absent(file: &Path, overwrite: bool) -> Result<(), RecordError> {
    if !overwrite && file.is_file() { Err(RecordError::Exists(file.into())) } else { Ok(()) }
}

/// Why a recording's file was not created.
pub(super) fn not_created(file: &Path, error: io::Error) -> RecordError {
    match error.kind() {
        io::ErrorKind::AlreadyExists => RecordError::Exists(file.into()),
        io::ErrorKind::ResourceBusy => RecordError::Busy(file.into()),
        _ => RecordError::File { path: file.into(), source: error },
    }
}

/// Time since a recording began, µs.
#[must_use]
pub fn since_us(began: Instant, at: Instant) -> u64 {
    at.saturating_duration_since(began).as_micros() as u64
}

/// Why the loop ends.
pub(super) enum Stop {
    Link(LinkError),
    File(io::Error),
    Another(String),
}

impl From<LinkError> for Stop {
    fn from(error: LinkError) -> Self {
        Self::Link(error)
    }
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Self::File(error)
    }
}

/// Follows one device.
pub(super) struct Recorder<'p> {
    plan: &'p Plan,
    writer: Share,
    began: Instant,
    identity: Identity,
    stream: Stream,
    gaps: u64,
    /// What the device had lost when it began, and has lost now; after a reset it counts anew.
    drops: (u64, u64),
    drops_before_resets: u64,
    row: Option<Row>,
    heard_at: Instant,
    /// Rows a second ago, the device's time at the last of them, µs, and when that was.
    second: (u64, Option<u64>, Instant),
    rate_hz: f64,
    backlog: (usize, usize),
    linked: bool,
}

impl<'p> Recorder<'p> {
    /// Of a device whose stream was begun, into its share of a file that was opened at `began`.
    pub(super) fn new(plan: &'p Plan, writer: Share, began: Instant, identity: Identity) -> Self {
        let lost = lost(&identity.counters);
        Self {
            plan,
            writer,
            began,
            identity,
            stream: Stream::default(),
            gaps: 0,
            drops: (lost, lost),
            drops_before_resets: 0,
            row: None,
            heard_at: began,
            second: (0, None, began),
            rate_hz: 0.0,
            backlog: (0, 0),
            linked: true,
        }
    }

    fn now_us(&self, at: Instant) -> u64 {
        since_us(self.began, at)
    }

    /// What the loop ended with, in words.
    pub(super) fn failed(&self, stop: Stop, file: &Path) -> RecordError {
        match stop {
            Stop::Link(error) => error.into(),
            Stop::File(source) => RecordError::File { path: file.into(), source },
            Stop::Another(now) => {
                RecordError::AnotherDevice { before: self.identity.serial_number(), now }
            }
        }
    }

    /// Records until it is over.
    pub(super) fn run(&mut self, session: Session, beside: &mut dyn Beside) -> Result<(), Stop> {
        let mut present = Some(session);
        let outcome = self.follow(&mut present, beside);
        if let (Err(Stop::File(_)), Some(session)) = (&outcome, &mut present) {
            // Or the device would stream on for nobody. The file is what there is to tell.
            let _ = session.quiet();
        }
        outcome
    }

    /// Follows the device as long as it takes; it is `present` while its port is open.
    fn follow(
        &mut self,
        present: &mut Option<Session>,
        beside: &mut dyn Beside,
    ) -> Result<(), Stop> {
        self.heard_at = Instant::now();
        let mut watched = self.began;
        while !self.is_over(beside) {
            let Some(session) = present else { return Ok(()) };
            let until = Instant::now() + SLICE;
            let listened = self.listen(session, until, beside);
            let listened = listened.and_then(|()| Ok(beside.command(session)?));
            let silent = self.heard_at.elapsed() > SILENCE;
            match listened {
                Ok(()) if !silent => {}
                Ok(()) | Err(Stop::Link(LinkError::Line(_) | LinkError::Silent { .. })) => {
                    let gone = present.take();
                    *present = self.reconnect(gone, beside)?;
                    continue;
                }
                Err(stop) => return Err(stop),
            }
            self.writer.tick(self.now_us(Instant::now()))?;
            if watched.elapsed() >= WATCH {
                watched = Instant::now();
                beside.watch(&self.view());
            }
        }
        present.as_mut().map_or(Ok(()), |session| self.finish(session, beside))
    }

    fn is_over(&self, beside: &mut dyn Beside) -> bool {
        beside.ended() || self.plan.duration.is_some_and(|most| self.began.elapsed() >= most)
    }

    /// Writes what is heard until then.
    fn listen(
        &mut self,
        session: &mut Session,
        until: Instant,
        beside: &mut dyn Beside,
    ) -> Result<(), Stop> {
        while let Some(heard) = session.hear(until)? {
            self.take(&heard)?;
            match &heard.said {
                Ok((_, Said::Rows(rows))) => {
                    let rows = session.rows(rows).unwrap_or_default();
                    beside.rows(&rows, heard.at);
                    self.row = rows.last().copied();
                    if let (None, Some(row)) = (self.second.1, &self.row) {
                        self.second = (self.stream.tally().rows, Some(row.time_us), heard.at);
                    }
                }
                Ok((_, Said::Event(felt))) => beside.feel(felt),
                _ => {}
            }
            self.backlog = (session.backlog().now(), session.backlog().most().max(self.backlog.1));
            if Instant::now() >= until {
                break;
            }
        }
        Ok(())
    }

    fn take(&mut self, heard: &Heard) -> io::Result<()> {
        let at_us = self.now_us(heard.at);
        for gap in self.stream.take(heard).into_iter().filter_map(Mark::gap) {
            self.gap(at_us, gap)?;
        }
        let Ok((_, said)) = &heard.said else { return Ok(()) };
        self.heard_at = heard.at;
        if let Said::Status(status) = said {
            self.drops.1 = lost(&status.counters);
        }
        self.writer.frame(at_us, &heard.frame)
    }

    fn gap(&mut self, at_us: u64, gap: Gap) -> io::Result<()> {
        self.gaps += 1;
        self.writer.note(at_us, &Note::Gap(gap))
    }

    /// Waits until the device is there again; none if the recording is over before.
    fn reconnect(
        &mut self,
        gone: Option<Session>,
        beside: &mut dyn Beside,
    ) -> Result<Option<Session>, Stop> {
        self.linked = false;
        self.gap(self.now_us(Instant::now()), Gap::LinkLost)?;
        drop(gone);
        while !self.is_over(beside) {
            beside.watch(&self.view());
            self.writer.tick(self.now_us(Instant::now()))?;
            match self.resume() {
                Ok(session) => return Ok(Some(session)),
                Err(Stop::Link(LinkError::Line(_) | LinkError::Silent { .. })) => {
                    std::thread::sleep(PAUSE);
                }
                Err(stop) => return Err(stop),
            }
        }
        Ok(None)
    }

    fn resume(&mut self) -> Result<Session, Stop> {
        let mut session = Session::open(&self.plan.port, ANSWER_WITHIN)?;
        if session.identity().serial != self.identity.serial {
            return Err(Stop::Another(session.identity().serial_number()));
        }
        let status = session.status()?;
        let now_us = self.now_us(Instant::now());
        self.writer.note(now_us, &Note::Gap(Gap::LinkBack))?;
        if status.streaming != Some(self.plan.start.source) {
            // It does not stop on its own, so it began anew.
            self.gap(now_us, Gap::Reset)?;
            self.stream.restart();
            let before = self.drops.1 - self.drops.0;
            self.drops_before_resets += before;
            self.drops = (0, 0);
            begin(&mut session, self.plan.start)?;
        }
        self.linked = true;
        self.heard_at = Instant::now();
        Ok(session)
    }

    /// Ends the stream and writes the rest of it.
    fn finish(&mut self, session: &mut Session, beside: &mut dyn Beside) -> Result<(), Stop> {
        match session.quiet().and_then(|()| session.status().map(drop)) {
            // Then it just ends here.
            Ok(()) | Err(LinkError::Line(_) | LinkError::Silent { .. }) => {}
            Err(error) => return Err(error.into()),
        }
        match self.listen(session, Instant::now() + SLICE, beside) {
            Err(Stop::Link(_)) => Ok(()),
            listened => listened,
        }
    }

    /// Rows for each second of the device, Hz, so that a computer which hears them late tells the same; 0 where none came.
    fn rate(&self, rows: u64, time_us: Option<u64>) -> f64 {
        let (before, since_us, _) = self.second;
        // A device that began again counts its time from zero.
        let passed_us = time_us.zip(since_us).and_then(|(now, since)| now.checked_sub(since));
        match passed_us.filter(|&passed| passed > 0) {
            Some(passed) => rows.saturating_sub(before) as f64 / (passed as f64 * 1e-6),
            None => 0.0,
        }
    }

    /// How it goes.
    pub(super) fn view(&mut self) -> View {
        let now = Instant::now();
        let rows = self.stream.tally().rows;
        if now.duration_since(self.second.2) >= RATE_OVER {
            let time_us = self.row.as_ref().map(|row| row.time_us);
            self.rate_hz = self.rate(rows, time_us);
            self.second = (rows, time_us, now);
        }
        View {
            passed: now.duration_since(self.began),
            rate_hz: self.rate_hz,
            tally: *self.stream.tally(),
            gaps: self.gaps,
            drops: self.drops_before_resets + self.drops.1.saturating_sub(self.drops.0),
            row: self.row,
            backlog: self.backlog,
            linked: self.linked,
        }
    }
}

/// Begins a stream; what is heard from here on begins with who the device is and its settings.
pub fn begin(session: &mut Session, start: Start) -> Result<(), LinkError> {
    session.settle()?;
    session.again(ANSWER_WITHIN)?;
    session.command(&ToDevice::Start(start))?;
    Ok(())
}

/// Rows that the device lost.
fn lost(counters: &Counters) -> u64 {
    let Counters { conversions_missed, conversions_damaged, queue_full, link_full, .. } = *counters;
    [conversions_missed, conversions_damaged, queue_full, link_full]
        .into_iter()
        .map(u64::from)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_that_the_line_cannot_carry_is_told_with_what_to_do() {
        let device = Identity { clock: ClockSource::Crystal, ..Identity::unknown() };
        let told = overload(&device, 1.0 / 3_906.25, Columns::All).unwrap();
        assert!(
            told.contains("147 kB/s") && told.contains("100") && told.contains("--rate"),
            "{told}"
        );
        assert_eq!(overload(&device, 1.0 / 3_906.25, Columns::Parts), None);
        assert_eq!(overload(&device, 1.0 / 1_953.125, Columns::All), None);
        let simulated = Identity { clock: ClockSource::Simulated, ..device };
        assert_eq!(overload(&simulated, 1.0 / 3_906.25, Columns::All), None);
    }
}
