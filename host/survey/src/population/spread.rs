//! How much a number varies beyond its errors: restricted maximum likelihood for values with known standard errors.
//!
//! A value of a group is the typical value, plus what its specimen is off, plus what the occasion is off, plus the error of its fit.
//! Specimens and occasions are normal with standard deviations that are estimated; where each specimen was asked once, the two are one.
//! This is the second stage of the two-stage estimate of a mixed model (Steimer, Mallet, Golmard and Boisvieux 1984), and the
//! random-effects model of meta-analysis. Intervals of a spread are those of the profile of the restricted likelihood.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// A value with the square of its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    pub(super) value: f64,
    pub(super) variance: f64,
}

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// The number.
    pub value: f64,
    /// From where on.
    pub lower: f64,
    /// Up to where.
    pub upper: f64,
}

/// A standard deviation beyond the errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The standard deviation; the lower end of its interval is 0 where none is as likely.
    pub deviation: Between,
    /// p value of as much where there is none.
    pub p_value: f64,
}

/// What values say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Together {
    /// Mean over the specimens.
    pub(super) mean: Between,
    /// From specimen to specimen.
    pub(super) specimens: Spread,
    /// From one occasion to another of a specimen; none where each was asked once.
    pub(super) occasions: Option<Spread>,
}

/// Chance that a 95 % interval leaves on either side.
const TAIL: f64 = 0.025;
/// Steps of the coarse grid on which a likelihood is looked at first.
const GRID: usize = 16;
/// Golden sections, each of which leaves 0.62 of what the last left.
const SECTIONS: usize = 30;
/// Halvings in which the end of an interval is found.
const HALVINGS: usize = 40;
/// Largest standard deviation that is tried, in those of the values themselves.
const WIDEST: f64 = 20.0;

/// What the values of specimens, each with one or more occasions, say together; none of fewer than three specimens.
pub(super) fn together(specimens: &[Vec<Known>]) -> Option<Together> {
    if specimens.len() < 3 {
        return None;
    }
    let repeated = specimens.iter().any(|occasions| occasions.len() > 1);
    let model = Model { specimens, unit: deviation(specimens)?, repeated };
    let best = model.best_between();
    let within = model.best_within(best);
    let most = model.at(best, within);
    let degrees = specimens.len() as f64 - 1.0;
    let width =
        StudentsT::new(0.0, 1.0, degrees).ok()?.inverse_cdf(1.0 - TAIL) / most.weight.sqrt();
    let mean = Between { value: most.mean, lower: most.mean - width, upper: most.mean + width };
    let of_specimens = |between| model.at(between, model.best_within(between)).log;
    let of_occasions = |within| model.at(model.best_between_beside(within), within).log;
    Some(Together {
        mean,
        specimens: model.spread(best, most.log, of_specimens),
        occasions: repeated.then(|| model.spread(within, most.log, of_occasions)),
    })
}

/// Standard deviation of all values; none where they are all the same or an error is none.
fn deviation(specimens: &[Vec<Known>]) -> Option<f64> {
    let all = || specimens.iter().flatten();
    let count = all().count() as f64;
    let mean = all().map(|known| known.value).sum::<f64>() / count;
    let squares = all().map(|known| (known.value - mean).powi(2)).sum::<f64>();
    let deviation = (squares / (count - 1.0)).sqrt();
    (deviation > 0.0 && deviation.is_finite() && all().all(|known| known.variance > 0.0))
        .then_some(deviation)
}

struct Model<'a> {
    specimens: &'a [Vec<Known>],
    unit: f64,
    repeated: bool,
}

/// The restricted likelihood at two standard deviations.
struct At {
    log: f64,
    mean: f64,
    /// One over the variance of the mean.
    weight: f64,
}

impl Model<'_> {
    /// The variance of a specimen's values is that of the errors and of the occasions on the diagonal, that between specimens
    /// everywhere: its inverse and its determinant need sums only.
    fn at(&self, between: f64, within: f64) -> At {
        let (between, within) = (between * between, within * within);
        let (mut determinants, mut weight, mut along, mut squares) = (0.0, 0.0, 0.0, 0.0);
        for occasions in self.specimens {
            let (mut ones, mut first, mut second) = (0.0, 0.0, 0.0);
            for Known { value, variance } in occasions {
                let inverse = 1.0 / (variance + within);
                ones += inverse;
                first += inverse * value;
                second += inverse * value * value;
                determinants -= inverse.ln();
            }
            let shared = 1.0 + between * ones;
            determinants += shared.ln();
            weight += ones / shared;
            along += first / shared;
            squares += second - between * first * first / shared;
        }
        let log = -0.5 * (determinants + weight.ln() + squares - along * along / weight);
        At { log, mean: along / weight, weight }
    }

    fn best_within(&self, between: f64) -> f64 {
        if self.repeated { self.peak(|within| self.at(between, within).log) } else { 0.0 }
    }

    fn best_between_beside(&self, within: f64) -> f64 {
        self.peak(|between| self.at(between, within).log)
    }

    fn best_between(&self) -> f64 {
        self.peak(|between| self.at(between, self.best_within(between)).log)
    }

    /// Where a likelihood is largest: the best of a grid that is finest at 0, refined by golden sections.
    fn peak(&self, of: impl Fn(f64) -> f64) -> f64 {
        let at = |k: usize| 3.0 * self.unit * (k as f64 / GRID as f64).powi(2);
        let heights: Vec<f64> = (0..=GRID).map(|k| of(at(k))).collect();
        let best = (0..=GRID).max_by(|&a, &b| heights[a].total_cmp(&heights[b])).unwrap_or(0);
        let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(GRID)));
        let part = 0.5 * (5.0_f64.sqrt() - 1.0);
        let inner = |low: f64, high: f64| (high - part * (high - low), low + part * (high - low));
        let (mut a, mut b) = inner(low, high);
        let (mut of_a, mut of_b) = (of(a), of(b));
        for _ in 0..SECTIONS {
            if of_a >= of_b {
                (high, b, of_b) = (b, a, of_a);
                a = inner(low, high).0;
                of_a = of(a);
            } else {
                (low, a, of_a) = (a, b, of_b);
                b = inner(low, high).1;
                of_b = of(b);
            }
        }
        let found = 0.5 * (low + high);
        if heights[0] >= of(found) { 0.0 } else { found }
    }

    /// A standard deviation that is likeliest at `best`, where the logarithm of the likelihood is `most`.
    fn spread(&self, best: f64, most: f64, profile: impl Fn(f64) -> f64) -> Spread {
        let chi_squared = ChiSquared::new(1.0).ok();
        let fall = chi_squared.map_or(3.84, |it| it.inverse_cdf(1.0 - 2.0 * TAIL));
        let falls = |deviation: f64| 2.0 * (most - profile(deviation));
        // On the edge of what can be, half the chance of a square of a normal number (Self and Liang 1987).
        let gain = falls(0.0).max(0.0);
        let p_value = match (chi_squared, gain > 0.0) {
            (Some(it), true) => 0.5 * it.sf(gain),
            _ => 1.0,
        };
        let lower = if gain <= fall { 0.0 } else { crossing(0.0, best, |at| falls(at) > fall) };
        let mut outside = best.max(0.1 * self.unit);
        while falls(outside) <= fall && outside < WIDEST * self.unit {
            outside *= 2.0;
        }
        let upper = crossing(outside, best, |at| falls(at) > fall);
        Spread { deviation: Between { value: best, lower, upper }, p_value }
    }
}

