//! Several soft contacts that hold one object: the forces that balance a load.
//!
//! A contact presses with N ≥ 0 and carries a tangential force and a moment about its normal within its limit
//! surface, μN times a convex body. What all of them together can do to the object is convex too, so the least
//! grip forces, and the largest load, are convex programmes; [`clarabel`] solves them.
//!
//! The limit surface is no cone that a solver knows. In units in which the largest moment counts like the
//! largest force it is close to a ball, and its gauge φ (the share of the contact in use, for μN = 1) is smooth:
//! φ² is taken for yᵀMy, which has value and slope of φ² where the last solution was, and learns its curvature
//! from one solution to the next (BFGS). A solution at which φ² is what it was taken for solves the true
//! problem. That it does is certified by another bound: each solution gives planes beside which no limit
//! surface goes (the motions that give way first), and with these alone the problem can only be easier.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, Matrix3, Vector3};

use super::contact::{Contact, Load, Motion};
use super::margin::margin;

/// Force, N, and moment about the origin, N mm, on the object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force, N.
    pub force: [f64; 3],
    /// Moment about the origin, N mm.
    pub moment: [f64; 3],
}

impl Wrench {
    /// The wrench so many times.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self {
            force: self.force.map(|part| factor * part),
            moment: self.moment.map(|part| factor * part),
        }
    }

    /// Both together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            force: std::array::from_fn(|k| self.force[k] + other.force[k]),
            moment: std::array::from_fn(|k| self.moment[k] + other.moment[k]),
        }
    }
}

/// Where a contact is on the object, mm, and how it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The middle of the contact.
    pub position: Vector3<f64>,
    /// Axis x of the contact, y, and the normal, which points into the object: of unit length, at right angles
    /// and right-handed.
    pub axes: [Vector3<f64>; 3],
}

/// A direction that cannot be: of no length, or along the normal.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// The normal has no length.
    #[error("the normal has no length")]
    Normal,
    /// The axis has no length across the normal.
    #[error("the axis x of the contact must have a part across the normal")]
    Axis,
}

impl Pose {
    /// At a place, mm, with a normal into the object. The axis x is the part across the normal of what is
    /// given, and without any of that coordinate axis which lies most across.
    ///
    /// # Errors
    /// [`PoseError`].
    pub fn new(
        position: [f64; 3],
        normal: [f64; 3],
        along: Option<[f64; 3]>,
    ) -> Result<Self, PoseError> {
        let normal = Vector3::from(normal);
        let normal = normal.try_normalize(MIN_LENGTH).ok_or(PoseError::Normal)?;
        let along = along.map_or_else(|| Vector3::ith(normal.iamin(), 1.0), Vector3::from);
        let across = along - normal * normal.dot(&along);
        let x = across.try_normalize(MIN_LENGTH * along.norm().max(1.0)).ok_or(PoseError::Axis)?;
        Ok(Self { position: position.into(), axes: [x, normal.cross(&x), normal] })
    }

    /// What the finger does to the object with a normal force, N, and a load within the contact.
    #[must_use]
    pub fn wrench(&self, normal: f64, load: &Load) -> Wrench {
        let [x, y, n] = self.axes;
        let force = n * normal + x * load.force[0] + y * load.force[1];
        let moment = self.position.cross(&force) + n * load.moment;
        Wrench { force: force.into(), moment: moment.into() }
    }
}

/// Lengths below this, of those given, are none.
const MIN_LENGTH: f64 = 1e-9;

/// One contact of a grasp.
#[derive(Clone, Debug)]
pub struct Touch {
    /// Where it is.
    pub pose: Pose,
    /// Its shape and pressure.
    pub contact: Contact,
    /// Coefficient of friction μ, above 0.
    pub friction: f64,
    /// Largest normal force, N; may be infinite.
    pub most: f64,
}

/// What one contact does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Normal force, N.
    pub normal: f64,
    /// What it does to the object across the normal.
    pub load: Load,
    /// Share of what it could carry that is in use: slip at 1. Not a number where it does not press.
    pub used: f64,
}

