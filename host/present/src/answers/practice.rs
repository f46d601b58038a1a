//! `palpate hide`: a practice data set, one more recording of it, and its truth.

use std::collections::BTreeMap;
use std::path::Path;

use palpate_diagnose::practice::{Practice, SEALED, Truth};
use palpate_model::{StoredEffect, StoredParameter};
use palpate_trace::Trace;
use serde::Serialize;

/// A practice set that was made; nothing of its truth.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PracticeAnswer {
    /// Version of this answer.
    pub palpate_practice: u32,
    /// The folder it is in.
    pub folder: String,
    /// Seed it was made from.
    pub seed: u64,
    /// Misfit that each hidden effect alone was to leave, over the noise.
    pub size: f64,
    /// Names of the traces.
    pub traces: Vec<String>,
    /// Name of the file with the sealed truth.
    pub truth: &'static str,
}

/// One more recording of the specimen of a practice set.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PracticeRecording {
    /// The file of the recording.
    pub recorded: String,
    /// How long it lasts, s.
    pub duration_s: f64,
}

/// What is hidden in a practice set.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct TruthAnswer {
    /// Version of this answer.
    pub palpate_truth: u32,
    /// Seed the set was made from.
    pub seed: u64,
    /// Misfit that each hidden effect alone was to leave, over the noise.
    pub size: f64,
    /// Misfit that all of them leave after the base law is refitted, over the noise.
    pub misfit_over_noise: f64,
    /// Standard deviation of the noise, N.
    pub noise_rms: f64,
    /// Correlation of the noise from sample to sample, −1 to 1.
    pub noise_correlation: f64,
    /// The hidden effects.
    pub effects: Vec<HiddenEffect>,
}

/// A hidden effect.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct HiddenEffect {
    /// Name of the effect.
    pub effect: String,
    /// Name of its law; null for the reference form.
    pub law: Option<String>,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, HiddenValue>,
}

/// The true value of a parameter.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct HiddenValue {
    /// The value, in `unit`.
    pub value: f64,
    /// Unit, empty for a pure number.
    pub unit: String,
}

impl PracticeAnswer {
    /// A practice set in a folder.
    #[must_use]
    pub fn of(practice: &Practice, folder: &str) -> Self {
        Self {
            palpate_practice: 1,
            folder: folder.to_owned(),
            seed: practice.truth.seed,
            size: practice.truth.size,
            traces: practice.traces.iter().map(Trace::label).collect(),
            truth: SEALED,
        }
    }
}

impl PracticeRecording {
    /// A recording in a file.
    #[must_use]
    pub fn of(trace: &Trace, file: &Path) -> Self {
        Self { recorded: file.display().to_string(), duration_s: trace.duration() }
    }
}

impl From<&Truth> for TruthAnswer {
    fn from(truth: &Truth) -> Self {
        Self {
            palpate_truth: 1,
            seed: truth.seed,
            size: truth.size,
            misfit_over_noise: truth.misfit_over_noise,
            noise_rms: truth.noise_rms,
            noise_correlation: truth.noise_correlation,
            effects: truth.model.effects.iter().map(HiddenEffect::from).collect(),
        }
    }
}

impl From<&StoredEffect> for HiddenEffect {
    fn from(effect: &StoredEffect) -> Self {
        let value = |(name, stored): (&String, &StoredParameter)| {
            (name.clone(), HiddenValue { value: stored.value, unit: stored.unit.clone() })
        };
        Self {
            effect: effect.name.clone(),
            law: effect.law.clone(),
            parameters: effect.parameters.iter().map(value).collect(),
        }
    }
}
