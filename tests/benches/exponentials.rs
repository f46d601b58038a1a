//! Two exponentials on 860 samples: palpate beside `rmpfit`, `varpro` and `levenberg-marquardt`
//! on the same traces in one run.
//!
//! palpate gets no start; the rivals get what a user would give them: a start within 20 % of the
//! truth, analytic derivatives, their default tolerances, and the exponentials of each set of
//! rates computed once.

use criterion::Criterion;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_of_rivals::{DMatrix, DVector, Dyn, Matrix, OMatrix, Owned, U1, U5, Vector5};
use palpate::fit::exponentials::{Options, Parameter, Prepared};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use rmpfit::{MPFitter, MPPar, MPResult, MPSide};
use std::convert::Infallible;
use std::hint::black_box;
use std::time::Instant;
use varpro::prelude::SeparableNonlinearModel;
use varpro::problem::SeparableProblemBuilder;
use varpro::solvers::levmar::LevMarSolver;

/// Amplitudes and rates of (3.6): A0, A1, A2, v1, v2.
const TRUTH: [f64; 5] = [0.4852, 0.2472, 0.2676, 3.981, 0.5325];
/// A start that a user might read off a plot.
const START: [f64; 5] = [0.5, 0.2, 0.3, 3.3, 0.63];
const NOISE: f64 = 0.01;
const TRACES: usize = 200;
const ROUNDS: usize = 15;

/// A name, and a fit that returns its sum of squared residuals.
type Run<'a> = (&'a str, &'a dyn Fn(&[f64]) -> f64);

fn main() {
    let times: Vec<f64> = (0..860).map(|k| f64::from(k) / 200.0).collect();
    let traces = traces(&times);
    let prepared = Prepared::new(&times, &Options::relaxation()).expect("these times can be used");
    let runs: [Run; 4] = [
        ("palpate", &|trace| ours(&prepared, trace)),
        ("rmpfit", &|trace| rmpfit(&times, trace)),
        ("varpro", &|trace| varpro(&times, trace)),
        ("levenberg-marquardt", &|trace| levenberg_marquardt(&times, trace)),
    ];

    let mut criterion = Criterion::default().configure_from_args();
    let mut group = criterion.benchmark_group("two exponentials, 860 samples");
    for (name, run) in runs {
        let mut next = traces.iter().cycle();
        group.bench_function(name, |bencher| {
            bencher.iter(|| run(black_box(next.next().expect("a cycle has no end"))));
        });
    }
    group.bench_function("palpate: prepare", |bencher| {
        bencher.iter(|| Prepared::new(black_box(&times), &Options::relaxation()));
    });
    group.finish();
    criterion.final_summary();
    summary(&runs, &traces);
}

fn traces(times: &[f64]) -> Vec<Vec<f64>> {
    let noise = Normal::new(0.0, NOISE).expect("a positive standard deviation");
    let mut random = ChaCha8Rng::seed_from_u64(36);
    let [a0, a1, a2, v1, v2] = TRUTH;
    (0..TRACES)
        .map(|_| {
            let value = |t: &f64| a0 + a1 * (-v1 * t).exp() + a2 * (-v2 * t).exp();
            times.iter().map(|t| value(t) + noise.sample(&mut random)).collect()
        })
        .collect()
}

