//! Time since the first of some stamps.

use std::borrow::Cow;

/// The finest step, s, to which differences of stamps are rounded.
const FINEST_STEP_S: f64 = 1e-12;

/// Time from the first of these stamps to each, s, in the decimals that the stamps resolve.
///
/// A clock that counts seconds since 1970 resolves no better than 0.24 µs in a `f64`, so that differences of even stamps come out
/// uneven; rounding them gives back the steps that were written. They are left as they are where that would make two of them one.
#[must_use]
pub fn elapsed(time: &[f64]) -> Cow<'_, [f64]> {
    let (Some(&first), Some(&last)) = (time.first(), time.last()) else { return time.into() };
    if first == 0.0 {
        return time.into();
    }
    let largest = first.abs().max(last.abs());
    // Each of the two stamps is off by half of what it resolves.
    let resolved = (2.0 * (largest.next_up() - largest)).max(FINEST_STEP_S);
    let in_a_second = 10_f64.powf((-resolved.log10()).floor());
    let rounded: Vec<f64> =
        time.iter().map(|stamp| ((stamp - first) * in_a_second).round() / in_a_second).collect();
    if rounded.windows(2).all(|pair| pair[0] < pair[1]) {
        rounded.into()
    } else {
        time.iter().map(|stamp| stamp - first).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_written_with_seconds_since_1970_are_those_from_zero() {
        let from_zero: Vec<f64> = (0..2_000).map(|k| f64::from(k) * 5.0 / 1_000.0).collect();
        let stamps: Vec<f64> = (0..2_000)
            .map(|k: u32| {
                format!("{}.{:03}", 1_700_000_000 + k / 200, k % 200 * 5).parse().unwrap()
            })
            .collect();
        assert_eq!(elapsed(&stamps), from_zero);
        assert_ne!(stamps.iter().map(|t| t - stamps[0]).collect::<Vec<_>>(), from_zero);
    }

    #[test]
    fn a_clock_that_starts_with_the_recording_is_left_as_it_is() {
        let third: Vec<f64> = (0..10).map(|k| f64::from(k) / 3.0).collect();
        assert!(matches!(elapsed(&third), Cow::Borrowed(same) if same == third));
        assert_eq!(elapsed(&[2.0, 2.25, 3.0]), [0.0, 0.25, 1.0].as_slice());
        assert_eq!(elapsed(&[1.25, 1.255, 901.26]), [0.0, 0.005, 900.01].as_slice());
        assert!(elapsed(&[]).is_empty());
    }

    #[test]
    fn stamps_of_any_size_stay_in_order_and_finite() {
        for first in [1e7_f64, -1e7, 1.7e9, 1.7e12, 1e15, 1e300] {
            let mut stamps = vec![first];
            for _ in 0..20 {
                stamps.push(stamps.last().copied().unwrap().next_up());
            }
            let since = elapsed(&stamps);
            assert!(since.iter().all(|t| t.is_finite()), "{first}");
            assert!(since.windows(2).all(|pair| pair[0] < pair[1]), "{first}: {since:?}");
        }
    }
}