/// What is made least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Least {
    /// The sum of the normal forces.
    Sum,
    /// The largest normal force.
    Largest,
}

/// Forces that balance a load.
#[derive(Clone, Debug, PartialEq)]
pub struct Balance {
    /// What was made least, N, or for [`largest_load`] the factor.
    pub value: f64,
    /// What it cannot be better than, by the planes beside the limit surfaces.
    pub bound: f64,
    /// What each contact does.
    pub shares: Vec<Share>,
}

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BalanceError {
    /// No forces of these contacts balance the load.
    #[error("no forces of these contacts balance the load")]
    Impossible,
    /// The load can be as large as one likes.
    #[error("the contacts carry this load however large it is")]
    Unlimited,
    /// The solver did not come to an end.
    #[error("the search for forces did not come to an end ({0:?})")]
    Unfinished(SolverStatus),
}

/// Whether a grasp can resist whatever comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// Rank of the grasp matrix: 6 where every wrench can be made of contact forces of any sign.
    pub rank: usize,
    /// Largest share of the friction, of a mean normal force of 1 N, that stays unused at every contact while
    /// all press and nothing else acts; above 0 with rank 6 the grasp is force-closed.
    pub reserve: f64,
}

impl Closure {
    /// Whether any wrench can be resisted by gripping hard enough.
    #[must_use]
    pub fn is_force_closed(&self) -> bool {
        self.rank == 6 && self.reserve > RESERVE
    }
}

/// A reserve below this is rounding.
const RESERVE: f64 = 1e-6;
/// Solutions at most before the planes alone go on.
const ROUNDS: usize = 25;
/// Solutions with planes alone at most.
const MOST_PLANES: usize = 300;
/// Relative difference of a gauge from what it was taken for, and of value and bound, that is none.
const TOLERANCE: f64 = 1e-8;
/// Tangential loads below this, of the friction, ask nothing of a limit surface.
const NO_LOAD: f64 = 1e-9;
/// A normal force below this, of the largest, is none.
const NO_PRESS: f64 = 1e-6;
/// Singular values below this, of the largest, are none.
const SINGULAR: f64 = 1e-9;

/// The least normal forces that balance a load, with every contact at most at 1/`margin` of its limit surface.
///
/// # Errors
/// [`BalanceError`].
pub fn least_grip(
    touches: &[Touch],
    load: &Wrench,
    margin: f64,
    least: Least,
) -> Result<Balance, BalanceError> {
    let size = size(load, length(touches));
    if size == 0.0 {
        let share = Share { normal: 0.0, load: Load::default(), used: f64::NAN };
        return Ok(Balance { value: 0.0, bound: 0.0, shares: vec![share; touches.len()] });
    }
    let ask =
        Ask { touches, load: load.times(size.recip()), unit: size, margin, aim: Aim::Grip(least) };
    ask.solve()
}

/// The factor by which a load could grow until these contacts, none pressing harder than it may, cannot balance
/// it any more.
///
/// # Errors
/// [`BalanceError`].
pub fn largest_load(touches: &[Touch], load: &Wrench) -> Result<Balance, BalanceError> {
    let size = size(load, length(touches));
    if size == 0.0 {
        return Err(BalanceError::Unlimited);
    }
    let grip = touches.iter().map(|touch| touch.most).filter(|most| most.is_finite());
    let unit = grip.fold(0.0, f64::max);
    if unit == 0.0 {
        return Err(if touches.iter().any(|t| t.most > 0.0) {
            BalanceError::Unlimited
        } else {
            BalanceError::Impossible
        });
    }
    let ask = Ask { touches, load: load.times(size.recip()), unit, margin: 1.0, aim: Aim::Load };
    let mut found = ask.solve()?;
    (found.value, found.bound) = (found.value / size, found.bound / size);
    Ok(found)
}

