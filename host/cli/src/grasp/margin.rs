//! `palpate grasp margin`.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;

use super::{Pressing, body, number};
use crate::Failure;
use crate::answer::{Answer, labels};
use crate::output::{Output, write_file};
use palpate_analysis::decomposition::{decompose, relaxation_of};
use palpate_contact::grasp::history::{MOMENT, history};
use palpate_contact::grasp::{Body, Grip, History, Source, Sources};
use palpate_model::Model;
use palpate_present::answers::{self, GraspMarginAnswer};
use palpate_present::summary::{HISTORY_HEADER, history_csv, history_sections};
use palpate_report::Section;
use palpate_trace::files::plan::table;
use palpate_trace::{FORCE, TANGENTIAL, Trace, read_set};

/// The margin over a recording, and when it first slips.
#[derive(clap::Args)]
#[command(after_help = "\
The margin is the factor by which the load, tangential force and moment together, could grow until
the contact slips; its inverse is the share of the grip in use. A load is a column or a number.
Without --contact the body is that of the trace's [specimen]; a ball or a block with Poisson's
ratio grows with displacement_mm.

With --model the filter of the device says at every sample where the normal force will settle if
the grasp is held as it is, and with it the margin that will be left.

Examples:
  palpate grasp margin pull.csv --contact circle:5 --friction 0.7
  palpate grasp margin press.csv --friction 0.7 --tangential 0.8 --moment 3
  palpate grasp margin pull.csv --contact sphere:35 --friction 0.7 --model model.toml -o margin.csv")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    #[command(flatten)]
    options: Options,
    /// Also give the margin once settled, by the relaxation function of this model
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Write the share in use at every sample of the one trace as CSV
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// The contact, and where its load is.
#[derive(clap::Args)]
pub struct Options {
    /// The contact, sizes in mm: circle:5, ellipse:6x4, rectangle:42x26, sphere:35, block:40x25x50:0.48
    #[arg(long, value_name = "CONTACT", value_parser = body)]
    contact: Option<Body>,
    #[command(flatten)]
    pressing: Pressing,
    /// Column of the normal force, N
    #[arg(long, default_value = FORCE, value_name = "COLUMN")]
    normal: String,
    /// Tangential force along x: a column, or N
    #[arg(long, default_value = TANGENTIAL, value_name = "COLUMN|N", value_parser = source, allow_hyphen_values = true)]
    tangential: Source,
    /// Tangential force along y: a column, or N
    #[arg(long, default_value = "0", value_name = "COLUMN|N", value_parser = source, allow_hyphen_values = true)]
    across: Source,
    /// Moment about the normal: a column, or N mm; without it moment_Nmm where there is one, else none
    #[arg(long, value_name = "COLUMN|NMM", value_parser = source, allow_hyphen_values = true)]
    moment: Option<Source>,
    /// There is contact where the normal force is above this, N; without it, five times its noise
    #[arg(long, value_name = "N", value_parser = number)]
    contact_above: Option<f64>,
}

fn source(text: &str) -> Result<Source, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Source::Constant(value)),
        Ok(_) => Err("give the name of a column, or a number".into()),
        Err(_) => Ok(Source::Column(text.into())),
    }
}

/// Follows the margin and prints it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = args.result.files(args.traces.iter().chain(&args.model))?;
    if let Some(path) = &args.output {
        files.writes(path, &table(&[HISTORY_HEADER]))?;
    }
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    if args.output.is_some() && traces.len() > 1 {
        return Err(Failure::Input(miette::miette!(
            "-o takes one trace; {} were given",
            traces.len()
        )));
    }
    let model = args.model.as_deref().map(Model::read).transpose().map_err(Failure::input)?;
    let found = followed(&args.options, model.as_ref(), traces)?;
    if let (Some(path), [(trace, history)]) = (&args.output, &found.each()[..]) {
        write_file(path, history_csv(trace, history).as_bytes())?;
    }
    args.result.show(&found)
}

/// Follows the margin over traces in memory; with a model also that once settled.
pub fn ask(
    options: &Options,
    model: Option<&Model>,
    traces: Arc<Vec<Trace>>,
) -> Result<Box<dyn Answer>, Failure> {
    Ok(Box::new(followed(options, model, traces)?))
}

fn followed(
    options: &Options,
    model: Option<&Model>,
    traces: Arc<Vec<Trace>>,
) -> Result<Followed, Failure> {
    let relaxation = model.map(relaxation_of).transpose().map_err(Failure::input)?;
    let mut histories = Vec::new();
    for trace in &*traces {
        let settled = relaxation.as_ref().map(|relaxation| {
            let channel = decompose(trace, &options.normal, relaxation, || {});
            channel.map(|channel| channel.equilibrium).map_err(Failure::input)
        });
        let settled = settled.transpose()?;
        let found = history(
            trace,
            &grip(options, trace)?,
            &sources(options, trace),
            settled.as_deref(),
            options.contact_above,
        );
        histories.push(found.map_err(Failure::input)?);
    }
    Ok(Followed { traces, histories })
}

/// The margin over recordings.
struct Followed {
    traces: Arc<Vec<Trace>>,
    histories: Vec<History>,
}

impl Followed {
    fn each(&self) -> Vec<(&Trace, &History)> {
        self.traces.iter().zip(&self.histories).collect()
    }
}

impl Answer for Followed {
    fn title(&self) -> &'static str {
        "Margin until slip"
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        answers::json(&GraspMarginAnswer::from(&self.each()[..]))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(history_sections(&self.each()))
    }
}

fn grip(options: &Options, trace: &Trace) -> Result<Grip, Failure> {
    let body = match options.contact {
        Some(body) => body,
        None => Body::of(&trace.head.specimen).map_err(Failure::input)?,
    };
    Ok(Grip { body, law: options.pressing.exponent, friction: options.pressing.friction })
}

fn sources(options: &Options, trace: &Trace) -> Sources {
    let moment = options.moment.clone().unwrap_or_else(|| match trace.column(MOMENT) {
        Some(_) => Source::Column(MOMENT.into()),
        None => Source::Constant(0.0),
    });
    Sources {
        normal: options.normal.clone(),
        tangential: options.tangential.clone(),
        across: options.across.clone(),
        moment,
    }
}
