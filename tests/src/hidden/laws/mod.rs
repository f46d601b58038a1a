//! The hidden laws: for each effect its reference form and other forms of the same physics.

pub mod contact;
pub mod elastic;
pub mod motion;
pub mod outside;
pub mod relaxation;
pub mod sensor;

use rand_chacha::ChaCha8Rng;

use super::specimen::{Act, Base};

/// What the laws are scaled by.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// The specimen.
    pub base: Base,
    /// Largest force of the base over the data set, N: full scale of the force channel.
    pub full_scale: f64,
    /// Number of traces.
    pub traces: usize,
    /// The gauges beside the first, where there are gauges.
    pub neighbours: [sensor::Neighbour; 3],
}

/// A law with its inner parameters drawn and only its strength open.
#[allow(missing_debug_implementations)]
pub struct Recipe {
    /// The law in words and symbols.
    pub form: &'static str,
    /// Inner parameters by name, their unit part of the name.
    pub inner: Vec<(&'static str, f64)>,
    /// Unit of the strength.
    pub unit: &'static str,
    /// First guess of the strength; its sign is the law's.
    pub guess: f64,
    /// Largest size of the strength that physics allows.
    pub most: f64,
    /// The law at a strength.
    pub act: Box<dyn Fn(f64) -> Vec<Act>>,
}

/// Draws a law's inner parameters.
pub type Draw = fn(&Setting, &mut ChaCha8Rng) -> Recipe;

/// Which law of an effect is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawKind {
    /// The reference law of the library of effects.
    Reference,
    /// Another law of the same physics.
    Foreign,
    /// Something the library does not hold.
    Outside,
}

/// One effect with its laws.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// Name in the library of effects.
    pub name: &'static str,
    /// Its place in the chain: 1 motion … 5 sensor.
    pub stage: u8,
    /// The reference law.
    pub reference: Draw,
    /// Other laws of the same physics.
    pub foreign: &'static [Draw],
}

/// The one effect that needs gauges; its data sets have four, and the first shows it.
pub const CROSSTALK: &str = "crosstalk";

/// Every effect of the library.
#[rustfmt::skip]
pub const EFFECTS: &[Effect] = &[
    Effect { name: "contact-offset", stage: 1, reference: motion::offset, foreign: &[motion::tilt] },
    Effect { name: "fixture-compliance", stage: 1, reference: motion::compliance, foreign: &[motion::joint, motion::closing_joint] },
    Effect { name: "backlash", stage: 1, reference: motion::play, foreign: &[motion::smooth_play] },
    Effect { name: "sync-delay", stage: 1, reference: motion::delay, foreign: &[motion::growing_delay] },
    Effect { name: "elastic-stiffening", stage: 2, reference: elastic::power, foreign: &[elastic::exponential, elastic::densification] },
    Effect { name: "mullins", stage: 2, reference: elastic::mullins, foreign: &[elastic::relative_mullins, elastic::ogden_roxburgh] },
    Effect { name: "cyclic-softening", stage: 2, reference: elastic::cyclic, foreign: &[elastic::saturating_cyclic] },
    Effect { name: "permanent-set", stage: 2, reference: elastic::set, foreign: &[elastic::yielding] },
    Effect { name: "thermal-stiffness", stage: 2, reference: elastic::thermal, foreign: &[elastic::lagging_thermal] },
    Effect { name: "fast-mode", stage: 3, reference: relaxation::fast, foreign: &[relaxation::fast_band] },
    Effect { name: "slow-relaxation", stage: 3, reference: relaxation::logarithmic, foreign: &[relaxation::power_law] },
    Effect { name: "amplitude-dependent-relaxation", stage: 3, reference: relaxation::amplitude, foreign: &[relaxation::pipkin_rogers] },
    Effect { name: "time-temperature", stage: 3, reference: relaxation::shift, foreign: &[relaxation::wlf] },
    Effect { name: "latency-law", stage: 3, reference: relaxation::latency, foreign: &[relaxation::eyring] },
    Effect { name: "coulomb-friction", stage: 4, reference: contact::coulomb, foreign: &[contact::dahl, contact::stribeck] },
    Effect { name: "load-friction", stage: 4, reference: contact::load, foreign: &[contact::load_dahl] },
    Effect { name: "viscous-drag", stage: 4, reference: contact::viscous, foreign: &[contact::viscous_area] },
    Effect { name: "rate-drag", stage: 4, reference: contact::rate, foreign: &[contact::eyring] },
    Effect { name: "inertia", stage: 4, reference: contact::inertia, foreign: &[contact::sprung_mass] },
    Effect { name: "adhesion", stage: 4, reference: contact::adhesion, foreign: &[contact::cohesive] },
    Effect { name: "zero-shift", stage: 5, reference: sensor::zeros, foreign: &[sensor::wandering_zero] },
    Effect { name: "drift", stage: 5, reference: sensor::drift, foreign: &[sensor::root_drift] },
    Effect { name: "warm-up", stage: 5, reference: sensor::warm_up, foreign: &[sensor::hyperbolic_warm_up] },
    Effect { name: "thermal-output", stage: 5, reference: sensor::thermal, foreign: &[sensor::lagging_thermal, sensor::curved_thermal] },
    Effect { name: "gauge-nonlinearity", stage: 5, reference: sensor::cubic, foreign: &[sensor::bridge, sensor::arctangent] },
    Effect { name: "saturation", stage: 5, reference: sensor::clip, foreign: &[sensor::soft_clip] },
    Effect { name: "sensor-lag", stage: 5, reference: sensor::lag, foreign: &[sensor::second_order] },
    Effect { name: "hysteresis", stage: 5, reference: sensor::bouc_wen, foreign: &[sensor::prandtl_ishlinskii] },
    Effect { name: "mains-hum", stage: 5, reference: sensor::hum, foreign: &[sensor::wandering_hum] },
    Effect { name: CROSSTALK, stage: 5, reference: sensor::crosstalk, foreign: &[sensor::capacitive_crosstalk] },
];

/// What no effect of the library describes.
pub const OUTSIDE: &[(&str, Draw)] = &[
    ("snap", outside::snap),
    ("cogging", outside::cogging),
    ("slip", outside::slip),
    ("tap", outside::tap),
    ("parity-gain", outside::parity_gain),
    ("ringing", outside::ringing),
    ("crackling", outside::crackling),
];

/// The effect of a name.
#[must_use]
pub fn effect(name: &str) -> Option<&'static Effect> {
    EFFECTS.iter().find(|effect| effect.name == name)
}

/// The laws of a kind under a name.
#[must_use]
pub fn laws(name: &str, kind: LawKind) -> Option<Vec<Draw>> {
    match kind {
        LawKind::Reference => effect(name).map(|effect| vec![effect.reference]),
        LawKind::Foreign => effect(name).map(|effect| effect.foreign.to_vec()),
        LawKind::Outside => {
            OUTSIDE.iter().find(|(known, _)| *known == name).map(|(_, draw)| vec![*draw])
        }
    }
}

/// One act as a list.
fn one(act: Act) -> Vec<Act> {
    vec![act]
}
