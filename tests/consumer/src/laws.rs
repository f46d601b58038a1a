//! Laws of this program's own.

use palpate::Laws;
use palpate::model::laws::{Family, LawOption, LawParameter, POSITIVE};
use palpate::model::{Constants, Coordinate, Form};

pub use crate::declared::EXPONENTIAL;

/// A ball on a half-space (Hertz) that relaxes at one rate.
pub static BALL: Family = Family {
    name: "ball",
    meaning: "a ball on a flat body that relaxes at one rate",
    formula: "F = ∫ g(t − s) d(K x^1.5), g = 1 − c1 + c1 e^(−v1 t)",
    source: "Hertz (1882), with eq. 3.3",
    drawing: "(  )\n────",
    form: Form::Force,
    retarded: false,
    linear_memory: true,
    takes: &[LawOption::Bonded],
    term: ["exponential", "exponentials"],
    least_q: 0.5,
    shape: 0.5,
    parameters: |_| {
        let (k, share) = ("stiffness", "share that relaxes");
        vec![
            LawParameter::new("K", "N/mm^1.5", k, POSITIVE, Coordinate::Force(0)).scaling(),
            LawParameter::new("c1", "", share, (0.0, 1.0), Coordinate::Force(1)),
            LawParameter::new("v1", "1/s", "its rate", POSITIVE, Coordinate::Rate(1)),
        ]
    },
    // The elastic response is p/(q+1) x^(q+1), q = 0.5.
    constants: |_, values| Constants {
        shares: vec![values[1]],
        rates: vec![values[2]],
        ..Constants::new(1.5 * values[0], 0.5)
    },
    values: |_, constants| vec![constants.p / 1.5, constants.shares[0], constants.rates[0]],
    starts: |_, beginning| beginning.linear.clone(),
};

/// The laws that this program knows.
#[must_use]
pub fn laws() -> Laws {
    Laws::library().with(&BALL).with_elastic(&EXPONENTIAL)
}
