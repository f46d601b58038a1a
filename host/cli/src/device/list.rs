//! `palpate device list`.

use std::path::PathBuf;

use crate::Failure;
use crate::output::{print, print_json};
use palpate_link::device::answers::PortsAnswer;
use palpate_link::device::describe::one_line;
use palpate_link::device::discover::{Found, ask, ports};
use palpate_present::answers;

/// Say which ports have a device.
#[derive(clap::Args)]
#[command(after_help = "\
Every serial port of this computer is asked who is there, first those that say on USB that they are a
fingertip's. Pseudo-terminals are none of them: name them.

Examples:
  palpate device list
  palpate device list /dev/pts/4")]
pub struct Args {
    /// More ports to ask
    #[arg(value_name = "PORT")]
    ports: Vec<PathBuf>,
    /// Print one JSON object instead of lines
    #[arg(long)]
    json: bool,
}

/// Asks and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut asked = ports();
    asked.extend(
        args.ports.iter().filter(|port| !asked.contains(port)).cloned().collect::<Vec<_>>(),
    );
    let found = ask(&asked);
    if args.json {
        return print_json(&answers::json(&PortsAnswer::from(&found[..])));
    }
    if found.is_empty() {
        return print("no serial port\n");
    }
    print(&found.iter().map(line).collect::<String>())
}

fn line(found: &Found) -> String {
    let said = found.answer.as_ref().map_or_else(|error| format!("- {error}"), one_line);
    format!("{}  {said}\n", found.port.display())
}
