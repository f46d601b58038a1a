//! From a displacement to a stretch: the gauge length of the specimen, and how it is deformed.

use serde::{Deserialize, Serialize};

use palpate_trace::Trace;

/// How the specimen is deformed by a displacement above zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Deformation {
    /// Pressed together: λ = 1 − x/L. So where a head does not say otherwise.
    Compression,
    /// Pulled: λ = 1 + x/L.
    Tension,
    /// Sheared: γ = x/L.
    Shear,
}

impl Deformation {
    /// Every deformation.
    pub const ALL: [Self; 3] = [Self::Compression, Self::Tension, Self::Shear];

    /// Name in model files, and the word by which `mode` in the head of a trace says it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Compression => "compression",
            Self::Tension => "tension",
            Self::Shear => "shear",
        }
    }
}

/// Gauge length and deformation of a specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gauge {
    /// Length L along which it is deformed, mm: between the grips, or in shear the thickness.
    pub length_mm: f64,
    /// How it is deformed.
    pub deformation: Deformation,
}

/// Why a displacement is no stretch.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum GaugeError {
    #[error(
        "{0}: a law of the stretch needs the gauge length, and the head has no height_mm in [specimen]: write there the length between the grips (in compression the height, in shear the thickness), mm"
    )]
    NoLength(String),
    #[error(
        "{trace}: the head says mode = \"{mode}\", which is neither compression, tension nor shear: say which"
    )]
    Mode { trace: String, mode: String },
    #[error(
        "{trace} has a gauge length of {length} mm in {deformation}, and {other} one of {other_length} mm in {other_deformation}: one law of the stretch is for one specimen in one set-up"
    )]
    Differs {
        trace: String,
        length: f64,
        deformation: &'static str,
        other: String,
        other_length: f64,
        other_deformation: &'static str,
    },
    #[error("{trace}: a specimen {length} mm high cannot be pressed together by {most} mm")]
    Crushed { trace: String, length: f64, most: f64 },
}

/// Gauge lengths closer than this, relatively, are the same.
const SAME_LENGTH: f64 = 1e-3;

impl Gauge {
    /// That of a data set, as the heads of its traces say: `height_mm`, and `mode`, which names the
    /// deformation (compression where it is absent).
    ///
    /// # Errors
    /// When a head does not say it, when traces differ, or when a specimen would be crushed.
    pub fn of(traces: &[Trace]) -> Result<Self, GaugeError> {
        let first = traces.first().ok_or_else(|| GaugeError::NoLength("no trace".into()))?;
        let gauge = Self::of_trace(first)?;
        gauge.check(&first.label(), traces)?;
        Ok(gauge)
    }

    /// Whether these traces are of a specimen of this gauge; `owner` is what has it.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn check(&self, owner: &str, traces: &[Trace]) -> Result<(), GaugeError> {
        for trace in traces {
            let own = Self::of_trace(trace)?;
            let apart = (own.length_mm / self.length_mm - 1.0).abs() > SAME_LENGTH;
            if apart || own.deformation != self.deformation {
                return Err(GaugeError::Differs {
                    trace: trace.label(),
                    length: own.length_mm,
                    deformation: own.deformation.name(),
                    other: owner.into(),
                    other_length: self.length_mm,
                    other_deformation: self.deformation.name(),
                });
            }
            let most = trace.displacement().unwrap_or_default().iter().copied().fold(0.0, f64::max);
            if own.deformation == Deformation::Compression && most >= own.length_mm {
                let (trace, length) = (trace.label(), own.length_mm);
                return Err(GaugeError::Crushed { trace, length, most });
            }
        }
        Ok(())
    }

    fn of_trace(trace: &Trace) -> Result<Self, GaugeError> {
        let length_mm =
            trace.head.specimen.height_mm.ok_or_else(|| GaugeError::NoLength(trace.label()))?;
        let deformation = match trace.head.setup.other.get("mode").and_then(toml::Value::as_str) {
            None => Deformation::Compression,
            Some(mode) => named(mode)
                .ok_or_else(|| GaugeError::Mode { trace: trace.label(), mode: mode.into() })?,
        };
        Ok(Self { length_mm, deformation })
    }
}

/// The deformation whose name comes first in these words.
fn named(mode: &str) -> Option<Deformation> {
    let mode = mode.to_lowercase();
    let place = |one: &Deformation| mode.find(one.name());
    Deformation::ALL.into_iter().filter(|one| place(one).is_some()).min_by_key(|one| place(one))
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::DISPLACEMENT;

    fn trace(length: Option<f64>, mode: Option<&str>, most: f64) -> Trace {
        let mut trace = Trace { time: vec![0.0, 1.0], ..Trace::default() };
        trace.set_column(DISPLACEMENT, vec![0.0, most]);
        trace.head.specimen.height_mm = length;
        if let Some(mode) = mode {
            trace.head.setup.other.insert("mode".into(), mode.into());
        }
        trace
    }

    #[test]
    fn the_head_says_length_and_deformation() {
        for (mode, deformation) in [
            (None, Deformation::Compression),
            (Some("tension: extension and pull are positive"), Deformation::Tension),
            (Some("Simple shear: not compression"), Deformation::Shear),
        ] {
            let gauge = Gauge::of(&[trace(Some(33.0), mode, 10.0)]).unwrap();
            assert_eq!(gauge, Gauge { length_mm: 33.0, deformation });
        }
    }

    #[test]
    fn what_is_missing_or_cannot_be_is_said() {
        let refusal = |traces: &[Trace]| Gauge::of(traces).unwrap_err().to_string();
        assert!(refusal(&[trace(None, None, 1.0)]).contains("no height_mm"));
        assert!(refusal(&[trace(Some(3.0), Some("torsion"), 1.0)]).contains("torsion"));
        assert!(refusal(&[trace(Some(3.0), None, 3.0)]).contains("cannot be pressed"));
        let two = [trace(Some(3.0), None, 1.0), trace(Some(4.0), None, 1.0)];
        assert!(refusal(&two).contains("one specimen"));
    }
}
