//! In the sensor and its electronics.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::contact::Oscillator;
use super::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::{Act, Now};

/// F + s h, h of the instant alone.
fn added(shape: impl Fn(&Now<'_>) -> f64 + Copy + 'static) -> Box<dyn Fn(f64) -> Vec<Act>> {
    Box::new(move |s| one(Act::Sensor(Box::new(move |now, force| force + s * shape(now)))))
}

fn zero_of_each(form: &'static str, full_scale: f64, zeros: Vec<f64>) -> Recipe {
    Recipe {
        form,
        inner: vec![],
        unit: "N",
        guess: 0.002 * full_scale,
        most: full_scale,
        act: Box::new(move |s| {
            let zeros = zeros.clone();
            one(Act::Sensor(Box::new(move |now, force| force + s * zeros[now.trace])))
        }),
    }
}

/// F + b, one b for each trace, normally distributed.
pub fn zeros(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let zeros = (0..setting.traces).map(|_| StandardNormal.sample(random)).collect();
    zero_of_each("F + b, b normal for each trace", setting.full_scale, zeros)
}

/// F + b, b a random walk from trace to trace.
pub fn wandering_zero(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let mut zero = 0.0;
    let zeros = (0..setting.traces).map(|_| {
        let step: f64 = StandardNormal.sample(random);
        zero += step;
        zero
    });
    zero_of_each("F + b, b a random walk from trace to trace", setting.full_scale, zeros.collect())
}

/// F + d t_set.
pub fn drift(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "F + d t_set",
        inner: vec![],
        unit: "N/min",
        guess: 0.0005 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: added(|now| now.set_time / 60.0),
    }
}

/// F + d √t_set.
pub fn root_drift(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "F + d sqrt(t_set)",
        inner: vec![],
        unit: "N/min^0.5",
        guess: 0.001 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: added(|now| (now.set_time / 60.0).max(0.0).sqrt()),
    }
}

/// F + b (1 − e^(−t_set/τ)).
pub fn warm_up(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 120.0, 1800.0);
    Recipe {
        form: "F + b (1 - e^(-t_set/tau))",
        inner: vec![("tau_s", tau)],
        unit: "N",
        guess: 0.005 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: added(move |now| -(-now.set_time / tau).exp_m1()),
    }
}

/// F + b t_set/(t_set + τ).
pub fn hyperbolic_warm_up(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 60.0, 600.0);
    Recipe {
        form: "F + b t_set/(t_set + tau)",
        inner: vec![("tau_s", tau)],
        unit: "N",
        guess: 0.005 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: added(move |now| now.set_time / (now.set_time + tau)),
    }
}

/// F + β (T − T0).
pub fn thermal(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "F + beta (T - T0)",
        inner: vec![],
        unit: "N/K",
        guess: 0.002 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: added(|now| now.warmer),
    }
}

/// The gauge follows the air with a time constant.
pub fn lagging_thermal(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = log_even(random, 20.0, 100.0);
    Recipe {
        form: "F + beta (T_g - T0), tau dT_g/dt = T - T_g",
        inner: vec![("tau_s", tau)],
        unit: "N/K",
        guess: 0.002 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut gauge: Option<f64> = None;
            one(Act::Sensor(Box::new(move |now, force| {
                let before = gauge.unwrap_or(now.warmer);
                let after = before - (now.warmer - before) * (-now.step / tau).exp_m1();
                gauge = Some(after);
                force + s * after
            })))
        }),
    }
}

/// F + β (ΔT + c ΔT²).
pub fn curved_thermal(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let curvature = sign(random) * even(random, 0.05, 0.2);
    Recipe {
        form: "F + beta (dT + c dT^2), dT = T - T0",
        inner: vec![("c_per_K", curvature)],
        unit: "N/K",
        guess: 0.002 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: added(move |now| now.warmer * (1.0 + curvature * now.warmer)),
    }
}

/// F − k2 F² − k3 F³.
pub fn cubic(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (full, sign, angle) = (setting.full_scale, sign(random), even(random, 0.0, TAU / 4.0));
    let (square, cube) = (angle.cos() / full, angle.sin() / full.powi(2));
    Recipe {
        form: "F - s (cos(angle) F^2/FS + sin(angle) F^3/FS^2)",
        inner: vec![("angle_rad", angle), ("FS_N", full)],
        unit: "",
        guess: 0.01 * sign,
        most: 0.3,
        act: Box::new(move |s| {
            one(Act::Sensor(Box::new(move |_, f| f - s * f * f * (square + cube * f))))
        }),
    }
}

