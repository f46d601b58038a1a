//! `palpate grasp watch`.

use std::io::{self, Write};
use std::ops::ControlFlow::{self, Break, Continue};
use std::path::PathBuf;

use shared::pipeline::GAUGES;
use shared::wire::Row;

use super::{Pressing, body, contact_of, number, positive};
use crate::device::At;
use crate::{Failure, interrupt};
use palpate_analysis::decomposition::{decompose, default_relaxation, relaxation_of};
use palpate_contact::grasp::live::{Felt, Fingertip, Growing, Reading, Watch, Weights, weights};
use palpate_contact::grasp::{Body, Material};
use palpate_link::device::watch::watch;
use palpate_model::Model;
use palpate_present::answers::{self, GraspWatchAnswer};
use palpate_present::summary::reading_line;
use palpate_trace::{self as trace, Trace, read_set};

/// The margin as a fingertip feels it, while it grasps.
#[derive(clap::Args)]
#[command(after_help = "\
Forces come from the gauges by weights, in N per µε, that a calibration against known loads gives.
The fingertip's filter says where each gauge will settle, so every line has the margin now and the
margin once settled. How the gauges relax says when it will slip, and how much to tighten the grip so
that it does not: of a recording by the filter's relaxation function, of a device by that of --model.
A contact that grows follows the compression that --model makes of the force. Ctrl-C ends it.

With --recording the same is said of a recording of a fingertip, or of any trace with gauges.

Examples:
  palpate grasp watch --contact circle:5 --friction 0.7 --normal 0.001 --tangential 0.4
  palpate grasp watch --port /dev/ttyUSB0 --contact circle:5 --friction 0.7 \\
      --normal 0.001,0.001,0,0 --tangential-gauges 0,0,0.002,-0.002 --rest 1
  palpate grasp watch --recording press.palpate --contact circle:5 --friction 0.7 --normal 0.001 \\
      --tangential 0.4 --json")]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// Follow a recording instead of a device
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    recording: Option<PathBuf>,
    /// How the gauges relax, and how force and compression go together; without it, a recording relaxes by
    /// eq. 3.6
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// The contact, sizes in mm: circle:5, ellipse:6x4, rectangle:42x26
    #[arg(long, value_name = "CONTACT", value_parser = body)]
    contact: Body,
    /// Compression of a contact that grows with it, mm, where it is constant; else --model predicts it
    #[arg(long, value_name = "MM", value_parser = number)]
    compression: Option<f64>,
    #[command(flatten)]
    pressing: Pressing,
    /// Normal force, N per µε: one number for all gauges, or four
    #[arg(long, value_name = "WEIGHTS", value_parser = weights, allow_hyphen_values = true)]
    normal: [f64; GAUGES],
    /// Tangential force that is always there, N
    #[arg(long, value_name = "N", default_value = "0", value_parser = number, allow_hyphen_values = true)]
    tangential: f64,
    /// Tangential force, N per µε of each gauge
    #[arg(long, value_name = "WEIGHTS", default_value = "0", value_parser = weights, allow_hyphen_values = true)]
    tangential_gauges: [f64; GAUGES],
    /// Moment about the normal that is always there, N mm
    #[arg(long, value_name = "NMM", default_value = "0", value_parser = number, allow_hyphen_values = true)]
    moment: f64,
    /// Moment about the normal, N mm per µε of each gauge
    #[arg(long, value_name = "WEIGHTS", default_value = "0", value_parser = weights, allow_hyphen_values = true)]
    moment_gauges: [f64; GAUGES],
    /// Something is held where the normal force is above this, N
    #[arg(long, value_name = "N", default_value = "0.05", value_parser = number)]
    contact_above: f64,
    /// The strain over the first so many seconds, without a grasp, is zero
    #[arg(long, value_name = "S", value_parser = positive)]
    rest: Option<f64>,
    /// Time between two lines, s
    #[arg(long, value_name = "S", default_value = "0.2", value_parser = positive)]
    every: f64,
    /// End after so many seconds
    #[arg(long, value_name = "S", value_parser = positive)]
    duration: Option<f64>,
    /// Print one JSON object a line
    #[arg(long)]
    json: bool,
}

/// Prints a line from time to time.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut watcher = Watcher::new(args)?;
    match &args.recording {
        Some(path) => {
            for trace in &read_set(&[path]).map_err(Failure::input)? {
                watcher.watch.begin();
                let _ = felt(trace, args)?.iter().try_for_each(|felt| watcher.take(felt));
            }
        }
        None => {
            let ended = interrupt::handle()?;
            let (_, mut session) = args.at.open()?;
            let each = |row: &Row| Felt::of(row).map_or(Continue(()), |felt| watcher.take(&felt));
            let tally = watch(&mut session, ended, each).map_err(Failure::work)?;
            eprintln!("{} rows, {} lost", tally.rows, tally.rows_lost);
        }
    }
    watcher.written.map_err(Failure::work)
}

