//! What is to be sent, in which order.

use heapless::Deque;
use shared::wire::Answer;

/// Answers that may wait.
const ANSWERS: usize = 4;

/// Messages of which one at most is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Due {
    Hello = 1,
    Settings = 1 << 1,
    Status = 1 << 2,
    Kept = 1 << 4,
    Capabilities = 1 << 5,
    Pulse = 1 << 6,
}

const AN_ANSWER: u8 = 1 << 3;

/// Messages that are due; blocks and log have their own queues.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outgoing {
    /// A bit for each [`Due`] and for the answers, because after every sample it is asked whether there are any.
    due: u8,
    answers: Deque<Answer, ANSWERS>,
}

impl Outgoing {
    pub(crate) const fn new() -> Self {
        Self { due: 0, answers: Deque::new() }
    }

    /// Whether there is room for one more answer.
    pub(crate) fn has_room(&self) -> bool {
        !self.answers.is_full()
    }

    /// Queues an answer; dropped without room, which [`Self::has_room`] tells beforehand.
    pub(crate) fn answer(&mut self, answer: Answer) {
        let _ = self.answers.push_back(answer);
        self.due |= AN_ANSWER;
    }

    pub(crate) fn next_answer(&mut self) -> Option<Answer> {
        let answer = self.answers.pop_front();
        if self.answers.is_empty() {
            self.due &= !AN_ANSWER;
        }
        answer
    }

    /// From now on this is due.
    pub(crate) const fn ask(&mut self, message: Due) {
        self.due |= message as u8;
    }

    pub(crate) const fn is_due(&self, message: Due) -> bool {
        self.due & message as u8 != 0
    }

    /// Whether it was due; it no longer is.
    pub(crate) const fn take(&mut self, message: Due) -> bool {
        let due = self.is_due(message);
        self.due &= !(message as u8);
        due
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.due == 0
    }
}
