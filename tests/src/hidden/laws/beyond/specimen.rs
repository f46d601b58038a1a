//! Of the specimen.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;

use super::super::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even};
use crate::hidden::specimen::Act;

/// A hard inclusion: the specimen is stiffer over a plateau of compression.
pub(super) fn inclusion(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (at, width) = (even(random, 3.0, 8.0), even(random, 0.6, 1.4));
    let scale = setting.base.elastic(at);
    Recipe {
        form: "N + s N(x_i) / (1 + ((x - x_i)/w)^4)",
        inner: vec![("x_i_mm", at), ("w_mm", width)],
        unit: "",
        guess: 0.03,
        most: 2.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                n + s * scale / (1.0 + ((x - at) / width).powi(4))
            })))
        }),
    }
}

/// Motion loosens the structure, rest builds it up again.
pub(super) fn thixotropy(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (builds, way) = (log_even(random, 0.5, 3.0), even(random, 4.0, 12.0));
    Recipe {
        form: "N (1 - s y), dy/dt = |v|/way (1 - y) - y/tau",
        inner: vec![("tau_s", builds), ("way_mm", way)],
        unit: "",
        guess: 0.03,
        most: 0.8,
        act: Box::new(move |s| {
            let mut loose = 0.0;
            one(Act::Elastic(Box::new(move |now, _, n| {
                let rate = now.speed.abs() / way + 1.0 / builds;
                let settles = now.speed.abs() / way / rate;
                loose = settles + (loose - settles) * (-rate * now.step).exp();
                n * (1.0 - s * loose)
            })))
        }),
    }
}

/// The specimen swells and shrinks over the session.
pub(super) fn swelling(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (period, phase) = (even(random, 500.0, 1200.0), even(random, 0.0, TAU));
    Recipe {
        form: "N (1 + s sin(2 pi t_set/period + phase))",
        inner: vec![("period_s", period), ("phase_rad", phase)],
        unit: "",
        guess: 0.02,
        most: 0.8,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |now, _, n| {
                n * (1.0 + s * (TAU * now.set_time / period + phase).sin())
            })))
        }),
    }
}

/// Between two compressions the specimen relaxes faster.
pub(super) fn fast_inside(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (from, to) = (even(random, 2.0, 5.0), even(random, 6.0, 10.0));
    Recipe {
        form: "v_i (1 + s) where x_1 < x < x_2",
        inner: vec![("x_1_mm", from), ("x_2_mm", to)],
        unit: "",
        guess: 0.2,
        most: 30.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(
                move |now, _, _| {
                    if (from..to).contains(&now.x) { 1.0 + s } else { 1.0 }
                },
            )))
        }),
    }
}

/// A dome snaps through at one compression, and back at a smaller one.
pub(super) fn snap_through(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let through = even(random, 3.0, 7.0);
    let back = through * even(random, 0.35, 0.7);
    let scale = setting.base.elastic(through);
    Recipe {
        form: "N - s N(x_1) from x > x_1 to x < x_2",
        inner: vec![("x_1_mm", through), ("x_2_mm", back)],
        unit: "",
        guess: 0.03,
        most: 0.9,
        act: Box::new(move |s| {
            let mut snapped = false;
            one(Act::Elastic(Box::new(move |_, x, n| {
                snapped = x > if snapped { back } else { through };
                if snapped { n - s * scale } else { n }
            })))
        }),
    }
}

/// The specimen is stiffer while it is moved fast, either way.
pub(super) fn stiff_when_fast(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let fast = log_even(random, 5.0, 40.0);
    Recipe {
        form: "N (1 + s |v|/(|v| + v_0))",
        inner: vec![("v_0_mm_per_s", fast)],
        unit: "",
        guess: 0.03,
        most: 0.9,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |now, _, n| {
                n * (1.0 + s * now.speed.abs() / (now.speed.abs() + fast))
            })))
        }),
    }
}

/// Two struts give way, one after the other.
pub(super) fn two_struts(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (first, second) = (even(random, 1.5, 3.2), even(random, 4.5, 7.5));
    let width = even(random, 0.3, 0.9);
    let scale = setting.base.elastic(second);
    let dip = move |x: f64, at: f64| 1.0 / (1.0 + ((x - at) / width).powi(2));
    Recipe {
        form: "N - s N(x_2) (L(x - x_1)/2 + L(x - x_2)), L = 1/(1 + (x/w)^2)",
        inner: vec![("x_1_mm", first), ("x_2_mm", second), ("w_mm", width)],
        unit: "",
        guess: 0.03,
        most: 1.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                if x > 0.0 { n - s * scale * (0.5 * dip(x, first) + dip(x, second)) } else { n }
            })))
        }),
    }
}

/// Liquid weeps out while the specimen is deep, and soaks back more slowly.
pub(super) fn weeping(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (out, back) = (log_even(random, 0.6, 2.0), log_even(random, 6.0, 20.0));
    Recipe {
        form: "N (1 - s y), dy/dt = (x/12)^2 (1 - y)/tau_1 - y/tau_2",
        inner: vec![("tau_1_s", out), ("tau_2_s", back)],
        unit: "",
        guess: 0.05,
        most: 0.9,
        act: Box::new(move |s| {
            let mut lost: f64 = 0.0;
            one(Act::Elastic(Box::new(move |now, x, n| {
                let rate = (x.max(0.0) / 12.0).powi(2) / out;
                let settles = rate / (rate + 1.0 / back);
                lost = settles + (lost - settles) * (-(rate + 1.0 / back) * now.step).exp();
                n * (1.0 - s * lost)
            })))
        }),
    }
}

/// What is hardly loaded relaxes faster.
pub(super) fn fast_when_light(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let force = even(random, 0.05, 0.2) * setting.full_scale;
    Recipe {
        form: "v_i (1 + s e^(-F/F_0))",
        inner: vec![("F_0_N", force)],
        unit: "",
        guess: 0.2,
        most: 30.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(move |now, _, _| 1.0 + s * (-now.force.max(0.0) / force).exp())))
        }),
    }
}
