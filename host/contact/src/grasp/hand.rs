//! A hand: several fingers on one object, as a file describes them, and how their grip changes while it is held.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::balance::{
    Balance, BalanceError, Closure, Least, Pose, Touch, Wrench, closure, largest_load, least_grip,
};
use super::body::Body;
use super::contact::{Contact, Shape};
use super::growth::{Held, Material};
use super::pressure::PressureLaw;
use palpate_model::Model;

/// Major version of the hand file that this program reads.
const VERSION: i64 = 1;

/// What stays as it is while a finger holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Keeps {
    /// The position: the force relaxes.
    #[default]
    Position,
    /// The force: the contact creeps, and grows.
    Force,
}

/// A hand as a TOML file holds it.
///
/// ```toml
/// palpate-hand = 1
/// [load]                       # on the object, about the origin
/// force_N = [0, 0, -4.9]
/// moment_Nmm = [0, 0, 0]       # may be left out
/// [[finger]]
/// name = "thumb"
/// position_mm = [20, 0, 0]
/// normal = [-1, 0, 0]          # into the object
/// along = [0, 1, 0]            # axis x of the contact, may be left out
/// contact = "circle:6"         # as --contact of the other commands
/// friction = 0.7
/// exponent = 4                 # 2 where absent
/// normal_N = 5                 # how hard it presses now, may be left out
/// most_N = 20                  # how hard it can press, may be left out
/// model = "tip.toml"           # how it relaxes and creeps; needed for a forecast
/// keeps = "position"           # or "force"
/// ```
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "palpate-hand")]
    version: i64,
    load: LoadEntry,
    #[serde(rename = "finger")]
    fingers: Vec<FingerEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LoadEntry {
    #[serde(rename = "force_N")]
    force: [f64; 3],
    #[serde(rename = "moment_Nmm", default)]
    moment: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FingerEntry {
    name: String,
    position_mm: [f64; 3],
    normal: [f64; 3],
    along: Option<[f64; 3]>,
    contact: String,
    compression_mm: Option<f64>,
    friction: f64,
    #[serde(default = "hertz")]
    exponent: f64,
    #[serde(rename = "normal_N")]
    now: Option<f64>,
    #[serde(rename = "most_N")]
    most: Option<f64>,
    model: Option<PathBuf>,
    #[serde(default)]
    keeps: Keeps,
}

const fn hertz() -> f64 {
    2.0
}

/// Why a hand cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {problem}")]
pub struct HandError {
    path: PathBuf,
    problem: String,
}

/// One finger.
#[derive(Clone, Debug)]
pub struct Finger {
    /// Its name.
    pub name: String,
    /// Where it is on the object.
    pub pose: Pose,
    /// What is pressed.
    pub body: Body,
    /// Its compression, mm, where that was given.
    pub compression: Option<f64>,
    /// How it presses.
    pub law: PressureLaw,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// How hard it presses now, N.
    pub now: Option<f64>,
    /// How hard it can press, N; infinite where nothing is known.
    pub most: f64,
    /// How what is pressed relaxes.
    pub material: Option<Material>,
    /// What stays as it is while it holds.
    pub keeps: Keeps,
}

/// Several fingers and the load on the object.
#[derive(Clone, Debug)]
pub struct Hand {
    /// Its fingers.
    pub fingers: Vec<Finger>,
    /// Force and moment on the object.
    pub load: Wrench,
    /// Names of models with effects, which are left out.
    pub without_effects: Vec<String>,
}

impl Hand {
    /// Reads a hand and the models it names.
    ///
    /// # Errors
    /// When the file or a model cannot be read, or something in it cannot be.
    pub fn read(path: &Path) -> Result<Self, HandError> {
        let error = |problem: String| HandError { path: path.into(), problem };
        let text = std::fs::read_to_string(path).map_err(|source| error(source.to_string()))?;
        let file: File =
            toml::from_str(&text).map_err(|source| error(format!("not a hand: {source}")))?;
        if file.version != VERSION {
            let found = file.version;
            return Err(error(format!(
                "a hand of version {found}; this palpate reads version {VERSION}"
            )));
        }
        if file.fingers.is_empty() {
            return Err(error("no [[finger]] in it".into()));
        }
        let load = Wrench { force: file.load.force, moment: file.load.moment };
        if !load.force.iter().chain(&load.moment).all(|part| part.is_finite()) {
            return Err(error("the load must be of finite numbers".into()));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut without_effects = Vec::new();
        let mut fingers = Vec::new();
        for entry in file.fingers {
            let name = entry.name.clone();
            let finger = entry.finger(folder, &mut without_effects);
            fingers.push(finger.map_err(|what| error(format!("finger `{name}`: {what}")))?);
        }
        Ok(Self { fingers, load, without_effects })
    }

    /// Lets the fingers whose file names no model relax and creep by this one, of such a name.
    ///
    /// # Errors
    /// In words, when the model cannot be run.
    pub fn made_of(&mut self, model: &Model, name: String) -> Result<(), String> {
        let material = Material::of(model)?;
        for finger in &mut self.fingers {
            finger.material.get_or_insert_with(|| material.clone());
        }
        if !model.effects.is_empty() {
            self.without_effects.push(name);
        }
        Ok(())
    }

    /// The contacts while the fingers press so hard, N, none harder than `most`, N.
    ///
    /// # Errors
    /// In words, when a contact depends on something that is not known.
    pub fn touches(&self, normals: &[f64], most: &[f64]) -> Result<Vec<Touch>, String> {
        let touch = |(finger, (normal, most)): (&Finger, (&f64, &f64))| {
            finger.touch(finger.shape(*normal)?, *most)
        };
        self.fingers.iter().zip(normals.iter().zip(most)).map(touch).collect()
    }

    /// Whether the grasp is force-closed; contacts that grow are those under the load's own size.
    ///
    /// # Errors
    /// In words.
    pub fn closure(&self) -> Result<Closure, String> {
        let touches = self.touches(&self.first_guess(), &self.most())?;
        closure(&touches).map_err(|error| error.to_string())
    }

    fn most(&self) -> Vec<f64> {
        self.fingers.iter().map(|finger| finger.most).collect()
    }

    /// Normal forces of the size of the load.
    fn first_guess(&self) -> Vec<f64> {
        let [x, y, z] = self.load.force;
        let size = (x * x + y * y + z * z).sqrt();
        vec![if size > 0.0 { size } else { 1.0 }; self.fingers.len()]
    }

    /// The least normal forces that hold the load with every contact at most at 1/`margin` of its limit
    /// surface. A contact that grows with the force is that of the force found.
    ///
    /// # Errors
    /// In words when something is not known; inside, when no forces hold the load.
    pub fn least_grip(
        &self,
        margin: f64,
        least: Least,
    ) -> Result<Result<Balance, BalanceError>, String> {
        let (mut normals, most) = (self.first_guess(), self.most());
        let grows = self.fingers.iter().any(|finger| finger.body.grows());
        let mut found = least_grip(&self.touches(&normals, &most)?, &self.load, margin, least);
        for _ in 0..MOST_ROUNDS {
            let (true, Ok(balance)) = (grows, &found) else { break };
            let next: Vec<f64> =
                balance.shares.iter().map(|share| share.normal.max(SMALLEST_NORMAL)).collect();
            let moved =
                next.iter().zip(&normals).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
            normals = next;
            if moved < TOLERANCE {
                break;
            }
            found = least_grip(&self.touches(&normals, &most)?, &self.load, margin, least);
        }
        Ok(found)
    }

    /// How hard the fingers press now, N, where all say it.
    #[must_use]
    pub fn now(&self) -> Option<Vec<f64>> {
        self.fingers.iter().map(|finger| finger.now).collect()
    }

    /// The factor by which the load could grow with no finger pressing harder than this, N.
    ///
    /// # Errors
    /// As [`Self::least_grip`].
    pub fn margin(&self, normals: &[f64]) -> Result<Result<Balance, BalanceError>, String> {
        Ok(largest_load(&self.touches(normals, normals)?, &self.load))
    }

    /// How grip and margin go on from a grip of these normal forces, N, at these times, s, growing from 0 or
    /// later. With `again` the grip is made so many times as strong at that time, s.
    ///
    /// # Errors
    /// In words, when it is not known how a finger relaxes.
    pub fn course(
        &self,
        normals: &[f64],
        times: &[f64],
        again: Option<(f64, f64)>,
    ) -> Result<Vec<Instant>, String> {
        let each: Vec<Vec<(f64, Shape)>> = self
            .fingers
            .iter()
            .zip(normals)
            .map(|(finger, normal)| finger.course(*normal, times, again))
            .collect::<Result<_, _>>()?;
        let instant = |k: usize| {
            let normals: Vec<f64> = each.iter().map(|course| course[k].0).collect();
            let touch = |(finger, course): (&Finger, &Vec<(f64, Shape)>)| {
                finger.touch(course[k].1, course[k].0)
            };
            let touches: Vec<Touch> =
                self.fingers.iter().zip(&each).map(touch).collect::<Result<_, _>>()?;
            let margin = match largest_load(&touches, &self.load) {
                Ok(found) => found.value,
                Err(BalanceError::Unlimited) => f64::INFINITY,
                Err(BalanceError::Impossible) => 0.0,
                Err(error) => return Err(error.to_string()),
            };
            Ok(Instant { time: times[k], normals, margin })
        };
        (0..times.len()).map(instant).collect()
    }

    /// When the margin of a grip of these normal forces, N, falls to `margin` within `horizon`, s; none where
    /// it does not.
    ///
    /// # Errors
    /// As [`Self::course`].
    pub fn falls_to(
        &self,
        normals: &[f64],
        margin: f64,
        course: &[Instant],
    ) -> Result<Option<f64>, String> {
        let Some(k) = course.iter().position(|instant| instant.margin <= margin) else {
            return Ok(None);
        };
        if k == 0 {
            return Ok(Some(course[0].time));
        }
        let (mut before, mut after) = (course[k - 1].time, course[k].time);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + after);
            let there = &self.course(normals, &[middle], None)?[0];
            if there.margin <= margin { after = middle } else { before = middle }
        }
        Ok(Some(after))
    }

    /// By how many times to strengthen the grip at `now`, s, so that its margin does not fall below `margin`
    /// for `lasts`, s; 1 where it need not. None where no grip up to a thousand times as strong does it.
    ///
    /// # Errors
    /// As [`Self::course`].
    pub fn regrip(
        &self,
        normals: &[f64],
        margin: f64,
        now: f64,
        lasts: f64,
    ) -> Result<Option<f64>, String> {
        let times: Vec<f64> = LOOKS.iter().map(|part| now + lasts * part).collect();
        let least = |factor: f64| {
            let course = self.course(normals, &times, Some((now, factor)))?;
            Ok::<f64, String>(course.iter().map(|i| i.margin).fold(f64::INFINITY, f64::min))
        };
        let (mut low, mut high) = (1.0, 1.0);
        let mut at_high = least(high)?;
        if at_high >= margin {
            return Ok(Some(1.0));
        }
        while at_high < margin {
            // A margin grows about as the grip does.
            low = high;
            high *= (1.1 * margin / at_high.max(0.1 * margin)).max(1.05);
            if high > STRONGEST {
                return Ok(None);
            }
            at_high = least(high)?;
        }
        while high / low > 1.0 + FINE {
            let middle = 0.5 * (low + high);
            if least(middle)? >= margin { high = middle } else { low = middle }
        }
        Ok(Some(high))
    }
}

