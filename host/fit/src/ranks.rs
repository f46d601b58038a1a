//! Whether several groups differ by the ranks of their values alone (Kruskal and Wallis 1952), whatever
//! distribution they scatter by.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Chance of ranks so uneven if all groups were of one distribution: χ² of H, corrected for ties.
///
/// None for fewer than two groups, an empty group, a value that is not finite, or values all the same.
#[must_use]
pub fn kruskal_wallis(groups: &[Vec<f64>]) -> Option<f64> {
    let mut all: Vec<(f64, usize)> = Vec::new();
    for (place, group) in groups.iter().enumerate() {
        all.extend(group.iter().map(|value| (*value, place)));
    }
    let usable = groups.iter().all(|group| !group.is_empty());
    if groups.len() < 2 || !usable || !all.iter().all(|(value, _)| value.is_finite()) {
        return None;
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = all.len() as f64;
    let (mut sums, mut ties, mut first) = (vec![0.0; groups.len()], 0.0, 0);
    for tied in all.chunk_by(|a, b| a.0 == b.0) {
        let number = tied.len() as f64;
        // Equal values share the mean of their ranks.
        let rank = first as f64 + 0.5 * (number + 1.0);
        for (_, place) in tied {
            sums[*place] += rank;
        }
        ties += number.powi(3) - number;
        first += tied.len();
    }
    let squares: f64 =
        sums.iter().zip(groups).map(|(sum, group)| sum * sum / group.len() as f64).sum();
    let even = 1.0 - ties / (count.powi(3) - count);
    let statistic = (12.0 / (count * (count + 1.0)) * squares - 3.0 * (count + 1.0)) / even;
    let spread = ChiSquared::new(groups.len() as f64 - 1.0).ok()?;
    statistic.is_finite().then(|| spread.sf(statistic.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_in_order_give_the_largest_statistic() {
        // Three groups of three in order: H = 7.2, and χ² of two degrees is exponential.
        let groups = [vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0], vec![7.0, 8.0, 90.0]];
        let p = kruskal_wallis(&groups).unwrap();
        assert!((p - (-3.6f64).exp()).abs() < 1e-9, "{p}");
    }

    #[test]
    fn ties_share_their_rank() {
        // Ranks 1.5 1.5 4 | 4 4 6: H = 12/42 (49/3 + 196/3) − 21 = 7/3, over 1 − 30/210.
        let p = kruskal_wallis(&[vec![1.0, 1.0, 2.0], vec![2.0, 2.0, 3.0]]).unwrap();
        let spread = ChiSquared::new(1.0).unwrap();
        assert!((p - spread.sf(7.0 / 3.0 / (1.0 - 30.0 / 210.0))).abs() < 1e-9, "{p}");
        assert_eq!(kruskal_wallis(&[vec![1.0], vec![1.0]]), None);
        assert_eq!(kruskal_wallis(&[vec![1.0], vec![]]), None);
    }
}
