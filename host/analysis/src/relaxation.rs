//! What a hold shows: eq. 3.4, how many exponentials, and the linear latency model (chapters 3 and 4,
//! appendix A).

use super::controlled::{ForceControlled, displacement_controlled};
use super::derivative::{Derivative, derivative};
use super::terms::{self, Terms};
use palpate_fit::exponentials::{Fit, Options, Parameter, Prepared};
use palpate_fit::hold::{self, HoldError, HoldFit, Holds, Response};
use palpate_fit::relaxation_form::{Forms, forms};
use palpate_model::latency::Linear;
use palpate_trace::Trace;

/// Instants at which the strain rate of a hold is drawn.
const INSTANTS: usize = 120;
/// Share of a relaxation after which it counts as over.
pub const OVER: f64 = 0.99;

/// One hold of a recording.
#[derive(Clone, Debug)]
pub struct Hold {
    /// Eq. 3.4.
    pub fit: HoldFit,
    /// One to four exponentials beside each other.
    pub terms: Terms,
    /// Sums of exponentials beside a power law and a stretched exponential; none where the samples are too
    /// few.
    pub forms: Option<Forms>,
    /// The linear latency model; none where the hold does not tell where it settles.
    pub latency: Option<Latency>,
}

/// The linear latency model of a hold (4.2.2).
#[derive(Clone, Debug)]
pub struct Latency {
    /// Eq. 4.4: one exponential.
    pub fit: Fit,
    /// Its closed form (4.5)–(4.10). Strain is negative in compression.
    pub law: Linear,
    /// Where the signal settles, N0 c0, with its standard error, in the unit of the signal.
    pub settles: (f64, Option<f64>),
    /// What the strain is in: of the specimen's height, where the head gives it, else in units of
    /// the equilibrium strain.
    pub scale: StrainScale,
    /// Strain and strain rate as measured.
    pub measured: Option<Derivative>,
}

impl Latency {
    /// When this share of the gap between the strain at first and the equilibrium is left, s (4.10).
    #[must_use]
    pub fn time_with_left(&self, share: f64) -> Option<f64> {
        let (start, end) = (self.law.strain(0.0), self.law.equilibrium());
        self.law.time_at(end + share * (start - end))
    }
}

/// What a strain is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrainScale {
    /// Equilibrium is the displacement over the specimen's height (5.8).
    OfHeight,
    /// Equilibrium is −1.
    OfEquilibrium,
}

