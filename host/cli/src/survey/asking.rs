//! A single command as the question of a survey.

use std::sync::Arc;

use crate::Failure;
use crate::answer::Answer;
use palpate_survey::Group;
use palpate_survey::row::Asked;
use palpate_survey::run::{self, Question};
use palpate_trace::Trace;

/// What the command does to the traces of a group.
type Ask<'a> = dyn Fn(&Group, Arc<Vec<Trace>>) -> Result<Box<dyn Answer>, Failure> + Sync + 'a;

/// A single command.
pub struct Asking<'a> {
    asked: Asked,
    ask: Box<Ask<'a>>,
}

impl<'a> Asking<'a> {
    /// That command, by what it does.
    pub fn new(
        asked: Asked,
        ask: impl Fn(&Group, Arc<Vec<Trace>>) -> Result<Box<dyn Answer>, Failure> + Sync + 'a,
    ) -> Self {
        Self { asked, ask: Box::new(ask) }
    }
}

impl Question for Asking<'_> {
    fn asked(&self) -> Asked {
        self.asked
    }

    fn answer(&self, group: &Group, traces: Vec<Trace>) -> run::Answer {
        match (self.ask)(group, Arc::new(traces)) {
            Ok(found) => run::Answer::Found {
                answer: found.json(),
                failed: found.failed(),
                remarks: found.remarks(),
            },
            Err(failure @ Failure::Input(_)) => run::Answer::Refused(failure.words()),
            Err(failure @ Failure::Work(_)) => run::Answer::Failed(failure.words()),
        }
    }
}
