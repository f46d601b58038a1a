//! The holds of a recording, found from the quantity that was controlled.

use std::iter;
use std::ops::Range;

use super::error::SignalError;
use super::levels::levels;
use super::segments::{Kind, segments};
use super::{Control, DISPLACEMENT, FORCE, Trace};

/// The holds of a trace, as ranges of samples, in order.
///
/// The controlled quantity (`control` of the head; displacement unless it says force) is looked at for
/// rest: a displacement is a motion with corners, a force is noisy and settles to its levels. Where it was not recorded the trace is the answer to one step: from the largest value of
/// `signal` on when displacement was stepped, all of it when force was.
///
/// # Errors
/// [`SignalError::NoColumn`], [`SignalError::Constant`] if `signal` never changes,
/// [`SignalError::NoHold`] if nothing rests, [`SignalError::EmptyHold`] if no hold has two samples.
pub fn holds(trace: &Trace, signal: &str) -> Result<Vec<Range<usize>>, SignalError> {
    let values = changing(trace, signal)?;
    let force_control = trace.head.control == Some(Control::Force);
    let controlled = if force_control { FORCE } else { DISPLACEMENT };
    let found: Vec<Range<usize>> = match trace.column(controlled) {
        Some(column) if column.len() >= 2 && force_control => levels(&trace.time, column),
        Some(column) if column.len() >= 2 => segments(&trace.time, column)
            .into_iter()
            .filter(|segment| segment.kind == Kind::Hold)
            .map(|segment| segment.range)
            .collect(),
        _ if force_control => iter::once(0..trace.len()).collect(),
        _ => {
            let largest = (0..values.len()).rev().max_by(|&a, &b| values[a].total_cmp(&values[b]));
            iter::once(largest.unwrap_or(0)..trace.len()).collect()
        }
    };
    let Some(longest) = found.iter().max_by_key(|range| range.len()) else {
        return Err(SignalError::NoHold { trace: trace.label(), controlled: controlled.into() });
    };
    if longest.len() < 2 {
        return Err(SignalError::EmptyHold {
            trace: trace.label(),
            from_s: trace.time[longest.start],
            samples: longest.len(),
            needed: 2,
        });
    }
    Ok(found)
}

/// A column that is there and changes.
pub(super) fn changing<'a>(trace: &'a Trace, signal: &str) -> Result<&'a [f64], SignalError> {
    let values = trace.column(signal).ok_or_else(|| SignalError::NoColumn {
        trace: trace.label(),
        column: signal.into(),
        present: trace.columns.iter().map(|column| column.name.clone()).collect(),
    })?;
    match values.first() {
        Some(&value) if values.iter().any(|&other| other != value) => Ok(values),
        first => Err(SignalError::Constant {
            trace: trace.label(),
            column: signal.into(),
            value: first.copied().unwrap_or(0.0),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_displacement_the_hold_begins_at_the_largest_value() {
        let mut trace = Trace { time: vec![0.1, 0.2, 0.3, 0.4], ..Trace::default() };
        trace.set_column("relaxation_modulus_Pa", vec![3.0, 9.0, 7.0, 6.0]);
        assert_eq!(holds(&trace, "relaxation_modulus_Pa"), Ok(iter::once(1..4).collect()));
        trace.head.control = Some(Control::Force);
        assert_eq!(holds(&trace, "relaxation_modulus_Pa"), Ok(iter::once(0..4).collect()));
    }

    #[test]
    fn what_cannot_be_fitted_is_said_by_name() {
        let (time, x): (Vec<f64>, Vec<f64>) =
            (0..100).map(|i| (f64::from(i) * 0.01, f64::from(i) * 0.05)).unzip();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x.clone());
        trace.set_column(FORCE, vec![2.0; x.len()]);
        assert!(matches!(holds(&trace, FORCE), Err(SignalError::Constant { value: 2.0, .. })));
        assert!(matches!(holds(&trace, "strain"), Err(SignalError::NoColumn { .. })));
        trace.set_column(FORCE, x);
        assert!(matches!(holds(&trace, FORCE), Err(SignalError::NoHold { .. })));
        let mut step = Trace { time: vec![0.0, 1.0, 2.0], ..Trace::default() };
        step.set_column(FORCE, vec![0.0, 1.0, 2.0]);
        assert!(matches!(holds(&step, FORCE), Err(SignalError::EmptyHold { samples: 1, .. })));
    }
}
