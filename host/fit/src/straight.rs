//! Where samples can be taken together: as long as nothing that a contact model can follow bends within them.
//!
//! Whatever its law, a model follows the compression and what it remembers of it, and exponentials of all rates that a
//! recording can show span what can be remembered. They are run along a motion as probes, beside the square of the
//! compression and every other quantity that was recorded: a block ends before the sample at which one of them leaves the
//! straight line over the block by more than the noise of its mean. So blocks are short after a touch or a corner of
//! the motion and grow with the time since, in a hold as in a ramp, and their number follows what happens, not the rate.

use palpate_trace::scatter;

/// Factor between the rates of neighbouring probes.
const APART: f64 = 4.0;
/// Noise over the range of the signal where it is not known.
pub(super) const USUAL_NOISE: f64 = 1e-3;
/// Least and largest part of its range by which a probe may bend within a block.
const BENDS: (f64, f64) = (1e-4, 5e-3);
/// Times the scatter of a recorded quantity that do not count as bending.
const SCATTERS: f64 = 3.0;
/// Part of the largest compression of a set over which a block moves at most: a law may have steps between. Off the specimen, part
/// of so many times the distance from it beside that.
const MOVES: f64 = 1.0 / 64.0;
const OFF: f64 = 4.0;

/// Part of the largest speed that counts as rest, and so many times the scatter of the velocity between samples that are so far apart
/// that no slope was taken over both.
const AT_REST: f64 = 1e-3;
const STEADY: f64 = 10.0;
const SMOOTHED: usize = 17;
/// Logarithm of the factor by which the speed changes within a block at most: where a motion begins, ends or turns round, friction and
/// dampers jump. A sample at a corner has half the speed, and so stands alone.
const TURNS: f64 = 0.5;

/// How far blocks may go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Largest compression of the set, mm.
    pub compression: f64,
    /// Largest speed of the set, mm/s.
    pub speed: f64,
    /// Fastest and slowest rate that can be seen, 1/s.
    pub rates: (f64, f64),
    /// Noise over the range of the signal.
    pub noise: f64,
    /// Longest block, s.
    pub longest: f64,
    /// Whether the specimen is loaded to either side.
    pub either: bool,
    /// By how much less than usual may change within a block.
    pub finer: f64,
}

/// A quantity along a stretch.
struct Probe {
    values: Vec<f64>,
    /// What counts as its range.
    range: f64,
    /// What its scatter makes of it.
    scatter: f64,
}

/// Where the blocks of a stretch begin, and the number of its samples. The first and the last sample stand alone.
pub(super) fn begins(
    time: &[f64],
    (x, velocity): (&[f64], &[f64]),
    recorded: &[&[f64]],
    reach: Reach,
) -> Vec<usize> {
    let probes = probes(time, x, recorded, reach);
    let apart = |values: &[f64]| values.iter().step_by(SMOOTHED).copied().collect::<Vec<f64>>();
    let scattered = scatter(&apart(time), &apart(velocity));
    let at_rest = (AT_REST * reach.speed).max(STEADY * scattered);
    let speed = |k: usize| if at_rest > 0.0 { (velocity[k] / at_rest).asinh() } else { 0.0 };
    let count = time.len();
    // The first and the last sample of a contact stand alone, and those beside them: what depends on the speed jumps there.
    let side = |k: usize| (x[k] > 0.0, reach.either && x[k] < 0.0);
    let touches = |k: usize| k > 0 && k < count && side(k) != side(k - 1);
    let off = |x: f64| if reach.either { 0.0 } else { OFF * (-x).max(0.0) };
    let mut begins = vec![0];
    let mut begin = 0;
    for k in 1..count {
        let apart = begin == 0
            || k + 1 == count
            || touches(k)
            || touches(k - 1)
            || touches(k + 1)
            || (x[k] - x[begin]).abs() > MOVES / reach.finer * (reach.compression + off(x[k]))
            || (speed(k) - speed(begin)).abs() > TURNS / reach.finer
            || time[k] - time[begin] > reach.longest;
        if apart || !straight(time, &probes, begin, k, reach) {
            begins.push(k);
            begin = k;
        }
    }
    begins.push(count);
    begins
}

/// Whether every probe is straight from one sample to another.
fn straight(time: &[f64], probes: &[Probe], from: usize, to: usize, reach: Reach) -> bool {
    if to - from < 2 {
        return true;
    }
    let middle = from.midpoint(to);
    let part = (time[middle] - time[from]) / (time[to] - time[from]);
    let bends = reach.noise / ((to - from + 1) as f64).sqrt();
    let bends = bends.clamp(BENDS.0, BENDS.1) / reach.finer;
    probes.iter().all(|Probe { values, range, scatter }| {
        let line = values[from] + part * (values[to] - values[from]);
        (values[middle] - line).abs() <= bends * range + scatter
    })
}

fn probes(time: &[f64], x: &[f64], recorded: &[&[f64]], reach: Reach) -> Vec<Probe> {
    let most = reach.compression.max(f64::MIN_POSITIVE);
    let scattered = SCATTERS * scatter(time, x);
    let felt: Vec<f64> = x.iter().map(|x| if reach.either { *x } else { x.max(0.0) }).collect();
    let squares = felt.iter().map(|x| x * x.abs()).collect();
    let mut probes = vec![
        Probe { values: squares, range: most * most, scatter: 2.0 * most * scattered },
        remembered(time, x, reach.rates.0, most, scattered),
    ];
    let rates = std::iter::successors(Some(reach.rates.0), |rate| Some(rate / APART));
    let rates = rates.take_while(|rate| *rate > reach.rates.1 / APART);
    probes.extend(rates.map(|rate| remembered(time, &felt, rate, most, scattered)));
    probes.extend(recorded.iter().map(|values| {
        let (least, most) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let scatter = SCATTERS * scatter(time, values);
        Probe { values: values.to_vec(), range: most - least, scatter }
    }));
    probes
}

