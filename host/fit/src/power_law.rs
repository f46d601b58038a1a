//! The power law of the latency model over one hold: ε̇ = −ν sgn(ε − ε_e) |ε − ε_e|^n (eqs 7.2, 7.3).
//!
//! What is fitted is the strain itself, with the closed forms (7.4) and (7.5).

use nalgebra::DVector;

use super::least_squares::{LeastSquares, Normal, minimise};
use super::uncertainty;
use palpate_model::latency::{Power, decay};

/// The odd orders among which the lowest that fits is looked for.
pub const ODD_ORDERS: [f64; 6] = [1.0, 3.0, 5.0, 7.0, 9.0, 11.0];
/// Highest order of a free fit.
const HIGHEST: f64 = 25.0;

/// A value with its standard error, where the data determine it.
pub type Estimate = (f64, Option<f64>);

/// The power law fitted to one hold.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerFit {
    /// The law.
    pub law: Power,
    /// n; without a standard error where it was given.
    pub order: Estimate,
    /// ν, 1/s, with the standard error of ln ν: a factor, for ν spans decades.
    pub rate: Estimate,
    /// ε_e.
    pub equilibrium: Estimate,
    /// ε_0 − ε_e.
    pub gap: Estimate,
    /// ε_0.
    pub initial: Estimate,
    /// Correlation of ln ν and n, of a free fit.
    pub trade_off: Option<f64>,
    /// Sum of squared residuals.
    pub rss: f64,
    /// Standard deviation of the residuals.
    pub noise: f64,
    /// Share of the variance about the mean that is explained.
    pub r_squared: f64,
    /// Share of the gap that is still open at the end of the hold.
    pub left: f64,
    /// What of it the hold does not tell, in words.
    pub doubts: Vec<String>,
}

/// Fits the law to strains at times since the hold began, s, with this order, or with a free one.
///
/// # Panics
/// If there are fewer than two samples, or not one strain for each time.
#[must_use]
pub fn fit(time: &[f64], strain: &[f64], order: Option<f64>) -> PowerFit {
    let problem = Problem::new(time, strain, order);
    let solution = minimise(&problem, &problem.start());
    let (samples, free) = (time.len() as f64, solution.point.len() as f64);
    let rss = solution.normal.cost;
    let variance = rss / (samples - free).max(1.0);
    let found = uncertainty(&solution.normal.curvature, &solution.at_bound, variance);
    let error = |slope: &[f64]| found.variance(&DVector::from_column_slice(slope)).map(f64::sqrt);
    let point = Point::of(&solution.point, order);
    // ln ν = ln p − (n − 1) ln |gap|.
    let k = point.order - 1.0;
    let log_gap = point.gap.abs().ln();
    let slope = [0.0, -k / point.gap, 1.0, -log_gap];
    let dimension = solution.point.len();
    let unit = |place: usize| (0..dimension).map(|k| f64::from(k == place)).collect::<Vec<_>>();
    let initial = [1.0, 1.0, 0.0, 0.0];
    let log_rate = point.log_pace - k * log_gap;
    let rate_error = error(&slope[..dimension]);
    let order_error = order.is_none().then(|| error(&unit(3))).flatten();
    let trade_off = rate_error.zip(order_error).map(|(rate, order)| {
        let row = found.covariance.column(3);
        slope.iter().zip(row.iter()).map(|(a, b)| a * b).sum::<f64>() / (rate * order)
    });
    let mean = strain.iter().sum::<f64>() / samples;
    let total: f64 = strain.iter().map(|value| (value - mean).powi(2)).sum();
    let law = Power {
        rate: log_rate.exp(),
        order: point.order,
        equilibrium: point.equilibrium,
        initial: point.equilibrium + point.gap,
    };
    let mut fit = PowerFit {
        left: decay(point.log_pace.exp() * time[time.len() - 1], point.order),
        order: (point.order, order_error),
        rate: (law.rate, rate_error),
        equilibrium: (point.equilibrium, error(&unit(0))),
        gap: (point.gap, error(&unit(1))),
        initial: (law.initial, error(&initial[..dimension])),
        trade_off,
        noise: variance.sqrt(),
        r_squared: 1.0 - rss / total.max(f64::MIN_POSITIVE),
        rss,
        law,
        doubts: Vec::new(),
    };
    fit.doubts = doubts(&fit, solution.stop.converged(), &solution.at_bound);
    fit
}

/// What a hold does not tell of a fit.
fn doubts(fit: &PowerFit, converged: bool, at_bound: &[bool]) -> Vec<String> {
    let mut found = Vec::new();
    if !converged {
        found.push("the fit did not converge".to_owned());
    }
    if at_bound[2] {
        found.push(
            "the rate is at its limit: the hold is too short or too coarsely sampled for it".into(),
        );
    }
    if fit.gap.1.is_none_or(|error| fit.gap.0.abs() < 2.0 * error) {
        found.push("the gap is not significantly different from zero: nothing relaxes beyond the noise, or its size trades off with ε_e".into());
    } else if fit.equilibrium.1.is_none_or(|error| error > 0.5 * fit.gap.0.abs()) {
        found.push(
            "ε_e is not identifiable from this hold: its standard error exceeds half the gap"
                .into(),
        );
    } else if fit.left > 0.5 {
        found.push(format!(
            "{:.0} % of the gap is still open at the end: ε_e is an extrapolation",
            100.0 * fit.left
        ));
    }
    if fit.equilibrium.0 * fit.law.initial < 0.0 {
        found.push("ε_e lies on the other side of zero strain: it is an extrapolation that no specimen reaches".into());
    }
    if fit.rate.1.is_none_or(|error| error > 0.7) {
        found.push("ν is not known within a factor of two".into());
    }
    if fit.trade_off.is_some_and(|r| r.abs() > 0.98) {
        found.push(
            "ν and n trade off (correlation beyond 0.98): only both together mean something".into(),
        );
    }
    found
}

