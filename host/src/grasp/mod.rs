//! Stability of a grasp with soft contacts (6.4.5): how a contact presses and what it can hold.
//!
//! - [`pressure`]: how the normal force spreads over the contact.

pub mod pressure;
