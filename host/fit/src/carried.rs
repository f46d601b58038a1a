//! Derivatives of a linear base law, carried along in the pass that predicts.
//!
//! With the elastic response u = (x/X)^(q+1) at a reference compression X, branch forces Pi and
//! yi' = −vi yi + u', the force is F = P0 u + Σ Pi yi. So ∂F/∂P0 = u, ∂F/∂Pi = yi, ∂F/∂q = P0 u_q + Σ Pi wi
//! with u_q = u ln(x/X) and wi' = −vi wi + u_q', and ∂F/∂ln vi = Pi zi with zi = ∂yi/∂ln vi, which steps as
//! exactly as yi does. Where the memory acts on the strain, yi follows x and F is u/x times their sum.

use super::columns::{BLOCK, Column, Products};
use super::coordinates::Coordinates;
use super::many_exp::exp;
use palpate_model::{Chain, Coordinate, Elastic, Form, Hereditary, MAX_TERMS, Separation};

/// A linear base law at a point of the search.
#[derive(Clone, Debug)]
pub struct Carried {
    form: Form,
    separation: Separation,
    reference: f64,
    /// q + 1.
    exponent: f64,
    /// Force of each branch at the reference compression, N; the equilibrium is branch 0.
    forces: [f64; MAX_TERMS + 1],
    /// Part of all force that the equilibrium has, where that is given.
    equilibrium: Option<f64>,
    rates: [f64; MAX_TERMS],
    /// Damping, N·s/mm; none where the law has no damper.
    damping: Option<f64>,
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
    /// ln(|x|/X) where x is not 0.
    pub logarithm: &'a [f64],
    /// Rest since the stretch before, s; none where the specimen has forgotten all.
    pub rest: Option<f64>,
}

/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;
/// Compression, mm, below which the ratio u/x is not formed.
const TOUCHING: f64 = 1e-9;
/// Turns below which the gain of a branch is summed up as a series, and 1/(k+1)! from the highest power on that counts there.
const SHORT: f64 = 0.1;
const GAIN: [f64; 10] = [
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
    1.0,
];
/// Most coordinates of a law.
const MOST: usize = 2 * MAX_TERMS + 3;

/// ln(|x|/X) at every displacement x, mm; 0 where it is 0.
pub fn logarithms(x: &[f64], reference: f64, into: &mut Vec<f64>) {
    into.clear();
    into.extend(x.iter().map(|&x| if x == 0.0 { 0.0 } else { (x.abs() / reference).ln() }));
}

