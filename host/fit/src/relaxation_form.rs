//! The form of a relaxation: a sum of exponentials, a power law or a stretched exponential, ranked by what
//! each predicts of decades of time that it has not seen.
//!
//! Samples are averaged over steps of a hundredth in time, each mean weighing as many as it is of: so a
//! day at ten samples a second is some thousand numbers, and nothing of its first seconds is lost.

use nalgebra::DVector;

use super::exponentials::{Options, Prepared, correlated_covariance, most_terms};
use super::least_squares::{LeastSquares, Normal, minimise};
use super::log_blocks::log_blocks;

/// Form of a relaxation function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A sum of so many exponentials (3.3).
    Exponentials(usize),
    /// A + B (1 + t/τ)^(−β).
    PowerLaw,
    /// A + B e^(−(t/τ)^β).
    Stretched,
}

/// One form fitted to a hold.
#[derive(Clone, Debug, PartialEq)]
pub struct FormFit {
    /// The form.
    pub form: Form,
    /// Number of parameters.
    pub numbers: usize,
    /// Root mean square residual over all samples, in the unit of the signal.
    pub residual_rms: f64,
    /// Root mean square error on the spans of time left out: the geometric mean over the spans, so that
    /// each weighs the same however much its samples are averaged.
    pub held_out_rms: Option<f64>,
    /// A, B, τ and β of a form that is no sum of exponentials, with standard errors that allow for the
    /// correlation of residuals with their neighbours.
    pub parameters: Option<Broad>,
    /// Shortest and longest time constant of a sum of exponentials, s.
    pub span: Option<(f64, f64)>,
}

/// Parameters of a form that is no sum of exponentials, with their standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Broad {
    /// Where it settles, A, in the unit of the signal.
    pub settles: (f64, Option<f64>),
    /// What relaxes, B, in the unit of the signal.
    pub relaxes: (f64, Option<f64>),
    /// Time τ, s.
    pub tau: (f64, Option<f64>),
    /// Order β.
    pub beta: (f64, Option<f64>),
}

/// Every form of a hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Forms {
    /// The forms, the least error on the spans left out first; by their residual where none was.
    pub rows: Vec<FormFit>,
    /// The form of fewest numbers that is no worse than the best by more than two standard errors.
    pub chosen: Form,
}

impl Forms {
    /// The fit of the chosen form.
    #[must_use]
    pub fn best(&self) -> Option<&FormFit> {
        self.rows.iter().find(|row| row.form == self.chosen)
    }
}

impl Form {
    /// Its name.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Exponentials(1) => "1 exponential".into(),
            Self::Exponentials(terms) => format!("{terms} exponentials"),
            Self::PowerLaw => "power law".into(),
            Self::Stretched => "stretched exponential".into(),
        }
    }

    const fn numbers(self) -> usize {
        match self {
            Self::Exponentials(terms) => 1 + 2 * terms,
            _ => 4,
        }
    }
}

/// Means over steps of time, with the number of samples of each.
struct Thinned {
    time: Vec<f64>,
    value: Vec<f64>,
    weight: Vec<f64>,
}

/// Spans of time for each decade, and fewest and most of them.
const SPANS_PER_DECADE: f64 = 2.0;
const SPANS: (usize, usize) = (4, 12);
/// Orders of a power law and of a stretched exponential.
const ORDERS: [(f64, f64); 2] = [(0.01, 4.0), (0.1, 1.0)];
/// Standard errors over the spans by which a form is worse than the best; with one, of sums that fit alike
/// every sixth would be told apart.
const WORSE: f64 = 2.0;
/// Fewest samples for which forms are compared.
const FEWEST: usize = 16;

