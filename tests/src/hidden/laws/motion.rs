//! What reaches the specimen is not what was commanded.

use rand_chacha::ChaCha8Rng;

use super::{Recipe, Setting, one};
use crate::hidden::random::{even, sign};
use crate::hidden::specimen::Act;

/// x → x − δ.
pub fn offset(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let sign = sign(random);
    Recipe {
        form: "x - delta",
        inner: vec![],
        unit: "mm",
        guess: 0.03 * sign,
        // Traces begin at least 0.5 mm off the nominal touch, and none begins in contact.
        most: if sign < 0.0 { 0.45 } else { 1.0 },
        act: Box::new(|s| one(Act::Motion(Box::new(move |_, x| x - s)))),
    }
}

/// A tilted plate meets the surface bit by bit, its gaps spread evenly over 0 to 2δ.
pub fn tilt(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    // Gauss's four points on −1 to 1 with their weights.
    const POINTS: [(f64, f64); 4] = [
        (-0.861_136_311_594_053, 0.173_927_422_568_727),
        (-0.339_981_043_584_856, 0.326_072_577_431_273),
        (0.339_981_043_584_856, 0.326_072_577_431_273),
        (0.861_136_311_594_053, 0.173_927_422_568_727),
    ];
    let base = setting.base;
    Recipe {
        form: "tilted plate: N averaged over gaps from 0 to 2 delta",
        inner: vec![],
        unit: "mm",
        guess: 0.03,
        most: 1.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                if x <= 0.0 {
                    return n;
                }
                let spread = POINTS.iter().map(|(at, w)| w * base.elastic(x - s * (1.0 + at)));
                n + spread.sum::<f64>() - base.elastic(x)
            })))
        }),
    }
}

/// x → x − C F.
pub fn compliance(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "x - C F",
        inner: vec![],
        unit: "mm/N",
        guess: 0.1 / setting.full_scale,
        // A millimetre at the largest force: beyond, the force of the step before is no guide.
        most: 1.0 / setting.full_scale,
        act: Box::new(|s| one(Act::Motion(Box::new(move |now, x| x - s * now.force)))),
    }
}

/// A bolted joint of round asperities: x → x − C F^(2/3).
pub fn joint(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "Hertzian joint: x - C F^(2/3)",
        inner: vec![],
        unit: "mm/N^(2/3)",
        guess: 0.1 / setting.full_scale.powf(2.0 / 3.0),
        most: 1.5 / setting.full_scale.powf(2.0 / 3.0),
        act: Box::new(|s| {
            one(Act::Motion(Box::new(move |now, x| x - s * now.force.powf(2.0 / 3.0))))
        }),
    }
}

/// Gaps in the frame that close under load: x → x − C F0 (1 − e^(−F/F0)).
pub fn closing_joint(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let closed = even(random, 0.15, 0.5) * setting.full_scale;
    Recipe {
        form: "closing joint: x - C F0 (1 - e^(-F/F0))",
        inner: vec![("F0_N", closed)],
        unit: "mm/N",
        guess: 0.1 / setting.full_scale,
        most: 1.0 / setting.full_scale,
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(move |now, x| {
                x + s * closed * (-now.force / closed).exp_m1()
            })))
        }),
    }
}

/// Play of width b: its output stays between x and x + b.
pub fn play(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "play of width b, y in [x, x + b]",
        inner: vec![],
        unit: "mm",
        guess: 0.02,
        most: 0.5,
        act: Box::new(|b| {
            let mut y = f64::INFINITY;
            one(Act::Motion(Box::new(move |_, x| {
                y = y.clamp(x, x + b);
                y
            })))
        }),
    }
}

/// Play that is taken up gradually: the mean of five plays of widths up to 2 b.
pub fn smooth_play(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "mean of five plays of widths 0.4 b to 2 b (Prandtl-Ishlinskii)",
        inner: vec![],
        unit: "mm",
        guess: 0.02,
        most: 0.25,
        act: Box::new(|b| {
            let mut plays = [f64::INFINITY; 5];
            one(Act::Motion(Box::new(move |_, x| {
                for (k, y) in plays.iter_mut().enumerate() {
                    *y = y.clamp(x, x + 0.4 * b * (k + 1) as f64);
                }
                plays.iter().sum::<f64>() / 5.0
            })))
        }),
    }
}

/// x(t) → x(t − δ).
pub fn delay(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "x(t - delta)",
        inner: vec![],
        unit: "s",
        guess: 0.003,
        most: 0.1,
        act: Box::new(|s| {
            one(Act::Motion(Box::new(move |now, x| {
                x + now.course.at(now.time - s).x - now.course.at(now.time).x
            })))
        }),
    }
}

/// The clock of the motion runs slow: the delay grows from start to end of each trace.
pub fn growing_delay(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let period = even(random, 5.0, 20.0);
    Recipe {
        form: "x(t - delta (1 + t/period)), t since the trace began",
        inner: vec![("period_s", period)],
        unit: "s",
        guess: 0.002,
        most: 0.1,
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(move |now, x| {
                let late = s * (1.0 + now.time / period);
                x + now.course.at(now.time - late).x - now.course.at(now.time).x
            })))
        }),
    }
}
