//! A device's test of itself, in words: what was measured, and within which limits it must be.

use shared::wire::{SelfTest, Settings};

use super::refusal::Fault;

/// Counts beyond this fraction of full scale are those of a bridge that is open or shorted.
const NEAR_RAIL: f64 = 0.95;
/// A rate further off than this is wrong.
const RATE_TOLERANCE: f64 = 0.02;
/// Full scale of the converter, counts.
const FULL_SCALE: f64 = 8_388_608.0;

/// One thing that was tested.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// What.
    pub name: String,
    /// What was measured.
    pub measured: String,
    /// Within which limits it must be.
    pub limits: String,
    /// What is wrong; none if it passed.
    pub fault: Option<String>,
}

/// All that was tested, with what came of it.
#[must_use]
pub fn checks(test: &SelfTest) -> Vec<Check> {
    let converter = Check {
        name: "converter".into(),
        measured: format!("{} samples", test.samples),
        limits: "answers, keeps its registers and sends samples".into(),
        fault: test.converter.err().map(|fault| Fault(fault).to_string()),
    };
    let gauges = (1..).zip(test.mean_counts).map(|(gauge, mean)| {
        let size = f64::from(mean).abs() / FULL_SCALE;
        let fault = || {
            format!(
                "gauge {gauge} is at {:.0} % of full scale: its bridge is open or shorted",
                size * 100.0
            )
        };
        Check {
            name: format!("bridge of gauge {gauge}"),
            measured: format!("{:.1} % of full scale", size * 100.0),
            limits: format!("at most {:.0} %", NEAR_RAIL * 100.0),
            fault: (size > NEAR_RAIL).then(fault),
        }
    });
    let rate = (test.samples > 0).then(|| {
        let ratio = f64::from(test.rate_ratio);
        let fault = || format!("samples come at {ratio:.3} times the rate");
        Check {
            name: "rate".into(),
            measured: format!("{ratio:.4} times the rate that is set"),
            limits: format!("{} to {}", 1.0 - RATE_TOLERANCE, 1.0 + RATE_TOLERANCE),
            fault: ((ratio - 1.0).abs() > RATE_TOLERANCE).then(fault),
        }
    });
    std::iter::once(converter).chain(gauges).chain(rate).collect()
}

/// What a self-test found wrong, in words; nothing if all is well.
#[must_use]
pub fn faults(test: &SelfTest) -> Vec<String> {
    checks(test).into_iter().filter_map(|check| check.fault).collect()
}

/// Noise of each gauge, µε.
#[must_use]
pub fn noise(test: &SelfTest, settings: &Settings) -> Vec<f64> {
    let sheets = settings.calibration.iter().zip(test.noise_counts);
    sheets.map(|(sheet, noise)| f64::from(noise) * sheet.gain.abs()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::answers::SelfTestInFull;
    use shared::wire::ConverterFault;

    const WELL: SelfTest = SelfTest {
        converter: Ok(()),
        noise_counts: [110.0; 4],
        mean_counts: [0, 100_000, -200_000, 7_900_000],
        samples: 256,
        rate_ratio: 1.001,
    };

    #[test]
    fn what_is_within_its_limits_passed() {
        let checks = checks(&WELL);
        assert_eq!(checks.len(), 6);
        assert!(checks.iter().all(|check| check.fault.is_none()), "{checks:?}");
        assert_eq!(checks[4].measured, "94.2 % of full scale");
        assert_eq!(checks[5].limits, "0.98 to 1.02");
        let answer = SelfTestInFull::of(&WELL, &Settings::DEFAULT);
        assert!(answer.found.passed && answer.checks.iter().all(|check| check.passed));
    }

    #[test]
    fn what_is_beyond_them_is_named() {
        let open = SelfTest { mean_counts: [0, 8_388_607, 0, 0], rate_ratio: 0.5, ..WELL };
        let faults = faults(&open);
        assert_eq!(faults.len(), 2);
        assert!(faults[0].starts_with("gauge 2 is at 100 % of full scale"), "{faults:?}");
        assert_eq!(faults[1], "samples come at 0.500 times the rate");
        let stuck = SelfTest { converter: Err(ConverterFault::Stuck), samples: 0, ..WELL };
        let checks = checks(&stuck);
        assert!(checks.len() == 5 && checks[0].fault.is_some(), "without samples there is no rate");
    }
}
