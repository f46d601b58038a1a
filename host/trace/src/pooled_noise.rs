//! The noise of a data set.

use super::{Noise, Source, Trace, noise};

/// Noise of a column over all traces of a set, from the best source that any of them offers: rest
/// before the touch, else holds, else the whole traces. None where no trace tells.
#[must_use]
pub fn pooled_noise(traces: &[Trace], column: &str) -> Option<Noise> {
    let found: Vec<Noise> = traces.iter().filter_map(|trace| noise(trace, column).ok()).collect();
    [Source::BeforeTouch, Source::Holds, Source::WholeTrace].into_iter().find_map(|source| {
        pool(&found.iter().copied().filter(|noise| noise.source == source).collect::<Vec<_>>())
    })
}

/// Mean variance and mean correlation, each trace weighing as its samples.
fn pool(found: &[Noise]) -> Option<Noise> {
    let first = found.first()?;
    let samples: usize = found.iter().map(|noise| noise.samples).sum();
    let mean = |value: fn(&Noise) -> f64| {
        found.iter().map(|noise| value(noise) * noise.samples as f64).sum::<f64>() / samples as f64
    };
    let standard_deviation = mean(|noise| noise.standard_deviation.powi(2)).sqrt();
    let lag1 = first.lag1.map(|_| mean(|noise| noise.lag1.unwrap_or(0.0)));
    Some(Noise { standard_deviation, lag1, samples, source: first.source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Column, DISPLACEMENT, FORCE};

    fn quiet_then_pressed(rest: usize, noise: f64) -> Trace {
        let samples = rest + 100;
        let sign = |k: usize| if k.is_multiple_of(2) { noise } else { -noise };
        let pressed = |k: usize| k.saturating_sub(rest) as f64;
        Trace {
            time: (0..samples).map(|k| k as f64 * 0.01).collect(),
            columns: vec![
                Column { name: DISPLACEMENT.into(), values: (0..samples).map(pressed).collect() },
                Column {
                    name: FORCE.into(),
                    values: (0..samples).map(|k| pressed(k) + sign(k)).collect(),
                },
            ],
            ..Trace::default()
        }
    }

    #[test]
    fn variances_are_averaged_and_the_best_source_wins() {
        let traces = [quiet_then_pressed(100, 3.0), quiet_then_pressed(100, 1.0)];
        let noise = pooled_noise(&traces, FORCE).unwrap();
        assert_eq!((noise.source, noise.samples), (Source::BeforeTouch, 202));
        assert!((noise.standard_deviation - 5f64.sqrt()).abs() < 0.05);
        let with_a_late_start = [quiet_then_pressed(100, 1.0), quiet_then_pressed(5, 50.0)];
        let noise = pooled_noise(&with_a_late_start, FORCE).unwrap();
        assert!((noise.standard_deviation - 1.0).abs() < 0.05);
    }

    #[test]
    fn nothing_is_said_of_a_column_that_is_not_there() {
        assert_eq!(pooled_noise(&[quiet_then_pressed(100, 1.0)], "gauge1_ustrain"), None);
    }
}
