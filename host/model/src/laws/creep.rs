//! `creep`: the compression settles late under a given force.

use super::declaration::POSITIVE;
use super::{Family, LawOption, LawParameter};
use crate::coordinate::Coordinate;
use crate::elastic::EXPONENTS_Q;
use crate::kernel::{RATES, SHARES};
use crate::{Constants, Form};

/// δ = ∫ h(t−s) dD(F(s)), h = 1 + Σ ci e^(−vi t) (eqs 6.1, 6.2), solved for the force.
pub static FAMILY: Family = Family {
    name: "creep",
    meaning: "the compression settles late under a given force, solved for the force",
    formula: "F = N(D), x = ∫ h(t − s) dD(s), h(t) = 1 + Σ ci e^(−vi t)",
    source: "eqs 6.1, 6.2",
    drawing: "──N──┬──[ ]───┬──┬──[ ]───┬──\n     └─/\\/\\/\\─┘  └─/\\/\\/\\─┘",
    form: Form::Compression,
    retarded: true,
    linear_memory: true,
    takes: &[LawOption::Terms, LawOption::Elastic],
    term: ["exponential", "exponentials"],
    least_q: EXPONENTS_Q.0,
    shape: 0.0,
    parameters: |law| {
        let shares = LawParameter::each(&SHARES, law.terms, |name, branch| {
            let meaning = "part of the settled compression that comes late, at this rate";
            LawParameter::new(name, "", meaning, (-1.0, 0.0), Coordinate::Force(branch))
        });
        let rates = LawParameter::each(&RATES, law.terms, |name, branch| {
            LawParameter::new(name, "1/s", "rate of creep", POSITIVE, Coordinate::Rate(branch))
        });
        [law.elastic.parameters(EXPONENTS_Q.0, Coordinate::Force(0)), shares, rates].concat()
    },
    constants: |law, values| {
        let (p, shape, own) = law.elastic.split(values);
        let (shares, rates) = own[..2 * law.terms].split_at(law.terms);
        let shares = shares.iter().map(|share| -share).collect();
        Constants { shares, rates: rates.to_vec(), ..Constants::new(p, shape) }
    },
    values: |law, constants| {
        let shares: Vec<f64> = constants.shares.iter().map(|share| -share).collect();
        let elastic = law.elastic.values(constants.p, constants.shape);
        [&elastic[..], &shares, &constants.rates].concat()
    },
    // What relaxes by the share c creeps by it too, slower by the share that is left.
    starts: |_, beginning| {
        let late = |found: &Constants| {
            let left = found.equilibrium();
            let rates = found.rates.iter().map(|rate| rate * left.max(0.1)).collect();
            Constants { p: found.p * left, rates, ..found.clone() }
        };
        beginning.linear.iter().map(late).collect()
    },
};
