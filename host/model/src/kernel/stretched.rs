//! `stretched`: a stretched exponential.

use std::sync::OnceLock;

use nalgebra::DMatrix;

use super::{FIRST_ORDERS, Kernel, MemoryOf, OVER, Span, Spectrum};
use crate::coordinate::Coordinate;
use crate::laws::{LawParameter, POSITIVE, divisor};
use crate::{Branch, Constants};

/// Orders β that it may have.
const ORDERS: (f64, f64) = (0.1, 1.0);
/// Step of the logarithm of the rate for a stretched exponential.
const STRETCHED_STEP: f64 = 0.45;
/// Times, in time constants τ, over which it is followed.
const STRETCHED_TIMES: (f64, f64) = (1e-12, 1e11);
/// Shares below this are left out.
const NO_SHARE: f64 = 1e-8;

/// g = c0 + c1 e^(−(t/τ)^β), c0 + c1 = 1 (Kohlrausch).
pub(super) static KERNEL: Kernel = Kernel {
    name: "stretched",
    meaning: "an exponential of a power of time (Kohlrausch): relaxes at many rates about one",
    formula: "g = c0 + c1 e^(−(t/τ)^β)",
    memory: MemoryOf::Spectrum {
        of: stretched,
        later: |_, _| 1.0,
        has_rate: true,
        orders: FIRST_ORDERS,
    },
    parameters: |_| {
        let (share, tau) =
            ("share of the elastic response that relaxes", "time in which it relaxes to 1/e");
        vec![
            LawParameter::new("c1", "", share, (0.0, 1.0), Coordinate::Force(1)),
            LawParameter::new("tau", "s", tau, POSITIVE, Coordinate::Rate(1)),
            LawParameter::new(
                "beta",
                "",
                "power of time in the exponent",
                ORDERS,
                Coordinate::Order,
            ),
        ]
    },
    constants: |values, elastic| Constants {
        shares: vec![values[0]],
        rates: vec![1.0 / divisor(values[1])],
        order: values[2],
        ..elastic
    },
    values: |constants| vec![constants.shares[0], 1.0 / constants.rates[0], constants.order],
};

/// e^(−(t/τ)^β) as the sum of exponentials that comes closest to it at times at equal steps in their
/// logarithm.
pub(super) fn stretched(rate: f64, order: f64, span: Span) -> Spectrum {
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
