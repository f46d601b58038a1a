//! Derivatives of the residual by the coordinates, stretch by stretch.

use std::mem::take;

use super::Problem;
use super::run::Run;
use crate::data::Piece;
use crate::remembering::Reached;
use palpate_model::{Coordinate, History};

/// Derivatives of one stretch: coordinates and their columns.
pub type Columns = Vec<(usize, Vec<f64>)>;

/// Step of a derivative, relative to the coordinate and to its range.
const STEP: (f64, f64) = (1e-6, 1e-8);
/// Part of the largest signal of a stretch by which a step of a derivative moves none of its samples but across a jump of a law, and
/// how many times as far as its neighbours it moves one there.
const LEAP: f64 = 3e-5;
const ALONE: f64 = 30.0;

impl Problem<'_> {
    /// Steps of the derivatives at a point, within the bounds.
    pub(crate) fn steps(&self, point: &[f64]) -> Vec<f64> {
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
    pub(super) fn slopes(
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
}

/// Lets samples that a step moves across a jump, farther than `least` and alone, follow their neighbours: the jump says nothing of the
/// slope.
pub(super) fn smooth_jumps(differences: &mut [f64], least: f64) {
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
