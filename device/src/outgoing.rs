//! What is to be sent, in which order.

use heapless::Deque;
use shared::wire::Answer;

/// Answers that may wait.
const ANSWERS: usize = 4;

/// Messages that are due; blocks and log have their own queues.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outgoing {
    pub(crate) hello: bool,
    pub(crate) settings: bool,
    pub(crate) status: bool,
    answers: Deque<Answer, ANSWERS>,
}

impl Outgoing {
    pub(crate) const fn new() -> Self {
        Self { hello: false, settings: false, status: false, answers: Deque::new() }
    }

    /// Whether there is room for one more answer.
    pub(crate) fn has_room(&self) -> bool {
        !self.answers.is_full()
    }

    /// Queues an answer; dropped without room, which [`Self::has_room`] tells beforehand.
    pub(crate) fn answer(&mut self, answer: Answer) {
        let _ = self.answers.push_back(answer);
    }

    pub(crate) fn next_answer(&mut self) -> Option<Answer> {
        self.answers.pop_front()
    }

    pub(crate) fn is_empty(&self) -> bool {
        !(self.hello || self.settings || self.status) && self.answers.is_empty()
    }
}
