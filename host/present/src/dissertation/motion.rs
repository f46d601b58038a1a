//! Figs 5.2 and 5.5 in kind: the gripper's motion with its inertial force, and force, displacement and loop of one press.

use palpate_model::{Hold, Move, Profile, Step};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Panels, Plot, Section, Series};
use palpate_trace::Trace;

/// Mass of the gripper, kg, its largest acceleration, mm/s², and the accuracy of the load cell, N (5.3.1).
const MASS_KG: f64 = 14e-3;
const ACCELERATION: f64 = 5000.0;
const ACCURACY_N: f64 = 0.25;
/// Compression, mm, and speed, mm/s: the fastest.
const COMPRESSION: f64 = 6.0;
const SPEED: f64 = 100.0;
/// Samples per second.
const SAMPLING: f64 = 2000.0;

/// Both figures; the run is the press at the highest rate.
pub(super) fn section(run: Option<&Trace>) -> Section {
    let motion = Motion::new();
    let section = Section::new("How the gripper moves")
        .figure(
            motion.figure(),
            "Fig. 5.2 in kind: a trapezoid of speed with the printed limit of acceleration; speed and acceleration are \
             differences of the displacement, the inertial force is 14 g times the acceleration.",
        )
        .callout(
            Callout::Finding,
            "Inertia",
            format!(
                "The largest inertial force is {} N, {} % of the load cell's accuracy of {ACCURACY_N} N.",
                significant(motion.largest_force(), 2),
                significant(100.0 * motion.largest_force() / ACCURACY_N, 2)
            ),
        );
    match run {
        None => section,
        Some(run) => section
            .figure(course(run), "Fig. 5.5 in kind: the soft silicone at 100 mm/s.")
            .figure(looped(run), "Fig. 5.5 in kind, right: force over displacement."),
    }
}

struct Motion {
    time: Vec<f64>,
    x: Vec<f64>,
    speed: Vec<f64>,
    acceleration: Vec<f64>,
}

impl Motion {
    fn new() -> Self {
        let motion = Profile {
            version: 1,
            rate_hz: SAMPLING,
            start_mm: 0.0,
            speed_mm_per_s: SPEED,
            acceleration_mm_per_s2: Some(ACCELERATION),
            repeat: 1,
            steps: vec![
                Step::Hold(Hold { hold_s: 0.05 }),
                Step::Move(Move { to_mm: COMPRESSION, speed_mm_per_s: None }),
                Step::Hold(Hold { hold_s: 0.1 }),
                Step::Move(Move { to_mm: 0.0, speed_mm_per_s: None }),
                Step::Hold(Hold { hold_s: 0.05 }),
            ],
        }
        .motion();
        let (time, x) = (motion.time.to_vec(), motion.displacement.to_vec());
        let speed = slope(&time, &x);
        let acceleration = slope(&time, &speed);
        Self { time, x, speed, acceleration }
    }

    fn force(&self) -> Vec<f64> {
        self.acceleration.iter().map(|a| MASS_KG * 1e-3 * a).collect()
    }

    fn largest_force(&self) -> f64 {
        self.force().iter().fold(0.0, |most: f64, force| most.max(force.abs()))
    }

    fn figure(&self) -> Panels {
        let plot = |name: &str, unit: &str, values: &[f64], hue| {
            Plot::new("", Axis::new("time", "s"), Axis::new(name, unit))
                .series(Series::line("", &self.time[..], values).colour(Colour::Hue(hue)))
                .height(110.0)
        };
        Panels::new("")
            .summary("Displacement, speed, acceleration and inertial force over time")
            .plot(plot("displacement", "mm", &self.x, 0))
            .plot(plot("speed", "mm/s", &self.speed, 2))
            .plot(plot("acceleration", "mm/s²", &self.acceleration, 3))
            .plot(plot("inertial force", "N", &self.force(), 1))
    }
}

/// Central differences; at the ends those of one side.
fn slope(time: &[f64], values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        if a == b { 0.0 } else { (values[b] - values[a]) / (time[b] - time[a]) }
    };
    (0..values.len()).map(at).collect()
}

fn course(run: &Trace) -> Panels {
    let line = |values: Option<&[f64]>| Series::line("", &run.time[..], values.unwrap_or_default());
    let plot =
        |name: &str, unit: &str| Plot::new("", Axis::new("time", "s"), Axis::new(name, unit));
    Panels::new("")
        .summary("Force and displacement of one press over time")
        .plot(plot("force", "N").series(line(run.force()).colour(Colour::MEASURED)))
        .plot(plot("displacement", "mm").series(line(run.displacement())).height(130.0))
}

fn looped(run: &Trace) -> Plot {
    let (x, force) = (run.displacement().unwrap_or_default(), run.force().unwrap_or_default());
    Plot::new("", Axis::new("displacement", "mm"), Axis::new("force", "N"))
        .summary("Force over displacement of one press")
        .series(Series::line("", x, force).colour(Colour::MEASURED))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inertial_force_is_the_printed_one_and_the_gripper_comes_back() {
        let motion = Motion::new();
        assert!((motion.largest_force() - 0.07).abs() < 1e-3, "{}", motion.largest_force());
        let fastest = motion.speed.iter().copied().fold(0.0, f64::max);
        assert!((fastest - SPEED).abs() < 1e-6, "{fastest}");
        assert!(motion.x.last().unwrap().abs() < 1e-9);
    }
}
