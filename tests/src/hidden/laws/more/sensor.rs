//! In the sensor and its electronics.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::hidden::laws::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::{Act, Now};

/// F + s h, h of the instant alone, s a force.
fn added(
    form: &'static str,
    inner: Vec<(&'static str, f64)>,
    (guess, most): (f64, f64),
    shape: impl Fn(&Now<'_>) -> f64 + Copy + 'static,
) -> Recipe {
    let act = move |s| -> Vec<Act> {
        one(Act::Sensor(Box::new(move |now, force| force + s * shape(now))))
    };
    Recipe { form, inner, unit: "N", guess, most, act: Box::new(act) }
}

/// F changed by itself, s without unit.
fn bent(
    form: &'static str,
    inner: Vec<(&'static str, f64)>,
    (guess, most): (f64, f64),
    law: impl Fn(f64, f64) -> f64 + Copy + 'static,
) -> Recipe {
    let act = move |s| -> Vec<Act> { one(Act::Sensor(Box::new(move |_, force| law(force, s)))) };
    Recipe { form, inner, unit: "", guess, most, act: Box::new(act) }
}

/// Traces are tared or they are not: b or −b.
pub fn two_zeros(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let zeros: Vec<f64> = (0..setting.traces).map(|_| sign(random)).collect();
    Recipe {
        form: "F + b or F - b for each trace",
        inner: vec![],
        unit: "N",
        guess: 0.002 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let zeros = zeros.clone();
            one(Act::Sensor(Box::new(move |now, force| force + s * zeros[now.trace])))
        }),
    }
}

/// One trace alone was not tared.
pub fn one_zero(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let trace = random.random_range(0..setting.traces);
    let guess = 0.005 * setting.full_scale * sign(random);
    let shape = move |now: &Now<'_>| f64::from(u8::from(now.trace == trace));
    added("F + b in one trace", vec![("trace", trace as f64)], (guess, setting.full_scale), shape)
}

/// A drift that grows: F + d t (1 + t/t0), t of the set, min.
pub fn growing_drift(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let from = even(random, 5.0, 20.0);
    let shape = move |now: &Now<'_>| {
        let minutes = now.set_time / 60.0;
        minutes * (1.0 + minutes / from)
    };
    let guess = 0.0005 * setting.full_scale * sign(random);
    added(
        "F + d t (1 + t/t0), d per minute",
        vec![("t0_min", from)],
        (guess, setting.full_scale),
        shape,
    )
}

/// A leak that begins at a time.
pub fn late_drift(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let from = even(random, 60.0, 300.0);
    let shape = move |now: &Now<'_>| (now.set_time - from).max(0.0) / 60.0;
    let guess = 0.0005 * setting.full_scale * sign(random);
    added(
        "F + d (t - t1) from t1 on, d per minute",
        vec![("t1_s", from)],
        (guess, setting.full_scale),
        shape,
    )
}

/// Body and electronics warm up, each at its own pace.
pub fn two_stage_warm_up(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (fast, slow, share) =
        (log_even(random, 60.0, 200.0), log_even(random, 400.0, 2000.0), even(random, 0.3, 0.8));
    let shape = move |now: &Now<'_>| {
        let gone = |tau: f64| -(-now.set_time / tau).exp_m1();
        share * gone(fast) + (1.0 - share) * gone(slow)
    };
    let inner = vec![("tau1_s", fast), ("tau2_s", slow), ("share", share)];
    let guess = 0.005 * setting.full_scale * sign(random);
    let form = "F + b (share (1 - e^(-t/tau1)) + (1 - share) (1 - e^(-t/tau2)))";
    added(form, inner, (guess, setting.full_scale), shape)
}

/// F + b (1 − e^(−(t/τ)^a)).
pub fn stretched_warm_up(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (tau, a) = (log_even(random, 100.0, 500.0), even(random, 0.5, 0.8));
    let shape = move |now: &Now<'_>| -(-(now.set_time.max(0.0) / tau).powf(a)).exp_m1();
    let guess = 0.005 * setting.full_scale * sign(random);
    let inner = vec![("tau_s", tau), ("a", a)];
    added("F + b (1 - e^(-(t/tau)^a))", inner, (guess, setting.full_scale), shape)
}

