//! The margin of a load history: when does a recorded grasp begin to slip?

use std::ops::Range;

use rayon::prelude::*;

use super::body::Body;
use super::contact::{Contact, Load};
use super::margin::margin;
use super::pressure::PressureLaw;
use palpate_trace::{DISPLACEMENT, Trace, noise, runs};

/// Column of the moment about the normal, N mm.
pub const MOMENT: &str = "moment_Nmm";

/// Where a load comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A column of the trace, in N or N mm.
    Column(String),
    /// Always the same, N or N mm.
    Constant(f64),
}

/// What is asked of the contact, and with what it is pressed.
#[derive(Clone, Debug, PartialEq)]
pub struct Sources {
    /// Column of the normal force, N.
    pub normal: String,
    /// Tangential force along x.
    pub tangential: Source,
    /// Tangential force along y.
    pub across: Source,
    /// Moment about the normal.
    pub moment: Source,
}

/// The contact of a grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// What is pressed.
    pub body: Body,
    /// How it presses.
    pub law: PressureLaw,
    /// Coefficient of friction μ, above 0.
    pub friction: f64,
}

/// A stretch of time over which the contact slips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// When it begins, s: between the samples before and after.
    pub from: f64,
    /// When it ends, by holding again or by losing contact, s.
    pub to: f64,
    /// Whether the contact had not held before: the load was there at the touch.
    pub from_touch: bool,
}

/// The margin over a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Share of what the contact can carry that is used, 1/margin, at each sample: above 1 it slips; not a
    /// number where there is no contact.
    pub used: Vec<f64>,
    /// The same once the normal force has settled, if that was given.
    pub settled: Option<Vec<f64>>,
    /// Normal force above which there is contact, N.
    pub threshold: f64,
    /// Where it slips, in order.
    pub slips: Vec<Slip>,
    /// The most that was used, and when, s.
    pub most_used: (f64, f64),
    /// Part of the time in contact at which it slips.
    pub slipping: f64,
}

impl History {
    /// The smallest margin: the load could have been so many times as large.
    #[must_use]
    pub fn smallest_margin(&self) -> f64 {
        self.most_used.0.recip()
    }

    /// When a grasp that held first gives way, s.
    #[must_use]
    pub fn first_slip(&self) -> Option<f64> {
        self.slips.iter().find(|slip| !slip.from_touch).map(|slip| slip.from)
    }
}

/// Why there is no margin.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum HistoryError {
    #[error("{trace} has no column `{column}`; {advice}")]
    NoColumn { trace: String, column: String, advice: &'static str },
    #[error("{trace}: the normal force never exceeds {threshold:.3} N, so there is no contact")]
    NoContact { trace: String, threshold: f64 },
}

/// There is contact where the normal force exceeds its noise so many times.
const OVER_NOISE: f64 = 5.0;

/// Follows the margin over a trace. `settled` is the normal force once settled at each sample, N, where it
/// is known; `threshold` the normal force above which there is contact, N, or five times its noise.
///
/// # Errors
/// [`HistoryError`].
pub fn history(
    trace: &Trace,
    grip: &Grip,
    sources: &Sources,
    settled: Option<&[f64]>,
    threshold: Option<f64>,
) -> Result<History, HistoryError> {
    let normal = column(trace, &sources.normal, "name the normal force with --normal")?;
    let loads = loads(trace, sources)?;
    let compression = compression(trace, &grip.body)?;
    let threshold = threshold.unwrap_or_else(|| {
        let noise = noise(trace, &sources.normal);
        noise.map_or(0.0, |noise| OVER_NOISE * noise.standard_deviation)
    });
    // Any size will do for one whose tables serve all samples.
    let shape = grip.body.contact(1.0);
    let model = shape.and_then(|shape| Contact::new(shape, grip.law).ok());
    let contact = |k: usize| {
        let shape = grip.body.contact(compression.map_or(0.0, |compression| compression[k]))?;
        model.as_ref()?.reshaped(shape).ok()
    };
    let used = |normal: &[f64]| -> Vec<f64> {
        let at = |k: usize| {
            let contact = contact(k).filter(|_| normal[k] > threshold)?;
            Some(margin(&contact, grip.friction * normal[k], &loads[k]).factor.recip())
        };
        (0..trace.len()).into_par_iter().map(|k| at(k).unwrap_or(f64::NAN)).collect()
    };
    let settled = settled.map(used);
    let used = used(normal);
    let most_used = used
        .iter()
        .zip(&trace.time)
        .filter(|(used, _)| !used.is_nan())
        .map(|(&used, &time)| (used, time))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .ok_or_else(|| HistoryError::NoContact { trace: trace.label(), threshold })?;
    let in_contact = used.iter().filter(|used| !used.is_nan()).count();
    let slipping = used.iter().filter(|used| **used >= 1.0).count();
    Ok(History {
        slips: runs(&trace.time)
            .into_iter()
            .flat_map(|run| slips(&trace.time, &used, run))
            .collect(),
        slipping: slipping as f64 / in_contact as f64,
        used,
        settled,
        threshold,
        most_used,
    })
}

