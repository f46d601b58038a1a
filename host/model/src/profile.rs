//! A programme of motion: moves with limited acceleration, and holds.

use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::Motion;

/// Major version of the profile file that this program reads.
const VERSION: i64 = 1;

/// Most samples one profile may ask for.
const MAX_SAMPLES: f64 = 1e7;
/// Most steps of one profile, those of all runs together.
const MAX_STEPS: u64 = 1_000_000;

/// A programme of motion, as a TOML file holds it.
///
/// ```toml
/// palpate-profile = 1
/// rate_hz = 200.0
/// speed_mm_per_s = 20.0
/// acceleration_mm_per_s2 = 700.0  # absent: sharp corners
/// [[step]]
/// hold_s = 0.2
/// [[step]]
/// to_mm = 12.0
/// [[step]]
/// hold_s = 4.3
/// [[step]]
/// to_mm = 0.0
/// speed_mm_per_s = 5.0            # for this move only
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Major version of the format.
    #[serde(rename = "palpate-profile")]
    pub version: i64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Where the motion starts, mm.
    #[serde(default)]
    pub start_mm: f64,
    /// Speed of moves that do not give their own, mm/s.
    pub speed_mm_per_s: f64,
    /// Acceleration at the corners, mm/s²; absent for sharp corners.
    pub acceleration_mm_per_s2: Option<f64>,
    /// How many times the steps are run.
    #[serde(default = "once")]
    pub repeat: u32,
    /// The steps.
    #[serde(rename = "step")]
    pub steps: Vec<Step>,
}

fn once() -> u32 {
    1
}

/// One step of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Step {
    /// Stay where the last move ended, s.
    Hold(Hold),
    /// Go to a place.
    Move(Move),
}

/// Stay.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// For how long, s.
    pub hold_s: f64,
}

/// Go to a place.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Move {
    /// Where to, mm.
    pub to_mm: f64,
    /// At which speed, mm/s, where it differs from the profile's.
    pub speed_mm_per_s: Option<f64>,
}

/// Why a profile cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ProfileError {
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: io::Error },
    #[error("{path}: not a profile: {source}")]
    Toml { path: PathBuf, source: Box<toml::de::Error> },
    #[error(
        "{path}: a profile of version {found}; this palpate reads version {VERSION}: install a newer palpate"
    )]
    Newer { path: PathBuf, found: i64 },
    #[error("{path}: {problem}")]
    Content { path: PathBuf, problem: String },
}

/// A piece of the programme with constant acceleration.
struct Piece {
    from: f64,
    velocity: f64,
    acceleration: f64,
    duration: f64,
}

