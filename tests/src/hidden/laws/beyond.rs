//! Steady effects that neither the library nor the grammar of formulas holds: at every stage of the chain, each with the
//! quantities that it depends on.

use std::f64::consts::{PI, TAU};
use std::rc::Rc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Draw, Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::{Act, Now};

/// An effect: its name, its law, and the quantities that it depends on, each by any of several symbols.
#[derive(Clone, Copy, Debug)]
pub struct Beyond {
    /// Name.
    pub name: &'static str,
    /// Its law.
    pub draw: Draw,
    /// For every quantity that the law depends on, the symbols by which it may be named.
    pub depends_on: &'static [&'static [&'static str]],
}

const PLACE: &[&str] = &["x"];
const SPEED: &[&str] = &["v"];
const TIME: &[&str] = &["t", "since"];

/// All of them, by their place in the chain.
pub const BEYOND: &[Beyond] = &[
    Beyond { name: "screw", draw: screw, depends_on: &[PLACE] },
    Beyond { name: "spindle", draw: spindle, depends_on: &[PLACE] },
    Beyond { name: "lifting-carriage", draw: lifting_carriage, depends_on: &[SPEED] },
    Beyond { name: "inclusion", draw: inclusion, depends_on: &[PLACE] },
    Beyond { name: "thixotropy", draw: thixotropy, depends_on: &[SPEED] },
    Beyond { name: "swelling", draw: swelling, depends_on: &[&["t_set", "n"]] },
    Beyond { name: "fast-inside", draw: fast_inside, depends_on: &[PLACE] },
    Beyond { name: "stribeck-hump", draw: stribeck_hump, depends_on: &[SPEED] },
    Beyond { name: "squeezed-film", draw: squeezed_film, depends_on: &[PLACE, SPEED] },
    Beyond { name: "suction", draw: suction, depends_on: &[PLACE, SPEED] },
    Beyond { name: "seam", draw: seam, depends_on: &[PLACE, SPEED] },
    Beyond { name: "breathing", draw: breathing, depends_on: &[TIME] },
    Beyond { name: "staircase", draw: staircase, depends_on: &[&["F", "N"]] },
    Beyond { name: "late-direction", draw: late_direction, depends_on: &[SPEED] },
    Beyond { name: "cable", draw: cable, depends_on: &[PLACE, SPEED] },
];

/// The effect of a name.
#[must_use]
pub fn beyond(name: &str) -> Option<&'static Beyond> {
    BEYOND.iter().find(|effect| effect.name == name)
}

