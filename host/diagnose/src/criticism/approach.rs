//! Noise on the way to the first touch, where a recording begins in motion: what depends on the motion may be in it, so that it counts
//! as noise only where nothing but noise that correlates for a few samples is there.

use palpate_fit::data::{Data, Piece};
use palpate_fit::whitening::Whitening;

/// Fewest samples of a way.
const SHORTEST: usize = 32;
/// Lengths of the blocks, samples, whose sums tell what is slower than such noise.
const LENGTHS: [usize; 4] = [8, 24, 72, 216];
/// Blocks of a length that are enough to compare.
const FEW: f64 = 8.0;
/// Times by which the mean square of block sums may be that of white noise, and standard errors beyond them.
const WHITE: f64 = 1.2;
const SURELY: f64 = 3.0;
/// Times by which noise may be larger than its neighbours scatter.
const CORRELATED: f64 = 3.0;

/// The signal on the way to the first touch of every trace, about a straight line in time.
pub(super) fn approaches(data: &Data) -> Vec<Vec<f64>> {
    let mut before = None;
    let first = data.pieces.iter().filter(|piece| before.replace(piece.trace) != Some(piece.trace));
    first.filter_map(|piece| straightened(approach(data, piece)?)).collect()
}

/// Whether nothing is on these ways but noise that this filter makes white.
pub(super) fn whitens(whitening: &Whitening, mut ways: Vec<Vec<f64>>) -> bool {
    let near = whitening.standard_deviation() <= CORRELATED * neighbours(&ways);
    ways.iter_mut().for_each(|way| whitening.apply(way));
    near && LENGTHS.iter().all(|length| is_white(&ways, *length))
}

/// The signal before the first touch, clear of it.
fn approach<'a>(data: &Data, piece: &'a Piece) -> Option<&'a [f64]> {
    let touch = data.touch(piece)?;
    let clear = -data.aside();
    let x = &piece.motion.displacement[..touch];
    let near = x.iter().position(|&x| x >= clear).unwrap_or(touch);
    (near >= SHORTEST).then(|| &piece.measured[..near])
}

/// Values about the straight line through them; none where they are all on it.
fn straightened(values: &[f64]) -> Option<Vec<f64>> {
    let count = values.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = values.iter().sum::<f64>() / count;
    let along = |k: usize| k as f64 - middle;
    let moments = values.iter().enumerate().map(|(k, value)| along(k) * value);
    let slope = moments.sum::<f64>() / (count * (count * count - 1.0) / 12.0);
    let about: Vec<f64> =
        values.iter().enumerate().map(|(k, value)| value - mean - slope * along(k)).collect();
    about.iter().any(|value| *value != 0.0).then_some(about)
}

/// Whether the sums over blocks of a length are no larger than those of white noise of size 1, surely.
fn is_white(whitened: &[Vec<f64>], length: usize) -> bool {
    let blocks = whitened.iter().flat_map(|way| way.chunks_exact(length));
    let squares = blocks.map(|block| block.iter().sum::<f64>().powi(2) / length as f64);
    let (mean, count) = mean(squares);
    count < FEW || mean < WHITE + SURELY * (2.0 / count).sqrt()
}

/// Scatter of neighbours: standard deviation by second differences.
fn neighbours(ways: &[Vec<f64>]) -> f64 {
    let threes = ways.iter().flat_map(|way| way.windows(3));
    mean(threes.map(|at| (at[0] - 2.0 * at[1] + at[2]).powi(2) / 6.0)).0.sqrt()
}

/// The mean and the number of values.
fn mean(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (sum / count, count)
}

#[cfg(test)]
mod tests {
    use crate::criticism::noise::{Seen, noise_model};
    use palpate_fit::data::Data;
    use palpate_trace::{Column, DISPLACEMENT, FORCE, Trace};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Presses that come from far off without a stop, beside something on the way in.
    fn presses(on_the_way: impl Fn(f64) -> f64) -> Vec<Trace> {
        let mut random = ChaCha8Rng::seed_from_u64(31);
        let mut press = |deep: f64| {
            let time: Vec<f64> = (0..1500).map(|k| 0.01 * f64::from(k)).collect();
            let x: Vec<f64> = time.iter().map(|t| (2.0 * t - 8.0).min(deep)).collect();
            let mut measured = |x: &f64| {
                let noise: f64 = StandardNormal.sample(&mut random);
                0.02 * noise + 0.3 * x.max(0.0).powf(1.5) + on_the_way(*x)
            };
            let force = x.iter().map(&mut measured).collect();
            let column = |name: &str, values| Column { name: name.into(), values };
            let columns = vec![column(DISPLACEMENT, x), column(FORCE, force)];
            Trace { time, columns, ..Trace::default() }
        };
        vec![press(4.0), press(3.0), press(5.0)]
    }

    fn seen(on_the_way: impl Fn(f64) -> f64) -> Option<(f64, usize)> {
        let found = noise_model(&Data::of(&presses(on_the_way), FORCE).expect("a data set"))?;
        assert_eq!(found.seen, Seen::OnTheWayIn);
        Some((found.level, found.samples))
    }

    #[test]
    fn noise_on_the_way_in_is_the_noise_whatever_the_zero_and_a_drift() {
        for way in [&|_: f64| 0.0, &|x: f64| 0.7 + 0.05 * x] as [&dyn Fn(f64) -> f64; 2] {
            let (level, samples) = seen(way).expect("noise is seen");
            assert!((level / 0.02 - 1.0).abs() < 0.06, "{level}");
            assert!(samples > 900, "{samples}");
        }
    }

    #[test]
    fn what_follows_the_motion_on_the_way_in_is_no_noise() {
        // A screw that errs, a spring that is pulled along, a touch before the zero of the displacement.
        assert_eq!(seen(|x| 0.02 * (7.8 * x).sin()), None);
        assert_eq!(seen(|x| 0.003 * (x + 8.0).powi(2)), None);
        assert_eq!(seen(|x| 0.3 * (x.min(0.0) + 2.0).max(0.0)), None);
    }
}
