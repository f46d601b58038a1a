//! One file for each subcommand: parse, call, print.
//!
//! Results go to standard output, words about the work to standard error. Exit status 0, 1 when the
//! work failed, 2 when the input or the call was wrong.
//!
//! ```
//! assert_eq!(palpate_cli::run_with(["palpate", "effects", "mullins"].map(Into::into)), 0);
//! ```
#![forbid(unsafe_code)]

mod add;
mod afm;
mod answer;
pub mod ask;
mod compare;
mod completions;
mod convert;
mod creep;
mod decompose;
mod demo;
mod device;
mod diagnose;
mod discover;
mod dissertation;
mod drop;
mod effects;
mod events;
mod explore;
mod fit;
mod grasp;
mod hide;
pub mod import;
mod interrupt;
mod markers;
mod output;
mod plan;
mod plot;
mod preparation;
mod progress;
mod published;
mod rates;
mod record;
mod relaxation;
mod segment;
mod sensor;
mod serve;
mod simulate;
mod specimen;
mod strain_rate;
pub mod survey;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use miette::{Diagnostic, Report};
use tracing_subscriber::filter::LevelFilter;

pub use output::{Force, Output};

/// Fit contact models to recordings of touch, and see where they fail.
#[derive(Parser)]
#[command(name = "palpate", bin_name = "palpate", version, max_term_width = 100, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Report more of what is done, on standard error; twice for all
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
}

const EXAMPLES: &str = "\
Examples:
  palpate demo                                     a press, from gauges to a report
  palpate decompose press.csv -o split/            FA, SA, regions of every gauge
  palpate fit fung traces/ -o model.toml           one model for a whole data set
  palpate compare model.toml traces/               where the model fails
  palpate add mullins model.toml traces/           what an effect explains
  palpate effects mullins                          one effect of the library, in depth
  palpate hide -o practice/                        an exercise: which effect is in it?
  palpate simulate model.toml --motion press.csv   what the model says of another motion
  palpate grasp margin pull.csv --friction 0.7     when a grasp slips
  palpate import lab.txt --map lab.map.toml        a foreign recording
  palpate device list                              the fingertips that are plugged in
  palpate record -o press.palpate                  a recording of one
  palpate serve --simulate --open                  a page that shows a fingertip live
  palpate serve traces/ --open                     a page that puts a model right";

#[derive(Subcommand)]
enum Command {
    /// Replay a bundled press through the device's filter, fit it, write a report
    Demo(demo::Args),
    /// Split signals into fast (FA) and slow adapting (SA) parts, and mark the regions of the grasp
    Decompose(decompose::Args),
    /// Fit a contact model
    Fit(fit::Args),
    /// Touch, release and incipient slip, found in FA as a device finds them
    Events(events::Args),
    /// Cut grasps into their six regions, cycle by cycle: points, forces, work, dissipation
    Segment(segment::Args),
    /// What holds of a displacement show: eq. 3.4, repeats, number of exponentials, latency model
    Relaxation(relaxation::Args),
    /// Creep in holds of a force: eq. 6.2, Type I and II, what is not identified
    Creep(creep::Args),
    /// One specimen at several loading rates: stiffness, surface strain, asymptotes, stiffening
    Rates(rates::Args),
    /// Strain and strain rate from force, and the power law of every hold
    StrainRate(strain_rate::Args),
    /// Markers that a camera follows: the latency model of the gaps between them
    Markers(markers::Args),
    /// Compare a model with measurements, and see where it fails
    Compare(compare::Args),
    /// Say which physical effect a model lacks, with the evidence
    Diagnose(diagnose::Args),
    /// Ask every group of a large data set, one row a group
    Survey(survey::Args),
    /// Add an effect to a model, refit, and see the error fall
    Add(add::Args),
    /// Take an effect out of a model, refit, and see the error rise
    Drop(drop::Args),
    /// Add what is missing until only noise is left, or say that it does not know
    Explore(explore::Args),
    /// Find a formula for what no effect of the library explains
    Discover(discover::Args),
    /// Show the library of effects, or one effect in depth
    Effects(effects::Args),
    /// Make a practice data set with a hidden effect, or open one
    Hide(hide::Args),
    /// Predict the force of a motion
    Simulate(simulate::Args),
    /// Simulate a fingertip that is pressed, shaken or slid over
    Sensor(sensor::Args),
    /// What a soft contact carries before it slips
    Grasp(grasp::Args),
    /// Analyse force curves of a tip
    Afm(afm::Args),
    /// Turn a foreign recording into a trace
    Import(import::Args),
    /// Turn recordings of a device into traces (CSV, Parquet), and back
    Convert(convert::Args),
    /// Draw traces
    Plot(plot::Args),
    /// How long and how fast to record for a wanted precision
    Plan(plan::Args),
    /// Find, set, test and simulate fingertips
    Device(device::Args),
    /// Record a device into a file
    Record(record::Args),
    /// Open a local page: a fingertip live, or a model beside recordings
    Serve(serve::Args),
    /// Recompute every printed table and equation of the dissertation
    Dissertation(dissertation::Args),
    /// Print completions for a shell
    Completions(completions::Args),
}

