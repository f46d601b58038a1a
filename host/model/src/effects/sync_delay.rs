//! `sync-delay`: the clocks of motion and force do not agree.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Scene, Stage};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "sync-delay",
    stage: Stage::Motion,
    meaning: "Displacement and force were recorded by devices whose clocks differ, or one of them passed through a buffer.",
    signature: "Grows with the slope of the force over time; corners are shifted but stay sharp, and so do touch-on and touch-off.",
    against: Covariate::Velocity,
    confused_with: &["sensor-lag", "fast-mode"],
    experiment: "Press a rigid block at fifty times the rate: a shift leaves the corners sharp, a lag rounds them.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "x(t) → x(t − δ)",
            strength: Strength {
                name: "delay",
                unit: "s",
                meaning: "time by which the motion reaches the specimen later than recorded",
                sign: Sign::Either,
                typical: |scales| 0.4 * scales.interval,
                most: |scales| (10.0 * scales.interval).max(0.05),
                count: Count::Fixed(&[]),
            },
            shapes: &[],
            act: Act::Compression(|scene, parameters, _, x| shift(scene, |_| parameters[0], x)),
        },
        Law {
            name: "growing",
            formula: "x(t) → x(t − δ (1 + t/T)), t since the trace began",
            strength: Strength {
                name: "delay",
                unit: "s",
                meaning: "delay at the beginning of a trace",
                sign: Sign::Either,
                typical: |scales| 0.4 * scales.interval,
                most: |scales| (10.0 * scales.interval).max(0.05),
                count: Count::Fixed(&[]),
            },
            shapes: &[Shape {
                name: "doubling",
                unit: "s",
                meaning: "time in which the clocks drift apart by as much again",
                grid: |scales| vec![0.5 * scales.duration],
                role: Role::Fitted(|scales| (0.1 * scales.duration, 100.0 * scales.duration)),
            }],
            act: Act::Compression(|scene, parameters, _, x| {
                shift(scene, |k| parameters[0] * (1.0 + scene.since[k] / parameters[1]), x);
            }),
        },
    ],
};

/// The motion is straight between samples, and rests before the first and after the last.
fn shift(scene: &Scene, delay: impl Fn(usize) -> f64, x: &mut [f64]) {
    let time = &scene.motion.time;
    let commanded = x.to_vec();
    // The last sample that is not later than the one looked for.
    let mut at = 0;
    for (k, (x, now)) in x.iter_mut().zip(time.iter()).enumerate() {
        let then = now - delay(k);
        while at + 1 < time.len() && time[at + 1] <= then {
            at += 1;
        }
        *x = if then <= time[0] || at + 1 == time.len() {
            commanded[at]
        } else {
            let part = (then - time[at]) / (time[at + 1] - time[at]);
            commanded[at] + part * (commanded[at + 1] - commanded[at])
        };
    }
}
