//! What any device must do, simulated, emulated or real: each check takes the path of its serial port and says in figures
//! what it saw.

#[cfg(unix)]
mod flood;
#[cfg(unix)]
mod foreign;
mod handshake;
#[cfg(unix)]
mod noise;
mod recordings;
mod restart;
mod steady;

#[cfg(unix)]
pub use flood::check_flooding;
#[cfg(unix)]
pub use foreign::{Foreign, check_foreign_device_is_refused};
pub use handshake::{check_handshake, check_wrong_schema_is_refused};
#[cfg(unix)]
pub use noise::{Noise, NoisyLine, check_noisy_line};
pub use recordings::{check_every_recording, check_recording};
pub use restart::check_restart_while_recording;
pub use steady::check_steady_stream;

use std::error::Error;
use std::fmt;
use std::path::Path;
use std::time::Duration;

use palpate::device::session::Session;

/// A device may take so long to answer; an emulated one is slow.
const PATIENCE: Duration = Duration::from_secs(5);

/// What a check saw.
pub type Checked = Result<Report, Box<dyn Error + Send + Sync>>;

/// A check that passed, and its figures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// What was checked.
    pub check: &'static str,
    /// What was seen, by name.
    pub figures: Vec<(&'static str, String)>,
}

impl Report {
    fn new(check: &'static str) -> Self {
        Self { check, figures: Vec::new() }
    }

    fn with(mut self, name: &'static str, figure: impl fmt::Display) -> Self {
        self.figures.push((name, figure.to_string()));
        self
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let figures = self.figures.iter().map(|(name, figure)| format!("{figure} {name}"));
        write!(f, "{}: {}", self.check, figures.collect::<Vec<_>>().join(", "))
    }
}

/// Fails a check with words unless `held`.
fn require(held: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if held { Ok(()) } else { Err(otherwise()) }
}

fn open(port: &Path) -> Result<Session, Box<dyn Error + Send + Sync>> {
    Session::open(port, PATIENCE).map_err(|error| format!("{}: {error}", port.display()).into())
}
