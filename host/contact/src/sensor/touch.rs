//! What the gauges read while an indenter moves.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use shared::adaptation::Relaxation;
use shared::pipeline::GAUGES;
use toml::Table;

use super::fingertip::DEEPEST;
use super::{Fingertip, Indenter, SensorError};
use palpate_model::{self as model, Memory};
use palpate_trace::{Control, DISPLACEMENT, FORCE, GAUGES as NAMES, HAPPENED, Head, Shape, Trace};

/// What an indenter does; all vectors are of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Time, s, strictly increasing.
    pub time: Vec<f64>,
    /// Depth below the resting surface, mm; negative off the fingertip.
    pub depth_mm: Vec<f64>,
    /// Place x and y, mm.
    pub place_mm: Vec<[f64; 2]>,
    /// Force along x, N; empty where nothing pulls sideways.
    pub pull_n: Vec<f64>,
}

/// What the fingertip felt of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// Gauges, depth of the indenter and force, with a head from which `convert` makes a recording of a device.
    pub trace: Trace,
    /// What each gauge would have read without memory, limit and noise, µε.
    pub elastic: [Vec<f64>; GAUGES],
    /// When each gauge was first cut off, s; none if it never was.
    pub saturated_from_s: [Option<f64>; GAUGES],
    /// When the indenter left the fingertip for the first time, s; none if it never did.
    pub left_at_s: Option<f64>,
}

impl Touch {
    /// Notes in the head that something happened at a time, s, so that what is found in the readings can be judged.
    pub(super) fn happened(&mut self, kind: &str, time_s: f64) {
        let other = &mut self.trace.head.setup.other;
        let list = other.entry(HAPPENED).or_insert_with(|| toml::Value::Array(Vec::new()));
        if let toml::Value::Array(list) = list {
            let entry = [("kind", kind.into()), ("time_s", time_s.into())];
            let entry = entry.map(|(key, value): (&str, toml::Value)| (key.to_owned(), value));
            list.push(Table::from_iter(entry).into());
        }
    }
}

/// Lets a fingertip feel a stroke, with the noise of a seed.
///
/// # Errors
/// [`SensorError::Range`] for a fingertip that cannot be, [`SensorError::TooDeep`] where the tip would come to the gauges.
pub fn feel(
    fingertip: &Fingertip,
    indenter: Indenter,
    stroke: &Stroke,
    name: &str,
    seed: u64,
) -> Result<Touch, SensorError> {
    fingertip.check()?;
    super::within("the tip's radius (mm)", indenter.radius_mm, 0.01, 1000.0)?;
    let deepest = stroke.depth_mm.iter().copied().fold(0.0, f64::max);
    let most_mm = DEEPEST * fingertip.cover_mm;
    if deepest > most_mm {
        return Err(SensorError::TooDeep { depth_mm: deepest, most_mm });
    }
    let mut noise = ChaCha8Rng::seed_from_u64(seed);
    let scatter = Normal::new(0.0, fingertip.noise_ustrain).ok();
    let mut surface = Surface::new(fingertip, indenter);
    let readings = relaxation(fingertip.relaxation_of_readings());
    let mut memories: [Memory; GAUGES] = std::array::from_fn(|_| Memory::rested(2));
    let mut elastic: [Vec<f64>; GAUGES] = std::array::from_fn(|_| Vec::new());
    let mut felt: [Vec<f64>; GAUGES] = std::array::from_fn(|_| Vec::new());
    let mut saturated_from_s = [None; GAUGES];
    let mut left_at_s = None;
    let mut changes = Vec::new();
    let mut force = Vec::with_capacity(stroke.time.len());
    for (k, &time) in stroke.time.iter().enumerate() {
        let interval = if k == 0 { 0.0 } else { time - stroke.time[k - 1] };
        let was_touched = surface.touched;
        let (depth, newton) = surface.follow(stroke.depth_mm[k], interval);
        force.push(newton);
        if was_touched && !surface.touched {
            left_at_s.get_or_insert(time);
        }
        if was_touched != surface.touched {
            changes.push((if surface.touched { "touch" } else { "release" }, time));
        }
        let place = stroke.place_mm[k];
        let mut at_once = fingertip.elastic_readings(indenter, depth, place);
        if let Some(pull) = stroke.pull_n.get(k) {
            let sheared = fingertip.readings_of_pull(*pull, place);
            at_once.iter_mut().zip(sheared).for_each(|(reading, more)| *reading += more);
        }
        for gauge in 0..GAUGES {
            elastic[gauge].push(at_once[gauge]);
            let reading = if k == 0 {
                memories[gauge].jump(&readings, at_once[gauge])
            } else {
                memories[gauge].step(&readings, at_once[gauge], interval)
            };
            let limit = fingertip.limit_ustrain;
            let noisy = reading + scatter.map_or(0.0, |normal| normal.sample(&mut noise));
            if noisy.abs() >= limit {
                saturated_from_s[gauge].get_or_insert(time);
            }
            felt[gauge].push(noisy.clamp(-limit, limit));
        }
    }
    let mut trace = Trace {
        head: head(fingertip, indenter, name, seed),
        time: stroke.time.clone(),
        ..Trace::default()
    };
    trace.set_column(DISPLACEMENT, stroke.depth_mm.clone());
    trace.set_column(FORCE, force);
    for (name, values) in NAMES.into_iter().zip(felt) {
        trace.set_column(name, values);
    }
    let mut touch = Touch { trace, elastic, saturated_from_s, left_at_s };
    for (kind, time) in changes {
        touch.happened(kind, time);
    }
    Ok(touch)
}

