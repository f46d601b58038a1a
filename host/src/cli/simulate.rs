//! `palpate simulate`.

use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::Failure;
use super::output::{print, write_file};
use crate::effects::chain_of;
use crate::fit::data::Data;
use crate::fit::whole_motion::predict;
use crate::model::{Model, Profile};
use crate::trace::{Column, Control, DISPLACEMENT, Head, TEMPERATURE, Trace, read, write_to};

/// Predict the force of a motion.
#[derive(clap::Args)]
#[command(after_help = "\
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

Examples:
  palpate simulate model.toml --motion press.csv -o predicted.csv
  palpate simulate model.toml --motion profile.toml --noise 0.01 --seed 3")]
pub struct Args {
    /// The model
    model: PathBuf,
    /// The motion: a trace (.csv) or a profile (.toml)
    #[arg(long, value_name = "TRACE|PROFILE.toml")]
    motion: PathBuf,
    /// Standard deviation of white noise to add, in the unit of the signal
    #[arg(long, value_name = "RMS", value_parser = parse_noise)]
    noise: Option<f64>,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the trace here instead of standard output
    #[arg(short, long, value_name = "TRACE")]
    output: Option<PathBuf>,
}

fn parse_noise(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|noise: &f64| noise.is_finite() && *noise >= 0.0)
        .ok_or_else(|| "give a number of 0 or more".into())
}

/// Simulates and writes the trace.
pub fn run(args: &Args) -> Result<(), Failure> {
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let mut trace = motion(&args.motion)?;
    let signal = &model.base.signal;
    let mut force = {
        let data = Data::of_motions(std::slice::from_ref(&trace), signal)
            .map_err(Failure::input)?
            .with_reference(model.reference_temperature);
        let (chain, parameters) = chain_of(&model, &data.setting()).map_err(Failure::input)?;
        let deepest = data.largest_compression();
        if let Some(seen) = model.fit.as_ref().and_then(|fit| fit.largest_compression_mm)
            && deepest > seen * 1.001
        {
            eprintln!(
                "! the motion goes to {deepest:.3} mm, beyond the {seen:.3} mm that the model was fitted to"
            );
        }
        if let Some(what) = data.left_out.first() {
            return Err(Failure::Input(miette::miette!("{what}")));
        }
        predict(&chain, &parameters, &data).concat()
    };
    if let Some(noise) = args.noise {
        eprintln!("noise of {noise} RMS, seed {}", args.seed);
        add_noise(&mut force, noise, args.seed);
    }
    trace.columns.retain(|column| [DISPLACEMENT, TEMPERATURE].contains(&column.name.as_str()));
    trace.set_column(signal, force);
    let mut bytes = Vec::new();
    write_to(&mut bytes, &trace).map_err(Failure::work)?;
    match &args.output {
        Some(path) => write_file(path, &bytes),
        None => print(&String::from_utf8_lossy(&bytes)),
    }
}

/// The motion as a trace: read, or made from a profile.
fn motion(path: &Path) -> Result<Trace, Failure> {
    let mut head = Head {
        version: Some(1),
        name: Some(format!("simulated over {}", path.display())),
        control: Some(Control::Displacement),
        ..Head::default()
    };
    if path.extension().is_some_and(|extension| extension == "toml") {
        let motion = Profile::read(path).map_err(Failure::input)?.motion();
        let displacement = motion.displacement.into_owned();
        let columns = vec![Column { name: DISPLACEMENT.into(), values: displacement }];
        return Ok(Trace { path: None, head, time: motion.time.into_owned(), columns });
    }
    let trace = read(path).map_err(Failure::input)?;
    head.specimen = trace.head.specimen;
    Ok(Trace { path: None, head, ..trace })
}

fn add_noise(force: &mut [f64], noise: f64, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    if let Ok(normal) = Normal::new(0.0, noise) {
        for value in force {
            *value += normal.sample(&mut random);
        }
    }
}