/// Grip and margin at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Instant {
    /// Time since the grasp was made, s.
    pub time: f64,
    /// Normal force of each finger, N.
    pub normals: Vec<f64>,
    /// The load could be so many times as large.
    pub margin: f64,
}

/// Rounds in which contacts and forces find each other, at most; and relative change that ends them.
const MOST_ROUNDS: usize = 30;
const TOLERANCE: f64 = 1e-8;
/// A finger that does not press has the contact of this force, N.
const SMALLEST_NORMAL: f64 = 1e-6;
/// Halvings of a time at which a margin is reached.
const HALVINGS: u32 = 12;
/// Where within a hold the margin is looked at, as parts of its length.
const LOOKS: [f64; 6] = [0.0, 0.01, 0.05, 0.2, 0.5, 1.0];
/// Strongest grip that is tried, of the one that is there, and relative precision of the answer.
const STRONGEST: f64 = 1e3;
const FINE: f64 = 1e-3;
/// How fast a grip is strengthened, s.
const SUDDENLY: f64 = 1e-3;

impl FingerEntry {
    fn finger(self, folder: &Path, without_effects: &mut Vec<String>) -> Result<Finger, String> {
        let positive = |name: &str, value: f64| {
            let fine = value > 0.0 && value.is_finite();
            if fine {
                Ok(value)
            } else {
                Err(format!("`{name}` is {value}; it must be above zero"))
            }
        };
        if !self.position_mm.iter().chain(&self.normal).all(|part| part.is_finite()) {
            return Err("position and normal must be of finite numbers".into());
        }
        let material = match &self.model {
            None => None,
            Some(path) => {
                let path = folder.join(path);
                let model = Model::read(&path).map_err(|error| error.to_string())?;
                if !model.effects.is_empty() {
                    without_effects.push(path.display().to_string());
                }
                Some(Material::of(&model)?)
            }
        };
        let said = |error: &dyn std::fmt::Display| error.to_string();
        Ok(Finger {
            pose: Pose::new(self.position_mm, self.normal, self.along).map_err(|e| said(&e))?,
            body: self.contact.parse().map_err(|e: super::BodyError| said(&e))?,
            compression: self
                .compression_mm
                .map(|value| positive("compression_mm", value))
                .transpose()?,
            law: PressureLaw::new(self.exponent).map_err(|e| said(&e))?,
            friction: positive("friction", self.friction)?,
            now: self.now.map(|value| positive("normal_N", value)).transpose()?,
            most: self.most.map_or(Ok(f64::INFINITY), |value| positive("most_N", value))?,
            material,
            keeps: self.keeps,
            name: self.name,
        })
    }
}

