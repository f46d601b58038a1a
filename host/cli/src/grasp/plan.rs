//! `palpate grasp plan`.

use std::path::PathBuf;

use serde_json::Value;

use super::positive;
use crate::answer::Answer;
use crate::output::Output;
use crate::{Failure, progress};
use palpate_contact::grasp::hand::Hand;
use palpate_contact::grasp::{BalanceError, Least};
use palpate_model::Model;
use palpate_present::answers::{self, GraspPlanAnswer};
use palpate_present::summary::{Forecast, HandPlan, plan_sections};
use palpate_report::Section;

/// Several fingers on one object: least grip, margin, and when it will slip.
#[derive(clap::Args)]
#[command(after_help = "\
The hand is a TOML file: the load on the object and, for each finger, where it touches, how it lies,
its contact and friction, and the fitted model of what is pressed (docs/grasp.md has two).

  least grip      the normal forces that hold the load with the margin asked for
  margin          how many times the load could be, with fingers pressing as the file says (normal_N)
  over time       with --for: how the grip goes on, when it slips, and how much to tighten it now

Examples:
  palpate grasp plan hand.toml
  palpate grasp plan hand.toml --margin 1.5 --least largest
  palpate grasp plan hand.toml --model tip.toml --margin 1.2 --for 60 --report hand.html
  palpate grasp plan hand.toml --model tip.toml --for 60 --after 5      it has been held for 5 s already")]
pub struct Args {
    /// The hand
    #[arg(value_name = "HAND.toml")]
    hand: PathBuf,
    #[command(flatten)]
    options: Options,
    /// What is pressed, for fingers whose entry names no model
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// What the grasp must hold, and for how long.
#[derive(clap::Args)]
pub struct Options {
    /// How many times the load must be held
    #[arg(long, default_value = "1", value_parser = positive)]
    margin: f64,
    /// What to make least: the sum of the normal forces, or the largest of them
    #[arg(long, default_value = "sum", value_parser = ["sum", "largest"])]
    least: String,
    /// Look so many seconds ahead
    #[arg(long = "for", value_name = "S", value_parser = positive)]
    lasts: Option<f64>,
    /// The object has been held for so many seconds
    #[arg(long, value_name = "S", default_value = "0", value_parser = not_negative, requires = "lasts")]
    after: f64,
}

fn not_negative(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value: &f64| *value >= 0.0 && value.is_finite());
    value.ok_or_else(|| "give a number of 0 or more".into())
}

/// Times at which a forecast is looked at.
const INSTANTS: u32 = 24;

/// Plans and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files([&args.hand].into_iter().chain(&args.model))?;
    let hand = Hand::read(&args.hand).map_err(Failure::input)?;
    let model = args.model.as_deref().map(|path| {
        let name = path.display().to_string();
        Model::read(path).map(|model| (model, name)).map_err(Failure::input)
    });
    let name = args.hand.display().to_string();
    args.result.show(&*ask(&args.options, hand, model.transpose()?, name)?)
}

/// Plans the grasp of a hand of that name, which is made of a model with its own name where it names none itself.
pub fn ask(
    options: &Options,
    mut hand: Hand,
    model: Option<(Model, String)>,
    name: String,
) -> Result<Box<dyn Answer>, Failure> {
    if let Some((model, of)) = model {
        let wrong = |what: String| Failure::Input(miette::miette!("{of}: {what}"));
        hand.made_of(&model, of.clone()).map_err(wrong)?;
    }
    let wait = progress::spinner("looking for forces");
    let plan = plan(options, &hand, &name);
    wait.finish_and_clear();
    Ok(Box::new(Planned { plan: plan?, hand, name }))
}

/// How a hand is to grasp.
struct Planned {
    hand: Hand,
    plan: HandPlan,
    name: String,
}

impl Answer for Planned {
    fn title(&self) -> &'static str {
        "A grasp"
    }

    fn inputs(&self) -> Vec<String> {
        vec![self.name.clone()]
    }

    fn json(&self) -> Value {
        answers::json(&GraspPlanAnswer::of(&self.hand, &self.plan))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(plan_sections(&self.hand, &self.plan))
    }

    fn remarks(&self) -> Vec<String> {
        let left_out = |model: &String| {
            format!("the effects of {model} are left out: only its base law is followed")
        };
        self.hand.without_effects.iter().map(left_out).collect()
    }
}

fn plan(args: &Options, hand: &Hand, name: &str) -> Result<HandPlan, Failure> {
    let wrong = |what: String| Failure::Input(miette::miette!("{name}: {what}"));
    let least = if args.least == "sum" { Least::Sum } else { Least::Largest };
    let closure = hand.closure().map_err(wrong)?;
    let grip = hand.least_grip(args.margin, least).map_err(wrong)?;
    let now = match hand.now() {
        None => None,
        Some(normals) => Some((hand.margin(&normals).map_err(wrong)?, normals)),
    };
    let forecast = match args.lasts {
        None => None,
        Some(lasts) => {
            // What the file says, else what holds with the margin asked for.
            let planned = grip
                .as_ref()
                .ok()
                .map(|grip| grip.shares.iter().map(|share| share.normal).collect::<Vec<f64>>());
            let given = now.as_ref().map(|(_, normals)| normals.clone());
            match given.or(planned) {
                None => None,
                Some(normals) => Some(forecast(args, hand, &normals, lasts).map_err(wrong)?),
            }
        }
    };
    if let Err(error @ BalanceError::Unfinished(_)) = &grip {
        return Err(Failure::Work(miette::miette!("{error}")));
    }
    Ok(HandPlan { closure, margin: args.margin, least, grip, now, forecast })
}

fn forecast(args: &Options, hand: &Hand, normals: &[f64], lasts: f64) -> Result<Forecast, String> {
    // Close together at first: relaxation is fast then.
    let at = |k: u32| lasts * (f64::from(k) / f64::from(INSTANTS)).powi(2);
    let times: Vec<f64> = (0..=INSTANTS).map(|k| args.after + at(k)).collect();
    let course = hand.course(normals, &times, None)?;
    Ok(Forecast {
        slips: hand.falls_to(normals, 1.0, &course)?,
        below_margin: hand.falls_to(normals, args.margin, &course)?,
        tighten: hand.regrip(normals, args.margin, args.after, lasts)?,
        from: args.after,
        lasts,
        course,
    })
}
