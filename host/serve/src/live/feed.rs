//! The thread that talks with the device: rows into the store, wishes into commands, through whatever happens to the line.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use shared::wire::{Columns, Row, Source, Start, ToDevice};

use super::care::calibration;
use super::counts::Counts;
use super::foretold::Foretelling;
use super::grasp::Grasp;
use super::hand::Hand;
use super::log::Log;
use super::recorder::Recorder;
use super::replay::{Replay, Step};
use super::store::{Event, Store};
use super::wish::{Request, Wish, command, file_name};
use palpate_link::device::describe::felt_in_words;
use palpate_link::device::heard::{Heard, Said};
use palpate_link::device::record::begin;
use palpate_link::device::release::verdict;
use palpate_link::device::session::{LinkError, Session};
use palpate_link::device::stream::{Mark, Stream};
use palpate_link::robots::Listener;
use palpate_trace::recording::Gap;

/// How long to listen before looking at wishes.
const SLICE: Duration = Duration::from_millis(10);
/// A device that says nothing for so long is gone: a status comes every second.
const SILENCE: Duration = Duration::from_millis(2_500);
/// A device may take so long to answer when it is there again.
const ANSWER_WITHIN: Duration = Duration::from_millis(750);
/// Between two attempts to open a port that went away.
const PAUSE: Duration = Duration::from_millis(100);

/// Locks the store; a panic elsewhere does not make its numbers unreadable.
pub(crate) fn lock(store: &Mutex<Store>) -> MutexGuard<'_, Store> {
    store.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Everything the thread needs.
pub(super) struct Feed {
    /// Port of the device.
    pub(super) port: PathBuf,
    /// Folder for recordings.
    pub(super) folder: PathBuf,
    /// The fingers that write files together, and which of them this is, from 0.
    pub(super) hand: (Hand, u8),
    /// Where rows go.
    pub(super) store: Arc<Mutex<Store>>,
    /// What pages ask for.
    pub(super) requests: Receiver<Request>,
    /// Whether to end.
    pub(super) ended: Arc<AtomicBool>,
    /// The trace to put in, if the device shall not measure.
    pub(super) replay: Option<Replay>,
    pub(super) stream: Stream,
    pub(super) recorder: Option<(String, Recorder)>,
    pub(super) counts: Counts,
    pub(super) grasp: Grasp,
    pub(super) foretelling: Foretelling,
    pub(super) log: Log,
    /// What else hears the fingertip.
    pub(super) listener: Option<Box<dyn Listener>>,
    /// Whether a stream is wanted.
    pub(super) wanted: bool,
    pub(super) heard_at: Instant,
}

impl Feed {
    /// Talks until told to end, first over a conversation that is open, if one is.
    pub(super) fn run(mut self, session: Option<Session>) {
        let mut next = session;
        while !self.is_over() {
            match next.take().map_or_else(|| Session::open(&self.port, ANSWER_WITHIN), Ok) {
                Ok(session) => {
                    if let Err(error) = self.converse(session) {
                        self.lose(&error);
                    }
                }
                Err(error) => {
                    {
                        let mut store = lock(&self.store);
                        store.health.trouble = Some(error.to_string());
                        if let LinkError::Schema { theirs, .. } = &error {
                            store.bench.release = Some(verdict(theirs, false));
                        }
                    }
                    self.refuse();
                    std::thread::sleep(PAUSE);
                }
            }
        }
        self.end_recording();
    }