impl Finger {
    /// The contact under a normal force that is there at once, N.
    fn shape(&self, normal: f64) -> Result<Shape, String> {
        let foretold = || Some(self.material.as_ref()?.response.sudden_compression(normal));
        let compression = self.compression.or_else(|| self.body.grows().then(foretold).flatten());
        self.body.pressed(compression).map_err(|error| match error {
            super::BodyError::Compression => format!(
                "the contact of finger `{}` grows as it is pressed: give its `model` or `compression_mm`",
                self.name
            ),
            other => format!("finger `{}`: {other}", self.name),
        })
    }

    fn touch(&self, shape: Shape, most: f64) -> Result<Touch, String> {
        let contact = Contact::new(shape, self.law).map_err(|error| error.to_string())?;
        Ok(Touch { pose: self.pose, contact, friction: self.friction, most })
    }

    /// Normal force, N, and contact over a hold.
    fn course(
        &self,
        normal: f64,
        times: &[f64],
        again: Option<(f64, f64)>,
    ) -> Result<Vec<(f64, Shape)>, String> {
        let factor =
            |time: f64| again.filter(|(at, _)| time >= *at).map_or(1.0, |(_, factor)| factor);
        let Some(material) = &self.material else {
            if self.keeps == Keeps::Position {
                return Err(format!(
                    "how the grip of finger `{}` relaxes is not known: give its `model`, or keeps = \"force\"",
                    self.name
                ));
            }
            return times.iter().map(|&t| Ok((factor(t) * normal, self.shape(normal)?))).collect();
        };
        let held = match (self.keeps, again) {
            (Keeps::Force, None) => material.creep(times, normal),
            (Keeps::Force, Some((_, factor))) => material.creep(times, factor * normal),
            (Keeps::Position, _) => {
                let compression = material.response.sudden_compression(normal);
                material.relaxation_tightened(times, compression, again)
            }
        };
        let own = |held: Held| {
            let compression = self.compression.unwrap_or(held.compression);
            let shape = self.body.pressed(Some(compression));
            Ok((held.normal, shape.map_err(|error| error.to_string())?))
        };
        held.into_iter().map(own).collect()
    }
}

