//! `latency-power`: the strain at the contact lags behind and settles by a power law.

use super::declaration::POSITIVE;
use super::latency::{before_the_rate, latent, values_before_the_rate, with_equilibrium};
use super::{Beginning, Family, LawOption, LawParameter};
use crate::coordinate::Coordinate;
use crate::{BaseLaw, Constants, Form};

/// The exponents n that it may have.
pub const EXPONENTS_N: (f64, f64) = (1.0, 9.0);
/// Latent compression, mm, at which the rate ν is stated.
const UNIT_LATENT: f64 = 1.0;
/// Powers n that a search starts from.
const POWERS: [f64; 4] = [1.2, 2.0, 3.0, 5.0];
/// Latent compressions, as parts of the largest compression, at which its rate may be that of the linear
/// model.
const LATENT: [f64; 2] = [0.5, 0.15];

/// ε′ = −ν sgn(ε − εe) |ε − εe|^n (eqs 7.2, 7.3, 7.11).
pub static FAMILY: Family = Family {
    name: "latency-power",
    meaning: "the strain at the contact lags behind and settles by a power law",
    formula: "F = N(x) ε/x, ε′ = x′ − ν sgn(y) |y|^n, y = ε − c0 x",
    source: "eqs 7.2, 7.3, 7.11",
    drawing: "x → ε ⇢ c0 x by |y|^n, F = N(x) ε/x",
    form: Form::Strain,
    retarded: false,
    linear_memory: false,
    takes: &[LawOption::Elastic, LawOption::Segments, LawOption::Exponent, LawOption::Bonded],
    term: ["exponential", "exponentials"],
    least_q: 0.0,
    shape: 0.0,
    parameters: |law| {
        let meaning = "rate, 1/s, at which a latent compression of 1 mm relaxes";
        let unit = "1/(s·mm^(n−1))";
        let mut parameters = before_the_rate(law);
        parameters.push(LawParameter::new("nu", unit, meaning, POSITIVE, Coordinate::Rate(1)));
        if law.exponent.is_none() {
            let meaning = "power of the latent strain that its rate follows";
            parameters.push(LawParameter::new("n", "", meaning, EXPONENTS_N, Coordinate::Power));
        }
        parameters
    },
    constants: |law, values| {
        let (constants, own) = with_equilibrium(law, values);
        let exponent = law.exponent.unwrap_or_else(|| own[1]);
        let rate = own[0] * (latent(&constants) / UNIT_LATENT).powf(exponent - 1.0);
        Constants { rates: vec![rate], exponent, ..constants }
    },
    values: |law, constants| {
        let exponent = constants.exponent;
        let mut values = values_before_the_rate(law, constants);
        values.push(constants.rates[0] / (latent(constants) / UNIT_LATENT).powf(exponent - 1.0));
        if law.exponent.is_none() {
            values.push(exponent);
        }
        values
    },
    starts,
};

/// Every power, with the rate of the linear law at several latent compressions, of the best two linear laws.
fn starts(law: &BaseLaw, beginning: &Beginning) -> Vec<Constants> {
    let powers = law.exponent.map_or(POWERS.to_vec(), |power| vec![power]);
    let bent = |found: &Constants, power: f64, latent: f64| {
        let mut constants = Constants { exponent: power, ..found.clone() };
        constants.rates[0] /= (latent * beginning.reference).powf(power - 1.0);
        constants
    };
    let each = beginning.linear.iter().take(2).flat_map(|found| {
        powers.iter().flat_map(move |&power| LATENT.map(|latent| bent(found, power, latent)))
    });
    each.collect()
}
