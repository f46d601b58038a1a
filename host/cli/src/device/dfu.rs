//! `palpate device dfu`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use miette::miette;
use shared::wire::ToDevice;

use super::{At, failed};
use crate::Failure;
use crate::output::print;
use palpate_link::device::discover::DiscoverError;
use palpate_link::device::session::{LinkError, Session, command_of_core};

/// The port should be gone after so long.
const PORT_GONE_WITHIN: Duration = Duration::from_secs(3);
/// The loader appears on USB in so long.
const LOADER: Duration = Duration::from_secs(2);

/// Begin the loader in ROM, to write new firmware without a probe.
#[derive(clap::Args)]
#[command(after_help = "\
The loader of the STM32F405 speaks DFU over USB; the program `dfu-util` writes to it. `cargo xtask
firmware` makes the .bin file.

Examples:
  palpate device dfu                       begins the loader and prints the command to go on with
  palpate device dfu --flash palpate.bin   begins the loader and runs it")]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// Write this firmware
    #[arg(long, value_name = "FILE.bin")]
    flash: Option<PathBuf>,
}

/// Begins the loader, and writes or says how.
pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(file) = &args.flash {
        // Before the device stops being one.
        check(file)?;
    }
    let (port, gone) = match args.at.choose() {
        Ok((port, session)) => (port, begin(session)?),
        // Firmware of any release takes this command.
        Err(DiscoverError::Named { port, source: LinkError::Schema { .. } }) => {
            match command_of_core(&port, &ToDevice::Bootloader) {
                Ok(()) | Err(LinkError::Line(_)) => (port, true),
                Err(error) => return Err(failed(error)),
            }
        }
        Err(error) => return Err(Failure::input(error)),
    };
    if gone {
        eprintln!("the device began its loader; {} is gone", port.display());
    } else {
        eprintln!("the device began its loader; connect its USB socket if it is not");
    }
    let file = args.flash.as_deref().unwrap_or(Path::new("palpate.bin"));
    match &args.flash {
        None => print(&format!("dfu-util {}\n", words(file).join(" "))),
        Some(_) => flash(file),
    }
}

/// Begins the loader; whether the port went away.
fn begin(mut session: Session) -> Result<bool, Failure> {
    match session.command(&ToDevice::Bootloader) {
        Ok(_) => Ok(vanished(session)),
        // Its answer can be lost with the port.
        Err(LinkError::Line(_)) => Ok(true),
        Err(error) => Err(failed(error)),
    }
}

fn words(file: &Path) -> [String; 6] {
    let file = file.display().to_string();
    ["-a", "0", "-s", "0x08000000:leave", "-D", &file].map(String::from)
}

fn check(file: &Path) -> Result<(), Failure> {
    let size = std::fs::metadata(file)
        .map_err(|error| Failure::Input(miette!("{} cannot be read: {error}", file.display())))?
        .len();
    if size == 0 || size > 1 << 20 {
        return Err(Failure::Input(miette!(
            "{} has {size} bytes; the device's flash takes 1 to 1048576",
            file.display()
        )));
    }
    let found = Command::new("dfu-util").arg("--version").stdout(Stdio::null()).status();
    found.map(drop).map_err(|_| {
        Failure::Input(miette!(
            "the program `dfu-util` is not installed; most systems have a package of this name"
        ))
    })
}

/// Whether the port went away.
fn vanished(mut session: Session) -> bool {
    let until = Instant::now() + PORT_GONE_WITHIN;
    while Instant::now() < until {
        if session.hear(until).is_err() {
            return true;
        }
    }
    false
}

fn flash(file: &Path) -> Result<(), Failure> {
    std::thread::sleep(LOADER);
    let status = Command::new("dfu-util").args(words(file)).status().map_err(Failure::work)?;
    if status.success() {
        return print("written; the device begins anew\n");
    }
    Err(Failure::Work(miette!(
        "dfu-util failed ({status}); the loader still waits, so it can be tried again"
    )))
}
