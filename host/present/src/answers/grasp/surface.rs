//! `palpate grasp surface`: a limit surface.

use palpate_contact::grasp::{Contact, Load, Margin, Shape, SurfacePoint};
use serde::Serialize;

use crate::answers::finite;
use crate::summary::SurfaceSummary;

/// The limit surface of a contact and, where a load is given, its margin.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspSurfaceAnswer {
    /// Version of this answer.
    pub palpate_grasp_surface: u32,
    /// The contact.
    pub contact: ContactAnswer,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Normal force, N.
    #[serde(rename = "normal_N")]
    pub normal_n: f64,
    /// Largest tangential force, in every direction, N.
    #[serde(rename = "largest_force_N")]
    pub largest_force_n: f64,
    /// Largest moment about the normal, N mm.
    #[serde(rename = "largest_moment_Nmm")]
    pub largest_moment_nmm: f64,
    /// The load and its margin; null where no load was given.
    pub load: Option<GraspLoadAnswer>,
    /// Half of the surface, for turns from x to y; the other half is its mirror image through the origin.
    pub points: Vec<SurfacePointAnswer>,
}

/// How a contact lies and presses.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ContactAnswer {
    /// Shape and sizes.
    pub contact: ContactShapeAnswer,
    /// Exponent k of the pressure; null where it is infinite: a uniform pressure.
    pub exponent: Option<f64>,
    /// Pressure in the middle over mean pressure, Ck.
    pub middle_over_mean_pressure: f64,
    /// Mean distance of the pressure from the middle, mm: the largest moment over the largest force.
    pub arm_mm: f64,
}

/// Shape of a contact, centred in the middle, its axes along x and y.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
#[serde(tag = "shape", rename_all = "lowercase")]
pub enum ContactShapeAnswer {
    /// A rectangle whose pressure varies along x (eq. 6.10).
    Rectangle {
        /// Length along x, mm.
        length_mm: f64,
        /// Width along y, mm.
        width_mm: f64,
    },
    /// A circle whose pressure varies with the distance from the middle (eq. 8.1).
    Circle {
        /// Radius, mm.
        radius_mm: f64,
    },
    /// An ellipse whose pressure is the same along similar ellipses.
    Ellipse {
        /// Semi-axis along x, mm.
        x_mm: f64,
        /// Semi-axis along y, mm.
        y_mm: f64,
    },
}

/// A load on a contact and how far it is from slip.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspLoadAnswer {
    /// Tangential force along x and y, N.
    #[serde(rename = "force_N")]
    pub force_n: [f64; 2],
    /// Moment about the normal, N mm.
    #[serde(rename = "moment_Nmm")]
    pub moment_nmm: f64,
    /// The load could be so many times as large; null where it is infinite, without a load.
    pub margin: Option<f64>,
    /// Whether the contact slips under it.
    pub slips: bool,
    /// Centre of rotation of the slip, x and y, mm; null for a slip without a turn and without a load.
    pub slip_centre_mm: Option<[f64; 2]>,
}

/// One point of a limit surface.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SurfacePointAnswer {
    /// Velocity of the middle of the contact along x and y, mm/s.
    pub velocity: [f64; 2],
    /// Turn about the normal from x to y, rad/s.
    pub turn: f64,
    /// Centre of rotation, x and y, mm; null for a pure translation.
    pub centre_mm: Option<[f64; 2]>,
    /// Tangential force along x and y at which the contact slips with this motion, N.
    #[serde(rename = "force_N")]
    pub force_n: [f64; 2],
    /// Moment about the normal at which it does, N mm.
    #[serde(rename = "moment_Nmm")]
    pub moment_nmm: f64,
}

impl From<&SurfaceSummary<'_>> for GraspSurfaceAnswer {
    fn from(found: &SurfaceSummary<'_>) -> Self {
        Self {
            palpate_grasp_surface: 1,
            contact: found.contact.into(),
            friction: found.friction,
            normal_n: found.normal,
            largest_force_n: found.largest_force(),
            largest_moment_nmm: found.largest_moment(),
            load: found.load.map(|(load, margin)| GraspLoadAnswer::of(load, margin)),
            points: found.surface.iter().map(SurfacePointAnswer::from).collect(),
        }
    }
}

impl From<&Contact> for ContactAnswer {
    fn from(contact: &Contact) -> Self {
        Self {
            contact: contact.shape().into(),
            exponent: finite(contact.law().exponent()),
            middle_over_mean_pressure: contact.middle_over_mean_pressure(),
            arm_mm: contact.arm(),
        }
    }
}

impl From<Shape> for ContactShapeAnswer {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Rectangle { length, width } => {
                Self::Rectangle { length_mm: length, width_mm: width }
            }
            Shape::Circle { radius } => Self::Circle { radius_mm: radius },
            Shape::Ellipse { x, y } => Self::Ellipse { x_mm: x, y_mm: y },
        }
    }
}

impl GraspLoadAnswer {
    fn of(load: Load, margin: Margin) -> Self {
        Self {
            force_n: load.force,
            moment_nmm: load.moment,
            margin: finite(margin.factor),
            slips: margin.slips(),
            slip_centre_mm: margin.motion.and_then(|motion| motion.centre()),
        }
    }
}

impl From<&SurfacePoint> for SurfacePointAnswer {
    fn from(point: &SurfacePoint) -> Self {
        Self {
            velocity: point.motion.velocity,
            turn: point.motion.turn,
            centre_mm: point.motion.centre(),
            force_n: point.load.force,
            moment_nmm: point.load.moment,
        }
    }
}
