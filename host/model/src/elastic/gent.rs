//! `gent`: chains of limited extension.

use super::neo_hooke::modulus;
use super::{Acts, ElasticLaw, Reach, Shear, gaussian, invariant};
use crate::coordinate::Coordinate;
use crate::laws::{LawParameter, POSITIVE, divisor};

/// Part of the limit Jm that the largest deformation of the data may reach; beyond it the stiffening goes
/// on in a straight line, so that a prediction stays finite.
const LIMIT: f64 = 0.98;
/// Least part of it: there a limit is no longer told from none.
const NO_LIMIT: f64 = 1e-5;

/// F of Neo-Hooke over 1 − J/Jm, in tension J = λ² + 2/λ − 3; the shape is 1/Jm.
pub(super) static LAW: ElasticLaw = ElasticLaw {
    name: "gent",
    meaning: "a rubber whose chains end: it stiffens without bound towards a limit of the stretch",
    formula: "GA (λ − λ⁻²)/(1 − J/Jm), J = λ² + 2/λ − 3",
    acts: Acts::OnStretch {
        pulled: |shape, stretch| gaussian(stretch) * limited(shape * invariant(stretch)),
        sheared: Shear::Own(|shape, strain| strain * limited(shape * strain * strain)),
    },
    parameters: |_, stiffness| {
        let limit = "limit of the deformation J, λ² + 2/λ − 3 in tension";
        vec![modulus(stiffness), LawParameter::new("Jm", "", limit, POSITIVE, Coordinate::Shape)]
    },
    constants: |values| (values[0], 1.0 / divisor(values[1])),
    values: |p, shape| vec![p, 1.0 / shape],
    bounds: |Reach { invariant, .. }| Some((NO_LIMIT / invariant, LIMIT / invariant)),
    starts: |reach| [0.05, 0.3, 0.6, 0.9].map(|part| part / reach.invariant).to_vec(),
};

/// 1/(1 − r), which goes on in a straight line beyond [`LIMIT`].
fn limited(r: f64) -> f64 {
    if r <= LIMIT {
        return 1.0 / (1.0 - r);
    }
    let at = 1.0 / (1.0 - LIMIT);
    at + at * at * (r - LIMIT)
}
