//! `palpate device tare`.

use shared::wire::ToDevice;

use super::{At, failed};
use crate::Failure;
use crate::output::{print, print_json};
use palpate_link::device::answers::TareAnswer;
use palpate_link::device::measure;
use palpate_present::answers;

/// Read zero from now on, on every gauge.
#[derive(clap::Args)]
#[command(after_help = "\
The raw counts are sent and recorded as they are, so a tare loses nothing and can be taken back.

Examples:
  palpate device tare                  the strain now is the zero
  palpate device tare --undo           as calibrated
  palpate device tare --save           keep it over a loss of power")]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// Take the tare back
    #[arg(long)]
    undo: bool,
    /// Keep it over a loss of power
    #[arg(long)]
    save: bool,
    /// Print one JSON object instead of a line
    #[arg(long)]
    json: bool,
}

/// Tares and prints what is taken as zero.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (_, mut session) = args.at.open()?;
    if args.undo {
        session.quiet().and_then(|()| session.command(&ToDevice::Untare)).map_err(failed)?;
    } else {
        measure::tare(&mut session).map_err(failed)?;
    }
    if args.save {
        session.command(&ToDevice::Save).map_err(failed)?;
    }
    // The settings after the change have been heard before the status.
    session.status().map_err(failed)?;
    let answer = TareAnswer::of(session.settings().1, args.save);
    if args.json {
        return print_json(&answers::json(&answer));
    }
    let [a, b, c, d] = answer.tare_ustrain;
    print(&format!("zero is now at {a:.1}, {b:.1}, {c:.1}, {d:.1} µε\n"))
}