/// The gauge and its lead each follow the air at their own pace, with opposite signs.
pub fn differential_thermal(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (tau, share) = (log_even(random, 30.0, 150.0), even(random, 0.2, 0.5));
    Recipe {
        form: "F + beta (dT - share dT_s), tau dT_s/dt = T - T_s",
        inner: vec![("tau_s", tau), ("share", share)],
        unit: "N/K",
        guess: 0.003 * setting.full_scale * sign(random),
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut lead: Option<f64> = None;
            one(Act::Sensor(Box::new(move |now, force| {
                let before = lead.unwrap_or(now.warmer);
                let after = before - (now.warmer - before) * (-now.step / tau).exp_m1();
                lead = Some(after);
                force + s * (now.warmer - share * after)
            })))
        }),
    }
}

/// Bounded: F + β w tanh(ΔT/w).
pub fn bounded_thermal(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let width = even(random, 0.5, 2.0);
    let shape = move |now: &Now<'_>| width * (now.warmer / width).tanh();
    let guess = 0.003 * setting.full_scale * sign(random);
    added(
        "F + beta w tanh(dT/w), beta per kelvin",
        vec![("w_K", width)],
        (guess, setting.full_scale),
        shape,
    )
}

/// Half a sine over the range.
pub fn sine_error(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let full = setting.full_scale;
    let guess = 0.01 * sign(random);
    bent("F - s FS sin(pi F/FS)", vec![("FS_N", full)], (guess, 0.25), move |f, s| {
        f - s * full * (PI * f / full).sin()
    })
}

/// The gain changes at part of the range.
pub fn two_gains(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let full = setting.full_scale;
    let (at, width) = (even(random, 0.3, 0.6) * full, even(random, 0.02, 0.08) * full);
    let inner = vec![("F1_N", at), ("w_N", width)];
    let guess = 0.02 * sign(random);
    bent("F - s w ln(1 + e^((F - F1)/w))", inner, (guess, 0.6), move |f, s| {
        f - s * width * ((f - at) / width).exp().ln_1p()
    })
}

/// Above a limit a part still comes through.
pub fn part_clip(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (full, through) = (setting.full_scale, even(random, 0.1, 0.35));
    let inner = vec![("FS_N", full), ("part", through)];
    bent("F_sat + part (F - F_sat) above F_sat = FS (1 - s)", inner, (0.05, 0.7), move |f, s| {
        let limit = full * (1.0 - s);
        if f > limit { limit + through * (f - limit) } else { f }
    })
}

/// An overloaded amplifier: it clips, and takes a while to come back.
pub fn sticky_clip(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (full, tau) = (setting.full_scale, log_even(random, 0.02, 0.15));
    Recipe {
        form: "min(F, FS (1 - s)) - o, o follows the overload at once and fades with tau",
        inner: vec![("FS_N", full), ("tau_s", tau)],
        unit: "",
        guess: 0.03,
        most: 0.6,
        act: Box::new(move |s| {
            let mut held = 0.0_f64;
            one(Act::Sensor(Box::new(move |now, force| {
                let over = (force - full * (1.0 - s)).max(0.0);
                held = (held * (-now.step / tau).exp()).max(0.1 * over);
                (force - over).max(0.0) - held.min((force - over).max(0.0))
            })))
        }),
    }
}

/// The mean of F over the last `length` seconds.
struct Boxcar {
    length: f64,
    /// Time that each value lasted, s, and the value.
    recent: VecDeque<(f64, f64)>,
    span: f64,
    sum: f64,
}

impl Boxcar {
    fn new(length: f64) -> Self {
        Self { length, recent: VecDeque::from([(length, 0.0)]), span: length, sum: 0.0 }
    }

    fn advance(&mut self, step: f64, value: f64) -> f64 {
        self.recent.push_back((step, value));
        self.span += step;
        self.sum += step * value;
        while self.span > self.length {
            let Some((lasted, oldest)) = self.recent.front_mut() else { break };
            let cut = (self.span - self.length).min(*lasted);
            *lasted -= cut;
            self.span -= cut;
            self.sum -= cut * *oldest;
            if *lasted <= 1e-12 {
                self.recent.pop_front();
            }
        }
        self.sum / self.length
    }
}

