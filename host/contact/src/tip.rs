//! A rigid tip on an elastic half space without adhesion (Hertz 1882, Sneddon 1965).

use std::f64::consts::FRAC_2_PI;

/// Shape of a rigid tip; its axis is normal to the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tip {
    /// z = r²/(2R): Hertz's sphere, F = 4/3 E* √R δ^(3/2), a² = R δ. Exact for a paraboloid at any depth.
    Paraboloid {
        /// Radius R of the tip, m.
        radius_m: f64,
    },
    /// A whole sphere (Sneddon): δ = a artanh(a/R), F = E* ((R² + a²) artanh(a/R) − a R).
    Sphere {
        /// Radius R, m.
        radius_m: f64,
    },
    /// A cone (Sneddon): F = 2/π E* tan(α) δ², a = 2/π δ tan(α).
    Cone {
        /// Half angle α between axis and flank, rad.
        half_angle_rad: f64,
    },
}

impl Tip {
    /// Force, N, at a depth δ, m, on a body of reduced modulus E* = E/(1 − ν²), Pa; 0 out of contact.
    #[must_use]
    pub fn force(&self, reduced_modulus: f64, depth: f64) -> f64 {
        if depth <= 0.0 {
            return 0.0;
        }
        reduced_modulus
            * match *self {
                Self::Paraboloid { radius_m } => 4.0 / 3.0 * (radius_m * depth).sqrt() * depth,
                Self::Sphere { radius_m } => {
                    // a/R = tanh t; the difference of two nearly equal terms is left to its series where t is small.
                    let t = sphere_angle(depth / radius_m);
                    let a = t.tanh();
                    let shape = if t < 1e-3 {
                        t.powi(3) * (4.0 / 3.0 - 0.8 * t * t)
                    } else {
                        (1.0 + a * a) * t - a
                    };
                    radius_m * radius_m * shape
                }
                Self::Cone { half_angle_rad } => FRAC_2_PI * half_angle_rad.tan() * depth * depth,
            }
    }

    /// Radius of the contact, m, at a depth, m; 0 out of contact.
    #[must_use]
    pub fn contact_radius(&self, depth: f64) -> f64 {
        if depth <= 0.0 {
            return 0.0;
        }
        match *self {
            Self::Paraboloid { radius_m } => (radius_m * depth).sqrt(),
            Self::Sphere { radius_m } => radius_m * sphere_angle(depth / radius_m).tanh(),
            Self::Cone { half_angle_rad } => FRAC_2_PI * depth * half_angle_rad.tan(),
        }
    }

    /// Exponent m of F ∝ δ^m: 3/2 or 2; of the sphere, that of shallow depths.
    #[must_use]
    pub const fn exponent(&self) -> f64 {
        match self {
            Self::Paraboloid { .. } | Self::Sphere { .. } => 1.5,
            Self::Cone { .. } => 2.0,
        }
    }
}

/// t of t tanh t = d, d > 0, by Newton's method: a/R = tanh t and δ/R = d.
fn sphere_angle(d: f64) -> f64 {
    let mut t = d.max(d.sqrt());
    for _ in 0..40 {
        let tanh = t.tanh();
        let step = (t * tanh - d) / (tanh + t * (1.0 - tanh * tanh));
        t -= step;
        if step.abs() <= 1e-15 * t {
            break;
        }
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_sphere_is_a_paraboloid_when_shallow_and_softer_when_deep() {
        let (sphere, paraboloid) =
            (Tip::Sphere { radius_m: 2e-6 }, Tip::Paraboloid { radius_m: 2e-6 });
        let ratio = |depth| sphere.force(1e3, depth) / paraboloid.force(1e3, depth);
        assert!((ratio(2e-11) - 1.0).abs() < 1e-5);
        assert!(ratio(1e-6) < 0.96 && ratio(1e-6) > 0.9, "{}", ratio(1e-6));
        assert!(sphere.contact_radius(1e-5) < 2e-6);
    }

    proptest! {
        #[test]
        fn the_stiffness_of_every_tip_is_2_e_a(depth in 1e-9f64..1e-5, which in 0usize..3) {
            // dF/dδ = 2 E* a for every axisymmetric tip (Sneddon): it ties force and contact radius together.
            let tip = [
                Tip::Paraboloid { radius_m: 3e-6 },
                Tip::Sphere { radius_m: 3e-6 },
                Tip::Cone { half_angle_rad: 0.6 },
            ][which];
            let h = 1e-5 * depth;
            let slope = (tip.force(1.0, depth + h) - tip.force(1.0, depth - h)) / (2.0 * h);
            prop_assert!((slope / (2.0 * tip.contact_radius(depth)) - 1.0).abs() < 1e-6);
        }
    }
}