/// A quarter bridge: F/(1 + s F/FS).
pub fn bridge(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let full = setting.full_scale;
    Recipe {
        form: "quarter bridge: F/(1 + s F/FS)",
        inner: vec![("FS_N", full)],
        unit: "",
        guess: 0.01 * sign(random),
        most: 0.5,
        act: Box::new(move |s| one(Act::Sensor(Box::new(move |_, f| f / (1.0 + s * f / full))))),
    }
}

/// An amplifier that bends: (FS/√s) atan(√s F/FS).
pub fn arctangent(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let full = setting.full_scale;
    Recipe {
        form: "FS/sqrt(s) atan(sqrt(s) F/FS)",
        inner: vec![("FS_N", full)],
        unit: "",
        guess: 0.02,
        most: 3.0,
        act: Box::new(move |s| {
            let bend = s.sqrt() / full;
            one(Act::Sensor(Box::new(move |_, f| (bend * f).atan() / bend)))
        }),
    }
}

/// min(F, FS (1 − s)).
pub fn clip(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let full = setting.full_scale;
    Recipe {
        form: "min(F, FS (1 - s))",
        inner: vec![("FS_N", full)],
        unit: "",
        guess: 0.03,
        most: 0.6,
        act: Box::new(move |s| one(Act::Sensor(Box::new(move |_, f| f.min(full * (1.0 - s)))))),
    }
}

/// A soft min of F and FS (1 − s), as wide as a fraction of s.
pub fn soft_clip(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (full, share) = (setting.full_scale, even(random, 0.1, 0.3));
    Recipe {
        form: "F - w ln(1 + e^((F - FS (1 - s))/w)), w = share s FS",
        inner: vec![("FS_N", full), ("share", share)],
        unit: "",
        guess: 0.03,
        most: 0.6,
        act: Box::new(move |s| {
            let (limit, width) = (full * (1.0 - s), share * s * full);
            one(Act::Sensor(Box::new(move |_, f| {
                let over = (f - limit) / width;
                f - width * (over.max(0.0) + (-over.abs()).exp().ln_1p())
            })))
        }),
    }
}

/// τ dF_out/dt = F − F_out, F growing evenly over a step.
pub fn lag(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "tau dF_out/dt = F - F_out",
        inner: vec![],
        unit: "s",
        guess: 0.003,
        most: 0.5,
        act: Box::new(|tau| {
            let (mut output, mut before) = (0.0, 0.0);
            one(Act::Sensor(Box::new(move |now, force| {
                let behind = (force - before) / now.step * tau;
                let decay = (-now.step / tau).exp();
                output = force - behind + (output - before + behind) * decay;
                before = force;
                output
            })))
        }),
    }
}

/// A second-order low pass whose delay is the strength.
pub fn second_order(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let damping = even(random, 0.6, 1.0);
    Recipe {
        form: "second-order low pass, 1/omega the strength",
        inner: vec![("zeta", damping)],
        unit: "s",
        guess: 0.003,
        most: 0.2,
        act: Box::new(move |time| {
            let mut filter = Oscillator::new(1.0 / (TAU * time), damping);
            one(Act::Sensor(Box::new(move |now, force| filter.advance(now.step, force))))
        }),
    }
}

/// Bouc and Wen: F − s z, dz = (dF/W) (1 − z²) where z dF > 0, else dF/W.
pub fn bouc_wen(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let width = even(random, 0.1, 0.4) * setting.full_scale;
    Recipe {
        form: "Bouc-Wen: F - s z, dz = dF/W (1 - z^2 [z dF > 0])",
        inner: vec![("W_N", width)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let (mut z, mut before) = (0.0_f64, 0.0);
            one(Act::Sensor(Box::new(move |_, force| {
                let more = (force - before) / width;
                before = force;
                z += more * if z * more > 0.0 { 1.0 - z * z } else { 1.0 };
                force - s * z
            })))
        }),
    }
}

/// Prandtl and Ishlinskii: F − s Σ z_k/Σ r_k, z_k stops of widths r_k.
pub fn prandtl_ishlinskii(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    const SHARES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
    let width = even(random, 0.15, 0.5) * setting.full_scale;
    Recipe {
        form: "Prandtl-Ishlinskii: F - s sum z_k/sum r_k, four stops of widths up to W",
        inner: vec![("W_N", width)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let (mut stops, mut before) = ([0.0_f64; 4], 0.0);
            let all: f64 = SHARES.iter().map(|share| share * width).sum();
            one(Act::Sensor(Box::new(move |_, force| {
                for (stop, share) in stops.iter_mut().zip(SHARES) {
                    *stop = (*stop + force - before).clamp(-share * width, share * width);
                }
                before = force;
                force - s * stops.iter().sum::<f64>() / all
            })))
        }),
    }
}