/// The compression, where the contact depends on it.
fn compression<'t>(trace: &'t Trace, body: &Body) -> Result<Option<&'t [f64]>, HistoryError> {
    if !body.grows() {
        return Ok(None);
    }
    let advice = "the contact grows with it; give one of a fixed size with --contact";
    column(trace, DISPLACEMENT, advice).map(Some)
}

fn loads(trace: &Trace, sources: &Sources) -> Result<Vec<Load>, HistoryError> {
    let values = |source: &Source, advice| match source {
        Source::Column(name) => column(trace, name, advice).map(<[f64]>::to_vec),
        Source::Constant(value) => Ok(vec![*value; trace.len()]),
    };
    let advice = "name a column or a force in N with --tangential";
    let x = values(&sources.tangential, advice)?;
    let y = values(&sources.across, "name a column or a force in N with --across")?;
    let moment = values(&sources.moment, "name a column or a moment in N mm with --moment")?;
    let load = |k: usize| Load { force: [x[k], y[k]], moment: moment[k] };
    Ok((0..trace.len()).map(load).collect())
}

fn column<'t>(
    trace: &'t Trace,
    name: &str,
    advice: &'static str,
) -> Result<&'t [f64], HistoryError> {
    trace.column(name).ok_or_else(|| HistoryError::NoColumn {
        trace: trace.label(),
        column: name.into(),
        advice,
    })
}

/// Where the used share is 1 and more within samples that lie together; between samples it runs straight.
fn slips(time: &[f64], used: &[f64], run: Range<usize>) -> Vec<Slip> {
    let crossing = |before: usize, after: usize| {
        let share = (1.0 - used[before]) / (used[after] - used[before]);
        time[before] + share * (time[after] - time[before])
    };
    let mut found: Vec<Slip> = Vec::new();
    // Since when it slips, and whether from the touch on.
    let mut open: Option<(f64, bool)> = None;
    let mut last = run.start;
    for k in run {
        let (slips, slipped) = (used[k] >= 1.0, open.is_some());
        if slips && !slipped {
            // Without a number before there was no contact, and without a finite one nothing held.
            let held = k > last && used[last] < 1.0;
            let from = if held && used[k].is_finite() { crossing(last, k) } else { time[k] };
            open = Some((from, !held));
        } else if !slips && let Some((from, from_touch)) = open.take() {
            let holds = used[k] < 1.0 && used[last].is_finite();
            let to = if holds { crossing(last, k) } else { time[last] };
            found.push(Slip { from, to, from_touch });
        }
        last = k;
    }
    found.extend(open.map(|(from, from_touch)| Slip { from, to: time[last], from_touch }));
    found
}

#[cfg(test)]
mod tests {
    use super::super::contact::Shape;
    use super::*;
    use palpate_trace::{FORCE, TANGENTIAL};

