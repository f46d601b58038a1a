//! A chain over a data set as a problem of least squares.
//!
//! The search runs over the simulated force, never over differentiated measurements, in the coordinates
//! of the base law ([`super::coordinates`]) and the parameters of the effects as they are. Derivatives by
//! the coordinates of a linear base law are carried along (`carried.rs`); all others are differences,
//! so that a law is one plain function.

use std::borrow::Cow;
use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DMatrixView, DVector};

use super::carried::{Carried, Measured, Memory, Stretch, logarithms};
use super::columns::Products;
use super::compression::Compressed;
use super::coordinates::Coordinates;
use super::data::{Data, Piece};
use super::fold::Fold;
use super::least_squares::{HARDLY, LeastSquares, Normal, bounded_step_of};
use super::levels::LevelSums;
use super::means::Means;
use super::meant::Meant;
use super::remembering::Reached;
use super::spare::Spare;
use super::watch;
use super::whitening::Whitening;
use palpate_model::{Act, Chain, Coordinate, Elasticity, History, Scene, Stage};

/// Residuals of a chain over a data set.
pub struct Problem<'a> {
    /// The chain.
    pub chain: &'a Chain,
    data: &'a Data<'a>,
    /// ln(x/X) of the commanded compression at every sample, where the data set keeps what it knows.
    logarithms: Arc<Vec<Vec<f64>>>,
    spare: Arc<Spare>,
    whitening: &'a Whitening,
    /// By what each sample of a stretch is multiplied; by one where there is no such stretch.
    roots: Vec<&'a [f64]>,
    /// Sum of squares that no point changes.
    constant: f64,
    /// What means tell of each stretch beside their values; empty where the data are samples.
    means: Arc<Vec<Meant>>,
    /// Traces that are predicted but not fitted.
    left_out: Option<Fold>,
    /// Whether a search goes over shape and rates alone, the forces being always the best.
    projects: bool,
    coordinates: Coordinates,
    bounds: Vec<(f64, f64)>,
}

/// Samples whose products are taken at a time.
const AT_A_TIME: usize = 1024;
/// Step of a derivative, relative to the coordinate and to its range.
const STEP: (f64, f64) = (1e-6, 1e-8);

/// Part of the largest signal of a stretch by which a step of a derivative moves none of its samples but across a jump of a law, and
/// how many times as far as its neighbours it moves one there.
const LEAP: f64 = 3e-5;
const ALONE: f64 = 30.0;

/// Lets samples that a step moves across a jump, farther than `least` and alone, follow their neighbours: the jump says nothing of the
/// slope.
fn smooth_jumps(differences: &mut [f64], least: f64) {
    for k in 0..differences.len() {
        if differences[k].abs() <= least {
            continue;
        }
        let before = k.checked_sub(1).map_or(0.0, |k| differences[k]);
        let after = differences.get(k + 1).copied().unwrap_or(0.0);
        if differences[k].abs() > ALONE * before.abs().max(after.abs()) {
            differences[k] = 0.5 * (before + after);
        }
    }
}

impl<'a> Problem<'a> {
    /// The residuals of `chain`, whitened, on every trace but those left out.
    #[must_use]
    pub fn new(
        chain: &'a Chain,
        data: &'a Data<'a>,
        whitening: &'a Whitening,
        left_out: Option<Fold>,
    ) -> Self {
        let coordinates = Coordinates::new(chain.base, data.largest_compression());
        let logarithms_of = |piece: &Piece| {
            let mut values = Vec::new();
            logarithms(&piece.motion.displacement, coordinates.reference(), &mut values);
            values
        };
        let kept: &[Piece] = if data.keeps() { &data.pieces } else { &[] };
        let logarithms = kept.iter().map(logarithms_of).collect();
        Self {
            chain,
            data,
            logarithms: Arc::new(logarithms),
            spare: Arc::default(),
            whitening,
            roots: Vec::new(),
            constant: 0.0,
            means: Arc::default(),
            left_out,
            projects: false,
            bounds: bounds(&coordinates, chain, data),
            coordinates,
        }
    }

