//! Stability of a grasp with soft contacts (6.4.5): what a contact carries before it slips.
//!
//! - [`pressure`]: how the normal force spreads over the contact.
//! - [`contact`]: tangential force and moment of a contact that slips with a given motion.
//! - [`surface`]: all of them: the limit surface.
//! - [`mod@margin`]: how far a load is from it.

pub mod contact;
mod ellipse;
pub mod margin;
pub mod pressure;
mod quadrature;
mod rectangle;
pub mod surface;

pub use contact::{Contact, Load, Motion, Shape, SizeError};
pub use margin::{Margin, margin};
pub use pressure::{ExponentError, PressureLaw};
pub use surface::{SurfacePoint, limit_curve, limit_surface};
