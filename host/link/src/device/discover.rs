//! Which ports have a device: every port is asked.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::heard::Identity;
use super::session::{LinkError, Session};

/// A device on a port that was named may take so long to answer.
const NAMED: Duration = Duration::from_secs(2);
/// One on a port that is merely tried.
const TRIED: Duration = Duration::from_millis(600);

/// A port, and who is there.
#[derive(Debug)]
pub struct Found {
    /// The port.
    pub port: PathBuf,
    /// Who answered, or why nobody did.
    pub answer: Result<Identity, LinkError>,
}

/// Why no device was chosen.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum DiscoverError {
    #[error("{}: {source}", port.display())]
    Named { port: PathBuf, source: LinkError },
    #[error("there is no serial port; plug the device in, or name its port with --port")]
    NoPort,
    #[error("no device found; plug it in, or name its port with --port. Tried:{}", list(.0))]
    None(Vec<Found>),
    #[error("several devices found; choose one with --port:{}", list(.0))]
    Several(Vec<Found>),
}

fn list(found: &[Found]) -> String {
    let line = |found: &Found| {
        let port = found.port.display();
        match &found.answer {
            Ok(identity) => format!("\n  {port}: {} {}", identity.board, identity.serial_number()),
            Err(error) => format!("\n  {port}: {error}"),
        }
    };
    found.iter().map(line).collect()
}

/// The serial ports of this computer.
#[must_use]
pub fn ports() -> Vec<PathBuf> {
    // A system that cannot list its ports has none to offer.
    let mut ports: Vec<PathBuf> = serialport::available_ports()
        .unwrap_or_default()
        .into_iter()
        .map(|port| port.port_name)
        // There, every port has two names; this one waits for a modem.
        .filter(|name| !(cfg!(target_os = "macos") && name.starts_with("/dev/tty.")))
        .map(PathBuf::from)
        .collect();
    ports.sort();
    ports
}

/// Asks all these ports at once who is there.
#[must_use]
pub fn ask(ports: &[PathBuf]) -> Vec<Found> {
    let ask = |port: &PathBuf| Found {
        answer: Session::open(port, TRIED).map(|session| session.identity().clone()),
        port: port.clone(),
    };
    std::thread::scope(|scope| {
        let asked: Vec<_> = ports.iter().map(|port| scope.spawn(move || ask(port))).collect();
        asked.into_iter().filter_map(|thread| thread.join().ok()).collect()
    })
}

/// The device on a port, or the only one there is, and its port.
///
/// # Errors
/// [`DiscoverError`] lists what was found.
pub fn choose(port: Option<&Path>) -> Result<(PathBuf, Session), DiscoverError> {
    let port = match port {
        Some(port) => port.to_owned(),
        None => only(ask(&ports()))?,
    };
    match Session::open(&port, NAMED) {
        Ok(session) => Ok((port, session)),
        Err(source) => Err(DiscoverError::Named { port, source }),
    }
}

fn only(found: Vec<Found>) -> Result<PathBuf, DiscoverError> {
    if found.is_empty() {
        return Err(DiscoverError::NoPort);
    }
    let (devices, others): (Vec<_>, Vec<_>) =
        found.into_iter().partition(|found| found.answer.is_ok());
    match &devices[..] {
        [only] => Ok(only.port.clone()),
        [] => Err(DiscoverError::None(others)),
        _ => Err(DiscoverError::Several(devices)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::wire::{ClockSource, Counters, ResetCause};

    fn device(port: &str) -> Found {
        let identity = Identity {
            version: "1.0.0".into(),
            git: String::new(),
            board: "feather".into(),
            serial: [1, 2, 3],
            channels: 4,
            converter_clock_hz: 8_000_000,
            clock: ClockSource::Crystal,
            reset: ResetCause::PowerOn,
            panic: String::new(),
            counters: Counters::default(),
            kept: None,
        };
        Found { port: port.into(), answer: Ok(identity) }
    }

    fn silent(port: &str) -> Found {
        Found { port: port.into(), answer: Err(LinkError::Silent { damaged: 0 }) }
    }

    #[test]
    fn the_only_device_is_taken_and_none_or_several_are_listed() {
        assert_eq!(only(vec![silent("a"), device("b")]).unwrap(), PathBuf::from("b"));
        let none = only(vec![silent("/dev/a")]).unwrap_err().to_string();
        assert!(none.contains("/dev/a: nothing answers like a fingertip"), "{none}");
        let several = only(vec![device("b"), silent("a"), device("c")]).unwrap_err().to_string();
        assert!(several.ends_with(
            "\n  b: feather 000000010000000200000003\n  c: feather 000000010000000200000003"
        ));
        assert!(only(Vec::new()).unwrap_err().to_string().contains("no serial port"));
    }
}
