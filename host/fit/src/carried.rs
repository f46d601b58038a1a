//! Derivatives of a linear base law, carried along in the pass that predicts.
//!
//! With the elastic response u = (x/X)^(q+1) at a reference compression X, branch forces Pi and
//! yi' = −vi yi + u', the force is F = P0 u + Σ Pi yi. So ∂F/∂P0 = u, ∂F/∂Pi = yi, ∂F/∂q = P0 u_q + Σ Pi wi
//! with u_q = u ln(x/X) and wi' = −vi wi + u_q', and ∂F/∂ln vi = Pi zi with zi = ∂yi/∂ln vi, which steps as
//! exactly as yi does. Where the memory acts on the strain, yi follows x and F is u/x times their sum.

use super::coordinates::Coordinates;
use palpate_model::{Chain, Coordinate, Elastic, Form, Hereditary, MAX_TERMS, Separation};

/// A linear base law at a point of the search.
#[derive(Clone, Debug)]
pub struct Carried {
    form: Form,
    bonded: bool,
    reference: f64,
    /// q + 1.
    exponent: f64,
    /// Force of each branch at the reference compression, N; the equilibrium is branch 0.
    forces: [f64; MAX_TERMS + 1],
    /// Part of all force that the equilibrium has, where that is given.
    equilibrium: Option<f64>,
    rates: [f64; MAX_TERMS],
    /// Damping, N·s/mm.
    damping: f64,
    terms: usize,
}

/// What a linear law remembers from stretch to stretch, with its derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memory {
    driven: f64,
    driven_q: f64,
    branches: [Branch; MAX_TERMS],
}

/// State of a branch, and its derivatives by q and by the logarithm of its rate.
#[derive(Clone, Copy, Debug, Default)]
struct Branch {
    y: f64,
    by_q: f64,
    by_rate: f64,
}

/// Decay and gain of a branch over an interval, and their derivatives by the logarithm of its rate.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    decay: f64,
    gain: f64,
    decay_by_rate: f64,
    gain_by_rate: f64,
}

/// One stretch as a linear law sees it.
#[derive(Clone, Copy, Debug)]
pub struct Stretch<'a> {
    /// Time of each sample, s.
    pub time: &'a [f64],
    /// Compression, mm.
    pub x: &'a [f64],
    /// ln(x/X) where x > 0.
    pub logarithm: &'a [f64],
    /// Rest since the stretch before, s; none where the specimen has forgotten all.
    pub rest: Option<f64>,
}

/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;
/// Compression, mm, below which the ratio u/x is not formed.
const TOUCHING: f64 = 1e-9;
/// Samples that are kept at hand before their derivatives are written, column by column.
const BLOCK: usize = 128;

/// ln(x/X) at every compression x > 0, mm; 0 off the specimen.
pub fn logarithms(x: &[f64], reference: f64, into: &mut Vec<f64>) {
    into.clear();
    into.extend(x.iter().map(|&x| if x > 0.0 { (x / reference).ln() } else { 0.0 }));
}

impl Carried {
    /// The base law of a chain at a point; none where it is not linear in its memory, where contact breaks
    /// by the state of the memory, or where an effect acts within it.
    #[must_use]
    pub fn new(chain: &Chain, coordinates: &Coordinates, point: &[f64]) -> Option<Self> {
        let law = chain.base;
        let exponentials = law.kernel.is_exponentials() && law.elastic == Elastic::POWER;
        if !exponentials || !chain.leaves_base_alone() || law.separation == Separation::Free {
            return None;
        }
        let response = law.response(&coordinates.declared(&point[..coordinates.count()]));
        let linear = Hereditary {
            viscosity: response.hereditary.viscosity,
            ..Hereditary::linear(response.hereditary.branches.clone(), law.separation)
        };
        if response.hereditary != linear || response.form == Form::Compression {
            return None;
        }
        let mut carried = Self {
            form: response.form,
            bonded: law.separation == Separation::Bonded,
            reference: coordinates.reference(),
            exponent: law.family.shape + 1.0,
            forces: [0.0; MAX_TERMS + 1],
            equilibrium: None,
            rates: [0.0; MAX_TERMS],
            damping: 0.0,
            terms: response.hereditary.branches.len(),
        };
        for (coordinate, &value) in coordinates.list().iter().zip(point) {
            match *coordinate {
                Coordinate::Force(branch) => carried.forces[branch] = value,
                Coordinate::Total => {
                    let part = 1.0 / f64::from(law.segments?);
                    carried.equilibrium = Some(part);
                    carried.forces[..2].copy_from_slice(&[part * value, (1.0 - part) * value]);
                }
                Coordinate::Shape => carried.exponent = value + 1.0,
                Coordinate::Rate(branch) => carried.rates[branch - 1] = value.exp(),
                Coordinate::Damping => carried.damping = value,
                _ => return None,
            }
        }
        Some(carried)
    }

