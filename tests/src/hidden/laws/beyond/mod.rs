//! Steady effects that neither the library nor the grammar of formulas holds: at every stage of the chain, each with the
//! quantities that it depends on.

mod contact;
mod motion;
mod sensor;
mod specimen;

use std::rc::Rc;

use super::{Draw, Recipe, Setting, one};
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
const FORCE: &[&str] = &["F", "N"];
const HISTORY: &[&str] = &["t_set", "n"];
/// What is pressed and what comes of it: one goes with the other.
const LOAD: &[&str] = &["F", "N", "x"];

/// All of them, by their place in the chain.
#[rustfmt::skip]
pub const BEYOND: &[Beyond] = &[
    Beyond { name: "screw", draw: motion::screw, depends_on: &[PLACE] },
    Beyond { name: "spindle", draw: motion::spindle, depends_on: &[PLACE] },
    Beyond { name: "lifting-carriage", draw: motion::lifting_carriage, depends_on: &[SPEED] },
    Beyond { name: "belt", draw: motion::belt, depends_on: &[SPEED] },
    Beyond { name: "running-in", draw: motion::running_in, depends_on: &[HISTORY] },
    Beyond { name: "inclusion", draw: specimen::inclusion, depends_on: &[PLACE] },
    Beyond { name: "thixotropy", draw: specimen::thixotropy, depends_on: &[SPEED] },
    Beyond { name: "swelling", draw: specimen::swelling, depends_on: &[HISTORY] },
    Beyond { name: "fast-inside", draw: specimen::fast_inside, depends_on: &[PLACE] },
    Beyond { name: "two-struts", draw: specimen::two_struts, depends_on: &[PLACE] },
    Beyond { name: "weeping", draw: specimen::weeping, depends_on: &[LOAD] },
    Beyond { name: "fast-when-light", draw: specimen::fast_when_light, depends_on: &[LOAD] },
    Beyond { name: "snap-through", draw: specimen::snap_through, depends_on: &[LOAD] },
    Beyond { name: "stiff-when-fast", draw: specimen::stiff_when_fast, depends_on: &[SPEED] },
    Beyond { name: "stribeck-hump", draw: contact::stribeck_hump, depends_on: &[SPEED] },
    Beyond { name: "squeezed-film", draw: contact::squeezed_film, depends_on: &[PLACE, SPEED] },
    Beyond { name: "splashed-film", draw: contact::splashed_film, depends_on: &[PLACE, SPEED] },
    Beyond { name: "suction", draw: contact::suction, depends_on: &[PLACE, SPEED] },
    Beyond { name: "seam", draw: contact::seam, depends_on: &[PLACE, SPEED] },
    Beyond { name: "ratchet", draw: contact::ratchet, depends_on: &[PLACE, SPEED] },
    Beyond { name: "side-wall", draw: contact::side_wall, depends_on: &[PLACE, SPEED] },
    Beyond { name: "dwelling-tack", draw: contact::dwelling_tack, depends_on: &[PLACE, SPEED] },
    Beyond { name: "breathing", draw: sensor::breathing, depends_on: &[TIME] },
    Beyond { name: "staircase", draw: sensor::staircase, depends_on: &[FORCE] },
    Beyond { name: "late-direction", draw: sensor::late_direction, depends_on: &[SPEED] },
    Beyond { name: "cable", draw: sensor::cable, depends_on: &[PLACE, SPEED] },
    Beyond { name: "self-heating", draw: sensor::self_heating, depends_on: &[LOAD] },
    Beyond { name: "beat", draw: sensor::beat, depends_on: &[TIME, FORCE] },
    Beyond { name: "swing-out", draw: sensor::swing_out, depends_on: &[SPEED] },
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
