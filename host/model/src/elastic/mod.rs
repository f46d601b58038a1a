//! Elasticity: the force of an instantaneous displacement. One declaration a file, and one line in [`ELASTIC_LAWS`].
//!
//! Every elastic response is a stiffness p times a function of the displacement with at most one number
//! more, its shape: the exponent q, the share of C2, the exponent α, or 1/Jm.

mod declaration;
mod gent;
mod mooney_rivlin;
mod neo_hooke;
mod ogden;
mod power;

pub use declaration::{Acts, ElasticLaw, Reach, Shear};
pub use power::{EXPONENTS_Q, elastic_response};

use crate::coordinate::Coordinate;
use crate::gauge::{Deformation, Gauge};
use crate::laws::LawParameter;

/// Every elastic response of the library.
pub const ELASTIC_LAWS: &[&ElasticLaw] = &[
    ElasticLaw::POWER,
    ElasticLaw::NEO_HOOKE,
    ElasticLaw::MOONEY_RIVLIN,
    ElasticLaw::OGDEN,
    ElasticLaw::GENT,
];

impl ElasticLaw {
    /// A power of the compression (eq. 3.2).
    pub const POWER: &Self = &power::LAW;
    /// Gaussian chains.
    pub const NEO_HOOKE: &Self = &neo_hooke::LAW;
    /// Two constants.
    pub const MOONEY_RIVLIN: &Self = &mooney_rivlin::LAW;
    /// One term of Ogden's series.
    pub const OGDEN: &Self = &ogden::LAW;
    /// Chains of limited extension.
    pub const GENT: &Self = &gent::LAW;
}

/// How the elastic response grows with the displacement: a law, and the gauge of the specimen where it is one of the stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// The law.
    pub law: &'static ElasticLaw,
    /// Gauge of the specimen; none where the law is one of the displacement.
    pub gauge: Option<Gauge>,
}

/// A specimen is not pressed below this part of its height.
const MIN_HEIGHT: f64 = 1e-3;

impl Elastic {
    /// A power of the compression, p/(q+1) x^(q+1) (eq. 3.2).
    pub const POWER: Self = Self { law: ElasticLaw::POWER, gauge: None };

    /// A law of the stretch, for a specimen of this gauge.
    #[must_use]
    pub const fn stretch(law: &'static ElasticLaw, gauge: Gauge) -> Self {
        Self { law, gauge: Some(gauge) }
    }

    /// Name in model files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.law.name
    }

    /// Response, N, of a unit stiffness p at a displacement, mm.
    #[must_use]
    pub fn unit(self, shape: f64, x: f64) -> f64 {
        match (self.law.acts, self.gauge) {
            (Acts::OnDisplacement(response), _) => response(shape, x),
            (Acts::OnStretch { pulled, sheared }, Some(gauge)) => {
                let part = x / gauge.length_mm;
                match gauge.deformation {
                    Deformation::Tension => pulled(shape, (1.0 + part).max(MIN_HEIGHT)),
                    Deformation::Compression => -pulled(shape, (1.0 - part).max(MIN_HEIGHT)),
                    Deformation::Shear => match sheared {
                        Shear::Own(response) => response(shape, part),
                        Shear::As(law) => law.in_shear(shape, part),
                    },
                }
            }
            // Without a gauge there is no stretch.
            (Acts::OnStretch { .. }, None) => 0.0,
        }
    }

    /// Its parameters in order; the exponent q of the power law is at least `least_q`, and the stiffness stands for this coordinate.
    #[must_use]
    pub fn parameters(self, least_q: f64, stiffness: Coordinate) -> Vec<LawParameter> {
        (self.law.parameters)(least_q, stiffness)
    }

    /// Number of its parameters.
    #[must_use]
    pub fn count(self) -> usize {
        self.parameters(0.0, Coordinate::Total).len()
    }

    /// Stiffness p and shape of the first of these values, and the values that follow.
    #[must_use]
    pub fn split(self, values: &[f64]) -> (f64, f64, &[f64]) {
        let (own, rest) = values.split_at(self.count().min(values.len()));
        let (p, shape) = (self.law.constants)(own);
        (p, shape, rest)
    }

    /// The values of its parameters at this stiffness and shape.
    #[must_use]
    pub fn values(self, p: f64, shape: f64) -> Vec<f64> {
        (self.law.values)(p, shape)
    }

    /// Bounds of the shape for displacements up to `largest`, mm; none where there is no shape.
    #[must_use]
    pub fn shape_bounds(self, least_q: f64, largest: f64) -> Option<(f64, f64)> {
        (self.law.bounds)(&self.reach(least_q, largest))
    }

    /// Shapes from which a search over displacements up to `largest`, mm, starts.
    #[must_use]
    pub fn shapes(self, largest: f64) -> Vec<f64> {
        (self.law.starts)(&self.reach(EXPONENTS_Q.0, largest))
    }

    fn reach(self, least_q: f64, largest: f64) -> Reach {
        Reach { least_q, largest, invariant: self.invariant(largest).max(f64::MIN_POSITIVE.sqrt()) }
    }

    /// The deformation J = I1 − 3 at a displacement, mm.
    fn invariant(self, x: f64) -> f64 {
        let Some(gauge) = self.gauge else { return 0.0 };
        let part = x / gauge.length_mm;
        match gauge.deformation {
            Deformation::Tension => invariant(1.0 + part),
            Deformation::Compression => invariant(1.0 - part),
            Deformation::Shear => part * part,
        }
    }
}

