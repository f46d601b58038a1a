//! `palpate serve`.

use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};

use super::output::print;
use super::{Failure, interrupt, progress};
use palpate_diagnose::practice::{Choice, SEALED, check_empty, hide, write_set};
use palpate_link::device::discover::{self, DiscoverError};
use palpate_link::device::session::LinkError;
use palpate_link::robots::Viewers;
use palpate_model::Model;
use palpate_serve::held::Law;
use palpate_serve::lab::Session;
use palpate_serve::live::{Elf, Given, Hand, Live, Source};
use palpate_serve::{Options, run as serve};

/// Folder of the demo, where none is named.
const DEMO: &str = "palpate-demo";
/// Seeds, where none is named: of the simulated device, and of what the demo hides.
const SEED: u64 = 1;
const DEMO_SEED: u64 = 6;
/// Most fingers of a hand.
const FINGERS: u8 = 8;

/// Open a local page: a fingertip live, or a model beside recordings.
#[derive(clap::Args)]
#[command(after_help = "\
Prints the address to open in a browser, and serves until Ctrl-C. The page needs no network and no
installation. Its address holds a token that is new at every start: without it nothing is shown.

With a folder of traces it opens the Lab, with a device, a replay or a simulation the rooms Live and
Device, with both all. With neither, the only device that answers on any serial port is taken.

Examples:
  palpate serve --demo --open                 ten presses with a hidden effect and a simulated
                                             fingertip, to try it all; kept in palpate-demo/
  palpate serve traces/ --open               a model beside recordings, and what it lacks
  palpate serve traces/ --model model.toml   the same, from this model on
  palpate serve --simulate --open            a simulated fingertip
  palpate serve --port /dev/ttyUSB0          a fingertip on a port
  palpate serve --simulate --model model.toml  the same, and whether this model predicts how a
                                             held press goes on; without one, the device's filter
  palpate serve --port /dev/ttyUSB0 --port /dev/ttyUSB1
                                             the fingers of a hand side by side
  palpate serve --simulate --foxglove        also for Foxglove, PlotJuggler and their like
                                             (built with --features robots)
  palpate serve --replay press.csv           a trace through the filter of the device, as fast as
                                             it was recorded
  palpate serve --replay press.csv --speed 4 --recordings touches/")]
#[command(groups = [clap::ArgGroup::new("source"), clap::ArgGroup::new("made-up")])]
pub struct Args {
    /// Folder of traces to open in the Lab; practice sets and model files are written to it
    folder: Option<PathBuf>,
    /// Model to begin with in the Lab, and that predicts a held press in the Live room
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Serial port of the device, once for each finger of a hand; without it, the only device that answers on any port
    #[arg(long = "port", visible_alias = "device-port", value_name = "PORT", group = "source")]
    ports: Vec<PathBuf>,
    /// Replay a trace or a recording through the filter of the device
    #[arg(long, value_name = "TRACE", group = "source")]
    replay: Option<PathBuf>,
    /// Replay so many times as fast as it was recorded
    #[arg(long, value_name = "FACTOR", default_value = "1", requires = "replay", value_parser = speed)]
    speed: f64,
    /// Simulate a device
    #[arg(long, groups = ["source", "made-up"])]
    simulate: bool,
    /// Simulate a hand of so many fingers
    #[arg(long, value_name = "N", default_value_t = 1, requires = "simulate", value_parser = clap::value_parser!(u8).range(1..=i64::from(FINGERS)))]
    fingers: u8,
    /// Ten presses with a hidden effect to find, and a simulated device
    #[arg(long, groups = ["source", "made-up"], conflicts_with = "model")]
    demo: bool,
    /// Seed of the simulated device's noise, and of what the demo hides [default: 1 and 6]
    #[arg(long, requires = "made-up")]
    seed: Option<u64>,
    /// ELF file of the firmware, to put the device's log into words
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// Take the ELF file even if it is not that of the device's firmware
    #[arg(long, requires = "elf")]
    force: bool,
    /// Folder that recordings are written to
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    recordings: PathBuf,
    /// Port of the page; 0 for any that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    port_http: u16,
    /// Address to listen on; any but a loopback address lets other computers in
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    bind: IpAddr,
    /// Also send rows, events and margins as topics of ROS 2 to viewers that speak the Foxglove protocol, on this port of the
    /// same address; 0 for any that is free
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "8765")]
    foxglove: Option<u16>,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
}

