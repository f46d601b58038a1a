//! The groups of a survey side by side: one thread a group, whatever happens in it.

use std::io;
use std::num::NonZeroUsize;
use std::panic::AssertUnwindSafe;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use serde_json::Value;

use super::feed::Feed;
use super::group::Group;
use super::row::{Asked, Row, Said, Status, Worked};
use palpate_fit::watch::{Watch, alone, ended};
use palpate_trace::caught::caught;
use palpate_trace::many::Names;
use palpate_trace::{self as trace, Trace};

/// How often a group is tried that gives up in the middle.
const ATTEMPTS: u64 = 2;

/// What a single command says of the traces of a group.
#[derive(Clone, Debug)]
pub enum Answer {
    /// There is one.
    Found {
        /// The object that it prints with `--json`.
        answer: Value,
        /// Why the work failed nevertheless.
        failed: Option<String>,
        /// What it says aside.
        remarks: Vec<String>,
    },
    /// The traces or the wish cannot be used, with the reason.
    Refused(String),
    /// The work failed, with the reason.
    Failed(String),
}

/// What is asked of each group.
pub trait Question: Sync {
    /// Which command it is.
    fn asked(&self) -> Asked;

    /// The answer for the traces of one group.
    fn answer(&self, group: &Group, traces: Vec<Trace>) -> Answer;
}

/// Asks the groups in their order, `jobs` of them at a time, and gives each row to `done` as soon as it is there, in any order.
/// `names` are those of the columns of traces that lie in one file.
///
/// # Errors
/// What `done` or the system that gives no threads answers, and when the work is asked to end; then no further group is begun.
pub fn run(
    groups: impl Iterator<Item = Group> + Send,
    names: Names,
    question: &impl Question,
    jobs: NonZeroUsize,
    done: impl FnMut(Row, Worked) -> io::Result<()> + Send,
) -> io::Result<()> {
    let work = Work {
        groups: Mutex::new(groups),
        feed: Feed::new(names),
        done: Mutex::new(done),
        over: AtomicBool::new(false),
    };
    thread::scope(|scope| {
        // What is asked runs in parallel by itself where it can; here the groups do.
        let threads: Vec<_> = (0..jobs.get())
            .map(|_| Arc::new(Watch::within()))
            .map(|watch| {
                let work = &work;
                scope.spawn(move || {
                    alone(&watch, || work.until_done(question)).map_err(io::Error::other)?
                })
            })
            .collect();
        let ends = threads.into_iter().map(|thread| {
            thread.join().unwrap_or_else(|_| Err(io::Error::other("a thread of the survey ended")))
        });
        // All are waited for; the first error is told.
        ends.fold(Ok(()), Result::and)
    })
}

struct Work<G, D> {
    groups: Mutex<G>,
    feed: Feed,
    done: Mutex<D>,
    over: AtomicBool,
}

impl<G, D> Work<G, D>
where
    G: Iterator<Item = Group> + Send,
    D: FnMut(Row, Worked) -> io::Result<()> + Send,
{
    /// Takes one group after the other.
    fn until_done(&self, question: &impl Question) -> io::Result<()> {
        while let Some((group, rows)) = self.next() {
            let begun = cpu_seconds();
            let (row, attempts) = row(&group, rows, question);
            let worked = Worked { seconds: cpu_seconds() - begun, attempts };
            if ended() {
                // What comes out of work that was ended means nothing.
                return Err(io::ErrorKind::Interrupted.into());
            }
            let told = (self.done.lock().unwrap_or_else(PoisonError::into_inner))(row, worked);
            if told.is_err() {
                self.over.store(true, Ordering::Relaxed);
                return told;
            }
        }
        Ok(())
    }

    fn next(&self) -> Option<(Group, Result<Vec<Trace>, trace::Error>)> {
        let mut groups = self.groups.lock().unwrap_or_else(PoisonError::into_inner);
        if self.over.load(Ordering::Relaxed) {
            return None;
        }
        let group = groups.next()?;
        let rows = self.feed.rows(&group);
        Some((group, rows))
    }
}

/// The row of a group, and how often it was tried.
fn row(
    group: &Group,
    rows: Result<Vec<Trace>, trace::Error>,
    question: &impl Question,
) -> (Row, u64) {
    let mut row = Row {
        group: group.number,
        key: group.key.clone(),
        status: Status::Refused,
        reason: None,
        traces: 0,
        samples: 0,
        said: Said::default(),
    };
    let traces = match rows.and_then(|rows| Feed::whole(group, rows)) {
        Ok(traces) => traces,
        Err(error) => {
            row.reason = Some(error.to_string());
            return (row, 1);
        }
    };
    row.traces = traces.len() as u64;
    row.samples = traces.iter().map(|trace| trace.len() as u64).sum();
    let (answer, attempts) = asked(group, traces, question);
    match answer {
        Answer::Found { answer, failed, remarks } => {
            row.status = if failed.is_some() { Status::Failed } else { Status::Done };
            row.reason = failed;
            row.said = Said::of(question.asked(), &answer);
            row.said.warnings.extend(remarks);
        }
        Answer::Refused(reason) => row.reason = Some(reason),
        Answer::Failed(reason) => (row.status, row.reason) = (Status::Failed, Some(reason)),
    }
    (row, attempts)
}

