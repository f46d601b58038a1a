//! `palpate plan`.

use std::path::PathBuf;

use serde_json::Value;

use super::answer::Answer;
use super::output::{print_json, print_sections};
use super::{Failure, progress};
use palpate_fit::exponentials::plan::{Experiment, Plan, Recording, Wanted};
use palpate_fit::exponentials::{Bound, ExponentialSum, Normalisation, Parameter, Term};
use palpate_model::{EQUATION_3_6, Model};
use palpate_present::answers::{self, RecordingPlanAnswer};
use palpate_present::dissertation::EQUATION_3_5;
use palpate_present::summary::plan_section;
use palpate_report::Section;

/// How long and how fast to record for a wanted precision.
#[derive(clap::Args)]
#[command(after_help = "\
The answer is the Cramér–Rao bound of a hold: no unbiased fit of it can do better, and `palpate fit
--hold-only` comes close. Without a model or --shares, the relaxation of eqs 3.5 and 3.6 is taken.

Examples:
  palpate plan --noise 0.01                       what 4.3 s at 200 Hz would determine of eq. 3.6
  palpate plan --model model.toml --compression 8 --noise 0.02 --duration 10
  palpate plan --noise 0.01 --want v1=2 --want v2=5        percent of each
  palpate plan --force 1.5 --shares 0.25,0.27 --rates 4,0.5 --noise 0.01 --want v2=1")]
pub struct Args {
    /// Take the relaxation function from this model
    #[arg(long, value_name = "MODEL.toml", requires = "compression", conflicts_with_all = ["shares", "rates", "force"])]
    model: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

/// What is to be recorded, and how well known.
#[derive(clap::Args)]
pub struct Options {
    /// Standard deviation of the noise of one sample, in the unit of the signal
    #[arg(long, value_name = "RMS")]
    noise: f64,
    /// Compression of the hold, mm, for the model
    #[arg(long, value_name = "MM")]
    compression: Option<f64>,
    /// Signal at the start of the hold
    #[arg(long, value_name = "N")]
    force: Option<f64>,
    /// Shares c1,c2,… of the relaxation function
    #[arg(long, value_delimiter = ',', requires = "rates")]
    shares: Vec<f64>,
    /// Rates v1,v2,… of the relaxation function, 1/s
    #[arg(long, value_delimiter = ',', requires = "shares")]
    rates: Vec<f64>,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 200.0)]
    rate: f64,
    /// Length of the hold, s
    #[arg(long, value_name = "S", default_value_t = 4.3)]
    duration: f64,
    /// A precision wanted, in percent: v1=2; may be given several times
    #[arg(long, value_name = "PARAMETER=PERCENT", value_parser = parse_wanted)]
    want: Vec<Wanted>,
    /// Longest hold to consider, s
    #[arg(long, value_name = "S", default_value_t = 600.0)]
    longest: f64,
    /// Fastest sampling to consider, Hz
    #[arg(long, value_name = "HZ", default_value_t = 4000.0)]
    fastest: f64,
}

fn parse_wanted(text: &str) -> Result<Wanted, String> {
    let wrong = || "give a parameter and percent: N=1, c1=2 or v2=5".to_owned();
    let (name, percent) = text.split_once('=').ok_or_else(wrong)?;
    let parameter = (1..=4)
        .flat_map(Parameter::all)
        .find(|parameter| parameter.to_string() == name)
        .ok_or_else(wrong)?;
    let percent: f64 = percent.trim_end_matches('%').parse().map_err(|_| wrong())?;
    Ok(Wanted { parameter, relative: percent / 100.0 })
}

/// Prints what the recording would determine, and the recordings that determine what is wanted.
pub fn run(args: &Args) -> Result<(), Failure> {
    let model = args.model.as_deref().map(Model::read).transpose().map_err(Failure::input)?;
    let found = ask(&args.options, model.as_ref())?;
    if args.json { print_json(&found.json()) } else { print_sections(&found.sections()?) }
}

/// Plans with the relaxation function of a model, or with the one given.
pub fn ask(options: &Options, model: Option<&Model>) -> Result<Box<dyn Answer>, Failure> {
    let sum = sum(options, model)?;
    let experiment =
        Experiment { sum, noise: options.noise, normalisation: Normalisation::Initial };
    let recording = Recording::lasting(options.duration, options.rate);
    let bound = experiment.bound(recording).map_err(Failure::input)?;
    let wait = progress::spinner("searching recordings");
    let plans = if options.want.is_empty() {
        Vec::new()
    } else {
        let longer = experiment.duration_for(&options.want, options.rate, options.longest);
        let faster = experiment.rate_for(&options.want, options.duration, options.fastest);
        vec![longer.map_err(Failure::input)?, faster.map_err(Failure::input)?]
    };
    wait.finish_and_clear();
    Ok(Box::new(Planned { experiment, recording, bound, plans }))
}

/// What recordings would determine.
struct Planned {
    experiment: Experiment,
    recording: Recording,
    bound: Bound,
    plans: Vec<Plan>,
}

impl Answer for Planned {
    fn title(&self) -> &'static str {
        "Plan"
    }

    fn inputs(&self) -> Vec<String> {
        Vec::new()
    }

    fn json(&self) -> Value {
        let Self { experiment, recording, bound, plans } = self;
        answers::json(&RecordingPlanAnswer::of(experiment, recording, bound, plans))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        let Self { experiment, recording, bound, plans } = self;
        Ok(vec![plan_section(experiment, *recording, bound, plans)])
    }
}

/// The relaxation to plan for: a model's at a compression, the one given, or eqs 3.5 and 3.6.
fn sum(args: &Options, model: Option<&Model>) -> Result<ExponentialSum, Failure> {
    if let Some(model) = model {
        let compression = args.compression.ok_or_else(|| {
            Failure::Input(miette::miette!(
                "to plan with a model, give the --compression of the hold"
            ))
        })?;
        let (law, values) =
            model.law().map_err(|problem| Failure::Input(miette::miette!(problem)))?;
        let Some(relaxation) = law.relaxation(&values) else {
            return Err(Failure::Input(miette::miette!(
                "a hold of {} is no sum of exponentials: plan with a model of another law",
                law.in_words()
            )));
        };
        let constants = law.constants(&values);
        let force = constants.p * law.elastic.unit(constants.shape, compression);
        let branches = relaxation.branches.iter();
        return Ok(from_terms(force, branches.map(|branch| (branch.share, branch.rate))));
    }
    let ([_, c1, c2], [v1, v2]) = EQUATION_3_6;
    let terms = if args.shares.is_empty() {
        vec![(c1, v1), (c2, v2)]
    } else if args.shares.len() == args.rates.len() {
        args.shares.iter().copied().zip(args.rates.iter().copied()).collect()
    } else {
        return Err(Failure::Input(miette::miette!(
            "{} shares but {} rates: each exponential has one of both",
            args.shares.len(),
            args.rates.len()
        )));
    };
    Ok(from_terms(args.force.unwrap_or(EQUATION_3_5), terms.into_iter()))
}

fn from_terms(scale: f64, terms: impl Iterator<Item = (f64, f64)>) -> ExponentialSum {
    let mut terms: Vec<Term> =
        terms.map(|(coefficient, rate)| Term { coefficient, rate }).collect();
    terms.sort_by(|a, b| b.rate.total_cmp(&a.rate));
    let constant = 1.0 - terms.iter().map(|term| term.coefficient).sum::<f64>();
    ExponentialSum { scale, constant, terms }
}
