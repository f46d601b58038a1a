//! What the library of effects does not hold.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp1};

use super::contact::Oscillator;
use super::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::Act;

/// A strut inside buckles: the elastic response dips around one compression.
pub fn snap(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (at, width) = (even(random, 2.0, 7.0), even(random, 0.2, 0.6));
    let scale = setting.base.elastic(at);
    Recipe {
        form: "N - s N(x_s) e^(-((x - x_s)/w)^2)",
        inner: vec![("x_s_mm", at), ("w_mm", width)],
        unit: "",
        guess: 0.05,
        most: 2.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                n - s * scale * (-((x - at) / width).powi(2)).exp()
            })))
        }),
    }
}

/// The teeth of a drive: a force periodic in the commanded displacement.
pub fn cogging(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (pitch, phase) = (even(random, 0.6, 2.2), even(random, 0.0, TAU));
    Recipe {
        form: "F + A sin(2 pi x/pitch + phase)",
        inner: vec![("pitch_mm", pitch), ("phase_rad", phase)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            one(Act::Contact(Box::new(move |now, f| f + s * (TAU * now.x / pitch + phase).sin())))
        }),
    }
}

/// The specimen slips sideways once the force passes a threshold, until contact is lost.
pub fn slip(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let threshold = even(random, 0.25, 0.5) * setting.full_scale;
    Recipe {
        form: "F (1 - s) from where F passes a threshold until contact is lost",
        inner: vec![("threshold_N", threshold)],
        unit: "",
        guess: 0.02,
        most: 0.8,
        act: Box::new(move |s| {
            let mut slipped = false;
            one(Act::Contact(Box::new(move |_, force| {
                slipped = force > threshold || (slipped && force > 0.0);
                if slipped { force * (1.0 - s) } else { force }
            })))
        }),
    }
}

/// A knock in every hold sets part of the relaxation back.
pub fn tap(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let waits: Vec<f64> = (0..setting.traces).map(|_| even(random, 0.8, 2.5)).collect();
    Recipe {
        form: "at a time in each hold the branches get back s N",
        inner: vec![],
        unit: "",
        guess: 0.03,
        most: 2.0,
        act: Box::new(move |s| {
            let waits = waits.clone();
            let (mut held, mut given) = (0.0, 0.0);
            let mut done = false;
            one(Act::Drive(Box::new(move |now, x, n| {
                let holding = x > 0.0 && now.speed == 0.0;
                held = if holding { held + now.step } else { 0.0 };
                done &= holding;
                if holding && !done && held >= waits[now.trace] {
                    done = true;
                    given += s * n;
                }
                n + given
            })))
        }),
    }
}

/// The gain is one in even traces and another in odd ones.
pub fn parity_gain(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "F (1 + s) in even traces, F (1 - s) in odd ones",
        inner: vec![],
        unit: "",
        guess: 0.005 * sign(random),
        most: 0.5,
        act: Box::new(|s| {
            one(Act::Sensor(Box::new(move |now, force| {
                force * if now.trace % 2 == 0 { 1.0 + s } else { 1.0 - s }
            })))
        }),
    }
}

/// The frame rings for a second after every corner.
pub fn ringing(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (frequency, damping) = (even(random, 4.0, 12.0), even(random, 0.02, 0.05));
    Recipe {
        form: "F + m y, y'' + 2 zeta omega y' + omega^2 y = omega^2 a, lightly damped",
        inner: vec![("frequency_Hz", frequency), ("zeta", damping)],
        unit: "N s^2/mm",
        guess: 1e-5 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut frame = Oscillator::new(frequency, damping);
            one(Act::Sensor(Box::new(move |now, force| {
                force + s * frame.advance(now.step, now.acceleration)
            })))
        }),
    }
}

/// Skin cracks at random moments of loading: each time the force drops and heals.
pub fn crackling(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (spacing, heals) = (even(random, 0.6, 2.0), log_even(random, 0.03, 0.3));
    // Way between cracks, mm, and the size of each.
    let cracks: Vec<(f64, f64)> = (0..500)
        .map(|_| {
            let (way, size): (f64, f64) = (Exp1.sample(random), Exp1.sample(random));
            (spacing * way, size)
        })
        .collect();
    Recipe {
        form: "at random ways of loading F drops by s F times an exponential size and heals",
        inner: vec![("spacing_mm", spacing), ("heals_s", heals)],
        unit: "",
        guess: 0.02,
        most: 1.0,
        act: Box::new(move |s| {
            let cracks = cracks.clone();
            let (mut next, mut way, mut drop) = (0, 0.0, 0.0);
            one(Act::Contact(Box::new(move |now, force| {
                drop *= (-now.step / heals).exp();
                if now.x > 0.0 && now.speed > 0.0 {
                    way += now.speed * now.step;
                }
                let (until, size) = cracks[next % cracks.len()];
                if way > until {
                    (next, way) = (next + 1, 0.0);
                    drop += s * size * force;
                }
                (force - drop).max(force.min(0.0))
            })))
        }),
    }
}
