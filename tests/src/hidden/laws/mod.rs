//! The hidden laws: for each effect its reference form and other forms of the same physics.

pub mod beyond;
pub mod contact;
pub mod elastic;
pub mod inexact;
pub mod more;
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
    /// A further law of the same physics, as unlike as can be.
    ForeignMore,
    /// A further thing that the library does not hold.
    OutsideMore,
    /// Steady, and beyond the library and the grammar of formulas.
    Beyond,
    /// No effect: the base law itself is another.
    Inexact,
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
    /// Further laws, as unlike as can be.
    pub more: &'static [Draw],
}

/// The one effect that needs gauges; its data sets have four, and the first shows it.
pub const CROSSTALK: &str = "crosstalk";

/// Every effect of the library.
#[rustfmt::skip]
pub const EFFECTS: &[Effect] = &[
    Effect { name: "contact-offset", stage: 1, reference: motion::offset, foreign: &[motion::tilt], more: &[more::motion::film, more::motion::rough] },
    Effect { name: "fixture-compliance", stage: 1, reference: motion::compliance, foreign: &[motion::joint, motion::closing_joint], more: &[more::motion::stiffening_frame, more::motion::softening_frame] },
    Effect { name: "backlash", stage: 1, reference: motion::play, foreign: &[motion::smooth_play], more: &[more::motion::curved_play, more::motion::two_plays] },
    Effect { name: "sync-delay", stage: 1, reference: motion::delay, foreign: &[motion::growing_delay], more: &[more::motion::scattered_delay, more::motion::packets] },
    Effect { name: "elastic-stiffening", stage: 2, reference: elastic::power, foreign: &[elastic::exponential, elastic::densification], more: &[more::elastic::gent, more::elastic::second_layer] },
    Effect { name: "mullins", stage: 2, reference: elastic::mullins, foreign: &[elastic::relative_mullins, elastic::ogden_roxburgh], more: &[more::elastic::growing_damage, more::elastic::broken_bonds] },
    Effect { name: "cyclic-softening", stage: 2, reference: elastic::cyclic, foreign: &[elastic::saturating_cyclic], more: &[more::elastic::softening_by_way, more::elastic::softening_power] },
    Effect { name: "permanent-set", stage: 2, reference: elastic::set, foreign: &[elastic::yielding], more: &[more::elastic::creeping_set, more::elastic::saturating_set] },
    Effect { name: "thermal-stiffness", stage: 2, reference: elastic::thermal, foreign: &[elastic::lagging_thermal], more: &[more::elastic::curved_thermal, more::elastic::deep_thermal] },
    Effect { name: "fast-mode", stage: 3, reference: relaxation::fast, foreign: &[relaxation::fast_band], more: &[more::relaxation::fast_when_deep, more::relaxation::fast_power] },
    Effect { name: "slow-relaxation", stage: 3, reference: relaxation::logarithmic, foreign: &[relaxation::power_law], more: &[more::relaxation::slow_single, more::relaxation::slow_hump] },
    Effect { name: "amplitude-dependent-relaxation", stage: 3, reference: relaxation::amplitude, foreign: &[relaxation::pipkin_rogers], more: &[more::relaxation::saturating_amplitude, more::relaxation::slow_amplitude] },
    Effect { name: "time-temperature", stage: 3, reference: relaxation::shift, foreign: &[relaxation::wlf], more: &[more::relaxation::lagging_shift, more::relaxation::fast_shift] },
    Effect { name: "latency-law", stage: 3, reference: relaxation::latency, foreign: &[relaxation::eyring], more: &[more::relaxation::quadratic_latency, more::relaxation::yielding_latency] },
    Effect { name: "coulomb-friction", stage: 4, reference: contact::coulomb, foreign: &[contact::dahl, contact::stribeck], more: &[more::contact::lugre, more::contact::one_sided_friction, more::contact::iwan] },
    Effect { name: "load-friction", stage: 4, reference: contact::load, foreign: &[contact::load_dahl], more: &[more::contact::load_power, more::contact::load_iwan] },
    Effect { name: "viscous-drag", stage: 4, reference: contact::viscous, foreign: &[contact::viscous_area], more: &[more::contact::power_drag, more::contact::drag_in_contact, more::contact::thinning_drag] },
    Effect { name: "rate-drag", stage: 4, reference: contact::rate, foreign: &[contact::eyring], more: &[more::contact::logarithmic_rate, more::contact::rate_iwan] },
    Effect { name: "inertia", stage: 4, reference: contact::inertia, foreign: &[contact::sprung_mass], more: &[more::contact::added_mass, more::contact::filtered_mass] },
    Effect { name: "adhesion", stage: 4, reference: contact::adhesion, foreign: &[contact::cohesive], more: &[more::contact::neck, more::contact::rate_adhesion, more::contact::adhesion_above] },
    Effect { name: "zero-shift", stage: 5, reference: sensor::zeros, foreign: &[sensor::wandering_zero], more: &[more::sensor::two_zeros, more::sensor::one_zero] },
    Effect { name: "drift", stage: 5, reference: sensor::drift, foreign: &[sensor::root_drift], more: &[more::sensor::growing_drift, more::sensor::late_drift] },
    Effect { name: "warm-up", stage: 5, reference: sensor::warm_up, foreign: &[sensor::hyperbolic_warm_up], more: &[more::sensor::two_stage_warm_up, more::sensor::stretched_warm_up] },
    Effect { name: "thermal-output", stage: 5, reference: sensor::thermal, foreign: &[sensor::lagging_thermal, sensor::curved_thermal], more: &[more::sensor::differential_thermal, more::sensor::bounded_thermal] },
    Effect { name: "gauge-nonlinearity", stage: 5, reference: sensor::cubic, foreign: &[sensor::bridge, sensor::arctangent], more: &[more::sensor::sine_error, more::sensor::two_gains] },
    Effect { name: "saturation", stage: 5, reference: sensor::clip, foreign: &[sensor::soft_clip], more: &[more::sensor::part_clip, more::sensor::sticky_clip] },
    Effect { name: "sensor-lag", stage: 5, reference: sensor::lag, foreign: &[sensor::second_order], more: &[more::sensor::sinc, more::sensor::cascade, more::sensor::fractional, more::sensor::slew] },
    Effect { name: "hysteresis", stage: 5, reference: sensor::bouc_wen, foreign: &[sensor::prandtl_ishlinskii], more: &[more::sensor::duhem, more::sensor::preisach] },
    Effect { name: "mains-hum", stage: 5, reference: sensor::hum, foreign: &[sensor::wandering_hum], more: &[more::sensor::swelling_hum, more::sensor::bent_hum] },
    Effect { name: CROSSTALK, stage: 5, reference: sensor::crosstalk, foreign: &[sensor::capacitive_crosstalk], more: &[more::sensor::quadratic_crosstalk] },
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

/// More of it: short, rare, or bound to one instant.
pub const OUTSIDE_MORE: &[(&str, Draw)] = &[
    ("knock", more::rare::knock),
    ("freeze", more::rare::freeze),
    ("spikes", more::rare::spikes),
    ("zero-step", more::rare::zero_step),
    ("loose", more::rare::loose),
    ("sway", more::rare::sway),
    ("stick-slip", more::rare::stick_slip),
    ("resonance", more::rare::resonance),
    ("grip", more::rare::grip),
    ("lost-steps", more::rare::lost_steps),
    ("gain-step", more::rare::gain_step),
    ("burst", more::rare::burst),
];

/// The name under which another base law stands.
pub const INEXACT: &str = "inexact";

/// Base laws that are slightly other than the library's.
pub const INEXACT_LAWS: &[Draw] = &[inexact::elastic, inexact::relaxation, inexact::both];

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
        LawKind::ForeignMore => effect(name).map(|effect| effect.more.to_vec()),
        LawKind::Outside => of_name(OUTSIDE, name),
        LawKind::OutsideMore => of_name(OUTSIDE_MORE, name),
        LawKind::Beyond => beyond::beyond(name).map(|effect| vec![effect.draw]),
        LawKind::Inexact => Some(INEXACT_LAWS.to_vec()),
    }
}

fn of_name(all: &[(&str, Draw)], name: &str) -> Option<Vec<Draw>> {
    all.iter().find(|(known, _)| *known == name).map(|(_, draw)| vec![*draw])
}

/// One act as a list.
fn one(act: Act) -> Vec<Act> {
    vec![act]
}
