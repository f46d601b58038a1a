//! At the contact.

use rand_chacha::ChaCha8Rng;

use crate::hidden::laws::contact::parting;
use crate::hidden::laws::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even};
use crate::hidden::specimen::{Act, Now};

fn smoothing(random: &mut ChaCha8Rng) -> f64 {
    log_even(random, 0.1, 1.0)
}

/// F + s h, with a law of the instant alone.
fn added(
    form: &'static str,
    inner: Vec<(&'static str, f64)>,
    unit: &'static str,
    guess: f64,
    most: f64,
    shape: impl Fn(&Now<'_>, f64) -> f64 + Copy + 'static,
) -> Recipe {
    let act = move |s| -> Vec<Act> {
        one(Act::Contact(Box::new(move |now, force| force + s * shape(now, force))))
    };
    Recipe { form, inner, unit, guess, most, act: Box::new(act) }
}

/// LuGre: bristles σ z + σ1 dz/dt with Stribeck's fall, dz/dt = v − |v| z/(g(v) ℓ).
pub fn lugre(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (length, more, fall) =
        (log_even(random, 0.01, 0.1), even(random, 0.2, 0.8), even(random, 3.0, 15.0));
    let damping = even(random, 0.0, 0.002);
    Recipe {
        form: "LuGre: F + Fc (z + d dz/dt), dz/dt = (v - |v| z/g)/l, g = 1 + a e^(-(v/vs)^2)",
        inner: vec![("l_mm", length), ("a", more), ("vs_mm_per_s", fall), ("d_s", damping)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut z = 0.0_f64;
            one(Act::Contact(Box::new(move |now, force| {
                let way = now.speed * now.step;
                let before = z;
                if way != 0.0 {
                    let most = 1.0 + more * (-(now.speed / fall).powi(2)).exp();
                    let end = way.signum() * most;
                    z = end + (z - end) * (-way.abs() / (most * length)).exp();
                }
                force + s * (z + damping * (z - before) / now.step)
            })))
        }),
    }
}

/// Unlike up and down: F + Fc tanh(v/v0), weaker by a factor on the way back.
pub fn one_sided_friction(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, back) = (smoothing(random), even(random, 0.2, 0.6));
    let shape = move |now: &Now<'_>, _: f64| {
        let side = (now.speed / v0).tanh();
        if side > 0.0 { side } else { back * side }
    };
    let inner = vec![("v0_mm_per_s", v0), ("r", back)];
    let full = setting.full_scale;
    added("F + Fc tanh(v/v0), r Fc in unloading", inner, "N", 0.003 * full, full, shape)
}

/// Iwan: eight elements that slip one after the other, at ways spread as a power.
struct Iwan {
    ways: [f64; 8],
    forces: [f64; 8],
}

impl Iwan {
    fn new(longest: f64) -> Self {
        let ways = std::array::from_fn(|k| longest * ((k as f64 + 1.0) / 8.0).powi(2));
        Self { ways, forces: [0.0; 8] }
    }

    fn advance(&mut self, now: &Now<'_>) -> f64 {
        for (force, way) in self.forces.iter_mut().zip(self.ways) {
            *force = (*force + now.speed * now.step / way).clamp(-1.0, 1.0);
        }
        self.forces.iter().sum::<f64>() / 8.0
    }
}

/// Friction that comes to slip bit by bit.
pub fn iwan(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let longest = log_even(random, 0.1, 0.6);
    Recipe {
        form: "Iwan: F + Fc mean of eight slip elements, ways up to l",
        inner: vec![("l_mm", longest)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut slip = Iwan::new(longest);
            one(Act::Contact(Box::new(move |now, force| force + s * slip.advance(now))))
        }),
    }
}

/// Friction of the load's power: F + μ FS (F/FS)^a tanh(v/v0).
pub fn load_power(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, a, full) = (smoothing(random), even(random, 0.6, 0.85), setting.full_scale);
    let shape = move |now: &Now<'_>, force: f64| {
        full * (force.max(0.0) / full).powf(a) * (now.speed / v0).tanh()
    };
    let inner = vec![("v0_mm_per_s", v0), ("a", a)];
    added("F + mu FS (F/FS)^a tanh(v/v0)", inner, "", 0.01, 0.5, shape)
}

/// F (1 + μ z), z of Iwan's elements.
pub fn load_iwan(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let longest = log_even(random, 0.1, 0.6);
    Recipe {
        form: "F (1 + mu mean of eight slip elements, ways up to l)",
        inner: vec![("l_mm", longest)],
        unit: "",
        guess: 0.01,
        most: 0.5,
        act: Box::new(move |s| {
            let mut slip = Iwan::new(longest);
            one(Act::Contact(Box::new(move |now, force| force * (1.0 + s * slip.advance(now)))))
        }),
    }
}

/// A drag that is not quite straight: F + η (10 mm/s) sgn(v) |v/(10 mm/s)|^m, m 0.7 to 1.3.
pub fn power_drag(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let m = even(random, 0.7, 1.3);
    let shape =
        move |now: &Now<'_>, _: f64| 10.0 * now.speed.signum() * (now.speed.abs() / 10.0).powf(m);
    let full = setting.full_scale;
    let form = "F + eta (10 mm/s) sgn(v) |v/(10 mm/s)|^m";
    added(form, vec![("m", m)], "N s/mm", 1e-4 * full, full, shape)
}

