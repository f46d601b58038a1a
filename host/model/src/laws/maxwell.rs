//! `maxwell`: a spring and a damper in a row.

use super::declaration::{divisor, spring_and_damper};
use super::{Family, LawOption};
use crate::coordinate::Coordinate;
use crate::{Constants, Form};

/// F′/k + F/η = x′ (eq. 2.4).
pub static FAMILY: Family = Family {
    name: "maxwell",
    meaning: "a spring and a damper in a row",
    formula: "F′/k + F/η = x′",
    source: "eq. 2.4",
    drawing: "──/\\/\\/\\──[ ]──",
    form: Form::Force,
    retarded: false,
    linear_memory: true,
    takes: &[LawOption::Bonded],
    term: ["exponential", "exponentials"],
    least_q: 0.0,
    shape: 0.0,
    parameters: |_| spring_and_damper(Coordinate::Force(1), Coordinate::Rate(1)),
    constants: |_, values| Constants {
        shares: vec![1.0],
        rates: vec![values[0] / divisor(values[1])],
        ..Constants::new(values[0], 0.0)
    },
    values: |_, constants| vec![constants.p, constants.p / constants.rates[0]],
    // The spring of the equilibrium is not there: the branch carries all.
    starts: |_, beginning| {
        let alone = |found: &Constants| Constants { shares: vec![1.0], ..found.clone() };
        beginning.linear.iter().map(alone).collect()
    },
};
