//! The TOML head of a trace.

use serde::{Deserialize, Serialize};

/// Major version of the trace format this program reads and writes.
pub const VERSION: i64 = 1;

/// What a trace's head says; every key is optional and unknown keys are passed through.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// Major version of the trace format.
    #[serde(rename = "palpate-trace", skip_serializing_if = "Option::is_none")]
    pub version: Option<i64>,
    /// Name of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Which quantity the machine controlled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control: Option<Control>,
    /// What was pressed.
    #[serde(default, skip_serializing_if = "Specimen::is_empty")]
    pub specimen: Specimen,
    /// What pressed and measured.
    #[serde(default, skip_serializing_if = "Setup::is_empty")]
    pub setup: Setup,
    /// Keys this version does not know.
    #[serde(flatten)]
    pub other: toml::Table,
}

/// Which quantity the machine controlled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Control {
    /// Displacement followed a programme, force answered.
    Displacement,
    /// Force followed a programme, displacement answered.
    Force,
}

/// Shape of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Pressed along its axis; `radius_mm`, `height_mm`.
    Cylinder,
    /// `length_mm`, `width_mm`, `height_mm`.
    Block,
    /// `radius_mm`.
    Sphere,
}

/// What was pressed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Specimen {
    /// Free text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Shape, which says which sizes apply.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Radius, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Height, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
    /// Length, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Width, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_mm: Option<f64>,
    /// Poisson's ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poisson_ratio: Option<f64>,
    /// Keys this version does not know.
    #[serde(flatten)]
    pub other: toml::Table,
}

impl Specimen {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// What pressed and measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// Mass that moves with the force sensor, g.
    #[serde(skip_serializing_if = "Option::is_none", rename = "moving_mass_g")]
    pub moving_mass_g: Option<f64>,
    /// Smallest step of the force channel, N.
    #[serde(skip_serializing_if = "Option::is_none", rename = "force_resolution_N")]
    pub force_resolution_n: Option<f64>,
    /// Order of recording within the data set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sequence: Option<i64>,
    /// Time of the first sample since the data set began, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_s: Option<f64>,
    /// Keys this version does not know.
    #[serde(flatten)]
    pub other: toml::Table,
}

impl Setup {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
