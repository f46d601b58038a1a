//! The filter that makes correlated noise white.
//!
//! Noise is a short autoregression, and where it wanders slower than one allows, flicker beside it: a
//! sum of first-order processes with times a factor apart, whose spectrum together falls as 1/f. The
//! filter subtracts what the samples before foretell and divides by what is then left to chance: for
//! the autoregression alone a fixed filter, with flicker a Kalman filter. Neighbours count by number,
//! whatever the time between them.

use std::sync::Arc;

use super::levels::Levels;

/// A model of noise, as a filter.
#[derive(Clone, Debug)]
pub struct Whitening {
    /// Prediction of a sample from those before, nearest first: one predictor for each number of
    /// samples before, up to the order.
    predictors: Vec<Vec<f64>>,
    /// Standard deviation of what each predictor leaves.
    left: Vec<f64>,
    /// Standard deviation of each process of the flicker.
    flicker: f64,
    /// The Kalman filter's gains; empty without flicker.
    schedule: Arc<Schedule>,
    /// No whitening at all.
    none: bool,
    /// Whether the size of the noise is a guess: what is left tells it then.
    guessed: bool,
    /// How slow noise moves the level of each trace.
    levels: Option<Arc<Levels>>,
}

/// What the Kalman filter does at each sample until that settles, one after the other: the gains of the autoregression's last values
/// and of the flicker, and the standard deviation of what is left to chance.
#[derive(Clone, Debug, Default)]
struct Schedule {
    order: usize,
    numbers: Vec<f64>,
}

impl Schedule {
    /// Numbers of a sample.
    fn stride(&self) -> usize {
        self.order + TIMES.len() + 1
    }

    /// Samples until it settles.
    fn len(&self) -> usize {
        self.numbers.len() / self.stride()
    }

    /// Gains of the autoregression, gains of the flicker, and what is left at a sample.
    fn at(&self, k: usize) -> (&[f64], &[f64], f64) {
        let stride = self.stride();
        let begin = k.min(self.len() - 1) * stride;
        let numbers = &self.numbers[begin..begin + stride];
        let (gains, left) = numbers.split_at(stride - 1);
        let (own, slow) = gains.split_at(self.order);
        (own, slow, left[0])
    }

    /// Gains of a state of fixed size, and what is left at a sample.
    #[inline]
    fn all_at(&self, k: usize) -> (&[f64; STATES], f64) {
        let (rows, _) = self.numbers.as_chunks::<{ STATES + 1 }>();
        let row = &rows[k.min(rows.len() - 1)];
        let (gain, left) = row.split_first_chunk::<STATES>().unwrap_or((&[0.0; STATES], &[1.0]));
        (gain, left[0])
    }

    /// Whether the last sample's numbers are these, as far as it matters.
    fn is_near(&self, gain: &[f64], left: f64) -> bool {
        if self.numbers.is_empty() {
            return false;
        }
        let (own, slow, before) = self.at(self.len() - 1);
        let moved = own.iter().chain(slow).zip(gain).map(|(a, b)| (a - b).abs());
        (left - before).abs() < 1e-9 * left && moved.fold(0.0, f64::max) < 1e-7
    }
}

/// Time constants of the processes that together are flicker, in samples.
const TIMES: [f64; 6] = [4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0];
/// Numbers of a state with one value of the autoregression.
const STATES: usize = 1 + TIMES.len();
/// Samples of rest as most recordings have them.
const USUAL: usize = 1024;
/// Factor between the times of neighbouring processes.
const APART: f64 = 4.0;
/// Samples after which the Kalman filter counts as settled at the latest.
const SETTLED: usize = 8192;

impl Whitening {
    /// Leaves everything as it is.
    #[must_use]
    pub fn none() -> Self {
        Self {
            predictors: vec![vec![]],
            left: vec![1.0],
            flicker: 0.0,
            schedule: Arc::default(),
            none: true,
            guessed: true,
            levels: None,
        }
    }