fn mains(random: &mut ChaCha8Rng) -> (f64, f64) {
    let nominal = if sign(random) > 0.0 { 50.0 } else { 60.0 };
    (nominal + even(random, -0.1, 0.1), even(random, 0.0, TAU))
}

/// F + A sin(2π f t_set + φ): one clock through the whole set.
pub fn hum(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (frequency, phase) = mains(random);
    Recipe {
        form: "F + A sin(2 pi f t_set + phase)",
        inner: vec![("f_Hz", frequency), ("phase_rad", phase)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: added(move |now| (TAU * frequency * now.set_time + phase).sin()),
    }
}

/// The mains frequency wanders by some hundredths of a hertz.
pub fn wandering_hum(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (frequency, phase) = mains(random);
    let (swing, period) = (even(random, 0.01, 0.03), even(random, 60.0, 300.0));
    Recipe {
        form: "F + A sin(2 pi int f dt + phase), f = f0 + swing sin(2 pi t_set/period)",
        inner: vec![
            ("f0_Hz", frequency),
            ("phase_rad", phase),
            ("swing_Hz", swing),
            ("period_s", period),
        ],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: added(move |now| {
            let t = now.set_time;
            let turns = frequency * t + swing * period / TAU * (1.0 - (TAU * t / period).cos());
            (TAU * turns + phase).sin()
        }),
    }
}

/// What a neighbouring gauge feels: partly the force, partly a power of the compression.
#[derive(Clone, Copy, Debug)]
pub struct Neighbour {
    of_force: f64,
    exponent: f64,
    full_scale: f64,
}

impl Neighbour {
    /// Three neighbours; the first takes least of the force.
    #[must_use]
    pub fn three(full_scale: f64, random: &mut ChaCha8Rng) -> [Self; 3] {
        [(0.1, 0.4), (0.3, 0.7), (0.5, 0.9)].map(|(from, to)| Self {
            of_force: even(random, from, to),
            exponent: even(random, 0.5, 3.0),
            full_scale,
        })
    }

    /// What it feels, as a force, N.
    #[must_use]
    pub fn feels(&self, now: &Now<'_>, force: f64) -> f64 {
        let strain = (now.x.max(0.0) / 12.0).powf(self.exponent);
        self.of_force * force + (1.0 - self.of_force) * self.full_scale * strain
    }
}

/// Weights of three neighbours, of either sign, their squares summing to one.
fn weights(random: &mut ChaCha8Rng) -> [f64; 3] {
    let drawn = [(); 3].map(|()| sign(random) * even(random, 0.2, 1.0));
    let size = drawn.iter().map(|weight| weight * weight).sum::<f64>().sqrt();
    drawn.map(|weight| weight / size)
}

fn named([a, b, c]: [f64; 3]) -> Vec<(&'static str, f64)> {
    vec![("k12", a), ("k13", b), ("k14", c)]
}

/// gauge1 + s Σ k_j gauge_j; here and below in units of force.
pub fn crosstalk(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (neighbours, weights) = (setting.neighbours, weights(random));
    Recipe {
        form: "gauge1 + s sum k_1j gauge_j",
        inner: named(weights),
        unit: "",
        guess: 0.02,
        most: 0.5,
        act: Box::new(move |s| {
            one(Act::Sensor(Box::new(move |now, force| {
                let all = neighbours.iter().zip(weights);
                force + s * all.map(|(gauge, k)| k * gauge.feels(now, force)).sum::<f64>()
            })))
        }),
    }
}

/// Stray capacitance: gauge1 + s Σ k_j dgauge_j/dt.
pub fn capacitive_crosstalk(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (neighbours, weights) = (setting.neighbours, weights(random));
    Recipe {
        form: "gauge1 + s sum k_1j dgauge_j/dt",
        inner: named(weights),
        unit: "s",
        guess: 0.003,
        most: 0.5,
        act: Box::new(move |s| {
            let mut before = 0.0;
            one(Act::Sensor(Box::new(move |now, force| {
                let all = neighbours.iter().zip(weights);
                let sum: f64 = all.map(|(gauge, k)| k * gauge.feels(now, force)).sum();
                let slope = (sum - before) / now.step;
                before = sum;
                force + s * slope
            })))
        }),
    }
}