/// Whether the grasp is force-closed.
///
/// # Errors
/// [`BalanceError::Unfinished`].
pub fn closure(touches: &[Touch]) -> Result<Closure, BalanceError> {
    let scale = length(touches);
    let columns: Vec<_> = touches
        .iter()
        .flat_map(|touch| {
            let [x, y, n] = touch.pose.axes;
            let arm = touch.pose.position / scale;
            let force = |axis: Vector3<f64>| column(axis, arm.cross(&axis));
            [force(n), force(x), force(y), column(Vector3::zeros(), n)]
        })
        .collect();
    let singular = DMatrix::from_columns(&columns).singular_values();
    let largest = singular.iter().copied().fold(0.0, f64::max);
    let rank = singular.iter().filter(|value| **value > SINGULAR * largest).count();
    let ask = Ask { touches, load: Wrench::default(), unit: 1.0, margin: 1.0, aim: Aim::Reserve };
    let reserve = match ask.solve() {
        Ok(found) => found.value,
        Err(BalanceError::Impossible) => 0.0,
        Err(error) => return Err(error),
    };
    Ok(Closure { rank, reserve })
}

fn column(force: Vector3<f64>, moment: Vector3<f64>) -> nalgebra::DVector<f64> {
    nalgebra::DVector::from_iterator(6, force.iter().chain(moment.iter()).copied())
}

/// A length by which moments are made forces, mm.
fn length(touches: &[Touch]) -> f64 {
    let reach = |touch: &Touch| touch.pose.position.norm().max(touch.contact.arm());
    touches.iter().map(reach).fold(f64::MIN_POSITIVE, f64::max)
}

fn size(load: &Wrench, length: f64) -> f64 {
    let square =
        |parts: [f64; 3], unit: f64| parts.map(|part| (part / unit).powi(2)).iter().sum::<f64>();
    (square(load.force, 1.0) + square(load.moment, length)).sqrt()
}

/// What is looked for.
#[derive(Clone, Copy, Debug)]
enum Aim {
    /// Least normal forces for the load.
    Grip(Least),
    /// The largest multiple of the load.
    Load,
    /// The largest friction left over while nothing acts and the mean normal force is 1 N.
    Reserve,
}

/// A question to the solver. Unknowns are for each contact N, fx, fy and m over its arm, and last the aim's own.
struct Ask<'a> {
    touches: &'a [Touch],
    /// Of unit size.
    load: Wrench,
    /// Force that counts as 1, N.
    unit: f64,
    margin: f64,
    aim: Aim,
}

