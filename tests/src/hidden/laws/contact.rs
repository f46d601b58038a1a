//! At the contact. Signs of the speed are smoothed as tanh(v/v0); the laws act off the specimen too,
//! as EFFECTS.md writes them, unless they grow with load or contact.

use rand_chacha::ChaCha8Rng;

use super::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even};
use crate::hidden::specimen::{Act, Now};

fn smoothing(random: &mut ChaCha8Rng) -> f64 {
    log_even(random, 0.1, 1.0)
}

/// F + Fc tanh(v/v0).
pub fn coulomb(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let v0 = smoothing(random);
    Recipe {
        form: "F + Fc tanh(v/v0)",
        inner: vec![("v0_mm_per_s", v0)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            one(Act::Contact(Box::new(move |now, force| force + s * (now.speed / v0).tanh())))
        }),
    }
}

/// Dahl's presliding: dz/dx = (1 − z sgn v)/ℓ.
struct Dahl {
    length: f64,
    state: f64,
}

impl Dahl {
    fn new(length: f64) -> Self {
        Self { length, state: 0.0 }
    }

    fn advance(&mut self, now: &Now<'_>) -> f64 {
        let way = now.speed * now.step;
        if way != 0.0 {
            let end = way.signum();
            self.state = end + (self.state - end) * (-way.abs() / self.length).exp();
        }
        self.state
    }
}

/// F + Fc z, z by Dahl: friction stays frozen in the hold.
pub fn dahl(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let length = log_even(random, 0.03, 0.3);
    Recipe {
        form: "Dahl: F + Fc z, dz/dx = (1 - z sgn v)/l",
        inner: vec![("l_mm", length)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut friction = Dahl::new(length);
            one(Act::Contact(Box::new(move |now, force| force + s * friction.advance(now))))
        }),
    }
}

/// F + Fc (1 + a e^(−(v/vs)²)) tanh(v/v0).
pub fn stribeck(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, more, fall) = (smoothing(random), even(random, 0.3, 1.0), even(random, 4.0, 15.0));
    Recipe {
        form: "Stribeck: F + Fc (1 + a e^(-(v/vs)^2)) tanh(v/v0)",
        inner: vec![("v0_mm_per_s", v0), ("a", more), ("vs_mm_per_s", fall)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            one(Act::Contact(Box::new(move |now, force| {
                let size = 1.0 + more * (-(now.speed / fall).powi(2)).exp();
                force + s * size * (now.speed / v0).tanh()
            })))
        }),
    }
}

/// F (1 + μ tanh(v/v0)).
pub fn load(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let v0 = smoothing(random);
    Recipe {
        form: "F (1 + mu tanh(v/v0))",
        inner: vec![("v0_mm_per_s", v0)],
        unit: "",
        guess: 0.01,
        most: 0.5,
        act: Box::new(move |s| {
            one(Act::Contact(Box::new(move |now, force| {
                force * (1.0 + s * (now.speed / v0).tanh())
            })))
        }),
    }
}

/// F (1 + μ z), z by Dahl.
pub fn load_dahl(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let length = log_even(random, 0.03, 0.3);
    Recipe {
        form: "Dahl: F (1 + mu z), dz/dx = (1 - z sgn v)/l",
        inner: vec![("l_mm", length)],
        unit: "",
        guess: 0.01,
        most: 0.5,
        act: Box::new(move |s| {
            let mut friction = Dahl::new(length);
            one(Act::Contact(Box::new(move |now, force| force * (1.0 + s * friction.advance(now)))))
        }),
    }
}

/// F + η v.
pub fn viscous(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "F + eta v",
        inner: vec![],
        unit: "N s/mm",
        guess: 1e-4 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(|s| one(Act::Contact(Box::new(move |now, force| force + s * now.speed)))),
    }
}

/// Drag over a contact area that grows with compression: F + η v x/8.
pub fn viscous_area(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "F + eta v x/8 mm for x > 0",
        inner: vec![],
        unit: "N s/mm",
        guess: 1e-4 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(|s| {
            one(Act::Contact(Box::new(move |now, force| {
                force + s * now.speed * now.x.max(0.0) / 8.0
            })))
        }),
    }
}

/// F + c tanh(v/v0) |v/20|^m.
pub fn rate(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, m) = (smoothing(random), even(random, 0.2, 0.5));
    Recipe {
        form: "F + c tanh(v/v0) |v/(20 mm/s)|^m",
        inner: vec![("v0_mm_per_s", v0), ("m", m)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            one(Act::Contact(Box::new(move |now, force| {
                force + s * (now.speed / v0).tanh() * (now.speed.abs() / 20.0).powf(m)
            })))
        }),
    }
}

