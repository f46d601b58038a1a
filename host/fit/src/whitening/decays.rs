//! Noise of which every part decays from sample to sample: flicker beside an autoregression that remembers one value.

use super::{
    Likelihood, SETTLED, STATES, Stretch, TIMES, decays, is_near, logarithms, states_of, sum,
};

/// The Kalman filter's gains, one sample after the other, by the Chandrasekhar recursions (see `Whitening::gains`) with a state of
/// fixed size.
pub(super) struct Gains {
    decays: [f64; STATES],
    /// The covariance of the state with the next sample.
    towards: [f64; STATES],
    change: [f64; STATES],
    pub(super) gain: [f64; STATES],
    variance: f64,
    weight: f64,
    least: f64,
}

impl Gains {
    /// At the first sample, of an autoregression with this coefficient, which has a standard deviation of its own and leaves
    /// another to chance, and flicker.
    pub(super) fn new(own: f64, (deviation, left): (f64, f64), flicker: f64) -> Self {
        let (flicker, decays) = (flicker.powi(2), states_of(own, decays()));
        let towards = states_of(deviation.powi(2), [flicker; TIMES.len()]);
        let variance = sum(&towards);
        let chance = decays[1..].iter().map(|decay| flicker * (1.0 - decay * decay)).sum::<f64>();
        let gain = towards.map(|towards| towards / variance);
        Self {
            decays,
            towards,
            change: std::array::from_fn(|k| gain[k] * decays[k]),
            gain,
            variance,
            weight: -variance,
            least: chance + left.powi(2),
        }
    }

    /// Standard deviation of what is left to chance.
    pub(super) fn left(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Goes to the next sample.
    pub(super) fn advance(&mut self) {
        let told = sum(&self.change);
        let next = (self.variance + self.weight * told * told).max(self.least);
        let (along, inverse) = (self.weight * told, 1.0 / next);
        for k in 0..STATES {
            self.towards[k] += along * self.change[k];
            self.change[k] = (self.change[k] - told * self.gain[k]) * self.decays[k];
            self.gain[k] = self.towards[k] * inverse;
        }
        self.weight *= self.variance * inverse;
        self.variance = next;
    }
}

/// The filter at one sample after the other.
#[derive(Clone, Copy, Default)]
pub(super) struct Filter {
    state: [f64; STATES],
}

impl Filter {
    /// A value, whitened.
    #[inline]
    pub(super) fn pass(
        &mut self,
        value: f64,
        (gain, left): (&[f64; STATES], f64),
        decays: &[f64; STATES],
    ) -> f64 {
        let innovation = value - sum(&self.state);
        for ((state, gain), decay) in self.state.iter_mut().zip(gain).zip(decays) {
            *state = (*state + gain * innovation) * decay;
        }
        innovation / left
    }
}

/// What [`Whitening::likelihood`](super::Whitening::likelihood) says of each stretch, for an autoregression of standard deviation 1
/// with this partial correlation, and flicker.
///
/// All in one pass: the gains, a unit level and every stretch are chains of numbers that each wait for the one before, and side by
/// side they do not wait for each other.
#[must_use]
pub fn likelihoods(partial: f64, flicker: f64, stretches: &[Stretch]) -> Vec<Likelihood> {
    let chance = (1.0 - partial * partial).max(1e-6).sqrt();
    let mut gains = Gains::new(partial, (1.0, chance), flicker);
    let decays = gains.decays;
    let longest = stretches.iter().map(Stretch::len).max().unwrap_or(0);
    let mut lefts: Vec<f64> = Vec::with_capacity(longest.min(SETTLED));
    let (mut before, mut settled) = (gains.gain, false);
    let (mut unit, mut of_unit) = (Filter::default(), 0.0);
    let mut sums = vec![(Filter::default(), [0.0; 3]); stretches.len()];
    for k in 0..longest {
        if !settled {
            let left = gains.left();
            let last = lefts.last().copied();
            settled = k + 1 >= SETTLED
                || last.is_some_and(|last| is_near((&before, last), (&gains.gain, left)));
            lefts.push(left);
            before = gains.gain;
        }
        let here = (&gains.gain, lefts[lefts.len() - 1]);
        let one = unit.pass(1.0, here, &decays);
        of_unit += one * one;
        for (stretch, (filter, [squares, both, unit])) in stretches.iter().zip(&mut sums) {
            let Some(&value) = stretch.values.get(k) else { continue };
            let value = filter.pass(value, here, &decays);
            *squares += value * value;
            *both += one * value;
            *unit = of_unit;
        }
        if !settled {
            gains.advance();
        }
    }
    let parts = |(stretch, (_, [squares, both, unit])): (&Stretch, &(Filter, [f64; 3]))| {
        let left = |k: usize| lefts[k.min(lefts.len() - 1)];
        Likelihood {
            squares: squares - both.powi(2) / unit,
            logarithms: 2.0 * logarithms(stretch.len(), lefts.len(), left) + unit.ln(),
        }
    };
    stretches.iter().zip(&sums).map(parts).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Whitening;
    use super::*;

    #[test]
    fn likelihoods_in_one_pass_are_those_of_the_filter_to_the_last_bit() {
        let value = |k: usize| (0.7 * k as f64).sin() + (0.013 * k as f64 * k as f64).cos();
        let stretch = |length: usize| Stretch::new((0..length).map(value).collect());
        for lengths in [&[40, 16, 131][..], &[700], &[9000, 20]] {
            let stretches: Vec<Stretch> = lengths.iter().copied().map(stretch).collect();
            let longest = lengths.iter().copied().max().unwrap();
            for (partial, flicker) in [(0.0, 0.3), (0.6, 1e-3), (-0.9, 0.02), (0.99, 5.0)] {
                let noise = Whitening::new(1.0, &[partial], flicker, longest);
                let expected: Vec<_> = stretches.iter().map(|it| noise.likelihood(it)).collect();
                assert_eq!(likelihoods(partial, flicker, &stretches), expected, "{partial}");
            }
        }
    }
}