    /// Predicts the force, N, over a stretch into `force`, and the derivative by each coordinate `wanted`
    /// into its column.
    pub fn run(
        &self,
        stretch: Stretch,
        memory: &mut Memory,
        force: &mut Vec<f64>,
        wanted: &[Coordinate],
        columns: &mut [Vec<f64>],
    ) {
        match self.terms {
            0 => self.pass::<0>(stretch, memory, force, wanted, columns),
            1 => self.pass::<1>(stretch, memory, force, wanted, columns),
            2 => self.pass::<2>(stretch, memory, force, wanted, columns),
            3 => self.pass::<3>(stretch, memory, force, wanted, columns),
            _ => self.pass::<MAX_TERMS>(stretch, memory, force, wanted, columns),
        }
    }

    fn pass<const N: usize>(
        &self,
        stretch: Stretch,
        memory: &mut Memory,
        force: &mut Vec<f64>,
        wanted: &[Coordinate],
        columns: &mut [Vec<f64>],
    ) {
        let count = stretch.time.len();
        force.clear();
        force.reserve(count);
        for column in columns.iter_mut() {
            column.clear();
            column.reserve(count);
        }
        let mut branches: [Branch; N] = std::array::from_fn(|k| memory.branches[k]);
        match stretch.rest {
            Some(rest) => self.rest(rest, &mut branches),
            None => (*memory, branches) = (Memory::default(), [Branch::default(); N]),
        }
        let (mut driven, mut driven_q) = (memory.driven, memory.driven_q);
        // The first sample is reached at once: a step of no time.
        let mut steps = [Step { decay: 1.0, gain: 1.0, ..Step::default() }; N];
        let (mut before, mut interval) = (f64::NAN, f64::NAN);
        let mut rows = [Row::<N>::NONE; BLOCK];
        for begin in (0..count).step_by(BLOCK) {
            let end = (begin + BLOCK).min(count);
            for (k, row) in (begin..end).zip(&mut rows) {
                let sample = self.sample(stretch.x[k], stretch.logarithm[k]);
                let (change, change_q) = (sample.drive - driven, sample.drive_q - driven_q);
                (driven, driven_q) = (sample.drive, sample.drive_q);
                let now = stretch.time[k] - before;
                before = stretch.time[k];
                let same = (now - interval).abs() <= SAME_INTERVAL * now;
                if k > 0 && !same {
                    interval = now;
                    steps = std::array::from_fn(|branch| Step::new(self.rates[branch] * now));
                }
                let mut sum = self.forces[0] * sample.drive;
                let mut by_q = self.forces[0] * sample.drive_q;
                for ((branch, step), force) in
                    branches.iter_mut().zip(&steps).zip(&self.forces[1..])
                {
                    branch.by_rate = branch.by_rate * step.decay
                        + step.decay_by_rate * branch.y
                        + step.gain_by_rate * change;
                    branch.y = branch.y * step.decay + step.gain * change;
                    branch.by_q = branch.by_q * step.decay + step.gain * change_q;
                    sum += force * branch.y;
                    by_q += force * branch.by_q;
                }
                // A damper beside the spring follows the speed at which the contact is pressed.
                let speed = if k > 0 { self.reference * change / now } else { 0.0 };
                sum += self.damping * speed;
                // Contact breaks at zero force, and what does not touch has no derivative.
                let held = if self.bonded || sum > 0.0 { 1.0 } else { 0.0 };
                let factor = held * sample.factor;
                force.push(factor * sum);
                *row = Row {
                    factor,
                    drive: sample.drive,
                    by_q: factor * (by_q + sample.factor_q * sum),
                    speed: held * speed,
                    y: branches.map(|branch| branch.y),
                    by_rate: branches.map(|branch| branch.by_rate),
                };
            }
            for (column, coordinate) in columns.iter_mut().zip(wanted) {
                self.fill(*coordinate, &rows[..end - begin], column);
            }
        }
        (memory.driven, memory.driven_q) = (driven, driven_q);
        memory.branches[..N].copy_from_slice(&branches);
    }

