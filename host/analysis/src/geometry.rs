//! Area of contact and height of a specimen: (5.5) with the Poisson effect, (7.7) for a ball.

use std::f64::consts::PI;

use palpate_model::widened;
use palpate_trace::{Shape, Specimen};

/// What a ball's depression d in (7.7) means for a displacement of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Faces {
    /// d is the whole displacement, as (7.7) and (7.8) are printed: one face is pressed in.
    #[default]
    One,
    /// Each of two faces is pressed in by half of it, as in the simulation of 7.4.
    Each,
}

/// A specimen between flat faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Geometry {
    /// A cylinder pressed along its axis.
    Cylinder {
        /// Radius without load, mm.
        radius_mm: f64,
        /// Height without load, mm.
        height_mm: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
    /// A block.
    Block {
        /// Length without load, mm.
        length_mm: f64,
        /// Width without load, mm.
        width_mm: f64,
        /// Height without load, mm.
        height_mm: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
    /// A ball.
    Ball {
        /// Radius, mm.
        radius_mm: f64,
        /// What d means.
        faces: Faces,
    },
}

/// What of a specimen's geometry is missing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{trace}: the specimen's {} not known, and the area of contact needs it. Write it under [specimen] in the head, or give {}.", missing.words(), missing.option())]
pub struct GeometryError {
    /// Name of the trace.
    pub trace: String,
    /// What is missing.
    pub missing: Missing,
}

/// One property of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Missing {
    Shape,
    Radius,
    Height,
    Length,
    Width,
    Poisson,
}

impl Missing {
    fn words(self) -> &'static str {
        match self {
            Self::Shape => "shape (cylinder, block or sphere) is",
            Self::Radius => "radius_mm is",
            Self::Height => "height_mm is",
            Self::Length => "length_mm is",
            Self::Width => "width_mm is",
            Self::Poisson => "poisson_ratio (0.5 for rubber, 0 for an area that stays) is",
        }
    }

    fn option(self) -> &'static str {
        match self {
            Self::Shape => "--shape",
            Self::Radius => "--radius",
            Self::Height => "--height",
            Self::Length => "--length",
            Self::Width => "--width",
            Self::Poisson => "--poisson",
        }
    }
}

impl Geometry {
    /// The geometry of a specimen as a head or options give it; `trace` is for the error.
    ///
    /// # Errors
    /// Names the first property that is missing.
    pub fn of(specimen: &Specimen, faces: Faces, trace: &str) -> Result<Self, GeometryError> {
        let need = |value: Option<f64>, missing| {
            value.ok_or_else(|| GeometryError { trace: trace.to_owned(), missing })
        };
        let shape = specimen
            .shape
            .ok_or_else(|| GeometryError { trace: trace.to_owned(), missing: Missing::Shape })?;
        Ok(match shape {
            Shape::Cylinder => Self::Cylinder {
                radius_mm: need(specimen.radius_mm, Missing::Radius)?,
                height_mm: need(specimen.height_mm, Missing::Height)?,
                poisson: need(specimen.poisson_ratio, Missing::Poisson)?,
            },
            Shape::Block => Self::Block {
                length_mm: need(specimen.length_mm, Missing::Length)?,
                width_mm: need(specimen.width_mm, Missing::Width)?,
                height_mm: need(specimen.height_mm, Missing::Height)?,
                poisson: need(specimen.poisson_ratio, Missing::Poisson)?,
            },
            Shape::Sphere => {
                Self::Ball { radius_mm: need(specimen.radius_mm, Missing::Radius)?, faces }
            }
        })
    }

    /// Height without load, mm; of a ball its diameter.
    #[must_use]
    pub fn height_mm(&self) -> f64 {
        match *self {
            Self::Cylinder { height_mm, .. } | Self::Block { height_mm, .. } => height_mm,
            Self::Ball { radius_mm, .. } => 2.0 * radius_mm,
        }
    }

    /// Nominal area of contact, mm², at a displacement in mm (compression positive). Never above that
    /// of a ball's equator.
    #[must_use]
    pub fn area_mm2(&self, displacement_mm: f64) -> f64 {
        match *self {
            Self::Cylinder { radius_mm, height_mm, poisson } => {
                PI * (radius_mm * widened(displacement_mm, height_mm, poisson)).powi(2)
            }
            Self::Block { length_mm, width_mm, height_mm, poisson } => {
                length_mm * width_mm * widened(displacement_mm, height_mm, poisson).powi(2)
            }
            Self::Ball { radius_mm, faces } => {
                let share = if faces == Faces::One { 1.0 } else { 0.5 };
                let d = (share * displacement_mm).clamp(0.0, radius_mm);
                PI * (radius_mm.powi(2) - (radius_mm - d).powi(2))
            }
        }
    }

    /// Equilibrium strain Δl/l, compression positive (5.8).
    #[must_use]
    pub fn equilibrium_strain(&self, displacement_mm: f64) -> f64 {
        displacement_mm / self.height_mm()
    }

    /// Stress in Pa of a force in N at a displacement in mm; none where nothing touches.
    #[must_use]
    pub fn stress_pa(&self, force_n: f64, displacement_mm: f64) -> Option<f64> {
        let area = self.area_mm2(displacement_mm);
        (area > 0.0).then(|| 1e6 * force_n / area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_those_of_the_text() {
        let silicone = Geometry::Cylinder { radius_mm: 25.0, height_mm: 30.0, poisson: 0.48 };
        assert!((silicone.area_mm2(0.0) - 625.0 * PI).abs() < 1e-9);
        assert!((silicone.area_mm2(6.0) - 625.0 * PI * 1.096f64.powi(2)).abs() < 1e-9);
        let one = Geometry::Ball { radius_mm: 35.0, faces: Faces::One };
        let each = Geometry::Ball { radius_mm: 35.0, faces: Faces::Each };
        assert!((one.area_mm2(5.0) - PI * (35.0f64.powi(2) - 30.0f64.powi(2))).abs() < 1e-9);
        assert_eq!(one.area_mm2(5.0), each.area_mm2(10.0));
        assert_eq!(one.stress_pa(1.0, -0.1), None);
        assert!(
            (one.area_mm2(50.0) - PI * 35.0f64.powi(2)).abs() < 1e-9,
            "no more than the equator"
        );
    }

    #[test]
    fn an_incompressible_cylinder_keeps_its_volume_to_first_order() {
        let rubber = Geometry::Cylinder { radius_mm: 10.0, height_mm: 20.0, poisson: 0.5 };
        let volume = |d: f64| rubber.area_mm2(d) * (20.0 - d);
        assert!((volume(0.02) / volume(0.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_missing_size_is_named_with_its_option() {
        let specimen =
            Specimen { shape: Some(Shape::Cylinder), radius_mm: Some(3.0), ..Specimen::default() };
        let error = Geometry::of(&specimen, Faces::One, "press.csv").unwrap_err().to_string();
        assert!(error.contains("height_mm") && error.contains("--height"), "{error}");
    }
}