    /// The same chain on the block means of its data, in the same coordinates within the same bounds.
    #[must_use]
    pub fn on_means<'b>(&self, compressed: &'b Compressed, means: &'b Data<'b>) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem { roots: compressed.roots(), constant: compressed.within, ..self.on(means) }
    }

    /// The same chain on the means of its data that effects see. Its sums of squares and its normal equations are those of all
    /// samples, as far as nothing bends within a block.
    #[must_use]
    pub fn on_weighted_means<'b>(&self, means: &Means, data: &'b Data<'b>) -> Problem<'b>
    where
        'a: 'b,
    {
        let means = Arc::new(Meant::of(means, self.data, self.whitening));
        Problem { means, ..self.on(data) }
    }

    /// The same chain on other data of the same motions, in the same coordinates within the same bounds.
    fn on<'b>(&self, data: &'b Data<'b>) -> Problem<'b>
    where
        'a: 'b,
    {
        let mut problem = Problem::new(self.chain, data, self.whitening, self.left_out);
        let reference = self.coordinates.reference();
        for (kept, piece) in Arc::make_mut(&mut problem.logarithms).iter_mut().zip(&data.pieces) {
            logarithms(&piece.motion.displacement, reference, kept);
        }
        Problem { coordinates: self.coordinates.clone(), bounds: self.bounds.clone(), ..problem }
    }

    /// The same for a search from afar: it goes over shape and rates alone where the law is linear in its forces, and these are always
    /// the best. A valley that is bent in all coordinates is straight in those.
    #[must_use]
    pub fn projecting(mut self) -> Self {
        self.projects = true;
        self
    }

    /// The same without the residuals of some traces.
    #[must_use]
    pub fn leaving_out(&self, fold: Fold) -> Self {
        Self {
            left_out: Some(fold),
            coordinates: self.coordinates.clone(),
            bounds: self.bounds.clone(),
            ..self.with_chain(self.chain)
        }
    }

    /// The same with every residual multiplied by the root of its sample's weight, stretch by stretch.
    #[must_use]
    pub(super) fn weighted<'b>(&self, roots: &'b [Vec<f64>]) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem {
            roots: roots.iter().map(Vec::as_slice).collect(),
            coordinates: self.coordinates.clone(),
            bounds: self.bounds.clone(),
            ..self.with_chain(self.chain)
        }
    }

    /// The same data with another chain.
    #[must_use]
    pub fn with_chain<'b>(&self, chain: &'b Chain) -> Problem<'b>
    where
        'a: 'b,
    {
        let coordinates = self.coordinates.of(chain.base);
        Problem {
            chain,
            data: self.data,
            logarithms: self.logarithms.clone(),
            spare: self.spare.clone(),
            whitening: self.whitening,
            roots: self.roots.clone(),
            constant: self.constant,
            means: self.means.clone(),
            left_out: self.left_out,
            projects: self.projects,
            bounds: bounds(&coordinates, chain, self.data),
            coordinates,
        }
    }

    /// Whether the data are means that stand for their samples, with all that these tell.
    #[must_use]
    pub fn stands_for_samples(&self) -> bool {
        !self.means.is_empty()
    }

    /// Number of samples that the data stand for.
    #[must_use]
    pub fn rows(&self) -> usize {
        (0..self.data.pieces.len()).map(|index| self.rows_of(index, 0..usize::MAX)).sum()
    }

    /// Number of samples that a range of a stretch stands for.
    fn rows_of(&self, index: usize, range: Range<usize>) -> usize {
        let count = self.data.pieces[index].measured.len();
        let range = range.start..range.end.min(count);
        self.means.get(index).map_or(range.len(), |means| means.rows(range))
    }

    /// The sum of squares of whitened samples that their means do not show, the same at every point.
    #[must_use]
    pub fn unseen(&self) -> f64 {
        let fitted =
            self.means.iter().zip(&self.data.pieces).filter(|(_, piece)| self.fitted(piece));
        self.constant + fitted.map(|(means, _)| means.white.iter().sum::<f64>()).sum::<f64>()
    }

    /// The parts of a stretch that stand for about as many samples each.
    #[must_use]
    pub fn parts(&self, index: usize, parts: usize) -> Vec<Range<usize>> {
        let count = self.data.pieces[index].measured.len();
        let size = self.rows_of(index, 0..count).div_ceil(parts).max(1);
        let Some(means) = self.means.get(index) else {
            return (0..count).step_by(size).map(|k| k..(k + size).min(count)).collect();
        };
        let mut found: Vec<Range<usize>> = Vec::new();
        let (mut begin, mut rows) = (0, 0);
        for k in 0..count {
            rows += means.rows(k..k + 1);
            if rows >= size || k + 1 == count {
                found.push(begin..k + 1);
                (begin, rows) = (k + 1, 0);
            }
        }
        found
    }

    /// Makes the noise of the residual (predicted minus measured) of the stretch with this index white.
    pub fn whiten_residual(&self, index: usize, residual: &mut [f64]) {
        self.whiten_at(index, residual);
        if let Some(means) = self.means.get(index) {
            residual.iter_mut().zip(&means.shift).for_each(|(value, shift)| *value -= shift);
        }
    }

    /// Sum of squares of the samples that each mean of a stretch does not show, as they are; empty where the data are samples.
    #[must_use]
    pub fn scatter(&self, index: usize) -> &[f64] {
        self.means.get(index).map_or(&[], |means| &means.raw)
    }

    /// Gives every value of a stretch the weight of the samples that it stands for.
    pub fn weigh(&self, index: usize, values: &mut [f64]) {
        if let Some(means) = self.means.get(index) {
            values.iter_mut().zip(&means.roots).for_each(|(value, root)| *value *= root);
        }
    }

    /// The whitened sum of squares over the traces that are fitted, and the error on each that is left out, in order.
    #[must_use]
    pub fn apart(&self, point: &[f64]) -> (f64, Vec<Apart>) {
        let count = self.data.labels.len();
        let traces: Vec<usize> = self.left_out.iter().flat_map(|fold| fold.traces(count)).collect();
        let mut aparts = vec![Apart::default(); traces.len()];
        let mut stretches: Vec<Vec<(usize, Vec<f64>)>> = vec![Vec::new(); traces.len()];
        let cost = self.fitted_cost(point, &mut Reached::default(), |index, piece, residual| {
            let Ok(place) = traces.binary_search(&piece.trace) else { return };
            let apart = &mut aparts[place];
            let mut weighted = residual.to_vec();
            self.weigh(index, &mut weighted);
            let scatter: f64 = self.scatter(index).iter().sum();
            apart.square += scatter + weighted.iter().map(|r| r * r).sum::<f64>();
            apart.samples += self.rows_of(index, 0..usize::MAX);
            let touch = self.data.touch(piece);
            apart.before.extend_from_slice(&weighted[..touch.unwrap_or(0)]);
            stretches[place].push((index, residual.to_vec()));
        });
        for ((&trace, apart), stretches) in traces.iter().zip(&mut aparts).zip(&mut stretches) {
            apart.whitened = self.whitened_square(trace, stretches);
        }
        (cost, aparts)
    }

    /// Sum of squares and number of samples, not whitened, of each trace that is left out, in order. What comes after the last of them is
    /// not run.
    #[must_use]
    pub fn left_out_squares(&self, point: &[f64]) -> Vec<(f64, usize)> {
        let Some(fold) = self.left_out else { return Vec::new() };
        let traces: Vec<usize> = fold.traces(self.data.labels.len()).collect();
        let mut sums = vec![(0.0, 0); traces.len()];
        let last = self.data.pieces.iter().rposition(|piece| fold.holds(piece.trace));
        let (mut run, mut elasticity) = (self.run_at(point), Elasticity::default());
        let mut force = self.spare.take();
        for (index, piece) in self.data.pieces.iter().enumerate().take(last.map_or(0, |k| k + 1)) {
            self.advance(&mut run, index, &mut elasticity, &mut force);
            let Ok(place) = traces.binary_search(&piece.trace) else { continue };
            let (sum, count) = &mut sums[place];
            let residual = force.iter().zip(piece.measured).map(|(force, y)| force - y);
            *sum += residual.map(|r| r * r).sum::<f64>();
            *count += piece.measured.len();
        }
        self.spare.give([force]);
        sums
    }

    /// The whitened sum of squares over the traces that are fitted; `seen` gets the residual of every
    /// stretch (predicted minus measured).
    fn fitted_cost(
        &self,
        point: &[f64],
        reached: &mut Reached,
        mut seen: impl FnMut(usize, &Piece, &[f64]),
    ) -> f64 {
        let mut normal = Normal::zeros(0);
        normal.cost = self.unseen();
        let mut sums = self.level_sums(0);
        let mut run = self.run_at(point);
        let mut residual = self.spare.take();
        for (index, piece) in self.data.pieces.iter().enumerate() {
            self.advance(&mut run, index, reached.in_stretch(index), &mut residual);
            for (force, measured) in residual.iter_mut().zip(piece.measured) {
                *force -= measured;
            }
            seen(index, piece, &residual);
            if self.fitted(piece) {
                self.whiten_residual(index, &mut residual);
                if let Some(sums) = &mut sums {
                    sums.add(piece.trace, &self.unit_level(index), &[], &residual, 0);
                }
                normal.cost += residual.iter().map(|r| r * r).sum::<f64>();
            }
        }
        self.spare.give([residual]);
        self.marginalise(sums.as_ref(), &mut normal);
        normal.cost
    }

    /// The data set whose residuals these are.
    #[must_use]
    pub const fn data(&self) -> &'a Data<'a> {
        self.data
    }

    /// The coordinates of the base law.
    #[must_use]
    pub fn coordinates(&self) -> &Coordinates {
        &self.coordinates
    }

    /// The chain's parameters from coordinates.
    #[must_use]
    pub fn declared(&self, point: &[f64]) -> Vec<f64> {
        let (base, effects) = point.split_at(self.coordinates.count());
        let mut declared = self.coordinates.declared(base);
        declared.extend_from_slice(effects);
        declared
    }

    /// Coordinates of these parameters.
    #[must_use]
    pub fn point(&self, declared: &[f64]) -> Vec<f64> {
        let (base, effects) = declared.split_at(self.coordinates.count());
        let mut point = self.coordinates.point(base);
        point.extend_from_slice(effects);
        point
    }

    fn scene(&self, index: usize) -> Scene<'a> {
        self.data.scene(&self.data.pieces[index])
    }

    /// What effects see of a stretch; none where there are none to see it.
    fn seen(&self, index: usize) -> Option<Scene<'a>> {
        (!self.chain.effects.is_empty()).then(|| self.scene(index))
    }

    /// A run at a point, before the first stretch.
    fn run_at(&self, point: &[f64]) -> Run {
        Run {
            parameters: self.declared(point),
            carried: Carried::new(self.chain, &self.coordinates, point),
            memory: Memory::default(),
            history: History::default(),
        }
    }

    /// Takes a run over the stretch with this index, the next in order: what it predicts goes to `force`.
    fn advance(
        &self,
        run: &mut Run,
        index: usize,
        elasticity: &mut Elasticity,
        force: &mut Vec<f64>,
    ) {
        if run.carried.is_some() {
            self.relax(run, index, force, &[], &mut []);
            self.sense(run, index, force);
        } else {
            watch::evaluated(self.data.pieces[index].measured.len());
            let scene = self.scene(index);
            self.chain.run(&run.parameters, &scene, &mut run.history, elasticity, force);
        }
    }

    /// Takes a run whose base law is carried up to the force of that law, with the derivatives `wanted`.
    fn relax(
        &self,
        run: &mut Run,
        index: usize,
        force: &mut Vec<f64>,
        wanted: &[Coordinate],
        columns: &mut [Vec<f64>],
    ) {
        let Some(carried) = &run.carried else { return };
        watch::evaluated(self.data.pieces[index].measured.len());
        let motion = &self.data.pieces[index].motion;
        let scene = self.seen(index);
        let x = match &scene {
            Some(scene) => self.chain.upstream(&run.parameters, scene, &mut run.history),
            None => Cow::Borrowed(&motion.displacement[..]),
        };
        let mut own = self.spare.take();
        let known = self.logarithms.get(index).filter(|_| matches!(x, Cow::Borrowed(_)));
        let logarithm = known.unwrap_or_else(|| {
            logarithms(&x, self.coordinates.reference(), &mut own);
            &own
        });
        let (time, rest) = (&motion.time[..], motion.rest_before);
        let stretch = Stretch { time, x: &x, logarithm, rest };
        if wanted.is_empty() {
            carried.predict(stretch, &mut run.memory, force);
        } else {
            carried.run(stretch, &mut run.memory, force, wanted, columns);
        }
        self.spare.give([own]);
    }

    /// Sums of products of the derivatives and of the residual, for each of so many groups of stretches; no derivative is written down.
    /// None where the law is not carried, something acts beside it or whitens, means stand for samples, or what follows from the motions is
    /// not kept.
    fn in_one_pass(
        &self,
        point: &[f64],
        groups: usize,
        group: impl Fn(&Piece) -> Option<usize>,
    ) -> Option<Vec<Normal>> {
        let alone = self.chain.effects.is_empty() && self.whitening.is_none();
        if !alone || self.stands_for_samples() || !self.data.keeps() {
            return None;
        }
        let carried = Carried::new(self.chain, &self.coordinates, point)?;
        let mut memory = Memory::default();
        let free = |&j: &usize| self.bounds[j].0 < self.bounds[j].1;
        let moving: Vec<usize> = (0..self.coordinates.count()).filter(free).collect();
        let wanted: Vec<Coordinate> = moving.iter().map(|&j| self.coordinates.list()[j]).collect();
        // The last are of stretches that are not fitted: what comes after may remember them.
        let mut sums = vec![Products::zeros(wanted.len() + 1); groups + 1];
        for (index, piece) in self.data.pieces.iter().enumerate() {
            let motion = &piece.motion;
            let stretch = Stretch {
                time: &motion.time,
                x: &motion.displacement,
                logarithm: &self.logarithms[index],
                rest: motion.rest_before,
            };
            let roots = self.roots.get(index).copied().unwrap_or_default();
            let measured = Measured { signal: piece.measured, roots };
            let own = &mut sums[group(piece).unwrap_or(groups)];
            watch::evaluated(piece.measured.len());
            carried.add_products(stretch, &mut memory, measured, &wanted, own);
        }
        let normal = |sums: &Products| Normal::of(point.len(), &moving, sums);
        Some(sums[..groups].iter().map(normal).collect())
    }

    /// From the force of a carried base law to the signal.
    fn sense(&self, run: &mut Run, index: usize, force: &mut [f64]) {
        if let Some(scene) = self.seen(index) {
            self.chain.downstream(&run.parameters, &scene, &mut run.history, force);
        }
    }

    /// Whether the effect that this coordinate is of acts on the force that the base law makes.
    fn acts_after(&self, coordinate: usize) -> bool {
        let owner = (0..self.chain.effects.len())
            .find(|&index| self.chain.range(index).contains(&coordinate));
        owner.is_some_and(|index| {
            let effect = &self.chain.effects[index];
            match effect.act {
                Act::Force(_) | Act::Added(_) => true,
                Act::Own(_) => matches!(effect.stage, Stage::Contact | Stage::Sensor),
                _ => false,
            }
        })
    }

    /// Runs the chain at several points over every stretch and hands over, stretch by stretch, what
    /// each predicts. The runs are over all stretches in order: what is remembered stays right.
    pub fn each_piece(&self, points: &[Vec<f64>], mut sink: impl FnMut(&Piece, &[Vec<f64>])) {
        let mut runs: Vec<Run> = points.iter().map(|point| self.run_at(point)).collect();
        let mut forces: Vec<Vec<f64>> = points.iter().map(|_| self.spare.take()).collect();
        let mut elasticity = Elasticity::default();
        for (index, piece) in self.data.pieces.iter().enumerate() {
            for (run, force) in runs.iter_mut().zip(&mut forces) {
                self.advance(run, index, &mut elasticity, force);
            }
            sink(piece, &forces);
        }
        self.spare.give(forces);
    }

    /// Predicted signal of every stretch.
    #[must_use]
    pub fn predict(&self, point: &[f64]) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        self.each_piece(&[point.to_vec()], |_, forces| found.push(forces[0].clone()));
        found
    }

    /// Residuals (measured minus predicted) of every stretch.
    #[must_use]
    pub fn residuals(&self, point: &[f64]) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        self.each_piece(&[point.to_vec()], |piece, forces| {
            found.push(piece.measured.iter().zip(&forces[0]).map(|(y, f)| y - f).collect());
        });
        found
    }

    /// Steps of the derivatives at a point, within the bounds.
    pub(super) fn steps(&self, point: &[f64]) -> Vec<f64> {
        let unbounded = |&j: &usize| !(self.bounds[j].1 - self.bounds[j].0).is_finite();
        // What the base law leaves without a bound are forces: they reach as far as all of them together.
        let base = self.coordinates.count();
        let force: f64 = (0..base).filter(unbounded).map(|j| point[j].abs()).sum();
        let step = |j: usize| {
            let (lower, upper) = self.bounds[j];
            let range = match upper - lower {
                range if range.is_finite() => range,
                _ if j < base && force > 0.0 => force,
                _ => 1.0,
            };
            let step = STEP.0 * point[j].abs() + STEP.1 * range;
            if point[j] + step > upper { -step } else { step }
        };
        (0..point.len()).map(step).collect()
    }

    /// Hands over, stretch by stretch, the residual (predicted minus measured) and its derivatives, not
    /// whitened: a column for each coordinate that the stretch depends on. The others have none.
    pub fn derivatives(&self, point: &[f64], mut sink: impl FnMut(&Piece, Vec<f64>, Columns)) {
        self.slopes(point, &mut Reached::default(), |piece, residual, columns| {
            sink(piece, take(residual), take(columns));
        });
    }

    /// The same lent, not given away.
    fn slopes(
        &self,
        point: &[f64],
        reached: &mut Reached,
        mut sink: impl FnMut(&Piece, &mut Vec<f64>, &mut Columns),
    ) {
        let steps = self.steps(point);
        let moved = |j: usize| {
            let mut moved = point.to_vec();
            moved[j] += steps[j];
            moved
        };
        let owned: Vec<Vec<usize>> =
            (0..self.data.labels.len()).map(|trace| self.chain.own_of_trace(trace)).collect();
        let moves = |&j: &usize| self.bounds[j].0 < self.bounds[j].1;
        let mut run = self.run_at(point);
        // Derivatives that come with the run itself, and those by a run that is moved.
        let along = if run.carried.is_some() { self.coordinates.count() } else { 0 };
        let carried: Vec<usize> = (0..along).filter(moves).collect();
        let wanted: Vec<Coordinate> = carried.iter().map(|&j| self.coordinates.list()[j]).collect();
        let mut histories = vec![History::default(); carried.len()];
        let mut others: Vec<(usize, Run)> = (along..point.len())
            .filter(moves)
            .filter(|j| owned.iter().all(|own| !own.contains(j)))
            .map(|j| (j, self.run_at(&moved(j))))
            .collect();
        let changes = (self.coordinates.count()..point.len()).any(|j| self.acts_after(j));
        // What adds the same whatever the force leaves the derivatives of that as they are.
        let bends = !self.chain.only_adds_to_force();
        for (index, piece) in self.data.pieces.iter().enumerate() {
            let elasticity = reached.in_stretch(index);
            let own: Vec<usize> = owned[piece.trace].iter().copied().filter(moves).collect();
            let before = (!own.is_empty()).then(|| run.clone());
            let (mut base, mut relaxed) = (self.spare.take(), self.spare.take());
            let mut columns = Columns::with_capacity(carried.len() + others.len() + own.len());
            if run.carried.is_some() {
                let mut slopes: Vec<Vec<f64>> = carried.iter().map(|_| self.spare.take()).collect();
                self.relax(&mut run, index, &mut base, &wanted, &mut slopes);
                if changes {
                    relaxed.extend_from_slice(&base);
                    self.sense(&mut run, index, &mut base);
                    let bent = slopes.iter_mut().filter(|_| bends);
                    for ((&j, slope), history) in carried.iter().zip(bent).zip(&mut histories) {
                        self.sensed(&run, index, history, (&relaxed, &base), steps[j], slope);
                    }
                }
                columns.extend(carried.iter().copied().zip(slopes));
            } else {
                self.advance(&mut run, index, elasticity, &mut base);
            }
            let size = base.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
            let mut difference = |j: usize, run: &mut Run| {
                let mut force = self.spare.take();
                if run.carried.is_some() && self.acts_after(j) {
                    force.extend_from_slice(&relaxed);
                    self.sense(run, index, &mut force);
                } else {
                    self.advance(run, index, &mut elasticity.nearby(), &mut force);
                }
                for (force, base) in force.iter_mut().zip(&base) {
                    *force -= base;
                }
                smooth_jumps(&mut force, LEAP * size);
                force.iter_mut().for_each(|force| *force /= steps[j]);
                columns.push((j, force));
            };
            for (j, run) in &mut others {
                difference(*j, run);
            }
            // What belongs to this trace alone begins where the others have left it.
            for (j, before) in own.into_iter().zip(before.iter().cycle()) {
                let mut run = Run { parameters: self.declared(&moved(j)), ..before.clone() };
                difference(j, &mut run);
            }
            for (force, measured) in base.iter_mut().zip(piece.measured) {
                *force -= measured;
            }
            sink(piece, &mut base, &mut columns);
            self.spare.give(columns.drain(..).map(|(_, column)| column).chain([base, relaxed]));
        }
    }

    /// Takes a derivative of the base law's force, in place, through the effects that act on that force:
    /// `relaxed` becomes `base` by them.
    fn sensed(
        &self,
        run: &Run,
        index: usize,
        history: &mut History,
        (relaxed, base): (&[f64], &[f64]),
        step: f64,
        slope: &mut [f64],
    ) {
        let Some(scene) = self.seen(index) else { return };
        for (slope, relaxed) in slope.iter_mut().zip(relaxed) {
            *slope = relaxed + step * *slope;
        }
        self.chain.downstream(&run.parameters, &scene, history, slope);
        for (slope, base) in slope.iter_mut().zip(base) {
            *slope = (*slope - base) / step;
        }
    }

    /// The normal equations of every trace by itself, as it is.
    #[must_use]
    pub fn by_trace(&self, point: &[f64]) -> Vec<(Normal, usize)> {
        let traces = self.data.labels.len();
        if self.roots.is_empty()
            && let Some(normals) = self.in_one_pass(point, traces, |piece| Some(piece.trace))
        {
            let samples = |trace: usize| {
                let own = self.data.pieces.iter().filter(|piece| piece.trace == trace);
                own.map(|piece| piece.measured.len()).sum()
            };
            return normals
                .into_iter()
                .enumerate()
                .map(|(k, normal)| (normal, samples(k)))
                .collect();
        }
        let mut found = vec![(Normal::zeros(point.len()), 0); traces];
        self.slopes(point, &mut Reached::default(), |piece, residual, columns| {
            let (normal, samples) = &mut found[piece.trace];
            normal.add(columns, residual, 0..residual.len());
            *samples += residual.len();
        });
        found
    }

    /// The normal equations of every block of the data, whitened and as they are. A block is a trace,
    /// or a part of one where there are few.
    #[must_use]
    pub fn blocks(&self, point: &[f64]) -> Vec<Block> {
        self.blocks_from(point, &mut Reached::default())
    }

    /// The same from where a set-up that yields came to before.
    pub(super) fn blocks_from(&self, point: &[f64], reached: &mut Reached) -> Vec<Block> {
        let parts = FEWEST_BLOCKS.div_ceil(self.data.pieces.len().max(1));
        let mut blocks = Vec::new();
        let mut index = 0;
        self.slopes(point, reached, |piece, residual, columns| {
            let first = blocks.len();
            let ranges = self.parts(index, parts);
            let coordinates: Vec<usize> = columns.iter().map(|(j, _)| *j).collect();
            let mut weighted: Columns =
                columns.iter().enumerate().map(|(at, (_, column))| (at, column.clone())).collect();
            weighted.iter_mut().for_each(|(_, column)| self.weigh(index, column));
            let mut weighted_residual = residual.clone();
            self.weigh(index, &mut weighted_residual);
            for range in &ranges {
                let mut block = Block::new(piece.trace, coordinates.clone());
                block.levels = self.level_sums(point.len());
                block.samples = self.rows_of(index, range.clone());
                block.raw.add(&weighted, &weighted_residual, range.clone());
                blocks.push(block);
            }
            let unit = self.unit_level(index);
            self.whiten_residual(index, residual);
            for (_, column) in columns.iter_mut() {
                self.whiten_at(index, column);
            }
            for (block, range) in blocks[first..].iter_mut().zip(&ranges) {
                if let Some(sums) = &mut block.levels {
                    sums.add(piece.trace, &unit[range.clone()], columns, residual, range.start);
                }
            }
            columns.iter_mut().enumerate().for_each(|(at, (coordinate, _))| *coordinate = at);
            for (block, range) in blocks[first..].iter_mut().zip(ranges) {
                block.slow = self.sums_of_neighbours(index, &residual[range.clone()], range.start);
                block.white.add(columns, residual, range.clone());
                if let Some(means) = self.means.get(index) {
                    block.raw.cost += means.raw[range.clone()].iter().sum::<f64>();
                    block.white.cost += means.white[range].iter().sum::<f64>();
                }
            }
            index += 1;
        });
        blocks
    }

    /// Sum over runs of neighbours of the squared sum of their whitened residuals, over their number; `from` is where they
    /// begin in their stretch.
    fn sums_of_neighbours(&self, index: usize, residual: &[f64], from: usize) -> f64 {
        let rows = self.rows_of(index, from..from + residual.len());
        let length = (rows / 16).clamp(NEIGHBOURS.0, NEIGHBOURS.1);
        let Some(means) = self.means.get(index) else {
            let run = |run: &[f64]| run.iter().sum::<f64>().powi(2) / run.len() as f64;
            return residual.chunks(length).map(run).sum();
        };
        let (mut sum, mut count, mut total) = (0.0, 0usize, 0.0);
        for (k, value) in residual.iter().enumerate() {
            let own = means.rows(from + k..from + k + 1);
            sum += means.roots[from + k] * value;
            count += own;
            // A mean of many runs shows their common part alone; what scatters within it scatters between them.
            let more = own.saturating_sub(length) as f64 / length as f64;
            total += more * means.white[from + k] / own as f64;
            if count >= length || k + 1 == residual.len() {
                total += sum * sum / count as f64;
                (sum, count) = (0.0, 0);
            }
        }
        total
    }

    /// Sum of squares and number of samples of every trace, not whitened.
    #[must_use]
    pub fn trace_squares(&self, point: &[f64]) -> Vec<(f64, usize)> {
        let mut sums = vec![(0.0, 0); self.data.labels.len()];
        let mut index = 0;
        self.each_piece(&[point.to_vec()], |piece, forces| {
            let (sum, count) = &mut sums[piece.trace];
            let mut residual: Vec<f64> =
                forces[0].iter().zip(piece.measured).map(|(f, y)| f - y).collect();
            self.weigh(index, &mut residual);
            *sum += residual.iter().map(|r| r * r).sum::<f64>();
            *sum += self.scatter(index).iter().sum::<f64>();
            *count += self.rows_of(index, 0..usize::MAX);
            index += 1;
        });
        sums
    }

    /// Root mean square of the residual, not whitened.
    #[must_use]
    pub fn rms(&self, point: &[f64]) -> f64 {
        let squares: f64 = self.trace_squares(point).iter().map(|(square, _)| square).sum();
        (squares / self.rows() as f64).sqrt()
    }

    /// What is left, not whitened, in a few numbers.
    #[must_use]
    pub fn residuals_in_short(&self, point: &[f64]) -> Residuals {
        let mut traces = vec![(0.0, 0); self.data.labels.len()];
        let mut product = 0.0;
        self.each_piece(&[point.to_vec()], |piece, forces| {
            let (square, count) = &mut traces[piece.trace];
            let mut before = 0.0;
            for (force, measured) in forces[0].iter().zip(piece.measured) {
                let residual = force - measured;
                product += before * residual;
                *square += residual * residual;
                before = residual;
            }
            *count += piece.measured.len();
        });
        let square: f64 = traces.iter().map(|(square, _)| square).sum();
        let rms = |(square, count): &(f64, usize)| (square / (*count as f64).max(1.0)).sqrt();
        Residuals {
            autocorrelation: if square > 0.0 { product / square } else { 0.0 },
            trace_rms: traces.iter().map(rms).collect(),
        }
    }

    /// Sums over no samples, where slow noise moves the levels of the traces.
    fn level_sums(&self, coordinates: usize) -> Option<LevelSums> {
        self.whitening.levels().map(|levels| LevelSums::zeros(coordinates, levels.traces()))
    }

    /// The whitened unit level of the stretch with this index; empty where nothing moves the levels.
    #[must_use]
    pub fn unit_level(&self, index: usize) -> Vec<f64> {
        if self.whitening.levels().is_none() {
            return Vec::new();
        }
        let mut unit = vec![1.0; self.data.pieces[index].measured.len()];
        self.whiten_at(index, &mut unit);
        unit
    }

    /// Takes out of normal equations what the levels of the traces could explain.
    pub fn marginalise(&self, sums: Option<&LevelSums>, normal: &mut Normal) {
        if let (Some(levels), Some(sums)) = (self.whitening.levels(), sums) {
            levels.marginalise(sums, normal);
        }
    }

    /// Sum of squares of the whitened residual of one trace, from that of its stretches by their index, without what
    /// its level could explain.
    fn whitened_square(&self, trace: usize, stretches: &mut [(usize, Vec<f64>)]) -> f64 {
        let (mut square, mut along, mut of_unit) = (0.0, 0.0, 0.0);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (index, residual) in stretches {
            let unit = self.unit_level(*index);
            self.whiten_residual(*index, residual);
            square += dot(residual, residual);
            square += self.means.get(*index).map_or(0.0, |means| means.white.iter().sum());
            along += dot(&unit, residual);
            of_unit += dot(&unit, &unit);
        }
        match self.whitening.levels() {
            Some(levels) => levels.of_one(trace, square, along, of_unit),
            None => square,
        }
    }

    /// Makes the noise of a derivative of the stretch with this index white.
    pub fn whiten_at(&self, index: usize, values: &mut [f64]) {
        match self.means.get(index) {
            Some(means) => means.filter.apply(values),
            None => self.whitening.apply(values),
        }
        for (value, root) in
            values.iter_mut().zip(self.roots.get(index).copied().unwrap_or_default())
        {
            *value *= root;
        }
    }

    /// The normal equations in one pass, where they can be had so.
    fn fused(&self, point: &[f64]) -> Option<Normal> {
        let fitted = |piece: &Piece| self.fitted(piece).then_some(0);
        let mut normal = self.in_one_pass(point, 1, fitted)?.pop()?;
        normal.cost += self.constant;
        Some(normal)
    }

    /// Moves a point, with these normal equations, to the best forces where they are always the best; the normal equations there.
    fn projected(&self, point: &mut [f64], normal: &Normal) -> Option<Normal> {
        if !self.projects {
            return None;
        }
        let is_force = |coordinate: &Coordinate| {
            matches!(coordinate, Coordinate::Force(_) | Coordinate::Total | Coordinate::Damping)
        };
        let list = self.coordinates.list();
        let forces = (0..list.len()).filter(|&j| is_force(&list[j]));
        let step = bounded_step_of(forces, normal, HARDLY, point, &self.bounds);
        let best: Vec<f64> = point.iter().zip(step.iter()).map(|(x, dx)| x + dx).collect();
        let there = self.fused(&best).filter(|there| there.cost < normal.cost)?;
        point.copy_from_slice(&best);
        Some(there)
    }

    /// [`LeastSquares::cost`] from where a set-up that yields came to before.
    pub(super) fn cost_from(&self, point: &[f64], reached: &mut Reached) -> f64 {
        self.fitted_cost(point, reached, |_, _, _| {})
    }

    /// [`LeastSquares::tried`] from there.
    pub(super) fn tried_from(
        &self,
        point: &mut [f64],
        reached: &mut Reached,
    ) -> (f64, Option<Normal>) {
        let Some(normal) = self.fused(point) else {
            return (self.cost_from(point, reached), None);
        };
        let normal = self.projected(point, &normal).unwrap_or(normal);
        (normal.cost, Some(normal))
    }

    /// [`LeastSquares::normal`] from there.
    pub(super) fn normal_from(&self, point: &[f64], reached: &mut Reached) -> Normal {
        if let Some(normal) = self.fused(point) {
            return normal;
        }
        let mut normal = Normal::zeros(point.len());
        normal.cost = self.unseen();
        let mut sums = self.level_sums(point.len());
        let mut index = 0;
        self.slopes(point, reached, |piece, residual, columns| {
            if self.fitted(piece) {
                self.whiten_residual(index, residual);
                for (_, column) in columns.iter_mut() {
                    self.whiten_at(index, column);
                }
                if let Some(sums) = &mut sums {
                    let unit = self.unit_level(index);
                    sums.add(piece.trace, &unit, columns, residual, 0);
                }
                normal.add(columns, residual, 0..residual.len());
            }
            index += 1;
        });
        self.marginalise(sums.as_ref(), &mut normal);
        normal
    }

    fn fitted(&self, piece: &Piece) -> bool {
        self.left_out.is_none_or(|fold| !fold.holds(piece.trace))
    }
}

