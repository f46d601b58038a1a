//! How a held response relaxes: a sum of exponentials, or a kernel that stands for a broad spectrum.
//!
//! A kernel runs over any motion as a sum of many exponentials: with rates at equal steps in their
//! logarithm it follows the kernel over the whole span of times, and the cost of a sample stays constant
//! however long the history. Over the span the relative error of the power law is below 2e-5 and that of
//! the stretched exponential below 1e-4 of its initial value, whatever their parameters. What relaxes
//! faster than the span resolves acts as a damper, which is exact for ramps between samples.

use std::sync::OnceLock;

use nalgebra::DMatrix;
use statrs::function::gamma::gamma;

use super::elastic::parameter;
use super::{Branch, Parameter};

/// How a held response relaxes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// g = c0 + Σ ci e^(−vi t) (eq. 3.3).
    #[default]
    Exponentials,
    /// g = c0 + c1 (t/1 s)^(−β), c0 + c1 = 1: a springpot (fractional element) beside a spring. The
    /// elastic response is that one second after a step.
    PowerLaw,
    /// g = c0 + c1 e^(−(t/τ)^β), c0 + c1 = 1 (Kohlrausch).
    Stretched,
    /// g = 1: nothing relaxes.
    None,
}

/// Orders β of a power law.
pub const POWER_ORDERS: (f64, f64) = (0.005, 0.95);
/// Orders β of a stretched exponential.
pub const STRETCHED_ORDERS: (f64, f64) = (0.1, 1.0);

impl Kernel {
    /// Every kernel.
    pub const ALL: [Self; 4] = [Self::Exponentials, Self::PowerLaw, Self::Stretched, Self::None];

    /// Name in model files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exponentials => "exponentials",
            Self::PowerLaw => "power-law",
            Self::Stretched => "stretched",
            Self::None => "none",
        }
    }

    /// The kernel of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kernel| kernel.name() == name)
    }

    /// Parameters of a kernel that is no sum of exponentials.
    #[must_use]
    pub fn parameters(self) -> Vec<Parameter> {
        let share = |meaning| parameter("c1", "", meaning, (0.0, 1.0));
        let order = |meaning, range| parameter("beta", "", meaning, range);
        match self {
            Self::Exponentials | Self::None => Vec::new(),
            Self::PowerLaw => vec![
                share("share of the response after 1 s that relaxes"),
                order("power of time with which it relaxes", POWER_ORDERS),
            ],
            Self::Stretched => vec![
                share("share of the elastic response that relaxes"),
                parameter("tau", "s", "time in which it relaxes to 1/e", (0.0, f64::INFINITY)),
                order("power of time in the exponent", STRETCHED_ORDERS),
            ],
        }
    }

    /// Number of these parameters.
    #[must_use]
    pub const fn count(self) -> usize {
        match self {
            Self::Exponentials | Self::None => 0,
            Self::PowerLaw => 2,
            Self::Stretched => 3,
        }
    }

    /// The part that relaxes as a sum of exponentials, for these rates, 1/s, and this order β.
    #[must_use]
    pub fn spectrum(self, rate: f64, order: f64, span: Span) -> Spectrum {
        match self {
            Self::Exponentials | Self::None => Spectrum::default(),
            Self::PowerLaw => power_law(order, span),
            Self::Stretched => stretched(rate, order, span),
        }
    }
}

/// Times, s, over which a kernel is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The shortest.
    pub shortest: f64,
    /// The longest.
    pub longest: f64,
}

impl Span {
    /// From a microsecond to three years, for what is not known.
    pub const WIDEST: Self = Self { shortest: 1e-6, longest: 1e8 };

    /// From the shortest interval between samples, s, to the end of a data set, s.
    #[must_use]
    pub fn of(shortest: f64, longest: f64) -> Self {
        if shortest > 0.0 && shortest < longest && longest < f64::INFINITY {
            Self { shortest, longest }
        } else {
            Self::WIDEST
        }
    }

    /// The time in its middle on a scale of logarithms, s.
    #[must_use]
    pub fn middle(self) -> f64 {
        (self.shortest * self.longest).sqrt()
    }
}

/// A kernel as a sum of exponentials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Shares and rates, 1/s.
    pub branches: Vec<Branch>,
    /// Integral over time of what relaxes faster, s.
    pub viscosity: f64,
}

/// An exponential with this rate times the shortest time is over within it.
const OVER: f64 = 16.0;
/// One with less than this rate times the longest time stands for all that are slower.
const STANDING: f64 = 0.005;
/// Step of the logarithm of the rate for a power law.
const POWER_STEP: f64 = 0.7;

/// t^(−β) = 1/Γ(β) ∫ e^(βu) e^(−t e^u) du by the trapezoidal rule, which converges exponentially with the
/// step. What lies beyond either end is a geometric series.
fn power_law(order: f64, span: Span) -> Spectrum {
    let size = POWER_STEP / gamma(order);
    let first = ((STANDING / span.longest).ln() / POWER_STEP).floor();
    let last = ((OVER / span.shortest).ln() / POWER_STEP).ceil();
    // Sum of e^(power·u) over all places beyond this one.
    let beyond = |place: f64, power: f64| {
        let step = (-power.abs() * POWER_STEP).exp();
        (power * place * POWER_STEP).exp() * step / (1.0 - step)
    };
    let slow = beyond(first, order);
    let mut branches = vec![Branch { share: size * slow, rate: beyond(first, order + 1.0) / slow }];
    let count = (last - first) as usize;
    branches.extend((0..=count).map(|k| {
        let log = (first + k as f64) * POWER_STEP;
        Branch { share: size * (order * log).exp(), rate: log.exp() }
    }));
    Spectrum { branches, viscosity: size * beyond(last, order - 1.0) }
}