/// The filter of a sigma-delta converter: three moving means in a row.
pub fn sinc(_: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "sinc^3: three moving means of s in a row",
        inner: vec![],
        unit: "s",
        guess: 0.004,
        most: 0.2,
        act: Box::new(|s| {
            let mut means = [0; 3].map(|_| Boxcar::new(s));
            one(Act::Sensor(Box::new(move |now, force| {
                means.iter_mut().fold(force, |value, mean| mean.advance(now.step, value))
            })))
        }),
    }
}

/// A first-order low pass.
struct LowPass {
    output: f64,
}

impl LowPass {
    fn advance(&mut self, step: f64, tau: f64, value: f64) -> f64 {
        self.output -= (value - self.output) * (-step / tau).exp_m1();
        self.output
    }
}

/// Two low passes in a row.
pub fn cascade(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let ratio = even(random, 0.4, 1.0);
    Recipe {
        form: "two low passes in a row, tau and r tau",
        inner: vec![("r", ratio)],
        unit: "s",
        guess: 0.002,
        most: 0.2,
        act: Box::new(move |tau| {
            let mut passes = [LowPass { output: 0.0 }, LowPass { output: 0.0 }];
            one(Act::Sensor(Box::new(move |now, force| {
                let first = passes[0].advance(now.step, tau, force);
                passes[1].advance(now.step, ratio * tau, first)
            })))
        }),
    }
}

/// A diffusive lag: the mean of low passes with times of two decades about τ, weights τ^(−a).
pub fn fractional(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let a = even(random, 0.1, 0.6);
    Recipe {
        form: "mean of seven low passes, times s/10 to 10 s with weights as their power -a",
        inner: vec![("a", a)],
        unit: "s",
        guess: 0.003,
        most: 0.1,
        act: Box::new(move |s| {
            let times: Vec<f64> = (-3..=3).map(|k| s * 10f64.powf(f64::from(k) / 3.0)).collect();
            let weights: Vec<f64> = times.iter().map(|time| (time / s).powf(-a)).collect();
            let sum: f64 = weights.iter().sum();
            let mut passes: Vec<LowPass> = times.iter().map(|_| LowPass { output: 0.0 }).collect();
            one(Act::Sensor(Box::new(move |now, force| {
                let each = passes.iter_mut().zip(&times).zip(&weights);
                let all = each.map(|((pass, tau), w)| w * pass.advance(now.step, *tau, force));
                all.sum::<f64>() / sum
            })))
        }),
    }
}

/// The output follows no faster than FS/s.
pub fn slew(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let full = setting.full_scale;
    Recipe {
        form: "|dF_out/dt| at most FS/s",
        inner: vec![("FS_N", full)],
        unit: "s",
        guess: 0.12,
        most: 3.0,
        act: Box::new(move |s| {
            let mut output = 0.0;
            one(Act::Sensor(Box::new(move |now, force| {
                let most = full / s * now.step;
                output += (force - output).clamp(-most, most);
                output
            })))
        }),
    }
}

/// Duhem: F − s z, dz = (sgn(dF) − z) |dF|/W, wider the larger the force.
pub fn duhem(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (full, more) = (setting.full_scale, even(random, 0.0, 2.0));
    let width = even(random, 0.05, 0.3) * full;
    Recipe {
        form: "Duhem: F - s z (1 + k F/FS), dz = (sgn(dF) - z) |dF|/W",
        inner: vec![("W_N", width), ("k", more)],
        unit: "N",
        guess: 0.003 * full,
        most: full,
        act: Box::new(move |s| {
            let (mut z, mut before) = (0.0_f64, 0.0);
            one(Act::Sensor(Box::new(move |_, force| {
                let change: f64 = force - before;
                before = force;
                if change != 0.0 {
                    let end = change.signum();
                    z = end + (z - end) * (-change.abs() / width).exp();
                }
                force - s * z * (1.0 + more * force.max(0.0) / full)
            })))
        }),
    }
}