/// What a fit leaves, in a few numbers.
#[derive(Clone, Debug)]
pub struct Residuals {
    /// Sum of products of neighbouring residuals over the sum of squares.
    pub autocorrelation: f64,
    /// Root mean square residual of each trace, in the unit of the signal.
    pub trace_rms: Vec<f64>,
}

/// The error on one trace.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    /// Sum of squares.
    pub square: f64,
    /// Sum of squares of the whitened residual.
    pub whitened: f64,
    /// Number of samples.
    pub samples: usize,
    /// Residual (predicted minus measured) before the touch, each value with the weight of the samples that it stands for.
    pub before: Vec<f64>,
}

/// A run of a chain at one point over the stretches of a data set, in order.
#[derive(Clone)]
struct Run {
    parameters: Vec<f64>,
    /// The base law where its derivatives can be carried along.
    carried: Option<Carried>,
    memory: Memory,
    history: History,
}

/// Derivatives of one stretch: coordinates and their columns.
pub type Columns = Vec<(usize, Vec<f64>)>;

/// Fewest blocks that data are taken apart into.
const FEWEST_BLOCKS: usize = 8;

/// The normal equations of one part of the data.
#[derive(Clone, Debug)]
pub struct Block {
    /// The trace it is of.
    pub trace: usize,
    /// Number of samples.
    pub samples: usize,
    /// The coordinates that it depends on: what other traces have of their own is not among them.
    pub coordinates: Vec<usize>,
    /// The normal equations of those, whitened.
    pub white: Normal,
    /// As they are.
    pub raw: Normal,
    /// Sum over runs of neighbours of the squared sum of their whitened residuals, over their number:
    /// the sum of squares times the number of samples that count as one.
    pub slow: f64,
    /// What the levels of the traces have in common with it, where slow noise moves them.
    pub levels: Option<LevelSums>,
}

