//! Elasticity: the force of an instantaneous displacement.
//!
//! Every elastic response is a stiffness p times a function of the displacement with at most one number
//! more, its shape: the exponent q, the share of C2, the exponent α, or 1/Jm.

use std::borrow::Cow;

use super::Parameter;
use super::gauge::{Deformation, Gauge};

/// Elastic response N(x) = p/(q+1) x^(q+1) for x > 0, else 0, in N (eq. 3.2).
///
/// `compression` in mm, `p` in N/mm^(q+1).
#[must_use]
pub fn elastic_response(p: f64, q: f64, compression: f64) -> f64 {
    if compression <= 0.0 {
        return 0.0;
    }
    let exponent = q + 1.0;
    p / exponent * compression.powf(exponent)
}

/// A law of an incompressible solid at large strain. A is the cross-section before the deformation, G the
/// shear modulus at small strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hyperelastic {
    /// Gaussian chains: in tension F = GA (λ − λ⁻²).
    NeoHooke,
    /// In tension F = 2 (C1A + C2A/λ)(λ − λ⁻²).
    MooneyRivlin,
    /// Of one term: in tension F = 2 GA/α (λ^(α−1) − λ^(−α/2−1)).
    Ogden,
    /// Chains of limited extension: F of Neo-Hooke over 1 − J/Jm, in tension J = λ² + 2/λ − 3.
    Gent,
}

impl Hyperelastic {
    /// Every law.
    pub const ALL: [Self; 4] = [Self::NeoHooke, Self::MooneyRivlin, Self::Ogden, Self::Gent];

    /// Name in model files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NeoHooke => "neo-hooke",
            Self::MooneyRivlin => "mooney-rivlin",
            Self::Ogden => "ogden",
            Self::Gent => "gent",
        }
    }

    /// The law of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }
}

/// How the elastic response grows with the displacement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Elastic {
    /// A power of the compression, p/(q+1) x^(q+1) (eq. 3.2).
    #[default]
    Power,
    /// A law of the stretch, for a specimen of this gauge.
    Stretch(Hyperelastic, Gauge),
}

/// Name of the power law among the elastic responses.
pub const POWER: &str = "power";
/// Exponents q that the power law may have.
pub const EXPONENTS_Q: (f64, f64) = (-0.9, 6.0);
const EXPONENTS_ALPHA: (f64, f64) = (-10.0, 30.0);
/// Part of the limit Jm that the largest deformation of the data may reach; beyond it the stiffening goes
/// on in a straight line, so that a prediction stays finite.
const LIMIT: f64 = 0.98;
/// Least part of it: there a limit is no longer told from none.
const NO_LIMIT: f64 = 1e-5;
/// A specimen is not pressed below this part of its height.
const FLAT: f64 = 1e-3;
const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);

