//! A device's test of itself, in words: what was measured, and within which limits it must be.

use shared::wire::{Done, Inputs, SCHEMA, SelfTest, Settings, ToDevice};

use super::refusal::Fault;
use super::session::{LinkError, Session};

/// Counts beyond this fraction of full scale are those of a bridge that is open or shorted.
const NEAR_RAIL: f64 = 0.95;
/// A rate further off than this is wrong.
const RATE_TOLERANCE: f64 = 0.02;
/// Full scale of the converter, counts.
const FULL_SCALE: f64 = 8_388_608.0;

/// Offset of the converter itself beyond this fraction of full scale is a fault, and so is a test signal that is off by more.
const OFFSET_TOLERANCE: f64 = 0.02;
const SIGNAL_TOLERANCE: f64 = 0.05;

/// What a device and its converter found of themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    /// With the gauges.
    pub gauges: SelfTest,
    /// Without them; none if the converter cannot.
    pub own: Option<Own>,
}

/// What a converter found of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Own {
    /// With both sides of each input joined.
    pub shorted: SelfTest,
    /// With its own signal.
    pub signal: SelfTest,
    /// Counts that this signal should have.
    pub signal_counts: i32,
}

impl Own {
    /// Largest offset of a gauge's input, as a part of full scale.
    #[must_use]
    pub fn offset(&self) -> f64 {
        let most = self.shorted.mean_counts.iter().map(|mean| mean.unsigned_abs()).max();
        f64::from(most.unwrap_or_default()) / FULL_SCALE
    }

    /// The signal over what it should be, of the gauge where it is furthest off.
    #[must_use]
    pub fn signal_ratio(&self) -> f64 {
        let ratio = |mean: &i32| f64::from(*mean) / f64::from(self.signal_counts);
        let off = |ratio: &f64| (ratio - 1.0).abs();
        let ratios = self.signal.mean_counts.iter().map(ratio);
        ratios.max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(f64::NAN)
    }
}

/// Lets a device test itself, with its gauges and, if its converter can, without.
///
/// # Errors
/// Those of the session; [`LinkError::Refused`] while it streams.
pub fn run(session: &mut Session) -> Result<Tested, LinkError> {
    let gauges = test(session, &ToDevice::SelfTest)?;
    let signal_counts = session.identity().capabilities.test_counts;
    let can = session.identity().schema == SCHEMA && signal_counts > 0;
    let own = if can && gauges.converter.is_ok() {
        let shorted = test(session, &ToDevice::TestInputs(Inputs::Shorted))?;
        let signal = test(session, &ToDevice::TestInputs(Inputs::TestSignal))?;
        Some(Own { shorted, signal, signal_counts })
    } else {
        None
    };
    Ok(Tested { gauges, own })
}