/// Coordinates: ε_e, gap, ln of the pace ν |gap|^(n−1), and n where it is free.
struct Problem<'a> {
    time: &'a [f64],
    strain: &'a [f64],
    order: Option<f64>,
    bounds: Vec<(f64, f64)>,
}

struct Point {
    equilibrium: f64,
    gap: f64,
    log_pace: f64,
    order: f64,
}

impl Point {
    fn of(point: &[f64], order: Option<f64>) -> Self {
        let [equilibrium, gap, log_pace] = [point[0], point[1], point[2]];
        Self { equilibrium, gap, log_pace, order: order.unwrap_or_else(|| point[3]) }
    }
}

impl<'a> Problem<'a> {
    fn new(time: &'a [f64], strain: &'a [f64], order: Option<f64>) -> Self {
        let low = strain.iter().copied().fold(f64::INFINITY, f64::min);
        let high = strain.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let reach = 20.0 * (high - low).max(f64::MIN_POSITIVE);
        let duration = time[time.len() - 1];
        let shortest = time.windows(2).map(|pair| pair[1] - pair[0]).fold(duration, f64::min);
        let mut bounds = vec![
            (low - reach, high + reach),
            (-reach, reach),
            ((1e-3 / duration).ln(), (1e3 / shortest).ln()),
        ];
        if order.is_none() {
            bounds.push((1.0, HIGHEST));
        }
        Self { time, strain, order, bounds }
    }

    /// The best of a grid over pace and order; ε_e and gap are linear.
    fn start(&self) -> Vec<f64> {
        let orders = self.order.map_or_else(|| ODD_ORDERS.to_vec(), |order| vec![order]);
        let (low, high) = self.bounds[2];
        let step = self.time.len().div_ceil(400).max(1);
        let mut best = (f64::INFINITY, vec![0.0; self.bounds.len()]);
        for order in orders {
            for k in 0..=60 {
                let log_pace = low + (high - low) * f64::from(k) / 60.0;
                let Some((cost, equilibrium, gap)) = self.linear(log_pace, order, step) else {
                    continue;
                };
                if cost < best.0 {
                    let mut point = vec![equilibrium, gap, log_pace];
                    if self.order.is_none() {
                        point.push(order);
                    }
                    best = (cost, point);
                }
            }
        }
        best.1
    }

    /// Least squares for ε_e and gap, every `step`th sample: cost, ε_e, gap.
    fn linear(&self, log_pace: f64, order: f64, step: usize) -> Option<(f64, f64, f64)> {
        let pace = log_pace.exp();
        let samples = || self.time.iter().zip(self.strain).step_by(step);
        let shape = |t: f64| decay(pace * t, order);
        let (mut n, mut s, mut ss, mut y, mut sy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (t, strain) in samples() {
            let d = shape(*t);
            (n, s, ss, y, sy) = (n + 1.0, s + d, ss + d * d, y + strain, sy + d * strain);
        }
        let determinant = n * ss - s * s;
        if determinant <= 1e-12 * n * ss {
            return None;
        }
        let gap = (n * sy - s * y) / determinant;
        let equilibrium = (y - gap * s) / n;
        let cost = samples().map(|(t, strain)| (equilibrium + gap * shape(*t) - strain).powi(2));
        Some((cost.sum(), equilibrium, gap))
    }
}

impl LeastSquares for Problem<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn cost(&self, point: &[f64]) -> f64 {
        let Point { equilibrium, gap, log_pace, order } = Point::of(point, self.order);
        let pace = log_pace.exp();
        let residual = |(t, strain): (&f64, &f64)| {
            (equilibrium + gap * decay(pace * t, order) - strain).powi(2)
        };
        self.time.iter().zip(self.strain).map(residual).sum()
    }

    fn normal(&self, point: &[f64]) -> Normal {
        let Point { equilibrium, gap, log_pace, order } = Point::of(point, self.order);
        let (pace, k) = (log_pace.exp(), order - 1.0);
        let mut normal = Normal::zeros(point.len());
        for (t, strain) in self.time.iter().zip(self.strain) {
            let x = pace * t;
            let d = decay(x, order);
            let residual = equilibrium + gap * d - strain;
            // d = (1 + k x)^(−1/k).
            let row = [1.0, d, -gap * d * x / (1.0 + k * x), gap * d * order_slope(x, k)];
            let row = DVector::from_column_slice(&row[..point.len()]);
            normal.cost += residual * residual;
            normal.gradient += &row * residual;
            normal.curvature += &row * row.transpose();
        }
        normal
    }
}

/// d ln d / dn for d = (1 + k x)^(−1/k), k = n − 1.
fn order_slope(x: f64, k: f64) -> f64 {
    // Near k = 0 the two parts cancel; the series is x²/2 − 2kx³/3.
    if k * x < 1e-4 {
        return x * x * (0.5 - 2.0 * k * x / 3.0);
    }
    (k * x).ln_1p() / (k * k) - x / (k * (1.0 + k * x))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn slopes_are_those_of_the_law(x in 0.0f64..50.0, order in 1.0f64..12.0) {
            let h = 1e-5;
            let slope = order_slope(x, order - 1.0);
            // One-sided at n = 1.
            let numeric = (decay(x, order + 2.0 * h).ln() - decay(x, order).ln()) / (2.0 * h);
            let curvature = (order_slope(x, order - 1.0 + 2.0 * h) - slope).abs();
            prop_assert!((slope - numeric).abs() <= 1e-4 * slope.abs() + curvature + 1e-6, "{slope} {numeric}");
        }
    }
}