impl Elastic {
    /// Name in model files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Power => POWER,
            Self::Stretch(law, _) => law.name(),
        }
    }

    /// Gauge of the specimen, where the law needs it.
    #[must_use]
    pub const fn gauge(self) -> Option<Gauge> {
        match self {
            Self::Power => None,
            Self::Stretch(_, gauge) => Some(gauge),
        }
    }

    /// Response, N, of a unit stiffness p at a displacement, mm.
    #[must_use]
    pub fn unit(self, shape: f64, x: f64) -> f64 {
        let Self::Stretch(law, gauge) = self else { return elastic_response(1.0, shape, x) };
        let part = x / gauge.length_mm;
        match gauge.deformation {
            Deformation::Tension => pulled(law, shape, 1.0 + part),
            Deformation::Compression => -pulled(law, shape, 1.0 - part),
            Deformation::Shear => sheared(law, shape, part),
        }
    }

    /// Its parameters in order; the exponent q of the power law is at least `least_q`.
    #[must_use]
    pub fn parameters(self, least_q: f64) -> Vec<Parameter> {
        let stiffness = |name, meaning| parameter(name, "N", meaning, POSITIVE);
        let modulus = || stiffness("GA", "shear modulus at small strain times cross-section");
        let Self::Stretch(law, _) = self else {
            let meaning = "exponent by which the stiffness grows with compression";
            return vec![
                parameter("p", "N/mm^(q+1)", "stiffness of the elastic response", POSITIVE),
                parameter("q", "", meaning, (least_q, EXPONENTS_Q.1)),
            ];
        };
        match law {
            Hyperelastic::NeoHooke => vec![modulus()],
            Hyperelastic::MooneyRivlin => vec![
                stiffness("C1A", "first constant times cross-section"),
                stiffness("C2A", "second constant times cross-section"),
            ],
            Hyperelastic::Ogden => {
                vec![modulus(), parameter("alpha", "", "exponent of the stretch", EXPONENTS_ALPHA)]
            }
            Hyperelastic::Gent => {
                let meaning = "limit of the deformation J, λ² + 2/λ − 3 in tension";
                vec![modulus(), parameter("Jm", "", meaning, POSITIVE)]
            }
        }
    }

    /// Number of its parameters.
    #[must_use]
    pub const fn count(self) -> usize {
        match self {
            Self::Stretch(Hyperelastic::NeoHooke, _) => 1,
            _ => 2,
        }
    }

    /// Stiffness p and shape of these parameters.
    #[must_use]
    pub fn constants(self, parameters: &[f64]) -> (f64, f64) {
        match self {
            Self::Stretch(Hyperelastic::NeoHooke, _) => (parameters[0], 0.0),
            Self::Stretch(Hyperelastic::MooneyRivlin, _) => {
                let sum = parameters[0] + parameters[1];
                (2.0 * sum, if sum > 0.0 { parameters[1] / sum } else { 0.0 })
            }
            Self::Stretch(Hyperelastic::Gent, _) => {
                (parameters[0], 1.0 / parameters[1].max(f64::MIN_POSITIVE.sqrt()))
            }
            _ => (parameters[0], parameters[1]),
        }
    }

    /// The parameters of this stiffness and shape.
    #[must_use]
    pub fn parameters_of(self, p: f64, shape: f64) -> Vec<f64> {
        match self {
            Self::Stretch(Hyperelastic::NeoHooke, _) => vec![p],
            Self::Stretch(Hyperelastic::MooneyRivlin, _) => {
                vec![0.5 * p * (1.0 - shape), 0.5 * p * shape]
            }
            Self::Stretch(Hyperelastic::Gent, _) => vec![p, 1.0 / shape],
            _ => vec![p, shape],
        }
    }

    /// Bounds of the shape for displacements up to `largest`, mm; none where there is no shape.
    #[must_use]
    pub fn shape_bounds(self, least_q: f64, largest: f64) -> Option<(f64, f64)> {
        let Self::Stretch(law, _) = self else { return Some((least_q, EXPONENTS_Q.1)) };
        match law {
            Hyperelastic::NeoHooke => None,
            Hyperelastic::MooneyRivlin => Some((0.0, 1.0)),
            Hyperelastic::Ogden => Some(EXPONENTS_ALPHA),
            Hyperelastic::Gent => {
                let most = self.invariant(largest).max(f64::MIN_POSITIVE.sqrt());
                Some((NO_LIMIT / most, LIMIT / most))
            }
        }
    }

    /// Shapes from which a search over displacements up to `largest`, mm, starts.
    #[must_use]
    pub fn shapes(self, largest: f64) -> Vec<f64> {
        let Self::Stretch(law, _) = self else {
            return vec![0.0, 0.3, 0.6, 1.0, 1.5, 2.2, 3.0];
        };
        match law {
            Hyperelastic::NeoHooke => vec![0.0],
            Hyperelastic::MooneyRivlin => vec![0.0, 0.5, 1.0],
            Hyperelastic::Ogden => vec![-2.0, 1.0, 2.0, 3.5, 6.0, 12.0],
            Hyperelastic::Gent => {
                let most = self.invariant(largest).max(f64::MIN_POSITIVE.sqrt());
                [0.05, 0.3, 0.6, 0.9].map(|part| part / most).to_vec()
            }
        }
    }

    /// The deformation J = I1 − 3 at a displacement, mm.
    fn invariant(self, x: f64) -> f64 {
        let Some(gauge) = self.gauge() else { return 0.0 };
        let part = x / gauge.length_mm;
        match gauge.deformation {
            Deformation::Tension => invariant(1.0 + part),
            Deformation::Compression => invariant(1.0 - part),
            Deformation::Shear => part * part,
        }
    }
}

/// A parameter of a law.
pub(super) fn parameter(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    (lower, upper): (f64, f64),
) -> Parameter {
    let owned = Cow::Borrowed;
    Parameter {
        name: owned(name),
        unit: owned(unit),
        meaning: owned(meaning),
        lower,
        upper,
        bounded: true,
    }
}

/// Force of a unit GA at a stretch along the axis, positive in tension.
fn pulled(law: Hyperelastic, shape: f64, stretch: f64) -> f64 {
    let stretch = stretch.max(FLAT);
    let gaussian = stretch - stretch.powi(-2);
    match law {
        Hyperelastic::NeoHooke => gaussian,
        Hyperelastic::MooneyRivlin => gaussian * (1.0 - shape + shape / stretch),
        Hyperelastic::Ogden => {
            let log = stretch.ln();
            3.0 * log * stretch.powf(-0.5 * shape - 1.0) * mean_growth(1.5 * shape * log)
        }
        Hyperelastic::Gent => gaussian * limited(shape * invariant(stretch)),
    }
}

