//! The resting value of a signal, taken off.

use super::Trace;

/// Mean of a column before the first sample in which the specimen is touched; none where the recording
/// begins in contact, never touches, or lacks the column.
#[must_use]
pub fn resting_value(trace: &Trace, column: &str) -> Option<f64> {
    let touch = trace.displacement()?.iter().position(|&x| x > 0.0)?;
    let rest = &trace.column(column)?[..touch];
    (!rest.is_empty()).then(|| rest.iter().sum::<f64>() / rest.len() as f64)
}

/// Takes the resting value off a column, and returns it.
pub fn tare(trace: &mut Trace, column: &str) -> Option<f64> {
    let zero = resting_value(trace, column)?;
    let values = trace.column(column)?.iter().map(|value| value - zero).collect();
    trace.set_column(column, values);
    Some(zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Column, DISPLACEMENT};

    fn trace(x: &[f64], values: &[f64]) -> Trace {
        let column =
            |name: &str, values: &[f64]| Column { name: name.into(), values: values.into() };
        let time = (0..x.len()).map(|k| k as f64).collect();
        let columns = vec![column(DISPLACEMENT, x), column("sensor_ohm", values)];
        Trace { time, columns, ..Trace::default() }
    }

    #[test]
    fn the_mean_before_the_touch_is_taken_off_every_sample() {
        let mut rested = trace(&[-1.0, 0.0, 1.0, -1.0], &[32_990.0, 33_010.0, 34_000.0, 33_100.0]);
        assert_eq!(tare(&mut rested, "sensor_ohm"), Some(33_000.0));
        assert_eq!(rested.column("sensor_ohm"), Some(&[-10.0, 10.0, 1000.0, 100.0][..]));
        let mut pressed = trace(&[1.0, 2.0], &[5.0, 6.0]);
        assert_eq!(tare(&mut pressed, "sensor_ohm"), None);
        assert_eq!(pressed.column("sensor_ohm"), Some(&[5.0, 6.0][..]));
    }
}