/// Preisach: relays on a grid of thresholds, more of them near zero.
pub fn preisach(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    const COUNT: usize = 40;
    let (full, fall) = (setting.full_scale, even(random, 0.1, 0.5));
    Recipe {
        form: "Preisach: F - s mean of 820 relays, weights e^(-width/(k FS))",
        inner: vec![("k", fall)],
        unit: "N",
        guess: 0.005 * full,
        most: full,
        act: Box::new(move |s| {
            let at = |k: usize| full * (k as f64 + 0.5) / COUNT as f64;
            let mut relays: Vec<(f64, f64, f64, f64)> = (0..COUNT)
                .flat_map(|up| (0..=up).map(move |down| (up, down)))
                .map(|(up, down)| {
                    let width = (up - down) as f64 / COUNT as f64;
                    (at(up), at(down) - full / COUNT as f64, (-width / fall).exp(), -1.0)
                })
                .collect();
            let sum: f64 = relays.iter().map(|(_, _, weight, _)| weight).sum();
            let (mut before, mut mean, mut smooth) = (0.0, -1.0, -1.0);
            one(Act::Sensor(Box::new(move |_, force| {
                if force != before {
                    for (up, down, _, state) in &mut relays {
                        *state = if force >= *up {
                            1.0
                        } else if force <= *down {
                            -1.0
                        } else {
                            *state
                        };
                    }
                    before = force;
                    mean = relays.iter().map(|(_, _, w, state)| w * state).sum::<f64>() / sum;
                }
                // A grid has steps; a real material has none.
                smooth += 0.1 * (mean - smooth);
                // The part in proportion to F is gain, not loop.
                force - s * (smooth + 1.0)
            })))
        }),
    }
}

fn mains(random: &mut ChaCha8Rng) -> (f64, f64) {
    let nominal = if sign(random) > 0.0 { 50.0 } else { 60.0 };
    (nominal + even(random, -0.1, 0.1), even(random, 0.0, TAU))
}

/// A hum that swells and fades.
pub fn swelling_hum(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let ((frequency, phase), depth, period) =
        (mains(random), even(random, 0.3, 0.9), even(random, 5.0, 60.0));
    let shape = move |now: &Now<'_>| {
        let size = 1.0 + depth * (TAU * now.set_time / period).sin();
        size * (TAU * frequency * now.set_time + phase).sin()
    };
    let inner = vec![("f_Hz", frequency), ("depth", depth), ("period_s", period)];
    let full = setting.full_scale;
    added(
        "F + A (1 + depth sin(2 pi t/period)) sin(2 pi f t + phase)",
        inner,
        (0.003 * full, full),
        shape,
    )
}

/// A rectifier: the hum and its second overtone.
pub fn bent_hum(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let ((frequency, phase), third) = (mains(random), even(random, 0.2, 0.6));
    let shape = move |now: &Now<'_>| {
        let turn = TAU * frequency * now.set_time + phase;
        turn.sin() + third * (3.0 * turn).sin()
    };
    let inner = vec![("f_Hz", frequency), ("third", third)];
    let full = setting.full_scale;
    added("F + A (sin(2 pi f t) + third sin(6 pi f t))", inner, (0.003 * full, full), shape)
}

/// The neighbours leak through a diode: gauge1 + s Σ k_j gauge_j²/FS.
pub fn quadratic_crosstalk(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (neighbours, full) = (setting.neighbours, setting.full_scale);
    let weights = [(); 3].map(|()| sign(random) * even(random, 0.2, 1.0));
    Recipe {
        form: "gauge1 + s sum k_1j gauge_j (1 + gauge_j/FS)/2",
        inner: vec![("k12", weights[0]), ("k13", weights[1]), ("k14", weights[2])],
        unit: "",
        guess: 0.02,
        most: 0.5,
        act: Box::new(move |s| {
            one(Act::Sensor(Box::new(move |now, force| {
                let all = neighbours.iter().zip(weights).map(|(gauge, k)| {
                    let felt = gauge.feels(now, force);
                    0.5 * k * felt * (1.0 + felt / full)
                });
                force + s * all.sum::<f64>()
            })))
        }),
    }
}