/// Force of a unit GA at a shear strain γ.
fn sheared(law: Hyperelastic, shape: f64, strain: f64) -> f64 {
    match law {
        // The two constants are one in shear.
        Hyperelastic::NeoHooke | Hyperelastic::MooneyRivlin => strain,
        Hyperelastic::Ogden => {
            // λ − 1/λ = γ, F = 2/α (λ^α − λ^(−α))/(λ + 1/λ).
            let log = (0.5 * strain).asinh();
            let grown = mean_growth(2.0 * shape * log) * (-shape * log).exp();
            2.0 * log * grown / log.cosh()
        }
        Hyperelastic::Gent => strain * limited(shape * strain * strain),
    }
}

/// J = λ² + 2/λ − 3.
fn invariant(stretch: f64) -> f64 {
    let stretch = stretch.max(FLAT);
    // (λ − 1)² (λ + 2)/λ, which does not cancel at small strain.
    (stretch - 1.0).powi(2) * (stretch + 2.0) / stretch
}

/// 1/(1 − r), which goes on in a straight line beyond [`LIMIT`].
fn limited(r: f64) -> f64 {
    if r <= LIMIT {
        return 1.0 / (1.0 - r);
    }
    let at = 1.0 / (1.0 - LIMIT);
    at + at * at * (r - LIMIT)
}

/// (e^z − 1)/z.
fn mean_growth(z: f64) -> f64 {
    if z.abs() < 1e-8 { 1.0 + 0.5 * z } else { z.exp_m1() / z }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAUGE: Gauge = Gauge { length_mm: 20.0, deformation: Deformation::Tension };

    fn law(law: Hyperelastic, deformation: Deformation) -> Elastic {
        Elastic::Stretch(law, Gauge { deformation, ..GAUGE })
    }

    #[test]
    fn follows_the_power_law_and_is_zero_off_the_specimen() {
        assert!((elastic_response(0.3, 1.0, 2.0) - 0.3 / 2.0 * 4.0).abs() < 1e-15);
        assert_eq!(elastic_response(0.3, 1.0, 0.0), 0.0);
        assert_eq!(elastic_response(0.3, 1.0, -1.0), 0.0);
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
                (Hyperelastic::NeoHooke, 0.0),
                (Hyperelastic::MooneyRivlin, 0.4),
                (Hyperelastic::Ogden, 5.0),
                (Hyperelastic::Ogden, 0.0),
                (Hyperelastic::Ogden, -3.0),
                (Hyperelastic::Gent, 0.02),
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
        let energy = |kind, shape: f64, l: [f64; 3]| {
            let sum = |power: f64| l.iter().map(|l| l.powf(power)).sum::<f64>() - 3.0;
            match kind {
                Hyperelastic::NeoHooke => 0.5 * sum(2.0),
                Hyperelastic::MooneyRivlin => 0.5 * ((1.0 - shape) * sum(2.0) + shape * sum(-2.0)),
                Hyperelastic::Ogden => 2.0 / (shape * shape) * sum(shape),
                Hyperelastic::Gent => -0.5 / shape * (1.0 - shape * sum(2.0)).ln(),
            }
        };
        for deformation in Deformation::ALL {
            for (kind, shape) in [
                (Hyperelastic::NeoHooke, 0.0),
                (Hyperelastic::MooneyRivlin, 0.3),
                (Hyperelastic::Ogden, 3.4),
                (Hyperelastic::Ogden, -1.5),
                (Hyperelastic::Gent, 0.08),
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
        let gent = law(Hyperelastic::Gent, Deformation::Tension);
        let force: Vec<f64> = (0..100).map(|k| gent.unit(0.1, f64::from(k))).collect();
        assert!(force.windows(2).all(|pair| pair[1] > pair[0] && pair[1].is_finite()));
    }

    #[test]
    fn parameters_come_back_from_stiffness_and_shape() {
        for (kind, values) in [
            (Hyperelastic::NeoHooke, vec![2.0]),
            (Hyperelastic::MooneyRivlin, vec![0.5, 0.2]),
            (Hyperelastic::Ogden, vec![2.0, -1.5]),
            (Hyperelastic::Gent, vec![2.0, 40.0]),
        ] {
            let law = law(kind, Deformation::Tension);
            let (p, shape) = law.constants(&values);
            let back = law.parameters_of(p, shape);
            assert_eq!(law.parameters(0.0).len(), law.count());
            assert!(back.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-12), "{kind:?}");
        }
    }
}
