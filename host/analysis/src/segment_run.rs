//! The simulation of 7.4 along a motion: segments from the contact to the middle, each relaxing by eq. 7.10, and the force
//! of the contact by eq. 7.11, F = E ε1 A.
//!
//! Each face of the specimen moves by the part of the displacement that [`Faces`] says; the segments reach from there to
//! what does not move: the middle where both faces move, the far face where one does. Strain is positive in compression.

use super::geometry::{Faces, Geometry, GeometryError};
use palpate_model::{Equilibrium, Segments};
use palpate_trace::{DISPLACEMENT, FORCE, SignalError, Trace};

/// What is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The specimen.
    pub geometry: Geometry,
    /// Which faces move.
    pub faces: Faces,
    /// Modulus E, Pa.
    pub modulus_pa: f64,
    /// Segments m from the face to what does not move; at least 2.
    pub segments: usize,
    /// Power n of (7.10).
    pub order: f64,
    /// Rate ν, 1/s, at a latent strain of one.
    pub rate: f64,
}

impl Setting {
    /// Length from a face to what does not move, mm; of a ball its radius, to the plane of symmetry, in both cases
    /// (Fig. 7.7).
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        match (self.geometry, self.faces) {
            (Geometry::Ball { radius_mm, .. }, _) => radius_mm,
            (geometry, Faces::One) => geometry.height_mm(),
            (geometry, Faces::Each) => 0.5 * geometry.height_mm(),
        }
    }

    /// How far a face moves, mm, at a displacement, mm.
    fn face(&self, displacement_mm: f64) -> f64 {
        let share = if self.faces == Faces::One { 1.0 } else { 0.5 };
        share * displacement_mm.max(0.0)
    }

    /// Force, N, at each time, s, while the displacement goes along `x`, mm (7.11).
    #[must_use]
    pub fn force(&self, time: &[f64], x: &[f64]) -> Vec<f64> {
        let length = self.length_mm();
        let segments = Segments {
            count: self.segments,
            rate: self.rate / length.powf(self.order - 1.0),
            exponent: self.order,
            equilibrium: Equilibrium::OwnNode,
        };
        let face: Vec<f64> = x.iter().map(|x| self.face(*x)).collect();
        let latent = segments.at_contact(time, &face);
        let strains = face.iter().zip(&latent).map(|(face, latent)| (face + latent) / length);
        let force = |(x, strain): (&f64, f64)| {
            (1e-6 * self.modulus_pa * strain * self.geometry.area_mm2(*x)).max(0.0)
        };
        x.iter().zip(strains).map(force).collect()
    }
}

/// A simulation beside the force that was measured.
#[derive(Clone, Debug)]
pub struct SegmentRun {
    /// Name of the trace.
    pub trace: String,
    /// What was simulated, with ν as asked or as fitted.
    pub setting: Setting,
    /// Whether ν was fitted to the force.
    pub fitted: bool,
    /// Time, s.
    pub time: Vec<f64>,
    /// Displacement, mm.
    pub displacement_mm: Vec<f64>,
    /// Measured force, N.
    pub measured_n: Vec<f64>,
    /// Simulated force, N.
    pub force_n: Vec<f64>,
    /// Root mean square of the difference, N.
    pub rms_n: f64,
    /// The modulus that would fit best with this ν, Pa: the force is proportional to it.
    pub best_modulus_pa: f64,
}

/// Why a trace cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum SegmentRunError {
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error("{trace}: the displacement never goes above zero, so nothing is pressed")]
    NoContact { trace: String },
}

/// Decades of pace in which ν is looked for, 1/s at the largest strain, and steps of the first search.
const PACES: (f64, f64) = (-4.0, 5.0);
const STEPS: u32 = 45;

