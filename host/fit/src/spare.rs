//! Vectors that are used again: a long one that is made anew costs more to clear than to fill.

use std::sync::{Mutex, PoisonError};

/// Empty vectors with room.
#[derive(Debug, Default)]
pub struct Spare(Mutex<Vec<Vec<f64>>>);

impl Spare {
    /// One with room, if there is one.
    pub fn take(&self) -> Vec<f64> {
        let mut vector = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        vector.iter_mut().for_each(Vec::clear);
        vector.unwrap_or_default()
    }

    /// Takes vectors back.
    pub fn give(&self, vectors: impl IntoIterator<Item = Vec<f64>>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(vectors);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_back_is_taken_again_empty_with_its_room() {
        let spare = Spare::default();
        assert_eq!(spare.take().capacity(), 0);
        spare.give([vec![1.0; 500]]);
        let again = spare.take();
        assert!(again.is_empty() && again.capacity() >= 500);
    }
}
