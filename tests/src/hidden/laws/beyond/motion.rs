//! Of the machine: where the tip is.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;

use super::super::{Recipe, Setting, one};
use super::{adds, triangle};
use crate::hidden::random::{even, log_even};
use crate::hidden::specimen::{Act, Now};

/// The pitch of a screw errs: the place is off along a wave of straight flanks.
pub(super) fn screw(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (pitch, phase) = (even(random, 1.5, 4.0), even(random, 0.0, 1.0));
    let inner = vec![("pitch_mm", pitch), ("phase", phase)];
    let size = ("mm", 0.01, 1.0);
    adds("x + s triangle(x/pitch + phase)", inner, size, Act::Motion, move |now, _| {
        triangle(now.x / pitch + phase)
    })
}

/// A bent spindle lifts the carriage twice a turn.
pub(super) fn spindle(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (turn, phase) = (even(random, 2.5, 6.0), even(random, 0.0, PI));
    let inner = vec![("turn_mm", turn), ("phase_rad", phase)];
    let size = ("mm", 0.01, 1.0);
    adds("x + s |sin(pi x/turn + phase)|", inner, size, Act::Motion, move |now, _| {
        (PI * now.x / turn + phase).sin().abs()
    })
}

/// The carriage lifts with the speed, whichever way it goes.
pub(super) fn lifting_carriage(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let power = even(random, 0.4, 0.8);
    let shape = move |now: &Now<'_>, _| -(now.speed.abs() / 60.0).powf(power);
    adds("x - s (|v|/60)^m", vec![("m", power)], ("mm", 0.02, 1.0), Act::Motion, shape)
}

/// A belt stretches with the speed, and recovers.
pub(super) fn belt(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let late = log_even(random, 0.15, 1.0);
    Recipe {
        form: "x - s y, tau dy/dt = v/20 - y",
        inner: vec![("tau_s", late)],
        unit: "mm",
        guess: 0.01,
        most: 1.0,
        act: Box::new(move |s| {
            let mut behind = 0.0;
            one(Act::Motion(Box::new(move |now, x| {
                let pull = now.speed / 20.0;
                behind = pull + (behind - pull) * (-now.step / late).exp();
                x - s * behind
            })))
        }),
    }
}

/// A nut runs in: the place creeps off with the way that the carriage has gone.
pub(super) fn running_in(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let way = even(random, 60.0, 150.0);
    Recipe {
        form: "x - s (1 - e^(-(W/w)^2)), W = way gone",
        inner: vec![("w_mm", way)],
        unit: "mm",
        guess: 0.02,
        most: 1.0,
        act: Box::new(move |s| {
            let mut gone = 0.0;
            one(Act::Motion(Box::new(move |now, x| {
                gone += now.speed.abs() * now.step;
                x - s * (1.0 - (-(gone / way).powi(2)).exp())
            })))
        }),
    }
}
