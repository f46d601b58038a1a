//! `palpate device list`: which ports have a device.

use serde::Serialize;

use super::IdentityAnswer;
use crate::device::discover::Found;

/// The ports that were asked.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PortsAnswer {
    /// Version of this answer.
    pub palpate_devices: u32,
    /// Every port that was asked, with what answered there.
    pub ports: Vec<PortAnswer>,
}

/// A port, and who is there.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PortAnswer {
    /// The port.
    pub port: String,
    /// The device that answered; null where none did.
    pub device: Option<IdentityAnswer>,
    /// Why no device answered; null where one did.
    pub error: Option<String>,
}

impl From<&[Found]> for PortsAnswer {
    fn from(found: &[Found]) -> Self {
        Self { palpate_devices: 1, ports: found.iter().map(PortAnswer::from).collect() }
    }
}

impl From<&Found> for PortAnswer {
    fn from(found: &Found) -> Self {
        Self {
            port: found.port.display().to_string(),
            device: found.answer.as_ref().ok().map(IdentityAnswer::from),
            error: found.answer.as_ref().err().map(ToString::to_string),
        }
    }
}
