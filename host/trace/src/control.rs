//! Which quantity the machine controlled.

use std::ops::Range;

use super::segments::{Kind, segments};
use super::{Control, Trace};

/// Part of a rest that is left out at either end, where the machine still arrives or already leaves.
const END_SHARE: f64 = 0.1;
/// Fewest samples of a rest that tell a drift.
const MIN_REST_SAMPLES: usize = 10;

/// Which quantity was controlled: what the head says, else what the data tell.
///
/// In a hold the controlled quantity rests and the other one moves. So the drift of displacement and
/// of force is summed over the stretches where either of them rests, each as a share of its own range;
/// force was controlled when it drifts less than half as much. A trace that lacks either, or in which
/// nothing rests, counts as displacement controlled.
#[must_use]
pub fn control(trace: &Trace) -> Control {
    if let Some(told) = trace.head.control {
        return told;
    }
    let (Some(displacement), Some(force)) = (trace.displacement(), trace.force()) else {
        return Control::Displacement;
    };
    let rests: Vec<Range<usize>> = [displacement, force]
        .iter()
        .flat_map(|values| segments(&trace.time, values))
        .filter(|segment| segment.kind == Kind::Hold)
        .filter_map(|segment| inner(&segment.range))
        .collect();
    let drift = |values: &[f64]| rests.iter().map(|rest| drift(&values[rest.clone()])).sum::<f64>();
    let (moved, pressed) = (drift(displacement) / range(displacement), drift(force) / range(force));
    if pressed < 0.5 * moved { Control::Force } else { Control::Displacement }
}

/// A rest without its ends; none where too little is left.
fn inner(rest: &Range<usize>) -> Option<Range<usize>> {
    let end = (END_SHARE * rest.len() as f64).ceil() as usize;
    let inner = rest.start + end..rest.end.saturating_sub(end).max(rest.start + end);
    (inner.len() >= MIN_REST_SAMPLES).then_some(inner)
}

/// How far the last third lies from the first.
fn drift(values: &[f64]) -> f64 {
    let third = values.len() / 3;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    (mean(&values[values.len() - third..]) - mean(&values[..third])).abs()
}

pub(super) fn range(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    (most - least).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DISPLACEMENT, FORCE};

    /// A ramp of 1 s, then a hold of 9 s in which the other quantity moves by a fifth and a scatter
    /// that is not much smaller.
    fn hold(steady: &str, other: &str, scatter: f64) -> Trace {
        let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let ramp = |t: f64| 4.0 * t.min(1.0);
        let steadily = time.iter().map(|&t| ramp(t)).collect();
        let wobble = |k: usize| scatter * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        let answer = time
            .iter()
            .enumerate()
            .map(|(k, &t)| ramp(t) * (1.0 - 0.2 * (1.0 - (-(t - 1.0).max(0.0)).exp())) + wobble(k));
        let answer = answer.collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(steady, steadily);
        trace.set_column(other, answer);
        trace
    }

    #[test]
    fn what_rests_while_the_other_moves_was_controlled() {
        for scatter in [0.0, 0.02, 0.2] {
            assert_eq!(control(&hold(FORCE, DISPLACEMENT, scatter)), Control::Force);
            assert_eq!(control(&hold(DISPLACEMENT, FORCE, scatter)), Control::Displacement);
        }
    }

    #[test]
    fn the_head_is_believed() {
        let mut trace = hold(FORCE, DISPLACEMENT, 0.0);
        trace.head.control = Some(Control::Displacement);
        assert_eq!(control(&trace), Control::Displacement);
    }
}