/// Least and largest number of neighbours whose residuals are summed.
const NEIGHBOURS: (usize, usize) = (8, 216);

impl Block {
    fn new(trace: usize, coordinates: Vec<usize>) -> Self {
        let zeros = || Normal::zeros(coordinates.len());
        let (white, raw) = (zeros(), zeros());
        Self { trace, samples: 0, coordinates, white, raw, slow: 0.0, levels: None }
    }

    /// Its sums of squares after a step of all coordinates, as they are and whitened, as the straight line of the step foretells.
    #[must_use]
    pub fn foretold(&self, step: &DVector<f64>) -> (f64, f64) {
        let own = DVector::from_iterator(
            self.coordinates.len(),
            self.coordinates.iter().map(|&j| step[j]),
        );
        let after = |normal: &Normal| (normal.cost + normal.raised_by(&own)).max(0.0);
        (after(&self.raw), after(&self.white))
    }
}

/// Bounds of every coordinate.
fn bounds(coordinates: &Coordinates, chain: &Chain, data: &Data) -> Vec<(f64, f64)> {
    let mut bounds = coordinates.bounds(data);
    bounds.extend(chain.parameters()[chain.base.count()..].iter().map(|p| (p.lower, p.upper)));
    bounds
}

impl Normal {
    /// From products of the derivatives by the coordinates `moving`, of so many, and last of the residual.
    fn of(dimension: usize, moving: &[usize], products: &Products) -> Self {
        let mut normal = Self::zeros(dimension);
        let residual = moving.len();
        normal.cost = products.of(residual, residual);
        for (a, &i) in moving.iter().enumerate() {
            normal.gradient[i] = products.of(a, residual);
            for (b, &j) in moving.iter().enumerate() {
                normal.curvature[(i, j)] = products.of(a, b);
            }
        }
        normal
    }

