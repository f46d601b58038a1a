//! `palpate grasp surface`.

use std::path::PathBuf;

use serde_json::Value;

use super::{Pressing, body, contact_of, number, positive};
use crate::Failure;
use crate::answer::Answer;
use crate::output::{Output, OverwriteOnly, write_file};
use palpate_contact::grasp::{Body, Contact, Load, Margin, SurfacePoint, limit_surface, margin};
use palpate_present::answers::{self, GraspSurfaceAnswer};
use palpate_present::summary::{SURFACE_HEADER, SurfaceSummary, surface_csv};
use palpate_report::Section;
use palpate_trace::files::plan::table;

/// The limit surface of a contact, and the margin of a load.
#[derive(clap::Args)]
#[command(after_help = "\
The centre of rotation is scanned over the whole plane: outwards from the middle in --directions
directions, in --steps steps up to infinity, where the contact slips without a turn. -o writes a
row for each; the half of the surface with the opposite turn is its mirror image.

Examples:
  palpate grasp surface --contact rectangle:42.22x26.38 --exponent 4 --friction 0.7 --force 2
  palpate grasp surface --contact sphere:35 --compression 5 --friction 0.7 --force 2 -o surface.csv
  palpate grasp surface --contact ellipse:6x4 --friction 0.5 --force 3 --tangential 0.8 --moment 2")]
pub struct Args {
    #[command(flatten)]
    options: Options,
    /// Write the surface as CSV
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output<OverwriteOnly>,
}

/// The contact, and what it is to carry.
#[derive(clap::Args)]
pub struct Options {
    /// The contact, sizes in mm: circle:5, ellipse:6x4, rectangle:42x26, sphere:35, block:40x25x50:0.48
    #[arg(long, value_name = "CONTACT", value_parser = body)]
    contact: Body,
    /// Compression of a contact that grows with it, mm
    #[arg(long, value_name = "MM", value_parser = number)]
    compression: Option<f64>,
    #[command(flatten)]
    pressing: Pressing,
    /// Normal force, N
    #[arg(long, value_name = "N", value_parser = positive)]
    force: f64,
    /// Tangential force along x whose margin is asked for, N
    #[arg(long, value_name = "N", value_parser = number, allow_hyphen_values = true)]
    tangential: Option<f64>,
    /// Tangential force along y, N
    #[arg(long, value_name = "N", value_parser = number, allow_hyphen_values = true)]
    across: Option<f64>,
    /// Moment about the normal, N mm
    #[arg(long, value_name = "NMM", value_parser = number, allow_hyphen_values = true)]
    moment: Option<f64>,
    /// Directions in which the centre of rotation goes outwards
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..))]
    directions: u16,
    /// Steps from the middle to infinity
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..))]
    steps: u16,
}

/// Scans and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = args.result.files([""; 0])?;
    if let Some(path) = &args.output {
        files.writes(path, &table(&[SURFACE_HEADER]))?;
    }
    let found = scanned(&args.options)?;
    if let Some(path) = &args.output {
        write_file(path, surface_csv(&found.surface).as_bytes())?;
        eprintln!("{} points in {}", found.surface.len(), path.display());
    }
    args.result.show(&found)
}

/// The limit surface of a contact.
pub fn ask(options: &Options) -> Result<Box<dyn Answer>, Failure> {
    Ok(Box::new(scanned(options)?))
}

fn scanned(options: &Options) -> Result<Scanned, Failure> {
    let Pressing { friction, exponent } = options.pressing;
    let contact = contact_of(&options.contact, options.compression, exponent)?;
    let limit = friction * options.force;
    let (directions, steps) = (options.directions.into(), options.steps.into());
    let surface = limit_surface(&contact, limit, directions, steps);
    let parts = [options.tangential, options.across, options.moment];
    let load = parts.iter().any(Option::is_some).then(|| {
        let [x, y, moment] = parts.map(Option::unwrap_or_default);
        let load = Load { force: [x, y], moment };
        (load, margin(&contact, limit, &load))
    });
    Ok(Scanned { contact, friction, normal: options.force, surface, load })
}

/// What a contact carries.
struct Scanned {
    contact: Contact,
    friction: f64,
    normal: f64,
    surface: Vec<SurfacePoint>,
    load: Option<(Load, Margin)>,
}

impl Scanned {
    fn summary(&self) -> SurfaceSummary<'_> {
        let Self { contact, friction, normal, surface, load } = self;
        SurfaceSummary { contact, friction: *friction, normal: *normal, surface, load: *load }
    }
}

impl Answer for Scanned {
    fn title(&self) -> &'static str {
        "What a contact carries"
    }

    fn inputs(&self) -> Vec<String> {
        Vec::new()
    }

    fn json(&self) -> Value {
        answers::json(&GraspSurfaceAnswer::from(&self.summary()))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(self.summary().sections())
    }
}
