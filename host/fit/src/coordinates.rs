//! The coordinates in which a base law is searched for.
//!
//! They are the forces P0…Pn ≥ 0 that the branches carry at the largest compression, the shape of the
//! elastic response (the exponent q), the logarithms of the rates, the power n, the order β of a kernel and
//! the force of a damper: in these, shares that are not negative
//! and sum to one are plain bounds, and the stiffness does not trade off against the exponent.

use palpate_model::{
    BaseLaw, Constants, EXPONENTS_N, Family, Kernel, POWER_ORDERS, STRETCHED_ORDERS,
};

use super::data::Data;

/// One coordinate of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Force of a branch at the reference compression, N; the equilibrium is branch 0.
    Force(usize),
    /// Force of all branches together, N, where the shares are given.
    Total,
    /// Shape of the elastic response: the exponent q of the power law.
    Shape,
    /// Logarithm of the rate, 1/s, of a branch with a state of the reference compression.
    Rate(usize),
    /// Power n of the state that its rate of change follows.
    Power,
    /// Order β of a kernel.
    Order,
    /// Damping, N·s/mm.
    Damping,
}

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
        use Coordinate::{Damping, Force, Order, Power, Rate, Shape, Total};
        let terms = law.terms;
        let mut list = Vec::new();
        match law.family {
            Family::KelvinVoigt => list.extend([Force(0), Damping]),
            Family::Maxwell => list.extend([Force(1), Rate(1)]),
            _ => {
                match law.segments {
                    Some(_) => list.push(Total),
                    None if law.kernel == Kernel::None => list.push(Force(0)),
                    None => list.extend((0..=terms).map(Force)),
                }
                if !law.family.is_linear() && law.elastic.shape_bounds(0.0, reference).is_some() {
                    list.push(Shape);
                }
                match law.kernel {
                    Kernel::Exponentials => list.extend((1..=terms).map(Rate)),
                    Kernel::PowerLaw => list.push(Order),
                    Kernel::Stretched => list.extend([Rate(1), Order]),
                    Kernel::None => {}
                }
                if law.family == Family::LatencyPower && law.exponent.is_none() {
                    list.push(Power);
                }
            }
        }
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
        let shapes = self.law.elastic.shape_bounds(self.law.least_q(), self.reference);
        let bound = |coordinate: &Coordinate| match coordinate {
            Coordinate::Rate(_) => rates,
            Coordinate::Shape => shapes.unwrap_or((0.0, 0.0)),
            Coordinate::Order if self.law.kernel == Kernel::PowerLaw => POWER_ORDERS,
            Coordinate::Order => STRETCHED_ORDERS,
            Coordinate::Power => EXPONENTS_N,
            _ => (0.0, f64::INFINITY),
        };
        self.list.iter().map(bound).collect()
    }

    /// The law's parameters at a point.
    #[must_use]
    pub fn declared(&self, point: &[f64]) -> Vec<f64> {
        let terms = self.law.terms;
        let mut forces = vec![0.0; terms + 1];
        let mut constants = Constants::new(0.0, 0.0);
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
        if self.law.kernel == Kernel::PowerLaw {
            forces[1] *= self.span_middle().powf(constants.order);
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
        let later = match self.law.kernel {
            Kernel::PowerLaw => self.span_middle().powf(-constants.order),
            _ => 1.0,
        };
        let equilibrium = 1.0 - constants.shares.iter().sum::<f64>();
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

    /// Time at which the force of a power law is a coordinate, s: at one second it would trade off against
    /// the order wherever the data last much longer or shorter.
    fn span_middle(&self) -> f64 {
        self.law.span.middle()
    }

    /// The coordinate whose bound is that of each parameter of the law; none where no bound is its own.
    #[must_use]
    pub fn bound_of_parameters(&self) -> Vec<Option<usize>> {
        let place = |wanted| self.list.iter().position(|coordinate| *coordinate == wanted);
        let branch = |name: &str| name[1..].parse().ok();
        let of = |name: &str| match name {
            "q" | "C2A" | "alpha" | "Jm" => place(Coordinate::Shape),
            "beta" => place(Coordinate::Order),
            "tau" => place(Coordinate::Rate(1)),
            "n" => place(Coordinate::Power),
            "nu" => place(Coordinate::Rate(1)),
            "eta" => place(Coordinate::Damping).or_else(|| place(Coordinate::Rate(1))),
            _ if name.starts_with("eta") => {
                name[3..].parse().ok().and_then(|k| place(Coordinate::Rate(k)))
            }
            _ if name.starts_with('v') => branch(name).and_then(|k| place(Coordinate::Rate(k))),
            _ if name.starts_with(['c', 'k']) => {
                branch(name).and_then(|k| place(Coordinate::Force(k)))
            }
            _ => None,
        };
        self.law.parameters().iter().map(|parameter| of(&parameter.name)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_model::{Deformation, Elastic, Gauge, Hyperelastic, Separation};
    use proptest::prelude::*;

    /// Every law, with its options.
    fn laws() -> Vec<BaseLaw> {
        let mut laws: Vec<BaseLaw> = Family::ALL
            .iter()
            .flat_map(|&family| [1, 3].map(|terms| BaseLaw::new(family, terms, Separation::Clamp)))
            .collect();
        let latency = BaseLaw::new(Family::LatencyPower, 1, Separation::Clamp);
        laws.push(BaseLaw { segments: Some(8), ..latency });
        laws.push(BaseLaw { exponent: Some(5.0), ..latency });
        laws.push(BaseLaw { segments: Some(8), exponent: Some(5.0), ..latency });
        let linear = BaseLaw::new(Family::Latency, 1, Separation::Clamp);
        laws.push(BaseLaw { segments: Some(8), ..linear });
        let fung = BaseLaw::fung(2, Separation::Clamp);
        laws.extend(Kernel::ALL.map(|kernel| fung.with(Elastic::Power, kernel)));
        let gauge = Gauge { length_mm: 40.0, deformation: Deformation::Tension };
        let rubber = |law| fung.with(Elastic::Stretch(law, gauge), Kernel::PowerLaw);
        laws.extend(Hyperelastic::ALL.map(rubber));
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