/// What a limit surface is taken for.
enum Surface<'a> {
    /// yᵀMy ≤ (μN)².
    Ellipsoid(&'a [Matrix3<f64>]),
    /// |f| ≤ μN, |m| ≤ μN arm, and planes: of which contact, and their normals.
    Planes(&'a [(usize, Vector3<f64>)]),
}

/// Tangential force and moment over the arm of a contact, of a solution.
fn tangential(solution: &[f64], touch: usize) -> Vector3<f64> {
    Vector3::new(solution[4 * touch + 1], solution[4 * touch + 2], solution[4 * touch + 3])
}

impl Ask<'_> {
    /// Solves the true problem between the two that are taken for it.
    fn solve(&self) -> Result<Balance, BalanceError> {
        let count = self.touches.len();
        let mut planes = Vec::new();
        let mut shapes = vec![Shape::default(); count];
        let mut best = None;
        for _ in 0..ROUNDS {
            let models: Vec<Matrix3<f64>> = shapes.iter().map(|shape| shape.model).collect();
            let Ok(solution) = self.programme(&Surface::Ellipsoid(&models)).solve() else { break };
            let mut off: f64 = 0.0;
            for (k, shape) in shapes.iter_mut().enumerate() {
                let y = tangential(&solution, k);
                if let Some(gauge) = self.gauge(k, &y, &solution) {
                    planes.push((k, gauge.slope));
                    off = off.max((gauge.value / y.dot(&(shape.model * y)).sqrt() - 1.0).abs());
                    shape.learn(&y, &gauge);
                }
            }
            if off <= TOLERANCE {
                best = Some(solution);
                break;
            }
        }
        let (bound, mut outer) = self.bound(&planes)?;
        if let Some(best) = best {
            let value = self.value(&best);
            if (value - bound).abs() <= 10.0 * TOLERANCE * value.abs().max(self.smallest()) {
                return Ok(self.balance(&best, bound));
            }
        }
        // Planes alone, as many as it takes.
        for _ in 0..MOST_PLANES {
            let mut off: f64 = 0.0;
            for k in 0..count {
                let y = tangential(&outer, k);
                if let Some(gauge) = self.gauge(k, &y, &outer) {
                    planes.push((k, gauge.slope));
                    let allowed = self.allowed(k, &outer);
                    off = off.max((gauge.value - allowed) / allowed.max(TOLERANCE));
                }
            }
            let bound = self.value(&outer);
            if off <= 10.0 * TOLERANCE {
                return Ok(self.balance(&outer, bound));
            }
            outer = self.bound(&planes)?.1;
        }
        Err(BalanceError::Unfinished(SolverStatus::MaxIterations))
    }

    /// Below this a value is none.
    fn smallest(&self) -> f64 {
        match self.aim {
            Aim::Reserve => 1.0,
            _ => f64::MIN_POSITIVE,
        }
    }

    /// μN over the margin, less the reserve.
    fn allowed(&self, touch: usize, solution: &[f64]) -> f64 {
        let reserve =
            if matches!(self.aim, Aim::Reserve) { solution[4 * self.touches.len()] } else { 0.0 };
        self.touches[touch].friction / self.margin * solution[4 * touch] - reserve
    }

    /// The gauge of a contact's limit surface; none where hardly anything is asked of it.
    fn gauge(&self, touch: usize, y: &Vector3<f64>, solution: &[f64]) -> Option<Gauge> {
        if y.norm()
            <= NO_LOAD * self.touches[touch].friction * solution[4 * touch].abs().max(NO_LOAD)
        {
            return None;
        }
        let contact = &self.touches[touch].contact;
        let load = Load { force: [y.x, y.y], moment: y.z * contact.arm() };
        let found = margin(contact, 1.0, &load);
        let Motion { velocity, turn } = found.motion?;
        let motion = Vector3::new(velocity[0], velocity[1], turn * contact.arm());
        let value = found.factor.recip();
        Some(Gauge { value, slope: motion * (value / motion.dot(y)) })
    }

    /// The problem with planes alone: what the true one cannot be better than.
    fn bound(&self, planes: &[(usize, Vector3<f64>)]) -> Result<(f64, Vec<f64>), BalanceError> {
        let solution = self.programme(&Surface::Planes(planes)).solve()?;
        Ok((self.value(&solution), solution))
    }

    /// What was made least or largest, in N or as a factor.
    fn value(&self, solution: &[f64]) -> f64 {
        let count = self.touches.len();
        let normals = (0..count).map(|k| solution[4 * k]);
        match self.aim {
            Aim::Grip(Least::Sum) => self.unit * normals.sum::<f64>(),
            Aim::Grip(Least::Largest) => self.unit * normals.fold(0.0, f64::max),
            Aim::Load => self.unit * solution[4 * count],
            Aim::Reserve => solution[4 * count],
        }
    }

    fn balance(&self, solution: &[f64], bound: f64) -> Balance {
        let largest = (0..self.touches.len()).map(|k| solution[4 * k]).fold(0.0, f64::max);
        let share = |k: usize| {
            let (y, normal) = (tangential(solution, k), solution[4 * k].max(0.0));
            let touch = &self.touches[k];
            let force = [self.unit * y.x, self.unit * y.y];
            let load = Load { force, moment: self.unit * y.z * touch.contact.arm() };
            let limit = touch.friction * normal * self.unit;
            let used = margin(&touch.contact, limit, &load).factor.recip();
            let presses = normal > NO_PRESS * largest;
            Share { normal: self.unit * normal, load, used: if presses { used } else { f64::NAN } }
        };
        let shares = (0..self.touches.len()).map(share).collect();
        Balance { value: self.value(solution), bound, shares }
    }

    fn programme(&self, surface: &Surface) -> Programme {
        let count = self.touches.len();
        let last = 4 * count;
        let mut programme = Programme::new(last + 1);
        self.balance_rows(&mut programme);
        for (k, touch) in self.touches.iter().enumerate() {
            programme.at_least(&[(4 * k, 1.0)], 0.0);
            if touch.most.is_finite() {
                programme.at_least(&[(4 * k, -1.0)], -touch.most / self.unit);
            }
        }
        match self.aim {
            Aim::Grip(Least::Sum) => {
                (0..count).for_each(|k| programme.cost[4 * k] = 1.0);
                programme.equal(&[(last, 1.0)], 0.0);
            }
            Aim::Grip(Least::Largest) => {
                programme.cost[last] = 1.0;
                for k in 0..count {
                    programme.at_least(&[(last, 1.0), (4 * k, -1.0)], 0.0);
                }
            }
            Aim::Load => programme.cost[last] = -1.0,
            Aim::Reserve => {
                programme.cost[last] = -1.0;
                let all: Vec<(usize, f64)> = (0..count).map(|k| (4 * k, 1.0)).collect();
                programme.equal(&all, count as f64);
            }
        }
        let reserve = if matches!(self.aim, Aim::Reserve) { 1.0 } else { 0.0 };
        let limit =
            |k: usize| vec![(4 * k, self.touches[k].friction / self.margin), (last, -reserve)];
        match surface {
            Surface::Ellipsoid(models) => {
                for (k, model) in models.iter().enumerate() {
                    let root = model
                        .cholesky()
                        .map_or_else(Matrix3::identity, |root| root.l().transpose());
                    let row = |i: usize| (0..3).map(|j| (4 * k + 1 + j, root[(i, j)])).collect();
                    programme.cone([limit(k), row(0), row(1), row(2)]);
                }
            }
            Surface::Planes(planes) => {
                for k in 0..count {
                    for sign in [1.0, -1.0] {
                        let mut row = limit(k);
                        row.push((4 * k + 3, sign));
                        programme.at_least(&row, 0.0);
                    }
                }
                for (k, normal) in *planes {
                    let mut row = limit(*k);
                    row.extend((0..3).map(|j| (4 * k + 1 + j, -normal[j])));
                    programme.at_least(&row, 0.0);
                }
                for k in 0..count {
                    programme.cone([limit(k), vec![(4 * k + 1, 1.0)], vec![(4 * k + 2, 1.0)]]);
                }
            }
        }
        programme
    }

    /// Contacts and load balance: six rows.
    fn balance_rows(&self, programme: &mut Programme) {
        let scale = length(self.touches);
        let last = 4 * self.touches.len();
        let mut rows = vec![Vec::new(); 6];
        for (k, touch) in self.touches.iter().enumerate() {
            let [x, y, n] = touch.pose.axes;
            let arm = touch.pose.position / scale;
            let turning = n * (touch.contact.arm() / scale);
            let columns = [
                (n, arm.cross(&n)),
                (x, arm.cross(&x)),
                (y, arm.cross(&y)),
                (Vector3::zeros(), turning),
            ];
            for (j, (force, moment)) in columns.into_iter().enumerate() {
                for i in 0..3 {
                    rows[i].push((4 * k + j, force[i]));
                    rows[3 + i].push((4 * k + j, moment[i]));
                }
            }
        }
        let moment = self.load.moment.map(|part| part / scale);
        let load: Vec<f64> = self.load.force.into_iter().chain(moment).collect();
        for (mut row, load) in rows.into_iter().zip(load) {
            match self.aim {
                Aim::Load => {
                    row.push((last, load));
                    programme.equal(&row, 0.0);
                }
                _ => programme.equal(&row, -load),
            }
        }
    }
}

