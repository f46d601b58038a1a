//! The coordinates in which a base law is searched for.
//!
//! They are the forces P0…Pn ≥ 0 that the branches carry at the largest compression, the shape of the
//! elastic response (the exponent q), the logarithms of the rates, the power n, the order β of a kernel and
//! the force of a damper: in these, shares that are not negative
//! and sum to one are plain bounds, and the stiffness does not trade off against the exponent.

use palpate_model::{BaseLaw, Constants, Coordinate};

use super::data::Data;

/// The coordinates of a base law at a reference compression, mm.
#[derive(Clone, Debug)]
pub struct Coordinates {
    law: BaseLaw,
    reference: f64,
    list: Vec<Coordinate>,
}

/// A model without any force has no shares either; the tiny floor keeps them finite.
const NO_FORCE: f64 = f64::MIN_POSITIVE;

impl Coordinates {
    /// Those of this law.
    #[must_use]
    pub fn new(law: BaseLaw, reference: f64) -> Self {
        let mut list: Vec<Coordinate> =
            law.declared().iter().map(|parameter| parameter.coordinate).collect();
        list.sort_unstable();
        Self { law, reference, list }
    }

    /// Those of another law at the same reference.
    #[must_use]
    pub fn of(&self, law: BaseLaw) -> Self {
        Self::new(law, self.reference)
    }

    /// The reference compression, mm.
    #[must_use]
    pub fn reference(&self) -> f64 {
        self.reference
    }

    /// Each coordinate, in order.
    #[must_use]
    pub fn list(&self) -> &[Coordinate] {
        &self.list
    }

    /// Number of coordinates: that of the law's parameters.
    #[must_use]
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Bounds of every coordinate on these data.
    #[must_use]
    pub fn bounds(&self, data: &Data) -> Vec<(f64, f64)> {
        let rates = ((0.02 / data.longest()).ln(), (3.0 / data.shortest_interval()).ln());
        let least_q = self.law.family.least_q;
        let shapes = self.law.elastic.shape_bounds(least_q, self.reference);
        let bound = |coordinate: &Coordinate| match coordinate {
            Coordinate::Rate(_) => rates,
            Coordinate::Shape => shapes.unwrap_or((0.0, 0.0)),
            Coordinate::Order | Coordinate::Power => self.range(*coordinate),
            Coordinate::Force(_) | Coordinate::Total | Coordinate::Damping => (0.0, f64::INFINITY),
        };
        self.list.iter().map(bound).collect()
    }

    /// The range of the parameter that a coordinate stands for.
    fn range(&self, coordinate: Coordinate) -> (f64, f64) {
        let declared = self.law.declared();
        let own = declared.iter().find(|parameter| parameter.coordinate == coordinate);
        own.map_or((0.0, f64::INFINITY), |parameter| parameter.range)
    }

    /// The law's parameters at a point.
    #[must_use]
    pub fn declared(&self, point: &[f64]) -> Vec<f64> {
        let terms = self.law.terms;
        let mut forces = vec![0.0; terms + 1];
        let mut constants = Constants::new(0.0, self.law.family.shape);
        constants.rates = vec![1.0; terms];
        constants.exponent = self.law.exponent.unwrap_or(1.0);
        let mut damping = 0.0;
        for (coordinate, &value) in self.list.iter().zip(point) {
            match *coordinate {
                Coordinate::Force(branch) => forces[branch] = value,
                Coordinate::Total => {
                    let equilibrium = 1.0 / f64::from(self.law.segments.unwrap_or(1));
                    forces[0] = equilibrium * value;
                    forces[1] = value - forces[0];
                }
                Coordinate::Shape => constants.shape = value,
                Coordinate::Order => constants.order = value,
                Coordinate::Rate(branch) => constants.rates[branch - 1] = value.exp(),
                Coordinate::Power => constants.exponent = value,
                Coordinate::Damping => damping = value,
            }
        }
        if let Some(relaxing) = forces.get_mut(1) {
            *relaxing /= self.later(constants.order);
        }
        let total = forces.iter().sum::<f64>() + NO_FORCE.sqrt();
        constants.p = total / self.law.elastic.unit(constants.shape, self.reference);
        constants.shares = forces[1..].iter().map(|force| force / total).collect();
        constants.viscosity = damping / constants.p;
        let scale = self.reference.powf(constants.exponent - 1.0);
        constants.rates.iter_mut().for_each(|rate| *rate /= scale);
        self.law.parameters_of(&constants)
    }

