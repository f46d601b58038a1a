//! Whether the means of several groups differ when each group has its own scatter (Welch 1951).

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Repeats of one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation.
    pub deviation: f64,
    /// Number of repeats.
    pub count: f64,
}

impl Repeats {
    /// Mean, sample standard deviation (n − 1) and number of these values.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Self { mean, deviation: (square / (count - 1.0)).sqrt(), count }
    }
}

/// What the test says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Welch {
    /// F.
    pub statistic: f64,
    /// Degrees of freedom of numerator and denominator.
    pub degrees_of_freedom: (f64, f64),
    /// Chance of so large an F if all means were the same.
    pub p_value: f64,
}

/// Compares the means of two or more groups; none where a group has no scatter or fewer than two repeats.
#[must_use]
pub fn welch(groups: &[Repeats]) -> Option<Welch> {
    let usable = |group: &Repeats| group.count >= 2.0 && group.deviation > 0.0;
    if groups.len() < 2 || !groups.iter().all(usable) {
        return None;
    }
    let number = groups.len() as f64;
    let weight = |group: &Repeats| group.count / group.deviation.powi(2);
    let total: f64 = groups.iter().map(weight).sum();
    let mean = groups.iter().map(|group| weight(group) * group.mean).sum::<f64>() / total;
    let between =
        groups.iter().map(|group| weight(group) * (group.mean - mean).powi(2)).sum::<f64>();
    let lost: f64 =
        groups.iter().map(|g| (1.0 - weight(g) / total).powi(2) / (g.count - 1.0)).sum();
    let square = number * number - 1.0;
    let statistic = between / (number - 1.0) / (1.0 + 2.0 * (number - 2.0) / square * lost);
    let degrees_of_freedom = (number - 1.0, square / (3.0 * lost));
    let spread = FisherSnedecor::new(degrees_of_freedom.0, degrees_of_freedom.1).ok()?;
    Some(Welch { statistic, degrees_of_freedom, p_value: spread.sf(statistic) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_groups_give_welchs_t() {
        let (a, b) = (
            Repeats { mean: 20.82, deviation: 2.804, count: 15.0 },
            Repeats { mean: 22.98, deviation: 3.923, count: 15.0 },
        );
        // t² = Δ²/(s₁²/n₁ + s₂²/n₂), and the degrees of freedom of Welch and Satterthwaite.
        let found = welch(&[a, b]).unwrap();
        let (one, two) = (2.804f64.powi(2) / 15.0, 3.923f64.powi(2) / 15.0);
        assert!((found.statistic - 2.16f64.powi(2) / (one + two)).abs() < 1e-9);
        let degrees = (one + two).powi(2) / (one * one / 14.0 + two * two / 14.0);
        assert!((found.degrees_of_freedom.1 - degrees).abs() < 1e-9, "{found:?}");
        assert!((0.05..0.15).contains(&found.p_value), "{found:?}");
    }

    #[test]
    fn one_group_far_off_is_told_and_equal_means_are_not() {
        let group = |mean, deviation| Repeats { mean, deviation, count: 10.0 };
        let apart = welch(&[group(0.48, 0.02), group(0.52, 0.03), group(0.57, 0.03)]).unwrap();
        assert!(apart.p_value < 1e-4);
        let alike = welch(&[group(3.72, 0.12), group(3.62, 0.25), group(3.66, 0.68)]).unwrap();
        assert!(alike.p_value > 0.1);
        assert_eq!(welch(&[group(1.0, 0.0), group(1.0, 0.1)]), None);
    }
}
