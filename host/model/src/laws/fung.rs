//! `fung`: an elastic response that relaxes, quasi-linear viscoelasticity.

use super::{Family, LawOption};
use crate::coordinate::Coordinate;
use crate::elastic::EXPONENTS_Q;
use crate::{Constants, Form};

/// F = ∫ g(t−s) dN(x(s)) (eqs 2.1, 3.2, 3.3).
pub static FAMILY: Family = Family {
    name: "fung",
    meaning: "an elastic response that stiffens, and relaxes as a sum of exponentials; a good first choice for soft materials",
    formula: "F = ∫ g(t − s) dN(x(s))",
    source: "eqs 2.1, 3.2, 3.3",
    drawing: "N(x) → ┬──/\\/\\/\\───────┬\n       ├──/\\/\\/\\──[ ]──┤\n       └──/\\/\\/\\──[ ]──┘",
    form: Form::Force,
    retarded: false,
    linear_memory: true,
    takes: &[LawOption::Terms, LawOption::Elastic, LawOption::Relaxation, LawOption::Bonded],
    term: ["exponential", "exponentials"],
    least_q: EXPONENTS_Q.0,
    shape: 0.0,
    parameters: |law| {
        let elastic = law.elastic.parameters(EXPONENTS_Q.0, Coordinate::Force(0));
        [elastic, (law.kernel.parameters)(law.terms)].concat()
    },
    constants: |law, values| {
        let (p, shape, own) = law.elastic.split(values);
        let constants = Constants::new(p, shape);
        (law.kernel.constants)(&own[..(law.kernel.parameters)(law.terms).len()], constants)
    },
    values: |law, constants| {
        let elastic = law.elastic.values(constants.p, constants.shape);
        [elastic, (law.kernel.values)(constants)].concat()
    },
    starts: |_, beginning| beginning.linear.clone(),
};