/// The relaxation function as the base laws take it.
fn relaxation(g: Relaxation) -> model::Relaxation {
    model::Relaxation::new(&[g.c1, g.c2], &[g.v1, g.v2])
}

/// The surface below the indenter: it follows the indenter, or creeps back by itself where that is above it.
struct Surface<'a> {
    fingertip: &'a Fingertip,
    indenter: Indenter,
    relaxation: model::Relaxation,
    memory: Memory,
    touched: bool,
    begun: bool,
}

impl<'a> Surface<'a> {
    fn new(fingertip: &'a Fingertip, indenter: Indenter) -> Self {
        let relaxation = relaxation(fingertip.silicone.relaxation);
        let memory = Memory::rested(2);
        Self { fingertip, indenter, relaxation, memory, touched: false, begun: false }
    }

    /// Depth of the surface, mm, and force, N, with the indenter at a depth, so many seconds after the last sample.
    fn follow(&mut self, depth_mm: f64, interval: f64) -> (f64, f64) {
        let pressed = self.fingertip.elastic_force(self.indenter, depth_mm);
        if !self.begun {
            self.begun = true;
            self.touched = pressed > 0.0;
            return (depth_mm.max(0.0), self.memory.jump(&self.relaxation, pressed));
        }
        let free = self.memory.free(&self.relaxation, interval).max(0.0);
        self.touched = pressed > free;
        if self.touched {
            return (depth_mm, self.memory.step(&self.relaxation, pressed, interval));
        }
        self.memory.step(&self.relaxation, free, interval);
        (self.fingertip.depth_of_force(self.indenter, free), 0.0)
    }
}

