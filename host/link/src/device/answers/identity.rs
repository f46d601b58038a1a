//! `palpate device info`: who a device is.

use std::path::Path;

use serde::Serialize;
use shared::wire::{Settings, Status};

use super::{SettingsAnswer, StatusAnswer};
use crate::device::describe::{clock_in_words, kept_in_words, reset_in_words};
use crate::device::heard::Identity;

/// Who a device is, its settings, and what it lost.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DeviceAnswer {
    /// Version of this answer.
    pub palpate_device: u32,
    /// Serial port of the device.
    pub port: String,
    /// Who it is.
    pub device: IdentityAnswer,
    /// Its settings.
    pub settings: SettingsAnswer,
    /// Number of the settings, which grows by one with every change; rows carry it.
    pub generation: u32,
    /// How it is.
    pub status: StatusAnswer,
}

/// Who a device is.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct IdentityAnswer {
    /// The board; `simulated` for a device without hardware.
    pub board: String,
    /// Version of the firmware.
    pub version: String,
    /// Git state the firmware was made from: a short hash, and `+` where something was not committed; empty where unknown.
    pub git: String,
    /// Serial number, 24 hexadecimal digits.
    pub serial: String,
    /// Number of gauges.
    pub channels: u8,
    /// The converter, by the name of its part.
    pub converter: String,
    /// Clock of the converter, Hz.
    pub converter_clock_hz: u32,
    /// Sample rates that can be set, Hz.
    pub rates_hz: Vec<f64>,
    /// What the processor's clock comes from, in words.
    pub clock: &'static str,
    /// Reset cause, in words.
    pub reset: &'static str,
    /// What the last panic said; empty without one.
    pub panic: String,
    /// What a user must know of the settings that were kept, in words; null where all is as it was saved.
    pub settings: Option<&'static str>,
}

impl DeviceAnswer {
    /// Of the device on a port, whose settings have this generation.
    #[must_use]
    pub fn of(
        port: &Path,
        identity: &Identity,
        (generation, settings): (u32, &Settings),
        status: &Status,
    ) -> Self {
        Self {
            palpate_device: 1,
            port: port.display().to_string(),
            device: identity.into(),
            settings: SettingsAnswer::of(settings),
            generation,
            status: status.into(),
        }
    }
}

impl From<&Identity> for IdentityAnswer {
    fn from(identity: &Identity) -> Self {
        Self {
            board: identity.board.clone(),
            version: identity.version.clone(),
            git: identity.git.clone(),
            serial: identity.serial_number(),
            channels: identity.channels,
            converter: identity.converter.clone(),
            converter_clock_hz: identity.converter_clock_hz,
            rates_hz: identity.capabilities.intervals_ns().map(|ns| 1e9 / f64::from(ns)).collect(),
            clock: clock_in_words(identity.clock),
            reset: reset_in_words(identity.reset),
            panic: identity.panic.clone(),
            settings: identity.kept.and_then(kept_in_words),
        }
    }
}
