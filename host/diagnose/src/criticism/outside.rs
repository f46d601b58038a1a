//! What is no effect and yet describes the misfit: a change at one instant, a slow swing, a vibration, or what came before the recording. Where one of them
//! describes it better than everything named, nothing is named.

use super::fitted::Fitted;
use super::incident::Incident;
use super::noise::NoiseModel;
use super::past::Past;
use super::search::{DECISIVE, Search};
use super::swing::Swing;
use super::vibration::Vibration;

/// Something that is no effect.
#[derive(Clone, Debug, PartialEq)]
pub enum Outside {
    /// A change at one instant.
    Incident(Incident),
    /// A slow sine through all traces.
    Swing(Swing),
    /// A faster one, with a phase of its own in each stretch of recording.
    Vibration(Vibration),
    /// What the specimen remembers of before the recording.
    Past(Past),
}

/// Part of the misfit beyond the noise that it describes where it is what is missing.
const MOST: f64 = 0.5;
/// Part of what effects describe that is as much.
const AS_MUCH: f64 = 0.9;
/// Chance under noise alone below which it is there.
const CHANCE: f64 = 1e-4;

impl Outside {
    /// What describes the misfit of a model best of all that is no effect; none that noise alone would show. What comes and goes by itself
    /// is told from noise only where that is known; noise that is so many times louder in contact shows more of it.
    #[must_use]
    pub fn of(search: &Search, fitted: &Fitted, noise: &NoiseModel, louder: f64) -> Option<Self> {
        let incident = || Incident::of(search.problem, fitted).map(Self::Incident);
        // Means over more than a period show no swing.
        let swing = || Swing::of(search.samples, fitted).map(Self::Swing);
        let known = if noise.is_known() { [incident(), swing()] } else { [None, None] };
        let near = noise.vibration_hz;
        let vibration =
            near.and_then(|near| Vibration::of(search.samples, fitted, near)).map(Self::Vibration);
        let past = Past::of(search.problem, fitted).map(Self::Past);
        let sure = |it: &Self| it.is_sure(louder);
        let all = known.into_iter().flatten().chain(vibration).chain(past).filter(sure);
        all.max_by(|a, b| a.gain().total_cmp(&b.gain()))
    }

    /// Whether noise alone, so many times louder in contact, hardly shows as much.
    #[must_use]
    pub fn is_sure(&self, louder: f64) -> bool {
        self.log_chance() < CHANCE.ln() * louder * louder
    }

    /// Fall of the sum of squares of the whitened residual.
    #[must_use]
    pub fn gain(&self) -> f64 {
        match self {
            Self::Incident(it) => it.gain,
            Self::Swing(it) => it.gain,
            Self::Vibration(it) => it.gain,
            Self::Past(it) => it.gain,
        }
    }

    /// Logarithm of the chance of as large a fall under noise alone.
    #[must_use]
    pub fn log_chance(&self) -> f64 {
        match self {
            Self::Incident(it) => it.log_chance,
            Self::Swing(it) => it.log_chance,
            Self::Vibration(it) => it.log_chance,
            Self::Past(it) => it.log_chance,
        }
    }

    /// Part of what a base leaves beyond the noise that it describes, 0 to 1.
    #[must_use]
    pub fn share(&self, base: &Fitted) -> f64 {
        (self.gain() / (base.cost - base.samples as f64).max(self.gain())).min(1.0)
    }

    /// Whether it describes most of what a base leaves beyond the noise.
    #[must_use]
    pub fn is_most(&self, base: &Fitted) -> bool {
        self.share(base) > MOST
    }

    /// Whether it is what a base lacks: it describes most of what that leaves beyond the noise, and decisively
    /// better than a model with effects, by the information criterion. What came before the recording is there for certain, and need
    /// but describe as much as the effects.
    #[must_use]
    pub fn explains(&self, base: &Fitted, model: &Fitted) -> bool {
        let better = |numbers| base.bic_with(numbers, self.gain()) + DECISIVE < model.bic();
        self.is_most(base)
            && match self {
                Self::Incident(_) => better(Incident::NUMBERS),
                Self::Swing(_) => better(Swing::NUMBERS),
                // It is there at rest as well, whatever effects there are beside it.
                Self::Vibration(_) => false,
                Self::Past(it) => it.gain > AS_MUCH * (base.cost - model.cost),
            }
    }
}
