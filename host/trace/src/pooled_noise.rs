//! The noise of a data set.

use super::noise::of_rests;
use super::{Noise, Source, Trace, noise};

/// Noise of a column over all traces of a set, from the best source that any of them offers: rest
/// before the touch, in one trace or in many short ones together, else holds, else the whole traces.
/// None where no trace tells.
#[must_use]
pub fn pooled_noise(traces: &[Trace], column: &str) -> Option<Noise> {
    let found: Vec<Noise> = traces.iter().filter_map(|trace| noise(trace, column).ok()).collect();
    let of = |source| {
        pool(&found.iter().copied().filter(|noise| noise.source == source).collect::<Vec<_>>())
    };
    of(Source::BeforeTouch)
        .or_else(|| of_rests(traces, column))
        .or_else(|| of(Source::Holds))
        .or_else(|| of(Source::WholeTrace))
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
    fn short_rests_of_many_traces_tell_together_what_none_tells_alone() {
        // Five samples of rest in each, then a press that bends more between samples than the noise.
        let short = |shift: f64| {
            let mut trace = quiet_then_pressed(5, 1.0);
            let bent = |(k, y): (usize, &f64)| y + shift + (k.saturating_sub(5) as f64).powi(2);
            let force = trace.force().unwrap().iter().enumerate().map(bent).collect();
            trace.set_column(FORCE, force);
            trace
        };
        let traces: Vec<Trace> = (0..20).map(|k| short(f64::from(k))).collect();
        let noise = pooled_noise(&traces, FORCE).unwrap();
        assert_eq!((noise.source, noise.lag1), (Source::BeforeTouch, None));
        assert!((noise.standard_deviation - 1.0).abs() < 0.15, "{noise:?}");
        let few = pooled_noise(&traces[..5], FORCE).unwrap();
        assert_eq!(few.source, Source::WholeTrace);
    }

    #[test]
    fn nothing_is_said_of_a_column_that_is_not_there() {
        assert_eq!(pooled_noise(&[quiet_then_pressed(100, 1.0)], "gauge1_ustrain"), None);
    }
}
