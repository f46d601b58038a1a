//! The elasticity of the specimen.

use rand_chacha::ChaCha8Rng;

use crate::hidden::laws::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::Act;

const FULL_STROKE: f64 = 12.0;

/// Chains at their limit (Gent): N (1 + s u²/(1 − c u²)), u = x/12 mm.
pub fn gent(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let limit = even(random, 0.5, 0.8);
    Recipe {
        form: "Gent: N (1 + s u^2/(1 - c u^2)), u = x/(12 mm)",
        inner: vec![("c", limit)],
        unit: "",
        guess: 0.05,
        most: 3.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                let square = (x.max(0.0) / FULL_STROKE).powi(2);
                n * (1.0 + s * square / (1.0 - limit * square).max(0.05))
            })))
        }),
    }
}

/// A second, stiffer layer is reached: N + s N(12) w ln(1 + e^((x − x1)/w))/12 mm.
pub fn second_layer(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (at, width) = (even(random, 6.0, 9.0), even(random, 0.3, 1.0));
    let scale = setting.base.elastic(FULL_STROKE) * width / FULL_STROKE;
    let bend = move |x: f64| ((x - at) / width).exp().ln_1p();
    Recipe {
        form: "second layer: N + s N(12 mm) w ln(1 + e^((x - x1)/w))/(12 mm)",
        inner: vec![("x1_mm", at), ("w_mm", width)],
        unit: "",
        guess: 0.1,
        most: 5.0,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |_, x, n| {
                if x > 0.0 { n + s * scale * (bend(x) - bend(0.0)) } else { n }
            })))
        }),
    }
}

/// Damage that grows with what was reached and shows below it: N (1 − r (x_max/12)^a (1 − (x/x_max)^b)).
pub fn growing_damage(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (a, b) = (even(random, 0.5, 1.5), even(random, 1.0, 3.0));
    Recipe {
        form: "N (1 - r (x_max/12 mm)^a (1 - (x/x_max)^b))",
        inner: vec![("a", a), ("b", b)],
        unit: "",
        guess: 0.05,
        most: 0.8,
        act: Box::new(move |r| {
            one(Act::Elastic(Box::new(move |now, x, n| {
                if x <= 0.0 || now.largest <= 0.0 {
                    return n;
                }
                let below = 1.0 - (x / now.largest).min(1.0).powf(b);
                n * (1.0 - r * (now.largest / FULL_STROKE).powf(a) * below)
            })))
        }),
    }
}

/// Many bonds, each broken at its own compression and stiff until then: a Weibull law of x_max alone.
pub fn broken_bonds(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (scale, shape) = (even(random, 6.0, 12.0), even(random, 1.0, 2.5));
    Recipe {
        form: "below x_max N (1 - r (1 - e^(-(x_max/l)^k))), rising to N over the last 15 %",
        inner: vec![("l_mm", scale), ("k", shape)],
        unit: "",
        guess: 0.05,
        most: 0.8,
        act: Box::new(move |r| {
            one(Act::Elastic(Box::new(move |now, x, n| {
                if now.largest <= 0.0 {
                    return n;
                }
                let broken = -(-(now.largest / scale).powf(shape)).exp_m1();
                let below = ((1.0 - x / now.largest) / 0.15).clamp(0.0, 1.0);
                n * (1.0 - r * broken * below)
            })))
        }),
    }
}

/// Softening by the way gone under load, not by the count: N (1 − s ln(1 + W/20 mm)).
pub fn softening_by_way(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "N (1 - s ln(1 + W/(20 mm))), W the way of all loadings before",
        inner: vec![],
        unit: "",
        guess: 0.005,
        most: 0.2,
        act: Box::new(|s| {
            let (mut way, mut before, mut loadings, mut running) = (0.0, 0.0, 0, 0.0);
            one(Act::Elastic(Box::new(move |now, _, n| {
                running += (now.x.max(0.0) - before).max(0.0);
                before = now.x.max(0.0);
                if now.loadings > loadings {
                    (loadings, way) = (now.loadings, running);
                }
                n * (1.0 - s * (way / 20.0_f64).ln_1p())
            })))
        }),
    }
}

/// N (1 − s n^a), a 0.25 to 0.7.
pub fn softening_power(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let a = even(random, 0.25, 0.7);
    Recipe {
        form: "N (1 - s n^a)",
        inner: vec![("a", a)],
        unit: "",
        guess: 0.005,
        most: 0.12,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |now, _, n| {
                n * (1.0 - s * (now.loadings as f64).powf(a))
            })))
        }),
    }
}

/// Set that creeps with time under load and stays: dS/dt = s x/τ while S < s x_max.
pub fn creeping_set(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 2.0, 20.0);
    Recipe {
        form: "x - S, dS/dt = (s x - S)/tau where s x > S",
        inner: vec![("tau_s", tau)],
        unit: "",
        guess: 0.01,
        most: 0.3,
        act: Box::new(move |s| {
            let mut set = 0.0;
            one(Act::Motion(Box::new(move |now, x| {
                let goal = s * now.x.max(0.0);
                if goal > set {
                    set += (goal - set) * -(-now.step / tau).exp_m1();
                }
                x - set
            })))
        }),
    }
}

/// Set that comes to an end: x − s L (1 − e^(−x_max/L)).
pub fn saturating_set(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let length = even(random, 2.0, 6.0);
    Recipe {
        form: "x - s l (1 - e^(-x_max/l))",
        inner: vec![("l_mm", length)],
        unit: "",
        guess: 0.02,
        most: 0.4,
        act: Box::new(move |s| {
            one(Act::Motion(Box::new(move |now, x| {
                x + s * length * (-now.largest.max(0.0) / length).exp_m1()
            })))
        }),
    }
}

/// A stiffness that bends with temperature: N e^(α ΔT + α c ΔT²).
pub fn curved_thermal(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let curvature = sign(random) * even(random, 0.1, 0.4);
    Recipe {
        form: "N e^(alpha (dT + c dT^2))",
        inner: vec![("c_per_K", curvature)],
        unit: "1/K",
        guess: 0.003 * sign(random),
        most: 0.1,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |now, _, n| {
                n * (s * now.warmer * (1.0 + curvature * now.warmer)).exp()
            })))
        }),
    }
}

/// Only the deep layers soften: N (1 + α ΔT (x/8 mm)^a).
pub fn deep_thermal(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let a = even(random, 0.3, 1.0);
    Recipe {
        form: "N (1 + alpha dT (x/8 mm)^a)",
        inner: vec![("a", a)],
        unit: "1/K",
        guess: 0.003 * sign(random),
        most: 0.1,
        act: Box::new(move |s| {
            one(Act::Elastic(Box::new(move |now, x, n| {
                n * (1.0 + s * now.warmer * (x.max(0.0) / 8.0).powf(a))
            })))
        }),
    }
}
