//! Force of a tip over its depth, and over the way of the piezo that carries the cantilever.

use crate::Tip;

/// A tip on an elastic half space, with adhesion after Derjaguin, Muller and Toporov: the contact is that without adhesion,
/// and a constant force pulls while it lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// The tip.
    pub tip: Tip,
    /// Reduced modulus E/(1 − ν²), Pa.
    pub reduced_modulus: f64,
    /// Pull of adhesion while in contact, N; 0 or more.
    pub adhesion_n: f64,
}

impl Law {
    /// Force, N, with the piezo at `z`, m: 0 where tip and surface would touch if the cantilever were straight. A rigid
    /// cantilever where no spring constant, N/m, is given.
    #[must_use]
    pub fn force(&self, z: f64, spring: Option<f64>) -> f64 {
        let Some(k) = spring else {
            return if z > 0.0 { self.at_depth(z) } else { 0.0 };
        };
        match self.depth(z, k) {
            Some(depth) => k * (z - depth),
            None => 0.0,
        }
    }

    /// Force at a depth above 0, N.
    fn at_depth(&self, depth: f64) -> f64 {
        self.tip.force(self.reduced_modulus, depth) - self.adhesion_n
    }

    /// Depth, m, at which the contact and the cantilever bear the same force; none out of contact. Newton's method from
    /// above on an increasing convex function: every step stays above the root.
    fn depth(&self, z: f64, k: f64) -> Option<f64> {
        let mut depth = z + self.adhesion_n / k;
        if depth <= 0.0 {
            return None;
        }
        for _ in 0..60 {
            let excess = self.at_depth(depth) - k * (z - depth);
            // dF/dδ = 2 E* a.
            let slope = 2.0 * self.reduced_modulus * self.tip.contact_radius(depth) + k;
            let step = excess / slope;
            depth -= step;
            if step.abs() <= 1e-14 * depth.abs() {
                break;
            }
        }
        Some(depth.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn contact_and_cantilever_bear_the_same_force(
            z in 1e-10f64..1e-6, log_k in -3f64..2.0, log_e in 1f64..11.0, pull in 0f64..1e-9, cone: bool,
        ) {
            let tip = if cone {
                Tip::Cone { half_angle_rad: 0.6 }
            } else {
                Tip::Paraboloid { radius_m: 1e-7 }
            };
            let (k, law) = (
                10f64.powf(log_k),
                Law { tip, reduced_modulus: 10f64.powf(log_e), adhesion_n: pull },
            );
            let force = law.force(z, Some(k));
            let depth = z - force / k;
            prop_assert!(depth >= -1e-9 * z);
            let contact = law.tip.force(law.reduced_modulus, depth) - pull;
            let scale = k * z + pull;
            prop_assert!((contact - force).abs() <= 1e-6 * scale, "{contact} {force}");
        }
    }

    #[test]
    fn adhesion_pulls_until_the_contact_breaks() {
        let tip = Tip::Paraboloid { radius_m: 1e-6 };
        let law = Law { tip, reduced_modulus: 1e4, adhesion_n: 1e-10 };
        let k = 0.1;
        assert_eq!(law.force(-1.1e-9, Some(k)), 0.0);
        assert!((law.force(-0.999e-9, Some(k)) + 1e-10).abs() < 1e-12);
    }
}