/// What was measured over a stretch.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// The signal at each sample.
    pub signal: &'a [f64],
    /// By what the residual of each sample is multiplied; empty where by one.
    pub roots: &'a [f64],
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
            damper: response.hereditary.damper,
            ..Hereditary::linear(response.hereditary.branches.clone(), law.separation)
        };
        if response.hereditary != linear || response.form == Form::Compression {
            return None;
        }
        let mut carried = Self {
            form: response.form,
            separation: law.separation,
            reference: coordinates.reference(),
            exponent: law.family.shape + 1.0,
            forces: [0.0; MAX_TERMS + 1],
            equilibrium: None,
            rates: [0.0; MAX_TERMS],
            damping: None,
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
                Coordinate::Damping => carried.damping = Some(value),
                _ => return None,
            }
        }
        Some(carried)
    }

    /// Predicts the force, N, over a stretch into `force`.
    pub fn predict(&self, stretch: Stretch, memory: &mut Memory, force: &mut Vec<f64>) {
        force.clear();
        force.reserve(stretch.time.len());
        self.blocks::<false>(stretch, memory, |rows| {
            force.extend_from_slice(&rows.force.0[..rows.len]);
        });
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
        let count = stretch.time.len();
        for column in columns.iter_mut().chain([&mut *force]) {
            column.clear();
            column.reserve(count);
        }
        let mut filled = Column::ZERO;
        self.blocks::<true>(stretch, memory, |rows| {
            force.extend_from_slice(&rows.force.0[..rows.len]);
            for (column, coordinate) in columns.iter_mut().zip(wanted) {
                self.fill(*coordinate, rows, &mut filled);
                column.extend_from_slice(&filled.0[..rows.len]);
            }
        });
    }

    /// Adds the products of the derivatives by the coordinates `wanted`, and last of the residual (predicted minus measured), over a
    /// stretch: nothing is written down but a block of samples.
    pub fn add_products(
        &self,
        stretch: Stretch,
        memory: &mut Memory,
        measured: Measured,
        wanted: &[Coordinate],
        products: &mut Products,
    ) {
        let mut columns = [Column::ZERO; MOST + 1];
        let columns = &mut columns[..=wanted.len()];
        let mut begin = 0;
        self.blocks::<true>(stretch, memory, |rows| {
            let range = begin..begin + rows.len;
            begin = range.end;
            let (derivatives, residual) = columns.split_at_mut(wanted.len());
            let residual = &mut residual[0];
            residual.0[rows.len..].fill(0.0);
            let pairs = rows.force.0.iter().zip(&measured.signal[range.clone()]);
            for (residual, (force, signal)) in residual.0.iter_mut().zip(pairs) {
                *residual = force - signal;
            }
            let roots = measured.roots.get(range).unwrap_or_default();
            weigh(residual, roots);
            // What does not touch has no derivative.
            if rows.factor.0.iter().all(|factor| *factor == 0.0) {
                products.add_to_last(residual.0.iter().map(|r| r * r).sum());
                return;
            }
            for (column, coordinate) in derivatives.iter_mut().zip(wanted) {
                self.fill(*coordinate, rows, column);
                weigh(column, roots);
            }
            products.add(columns);
        });
    }

    /// Runs over a stretch, block by block; with `SLOPES` the derivatives come along.
    fn blocks<const SLOPES: bool>(
        &self,
        stretch: Stretch,
        memory: &mut Memory,
        sink: impl FnMut(&Rows),
    ) {
        match self.terms {
            0 => self.pass::<0, SLOPES>(stretch, memory, sink),
            1 => self.pass::<1, SLOPES>(stretch, memory, sink),
            2 => self.pass::<2, SLOPES>(stretch, memory, sink),
            3 => self.pass::<3, SLOPES>(stretch, memory, sink),
            _ => self.pass::<MAX_TERMS, SLOPES>(stretch, memory, sink),
        }
    }

    fn pass<const N: usize, const SLOPES: bool>(
        &self,
        stretch: Stretch,
        memory: &mut Memory,
        mut sink: impl FnMut(&Rows),
    ) {
        let count = stretch.time.len();
        let mut branches: [Branch; N] = std::array::from_fn(|k| memory.branches[k]);
        match stretch.rest {
            Some(rest) => self.rest(rest, &mut branches),
            None => (*memory, branches) = (Memory::default(), [Branch::default(); N]),
        }
        let (mut driven, mut driven_q) = (memory.driven, memory.driven_q);
        // The first sample is reached at once: a step of no time.
        let mut steps = [Step { decay: 1.0, gain: 1.0, ..Step::default() }; N];
        let (mut before, mut interval) = (f64::NAN, f64::NAN);
        let mut rows = Rows::ZERO;
        let (mut drives, mut ahead) = (Drives::ZERO, Drives::ZERO);
        for begin in (0..count).step_by(BLOCK) {
            let end = (begin + BLOCK).min(count);
            rows.len = end - begin;
            self.drives(&stretch.x[begin..end], &stretch.logarithm[begin..end], &mut drives);
            if self.damping.is_some() && end < count {
                self.drives(&stretch.x[end..=end], &stretch.logarithm[end..=end], &mut ahead);
            }
            for (k, &time) in stretch.time[begin..end].iter().enumerate() {
                let now = time - before;
                before = time;
                let same = (now - interval).abs() <= SAME_INTERVAL * now;
                let first = begin + k == 0;
                if !same && !first {
                    interval = now;
                    steps = std::array::from_fn(|branch| Step::new(self.rates[branch] * now));
                }
                let (drive, drive_q) = (drives.drive.0[k], drives.drive_q.0[k]);
                let (change, change_q) = (drive - driven, drive_q - driven_q);
                (driven, driven_q) = (drive, drive_q);
                let mut sum = self.forces[0] * drive;
                let mut by_q = self.forces[0] * drive_q;
                for branch in 0..N {
                    let (state, step) = (&mut branches[branch], &steps[branch]);
                    if SLOPES {
                        state.by_rate = state.by_rate * step.decay
                            + (step.decay_by_rate * state.y + step.gain_by_rate * change);
                        state.by_q = state.by_q * step.decay + step.gain * change_q;
                        by_q += self.forces[branch + 1] * state.by_q;
                        rows.by_rate[branch].0[k] = state.by_rate;
                    }
                    state.y = state.y * step.decay + step.gain * change;
                    sum += self.forces[branch + 1] * state.y;
                    rows.y[branch].0[k] = state.y;
                }
                // A damper beside the spring follows the speed at which the contact is pressed, as in a run of the model.
                let mut speed = 0.0;
                if let Some(damping) = self.damping.filter(|_| !first) {
                    let within = drives.drive.0[..rows.len].get(k + 1);
                    let ahead = within.unwrap_or(&ahead.drive.0[0]);
                    let next = stretch.time.get(begin + k + 1);
                    let next = next.map(|next| (next - time, ahead - drive));
                    speed = self.reference * palpate_model::speed((now, change), next);
                    sum += damping * speed;
                }
                // Contact breaks at zero force, and what does not touch has no derivative.
                let held =
                    if sum > 0.0 || self.separation == Separation::Bonded { 1.0 } else { 0.0 };
                let factor = held * drives.factor.0[k];
                rows.factor.0[k] = factor;
                rows.force.0[k] = factor * sum;
                if SLOPES {
                    rows.by_q.0[k] = factor * (by_q + drives.factor_q.0[k] * sum);
                    rows.speed.0[k] = held * speed;
                }
            }
            rows.end();
            rows.drive = drives.drive;
            sink(&rows);
        }
        (memory.driven, memory.driven_q) = (driven, driven_q);
        memory.branches[..N].copy_from_slice(&branches);
    }

    /// The derivative by one coordinate at the samples of a block.
    #[inline]
    fn fill(&self, by: Coordinate, rows: &Rows, column: &mut Column) {
        let mut times = |factor: f64, of: &Column| {
            let pairs = rows.factor.0.iter().zip(&of.0);
            for (value, (held, of)) in column.0.iter_mut().zip(pairs) {
                *value = factor * (held * of);
            }
        };
        match by {
            Coordinate::Force(0) => times(1.0, &rows.drive),
            Coordinate::Force(k) => times(1.0, &rows.y[k - 1]),
            Coordinate::Total => {
                let part = self.equilibrium.unwrap_or(1.0);
                let both = rows.drive.0.iter().zip(&rows.y[0].0);
                let mut sum = Column::ZERO;
                for (sum, (drive, y)) in sum.0.iter_mut().zip(both) {
                    *sum = part * drive + (1.0 - part) * y;
                }
                times(1.0, &sum);
            }
            Coordinate::Shape => *column = rows.by_q,
            Coordinate::Rate(k) => times(self.forces[k], &rows.by_rate[k - 1]),
            Coordinate::Damping => *column = rows.speed,
            Coordinate::Power | Coordinate::Order => *column = Column::ZERO,
        }
    }

    /// What the samples of a block drive the memory by, and what its answer is multiplied by.
    fn drives(&self, x: &[f64], logarithm: &[f64], drives: &mut Drives) {
        let mut u = Column::ZERO;
        let felt = |x: f64| self.separation.felt(x);
        // Off the specimen there is nothing to do.
        if x.iter().any(|&x| felt(x) != 0.0) {
            for (u, (&x, &logarithm)) in u.0.iter_mut().zip(x.iter().zip(logarithm)) {
                let power = exp(self.exponent * logarithm).copysign(x);
                *u = if felt(x) != 0.0 { power } else { 0.0 };
            }
        }
        match self.form {
            Form::Strain => {
                for (k, (&x, &logarithm)) in x.iter().zip(logarithm).enumerate() {
                    drives.drive.0[k] = felt(x);
                    drives.factor.0[k] = if x.abs() > TOUCHING { u.0[k] / x } else { 0.0 };
                    drives.factor_q.0[k] = logarithm;
                }
            }
            _ => {
                drives.drive = u;
                for (by_q, (u, logarithm)) in
                    drives.drive_q.0.iter_mut().zip(u.0.iter().zip(logarithm))
                {
                    *by_q = u * logarithm;
                }
            }
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

/// Multiplies the samples of a block by these roots; by one where there are none.
fn weigh(column: &mut Column, roots: &[f64]) {
    for (value, root) in column.0.iter_mut().zip(roots) {
        *value *= root;
    }
}

/// What the derivatives at the samples of a block are made of; zero where it has no more samples.
struct Rows {
    len: usize,
    force: Column,
    factor: Column,
    drive: Column,
    by_q: Column,
    speed: Column,
    y: [Column; MAX_TERMS],
    by_rate: [Column; MAX_TERMS],
}

impl Rows {
    const ZERO: Self = Self {
        len: 0,
        force: Column::ZERO,
        factor: Column::ZERO,
        drive: Column::ZERO,
        by_q: Column::ZERO,
        speed: Column::ZERO,
        y: [Column::ZERO; MAX_TERMS],
        by_rate: [Column::ZERO; MAX_TERMS],
    };

    /// Makes all derivatives zero where there are no more samples.
    fn end(&mut self) {
        for column in [&mut self.factor, &mut self.by_q, &mut self.speed] {
            column.0[self.len..].fill(0.0);
        }
    }
}

/// What the samples of a block drive the memory by, and what its answer is multiplied by.
struct Drives {
    drive: Column,
    /// Derivative of the drive by q.
    drive_q: Column,
    factor: Column,
    /// Derivative by q of the logarithm of the factor.
    factor_q: Column,
}

impl Drives {
    const ZERO: Self = Self {
        drive: Column::ZERO,
        drive_q: Column::ZERO,
        factor: Column([1.0; BLOCK]),
        factor_q: Column::ZERO,
    };
}

impl Step {
    /// Over `turns` times the branch's own time.
    fn new(turns: f64) -> Self {
        // (1 − e^(−s))/s, and its derivative by ln s; the series where the difference would cancel.
        let (decay, gain) = if turns < SHORT {
            let gain = GAIN.iter().fold(0.0, |sum, term| term - turns * sum);
            (1.0 - turns * gain, gain)
        } else {
            let decay = exp(-turns);
            (decay, (1.0 - decay) / turns)
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
