//! Control of the force: a programme of forces, and the motion by which a PI controller follows it (6.3.2).

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{BaseLaw, HereditaryState};

/// Major version of the force profile that this program reads.
const VERSION: i64 = 1;

/// Most samples one profile may ask for.
const MAX_SAMPLES: f64 = 1e7;

/// A programme of forces, as a TOML file holds it.
///
/// ```toml
/// palpate-force-profile = 1
/// rate_hz = 200.0
/// loading_N_per_s = 1.96
/// bandwidth_hz = 5.0        # of the controller; 5 where absent
/// [[step]]
/// to_N = 2.0
/// [[step]]
/// hold_s = 9.5
/// [[step]]
/// to_N = 0.0
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceProfile {
    /// Major version of the format.
    #[serde(rename = "palpate-force-profile")]
    pub version: i64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Loading rate of steps that do not give their own, N/s.
    #[serde(rename = "loading_N_per_s")]
    pub loading: f64,
    /// Bandwidth of the controller, Hz.
    #[serde(default = "five")]
    pub bandwidth_hz: f64,
    /// The steps.
    #[serde(rename = "step")]
    pub steps: Vec<ForceStep>,
}

fn five() -> f64 {
    5.0
}

/// One step of a programme of forces.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum ForceStep {
    /// Keep the force.
    Hold(super::Hold),
    /// Go to a force.
    Load(Loading),
}

/// Go to a force.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// To which force, N.
    #[serde(rename = "to_N")]
    pub to: f64,
    /// At which rate, N/s, where it differs from the programme's.
    #[serde(rename = "loading_N_per_s")]
    pub rate: Option<f64>,
}

/// Why a force profile cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {problem}")]
pub struct ForceProfileError {
    path: PathBuf,
    problem: String,
}

/// A run under force control, sample by sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Controlled {
    /// Time, s.
    pub time: Vec<f64>,
    /// Displacement that the controller chose, mm.
    pub displacement: Vec<f64>,
    /// Force of the specimen, N.
    pub force: Vec<f64>,
    /// Force that was asked for, N.
    pub wanted: Vec<f64>,
}

impl ForceProfile {
    /// Reads a force profile.
    ///
    /// # Errors
    /// When the file cannot be read, is of another version, or asks for what cannot be.
    pub fn read(path: &Path) -> Result<Self, ForceProfileError> {
        let error = |problem: String| ForceProfileError { path: path.into(), problem };
        let text = std::fs::read_to_string(path).map_err(|source| error(source.to_string()))?;
        let profile: Self = toml::from_str(&text)
            .map_err(|source| error(format!("not a force profile: {source}")))?;
        if profile.version != VERSION {
            let found = profile.version;
            return Err(error(format!(
                "a force profile of version {found}; this palpate reads version {VERSION}"
            )));
        }
        profile.check().map_err(error)?;
        Ok(profile)
    }

    fn check(&self) -> Result<(), String> {
        let positive = |name: &str, value: f64| {
            let fine = value.is_finite() && value > 0.0;
            if fine { Ok(()) } else { Err(format!("`{name}` is {value}; it must be above zero")) }
        };
        positive("rate_hz", self.rate_hz)?;
        positive("loading_N_per_s", self.loading)?;
        positive("bandwidth_hz", self.bandwidth_hz)?;
        if self.bandwidth_hz > self.rate_hz / 10.0 {
            return Err(format!(
                "`bandwidth_hz` is {}; a controller that samples at {} Hz is steady up to a tenth of that",
                self.bandwidth_hz, self.rate_hz
            ));
        }
        for step in &self.steps {
            match *step {
                ForceStep::Hold(hold) => positive("hold_s", hold.hold_s)?,
                ForceStep::Load(Loading { to, rate }) => {
                    if !(to.is_finite() && to >= 0.0) {
                        return Err(format!(
                            "`to_N` is {to}; a force that presses is not negative"
                        ));
                    }
                    rate.map_or(Ok(()), |rate| positive("loading_N_per_s", rate))?;
                }
            }
        }
        let samples = self.corners().last().map_or(0.0, |(time, _)| time * self.rate_hz);
        if !(1.0..=MAX_SAMPLES).contains(&samples) {
            return Err(format!(
                "the steps last {samples:.3e} samples; 1 to {MAX_SAMPLES:.0e} are possible"
            ));
        }
        Ok(())
    }