/// F + c asinh(v/v1).
pub fn eyring(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let v1 = log_even(random, 0.3, 3.0);
    Recipe {
        form: "Eyring: F + c asinh(v/v1)",
        inner: vec![("v1_mm_per_s", v1)],
        unit: "N",
        guess: 0.001 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            one(Act::Contact(Box::new(move |now, force| force + s * (now.speed / v1).asinh())))
        }),
    }
}

/// F + m a.
pub fn inertia(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    Recipe {
        form: "F + m a",
        inner: vec![],
        unit: "N s^2/mm",
        guess: 1e-5 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(|s| {
            one(Act::Contact(Box::new(move |now, force| force + s * now.acceleration)))
        }),
    }
}

/// The mass sits on a spring and a damper: F + m y, y'' + 2ζω y' + ω² y = ω² a.
pub fn sprung_mass(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (frequency, damping) = (even(random, 30.0, 70.0), even(random, 0.3, 0.6));
    Recipe {
        form: "F + m y, y'' + 2 zeta omega y' + omega^2 y = omega^2 a",
        inner: vec![("frequency_Hz", frequency), ("zeta", damping)],
        unit: "N s^2/mm",
        guess: 1e-5 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut mass = Oscillator::new(frequency, damping);
            one(Act::Contact(Box::new(move |now, force| {
                force + s * mass.advance(now.step, now.acceleration)
            })))
        }),
    }
}

/// y'' + 2ζω y' + ω² y = ω² (what drives it).
pub(super) struct Oscillator {
    omega: f64,
    damping: f64,
    y: f64,
    speed: f64,
}

impl Oscillator {
    pub(super) fn new(frequency: f64, damping: f64) -> Self {
        Self { omega: std::f64::consts::TAU * frequency, damping, y: 0.0, speed: 0.0 }
    }

    /// Runge–Kutta of the fourth order with steps of at most half of 1/ω; in a long step it has come
    /// to rest.
    pub(super) fn advance(&mut self, step: f64, drive: f64) -> f64 {
        let pieces = (2.0 * self.omega * step).ceil().max(1.0);
        if self.damping * self.omega * step > 30.0 {
            (self.y, self.speed) = (drive, 0.0);
            return self.y;
        }
        let h = step / pieces;
        let (w2, friction) = (self.omega * self.omega, 2.0 * self.damping * self.omega);
        let slope = |y: f64, u: f64| (u, w2 * (drive - y) - friction * u);
        for _ in 0..pieces as usize {
            let (y, u) = (self.y, self.speed);
            let (a, b) = slope(y, u);
            let (c, d) = slope(y + 0.5 * h * a, u + 0.5 * h * b);
            let (e, f) = slope(y + 0.5 * h * c, u + 0.5 * h * d);
            let (g, i) = slope(y + h * e, u + h * f);
            self.y += h / 6.0 * (a + 2.0 * c + 2.0 * e + g);
            self.speed += h / 6.0 * (b + 2.0 * d + 2.0 * f + i);
        }
        self.y
    }
}

/// How far the surfaces are parting: 0 at rest and in loading, 1 in unloading.
pub(super) fn parting(now: &Now<'_>, v0: f64) -> f64 {
    (-now.speed / v0).tanh().max(0.0)
}

/// F − w e^(−(x/ℓ)²) while parting.
pub fn adhesion(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, length) = (smoothing(random), log_even(random, 0.2, 0.8));
    Recipe {
        form: "F - w e^(-(x/l)^2) tanh(-v/v0) while v < 0",
        inner: vec![("l_mm", length), ("v0_mm_per_s", v0)],
        unit: "N",
        guess: 0.02 * setting.full_scale,
        most: 2.0 * setting.full_scale,
        act: Box::new(move |s| {
            one(Act::Contact(Box::new(move |now, force| {
                force - s * (-(now.x / length).powi(2)).exp() * parting(now, v0)
            })))
        }),
    }
}

/// A cohesive zone: from where the force has gone, F − w (s/ℓ) e^(1 − s/ℓ), s the way since.
pub fn cohesive(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, length) = (smoothing(random), log_even(random, 0.1, 0.5));
    Recipe {
        form: "cohesive zone: F - w (s/l) e^(1 - s/l), s the way since the force had gone",
        inner: vec![("l_mm", length), ("v0_mm_per_s", v0)],
        unit: "N",
        guess: 0.02 * setting.full_scale,
        most: 2.0 * setting.full_scale,
        act: Box::new(move |w| {
            let mut parted_at = f64::INFINITY;
            one(Act::Contact(Box::new(move |now, force| {
                if force > 0.0 {
                    parted_at = now.x;
                }
                let way = (parted_at - now.x).max(0.0) / length;
                if way.is_finite() {
                    force - w * way * (1.0 - way).exp() * parting(now, v0)
                } else {
                    force
                }
            })))
        }),
    }
}