/// Fits every form to a hold and ranks them; `limits` are those of the rates, 1/s. None for fewer than
/// sixteen samples.
#[must_use]
pub fn forms(time: &[f64], values: &[f64], most: usize, limits: (f64, f64)) -> Option<Forms> {
    if time.len() < FEWEST {
        return None;
    }
    let thinned = Thinned::of(time, values);
    let all = thinned.spans();
    let sums = (1..=most).map(Form::Exponentials);
    let mut order: Vec<Form> = sums.chain([Form::Stretched, Form::PowerLaw]).collect();
    order.sort_by_key(|form| form.numbers());
    let whole = thinned.kept(most, limits, |_| true);
    let spans = (1..=all[all.len() - 1]).filter(|span| all.contains(span));
    let without: Vec<(usize, Kept)> =
        spans.map(|span| (span, thinned.kept(most, limits, |k| all[k] != span))).collect();
    let mut rows = Vec::new();
    let mut errors = Vec::new();
    for form in order {
        let Some(fitted) = whole.fit(form) else { continue };
        let error = |(span, kept): &(usize, Kept)| {
            let error = thinned.error(&kept.fit(form)?, |k| all[k] == *span);
            Some(error.max(f64::MIN_POSITIVE).ln())
        };
        let left_out: Option<Vec<f64>> = without.iter().map(error).collect();
        let errors_of = left_out.filter(|errors| errors.len() > 1);
        let start = time[0];
        let residual = |(t, y): (&f64, &f64)| (y - fitted.at(t - start)).powi(2);
        let squares: f64 = time.iter().zip(values).map(residual).sum();
        rows.push(FormFit {
            form,
            numbers: form.numbers(),
            residual_rms: (squares / time.len() as f64).sqrt(),
            held_out_rms: errors_of.as_deref().map(|errors| (0.5 * mean(errors)).exp()),
            parameters: fitted.described(time, values),
            span: fitted.span(),
        });
        errors.push(errors_of);
    }
    let chosen = choose(&rows, &errors)?;
    rows.sort_by(|a, b| match (a.held_out_rms, b.held_out_rms) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        _ => a.residual_rms.total_cmp(&b.residual_rms),
    });
    Some(Forms { rows, chosen })
}

/// The fewest numbers that are no worse than the best by more than [`WORSE`] standard errors over the spans, the
/// lesser error where two have as many; `errors` are logarithms.
fn choose(rows: &[FormFit], errors: &[Option<Vec<f64>>]) -> Option<Form> {
    let known: Option<Vec<&Vec<f64>>> = errors.iter().map(Option::as_ref).collect();
    let Some(errors) = known.filter(|errors| !errors.is_empty()) else {
        return rows
            .iter()
            .min_by(|a, b| a.residual_rms.total_cmp(&b.residual_rms))
            .map(|r| r.form);
    };
    let best = errors.iter().min_by(|a, b| mean(a).total_cmp(&mean(b)))?;
    let as_good = |own: &Vec<f64>| {
        let excess: Vec<f64> = own.iter().zip(best.iter()).map(|(a, b)| a - b).collect();
        let (middle, count) = (mean(&excess), excess.len() as f64);
        let scatter = excess.iter().map(|e| (e - middle).powi(2)).sum::<f64>() / (count - 1.0);
        middle <= WORSE * (scatter / count).sqrt()
    };
    let good = rows.iter().zip(errors).filter(|(_, own)| as_good(own));
    let least =
        good.min_by(|a, b| a.0.numbers.cmp(&b.0.numbers).then(mean(a.1).total_cmp(&mean(b.1))));
    least.map(|(row, _)| row.form)
}

/// A fitted relaxation.
enum Curve {
    Sum(super::exponentials::ExponentialSum),
    Broad { form: Form, point: [f64; 4] },
}

impl Curve {
    fn at(&self, time: f64) -> f64 {
        match self {
            Self::Sum(sum) => sum.at(time),
            Self::Broad { form, point } => {
                point[0] + point[1] * shape(*form, time, point[2], point[3])[0]
            }
        }
    }

    fn span(&self) -> Option<(f64, f64)> {
        let Self::Sum(sum) = self else { return None };
        let (fast, slow) = (sum.terms.first()?, sum.terms.last()?);
        Some((1.0 / fast.rate, 1.0 / slow.rate))
    }

    fn described(&self, time: &[f64], values: &[f64]) -> Option<Broad> {
        let Self::Broad { form, point } = self else { return None };
        let [settles, relaxes, log, beta] = *point;
        let row = |t: f64, y: f64| {
            let [k, by_log, by_order] = shape(*form, t, log, beta);
            (vec![1.0, k, relaxes * by_log, relaxes * by_order], y - settles - relaxes * k)
        };
        let covariance = correlated_covariance(time, values, 4, row);
        let error = |k: usize| {
            let variance = covariance.as_ref().map(|covariance| covariance[(k, k)]);
            variance.filter(|variance| *variance > 0.0).map(f64::sqrt)
        };
        let tau = log.exp();
        Some(Broad {
            settles: (settles, error(0)),
            relaxes: (relaxes, error(1)),
            tau: (tau, error(2).map(|error| error * tau)),
            beta: (beta, error(3)),
        })
    }
}

/// The falling part of a form at a time, s, with its derivatives by ln τ and β.
fn shape(form: Form, time: f64, log: f64, order: f64) -> [f64; 3] {
    let x = time * (-log).exp();
    match form {
        Form::Stretched => {
            if x <= 0.0 {
                return [1.0, 0.0, 0.0];
            }
            let power = x.powf(order);
            let value = (-power).exp();
            [value, value * power * order, -value * power * x.ln()]
        }
        _ => {
            let grown = x.ln_1p();
            let value = (-order * grown).exp();
            [value, value * order * x / (1.0 + x), -value * grown]
        }
    }
}

