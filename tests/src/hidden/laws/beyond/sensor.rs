//! Of the sensor.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;

use super::super::{Recipe, Setting, one};
use super::{adds, newtons};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::{Act, Now};

/// The amplifier swings when a recording begins, and calms down.
pub(super) fn breathing(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (period, calms) = (even(random, 0.8, 2.5), even(random, 1.0, 4.0));
    let phase = even(random, 0.0, TAU);
    let shape =
        move |now: &Now<'_>, _| (-now.time / calms).exp() * (TAU * now.time / period + phase).sin();
    let inner = vec![("period_s", period), ("calms_s", calms), ("phase_rad", phase)];
    let form = "F + s e^(-t/tau) sin(2 pi t/period + phase)";
    adds(form, inner, newtons(setting), Act::Sensor, shape)
}

/// The converter errs along a sawtooth of the signal.
pub(super) fn staircase(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let step = even(random, 0.08, 0.25) * setting.full_scale;
    let sign = sign(random);
    let shape = move |_: &Now<'_>, force: f64| {
        let turns = force / step;
        sign * (turns - turns.floor() - 0.5)
    };
    adds("F + s (frac(F/step) - 1/2)", vec![("step_N", step)], newtons(setting), Act::Sensor, shape)
}

/// Something turns over with the direction of the motion, and late.
pub(super) fn late_direction(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let late = log_even(random, 0.2, 0.8);
    let guess = 0.005 * setting.full_scale;
    Recipe {
        form: "F + s y, tau dy/dt = sgn(v) - y",
        inner: vec![("tau_s", late)],
        unit: "N",
        guess,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut behind = 0.0;
            one(Act::Sensor(Box::new(move |now, force| {
                let way = if now.speed == 0.0 { 0.0 } else { now.speed.signum() };
                behind = way + (behind - way) * (-now.step / late).exp();
                force + s * behind
            })))
        }),
    }
}

/// A cable is dragged along: it pulls the more the farther out and the faster.
pub(super) fn cable(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (power, bend) = (even(random, 0.2, 0.6), even(random, 2.0, 6.0));
    let side = sign(random);
    let shape =
        move |now: &Now<'_>, _| side * (now.speed.abs() / 20.0).powf(power) * (now.x / bend).atan();
    let inner = vec![("m", power), ("bend_mm", bend)];
    adds("F + s |v/20|^m atan(x/b)", inner, newtons(setting), Act::Sensor, shape)
}

/// The bridge warms itself by what it carries, and its zero follows.
pub(super) fn self_heating(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (late, full) = (log_even(random, 1.0, 8.0), setting.full_scale);
    let (unit, guess, most) = newtons(setting);
    Recipe {
        form: "F + s y, tau dy/dt = (F/FS)^2 - y",
        inner: vec![("tau_s", late)],
        unit,
        guess,
        most,
        act: Box::new(move |s| {
            let mut warm = 0.0;
            one(Act::Sensor(Box::new(move |now, force| {
                let power = (force / full).powi(2);
                warm = power + (warm - power) * (-now.step / late).exp();
                force + s * warm
            })))
        }),
    }
}

/// The supply of the bridge beats, and the gain with it.
pub(super) fn beat(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (period, phase) = (even(random, 0.5, 3.0), even(random, 0.0, TAU));
    let shape = move |now: &Now<'_>, force: f64| force * (TAU * now.time / period + phase).sin();
    let inner = vec![("period_s", period), ("phase_rad", phase)];
    adds("F (1 + s sin(2 pi t/period + phase))", inner, ("", 0.01, 0.5), Act::Sensor, shape)
}

/// The frame swings out after every stop, slowly and well damped.
pub(super) fn swing_out(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (period, calms) = (even(random, 0.6, 1.8), even(random, 0.4, 1.2));
    let (unit, guess, most) = newtons(setting);
    Recipe {
        form: "F + s e^(-h/tau) sin(2 pi h/period) sqrt(|v_0|/20), h = time since the stop from v_0",
        inner: vec![("period_s", period), ("tau_s", calms)],
        unit,
        guess,
        most,
        act: Box::new(move |s| {
            let (mut held, mut fastest) = (0.0, 0.0_f64);
            one(Act::Sensor(Box::new(move |now, force| {
                if now.speed != 0.0 {
                    fastest = if held > 0.0 { 0.0 } else { fastest.max(now.speed.abs()) };
                    held = 0.0;
                    return force;
                }
                held += now.step;
                let swing = (-held / calms).exp() * (TAU * held / period).sin();
                force + s * swing * (fastest / 20.0).sqrt()
            })))
        }),
    }
}
