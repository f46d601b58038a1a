//! `palpate diagnose --next`: the next experiment as a motion.

use std::path::Path;

use palpate_diagnose::criticism::next_motion::{Informing, Precision, Proposed, Rig, SEED};
use serde::Serialize;

use super::finite;

/// The motion that best tells effects apart, or after which wanted parameters are known best.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct NextMotionAnswer {
    /// The file of the motion; null where none is proposed.
    pub file: Option<String>,
    /// The effects that it is to distinguish; empty where parameters are wanted.
    pub tells_apart: Vec<String>,
    /// The parameters that are to be known better; empty where effects are to be distinguished.
    pub informs: Vec<InformedParameter>,
    /// Least predicted misfit between two of them, in sums of squares over the noise; null where no motion is proposed.
    pub separates: Option<f64>,
    /// The same on the best motion of the menu; null where no motion is proposed, or none of the menu lies within the limits.
    pub separates_of_menu: Option<f64>,
    /// Number of pairs of effects; null where no motion is proposed or parameters are wanted.
    pub pairs: Option<usize>,
    /// Number of pairs that it distinguishes beyond the noise; null where no motion is proposed.
    pub pairs_told: Option<usize>,
    /// How long it lasts, s; null where no motion is proposed.
    pub duration_s: Option<f64>,
    /// Number of motions that were weighed; null where no motion is proposed.
    pub weighed: Option<usize>,
    /// Seed of the search.
    pub seed: u64,
    /// The limits of the rig.
    pub rig: RigAnswer,
}

/// How well a wanted parameter is known, and will be.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct InformedParameter {
    /// Its name, with the effect that it is of.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Its standard error from these traces; null where they do not determine it.
    pub standard_error: Option<f64>,
    /// The standard error that is foreseen with the motion recorded too; null where it would still not be determined.
    pub standard_error_then: Option<f64>,
    /// The same with the best motion of the menu; null also where none of the menu lies within the limits.
    pub standard_error_of_menu: Option<f64>,
}

/// Limits of a rig.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RigAnswer {
    /// Largest compression, mm.
    pub displacement_mm: f64,
    /// How far off the specimen it goes back at most, mm.
    pub off_mm: f64,
    /// Largest speed, mm/s.
    pub speed_mm_per_s: f64,
    /// Largest acceleration, mm/s²; null where none is given and the recordings show none.
    pub acceleration_mm_per_s2: Option<f64>,
    /// Largest size of the signal, in its unit.
    pub signal: f64,
    /// Longest recording, s.
    pub time_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

impl NextMotionAnswer {
    /// A proposal and the file that its motion is in.
    #[must_use]
    pub fn of(proposed: &Proposed, path: &Path) -> Self {
        let motion = proposed.motion.as_ref();
        let of_menu = motion.and_then(|it| it.of_menu.as_ref());
        Self {
            file: motion.map(|_| path.display().to_string()),
            tells_apart: proposed.members.clone(),
            informs: Vec::new(),
            separates: motion.and_then(|it| finite(it.foreseen.separates())),
            separates_of_menu: of_menu.and_then(|menu| finite(menu.separates())),
            pairs: motion.map(|it| it.foreseen.apart.len()),
            pairs_told: motion.map(|it| it.foreseen.told()),
            duration_s: motion.map(|it| it.trace.duration()),
            weighed: motion.map(|it| it.weighed),
            seed: SEED,
            rig: proposed.rig.into(),
        }
    }

    /// A motion for wanted parameters and its file.
    #[must_use]
    pub fn informing(found: &Informing, path: &Path) -> Self {
        Self {
            file: Some(path.display().to_string()),
            tells_apart: Vec::new(),
            informs: found.parameters.iter().map(InformedParameter::from).collect(),
            separates: None,
            separates_of_menu: None,
            pairs: None,
            pairs_told: None,
            duration_s: Some(found.trace.duration()),
            weighed: Some(found.weighed),
            seed: SEED,
            rig: found.rig.into(),
        }
    }
}

impl From<&Precision> for InformedParameter {
    fn from(found: &Precision) -> Self {
        Self {
            name: found.name.clone(),
            unit: found.unit.clone(),
            value: found.value,
            standard_error: found.now.and_then(finite),
            standard_error_then: found.then.and_then(finite),
            standard_error_of_menu: found.of_menu.and_then(finite),
        }
    }
}

impl From<Rig> for RigAnswer {
    fn from(rig: Rig) -> Self {
        let Rig {
            displacement_mm,
            off_mm,
            speed_mm_per_s,
            acceleration_mm_per_s2,
            signal,
            time_s,
            rate_hz,
        } = rig;
        Self {
            displacement_mm,
            off_mm,
            speed_mm_per_s,
            acceleration_mm_per_s2,
            signal,
            time_s,
            rate_hz,
        }
    }
}
