//! The base laws: one declaration a file, and one line in [`FAMILIES`].
//!
//! All of them are an elastic response N(x) ([`Elastic`](crate::Elastic)) and a memory of exponential branches or of another
//! [`Kernel`](crate::Kernel); they differ in what the memory acts on ([`Form`](crate::Form)), in what is held fixed, and in the
//! names and units by which people know their parameters.

mod creep;
mod declaration;
mod fung;
mod generalized_maxwell;
mod kelvin_voigt;
mod latency;
mod latency_power;
mod library;
mod maxwell;

pub(crate) use declaration::divisor;
pub use declaration::{Beginning, Family, LawOption, LawParameter, POSITIVE};
pub use latency_power::EXPONENTS_N;
pub use library::{FAMILIES, Laws};
