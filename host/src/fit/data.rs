//! Measurements as a fit takes them: motions with the signal that answered.

use crate::model::{Motion, MotionError};
use crate::trace::{SignalError, Trace, runs};

/// One stretch of recording without a gap, with its motion.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Which trace of the set it is from.
    pub trace: usize,
    /// What was done.
    pub motion: Motion,
    /// What was measured at each sample.
    pub measured: Vec<f64>,
}

/// A data set: traces of one specimen in one set-up, in order of recording.
#[derive(Clone, Debug)]
pub struct Data {
    /// Name of each trace.
    pub labels: Vec<String>,
    /// The stretches, in order of recording.
    pub pieces: Vec<Piece>,
    /// Stretches that were left out, in words.
    pub left_out: Vec<String>,
}

/// Why traces cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum DataError {
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error("{trace} never reaches the specimen: its displacement stays at or below 0")]
    NoContact { trace: String },
    #[error("{samples} samples for {parameters} parameters: record more, or fit fewer terms")]
    TooFew { samples: usize, parameters: usize },
    #[error(
        "nothing left to fit: every stretch begins in contact after a gap, so what the specimen remembers is unknown"
    )]
    NothingLeft,
}

impl Data {
    /// Takes `signal` and the motion from the traces of a set, in order of recording.
    ///
    /// Nothing is interpolated across a gap: the stretch after it is taken as a recording of its own
    /// where it begins off the specimen, and left out where it begins in contact.
    ///
    /// # Errors
    /// When a trace lacks the signal or a motion, is constant, or never reaches the specimen.
    pub fn of(traces: &[Trace], signal: &str) -> Result<Self, DataError> {
        let motions = Motion::of_set(traces)?;
        let mut data = Self {
            labels: traces.iter().map(Trace::label).collect(),
            pieces: Vec::new(),
            left_out: Vec::new(),
        };
        for (index, (trace, motion)) in traces.iter().zip(motions).enumerate() {
            let measured = trace.changing(signal)?;
            if motion.largest_compression() <= 0.0 {
                return Err(DataError::NoContact { trace: trace.label() });
            }
            data.add(index, trace, &motion, measured);
        }
        if data.pieces.is_empty() { Err(DataError::NothingLeft) } else { Ok(data) }
    }

    fn add(&mut self, index: usize, trace: &Trace, motion: &Motion, measured: &[f64]) {
        for (number, run) in runs(&trace.time).into_iter().enumerate() {
            let displacement = motion.displacement[run.clone()].to_vec();
            if number > 0 && displacement[0] > 0.0 {
                self.left_out.push(format!(
                    "{}: from {:.3} s on, {} samples after a gap begin in contact, so what the specimen remembers is unknown; they are left out",
                    trace.label(),
                    trace.time[run.start],
                    run.len(),
                ));
                continue;
            }
            let motion = Motion {
                time: motion.time[run.clone()].to_vec(),
                displacement,
                rest_before: if number == 0 { motion.rest_before } else { None },
            };
            self.pieces.push(Piece { trace: index, motion, measured: measured[run].to_vec() });
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.pieces.iter().map(|piece| piece.measured.len()).sum()
    }

    /// Largest compression of the set, mm.
    #[must_use]
    pub fn largest_compression(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.motion.largest_compression()).fold(0.0, f64::max)
    }

    /// Longest stretch, s.
    #[must_use]
    pub fn longest(&self) -> f64 {
        let duration = |piece: &Piece| {
            let time = &piece.motion.time;
            time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first)
        };
        self.pieces.iter().map(duration).fold(0.0, f64::max)
    }

    /// Shortest interval between samples, s.
    #[must_use]
    pub fn shortest_interval(&self) -> f64 {
        let intervals = |piece: &Piece| {
            piece.motion.time.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
        };
        self.pieces.iter().map(intervals).fold(f64::INFINITY, f64::min)
    }
}
