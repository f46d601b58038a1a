//! The chain at a point over the stretches of the data, in order: what is remembered stays right.

use std::borrow::Cow;

use super::Problem;
use crate::carried::{Carried, Measured, Memory, Stretch, logarithms};
use crate::columns::Products;
use crate::data::Piece;
use crate::least_squares::Normal;
use crate::watch;
use palpate_model::{Act, Coordinate, Elasticity, History, Scene, Stage};

/// A run of a chain at one point over the stretches of a data set, in order.
#[derive(Clone)]
pub(super) struct Run {
    pub(super) parameters: Vec<f64>,
    /// The base law where its derivatives can be carried along.
    pub(super) carried: Option<Carried>,
    pub(super) memory: Memory,
    pub(super) history: History,
}

impl<'a> Problem<'a> {
    pub(super) fn scene(&self, index: usize) -> Scene<'a> {
        self.data.scene(&self.data.pieces[index])
    }

    /// What effects see of a stretch; none where there are none to see it.
    pub(super) fn seen(&self, index: usize) -> Option<Scene<'a>> {
        (!self.chain.effects.is_empty()).then(|| self.scene(index))
    }

    /// A run at a point, before the first stretch.
    pub(super) fn run_at(&self, point: &[f64]) -> Run {
        Run {
            parameters: self.declared(point),
            carried: Carried::new(self.chain, &self.coordinates, point),
            memory: Memory::default(),
            history: History::default(),
        }
    }

    /// Takes a run over the stretch with this index, the next in order: what it predicts goes to `force`.
    pub(super) fn advance(
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
    pub(super) fn relax(
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

    /// From the force of a carried base law to the signal.
    pub(super) fn sense(&self, run: &mut Run, index: usize, force: &mut [f64]) {
        if let Some(scene) = self.seen(index) {
            self.chain.downstream(&run.parameters, &scene, &mut run.history, force);
        }
    }

    /// Whether the effect that this coordinate is of acts on the force that the base law makes.
    pub(super) fn acts_after(&self, coordinate: usize) -> bool {
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

    /// Sums of products of the derivatives and of the residual, for each of so many groups of stretches; no derivative is written down.
    /// None where the law is not carried, something acts beside it or whitens, means stand for samples, or what follows from the motions is
    /// not kept.
    pub(super) fn in_one_pass(
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
}
