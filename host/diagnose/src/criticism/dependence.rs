//! How much of a residual a quantity explains, and whether that could be chance.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::covariate::Covariate;
use super::residuals::{Residuals, Values};
use palpate_fit::watch;

/// Mean residual in one bin of a covariate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Mean of the covariate in the bin.
    pub at: f64,
    /// Mean residual.
    pub mean: f64,
    /// Standard error of the mean: how far it wanders when what the bins do not explain is shifted in a circle against the
    /// covariate, so that neighbours stay as correlated as they are.
    pub standard_error: f64,
    /// Number of samples.
    pub samples: usize,
}

/// Dependence of a residual on one covariate.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependence {
    /// The covariate.
    pub covariate: Covariate,
    /// Share of the residual's mean square that the bin means explain, 0 to 1.
    pub explained: f64,
    /// Chance of explaining as much if residual and covariate had nothing to do with each other.
    pub p_value: f64,
    /// Correlation of bin means with the covariate: +1 where the residual grows with it.
    pub trend: f64,
    /// The bins, by rising covariate.
    pub bins: Vec<Bin>,
}

/// Most bins of a covariate.
const BINS: usize = 20;
/// Shifts that a p value is counted from.
const SHIFTS: usize = 199;
/// Seed of the shifts.
pub const SEED: u64 = 7;

/// Dependence on every covariate that varies, strongest first.
///
/// The p value comes from shifting each trace's residuals in a circle against its covariates by a
/// random part of its length: this keeps the correlation of neighbours and breaks all else. The
/// shifts are seeded.
#[must_use]
pub fn dependences(left: &Residuals) -> Vec<Dependence> {
    watch::stage("quantities that the residual could depend on", Covariate::ALL.len());
    let residual = Residual::new(left.values());
    let mut found: Vec<Dependence> = Covariate::ALL
        .into_par_iter()
        .filter_map(|covariate| {
            let bins = left.covariate(covariate).and_then(|values| Bins::of(&values));
            watch::done();
            Some(dependence(&residual, covariate, &bins?))
        })
        .collect();
    found.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    found
}

fn dependence(residual: &Residual, covariate: Covariate, bins: &Bins) -> Dependence {
    let explained = bins.explained(residual, &vec![0; residual.values.len()]);
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let as_much = (0..SHIFTS)
        .take_while(|_| !watch::ended())
        .filter(|_| {
            let shift = |r: &Vec<f64>| random.random_range(0..r.len().max(1));
            let shifts: Vec<usize> = residual.values.iter().map(shift).collect();
            bins.explained(residual, &shifts) >= explained
        })
        .count();
    let bins = bins.means(&residual.values, &mut random);
    Dependence {
        covariate,
        explained,
        p_value: (as_much + 1) as f64 / (SHIFTS + 1) as f64,
        trend: trend(&bins),
        bins,
    }
}

/// Mean residuals in bins of a quantity; none where it does not vary.
pub(super) fn binned(residual: Vec<f64>, values: Vec<f64>) -> Option<Vec<Bin>> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    Some(Bins::of(&[values.into()])?.means(&[residual], &mut random))
}

/// Residuals of every stretch with their sums.
struct Residual {
    values: Vec<Vec<f64>>,
    /// Sum before each sample of a stretch, and of all.
    before: Vec<Vec<f64>>,
    /// Sum of squares of all.
    square: f64,
}

impl Residual {
    fn new(values: Vec<Vec<f64>>) -> Self {
        let before = values.iter().map(|values| sums_before(values.iter().copied())).collect();
        let square = values.iter().flatten().map(|r| r * r).sum();
        Self { values, before, square }
    }
}

/// Sum before each value, and of all.
fn sums_before(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let sums = values.scan(0.0, |sum, value| {
        *sum += value;
        Some(*sum)
    });
    std::iter::once(0.0).chain(sums).collect()
}

/// A covariate in bins, as runs in one bin each: it stays in one for long, and the sum of the residuals over a run is a
/// difference of two sums, so that a shift costs as much as the covariate changes its bin.
struct Bins {
    /// Bin of each run of a stretch, and the sample after its last.
    runs: Vec<Vec<(usize, usize)>>,
    /// Sum of the covariate in each bin.
    sums: Vec<f64>,
    /// Number of samples in each bin; no shift changes it.
    counts: Vec<usize>,
}

