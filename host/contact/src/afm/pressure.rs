//! What the general pressure law (8.1) says of the depth of a contact.
//!
//! A force N on a circle of radius a with p = Ck N/(πa²) [1 − (r/a)^k]^(1/k) pushes an elastic half space down; by the
//! Boussinesq kernel, u(r) = 1/(πE*) ∫∫ p dA / distance. In the middle that is 2/E* ∫ p dr, in closed form
//!
//! ```text
//! u(0) = 2N/(π a E*) · Ck Γ(1+1/k)²/Γ(1+2/k) = 2N/(π a E*) · Γ(1+1/k) Γ(1+3/k) / Γ(1+2/k)²
//! ```
//!
//! which for k = 2 is Hertz's 3N/(4aE*). With the radius of the contact that of the tip's geometry, a = √(R δ), and δ = u(0):
//!
//! ```text
//! N = 4/3 E*/κ(k) √R δ^(3/2),   κ(k) = u_k(0)/u_2(0) = 8/(3π) Γ(1+1/k) Γ(1+3/k) / Γ(1+2/k)²
//! ```
//!
//! So the exponent 3/2 stays and the modulus that Hertz's law finds is to be multiplied by κ: 1 for k = 2, 8/(3π) = 0.849 for a
//! uniform pressure. The shape of a force curve says nothing of k.

use std::f64::consts::PI;
use std::num::NonZeroUsize;

use statrs::function::gamma::ln_gamma;

use crate::grasp::PressureLaw;
use crate::grasp::quadrature::Rule;

/// κ(k): the depth in the middle over that of Hertz's pressure of the same force and radius, and so what a modulus found with
/// Hertz's law is to be multiplied by.
#[must_use]
pub fn modulus_factor(law: PressureLaw) -> f64 {
    let z = 1.0 / law.exponent();
    let gammas = ln_gamma(1.0 + z) + ln_gamma(1.0 + 3.0 * z) - 2.0 * ln_gamma(1.0 + 2.0 * z);
    8.0 / (3.0 * PI) * gammas.exp()
}

/// Depth of the surface at r/a from 0 to 1, over that of Hertz's contact of the same force and radius in its middle: the
/// kernel integrated along rays from the point, on which the distance cancels.
#[must_use]
pub fn surface(law: PressureLaw, rho: f64) -> f64 {
    const NODES: NonZeroUsize = NonZeroUsize::new(48).unwrap();
    let (along, around) = (Rule::flat_ended(NODES), Rule::smooth(NODES));
    let ray = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        // Where the ray leaves the circle; on it the pressure is highest nearest to the middle.
        let to_edge = ((1.0 - (rho * sin).powi(2)).max(0.0).sqrt() - rho * cos).max(0.0);
        let nearest = (-rho * cos).clamp(0.0, to_edge);
        let part = |from, to| -> f64 {
            let pressure = |s: f64| law.circular((rho * rho + s * s + 2.0 * rho * s * cos).sqrt());
            along.on(from, to).map(|(s, weight)| weight * pressure(s)).sum()
        };
        part(0.0, nearest) + part(nearest, to_edge)
    };
    // By symmetry half of the rays, cut where the nearest point of the ray leaves the point itself.
    let half: f64 = [(0.0, 0.5 * PI), (0.5 * PI, PI)]
        .into_iter()
        .flat_map(|(from, to)| around.on(from, to))
        .map(|(angle, weight)| weight * ray(angle))
        .sum();
    // u = N/(π² a E*) · 2 half, over 3N/(4 a E*).
    8.0 / (3.0 * PI * PI) * half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hertz_is_one_and_uniform_is_eight_over_three_pi() {
        assert!((modulus_factor(PressureLaw::HERTZ) - 1.0).abs() < 1e-13);
        assert!((modulus_factor(PressureLaw::UNIFORM) - 8.0 / (3.0 * PI)).abs() < 1e-13);
    }

    #[test]
    fn the_kernel_integrated_gives_the_closed_forms() {
        for k in [1.8, 2.0, 3.0, 10.0] {
            let law = PressureLaw::new(k).unwrap();
            assert!((surface(law, 0.0) - modulus_factor(law)).abs() < 1e-6, "{k}");
        }
        for rho in [0.0, 0.3, 0.7, 1.0] {
            // Hertz: u = u(0) (1 − r²/(2a²)).
            let hertz = surface(PressureLaw::HERTZ, rho);
            assert!((hertz - (1.0 - 0.5 * rho * rho)).abs() < 1e-6, "{rho}: {hertz}");
        }
        // Uniform, at the edge: 4 p a/(π E*) against 2 p a/E* in the middle.
        let edge = surface(PressureLaw::UNIFORM, 1.0) / surface(PressureLaw::UNIFORM, 0.0);
        assert!((edge - 2.0 / PI).abs() < 1e-4, "{edge}");
    }
}
