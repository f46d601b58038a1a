//! The specimen's geometry as options, over what the head says.

use clap::ValueEnum;

use palpate_analysis::geometry::Faces;
use palpate_trace::{Shape, Trace};

/// Geometry of the specimen; without an option, what the head of each trace says.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Specimen")]
pub struct SpecimenArgs {
    /// Its shape
    #[arg(long, value_enum)]
    shape: Option<ShapeArg>,
    /// Radius of a cylinder or a ball
    #[arg(long, value_name = "MM", value_parser = positive)]
    radius: Option<f64>,
    /// Height of a cylinder or a block
    #[arg(long, value_name = "MM", value_parser = positive)]
    height: Option<f64>,
    /// Length of a block
    #[arg(long, value_name = "MM", value_parser = positive)]
    length: Option<f64>,
    /// Width of a block
    #[arg(long, value_name = "MM", value_parser = positive)]
    width: Option<f64>,
    /// Poisson's ratio, by which the area of contact grows (5.5); 0 keeps the area
    #[arg(long, value_name = "RATIO", value_parser = poisson)]
    poisson: Option<f64>,
    /// What a ball's depression d is (7.7): the whole displacement (one), or half of it on each of two
    /// faces (each)
    #[arg(long, value_enum, default_value = "one")]
    faces: FacesArg,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ShapeArg {
    Cylinder,
    Block,
    Sphere,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum FacesArg {
    #[default]
    One,
    Each,
}

/// Reads a number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("give a number above 0".into()),
    }
}

fn poisson(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > -1.0 && value <= 0.5 => Ok(value),
        _ => Err("Poisson's ratio lies above -1 and up to 0.5".into()),
    }
}

impl SpecimenArgs {
    /// Writes what was given into the heads of the traces.
    pub fn apply(&self, traces: &mut [Trace]) {
        let set = |place: &mut Option<f64>, given: Option<f64>| *place = given.or(*place);
        for trace in traces {
            let specimen = &mut trace.head.specimen;
            if let Some(shape) = self.shape {
                specimen.shape = Some(match shape {
                    ShapeArg::Cylinder => Shape::Cylinder,
                    ShapeArg::Block => Shape::Block,
                    ShapeArg::Sphere => Shape::Sphere,
                });
            }
            set(&mut specimen.radius_mm, self.radius);
            set(&mut specimen.height_mm, self.height);
            set(&mut specimen.length_mm, self.length);
            set(&mut specimen.width_mm, self.width);
            set(&mut specimen.poisson_ratio, self.poisson);
        }
    }

    /// What a ball's depression is.
    pub fn faces(&self) -> Faces {
        match self.faces {
            FacesArg::One => Faces::One,
            FacesArg::Each => Faces::Each,
        }
    }
}