    fn is_over(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    fn start(&self) -> Start {
        let converter = Start { source: Source::Converter, columns: Columns::All };
        self.replay.as_ref().map_or(converter, Replay::start)
    }

    /// From a device that answers to one that does not.
    fn converse(&mut self, mut session: Session) -> Result<(), LinkError> {
        self.meet(&mut session)?;
        while !self.is_over() {
            self.listen(&mut session)?;
            if self.heard_at.elapsed() > SILENCE {
                // It says so itself, or it is gone.
                session.status()?;
            }
            self.inject(&mut session)?;
            while let Ok(request) = self.requests.try_recv() {
                self.answer(request, &mut session)?;
            }
            let kept = self.recorder.as_mut().map_or(Ok(()), |(_, recorder)| recorder.tick());
            self.check_disk(kept);
            self.counts.tick();
        }
        session.quiet()
    }

    /// A device is there, perhaps again: what it streams goes on, or begins.
    fn meet(&mut self, session: &mut Session) -> Result<(), LinkError> {
        let status = session.status()?;
        self.log.meet(session.identity(), &self.store);
        let goes_on = status.streaming == Some(self.start().source) && self.stream.tally().rows > 0;
        {
            let mut store = lock(&self.store);
            let was_here = store.health.trouble.take().is_some();
            (store.health.linked, store.health.streaming) = (true, goes_on);
            store.health.identify(session.identity());
            store.health.status(&status);
            store.health.set(session.settings().1);
            store.health.log = self.log.words();
            store.bench.release = Some(verdict(&session.identity().version, true));
            store.bench.generation = session.settings().0;
            store.say(if was_here { "the device is there again" } else { "the device is there" });
        }
        self.heard_at = Instant::now();
        self.note_gap(Gap::LinkBack);
        if goes_on {
            return Ok(());
        }
        self.stream.restart();
        if let Some(replay) = &self.replay {
            replay.prepare(session)?;
        }
        if self.wanted { self.begin(session) } else { session.settle().map(drop) }
    }

    /// Begins a stream.
    pub(super) fn begin(&mut self, session: &mut Session) -> Result<(), LinkError> {
        begin(session, self.start())?;
        self.stream.restart();
        if let Some(replay) = &mut self.replay {
            replay.begin();
        }
        self.wanted = true;
        let mut store = lock(&self.store);
        store.begin_stream();
        self.foretelling.begin(&mut store.bench.foretold);
        store.health.streaming = true;
        Ok(())
    }

    fn stop(&mut self, session: &mut Session) -> Result<(), LinkError> {
        session.quiet()?;
        self.wanted = false;
        self.counts.end("the stream was stopped");
        lock(&self.store).health.streaming = false;
        Ok(())
    }

    /// Takes what is heard in the next moment.
    fn listen(&mut self, session: &mut Session) -> Result<(), LinkError> {
        let until = Instant::now() + SLICE;
        while let Some(heard) = session.hear(until)? {
            self.take(session, &heard);
            if Instant::now() >= until {
                break;
            }
        }
        Ok(())
    }

    fn take(&mut self, session: &Session, heard: &Heard) {
        let marks = self.stream.take(heard);
        let kept =
            self.recorder.as_mut().map_or(Ok(()), |(_, recorder)| recorder.take(heard, &marks));
        self.check_disk(kept);
        let interval_s = match self.start().source {
            Source::Converter => session.interval_s(),
            Source::Link { interval_ns } => f64::from(interval_ns) * 1e-9,
        };
        let store = Arc::clone(&self.store);
        let mut store = lock(&store);
        for mark in marks {
            if breaks_history(mark) {
                self.foretelling.begin(&mut store.bench.foretold);
            }
            note(&mut store, mark, interval_s);
        }
        store.health.tally = *self.stream.tally();
        store.health.backlog = (session.backlog().now(), session.backlog().most());
        if let Some((file, recorder)) = &self.recorder {
            store.health.recording = Some((file.clone(), recorder.rows));
        }
        let Ok((_, said)) = &heard.said else { return };
        self.heard_at = heard.at;
        match said {
            Said::Rows(rows) => match session.rows(rows) {
                Some(rows) => {
                    if let Some(listener) = &mut self.listener {
                        listener.rows(&rows, heard.at);
                    }
                    store.take(&rows, interval_s);
                    self.show(&mut store, &rows, interval_s);
                    let filter = &session.settings().1.relaxation;
                    let times = (interval_s, store.now_s());
                    self.foretelling.take(&rows, times, filter, &mut store.bench.foretold);
                }
                None => store.say(format!("{} rows came before their settings", rows.len())),
            },
            Said::Status(status) => store.health.status(status),
            Said::Settings(generation, settings) => {
                store.bench.generation = *generation;
                store.health.set(settings);
            }
            Said::Hello(identity) => store.health.identify(identity),
            Said::Log(piece) => {
                self.log.take(piece);
                store.health.log = self.log.words();
            }
            Said::Event(felt) => {
                if let Some(listener) = &mut self.listener {
                    listener.event(felt);
                }
                store.say(felt_in_words(felt));
            }
            Said::Answer(_) | Said::Foreign { .. } | Said::Kept(_) | Said::Converter(..) => {}
            Said::Pulse { .. } => {}
        }
    }

    /// Shows the counts and the margin of rows.
    fn show(&mut self, store: &mut Store, rows: &[Row], interval_s: f64) {
        if let Some(counts) = self.counts.take(rows, interval_s) {
            store.bench.counts = Some((Instant::now(), counts));
        }
        let now_s = store.now_s();
        self.grasp.take(rows, now_s, &mut store.bench.readings, self.listener.as_deref_mut());
    }

    /// Puts in what is due of a trace.
    fn inject(&mut self, session: &mut Session) -> Result<(), LinkError> {
        let Some(replay) = self.replay.as_mut().filter(|_| self.wanted) else { return Ok(()) };
        let step = replay.step(session)?;
        let progress = replay.progress();
        lock(&self.store).health.replayed = Some(progress);
        match step {
            Step::On => Ok(()),
            Step::Gap => {
                self.drain(session)?;
                lock(&self.store).say("a gap in the trace; the filter begins anew behind it");
                self.begin(session)
            }
            Step::Over => {
                self.drain(session)?;
                self.stop(session)?;
                lock(&self.store).say("the trace is over");
                Ok(())
            }
        }
    }

    /// Hears everything that was made of what was put in.
    fn drain(&mut self, session: &mut Session) -> Result<(), LinkError> {
        session.status()?;
        self.listen(session)?;
        self.listen(session)
    }

    /// Does what a page asks for, and says what became of it. A line that fails meanwhile ends the conversation.
    fn answer(&mut self, request: Request, session: &mut Session) -> Result<(), LinkError> {
        if let (Wish::Average(seconds), true) = (&request.wish, self.wanted) {
            // Answered when its time is over; meanwhile all goes on.
            self.counts.average(*seconds, request.answer);
            return Ok(());
        }
        let outcome = self.carry_out(&request.wish, session);
        let (answer, result) = match outcome {
            Ok(result) => {
                let command = command(&request.wish, &self.port.to_string_lossy());
                (Ok(json!({ "command": command, "result": result })), Ok(()))
            }
            Err(Trouble::Words(words)) => (Err(words), Ok(())),
            Err(Trouble::Link(error)) => {
                let words = error.to_string();
                let alive = matches!(error, LinkError::Refused(_) | LinkError::Unsuited(_));
                (Err(words), if alive { Ok(()) } else { Err(error) })
            }
        };
        // A page that has gone away needs no answer.
        let _ = request.answer.send(answer);
        result
    }

    fn carry_out(&mut self, wish: &Wish, session: &mut Session) -> Result<Value, Trouble> {
        match wish {
            Wish::Start if self.wanted => {}
            Wish::Start => self.begin(session)?,
            Wish::Stop => self.stop(session)?,
            Wish::Tare => self.command(session, &ToDevice::Tare, "zero is read from here on")?,
            Wish::Untare => self.command(session, &ToDevice::Untare, "the tare is taken back")?,
            Wish::Record { file, together } => self.begin_recording(file, *together, session)?,
            Wish::EndRecording => self.end_recording(),
            Wish::Set(setting) => return self.set(setting, session),
            Wish::SelfTest => return self.test(session),
            Wish::Average(_) => {
                return Err(Trouble::Words(
                    "the stream is stopped; start it to read counts".into(),
                ));
            }
            Wish::Fit(basis) => {
                return calibration(basis, &session.settings().1.calibration).map(|(_, told)| told);
            }
            Wish::Calibrate(basis) => return self.calibrate(basis, session),
            Wish::Grasp(holding) => {
                self.grasp.watch(holding.as_ref()).map_err(Trouble::Words)?;
                let mut store = lock(&self.store);
                store.bench.holding = self.grasp.json();
                store.bench.readings.clear();
            }
        }
        Ok(Value::Null)
    }

    fn command(
        &self,
        session: &mut Session,
        command: &ToDevice<'_>,
        words: &str,
    ) -> Result<(), Trouble> {
        session.command(command)?;
        lock(&self.store).say(words);
        Ok(())
    }

    /// A recording begins with who the device is and its settings, so the stream begins anew.
    fn begin_recording(
        &mut self,
        file: &str,
        together: bool,
        session: &mut Session,
    ) -> Result<(), Trouble> {
        let file = file_name(file).map_err(Trouble::Words)?;
        if let Some((other, _)) = &self.recorder {
            return Err(Trouble::Words(format!("{other} is being recorded")));
        }
        let path = self.folder.join(&file);
        let (hand, device) = &self.hand;
        let begun = match together {
            true => Recorder::join(&path, hand, *device),
            false => Recorder::create(&path, &self.port.to_string_lossy()),
        };
        let recorder = begun.map_err(|error| {
            Trouble::Words(match error.kind() {
                std::io::ErrorKind::AlreadyExists => {
                    format!("{file} is there already; take another name")
                }
                _ => format!("{file}: {error}"),
            })
        })?;
        self.begin(session)?;
        lock(&self.store).say(format!("recording into {file}"));
        self.recorder = Some((file, recorder));
        Ok(())
    }

    fn end_recording(&mut self) {
        let Some((file, recorder)) = self.recorder.take() else { return };
        let rows = recorder.rows;
        let closed = recorder.close();
        let mut store = lock(&self.store);
        store.health.recording = None;
        match closed {
            Ok(()) => store.say(format!("{file} is written, {rows} rows")),
            Err(error) => store.say(format!("{file} ends early: {error}")),
        }
    }

    /// A disk that takes no more ends the recording, not the session.
    fn check_disk(&mut self, kept: std::io::Result<()>) {
        let Err(error) = kept else { return };
        let Some((file, _)) = self.recorder.take() else { return };
        let mut store = lock(&self.store);
        store.health.recording = None;
        store.say(format!("{file} ends early: {error}"));
    }

    fn note_gap(&mut self, gap: Gap) {
        let kept = self.recorder.as_mut().map_or(Ok(()), |(_, recorder)| recorder.gap(gap));
        self.check_disk(kept);
    }

    /// The device went away.
    fn lose(&mut self, error: &LinkError) {
        self.note_gap(Gap::LinkLost);
        self.counts.end("the device is gone; waiting for it");
        let mut store = lock(&self.store);
        store.health.gaps += 1;
        (store.health.linked, store.health.streaming) = (false, false);
        store.health.trouble = Some(error.to_string());
        store.say(format!("the device is gone: {error}"));
    }

    /// Answers everybody that there is no device.
    fn refuse(&self) {
        while let Ok(request) = self.requests.try_recv() {
            let _ = request.answer.send(Err("the device is gone; waiting for it".into()));
        }
    }
}

/// Why a wish was not carried out.
pub(super) enum Trouble {
    Words(String),
    Link(LinkError),
}

impl From<LinkError> for Trouble {
    fn from(error: LinkError) -> Self {
        Self::Link(error)
    }
}

/// Whether what comes next does not go on from what was felt before: rows are missing, or a tare moves the zero.
const fn breaks_history(mark: Mark) -> bool {
    matches!(mark, Mark::RowsLost { .. } | Mark::Reset | Mark::Settings { .. })
}

/// What is missing, as a stretch of time.
fn note(store: &mut Store, mark: Mark, interval_s: f64) {
    let now_s = store.now_s();
    let gap = |to_s, words| Event::Gap { from_s: now_s, to_s, words };
    let event = match mark {
        Mark::RowsLost { count, .. } => {
            gap(now_s + count as f64 * interval_s, format!("{count} rows lost"))
        }
        Mark::FramesLost(frames) => gap(now_s, format!("{frames} frames lost")),
        Mark::Reset => {
            store.begin_stream();
            gap(now_s, "the device began anew".into())
        }
        // The frame after it will be missing; other settings are said by whoever set them.
        Mark::Damaged(_) | Mark::Settings { .. } => return,
    };
    store.health.gaps += 1;
    store.happen(event);
}

/// What a page gets for a wish that nobody can carry out any more.
pub(super) fn ended() -> Result<Value, String> {
    Err("the session has ended".into())
}
