//! A device that dies while it is recorded.

use std::error::Error;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use palpate::device::record::{Beside, Plan, View, record};
use palpate::device::replay::inject;
use palpate::device::session::{LinkError, Session};
use palpate::recording::{Entry, Gap, Note, Reader};
use shared::pipeline::GAUGES;
use shared::wire::{Columns, INJECT_ROWS, Rows, Source, Start, ToHost};

use super::{Checked, Report, open, require};

/// Longest time until rows come.
const PATIENCE: Duration = Duration::from_secs(20);

/// Records while `restart` kills the device and starts it anew at the same path. The recording goes on, with the gap marked.
/// Rows are those of the converter, or are injected meanwhile if `source` says so.
///
/// # Errors
/// What is missing in the recording.
pub fn check_restart_while_recording(
    port: &Path,
    source: Source,
    file: &Path,
    restart: &mut dyn FnMut() -> Result<(), Box<dyn Error + Send + Sync>>,
) -> Checked {
    let session = open(port)?;
    let start = Start { source, columns: Columns::Parts };
    let plan = Plan { port: port.into(), start, duration: None };
    let (ended, rows) = (AtomicBool::new(false), AtomicU64::new(0));
    let mut beside = Feed { ended: &ended, rows: &rows, inject: source != Source::Converter };
    let some_rows = || {
        let before = rows.load(Ordering::Relaxed);
        wait_for(|| rows.load(Ordering::Relaxed) > before + 500)
    };
    let view = std::thread::scope(|scope| {
        let recording = scope.spawn(|| record(session, &plan, file, true, &mut beside));
        let outcome = some_rows().and_then(|()| restart()).and_then(|()| some_rows());
        ended.store(true, Ordering::Relaxed);
        let view = recording.join().map_err(|_| "the recording panicked")??;
        outcome.map(|()| view)
    })?;
    let (gaps, hellos, before, after) = contents(file)?;
    for mark in [Gap::LinkLost, Gap::LinkBack, Gap::Reset] {
        require(gaps.contains(&mark), || format!("no {mark:?} among the marks {gaps:?}"))?;
    }
    require(hellos >= 2 && before > 0 && after > 0, || {
        format!("{hellos} Hellos; {before} rows before and {after} after the reset")
    })?;
    Ok(Report::new("restart while recording")
        .with("rows before", before)
        .with("after", after)
        .with("in all", view.tally.rows)
        .with("marks", format!("{gaps:?}")))
}

/// Counts rows, and injects some where the converter gives none.
struct Feed<'a> {
    ended: &'a AtomicBool,
    rows: &'a AtomicU64,
    inject: bool,
}

impl Beside for Feed<'_> {
    fn ended(&mut self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    fn watch(&mut self, view: &View) {
        self.rows.store(view.tally.rows, Ordering::Relaxed);
    }

    fn command(&mut self, session: &mut Session) -> Result<(), LinkError> {
        if self.inject {
            inject(session, &[[1_000; GAUGES]; INJECT_ROWS], None)?;
        }
        Ok(())
    }
}

fn wait_for(held: impl Fn() -> bool) -> Result<(), Box<dyn Error + Send + Sync>> {
    let until = Instant::now() + PATIENCE;
    while Instant::now() < until {
        if held() {
            return Ok(());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Err("nothing came for 20 s".into())
}

/// Gaps, Hellos, and rows before and after the mark of the reset.
type Contents = (Vec<Gap>, usize, usize, usize);

fn contents(file: &Path) -> Result<Contents, Box<dyn Error + Send + Sync>> {
    let mut reader = Reader::open(file)?;
    let (mut gaps, mut hellos, mut before, mut after) = (Vec::new(), 0, 0, 0);
    while let Some(entry) = reader.next_entry()? {
        match entry {
            Entry::Note { note: Note::Gap(gap), .. } => gaps.push(gap),
            Entry::Note { .. } => {}
            Entry::Frame { head, message, .. } => {
                hellos += usize::from(matches!(message, ToHost::Hello(_)));
                if let ToHost::Samples(block) = message {
                    let reset = gaps.contains(&Gap::Reset);
                    *(if reset { &mut after } else { &mut before }) +=
                        Rows::decode(head, &block).map_or(0, |rows| rows.len());
                }
            }
        }
    }
    Ok((gaps, hellos, before, after))
}
