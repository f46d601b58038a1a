//! `latency`: the strain at the contact lags behind and settles at one rate.

use super::declaration::POSITIVE;
use super::{Family, LawOption, LawParameter};
use crate::coordinate::Coordinate;
use crate::{BaseLaw, Constants, Form};

/// A share c0 of zero would take an infinite latent strain; far below any that data determine.
const SMALLEST_SHARE: f64 = 1e-9;

/// The strain at the contact goes back to its equilibrium at a rate proportional to the distance,
/// ε′ = −v1 (ε − εe) (eqs 4.1–4.11).
pub static FAMILY: Family = Family {
    name: "latency",
    meaning: "the strain at the contact lags behind and settles at one rate",
    formula: "F = N(x) ε/x, ε′ = x′ − v1 (ε − c0 x)",
    source: "eqs 4.1–4.11",
    drawing: "x → ε ⇢ c0 x, F = N(x) ε/x",
    form: Form::Strain,
    retarded: false,
    linear_memory: true,
    takes: &[LawOption::Elastic, LawOption::Segments, LawOption::Bonded],
    term: ["exponential", "exponentials"],
    least_q: 0.0,
    shape: 0.0,
    parameters: |law| {
        let meaning = "rate at which the latent strain relaxes";
        let rate = LawParameter::new("v1", "1/s", meaning, POSITIVE, Coordinate::Rate(1));
        [before_the_rate(law), vec![rate]].concat()
    },
    constants: |law, values| {
        let (constants, own) = with_equilibrium(law, values);
        Constants { rates: vec![own[0]], ..constants }
    },
    values: |law, constants| {
        [values_before_the_rate(law, constants), vec![constants.rates[0]]].concat()
    },
    starts: |_, beginning| beginning.linear.clone(),
};

/// The elastic parameters, and c0 where no number of segments gives it.
pub(super) fn before_the_rate(law: &BaseLaw) -> Vec<LawParameter> {
    if law.segments.is_some() {
        return law.elastic.parameters(0.0, Coordinate::Total);
    }
    let mut parameters = law.elastic.parameters(0.0, Coordinate::Force(1));
    let meaning = "share of the elastic response that never relaxes";
    parameters.push(LawParameter::new("c0", "", meaning, (0.0, 1.0), Coordinate::Force(0)));
    parameters
}

/// The constants without a rate, and the values that are left.
pub(super) fn with_equilibrium<'a>(law: &BaseLaw, values: &'a [f64]) -> (Constants, &'a [f64]) {
    let (p, shape, rest) = law.elastic.split(values);
    let (equilibrium, rest) = match law.segments {
        Some(segments) => (1.0 / f64::from(segments), rest),
        None => (rest[0].max(SMALLEST_SHARE), &rest[1..]),
    };
    (Constants { shares: vec![1.0 - equilibrium], ..Constants::new(p, shape) }, rest)
}

/// The values of [`before_the_rate`].
pub(super) fn values_before_the_rate(law: &BaseLaw, constants: &Constants) -> Vec<f64> {
    let mut values = law.elastic.values(constants.p, constants.shape);
    if law.segments.is_none() {
        values.push(constants.equilibrium().max(SMALLEST_SHARE));
    }
    values
}

/// The branch carries y; the latent compression is y times this.
pub(super) fn latent(constants: &Constants) -> f64 {
    let equilibrium = constants.equilibrium().max(SMALLEST_SHARE);
    (1.0 - equilibrium) / equilibrium
}