    /// Adds so many times the normal equations of some of the coordinates.
    pub fn add_those_of(&mut self, coordinates: &[usize], own: &Self, times: f64) {
        self.cost += times * own.cost;
        for (a, &i) in coordinates.iter().enumerate() {
            self.gradient[i] += times * own.gradient[a];
            for (b, &j) in coordinates.iter().enumerate() {
                self.curvature[(i, j)] += times * own.curvature[(a, b)];
            }
        }
    }

    /// Adds a range of samples: derivatives column by column, and residuals.
    pub fn add(&mut self, columns: &Columns, residual: &[f64], range: Range<usize>) {
        // The residual counts as one more column: one product of few rows at a time, at hand in the cache,
        // gives all.
        let width = columns.len() + 1;
        let mut products = DMatrix::zeros(width, width);
        let mut entries = Vec::with_capacity(AT_A_TIME.min(range.len()) * width);
        for begin in range.clone().step_by(AT_A_TIME) {
            let part = begin..(begin + AT_A_TIME).min(range.end);
            let rows = part.len();
            entries.clear();
            for (_, column) in columns {
                entries.extend_from_slice(&column[part.clone()]);
            }
            entries.extend_from_slice(&residual[part]);
            let down = DMatrixView::from_slice(&entries, rows, width);
            products.gemm(1.0, &down.transpose(), &down, 1.0);
        }
        self.cost += products[(width - 1, width - 1)];
        for (a, (i, _)) in columns.iter().enumerate() {
            self.gradient[*i] += products[(a, width - 1)];
            for (b, (j, _)) in columns.iter().enumerate() {
                self.curvature[(*i, *j)] += products[(a, b)];
            }
        }
    }
}

