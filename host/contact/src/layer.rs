//! How much stiffer a thin layer on a rigid base is than a half space.

use std::f64::consts::PI;

/// Factor on the force of a paraboloid for a layer that is bonded to a rigid base (Dimitriadis and others 2002): the series
/// in χ = √(R δ)/h, h the thickness, up to χ³. Meant for χ up to 1; 1 for a half space (χ = 0). `poisson_ratio` is that of
/// the layer.
///
/// The next coefficient, 0.0975 for an incompressible layer, is printed with one sign in the general form and the other in the
/// special one; up to χ = 0.5 it decides over less than half a per cent and is left out.
#[must_use]
pub fn bonded_layer_factor(chi: f64, poisson_ratio: f64) -> f64 {
    let v = poisson_ratio;
    let alpha = -(1.2876 - 1.4678 * v + 1.3442 * v * v) / (1.0 - v);
    let beta = (0.6387 - 1.0277 * v + 1.5164 * v * v) / (1.0 - v);
    let first = -2.0 * alpha / PI;
    let third = -8.0 / PI.powi(3) * (alpha.powi(3) + 4.0 * PI * PI / 15.0 * beta);
    1.0 + chi * (first + chi * (first * first + chi * third))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_incompressible_layer_has_the_coefficients_printed_for_it() {
        for chi in [0.0_f64, 0.1, 0.5, 1.0] {
            let printed = 1.0 + 1.133 * chi + 1.283 * chi.powi(2) + 0.769 * chi.powi(3);
            assert!((bonded_layer_factor(chi, 0.5) - printed).abs() < 2e-3 * chi + 1e-15);
        }
    }
}