    /// The point of these parameters of the law.
    #[must_use]
    pub fn point(&self, declared: &[f64]) -> Vec<f64> {
        let constants = self.law.constants(declared);
        let total = constants.p * self.law.elastic.unit(constants.shape, self.reference);
        let later = self.later(constants.order);
        let equilibrium = constants.equilibrium();
        let scale = self.reference.powf(constants.exponent - 1.0);
        let value = |coordinate: &Coordinate| match *coordinate {
            Coordinate::Force(0) => (equilibrium * total).max(0.0),
            Coordinate::Force(branch) => constants.shares[branch - 1] * total * later,
            Coordinate::Total => total,
            Coordinate::Shape => constants.shape,
            Coordinate::Order => constants.order,
            Coordinate::Rate(branch) => {
                (constants.rates[branch - 1] * scale).max(f64::MIN_POSITIVE).ln()
            }
            Coordinate::Power => constants.exponent,
            Coordinate::Damping => constants.viscosity * constants.p,
        };
        self.list.iter().map(value).collect()
    }

    /// Part of a kernel's share at which its force is a coordinate: at one second that of a power law would trade off against the
    /// order wherever the data last much longer or shorter.
    fn later(&self, order: f64) -> f64 {
        self.law.kernel.later(order, self.law.span)
    }

    /// The coordinate whose bound is that of each parameter of the law; none where no bound is its own.
    #[must_use]
    pub fn bound_of_parameters(&self) -> Vec<Option<usize>> {
        let place = |wanted| self.list.iter().position(|coordinate| *coordinate == wanted);
        let declared = self.law.declared().into_iter();
        declared.map(|own| own.bounded.then(|| place(own.coordinate)).flatten()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_model::elastic::ELASTIC_LAWS;
    use palpate_model::kernel::KERNELS;
    use palpate_model::laws::FAMILIES;
    use palpate_model::{Deformation, Elastic, ElasticLaw, Family, Gauge, Kernel, Separation};
    use proptest::prelude::*;

    /// Every law, with its options.
    fn laws() -> Vec<BaseLaw> {
        let mut laws: Vec<BaseLaw> = FAMILIES
            .iter()
            .flat_map(|&family| [1, 3].map(|terms| BaseLaw::new(family, terms, Separation::Clamp)))
            .collect();
        let latency = BaseLaw::new(Family::LATENCY_POWER, 1, Separation::Clamp);
        laws.push(BaseLaw { segments: Some(8), ..latency });
        laws.push(BaseLaw { exponent: Some(5.0), ..latency });
        laws.push(BaseLaw { segments: Some(8), exponent: Some(5.0), ..latency });
        let linear = BaseLaw::new(Family::LATENCY, 1, Separation::Clamp);
        laws.push(BaseLaw { segments: Some(8), ..linear });
        let fung = BaseLaw::fung(2, Separation::Clamp);
        laws.extend(KERNELS.iter().map(|kernel| fung.with(Elastic::POWER, kernel)));
        let gauge = Gauge { length_mm: 40.0, deformation: Deformation::Tension };
        let rubber =
            |law: &&'static ElasticLaw| fung.with(Elastic::stretch(law, gauge), Kernel::POWER_LAW);
        laws.extend(ELASTIC_LAWS[1..].iter().map(rubber));
        laws
    }

    #[test]
    fn every_law_has_a_coordinate_for_each_of_its_parameters() {
        for law in laws() {
            let coordinates = Coordinates::new(law, 4.0);
            assert_eq!(coordinates.count(), law.parameters().len(), "{}", law.in_words());
            assert_eq!(coordinates.count(), law.count(), "{}", law.in_words());
        }
    }

    proptest! {
        #[test]
        fn parameters_come_back_from_their_point(
            numbers in proptest::collection::vec(0.05f64..2.0, 12),
            reference in 0.5f64..30.0,
        ) {
            for law in laws() {
                let coordinates = Coordinates::new(law, reference);
                let point: Vec<f64> = coordinates
                    .list()
                    .iter()
                    .zip(&numbers)
                    .map(|(coordinate, number)| match coordinate {
                        Coordinate::Power => 1.0 + number,
                        Coordinate::Shape | Coordinate::Order => 0.3 * number,
                        _ => *number,
                    })
                    .collect();
                let back = coordinates.point(&coordinates.declared(&point));
                for (a, b) in point.iter().zip(&back) {
                    prop_assert!((a - b).abs() < 1e-9 * (1.0 + a.abs()), "{}", law.in_words());
                }
            }
        }
    }
}