/// Asks, and once more where the work gave up.
fn asked(group: &Group, traces: Vec<Trace>, question: &impl Question) -> (Answer, u64) {
    let mut kept = Some(traces);
    for attempt in 1..=ATTEMPTS {
        let given = if attempt < ATTEMPTS { kept.clone() } else { kept.take() };
        let work = || question.answer(group, given.unwrap_or_default());
        match caught(AssertUnwindSafe(work)) {
            Ok(answer) => return (answer, attempt),
            Err(said) if attempt == ATTEMPTS => {
                return (Answer::Failed(format!("gave up {ATTEMPTS} times: {said}")), attempt);
            }
            Err(said) => tracing::info!("group {} is tried again: {said}", group.number),
        }
    }
    (Answer::Failed("was not tried".into()), 0)
}

/// Processor time of this thread, s.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Where the system tells no processor time of a thread: the time on the clock, s.
#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    use std::sync::OnceLock;
    use std::time::Instant;
    static BEGUN: OnceLock<Instant> = OnceLock::new();
    BEGUN.get_or_init(Instant::now).elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::group::Place;
    use serde_json::json;
    use std::collections::BTreeMap;
    use std::sync::atomic::AtomicU64;

    /// Answers by the number of the group: every third gives up, once or always.
    struct Moody {
        tried: [AtomicU64; 12],
    }

    impl Question for Moody {
        fn asked(&self) -> Asked {
            Asked::Fit
        }

        fn answer(&self, group: &Group, traces: Vec<Trace>) -> Answer {
            let tried = self.tried[group.number as usize].fetch_add(1, Ordering::Relaxed);
            match group.number % 6 {
                2 => panic!("poisoned"),
                5 if tried == 0 => panic!("in a bad mood"),
                4 => Answer::Refused("no contact".into()),
                _ => {
                    let answer = json!({"residual_rms": traces[0].len()});
                    Answer::Found { answer, failed: None, remarks: Vec::new() }
                }
            }
        }
    }

    fn asked(folder: &std::path::Path, jobs: usize) -> BTreeMap<u64, (Row, u64)> {
        let groups = (0..12).map(|number| {
            let path = folder.join(format!("{number}.csv"));
            if number != 7 {
                std::fs::write(&path, "time_s,force_N\n0,1\n1,2\n").unwrap();
            }
            Group { number, key: vec![Some(number.to_string())], places: vec![Place::File(path)] }
        });
        let moody = Moody { tried: Default::default() };
        let mut rows = BTreeMap::new();
        let done = |row: Row, worked: Worked| {
            assert!(rows.insert(row.group, (row, worked.attempts)).is_none());
            Ok(())
        };
        run(groups, Names::default(), &moody, NonZeroUsize::new(jobs).unwrap(), done).unwrap();
        rows
    }

    #[test]
    fn a_group_that_gives_up_is_tried_once_more_and_becomes_its_row() {
        let folder = tempfile::tempdir().unwrap();
        let rows = asked(folder.path(), 3);
        assert_eq!(rows.len(), 12);
        let told = |number| {
            let (row, attempts): &(Row, u64) = &rows[&number];
            (row.status, row.reason.as_deref().unwrap_or(""), *attempts)
        };
        assert_eq!(told(0), (Status::Done, "", 1));
        assert_eq!(told(5), (Status::Done, "", 2));
        assert_eq!(told(4), (Status::Refused, "no contact", 1));
        let (status, reason, attempts) = told(2);
        assert_eq!((status, attempts), (Status::Failed, 2));
        assert!(reason.starts_with("gave up 2 times: poisoned (run.rs:"), "{reason}");
        let (status, reason, _) = told(7);
        assert!(status == Status::Refused && reason.contains("7.csv"), "{reason}");
        assert_eq!(rows, asked(folder.path(), 1));
    }

    #[test]
    fn what_cannot_be_kept_ends_the_survey() {
        let group = |number| Group { number, key: Vec::new(), places: Vec::new() };
        let begun = AtomicU64::new(0);
        let groups = (0..100).map(|number| {
            begun.fetch_add(1, Ordering::Relaxed);
            group(number)
        });
        let moody = Moody { tried: Default::default() };
        let full = |_, _| Err(io::Error::other("disk full"));
        let error = run(groups, Names::default(), &moody, NonZeroUsize::MIN, full).unwrap_err();
        assert_eq!(error.to_string(), "disk full");
        assert_eq!(begun.load(Ordering::Relaxed), 1);
    }
}
