//! Effects over many specimens: what no single diagnosis may say of a population, all of them together may.

use statrs::distribution::{Beta, Binomial, ContinuousCDF, DiscreteCDF};

use super::{Between, LEVEL, Since, holm};
use crate::overview::{Effect, Overview};

/// Chance of naming anything where nothing is missing that a diagnosis keeps to.
const FALSE_ALARMS: f64 = 0.01;

/// One effect over the population.
#[derive(Clone, Debug)]
pub struct EffectInAll {
    /// Name of the effect.
    pub effect: String,
    /// Number of groups in which it is missing.
    pub groups: usize,
    /// In which specimens.
    pub specimens: Vec<Since>,
    /// Part of all specimens, with its 95 % interval (Clopper and Pearson).
    pub share: Between,
    /// p value of as many groups where every one is a false alarm.
    pub p_value: f64,
    /// Whether it is there, in some specimens at least, at [`LEVEL`] over all effects (Holm).
    pub is_there: bool,
}

/// Every effect that is missing in some group.
pub(super) fn in_all(overview: &Overview, groups: usize, specimens: usize) -> Vec<EffectInAll> {
    let ranked = overview.most_frequent_effects();
    let in_all = |(name, effect): &(&str, &Effect)| {
        let found = overview.since(effect);
        EffectInAll {
            effect: (*name).to_owned(),
            groups: effect.rows.len(),
            share: share(found.len(), specimens),
            p_value: as_many(effect.rows.len(), groups, FALSE_ALARMS),
            specimens: found,
            is_there: false,
        }
    };
    let mut all: Vec<EffectInAll> = ranked.iter().map(in_all).collect();
    let chances: Vec<f64> = all.iter().map(|it| it.p_value).collect();
    let there = holm(&chances, LEVEL);
    all.iter_mut().zip(there).for_each(|(it, there)| it.is_there = there);
    all
}

/// Chance of at least so many of all, each with this chance.
fn as_many(count: usize, all: usize, chance: f64) -> f64 {
    match (Binomial::new(chance, all as u64), count.checked_sub(1)) {
        (Ok(binomial), Some(fewer)) => binomial.sf(fewer as u64),
        _ => 1.0,
    }
}

/// A part of all, with the interval that holds the truth in at least 95 % of all cases.
fn share(count: usize, all: usize) -> Between {
    let (some, others) = (count as f64, all.saturating_sub(count) as f64);
    let quantile = |a: f64, b: f64, part: f64| Beta::new(a, b).map(|beta| beta.inverse_cdf(part));
    Between {
        value: some / (some + others).max(1.0),
        lower: quantile(some, others + 1.0, 0.025).unwrap_or(0.0),
        upper: quantile(some + 1.0, others, 0.975).unwrap_or(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_has_the_interval_of_the_tables() {
        let found = share(3, 100);
        assert!(
            (found.lower - 0.00623).abs() < 1e-4 && (found.upper - 0.0852).abs() < 1e-4,
            "{found:?}"
        );
        assert_eq!((share(0, 10).lower, share(10, 10).upper), (0.0, 1.0));
    }

    #[test]
    fn one_alarm_in_a_hundred_groups_is_chance_and_five_are_not() {
        assert!((as_many(1, 100, 0.01) - 0.634).abs() < 1e-3);
        assert!(as_many(5, 100, 0.01) < 0.01);
    }
}
