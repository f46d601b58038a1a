//! `mooney-rivlin`: two constants.

use super::{Acts, ElasticLaw, Shear, gaussian};
use crate::coordinate::Coordinate;
use crate::laws::{LawParameter, POSITIVE};

/// In tension F = 2 (C1A + C2A/λ)(λ − λ⁻²); the shape is the share of C2.
pub(super) static LAW: ElasticLaw = ElasticLaw {
    name: "mooney-rivlin",
    meaning: "a rubber with two constants, softer in tension than Gaussian chains",
    formula: "2 (C1A + C2A/λ)(λ − λ⁻²)",
    acts: Acts::OnStretch {
        pulled: |shape, stretch| gaussian(stretch) * (1.0 - shape + shape / stretch),
        // The two constants are one in shear.
        sheared: Shear::As(ElasticLaw::NEO_HOOKE),
    },
    parameters: |_, stiffness| {
        let (first, second) =
            ("first constant times cross-section", "second constant times cross-section");
        vec![
            LawParameter::new("C1A", "N", first, POSITIVE, stiffness).scaling(),
            LawParameter::new("C2A", "N", second, POSITIVE, Coordinate::Shape),
        ]
    },
    constants: |values| {
        let sum = values[0] + values[1];
        (2.0 * sum, if sum > 0.0 { values[1] / sum } else { 0.0 })
    },
    values: |p, shape| vec![0.5 * p * (1.0 - shape), 0.5 * p * shape],
    bounds: |_| Some((0.0, 1.0)),
    starts: |_| vec![0.0, 0.5, 1.0],
};