/// Why a subcommand ended without its result.
#[derive(Debug)]
pub enum Failure {
    /// The input or the call was wrong: exit status 2.
    Input(Report),
    /// The work failed: exit status 1.
    Work(Report),
}

impl Failure {
    /// The input was wrong.
    pub fn input(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Input(Report::new(Wrapped(Box::new(error))))
    }

    /// The work failed.
    pub fn work(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Work(Report::new(Wrapped(Box::new(error))))
    }
}

impl Failure {
    /// What went wrong, with every cause that is not in the words before it.
    #[must_use]
    pub fn words(&self) -> String {
        let (Self::Input(report) | Self::Work(report)) = self;
        let mut text = report.to_string();
        for cause in report.chain().skip(1).map(ToString::to_string) {
            if !text.contains(&cause) {
                text += &format!("\n  because {cause}");
            }
        }
        text
    }

    /// The exit status that it ends a command with.
    #[must_use]
    pub fn status(&self) -> u8 {
        match self {
            Self::Input(_) => 2,
            Self::Work(_) => 1,
        }
    }
}

/// An error of the library, shown by its own words.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
struct Wrapped(Box<dyn std::error::Error + Send + Sync>);

impl Diagnostic for Wrapped {}

/// Runs the command line of this process; the exit status is what `main` returns.
#[must_use]
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os()))
}

/// Runs a command line, its first word being the name of the program, and gives the exit status.
pub fn run_with(words: impl IntoIterator<Item = OsString>) -> u8 {
    let words: Vec<OsString> = words.into_iter().collect();
    output::remember_call(&words);
    let arguments = match Arguments::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(told) => {
            // Help on standard output, a wrong call on standard error; a reader that has gone away is no error.
            let _ = told.print();
            return told.exit_code().try_into().unwrap_or(2);
        }
    };
    start_log(arguments.verbose);
    interrupt::prepare();
    let outcome = match &arguments.command {
        Command::Demo(args) => demo::run(args),
        Command::Decompose(args) => decompose::run(args),
        Command::Fit(args) => fit::run(args),
        Command::Events(args) => events::run(args),
        Command::Segment(args) => segment::run(args),
        Command::Relaxation(args) => relaxation::run(args),
        Command::Creep(args) => creep::run(args),
        Command::Rates(args) => rates::run(args),
        Command::StrainRate(args) => strain_rate::run(args),
        Command::Markers(args) => markers::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Diagnose(args) => diagnose::run(args),
        Command::Survey(args) => survey::run(args),
        Command::Add(args) => add::run(args),
        Command::Drop(args) => drop::run(args),
        Command::Explore(args) => explore::run(args),
        Command::Discover(args) => discover::run(args),
        Command::Effects(args) => effects::run(args),
        Command::Hide(args) => hide::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Sensor(args) => sensor::run(args),
        Command::Grasp(args) => grasp::run(args),
        Command::Afm(args) => afm::run(args),
        Command::Import(args) => import::run(args),
        Command::Convert(args) => convert::run(args),
        Command::Plot(args) => plot::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Device(args) => device::run(args),
        Command::Record(args) => record::run(args),
        Command::Serve(args) => serve::run(args),
        Command::Dissertation(args) => dissertation::run(args),
        Command::Completions(args) => completions::run::<Arguments>(args),
    };
    match outcome {
        Ok(()) => 0,
        Err(failure) => {
            eprintln!("error: {}", failure.words());
            failure.status()
        }
    }
}

/// Messages of the library go to standard error; `PALPATE_LOG` names a level, `-v` raises it.
fn start_log(verbose: u8) {
    let named = std::env::var("PALPATE_LOG").ok().and_then(|level| level.parse().ok());
    let level = named.unwrap_or(match verbose {
        0 => LevelFilter::WARN,
        1 => LevelFilter::INFO,
        _ => LevelFilter::TRACE,
    });
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .without_time()
        .with_target(false)
        .with_ansi(console::colors_enabled_stderr())
        .init();
}
