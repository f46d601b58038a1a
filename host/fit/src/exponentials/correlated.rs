//! Standard errors where neighbouring residuals correlate.
//!
//! Residuals of a measured hold are rarely white: noise wanders, and what the law cannot follow stays. They
//! are taken as white noise plus a process whose correlation falls off as e^(−|t−t'|/T), a first-order
//! autoregression where the sampling is even. T and the share of white noise are not known: they go over a
//! grid, each member weighted by its restricted likelihood, which allows for what the fit has taken out of
//! the residuals. The covariance of least squares under each member is the sandwich
//! (JᵀJ)⁻¹ JᵀΣJ (JᵀJ)⁻¹; an interval holds its share of the mixture of all members' t distributions.

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::fit::{Fit, MOST_PARAMETERS, Normalisation, Note};
use crate::many_exp::exp;

/// How the residuals of a fit correlate.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlated {
    /// Correlation between a residual and the next.
    pub neighbours: f64,
    /// Correlation time T, s: the mean of its logarithm over all members.
    pub time: f64,
    /// How many times those of white noise the standard errors are, at most.
    pub inflation: f64,
    members: Vec<Member>,
}

/// One kind of noise.
#[derive(Clone, Debug, PartialEq)]
struct Member {
    weight: f64,
    /// Variance of each parameter.
    variance: [f64; MOST_PARAMETERS],
}

/// Share of pure white noise among all kinds, before the data.
const WHITE: f64 = 0.5;
/// Shares of white noise beside the process.
const SHARES: [f64; 3] = [0.0, 0.5, 0.9];
/// Correlation times on the grid, from half an interval to a tenth of the hold.
const TIMES: usize = 14;
const LONGEST: f64 = 0.1;
/// Members with less weight are left out.
const NO_WEIGHT: f64 = 1e-4;
/// Most samples that the grid runs over; of more, neighbours are averaged.
const MOST_SAMPLES: usize = 6000;
/// White noise that is always there, so that no covariance is singular.
const FLOOR: f64 = 1e-9;

/// Derivatives by the free coordinates, and last the residual.
type Row = [f64; MOST_PARAMETERS];

/// What the data are to the noise: derivatives and residual over time.
struct Linear {
    times: Vec<f64>,
    rows: Vec<Row>,
    /// Number of coordinates; the residual stands in the last column.
    count: usize,
    /// (JᵀJ)⁻¹.
    inverse: DMatrix<f64>,
}

const RESIDUAL: usize = MOST_PARAMETERS - 1;

impl Fit {
    /// This fit with standard errors and intervals that allow for the correlation of its residuals with
    /// their neighbours; as it is where its parameters are not determined.
    #[must_use]
    pub fn allowing_for_correlation(mut self, times: &[f64], values: &[f64]) -> Self {
        let coordinates = Coordinates::of(&self);
        let start = times[0];
        let row = |time: f64, value: f64| coordinates.row(&self, time - start, value);
        let Some(linear) = Linear::of(coordinates.count(), times, values, row) else { return self };
        let declared = coordinates.declared(&self);
        let size = declared.nrows();
        let white = self.covariance;
        let mut covariance = DMatrix::zeros(size, size);
        let mut members = Vec::new();
        let mut log_time = 0.0;
        for (weight, noise) in linear.posterior() {
            let own = &declared * linear.sandwich(noise) * declared.transpose();
            let mut variance = [0.0; MOST_PARAMETERS];
            for (k, variance) in variance.iter_mut().enumerate().take(size) {
                *variance = own[(k, k)];
            }
            covariance += weight * own;
            log_time += weight * noise.time.ln();
            members.push(Member { weight, variance });
        }
        if covariance.iter().any(|value| !value.is_finite()) {
            return self;
        }
        let mut inflation: f64 = 1.0;
        for i in 0..size {
            if self.determined[i] && white[i][i] > 0.0 {
                inflation = inflation.max((covariance[(i, i)] / white[i][i]).sqrt());
            }
            for j in 0..size {
                self.covariance[i][j] = covariance[(i, j)];
            }
        }
        let neighbours = linear.neighbours();
        self.correlated = Some(Correlated { neighbours, time: log_time.exp(), inflation, members });
        self
    }
}