/// The gauge φ of a limit surface and its slope at a load.
struct Gauge {
    value: f64,
    slope: Vector3<f64>,
}

/// What is known of φ² of a contact.
#[derive(Clone)]
struct Shape {
    /// φ² is taken for yᵀMy.
    model: Matrix3<f64>,
    /// The last load and half the slope of φ² there.
    last: Option<(Vector3<f64>, Vector3<f64>)>,
}

impl Default for Shape {
    fn default() -> Self {
        Self { model: Matrix3::identity(), last: None }
    }
}

impl Shape {
    /// Learns value and slope at a load, and the curvature from the load before.
    fn learn(&mut self, y: &Vector3<f64>, gauge: &Gauge) {
        // Only directions count: φ is of first degree.
        let y = y / gauge.value;
        let half = gauge.slope;
        if let Some((before, slope)) = self.last {
            self.update(&(y - before), &(half - slope));
        }
        self.update(&y, &half);
        self.last = Some((y, half));
    }

    /// The model after which a step turns the slope so far.
    fn update(&mut self, step: &Vector3<f64>, turned: &Vector3<f64>) {
        let model = self.model * step;
        let (along, before) = (step.dot(turned), step.dot(&model));
        // Too short a step tells nothing but rounding.
        if step.norm() < 1e-6 || along <= 1e-3 * before || before <= 0.0 {
            return;
        }
        self.model += turned * turned.transpose() / along - model * model.transpose() / before;
    }
}

