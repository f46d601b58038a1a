//! How much of a residual a quantity explains, and whether that could be chance.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::covariate::Covariate;
use super::residuals::Stretch;
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
pub fn dependences(stretches: &[Stretch]) -> Vec<Dependence> {
    watch::stage("quantities that the residual could depend on", Covariate::ALL.len());
    let mut found: Vec<Dependence> = Covariate::ALL
        .into_par_iter()
        .filter_map(|covariate| {
            let found = dependence(stretches, covariate);
            watch::done();
            found
        })
        .collect();
    found.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    found
}

/// Dependence on one covariate; none where it is missing or constant.
#[must_use]
pub fn dependence(stretches: &[Stretch], covariate: Covariate) -> Option<Dependence> {
    let values: Vec<&[f64]> =
        stretches.iter().map(|stretch| stretch.covariate(covariate)).collect::<Option<_>>()?;
    let edges = edges(&values)?;
    let places = places(&values, &edges);
    let residuals: Vec<Vec<f64>> = stretches.iter().map(Stretch::residual).collect();
    let binned = Binned::new(&residuals, &places, edges.len() + 1);
    let explained = binned.explained(&vec![0; stretches.len()]);
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let as_much = (0..SHIFTS)
        .take_while(|_| !watch::ended())
        .filter(|_| {
            let shifts: Vec<usize> =
                residuals.iter().map(|r| random.random_range(0..r.len().max(1))).collect();
            binned.explained(&shifts) >= explained
        })
        .count();
    let bins = bins(&residuals, &values, &places, edges.len() + 1, &mut random);
    Some(Dependence {
        covariate,
        explained,
        p_value: (as_much + 1) as f64 / (SHIFTS + 1) as f64,
        trend: trend(&bins),
        bins,
    })
}

/// Mean residuals in bins of a quantity; none where it does not vary.
pub(super) fn binned(residuals: &[Vec<f64>], values: &[&[f64]]) -> Option<Vec<Bin>> {
    let edges = edges(values)?;
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    Some(bins(residuals, values, &places(values, &edges), edges.len() + 1, &mut random))
}

/// The bin of every value.
fn places(values: &[&[f64]], edges: &[f64]) -> Vec<Vec<usize>> {
    let place = |v: &f64| edges.partition_point(|edge| edge <= v);
    values.iter().map(|values| values.iter().map(place).collect()).collect()
}

