//! `palpate record`.

mod hand;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use shared::wire::{Columns, Felt, Row, Source, Start};

use super::device::At;
use super::output::{Force, print};
use super::{Failure, interrupt};
use palpate_link::device::answers::{EventAnswer, RecordedAnswer, SecondAnswer};
use palpate_link::device::describe::{felt_in_words, live_line};
use palpate_link::device::discover::is_own_socket;
use palpate_link::device::record::{Beside, Plan, RecordError, View, overload, record};
use palpate_link::device::session::Session;
use palpate_link::robots::McapFile;
use palpate_present::answers;
use palpate_trace::files::plan::{self, MESSAGES, RECORDING};

/// Record a device into a file.
#[derive(clap::Args)]
#[command(after_help = "\
Everything that the device sends goes into the file as it came. Where something is missing (a
damaged line, a full queue, a reset, an unplugged cable) the file says so, and the recording goes
on when the device is there again. Ctrl-C ends it in order; after a kill, a crash or a full disk
all whole blocks written until then are readable. `palpate convert` makes traces of it.

With a --port for each finger of a hand all go into one file, on one clock: that of this computer.

On a terminal a line shows time, rate, rows, gaps, what the device dropped, FA and SA of each gauge;
a touch, a release and a slip are printed above it as the device reports them.

Examples:
  palpate record -o press.palpate                    until Ctrl-C
  palpate record -o press.palpate --duration 60
  palpate record -o press.palpate --json             an object a second, with the events in it
  palpate record --port /dev/ttyACM0 --port /dev/ttyACM1 -o grasp.palpate
                                                     two fingers
  palpate record -o press.palpate --mcap press.mcap  also as topics of ROS 2 (built with
                                                     --features robots)")]
pub struct Args {
    /// Serial port of the device, once for each finger of a hand; without it, the only device that answers on any port
    #[arg(long = "port", value_name = "PORT")]
    ports: Vec<PathBuf>,
    /// The recording to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Also write rows and events as topics of ROS 2, by the clock of this computer
    #[arg(long, value_name = "FILE.mcap")]
    mcap: Option<PathBuf>,
    /// End after so many seconds
    #[arg(long, value_name = "S", value_parser = parse_duration)]
    duration: Option<Duration>,
    /// Also record elastic input and equilibrium
    #[arg(long)]
    all: bool,
    /// Print nothing but errors
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print one JSON object a second on standard output, and a summary at the end
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    over: Force,
}

fn parse_duration(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| *seconds > 0.0);
    seconds
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| "give a number of seconds above 0".into())
}

/// What a person or a program sees of it.
struct Screen {
    live: bool,
    json: bool,
    shown_s: u64,
    /// Events since the last object.
    felt: Vec<EventAnswer>,
    mcap: Option<McapFile>,
    ended: fn() -> bool,
}

impl Beside for Screen {
    fn ended(&mut self) -> bool {
        (self.ended)()
    }

    fn rows(&mut self, rows: &[Row], at: Instant) {
        if let Some(file) = &mut self.mcap {
            file.listener().rows(rows, at);
        }
    }

    fn feel(&mut self, felt: &Felt) {
        if let Some(file) = &mut self.mcap {
            file.listener().event(felt);
        }
        if self.live {
            eprintln!("\r{}\x1b[K", felt_in_words(felt));
        }
        if self.json {
            self.felt.push(felt.into());
        }
    }

    fn watch(&mut self, view: &View) {
        if self.live {
            eprint!("\r{}\x1b[K", live_line(view));
        }
        if self.json && view.passed.as_secs() > self.shown_s {
            self.shown_s = view.passed.as_secs();
            let events = std::mem::take(&mut self.felt);
            let object = answers::json(&SecondAnswer { device: None, view: view.into(), events });
            // A reader that has gone away is no reason to end a recording.
            let _ = print(&format!("{object}\n"));
        }
    }
}

/// Records until it is asked to end.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = plan::Plan::reading([""; 0], args.over.into());
    files.writes(&args.output, &RECORDING)?;
    let mut mcap = None;
    if let Some(file) = &args.mcap {
        files.writes(file, &MESSAGES)?;
        mcap = Some(McapFile::at(file, args.over.force).map_err(Failure::input)?);
    }
    let ended = interrupt::handle()?;
    if let [_, _, ..] = args.ports[..] {
        return hand::run(args, ended);
    }
    let (session, plan) = args.open(args.ports.first())?;
    let live = !args.quiet && !args.json && std::io::stderr().is_terminal();
    let mut screen = Screen { live, json: args.json, shown_s: 0, felt: Vec::new(), mcap, ended };
    let outcome = record(session, &plan, &args.output, args.over.force, &mut screen);
    if live {
        eprintln!();
    }
    let mcap = screen.mcap.map_or(Ok(()), McapFile::end);
    summarise(args, None, &outcome.map_err(failed)?)?;
    mcap.map_err(Failure::work)
}

impl Args {
    /// The device on a port, or the only one, and what it shall stream.
    fn open(&self, port: Option<&PathBuf>) -> Result<(Session, Plan), Failure> {
        let (port, session) = At::on(port.cloned()).open()?;
        let columns = if self.all { Columns::All } else { Columns::Parts };
        let start = Start { source: Source::Converter, columns };
        if !is_own_socket(&port)
            && let Some(warning) = overload(session.identity(), session.interval_s(), columns)
        {
            eprintln!("warning: {warning}");
        }
        Ok((session, Plan { port, start, duration: self.duration }))
    }
}

/// Says how it went; of one of several devices, by its number from 1.
fn summarise(args: &Args, device: Option<u32>, view: &View) -> Result<(), Failure> {
    let file = args.output.display();
    if args.json {
        let of_one = RecordedAnswer::of(&args.output, args.mcap.as_deref(), view);
        let answer = RecordedAnswer { device, ..of_one };
        return print(&format!("{}\n", answers::json(&answer)));
    }
    if args.quiet {
        return Ok(());
    }
    let device = device.map_or_else(String::new, |number| format!(", device {number}"));
    print(&format!(
        "{file}{device}: {:.1} s, {} rows, {} gaps, {} drops\n",
        view.passed.as_secs_f64(),
        view.tally.rows,
        view.gaps,
        view.drops
    ))
}

fn failed(error: RecordError) -> Failure {
    match error {
        RecordError::Exists(_) | RecordError::Busy(_) => Failure::input(error),
        _ => Failure::work(error),
    }
}