/// Median over rounds of the time for each trace; rounds of all four alternate, so that all see
/// the same machine. Also how far each ends above the least sum of squares that any reached.
fn summary(runs: &[Run], traces: &[Vec<f64>]) {
    let mut micros = vec![Vec::new(); runs.len()];
    for _ in 0..ROUNDS {
        for (times, (_, run)) in micros.iter_mut().zip(runs) {
            let start = Instant::now();
            for trace in traces {
                black_box(run(black_box(trace)));
            }
            times.push(start.elapsed().as_secs_f64() * 1e6 / traces.len() as f64);
        }
    }
    let medians: Vec<f64> = micros
        .iter_mut()
        .map(|times| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        })
        .collect();
    let sums: Vec<Vec<f64>> =
        runs.iter().map(|(_, run)| traces.iter().map(|trace| run(trace)).collect()).collect();
    let excess = |sums: &[f64], all: &[Vec<f64>]| {
        (0..traces.len())
            .map(|k| {
                let least = all.iter().map(|sums| sums[k]).fold(f64::INFINITY, f64::min);
                sums[k] / least - 1.0
            })
            .fold(0.0, f64::max)
    };
    println!("\n{TRACES} traces of 860 samples, median of {ROUNDS} rounds on one core");
    println!("{:<20} {:>10} {:>8}  worst excess of the sum of squares", "", "µs/trace", "ratio");
    for ((name, _), (median, sums_here)) in runs.iter().zip(medians.iter().zip(&sums)) {
        let ratio = median / medians[0];
        println!("{name:<20} {median:>10.2} {ratio:>8.1}  {:.1e}", excess(sums_here, &sums));
    }
    let fastest = medians[1..].iter().copied().fold(f64::INFINITY, f64::min);
    println!("palpate is {:.1} times as fast as the fastest of the three", fastest / medians[0]);
}

/// No start, constraints c ≥ 0 and c0 ≥ 0, covariance; returns the sum of squares.
fn ours(prepared: &Prepared, trace: &[f64]) -> f64 {
    let fit = prepared.fit(trace).expect("a clean trace can be fitted");
    black_box(fit.standard_error(Parameter::Rate(1)));
    fit.rss
}

struct Mpfit<'a> {
    times: &'a [f64],
    trace: &'a [f64],
    limits: Vec<MPPar>,
}

fn rmpfit(times: &[f64], trace: &[f64]) -> f64 {
    let limits = (0..5)
        .map(|_| MPPar {
            limited_low: true,
            limit_low: 0.0,
            side: MPSide::User,
            ..MPPar::default()
        })
        .collect();
    let mut parameters = START;
    let status = Mpfit { times, trace, limits }.mpfit(&mut parameters);
    status.map_or(f64::NAN, |status| status.best_norm)
}

impl MPFitter for Mpfit<'_> {
    fn eval(&mut self, p: &[f64], deviates: &mut [f64]) -> MPResult<()> {
        for ((deviate, t), y) in deviates.iter_mut().zip(self.times).zip(self.trace) {
            *deviate = p[0] + p[1] * (-p[3] * t).exp() + p[2] * (-p[4] * t).exp() - y;
        }
        Ok(())
    }

    fn number_of_points(&self) -> usize {
        self.times.len()
    }

    fn parameters(&self) -> &[MPPar] {
        &self.limits
    }

    fn jacobian(
        &mut self,
        p: &[f64],
        deviates: &mut [f64],
        derivatives: &mut [Option<Vec<f64>>],
    ) -> MPResult<()> {
        let [Some(d0), Some(d1), Some(d2), Some(d3), Some(d4)] = derivatives else {
            return Err(rmpfit::MPError::Eval);
        };
        for (k, (t, y)) in self.times.iter().zip(self.trace).enumerate() {
            let (e1, e2) = ((-p[3] * t).exp(), (-p[4] * t).exp());
            deviates[k] = p[0] + p[1] * e1 + p[2] * e2 - y;
            d0[k] = 1.0;
            d1[k] = e1;
            d2[k] = e2;
            d3[k] = -p[1] * t * e1;
            d4[k] = -p[2] * t * e2;
        }
        Ok(())
    }
}

struct Joint<'a> {
    times: &'a [f64],
    trace: &'a [f64],
    parameters: Vector5<f64>,
    exponentials: Vec<(f64, f64)>,
}

