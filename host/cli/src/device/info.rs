//! `palpate device info`.

use serde_json::json;

use super::{At, failed};
use crate::Failure;
use crate::output::{print_json, print_sections};
use palpate_link::device::describe;
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
        return print_json(&json!({
            "palpate_device": 1,
            "port": port,
            "device": describe::identity_json(identity),
            "settings": describe::settings_json(settings, identity.converter_clock_hz),
            "generation": generation,
            "status": describe::status_json(&status),
        }));
    }
    print_sections(&device_sections(identity, settings, &status))
}
