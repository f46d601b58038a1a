//! Noise that is louder where the specimen is loaded than off it: it grows with the signal, or the drive shakes what it moves. It is told
//! from a misfit by neighbouring samples, which a smooth misfit moves together.

use nalgebra::{Matrix3, Vector3};

/// Samples in a block.
const BLOCK: usize = 12;
/// Part of the way of the fastest block of a stretch from which one moves.
const MOVES: f64 = 0.1;
/// Blocks off the specimen, and on it, that are enough to compare.
const ENOUGH: usize = 10;
/// Standard errors by which the logarithms of the scatter must differ.
const SURELY: f64 = 5.0;
/// Factor by which it must be larger to count.
const LOUDER: f64 = 1.05;
/// Times that the blocks are weighed anew by the variance found.
const ROUNDS: usize = 4;

/// A stretch of a recording beside a model.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Displacement at each sample, mm.
    pub x: &'a [f64],
    /// What the model predicts of the signal.
    pub predicted: &'a [f64],
}

/// What the variance of the noise may grow with, over that off the specimen: contact, the square of the signal, motion.
type Causes = Vector3<f64>;

/// How far neighbouring samples of residuals scatter, block by block.
#[derive(Debug, Default)]
pub struct Scatter {
    /// Off the specimen.
    quiet: Vec<Block>,
    /// On it, with the causes.
    loaded: Vec<(Block, Causes)>,
}

/// How far neighbours in a block scatter, squared.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// By all second differences.
    all: f64,
    /// By the smaller half of them: a jump of what the model lacks, from tooth to tooth of a specimen that sticks and slips, is no noise.
    half: f64,
}

/// A mean and the square of its standard error.
type Mean = (f64, f64);

/// How much louder the noise is than off the specimen.
#[derive(Debug)]
pub struct Loudness {
    /// What each cause adds to the variance, over that off the specimen.
    adds: Causes,
    /// Root mean square of the factor over all samples.
    pub overall: f64,
    /// The same over those in which the specimen is loaded.
    pub loaded: f64,
}

impl Seen<'_> {
    /// The causes at each sample; none where the specimen is not loaded.
    fn causes(&self, loads: impl Fn(f64) -> bool) -> Vec<Option<Causes>> {
        let x = self.x;
        let way = |k: usize| {
            let (from, to) = (k.saturating_sub(BLOCK / 2), (k + BLOCK / 2).min(x.len() - 1));
            (x[to] - x[from]).abs()
        };
        let longest = (0..x.len()).map(way).fold(0.0, f64::max);
        let at = |k: usize| {
            let moves = f64::from(u8::from(way(k) > MOVES * longest));
            loads(x[k]).then(|| Causes::new(1.0, self.predicted[k].powi(2), moves))
        };
        (0..x.len()).map(at).collect()
    }
}

impl Block {
    fn of(values: &[f64]) -> Self {
        let second = values.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs());
        let mut second: Vec<f64> = second.collect();
        second.sort_by(f64::total_cmp);
        let square = |some: &[f64]| (some.iter().sum::<f64>() / some.len() as f64).powi(2);
        Self { all: square(&second), half: square(&second[..second.len() / 2]) }
    }
}

impl Scatter {
    /// Adds the residual of a stretch; `loads` says of a displacement, mm, whether it loads the specimen.
    pub fn add(&mut self, residual: &[f64], seen: Seen, loads: impl Fn(f64) -> bool) {
        let causes = seen.causes(loads);
        for (values, causes) in residual.chunks_exact(BLOCK).zip(causes.chunks_exact(BLOCK)) {
            let block = Block::of(values);
            let own: Vec<Causes> = causes.iter().copied().flatten().collect();
            match own.len() {
                _ if block.half <= 0.0 => {}
                0 => self.quiet.push(block),
                count => self.loaded.push((block, own.iter().sum::<Causes>() / count as f64)),
            }
        }
    }

    /// How much louder the noise is where the specimen is loaded; none where it is not, or too little was recorded to tell.
    #[must_use]
    pub fn louder(&self) -> Option<Loudness> {
        let rest = logarithms(self.quiet.iter().map(|block| block.half))?;
        let louder = |moves: bool| {
            let own = self.loaded.iter().filter(|(_, causes)| (causes[2] > 0.5) == moves);
            logarithms(own.map(|(block, _)| block.half)).is_some_and(|(mean, variance)| {
                mean - rest.0 > LOUDER.ln().max(SURELY * (rest.1 + variance).sqrt())
            })
        };
        if !louder(false) && !louder(true) {
            return None;
        }
        let quiet: Vec<f64> = self.quiet.iter().map(|block| block.all).collect();
        let usual = mean(&quiet).0;
        let blocks: Vec<(f64, Causes)> =
            self.loaded.iter().map(|(block, causes)| (block.all / usual, *causes)).collect();
        let adds = explained(&blocks);
        let more: f64 = blocks.iter().map(|(_, causes)| adds.dot(causes)).sum();
        let root = |count: usize| (1.0 + more / count as f64).sqrt();
        let (overall, loaded) = (root(blocks.len() + self.quiet.len()), root(blocks.len()));
        (loaded > LOUDER).then_some(Loudness { adds, overall, loaded })
    }
}

impl Loudness {
    /// Divides the residual of a stretch by how much louder its noise is.
    pub fn even_out(&self, residual: &mut [f64], seen: Seen, loads: impl Fn(f64) -> bool) {
        for (value, causes) in residual.iter_mut().zip(seen.causes(loads)) {
            *value /= causes.map_or(1.0, |causes| (1.0 + self.adds.dot(&causes)).sqrt());
        }
    }
}

