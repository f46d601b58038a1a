//! What a rig may do.

use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use palpate_model::effects::Scales;

/// Limits of a rig; those that its file does not give are what the recordings at hand did, and a minute.
///
/// ```toml
/// displacement_mm = 12.0
/// off_mm = 0.5
/// speed_mm_per_s = 60.0
/// acceleration_mm_per_s2 = 800.0
/// signal = 10.0                  # in the unit of the signal
/// time_s = 30.0
/// rate_hz = 200.0
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RigFile {
    /// Largest compression, mm.
    pub displacement_mm: Option<f64>,
    /// How far off the specimen it goes back at most, mm.
    pub off_mm: Option<f64>,
    /// Largest speed, mm/s.
    pub speed_mm_per_s: Option<f64>,
    /// Largest acceleration, mm/s².
    pub acceleration_mm_per_s2: Option<f64>,
    /// Largest size of the signal that any model may foresee, in its unit.
    pub signal: Option<f64>,
    /// Longest recording, s.
    pub time_s: Option<f64>,
    /// Samples per second.
    pub rate_hz: Option<f64>,
}

/// Limits of a rig, complete.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rig {
    /// Largest compression, mm.
    pub displacement_mm: f64,
    /// How far off the specimen it goes back at most, mm.
    pub off_mm: f64,
    /// Largest speed, mm/s.
    pub speed_mm_per_s: f64,
    /// Largest acceleration, mm/s²; none where the recordings show none.
    pub acceleration_mm_per_s2: Option<f64>,
    /// Largest size of the signal, in its unit.
    pub signal: f64,
    /// Longest recording, s.
    pub time_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

/// Why a file with the limits of a rig cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum RigError {
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: io::Error },
    #[error("{path}: not the limits of a rig: {source}")]
    Toml { path: PathBuf, source: Box<toml::de::Error> },
    #[error("{path}: `{name}` is {value}; it must be above zero")]
    NotPositive { path: PathBuf, name: &'static str, value: f64 },
    #[error("{path}: {samples:.0} samples in `time_s` at `rate_hz`; at most {MOST_SAMPLES}")]
    TooLong { path: PathBuf, samples: f64 },
}

/// Most samples of a motion that is proposed.
const MOST_SAMPLES: usize = 200_000;
/// A recording may last at least so long where its length is not limited, s: time wears no rig out.
const LEAST_TIME_S: f64 = 60.0;
/// What a signal may exceed the largest one recorded by, so that noise does not forbid a motion that was made before.
const ROOM: f64 = 1.05;

impl RigFile {
    /// Reads the limits of a rig.
    ///
    /// # Errors
    /// When the file cannot be read, has a key that is none of a rig's, or a limit that is not above zero.
    pub fn read(path: &Path) -> Result<Self, RigError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| RigError::Io { path: path.into(), source })?;
        let limits: Self = toml::from_str(&text)
            .map_err(|source| RigError::Toml { path: path.into(), source: Box::new(source) })?;
        for (name, value) in limits.named() {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(RigError::NotPositive { path: path.into(), name, value });
            }
        }
        match limits.time_s.zip(limits.rate_hz).map(|(time, rate)| time * rate) {
            Some(samples) if samples > MOST_SAMPLES as f64 => {
                Err(RigError::TooLong { path: path.into(), samples })
            }
            _ => Ok(limits),
        }
    }

    fn named(&self) -> [(&'static str, Option<f64>); 7] {
        [
            ("displacement_mm", self.displacement_mm),
            ("off_mm", self.off_mm),
            ("speed_mm_per_s", self.speed_mm_per_s),
            ("acceleration_mm_per_s2", self.acceleration_mm_per_s2),
            ("signal", self.signal),
            ("time_s", self.time_s),
            ("rate_hz", self.rate_hz),
        ]
    }

    /// The limits, with what the recordings did where the file says nothing.
    #[must_use]
    pub fn beside(&self, scales: &Scales) -> Rig {
        let interval = scales.common_interval.max(scales.interval);
        let acceleration = Some(scales.acceleration).filter(|it| it.is_finite() && *it > 0.0);
        let time_s = self.time_s.unwrap_or(rounded(scales.duration).max(LEAST_TIME_S));
        let rate_hz = self.rate_hz.unwrap_or(rounded(1.0 / interval));
        Rig {
            displacement_mm: self.displacement_mm.unwrap_or(scales.compression),
            off_mm: self.off_mm.unwrap_or(scales.parting),
            speed_mm_per_s: self.speed_mm_per_s.unwrap_or(rounded(scales.speed)),
            acceleration_mm_per_s2: self.acceleration_mm_per_s2.or(acceleration.map(rounded)),
            signal: self.signal.unwrap_or(rounded(ROOM * scales.force)),
            time_s,
            rate_hz: rate_hz.min(MOST_SAMPLES as f64 / time_s),
        }
    }
}

/// To five significant digits: what comes from differences of samples has no more.
fn rounded(value: f64) -> f64 {
    let step = 10.0_f64.powi(value.abs().log10().floor() as i32 - 4);
    let rounded = (value / step).round() * step;
    if rounded.is_finite() { rounded } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_file_does_not_say_is_what_the_recordings_did() {
        let scales = Scales {
            compression: 8.0,
            parting: 0.4,
            speed: 20.0,
            acceleration: 700.0,
            force: 2.0,
            duration: 9.0,
            interval: 0.005,
            common_interval: 0.005,
            ..Scales::default()
        };
        let rig = RigFile { speed_mm_per_s: Some(5.0), ..RigFile::default() }.beside(&scales);
        assert_eq!((rig.displacement_mm, rig.off_mm, rig.speed_mm_per_s), (8.0, 0.4, 5.0));
        assert_eq!((rig.time_s, rig.rate_hz, rig.signal), (60.0, 200.0, 2.1));
    }

    #[test]
    fn a_limit_that_is_none_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        for (text, words) in [
            ("speed_mm_per_s = 0.0", "`speed_mm_per_s` is 0"),
            ("speed = 3.0", "unknown field `speed`"),
            ("time_s = 1e6\nrate_hz = 1000.0", "at most 200000"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = RigFile::read(&path).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
