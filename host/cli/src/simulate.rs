//! `palpate simulate`.

use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::Failure;
use super::output::{OverwriteOnly, print};
use palpate_fit::data::Data;
use palpate_fit::whole_motion::predict;
use palpate_model::effects::{FOLLOWED, chain_of};
use palpate_model::{Equilibrium, ForceProfile, Model, Profile, Segments};
use palpate_trace::files::plan::{COMPUTED, Plan};
use palpate_trace::{
    Column, Control, DISPLACEMENT, Head, TEMPERATURE, Trace, read, write, write_to,
};

/// Predict the force of a motion, or the motion under a controlled force.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true), after_help = "\
The motion is a trace, whose displacement is used, or a profile (a TOML file):
  palpate-profile = 1
  rate_hz = 200.0
  speed_mm_per_s = 20.0
  acceleration_mm_per_s2 = 700.0   # absent: sharp corners
  [[step]]
  hold_s = 0.2
  [[step]]
  to_mm = 12.0                     # with a speed_mm_per_s of its own where needed
  [[step]]
  hold_s = 4.3
  [[step]]
  to_mm = 0.0

A controlled force (--force) is a programme that a PI controller follows:
  palpate-force-profile = 1
  rate_hz = 200.0
  loading_N_per_s = 1.96
  bandwidth_hz = 5.0               # of the controller
  [[step]]
  to_N = 2.0                       # with a loading_N_per_s of its own where needed
  [[step]]
  hold_s = 9.5
  [[step]]
  to_N = 0.0

Examples:
  palpate simulate model.toml --motion press.csv -o predicted.csv
  palpate simulate model.toml --force creep.toml -o crept.csv
  palpate simulate latency.toml --motion profile.toml --nodes   with the nodes inside the specimen
  palpate simulate model.toml --motion profile.toml --noise 0.01 --seed 3")]
pub struct Args {
    /// The model
    model: PathBuf,
    /// The motion: a trace (.csv) or a profile (.toml)
    #[arg(long, value_name = "TRACE|PROFILE.toml", group = "what")]
    motion: Option<PathBuf>,
    /// The force to keep by PI control: a force profile (.toml)
    #[arg(long, value_name = "FORCE.toml", group = "what")]
    force: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
    /// Write the trace here instead of standard output
    #[arg(short, long, value_name = "TRACE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    over: OverwriteOnly,
}

/// What is added to the prediction.
#[derive(clap::Args)]
pub struct Options {
    /// Of a latency model with segments: add the displacement of every node inside, node2_mm, …
    #[arg(long)]
    nodes: bool,
    /// Standard deviation of white noise to add, in the unit of the signal
    #[arg(long, value_name = "RMS", value_parser = parse_noise)]
    noise: Option<f64>,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn parse_noise(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|noise: &f64| noise.is_finite() && *noise >= 0.0)
        .ok_or_else(|| "give a number of 0 or more".into())
}

/// Simulates and writes the trace.
pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        let read = args.motion.iter().chain(&args.force).chain([&args.model]);
        Plan::reading(read, args.over.into()).writes(path, &COMPUTED)?;
    }
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let (course, path) = match (&args.motion, &args.force) {
        (_, Some(path)) => (Course::Force(ForceProfile::read(path).map_err(Failure::input)?), path),
        (Some(path), None) => (Course::Motion(motion(path)?.into()), path),
        (None, None) => return Err(Failure::Input(miette::miette!("give --motion or --force"))),
    };
    let found = ask(&args.options, &model, course, &path.display().to_string())?;
    if let Some(noise) = args.options.noise {
        eprintln!("noise of {noise} RMS, seed {}", args.options.seed);
    }
    for remark in &found.remarks {
        eprintln!("! {remark}");
    }
    match &args.output {
        Some(path) => write(path, &found.trace).map_err(Failure::work),
        None => {
            let mut bytes = Vec::new();
            write_to(&mut bytes, &found.trace).map_err(Failure::work)?;
            print(&String::from_utf8_lossy(&bytes))
        }
    }
}

/// What the model goes through.
pub enum Course {
    /// A motion, and all that is known of the temperature on the way.
    Motion(Box<Trace>),
    /// A force that a controller keeps.
    Force(ForceProfile),
}

/// A simulated trace.
pub struct Simulated {
    /// The trace.
    pub trace: Trace,
    /// What is to be said of it.
    pub remarks: Vec<String>,
}

/// Predicts what happens over a course, which the trace says by its name.
pub fn ask(
    options: &Options,
    model: &Model,
    course: Course,
    name: &str,
) -> Result<Simulated, Failure> {
    let signal = &model.base.signal;
    let (mut trace, mut force) = match course {
        Course::Force(profile) => controlled(model, &profile, name)?,
        Course::Motion(motion) => moved(model, *motion, name)?,
    };
    let deepest = trace.displacement().unwrap_or_default().iter().copied().fold(0.0, f64::max);
    let remarks = beyond(model, deepest).into_iter().collect();
    if let Some(noise) = options.noise {
        add_noise(&mut force, noise, options.seed);
    }
    trace.columns.retain(|column| [DISPLACEMENT, TEMPERATURE].contains(&column.name.as_str()));
    trace.set_column(signal, force);
    if options.nodes {
        add_nodes(model, &mut trace)?;
    }
    Ok(Simulated { trace, remarks })
}

