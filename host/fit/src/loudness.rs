//! Noise that is louder where the specimen is loaded than off it: it grows with the signal, or the drive shakes what it moves. It is told
//! from a misfit by neighbouring samples, which a smooth misfit moves together.

/// Samples in a block.
const BLOCK: usize = 12;
/// Nearest blocks over which the scatter of a block is taken, in the middle: a short disturbance is no louder noise.
const AROUND: usize = 21;
/// Part of the way of the fastest block of a stretch from which a block moves.
const MOVES: f64 = 0.1;
/// Blocks off the specimen, and on it, that are enough to compare.
const ENOUGH: usize = 10;
/// Standard errors by which the logarithms of the scatter must differ.
const SURELY: f64 = 5.0;
/// Factor by which it must be larger to count.
const LOUDER: f64 = 1.05;

/// How far neighbouring samples of residuals scatter, block by block.
#[derive(Debug, Default)]
pub struct Scatter {
    stretches: Vec<Vec<Block>>,
}

#[derive(Clone, Copy, Debug)]
struct Block {
    /// Mean size of the second differences.
    scatter: f64,
    loaded: bool,
    moves: bool,
}

/// How much louder the noise is than off the specimen.
#[derive(Debug)]
pub struct Loudness {
    /// By what factor, block by block of each stretch, at least 1.
    factors: Vec<Vec<f64>>,
    /// Root mean square of the factor over all samples.
    pub overall: f64,
    /// The same over those in which the specimen is loaded.
    pub loaded: f64,
}

impl Scatter {
    /// Adds a stretch of residuals with its displacement, mm; `loads` says of one whether it loads the specimen.
    pub fn add(&mut self, residual: &[f64], x: &[f64], loads: impl Fn(f64) -> bool) {
        let way = |x: &[f64]| (x[x.len() - 1] - x[0]).abs();
        let longest = x.chunks_exact(BLOCK).map(way).fold(0.0, f64::max);
        let block = |(values, x): (&[f64], &[f64])| {
            let second =
                values.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs());
            let scatter = second.sum::<f64>() / (values.len() - 2) as f64;
            let loaded = x.iter().any(|&x| loads(x));
            Block { scatter, loaded, moves: way(x) > MOVES * longest }
        };
        let whole = residual.chunks_exact(BLOCK).zip(x.chunks_exact(BLOCK));
        self.stretches.push(whole.map(block).collect());
    }

    /// How much louder the noise is where the specimen is loaded; none where it is not, or too little was recorded to tell.
    #[must_use]
    pub fn louder(&self) -> Option<Loudness> {
        let all = |loaded: bool| {
            let blocks = self.stretches.iter().flatten();
            let own = blocks.filter(move |block| block.loaded == loaded && block.scatter > 0.0);
            own.map(|block| block.scatter.ln()).collect::<Vec<f64>>()
        };
        let (quiet, loud) = (all(false), all(true));
        if quiet.len() < ENOUGH || loud.len() < ENOUGH {
            return None;
        }
        let (rest, rest_variance) = mean(&quiet);
        let (pressed, variance) = mean(&loud);
        let error = (rest_variance / quiet.len() as f64 + variance / loud.len() as f64).sqrt();
        if pressed - rest < LOUDER.ln().max(SURELY * error) {
            return None;
        }
        let usual = middle(quiet).exp();
        let factors: Vec<Vec<f64>> =
            self.stretches.iter().map(|blocks| factors(blocks, usual)).collect();
        let (mut squares, mut count, mut loaded, mut pressed) = (0.0, 0.0, 0.0, 0.0);
        for (blocks, factors) in self.stretches.iter().zip(&factors) {
            for (block, factor) in blocks.iter().zip(factors) {
                (squares, count) = (squares + factor * factor, count + 1.0);
                if block.loaded {
                    (loaded, pressed) = (loaded + factor * factor, pressed + 1.0);
                }
            }
        }
        let root = |sum: f64, count: f64| (sum / count).sqrt();
        Some(Loudness { factors, overall: root(squares, count), loaded: root(loaded, pressed) })
    }
}

impl Loudness {
    /// Divides the residual of a stretch, by its place, by how much louder its noise is.
    pub fn even_out(&self, stretch: usize, residual: &mut [f64]) {
        let factors = &self.factors[stretch];
        for (number, values) in residual.chunks_mut(BLOCK).enumerate() {
            let factor = factors.get(number).or(factors.last()).copied().unwrap_or(1.0);
            values.iter_mut().for_each(|value| *value /= factor);
        }
    }
}

/// The scatter about each block over the usual one off the specimen, by the blocks nearest in time that move, or stay, as it does; 1 where
/// the specimen is not loaded.
fn factors(blocks: &[Block], usual: f64) -> Vec<f64> {
    let mut factors = vec![1.0; blocks.len()];
    for moves in [false, true] {
        let alike = |k: &usize| blocks[*k].loaded && blocks[*k].moves == moves;
        let places: Vec<usize> = (0..blocks.len()).filter(alike).collect();
        for (number, &k) in places.iter().enumerate() {
            let first = number.saturating_sub(AROUND / 2).min(places.len().saturating_sub(AROUND));
            let around = &places[first..(first + AROUND).min(places.len())];
            let own = around.iter().map(|&near| blocks[near].scatter);
            factors[k] = (middle(own.collect()) / usual).max(1.0);
        }
    }
    factors
}

/// Mean and variance.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, squares / (count - 1.0))
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;

    /// Noise whose loaded half, the second, is so many times louder, beside a misfit there.
    fn residual(seed: u64, louder: f64, misfit: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, 1.0).unwrap();
        let noise =
            (0..4000).map(|k| if k < 2000 { 1.0 } else { louder } * normal.sample(&mut random));
        noise.enumerate().map(|(k, r)| if k < 2000 { r } else { r + misfit(k) }).collect()
    }

    fn of(residual: &[f64]) -> Option<Loudness> {
        let mut scatter = Scatter::default();
        let x: Vec<f64> = (0..4000).map(|k| f64::from(u8::from(k >= 2000))).collect();
        scatter.add(residual, &x, |x| x > 0.0);
        scatter.louder()
    }

    #[test]
    fn louder_noise_is_seen_and_evened_out() {
        for seed in 0..20 {
            let mut values = residual(seed, 1.6, |_| 0.0);
            let found = of(&values).unwrap();
            assert!((found.loaded / 1.6 - 1.0).abs() < 0.15, "{}", found.loaded);
            found.even_out(0, &mut values);
            let square = values[2000..].iter().map(|r| r * r).sum::<f64>() / 2000.0;
            assert!((square - 1.0).abs() < 0.25, "{square}");
        }
    }

    #[test]
    fn even_noise_a_smooth_misfit_and_a_short_disturbance_are_no_louder_noise() {
        for seed in 0..50 {
            assert!(of(&residual(seed, 1.0, |_| 0.0)).is_none(), "{seed}");
            assert!(
                of(&residual(seed, 1.0, |k| 5.0 * (0.03 * k as f64).sin())).is_none(),
                "{seed}"
            );
            let burst = |k: usize| if (3000..3006).contains(&k) { 20.0 } else { 0.0 };
            assert!(of(&residual(seed, 1.0, burst)).is_none(), "{seed}");
        }
    }
}
