//! `ogden`: one term of Ogden's series.

use super::neo_hooke::modulus;
use super::{Acts, ElasticLaw, Shear};
use crate::coordinate::Coordinate;
use crate::laws::LawParameter;

const EXPONENTS_ALPHA: (f64, f64) = (-10.0, 30.0);

/// In tension F = 2 GA/α (λ^(α−1) − λ^(−α/2−1)).
pub(super) static LAW: ElasticLaw = ElasticLaw {
    name: "ogden",
    meaning: "a rubber whose stiffness grows as a power of the stretch",
    formula: "2 GA/α (λ^(α−1) − λ^(−α/2−1))",
    acts: Acts::OnStretch { pulled, sheared: Shear::Own(sheared) },
    parameters: |_, stiffness| {
        let alpha = "exponent of the stretch";
        vec![
            modulus(stiffness),
            LawParameter::new("alpha", "", alpha, EXPONENTS_ALPHA, Coordinate::Shape),
        ]
    },
    constants: |values| (values[0], values[1]),
    values: |p, shape| vec![p, shape],
    bounds: |_| Some(EXPONENTS_ALPHA),
    starts: |_| vec![-2.0, 1.0, 2.0, 3.5, 6.0, 12.0],
};

fn pulled(alpha: f64, stretch: f64) -> f64 {
    let log = stretch.ln();
    3.0 * log * stretch.powf(-0.5 * alpha - 1.0) * mean_growth(1.5 * alpha * log)
}

/// λ − 1/λ = γ, F = 2/α (λ^α − λ^(−α))/(λ + 1/λ).
fn sheared(alpha: f64, strain: f64) -> f64 {
    let log = (0.5 * strain).asinh();
    let grown = mean_growth(2.0 * alpha * log) * (-alpha * log).exp();
    2.0 * log * grown / log.cosh()
}

/// (e^z − 1)/z.
fn mean_growth(z: f64) -> f64 {
    if z.abs() < 1e-8 { 1.0 + 0.5 * z } else { z.exp_m1() / z }
}