/// Why holds cannot be analysed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum RelaxationError {
    #[error(transparent)]
    Hold(#[from] HoldError),
    #[error(transparent)]
    Controlled(#[from] ForceControlled),
}

/// Fits every hold of a trace; `exponentials` for eq. 3.4, `signs` as in [`hold::fit_holds`].
///
/// # Errors
/// As [`hold::fit_holds`], and when force was controlled.
pub fn relaxation(
    trace: &Trace,
    signal: &str,
    exponentials: hold::Terms,
    signs: bool,
) -> Result<Holds<Hold>, RelaxationError> {
    displacement_controlled(trace)?;
    let found = hold::fit_holds(trace, signal, exponentials, signs)?;
    let values = trace.changing(signal).map_err(HoldError::from)?;
    let of = |fit: HoldFit| {
        let (time, values) = (&trace.elapsed(fit.range.clone())[..], &values[fit.range.clone()]);
        let failed = |source| HoldError::Fit { trace: trace.label(), from_s: fit.from_s, source };
        let asked =
            Response::Relaxation.options(hold::Terms::Auto, signs.then_some(fit.relaxation));
        let terms = terms::terms(time, values, &asked).map_err(failed)?;
        let most = terms.rows.len();
        let limits = Prepared::new(time, &Options::default()).map_err(failed)?.rate_limits();
        let forms = forms(time, values, most, limits);
        let latency = latency(time, values, strain_of_height(trace, &fit));
        Ok::<_, HoldError>(Hold { fit, terms, forms, latency })
    };
    let mut each = Holds::of(found.holds.into_iter().map(of))?;
    each.left_out.splice(..0, found.left_out);
    Ok(each)
}

/// δ/h during a hold.
fn strain_of_height(trace: &Trace, fit: &HoldFit) -> Option<f64> {
    let strain = fit.displacement? / trace.head.specimen.height_mm?;
    (strain > 0.0).then_some(strain)
}

/// Fits the latency model to a hold whose equilibrium strain may be known.
fn latency(time: &[f64], values: &[f64], strain: Option<f64>) -> Option<Latency> {
    let options = Options { terms: 1, ..Options::default() };
    let fit = Prepared::new(time, &options).ok()?.fit(values).ok()?;
    let fit = fit.allowing_for_correlation(time, values);
    let (force, constant) = (fit.sum.scale, fit.sum.constant);
    let settles = force * constant;
    let error = settles_error(&fit);
    // Where it settles must be told from zero and of the sign of the force, else it is no solid.
    if settles * force <= 0.0 || error.is_none_or(|error| settles.abs() < 2.0 * error) {
        return None;
    }
    let stiffness_n = settles / strain.unwrap_or(1.0);
    let law =
        Linear { initial_force_n: force, constant, rate: fit.sum.terms.first()?.rate, stiffness_n };
    let strains: Vec<f64> = values.iter().map(|force| -force / stiffness_n).collect();
    let since: Vec<f64> = time.iter().map(|t| t - time[0]).collect();
    let measured = derivative(&since, &strains, fit.noise / stiffness_n.abs(), INSTANTS);
    let scale = strain.map_or(StrainScale::OfEquilibrium, |_| StrainScale::OfHeight);
    Some(Latency { law, settles: (settles, error), scale, measured, fit })
}

/// Standard error of N c0 from those of N and c0 and their covariance.
fn settles_error(fit: &Fit) -> Option<f64> {
    let (n, c0) = (Parameter::Scale, Parameter::Coefficient(0));
    let (force, constant) = (fit.value(n)?, fit.value(c0)?);
    let variance = (constant * fit.standard_error(n)?).powi(2)
        + (force * fit.standard_error(c0)?).powi(2)
        + 2.0 * force * constant * fit.covariance(n, c0)?;
    (variance > 0.0).then(|| variance.sqrt())
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use palpate_trace::{DISPLACEMENT, FORCE};

    /// A ramp to 6 mm on 30 mm and a hold of 8 s with one exponential, v1 = 0.5/s.
    fn press() -> Trace {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let normal = Normal::new(0.0, 0.01).unwrap();
        let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| (6.0 * t).min(6.0)).collect();
        let force = time.iter().map(|&t| match t {
            t if t < 1.0 => 5.0 * t,
            t => 3.0 + 2.0 * (-0.5 * (t - 1.0)).exp(),
        });
        let force = force.map(|f| f + normal.sample(&mut random)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    }

    #[test]
    fn a_hold_of_one_exponential_lies_on_the_straight_line_of_the_latency_model() {
        let mut trace = press();
        trace.head.specimen.height_mm = Some(30.0);
        let found = relaxation(&trace, FORCE, hold::Terms::Fixed(2), false).unwrap().holds;
        let hold = &found[0];
        assert_eq!(hold.terms.decided(), 1);
        let latency = hold.latency.as_ref().unwrap();
        assert_eq!(latency.scale, StrainScale::OfHeight);
        assert!((latency.law.rate - 0.5).abs() < 0.02);
        assert!((latency.law.equilibrium() + 0.2).abs() < 1e-3, "{}", latency.law.equilibrium());
        let (settles, error) = latency.settles;
        assert!((settles - 3.0).abs() < 4.0 * error.unwrap());
        let measured = latency.measured.as_ref().unwrap();
        let fastest = latency.law.strain_rate(0.0);
        for (strain, slope) in measured.smoothed.iter().zip(&measured.slope) {
            let line = latency.law.strain_rate_at(*strain);
            assert!((slope - line).abs() < 0.2 * fastest, "{strain}: {slope} {line}");
        }
    }

    #[test]
    fn without_a_height_strain_is_relative_to_the_equilibrium() {
        let found = relaxation(&press(), FORCE, hold::Terms::Fixed(1), false).unwrap().holds;
        let latency = found[0].latency.as_ref().unwrap();
        assert_eq!(latency.scale, StrainScale::OfEquilibrium);
        assert!((latency.law.equilibrium() + 1.0).abs() < 1e-12);
    }
}
