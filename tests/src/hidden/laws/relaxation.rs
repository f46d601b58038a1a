//! The time-dependence of the specimen.

use std::cell::Cell;
use std::rc::Rc;

use rand_chacha::ChaCha8Rng;

use super::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::{Act, Now, decay_and_gain};

/// Branches beside those of the base, with decays kept while the step stays the same.
pub(super) struct Branches {
    rates: Vec<f64>,
    forces: Vec<f64>,
    steps: Vec<(f64, f64)>,
    step: f64,
    before: f64,
}

impl Branches {
    pub(super) fn new(rates: Vec<f64>) -> Self {
        let count = rates.len();
        Self {
            rates,
            forces: vec![0.0; count],
            steps: vec![(1.0, 1.0); count],
            step: 0.0,
            before: 0.0,
        }
    }

    /// The force that each branch still has to forget, when N has come to `elastic`.
    pub(super) fn advance(&mut self, step: f64, elastic: f64) -> &[f64] {
        if step != self.step {
            self.step = step;
            self.steps = self.rates.iter().map(|rate| decay_and_gain(rate * step)).collect();
        }
        let more = elastic - self.before;
        self.before = elastic;
        for (force, (decay, gain)) in self.forces.iter_mut().zip(&self.steps) {
            *force = decay * *force + gain * more;
        }
        &self.forces
    }
}

/// A third exponential: F + c ∫ e^(−(t−s)/τ) dN.
pub fn fast(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 0.005, 0.1);
    Recipe {
        form: "F + c int e^(-(t-s)/tau) dN(s)",
        inner: vec![("tau_s", tau)],
        unit: "",
        guess: 0.03,
        most: 3.0,
        act: Box::new(move |c| {
            let mut branch = Branches::new(vec![1.0 / tau]);
            one(Act::Specimen(Box::new(move |now, elastic, force| {
                force + c * branch.advance(now.step, elastic)[0]
            })))
        }),
    }
}

/// A band of relaxation times, even in the logarithm over a decade.
pub fn fast_band(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 0.012, 0.06);
    Recipe {
        form: "F + c int b(t-s) dN(s), b the mean of five exponentials with times tau/3 to 3 tau",
        inner: vec![("tau_s", tau)],
        unit: "",
        guess: 0.03,
        most: 3.0,
        act: Box::new(move |c| {
            let times = (-2..=2).map(|k| tau * 3f64.powf(0.5 * f64::from(k)));
            let mut branches = Branches::new(times.map(|time| 1.0 / time).collect());
            one(Act::Specimen(Box::new(move |now, elastic, force| {
                force + c * branches.advance(now.step, elastic).iter().sum::<f64>() / 5.0
            })))
        }),
    }
}

/// Rates u/t0 with u e-spaced thrice a decade, and the weight of each for a spectrum over ln u.
fn spectrum(t0: f64, of_u: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let spacing = std::f64::consts::LN_10 / 3.0;
    let us = || (-13..=3).map(|k| (spacing * f64::from(k)).exp());
    (us().map(|u| u / t0).collect(), us().map(|u| spacing * of_u(u)).collect())
}

/// F − ∫ tail(t−s) dN(s), the tail a sum over a spectrum of exponentials that begins at 0.
fn tail(rates: Vec<f64>, weights: Vec<f64>, strength: f64) -> Vec<Act> {
    let mut branches = Branches::new(rates);
    one(Act::Specimen(Box::new(move |now, elastic, force| {
        let left = branches.advance(now.step, elastic);
        let gone: f64 = left.iter().zip(&weights).map(|(q, w)| w * (elastic - q)).sum();
        force - strength * gone
    })))
}

/// g → g − s log10(1 + t/t0).
pub fn logarithmic(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let t0 = log_even(random, 0.5, 5.0);
    Recipe {
        form: "g - s log10(1 + t/t0)",
        inner: vec![("t0_s", t0)],
        unit: "per decade",
        guess: 0.01,
        most: 0.3,
        act: Box::new(move |s| {
            // ln(1 + t/t0) = ∫ (1 − e^(−u t/t0)) e^(−u) d ln u.
            let (rates, weights) = spectrum(t0, |u| (-u).exp() / std::f64::consts::LN_10);
            tail(rates, weights, s)
        }),
    }
}