/// Where on the way from a place that is outside to one that is inside the edge lies.
fn crossing(mut outside: f64, mut inside: f64, is_outside: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (outside + inside);
        if is_outside(middle) { outside = middle } else { inside = middle }
    }
    0.5 * (outside + inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Specimens with a mean of 5, of which each has so many occasions; errors from 0.05 to 0.15.
    fn drawn(
        count: usize,
        repeats: usize,
        between: f64,
        within: f64,
        random: &mut ChaCha8Rng,
    ) -> Vec<Vec<Known>> {
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let mut specimen = |k: usize| {
            let own = 5.0 + between * normal();
            let mut occasion = |j: usize| {
                let error = 0.05 + 0.1 * ((3 * k + j) % 5) as f64 / 4.0;
                let value = own + within * normal() + error * normal();
                Known { value, variance: error * error }
            };
            (0..repeats).map(&mut occasion).collect()
        };
        (0..count).map(&mut specimen).collect()
    }

    /// How often, of 400 draws, the truth lies in the intervals of mean and spread, and the mean of the spread.
    fn covered(count: usize, repeats: usize, between: f64, within: f64) -> [f64; 4] {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let holds = |of: Between, truth: f64| f64::from(of.lower <= truth && truth <= of.upper);
        let mut sums = [0.0; 4];
        for _ in 0..400 {
            let found = together(&drawn(count, repeats, between, within, &mut random)).unwrap();
            let spread = found.specimens;
            let alarm = f64::from(spread.p_value < 0.05);
            let of_draw = [
                holds(found.mean, 5.0),
                holds(spread.deviation, between),
                spread.deviation.value,
                alarm,
            ];
            sums.iter_mut().zip(of_draw).for_each(|(sum, one)| *sum += one / 400.0);
        }
        sums
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        for (count, repeats, between, within) in
            [(12, 1, 0.1, 0.0), (60, 1, 0.3, 0.0), (12, 1, 0.02, 0.0), (15, 3, 0.2, 0.1)]
        {
            let [mean, spread, value, _] = covered(count, repeats, between, within);
            println!("{count} {repeats} {between} {within}: {mean:.3} {spread:.3} {value:.3}");
            assert!((0.925..=0.985).contains(&mean), "mean: {mean}");
            assert!((0.925..=0.995).contains(&spread), "spread: {spread}");
            assert!(
                (value / between - 1.0).abs() < 0.15 || between < 0.05,
                "{value} for {between}"
            );
        }
    }

    #[test]
    fn what_all_specimens_share_is_seldom_said_to_vary() {
        for count in [6, 30, 200] {
            let [.., alarms] = covered(count, 1, 0.0, 0.0);
            assert!((0.015..0.075).contains(&alarms), "{count}: {alarms}");
        }
    }

    #[test]
    fn occasions_are_told_from_specimens() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let found = together(&drawn(80, 4, 0.05, 0.4, &mut random)).unwrap();
        let occasions = found.occasions.unwrap();
        assert!((occasions.deviation.value - 0.4).abs() < 0.05, "{found:?}");
        assert!(found.specimens.deviation.value < 0.15 && occasions.p_value < 1e-6, "{found:?}");
    }

    /// The paired estimate by hand: with equal errors, the variance of the values less that of an error.
    #[test]
    fn equal_errors_give_the_variance_less_that_of_an_error() {
        let known = |value| vec![Known { value, variance: 0.25 }];
        let found = together(&[1.0, 2.0, 4.0, 5.0].map(known)).unwrap();
        assert!((found.mean.value - 3.0).abs() < 1e-9);
        let expected = (10.0_f64 / 3.0 - 0.25).sqrt();
        assert!((found.specimens.deviation.value - expected).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn too_few_specimens_or_none_that_differ_say_nothing() {
        let known = |value| vec![Known { value, variance: 0.25 }];
        assert_eq!(together(&[1.0, 2.0].map(known)), None);
        assert_eq!(together(&[2.0; 5].map(known)), None);
    }
}
