//! Markers on or in a specimen, followed by a camera: the latency model fitted to the gaps between them (4.3, 6.3).
//!
//! Between two markers lies a piece of the specimen. While the whole is held its length still goes to an equilibrium, by
//! the law of the strain at the contact: e' = −ν sgn e |e|^n with e the distance of the gap from where it ends (7.2),
//! n = 1 in chapter 4. A marker alone is taken for the gap to what does not move.

use std::ops::Range;

use super::strain_rate::{Order, as_good_orders, lowest_of_all};
use palpate_fit::power_law::{self, ODD_ORDERS, PowerFit};
use palpate_trace::{DISPLACEMENT, FORCE, SignalError, Trace, holds};

/// Fewest samples of a hold.
const MIN_HOLD_SAMPLES: usize = 5;

/// One gap in one hold.
#[derive(Clone, Debug)]
pub struct Gap {
    /// Name of the trace.
    pub trace: String,
    /// The two columns; one where the trace has a single marker.
    pub between: Vec<String>,
    /// When the hold began, s.
    pub from_s: f64,
    /// Time in the hold, s.
    pub time: Vec<f64>,
    /// The gap, mm.
    pub gap: Vec<f64>,
    /// The fit.
    pub fit: PowerFit,
    /// Lowest and highest odd order that fit as well as the best.
    pub odd_orders: (f64, f64),
}

/// The gaps of some traces.
#[derive(Clone, Debug)]
pub struct Study {
    /// What was asked of the order.
    pub asked: Order,
    /// The order of all gaps; none where it was free.
    pub order: Option<f64>,
    /// Hold by hold, gap by gap.
    pub gaps: Vec<Gap>,
}

/// Why gaps cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum MarkersError {
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error(
        "{trace}: no column of a marker: name them marker1_mm, marker2_mm … in their order along the direction of compression"
    )]
    None { trace: String },
    #[error(
        "{trace}: no hold has {MIN_HOLD_SAMPLES} frames in which {between} moves. Record longer, or with more frames a second."
    )]
    Short { trace: String, between: String },
}

/// The columns of markers of a trace, by number.
#[must_use]
pub fn columns(trace: &Trace) -> Vec<String> {
    let number = |name: &str| -> Option<u32> {
        name.strip_prefix("marker")?.strip_suffix("_mm")?.parse().ok()
    };
    let mut found: Vec<(u32, String)> = trace
        .columns
        .iter()
        .filter_map(|column| Some((number(&column.name)?, column.name.clone())))
        .collect();
    found.sort();
    found.into_iter().map(|(_, name)| name).collect()
}

/// Fits the latency model to every gap in every hold of the traces.
///
/// Holds are those of the displacement or of a controlled force; a trace of markers alone is one hold.
///
/// # Errors
/// When a trace has no markers, or none moves in a hold.
pub fn markers(traces: &[Trace], order: Order) -> Result<Study, MarkersError> {
    let mut series = Vec::new();
    for trace in traces {
        let names = columns(trace);
        if names.is_empty() {
            return Err(MarkersError::None { trace: trace.label() });
        }
        let ranges = if trace.column(DISPLACEMENT).is_some() || trace.column(FORCE).is_some() {
            let moves = |name: &&String| {
                trace.column(name).is_some_and(|all| all.iter().any(|it| *it != all[0]))
            };
            holds(trace, names.iter().find(moves).unwrap_or(&names[0]))?
        } else {
            std::iter::once(0..trace.len()).collect()
        };
        let pairs: Vec<Vec<String>> = match &names[..] {
            [only] => vec![vec![only.clone()]],
            more => more.windows(2).map(<[String]>::to_vec).collect(),
        };
        for pair in pairs {
            let before = series.len();
            series.extend(ranges.iter().filter_map(|range| Series::of(trace, &pair, range)));
            if series.len() == before {
                let between = pair.join(" to ");
                return Err(MarkersError::Short { trace: trace.label(), between });
            }
        }
    }
    let scans: Vec<Vec<PowerFit>> = series.iter().map(Series::scan).collect();
    let common = match order {
        Order::Fixed(n) => Some(n),
        Order::Free => None,
        Order::LowestOdd => Some(lowest_of_all(&scans)),
    };
    let gaps = series.into_iter().zip(scans).map(|(it, scan)| it.gap(&scan, common)).collect();
    Ok(Study { asked: order, order: common, gaps })
}