fn test(session: &mut Session, command: &ToDevice<'_>) -> Result<SelfTest, LinkError> {
    match session.command(command)? {
        Done::Tested(test) => Ok(test),
        other => Err(LinkError::Unsuited(other)),
    }
}

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
pub fn checks(tested: &Tested) -> Vec<Check> {
    let Tested { gauges: test, own } = tested;
    let converter = Check {
        name: "converter".into(),
        measured: format!("{} samples", test.samples),
        limits: "answers, keeps its registers and sends samples".into(),
        fault: test.converter.err().map(|fault| Fault(fault).to_string()),
    };
    let gauges = (1..).zip(*test.mean_counts).map(|(gauge, mean)| {
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
    let own = own.iter().flat_map(checks_of_own);
    std::iter::once(converter).chain(gauges).chain(rate).chain(own).collect()
}

/// Offset and signal of the converter itself.
fn checks_of_own(own: &Own) -> [Check; 2] {
    let (offset, ratio) = (own.offset(), own.signal_ratio());
    [
        Check {
            name: "converter's own offset".into(),
            measured: format!("{:.2} % of full scale", offset * 100.0),
            limits: format!("at most {:.0} %", OFFSET_TOLERANCE * 100.0),
            fault: (offset > OFFSET_TOLERANCE).then(|| {
                format!(
                    "the converter reads {:.1} % of full scale with its inputs shorted",
                    offset * 100.0
                )
            }),
        },
        Check {
            name: "converter's test signal".into(),
            measured: format!("{ratio:.4} of what it is"),
            limits: format!("{} to {}", 1.0 - SIGNAL_TOLERANCE, 1.0 + SIGNAL_TOLERANCE),
            fault: ((ratio - 1.0).abs() > SIGNAL_TOLERANCE)
                .then(|| format!("the converter reads {ratio:.3} of its own test signal")),
        },
    ]
}

/// What a self-test found wrong, in words; nothing if all is well.
#[must_use]
pub fn faults(tested: &Tested) -> Vec<String> {
    checks(tested).into_iter().filter_map(|check| check.fault).collect()
}

/// Noise of each gauge, µε.
#[must_use]
pub fn noise(tested: &Tested, settings: &Settings) -> Vec<f64> {
    let sheets = settings.calibration.iter().zip(*tested.gauges.noise_counts);
    sheets.map(|(sheet, noise)| f64::from(noise) * sheet.gain.abs()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::answers::SelfTestInFull;
    use shared::wire::{ConverterFault, PerGauge};

    const WELL: SelfTest = SelfTest {
        converter: Ok(()),
        noise_counts: PerGauge([110.0; 4]),
        mean_counts: PerGauge([0, 100_000, -200_000, 7_900_000]),
        samples: 256,
        rate_ratio: 1.001,
    };

    const ALONE: Tested = Tested { gauges: WELL, own: None };

    #[test]
    fn what_is_within_its_limits_passed() {
        let checks = checks(&ALONE);
        assert_eq!(checks.len(), 6);
        assert!(checks.iter().all(|check| check.fault.is_none()), "{checks:?}");
        assert_eq!(checks[4].measured, "94.2 % of full scale");
        assert_eq!(checks[5].limits, "0.98 to 1.02");
        let answer = SelfTestInFull::of(&ALONE, &Settings::DEFAULT);
        assert!(answer.found.passed && answer.checks.iter().all(|check| check.passed));
    }

    #[test]
    fn what_is_beyond_them_is_named() {
        let gauges =
            SelfTest { mean_counts: PerGauge([0, 8_388_607, 0, 0]), rate_ratio: 0.5, ..WELL };
        let faults = faults(&Tested { gauges, ..ALONE });
        assert_eq!(faults.len(), 2);
        assert!(faults[0].starts_with("gauge 2 is at 100 % of full scale"), "{faults:?}");
        assert_eq!(faults[1], "samples come at 0.500 times the rate");
        let gauges = SelfTest { converter: Err(ConverterFault::Stuck), samples: 0, ..WELL };
        let checks = checks(&Tested { gauges, ..ALONE });
        assert!(checks.len() == 5 && checks[0].fault.is_some(), "without samples there is no rate");
    }

    #[test]
    fn a_converter_that_misreads_its_own_signal_or_nothing_at_all_is_named() {
        let of = |mean| SelfTest { mean_counts: PerGauge(mean), ..WELL };
        let own = |shorted, signal| {
            let own = Own { shorted: of(shorted), signal: of(signal), signal_counts: 1_000_000 };
            faults(&Tested { own: Some(own), ..ALONE })
        };
        assert!(own([-9_000, 0, 0, 9_000], [1_000_000, 1_020_000, 990_000, 1_000_000]).is_empty());
        let signal = [1_000_000, 1_000_000, 1_000_000, 900_000];
        assert_eq!(own([0; 4], signal), ["the converter reads 0.900 of its own test signal"]);
        let shorted = [0, -840_000, 0, 0];
        assert_eq!(
            own(shorted, [1_000_000; 4]),
            ["the converter reads 10.0 % of full scale with its inputs shorted"]
        );
    }
}
