//! What a residual could depend on.

use crate::model::Motion;

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
    pub fn unit(self, signal: &'static str) -> &'static str {
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

/// Velocity, mm/s: the slope of a straight line through five samples. A recorded displacement has
/// noise, and a difference of neighbours would have little else.
#[must_use]
pub fn velocity(motion: &Motion) -> Vec<f64> {
    slopes(&motion.time, &motion.displacement)
}

/// Acceleration, mm/s²: the same slope of the velocity.
#[must_use]
pub fn acceleration(motion: &Motion) -> Vec<f64> {
    slopes(&motion.time, &velocity(motion))
}

/// Slope of the least-squares line through the two samples before, the two after and each sample.
fn slopes(time: &[f64], values: &[f64]) -> Vec<f64> {
    (0..time.len())
        .map(|index| {
            let range = index.saturating_sub(2)..(index + 3).min(time.len());
            let count = range.len() as f64;
            let mean_t = time[range.clone()].iter().sum::<f64>() / count;
            let mean_y = values[range.clone()].iter().sum::<f64>() / count;
            let (mut product, mut square) = (0.0, 0.0);
            for k in range {
                product += (time[k] - mean_t) * (values[k] - mean_y);
                square += (time[k] - mean_t).powi(2);
            }
            if square > 0.0 { product / square } else { 0.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocity_and_acceleration_of_a_parabola_are_exact_inside() {
        let time: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.01).collect();
        let displacement = time.iter().map(|t| 3.0 * t - 2.0 * t * t).collect();
        let motion = Motion { time, displacement, rest_before: None };
        let (v, a) = (velocity(&motion), acceleration(&motion));
        for k in 4..46 {
            assert!((v[k] - (3.0 - 4.0 * motion.time[k])).abs() < 1e-10);
            assert!((a[k] + 4.0).abs() < 1e-9);
        }
    }
}
