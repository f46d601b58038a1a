//! `palpate device`: one file for each subcommand.

mod calibrate;
mod dfu;
mod info;
mod list;
mod log;
mod self_test;
mod set;
mod simulate;
mod tare;

use std::path::PathBuf;

use super::Failure;
use palpate_link::device::discover::{DiscoverError, choose};
use palpate_link::device::session::{LinkError, Session};

/// Find, set, test and simulate fingertips.
#[derive(clap::Args)]
#[command(after_help = "\
Without --port, the only device that answers on any serial port is taken.

Examples:
  palpate device list                        which ports have a device
  palpate device info                        who it is, its settings, what it lost
  palpate device set --rate 2000 --save      another sample rate, kept over a loss of power
  palpate device simulate                    a device without hardware, behind a pseudo-terminal")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Say which ports have a device
    List(list::Args),
    /// Say who the device is, its settings, and what it lost
    Info(info::Args),
    /// Print the device's log
    Log(log::Args),
    /// Find gain and offset of the gauges, and set them
    Calibrate(calibrate::Args),
    /// Set rate, gain, filter and thresholds
    Set(set::Args),
    /// Read zero from now on
    Tare(tare::Args),
    /// Test converter, bridges and rate
    SelfTest(self_test::Args),
    /// Begin the loader in ROM, to write new firmware without a probe
    Dfu(dfu::Args),
    /// Simulate a device behind a pseudo-terminal
    Simulate(simulate::Args),
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    match &args.command {
        Command::List(args) => list::run(args),
        Command::Info(args) => info::run(args),
        Command::Log(args) => log::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Set(args) => set::run(args),
        Command::Tare(args) => tare::run(args),
        Command::SelfTest(args) => self_test::run(args),
        Command::Dfu(args) => dfu::run(args),
        Command::Simulate(args) => simulate::run(args),
    }
}

/// Which device.
#[derive(clap::Args)]
pub struct At {
    /// Serial port of the device; without it, the only device that answers on any port
    #[arg(long, value_name = "PORT")]
    port: Option<PathBuf>,
}

impl At {
    /// The device on this port, or the only one.
    pub const fn on(port: Option<PathBuf>) -> Self {
        Self { port }
    }

    /// The device, and its port.
    pub fn open(&self) -> Result<(PathBuf, Session), Failure> {
        self.choose().map_err(Failure::input)
    }

    /// The same, with the reason as it is.
    fn choose(&self) -> Result<(PathBuf, Session), DiscoverError> {
        choose(self.port.as_deref())
    }
}

/// What the device refuses was asked wrongly; anything else failed on the way.
fn failed(error: LinkError) -> Failure {
    match error {
        LinkError::Refused(_) => Failure::input(error),
        _ => Failure::work(error),
    }
}
