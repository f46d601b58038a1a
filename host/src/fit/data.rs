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
    #[error("no trace reaches the specimen: displacement stays at or below 0")]
    NoContact,
    #[error(
        "{signal} is negative while the specimen is pressed (mean {mean:.3e}): compression counts as positive; turn the sign with `negate = true` in `palpate import`"
    )]
    Negative { signal: String, mean: f64 },
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
    /// When a trace lacks the signal or a motion or is constant, when no trace reaches the specimen, or
    /// the signal is negative in compression.
    pub fn of(traces: &[Trace], signal: &str) -> Result<Self, DataError> {
        let motions = Motion::of_set(traces)?;
        let mut data = Self {
            labels: traces.iter().map(Trace::label).collect(),
            pieces: Vec::new(),
            left_out: Vec::new(),
        };
        for (index, (trace, motion)) in traces.iter().zip(motions).enumerate() {
            let measured = trace.changing(signal)?;
            data.add(index, trace, &motion, measured);
        }
        if data.pieces.is_empty() {
            return Err(DataError::NothingLeft);
        }
        data.check_contact(signal)?;
        Ok(data)
    }

    /// The specimen is pressed somewhere, and pushes back.
    fn check_contact(&self, signal: &str) -> Result<(), DataError> {
        let (mut sum, mut count) = (0.0, 0.0);
        for piece in &self.pieces {
            for (&x, &value) in piece.motion.displacement.iter().zip(&piece.measured) {
                if x > 0.0 {
                    sum += value;
                    count += 1.0;
                }
            }
        }
        if count == 0.0 {
            Err(DataError::NoContact)
        } else if sum < 0.0 {
            Err(DataError::Negative { signal: signal.into(), mean: sum / count })
        } else {
            Ok(())
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::{Column, DISPLACEMENT, FORCE};

    /// A trace over whole seconds.
    fn trace(time: &[f64], displacement: &[f64], force: &[f64]) -> Trace {
        let column =
            |name: &str, values: &[f64]| Column { name: name.into(), values: values.into() };
        Trace {
            time: time.into(),
            columns: vec![column(DISPLACEMENT, displacement), column(FORCE, force)],
            ..Trace::default()
        }
    }

    const TIMES: [f64; 9] = [0.0, 1.0, 2.0, 3.0, 4.0, 50.0, 51.0, 52.0, 53.0];

    #[test]
    fn a_stretch_after_a_gap_counts_where_it_begins_off_the_specimen() {
        let press = [0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0, 1.0];
        let data = Data::of(&[trace(&TIMES, &press, &press)], FORCE).unwrap();
        assert_eq!((data.pieces.len(), data.samples()), (2, 9));
        assert!(data.left_out.is_empty());
        let held = [0.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0, 0.0];
        let data = Data::of(&[trace(&TIMES, &held, &held)], FORCE).unwrap();
        assert_eq!((data.pieces.len(), data.samples()), (1, 5));
        assert!(data.left_out[0].contains("4 samples after a gap"), "{:?}", data.left_out);
    }

    #[test]
    fn a_stroke_without_contact_is_welcome_beside_others_but_not_alone() {
        let (time, press) = (&TIMES[..5], [0.0, 1.0, 2.0, 1.0, 0.0]);
        let stroke = trace(time, &[-3.0, -2.0, -1.0, -2.0, -3.0], &[0.0, 0.1, 0.0, 0.0, 0.1]);
        let pressed = trace(time, &press, &press);
        assert!(Data::of(&[stroke.clone(), pressed], FORCE).is_ok());
        assert!(matches!(Data::of(&[stroke], FORCE), Err(DataError::NoContact)));
    }

    #[test]
    fn a_force_of_the_wrong_sign_is_told_not_fitted() {
        let press = [0.0, 1.0, 2.0, 1.0, 0.0];
        let pull = press.map(|force| -force);
        let found = Data::of(&[trace(&TIMES[..5], &press, &pull)], FORCE);
        assert!(matches!(found, Err(DataError::Negative { .. })));
    }
}
