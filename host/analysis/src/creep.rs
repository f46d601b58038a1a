//! Creep in holds of a force: δ = D h(t), c0 = 1 (6.1)–(6.4), and what of it the hold identifies
//! (chapter 6, appendix B).

use std::ops::Range;

use shared::phase::RelaxationType;

use super::terms::{self, Terms};
use palpate_fit::exponentials::{Fit, Parameter};
use palpate_fit::hold::{self, HoldError, HoldFit, Holds, Response, Spread, spreads_by};
use palpate_trace::{Control, FORCE, Trace, control};

/// Relative standard error above which a value is not told by a hold.
const HARDLY: f64 = 0.5;

/// One hold of a recording.
#[derive(Clone, Debug)]
pub struct Hold {
    /// Eq. 6.2: N is D, the displacement after infinite time.
    pub fit: HoldFit,
    /// Force that was held, N, where it was recorded: mean and standard deviation.
    pub force: Option<(f64, f64)>,
    /// One to four exponentials beside each other.
    pub terms: Terms,
    /// What the hold does not identify, in words.
    pub doubts: Vec<String>,
}

/// Each coefficient over holds of one type at one force.
#[must_use]
pub fn spreads(holds: &[Hold]) -> Vec<Spread> {
    let fits: Vec<HoldFit> = holds.iter().map(|hold| hold.fit.clone()).collect();
    let force = |fit: &HoldFit| {
        let same = |hold: &&Hold| hold.fit.trace == fit.trace && hold.fit.range == fit.range;
        holds.iter().find(same).and_then(|hold| hold.force).map(|force| force.0)
    };
    spreads_by(&fits, force)
}

/// Why creep cannot be analysed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum CreepError {
    #[error(transparent)]
    Hold(#[from] HoldError),
    #[error(
        "{trace}: displacement was controlled ({}), so its holds relax: use `palpate relaxation`.{}",
        if *told { "the head says so" } else { "nothing shows that force was" },
        if *told { "" } else { " If force was, write control = \"force\" into the head." }
    )]
    DisplacementControlled { trace: String, told: bool },
}

/// Fits every hold of a trace whose force was controlled, in order. With `signs`, every ci has the sign of
/// its type (6.3), (6.4). A recording with neither displacement nor force is the answer to one step.
///
/// # Errors
/// As [`hold::fit_holds`], and when displacement was controlled.
pub fn creep(
    trace: &Trace,
    signal: &str,
    exponentials: hold::Terms,
    signs: bool,
) -> Result<Holds<Hold>, CreepError> {
    let told = trace.head.control.is_some();
    // One column alone (a compliance) tells nothing of what was controlled: asking for creep says it.
    let alone = trace.force().is_none() && !told;
    if control(trace) == Control::Displacement && !alone {
        return Err(CreepError::DisplacementControlled { trace: trace.label(), told });
    }
    let mut trace = trace.clone();
    trace.head.control = Some(Control::Force);
    let found = hold::fit_responses(&trace, signal, Response::Creep, exponentials, signs)?;
    let values = trace.changing(signal).map_err(HoldError::from)?;
    let of = |fit: HoldFit| {
        let (time, values) = (&trace.elapsed(fit.range.clone())[..], &values[fit.range.clone()]);
        let failed = |source| HoldError::Fit { trace: trace.label(), from_s: fit.from_s, source };
        let asked = Response::Creep.options(hold::Terms::Auto, signs.then_some(fit.relaxation));
        let terms = terms::terms(time, values, &asked).map_err(failed)?;
        let doubts = doubts(&fit.fit, fit.duration_s, fit.relaxation);
        let force = trace.column(FORCE).map(|force| spread(force, &fit.range));
        Ok::<_, HoldError>(Hold { force, terms, doubts, fit })
    };
    let mut each = Holds::of(found.holds.into_iter().map(of))?;
    each.left_out.splice(..0, found.left_out);
    Ok(each)
}