/// What was pressed with what, and the settings of a device that knows this silicone.
fn head(fingertip: &Fingertip, indenter: Indenter, name: &str, seed: u64) -> Head {
    let mut head = Head {
        version: Some(1),
        name: Some(name.into()),
        computed_by: Some("palpate sensor".into()),
        control: Some(Control::Displacement),
        ..Head::default()
    };
    let silicone = &fingertip.silicone;
    head.specimen.material = Some(format!("silicone:thinner {}", silicone.composition));
    head.specimen.shape = Some(Shape::Block);
    head.specimen.height_mm = Some(fingertip.thickness_mm);
    head.specimen.poisson_ratio = Some(silicone.elastic.poisson_ratio);
    let setup: [(&str, toml::Value); 4] = [
        ("simulated", true.into()),
        ("tip_radius_mm", indenter.radius_mm.into()),
        ("limit_ustrain", fingertip.limit_ustrain.into()),
        ("seed", toml::Value::Integer(i64::try_from(seed).unwrap_or(i64::MAX))),
    ];
    head.setup.other.extend(setup.map(|(key, value)| (key.to_owned(), value)));
    if let Ok(settings) = toml::Value::try_from(fingertip.settings()) {
        let device = Table::from_iter([("settings".to_owned(), settings)]);
        head.other.insert("device".into(), device.into());
    }
    head
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Silicone;

    fn fingertip() -> Fingertip {
        let silicone = Silicone::of("7:3".parse().unwrap());
        Fingertip { noise_ustrain: 0.0, ..Fingertip::new(silicone, 8.0).unwrap() }
    }

    /// Down within 0.1 s, held for 2 s, up within 0.02 s, left alone for 3 s.
    fn press(depth_mm: f64) -> Stroke {
        let time: Vec<f64> = (0..=5120).map(|k| f64::from(k) * 1e-3).collect();
        let depth = |t: &f64| (depth_mm * (t / 0.1).min((2.12 - t) / 0.02).min(1.0)).max(-1.0);
        let depth_mm = time.iter().map(depth).collect();
        Stroke { place_mm: vec![[3.0, 3.0]; time.len()], depth_mm, time, pull_n: Vec::new() }
    }

    #[test]
    fn a_press_relaxes_while_held_and_creeps_back_after_the_release() {
        let touch = feel(&fingertip(), Indenter::BLUNT, &press(0.6), "press", 1).unwrap();
        let gauge = touch.trace.column(NAMES[0]).unwrap();
        assert!(gauge[100] > gauge[2000] && gauge[2000] > 0.5 * gauge[100]);
        let left = touch.left_at_s.unwrap();
        assert!((2.1..2.13).contains(&left), "{left}");
        let residual = gauge[2150];
        assert!(residual > 0.02 * gauge[100], "{residual}");
        assert!(gauge[3000] < 0.8 * residual && gauge[5120] < 0.5 * residual && gauge[5120] > 0.0);
        assert!(touch.trace.force().unwrap()[2150..].iter().all(|force| *force == 0.0));
    }

    #[test]
    fn a_limit_cuts_off_and_says_since_when() {
        let fingertip = Fingertip { limit_ustrain: 500.0, ..fingertip() };
        let touch = feel(&fingertip, Indenter::SHARP, &press(1.0), "press", 1).unwrap();
        let gauge = touch.trace.column(NAMES[0]).unwrap();
        assert!(gauge.iter().all(|reading| reading.abs() <= 500.0));
        let since = touch.saturated_from_s[0].unwrap();
        assert!(since < 0.1 && gauge[(since * 1e3) as usize + 1] == 500.0);
    }

    #[test]
    fn a_tip_that_would_reach_the_gauges_is_refused() {
        let error = feel(&fingertip(), Indenter::SHARP, &press(4.0), "press", 1).unwrap_err();
        assert!(error.to_string().contains("press less"), "{error}");
    }

    #[test]
    fn the_same_seed_reads_the_same_and_another_one_otherwise() {
        let noisy = Fingertip { noise_ustrain: 0.2, ..fingertip() };
        let read = |seed| {
            let touch = feel(&noisy, Indenter::BLUNT, &press(0.3), "press", seed).unwrap();
            touch.trace.column(NAMES[2]).unwrap().to_vec()
        };
        assert_eq!(read(1), read(1));
        assert_ne!(read(1), read(2));
    }
}