/// What there is to see where there is no device.
const WITHOUT_DEVICE: &str = "\
Without a device:
  palpate serve --demo --open        ten presses with a hidden effect, and a simulated fingertip
  palpate serve --simulate --open    a simulated fingertip alone; with --fingers 3, a hand
  palpate serve FOLDER --open        your own recordings in the Lab";

fn speed(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|speed: &f64| (0.01..=100.0).contains(speed))
        .ok_or_else(|| "give a number from 0.01 to 100".into())
}

/// Serves until Ctrl-C.
pub fn run(args: &Args) -> Result<(), Failure> {
    let ended = interrupt::handle()?;
    if !args.recordings.is_dir() {
        let folder = args.recordings.display();
        return Err(Failure::Input(miette::miette!("{folder} is no folder for recordings")));
    }
    let lab = args.lab()?;
    let viewers = args.viewers()?;
    let fingers = args.fingers(lab.is_some(), viewers.as_ref())?;
    if !args.bind.is_loopback() {
        eprintln!(
            "! {} is no loopback address: whoever reaches it and has the token sees the page and commands the device, \
             and nothing is encrypted",
            args.bind
        );
        if viewers.is_some() {
            eprintln!("! whoever reaches it sees the topics for robots, without a token");
        }
    }
    let options = Options { bind: args.bind, port: args.port_http, fingers, lab };
    let mut printed = Ok(());
    let ready = |url: &str| {
        printed = print(&format!("{url}\n"));
        eprintln!("open this address in a browser; Ctrl-C ends it");
        if let Some(viewers) = &viewers {
            eprintln!("viewers of robots connect to {}", viewers.url());
        }
        if args.open
            && let Err(error) = open::that_detached(url)
        {
            eprintln!("! no browser could be opened: {error}");
        }
    };
    serve(options, ready, ended).map_err(Failure::work)?;
    printed
}

impl Args {
    /// The folder that was named, with its model.
    fn lab(&self) -> Result<Option<Session>, Failure> {
        let folder = if self.demo { Some(self.demo_folder()?) } else { self.folder.clone() };
        let Some(folder) = folder else { return Ok(None) };
        let session = Session::open(&folder, self.model.as_deref()).map_err(Failure::input)?;
        for (name, why) in session.left_out() {
            eprintln!("! {name} is left out: {why}");
        }
        Ok(Some(session))
    }

    /// The practice set of the demo: that of an earlier start, or a new one.
    fn demo_folder(&self) -> Result<PathBuf, Failure> {
        let folder = self.folder.clone().unwrap_or_else(|| DEMO.into());
        let shown = folder.display();
        if folder.join(SEALED).is_file() {
            eprintln!("{shown}: the practice set that is there");
            return Ok(folder);
        }
        check_empty(&folder).map_err(Failure::input)?;
        let wait = progress::spinner("recording ten presses");
        let seed = self.seed.unwrap_or(DEMO_SEED);
        let practice = hide(&Choice::Any(1), 1.0, seed);
        wait.finish_and_clear();
        let practice = practice.map_err(Failure::work)?;
        write_set(&folder, &practice).map_err(Failure::work)?;
        eprintln!("{shown}: ten presses with a hidden effect, seed {seed}");
        Ok(folder)
    }

    /// Whether the device is a simulated one. The demo does without where there cannot be one.
    fn made_up(&self) -> bool {
        self.simulate || (self.demo && cfg!(unix))
    }

    /// The devices, or what stands for them; none beside a folder where none was named.
    fn fingers(&self, beside: bool, viewers: Option<&Viewers>) -> Result<Vec<Live>, Failure> {
        let named = !self.ports.is_empty() || self.replay.is_some() || self.made_up();
        if beside && !named {
            return match viewers {
                None => Ok(Vec::new()),
                Some(_) => Err(Failure::Input(miette::miette!(
                    "--foxglove shows a fingertip: name its --port, or --simulate one"
                ))),
            };
        }
        let (given, elf, hand) = (self.given(beside)?, self.elf()?, Hand::default());
        let begin = |(index, source)| {
            let listener = viewers.map(|viewers| viewers.finger(index + 1)).transpose();
            let listener = listener.map_err(Failure::work)?;
            let (folder, elf, given) = (self.recordings.clone(), elf.clone(), given.clone());
            Live::begin(source, folder, elf, given, listener, &hand).map_err(Failure::input)
        };
        sources(self)?.into_iter().enumerate().map(begin).collect()
    }

