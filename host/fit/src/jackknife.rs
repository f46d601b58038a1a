//! Standard errors that allow for what the law leaves: the delete-one jackknife over traces.
//!
//! Where a law is inexact, what it leaves of a trace is not chance but a part of that trace, and traces, not samples,
//! are independent. Every trace is left out in turn, the others refitted in one step from the fit to all; the
//! scatter of those refits is the covariance (Efron and Stein 1981; the CR3 estimator of clustered regression is the
//! same to first order).

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::data::Data;
use super::least_squares::{LeastSquares, Normal, bounded_step};
use super::problem::Problem;
use super::uncertainty;
use super::whitening::Whitening;
use super::whole_motion::{Basis, MotionFit, declared_uncertainty};

/// Fewest traces that show how much they differ.
const FEWEST_TRACES: usize = 5;
/// A residual beyond this many times the noise is more than noise.
pub(super) const MISFIT: f64 = 1.2;
/// Damping of a refit: none but what keeps it defined.
const HARDLY: f64 = 1e-12;
/// Standard errors in the half width of a 95 % interval of a normal number.
const NORMAL: f64 = 1.959_963_985;

impl MotionFit {
    /// Whether what it leaves is more than noise of this standard deviation.
    #[must_use]
    pub fn is_misfit(&self, noise: f64) -> bool {
        self.rms() > MISFIT * noise
    }

    /// Takes standard errors and correlations from the scatter of refits without each trace, where the fit leaves more
    /// than the noise and there are at least five traces; else they stay those of the noise. With few traces
    /// the errors are larger by as much as Student's distribution is wider than the normal one. A refit in one step
    /// sees less than a whole one does: docs/measured.md tells how often the intervals hold.
    #[must_use]
    pub fn allowing_for_misfit(mut self, data: &Data, noise: Option<f64>) -> Self {
        let traces = data.labels.len();
        if traces < FEWEST_TRACES || !noise.is_some_and(|noise| self.is_misfit(noise)) {
            return self;
        }
        let white = Whitening::none();
        let problem = Problem::new(&self.chain, data, &white, None);
        let point = problem.point(&self.values);
        let of_traces = problem.by_trace(&point);
        let mut all = Normal::zeros(point.len());
        of_traces.iter().for_each(|(own, _)| all.add_times(own, 1.0));
        let refit = |(own, _): &(Normal, usize)| {
            let mut others = all.clone();
            others.add_times(own, -1.0);
            bounded_step(&others, HARDLY, &point, problem.bounds())
        };
        let steps: Vec<DVector<f64>> = of_traces.iter().map(refit).collect();
        let held: Vec<bool> =
            (0..point.len()).map(|j| steps.iter().all(|step| step[j] == 0.0)).collect();
        let mut known = uncertainty(&all.curvature, &held, 1.0);
        known.covariance = scatter(&steps) * widening(traces).powi(2);
        (self.standard_errors, self.correlation) = declared_uncertainty(&problem, &point, &known);
        self.basis = Basis::Traces;
        self
    }
}

/// Covariance from refits without each part.
fn scatter(steps: &[DVector<f64>]) -> DMatrix<f64> {
    let count = steps.len() as f64;
    let size = steps.first().map_or(0, DVector::len);
    let mean = steps.iter().fold(DVector::zeros(size), |sum, step| sum + step) / count;
    let off = steps.iter().map(|step| step - &mean);
    off.fold(DMatrix::zeros(size, size), |sum, off| sum + &off * off.transpose())
        * ((count - 1.0) / count)
}

/// How much wider a 95 % interval is where the scatter is that of so few parts.
fn widening(parts: usize) -> f64 {
    let student = StudentsT::new(0.0, 1.0, (parts - 1) as f64);
    student.map_or(1.0, |student| student.inverse_cdf(0.975) / NORMAL)
}
