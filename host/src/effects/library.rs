//! The registry of effects, in the order of the chain.

use super::Effect;

/// Every effect of the library.
pub const LIBRARY: [&Effect; 4] = [
    &super::contact_offset::EFFECT,
    &super::mullins::EFFECT,
    &super::fast_mode::EFFECT,
    &super::zero_shift::EFFECT,
];

/// The effect of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Effect> {
    LIBRARY.into_iter().find(|effect| effect.name == name)
}
