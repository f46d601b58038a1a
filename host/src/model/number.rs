//! The numbers a law is written over: `f64`, or a value with its derivatives.

use num_dual::{DualNum, DualSVec64};

/// A real number or a dual number; laws are generic over it.
pub trait Number: DualNum<Primitive = f64> + Copy {}

impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

/// How many derivatives one pass carries; more parameters take more passes.
pub const CHUNK: usize = 8;

/// A value with its derivatives to up to [`CHUNK`] parameters.
pub type Dual = DualSVec64<CHUNK>;

/// `values` as dual numbers whose derivatives count from parameter `first`: the value with index
/// `first + k` carries a one in place `k`.
#[must_use]
pub fn seeded(values: &[f64], first: usize) -> Vec<Dual> {
    let seed = |(index, &value): (usize, &f64)| {
        let dual = Dual::from_re(value);
        match index.checked_sub(first) {
            Some(place) if place < CHUNK => dual.derivative(place),
            _ => dual,
        }
    };
    values.iter().enumerate().map(seed).collect()
}

/// `values` as numbers without a derivative.
#[must_use]
pub fn constants<T: Number>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&value| T::from(value)).collect()
}
