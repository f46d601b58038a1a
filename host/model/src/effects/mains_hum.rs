//! `mains-hum`: the mains leak into the signal.

use std::f64::consts::TAU;

use super::line_around::line_around;
use super::{Count, Covariate, Effect, FOLLOWED, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Remembered, Scene, Stage};

const AMPLITUDE: Strength = Strength {
    name: "hum",
    unit: "N",
    meaning: "amplitude of the hum in this phase",
    sign: Sign::Either,
    typical: |scales| 0.003 * scales.force,
    most: |scales| 0.2 * scales.force,
    count: Count::Fixed(&["sine", "cosine"]),
};

const FREQUENCY: Shape = Shape {
    name: "frequency",
    unit: "Hz",
    meaning: "frequency of the mains; the samples may show its alias",
    grid: |scales| scales.mains.unwrap_or([50.0, 60.0]).to_vec(),
    role: Role::Fitted(|_| (48.5, 61.5)),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "mains-hum",
    stage: Stage::Sensor,
    meaning: "Mains couple into cables or amplifier; where sampling is slow, their alias shows.",
    signature: "One line in the spectrum, the same loaded and unloaded, in motion and at rest.",
    against: Covariate::Time,
    confused_with: &[],
    experiment: "Record a minute with no load, then with the drive switched off; and at another sampling rate, where an alias moves.",
    needs: Needs::FastSampling,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + A sin(2π f t_set) + B cos(2π f t_set)",
            strength: AMPLITUDE,
            shapes: &[FREQUENCY],
            act: Act::Added(|scene, parameters, _, force| {
                let frequency = parameters[2];
                hum(force, &parameters[..2], |k| frequency * scene.set_time(k));
            }),
        },
        Law {
            name: "each-trace",
            formula: "F → F + A sin(2π f t) + B cos(2π f t), t since each trace began",
            strength: AMPLITUDE,
            shapes: &[FREQUENCY],
            act: Act::Added(|scene, parameters, _, force| {
                let frequency = parameters[2];
                hum(force, &parameters[..2], |k| frequency * scene.since[k]);
            }),
        },
        Law {
            name: "free-phase",
            formula: "F → F + A sin(2π f t) + B cos(2π f t), one A and one B for each trace",
            strength: Strength { count: Count::EachTrace(&["sine", "cosine"]), ..AMPLITUDE },
            shapes: &[FREQUENCY],
            act: Act::Added(free_phase),
        },
        Law {
            name: FOLLOWED,
            formula: "F → F + g h(t), h the line at f that the signal shows in the 2 s around t, less those next to t",
            strength: Strength {
                name: "share",
                unit: "1",
                meaning: "part of the line which the seconds around a sample show that is in it",
                sign: Sign::Positive,
                typical: |_| 1.0,
                most: |_| 4.0,
                count: Count::Fixed(&[]),
            },
            shapes: &[Shape {
                name: "about",
                unit: "Hz",
                meaning: "frequency about which the line is followed",
                grid: |scales| vec![scales.line.unwrap_or(50.0)],
                role: Role::Given,
            }],
            act: Act::Added(followed),
        },
    ],
};

/// Adds a hum of this sine and cosine, `turns` at each sample.
fn hum(force: &mut [f64], amplitudes: &[f64], turns: impl Fn(usize) -> f64) {
    for (k, force) in force.iter_mut().enumerate() {
        let (sine, cosine) = (TAU * turns(k)).sin_cos();
        *force += amplitudes[0] * sine + amplitudes[1] * cosine;
    }
}

fn free_phase(scene: &Scene, parameters: &[f64], _: &mut Remembered, force: &mut [f64]) {
    let at = 2 * scene.trace;
    if let (Some(frequency), Some(amplitudes)) = (parameters.last(), parameters.get(at..at + 2)) {
        hum(force, amplitudes, |k| frequency * scene.since[k]);
    }
}

/// The mains wander, and amplitudes swell: of a hum whose phase no clock foretells, the samples around tell it.
fn followed(scene: &Scene, parameters: &[f64], _: &mut Remembered, force: &mut [f64]) {
    let &[share, about] = parameters else { return };
    if share == 0.0 || scene.measured.len() != force.len() {
        return;
    }
    let line = line_around(&scene.since, scene.measured, about);
    force.iter_mut().zip(line).for_each(|(force, line)| *force += share * line);
}