/// What an exponential of this rate, 1/s, remembers of a motion.
fn remembered(time: &[f64], x: &[f64], rate: f64, most: f64, scatter: f64) -> Probe {
    let mut values = Vec::with_capacity(x.len());
    let (mut interval, mut decay, mut gain) = (0.0, 1.0, 1.0);
    let (mut state, mut before) = (x.first().copied().unwrap_or(0.0), 0.0);
    let mut largest = 0.0f64;
    for k in 0..x.len() {
        if k > 0 {
            let now = time[k] - time[k - 1];
            if (now - interval).abs() > 1e-6 * now {
                interval = now;
                decay = (-rate * now).exp();
                gain = -(-rate * now).exp_m1() / (rate * now);
            }
            state = state * decay + gain * (x[k] - before);
        }
        before = x[k];
        largest = largest.max(state.abs());
        values.push(state);
    }
    // What is remembered for a short time alone never grows large, and can still be most of what a law lacks.
    Probe { values, range: (most * largest).sqrt(), scatter }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACH: Reach = Reach {
        compression: 4.0,
        speed: 4.0,
        rates: (100.0, 1e-4),
        noise: USUAL_NOISE,
        longest: f64::INFINITY,
        either: false,
        finer: 1.0,
    };

    /// A rest of a second, a press at 4 mm/s, a hold, a release, and a rest.
    fn press(rate: f64, hold: f64) -> (Vec<f64>, Vec<f64>) {
        let count = ((5.0 + hold) * rate) as usize;
        let time: Vec<f64> = (0..count).map(|k| k as f64 / rate).collect();
        let course = |t: &f64| (4.0 * (t - 1.0)).min(4.0).min(4.0 * (3.0 + hold - t)).max(-0.1);
        let x = time.iter().map(course).collect();
        (time, x)
    }

    /// The blocks of a motion, with the speed between neighbours.
    fn blocks(time: &[f64], x: &[f64]) -> Vec<usize> {
        let speed = |k: usize| (x[k] - x[k - 1]) / (time[k] - time[k - 1]);
        let velocity: Vec<f64> = (0..x.len()).map(|k| speed(k.max(1))).collect();
        begins(time, (x, &velocity), &[], REACH)
    }

    fn lengths(begins: &[usize]) -> Vec<usize> {
        begins.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    #[test]
    fn every_sample_is_in_one_block_and_a_corner_is_left_as_it_is() {
        let (time, x) = press(100.0, 60.0);
        let found = blocks(&time, &x);
        assert!(found.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!((found[0], found[found.len() - 1]), (0, time.len()));
        // The press begins at sample 100 and ends at sample 200.
        for corner in [102, 202] {
            let block = found.partition_point(|begin| *begin <= corner);
            assert!(found[block] - found[block - 1] <= 3, "{:?}", lengths(&found));
        }
        assert!(found.contains(&201), "{found:?}");
    }

    #[test]
    fn blocks_grow_like_the_logarithm_of_a_hold_and_hardly_with_the_rate() {
        let count = |rate: f64, hold: f64| {
            let (time, x) = press(rate, hold);
            blocks(&time, &x).len()
        };
        let (short, long) = (count(50.0, 60.0), count(50.0, 6000.0));
        assert!(long < 3 * short, "{long} for {short}");
        let (slow, fast) = (count(100.0, 60.0), count(1600.0, 60.0));
        assert!(fast < 3 * slow, "{fast} for {slow}");
    }

    #[test]
    fn a_motion_that_goes_on_is_followed_by_as_many_blocks_at_any_rate() {
        let count = |rate: usize| {
            let time: Vec<f64> = (0..100 * rate).map(|k| k as f64 / rate as f64).collect();
            let x: Vec<f64> = time.iter().map(|t| 2.0 - 2.0 * (0.3 * t).cos()).collect();
            blocks(&time, &x).len()
        };
        let (slow, fast) = (count(50), count(400));
        assert!(slow < 2500 && fast < 2 * slow, "{fast} for {slow}");
    }

    #[test]
    fn a_scatter_of_the_motion_does_not_count_as_bending() {
        let (time, mut x) = press(100.0, 600.0);
        let mut seed = 1u64;
        for x in &mut x {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            *x += 1e-2 * ((seed >> 40) as f64 / f64::from(1u32 << 24) - 0.5);
        }
        let found = blocks(&time, &x);
        assert!(10 * found.len() < time.len(), "{}", found.len());
    }

    #[test]
    fn what_is_loaded_to_either_side_bends_to_either_side() {
        let time: Vec<f64> = (0..20_000).map(|k| 1e-3 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| 4.0 * (1.5 * t).sin()).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 6.0 * (1.5 * t).cos()).collect();
        let turned: Vec<f64> = x.iter().map(|x| -x).collect();
        let backwards: Vec<f64> = velocity.iter().map(|v| -v).collect();
        let reach = Reach { speed: 6.0, either: true, ..REACH };
        let begins_of = |x: &[f64], velocity: &[f64]| begins(&time, (x, velocity), &[], reach);
        assert!(begins_of(&x, &velocity) == begins_of(&turned, &backwards));
    }
}
