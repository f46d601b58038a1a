//! `palpate grasp friction`.

use std::path::PathBuf;

use serde_json::Value;

use super::{body, exponent, number};
use crate::Failure;
use crate::answer::Answer;
use crate::output::Output;
use palpate_contact::grasp::friction::{Friction, Sliding, friction};
use palpate_contact::grasp::history::MOMENT;
use palpate_contact::grasp::{Body, Load, PressureLaw};
use palpate_present::answers::{self, GraspFrictionAnswer};
use palpate_present::summary::friction_sections;
use palpate_report::Section;
use palpate_trace::{DISPLACEMENT, FORCE, TANGENTIAL, Trace, read};

/// Friction μ and exponent k of the pressure from a recorded slide.
#[derive(clap::Args)]
#[command(after_help = "\
While a contact slides its load lies on the limit surface, so every sample says what μ is. Give the
part of the recording in which it slides with --from and --to; without them every sample in contact
counts. A slide along a line determines μ alone; one that also turns about the normal, more and less, determines
the exponent k of the pressure too, if the moment was recorded.

Examples:
  palpate grasp friction slide.csv --contact circle:5 --from 1.2 --to 3.0
  palpate grasp friction twist.csv --contact rectangle:30x20 --across shear_y_N --moment moment_Nmm")]
pub struct Args {
    /// The recording
    #[arg(value_name = "TRACE")]
    trace: PathBuf,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    result: Output,
}

/// The contact, and where it slides.
#[derive(clap::Args)]
pub struct Options {
    /// The contact, sizes in mm; without it, that of the trace's [specimen]
    #[arg(long, value_name = "CONTACT", value_parser = body)]
    contact: Option<Body>,
    /// Exponent k where the slide does not determine it
    #[arg(long, value_name = "K", default_value = "2", value_parser = exponent)]
    exponent: PressureLaw,
    /// It slides from this time on, s
    #[arg(long, value_name = "S", value_parser = number, allow_hyphen_values = true)]
    from: Option<f64>,
    /// It slides until this time, s
    #[arg(long, value_name = "S", value_parser = number, allow_hyphen_values = true)]
    to: Option<f64>,
    /// Column of the normal force, N
    #[arg(long, default_value = FORCE, value_name = "COLUMN")]
    normal: String,
    /// Column of the tangential force along x, N
    #[arg(long, default_value = TANGENTIAL, value_name = "COLUMN")]
    tangential: String,
    /// Column of the tangential force along y, N
    #[arg(long, value_name = "COLUMN")]
    across: Option<String>,
    /// Column of the moment about the normal, N mm; without it moment_Nmm where there is one
    #[arg(long, value_name = "COLUMN")]
    moment: Option<String>,
    /// There is contact where the normal force is above this, N
    #[arg(long, value_name = "N", default_value = "0", value_parser = number)]
    contact_above: f64,
}

/// Identifies and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files([&args.trace])?;
    let trace = read(&args.trace).map_err(Failure::input)?;
    args.result.show(&*ask(&args.options, &trace)?)
}

/// Friction from a slide in memory.
pub fn ask(options: &Options, trace: &Trace) -> Result<Box<dyn Answer>, Failure> {
    let body = match options.contact {
        Some(body) => body,
        None => Body::of(&trace.head.specimen).map_err(Failure::input)?,
    };
    let samples = sliding(options, trace, &body)?;
    let found = friction(&body, options.exponent, &samples);
    let found = found.map_err(|error| wrong(&format!("{}: {error}", trace.label())))?;
    Ok(Box::new(Slid { found, exponent: options.exponent, trace: trace.label() }))
}

/// What a slide says of friction.
struct Slid {
    found: Friction,
    exponent: PressureLaw,
    trace: String,
}

impl Answer for Slid {
    fn title(&self) -> &'static str {
        "Friction"
    }

    fn inputs(&self) -> Vec<String> {
        vec![self.trace.clone()]
    }

    fn json(&self) -> Value {
        answers::json(&GraspFrictionAnswer::from(&self.found))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(friction_sections(&self.found, self.exponent))
    }
}

fn wrong(what: &str) -> Failure {
    Failure::Input(miette::miette!("{what}"))
}

fn sliding(options: &Options, trace: &Trace, body: &Body) -> Result<Vec<Sliding>, Failure> {
    let column = |name: &str| {
        let missing = || wrong(&format!("{} has no column `{name}`", trace.label()));
        trace.column(name).ok_or_else(missing)
    };
    let (normal, x) = (column(&options.normal)?, column(&options.tangential)?);
    let y = options.across.as_deref().map(column).transpose()?;
    let moment = match &options.moment {
        Some(name) => Some(column(name)?),
        None => trace.column(MOMENT),
    };
    let compression = if body.grows() { Some(column(DISPLACEMENT)?) } else { None };
    let of = |values: Option<&[f64]>, k: usize| values.map_or(0.0, |values| values[k]);
    let slides = |k: &usize| {
        let time = trace.time[*k];
        options.from.is_none_or(|from| time >= from)
            && options.to.is_none_or(|to| time <= to)
            && normal[*k] > options.contact_above
    };
    let sample = |k: usize| Sliding {
        normal: normal[k],
        compression: of(compression, k),
        load: Load { force: [x[k], of(y, k)], moment: of(moment, k) },
    };
    Ok((0..trace.len()).filter(slides).map(sample).collect())
}