/// What a hold of `duration_s` does not identify of a fit.
#[must_use]
pub fn doubts(fit: &Fit, duration_s: f64, relaxation: RelaxationType) -> Vec<String> {
    let mut found: Vec<String> = fit.notes.iter().map(ToString::to_string).collect();
    for (index, term) in fit.sum.terms.iter().enumerate() {
        let number = index + 1;
        let rate = Parameter::Rate(number);
        let constant = 1.0 / term.rate;
        if constant > duration_s {
            found.push(format!(
                "1/v{number} = {constant:.3} s is longer than the hold of {duration_s:.3} s: c{number} and D trade off, and D is an extrapolation"
            ));
        }
        if fit.standard_error(rate).is_none_or(|error| error > HARDLY * term.rate) {
            found.push(format!("v{number} is not identifiable from this hold: its standard error exceeds half of it"));
        }
        let wrong = match relaxation {
            RelaxationType::TypeI => term.coefficient > 0.0,
            RelaxationType::TypeII => term.coefficient < 0.0,
            RelaxationType::None => false,
        };
        if wrong {
            let equation = if relaxation == RelaxationType::TypeI { "6.3" } else { "6.4" };
            found.push(format!(
                "c{number} has the wrong sign for its type ({equation}); --signs forbids it"
            ));
        }
    }
    found
}

fn spread(values: &[f64], range: &Range<usize>) -> (f64, f64) {
    let held = &values[range.clone()];
    let mean = held.iter().sum::<f64>() / held.len() as f64;
    let square: f64 = held.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (square / (held.len().max(2) - 1) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use palpate_trace::DISPLACEMENT;

    /// Two levels of force, the second reached from above, and the displacement of a solid with one
    /// retardation rate of 0.6/s.
    fn steps() -> Trace {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let normal = Normal::new(0.0, 0.004).unwrap();
        let time: Vec<f64> = (0..4000).map(|k| 0.01 * f64::from(k)).collect();
        let force: Vec<f64> = time
            .iter()
            .map(|&t| match t {
                t if t < 1.0 => 0.0,
                t if t < 2.0 => 4.0 * (t - 1.0),
                t if t < 20.0 => 4.0,
                t if t < 20.5 => 4.0 - 4.0 * (t - 20.0),
                _ => 2.0,
            })
            .collect();
        let mut slow = 0.0;
        let displacement = (0..time.len())
            .map(|k| {
                slow += (force[k] - slow) * -(-0.6f64 * 0.01).exp_m1();
                1.5 * force[k] + 0.3 * slow + normal.sample(&mut random)
            })
            .collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, displacement);
        trace.set_column(FORCE, force);
        trace
    }

    #[test]
    fn creep_goes_up_after_loading_and_down_after_unloading() {
        let found = creep(&steps(), DISPLACEMENT, hold::Terms::Fixed(1), true).unwrap().holds;
        let types: Vec<_> = found.iter().map(|hold| hold.fit.relaxation).collect();
        assert_eq!(types, [RelaxationType::TypeI, RelaxationType::TypeII]);
        for (hold, (force, sign)) in found.iter().zip([(4.0, -1.0), (2.0, 1.0)]) {
            let term = hold.fit.fit.sum.terms[0];
            assert!((hold.force.unwrap().0 - force).abs() < 0.01);
            assert!((term.rate - 0.6).abs() < 0.06, "{term:?}");
            assert!(term.coefficient * sign > 0.0);
            assert_eq!(hold.fit.fit.sum.constant, 1.0);
            assert!((hold.fit.fit.sum.scale - 1.8 * force).abs() < 0.02, "D = 1.8 mm/N");
            assert_eq!(hold.terms.decided(), 1);
            assert_eq!(hold.doubts, [""; 0]);
        }
    }

    #[test]
    fn rates_that_a_short_hold_does_not_tell_are_named() {
        let found = creep(&steps(), DISPLACEMENT, hold::Terms::Fixed(3), false).unwrap().holds;
        assert!(
            found[0].doubts.iter().any(|doubt| doubt.contains("not identifiable")
                || doubt.contains("coincide")
                || doubt.contains("trade off")
                || doubt.contains("limit")),
            "{:?}",
            found[0].doubts
        );
    }

    #[test]
    fn a_relaxation_is_sent_elsewhere() {
        let mut trace = steps();
        trace.head.control = Some(Control::Displacement);
        let error = creep(&trace, DISPLACEMENT, hold::Terms::Fixed(1), false).unwrap_err();
        assert!(error.to_string().contains("palpate relaxation"), "{error}");
    }
}
