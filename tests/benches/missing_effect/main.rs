//! How often the missing effect is named, on data sets of the independent simulator.
//!
//! `cargo bench -p palpate-tests --bench missing_effect -- --sets 100 --only reference-1`

mod answer;
mod cpu;
mod groups;
mod score;
mod share;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use palpate_tests::hidden::folder;

use groups::{GROUPS, Group};
use score::Outcome;

/// Names the missing effect of simulated data sets and counts.
#[derive(Parser)]
struct Call {
    /// Data sets in each group.
    #[arg(long, default_value_t = 60)]
    sets: usize,
    /// Only the groups whose name begins so.
    #[arg(long)]
    only: Option<String>,
    /// Seed of all data sets.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Data sets diagnosed at the same time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// One line of CSV for each data set.
    #[arg(long)]
    lines: bool,
    /// Writes the data sets and truth.json into this folder.
    #[arg(long)]
    dump: Option<PathBuf>,
    /// Given by `cargo bench`.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let call = Call::parse();
    let wanted =
        |group: &&Group| call.only.as_ref().is_none_or(|only| group.name.starts_with(only));
    let mut all = Vec::new();
    if call.lines {
        println!("{}", Outcome::HEADER);
    }
    for group in GROUPS.iter().filter(wanted) {
        let outcomes = run(group, &call);
        if call.lines {
            outcomes.iter().for_each(|outcome| println!("{}", outcome.line()));
        }
        if let Some(folder) = &call.dump {
            write_truth(folder, all.iter().flatten().chain(&outcomes))?;
        }
        all.push(outcomes);
    }
    let all: Vec<Outcome> = all.into_iter().flatten().collect();
    println!("seed {}, {} sets a group, {} thread(s)\n", call.seed, call.sets, call.threads);
    score::print(&all);
    Ok(())
}

fn write_truth<'a>(
    folder: &Path,
    outcomes: impl Iterator<Item = &'a Outcome>,
) -> Result<(), Box<dyn Error>> {
    folder::write_truth(folder, outcomes.map(|outcome| (&outcome.name[..], &outcome.truth)))
}

/// Generates and diagnoses the sets of a group; the same whatever the number of threads.
fn run(group: &Group, call: &Call) -> Vec<Outcome> {
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..call.threads.max(1) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= call.sets {
                        return;
                    }
                    let (set, fresh) = group.set(call.seed, index);
                    let outcome = Outcome::of(group, index, &set, &fresh);
                    if let Some(folder) = &call.dump {
                        folder::write_traces(&folder.join(&outcome.name), &set)
                            .expect("the folder can be written");
                    }
                    done.lock().expect("no thread panicked").push((index, outcome));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no thread panicked");
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, outcome)| outcome).collect()
}
