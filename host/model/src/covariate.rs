//! What a residual could depend on.

/// A quantity known at every sample without the residual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Covariate {
    /// Displacement x, mm.
    Displacement,
    /// Velocity v, mm/s.
    Velocity,
    /// Direction of the motion, sgn v.
    Direction,
    /// Acceleration a, mm/s².
    Acceleration,
    /// Force predicted by the model.
    Force,
    /// Time t since the trace began, s.
    Time,
    /// Time since the data set began, s.
    SetTime,
    /// Temperature, °C.
    Temperature,
    /// Number n of loadings completed before, over the whole set.
    Cycle,
    /// Largest displacement so far, over the whole set, mm.
    Largest,
}

impl Covariate {
    /// Every covariate.
    pub const ALL: [Self; 10] = [
        Self::Displacement,
        Self::Velocity,
        Self::Direction,
        Self::Acceleration,
        Self::Force,
        Self::Time,
        Self::SetTime,
        Self::Temperature,
        Self::Cycle,
        Self::Largest,
    ];

    /// Symbol in answers, as in a law of one's own.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Displacement => "x",
            Self::Velocity => "v",
            Self::Direction => "sgn(v)",
            Self::Acceleration => "a",
            Self::Force => "F",
            Self::Time => "t",
            Self::SetTime => "t_set",
            Self::Temperature => "T",
            Self::Cycle => "n",
            Self::Largest => "x_max",
        }
    }

    /// Name in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Direction => "direction of the motion",
            Self::Acceleration => "acceleration",
            Self::Force => "predicted force",
            Self::Time => "time in the trace",
            Self::SetTime => "time in the data set",
            Self::Temperature => "temperature",
            Self::Cycle => "loadings completed before",
            Self::Largest => "largest displacement so far",
        }
    }

    /// Unit; the predicted force has that of the signal.
    #[must_use]
    pub fn unit(self, signal: &str) -> &str {
        match self {
            Self::Displacement | Self::Largest => "mm",
            Self::Velocity => "mm/s",
            Self::Acceleration => "mm/s²",
            Self::Force => signal,
            Self::Time | Self::SetTime => "s",
            Self::Temperature => "°C",
            Self::Direction | Self::Cycle => "",
        }
    }
}
