//! `palpate device info`.

use super::{At, failed};
use crate::Failure;
use crate::output::{print_json, print_sections};
use palpate_link::device::answers::DeviceAnswer;
use palpate_present::answers;
use palpate_present::summary::device_sections;

/// Say who the device is, its settings, and what it lost.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate device info
  palpate device info --port /dev/ttyACM0 --json")]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

/// Asks and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (port, mut session) = args.at.open()?;
    let status = session.status().map_err(failed)?;
    let identity = session.identity();
    let (generation, settings) = session.settings();
    if args.json {
        let answer = DeviceAnswer::of(&port, identity, (generation, settings), &status);
        return print_json(&answers::json(&answer));
    }
    print_sections(&device_sections(identity, settings, &status))
}
