//! `sensor-lag`: the signal follows the force with a delay and rounds its corners.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::low_pass;
use crate::{Act, Remembered, Scene, Stage};

const TIME: Strength = Strength {
    name: "time",
    unit: "s",
    meaning: "time constant of the sensor",
    sign: Sign::Positive,
    typical: |scales| 0.4 * scales.interval,
    most: |scales| (10.0 * scales.interval).max(0.2),
    count: Count::Fixed(&[]),
};

/// A time shorter than this, s, is none.
const INSTANT: f64 = 1e-9;

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "sensor-lag",
    stage: Stage::Sensor,
    meaning: "A filter in the amplifier, or the sensor itself, takes milliseconds to follow the force.",
    signature: "Grows with the slope of the force over time; corners are rounded.",
    against: Covariate::Velocity,
    confused_with: &["sync-delay", "fast-mode"],
    experiment: "Press a rigid block at fifty times the rate: a sensor still lags there, the specimen is gone.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "τ dF_out/dt = F − F_out",
            strength: TIME,
            shapes: &[],
            act: Act::Force(first_order),
        },
        Law {
            name: "second-order",
            formula: "τ² d²F_out/dt² + 2 ζ τ dF_out/dt = F − F_out",
            strength: TIME,
            shapes: &[Shape {
                name: "damping",
                unit: "",
                meaning: "damping ratio ζ",
                grid: |_| vec![0.7],
                role: Role::Fitted(|_| (0.1, 5.0)),
            }],
            act: Act::Force(second_order),
        },
        Law {
            name: "average",
            formula: "F_out = mean of F over the last τ",
            strength: Strength {
                meaning: "time over which the sensor takes the mean",
                typical: |scales| 0.8 * scales.interval,
                ..TIME
            },
            shapes: &[],
            act: Act::Force(average),
        },
    ],
};

/// Exact for a force that is straight between samples; settled at the first.
fn first_order(scene: &Scene, parameters: &[f64], _: &mut Remembered, force: &mut [f64]) {
    let time = &scene.motion.time;
    if parameters[0] < INSTANT {
        return;
    }
    let mut before = force.first().copied().unwrap_or_default();
    for k in 1..force.len() {
        let ahead = force[k];
        let turns = (time[k] - time[k - 1]) / parameters[0];
        force[k] = low_pass(force[k - 1], before, ahead, turns);
        before = ahead;
    }
}

/// Exact for a force that is straight between samples; settled at the first.
fn second_order(scene: &Scene, parameters: &[f64], _: &mut Remembered, force: &mut [f64]) {
    let (time, &[constant, damping]) = (&scene.motion.time, parameters) else { return };
    if constant < INSTANT {
        return;
    }
    let frequency = 1.0 / constant;
    let swing = frequency * (1.0 - damping * damping).abs().sqrt();
    let (mut before, mut rate) = (force.first().copied().unwrap_or_default(), 0.0);
    for k in 1..force.len() {
        let (ahead, interval) = (force[k], time[k] - time[k - 1]);
        let slope = (ahead - before) / interval;
        // The output trails a ramp by this much; what it is off from there swings freely.
        let trail = 2.0 * damping * constant * slope;
        let (off, off_rate) = (force[k - 1] - before + trail, rate - slope);
        let decay = (-damping * frequency * interval).exp();
        let angle = swing * interval;
        // Beyond critical damping the swing is two decays, and cosine and sine are hyperbolic.
        let (cosine, sine) =
            if damping > 1.0 { (angle.cosh(), angle.sinh()) } else { (angle.cos(), angle.sin()) };
        let sine = if angle > 1e-6 { sine / swing } else { interval };
        let damped = damping * frequency;
        force[k] = ahead - trail + decay * (off * (cosine + damped * sine) + off_rate * sine);
        rate = slope
            + decay * (off_rate * (cosine - damped * sine) - frequency * frequency * off * sine);
        before = ahead;
    }
}

/// Exact for a force that is straight between samples, and before the first what it is there.
fn average(scene: &Scene, parameters: &[f64], _: &mut Remembered, force: &mut [f64]) {
    let (time, window) = (&scene.motion.time, parameters[0]);
    if window < INSTANT {
        return;
    }
    let input = force.to_vec();
    // The sample before the window begins, and the integral from there to the sample at hand.
    let (mut at, mut sum) = (0, 0.0);
    let area = |k: usize| 0.5 * (input[k] + input[k + 1]) * (time[k + 1] - time[k]);
    for k in 1..force.len() {
        sum += area(k - 1);
        let begin = time[k] - window;
        while at + 1 < k && time[at + 1] <= begin {
            sum -= area(at);
            at += 1;
        }
        // What lies between that sample and the window, negative where the window begins earlier.
        let outside = if begin <= time[0] {
            input[0] * (begin - time[0])
        } else {
            let part = begin - time[at];
            let slope = (input[at + 1] - input[at]) / (time[at + 1] - time[at]);
            (input[at] + 0.5 * slope * part) * part
        };
        force[k] = (sum - outside) / window;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    /// Runs a law over a force that is straight between three points, sampled at `interval`.
    fn run(law: usize, parameters: &[f64], interval: f64) -> f64 {
        let count = (1.2 / interval).round() as usize;
        let time: Vec<f64> = (0..=count).map(|k| interval * k as f64).collect();
        let mut force: Vec<f64> = time.iter().map(|t| 1.0 + (t - 0.4).max(0.0)).collect();
        let motion =
            Motion { time: (&time).into(), displacement: (&time).into(), rest_before: None };
        let scene = Scene {
            trace: 0,
            motion: &motion,
            since: (&time).into(),
            begin: 0.0,
            velocity: (&time).into(),
            acceleration: (&time).into(),
            loadings: (&time).into(),
            largest: (&time).into(),
            warmth: None,
            channels: &[],
            measured: &[],
        };
        let Act::Force(act) = &EFFECT.laws[law].act else { panic!("a lag acts on the force") };
        act(&scene, parameters, &mut Vec::new(), &mut force);
        force[count]
    }

    #[test]
    fn lags_are_exact_on_a_ramp_in_steps_of_any_size() {
        for interval in [0.4, 0.1, 0.004] {
            let first = 1.8 - 0.3 * (1.0 - (-0.8f64 / 0.3).exp());
            assert!((run(0, &[0.3], interval) - first).abs() < 1e-12, "{interval}");
            // Critical damping: y = x − 2 τ + (2 τ + t) e^(−t/τ) on a ramp that begins at t = 0.
            let second = 1.8 - 0.4 + (0.4 + 0.8) * (-0.8f64 / 0.2).exp();
            assert!((run(1, &[0.2, 1.0], interval) - second).abs() < 1e-9, "{interval}");
            assert!((run(2, &[0.3], interval) - (1.8 - 0.15)).abs() < 1e-12, "{interval}");
            assert!((run(2, &[2.0], interval) - (1.0 + 0.16)).abs() < 1e-12, "{interval}");
        }
    }
}