/// Drag in contact alone.
pub fn drag_in_contact(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let shape = |now: &Now<'_>, _: f64| if now.x > 0.0 { now.speed } else { 0.0 };
    let full = setting.full_scale;
    added("F + eta v for x > 0", vec![], "N s/mm", 1e-4 * full, full, shape)
}

/// A melt that thins: F + η v/(1 + |v|/v1).
pub fn thinning_drag(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let v1 = even(random, 40.0, 150.0);
    let shape = move |now: &Now<'_>, _: f64| now.speed / (1.0 + now.speed.abs() / v1);
    let full = setting.full_scale;
    let inner = vec![("v1_mm_per_s", v1)];
    added("F + eta v/(1 + |v|/v1)", inner, "N s/mm", 1e-4 * full, full, shape)
}

/// F + c ln(1 + |v|/v1) sgn v, a part of it on the way back.
pub fn logarithmic_rate(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v1, back) = (log_even(random, 0.5, 5.0), even(random, 0.5, 1.0));
    let shape = move |now: &Now<'_>, _: f64| {
        let size = (now.speed.abs() / v1).ln_1p();
        if now.speed > 0.0 { size } else { -back * size }
    };
    let full = setting.full_scale;
    let inner = vec![("v1_mm_per_s", v1), ("r", back)];
    added("F + c sgn(v) ln(1 + |v|/v1), r c in unloading", inner, "N", 0.001 * full, full, shape)
}

/// Rate drag that builds up over a way: F + c z |v/20|^m, z by slip elements.
pub fn rate_iwan(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (longest, m) = (log_even(random, 0.1, 0.4), even(random, 0.2, 0.5));
    Recipe {
        form: "F + c |v/(20 mm/s)|^m mean of eight slip elements, ways up to l",
        inner: vec![("l_mm", longest), ("m", m)],
        unit: "N",
        guess: 0.003 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut slip = Iwan::new(longest);
            one(Act::Contact(Box::new(move |now, force| {
                force + s * slip.advance(now) * (now.speed.abs() / 20.0).powf(m)
            })))
        }),
    }
}

/// The specimen moves along: F + m a (1 + x/8 mm).
pub fn added_mass(setting: &Setting, _: &mut ChaCha8Rng) -> Recipe {
    let shape = |now: &Now<'_>, _: f64| now.acceleration * (1.0 + now.x.max(0.0) / 8.0);
    let full = setting.full_scale;
    added("F + m a (1 + x/(8 mm))", vec![], "N s^2/mm", 1e-5 * full, full, shape)
}

/// The load cell feels the mass through its own low pass.
pub fn filtered_mass(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let tau = even(random, 0.002, 0.006);
    Recipe {
        form: "F + m y, tau dy/dt = a - y",
        inner: vec![("tau_s", tau)],
        unit: "N s^2/mm",
        guess: 1e-5 * setting.full_scale,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut y = 0.0;
            one(Act::Contact(Box::new(move |now, force| {
                y -= (now.acceleration - y) * (-now.step / tau).exp_m1();
                force + s * y
            })))
        }),
    }
}

/// A neck as of Johnson, Kendall and Roberts: it holds to ℓ beyond the touch, its pull falling as a
/// root, and reaches in to 2 ℓ.
pub fn neck(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, length) = (smoothing(random), even(random, 0.15, 0.45));
    let shape = move |now: &Now<'_>, _: f64| {
        let way = (now.x + length) / (3.0 * length);
        let pull =
            if (0.0..1.0).contains(&way) { (4.0 * way.sqrt() * (1.0 - way)).min(1.0) } else { 0.0 };
        -pull * parting(now, v0)
    };
    let inner = vec![("l_mm", length), ("v0_mm_per_s", v0)];
    let full = setting.full_scale;
    added(
        "neck: F - w 4 sqrt(u) (1 - u), u = (x + l)/(3 l), while v < 0",
        inner,
        "N",
        0.02 * full,
        2.0 * full,
        shape,
    )
}

/// Stronger the faster it parts, and gone exponentially: F − w (|v|/10)^a e^(−|x|/ℓ).
pub fn rate_adhesion(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, length, a) = (smoothing(random), log_even(random, 0.2, 0.6), even(random, 0.2, 0.6));
    let shape = move |now: &Now<'_>, _: f64| {
        let rate = (now.speed.abs() / 10.0).powf(a);
        -rate * (-now.x.abs() / length).exp() * parting(now, v0)
    };
    let inner = vec![("l_mm", length), ("a", a), ("v0_mm_per_s", v0)];
    let full = setting.full_scale;
    added(
        "F - w (|v|/(10 mm/s))^a e^(-|x|/l) while v < 0",
        inner,
        "N",
        0.02 * full,
        2.0 * full,
        shape,
    )
}

/// It lets go above the touch: F − w e^(−((x + x0)/ℓ)²) while parting.
pub fn adhesion_above(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (v0, length) = (smoothing(random), log_even(random, 0.1, 0.3));
    let above = even(random, 0.15, 0.35);
    let shape = move |now: &Now<'_>, _: f64| {
        -(-((now.x + above) / length).powi(2)).exp() * parting(now, v0)
    };
    let inner = vec![("l_mm", length), ("x0_mm", above), ("v0_mm_per_s", v0)];
    let full = setting.full_scale;
    added("F - w e^(-((x + x0)/l)^2) while v < 0", inner, "N", 0.02 * full, 2.0 * full, shape)
}