/// g → g − s (1 − (1 + t/t0)^(−β)).
pub fn power_law(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (t0, beta) = (log_even(random, 0.5, 5.0), even(random, 0.2, 0.6));
    Recipe {
        form: "g - s (1 - (1 + t/t0)^(-beta))",
        inner: vec![("t0_s", t0), ("beta", beta)],
        unit: "",
        guess: 0.03,
        most: 1.0,
        act: Box::new(move |s| {
            let gamma = libm::tgamma(beta);
            let (rates, weights) = spectrum(t0, |u| u.powf(beta) * (-u).exp() / gamma);
            tail(rates, weights, s)
        }),
    }
}

/// c_i → c_i (1 + κ x) with c0 = 1 − c1 − c2 still, all at the x of each dN.
pub fn amplitude(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let base = setting.base;
    let sign = sign(random);
    // ∫ x dN = N x (q + 1)/(q + 2) for a power law.
    let mean = (base.q + 1.0) / (base.q + 2.0);
    let shares = base.shares[0] + base.shares[1];
    Recipe {
        form: "int g(t-s; x(s)) dN(s), c_i (1 + kappa x), c0 + c1 + c2 = 1",
        inner: vec![],
        unit: "1/mm",
        guess: 0.005 * sign,
        most: if sign < 0.0 { 0.08 } else { 0.5 },
        act: Box::new(move |s| {
            let more = Rc::new(Cell::new(0.0));
            let seen = Rc::clone(&more);
            let drive = move |_: &Now<'_>, x: f64, n: f64| {
                more.set(n * s * mean * x.max(0.0));
                n + more.get()
            };
            // What the branches take up more, equilibrium gives up.
            let rest = move |_: &Now<'_>, _: f64, force: f64| force - shares * seen.get();
            vec![Act::Drive(Box::new(drive)), Act::Specimen(Box::new(rest))]
        }),
    }
}

/// Pipkin and Rogers: the branches are driven by N (x/8)^k.
pub fn pipkin_rogers(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let sign = sign(random);
    Recipe {
        form: "Pipkin-Rogers: branches driven by N (x/8 mm)^k",
        inner: vec![],
        unit: "",
        guess: 0.03 * sign,
        most: if sign < 0.0 { 0.4 } else { 3.0 },
        act: Box::new(|k| {
            one(Act::Drive(Box::new(
                move |_, x, n| {
                    if x > 0.0 { n * (x / 8.0).powf(k) } else { n }
                },
            )))
        }),
    }
}

/// v_i → v_i e^(κ (T − T0)).
pub fn shift(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "v_i e^(kappa (T - T0))",
        inner: vec![],
        unit: "1/K",
        guess: 0.02,
        most: 1.0,
        act: Box::new(|s| one(Act::Rate(Box::new(move |now, _, _| (s * now.warmer).exp())))),
    }
}

/// Williams, Landel and Ferry, the slow branch with an activation of its own.
pub fn wlf(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (width, slow) = (even(random, 15.0, 40.0), even(random, 0.5, 1.5));
    Recipe {
        form: "WLF: v_i e^(kappa_i C (T - T0)/(C + T - T0)), kappa_2 a fraction of kappa_1",
        inner: vec![("C_K", width), ("fraction", slow)],
        unit: "1/K",
        guess: 0.02,
        most: 1.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(move |now, branch, _| {
                let activation = if branch == 1 { slow } else { 1.0 };
                (s * activation * width * now.warmer / (width + now.warmer)).exp()
            })))
        }),
    }
}

/// dε/dt = −ν sgn(ε − ε_e) |ε − ε_e|^n for both branches, the same rate as before at a tenth of
/// N(12 mm).
pub fn latency(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let scale = 0.1 * setting.base.elastic(12.0);
    Recipe {
        form: "dq/dt = dN/dt - v q |q/D|^(n-1), strength n - 1",
        inner: vec![("D_N", scale)],
        unit: "",
        guess: 0.05,
        most: 4.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(move |_, _, force| (force.abs() / scale).max(1e-6).powf(s))))
        }),
    }
}

/// Eyring: dq/dt = dN/dt − v (D/s) sinh(s q/D).
pub fn eyring(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let scale = 0.1 * setting.base.elastic(12.0);
    Recipe {
        form: "Eyring: dq/dt = dN/dt - v (D/s) sinh(s q/D)",
        inner: vec![("D_N", scale)],
        unit: "",
        guess: 0.2,
        most: 5.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(move |_, _, force| {
                let size = s * force.abs() / scale;
                if size > 1e-6 { size.min(30.0).sinh() / size } else { 1.0 }
            })))
        }),
    }
}