/// Covariance of the coordinates of any least-squares fit over time that allows for the correlation of
/// residuals with their neighbours: `row` gives the `count` derivatives (at most nine) and the residual
/// (measured minus fitted) at a time since the first sample. None where the coordinates are not determined.
#[must_use]
pub fn correlated_covariance(
    times: &[f64],
    values: &[f64],
    count: usize,
    row: impl Fn(f64, f64) -> (Vec<f64>, f64),
) -> Option<DMatrix<f64>> {
    let start = times[0];
    let packed = |time: f64, value: f64| {
        let (derivatives, residual) = row(time - start, value);
        let mut packed = [0.0; MOST_PARAMETERS];
        packed[..count].copy_from_slice(&derivatives);
        packed[RESIDUAL] = residual;
        packed
    };
    let linear = Linear::of(count, times, values, packed)?;
    let mut covariance = DMatrix::zeros(count, count);
    for (weight, noise) in linear.posterior() {
        covariance += weight * linear.sandwich(noise);
    }
    covariance.iter().all(|value| value.is_finite()).then_some(covariance)
}

impl Correlated {
    /// Half the width of an interval of the parameter at this place that holds this share.
    pub(super) fn half(&self, place: usize, degrees: usize, level: f64) -> Option<f64> {
        let student = StudentsT::new(0.0, 1.0, degrees as f64).ok()?;
        // Terms that coincide leave rounding where a variance should be, of either sign.
        let known =
            |member: &Member| member.variance[place] > 0.0 && member.variance[place].is_finite();
        if !self.members.iter().all(known) {
            return None;
        }
        let within = |half: f64| {
            let one = |member: &Member| {
                let deviation = member.variance[place].sqrt();
                member.weight * (2.0 * student.cdf(half / deviation) - 1.0)
            };
            self.members.iter().map(one).sum::<f64>()
        };
        let widest = self.members.iter().map(|member| member.variance[place]).fold(0.0, f64::max);
        let (mut below, mut above) = (0.0, widest.sqrt());
        while within(above) < level {
            above *= 2.0;
            if !above.is_finite() || above == 0.0 {
                return None;
            }
        }
        for _ in 0..50 {
            let middle = 0.5 * (below + above);
            if within(middle) < level { below = middle } else { above = middle }
        }
        Some(above)
    }
}

/// Coordinates in which a sum of exponentials is linear or nearly so: the constant, amplitudes, and
/// logarithms of rates; without what is held at zero.
struct Coordinates {
    constant: bool,
    terms: Vec<usize>,
}

impl Coordinates {
    fn of(fit: &Fit) -> Self {
        let held = |k: usize| fit.notes.contains(&Note::Vanishes { term: k + 1 });
        let terms = (0..fit.sum.terms.len()).filter(|&k| !held(k)).collect();
        Self { constant: !fit.notes.contains(&Note::ConstantAtZero), terms }
    }

    fn count(&self) -> usize {
        usize::from(self.constant) + 2 * self.terms.len()
    }

