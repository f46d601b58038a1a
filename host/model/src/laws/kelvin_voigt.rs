//! `kelvin-voigt`: a spring and a damper side by side.

use super::declaration::{divisor, spring_and_damper};
use super::{Family, LawOption};
use crate::coordinate::Coordinate;
use crate::{Constants, Form};

/// F = k x + η x′ (eq. 2.3).
pub static FAMILY: Family = Family {
    name: "kelvin-voigt",
    meaning: "a spring and a damper side by side",
    formula: "F = k x + η x′",
    source: "eq. 2.3",
    drawing: "┬─/\\/\\/\\─┬\n└──[ ]───┘",
    form: Form::Force,
    retarded: false,
    linear_memory: true,
    takes: &[LawOption::Bonded],
    term: ["exponential", "exponentials"],
    least_q: 0.0,
    shape: 0.0,
    parameters: |_| spring_and_damper(Coordinate::Force(0), Coordinate::Damping),
    constants: |_, values| Constants {
        viscosity: values[1] / divisor(values[0]),
        ..Constants::new(values[0], 0.0)
    },
    values: |_, constants| vec![constants.p, constants.viscosity * constants.p],
    // As large as the forces.
    starts: |_, beginning| {
        let p = beginning.force / beginning.reference;
        let damping = 0.1 * beginning.force / beginning.speed.max(f64::MIN_POSITIVE);
        vec![Constants { viscosity: damping / p, ..Constants::new(p, 0.0) }]
    },
};
