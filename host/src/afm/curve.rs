//! A force curve, however it was recorded.

use std::ops::Range;
use std::path::Path;

use super::{AfmError, jpk};
use crate::trace::{self, DISPLACEMENT, FORCE, Trace};

/// Which samples are what.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Segments {
    /// From far off into the specimen.
    pub approach: Range<usize>,
    /// At rest on the specimen.
    pub hold: Option<Range<usize>>,
    /// Back off the specimen.
    pub retract: Option<Range<usize>>,
}

/// A force curve; all vectors are of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceCurve {
    /// What to call it.
    pub label: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Way of the piezo towards the specimen, m, from any zero.
    pub piezo_m: Vec<f64>,
    /// Force on the tip, N, from any zero; pushing is positive.
    pub force_n: Vec<f64>,
    /// Spring constant of the cantilever, N/m; none where the way is that of the tip itself.
    pub spring_n_per_m: Option<f64>,
    /// What its stretches are.
    pub segments: Segments,
    /// What was taken from where.
    pub notes: Vec<String>,
}

/// Key in the table `[setup]` of a trace's head: spring constant, N/m.
pub const SPRING: &str = "spring_constant_N_per_m";
/// The piezo rests where it is within this part of its travel from its farthest.
const REST: f64 = 0.005;
/// A rest is a hold if it lasts this part of the recording.
const SHORTEST_HOLD: f64 = 0.05;

impl ForceCurve {
    /// Reads a text export of JPK, or a trace.
    ///
    /// # Errors
    /// [`AfmError`] for what cannot be read.
    pub fn read(path: &Path) -> Result<Self, AfmError> {
        let bytes =
            std::fs::read(path).map_err(|source| AfmError::Io { path: path.into(), source })?;
        match std::str::from_utf8(&bytes) {
            Ok(text) if jpk::is_export(text) => {
                let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
                jpk::parse(&name.unwrap_or_default(), text)
            }
            _ => Self::of(&trace::read(path)?),
        }
    }

    /// Takes a trace: its displacement is the way of the piezo if its head (`[setup] spring_constant_N_per_m`) states a spring
    /// constant, else that of the tip.
    ///
    /// # Errors
    /// [`AfmError::NoColumn`].
    pub fn of(trace: &Trace) -> Result<Self, AfmError> {
        let column = |name: &'static str| {
            let missing = || AfmError::NoColumn { curve: trace.label(), column: name };
            trace.column(name).ok_or_else(missing)
        };
        let piezo_m: Vec<f64> = column(DISPLACEMENT)?.iter().map(|mm| mm * 1e-3).collect();
        let force_n = column(FORCE)?.to_vec();
        let spring = trace.head.setup.other.get(SPRING);
        let spring = spring.and_then(|k| k.as_float().or(k.as_integer().map(|k| k as f64)));
        let spring = spring.filter(|k| *k > 0.0);
        let note = match spring {
            Some(k) => format!("spring constant of the head: {k} N/m"),
            None => "no spring constant: the displacement is taken as that of the tip".into(),
        };
        Ok(Self {
            label: trace.label(),
            segments: segments(&trace.time, &piezo_m),
            time_s: trace.time.clone(),
            piezo_m,
            force_n,
            spring_n_per_m: spring,
            notes: vec![note],
        })
    }

    /// The same curve with another spring constant, N/m.
    #[must_use]
    pub fn with_spring(mut self, spring_n_per_m: f64) -> Self {
        self.spring_n_per_m = Some(spring_n_per_m);
        self.notes.push(format!("spring constant as told: {spring_n_per_m} N/m"));
        self
    }
}

/// The approach goes until the piezo is nearest; if it rests there for long, that is a hold.
fn segments(time: &[f64], piezo: &[f64]) -> Segments {
    let bounds = piezo
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
    let near = |x: &f64| *x >= bounds.1 - REST * (bounds.1 - bounds.0);
    let count = piezo.len();
    let first = piezo.iter().position(near).unwrap_or(count);
    let last = piezo.iter().rposition(near).unwrap_or(first);
    if first >= count {
        return Segments::default();
    }
    let rested = time[last] - time[first] > SHORTEST_HOLD * (time[count - 1] - time[0]);
    let (top, hold) = if rested {
        (first, Some(first..last + 1))
    } else {
        let nearest = (first..=last).max_by(|a, b| piezo[*a].total_cmp(&piezo[*b]));
        (nearest.unwrap_or(first), None)
    };
    let back = hold.as_ref().map_or(top + 1, |hold| hold.end);
    Segments { approach: 0..top + 1, hold, retract: (back + 1 < count).then_some(back..count) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rest_at_the_nearest_is_a_hold_and_a_turn_is_none() {
        let time: Vec<f64> = (0..300).map(f64::from).collect();
        let held: Vec<f64> = time.iter().map(|t| t.min(100.0).min(300.0 - t)).collect();
        let found = segments(&time, &held);
        assert_eq!(found.approach, 0..101);
        assert_eq!(found.hold, Some(100..201));
        assert_eq!(found.retract, Some(201..300));
        let turned: Vec<f64> = time.iter().map(|t| t.min(300.0 - t)).collect();
        let found = segments(&time, &turned);
        assert_eq!((found.approach, found.hold, found.retract), (0..151, None, Some(151..300)));
    }
}