/// Inner edges of bins of equal width; around each value where they are few.
fn edges(values: &[&[f64]]) -> Option<Vec<f64>> {
    // The distinct values, rising, as long as they are few.
    let mut distinct: Vec<f64> = Vec::new();
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for &value in values.iter().copied().flatten() {
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

/// Residuals in bins of a covariate, laid out so that a shift costs as much as the covariate changes its
/// bin: it stays in one for long, and the sum over such a run is a difference of two prefix sums.
struct Binned {
    stretches: Vec<Runs>,
    /// Number of samples in each bin; no shift changes it.
    counts: Vec<f64>,
    /// Sum of squares of all residuals.
    square: f64,
}

/// One stretch of residuals as runs in one bin each.
struct Runs {
    /// Bin of each run, and the sample after its last.
    runs: Vec<(usize, usize)>,
    /// Sum of the residuals before each sample, and of all.
    before: Vec<f64>,
}

impl Binned {
    fn new(residuals: &[Vec<f64>], places: &[Vec<usize>], bins: usize) -> Self {
        let mut counts = vec![0.0; bins];
        for &place in places.iter().flatten() {
            counts[place] += 1.0;
        }
        let stretches = residuals.iter().zip(places).map(|(r, places)| Runs::new(r, places));
        Self {
            stretches: stretches.collect(),
            counts,
            square: residuals.iter().flatten().map(|r| r * r).sum(),
        }
    }

    /// Share of the mean square explained by the bin means, the residuals shifted in a circle.
    fn explained(&self, shifts: &[usize]) -> f64 {
        let mut sums = vec![0.0; self.counts.len()];
        for (stretch, &shift) in self.stretches.iter().zip(shifts) {
            stretch.add(shift, &mut sums);
        }
        let of_means =
            |(sum, count): (&f64, &f64)| if *count > 0.0 { sum * sum / count } else { 0.0 };
        let of_means: f64 = sums.iter().zip(&self.counts).map(of_means).sum();
        if self.square > 0.0 { of_means / self.square } else { 0.0 }
    }
}

impl Runs {
    fn new(residual: &[f64], places: &[usize]) -> Self {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for (k, &place) in places.iter().enumerate() {
            match runs.last_mut() {
                Some((bin, end)) if *bin == place => *end = k + 1,
                _ => runs.push((place, k + 1)),
            }
        }
        let sums = residual.iter().scan(0.0, |sum, r| {
            *sum += r;
            Some(*sum)
        });
        Self { runs, before: std::iter::once(0.0).chain(sums).collect() }
    }

    /// Adds the residuals of every run to the sum of its bin, each sample taking the residual `shift`
    /// samples later, round and round.
    fn add(&self, shift: usize, sums: &mut [f64]) {
        let count = self.before.len() - 1;
        let all = self.before[count];
        let until = |sample: usize| {
            let sample = sample + shift;
            if sample <= count { self.before[sample] } else { all + self.before[sample - count] }
        };
        let mut last = until(0);
        for &(bin, end) in &self.runs {
            let sum = until(end);
            sums[bin] += sum - last;
            last = sum;
        }
    }
}

fn bins(
    residuals: &[Vec<f64>],
    values: &[&[f64]],
    places: &[Vec<usize>],
    count: usize,
    random: &mut ChaCha8Rng,
) -> Vec<Bin> {
    let mut sums = vec![(0.0, 0.0, 0_usize); count];
    for ((residual, values), places) in residuals.iter().zip(values).zip(places) {
        for ((r, v), &place) in residual.iter().zip(*values).zip(places) {
            let sum = &mut sums[place];
            *sum = (sum.0 + v, sum.1 + r, sum.2 + 1);
        }
    }
    let means: Vec<f64> = sums.iter().map(|(_, r, samples)| r / *samples as f64).collect();
    let errors = standard_errors(residuals, places, &means, random);
    let bin = |(((v, _, samples), mean), standard_error): (((f64, f64, usize), &f64), f64)| Bin {
        at: v / samples as f64,
        mean: *mean,
        standard_error,
        samples,
    };
    sums.into_iter().zip(&means).zip(errors).map(bin).filter(|bin| bin.samples > 0).collect()
}

/// Root mean square of each bin's mean over shifts of what the bins leave unexplained. All stretches make one circle: then a
/// covariate that is constant within each of them is told from them as well.
fn standard_errors(
    residuals: &[Vec<f64>],
    places: &[Vec<usize>],
    means: &[f64],
    random: &mut ChaCha8Rng,
) -> Vec<f64> {
    let places = places.concat();
    let rest = residuals.iter().flatten().zip(&places).map(|(r, &place)| r - means[place]);
    let binned = Binned::new(&[rest.collect()], std::slice::from_ref(&places), means.len());
    let mut squares = vec![0.0; means.len()];
    for _ in 0..SHIFTS {
        let mut sums = vec![0.0; means.len()];
        binned.stretches[0].add(random.random_range(0..places.len().max(1)), &mut sums);
        for ((square, sum), count) in squares.iter_mut().zip(&sums).zip(&binned.counts) {
            *square += (sum / count).powi(2);
        }
    }
    squares.iter().map(|square| (square / SHIFTS as f64).sqrt()).collect()
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
    use super::*;
    use crate::criticism::region::Region;

    /// Three traces whose residual is correlated noise plus `slope` times the displacement.
    fn stretches(slope: f64) -> Vec<Stretch> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        (0..3)
            .map(|trace| {
                let time: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.01).collect();
                let x: Vec<f64> = time.iter().map(|t| (t * 1.3 + f64::from(trace)).sin()).collect();
                let mut noise = 0.0;
                let measured = x
                    .iter()
                    .map(|x| {
                        noise = 0.8 * noise + random.random_range(-1.0..1.0);
                        noise + slope * x
                    })
                    .collect();
                Stretch {
                    trace: trace as usize,
                    regions: vec![Region::Loading; time.len()],
                    predicted: vec![0.0; time.len()],
                    measured,
                    covariates: vec![
                        (Covariate::Displacement, x),
                        (Covariate::Time, time.clone()),
                        (Covariate::Direction, vec![0.0; time.len()]),
                    ],
                    time,
                }
            })
            .collect()
    }

    #[test]
    fn a_real_dependence_is_found_with_its_direction() {
        for (slope, sign) in [(2.0, 1.0), (-2.0, -1.0)] {
            let found = dependence(&stretches(slope), Covariate::Displacement).unwrap();
            assert!(found.explained > 0.4 && found.p_value <= 0.01, "{found:?}");
            assert!(found.trend * sign > 0.95);
        }
    }

    #[test]
    fn correlated_noise_alone_passes_for_chance() {
        let found = dependences(&stretches(0.0));
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
            let binned = Binned::new(&residuals, &places, 6);
            for _ in 0..50 {
                let shifts = lengths.map(|length| random.random_range(0..length));
                let expected = sample_by_sample(&residuals, &places, 6, &shifts);
                let found = binned.explained(&shifts);
                assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn a_shift_costs_as_many_sums_as_the_covariate_changes_its_bin() {
        for samples in [1_000, 100_000] {
            let places: Vec<usize> = (0..samples).map(|k| 20 * k / samples).collect();
            assert_eq!(Runs::new(&vec![1.0; samples], &places).runs.len(), 20);
        }
    }

    /// How often a mean lies within so many of its standard errors of zero, where there is no dependence.
    #[test]
    fn error_bars_allow_for_the_correlation_of_neighbours() {
        let found = dependences(&stretches(0.0));
        let bins: Vec<&Bin> = found.iter().flat_map(|dependence| &dependence.bins).collect();
        let within = |times: f64| {
            let near = |bin: &&&Bin| bin.mean.abs() <= times * bin.standard_error;
            bins.iter().filter(near).count() as f64 / bins.len() as f64
        };
        assert!(bins.len() > 30, "{}", bins.len());
        // Of samples taken as independent, a third: neighbours with a correlation of 0.8 count as one of nine.
        assert!(within(1.0) > 0.5 && within(2.0) > 0.85, "{} {}", within(1.0), within(2.0));
        // Nor are they so wide that they hide what is there.
        let real = dependence(&stretches(2.0), Covariate::Displacement).unwrap();
        let clear = |bin: &&Bin| bin.mean.abs() > 3.0 * bin.standard_error;
        assert!(real.bins.iter().filter(clear).count() > real.bins.len() / 2, "{real:?}");
    }

    #[test]
    fn a_quantity_that_is_constant_within_each_trace_has_error_bars() {
        let mut stretches = stretches(0.0);
        for (stretch, celsius) in stretches.iter_mut().zip([20.0, 22.0, 25.0]) {
            let temperature = vec![celsius; stretch.time.len()];
            stretch.covariates.push((Covariate::Temperature, temperature));
        }
        let found = dependence(&stretches, Covariate::Temperature).unwrap();
        assert!(
            found.bins.iter().all(|bin| bin.mean.abs() < 3.0 * bin.standard_error),
            "{found:?}"
        );
    }

    #[test]
    fn a_quantity_that_does_not_vary_is_left_out() {
        assert_eq!(dependence(&stretches(1.0), Covariate::Direction), None);
        assert_eq!(dependence(&stretches(1.0), Covariate::Temperature), None);
    }
}