impl LeastSquares for Problem<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn cost(&self, point: &[f64]) -> f64 {
        self.cost_from(point, &mut Reached::default())
    }

    fn tried(&self, point: &mut [f64]) -> (f64, Option<Normal>) {
        self.tried_from(point, &mut Reached::default())
    }

    fn normal(&self, point: &[f64]) -> Normal {
        self.normal_from(point, &mut Reached::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::whole_motion::predict;
    use palpate_model::effects::candidates;
    use palpate_model::{BaseLaw, Separation};
    use palpate_trace::{Column, DISPLACEMENT, FORCE, Trace};

    #[test]
    fn a_sample_that_a_step_moves_across_a_jump_follows_its_neighbours() {
        let smoothed = |mut differences: Vec<f64>| {
            smooth_jumps(&mut differences, 1e-4);
            differences
        };
        assert_eq!(smoothed(vec![1e-6, 0.02, 3e-6]), [1e-6, 2e-6, 3e-6]);
        assert_eq!(smoothed(vec![0.0, -0.02]), [0.0, 0.0]);
        for smooth in [vec![1e-3, 2e-3, 1e-3], vec![0.0, 9e-5, 0.0], vec![0.02, 0.02, 0.0]] {
            assert_eq!(smoothed(smooth.clone()), smooth);
        }
    }

    /// Two presses with holds, one after the other.
    fn traces() -> Vec<Trace> {
        [3.0, 2.0]
            .into_iter()
            .enumerate()
            .map(|(trace, deep)| {
                let time: Vec<f64> = (0..240).map(|k| 0.025 * f64::from(k)).collect();
                let course = |t: &f64| (4.0 * t - 1.0).min(deep).min(20.0 - 4.0 * t);
                let x: Vec<f64> = time.iter().map(course).collect();
                let force = x.iter().map(|x: &f64| 0.3 * x.max(0.0).powf(1.5)).collect();
                let mut trace_of = Trace {
                    time,
                    columns: vec![
                        Column { name: DISPLACEMENT.into(), values: x },
                        Column { name: FORCE.into(), values: force },
                    ],
                    ..Trace::default()
                };
                trace_of.head.setup.start_s = Some(9.0 * trace as f64);
                trace_of
            })
            .collect()
    }

    #[test]
    fn derivatives_beside_any_effect_are_those_of_the_whole_chain() {
        let traces = traces();
        let data = Data::of(&traces, FORCE).unwrap();
        let white = Whitening::none();
        let base = Chain::new(BaseLaw::fung(2, Separation::Clamp));
        let mut carried = 0;
        for candidate in candidates(&data.setting(), &[]).unwrap() {
            for form in candidate.forms.iter().filter(|_| candidate.missing.is_none()) {
                let chain = base.with(form.applied.clone());
                let problem = Problem::new(&chain, &data, &white, None);
                let strengths = std::iter::repeat_n(form.typical, form.applied.strengths);
                let shapes = form.grid[0].iter().copied();
                let point: Vec<f64> = [0.4, 0.3, 0.2, 0.6, 1.2, -0.7]
                    .into_iter()
                    .chain(strengths)
                    .chain(shapes)
                    .collect();
                carried += usize::from(problem.run_at(&point).carried.is_some());
                let at = |j: usize, step: f64| {
                    let mut moved = point.clone();
                    moved[j] += step;
                    predict(&chain, &problem.declared(&moved), &data)
                };
                let steps = problem.steps(&point);
                let mut found: Vec<Vec<Vec<f64>>> = Vec::new();
                problem.derivatives(&point, |piece, residual, columns| {
                    let index = found.len();
                    let force: Vec<f64> =
                        residual.iter().zip(piece.measured).map(|(r, y)| r + y).collect();
                    let expected = &at(0, 0.0)[index];
                    assert!(distance(&force, expected) < 1e-11, "{}", form.applied.law);
                    let mut all = vec![Vec::new(); point.len()];
                    for (j, column) in columns {
                        all[j] = column;
                    }
                    found.push(all);
                });
                for j in 0..point.len() {
                    let (here, there) = (at(j, 0.0), at(j, steps[j]));
                    for (piece, columns) in found.iter().enumerate() {
                        // What belongs to another trace alone has no column.
                        if columns[j].is_empty() {
                            continue;
                        }
                        let slope: Vec<f64> = here[piece]
                            .iter()
                            .zip(&there[piece])
                            .map(|(a, b)| (b - a) / steps[j])
                            .collect();
                        let off = distance(&columns[j], &slope);
                        let size = slope.iter().map(|s| s * s).sum::<f64>().sqrt();
                        assert!(
                            off < 1e-3 * size + 1e-5,
                            "{} ({}) coordinate {j}: off by {off:.1e} of {size:.1e}",
                            candidate.name,
                            form.applied.law
                        );
                    }
                }
            }
        }
        assert!(carried > 20, "{carried}");
    }

    #[test]
    fn traces_left_out_have_the_same_errors_where_no_more_is_run() {
        let traces = traces();
        let data = Data::of(&traces, FORCE).unwrap();
        let white = Whitening::none();
        let chain = Chain::new(BaseLaw::fung(2, Separation::Clamp));
        let problem = Problem::new(&chain, &data, &white, None);
        let point = [0.4, 0.3, 0.2, 0.6, 1.2, -0.7];
        for trace in 0..2 {
            let others = problem.leaving_out(Fold::alone(trace));
            let all = others.apart(&point).1;
            let found = others.left_out_squares(&point);
            assert_eq!((found.len(), found[0].1), (1, all[0].samples));
            assert!((found[0].0 - all[0].square).abs() < 1e-12 * all[0].square);
        }
    }

    fn distance(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }
}