/// Step of the logarithm of the rate for a stretched exponential.
const STRETCHED_STEP: f64 = 0.45;
/// Times, in time constants τ, over which it is followed.
const STRETCHED_TIMES: (f64, f64) = (1e-12, 1e11);
/// Shares below this are left out.
const NO_SHARE: f64 = 1e-8;

/// e^(−(t/τ)^β) as the sum of exponentials that comes closest to it at times at equal steps in their
/// logarithm.
fn stretched(rate: f64, order: f64, span: Span) -> Spectrum {
    let Projection { rates, times, inverse } = Projection::get();
    let kernel = nalgebra::DVector::from_iterator(
        times.len(),
        times.iter().map(|time| (-time.powf(order)).exp()),
    );
    let shares = inverse * kernel;
    let mut spectrum = Spectrum::default();
    for (&share, own) in shares.iter().zip(rates) {
        let rate = rate * own;
        if rate * span.shortest > OVER {
            spectrum.viscosity += share / rate;
        } else if share.abs() > NO_SHARE {
            spectrum.branches.push(Branch { share, rate });
        }
    }
    spectrum
}

/// What gives the shares of exponentials from a kernel's values at given times.
struct Projection {
    rates: Vec<f64>,
    times: Vec<f64>,
    inverse: DMatrix<f64>,
}

impl Projection {
    fn get() -> &'static Self {
        static PROJECTION: OnceLock<Projection> = OnceLock::new();
        PROJECTION.get_or_init(|| {
            let ladder = |from: f64, to: f64, step: f64| {
                let count = ((to / from).ln() / step).ceil() as usize;
                (0..=count).map(|k| from * (k as f64 * step).exp()).collect::<Vec<f64>>()
            };
            let (first, last) = STRETCHED_TIMES;
            let rates = ladder(0.01 / last, OVER / first, STRETCHED_STEP);
            let times = ladder(first, last, 0.5 * STRETCHED_STEP);
            let matrix =
                DMatrix::from_fn(times.len(), rates.len(), |i, j| (-rates[j] * times[i]).exp());
            let svd = matrix.svd(true, true);
            let least = 1e-9 * svd.singular_values.max();
            // Both factors are there: they were asked for.
            let inverse = svd
                .pseudo_inverse(least)
                .unwrap_or_else(|_| DMatrix::zeros(rates.len(), times.len()));
            Self { rates, times, inverse }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(spectrum: &Spectrum, time: f64) -> f64 {
        spectrum.branches.iter().map(|b| b.share * (-b.rate * time).exp()).sum()
    }

    fn times(span: Span) -> impl Iterator<Item = f64> {
        let decades = (span.longest / span.shortest).log10();
        (0..=400).map(move |k| span.shortest * 10f64.powf(decades * f64::from(k) / 400.0))
    }

    #[test]
    fn a_power_law_is_followed_within_2e_minus_5_of_itself() {
        for span in [Span::WIDEST, Span::of(0.002, 30.0), Span::of(1.0, 86_400.0)] {
            for order in [0.005, 0.02, 0.1, 0.25, 0.5, 0.8, 0.95] {
                let spectrum = power_law(order, span);
                for time in times(span) {
                    let off = at(&spectrum, time) * time.powf(order) - 1.0;
                    assert!(off.abs() < 2e-5, "β {order}, {time} s: {off:.1e}");
                }
            }
        }
    }

    #[test]
    fn a_stretched_exponential_is_followed_within_1e_minus_4() {
        let mut most: f64 = 0.0;
        for span in [Span::WIDEST, Span::of(0.002, 30.0)] {
            for order in [0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9, 0.97, 1.0] {
                for tau in [1e-3, 0.017, 0.3, 1.0, 5.5, 120.0] {
                    let spectrum = stretched(1.0 / tau, order, span);
                    for time in times(span) {
                        let off = at(&spectrum, time) - (-(time / tau).powf(order)).exp();
                        most = most.max(off.abs());
                    }
                }
            }
        }
        assert!(most < 1e-4, "{most:.1e}");
    }

    #[test]
    fn what_is_faster_than_the_span_keeps_its_integral() {
        // ∫0^T t^(−β) dt = T^(1−β)/(1−β), whatever the shortest time.
        for order in [0.1, 0.5, 0.9] {
            let spectrum = power_law(order, Span::of(0.01, 100.0));
            let within = |b: &Branch| -b.share * (-b.rate * 50.0).exp_m1() / b.rate;
            let integral: f64 =
                spectrum.viscosity + spectrum.branches.iter().map(within).sum::<f64>();
            let exact = 50f64.powf(1.0 - order) / (1.0 - order);
            assert!((integral / exact - 1.0).abs() < 2e-5, "β {order}: {integral} {exact}");
        }
        // ∫0^T e^(−√(t/τ)) dt = 2τ (1 − (1 + s) e^(−s)), s = √(T/τ).
        let spectrum = stretched(2.0, 0.5, Span::of(0.3, 1e6));
        let within = |b: &Branch| -b.share * (-b.rate * 50.0).exp_m1() / b.rate;
        let integral: f64 = spectrum.viscosity + spectrum.branches.iter().map(within).sum::<f64>();
        let exact = 1.0 - 11.0 * (-10f64).exp();
        assert!((integral - exact).abs() < 1e-3, "{integral} {exact}");
    }
}