/// Simulates the motion of a trace; without a rate, ν is the one whose force is nearest to the measured one.
///
/// # Errors
/// When displacement or force is not there, or nothing is pressed.
pub fn segment_run(
    trace: &Trace,
    setting: &Setting,
    rate: Option<f64>,
) -> Result<SegmentRun, SegmentRunError> {
    let (x, measured) = (trace.changing(DISPLACEMENT)?, trace.changing(FORCE)?);
    let largest = x.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return Err(SegmentRunError::NoContact { trace: trace.label() });
    }
    let force_at = |rate: f64| Setting { rate, ..*setting }.force(&trace.time, x);
    let strain = setting.face(largest) / setting.length_mm();
    let at = |pace: f64| 10f64.powf(pace) / strain.powf(setting.order - 1.0);
    let miss = |pace: f64| rms(&force_at(at(pace)), measured);
    let found = rate.unwrap_or_else(|| at(least(miss, PACES)));
    let force_n = force_at(found);
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let stiffer = product(measured, &force_n) / product(&force_n, &force_n);
    Ok(SegmentRun {
        trace: trace.label(),
        setting: Setting { rate: found, ..*setting },
        fitted: rate.is_none(),
        time: trace.time.clone(),
        displacement_mm: x.to_vec(),
        measured_n: measured.to_vec(),
        rms_n: rms(&force_n, measured),
        best_modulus_pa: setting.modulus_pa * stiffer,
        force_n,
    })
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}

/// Where a function is least: on a grid, then by thirds about its best point.
fn least(of: impl Fn(f64) -> f64, (from, to): (f64, f64)) -> f64 {
    let step = (to - from) / f64::from(STEPS);
    let grid = (0..=STEPS).map(|k| from + step * f64::from(k)).map(|x| (x, of(x)));
    let best = grid.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(from, |(x, _)| x);
    let (mut low, mut high) = (best - step, best + step);
    for _ in 0..40 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if of(a) < of(b) {
            high = b;
        } else {
            low = a;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::Column;

    /// Fig. 7.8: 5 mm steps with holds of 10 s at 500 mm/min.
    fn run(setting: &Setting, noise: f64) -> Trace {
        let time: Vec<f64> = (0..2650).map(|k| f64::from(k) / 50.0).collect();
        let speed = 500.0 / 60.0;
        let x = |t: f64| {
            let (step, within) = ((t / 10.6).floor(), t % 10.6);
            5.0 * step + (speed * within).min(5.0)
        };
        let x: Vec<f64> = time.iter().map(|t| x(*t)).collect();
        let scatter = |k: usize| noise * (((k * 7919) % 101) as f64 / 50.0 - 1.0);
        let force = setting.force(&time, &x);
        let force = force.iter().enumerate().map(|(k, force)| force + scatter(k)).collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        Trace {
            time,
            columns: vec![column(DISPLACEMENT, x), column(FORCE, force)],
            ..Trace::default()
        }
    }

    const BALL: Setting = Setting {
        geometry: Geometry::Ball { radius_mm: 35.0, faces: Faces::Each },
        faces: Faces::Each,
        modulus_pa: 2.8e4,
        segments: 8,
        order: 5.0,
        rate: 2.0e4,
    };

    #[test]
    fn the_rate_that_made_a_recording_is_found_again_and_the_force_with_it() {
        let cylinder = Geometry::Cylinder { radius_mm: 25.0, height_mm: 60.0, poisson: 0.48 };
        let other =
            Setting { geometry: cylinder, faces: Faces::One, order: 1.0, rate: 0.5, ..BALL };
        for setting in [BALL, other] {
            let trace = run(&setting, 0.05);
            let found = segment_run(&trace, &Setting { rate: f64::NAN, ..setting }, None).unwrap();
            assert!(
                found.fitted && (found.setting.rate / setting.rate - 1.0).abs() < 0.02,
                "{:?}",
                found.setting
            );
            assert!(found.rms_n < 0.05, "{}", found.rms_n);
            assert!((found.best_modulus_pa / 2.8e4 - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn the_force_at_rest_is_that_of_an_even_strain() {
        // Linear and waited for long: ε = d/2 over the radius.
        let setting = Setting { order: 1.0, rate: 2.0, ..BALL };
        let time: Vec<f64> = (0..2000).map(|k| 0.05 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| (10.0 * t).min(10.0)).collect();
        let last = *setting.force(&time, &x).last().unwrap();
        let area = setting.geometry.area_mm2(10.0);
        assert!((last / (2.8e4 * 1e-6 * 5.0 / 35.0 * area) - 1.0).abs() < 1e-9, "{last}");
    }
}
