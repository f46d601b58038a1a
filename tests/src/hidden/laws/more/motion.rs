//! What reaches the specimen is not what was commanded.

use std::collections::VecDeque;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::hidden::laws::{Recipe, Setting, one};
use crate::hidden::random::even;
use crate::hidden::specimen::Act;

/// A film of dirt that is squeezed out of the way: x − δ (1 − e^(−x/1.2δ)).
pub fn film(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "film: x - delta (1 - e^(-x/(1.2 delta)))",
        inner: vec![],
        unit: "mm",
        guess: 0.05,
        most: 1.0,
        act: Box::new(|s| {
            one(Act::Motion(Box::new(
                move |_, x| {
                    if x > 0.0 { x + s * (-x / (1.2 * s)).exp_m1() } else { x }
                },
            )))
        }),
    }
}

/// Rough surfaces meet at their tips first: N averaged over heights spread normally with δ.
pub fn rough(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    // Gauss–Hermite points of the normal distribution, with weights.
    const POINTS: [(f64, f64); 5] = [
        (-2.856_970_013_872_806, 0.011_257_411_327_721),
        (-1.355_626_179_974_266, 0.222_075_922_005_613),
        (0.0, 0.533_333_333_333_333),
        (1.355_626_179_974_266, 0.222_075_922_005_613),
        (2.856_970_013_872_806, 0.011_257_411_327_721),
    ];
    let base = setting.base;
    Recipe {
        form: "rough surface: N averaged over gaps spread normally with delta about delta",
        inner: vec![],
        unit: "mm",
        guess: 0.05,
        most: 0.5,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                let spread = POINTS.iter().map(|(at, w)| w * base.elastic(x - s * (1.0 + at)));
                n + spread.sum::<f64>() - base.elastic(x)
            })))
        }),
    }
}

/// A frame that gives way less and less: x − C F0 asinh(F/F0).
pub fn stiffening_frame(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let scale = even(random, 0.1, 0.4) * setting.full_scale;
    Recipe {
        form: "stiffening frame: x - C F0 asinh(F/F0)",
        inner: vec![("F0_N", scale)],
        unit: "mm/N",
        guess: 0.1 / setting.full_scale,
        // A millimetre at the largest force.
        most: 1.0 / (scale * (setting.full_scale / scale).asinh()),
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(move |now, x| x - s * scale * (now.force / scale).asinh())))
        }),
    }
}

/// A lever that bends more and more: x − C F (1 + k F/FS).
pub fn softening_frame(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (more, full) = (even(random, 0.5, 2.0), setting.full_scale);
    Recipe {
        form: "softening frame: x - C F (1 + k F/FS)",
        inner: vec![("k", more)],
        unit: "mm/N",
        guess: 0.1 / full,
        most: 0.4 / full,
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(move |now, x| {
                x - s * now.force * (1.0 + more * now.force / full)
            })))
        }),
    }
}

/// Play taken up along a curve: the lag follows dz/dx = (1 − z sgn v)/ℓ.
pub fn curved_play(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let length = even(random, 0.1, 0.6);
    Recipe {
        form: "x - b (1 + z)/2, dz/dx = (1 - z sgn v)/l",
        inner: vec![("l_mm", length)],
        unit: "mm",
        guess: 0.03,
        most: 0.4,
        act: Box::new(move |b| {
            let (mut z, mut before) = (-1.0_f64, None);
            one(Act::Motion(Box::new(move |_, x| {
                let way: f64 = x - before.unwrap_or(x);
                before = Some(x);
                let end = way.signum();
                z = if way == 0.0 { z } else { end + (z - end) * (-way.abs() / length).exp() };
                x - 0.5 * b * (1.0 + z)
            })))
        }),
    }
}

/// Two joints with play of unlike widths, one after the other share.
pub fn two_plays(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (share, wide) = (even(random, 0.3, 0.7), even(random, 3.0, 8.0));
    Recipe {
        form: "share of play b and the rest of play w b",
        inner: vec![("share", share), ("w", wide)],
        unit: "mm",
        guess: 0.02,
        most: 0.15,
        act: Box::new(move |b| {
            let (mut near, mut far) = (f64::INFINITY, f64::INFINITY);
            one(Act::Motion(Box::new(move |_, x| {
                near = near.clamp(x, x + b);
                far = far.clamp(x, x + wide * b);
                share * near + (1.0 - share) * far
            })))
        }),
    }
}

/// Every trace is late by another time.
pub fn scattered_delay(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let factors: Vec<f64> = (0..setting.traces)
        .map(|_| {
            let spread: f64 = StandardNormal.sample(random);
            (1.0 + 0.3 * spread).max(0.0)
        })
        .collect();
    Recipe {
        form: "x(t - delta k), k of each trace normal about 1 by 0.3",
        inner: vec![],
        unit: "s",
        guess: 0.003,
        most: 0.1,
        act: Box::new(move |s| {
            let factors = factors.clone();
            one(Act::Motion(Box::new(move |now, x| {
                let late = s * factors[now.trace];
                x + now.course.at(now.time - late).x - now.course.at(now.time).x
            })))
        }),
    }
}

/// The command goes out in packets: x as it was at the last multiple of 2 δ.
pub fn packets(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "x held between multiples of 2 delta, smoothed over delta",
        inner: vec![],
        unit: "s",
        guess: 0.004,
        most: 0.1,
        act: Box::new(|s| {
            let mut recent: VecDeque<(f64, f64)> = VecDeque::new();
            one(Act::Motion(Box::new(move |now, x| {
                let held = (now.time / (2.0 * s)).floor() * 2.0 * s;
                recent.push_back((now.set_time, now.course.at(held).x - now.x));
                while recent.front().is_some_and(|(time, _)| *time < now.set_time - s) {
                    recent.pop_front();
                }
                x + recent.iter().map(|(_, late)| late).sum::<f64>() / recent.len() as f64
            })))
        }),
    }
}
