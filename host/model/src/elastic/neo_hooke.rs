//! `neo-hooke`: Gaussian chains.

use super::{Acts, ElasticLaw, Shear, gaussian};
use crate::coordinate::Coordinate;
use crate::laws::{LawParameter, POSITIVE};

/// In tension F = GA (λ − λ⁻²); A is the cross-section before the deformation, G the shear modulus at small strain.
pub(super) static LAW: ElasticLaw = ElasticLaw {
    name: "neo-hooke",
    meaning: "a rubber of Gaussian chains",
    formula: "GA (λ − λ⁻²)",
    acts: Acts::OnStretch {
        pulled: |_, stretch| gaussian(stretch),
        sheared: Shear::Own(|_, strain| strain),
    },
    parameters: |_, stiffness| vec![modulus(stiffness)],
    constants: |values| (values[0], 0.0),
    values: |p, _| vec![p],
    bounds: |_| None,
    starts: |_| vec![0.0],
};

/// The parameter that three of the laws have.
pub(super) const fn modulus(stiffness: Coordinate) -> LawParameter {
    let meaning = "shear modulus at small strain times cross-section";
    LawParameter::new("GA", "N", meaning, POSITIVE, stiffness).scaling()
}
