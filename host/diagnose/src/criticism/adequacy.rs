//! Whether what a model leaves is noise: slow wandering of the residual against that of the signal at
//! rest.
//!
//! The whitened residual is summed in blocks of several lengths. White noise gives block sums whose
//! mean square is that of the samples; what a model lacks adds up within a block. What the whitening
//! itself leaves in the noise is in the rest off the specimen as well, so the two are compared. Where neighbouring samples scatter
//! farther in contact than at rest, the noise is louder there, and the residual is evened out first.

use super::tail::log_tail;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use palpate_fit::loudness::{Loudness, Scatter, Seen};
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;

/// Lengths of the blocks, samples.
const LENGTHS: [usize; 4] = [8, 24, 72, 216];
/// Chance below which a residual is more than noise.
pub const LEVEL: f64 = 1e-3;

/// What the residual of a model looks like beside noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Adequacy {
    /// Chance of block sums as large under noise alone, over all lengths.
    pub p_value: f64,
    /// Sum of squares, whitened, that noise does not account for: the largest over the lengths.
    pub excess: f64,
    /// Root mean square of the residual, not whitened.
    pub rms: f64,
    /// How many times the noise is louder than at rest: root mean square over all samples.
    pub louder: f64,
    /// The same over the samples in which the specimen is loaded.
    pub louder_loaded: f64,
    /// Lights: Ljung and Box's chance, Durbin and Watson's statistic, and the chance of the number of
    /// runs of one sign.
    pub lights: Lights,
}

/// Well-known figures of a whitened residual: to look at, not to judge by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lights {
    /// Ljung and Box: mean over their number of the squared correlations at distances 1 to 20; 1 for noise.
    pub ljung_box: f64,
    /// Durbin and Watson: 2 for noise, less where neighbours agree.
    pub durbin_watson: f64,
    /// Runs of one sign over their expected number; 1 for noise.
    pub runs: f64,
}

/// Sum of squares of block sums, per sample, and the number of blocks.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    squares: f64,
    count: f64,
}

/// Tests the residual of a problem at a point.
#[must_use]
pub fn adequacy(problem: &Problem, point: &[f64], whitening: &Whitening) -> Adequacy {
    let (even, scatter) = weighed(problem, point, whitening, None);
    // Where the noise is a guess, the samples may be means over blocks that are longer off the specimen.
    match scatter.louder().filter(|_| !whitening.is_guess()) {
        None => even,
        louder => weighed(problem, point, whitening, louder.as_ref()).0,
    }
}

/// Block sums of one length off the specimen: what noise adds up to there. What comes anew at the same time of each recording is no noise,
/// nor is what remains of a touch where that is more than there was before.
#[derive(Clone, Debug, Default)]
struct Floor {
    /// Before the first touch of a trace: for each place of a block in it the sum, the sum of squares, and the number of traces.
    before: Vec<(f64, f64, f64)>,
    /// After a touch.
    after: Sums,
}

impl Floor {
    /// Adds a block before the first touch of its trace, at a place in it.
    fn add_before(&mut self, place: usize, sum: f64) {
        if self.before.len() <= place {
            self.before.resize(place + 1, (0.0, 0.0, 0.0));
        }
        let own = &mut self.before[place];
        *own = (own.0 + sum, own.1 + sum * sum, own.2 + 1.0);
    }

    /// Before a touch: squares about the mean over traces where there are several, and how many are free.
    fn before(&self) -> Sums {
        let about = |&(sum, squares, traces): &(f64, f64, f64)| match traces {
            0.0 => Sums::default(),
            1.0 => Sums { squares, count: 1.0 },
            _ => Sums { squares: squares - sum * sum / traces, count: traces - 1.0 },
        };
        self.before.iter().map(about).fold(Sums::default(), Sums::with)
    }

