//! Where the specimen is touched, where displacement does not count from there.

use super::data::Data;

/// Parts of the largest displacement in which the mean of the signal is taken.
const PARTS: usize = 50;
/// Mean of the signal, over its range, below which nothing is felt.
const UNFELT: f64 = 0.02;
/// Part of the largest displacement up to which a specimen that is touched at 0 is felt, unless its force grows beyond the fourth power.
const FELT_BY: f64 = 0.4;
/// Samples at which nothing is felt that are enough to say so.
const ENOUGH: usize = 5;

/// Displacement, mm, before which nothing is felt on the way in, by means over parts of it; none where it may count from the touch.
#[must_use]
pub fn touched_at(data: &Data) -> Option<f64> {
    let largest = data.largest_compression();
    let mut means = [(0.0, 0); PARTS];
    let (mut least, mut most) = (0.0_f64, 0.0_f64);
    for piece in &data.pieces {
        let x = &piece.motion.displacement;
        let deepest = (0..x.len()).max_by(|&a, &b| x[a].total_cmp(&x[b]))?;
        let way_in = x.iter().zip(piece.measured).take(deepest + 1);
        for (&x, &y) in way_in.filter(|(x, _)| **x > 0.0) {
            let part = (x / largest * PARTS as f64) as usize;
            let (sum, count) = &mut means[part.min(PARTS - 1)];
            (*sum, *count) = (*sum + y, *count + 1);
            (least, most) = (least.min(y), most.max(y));
        }
    }
    let (mut end, mut unfelt) = (0, 0);
    for (part, (sum, count)) in means.iter().enumerate().filter(|(_, (_, count))| *count > 0) {
        if (sum / *count as f64).abs() > UNFELT * (most - least) {
            break;
        }
        (end, unfelt) = (part + 1, unfelt + count);
    }
    let at = largest * end as f64 / PARTS as f64;
    (end < PARTS && at > FELT_BY * largest && unfelt >= ENOUGH).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::{DISPLACEMENT, FORCE, Trace};

    /// A press to 10 mm of a specimen that is touched at `touch`, mm, and whose force grows with this power.
    fn press(touch: f64, power: f64, rest: f64) -> Trace {
        let x: Vec<f64> = (0..400).map(|k| (0.05 * f64::from(k)).min(10.0)).collect();
        let force = x.iter().map(|x: &f64| rest + 0.1 * (x - touch).max(0.0).powf(power));
        let force = force.enumerate().map(|(k, force)| force + 0.001 * f64::from(k as u32 % 3));
        let mut trace =
            Trace { time: (0..400).map(|k| 0.01 * f64::from(k)).collect(), ..Trace::default() };
        trace.set_column(FORCE, force.collect());
        trace.set_column(DISPLACEMENT, x);
        trace
    }

    #[test]
    fn a_touch_shows_where_it_is_far_from_zero() {
        let touched = |touch, power, rest| {
            let traces = [press(touch, power, rest)];
            touched_at(&Data::of(&traces, FORCE).unwrap())
        };
        for power in [1.0, 1.5, 2.5, 4.0] {
            assert_eq!(touched(0.0, power, 0.0), None, "{power}");
        }
        assert_eq!(touched(0.0, 1.5, 2.0), None);
        let found = touched(6.0, 1.8, 0.0).unwrap();
        assert!((6.0..7.0).contains(&found), "{found}");
    }
}
