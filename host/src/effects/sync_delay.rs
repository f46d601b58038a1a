//! `sync-delay`: the clocks of motion and force do not agree.

use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::model::{Act, Remembered, Scene, Stage};

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
    laws: &[Law {
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
        act: Act::Compression(shift),
    }],
};

/// The motion is straight between samples, and rests before the first and after the last.
fn shift(scene: &Scene, parameters: &[f64], _: &mut Remembered, x: &mut [f64]) {
    let time = &scene.motion.time;
    let commanded = x.to_vec();
    // The last sample that is not later than the one looked for.
    let mut at = 0;
    for (x, now) in x.iter_mut().zip(time.iter()) {
        let then = now - parameters[0];
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