    /// For noise of this standard deviation with these partial correlations (each within −1 and 1, at
    /// distances 1, 2, …), and flicker whose processes have the standard deviation `flicker` each; for
    /// stretches of up to `longest` samples.
    #[must_use]
    pub fn new(standard_deviation: f64, partial: &[f64], flicker: f64, longest: usize) -> Self {
        let mut predictors: Vec<Vec<f64>> = vec![vec![]];
        let mut left = vec![standard_deviation];
        // Durbin and Levinson.
        for &reflection in partial {
            let before = &predictors[predictors.len() - 1];
            let mut next: Vec<f64> =
                before.iter().zip(before.iter().rev()).map(|(a, b)| a - reflection * b).collect();
            next.push(reflection);
            predictors.push(next);
            left.push(left[left.len() - 1] * (1.0 - reflection * reflection).max(1e-6).sqrt());
        }
        let mut noise = Self {
            predictors,
            left,
            flicker,
            schedule: Arc::default(),
            none: false,
            guessed: false,
            levels: None,
        };
        if flicker > 0.0 {
            noise.schedule = Arc::new(noise.gains(longest));
        }
        noise
    }

    /// Whether everything is left as it is.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.none
    }

    /// This noise with its size counted as a guess.
    #[must_use]
    pub fn guess(self) -> Self {
        Self { guessed: true, ..self }
    }

    /// This noise with its flicker running on through the pauses between traces, in the middle of which
    /// these times stand, in samples since the data set began; unchanged where there is no flicker.
    #[must_use]
    pub fn through_pauses(self, middles: &[f64]) -> Self {
        let end = middles.iter().copied().fold(0.0, f64::max);
        let longest = TIMES[TIMES.len() - 1];
        let times: Vec<f64> =
            std::iter::successors(Some(longest * APART), |time| Some(time * APART))
                .take_while(|time| *time < APART * end)
                .collect();
        let levels = Levels::of_processes(self.flicker, &times, middles).map(Arc::new);
        Self { levels, ..self }
    }

    /// How slow noise moves the level of each trace; none where it does not.
    #[must_use]
    pub fn levels(&self) -> Option<&Levels> {
        self.levels.as_deref()
    }

    /// A unit level over so many samples, whitened.
    #[must_use]
    pub fn unit_level(&self, samples: usize) -> Vec<f64> {
        let mut unit = vec![1.0; samples];
        self.apply(&mut unit);
        unit
    }

    /// Whether the size of the noise is a guess.
    #[must_use]
    pub fn is_guess(&self) -> bool {
        self.guessed
    }

    /// Standard deviation of one sample.
    #[must_use]
    pub fn standard_deviation(&self) -> f64 {
        (self.left[0].powi(2) + TIMES.len() as f64 * self.flicker.powi(2)).sqrt()
    }

    /// Standard deviation of each process of the flicker; 0 where there is none.
    #[must_use]
    pub fn flicker(&self) -> f64 {
        self.flicker
    }

    /// The coefficients of the autoregression, nearest first.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        self.predictors.last().map_or(&[], Vec::as_slice)
    }

    /// This noise made larger or smaller.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        scaled.flicker *= factor;
        scaled.left.iter_mut().for_each(|left| *left *= factor);
        let schedule = Arc::make_mut(&mut scaled.schedule);
        let stride = schedule.stride();
        schedule
            .numbers
            .iter_mut()
            .skip(stride - 1)
            .step_by(stride)
            .for_each(|left| *left *= factor);
        scaled
    }

    /// Whitens the samples of one stretch.
    pub fn apply(&self, values: &mut [f64]) {
        if self.none {
        } else if self.schedule.numbers.is_empty() {
            self.apply_autoregression(values);
        } else {
            self.apply_kalman(values);
        }
    }

    fn apply_autoregression(&self, values: &mut [f64]) {
        let order = self.predictors.len() - 1;
        // From the end, so that what is needed is still as it was.
        for k in (0..values.len()).rev() {
            let known = k.min(order);
            let mut value = values[k];
            for (distance, coefficient) in self.predictors[known].iter().enumerate() {
                value -= coefficient * values[k - 1 - distance];
            }
            values[k] = value / self.left[known];
        }
    }

    fn apply_kalman(&self, values: &mut [f64]) {
        match self.coefficients() {
            [] => self.apply_decays(0.0, values),
            [own] => self.apply_decays(*own, values),
            coefficients => self.apply_in_general(coefficients, values),
        }
    }

    /// Where the autoregression remembers one value, which decays like the flicker.
    fn apply_decays(&self, own: f64, values: &mut [f64]) {
        let decays = states_of(own, decays());
        let mut state = [0.0; STATES];
        for (k, value) in values.iter_mut().enumerate() {
            let (gain, left) = self.schedule.all_at(k);
            let innovation = *value - sum(&state);
            for ((state, gain), decay) in state.iter_mut().zip(gain).zip(&decays) {
                *state = (*state + gain * innovation) * decay;
            }
            *value = innovation / left;
        }
    }

    fn apply_in_general(&self, coefficients: &[f64], values: &mut [f64]) {
        let decays = decays();
        let mut own = vec![0.0; self.order()];
        let mut slow = [0.0; TIMES.len()];
        for (k, value) in values.iter_mut().enumerate() {
            let (own_gain, slow_gain, left) = self.schedule.at(k);
            let innovation = *value - own[0] - slow.iter().sum::<f64>();
            for (own, gain) in own.iter_mut().zip(own_gain) {
                *own += gain * innovation;
            }
            pass(&mut own, coefficients);
            for ((slow, gain), decay) in slow.iter_mut().zip(slow_gain).zip(&decays) {
                *slow = (*slow + gain * innovation) * decay;
            }
            *value = innovation / left;
        }
    }

    /// How many numbers the filter remembers from sample to sample.
    pub(super) fn states(&self) -> usize {
        if self.none {
            0
        } else if self.schedule.numbers.is_empty() {
            self.coefficients().len()
        } else {
            self.order() + TIMES.len()
        }
    }

    /// Samples of a stretch after which the filter does the same at each.
    pub(super) fn settles_after(&self) -> usize {
        self.schedule.len().max(self.predictors.len())
    }

    /// Whitens sample `k` of a stretch; `state` is what the filter remembers, zero before the first.
    pub(super) fn step(&self, k: usize, state: &mut [f64], value: f64) -> f64 {
        if self.none {
            return value;
        }
        if self.schedule.numbers.is_empty() {
            let known = k.min(self.predictors.len() - 1);
            let foretold: f64 =
                self.predictors[known].iter().zip(&*state).map(|(a, x)| a * x).sum();
            for place in (1..state.len()).rev() {
                state[place] = state[place - 1];
            }
            if let Some(last) = state.first_mut() {
                *last = value;
            }
            return (value - foretold) / self.left[known];
        }
        let (own_gain, slow_gain, left) = self.schedule.at(k);
        let (own, slow) = state.split_at_mut(self.order());
        let innovation = value - own[0] - slow.iter().sum::<f64>();
        for (own, gain) in own.iter_mut().zip(own_gain) {
            *own += gain * innovation;
        }
        pass(own, self.coefficients());
        for ((slow, gain), decay) in slow.iter_mut().zip(slow_gain).zip(decays()) {
            *slow = (*slow + gain * innovation) * decay;
        }
        innovation / left
    }

    /// Values of the autoregression that the Kalman filter keeps: at least the last.
    fn order(&self) -> usize {
        self.coefficients().len().max(1)
    }

    /// The Kalman filter's gains and standard deviations of the innovation, until they settle, by the Chandrasekhar recursions (Morf,
    /// Sidhu and Kailath, 1974): the covariance of a stationary state first changes by a matrix of rank one, and so it does from
    /// then on. A sample costs a few operations for each number of the state, not for each pair of them.
    fn gains(&self, longest: usize) -> Schedule {
        match self.coefficients() {
            [] => self.gains_of_decays(0.0, longest),
            [own] => self.gains_of_decays(*own, longest),
            _ => self.gains_in_general(longest),
        }
    }

    /// Where the autoregression remembers one value, which decays like the flicker: the same with a state of fixed size.
    fn gains_of_decays(&self, own: f64, longest: usize) -> Schedule {
        let (flicker, decays) = (self.flicker.powi(2), states_of(own, decays()));
        let mut towards = states_of(self.left[0].powi(2), [flicker; TIMES.len()]);
        let mut variance = sum(&towards);
        let chance = decays[1..].iter().map(|decay| flicker * (1.0 - decay * decay)).sum::<f64>();
        let least = chance + self.left[self.left.len() - 1].powi(2);
        let mut gain = towards.map(|towards| towards / variance);
        let mut change: [f64; STATES] = std::array::from_fn(|k| gain[k] * decays[k]);
        let mut weight = -variance;
        let mut found = Schedule { order: 1, numbers: Vec::new() };
        let most = longest.clamp(1, SETTLED);
        found.numbers.reserve(most.min(USUAL) * (STATES + 1));
        loop {
            let left = variance.sqrt();
            let settled = found.is_near(&gain, left);
            found.numbers.extend_from_slice(&gain);
            found.numbers.push(left);
            if settled || found.len() >= most {
                return found;
            }
            let told = sum(&change);
            let next = (variance + weight * told * told).max(least);
            let (along, inverse) = (weight * told, 1.0 / next);
            for k in 0..STATES {
                towards[k] += along * change[k];
                change[k] = (change[k] - told * gain[k]) * decays[k];
                gain[k] = towards[k] * inverse;
            }
            weight *= variance * inverse;
            variance = next;
        }
    }

    fn gains_in_general(&self, longest: usize) -> Schedule {
        let order = self.order();
        let (flicker, decays) = (self.flicker.powi(2), decays());
        let seen = |state: &[f64]| state[0] + state[order..].iter().sum::<f64>();
        // The covariance of the state, foretold from the samples before, with the next sample; and the variance of that.
        let mut towards = self.autocovariance(order);
        towards.extend([flicker; TIMES.len()]);
        let mut variance = seen(&towards);
        // What chance adds from one sample to the next is never foretold.
        let chance = decays.iter().map(|decay| flicker * (1.0 - decay * decay)).sum::<f64>();
        let least = chance + self.left[self.left.len() - 1].powi(2);
        let mut gain: Vec<f64> = towards.iter().map(|towards| towards / variance).collect();
        // From one sample to the next the covariance of the state changes by `weight` times `change` and its transpose.
        let mut change = gain.clone();
        self.advance(&mut change, &decays);
        let mut weight = -variance;
        let mut found = Schedule { order, numbers: Vec::new() };
        loop {
            let left = variance.sqrt();
            let settled = found.is_near(&gain, left);
            found.numbers.extend(gain.iter().chain([&left]));
            if settled || found.len() >= longest.clamp(1, SETTLED) {
                return found;
            }
            let told = seen(&change);
            let next = (variance + weight * told * told).max(least);
            for ((towards, change), gain) in towards.iter_mut().zip(&mut change).zip(&mut gain) {
                *towards += weight * told * *change;
                *change -= told * *gain;
                *gain = *towards / next;
            }
            self.advance(&mut change, &decays);
            weight *= variance / next;
            variance = next;
        }
    }

    /// What a sample of time does to a state: the autoregression's last values move up, the flicker decays.
    fn advance(&self, state: &mut [f64], decays: &[f64]) {
        let (own, slow) = state.split_at_mut(self.order());
        pass(own, self.coefficients());
        slow.iter_mut().zip(decays).for_each(|(slow, decay)| *slow *= decay);
    }

    /// Autocovariance of the autoregression at distances from 0 to below `count`.
    fn autocovariance(&self, count: usize) -> Vec<f64> {
        let mut found = vec![self.left[0].powi(2)];
        for distance in 1..count {
            let predictor = &self.predictors[distance.min(self.predictors.len() - 1)];
            let before = &self.predictors[distance - 1];
            let reflection = predictor.last().copied().unwrap_or(0.0);
            let foretold: f64 = before.iter().zip(found.iter().rev()).map(|(a, r)| a * r).sum();
            found.push(foretold + reflection * self.left[distance - 1].powi(2));
        }
        found
    }

    /// What the likelihood of values that are this noise about an unknown constant takes: minus twice
    /// its logarithm is `squares`/s² + `logarithms` + 2 (count − 1) ln s for this noise times s.
    #[must_use]
    pub fn likelihood(&self, stretch: &Stretch) -> Likelihood {
        let count = stretch.values.len();
        let [values, both, unit] = if self.schedule.numbers.is_empty() && self.reach() <= REACH {
            self.by_moments(stretch)
        } else {
            let mut values = stretch.values.clone();
            let mut ones = vec![1.0; count];
            self.apply(&mut values);
            self.apply(&mut ones);
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            [dot(&values, &values), dot(&ones, &values), dot(&ones, &ones)]
        };
        let own = &self.left;
        let left = |k: usize| match self.schedule.len() {
            0 => own[k],
            _ => self.schedule.at(k).2,
        };
        // From where it has settled, what is left is the same at each sample.
        let settled = self.schedule.len().max(own.len());
        // Few logarithms of products instead of many.
        let mut changing = 0.0;
        for begin in (0..count.min(settled)).step_by(AT_A_TIME) {
            let end = (begin + AT_A_TIME).min(count).min(settled);
            changing += (begin..end).map(left).product::<f64>().ln();
        }
        let rest = count.saturating_sub(settled) as f64 * left(settled - 1).ln();
        let logarithms = changing + rest;
        Likelihood {
            squares: values - both.powi(2) / unit,
            logarithms: 2.0 * logarithms + unit.ln(),
        }
    }

    /// Number of samples before one that the autoregression sees.
    fn reach(&self) -> usize {
        self.predictors.len() - 1
    }

    /// Inner products of the whitened values with themselves and with a whitened unit level, and of that with itself, without flicker.
    fn by_moments(&self, stretch: &Stretch) -> [f64; 3] {
        let (values, order) = (&stretch.values, self.reach());
        let [mut squares, mut both, mut unit] = [0.0; 3];
        for k in 0..values.len().min(REACH) {
            let known = k.min(order);
            let (predictor, left) = (&self.predictors[known], self.left[known]);
            let foretold: f64 =
                predictor.iter().zip(values[..k].iter().rev()).map(|(a, y)| a * y).sum();
            let value = (values[k] - foretold) / left;
            let one = (1.0 - predictor.iter().sum::<f64>()) / left;
            squares += value * value;
            both += value * one;
            unit += one * one;
        }
        let mut weights = [0.0; REACH + 1];
        weights[0] = 1.0;
        for (weight, coefficient) in weights[1..].iter_mut().zip(self.coefficients()) {
            *weight = -coefficient;
        }
        let scale = 1.0 / self.left[order].powi(2);
        let one: f64 = weights.iter().sum();
        for (a, products) in weights.iter().zip(&stretch.products) {
            squares += scale * a * weights.iter().zip(products).map(|(b, p)| b * p).sum::<f64>();
        }
        let sum: f64 = weights.iter().zip(&stretch.sums).map(|(a, sum)| a * sum).sum();
        both += scale * one * sum;
        unit += scale * one * one * values.len().saturating_sub(REACH) as f64;
        [squares, both, unit]
    }
}

