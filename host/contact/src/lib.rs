//! Contact of a smooth round tip with an elastic body: force and contact radius, a thin layer, the stress below.
//!
//! Everything here is linear elasticity of small strains without friction, in SI units, compression positive in force and
//! depth. [`sensor`] presses silicone with it, [`afm`] a cell or a gel.
//!
//! ```
//! use palpate_contact::{Elastic, Tip};
//!
//! // A ball of 5 mm on silicone of 100 kPa, 1 mm deep.
//! let silicone = Elastic { modulus_pa: 1e5, poisson_ratio: 0.48 };
//! let force = Tip::Paraboloid { radius_m: 5e-3 }.force(silicone.reduced_modulus(), 1e-3);
//! assert!((force - 0.39).abs() < 0.01);
//! ```
#![forbid(unsafe_code)]

pub mod afm;
mod field;
pub mod grasp;
mod layer;
pub mod sensor;
mod tip;

pub use field::{HertzField, Stress};
pub use layer::bonded_layer_factor;
pub use tip::Tip;

/// An isotropic elastic body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Young's modulus, Pa.
    pub modulus_pa: f64,
    /// Poisson's ratio, −1 to 0.5.
    pub poisson_ratio: f64,
}

impl Elastic {
    /// Reduced modulus E/(1 − ν²) of the body under a rigid tip, Pa.
    #[must_use]
    pub fn reduced_modulus(&self) -> f64 {
        self.modulus_pa / (1.0 - self.poisson_ratio * self.poisson_ratio)
    }
}
