//! The time-dependence of the specimen.

use rand_chacha::ChaCha8Rng;

use crate::hidden::laws::relaxation::Branches;
use crate::hidden::laws::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::Act;

/// A fast branch that only large compressions wake: driven by N (x/8)^a.
pub fn fast_when_deep(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (tau, a) = (log_even(random, 0.01, 0.08), even(random, 0.5, 1.5));
    Recipe {
        form: "F + c int e^(-(t-s)/tau) d(N (x/8 mm)^a)",
        inner: vec![("tau_s", tau), ("a", a)],
        unit: "",
        guess: 0.03,
        most: 3.0,
        act: Box::new(move |c| {
            let mut branch = Branches::new(vec![1.0 / tau]);
            one(Act::Specimen(Box::new(move |now, elastic, force| {
                let deep = elastic * (now.x.max(0.0) / 8.0).powf(a);
                force + c * branch.advance(now.step, deep)[0]
            })))
        }),
    }
}

/// A power law that is cut off at 0.1 s: times of 3 to 100 ms with weights τ^a.
pub fn fast_power(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let a = even(random, -0.5, 0.5);
    let times: Vec<f64> = (0..7).map(|k| 0.003 * 10f64.powf(f64::from(k) / 4.0)).collect();
    let sum: f64 = times.iter().map(|time| time.powf(a)).sum();
    Recipe {
        form: "F + c int k(t-s) dN(s), k of times 3 ms to 95 ms with weights tau^a",
        inner: vec![("a", a)],
        unit: "",
        guess: 0.05,
        most: 3.0,
        act: Box::new(move |c| {
            let weights: Vec<f64> = times.iter().map(|time| time.powf(a) / sum).collect();
            let mut branches = Branches::new(times.iter().map(|time| 1.0 / time).collect());
            one(Act::Specimen(Box::new(move |now, elastic, force| {
                let left = branches.advance(now.step, elastic);
                force + c * left.iter().zip(&weights).map(|(q, w)| q * w).sum::<f64>()
            })))
        }),
    }
}

fn slow_tail(
    form: &'static str,
    inner: Vec<(&'static str, f64)>,
    spectrum: Vec<(f64, f64)>,
) -> Recipe {
    let sum: f64 = spectrum.iter().map(|(_, weight)| weight).sum();
    Recipe {
        form,
        inner,
        unit: "",
        guess: 0.03,
        most: 0.8,
        act: Box::new(move |s| {
            let weights: Vec<f64> = spectrum.iter().map(|(_, w)| w / sum).collect();
            let mut branches = Branches::new(spectrum.iter().map(|(time, _)| 1.0 / time).collect());
            one(Act::Specimen(Box::new(move |now, elastic, force| {
                let left = branches.advance(now.step, elastic);
                let gone = left.iter().zip(&weights).map(|(q, w)| w * (elastic - q));
                force - s * gone.sum::<f64>()
            })))
        }),
    }
}

/// One slow exponential.
pub fn slow_single(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 10.0, 60.0);
    slow_tail("g - s (1 - e^(-t/tau))", vec![("tau_s", tau)], vec![(tau, 1.0)])
}

/// A broad hump of slow times, log-normal.
pub fn slow_hump(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (tau, width) = (log_even(random, 15.0, 100.0), even(random, 0.8, 2.0));
    let weight = |time: f64| (-0.5 * ((time / tau).ln() / width).powi(2)).exp();
    let times = (-2..=16).map(|k| 10f64.powf(0.25 * f64::from(k)));
    let spectrum = times.map(|time| (time, weight(time))).collect();
    slow_tail(
        "g - s (1 - k(t)), k of log-normal times",
        vec![("tau_s", tau), ("width", width)],
        spectrum,
    )
}