impl Default for Elastic {
    fn default() -> Self {
        Self::POWER
    }
}

/// J = λ² + 2/λ − 3.
fn invariant(stretch: f64) -> f64 {
    let stretch = stretch.max(MIN_HEIGHT);
    // (λ − 1)² (λ + 2)/λ, which does not cancel at small strain.
    (stretch - 1.0).powi(2) * (stretch + 2.0) / stretch
}

/// What Gaussian chains carry at a stretch λ along the axis: λ − λ⁻².
fn gaussian(stretch: f64) -> f64 {
    stretch - stretch.powi(-2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAUGE: Gauge = Gauge { length_mm: 20.0, deformation: Deformation::Tension };

    fn law(law: &'static ElasticLaw, deformation: Deformation) -> Elastic {
        Elastic::stretch(law, Gauge { deformation, ..GAUGE })
    }

    #[test]
    fn follows_the_power_law_to_either_side() {
        assert!((elastic_response(0.3, 1.0, 2.0) - 0.3 / 2.0 * 4.0).abs() < 1e-15);
        assert_eq!(elastic_response(0.3, 1.0, 0.0), 0.0);
        assert_eq!(elastic_response(0.3, 1.0, -2.0), -elastic_response(0.3, 1.0, 2.0));
    }

    #[test]
    fn at_small_strain_every_law_has_the_same_modulus() {
        // E = 3 G in tension and compression, G in shear.
        for (deformation, modulus) in [
            (Deformation::Tension, 3.0),
            (Deformation::Compression, 3.0),
            (Deformation::Shear, 1.0),
        ] {
            for (kind, shape) in [
                (ElasticLaw::NEO_HOOKE, 0.0),
                (ElasticLaw::MOONEY_RIVLIN, 0.4),
                (ElasticLaw::OGDEN, 5.0),
                (ElasticLaw::OGDEN, 0.0),
                (ElasticLaw::OGDEN, -3.0),
                (ElasticLaw::GENT, 0.02),
            ] {
                let force = law(kind, deformation).unit(shape, 20.0 * 1e-6);
                assert!((force / (1e-6 * modulus) - 1.0).abs() < 1e-4, "{kind:?} {deformation:?}");
            }
        }
    }

    #[test]
    fn a_force_is_the_slope_of_the_energy_that_the_law_is_known_by() {
        let stretched = |deformation, part: f64| match deformation {
            Deformation::Tension => (1.0 + part).ln(),
            _ => (1.0 - part).ln(),
        };
        // Principal stretches λ1 = e^a, λ2, λ3 of an incompressible body.
        let principal = |deformation, part: f64| -> [f64; 3] {
            if deformation == Deformation::Shear {
                let a = (0.5 * part).asinh();
                return [a.exp(), 1.0, (-a).exp()];
            }
            let a = stretched(deformation, part);
            [a.exp(), (-0.5 * a).exp(), (-0.5 * a).exp()]
        };
        let energy = |kind: &ElasticLaw, shape: f64, l: [f64; 3]| {
            let sum = |power: f64| l.iter().map(|l| l.powf(power)).sum::<f64>() - 3.0;
            match kind.name {
                "neo-hooke" => 0.5 * sum(2.0),
                "mooney-rivlin" => 0.5 * ((1.0 - shape) * sum(2.0) + shape * sum(-2.0)),
                "ogden" => 2.0 / (shape * shape) * sum(shape),
                _ => -0.5 / shape * (1.0 - shape * sum(2.0)).ln(),
            }
        };
        for deformation in Deformation::ALL {
            for (kind, shape) in [
                (ElasticLaw::NEO_HOOKE, 0.0),
                (ElasticLaw::MOONEY_RIVLIN, 0.3),
                (ElasticLaw::OGDEN, 3.4),
                (ElasticLaw::OGDEN, -1.5),
                (ElasticLaw::GENT, 0.08),
            ] {
                for part in [-0.3, 0.05, 0.4, 0.6] {
                    let h = 1e-5;
                    let at = |part| energy(kind, shape, principal(deformation, part));
                    let slope = (at(part + h) - at(part - h)) / (2.0 * h);
                    let force = law(kind, deformation).unit(shape, 20.0 * part);
                    let off = (force - slope).abs();
                    assert!(
                        off < 1e-6 * (1.0 + slope.abs()),
                        "{kind:?} {deformation:?} {part}: {force} {slope}"
                    );
                }
            }
        }
    }

    #[test]
    fn beyond_its_limit_gents_law_stays_finite_and_grows() {
        let gent = law(ElasticLaw::GENT, Deformation::Tension);
        let force: Vec<f64> = (0..100).map(|k| gent.unit(0.1, f64::from(k))).collect();
        assert!(force.windows(2).all(|pair| pair[1] > pair[0] && pair[1].is_finite()));
    }

    #[test]
    fn parameters_come_back_from_stiffness_and_shape() {
        for (kind, values) in [
            (ElasticLaw::NEO_HOOKE, vec![2.0]),
            (ElasticLaw::MOONEY_RIVLIN, vec![0.5, 0.2]),
            (ElasticLaw::OGDEN, vec![2.0, -1.5]),
            (ElasticLaw::GENT, vec![2.0, 40.0]),
        ] {
            let law = law(kind, Deformation::Tension);
            let (p, shape, _) = law.split(&values);
            let back = law.values(p, shape);
            assert_eq!(values.len(), law.count());
            assert!(back.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-12), "{kind:?}");
        }
    }
}
