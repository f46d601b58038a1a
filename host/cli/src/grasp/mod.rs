//! `palpate grasp`: one file for each subcommand.

pub mod friction;
pub mod growth;
pub mod margin;
pub mod plan;
pub mod surface;
mod watch;

use super::Failure;
use palpate_contact::grasp::{Body, Contact, PressureLaw};

/// What a soft contact carries before it slips.
#[derive(clap::Args)]
#[command(after_help = "\
A contact is given by its sizes in mm:
  circle:R   ellipse:XxY   rectangle:LxW            of a fixed size
  sphere:R                                          grows as it is pressed (7.7)
  cylinder:RxH:POISSON   block:LxWxH:POISSON        widened by the Poisson effect (5.5)

Examples:
  palpate grasp surface --contact rectangle:42.22x26.38 --exponent 4 --friction 0.7 --force 2
  palpate grasp growth --contact block:40x25x50:0.48 --friction 0.7 --force 2 --model model.toml
  palpate grasp margin pull.csv --contact circle:5 --friction 0.7
  palpate grasp plan hand.toml --margin 1.5 --for 60
  palpate grasp watch --contact circle:5 --friction 0.7 --normal 0.001 --tangential 0.4")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// The limit surface of a contact, and the margin of a load
    Surface(surface::Args),
    /// How the limit surface grows under creep or shrinks under relaxation
    Growth(growth::Args),
    /// The margin over a recording, and when it first slips
    Margin(margin::Args),
    /// Friction μ and exponent k of the pressure from a recorded slide
    Friction(friction::Args),
    /// Several fingers on one object: least grip, margin, and when it will slip
    Plan(plan::Args),
    /// The margin as a fingertip feels it, while it grasps
    Watch(watch::Args),
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    match &args.command {
        Command::Surface(args) => surface::run(args),
        Command::Growth(args) => growth::run(args),
        Command::Margin(args) => margin::run(args),
        Command::Friction(args) => friction::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Watch(args) => watch::run(args),
    }
}

/// How a contact presses and rubs.
#[derive(clap::Args)]
struct Pressing {
    /// Coefficient of friction
    #[arg(long, value_name = "MU", value_parser = positive)]
    friction: f64,
    /// Exponent k of the pressure: 2 is Hertz, softer materials have more, inf is uniform
    #[arg(long, value_name = "K", default_value = "2", value_parser = exponent)]
    exponent: PressureLaw,
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value: &f64| *value > 0.0 && value.is_finite());
    value.ok_or_else(|| "give a number above 0".into())
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| "give a number".into())
}

fn exponent(text: &str) -> Result<PressureLaw, String> {
    let exponent = text.parse().map_err(|_| "give a number from 1 on, or inf".to_owned())?;
    PressureLaw::new(exponent).map_err(|error| error.to_string())
}

fn body(text: &str) -> Result<Body, String> {
    text.parse().map_err(|error: palpate_contact::grasp::BodyError| error.to_string())
}

/// The contact of a body at a compression, which must be known if the contact depends on it.
fn contact_of(body: &Body, compression: Option<f64>, law: PressureLaw) -> Result<Contact, Failure> {
    let shape = body.pressed(compression).map_err(Failure::input)?;
    Contact::new(shape, law).map_err(Failure::input)
}