/// A gap over one hold.
struct Series {
    trace: String,
    between: Vec<String>,
    from_s: f64,
    time: Vec<f64>,
    gap: Vec<f64>,
}

impl Series {
    /// None where it is too short, or nothing moves.
    fn of(trace: &Trace, pair: &[String], range: &Range<usize>) -> Option<Self> {
        let first = &trace.column(pair.first()?)?[range.clone()];
        let gap: Vec<f64> = match pair.get(1) {
            Some(second) => {
                let second = &trace.column(second)?[range.clone()];
                second.iter().zip(first).map(|(b, a)| b - a).collect()
            }
            None => first.to_vec(),
        };
        let moves = gap.iter().any(|it| *it != gap[0]);
        if gap.len() < MIN_HOLD_SAMPLES || !moves {
            return None;
        }
        let from_s = trace.time[range.start];
        Some(Self {
            trace: trace.label(),
            between: pair.to_vec(),
            from_s,
            time: trace.elapsed(range.clone()).into_owned(),
            gap,
        })
    }

    fn scan(&self) -> Vec<PowerFit> {
        ODD_ORDERS.iter().map(|n| power_law::fit(&self.time, &self.gap, Some(*n))).collect()
    }

    fn gap(self, scan: &[PowerFit], order: Option<f64>) -> Gap {
        let known = order.and_then(|n| scan.iter().find(|fit| fit.law.order == n)).cloned();
        let fit = known.unwrap_or_else(|| power_law::fit(&self.time, &self.gap, order));
        let odd_orders = as_good_orders(scan).unwrap_or((fit.law.order, fit.law.order));
        let Self { trace, between, from_s, time, gap } = self;
        Gap { trace, between, from_s, time, gap, fit, odd_orders }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_model::latency::Power;

    fn trace(law: Power) -> Trace {
        let time: Vec<f64> = (0..1200).map(|k| f64::from(k) / 20.0).collect();
        let mut trace = Trace { time: time.clone(), ..Trace::default() };
        // A camera's picture elements, 1 µm here, as scatter that is no drift.
        let seen = |k: usize, value: f64| value + 1e-3 * ((k * 7919) % 13) as f64 / 13.0;
        let gap = |k: usize| law.strain((time[k] - 2.0).max(0.0));
        let course = |of: &dyn Fn(usize) -> f64| (0..time.len()).map(of).collect::<Vec<f64>>();
        trace.set_column(DISPLACEMENT, course(&|k| 5.0 * time[k].min(2.0)));
        trace.set_column("marker10_mm", course(&|k| 20.0 + seen(k, gap(k))));
        trace.set_column("marker2_mm", course(&|_| 20.0));
        trace
    }

    #[test]
    fn the_law_of_a_gap_comes_back_with_its_order_and_where_it_ends() {
        for order in [1.0, 5.0] {
            let gap: f64 = 0.68;
            let law = Power {
                rate: 0.3 / gap.powf(order - 1.0),
                order,
                equilibrium: 3.11,
                initial: 3.11 - gap,
            };
            let study = markers(&[trace(law)], Order::LowestOdd).unwrap();
            assert_eq!(study.order, Some(order));
            let [gap] = &study.gaps[..] else { panic!("{study:?}") };
            assert_eq!(gap.between, ["marker2_mm", "marker10_mm"]);
            assert!((gap.from_s - 2.0).abs() < 0.06);
            let fit = &gap.fit;
            assert!((fit.rate.0 / law.rate - 1.0).abs() < 0.03, "{fit:?}");
            assert!((fit.equilibrium.0 - 3.11).abs() < 2e-3, "{fit:?}");
        }
    }

    #[test]
    fn a_trace_without_markers_says_how_to_name_them() {
        let mut trace = Trace { time: vec![0.0, 1.0], ..Trace::default() };
        trace.set_column(DISPLACEMENT, vec![0.0, 1.0]);
        let error = markers(&[trace], Order::Free).unwrap_err();
        assert!(error.to_string().contains("marker1_mm"), "{error}");
    }
}