/// Mean of the logarithms of the scatter; none where there are too few.
fn logarithms(scatter: impl Iterator<Item = f64>) -> Option<Mean> {
    let own: Vec<f64> = scatter.map(|scatter| 0.5 * scatter.ln()).collect();
    let (mean, variance) = mean(&own);
    (own.len() >= ENOUGH).then_some((mean, variance / own.len() as f64))
}

/// What each cause adds to a variance of one, none of them less than nothing: least squares, each block weighed by its variance.
fn explained(blocks: &[(f64, Causes)]) -> Causes {
    // In units in which each is about one.
    let squares =
        blocks.iter().fold(Causes::zeros(), |sum, (_, causes)| sum + causes.map(|c| c * c));
    let scale = (squares / blocks.len() as f64)
        .map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
    let scaled: Vec<(f64, Causes)> = blocks
        .iter()
        .map(|(scatter, causes)| (scatter - 1.0, causes.component_div(&scale)))
        .collect();
    let mut adds = Causes::zeros();
    for _ in 0..ROUNDS {
        let weight = |causes: &Causes| (1.0 + adds.dot(causes)).powi(-2);
        let (mut products, mut along) = (Matrix3::zeros(), Vector3::zeros());
        for (scatter, causes) in &scaled {
            let weight = weight(causes);
            products += weight * causes * causes.transpose();
            along += weight * *scatter * causes;
        }
        adds = least(&products, &along);
    }
    adds.component_div(&scale)
}

/// The least of a quadratic form, no coordinate below zero: the best of all choices of coordinates that are not zero.
fn least(products: &Matrix3<f64>, along: &Vector3<f64>) -> Vector3<f64> {
    let value = |at: &Vector3<f64>| at.dot(&(products * at)) - 2.0 * at.dot(along);
    let of = |chosen: u8| {
        let free = |k: usize| chosen >> k & 1 == 1;
        let held = Matrix3::from_fn(|i, j| match (free(i) && free(j), i == j) {
            (true, _) => products[(i, j)] * if i == j { 1.0 + 1e-9 } else { 1.0 },
            (false, same) => f64::from(u8::from(same)),
        });
        let along = Vector3::from_fn(|k, _| if free(k) { along[k] } else { 0.0 });
        held.cholesky().map(|factor| factor.solve(&along)).filter(|at| at.min() >= 0.0)
    };
    let all = (1..8).filter_map(of);
    all.min_by(|a, b| value(a).total_cmp(&value(b))).unwrap_or_default()
}

/// Mean and variance.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, squares / (count - 1.0))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;

    const HALF: usize = 2000;

    /// Rest, then contact: displacement goes to and fro in every other 250 samples, and the signal goes on growing.
    fn motion() -> (Vec<f64>, Vec<f64>) {
        let phase = |k: usize| (k - HALF) / 250;
        let way = |k: usize| if k >= HALF && phase(k) % 2 == 0 { 0.01 } else { 0.0 };
        let x = (0..2 * HALF).scan(-0.005, |x, k| {
            *x += way(k);
            Some(*x)
        });
        (x.collect(), (0..2 * HALF).map(|k| k.saturating_sub(HALF) as f64 / HALF as f64).collect())
    }

    /// Noise that is so many times louder in contact, at a signal, in motion; beside a misfit in contact.
    fn residual(
        seed: u64,
        louder: impl Fn(f64, bool) -> f64,
        misfit: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, 1.0).unwrap();
        let (x, signal) = motion();
        let drawn = (0..2 * HALF).map(|k| {
            let r: f64 = normal.sample(&mut random);
            let moves = k > 0 && x[k] != x[k - 1];
            if k < HALF { r } else { louder(signal[k], moves) * r + misfit(k) }
        });
        drawn.collect()
    }

    fn of(residual: &[f64]) -> Option<Loudness> {
        let (x, predicted) = motion();
        let mut scatter = Scatter::default();
        scatter.add(residual, Seen { x: &x, predicted: &predicted }, |x| x > 0.0);
        scatter.louder()
    }

    #[test]
    fn louder_noise_is_seen_and_evened_out() {
        let (x, predicted) = motion();
        let of_signal = |signal: f64, _: bool| (1.0 + 8.0 * signal * signal).sqrt();
        let of_motion = |_: f64, moves: bool| if moves { 2.5 } else { 1.0 };
        let of_contact = |_: f64, _: bool| 1.6;
        let causes: [&dyn Fn(f64, bool) -> f64; 3] = [&of_signal, &of_motion, &of_contact];
        for (seed, louder) in (0..10).flat_map(|seed| causes.map(|louder| (seed, louder))) {
            let mut values = residual(seed, louder, |_| 0.0);
            let found = of(&values).unwrap();
            found.even_out(&mut values, Seen { x: &x, predicted: &predicted }, |x| x > 0.0);
            for part in values[HALF..].chunks(500) {
                let square = part.iter().map(|r| r * r).sum::<f64>() / part.len() as f64;
                assert!((square - 1.0).abs() < 0.35, "{seed}: {square}");
            }
        }
    }

    #[test]
    fn even_noise_a_smooth_misfit_and_a_short_disturbance_are_no_louder_noise() {
        let even = |_: f64, _: bool| 1.0;
        for seed in 0..50 {
            assert!(of(&residual(seed, even, |_| 0.0)).is_none(), "{seed}");
            let smooth = |k: usize| 5.0 * (0.03 * k as f64).sin();
            assert!(of(&residual(seed, even, smooth)).is_none(), "{seed}");
            let burst = |k: usize| if (3000..3006).contains(&k) { 20.0 } else { 0.0 };
            assert!(of(&residual(seed, even, burst)).is_none(), "{seed}");
            let teeth = |k: usize| 0.3 * (k % 9) as f64;
            assert!(of(&residual(seed, even, teeth)).is_none(), "{seed}");
        }
    }
}
