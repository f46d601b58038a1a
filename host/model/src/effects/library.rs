//! The registry of effects, in the order of the chain.

use super::Effect;

/// Every effect of the library.
pub const LIBRARY: &[&Effect] = &[
    &super::contact_offset::EFFECT,
    &super::fixture_compliance::EFFECT,
    &super::backlash::EFFECT,
    &super::sync_delay::EFFECT,
    &super::elastic_stiffening::EFFECT,
    &super::mullins::EFFECT,
    &super::cyclic_softening::EFFECT,
    &super::permanent_set::EFFECT,
    &super::thermal_stiffness::EFFECT,
    &super::fast_mode::EFFECT,
    &super::slow_relaxation::EFFECT,
    &super::amplitude_dependent_relaxation::EFFECT,
    &super::time_temperature::EFFECT,
    &super::latency_law::EFFECT,
    &super::coulomb_friction::EFFECT,
    &super::load_friction::EFFECT,
    &super::viscous_drag::EFFECT,
    &super::rate_drag::EFFECT,
    &super::inertia::EFFECT,
    &super::adhesion::EFFECT,
    &super::zero_shift::EFFECT,
    &super::drift::EFFECT,
    &super::warm_up::EFFECT,
    &super::thermal_output::EFFECT,
    &super::gauge_nonlinearity::EFFECT,
    &super::saturation::EFFECT,
    &super::sensor_lag::EFFECT,
    &super::hysteresis::EFFECT,
    &super::mains_hum::EFFECT,
    &super::crosstalk::EFFECT,
];

/// `; did you mean X?` where an effect has a name like this, else nothing.
#[must_use]
pub fn meant(name: &str) -> String {
    palpate_trace::meant::did_you_mean(name, LIBRARY.iter().map(|effect| effect.name))
}

/// The effect of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Effect> {
    LIBRARY.iter().copied().find(|effect| effect.name == name)
}
