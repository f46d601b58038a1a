//! Short or rare disturbances, and others that no effect of the library describes.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::hidden::laws::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::{Act, Now};

/// Length of one sample, s.
const SAMPLE: f64 = 0.005;

/// An instant within the motion of some trace: its number and the time since its beginning, s.
fn instant(setting: &Setting, random: &mut ChaCha8Rng) -> (usize, f64) {
    (random.random_range(0..setting.traces), even(random, 0.8, 5.0))
}

fn told((trace, time): (usize, f64)) -> Vec<(&'static str, f64)> {
    vec![("trace", trace as f64), ("time_s", time)]
}

/// F + s h, h of the instant alone.
fn added(
    form: &'static str,
    inner: Vec<(&'static str, f64)>,
    full_scale: f64,
    shape: impl Fn(&Now<'_>) -> f64 + 'static,
) -> Recipe {
    let shape = std::rc::Rc::new(shape);
    let act = move |s| -> Vec<Act> {
        let shape = std::rc::Rc::clone(&shape);
        one(Act::Sensor(Box::new(move |now, force| force + s * shape(now))))
    };
    Recipe {
        form,
        inner,
        unit: "N",
        guess: 0.01 * full_scale,
        most: 20.0 * full_scale,
        act: Box::new(act),
    }
}

/// Somebody knocks at the table once, for 30 ms.
pub fn knock(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (trace, at) = instant(setting, random);
    let shape = move |now: &Now<'_>| {
        let since = (now.time - at) / 0.03;
        if now.trace == trace && (0.0..1.0).contains(&since) { (PI * since).sin() } else { 0.0 }
    };
    added("one knock of 30 ms in one trace", told((trace, at)), setting.full_scale, shape)
}

/// The recorder repeats its last value for s seconds.
pub fn freeze(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (trace, at) = (random.random_range(0..setting.traces), even(random, 0.8, 1.2));
    Recipe {
        form: "F stands still for s seconds in one trace",
        inner: told((trace, at)),
        unit: "s",
        guess: 0.1,
        most: 3.0,
        act: Box::new(move |s| {
            let mut last = 0.0;
            one(Act::Sensor(Box::new(move |now, force| {
                let frozen = now.trace == trace && (at..at + s).contains(&now.time);
                if !frozen {
                    last = force;
                }
                last
            })))
        }),
    }
}

/// Single samples jump, up or down, all through the set.
pub fn spikes(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let rate = log_even(random, 0.05, 1.0);
    let mut times = Vec::new();
    let mut next = 0.0;
    while next < 2000.0 {
        next += -even(random, 1e-9, 1.0).ln() / rate;
        times.push((next, sign(random) * even(random, 0.5, 1.5)));
    }
    let shape = move |now: &Now<'_>| {
        let after = times.partition_point(|(time, _)| *time <= now.set_time);
        let last = after.checked_sub(1).map(|k| times[k]);
        last.map_or(0.0, |(time, size)| if now.set_time - time < SAMPLE { size } else { 0.0 })
    };
    added("single samples jump at random", vec![("per_s", rate)], setting.full_scale, shape)
}

/// The zero jumps in the middle of one trace, and is tared before the next.
pub fn zero_step(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (trace, at) = instant(setting, random);
    let sign = sign(random);
    let shape = move |now: &Now<'_>| {
        if now.trace == trace && now.time > at { sign } else { 0.0 }
    };
    added(
        "F + s from an instant of one trace to its end",
        told((trace, at)),
        setting.full_scale,
        shape,
    )
}

/// A loose connector: now and then the signal falls to another value for some samples.
pub fn loose(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let traces = [(); 2].map(|()| random.random_range(0..setting.traces));
    let (from, lasts) = (even(random, 0.5, 1.0), even(random, 0.01, 0.05));
    let times: Vec<f64> = (0..6).map(|_| even(random, 0.5, 6.0)).collect();
    let value = even(random, -0.3, 0.3) * setting.full_scale;
    Recipe {
        form: "six times in two traces F falls by a part s to another value",
        inner: vec![("value_N", value), ("lasts_s", lasts), ("from_s", from)],
        unit: "",
        guess: 0.1,
        most: 3.0,
        act: Box::new(move |s| {
            let times = times.clone();
            one(Act::Sensor(Box::new(move |now, force| {
                let out = traces.contains(&now.trace)
                    && times.iter().any(|time| (*time..time + lasts).contains(&now.time));
                if out { force + s * (value - force) } else { force }
            })))
        }),
    }
}

