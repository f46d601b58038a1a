//! Set-up, the whole check, generated recordings and pages: `cargo xtask --help`.

mod browser;
mod check;
mod emulate;
mod firmware;
mod formats;
mod golden;
mod modelled;
mod packages;
mod python;
mod steady;
mod supply;
mod uf2;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(
    about = "Set-up, the whole check, generated recordings and pages",
    bin_name = "cargo xtask"
)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Set up what the tests need, then run format, lints, all tests and the documentation.
    Test,
    /// Build the firmware and leave palpate.elf, palpate.bin, palpate.uf2 and their sizes in target/firmware/.
    Firmware,
    /// Run the firmware on two emulated boards and hold it to everything it promises; ten minutes of stream, a thousand killed
    /// hosts.
    Emulate {
        /// Seconds of steady stream.
        #[arg(long, default_value_t = 600)]
        steady: u32,
        /// Write sizes and counts of instructions to tests/golden/firmware.txt instead of comparing them.
        #[arg(long)]
        update: bool,
    },
    /// Run the firmware on the modelled board alone.
    Model {
        /// Hosts that are killed.
        #[arg(long, default_value_t = modelled::KILLS)]
        kills: u32,
    },
    /// Show the local page in a real browser and hold it to everything it promises; an hour of stream.
    Browser {
        /// Seconds of steady stream.
        #[arg(long, default_value_t = 3_600)]
        steady: u32,
    },
    /// Run the browser, emulator and device tests again and again beside two busy loops, and print a table of the rounds.
    Steady {
        /// Rounds in a row.
        #[arg(long, default_value_t = 20)]
        rounds: u32,
        /// These tests alone [default: all three]
        #[arg(value_enum)]
        suites: Vec<steady::Suite>,
    },
    /// Take the pictures of the docs anew, in a real browser.
    Pictures,
    /// Give every parser and the device hostile bytes, and the line losses; each for so many seconds.
    Fuzz {
        /// Seconds for each target.
        #[arg(long, default_value_t = 60)]
        seconds: u32,
        /// Seed of what is tried [default: another one each time; it is printed]
        #[arg(long)]
        seed: Option<u64>,
        /// One target alone [default: all of them, and the line]
        #[arg(long)]
        target: Option<String>,
    },
    /// Let other programs' libraries write a file of each format, and read them: whole, cut off and damaged.
    Formats,
    /// Build the wheel of the Python package and test all that it installs, in an environment under target/.
    Python {
        /// Profile of the wheel that is tested.
        #[arg(long, default_value = "dev")]
        profile: String,
    },
    /// Test what the Python package does with data sets of LeRobot, on one that LeRobot 0.4 writes (fetches some 8 GB).
    Lerobot {
        /// Profile of the wheel that is tested.
        #[arg(long, default_value = "dev")]
        profile: String,
    },
    /// Build the wheel of the Python package for this platform and leave it in target/wheels/.
    Wheel,
    /// Check licences, sources, versions and known faults of all crates.
    Supply,
    /// Write the bill of materials of the program to target/palpate.cdx.json (CycloneDX).
    Sbom,
    /// Write the bundled recordings of tests/traces/ anew; the same bytes on every run.
    Traces,
    /// Write the pages of docs/effects/ anew, from the library's own declarations.
    Effects,
}

/// Writes recordings or pages anew, by a program of its own: this one is to be built at once.
fn generate(what: &str) -> miette::Result<()> {
    let call = ["run", "--quiet", "--package", "palpate-generate", "--", what];
    check::rust(what, check::workspace(), &call, &[])
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().task {
        Task::Test => check::run(),
        Task::Firmware => firmware::everything(),
        Task::Emulate { steady, update } => {
            emulate::run(steady, update).and_then(|()| modelled::run(1_000))
        }
        Task::Model { kills } => firmware::release().and_then(|_| modelled::run(kills)),
        Task::Browser { steady } => browser::run(steady),
        Task::Steady { rounds, suites } => steady::run(rounds, &suites),
        Task::Pictures => browser::pictures(),
        Task::Fuzz { seconds, seed, target } => check::fuzz(seconds, seed, target.as_deref()),
        Task::Formats => formats::run(),
        Task::Python { profile } => python::check(&profile),
        Task::Lerobot { profile } => python::lerobot(&profile),
        Task::Wheel => python::wheel(),
        Task::Supply => supply::run(),
        Task::Sbom => generate("sbom"),
        Task::Effects => generate("effects"),
        Task::Traces => generate("traces"),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            eprintln!("error: {report}");
            ExitCode::FAILURE
        }
    }
}
