//! The registry of effects, in the order of the chain, and registries with others beside them.

use std::fmt;

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

/// The effects that can be tried and named: those of the library, and of other programs beside them.
///
/// A value, not a constant: a program declares an [`Effect`] of its own as a `static` and adds it with [`Effects::with`].
#[derive(Clone)]
pub struct Effects(Vec<&'static Effect>);

impl Effects {
    /// Those of the library alone.
    #[must_use]
    pub fn library() -> Self {
        Self(LIBRARY.to_vec())
    }

    /// These and another, last. A name that is there already is refused where effects are tried.
    #[must_use]
    pub fn with(mut self, effect: &'static Effect) -> Self {
        self.0.push(effect);
        self
    }

    /// These without the effect of this name.
    #[must_use]
    pub fn without(mut self, name: &str) -> Self {
        self.0.retain(|effect| effect.name != name);
        self
    }

    /// The effect of this name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<&'static Effect> {
        self.iter().find(|effect| effect.name == name)
    }

    /// One after the other.
    pub fn iter(&self) -> impl Iterator<Item = &'static Effect> + '_ {
        self.0.iter().copied()
    }

    /// A name that two of them have.
    #[must_use]
    pub fn twice(&self) -> Option<&'static str> {
        let mut names = self.iter().enumerate().map(|(place, effect)| (place, effect.name));
        names
            .find(|(place, name)| self.iter().take(*place).any(|it| it.name == *name))
            .map(|it| it.1)
    }
}

impl Default for Effects {
    fn default() -> Self {
        Self::library()
    }
}

impl PartialEq for Effects {
    /// Effects are known by their names.
    fn eq(&self, other: &Self) -> bool {
        self.iter().map(|effect| effect.name).eq(other.iter().map(|effect| effect.name))
    }
}

impl fmt::Debug for Effects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter().map(|effect| effect.name)).finish()
    }
}

/// ` (did you mean X?)` where an effect has a name like this, else nothing.
#[must_use]
pub fn meant(name: &str) -> String {
    palpate_trace::meant::did_you_mean(name, LIBRARY.iter().map(|effect| effect.name))
}

/// The effect of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Effect> {
    LIBRARY.iter().copied().find(|effect| effect.name == name)
}
