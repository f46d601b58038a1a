//! `exponentials`: a Prony series.

use super::{Kernel, MemoryOf};
use crate::coordinate::Coordinate;
use crate::laws::{LawParameter, POSITIVE};
use crate::{Constants, MAX_TERMS};

/// Names of the shares.
pub(crate) const SHARES: [&str; MAX_TERMS] = ["c1", "c2", "c3", "c4"];
/// Names of the rates.
pub(crate) const RATES: [&str; MAX_TERMS] = ["v1", "v2", "v3", "v4"];

/// g = c0 + Σ ci e^(−vi t) (eq. 3.3).
pub(super) static KERNEL: Kernel = Kernel {
    name: "exponentials",
    meaning: "a sum of exponentials (Prony series)",
    formula: "g = c0 + Σ ci e^(−vi t)",
    memory: MemoryOf::Exponentials,
    parameters: |terms| {
        let shares = LawParameter::each(&SHARES, terms, |name, branch| {
            let meaning = "share of the elastic response that relaxes at this rate";
            LawParameter::new(name, "", meaning, (0.0, 1.0), Coordinate::Force(branch))
        });
        let rates = LawParameter::each(&RATES, terms, |name, branch| {
            let meaning = "rate of relaxation";
            LawParameter::new(name, "1/s", meaning, POSITIVE, Coordinate::Rate(branch))
        });
        [shares, rates].concat()
    },
    constants: |values, elastic| {
        let (shares, rates) = values.split_at(values.len() / 2);
        Constants { shares: shares.to_vec(), rates: rates.to_vec(), ..elastic }
    },
    values: |constants| [&constants.shares[..], &constants.rates].concat(),
};
