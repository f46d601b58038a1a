//! A force curve, however it was recorded.

use std::ops::Range;
use std::path::Path;

use super::{AfmError, jpk};
use palpate_trace::{self as trace, DISPLACEMENT, FORCE, Kind, Trace};

/// Which samples are what.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Segments {
    /// From far off into the specimen, with all pauses.
    pub approach: Range<usize>,
    /// The pauses of the piezo in it, in order.
    pub pauses: Vec<Range<usize>>,
    /// Back off the specimen; what comes in again after it is not looked at.
    pub retract: Option<Range<usize>>,
}

/// Column of a trace that says what the tip does: 0 on the way in, 1 in a pause, 2 on the way back.
pub const SEGMENT: &str = "afm_segment";

/// What the tip does for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stretch {
    Approach,
    Pause,
    Retract,
}

impl Stretch {
    /// What the number in [`SEGMENT`] stands for.
    fn of(number: f64) -> Option<Self> {
        let all = [(0.0, Self::Approach), (1.0, Self::Pause), (2.0, Self::Retract)];
        all.into_iter().find(|(code, _)| *code == number).map(|(_, stretch)| stretch)
    }
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
/// A rest is a pause if it lasts this part of the recording.
const SHORTEST_PAUSE: f64 = 0.05;

impl Segments {
    /// Of the stretches of a curve in their order, and whether the tip comes in again after its first way back: that is left out.
    pub(super) fn joined(
        stretches: impl IntoIterator<Item = (Stretch, Range<usize>)>,
    ) -> (Self, bool) {
        let (mut found, mut came_in) = (Self::default(), false);
        for (stretch, range) in stretches {
            match (stretch, &mut found.retract) {
                (Stretch::Approach, Some(_)) => return (found, true),
                (_, Some(back)) => back.end = range.end,
                (Stretch::Retract, back) => *back = Some(range),
                (stretch, None) => {
                    found.approach.end = range.end;
                    // A rest far off, before the tip comes in, is none on the specimen.
                    if stretch == Stretch::Pause && came_in {
                        found.pauses.push(range);
                    }
                    came_in |= stretch == Stretch::Approach;
                }
            }
        }
        (found, false)
    }
}

impl ForceCurve {
    /// Reads a text export of JPK, or a trace.
    ///
    /// # Errors
    /// [`AfmError`] for what cannot be read.
    pub fn read(path: &Path) -> Result<Self, AfmError> {
        exported(path)?.map_or_else(|| Self::of(&trace::read(path)?), Ok)
    }

    /// Reads all curves of a file: of a map there are many.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_all(path: &Path) -> Result<Vec<Self>, AfmError> {
        match exported(path)? {
            Some(curve) => Ok(vec![curve]),
            None => trace::read_all(path)?.iter().map(Self::of).collect(),
        }
    }

    /// Takes a trace: its displacement is the way of the piezo if its head (`[setup] spring_constant_N_per_m`) states a spring
    /// constant, else that of the tip. What the tip does says the column [`SEGMENT`], or else the motion.
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
        let (segments, comes_again) = match trace.column(SEGMENT) {
            Some(numbers) => Segments::joined(stretches(numbers)),
            None => (segments(&trace.time, &piezo_m), false),
        };
        let mut notes = vec![note];
        notes.extend(comes_again.then(|| COMES_AGAIN.into()));
        Ok(Self {
            label: trace.label(),
            segments,
            time_s: trace.time.clone(),
            piezo_m,
            force_n,
            spring_n_per_m: spring,
            notes,
        })
    }

    /// The same curve with another spring constant, N/m.
    #[must_use]
    pub fn with_spring(mut self, spring_n_per_m: f64) -> Self {
        self.spring_n_per_m = Some(spring_n_per_m);
        self.notes.push(format!("spring constant as given: {spring_n_per_m} N/m"));
        self
    }
}

/// What is said of a curve in which the tip comes in more than once.
pub(super) const COMES_AGAIN: &str = "what comes in again after the first way back is left out";

/// The curve of a text export of JPK; none of any other file.
fn exported(path: &Path) -> Result<Option<ForceCurve>, AfmError> {
    let bytes = std::fs::read(path).map_err(|source| AfmError::Io { path: path.into(), source })?;
    let Ok(text) = std::str::from_utf8(&bytes) else { return Ok(None) };
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    jpk::is_export(text).then(|| jpk::parse(&name.unwrap_or_default(), text)).transpose()
}

/// The stretches that the numbers of [`SEGMENT`] make; what no number stands for is left out.
fn stretches(numbers: &[f64]) -> impl Iterator<Item = (Stretch, Range<usize>)> {
    let mut end = 0;
    numbers.chunk_by(|one, next| one == next).filter_map(move |same| {
        let range = end..end + same.len();
        end = range.end;
        Some((Stretch::of(same[0])?, range))
    })
}

/// The approach goes until the piezo first turns back, however often it rests on the way.
fn segments(time: &[f64], piezo: &[f64]) -> Segments {
    let (low, high) = piezo
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
    // Counted from so far off that nothing is before a touch.
    let way: Vec<f64> = piezo.iter().map(|x| x - low + (high - low)).collect();
    let moves = trace::segments(time, &way);
    let Some(comes) = moves.iter().position(|part| part.kind == Kind::Load) else {
        return Segments::default();
    };
    let back = moves[comes..].iter().position(|part| part.kind == Kind::Unload);
    let back = back.map_or(moves.len(), |k| comes + k);
    let end = |part: usize| moves[..part].last().map_or(0, |part| part.range.end);
    let again = moves[back..].iter().position(|part| part.kind == Kind::Load);
    let over = again.map_or(moves.len(), |k| back + k);
    let recording = time[time.len() - 1] - time[0];
    let lasts = |range: &Range<usize>| time[range.end - 1] - time[range.start];
    Segments {
        approach: 0..end(back),
        pauses: moves[comes..back]
            .iter()
            .filter(|part| part.kind == Kind::Hold)
            .map(|part| part.range.clone())
            .filter(|range| lasts(range) > SHORTEST_PAUSE * recording)
            .collect(),
        retract: (back < over).then(|| end(back)..end(over)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rest_at_the_nearest_is_a_hold_and_a_turn_is_none() {
        let time: Vec<f64> = (0..300).map(f64::from).collect();
        let held: Vec<f64> = time.iter().map(|t| t.min(100.0).min(300.0 - t)).collect();
        let found = segments(&time, &held);
        assert_eq!(found.approach, 0..201);
        assert_eq!(found.pauses, vec![100..201]);
        assert_eq!(found.retract, Some(201..300));
        let turned: Vec<f64> = time.iter().map(|t| t.min(300.0 - t)).collect();
        let found = segments(&time, &turned);
        assert_eq!(found, Segments { approach: 0..151, pauses: vec![], retract: Some(151..300) });
    }

    #[test]
    fn a_staircase_is_one_approach_with_its_pauses() {
        let time: Vec<f64> = (0..500).map(f64::from).collect();
        let way = |t: f64| t.min(100.0).max(t - 100.0).min(200.0).min(500.0 - t);
        let found = segments(&time, &time.iter().map(|t| way(*t)).collect::<Vec<f64>>());
        assert_eq!((found.approach, found.retract), (0..301, Some(301..500)));
        assert_eq!(found.pauses, vec![100..201]);
    }
}
