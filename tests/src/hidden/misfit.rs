//! The misfit that remains after the base is refitted to data without noise.

use nalgebra::{SMatrix, SVector};

use super::session::Session;
use super::specimen::{Base, decay_and_gain};

/// ln of the force at 12 mm, q, ln c1, ln c2, ln v1, ln v2.
type Point = SVector<f64, 6>;

/// Largest compression of the planned motions, mm: the stiffness is stated by the force there.
const REFERENCE: f64 = 12.0;

/// A base over the samples of a session, to be fitted to signals.
#[derive(Debug)]
pub struct Refit {
    start: Point,
    rate_hz: f64,
    /// For each trace ln(x/12 mm) of its samples, none off the specimen, and the pause before, s.
    traces: Vec<(Vec<Option<f64>>, f64)>,
    samples: usize,
}

impl Refit {
    /// Fits of the base over the session, from its true parameters.
    #[must_use]
    pub fn new(base: &Base, session: &Session) -> Self {
        let mut end = 0.0;
        let traces = session.recordings.iter().map(|recording| {
            let x = |time| recording.course.at(time).x;
            let depth = |time| (x(time) > 0.0).then(|| (x(time) / REFERENCE).ln());
            let pause = recording.start_s - end;
            end = recording.start_s + recording.last_s();
            (recording.times().map(depth).collect(), pause)
        });
        let traces: Vec<(Vec<Option<f64>>, f64)> = traces.collect();
        let samples = traces.iter().map(|(depths, _)| depths.len()).sum();
        let [c1, c2] = base.shares.map(f64::ln);
        let [v1, v2] = base.rates.map(f64::ln);
        let start = Point::from([base.elastic(REFERENCE).ln(), base.q, c1, c2, v1, v2]);
        Self { start, rate_hz: session.rate_hz(), traces, samples }
    }

    /// Hands the prediction for each sample of the set to `sink`.
    fn predict(&self, point: &Point, mut sink: impl FnMut(usize, f64)) {
        let shares = [point[2].exp(), point[3].exp()];
        let rates = [point[4].exp(), point[5].exp()];
        let within = rates.map(|rate| decay_and_gain(rate / self.rate_hz));
        let mut branches = [0.0; 2];
        let (mut before, mut sample) = (0.0, 0);
        for (depths, pause) in &self.traces {
            for (branch, rate) in branches.iter_mut().zip(rates) {
                *branch *= (-rate * pause).exp();
            }
            for (k, depth) in depths.iter().enumerate() {
                let elastic =
                    depth.map_or(0.0, |depth| (point[0] + (point[1] + 1.0) * depth).exp());
                if k > 0 {
                    for (branch, (decay, gain)) in branches.iter_mut().zip(within) {
                        *branch = decay * *branch + gain * (elastic - before);
                    }
                }
                before = elastic;
                let force = (1.0 - shares[0] - shares[1]) * elastic
                    + shares[0] * branches[0]
                    + shares[1] * branches[1];
                sink(sample, force.max(0.0));
                sample += 1;
            }
        }
    }

    fn residuals(&self, point: &Point, signal: &[f64]) -> Vec<f64> {
        let mut residuals = vec![0.0; self.samples];
        self.predict(point, |sample, force| residuals[sample] = signal[sample] - force);
        residuals
    }

    /// Root mean square of what the best base leaves of a signal (all traces one after the other).
    #[must_use]
    pub fn misfit(&self, signal: &[f64]) -> f64 {
        let cost = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
        let mut point = self.start;
        let mut residuals = self.residuals(&point, signal);
        let mut damping = 0.0;
        for _ in 0..60 {
            let now = cost(&residuals);
            let (curvature, slope) = self.normal(&point, signal, &residuals);
            let mut damped = curvature;
            for k in 0..6 {
                damped[(k, k)] *= 1.0 + damping;
            }
            let Some(cholesky) = damped.cholesky() else {
                damping = (10.0 * damping).max(1e-6);
                continue;
            };
            let next = point + cholesky.solve(&slope);
            let left = self.residuals(&next, signal);
            let then = cost(&left);
            if then < now {
                (point, residuals) = (next, left);
                damping *= 0.1;
            } else {
                damping = (10.0 * damping).max(1e-4);
            }
            if (now - then).abs() < 1e-5 * now || damping > 1e6 {
                break;
            }
        }
        (cost(&residuals) / self.samples as f64).sqrt()
    }

    /// JᵀJ and Jᵀr by forward differences.
    fn normal(
        &self,
        point: &Point,
        signal: &[f64],
        residuals: &[f64],
    ) -> (SMatrix<f64, 6, 6>, Point) {
        const STEP: f64 = 1e-6;
        let columns: Vec<Vec<f64>> = (0..6)
            .map(|k| {
                let mut moved = *point;
                moved[k] += STEP;
                let mut column = self.residuals(&moved, signal);
                for (moved, here) in column.iter_mut().zip(residuals) {
                    *moved = (here - *moved) / STEP;
                }
                column
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let curvature = SMatrix::from_fn(|i, j| dot(&columns[i], &columns[j]));
        (curvature, Point::from_fn(|i, _| dot(&columns[i], residuals)))
    }
}