type Law = dyn Fn(&Now<'_>, f64) -> f64;

/// What a law makes of a displacement or a force at one instant.
type Changed = Box<dyn FnMut(&Now<'_>, f64) -> f64>;

/// A law without a memory that adds `s` times something to a displacement or a force.
fn adds(
    form: &'static str,
    inner: Vec<(&'static str, f64)>,
    (unit, guess, most): (&'static str, f64, f64),
    act: fn(Changed) -> Act,
    shape: impl Fn(&Now<'_>, f64) -> f64 + 'static,
) -> Recipe {
    let shape: Rc<Law> = Rc::new(shape);
    let act = move |s: f64| -> Vec<Act> {
        let shape = Rc::clone(&shape);
        one(act(Box::new(move |now, value| value + s * shape(now, value))))
    };
    Recipe { form, inner, unit, guess, most, act: Box::new(act) }
}

fn newtons(setting: &Setting) -> (&'static str, f64, f64) {
    ("N", 0.01 * setting.full_scale, 20.0 * setting.full_scale)
}

/// A wave of straight flanks, −1 to 1.
fn triangle(turns: f64) -> f64 {
    4.0 * (turns - (turns + 0.5).floor()).abs() - 1.0
}

/// The pitch of a screw errs: the place is off along a wave of straight flanks.
fn screw(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (pitch, phase) = (even(random, 1.5, 4.0), even(random, 0.0, 1.0));
    let inner = vec![("pitch_mm", pitch), ("phase", phase)];
    let size = ("mm", 0.01, 1.0);
    adds("x + s triangle(x/pitch + phase)", inner, size, Act::Motion, move |now, _| {
        triangle(now.x / pitch + phase)
    })
}

/// A bent spindle lifts the carriage twice a turn.
fn spindle(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (turn, phase) = (even(random, 2.5, 6.0), even(random, 0.0, PI));
    let inner = vec![("turn_mm", turn), ("phase_rad", phase)];
    let size = ("mm", 0.01, 1.0);
    adds("x + s |sin(pi x/turn + phase)|", inner, size, Act::Motion, move |now, _| {
        (PI * now.x / turn + phase).sin().abs()
    })
}

/// The carriage lifts with the speed, whichever way it goes.
fn lifting_carriage(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let power = even(random, 0.4, 0.8);
    let shape = move |now: &Now<'_>, _| -(now.speed.abs() / 60.0).powf(power);
    adds("x - s (|v|/60)^m", vec![("m", power)], ("mm", 0.02, 1.0), Act::Motion, shape)
}

/// A hard inclusion: the specimen is stiffer over a plateau of compression.
fn inclusion(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
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
fn thixotropy(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
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
fn swelling(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
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
fn fast_inside(_: &Setting, random: &mut ChaCha8Rng) -> Recipe {
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

/// Friction with a hump over the speed.
fn stribeck_hump(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (at, width) = (log_even(random, 8.0, 40.0), even(random, 0.5, 1.0));
    let shape = move |now: &Now<'_>, _| {
        let off = (now.speed.abs().max(1e-9) / at).ln() / width;
        now.speed.signum() * (-off * off).exp()
    };
    let inner = vec![("speed_mm_per_s", at), ("width", width)];
    let form = "F + s sgn(v) e^(-(ln(|v|/v_0)/w)^2)";
    adds(form, inner, newtons(setting), Act::Contact, shape)
}

/// A liquid film is squeezed out of the gap: Reynolds' force over the cube of what is left of it.
fn squeezed_film(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let thick = even(random, 0.4, 1.5);
    let shape = move |now: &Now<'_>, _| {
        let gap = thick + now.x.max(0.0);
        if now.x > -thick { now.speed / 20.0 * (thick / gap).powi(3) } else { 0.0 }
    };
    let form = "F + s (v/20) (h/(h + x))^3";
    adds(form, vec![("h_mm", thick)], newtons(setting), Act::Contact, shape)
}

/// While it leaves the tip sucks, the more the faster, near the end of contact.
fn suction(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let reach = even(random, 0.8, 2.5);
    let shape = move |now: &Now<'_>, _| {
        let leaving = now.speed < 0.0 && now.x > 0.0;
        if leaving {
            -(-now.speed / 60.0).sqrt() * (now.x / reach) * (-now.x / reach).exp()
        } else {
            0.0
        }
    };
    let form = "F - s sqrt(|v|/60) (x/r) e^(-x/r) while leaving";
    adds(form, vec![("r_mm", reach)], newtons(setting), Act::Contact, shape)
}

/// The tip passes a seam on its way out only: a triangle of force.
fn seam(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (at, width) = (even(random, 1.0, 3.2), even(random, 0.3, 0.8));
    let shape = move |now: &Now<'_>, _| {
        if now.speed < 0.0 { (1.0 - (now.x - at).abs() / width).max(0.0) } else { 0.0 }
    };
    let inner = vec![("x_s_mm", at), ("w_mm", width)];
    adds("F + s (1 - |x - x_s|/w) while leaving", inner, newtons(setting), Act::Contact, shape)
}

/// The amplifier swings when a recording begins, and calms down.
fn breathing(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (period, calms) = (even(random, 0.8, 2.5), even(random, 1.0, 4.0));
    let phase = even(random, 0.0, TAU);
    let shape =
        move |now: &Now<'_>, _| (-now.time / calms).exp() * (TAU * now.time / period + phase).sin();
    let inner = vec![("period_s", period), ("calms_s", calms), ("phase_rad", phase)];
    let form = "F + s e^(-t/tau) sin(2 pi t/period + phase)";
    adds(form, inner, newtons(setting), Act::Sensor, shape)
}

/// The converter errs along a sawtooth of the signal.
fn staircase(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let step = even(random, 0.08, 0.25) * setting.full_scale;
    let sign = sign(random);
    let shape = move |_: &Now<'_>, force: f64| {
        let turns = force / step;
        sign * (turns - turns.floor() - 0.5)
    };
    adds("F + s (frac(F/step) - 1/2)", vec![("step_N", step)], newtons(setting), Act::Sensor, shape)
}

/// Something turns over with the direction of the motion, and late.
fn late_direction(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let late = log_even(random, 0.2, 0.8);
    let guess = 0.005 * setting.full_scale;
    Recipe {
        form: "F + s y, tau dy/dt = sgn(v) - y",
        inner: vec![("tau_s", late)],
        unit: "N",
        guess,
        most: setting.full_scale,
        act: Box::new(move |s| {
            let mut behind = 0.0;
            one(Act::Sensor(Box::new(move |now, force| {
                let way = if now.speed == 0.0 { 0.0 } else { now.speed.signum() };
                behind = way + (behind - way) * (-now.step / late).exp();
                force + s * behind
            })))
        }),
    }
}

/// A cable is dragged along: it pulls the more the farther out and the faster.
fn cable(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (power, bend) = (even(random, 0.2, 0.6), even(random, 2.0, 6.0));
    let side: f64 = [-1.0, 1.0][random.random_range(0..2)];
    let shape =
        move |now: &Now<'_>, _| side * (now.speed.abs() / 20.0).powf(power) * (now.x / bend).atan();
    let inner = vec![("m", power), ("bend_mm", bend)];
    adds("F + s |v/20|^m atan(x/b)", inner, newtons(setting), Act::Sensor, shape)
}