/// Relaxation that saturates with compression: branches driven by N (1 + κ (1 − e^(−x/l))).
pub fn saturating_amplitude(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (length, sign) = (even(random, 3.0, 8.0), sign(random));
    Recipe {
        form: "branches driven by N (1 + kappa (1 - e^(-x/l)))",
        inner: vec![("l_mm", length)],
        unit: "",
        guess: 0.05 * sign,
        most: if sign < 0.0 { 0.8 } else { 3.0 },
        act: Box::new(move |k| {
            one(Act::Drive(Box::new(move |_, x, n| {
                n * (1.0 - k * (-x.max(0.0) / length).exp_m1())
            })))
        }),
    }
}

/// Only one branch knows of the amplitude, through a branch of its own driven by N x/8.
pub fn slow_amplitude(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (base, sign) = (setting.base, sign(random));
    let branch = usize::from(even(random, 0.0, 1.0) > 0.5);
    Recipe {
        form: "c_k (1 + kappa x/8 mm) for one k, taken from equilibrium",
        inner: vec![("k", branch as f64 + 1.0)],
        unit: "",
        guess: 0.05 * sign,
        most: if sign < 0.0 { 0.6 } else { 3.0 },
        act: Box::new(move |s| {
            let mut own = Branches::new(vec![base.rates[branch]]);
            one(Act::Specimen(Box::new(move |now, elastic, force| {
                let deep = elastic * now.x.max(0.0) / 8.0;
                force + s * base.shares[branch] * (own.advance(now.step, deep)[0] - deep)
            })))
        }),
    }
}

/// The specimen is as warm as the air was some time ago.
pub fn lagging_shift(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 20.0, 150.0);
    Recipe {
        form: "v_i e^(kappa (T_s - T0)), tau dT_s/dt = T - T_s",
        inner: vec![("tau_s", tau)],
        unit: "1/K",
        guess: 0.02,
        most: 1.0,
        act: Box::new(move |s| {
            let mut inside: Option<f64> = None;
            one(Act::Rate(Box::new(move |now, branch, _| {
                let before = inside.unwrap_or(now.warmer);
                // Asked once for each branch: only the first lets time pass.
                let step = if branch == 0 { now.step } else { 0.0 };
                let after = before - (now.warmer - before) * (-step / tau).exp_m1();
                inside = Some(after);
                (s * after).exp()
            })))
        }),
    }
}

/// Arrhenius with a curvature, for the fast branch alone.
pub fn fast_shift(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let curvature = even(random, -0.1, 0.1);
    Recipe {
        form: "v_1 e^(kappa dT (1 + c dT)), v_2 as it is",
        inner: vec![("c_per_K", curvature)],
        unit: "1/K",
        guess: 0.03,
        most: 1.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(move |now, branch, _| {
                let warmer = now.warmer * (1.0 + curvature * now.warmer);
                if branch == 0 { (s * warmer).exp() } else { 1.0 }
            })))
        }),
    }
}

/// Rates that grow with the square of what is to be forgotten, to a limit.
pub fn quadratic_latency(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let scale = 0.1 * setting.base.elastic(12.0);
    Recipe {
        form: "v (1 + s (q/D)^2/(1 + 0.2 (q/D)^2))",
        inner: vec![("D_N", scale)],
        unit: "",
        guess: 0.1,
        most: 20.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(move |_, _, force| {
                let square = (force / scale).powi(2);
                1.0 + s * square / (1.0 + 0.2 * square)
            })))
        }),
    }
}

/// A soft yield: hardly any relaxation below a force, then (1 + |q|/D)^s.
pub fn yielding_latency(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let scale = even(random, 0.02, 0.08) * setting.base.elastic(12.0);
    Recipe {
        form: "v (1 + |q|/D)^s",
        inner: vec![("D_N", scale)],
        unit: "",
        guess: 0.1,
        most: 3.0,
        act: Box::new(move |s| {
            one(Act::Rate(Box::new(move |_, _, force| (1.0 + force.abs() / scale).powf(s))))
        }),
    }
}