impl Bins {
    /// Bins of equal width, or around each value where they are few; none of a covariate that does not vary.
    fn of(values: &Values) -> Option<Self> {
        let edges = edges(values)?;
        let (mut sums, mut counts) = (vec![0.0; edges.len() + 1], vec![0; edges.len() + 1]);
        let mut runs = Vec::new();
        for values in values {
            let mut own: Vec<(usize, usize)> = Vec::new();
            for (k, value) in values.iter().enumerate() {
                let bin = edges.partition_point(|edge| edge <= value);
                sums[bin] += value;
                counts[bin] += 1;
                match own.last_mut() {
                    Some((last, end)) if *last == bin => *end = k + 1,
                    _ => own.push((bin, k + 1)),
                }
            }
            runs.push(own);
        }
        Some(Self { runs, sums, counts })
    }

    /// Share of the residual's mean square that the bin means explain, each stretch of it shifted in a circle.
    fn explained(&self, residual: &Residual, shifts: &[usize]) -> f64 {
        let mut sums = vec![0.0; self.counts.len()];
        for ((runs, before), &shift) in self.runs.iter().zip(&residual.before).zip(shifts) {
            add(runs, before, shift, &mut sums);
        }
        let of_means = |(sum, &count): (&f64, &usize)| {
            if count > 0 { sum * sum / count as f64 } else { 0.0 }
        };
        let of_means: f64 = sums.iter().zip(&self.counts).map(of_means).sum();
        if residual.square > 0.0 { of_means / residual.square } else { 0.0 }
    }

    /// The mean residual in every bin that has samples.
    fn means(&self, residual: &[Vec<f64>], random: &mut ChaCha8Rng) -> Vec<Bin> {
        let mut means = vec![0.0; self.counts.len()];
        self.each_run(residual, |bin, values| values.iter().for_each(|r| means[bin] += r));
        means.iter_mut().zip(&self.counts).for_each(|(mean, &count)| *mean /= count as f64);
        let errors = self.standard_errors(residual, &means, random);
        let bin = |k: usize| Bin {
            at: self.sums[k] / self.counts[k] as f64,
            mean: means[k],
            standard_error: errors[k],
            samples: self.counts[k],
        };
        (0..means.len()).map(bin).filter(|bin| bin.samples > 0).collect()
    }

    /// Calls `visit` with the bin and the residuals of every run.
    fn each_run(&self, residual: &[Vec<f64>], mut visit: impl FnMut(usize, &[f64])) {
        for (runs, residual) in self.runs.iter().zip(residual) {
            let mut begin = 0;
            for &(bin, end) in runs {
                visit(bin, &residual[begin..end]);
                begin = end;
            }
        }
    }

    /// Root mean square of each bin's mean over shifts of what the bins leave unexplained. All stretches make one circle: then
    /// a covariate that is constant within each of them is told from them as well.
    fn standard_errors(
        &self,
        residual: &[Vec<f64>],
        means: &[f64],
        random: &mut ChaCha8Rng,
    ) -> Vec<f64> {
        let (mut before, mut sum) = (vec![0.0], 0.0);
        let mut runs: Vec<(usize, usize)> = Vec::new();
        self.each_run(residual, |bin, values| {
            before.extend(values.iter().map(|r| {
                sum += r - means[bin];
                sum
            }));
            match runs.last_mut() {
                Some((last, end)) if *last == bin => *end = before.len() - 1,
                _ => runs.push((bin, before.len() - 1)),
            }
        });
        let mut squares = vec![0.0; means.len()];
        for _ in 0..SHIFTS {
            let mut sums = vec![0.0; means.len()];
            let shift = random.random_range(0..(before.len() - 1).max(1));
            add(&runs, &before, shift, &mut sums);
            for ((square, sum), &count) in squares.iter_mut().zip(&sums).zip(&self.counts) {
                *square += (sum / count as f64).powi(2);
            }
        }
        squares.iter().map(|square| (square / SHIFTS as f64).sqrt()).collect()
    }
}

