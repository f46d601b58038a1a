//! `palpate grasp growth`.

use std::path::PathBuf;

use serde_json::Value;

use super::{Pressing, body, number, positive};
use crate::Failure;
use crate::answer::Answer;
use crate::output::{Output, OverwriteOnly};
use palpate_contact::grasp::growth::{creep, growth, relaxation};
use palpate_contact::grasp::{Body, Grown, Held, Material};
use palpate_model::{Model, Relaxation};
use palpate_present::answers::{self, GraspGrowthAnswer};
use palpate_present::summary::growth_sections;
use palpate_report::Section;

/// How the limit surface grows under creep or shrinks under relaxation.
#[derive(clap::Args)]
#[command(after_help = "\
With a constant force the body creeps: its contact grows, and with it the moment that it carries.
With a constant compression the force relaxes, and all that it carries shrinks with it.

  --model M --force N                        creep that the model predicts
  --model M --compression MM                 relaxation that the model predicts
  --creep D --shares c1,… --rates v1,… --force N        D (1 + Σ ci e^(−vi t)), eqs 6.1 and 6.2
  --shares c1,… --rates v1,… --force N --compression MM   N (c0 + Σ ci e^(−vi t)), eq. 3.4

Examples:
  palpate grasp growth --contact block:40x25x50:0.48 --exponent 4 --friction 0.7 --force 2 \\
      --creep 8.1 --shares=-0.0738,-0.214 --rates 0.8229,0.007805
  palpate grasp growth --contact sphere:35 --friction 0.7 --compression 5 --model model.toml")]
pub struct Args {
    /// Take elastic response and relaxation from this model
    #[arg(long, value_name = "MODEL.toml", conflicts_with_all = ["shares", "rates", "creep"])]
    model: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    result: Output<OverwriteOnly>,
}

/// The body, and how it is held.
#[derive(clap::Args)]
pub struct Options {
    /// The body, sizes in mm: block:40x25x50:0.48, cylinder:25x30:0.48, sphere:35; or a fixed contact
    #[arg(long, value_name = "CONTACT", value_parser = body)]
    contact: Body,
    #[command(flatten)]
    pressing: Pressing,
    /// Normal force, N: constant under creep, at the start of a relaxation
    #[arg(long, value_name = "N", value_parser = positive)]
    force: Option<f64>,
    /// Constant compression, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    compression: Option<f64>,
    /// Compression once the creep has settled, mm
    #[arg(long, value_name = "MM", value_parser = positive, requires_all = ["shares", "force"], conflicts_with = "compression")]
    creep: Option<f64>,
    /// Shares c1,c2,…
    #[arg(long, value_delimiter = ',', value_parser = number, requires = "rates", allow_hyphen_values = true)]
    shares: Vec<f64>,
    /// Rates v1,v2,… 1/s
    #[arg(long, value_delimiter = ',', value_parser = positive, requires = "shares")]
    rates: Vec<f64>,
    /// Length of the hold, s
    #[arg(long, value_name = "S", default_value = "10", value_parser = positive)]
    duration: f64,
    /// Times at which it is computed
    #[arg(long, default_value_t = 101, value_parser = clap::value_parser!(u16).range(2..))]
    points: u16,
}

/// Computes and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.model)?;
    let model = args.model.as_deref().map(|path| {
        let name = path.display().to_string();
        Model::read(path).map(|model| (model, name)).map_err(Failure::input)
    });
    args.result.show(&*ask(&args.options, model.transpose()?)?)
}

/// How the limit surface changes, by a model of that name or by the shares and rates given.
pub fn ask(options: &Options, model: Option<(Model, String)>) -> Result<Box<dyn Answer>, Failure> {
    let course = course(options, model.as_ref().map(|(model, _)| model))?;
    let Pressing { friction, exponent } = options.pressing;
    let grown = growth(&options.contact, exponent, friction, &course);
    if grown.is_empty() {
        return Err(Failure::Input(miette::miette!(
            "the body is never pressed, so nothing is held"
        )));
    }
    let without_effects = model.as_ref().is_some_and(|(model, _)| !model.effects.is_empty());
    let inputs = model.into_iter().map(|(_, name)| name).collect();
    Ok(Box::new(OverTime { grown, without_effects, inputs }))
}

/// A limit surface over time.
struct OverTime {
    grown: Vec<Grown>,
    without_effects: bool,
    inputs: Vec<String>,
}

impl Answer for OverTime {
    fn title(&self) -> &'static str {
        "A limit surface over time"
    }

    fn inputs(&self) -> Vec<String> {
        self.inputs.clone()
    }

    fn json(&self) -> Value {
        answers::json(&GraspGrowthAnswer::from(&self.grown[..]))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(growth_sections(&self.grown))
    }

    fn remarks(&self) -> Vec<String> {
        let what = "the effects of the model are left out: only its base law is followed";
        self.without_effects.then(|| what.into()).into_iter().collect()
    }
}

/// Compression and normal force over the hold.
fn course(args: &Options, model: Option<&Model>) -> Result<Vec<Held>, Failure> {
    let wrong = |what: &str| Failure::Input(miette::miette!("{what}"));
    let last = f64::from(args.points - 1);
    let times: Vec<f64> = (0..args.points).map(|k| args.duration * f64::from(k) / last).collect();
    if let Some(model) = model {
        let material = Material::of(model).map_err(|what| wrong(&what))?;
        return match (args.force, args.compression) {
            (Some(force), None) => Ok(material.creep(&times, force)),
            (None, Some(compression)) => Ok(material.relaxation(&times, compression)),
            _ => Err(wrong(
                "with --model give either --force, for creep, or --compression, for relaxation",
            )),
        };
    }
    if args.shares.is_empty() || args.shares.len() != args.rates.len() {
        return Err(wrong("give --model, or as many --shares as --rates"));
    }
    let force = args.force.ok_or_else(|| wrong("give the normal force with --force N"))?;
    let relaxing = Relaxation::new(&args.shares, &args.rates);
    if let Some(settled) = args.creep {
        return Ok(creep(&times, settled, &relaxing.branches, force));
    }
    if relaxing.equilibrium() < 0.0 || args.shares.iter().any(|share| *share < 0.0) {
        return Err(wrong("shares of a relaxation are 0 or more, and no more than 1 together"));
    }
    if args.contact.grows() && args.compression.is_none() {
        return Err(wrong("give the constant compression with --compression MM, or --creep MM"));
    }
    Ok(relaxation(&times, &relaxing, force, args.compression.unwrap_or_default()))
}