/// A linear programme with cones: cost · z least, equal rows, rows at least, and cones of second order.
struct Programme {
    cost: Vec<f64>,
    equal: Vec<Row>,
    at_least: Vec<Row>,
    cones: Vec<Vec<Vec<(usize, f64)>>>,
}

/// Coefficients and what they make.
type Row = (Vec<(usize, f64)>, f64);

impl Programme {
    fn new(unknowns: usize) -> Self {
        let (equal, at_least, cones) = (Vec::new(), Vec::new(), Vec::new());
        Self { cost: vec![0.0; unknowns], equal, at_least, cones }
    }

    fn equal(&mut self, row: &[(usize, f64)], value: f64) {
        self.equal.push((row.to_vec(), value));
    }

    fn at_least(&mut self, row: &[(usize, f64)], value: f64) {
        self.at_least.push((row.to_vec(), value));
    }

    /// The first row is not below the length of the others.
    fn cone<const N: usize>(&mut self, rows: [Vec<(usize, f64)>; N]) {
        self.cones.push(rows.into());
    }

    fn solve(&self) -> Result<Vec<f64>, BalanceError> {
        let (mut i, mut j, mut v, mut b) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        // The solver has A z + s = b with s in the cones.
        let mut add = |row: &[(usize, f64)], sign: f64, value: f64| {
            for &(column, coefficient) in row.iter().filter(|part| part.1 != 0.0) {
                i.push(b.len());
                j.push(column);
                v.push(sign * coefficient);
            }
            b.push(sign * value);
        };
        let mut kinds = Vec::new();
        self.equal.iter().for_each(|(row, value)| add(row, 1.0, *value));
        kinds.push(SupportedConeT::ZeroConeT(self.equal.len()));
        self.at_least.iter().for_each(|(row, value)| add(row, -1.0, *value));
        kinds.push(SupportedConeT::NonnegativeConeT(self.at_least.len()));
        for cone in &self.cones {
            cone.iter().for_each(|row| add(row, -1.0, 0.0));
            kinds.push(SupportedConeT::SecondOrderConeT(cone.len()));
        }
        let unknowns = self.cost.len();
        let rows = CscMatrix::new_from_triplets(b.len(), unknowns, i, j, v);
        let square = CscMatrix::zeros((unknowns, unknowns));
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-11,
            tol_gap_rel: 1e-11,
            tol_feas: 1e-11,
            ..DefaultSettings::default()
        };
        let failed = BalanceError::Unfinished(SolverStatus::Unsolved);
        let mut solver = DefaultSolver::new(&square, &self.cost, &rows, &b, &kinds, settings)
            .map_err(|_| failed)?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(solver.solution.x.clone()),
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                Err(BalanceError::Impossible)
            }
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => {
                Err(BalanceError::Unlimited)
            }
            other => Err(BalanceError::Unfinished(other)),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::contact::Shape as ContactShape;
    use super::super::pressure::PressureLaw;
    use super::*;

    /// A grasp of two to four contacts of any shape about an object, each with a largest normal force.
    fn any_grasp(random: &mut ChaCha8Rng, count: usize) -> Vec<Touch> {
        let mut part = |from: f64, to: f64| random.random_range(from..to);
        (0..count)
            .map(|k| {
                let angle = std::f64::consts::TAU * k as f64 / count as f64 + part(0.0, 0.3);
                let position = [20.0 * angle.cos(), 20.0 * angle.sin(), part(-4.0, 4.0)];
                let normal = [-angle.cos() + part(-0.1, 0.1), -angle.sin(), part(-0.1, 0.1)];
                let shape = match part(0.0, 3.0) {
                    kind if kind < 1.0 => ContactShape::Circle { radius: part(3.0, 8.0) },
                    kind if kind < 2.0 => {
                        ContactShape::Ellipse { x: part(3.0, 7.0), y: part(2.0, 4.0) }
                    }
                    _ => {
                        ContactShape::Rectangle { length: part(6.0, 15.0), width: part(4.0, 12.0) }
                    }
                };
                let law = [2.0, 4.0, f64::INFINITY][part(0.0, 3.0) as usize];
                Touch {
                    pose: Pose::new(position, normal, None).unwrap(),
                    contact: Contact::new(shape, PressureLaw::new(law).unwrap()).unwrap(),
                    friction: part(0.3, 1.0),
                    most: part(1.0, 3.0),
                }
            })
            .collect()
    }

    /// The wrench that these contacts resist a motion of the object with at most, by brute force over the
    /// contacts: each does what works most against it, or nothing.
    fn resisting(touches: &[Touch], velocity: Vector3<f64>, turn: Vector3<f64>) -> Wrench {
        let mut total = Wrench::default();
        for touch in touches {
            let there = velocity + turn.cross(&touch.pose.position);
            let [x, y, n] = touch.pose.axes;
            let motion = Motion { velocity: [there.dot(&x), there.dot(&y)], turn: turn.dot(&n) };
            let load = touch.contact.slipping(&motion).times(touch.friction * touch.most);
            let wrench = touch.pose.wrench(touch.most, &load);
            if work(&wrench, velocity, turn) > 0.0 {
                total = total.plus(&wrench);
            }
        }
        total
    }

    fn work(wrench: &Wrench, velocity: Vector3<f64>, turn: Vector3<f64>) -> f64 {
        velocity.dot(&Vector3::from(wrench.force)) + turn.dot(&Vector3::from(wrench.moment))
    }

    #[test]
    fn sampled_wrenches_at_the_limit_of_a_grasp_have_a_margin_of_one() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        for trial in 0..60 {
            let touches = any_grasp(&mut random, 2 + trial % 3);
            let mut part = |size: f64| random.random_range(-size..size);
            let velocity = Vector3::new(part(0.5), part(0.5), part(0.5));
            let turn = Vector3::new(part(0.025), part(0.025), part(0.025));
            let load = resisting(&touches, velocity, turn).times(-1.0);
            let found = largest_load(&touches, &load).unwrap();
            assert!((found.value - 1.0).abs() < 1e-6, "{trial}: {}", found.value);
            assert!((found.bound - found.value).abs() < 1e-6, "{trial}: {}", found.bound);
            let half = largest_load(&touches, &load.times(0.5)).unwrap();
            assert!((half.value - 2.0).abs() < 2e-6, "{trial}: {}", half.value);
            // The same forces, scaled, are the least whose largest part of each finger's most is 1.
            let free: Vec<Touch> =
                touches.iter().map(|t| Touch { most: f64::INFINITY, ..t.clone() }).collect();
            let grip = least_grip(&free, &load, 1.0, Least::Sum).unwrap();
            let enough: f64 = touches.iter().map(|touch| touch.most).sum();
            assert!(grip.value <= enough * (1.0 + 1e-6), "{trial}: {} of {enough}", grip.value);
            assert!((grip.value - grip.bound).abs() < 1e-6 * grip.value, "{trial}");
            let mut left = load;
            for (touch, share) in free.iter().zip(&grip.shares) {
                left = left.plus(&touch.pose.wrench(share.normal, &share.load));
                assert!(share.used.is_nan() || share.used < 1.0 + 1e-6, "{trial}: {}", share.used);
            }
            let off =
                left.force.iter().chain(&left.moment).fold(0.0f64, |most, x| most.max(x.abs()));
            assert!(off < 1e-6, "{trial}: {off} out of balance");
        }
    }

    #[test]
    fn no_sampled_motion_is_resisted_by_less_than_the_margin_says() {
        // The margin is the least of the resistance over the work of the load, over all motions.
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let touches = any_grasp(&mut random, 3);
        let load = Wrench { force: [0.3, -0.2, -0.6], moment: [4.0, 3.0, -2.0] };
        let found = largest_load(&touches, &load).unwrap().value;
        let mut least = f64::INFINITY;
        for _ in 0..20_000 {
            let mut part = |size: f64| random.random_range(-size..size);
            let velocity = Vector3::new(part(0.5), part(0.5), part(0.5));
            let turn = Vector3::new(part(0.05), part(0.05), part(0.05));
            let driven = -work(&load, velocity, turn);
            if driven > 1e-3 {
                // Against the motion that the load drives.
                let held = resisting(&touches, velocity, turn);
                least = least.min(work(&held, velocity, turn) / driven);
            }
        }
        assert!(least >= found - 1e-6 && least < 1.5 * found, "{least} sampled, {found}");
    }

    #[test]
    fn a_weight_between_two_fingers_takes_half_of_it_over_the_friction_from_each() {
        let law = PressureLaw::HERTZ;
        let contact = Contact::new(ContactShape::Circle { radius: 6.0 }, law).unwrap();
        let touch = |x: f64| Touch {
            pose: Pose::new([x, 0.0, 0.0], [-x, 0.0, 0.0], None).unwrap(),
            contact: contact.clone(),
            friction: 0.5,
            most: 20.0,
        };
        let pair = [touch(20.0), touch(-20.0)];
        let load = Wrench { force: [0.0, 0.0, -8.0], moment: [0.0; 3] };
        let grip = least_grip(&pair, &load, 1.0, Least::Largest).unwrap();
        assert!((grip.value - 8.0).abs() < 1e-6, "{grip:?}");
        assert!((largest_load(&pair, &load).unwrap().value - 2.5).abs() < 1e-6);
        assert!(closure(&pair).unwrap().is_force_closed(), "{:?}", closure(&pair));
        // One finger holds nothing up and is no grasp.
        let one = closure(&pair[..1]).unwrap();
        assert!(one.rank == 4 && !one.is_force_closed(), "{one:?}");
        assert_eq!(least_grip(&pair[..1], &load, 1.0, Least::Sum), Err(BalanceError::Impossible));
        // A twist about the line between them is carried by the moments about the normals alone.
        let twist = Wrench { force: [0.0; 3], moment: [10.0, 0.0, 0.0] };
        let grip = least_grip(&pair, &twist, 1.0, Least::Sum).unwrap();
        assert!((grip.value - 10.0 / (0.5 * contact.arm())).abs() < 1e-5, "{grip:?}");
    }

    #[test]
    fn a_pose_needs_a_normal_and_an_axis_across_it() {
        assert_eq!(Pose::new([0.0; 3], [0.0; 3], None), Err(PoseError::Normal));
        let along = Some([0.0, 0.0, 2.0]);
        assert_eq!(Pose::new([0.0; 3], [0.0, 0.0, 1.0], along), Err(PoseError::Axis));
        let pose = Pose::new([0.0; 3], [0.0, 0.0, 3.0], Some([1.0, 0.0, 5.0])).unwrap();
        assert_eq!(pose.axes, [Vector3::x(), Vector3::y(), Vector3::z()]);
    }
}