/// Samples whose logarithms are taken together.
const AT_A_TIME: usize = 16;
/// Samples before one that moments go back to.
const REACH: usize = 3;

/// A stretch of noise, with what the likelihood of a short autoregression needs of it.
#[derive(Clone, Debug)]
pub struct Stretch {
    values: Vec<f64>,
    /// Sums of products of values so many samples before each, from the first on that has them all.
    products: [[f64; REACH + 1]; REACH + 1],
    /// Sums of those values.
    sums: [f64; REACH + 1],
}

impl Stretch {
    /// Of these values.
    #[must_use]
    pub fn new(values: Vec<f64>) -> Self {
        let mut products = [[0.0; REACH + 1]; REACH + 1];
        let mut sums = [0.0; REACH + 1];
        for window in values.windows(REACH + 1) {
            for i in 0..=REACH {
                let value = window[REACH - i];
                sums[i] += value;
                for j in 0..=REACH {
                    products[i][j] += value * window[REACH - j];
                }
            }
        }
        Self { values, products, sums }
    }

    /// Number of values.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
}

/// Parts of a likelihood.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Likelihood {
    /// Sum of squares of what chance would have to explain.
    pub squares: f64,
    /// Logarithm of the determinant.
    pub logarithms: f64,
}

/// The last values of an autoregression with these coefficients, one sample on.
fn pass(values: &mut [f64], coefficients: &[f64]) {
    let next: f64 = coefficients.iter().zip(&*values).map(|(a, x)| a * x).sum();
    // By hand: there is one value, or a few.
    for k in (1..values.len()).rev() {
        values[k] = values[k - 1];
    }
    values[0] = next;
}