impl Thinned {
    fn of(time: &[f64], values: &[f64]) -> Self {
        let mut thinned = Self { time: vec![], value: vec![], weight: vec![] };
        for block in log_blocks(time) {
            let count = block.len() as f64;
            thinned.time.push(time[block.clone()].iter().sum::<f64>() / count - time[0]);
            thinned.value.push(values[block].iter().sum::<f64>() / count);
            thinned.weight.push(count);
        }
        thinned.time[0] = 0.0;
        thinned
    }

    /// In which span of time each sample lies: spans are equally long in the logarithm of time, and the
    /// first holds the start.
    fn spans(&self) -> Vec<usize> {
        let (first, last) = (self.time[1], self.time[self.time.len() - 1]);
        let decades = (last / first).log10();
        let count = ((SPANS_PER_DECADE * decades).round() as usize).clamp(SPANS.0, SPANS.1);
        let span = |t: &f64| {
            let part = (t / first).max(1.0).log10() / decades;
            ((part * count as f64) as usize).min(count - 1)
        };
        self.time.iter().map(span).collect()
    }

    /// Some of the samples, for fits of up to so many exponentials with rates between these, 1/s.
    fn kept(&self, most: usize, limits: (f64, f64), keep: impl Fn(usize) -> bool) -> Kept<'_> {
        let weight = |k: usize| if keep(k) { self.weight[k] } else { 0.0 };
        let weights: Vec<f64> = (0..self.time.len()).map(weight).collect();
        let samples = weights.iter().filter(|weight| **weight > 0.0).count();
        let terms = most.min(most_terms(samples));
        let (slowest, fastest) = (Some(limits.0), Some(limits.1));
        let options = Options { terms, slowest, fastest, ..Options::default() };
        let sums = Prepared::weighted(&self.time, &weights, &options).ok();
        Kept { thinned: self, weights, sums }
    }

    /// Mean squared error of a curve on some samples.
    fn error(&self, curve: &Curve, on: impl Fn(usize) -> bool) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for k in (0..self.time.len()).filter(|k| on(*k)) {
            sum += self.weight[k] * (self.value[k] - curve.at(self.time[k])).powi(2);
            count += self.weight[k];
        }
        sum / count
    }
}

/// Samples that are fitted, the others with a weight of 0.
struct Kept<'a> {
    thinned: &'a Thinned,
    weights: Vec<f64>,
    /// Fits of sums of exponentials; none where they are too few.
    sums: Option<Prepared>,
}

impl Kept<'_> {
    fn fit(&self, form: Form) -> Option<Curve> {
        if let Form::Exponentials(terms) = form {
            let fit = self.sums.as_ref()?.fit_terms(&self.thinned.value, terms).ok()?;
            return Some(Curve::Sum(fit.sum));
        }
        let problem = Search::new(self.thinned, &self.weights, form);
        let found = minimise(&problem, &problem.start()?);
        let point = [found.point[0], found.point[1], found.point[2], found.point[3]];
        point.iter().all(|value| value.is_finite()).then_some(Curve::Broad { form, point })
    }
}

/// The search for A, B, ln τ and β.
struct Search<'a> {
    thinned: &'a Thinned,
    weights: &'a [f64],
    form: Form,
    bounds: [(f64, f64); 4],
}

impl<'a> Search<'a> {
    fn new(thinned: &'a Thinned, weights: &'a [f64], form: Form) -> Self {
        let (first, last) = (thinned.time[1], thinned.time[thinned.time.len() - 1]);
        let any = (f64::NEG_INFINITY, f64::INFINITY);
        let times = ((1e-3 * first).ln(), (1e3 * last).ln());
        let order = if form == Form::Stretched { ORDERS[1] } else { ORDERS[0] };
        Self { thinned, weights, form, bounds: [any, any, times, order] }
    }

    /// The best of a grid over τ and β; A and B are linear.
    fn start(&self) -> Option<Vec<f64>> {
        let (low, high) = self.bounds[2];
        let orders: &[f64] = match self.form {
            Form::Stretched => &[0.15, 0.3, 0.5, 0.75, 1.0],
            _ => &[0.05, 0.15, 0.3, 0.6, 1.0, 2.0],
        };
        let mut best: Option<(f64, Vec<f64>)> = None;
        for k in 0..=18 {
            let log = low + (high - low) * f64::from(k) / 18.0;
            for &order in orders {
                let Some((cost, a, b)) = self.linear(log, order) else { continue };
                if best.as_ref().is_none_or(|best| cost < best.0) {
                    best = Some((cost, vec![a, b, log, order]));
                }
            }
        }
        best.map(|best| best.1)
    }

