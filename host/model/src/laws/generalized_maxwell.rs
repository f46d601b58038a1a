//! `generalized-maxwell`: a spring beside springs with dampers.

use super::declaration::{POSITIVE, divisor};
use super::{Family, LawOption, LawParameter};
use crate::coordinate::Coordinate;
use crate::{Constants, Form, MAX_TERMS};

const STIFFNESSES: [&str; MAX_TERMS] = ["k1", "k2", "k3", "k4"];
const DAMPINGS: [&str; MAX_TERMS] = ["eta1", "eta2", "eta3", "eta4"];

/// F = k0 x + Σ ki ∫ e^(−(ki/ηi)(t−s)) dx (eq. 2.2).
pub static FAMILY: Family = Family {
    name: "generalized-maxwell",
    meaning: "a spring beside springs with dampers",
    formula: "F = k0 x + Σ ki ∫ e^(−(ki/ηi)(t − s)) dx(s)",
    source: "eq. 2.2",
    drawing: "┬──/\\/\\/\\───────┬\n├──/\\/\\/\\──[ ]──┤\n└──/\\/\\/\\──[ ]──┘",
    form: Form::Force,
    retarded: false,
    linear_memory: true,
    takes: &[LawOption::Terms, LawOption::Bonded],
    term: ["branch", "branches"],
    least_q: 0.0,
    shape: 0.0,
    parameters: |law| {
        let alone = "stiffness of the spring that stands alone";
        let spring = LawParameter::new("k0", "N/mm", alone, POSITIVE, Coordinate::Force(0));
        let springs = LawParameter::each(&STIFFNESSES, law.terms, |name, branch| {
            let meaning = "stiffness of a branch's spring";
            LawParameter::new(name, "N/mm", meaning, POSITIVE, Coordinate::Force(branch))
        });
        let dampers = LawParameter::each(&DAMPINGS, law.terms, |name, branch| {
            let meaning = "damping of a branch's damper";
            LawParameter::new(name, "N·s/mm", meaning, POSITIVE, Coordinate::Rate(branch))
        });
        [vec![spring], springs, dampers].concat()
    },
    constants: |law, values| {
        let (springs, dampers) = values[..2 * law.terms + 1].split_at(law.terms + 1);
        let total: f64 = springs.iter().sum();
        let rate = |(k, eta): (&f64, &f64)| k / divisor(*eta);
        Constants {
            shares: springs[1..].iter().map(|k| k / divisor(total)).collect(),
            rates: springs[1..].iter().zip(dampers).map(rate).collect(),
            ..Constants::new(total, 0.0)
        }
    },
    values: |_, constants| {
        let Constants { p, shares, rates, .. } = constants;
        let springs = shares.iter().map(|share| share * p);
        let dampers = shares.iter().zip(rates).map(|(share, rate)| share * p / rate);
        std::iter::once(constants.equilibrium() * p).chain(springs).chain(dampers).collect()
    },
    starts: |_, beginning| beginning.linear.clone(),
};