    /// Whether blocks after a touch surely hold more than noise.
    fn is_stirred(&self) -> bool {
        let (before, after) = (self.before(), self.after);
        if before.count < FEW || after.count < FEW {
            return false;
        }
        let ratio = after.mean() / before.mean().max(f64::MIN_POSITIVE);
        FisherSnedecor::new(after.count, before.count).is_ok_and(|law| law.sf(ratio) < LEVEL)
    }

    /// Mean square of a block and the number of blocks that it is from; few of them say little of what noise does, and it counts as white.
    fn level(&self, stirred: bool) -> (f64, f64) {
        let quiet = if stirred { self.before() } else { self.before().with(self.after) };
        if quiet.count >= FEW { (quiet.mean().max(1.0), quiet.count) } else { (1.0, 200.0) }
    }
}

impl Sums {
    fn with(self, other: Self) -> Self {
        Self { squares: self.squares + other.squares, count: self.count + other.count }
    }

    fn mean(self) -> f64 {
        self.squares / self.count
    }
}

/// Blocks at rest that are enough to see noise in.
const FEW: f64 = 8.0;

/// Tests the residual, evened out where its noise is louder in contact; and how far its neighbours scatter.
fn weighed(
    problem: &Problem,
    point: &[f64],
    whitening: &Whitening,
    louder: Option<&Loudness>,
) -> (Adequacy, Scatter) {
    let mut touched = [Sums::default(); LENGTHS.len()];
    let mut floor: [Floor; LENGTHS.len()] = Default::default();
    let mut current = Current::default();
    let mut counts = Counts::default();
    let mut strongest = Strongest::default();
    let (mut square, mut samples): (f64, f64) = (0.0, 0.0);
    let mut scatter = Scatter::default();
    problem.each_piece(&[point.to_vec()], |piece, forces| {
        let mut residual: Vec<f64> =
            piece.measured.iter().zip(&forces[0]).map(|(y, f)| y - f).collect();
        square += residual.iter().map(|r| r * r).sum::<f64>();
        samples += residual.len() as f64;
        whitening.apply(&mut residual);
        let x = &piece.motion.displacement;
        let seen = Seen { x, predicted: &forces[0] };
        match louder {
            Some(louder) => louder.even_out(&mut residual, seen, |x| problem.data().loads(x)),
            None => scatter.add(&residual, seen, |x| problem.data().loads(x)),
        }
        let first = current.first_touch(piece.trace, x, |x| problem.data().loads(x));
        for (place, &length) in LENGTHS.iter().enumerate() {
            let blocks = residual.chunks_exact(length).zip(x.chunks_exact(length));
            for (number, (block, x)) in blocks.enumerate() {
                let sum = block.iter().sum::<f64>() / (length as f64).sqrt();
                let own = Sums { squares: sum * sum, count: 1.0 };
                if x.iter().any(|&x| problem.data().loads(x)) {
                    touched[place] = touched[place].with(own);
                } else if (number + 1) * length <= first {
                    floor[place].add_before(number, sum);
                } else {
                    floor[place].after = floor[place].after.with(own);
                }
            }
        }
        counts.add(&residual);
        strongest.add(&residual, x, |x| problem.data().loads(x));
    });
    let mut p_value: f64 = 1.0;
    let mut excess: f64 = 0.0;
    let stirred = floor.iter().any(Floor::is_stirred);
    for (touched, floor) in touched.iter().zip(&floor) {
        if touched.count < 2.0 {
            continue;
        }
        let mean = touched.mean();
        let (floor, degrees) = floor.level(stirred);
        excess = excess.max((mean - floor) * touched.count);
        if let Ok(fisher) = FisherSnedecor::new(touched.count, degrees) {
            p_value = p_value.min(fisher.sf((mean / floor).max(0.0)));
        }
    }
    let p_value = (p_value * LENGTHS.len() as f64).min(1.0).min(strongest.p_value());
    let (louder, louder_loaded) = louder.map_or((1.0, 1.0), |it| (it.overall, it.loaded));
    let rms = (square / samples.max(1.0)).sqrt();
    let lights = counts.lights();
    (Adequacy { p_value, excess, rms, louder, louder_loaded, lights }, scatter)
}

