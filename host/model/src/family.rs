//! The families of base laws, and what happens when contact breaks.

use serde::{Deserialize, Serialize};

/// What happens when the indenter leaves the specimen faster than it recovers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Separation {
    /// The law runs over the commanded motion; the recorded force is its positive part.
    #[default]
    Clamp,
    /// The parted surface is free of stress and recovers by itself until the indenter meets it.
    Free,
    /// It cannot leave: the specimen is glued or clamped, and the force may turn to tension.
    Bonded,
}

impl Separation {
    /// Its name in a model file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Free => "free",
            Self::Bonded => "bonded",
        }
    }
}

/// A family of base laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// Spring and damper side by side, F = k x + η x' (eq. 2.3).
    KelvinVoigt,
    /// Spring and damper in a row, F'/k + F/η = x' (eq. 2.4).
    Maxwell,
    /// A spring beside n springs with dampers: F = k0 x + Σ ki ∫ e^(−(ki/ηi)(t−s)) dx (2.2).
    GeneralizedMaxwell,
    /// Fung's quasi-linear law, F = ∫ g(t−s) dN(x(s)) (eqs 2.1, 3.2, 3.3).
    Fung,
    /// The linear latency model: the strain at the contact goes back to its equilibrium at a rate
    /// proportional to the distance, ε' = −v1 (ε − εe) (eqs 4.1–4.11).
    Latency,
    /// The nonlinear latency model, ε' = −ν sgn(ε − εe) |ε − εe|^n (eqs 7.2, 7.3, 7.11).
    LatencyPower,
    /// Creep, δ = ∫ h(t−s) dD(F(s)), h = 1 + Σ ci e^(−vi t) (eqs 6.1, 6.2), solved for the force.
    Creep,
}

impl Family {
    /// Every family.
    pub const ALL: [Self; 7] = [
        Self::KelvinVoigt,
        Self::Maxwell,
        Self::GeneralizedMaxwell,
        Self::Fung,
        Self::Latency,
        Self::LatencyPower,
        Self::Creep,
    ];

    /// Name in model files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::KelvinVoigt => "kelvin-voigt",
            Self::Maxwell => "maxwell",
            Self::GeneralizedMaxwell => "generalized-maxwell",
            Self::Fung => "fung",
            Self::Latency => "latency",
            Self::LatencyPower => "latency-power",
            Self::Creep => "creep",
        }
    }

    /// The family of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.name() == name)
    }

    /// Whether the number of exponentials can be chosen.
    #[must_use]
    pub const fn has_terms(self) -> bool {
        matches!(self, Self::GeneralizedMaxwell | Self::Fung | Self::Creep)
    }

    /// Whether a number of segments can be given in place of the share c0.
    #[must_use]
    pub const fn has_segments(self) -> bool {
        matches!(self, Self::Latency | Self::LatencyPower)
    }

    /// Whether its force is proportional to the compression: q = 0.
    #[must_use]
    pub const fn is_linear(self) -> bool {
        matches!(self, Self::KelvinVoigt | Self::Maxwell | Self::GeneralizedMaxwell)
    }

    /// Whether the response can relax by another kernel than exponentials.
    #[must_use]
    pub const fn has_kernel(self) -> bool {
        matches!(self, Self::Fung)
    }

    /// Whether it can pull: a law that is stated for a compressed specimen alone cannot be bonded.
    #[must_use]
    pub const fn can_be_bonded(self) -> bool {
        !matches!(self, Self::Creep)
    }
}