/// A state with this value of the autoregression, and these of the flicker.
fn states_of(own: f64, slow: [f64; TIMES.len()]) -> [f64; STATES] {
    std::array::from_fn(|k| if k == 0 { own } else { slow[k - 1] })
}

/// What a sample shows of a state: in pairs, so that no addition waits for all before it.
fn sum(state: &[f64; STATES]) -> f64 {
    let [a, b, c, d, e, f, g] = state;
    ((a + b) + (c + d)) + ((e + f) + g)
}

fn decays() -> [f64; TIMES.len()] {
    TIMES.map(|time| (-1.0 / time).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn normal(count: usize, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| StandardNormal.sample(&mut random)).collect()
    }

    fn correlation(values: &[f64], distance: usize) -> f64 {
        let product: f64 = values.iter().zip(&values[distance..]).map(|(a, b)| a * b).sum();
        product / values.iter().map(|v| v * v).sum::<f64>()
    }

    #[test]
    fn an_autoregression_becomes_white_from_its_first_sample_on() {
        // Many short stretches: the first sample has the full standard deviation.
        let (a, sd) = (0.7, 2.0);
        let noise = Whitening::new(sd, &[a], 0.0, 0);
        let chance = normal(40_000, 1);
        let (mut first, mut all) = (Vec::new(), Vec::new());
        for chance in chance.chunks(8) {
            let mut values = vec![sd * chance[0]];
            for c in &chance[1..] {
                values.push(a * values[values.len() - 1] + sd * (1.0f64 - a * a).sqrt() * c);
            }
            noise.apply(&mut values);
            assert!(values.iter().zip(chance).all(|(w, c)| (w - c).abs() < 1e-9));
            first.push(values[0]);
            all.extend(values);
        }
        assert!(correlation(&all, 1).abs() < 0.01);
    }

    #[test]
    fn flicker_becomes_white() {
        let (sd, flicker) = (1.0, 0.8);
        let noise = Whitening::new(sd, &[0.5, 0.1], flicker, 30_000);
        let count = 30_000;
        let mut values = vec![0.0; count];
        let base = Whitening::new(sd, &[0.5, 0.1], 0.0, 0);
        let (c, last) = (base.coefficients().to_vec(), base.left[2]);
        let chance = normal(count, 2);
        for k in 2..count {
            values[k] = c[0] * values[k - 1] + c[1] * values[k - 2] + last * chance[k];
        }
        for (k, decay) in decays().into_iter().enumerate() {
            let mut state = 0.0;
            for (value, c) in values.iter_mut().zip(normal(count, 10 + k as u64)) {
                state = decay * state + flicker * (1.0 - decay * decay).sqrt() * c;
                *value += state;
            }
        }
        noise.apply(&mut values);
        let spread = values.iter().map(|v| v * v).sum::<f64>() / count as f64;
        assert!((spread - 1.0).abs() < 0.03, "{spread}");
        for distance in [1, 2, 5, 50, 500] {
            assert!(correlation(&values, distance).abs() < 0.02, "{distance}");
        }
    }

    #[test]
    fn the_likelihood_is_largest_at_the_noise_that_was() {
        let mut values = normal(4000, 3);
        for k in 1..values.len() {
            values[k] += 0.6 * values[k - 1];
        }
        let sd = 1.0 / (1.0f64 - 0.36).sqrt();
        let at = |sd: f64, a: f64, flicker: f64| {
            let noise = Whitening::new(sd, &[a], flicker, values.len());
            let parts = noise.likelihood(&Stretch::new(values.clone()));
            parts.squares + parts.logarithms
        };
        let best = at(sd, 0.6, 0.0);
        for other in [at(1.2 * sd, 0.6, 0.0), at(sd, 0.4, 0.0), at(sd, 0.6, 0.3)] {
            assert!(other > best + 5.0);
        }
    }

    #[test]
    fn the_moments_of_a_stretch_tell_its_likelihood() {
        let values = normal(300, 8);
        for partial in [&[][..], &[0.6], &[0.6, -0.3], &[0.6, -0.3, 0.2]] {
            let noise = Whitening::new(1.3, partial, 0.0, 0);
            let (mut white, mut ones) = (values.clone(), vec![1.0; values.len()]);
            noise.apply(&mut white);
            noise.apply(&mut ones);
            let found = noise.by_moments(&Stretch::new(values.clone()));
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let expected = [dot(&white, &white), dot(&ones, &white), dot(&ones, &ones)];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-10 * (1.0 + expected.abs()), "{partial:?}");
            }
        }
    }

    /// Gains and what is left at every sample by the Kalman filter's own equations, over the whole covariance of the state.
    fn by_riccati(noise: &Whitening, samples: usize) -> Vec<(Vec<f64>, f64)> {
        let (order, decays) = (noise.order(), decays());
        let size = order + TIMES.len();
        let (flicker, own) = (noise.flicker.powi(2), noise.autocovariance(order));
        let mut covariance = nalgebra::DMatrix::from_fn(size, size, |i, j| match (i, j) {
            (i, j) if i < order && j < order => own[i.abs_diff(j)],
            (i, j) if i == j => flicker,
            _ => 0.0,
        });
        let mut step = nalgebra::DMatrix::zeros(size, size);
        for (j, coefficient) in noise.coefficients().iter().enumerate() {
            step[(0, j)] = *coefficient;
        }
        (1..order).for_each(|i| step[(i, i - 1)] = 1.0);
        let mut chance = nalgebra::DMatrix::zeros(size, size);
        chance[(0, 0)] = noise.left[noise.left.len() - 1].powi(2);
        for (k, decay) in decays.iter().enumerate() {
            step[(order + k, order + k)] = *decay;
            chance[(order + k, order + k)] = flicker * (1.0 - decay * decay);
        }
        let seen = nalgebra::DVector::from_fn(size, |i, _| f64::from(i == 0 || i >= order));
        (0..samples)
            .map(|_| {
                let towards = &covariance * &seen;
                let variance = seen.dot(&towards);
                let gain = &towards / variance;
                let known = &covariance - &gain * towards.transpose();
                covariance = &step * known * step.transpose() + &chance;
                (gain.iter().copied().collect(), variance.sqrt())
            })
            .collect()
    }

    #[test]
    fn the_gains_are_those_of_the_kalman_filter() {
        let models: [&[f64]; 6] =
            [&[], &[0.5], &[-0.9], &[0.99, -0.3], &[0.9, 0.5, -0.7, 0.2], &[0.999, 0.9]];
        for partial in models {
            for flicker in [1e-3, 0.3, 30.0] {
                let noise = Whitening::new(1.5, partial, flicker, 1_500);
                let samples = noise.schedule.len();
                for (k, (gain, left)) in by_riccati(&noise, samples).iter().enumerate() {
                    let (own, slow, found) = noise.schedule.at(k);
                    let wrong = own.iter().chain(slow).zip(gain).map(|(a, b)| (a - b).abs());
                    let wrong = wrong.fold((found - left).abs() / left, f64::max);
                    assert!(wrong < 1e-8, "{partial:?}, {flicker}, sample {k}: {wrong}");
                }
            }
        }
    }
}