    /// The change of N, c0 … cn, v1 … vn with each coordinate.
    fn declared(&self, fit: &Fit) -> DMatrix<f64> {
        let (sum, terms) = (&fit.sum, fit.sum.terms.len());
        let mut matrix = DMatrix::zeros(2 + 2 * terms, self.count());
        let mut column = 0;
        let mut amplitude = |of: Option<usize>, matrix: &mut DMatrix<f64>| {
            let scale = match fit.normalisation {
                Normalisation::Initial => 1.0,
                Normalisation::Asymptotic => f64::from(u8::from(of.is_none())),
            };
            let coefficients = std::iter::once(sum.constant)
                .chain(sum.terms.iter().map(|term| term.coefficient))
                .enumerate();
            matrix[(0, column)] = scale;
            for (k, coefficient) in coefficients {
                let own = f64::from(u8::from(of.map_or(0, |of| of + 1) == k));
                matrix[(1 + k, column)] = (own - coefficient * scale) / sum.scale;
            }
            column += 1;
        };
        if self.constant {
            amplitude(None, &mut matrix);
        }
        for &k in &self.terms {
            amplitude(Some(k), &mut matrix);
        }
        for (place, &k) in self.terms.iter().enumerate() {
            let column = usize::from(self.constant) + self.terms.len() + place;
            matrix[(2 + terms + k, column)] = sum.terms[k].rate;
        }
        matrix
    }

    fn row(&self, fit: &Fit, time: f64, value: f64) -> Row {
        let mut row = [0.0; MOST_PARAMETERS];
        let mut place = 0;
        let mut put = |derivative: f64| {
            row[place] = derivative;
            place += 1;
        };
        if self.constant {
            put(1.0);
        }
        let mut decays = [0.0; MOST_PARAMETERS];
        for (&k, kept) in self.terms.iter().zip(&mut decays) {
            *kept = exp(-fit.sum.terms[k].rate * time);
            put(*kept);
        }
        for (&k, decay) in self.terms.iter().zip(decays) {
            let term = fit.sum.terms[k];
            put(-fit.sum.scale * term.coefficient * term.rate * time * decay);
        }
        row[RESIDUAL] = value - fit.sum.at(time);
        row
    }
}

/// White noise beside a process with a correlation time, s; both together have a variance of 1 times a
/// scale.
#[derive(Clone, Copy)]
struct Noise {
    time: f64,
    white: f64,
    scale: f64,
}

