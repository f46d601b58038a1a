//! `palpate device simulate`.

use std::path::PathBuf;

use crate::Failure;

/// Simulate a device behind a pseudo-terminal.
#[derive(clap::Args)]
#[command(after_help = "\
The device's own program runs here; only the board is made up: four gauges that are pressed, held,
released and left to rest, over and over. Prints the path to open as a serial port, then runs
until Ctrl-C. Needs Linux or macOS.

Examples:
  palpate device simulate                              prints a path such as /dev/pts/4
  palpate record --port /dev/pts/4 -o press.palpate    in another terminal
  palpate device simulate --link /tmp/fingertip        a path that stays the same
  palpate device simulate --settings fingertip.bin     keeps its settings, as flash would")]
pub struct Args {
    /// Make this a link to the pseudo-terminal
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// Keep the settings in this file
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Simulates until it is asked to end.
#[cfg(unix)]
pub fn run(args: &Args) -> Result<(), Failure> {
    use crate::output::print;
    use palpate_link::device::simulate::{Simulated, Simulation};

    let ended = crate::interrupt::handle()?;
    let simulation = Simulation {
        settings: args.settings.clone(),
        seed: args.seed,
        link: args.link.clone(),
        finger: 0,
    };
    let mut simulated = Simulated::new(&simulation).map_err(Failure::input)?;
    print(&format!("{}\n", simulated.path().display()))?;
    eprintln!("a simulated fingertip; Ctrl-C ends it");
    if simulated.run(ended).map_err(Failure::work)? {
        eprintln!("it was asked for its loader; a simulated one has none and ends here");
    }
    Ok(())
}

/// Says what is missing.
#[cfg(not(unix))]
pub fn run(_: &Args) -> Result<(), Failure> {
    Err(Failure::Input(miette::miette!(
        "a simulated device needs a pseudo-terminal, which Linux and macOS have"
    )))
}
