//! The functions and constants of expressions.

use super::memory::MEMORIES;

/// A function of one number, applied to every value of a column.
pub(super) type OfOne = fn(&mut [f64]);
/// A function of two numbers, applied to every pair of two columns.
pub(super) type OfTwo = fn(Pairs);

/// Two columns, or a column and a number that stands for one; the results go where the mutable column is.
pub(super) enum Pairs<'a> {
    /// Two columns.
    Columns(&'a mut [f64], &'a [f64]),
    /// The second is the same at all samples.
    SecondSame(&'a mut [f64], f64),
    /// The first is.
    FirstSame(f64, &'a mut [f64]),
}

/// Applies a function to every value: a loop of its own for each function, which the compiler can make wide.
fn each(values: &mut [f64], apply: impl Fn(f64) -> f64) {
    values.iter_mut().for_each(|value| *value = apply(*value));
}

/// Applies a function to every pair.
pub(super) fn every(pairs: Pairs, apply: impl Fn(f64, f64) -> f64) {
    match pairs {
        Pairs::Columns(first, second) => {
            first.iter_mut().zip(second).for_each(|(a, b)| *a = apply(*a, *b));
        }
        Pairs::SecondSame(first, b) => first.iter_mut().for_each(|a| *a = apply(*a, b)),
        Pairs::FirstSame(a, second) => second.iter_mut().for_each(|b| *b = apply(a, *b)),
    }
}

/// Functions of one value.
pub(super) const ONE: [(&str, OfOne); 25] = [
    ("abs", |values| each(values, f64::abs)),
    ("sign", |values| each(values, sign)),
    ("signum", |values| each(values, sign)),
    ("sqrt", |values| each(values, f64::sqrt)),
    ("cbrt", |values| each(values, f64::cbrt)),
    ("exp", |values| each(values, f64::exp)),
    ("ln", |values| each(values, f64::ln)),
    ("log", |values| each(values, f64::ln)),
    ("log2", |values| each(values, f64::log2)),
    ("log10", |values| each(values, f64::log10)),
    ("sin", |values| each(values, f64::sin)),
    ("cos", |values| each(values, f64::cos)),
    ("tan", |values| each(values, f64::tan)),
    ("asin", |values| each(values, f64::asin)),
    ("acos", |values| each(values, f64::acos)),
    ("atan", |values| each(values, f64::atan)),
    ("sinh", |values| each(values, f64::sinh)),
    ("cosh", |values| each(values, f64::cosh)),
    ("tanh", |values| each(values, f64::tanh)),
    ("asinh", |values| each(values, f64::asinh)),
    ("acosh", |values| each(values, f64::acosh)),
    ("atanh", |values| each(values, f64::atanh)),
    ("floor", |values| each(values, f64::floor)),
    ("ceil", |values| each(values, f64::ceil)),
    ("round", |values| each(values, f64::round)),
];

/// The other sign.
pub(super) fn negate(values: &mut [f64]) {
    each(values, |x| -x);
}

/// −1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Functions of two values.
pub(super) const TWO: [(&str, OfTwo); 3] = [
    ("min", |pairs| every(pairs, f64::min)),
    ("max", |pairs| every(pairs, f64::max)),
    ("atan2", |pairs| every(pairs, f64::atan2)),
];

/// A power; a square is a product, which is what a power is rounded to, and quicker.
pub(super) fn power(pairs: Pairs) {
    match pairs {
        Pairs::SecondSame(first, 2.0) => each(first, |a| a * a),
        pairs => every(pairs, f64::powf),
    }
}

/// Constants.
pub(super) const CONSTANTS: [(&str, f64); 5] = [
    ("PI", std::f64::consts::PI),
    ("π", std::f64::consts::PI),
    ("TAU", std::f64::consts::TAU),
    ("τ", std::f64::consts::TAU),
    ("E", std::f64::consts::E),
];

/// What stands under a name in a table.
pub(super) fn of<T: Copy>(table: &[(&str, T)], name: &str) -> Option<T> {
    table.iter().find(|(known, _)| *known == name).map(|(_, found)| *found)
}

/// Names of all functions.
pub(super) fn names() -> Vec<&'static str> {
    let plain = ONE.iter().map(|(name, _)| *name).chain(TWO.iter().map(|(name, _)| *name));
    plain.chain(MEMORIES.iter().map(|(name, _)| *name)).collect()
}