/// Turns samples into lines.
struct Watcher<'a> {
    args: &'a Args,
    watch: Watch,
    /// Whether all lines could be written.
    written: io::Result<()>,
}

impl<'a> Watcher<'a> {
    fn new(args: &'a Args) -> Result<Self, Failure> {
        let model = match &args.model {
            Some(path) => Some(Model::read(path).map_err(Failure::input)?),
            None => None,
        };
        let growing = growing(args, model.as_ref())?;
        // Any compression will do for a contact that is shaped anew at every reading.
        let compression = args.compression.or(growing.as_ref().map(|_| 1.0));
        let contact = contact_of(&args.contact, compression, args.pressing.exponent)?;
        let relaxation = match &model {
            Some(model) => Some(relaxation_of(model).map_err(Failure::input)?),
            None => args.recording.is_some().then(default_relaxation),
        };
        let weights = |gauges, constant| Weights { gauges, constant };
        let fingertip = Fingertip {
            contact,
            friction: args.pressing.friction,
            normal: weights(args.normal, 0.0),
            tangential: weights(args.tangential_gauges, args.tangential),
            moment: weights(args.moment_gauges, args.moment),
            threshold: args.contact_above,
            zero: [0.0; GAUGES],
            elastic_zero: [0.0; GAUGES],
            growing,
            relaxation,
        };
        let watch = Watch::new(fingertip, args.rest.unwrap_or_default(), args.every);
        Ok(Self { args, watch, written: Ok(()) })
    }

    /// Takes a sample; breaks after the last one that is wanted.
    fn take(&mut self, felt: &Felt) -> ControlFlow<()> {
        if let Some(reading) = self.watch.take(felt) {
            return self.say(&reading);
        }
        let is_over = self.args.duration.is_some_and(|most| self.watch.passed_s() >= most);
        if is_over && !self.watch.is_resting() { Break(()) } else { Continue(()) }
    }

    /// Writes a line; breaks where nobody reads any more.
    fn say(&mut self, reading: &Reading) -> ControlFlow<()> {
        let line = if self.args.json {
            answers::json(&GraspWatchAnswer::from(reading)).to_string()
        } else {
            reading_line(reading)
        };
        let mut out = io::stdout().lock();
        match writeln!(out, "{line}").and_then(|()| out.flush()) {
            Ok(()) => Continue(()),
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Break(()),
            Err(error) => {
                self.written = Err(error);
                Break(())
            }
        }
    }
}

/// How the contact grows, where no compression is given.
fn growing(args: &Args, model: Option<&Model>) -> Result<Option<Growing>, Failure> {
    let body = args.contact;
    let (true, None, Some(model)) = (body.grows(), args.compression, model) else {
        return Ok(None);
    };
    let wrong = |what: String| Failure::Input(miette::miette!("{what}"));
    let material = Material::of(model).map_err(wrong)?;
    Ok(Some(Growing { body, material }))
}

/// The samples of a trace with gauges. Where their equilibria were not recorded, the filter of the device says
/// them.
fn felt(trace: &Trace, args: &Args) -> Result<Vec<Felt>, Failure> {
    let relaxation = match &args.model {
        Some(path) => {
            let model = Model::read(path).map_err(Failure::input)?;
            relaxation_of(&model).map_err(Failure::input)?
        }
        None => default_relaxation(),
    };
    // Strain, equilibrium, fast part and elastic input of each gauge.
    let mut gauges: Vec<[Vec<f64>; 4]> = Vec::new();
    for name in trace::GAUGES {
        let part = |part: &str| trace.column(&name.replace("_ustrain", &format!("{part}_ustrain")));
        let recorded = [part(""), part("_equilibrium"), part("_fa"), part("_elastic")];
        gauges.push(match recorded {
            [Some(strain), Some(equilibrium), Some(fast), Some(elastic)] => {
                [strain, equilibrium, fast, elastic].map(<[f64]>::to_vec)
            }
            _ => {
                let channel = decompose(trace, name, &relaxation, || {}).map_err(Failure::input)?;
                [channel.input, channel.equilibrium, channel.fa, channel.elastic]
            }
        });
    }
    let at = |(k, &time): (usize, &f64)| {
        let part = |part: usize| std::array::from_fn(|gauge| gauges[gauge][part][k]);
        Felt { time, strain: part(0), equilibrium: part(1), fast: part(2), elastic: part(3) }
    };
    Ok(trace.time.iter().enumerate().map(at).collect())
}