/// Adds the residuals of every run to the sum of its bin, each sample taking the residual `shift` samples later, round and round;
/// `before` are the sums of the residuals before each sample, and of all.
fn add(runs: &[(usize, usize)], before: &[f64], shift: usize, sums: &mut [f64]) {
    let count = before.len() - 1;
    let all = before[count];
    let until = |sample: usize| {
        let sample = sample + shift;
        if sample <= count { before[sample] } else { all + before[sample - count] }
    };
    let mut last = until(0);
    for &(bin, end) in runs {
        let sum = until(end);
        sums[bin] += sum - last;
        last = sum;
    }
}

/// Inner edges of bins of equal width; around each value where they are few.
fn edges(values: &Values) -> Option<Vec<f64>> {
    // The distinct values, rising, as long as they are few.
    let mut distinct: Vec<f64> = Vec::new();
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for &value in values.iter().flat_map(|values| values.iter()) {
        (least, most) = (least.min(value), most.max(value));
        if distinct.len() <= BINS {
            let place = distinct.partition_point(|known| *known < value);
            if distinct.get(place).is_none_or(|known| *known != value) {
                distinct.insert(place, value);
            }
        }
    }
    let edges: Vec<f64> = if distinct.len() <= BINS {
        distinct.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
    } else {
        (1..BINS).map(|k| least + (most - least) * k as f64 / BINS as f64).collect()
    };
    (!edges.is_empty()).then_some(edges)
}

