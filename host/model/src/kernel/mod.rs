//! How a held response relaxes: a sum of exponentials, or a kernel that stands for a broad spectrum. One declaration a file, and
//! one line in [`KERNELS`].
//!
//! A kernel runs over any motion as a sum of many exponentials: with rates at equal steps in their
//! logarithm it follows the kernel over the whole span of times, and the cost of a sample stays constant
//! however long the history. Over the span the relative error of the power law is below 2e-5 and that of
//! the stretched exponential below 1e-4 of its initial value, whatever their parameters. What relaxes
//! faster than the span resolves acts as a damper, which is exact for ramps between samples.

mod exponentials;
mod none;
mod power_law;
mod stretched;

use std::fmt;

pub(crate) use exponentials::{RATES, SHARES};

use super::Branch;
use super::base_law::Constants;
use super::laws::LawParameter;

/// Every way to relax of the library.
pub const KERNELS: &[&Kernel] =
    &[Kernel::EXPONENTIALS, Kernel::POWER_LAW, Kernel::STRETCHED, Kernel::NONE];

/// How a held response relaxes.
///
/// It is a `static`. Two are the same where their names are.
pub struct Kernel {
    /// Name in answers, model files and on the command line.
    pub name: &'static str,
    /// What it is, for one who meets it for the first time.
    pub meaning: &'static str,
    /// The relaxation function g(t).
    pub formula: &'static str,
    /// What it is made of.
    pub memory: MemoryOf,
    /// Its parameters beside the elastic ones, in the order of model files, for so many terms.
    pub parameters: fn(usize) -> Vec<LawParameter>,
    /// Constants with shares, rates and order from these values; stiffness and shape are there.
    pub constants: fn(&[f64], Constants) -> Constants,
    /// The values of these constants.
    pub values: fn(&Constants) -> Vec<f64>,
}

/// What a kernel is made of.
#[derive(Clone, Copy)]
pub enum MemoryOf {
    /// Exponentials whose shares and rates are parameters.
    Exponentials,
    /// Nothing relaxes.
    Nothing,
    /// A spectrum of exponentials.
    Spectrum {
        /// For a rate, 1/s, an order β and a span of times: the part that relaxes, for a share of one.
        of: fn(f64, f64, Span) -> Spectrum,
        /// Part of the share that is left at a time, s, for an order β: the time at which its force is a coordinate of the search, so
        /// that it does not trade off against the order. 1 for a kernel whose share is that at once.
        later: fn(f64, f64) -> f64,
        /// Whether it has a rate.
        has_rate: bool,
        /// Orders β from which a search starts.
        orders: &'static [f64],
    },
}

/// Orders β from which a search starts, evenly over what soft matter shows.
const FIRST_ORDERS: &[f64] = &[0.08, 0.2, 0.35, 0.5, 0.75];

impl Kernel {
    /// g = c0 + Σ ci e^(−vi t) (eq. 3.3).
    pub const EXPONENTIALS: &Self = &exponentials::KERNEL;
    /// A springpot (fractional element) beside a spring.
    pub const POWER_LAW: &Self = &power_law::KERNEL;
    /// Kohlrausch's.
    pub const STRETCHED: &Self = &stretched::KERNEL;
    /// Nothing relaxes.
    pub const NONE: &Self = &none::KERNEL;

    /// Whether it is a sum of exponentials, each with its parameters.
    #[must_use]
    pub const fn is_exponentials(&self) -> bool {
        matches!(self.memory, MemoryOf::Exponentials)
    }

    /// Part of the share that is left in the middle of a span of times.
    #[must_use]
    pub fn later(&self, order: f64, span: Span) -> f64 {
        match self.memory {
            MemoryOf::Spectrum { later, .. } => later(order, span.middle()),
            MemoryOf::Exponentials | MemoryOf::Nothing => 1.0,
        }
    }
}

impl PartialEq for Kernel {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
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
#[cfg(test)]
mod tests {
    use super::power_law::power_law;
    use super::stretched::stretched;
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
