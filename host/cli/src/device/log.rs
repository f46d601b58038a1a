//! `palpate device log`.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use miette::miette;

use super::{At, failed};
use crate::Failure;
use crate::output::print;
use palpate_link::device::heard::Said;
use palpate_link::device::log::{Line, Words};

/// Without more for so long, the log that waited has been heard.
const PAUSE: Duration = Duration::from_millis(700);

/// Print the device's log.
#[derive(clap::Args)]
#[command(after_help = "\
The device sends numbers; the words are in the ELF file of its firmware. `cargo xtask firmware`
writes it beside the binary; take that of the version which `palpate device info` shows.

Examples:
  palpate device log --elf palpate.elf            what waits, then ends
  palpate device log --elf palpate.elf --follow   until Ctrl-C")]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// ELF file of the firmware that runs on the device
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// Go on until Ctrl-C
    #[arg(long)]
    follow: bool,
    /// Take the ELF file even if it is not that of this firmware
    #[arg(long)]
    force: bool,
}

/// Prints the log line by line.
pub fn run(args: &Args) -> Result<(), Failure> {
    let Some(elf) = &args.elf else {
        return Err(Failure::Input(miette!(
            "the words of the log are in the firmware's ELF file: name it with --elf. `cargo xtask firmware` writes it \
             beside the binary"
        )));
    };
    let (_, mut session) = args.at.open()?;
    let git = if args.force { "" } else { session.identity().git.as_str() };
    let words = Words::read(elf, git).map_err(Failure::input)?;
    let mut stream = words.stream();
    let mut malformed = false;
    let mut last = Instant::now();
    while args.follow || last.elapsed() < PAUSE {
        let heard = session.hear(Instant::now() + PAUSE).map_err(failed)?;
        let Some(Ok((_, Said::Log(piece)))) = heard.map(|heard| heard.said) else { continue };
        last = Instant::now();
        for line in stream.take(&piece) {
            match line {
                Line::Words(words) => print(&format!("{words}\n"))?,
                Line::Malformed if !malformed => {
                    malformed = true;
                    eprintln!(
                        "! a part of the log has no meaning in this ELF file; is it of another build?"
                    );
                }
                Line::Malformed => {}
            }
        }
    }
    Ok(())
}