    /// The derivative by one coordinate at these samples.
    fn fill<const N: usize>(&self, by: Coordinate, rows: &[Row<N>], column: &mut Vec<f64>) {
        match by {
            Coordinate::Force(0) => column.extend(rows.iter().map(|row| row.factor * row.drive)),
            Coordinate::Force(k) => column.extend(rows.iter().map(|row| row.factor * row.y[k - 1])),
            Coordinate::Total => {
                let part = self.equilibrium.unwrap_or(1.0);
                let sum = |row: &Row<N>| part * row.drive + (1.0 - part) * row.y[0];
                column.extend(rows.iter().map(|row| row.factor * sum(row)));
            }
            Coordinate::Shape => column.extend(rows.iter().map(|row| row.by_q)),
            Coordinate::Rate(k) => {
                let force = self.forces[k];
                column.extend(rows.iter().map(|row| row.factor * force * row.by_rate[k - 1]));
            }
            Coordinate::Damping => column.extend(rows.iter().map(|row| row.speed)),
            Coordinate::Power | Coordinate::Order => column.extend(rows.iter().map(|_| 0.0)),
        }
    }

    /// What one sample drives the memory by, and what its answer is multiplied by.
    fn sample(&self, x: f64, logarithm: f64) -> Sample {
        let u = if x > 0.0 { (self.exponent * logarithm).exp() } else { 0.0 };
        match self.form {
            Form::Strain => Sample {
                drive: if self.bonded { x } else { x.max(0.0) },
                drive_q: 0.0,
                factor: if x > TOUCHING { u / x } else { 0.0 },
                factor_q: logarithm,
            },
            _ => Sample { drive: u, drive_q: u * logarithm, factor: 1.0, factor_q: 0.0 },
        }
    }

    /// Lets the specimen rest between two stretches.
    fn rest(&self, seconds: f64, branches: &mut [Branch]) {
        for (branch, rate) in branches.iter_mut().zip(&self.rates) {
            let turns = rate * seconds;
            let decay = (-turns).exp();
            branch.by_rate = decay * (branch.by_rate - turns * branch.y);
            branch.y *= decay;
            branch.by_q *= decay;
        }
    }
}

/// What the derivatives at one sample are made of.
#[derive(Clone, Copy)]
struct Row<const N: usize> {
    factor: f64,
    drive: f64,
    by_q: f64,
    speed: f64,
    y: [f64; N],
    by_rate: [f64; N],
}

impl<const N: usize> Row<N> {
    const NONE: Self =
        Self { factor: 0.0, drive: 0.0, by_q: 0.0, speed: 0.0, y: [0.0; N], by_rate: [0.0; N] };
}

/// See [`Carried::sample`].
struct Sample {
    drive: f64,
    /// Its derivative by q.
    drive_q: f64,
    factor: f64,
    /// Derivative by q of the logarithm of the factor.
    factor_q: f64,
}

