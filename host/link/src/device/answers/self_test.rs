//! `palpate device self-test`: what the device's test of itself found.

use serde::Serialize;
use shared::pipeline::GAUGES;
use shared::wire::Settings;

use crate::device::self_test::{Check, Own, Tested, checks, faults, noise};

/// What a device's test of itself found.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SelfTestAnswer {
    /// Whether nothing is wrong.
    pub passed: bool,
    /// What is wrong, one sentence each; empty where nothing is.
    pub faults: Vec<String>,
    /// Number of samples that were taken.
    pub samples: u16,
    /// Measured sample rate over the one that is set; 0 where too few samples came.
    pub rate_ratio: f32,
    /// Mean of each gauge, counts of the converter.
    pub mean_counts: [i32; GAUGES],
    /// Standard deviation of the noise of each gauge, counts of the converter.
    pub noise_counts: [f32; GAUGES],
    /// What the converter found of itself; absent where it cannot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub converter: Option<OwnAnswer>,
}

/// What a converter found of itself, its gauges disconnected.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct OwnAnswer {
    /// Mean of each gauge with its inputs joined, counts of the converter.
    pub offset_counts: [i32; GAUGES],
    /// Standard deviation of the noise of each gauge with its inputs joined, counts of the converter.
    pub noise_counts: [f32; GAUGES],
    /// The converter's own test signal over what it should be, of the gauge where it is furthest off.
    pub test_signal_ratio: f64,
}

/// The same with every check and the noise as strain, as the page reads it.
#[derive(Clone, Debug, Serialize)]
pub struct SelfTestInFull {
    /// What was found.
    #[serde(flatten)]
    pub found: SelfTestAnswer,
    /// Everything that was tested.
    pub checks: Vec<CheckAnswer>,
    /// Standard deviation of the noise of each gauge, µε.
    pub noise_ustrain: Vec<f64>,
}

/// One thing that was tested.
#[derive(Clone, Debug, Serialize)]
pub struct CheckAnswer {
    /// What was tested.
    pub name: String,
    /// What was measured, with its unit.
    pub measured: String,
    /// Within which limits it must be.
    pub limits: String,
    /// Whether it is.
    pub passed: bool,
    /// What is wrong; null where it passed.
    pub fault: Option<String>,
}

impl From<&Own> for OwnAnswer {
    fn from(own: &Own) -> Self {
        Self {
            offset_counts: own.shorted.mean_counts.0,
            noise_counts: own.shorted.noise_counts.0,
            test_signal_ratio: own.signal_ratio(),
        }
    }
}

impl From<&Tested> for SelfTestAnswer {
    fn from(tested: &Tested) -> Self {
        let (faults, test) = (faults(tested), &tested.gauges);
        Self {
            passed: faults.is_empty(),
            faults,
            samples: test.samples,
            rate_ratio: test.rate_ratio,
            mean_counts: test.mean_counts.0,
            noise_counts: test.noise_counts.0,
            converter: tested.own.as_ref().map(OwnAnswer::from),
        }
    }
}

impl SelfTestInFull {
    /// Of a test with these settings.
    #[must_use]
    pub fn of(tested: &Tested, settings: &Settings) -> Self {
        Self {
            found: tested.into(),
            checks: checks(tested).into_iter().map(CheckAnswer::from).collect(),
            noise_ustrain: noise(tested, settings),
        }
    }
}

impl From<Check> for CheckAnswer {
    fn from(Check { name, measured, limits, fault }: Check) -> Self {
        Self { name, measured, limits, passed: fault.is_none(), fault }
    }
}