impl Material {
    /// Relaxation under a compression that is there at once, mm; at a time, s, the force is made so many times
    /// as large within a millisecond, and held on.
    fn relaxation_tightened(
        &self,
        times: &[f64],
        compression: f64,
        again: Option<(f64, f64)>,
    ) -> Vec<Held> {
        let Some((at, factor)) = again.filter(|(_, factor)| *factor != 1.0) else {
            return self.relaxation(times, compression);
        };
        let mut state = palpate_model::HereditaryState::default();
        let mut normal = self.response.begin(&mut state, compression);
        if at > 0.0 {
            normal = self.response.advance(&mut state, at, compression);
        }
        let tightened = self.response.keeping(&state, SUDDENLY, factor * normal, compression);
        let _ = self.response.advance(&mut state, SUDDENLY, tightened);
        let mut now = at;
        let after = |&time: &f64| {
            if time <= at {
                let before = if time < at {
                    self.relaxation(&[time], compression)[0].normal
                } else {
                    factor * normal
                };
                return Held { time, compression, normal: before };
            }
            let normal = self.response.advance(&mut state, time - now, tightened);
            now = time;
            Held { time, compression: tightened, normal }
        };
        times.iter().map(after).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_model::{BaseLaw, Separation};

    /// Two fingertips of silicone from both sides of an object of so many newtons.
    fn gripper(keeps: Keeps, weight: f64) -> Hand {
        let law = BaseLaw::fung(1, Separation::Clamp);
        let material = Material { response: law.response(&[2.0, 0.5, 0.4, 0.5]) };
        let finger = |name: &str, x: f64| Finger {
            name: name.into(),
            pose: Pose::new([x, 0.0, 0.0], [-x, 0.0, 0.0], None).unwrap(),
            body: "circle:6".parse().unwrap(),
            compression: None,
            law: PressureLaw::HERTZ,
            friction: 0.5,
            now: Some(10.0),
            most: f64::INFINITY,
            material: Some(material.clone()),
            keeps,
        };
        Hand {
            fingers: vec![finger("left", -20.0), finger("right", 20.0)],
            load: Wrench { force: [0.0, 0.0, -weight], moment: [0.0; 3] },
            without_effects: Vec::new(),
        }
    }

    #[test]
    fn a_gripper_slips_when_its_force_has_relaxed_to_the_weight_over_twice_the_friction() {
        // 10 N (0.6 + 0.4 e^(−0.5 t)) must carry 8 N by 2 × 0.5: until 0.2/0.4 = e^(−0.5 t).
        let hand = gripper(Keeps::Position, 8.0);
        let times: Vec<f64> = (0..=40).map(|k| 0.5 * f64::from(k)).collect();
        let course = hand.course(&[10.0; 2], &times, None).unwrap();
        assert!((course[0].margin - 10.0 / 8.0).abs() < 1e-6, "{}", course[0].margin);
        let slip = hand.falls_to(&[10.0; 2], 1.0, &course).unwrap().unwrap();
        assert!((slip - 2.0 * 2f64.ln()).abs() < 1e-3, "{slip}");
        let never = gripper(Keeps::Force, 8.0).course(&[10.0; 2], &times, None).unwrap();
        assert!(never.iter().all(|instant| (instant.margin - 1.25).abs() < 1e-6));
    }

    #[test]
    fn a_grip_strengthened_now_holds_as_long_as_was_asked_and_hardly_more() {
        let hand = gripper(Keeps::Position, 8.0);
        let (now, lasts, margin) = (1.0, 60.0, 1.2);
        let factor = hand.regrip(&[10.0; 2], margin, now, lasts).unwrap().unwrap();
        let at = |factor| {
            hand.course(&[10.0; 2], &[now + lasts], Some((now, factor))).unwrap()[0].margin
        };
        assert!(at(factor) >= margin && at(0.99 * factor) < margin, "{factor}: {}", at(factor));
        // What the first squeeze left to relax, and 0.6 of what is added, must be 9.6 N.
        let before = 10.0 * (0.6 + 0.4 * (-0.5f64).exp());
        let added = (factor - 1.0) * before;
        assert!((6.0 + 0.6 * added - 9.6).abs() < 0.02, "{factor}");
    }

    #[test]
    fn the_least_grip_is_half_the_weight_over_the_friction_each() {
        let hand = gripper(Keeps::Position, 8.0);
        let found = hand.least_grip(1.0, Least::Sum).unwrap().unwrap();
        assert!((found.value - 16.0).abs() < 1e-5, "{}", found.value);
        let safe = hand.least_grip(1.5, Least::Largest).unwrap().unwrap();
        assert!((safe.value - 12.0).abs() < 1e-5, "{}", safe.value);
        assert!(hand.closure().unwrap().is_force_closed());
    }
}