    fn samples(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let Thinned { time, value, .. } = self.thinned;
        let all = time.iter().zip(value).zip(self.weights);
        all.filter(|(_, weight)| **weight > 0.0).map(|((t, y), weight)| (*t, *y, *weight))
    }

    fn linear(&self, log: f64, order: f64) -> Option<(f64, f64, f64)> {
        let (mut n, mut s, mut ss, mut sum, mut along) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (t, y, w) in self.samples() {
            let k = shape(self.form, t, log, order)[0];
            (n, s, ss, sum, along) =
                (n + w, s + w * k, ss + w * k * k, sum + w * y, along + w * k * y);
        }
        let determinant = n * ss - s * s;
        if determinant <= 1e-10 * n * ss {
            return None;
        }
        let b = (n * along - s * sum) / determinant;
        let a = (sum - b * s) / n;
        Some((self.cost(&[a, b, log, order]), a, b))
    }
}

impl LeastSquares for Search<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn cost(&self, point: &[f64]) -> f64 {
        let residual = |(t, y, w): (f64, f64, f64)| {
            w * (point[0] + point[1] * shape(self.form, t, point[2], point[3])[0] - y).powi(2)
        };
        self.samples().map(residual).sum()
    }

    fn normal(&self, point: &[f64]) -> Normal {
        let mut normal = Normal::zeros(4);
        for (t, y, w) in self.samples() {
            let [k, by_log, by_order] = shape(self.form, t, point[2], point[3]);
            let residual = point[0] + point[1] * k - y;
            let row = [1.0, k, point[1] * by_log, point[1] * by_order];
            let row = DVector::from_column_slice(&row);
            normal.cost += w * residual * residual;
            normal.gradient += &row * (w * residual);
            normal.curvature += &row * row.transpose() * w;
        }
        normal
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;

    /// A hold of 100 s at 50 Hz that relaxes so, with noise.
    fn hold(g: impl Fn(f64) -> f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, 0.002).unwrap();
        (0..5000)
            .map(|k| 0.02 * f64::from(k))
            .map(|t| (t, g(t) + normal.sample(&mut random)))
            .unzip()
    }

    const LIMITS: (f64, f64) = (2e-4, 10.0);

    #[test]
    fn the_form_that_made_a_hold_is_chosen_with_its_numbers() {
        let power = |t: f64| 1.0 + 2.0 * (1.0 + t / 0.3).powf(-0.25);
        let stretched = |t: f64| 1.0 + 2.0 * (-(t / 4.0).powf(0.4)).exp();
        let two = |t: f64| 1.0 + 1.2 * (-2.0 * t).exp() + 0.8 * (-0.1 * t).exp();
        for seed in 0..3 {
            let (time, values) = hold(power, seed);
            let found = forms(&time, &values, 4, LIMITS).unwrap();
            assert_eq!(found.chosen, Form::PowerLaw, "{found:#?}");
            let own = found.best().unwrap().parameters.unwrap();
            let (beta, error) = (own.beta.0, own.beta.1.unwrap());
            assert!((beta - 0.25).abs() < 4.0 * error && error < 0.05, "{beta} ± {error}");
            let (time, values) = hold(stretched, seed);
            let found = forms(&time, &values, 4, LIMITS).unwrap();
            assert_eq!(found.chosen, Form::Stretched, "{found:#?}");
            let own = found.best().unwrap().parameters.unwrap();
            assert!((own.beta.0 - 0.4).abs() < 4.0 * own.beta.1.unwrap());
            let (time, values) = hold(two, seed);
            let found = forms(&time, &values, 4, LIMITS).unwrap();
            assert_eq!(found.chosen, Form::Exponentials(2), "{found:#?}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_shapes() {
        for form in [Form::PowerLaw, Form::Stretched] {
            for time in [0.01, 0.7, 30.0] {
                let (log, order, h) = (0.4, 0.35, 1e-6);
                let at = |log, order| shape(form, time, log, order)[0];
                let [_, by_log, by_order] = shape(form, time, log, order);
                let numeric = (at(log + h, order) - at(log - h, order)) / (2.0 * h);
                assert!((by_log - numeric).abs() < 1e-8, "{form:?}");
                let numeric = (at(log, order + h) - at(log, order - h)) / (2.0 * h);
                assert!((by_order - numeric).abs() < 1e-8, "{form:?}");
            }
        }
    }
}