fn levenberg_marquardt(times: &[f64], trace: &[f64]) -> f64 {
    let mut problem = Joint {
        times,
        trace,
        parameters: Vector5::zeros(),
        exponentials: vec![(0.0, 0.0); times.len()],
    };
    problem.set_params(&Vector5::from(START));
    let (_, report) = LevenbergMarquardt::new().minimize(problem);
    2.0 * report.objective_function
}

impl LeastSquaresProblem<f64, Dyn, U5> for Joint<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U5>;
    type ParameterStorage = Owned<f64, U5>;

    fn set_params(&mut self, p: &Vector5<f64>) {
        self.parameters = *p;
        for (pair, t) in self.exponentials.iter_mut().zip(self.times) {
            *pair = ((-p[3] * t).exp(), (-p[4] * t).exp());
        }
    }

    fn params(&self) -> Vector5<f64> {
        self.parameters
    }

    fn residuals(&self) -> Option<Matrix<f64, Dyn, U1, Self::ResidualStorage>> {
        let p = &self.parameters;
        let values = self.exponentials.iter().zip(self.trace);
        let residuals = values.map(|((e1, e2), y)| p[0] + p[1] * e1 + p[2] * e2 - y);
        Some(DVector::from_iterator(self.trace.len(), residuals))
    }

    fn jacobian(&self) -> Option<Matrix<f64, Dyn, U5, Self::JacobianStorage>> {
        let p = &self.parameters;
        let mut jacobian = OMatrix::<f64, Dyn, U5>::zeros(self.trace.len());
        for (k, ((e1, e2), t)) in self.exponentials.iter().zip(self.times).enumerate() {
            jacobian[(k, 0)] = 1.0;
            jacobian[(k, 1)] = *e1;
            jacobian[(k, 2)] = *e2;
            jacobian[(k, 3)] = -p[1] * t * e1;
            jacobian[(k, 4)] = -p[2] * t * e2;
        }
        Some(jacobian)
    }
}

struct Separable {
    times: DVector<f64>,
    rates: DVector<f64>,
    columns: DMatrix<f64>,
}

fn varpro(times: &[f64], trace: &[f64]) -> f64 {
    let samples = times.len();
    let mut model = Separable {
        times: DVector::from_column_slice(times),
        rates: DVector::zeros(2),
        columns: DMatrix::from_element(samples, 3, 1.0),
    };
    let start = DVector::from_vec(vec![START[3], START[4]]);
    model.set_params(start).unwrap_or_else(|error| match error {});
    let problem = SeparableProblemBuilder::new(model)
        .observations(DVector::from_column_slice(trace))
        .build()
        .expect("lengths agree");
    // A fit that fails is one whose sum of squares is not known.
    LevMarSolver::default()
        .solve(problem)
        .map_or(f64::NAN, |fit| 2.0 * fit.minimization_report.objective_function)
}

impl SeparableNonlinearModel for Separable {
    type ScalarType = f64;
    type Error = Infallible;

    fn parameter_count(&self) -> usize {
        2
    }

    fn base_function_count(&self) -> usize {
        3
    }

    fn output_len(&self) -> usize {
        self.times.len()
    }

    fn set_params(&mut self, rates: DVector<f64>) -> Result<(), Infallible> {
        for column in 0..2 {
            for (k, t) in self.times.iter().enumerate() {
                self.columns[(k, column)] = (-rates[column] * t).exp();
            }
        }
        self.rates = rates;
        Ok(())
    }

    fn params(&self) -> DVector<f64> {
        self.rates.clone()
    }

    fn eval(&self) -> Result<DMatrix<f64>, Infallible> {
        Ok(self.columns.clone())
    }

    fn eval_partial_deriv(&self, rate: usize) -> Result<DMatrix<f64>, Infallible> {
        let mut derivative = DMatrix::zeros(self.times.len(), 3);
        for (k, t) in self.times.iter().enumerate() {
            derivative[(k, rate)] = -t * self.columns[(k, rate)];
        }
        Ok(derivative)
    }
}