impl Linear {
    fn of(
        count: usize,
        times: &[f64],
        values: &[f64],
        row: impl Fn(f64, f64) -> Row,
    ) -> Option<Self> {
        let together = times.len().div_ceil(MOST_SAMPLES).max(1);
        let samples = || times.chunks(together).zip(values.chunks(together));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let rows: Vec<Row> = samples()
            .map(|(times, values)| {
                let mut sum = [0.0; MOST_PARAMETERS];
                for (time, value) in times.iter().zip(values) {
                    sum.iter_mut().zip(row(*time, *value)).for_each(|(sum, value)| *sum += value);
                }
                sum.map(|sum| sum / times.len() as f64)
            })
            .collect();
        let mut products = DMatrix::zeros(count, count);
        for row in &rows {
            for i in 0..count {
                for j in 0..count {
                    products[(i, j)] += row[i] * row[j];
                }
            }
        }
        // Columns differ by many orders; scaled, what is singular shows.
        let scale = products.diagonal().map(f64::sqrt);
        let scaled = DMatrix::from_fn(count, count, |i, j| products[(i, j)] / scale[i] / scale[j]);
        let inverse = scaled.cholesky()?.inverse();
        let inverse = DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] / scale[i] / scale[j]);
        let known = rows.len() > count + 1 && inverse.iter().all(|value| value.is_finite());
        known.then(|| Self { times: samples().map(|s| mean(s.0)).collect(), rows, count, inverse })
    }

    /// Correlation between a residual and the next.
    fn neighbours(&self) -> f64 {
        let residual = || self.rows.iter().map(|row| row[RESIDUAL]);
        let products: f64 = residual().zip(residual().skip(1)).map(|(a, b)| a * b).sum();
        let squares: f64 = residual().map(|r| r * r).sum();
        if squares > 0.0 { products / squares } else { 0.0 }
    }

    /// The kinds of noise with their weights, which sum to one.
    fn posterior(&self) -> Vec<(f64, Noise)> {
        let mut intervals: Vec<f64> = self.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        intervals.sort_by(f64::total_cmp);
        let shortest = 0.5 * intervals[intervals.len() / 2];
        let duration = self.times[self.times.len() - 1] - self.times[0];
        let ratio = (LONGEST * duration / shortest).max(2.0);
        let each = (1.0 - WHITE) / (TIMES * SHARES.len()) as f64;
        let member = |prior: f64, time: f64, decays: &[f64], white: f64| {
            let (log, scale) = self.likelihood(decays, white);
            (log + prior.ln(), Noise { time, white, scale })
        };
        let mut members = vec![member(WHITE, shortest, &self.decays(shortest), 1.0)];
        for k in 0..TIMES {
            let time = shortest * ratio.powf(k as f64 / (TIMES - 1) as f64);
            let decays = self.decays(time);
            members.extend(SHARES.map(|white| member(each, time, &decays, white)));
        }
        members.retain(|member| member.0.is_finite());
        let best = members.iter().map(|member| member.0).fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = members.iter().map(|member| (member.0 - best).exp()).sum();
        let weighted = members.iter().map(|&(log, noise)| ((log - best).exp() / sum, noise));
        let kept: Vec<(f64, Noise)> = weighted.filter(|member| member.0 > NO_WEIGHT).collect();
        let sum: f64 = kept.iter().map(|member| member.0).sum();
        kept.into_iter().map(|(weight, noise)| (weight / sum, noise)).collect()
    }

    /// How much of a process with a correlation time, s, is left from each sample to the next.
    fn decays(&self, time: f64) -> Vec<f64> {
        self.times.windows(2).map(|pair| exp(-(pair[1] - pair[0]) / time)).collect()
    }

    /// Logarithm of the restricted likelihood, up to a constant, and the scale of the noise, by a Kalman
    /// filter over all columns at once; of a process beside so much white noise, with what is left of it from sample to sample.
    fn likelihood(&self, decays: &[f64], white: f64) -> (f64, f64) {
        let count = self.count;
        let (mut state, mut variance) = ([0.0; MOST_PARAMETERS], 1.0 - white);
        // The residual behind the derivatives.
        let mut products = [[0.0; MOST_PARAMETERS]; MOST_PARAMETERS];
        let mut log = 0.0;
        for (k, row) in self.rows.iter().enumerate() {
            if let Some(decay) = k.checked_sub(1).and_then(|before| decays.get(before)) {
                state.iter_mut().for_each(|state| *state *= decay);
                variance = decay * decay * variance + (1.0 - white) * (1.0 - decay * decay);
            }
            let total = variance + white + FLOOR;
            let inverse = total.recip();
            let gain = variance * inverse;
            let mut innovation = *row;
            innovation[count] = row[RESIDUAL];
            for (innovation, state) in innovation.iter_mut().zip(&mut state) {
                *innovation -= *state;
                *state += gain * *innovation;
            }
            variance *= 1.0 - gain;
            log += total.ln();
            for (i, products) in products.iter_mut().enumerate().take(count + 1) {
                let weighted = innovation[i] * inverse;
                for (product, other) in products.iter_mut().zip(&innovation).take(i + 1) {
                    *product += weighted * other;
                }
            }
        }
        let whitened = DMatrix::from_fn(count, count, |i, j| products[i.max(j)][i.min(j)]);
        let along = nalgebra::DVector::from_fn(count, |i, _| products[count][i]);
        let Some(factor) = whitened.cholesky() else { return (f64::NEG_INFINITY, 0.0) };
        let rest = products[count][count] - along.dot(&factor.solve(&along));
        let degrees = (self.rows.len() - count) as f64;
        let scale = rest.max(f64::MIN_POSITIVE) / degrees;
        let determinant: f64 = (0..count).map(|i| 2.0 * factor.l()[(i, i)].ln()).sum();
        (-0.5 * (degrees * scale.ln() + log + determinant), scale)
    }

    /// Covariance of the coordinates as least squares finds them.
    fn sandwich(&self, noise: Noise) -> DMatrix<f64> {
        let count = self.count;
        let mut before = [0.0; MOST_PARAMETERS];
        let mut middle = DMatrix::zeros(count, count);
        let decays = self.decays(noise.time);
        for (k, row) in self.rows.iter().enumerate() {
            if let Some(decay) = k.checked_sub(1).and_then(|before| decays.get(before)) {
                before.iter_mut().for_each(|sum| *sum *= decay);
            }
            for i in 0..count {
                for j in 0..count {
                    let both = row[i] * before[j] + before[i] * row[j];
                    middle[(i, j)] += row[i] * row[j] + (1.0 - noise.white) * both;
                }
            }
            before.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        &self.inverse * middle * &self.inverse * noise.scale
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::super::fit::{Options, Parameter};
    use super::super::{ExponentialSum, Prepared, Term};
    use super::{Correlated, MOST_PARAMETERS, Member};

    #[test]
    fn a_variance_that_is_lost_in_rounding_has_no_interval() {
        let of = |value: f64| Correlated {
            neighbours: 0.0,
            time: 0.1,
            inflation: 1.0,
            members: vec![
                Member { weight: 0.5, variance: [1.0; MOST_PARAMETERS] },
                Member { weight: 0.5, variance: [value; MOST_PARAMETERS] },
            ],
        };
        assert!(of(1.0).half(0, 50, 0.95).is_some_and(|half| (1.9..2.1).contains(&half)));
        for lost in [-1e-20, 0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(of(lost).half(0, 50, 0.95), None, "{lost}");
        }
    }

    /// Eqs 3.5 and 3.6.
    fn truth() -> ExponentialSum {
        let term = |coefficient, rate| Term { coefficient, rate };
        let terms = vec![term(0.2472, 3.981), term(0.2676, 0.5325)];
        ExponentialSum { scale: 2.187, constant: 0.4852, terms }
    }

    /// How the samples of a hold lie in time.
    #[derive(Clone, Copy, Debug)]
    enum Instants {
        Even,
        Random,
        Bursts,
    }

    /// A hold of so many samples over so many seconds; a sample remembers the one an even interval before
    /// by `memory`, and beside that has white noise of `white` times its deviation.
    #[derive(Clone, Copy, Debug)]
    struct Case {
        samples: usize,
        seconds: f64,
        memory: f64,
        white: f64,
        instants: Instants,
    }

    const NOISE: f64 = 0.01;

    impl Case {
        fn times(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
            let interval = self.seconds / self.samples as f64;
            let mut times: Vec<f64> = (0..self.samples)
                .map(|k| match self.instants {
                    Instants::Even => k as f64 * interval,
                    Instants::Random => random.random_range(0.0..self.seconds),
                    Instants::Bursts => (3 * (k / 3)) as f64 * interval + (k % 3) as f64 * 1e-3,
                })
                .collect();
            times.sort_by(f64::total_cmp);
            times
        }

        fn values(&self, times: &[f64], random: &mut ChaCha8Rng) -> Vec<f64> {
            let normal = Normal::new(0.0, 1.0).unwrap();
            let interval = self.seconds / self.samples as f64;
            let mut wander = normal.sample(random);
            let mut before = times[0];
            let value = |&time: &f64| {
                let memory = if self.memory > 0.0 {
                    self.memory.powf((time - before) / interval)
                } else {
                    0.0
                };
                before = time;
                wander = memory * wander + (1.0 - memory * memory).sqrt() * normal.sample(random);
                let noise = wander + self.white * normal.sample(random);
                truth().at(time - times[0]) + NOISE * noise
            };
            times.iter().map(value).collect()
        }

        /// Part of the 95 % intervals that hold the truth, for each parameter: with the correlation, and
        /// as if the noise were white.
        fn coverage(&self, copies: u32, seed: u64) -> Vec<(Parameter, f64, f64)> {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let parameters: Vec<Parameter> = Parameter::all(2).collect();
            let mut hits = vec![(0u32, 0u32, 0u32); parameters.len()];
            for _ in 0..copies {
                let times = self.times(&mut random);
                let values = self.values(&times, &mut random);
                let prepared = Prepared::new(&times, &Options::default()).unwrap();
                let white = prepared.fit(&values).unwrap();
                let fit = white.clone().allowing_for_correlation(&times, &values);
                for (parameter, hits) in parameters.iter().zip(&mut hits) {
                    let wanted = truth().value(*parameter).unwrap();
                    let within = |interval: Option<(f64, f64)>| {
                        interval.map(|(low, high)| u32::from(low <= wanted && wanted <= high))
                    };
                    if let Some(hit) = within(fit.interval(*parameter, 0.95)) {
                        hits.0 += hit;
                        hits.1 += within(white.interval(*parameter, 0.95)).unwrap_or(0);
                        hits.2 += 1;
                    }
                }
            }
            let part = |hits: u32, of: u32| f64::from(hits) / f64::from(of.max(1));
            let all = parameters.into_iter().zip(hits);
            all.map(|(p, (own, white, of))| (p, part(own, of), part(white, of))).collect()
        }
    }

    const HOLD: Case =
        Case { samples: 860, seconds: 4.3, memory: 0.0, white: 0.0, instants: Instants::Even };

    #[test]
    fn intervals_hold_the_truth_whatever_the_noise_remembers() {
        let random = Case { instants: Instants::Random, ..HOLD };
        for case in [HOLD, Case { memory: 0.95, ..HOLD }, Case { memory: 0.9, ..random }] {
            for (parameter, own, white) in case.coverage(60, 3) {
                assert!(own >= 0.85, "{case:?} {parameter}: {own}");
                assert!(case.memory == 0.0 || white < 0.6, "{case:?} {parameter}: {white}");
            }
        }
    }

    #[test]
    fn white_noise_has_the_errors_of_white_noise() {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut ratios = Vec::new();
        for _ in 0..30 {
            let times = HOLD.times(&mut random);
            let values = HOLD.values(&times, &mut random);
            let fit = Prepared::new(&times, &Options::default()).unwrap().fit(&values).unwrap();
            let white = fit.standard_error(Parameter::Rate(1)).unwrap();
            let fit = fit.allowing_for_correlation(&times, &values);
            ratios.push(fit.standard_error(Parameter::Rate(1)).unwrap() / white);
        }
        ratios.sort_by(f64::total_cmp);
        assert!((ratios[15] - 1.0).abs() < 0.1, "{ratios:?}");
    }

    /// The figures of docs/measured.md.
    #[test]
    #[ignore = "minutes: the figures of docs/measured.md"]
    fn coverage_of_intervals() {
        let random = Case { instants: Instants::Random, ..HOLD };
        let bursts = Case { instants: Instants::Bursts, ..HOLD };
        for case in [
            HOLD,
            Case { memory: 0.5, ..HOLD },
            Case { memory: 0.8, ..HOLD },
            Case { memory: 0.95, ..HOLD },
            Case { memory: 0.95, white: 1.0, ..HOLD },
            Case { memory: 0.95, samples: 3000, seconds: 15.0, ..HOLD },
            random,
            Case { memory: 0.95, ..random },
            Case { memory: 0.95, ..bursts },
            Case { samples: 100, ..HOLD },
            Case { samples: 100, memory: 0.8, ..HOLD },
            Case { samples: 10, seconds: 8.0, ..HOLD },
        ] {
            println!("{case:?}, seed 1");
            for (parameter, own, white) in case.coverage(1000, 1) {
                println!(
                    "  {parameter}: {:.1} %, as white noise {:.1} %",
                    100.0 * own,
                    100.0 * white
                );
            }
        }
    }
}