/// A motion and the force that the model predicts for it.
fn moved(model: &Model, motion: Trace, name: &str) -> Result<(Trace, Vec<f64>), Failure> {
    if let Some(effect) =
        model.effects.iter().find(|effect| effect.law.as_deref() == Some(FOLLOWED))
    {
        return Err(Failure::Input(miette::miette!(
            "`{0}` follows a measured signal (law `{FOLLOWED}`), and a motion alone has none: take it out (palpate drop {0} ...)",
            effect.name
        )));
    }
    let control = Some(Control::Displacement);
    let head = Head { specimen: motion.head.specimen, control, ..simulated(name) };
    let trace = Trace { path: None, head, ..motion };
    let data = Data::of_motions(std::slice::from_ref(&trace), &model.base.signal)
        .map_err(Failure::input)?
        .with_reference(model.reference_temperature);
    let (chain, parameters) = chain_of(model, &data.setting()).map_err(Failure::input)?;
    if let Some(what) = data.left_out.first() {
        return Err(Failure::Input(miette::miette!("{what}")));
    }
    let force = predict(&chain, &parameters, &data).concat();
    Ok((trace, force))
}

/// The motion by which a controller keeps a force, and that force.
fn controlled(
    model: &Model,
    profile: &ForceProfile,
    name: &str,
) -> Result<(Trace, Vec<f64>), Failure> {
    if let Some(effect) = model.effects.first() {
        return Err(Failure::Input(miette::miette!(
            "under force control a model runs without effects, and this one has `{}`: take it out (palpate drop), or give --motion",
            effect.name
        )));
    }
    let (law, parameters) =
        model.law().map_err(|problem| Failure::Input(miette::miette!(problem)))?;
    let run = profile.run(&law, &parameters);
    let head = Head { control: Some(Control::Force), ..simulated(name) };
    let columns = vec![Column { name: DISPLACEMENT.into(), values: run.displacement }];
    Ok((Trace { path: None, head, time: run.time, columns }, run.force))
}

/// Says when the model is asked for more than it has seen.
fn beyond(model: &Model, deepest: f64) -> Option<String> {
    let seen = model.fit.as_ref()?.largest_compression_mm?;
    (deepest > seen * 1.001).then(|| {
        format!(
            "the motion goes to {deepest:.3} mm, beyond the {seen:.3} mm that the model was fitted to"
        )
    })
}

/// Adds what the nodes inside the specimen do.
fn add_nodes(model: &Model, trace: &mut Trace) -> Result<(), Failure> {
    let wrong = |problem: String| Failure::Input(miette::miette!("{problem}"));
    let (law, parameters) = model.law().map_err(wrong)?;
    let (Some(count), Some(x)) = (law.segments, trace.displacement()) else {
        return Err(wrong(
            "--nodes needs a latency model with `segments`: fit one with --segments".into(),
        ));
    };
    let equilibrium =
        if law.family.linear_memory { Equilibrium::Common } else { Equilibrium::OwnNode };
    let segments = Segments {
        count: count as usize,
        rate: parameters[2],
        exponent: law.constants(&parameters).exponent,
        equilibrium,
    };
    let pressed: Vec<f64> = x.iter().map(|x| x.max(0.0)).collect();
    let nodes = segments.displacements(&trace.time, &pressed);
    for (node, values) in nodes.into_iter().enumerate().skip(1) {
        trace.set_column(format!("node{}_mm", node + 1), values);
    }
    Ok(())
}

/// The head of a simulated trace.
fn simulated(course: &str) -> Head {
    Head {
        version: Some(1),
        name: Some(format!("simulated over {course}")),
        computed_by: Some("palpate simulate".into()),
        ..Head::default()
    }
}

/// The motion as a trace: read, or made from a profile.
pub fn motion(path: &Path) -> Result<Trace, Failure> {
    if path.extension().is_none_or(|extension| extension != "toml") {
        return read(path).map_err(Failure::input);
    }
    let motion = Profile::read(path).map_err(Failure::input)?.motion();
    let displacement = motion.displacement.into_owned();
    let columns = vec![Column { name: DISPLACEMENT.into(), values: displacement }];
    Ok(Trace { path: None, head: Head::default(), time: motion.time.into_owned(), columns })
}

fn add_noise(force: &mut [f64], noise: f64, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    if let Ok(normal) = Normal::new(0.0, noise) {
        for value in force {
            *value += normal.sample(&mut random);
        }
    }
}