/// Correlation of the bin means with the covariate, each bin weighing as its samples.
fn trend(bins: &[Bin]) -> f64 {
    let total: f64 = bins.iter().map(|bin| bin.samples as f64).sum();
    let mean = |value: fn(&Bin) -> f64| {
        bins.iter().map(|bin| value(bin) * bin.samples as f64).sum::<f64>() / total
    };
    let (mean_at, mean_r) = (mean(|bin| bin.at), mean(|bin| bin.mean));
    let moment = |a: fn(&Bin) -> f64, mean_a: f64, b: fn(&Bin) -> f64, mean_b: f64| {
        let term = |bin: &Bin| (a(bin) - mean_a) * (b(bin) - mean_b) * bin.samples as f64;
        bins.iter().map(term).sum::<f64>()
    };
    let at = moment(|b| b.at, mean_at, |b| b.at, mean_at);
    let r = moment(|b| b.mean, mean_r, |b| b.mean, mean_r);
    let both = moment(|b| b.at, mean_at, |b| b.mean, mean_r);
    if at > 0.0 && r > 0.0 { both / (at * r).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;

    /// A quantity with its values, trace by trace.
    type Quantity = (Covariate, Vec<Cow<'static, [f64]>>);

    /// Residuals of three traces, correlated noise plus `slope` times the displacement, and their quantities.
    fn traces(slope: f64) -> (Residual, [Quantity; 3]) {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let time: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.01).collect();
        let (mut displacement, mut residuals) = (Vec::new(), Vec::new());
        for trace in 0..3 {
            let x: Vec<f64> = time.iter().map(|t| (t * 1.3 + f64::from(trace)).sin()).collect();
            let mut noise = 0.0;
            let mut left = |x: &f64| {
                noise = 0.8 * noise + random.random_range(-1.0..1.0);
                noise + slope * x
            };
            residuals.push(x.iter().map(&mut left).collect());
            displacement.push(x.into());
        }
        let still = vec![Cow::from(vec![0.0; time.len()]); 3];
        let quantities = [
            (Covariate::Displacement, displacement),
            (Covariate::Time, vec![time.into(); 3]),
            (Covariate::Direction, still),
        ];
        (Residual::new(residuals), quantities)
    }

    /// What they depend on.
    fn dependences(slope: f64) -> Vec<Dependence> {
        let (residual, quantities) = traces(slope);
        let found = |(it, values): &Quantity| Some(dependence(&residual, *it, &Bins::of(values)?));
        quantities.iter().filter_map(found).collect()
    }

    #[test]
    fn a_real_dependence_is_found_with_its_direction() {
        for (slope, sign) in [(2.0, 1.0), (-2.0, -1.0)] {
            let found = &dependences(slope)[0];
            assert!(found.explained > 0.4 && found.p_value <= 0.01, "{found:?}");
            assert!(found.trend * sign > 0.95);
        }
    }

    #[test]
    fn correlated_noise_alone_passes_for_chance() {
        let found = dependences(0.0);
        assert!(found.iter().all(|dependence| dependence.p_value > 0.02), "{found:?}");
    }

    /// Share explained, sample by sample.
    fn sample_by_sample(
        residuals: &[Vec<f64>],
        places: &[Vec<usize>],
        bins: usize,
        shifts: &[usize],
    ) -> f64 {
        let mut sums = vec![(0.0, 0.0); bins];
        let mut square = 0.0;
        for ((residual, places), &shift) in residuals.iter().zip(places).zip(shifts) {
            let (head, tail) = residual.split_at(shift);
            for (r, &place) in tail.iter().chain(head).zip(places) {
                sums[place].0 += r;
                sums[place].1 += 1.0;
                square += r * r;
            }
        }
        let of_mean =
            |(sum, count): &(f64, f64)| if *count > 0.0 { sum * sum / count } else { 0.0 };
        sums.iter().map(of_mean).sum::<f64>() / square
    }

    #[test]
    fn runs_explain_what_samples_do() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for longest_run in [1, 7, 200] {
            let lengths = [500, 1, 333];
            let places: Vec<Vec<usize>> = lengths
                .iter()
                .map(|&length| {
                    let mut place = 0;
                    let next = |_| {
                        if random.random_range(0..longest_run) == 0 {
                            place = random.random_range(0..6);
                        }
                        place
                    };
                    (0..length).map(next).collect()
                })
                .collect();
            let residual = |&length: &usize| {
                (0..length).map(|_| 3.0 + random.random_range(-1.0..1.0)).collect::<Vec<f64>>()
            };
            let residuals: Vec<Vec<f64>> = lengths.iter().map(residual).collect();
            let values = places.iter().map(|own| own.iter().map(|place| *place as f64).collect());
            let bins = Bins::of(&values.collect::<Vec<Cow<[f64]>>>()).unwrap();
            let residual = Residual::new(residuals.clone());
            for _ in 0..50 {
                let shifts = lengths.map(|length| random.random_range(0..length));
                let expected = sample_by_sample(&residuals, &places, 6, &shifts);
                let found = bins.explained(&residual, &shifts);
                assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn a_shift_costs_as_many_sums_as_the_covariate_changes_its_bin() {
        for samples in [1_000, 100_000] {
            let rising: Cow<[f64]> = (0..samples).map(f64::from).collect();
            assert_eq!(Bins::of(&[rising]).unwrap().runs[0].len(), BINS);
        }
    }

    /// How often a mean lies within so many of its standard errors of zero, where there is no dependence.
    #[test]
    fn error_bars_allow_for_the_correlation_of_neighbours() {
        let found = dependences(0.0);
        let bins: Vec<&Bin> = found.iter().flat_map(|dependence| &dependence.bins).collect();
        let within = |times: f64| {
            let near = |bin: &&&Bin| bin.mean.abs() <= times * bin.standard_error;
            bins.iter().filter(near).count() as f64 / bins.len() as f64
        };
        assert!(bins.len() > 30, "{}", bins.len());
        // Of samples taken as independent, a third: neighbours with a correlation of 0.8 count as one of nine.
        assert!(within(1.0) > 0.5 && within(2.0) > 0.85, "{} {}", within(1.0), within(2.0));
        // Nor are they so wide that they hide what is there.
        let real = &dependences(2.0)[0];
        let clear = |bin: &&Bin| bin.mean.abs() > 3.0 * bin.standard_error;
        assert!(real.bins.iter().filter(clear).count() > real.bins.len() / 2, "{real:?}");
    }

    #[test]
    fn a_quantity_that_is_constant_within_each_trace_has_error_bars() {
        let residual = traces(0.0).0;
        let celsius = [20.0, 22.0, 25.0].map(|celsius| Cow::from(vec![celsius; 600]));
        let found = dependence(&residual, Covariate::Temperature, &Bins::of(&celsius).unwrap());
        assert!(
            found.bins.iter().all(|bin| bin.mean.abs() < 3.0 * bin.standard_error),
            "{found:?}"
        );
    }

    #[test]
    fn a_quantity_that_does_not_vary_is_left_out() {
        let found = dependences(1.0);
        assert!(found.iter().all(|it| it.covariate != Covariate::Direction), "{found:?}");
    }
}