/// The trace whose stretches are being read.
#[derive(Default)]
struct Current {
    trace: Option<usize>,
    touched: bool,
}

impl Current {
    /// The number of samples of a stretch before the first touch of its trace.
    fn first_touch(&mut self, trace: usize, x: &[f64], loads: impl Fn(f64) -> bool) -> usize {
        if self.trace != Some(trace) {
            *self = Self { trace: Some(trace), touched: false };
        }
        let before = if self.touched { 0 } else { x.iter().take_while(|&&x| !loads(x)).count() };
        self.touched |= before < x.len();
        before
    }
}

/// Lengths of the windows in which a short disturbance is looked for, samples.
const WINDOWS: [usize; 6] = [1, 3, 6, 12, 25, 50];

/// The strongest short disturbance: the largest sum over a window beside what noise sums to.
#[derive(Debug, Default)]
struct Strongest {
    /// Largest squared sum of each length over the length, in contact.
    largest: [f64; WINDOWS.len()],
    /// The same off the specimen, where nothing but noise can be.
    quiet: [f64; WINDOWS.len()],
    /// Number of windows that do not overlap, in contact.
    windows: [f64; WINDOWS.len()],
}

impl Strongest {
    fn add(&mut self, whitened: &[f64], x: &[f64], loads: impl Fn(f64) -> bool) {
        for (place, &length) in WINDOWS.iter().enumerate() {
            if whitened.len() < length {
                continue;
            }
            let mut sum: f64 = whitened[..length].iter().sum();
            for begin in 0..=whitened.len() - length {
                if begin > 0 {
                    sum += whitened[begin + length - 1] - whitened[begin - 1];
                }
                let square = sum * sum / length as f64;
                let loaded = x[begin..begin + length].iter().any(|&x| loads(x));
                let largest = if loaded { &mut self.largest } else { &mut self.quiet };
                largest[place] = largest[place].max(square);
            }
            self.windows[place] += (whitened.len() / length) as f64;
        }
    }

    /// Chance of a disturbance as strong under noise alone, over all windows. Noise with heavy tails
    /// shows some off the specimen too: only what exceeds the strongest there counts.
    fn p_value(&self) -> f64 {
        let of_length = |place: usize| {
            if self.largest[place] <= self.quiet[place] {
                return 1.0;
            }
            // Windows overlap: about four of each length's places are independent.
            4.0 * self.windows[place] * log_tail(self.largest[place], 1, false).exp()
        };
        let least = (0..WINDOWS.len()).map(of_length).fold(1.0, f64::min);
        (WINDOWS.len() as f64 * least).min(1.0)
    }
}

/// Distances at which neighbours are compared.
const DISTANCES: usize = 20;

/// What the lights are counted from.
#[derive(Default)]
struct Counts {
    products: [f64; DISTANCES + 1],
    differences: f64,
    runs: f64,
    expected: f64,
    samples: f64,
}

impl Counts {
    /// Counts one whitened stretch.
    fn add(&mut self, stretch: &[f64]) {
        for (distance, product) in self.products.iter_mut().enumerate() {
            let later = stretch.get(distance..).unwrap_or_default();
            *product += stretch.iter().zip(later).map(|(a, b)| a * b).sum::<f64>();
        }
        self.differences += stretch.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>();
        let changes = stretch.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count();
        self.runs += changes as f64 + 1.0;
        let above = stretch.iter().filter(|value| **value > 0.0).count() as f64;
        let count = stretch.len() as f64;
        self.expected += 1.0 + 2.0 * above * (count - above) / count.max(1.0);
        self.samples += count;
    }

    fn lights(&self) -> Lights {
        let square = self.products[0].max(f64::MIN_POSITIVE);
        let squared = self.products[1..].iter().map(|product| (product / square).powi(2));
        Lights {
            ljung_box: self.samples * squared.sum::<f64>() / DISTANCES as f64,
            durbin_watson: self.differences / square,
            runs: self.runs / self.expected.max(1.0),
        }
    }
}
