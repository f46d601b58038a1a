//! The elasticity of the specimen.

use rand_chacha::ChaCha8Rng;

use super::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::Act;

/// Largest compression of the planned motions, mm.
const FULL_STROKE: f64 = 12.0;

/// N → N + s N(12) (x/12)^m.
pub fn power(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let m = even(random, 3.0, 6.0);
    let full = setting.base.elastic(FULL_STROKE);
    Recipe {
        form: "N + s N(12 mm) (x/12 mm)^m",
        inner: vec![("m", m)],
        unit: "",
        guess: 0.05,
        most: 3.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                n + s * full * (x.max(0.0) / FULL_STROKE).powf(m)
            })))
        }),
    }
}

/// An exponential toe: N + s N(12) (e^(x/ℓ) − 1 − x/ℓ), one at 12 mm.
pub fn exponential(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let length = even(random, 1.5, 4.0);
    let shape = move |x: f64| (x / length).exp_m1() - x / length;
    let scale = setting.base.elastic(FULL_STROKE) / shape(FULL_STROKE);
    Recipe {
        form: "N + s N(12 mm) h(x)/h(12 mm), h = e^(x/l) - 1 - x/l",
        inner: vec![("l_mm", length)],
        unit: "",
        guess: 0.05,
        most: 3.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| n + s * scale * shape(x.max(0.0)))))
        }),
    }
}

/// Pores close: N → N (1 + s x/(L − x)).
pub fn densification(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let length = even(random, 14.0, 20.0);
    Recipe {
        form: "densification: N (1 + s x/(L - x))",
        inner: vec![("L_mm", length)],
        unit: "",
        guess: 0.03,
        most: 3.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                let x = x.max(0.0);
                n * (1.0 + s * x / (length - x).max(1.0))
            })))
        }),
    }
}

/// N → N (1 − r tanh((x_max − x)/w)).
pub fn mullins(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let w = even(random, 1.5, 6.0);
    Recipe {
        form: "N (1 - r tanh((x_max - x)/w))",
        inner: vec![("w_mm", w)],
        unit: "",
        guess: 0.03,
        most: 0.8,
        act: Box::new(move |r| {
            one(Act::Elastic(Box::new(move |now, x, n| {
                n * (1.0 - r * ((now.largest - x).max(0.0) / w).tanh())
            })))
        }),
    }
}

/// N → N (1 − r (1 − x/x_max)).
pub fn relative_mullins(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "N (1 - r (1 - x/x_max))",
        inner: vec![],
        unit: "",
        guess: 0.05,
        most: 0.8,
        act: Box::new(|r| {
            one(Act::Elastic(Box::new(move |now, x, n| {
                let below = if now.largest > 0.0 { 1.0 - x / now.largest } else { 0.0 };
                n * (1.0 - r * below.clamp(0.0, 1.0))
            })))
        }),
    }
}

/// Ogden and Roxburgh: N (1 − r erf((W_max − W)/(m + β W_max))), W = ∫ N dx.
pub fn ogden_roxburgh(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let base = setting.base;
    let energy = move |x: f64| base.elastic(x) * x.max(0.0) / (base.q + 2.0);
    let (m, beta) = (even(random, 0.1, 0.5) * energy(8.0), even(random, 0.1, 0.3));
    Recipe {
        form: "Ogden-Roxburgh: N (1 - r erf((W_max - W)/(m + beta W_max)))",
        inner: vec![("m_N_mm", m), ("beta", beta)],
        unit: "",
        guess: 0.03,
        most: 0.8,
        act: Box::new(move |r| {
            let (mut largest, mut most) = (0.0, 0.0);
            one(Act::Elastic(Box::new(move |now, x, n| {
                if n <= 0.0 {
                    return n;
                }
                if now.largest > largest {
                    (largest, most) = (now.largest, energy(now.largest));
                }
                let below = (most - energy(x)).max(0.0) / (m + beta * most);
                n * (1.0 - r * libm::erf(below))
            })))
        }),
    }
}

/// N → N (1 − s ln(1 + n)).
pub fn cyclic(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "N (1 - s ln(1 + n))",
        inner: vec![],
        unit: "",
        guess: 0.005,
        most: 0.25,
        act: Box::new(|s| {
            one(Act::Elastic(Box::new(move |now, _, n| {
                n * (1.0 - s * (now.loadings as f64).ln_1p())
            })))
        }),
    }
}

/// Softening that comes to an end: N (1 − s (1 − e^(−n/n0))).
pub fn saturating_cyclic(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let count = even(random, 2.0, 6.0);
    Recipe {
        form: "N (1 - s (1 - e^(-n/n0)))",
        inner: vec![("n0", count)],
        unit: "",
        guess: 0.01,
        most: 0.6,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |now, _, n| {
                n * (1.0 + s * (-(now.loadings as f64) / count).exp_m1())
            })))
        }),
    }
}

/// x → x − s x_max.
pub fn set(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "x - s x_max",
        inner: vec![],
        unit: "",
        guess: 0.01,
        most: 0.3,
        act: Box::new(|s| one(Act::Motion(Box::new(move |now, x| x - s * now.largest)))),
    }
}

/// Set only above a yield compression: x − s (x_max − x_y).
pub fn yielding(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let from = even(random, 2.0, 5.0);
    Recipe {
        form: "x - s (x_max - x_y) above x_y",
        inner: vec![("x_y_mm", from)],
        unit: "",
        guess: 0.01,
        most: 0.3,
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(move |now, x| x - s * (now.largest - from).max(0.0))))
        }),
    }
}

/// N → N (1 + α (T − T0)).
pub fn thermal(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "N (1 + alpha (T - T0))",
        inner: vec![],
        unit: "1/K",
        guess: 0.003 * sign(random),
        most: 0.1,
        act: Box::new(|s| one(Act::Elastic(Box::new(move |now, _, n| n * (1.0 + s * now.warmer))))),
    }
}

/// The specimen follows the air with a time constant.
pub fn lagging_thermal(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 40.0, 200.0);
    Recipe {
        form: "N (1 + alpha (T_s - T0)), tau dT_s/dt = T - T_s",
        inner: vec![("tau_s", tau)],
        unit: "1/K",
        guess: 0.003 * sign(random),
        most: 0.1,
        act: Box::new(move |s| {
            let mut inside: Option<f64> = None;
            one(Act::Elastic(Box::new(move |now, _, n| {
                let before = inside.unwrap_or(now.warmer);
                let after = before - (now.warmer - before) * (-now.step / tau).exp_m1();
                inside = Some(after);
                n * (1.0 + s * after)
            })))
        }),
    }
}
