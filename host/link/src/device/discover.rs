//! Which ports have a device. One in its own USB socket is known by what it says there; on other ports everyone is asked.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serialport::{SerialPortInfo, SerialPortType};
use shared::wire::{USB_NAME, USB_PRODUCT, USB_VENDOR};

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

/// The serial ports of this computer, those first that say on USB that they are a fingertip's.
#[must_use]
pub fn ports() -> Vec<PathBuf> {
    let (ours, others) = ports_by_kind();
    [ours, others].concat()
}

/// Ports that say on USB that they are a fingertip's, and all others.
fn ports_by_kind() -> (Vec<PathBuf>, Vec<PathBuf>) {
    // A system that cannot list its ports has none to offer.
    let ports = serialport::available_ports().unwrap_or_default().into_iter();
    // There, every port has two names; this one waits for a modem.
    let twice = |name: &str| cfg!(target_os = "macos") && name.starts_with("/dev/tty.");
    let (ours, others) = ports.filter(|port| !twice(&port.port_name)).partition(is_ours);
    (sorted(ours), sorted(others))
}

/// Whether a port says on USB that it is a fingertip's own socket, which carries whatever is streamed.
#[must_use]
pub fn is_own_socket(port: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let (ours, _) = ports_by_kind();
    ours.iter().any(|own| real(own) == real(port))
}

fn sorted(ports: Vec<SerialPortInfo>) -> Vec<PathBuf> {
    let mut ports: Vec<_> = ports.into_iter().map(|port| PathBuf::from(port.port_name)).collect();
    ports.sort();
    ports
}

/// Whether a port says on USB that it is a fingertip's. Other serial ports may have the same two numbers, and tell their names;
/// Windows gives a name of its own.
fn is_ours(port: &SerialPortInfo) -> bool {
    let SerialPortType::UsbPort(usb) = &port.port_type else { return false };
    let is_named = usb.product.as_deref().is_none_or(|name| cfg!(windows) || name == USB_NAME);
    (usb.vid, usb.pid) == (USB_VENDOR, USB_PRODUCT) && is_named
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

/// The device on a port, or the only one there is, and its port. While one in its own USB socket answers, other ports are left alone.
///
/// # Errors
/// [`DiscoverError`] lists what was found.
pub fn choose(port: Option<&Path>) -> Result<(PathBuf, Session), DiscoverError> {
    let port = match port {
        Some(port) => port.to_owned(),
        None => only_of(ports_by_kind(), ask)?,
    };
    match Session::open(&port, NAMED) {
        Ok(session) => Ok((port, session)),
        Err(source) => Err(DiscoverError::Named { port, source }),
    }
}

fn only_of(
    (ours, others): (Vec<PathBuf>, Vec<PathBuf>),
    ask: impl Fn(&[PathBuf]) -> Vec<Found>,
) -> Result<PathBuf, DiscoverError> {
    let mut found = ask(&ours);
    if found.iter().all(|found| found.answer.is_err()) {
        found.extend(ask(&others));
    }
    only(found)
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
    use serialport::UsbPortInfo;

    fn device(port: &str) -> Found {
        let identity = Identity {
            version: "1.0.0".into(),
            board: "feather".into(),
            serial: [1, 2, 3],
            ..Identity::unknown()
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

    #[test]
    fn one_in_its_own_socket_is_known_by_vendor_product_and_name() {
        let port = |vid, pid, product: Option<&str>| {
            let usb = UsbPortInfo {
                vid,
                pid,
                serial_number: None,
                manufacturer: None,
                product: product.map(Into::into),
            };
            SerialPortInfo { port_name: "a".into(), port_type: SerialPortType::UsbPort(usb) }
        };
        assert!(is_ours(&port(USB_VENDOR, USB_PRODUCT, Some(USB_NAME))));
        assert!(is_ours(&port(USB_VENDOR, USB_PRODUCT, None)));
        assert!(!is_ours(&port(0x0403, 0x6001, Some("FT232R USB UART"))));
        assert_eq!(is_ours(&port(USB_VENDOR, USB_PRODUCT, Some("another"))), cfg!(windows));
        let unknown = SerialPortInfo { port_type: SerialPortType::Unknown, ..port(1, 2, None) };
        assert!(!is_ours(&unknown));
    }

    #[test]
    fn other_ports_are_left_alone_while_one_in_its_own_socket_answers() {
        let ports = || (vec!["usb".into()], vec!["adapter".into()]);
        let asked =
            |ports: &[PathBuf]| ports.iter().map(|it| device(it.to_str().unwrap())).collect();
        assert_eq!(only_of(ports(), asked).unwrap(), PathBuf::from("usb"));
        let but_usb = |ports: &[PathBuf]| {
            let ask = |it: &PathBuf| {
                let name = it.to_str().unwrap();
                if name == "usb" { silent(name) } else { device(name) }
            };
            ports.iter().map(ask).collect()
        };
        assert_eq!(only_of(ports(), but_usb).unwrap(), PathBuf::from("adapter"));
    }
}
