//! `power`: a power of the compression.

use super::{Acts, ElasticLaw};
use crate::coordinate::Coordinate;
use crate::laws::{LawParameter, POSITIVE};

/// Exponents q that it may have.
pub const EXPONENTS_Q: (f64, f64) = (-0.9, 6.0);

/// N(x) = p/(q+1) x^(q+1) (eq. 3.2), and −N(−x) to the other side, where a bonded specimen can be moved.
pub(super) static LAW: ElasticLaw = ElasticLaw {
    name: "power",
    meaning: "a power of the compression",
    formula: "p/(q+1) x^(q+1)",
    acts: Acts::OnDisplacement(|q, x| elastic_response(1.0, q, x)),
    parameters: |least_q, stiffness| {
        let (p, unit) = ("stiffness of the elastic response", "N/mm^(q+1)");
        let q = "exponent by which the stiffness grows with compression";
        vec![
            LawParameter::new("p", unit, p, POSITIVE, stiffness).scaling(),
            LawParameter::new("q", "", q, (least_q, EXPONENTS_Q.1), Coordinate::Shape),
        ]
    },
    constants: |values| (values[0], values[1]),
    values: |p, shape| vec![p, shape],
    bounds: |reach| Some((reach.least_q, EXPONENTS_Q.1)),
    starts: |_| vec![0.0, 0.3, 0.6, 1.0, 1.5, 2.2, 3.0],
};

/// Elastic response N(x) = p/(q+1) x^(q+1), in N (eq. 3.2); −N(−x) for x < 0, to which only what is bonded is moved.
///
/// `displacement` in mm, `p` in N/mm^(q+1).
#[must_use]
pub fn elastic_response(p: f64, q: f64, displacement: f64) -> f64 {
    if displacement == 0.0 {
        return 0.0;
    }
    let exponent = q + 1.0;
    (p / exponent * displacement.abs().powf(exponent)).copysign(displacement)
}