impl Profile {
    /// Reads a profile.
    ///
    /// # Errors
    /// When the file cannot be read, is of a newer version, or asks for an impossible motion.
    pub fn read(path: &Path) -> Result<Self, ProfileError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| ProfileError::Io { path: path.into(), source })?;
        let not_toml = |source| ProfileError::Toml { path: path.into(), source: Box::new(source) };
        let content = |problem| ProfileError::Content { path: path.into(), problem };
        let table: toml::Table = toml::from_str(&text).map_err(not_toml)?;
        match table.get("palpate-profile").and_then(toml::Value::as_integer) {
            Some(VERSION) => {}
            Some(found) if found > VERSION => {
                return Err(ProfileError::Newer { path: path.into(), found });
            }
            _ => {
                return Err(content(format!(
                    "no line `palpate-profile = {VERSION}`: not a profile"
                )));
            }
        }
        let profile: Self = toml::from_str(&text).map_err(not_toml)?;
        profile.check().map_err(content)?;
        Ok(profile)
    }

    fn check(&self) -> Result<(), String> {
        let positive = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(format!("`{name}` is {value}; it must be above zero"))
            }
        };
        positive("rate_hz", self.rate_hz)?;
        positive("speed_mm_per_s", self.speed_mm_per_s)?;
        self.acceleration_mm_per_s2.map_or(Ok(()), |a| positive("acceleration_mm_per_s2", a))?;
        for step in &self.steps {
            match *step {
                Step::Hold(Hold { hold_s }) => positive("hold_s", hold_s)?,
                Step::Move(Move { to_mm, speed_mm_per_s }) => {
                    if !to_mm.is_finite() {
                        return Err(format!("`to_mm` is {to_mm}"));
                    }
                    speed_mm_per_s.map_or(Ok(()), |speed| positive("speed_mm_per_s", speed))?;
                }
            }
        }
        let steps = self.steps.len() as u64 * u64::from(self.repeat);
        if steps > MAX_STEPS {
            return Err(format!("{steps} steps, `repeat` counted; at most {MAX_STEPS}"));
        }
        let samples = self.samples();
        if samples < 1.0 {
            return Err("the steps last less than one sample".into());
        }
        if samples.is_nan() || samples > MAX_SAMPLES {
            return Err(format!("the steps last {samples:.3e} samples; at most {MAX_SAMPLES:.0e}"));
        }
        Ok(())
    }

    /// How many samples the motion has, about.
    #[must_use]
    pub fn samples(&self) -> f64 {
        self.pieces().iter().map(|piece| piece.duration).sum::<f64>() * self.rate_hz
    }

    /// The motion, sampled from the start of the first step to the end of the last.
    #[must_use]
    pub fn motion(&self) -> Motion<'static> {
        let pieces = self.pieces();
        let total: f64 = pieces.iter().map(|piece| piece.duration).sum();
        let mut pieces = pieces.into_iter().peekable();
        let mut began = 0.0;
        let mut time = Vec::new();
        let mut displacement = Vec::new();
        // Half a sample of slack: the last instant belongs to the motion despite rounding.
        let last = (total * self.rate_hz + 1e-6).floor() as usize;
        for index in 0..=last {
            let now = index as f64 / self.rate_hz;
            while let Some(piece) = pieces.peek() {
                if now - began <= piece.duration {
                    break;
                }
                let duration = piece.duration;
                // The last piece stays: the final sample may lie a rounding beyond its end.
                let ended = pieces.next();
                if pieces.peek().is_none() {
                    pieces = ended.into_iter().collect::<Vec<_>>().into_iter().peekable();
                    break;
                }
                began += duration;
            }
            let Some(piece) = pieces.peek() else { break };
            let elapsed = (now - began).min(piece.duration);
            time.push(now);
            displacement
                .push(piece.from + elapsed * (piece.velocity + 0.5 * piece.acceleration * elapsed));
        }
        Motion { time: time.into(), displacement: displacement.into(), rest_before: None }
    }

    fn pieces(&self) -> Vec<Piece> {
        let mut at = self.start_mm;
        let mut pieces = Vec::new();
        for step in (0..self.repeat).flat_map(|_| &self.steps) {
            match *step {
                Step::Hold(Hold { hold_s }) => {
                    pieces.push(Piece {
                        from: at,
                        velocity: 0.0,
                        acceleration: 0.0,
                        duration: hold_s,
                    });
                }
                Step::Move(Move { to_mm, speed_mm_per_s }) => {
                    let speed = speed_mm_per_s.unwrap_or(self.speed_mm_per_s);
                    self.travel(at, to_mm, speed, &mut pieces);
                    at = to_mm;
                }
            }
        }
        pieces
    }

    /// A move: speed up, go, slow down; short moves never reach the full speed.
    fn travel(&self, from: f64, to: f64, speed: f64, pieces: &mut Vec<Piece>) {
        let distance = (to - from).abs();
        let sign = (to - from).signum();
        if distance == 0.0 {
            return;
        }
        let Some(acceleration) = self.acceleration_mm_per_s2 else {
            let duration = distance / speed;
            pieces.push(Piece { from, velocity: sign * speed, acceleration: 0.0, duration });
            return;
        };
        let speed = speed.min((distance * acceleration).sqrt());
        let corner = speed / acceleration;
        let ramp = 0.5 * speed * corner;
        let (a, v) = (sign * acceleration, sign * speed);
        pieces.push(Piece { from, velocity: 0.0, acceleration: a, duration: corner });
        let cruise = (distance - 2.0 * ramp) / speed;
        if cruise > 0.0 {
            let from = from + sign * ramp;
            pieces.push(Piece { from, velocity: v, acceleration: 0.0, duration: cruise });
        }
        pieces.push(Piece {
            from: to - sign * ramp,
            velocity: v,
            acceleration: -a,
            duration: corner,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn profile(acceleration: Option<f64>, steps: Vec<Step>) -> Profile {
        Profile {
            version: 1,
            rate_hz: 200.0,
            start_mm: 0.0,
            speed_mm_per_s: 20.0,
            acceleration_mm_per_s2: acceleration,
            repeat: 1,
            steps,
        }
    }

    fn to(to_mm: f64) -> Step {
        Step::Move(Move { to_mm, speed_mm_per_s: None })
    }

    #[test]
    fn a_press_reaches_its_place_at_its_speed() {
        let steps =
            vec![Step::Hold(Hold { hold_s: 0.2 }), to(12.0), Step::Hold(Hold { hold_s: 1.0 })];
        let motion = profile(None, steps).motion();
        assert_eq!(motion.time.len(), 361);
        assert!((motion.displacement[80] - 4.0).abs() < 1e-9, "0.4 s: 0.2 s at 20 mm/s");
        assert!((motion.displacement[360] - 12.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn corners_are_rounded_and_no_sample_overshoots(
            target in 0.01f64..20.0,
            acceleration in 10f64..5000.0,
        ) {
            let motion = profile(Some(acceleration), vec![to(target), to(-0.5)]).motion();
            let x = &motion.displacement;
            prop_assert!(x.iter().all(|x| (-0.5 - 1e-9..=target + 1e-9).contains(x)));
            let step = 1.0 / 200.0;
            for three in x.windows(3) {
                let second = (three[2] - 2.0 * three[1] + three[0]) / (step * step);
                prop_assert!(second.abs() <= acceleration * (1.0 + 1e-6) + 1e-6);
            }
        }
    }

    #[test]
    fn an_impossible_profile_is_refused_with_the_key_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("press.toml");
        let refusal = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Profile::read(&path).unwrap_err().to_string()
        };
        let head = "palpate-profile = 1\nspeed_mm_per_s = 20.0\n";
        assert!(refusal("palpate-profile = 2").contains("version 2"));
        assert!(refusal(&format!("{head}rate_hz = 0.0\nstep = []")).contains("`rate_hz` is 0"));
        assert!(refusal(&format!("{head}rate_hz = 200.0\nstep = []")).contains("less than one"));
        let endless = format!("{head}rate_hz = 200.0\n[[step]]\nhold_s = 1e9");
        assert!(refusal(&endless).contains("at most"));
        // Refused before it is laid out.
        let again = format!("{head}rate_hz = 1.0\nrepeat = 4000000000\n[[step]]\nhold_s = 1e-9");
        assert!(refusal(&again).contains("4000000000 steps"));
    }
}