/// The building sways.
pub fn sway(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (frequency, phase) = (even(random, 0.12, 0.35), even(random, 0.0, TAU));
    let shape = move |now: &Now<'_>| (TAU * frequency * now.set_time + phase).sin();
    let inner = vec![("f_Hz", frequency), ("phase_rad", phase)];
    added("F + A sin(2 pi f t_set + phase), slow", inner, setting.full_scale, shape)
}

/// While it goes slowly the contact sticks and slips: bursts of a sawtooth over the way.
pub fn stick_slip(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (pitch, below, from) =
        (even(random, 0.15, 0.5), even(random, 8.0, 30.0), even(random, 1.0, 3.0));
    let shape = move |now: &Now<'_>| {
        let slow = now.speed < 0.0 && -now.speed < below && now.x > from;
        if slow { (now.x / pitch).fract() - 0.5 } else { 0.0 }
    };
    let inner = vec![("pitch_mm", pitch), ("below_mm_per_s", below), ("from_mm", from)];
    added("stick-slip: a sawtooth over x while parting slowly", inner, setting.full_scale, shape)
}

/// The drive rings at one of its speeds.
pub fn resonance(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (pitch, phase) = (even(random, 0.8, 3.0), even(random, 0.0, TAU));
    let (at, width) = ([5.0, 20.0, 60.0][random.random_range(0..3)], even(random, 0.1, 0.4));
    let shape = move |now: &Now<'_>| {
        let off = (now.speed.abs() / at).max(1e-6).ln() / width;
        (TAU * now.x / pitch + phase).sin() / (1.0 + off * off)
    };
    let inner = vec![("pitch_mm", pitch), ("speed_mm_per_s", at), ("width", width)];
    added("F + A sin(2 pi x/pitch) near one speed", inner, setting.full_scale, shape)
}

/// The grip slips once: from an instant on x is less by s.
pub fn grip(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (trace, at) = (random.random_range(1..setting.traces.max(2)), even(random, 1.0, 4.0));
    Recipe {
        form: "x - s from an instant to the end of the set",
        inner: told((trace, at)),
        unit: "mm",
        guess: 0.05,
        most: 2.0,
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(move |now, x| {
                let slipped = now.trace > trace || (now.trace == trace && now.time > at);
                if slipped { x - s } else { x }
            })))
        }),
    }
}

/// The motor loses steps in one trace and is homed before the next.
pub fn lost_steps(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (trace, at) = (random.random_range(0..setting.traces), even(random, 0.9, 1.6));
    Recipe {
        form: "x - s from an instant of one trace to its end",
        inner: told((trace, at)),
        unit: "mm",
        guess: 0.05,
        most: 2.0,
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(
                move |now, x| {
                    if now.trace == trace && now.time > at { x - s } else { x }
                },
            )))
        }),
    }
}

/// The gain is another for some seconds of one trace.
pub fn gain_step(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (trace, at) = (random.random_range(0..setting.traces), even(random, 0.9, 2.5));
    let (lasts, sign) = (even(random, 0.3, 2.0), sign(random));
    Recipe {
        form: "F (1 + s) for a while in one trace",
        inner: vec![("trace", trace as f64), ("time_s", at), ("lasts_s", lasts)],
        unit: "",
        guess: 0.05 * sign,
        most: if sign < 0.0 { 1.0 } else { 20.0 },
        act: Box::new(move |s| {
            one(Act::Sensor(Box::new(move |now, force| {
                let while_other = now.trace == trace && (at..at + lasts).contains(&now.time);
                if while_other { force * (1.0 + s) } else { force }
            })))
        }),
    }
}

/// A bubble in the specimen bursts: from one instant on it is softer.
pub fn burst(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (trace, at) = (random.random_range(1..setting.traces.max(2)), even(random, 1.0, 3.0));
    Recipe {
        form: "N (1 - s) from an instant to the end of the set",
        inner: told((trace, at)),
        unit: "",
        guess: 0.03,
        most: 0.8,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |now, _, n| {
                let burst = now.trace > trace || (now.trace == trace && now.time > at);
                if burst { n * (1.0 - s) } else { n }
            })))
        }),
    }
}