    /// The door for viewers of robots, if it is to be open.
    fn viewers(&self) -> Result<Option<Viewers>, Failure> {
        let viewers = self.foxglove.map(|port| Viewers::serve(self.bind, port));
        viewers.transpose().map_err(Failure::input)
    }

    /// The model that predicts in the Live room. One that does not is of use in the Lab alone.
    fn given(&self, beside: bool) -> Result<Option<Given>, Failure> {
        let Some(path) = &self.model else { return Ok(None) };
        let name = path.display().to_string();
        match Law::of(&Model::read(path).map_err(Failure::input)?) {
            Ok(law) => Ok(Some(Given { name, law })),
            Err(error) if beside => {
                eprintln!("! {name} predicts nothing in the Live room: {error}");
                Ok(None)
            }
            Err(error) => Err(Failure::Input(miette::miette!("{name}: {error}"))),
        }
    }
}

impl Args {
    /// The words of the device's log, once it is known that there are any.
    fn elf(&self) -> Result<Option<Elf>, Failure> {
        let Some(path) = &self.elf else { return Ok(None) };
        let elf = Elf { path: path.clone(), force: self.force };
        elf.words("").map_err(Failure::input)?;
        Ok(Some(elf))
    }
}

#[cfg(unix)]
fn sources(args: &Args) -> Result<Vec<Source>, Failure> {
    if args.made_up() {
        let seed = args.seed.unwrap_or(SEED);
        let finger =
            |finger: u8| Source::Simulated { seed: seed.wrapping_add(finger.into()), finger };
        return Ok((0..args.fingers).map(finger).collect());
    }
    if let Some(path) = &args.replay {
        let mut traces =
            palpate_trace::read_set(std::slice::from_ref(path)).map_err(Failure::input)?;
        if traces.len() != 1 {
            let (path, count) = (path.display(), traces.len());
            return Err(Failure::Input(miette::miette!("{path} holds {count} traces; name one")));
        }
        return Ok(vec![Source::Replay { trace: Box::new(traces.remove(0)), speed: args.speed }]);
    }
    devices(&args.ports)
}

#[cfg(not(unix))]
fn sources(args: &Args) -> Result<Vec<Source>, Failure> {
    if args.simulate || args.replay.is_some() {
        return Err(Failure::Input(miette::miette!(
            "a simulated device needs a pseudo-terminal, which Linux and macOS have"
        )));
    }
    devices(&args.ports)
}

/// The devices on these ports, each a finger; without a port, the only one that answers.
fn devices(ports: &[PathBuf]) -> Result<Vec<Source>, Failure> {
    if ports.is_empty() {
        return Ok(vec![device(None)?]);
    }
    if ports.len() > usize::from(FINGERS) {
        let count = ports.len();
        return Err(Failure::Input(miette::miette!("{count} ports; a hand has at most {FINGERS}")));
    }
    for (index, port) in ports.iter().enumerate() {
        let real = |port: &PathBuf| port.canonicalize().unwrap_or_else(|_| port.clone());
        if ports[..index].iter().any(|other| real(other) == real(port)) {
            let port = port.display();
            return Err(Failure::Input(miette::miette!(
                "{port} is named twice; name each finger's port once"
            )));
        }
    }
    ports.iter().map(|port| device(Some(port))).collect()
}

fn device(port: Option<&Path>) -> Result<Source, Failure> {
    match discover::choose(port) {
        Ok((port, session)) => Ok(Source::Device { port, session: Some(Box::new(session)) }),
        // The page says what to do with it, and goes on when that was done.
        Err(DiscoverError::Named { port, source: source @ LinkError::Schema { .. } }) => {
            eprintln!("! {}: {source}", port.display());
            Ok(Source::Device { port, session: None })
        }
        Err(error @ (DiscoverError::NoPort | DiscoverError::None(_))) => {
            Err(Failure::Input(miette::miette!("{error}\n{WITHOUT_DEVICE}")))
        }
        Err(error @ DiscoverError::Several(_)) => Err(Failure::Input(miette::miette!(
            "{error}\nor, where they are fingers of one hand, each with a --port of its own"
        ))),
        Err(error) => Err(Failure::input(error)),
    }
}
