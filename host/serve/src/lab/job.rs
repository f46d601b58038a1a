//! A task at work on threads of its own.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use serde_json::{Value, json};

use super::error::LabError;
use super::task::Task;
use super::work::{Bench, Outcome, run};
use palpate_fit::watch::{Watch, under};

/// A task at work.
pub struct Job {
    task: Task,
    /// The command that does the same.
    pub command: String,
    /// Name of the model file that it writes.
    pub written: String,
    begun: Instant,
    watch: Arc<Watch>,
    thread: JoinHandle<Result<Outcome, LabError>>,
}

impl Job {
    /// Sets a task to work.
    #[must_use]
    pub fn new(task: Task, bench: Bench) -> Self {
        let watch = Arc::new(Watch::default());
        let (own, asked) = (watch.clone(), task.clone());
        let (command, written) = (bench.command.clone(), bench.written.clone());
        let thread = std::thread::spawn(move || {
            let outcome = under(&own, || run(&asked, &bench))?;
            if own.ended() { Err(LabError::Cancelled) } else { outcome }
        });
        Self { task, command, written, begun: Instant::now(), watch, thread }
    }

    /// What is asked for.
    #[must_use]
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// Whether there is an outcome.
    #[must_use]
    pub fn done(&self) -> bool {
        self.thread.is_finished()
    }

    /// Gives it up. Its threads end by themselves, at the next step of a search.
    pub fn cancel(&self) {
        self.watch.end();
    }

    /// The outcome, waited for.
    ///
    /// # Errors
    /// What the command would say, or that it was cancelled.
    pub fn outcome(self) -> Result<Outcome, LabError> {
        self.thread.join().unwrap_or(Err(LabError::BrokeOff))
    }

    /// How far it is.
    #[must_use]
    pub fn json(&self) -> Value {
        let (searches, steps) = self.watch.progress();
        let stage = self.watch.stage();
        let stage = stage.map(|s| json!({"what": s.what, "of": s.of, "done": s.done}));
        json!({
            "what": self.task.in_words(),
            "command": self.command,
            "seconds": self.begun.elapsed().as_secs_f64(),
            "searches": searches,
            "steps": steps,
            "stage": stage,
        })
    }
}