impl Step {
    /// Over `turns` times the branch's own time.
    fn new(turns: f64) -> Self {
        let decay = (-turns).exp();
        // (1 − e^(−s))/s, and its derivative by ln s; the series where the difference would cancel.
        let gain = if turns < 1e-5 {
            1.0 - turns * (0.5 - turns / 6.0)
        } else {
            -(-turns).exp_m1() / turns
        };
        let gain_by_rate = if turns < 1e-3 {
            turns * (-0.5 + turns * (1.0 / 3.0 - turns * (0.125 - turns / 30.0)))
        } else {
            decay - gain
        };
        Self { decay, gain, decay_by_rate: -turns * decay, gain_by_rate }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Data;
    use crate::least_squares::LeastSquares;
    use crate::problem::Problem;
    use crate::whitening::Whitening;
    use palpate_model::{BaseLaw, Family};
    use palpate_trace::{Column, DISPLACEMENT, FORCE, Trace};

    /// Two presses with a hold, the second after a rest, sampled unevenly.
    fn traces() -> Vec<Trace> {
        [0.0, 9.0]
            .into_iter()
            .map(|start| {
                let time: Vec<f64> =
                    (0..300).map(|k| 0.02 * f64::from(k) + 1e-3 * f64::from(k % 3)).collect();
                let course = |t: &f64| (4.0 * t - 1.0).min(3.0).min(24.0 - 5.0 * t) + 0.02 * start;
                let x: Vec<f64> = time.iter().map(course).collect();
                let force = x.iter().map(|x: &f64| 0.3 * x.max(0.0).powf(1.5)).collect();
                let mut trace = Trace {
                    time,
                    columns: vec![
                        Column { name: DISPLACEMENT.into(), values: x },
                        Column { name: FORCE.into(), values: force },
                    ],
                    ..Trace::default()
                };
                trace.head.setup.start_s = Some(start);
                trace
            })
            .collect()
    }

    /// Every linear law, with its options.
    fn laws() -> Vec<BaseLaw> {
        let separations = [Separation::Clamp, Separation::Bonded];
        let mut laws = Vec::new();
        for separation in separations {
            for family in [Family::KELVIN_VOIGT, Family::MAXWELL, Family::LATENCY] {
                laws.push(BaseLaw::new(family, 1, separation));
            }
            for terms in 1..=MAX_TERMS {
                laws.push(BaseLaw::fung(terms, separation));
                laws.push(BaseLaw::new(Family::GENERALIZED_MAXWELL, terms, separation));
            }
            laws.push(BaseLaw {
                segments: Some(8),
                ..BaseLaw::new(Family::LATENCY, 1, separation)
            });
        }
        laws
    }

    fn point_of(coordinates: &Coordinates) -> Vec<f64> {
        let value = |coordinate: &Coordinate| match *coordinate {
            Coordinate::Force(branch) => 0.7 + 0.3 * branch as f64,
            Coordinate::Rate(branch) => 2.0 - 1.1 * branch as f64,
            Coordinate::Shape => 0.6,
            _ => 0.8,
        };
        coordinates.list().iter().map(value).collect()
    }

    #[test]
    fn every_derivative_is_that_of_the_law_itself() {
        let traces = traces();
        let data = Data::of(&traces, FORCE).unwrap();
        let white = Whitening::none();
        for law in laws() {
            let chain = Chain::new(law);
            let problem = Problem::new(&chain, &data, &white, None);
            let point = point_of(problem.coordinates());
            assert!(Carried::new(&chain, problem.coordinates(), &point).is_some());
            let predicted = problem.predict(&point);
            let at = |j: usize, step: f64| {
                let mut moved = point.clone();
                moved[j] += step;
                problem.predict(&moved)
            };
            let slopes: Vec<_> = (0..point.len()).map(|j| (at(j, -1e-5), at(j, 1e-5))).collect();
            let mut piece_index = 0;
            problem.derivatives(&point, |piece, residual, columns| {
                assert_eq!(columns.len(), point.len());
                for (k, r) in residual.iter().enumerate() {
                    let force = predicted[piece_index][k];
                    assert!((r + piece.measured[k] - force).abs() < 1e-12, "{}", law.in_words());
                    for (j, column) in &columns {
                        let (below, above) = &slopes[*j];
                        let (below, above) = (below[piece_index][k], above[piece_index][k]);
                        // Where contact breaks between the two, the difference means nothing.
                        if law.separation == Separation::Clamp && (below == 0.0 || above == 0.0) {
                            continue;
                        }
                        let expected = (above - below) / 2e-5;
                        assert!(
                            (column[k] - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                            "{} coordinate {j} sample {k}: {} for {expected}",
                            law.in_words(),
                            column[k]
                        );
                    }
                }
                piece_index += 1;
            });
            let cost: f64 = problem.trace_squares(&point).iter().map(|(sum, _)| sum).sum();
            assert!((problem.cost(&point) - cost).abs() < 1e-12 * cost);
            assert!((problem.normal(&point).cost - cost).abs() < 1e-12 * cost);
        }
    }

    #[test]
    fn what_is_not_linear_is_left_to_differences() {
        for law in [
            BaseLaw::fung(2, Separation::Free),
            BaseLaw::new(Family::CREEP, 2, Separation::Clamp),
            BaseLaw {
                exponent: Some(3.0),
                ..BaseLaw::new(Family::LATENCY_POWER, 1, Separation::Clamp)
            },
        ] {
            let coordinates = Coordinates::new(law, 3.0);
            let point = point_of(&coordinates);
            assert!(Carried::new(&Chain::new(law), &coordinates, &point).is_none());
        }
    }

    #[test]
    fn the_derivative_of_the_gain_has_no_seam() {
        for turns in [9e-4, 1.1e-3, 0.02, 3.0] {
            let step = |by: f64| Step::new(turns * f64::exp(by)).gain;
            let expected = (step(1e-4) - step(-1e-4)) / 2e-4;
            let found = Step::new(turns).gain_by_rate;
            assert!((found - expected).abs() < 1e-8 * turns, "{found} for {expected}");
        }
    }
}
