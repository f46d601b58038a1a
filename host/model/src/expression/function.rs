//! The functions and constants of expressions.

use super::memory::MEMORIES;

/// A function of one number.
pub(super) type OfOne = fn(f64) -> f64;
/// A function of two numbers.
pub(super) type OfTwo = fn(f64, f64) -> f64;

/// Functions of one value.
pub(super) const ONE: [(&str, OfOne); 25] = [
    ("abs", f64::abs),
    ("sign", sign),
    ("signum", sign),
    ("sqrt", f64::sqrt),
    ("cbrt", f64::cbrt),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("log", f64::ln),
    ("log2", f64::log2),
    ("log10", f64::log10),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("asinh", f64::asinh),
    ("acosh", f64::acosh),
    ("atanh", f64::atanh),
    ("floor", f64::floor),
    ("ceil", f64::ceil),
    ("round", f64::round),
];

/// −1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Functions of two values.
pub(super) const TWO: [(&str, OfTwo); 3] =
    [("min", f64::min), ("max", f64::max), ("atan2", f64::atan2)];

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