    /// Pressed with 2 N from 1 s on, pulled at 0.5 N/s from 2 s on.
    fn pulled() -> Trace {
        let time: Vec<f64> = (0..600).map(|k| 0.01 * f64::from(k)).collect();
        let normal = time.iter().map(|&t| if t < 1.0 { 0.0 } else { 2.0 }).collect();
        let pull = time.iter().map(|&t| 0.5 * (t - 2.0).max(0.0)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(FORCE, normal);
        trace.set_column(TANGENTIAL, pull);
        trace
    }

    fn sources() -> Sources {
        Sources {
            normal: FORCE.into(),
            tangential: Source::Column(TANGENTIAL.into()),
            across: Source::Constant(0.0),
            moment: Source::Constant(0.0),
        }
    }

    fn grip(body: Body) -> Grip {
        Grip { body, law: PressureLaw::HERTZ, friction: 0.7 }
    }

    const PAD: Body = Body::Fixed(Shape::Circle { radius: 5.0 });

    #[test]
    fn a_pull_slips_when_it_reaches_the_friction() {
        let found = history(&pulled(), &grip(PAD), &sources(), None, Some(0.1)).unwrap();
        assert!((found.first_slip().unwrap() - 4.8).abs() < 1e-9, "{:?}", found.slips);
        assert!(found.used[99].is_nan() && found.used[150] == 0.0);
        assert!((found.smallest_margin() - 1.4 / (0.5 * 3.99)).abs() < 1e-9);
        assert!((found.slipping - 120.0 / 500.0).abs() < 0.01);
    }

    #[test]
    fn a_moment_brings_the_slip_forward_and_a_settled_force_too() {
        let mut twisted = sources();
        twisted.moment = Source::Constant(2.0);
        let relaxed = vec![1.2; 600];
        let trace = pulled();
        let found = history(&trace, &grip(PAD), &twisted, Some(&relaxed), Some(0.1)).unwrap();
        assert!(found.first_slip().unwrap() < 4.7);
        let settled = found.settled.unwrap();
        assert!(settled[450] > found.used[450] * 1.5);
    }

    #[test]
    fn a_load_that_is_there_at_the_touch_slips_at_the_touch() {
        let mut loaded = sources();
        loaded.tangential = Source::Constant(-9.0);
        let found = history(&pulled(), &grip(PAD), &loaded, None, Some(0.1)).unwrap();
        assert_eq!(found.first_slip(), None);
        assert_eq!(found.slips, [Slip { from: 1.0, to: 5.99, from_touch: true }]);
    }

    #[test]
    fn a_grasp_that_slips_while_it_forms_and_again_later_has_two_slips() {
        let mut trace = pulled();
        let time = trace.time.clone();
        let pull = time.iter().map(|t| 2.0 - (t - 3.0).abs()).map(|pull| 1.8 - pull).collect();
        trace.set_column(TANGENTIAL, pull);
        let found = history(&trace, &grip(PAD), &sources(), None, Some(0.1)).unwrap();
        let [touch, later] = found.slips[..] else { panic!("{:?}", found.slips) };
        assert!(touch.from_touch && touch.from == 1.0 && (touch.to - 1.4).abs() < 1e-9);
        assert!(!later.from_touch && (later.from - 4.6).abs() < 1e-9);
        assert_eq!(found.first_slip(), Some(later.from));
    }

    #[test]
    fn what_is_missing_is_named_with_what_to_do() {
        let said = |trace: &Trace, body, sources: &Sources, threshold| {
            history(trace, &grip(body), sources, None, Some(threshold)).unwrap_err().to_string()
        };
        let ball = Body::Sphere { radius: 9.0 };
        assert!(said(&pulled(), ball, &sources(), 0.1).contains("`displacement_mm`"));
        let mut other = sources();
        other.tangential = Source::Column("shear".into());
        assert!(said(&pulled(), PAD, &other, 0.1).contains("--tangential"));
        assert!(said(&pulled(), PAD, &sources(), 3.0).contains("no contact"));
    }
}
