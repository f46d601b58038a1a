//! Traces that begin in the midst of a motion: a specimen that relaxes remembers what came before, which was not recorded.

use palpate_model::Motion;

use super::data::{Data, Piece};

/// Part of a trace's range that a motion leaves soon where it goes on from the first sample.
const LEAVES: f64 = 0.05;
/// How much longer than at the trace's own speed it may take: at a turn it takes three times as long.
const LINGERS: f64 = 5.0;
/// Samples at the beginning in which the signal is felt, and the part of its largest value from which it is.
const FIRST: usize = 3;
const FELT: f64 = 0.1;

/// The stretches, by their place, that begin pressed and in motion, without what went before.
#[must_use]
pub fn begun_in_motion(data: &Data) -> Vec<usize> {
    let aside = data.aside();
    let begins = |piece: &Piece| {
        let deep =
            piece.motion.displacement.first().is_some_and(|&x| data.loads(x) && x.abs() > aside);
        let unknown = piece.motion.rest_before.is_none();
        unknown && deep && is_felt(piece.measured) && moves_from_the_first(&piece.motion, aside)
    };
    (0..data.pieces.len()).filter(|&index| begins(&data.pieces[index])).collect()
}

/// Whether the signal begins away from 0.
fn is_felt(measured: &[f64]) -> bool {
    let first = &measured[..FIRST.min(measured.len())];
    let mean = first.iter().sum::<f64>() / first.len().max(1) as f64;
    let most = measured.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    mean.abs() > FELT * most
}

/// Whether the motion, of more than `least`, mm, leaves its first place as soon as its own root mean square speed would.
fn moves_from_the_first(motion: &Motion, least: f64) -> bool {
    let (time, x) = (&motion.time, &motion.displacement);
    let extremes = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = x.iter().fold(extremes, |(low, high), &x| (low.min(x), high.max(x)));
    let range = high - low;
    let Some(left) = x.iter().position(|at| (at - x[0]).abs() > LEAVES * range) else {
        return false;
    };
    // Over ways of some length: scatter of the displacement is no motion.
    let (mut from, mut squares) = (0, 0.0);
    for k in 1..x.len() {
        let way = x[k] - x[from];
        if way.abs() > LEAVES * range {
            squares += way * way / (time[k] - time[from]);
            from = k;
        }
    }
    let speed = (squares / (time[time.len() - 1] - time[0])).sqrt();
    range > least && (time[left] - time[0]) * speed < LINGERS * LEAVES * range
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::{DISPLACEMENT, FORCE, Trace};

    fn found(x: impl Fn(f64) -> f64, signal: impl Fn(f64) -> f64) -> bool {
        let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let scatter = |k: usize| 1e-3 * (k * 7919 % 13) as f64;
        let x: Vec<f64> = time.iter().enumerate().map(|(k, &t)| x(t) + scatter(k)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(
            FORCE,
            x.iter().enumerate().map(|(k, &x)| signal(x) + scatter(k)).collect(),
        );
        trace.set_column(DISPLACEMENT, x);
        !begun_in_motion(&Data::of(&[trace], FORCE).unwrap()).is_empty()
    }

    #[test]
    fn a_motion_that_goes_on_from_before_is_told_from_all_that_begin_at_rest() {
        let stiff = |x: f64| 0.2 * x.max(0.0);
        let wave = |frequency: f64, phase: f64| {
            move |t: f64| 3.0 + (std::f64::consts::TAU * (frequency * t + phase)).sin()
        };
        for frequency in [0.2, 1.0, 5.0] {
            for phase in [0.0, 0.25, 0.4, 0.75] {
                assert!(found(wave(frequency, phase), stiff), "{frequency} Hz, {phase}");
            }
        }
        assert!(found(|t| 5.0 - 0.5 * t, stiff), "a retreat");
        assert!(
            !found(|t| (2.0 * t - 1.0).clamp(0.0, 5.0), stiff),
            "a press from off the specimen"
        );
        assert!(!found(|_| 4.0, stiff), "a hold");
        assert!(
            !found(|t| 4.0 - (2.0 * (t - 8.0)).clamp(0.0, 4.0), stiff),
            "a hold, then a retreat"
        );
        assert!(!found(|t| 2.0 + (10.0 * (t - 2.0)).clamp(0.0, 3.0), stiff), "a step from a hold");
        let offset = |x: f64| 0.2 * (x - 50.0).max(0.0);
        assert!(!found(|t| 50.0 + t.min(5.0), offset), "a press in the coordinates of its rig");
    }
}