    /// Time, s, and force, N, at the corners of the programme.
    fn corners(&self) -> Vec<(f64, f64)> {
        let (mut time, mut force) = (0.0, 0.0);
        let mut corners = vec![(time, force)];
        for step in &self.steps {
            match *step {
                ForceStep::Hold(hold) => time += hold.hold_s,
                ForceStep::Load(Loading { to, rate }) => {
                    time += (to - force).abs() / rate.unwrap_or(self.loading);
                    force = to;
                }
            }
            corners.push((time, force));
        }
        corners
    }

    /// Largest force asked for, N.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.corners().iter().map(|(_, force)| *force).fold(0.0, f64::max)
    }

    /// Runs a specimen of this law under PI control from rest: v = kp e + ki ∫ e dt, with gains that give
    /// the loop its bandwidth where the specimen is stiffest in this run.
    #[must_use]
    pub fn run(&self, law: &BaseLaw, parameters: &[f64]) -> Controlled {
        let response = law.response(parameters);
        let corners = self.corners();
        let omega = TAU * self.bandwidth_hz;
        let reach = response.sudden_compression(self.largest());
        let proportional = omega / response.stiffness(reach).max(f64::MIN_POSITIVE);
        let integral = 0.25 * omega * proportional;
        let interval = 1.0 / self.rate_hz;
        let duration = corners.last().map_or(0.0, |(time, _)| *time);
        let mut state = HereditaryState::default();
        let (mut x, mut force, mut built_up) = (0.0, response.begin(&mut state, 0.0), 0.0);
        let mut run = Controlled {
            time: Vec::new(),
            displacement: Vec::new(),
            force: Vec::new(),
            wanted: Vec::new(),
        };
        for k in 0..=(duration * self.rate_hz + 1e-6).floor() as usize {
            let time = k as f64 * interval;
            let wanted = force_at(&corners, time);
            if k > 0 {
                force = response.advance(&mut state, interval, x);
            }
            run.time.push(time);
            run.displacement.push(x);
            run.force.push(force);
            run.wanted.push(wanted);
            let error = wanted - force;
            built_up += integral * error * interval;
            x += (proportional * error + built_up) * interval;
        }
        run
    }
}

/// The programme at a time, N.
fn force_at(corners: &[(f64, f64)], time: f64) -> f64 {
    let next = corners.iter().position(|(t, _)| *t >= time).unwrap_or(corners.len() - 1).max(1);
    let ((t0, f0), (t1, f1)) = (corners[next - 1], corners[next]);
    if t1 > t0 { f0 + (f1 - f0) * ((time - t0) / (t1 - t0)).clamp(0.0, 1.0) } else { f1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Family, Hold, Separation};

    fn programme(loading: f64) -> ForceProfile {
        ForceProfile {
            version: 1,
            rate_hz: 500.0,
            loading,
            bandwidth_hz: 5.0,
            steps: vec![
                ForceStep::Load(Loading { to: 4.0, rate: None }),
                ForceStep::Hold(Hold { hold_s: 9.5 }),
                ForceStep::Load(Loading { to: 2.0, rate: None }),
                ForceStep::Hold(Hold { hold_s: 9.5 }),
            ],
        }
    }

    #[test]
    fn the_controller_keeps_the_force_and_the_specimen_creeps_both_ways() {
        let law = BaseLaw::new(Family::CREEP, 2, Separation::Clamp);
        let run = programme(0.85).run(&law, &[0.4, 0.0, -0.08, -0.15, 0.8, 0.05]);
        let at = |time: f64| (time * 500.0) as usize;
        let (loaded, eased) = (4.0 / 0.85, 4.0 / 0.85 + 9.5 + 2.0 / 0.85);
        for (begin, force) in [(loaded, 4.0), (eased, 2.0)] {
            for k in at(begin + 1.0)..at(begin + 9.4) {
                assert!((run.force[k] - force).abs() < 0.01, "{} N at {k}", run.force[k]);
            }
        }
        // Type I grows, Type II falls.
        assert!(run.displacement[at(loaded + 9.0)] > run.displacement[at(loaded + 1.0)] + 0.05);
        assert!(run.displacement[at(eased + 9.0)] < run.displacement[at(eased + 1.0)] - 0.01);
    }

    #[test]
    fn a_faster_loading_arrives_at_a_smaller_compression() {
        let law = BaseLaw::new(Family::CREEP, 2, Separation::Clamp);
        let reached = |loading: f64| {
            let run = programme(loading).run(&law, &[0.4, 0.0, -0.08, -0.15, 0.8, 0.05]);
            run.displacement[(4.0 / loading * 500.0) as usize]
        };
        assert!(reached(2.71) < reached(0.85) && reached(0.85) < reached(0.092));
    }
}
