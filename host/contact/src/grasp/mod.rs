//! Stability of a grasp with soft contacts (6.4.5): what a contact carries before it slips.
//!
//! - [`pressure`]: how the normal force spreads over the contact.
//! - [`contact`]: tangential force and moment of a contact that slips with a given motion.
//! - [`surface`]: all of them: the limit surface.
//! - [`mod@margin`]: how far a load is from it.
//! - [`body`]: what is pressed, and how its contact grows with the compression.
//! - [`balance`]: several contacts on one object: the forces that hold a load.
//! - [`hand`]: fingers as a file describes them, and how their grip changes while they hold.
//! - [`mod@friction`]: μ and k from a recorded slide.
//! - [`mod@growth`]: the limit surface of a grasp that creeps or relaxes.
//! - [`mod@history`]: the margin over a recording.
//! - [`live`]: the margin as a fingertip feels it.

pub mod balance;
pub mod body;
pub mod contact;
mod ellipse;
pub mod friction;
pub mod growth;
pub mod hand;
pub mod history;
pub mod live;
pub mod margin;
pub mod pressure;
pub(crate) mod quadrature;
mod rectangle;
pub mod surface;

pub use balance::{Balance, BalanceError, Closure, Least, Pose, Touch, Wrench};
pub use body::{Body, BodyError};
pub use contact::{Contact, Load, Motion, Shape, SizeError};
pub use growth::{Grown, Held, Material, growth};
pub use hand::{Finger, Hand, HandError, Instant};
pub use history::{Grip, History, HistoryError, Slip, Source, Sources, history};
pub use margin::{Margin, margin};
pub use pressure::{ExponentError, PressureLaw};
pub use surface::{SurfacePoint, limit_curve, limit_surface};
