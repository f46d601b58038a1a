//! Between tip and specimen.

use rand_chacha::ChaCha8Rng;

use super::super::{Recipe, Setting, one};
use super::{adds, newtons};
use crate::hidden::random::{even, log_even};
use crate::hidden::specimen::{Act, Now};

/// Friction with a hump over the speed.
pub(super) fn stribeck_hump(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
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
pub(super) fn squeezed_film(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let thick = even(random, 0.4, 1.5);
    let shape = move |now: &Now<'_>, _| {
        let gap = thick + now.x.max(0.0);
        if now.x > -thick { now.speed / 20.0 * (thick / gap).powi(3) } else { 0.0 }
    };
    let form = "F + s (v/20) (h/(h + x))^3";
    adds(form, vec![("h_mm", thick)], newtons(setting), Act::Contact, shape)
}

/// A film is pushed aside near the touch, with the drag of a fluid in turbulence.
pub(super) fn splashed_film(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let reach = even(random, 0.8, 2.5);
    let shape = move |now: &Now<'_>, _| {
        let drag = now.speed * now.speed.abs() / 900.0;
        if now.x > 0.0 { drag * (-now.x / reach).exp() } else { 0.0 }
    };
    let form = "F + s v |v|/900 e^(-x/r) in contact";
    adds(form, vec![("r_mm", reach)], newtons(setting), Act::Contact, shape)
}

/// While it leaves the tip sucks, the more the faster, near the end of contact.
pub(super) fn suction(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
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
pub(super) fn seam(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (at, width) = (even(random, 1.0, 3.2), even(random, 0.3, 0.8));
    let shape = move |now: &Now<'_>, _| {
        if now.speed < 0.0 { (1.0 - (now.x - at).abs() / width).max(0.0) } else { 0.0 }
    };
    let inner = vec![("x_s_mm", at), ("w_mm", width)];
    adds("F + s (1 - |x - x_s|/w) while leaving", inner, newtons(setting), Act::Contact, shape)
}

/// A ratchet: a sawtooth along the way in, nothing on the way out.
pub(super) fn ratchet(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (pitch, phase) = (even(random, 1.2, 3.0), even(random, 0.0, 1.0));
    let shape = move |now: &Now<'_>, _| {
        let turns = now.x / pitch + phase;
        if now.speed > 0.0 { turns - turns.floor() } else { 0.0 }
    };
    let inner = vec![("pitch_mm", pitch), ("phase", phase)];
    adds("F + s frac(x/pitch + phase) while pressing", inner, newtons(setting), Act::Contact, shape)
}

/// Beyond a depth the flank of the tip rubs along a wall, more on the way in.
pub(super) fn side_wall(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let from = even(random, 2.0, 6.5);
    let shape = move |now: &Now<'_>, _| {
        let way = if now.speed == 0.0 { 0.0 } else { now.speed.signum() };
        (now.x - from).max(0.0).sqrt() * (1.0 + 0.6 * way)
    };
    let inner = vec![("x_w_mm", from)];
    adds("F + s sqrt(x - x_w) (1 + 0.6 sgn v)", inner, newtons(setting), Act::Contact, shape)
}

/// The longer the tip has lain, the more it sticks as it leaves.
pub(super) fn dwelling_tack(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (power, reach) = (even(random, 0.2, 0.5), even(random, 0.5, 2.0));
    let (unit, guess, most) = newtons(setting);
    Recipe {
        form: "F - s D^m e^(-|x|/r) while leaving, D = seconds touched",
        inner: vec![("m", power), ("r_mm", reach)],
        unit,
        guess,
        most,
        act: Box::new(move |s| {
            let mut touched: f64 = 0.0;
            one(Act::Contact(Box::new(move |now, force| {
                touched = if now.x > 0.0 { touched + now.step } else { 0.0 };
                let leaving = now.speed < 0.0 && now.x > 0.0;
                force - if leaving { s * touched.powf(power) * (-now.x / reach).exp() } else { 0.0 }
            })))
        }),
    }
}
