//! A stretch of a chain whose set-up yields, where what happens at one sample depends on those before.

use std::sync::Arc;

use super::chain::{Chain, Elasticity, History};
use super::hereditary::Hereditary;
use super::tangent::{Here, Tangent};
use super::yielding::{Settling, StretchYielding};
use super::{Act, Response, Scene};

/// A stretch of a chain whose set-up yields.
struct Yields<'a, Run, Yielded> {
    /// From compressions, mm, to the contact force, N.
    run: Run,
    /// Commanded compressions, mm.
    x: &'a [f64],
    time: &'a [f64],
    response: &'a Response,
    memory: Option<Hereditary>,
    /// Whether the tangent holds at its compressions.
    nearby: bool,
    /// The numbers of the laws by which it yields.
    laws: &'a [f64],
    /// What yields, mm, under a force, N.
    yielded: Yielded,
    /// The compressions, mm, of the last run, and the force, N, at them.
    at: Vec<f64>,
    force: &'a mut Vec<f64>,
    tangent: &'a mut Arc<Tangent>,
}

impl<Run, Yielded: Fn(f64) -> f64> Yields<'_, Run, Yielded> {
    /// Takes the tangent where the last run was.
    fn take_tangent(&mut self) {
        let here = (&self.at[..], &self.force[..]);
        Arc::make_mut(self.tangent).take(self.response, here, (self.laws, &self.yielded));
    }
}

impl<Run, Yielded> Settling for Yields<'_, Run, Yielded>
where
    Run: FnMut(&[f64], &mut Vec<f64>),
    Yielded: Fn(f64) -> f64,
{
    fn next(&mut self, at: &[f64]) -> Vec<f64> {
        (self.run)(at, self.force);
        self.at.clear();
        self.at.extend_from_slice(at);
        let near = self.nearby.then(|| self.tangent.yielded(self.laws, self.force)).flatten();
        let yielded =
            near.unwrap_or_else(|| self.force.iter().map(|&force| (self.yielded)(force)).collect());
        self.x.iter().zip(yielded).map(|(x, yielded)| x - yielded).collect()
    }

    fn moves(&mut self, rest: &[f64], anew: bool) -> Option<Vec<f64>> {
        if self.memory.is_some() && (anew || !self.tangent.knows(rest.len())) {
            self.take_tangent();
        }
        let memory = self.memory.as_ref()?;
        let yielded: Vec<f64> = self.x.iter().zip(&self.at).map(|(x, at)| x - at).collect();
        let force = &self.force[..];
        let here = Here { commanded: self.x, yielded: &yielded, open: rest, force };
        Some(self.tangent.moves((self.response.p, memory), self.time, &here))
    }
}

impl Chain {
    /// Runs over a stretch of a set-up that yields where what happens at one sample depends on those before: commanded compressions x, mm,
    /// and what yields, mm, under a force, N.
    pub(super) fn settle(
        &self,
        parameters: &[f64],
        scene: &Scene,
        (history, elasticity): (&mut History, &mut Elasticity),
        x: &[f64],
        yielded: impl Fn(f64) -> f64,
        force: &mut Vec<f64>,
    ) {
        let time = &scene.motion.time[..];
        let start = time.first().copied().unwrap_or(0.0);
        let before = history.clone();
        let mut yielding = std::mem::take(&mut elasticity.yielding);
        let mut tangent = std::mem::take(&mut elasticity.tangent);
        let response = self.base.response(parameters);
        let yields = |index: &usize| matches!(self.effects[*index].act, Act::Yield(_));
        let laws = (0..self.effects.len()).filter(yields);
        let laws: Vec<f64> =
            laws.flat_map(|index| &parameters[self.range(index)]).copied().collect();
        loop {
            let known = yielding.knows(start, x.len());
            // What is known of the tangent holds near where it was taken.
            let holds = yielding.is_nearby() || yielding.stays();
            if !known && response.can_yield() {
                // Where the base law alone comes to is near.
                let mut alone = before.relaxation.clone();
                let next = |x: f64, force: f64| x - yielded(force);
                let stretch = (time, x, scene.motion.rest_before);
                response.run_yielding(stretch, &mut alone, next, force);
                yielding.comes_near(start, force.iter().map(|&force| yielded(force)));
            }
            let mut stretch = Yields {
                run: |at: &[f64], force: &mut Vec<f64>| {
                    history.clone_from(&before);
                    self.contact(parameters, scene, (history, elasticity), at, force);
                },
                x,
                time,
                response: &response,
                memory: response.memory_of_moves(),
                nearby: yielding.is_nearby(),
                laws: &laws,
                yielded: &yielded,
                at: Vec::new(),
                force,
                tangent: &mut tangent,
            };
            yielding.settle(start, x, &mut stretch);
            if !(known && yielding.is_open()) {
                if !holds {
                    stretch.take_tangent();
                }
                break;
            }
            // From where another run came to it does not settle.
            yielding = StretchYielding::default();
        }
        (elasticity.yielding, elasticity.tangent) = (yielding, tangent);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Scales, Setting, find};
    use crate::hereditary::HereditaryState;
    use crate::{Applied, BaseLaw, Motion, Separation};

    fn applied(effect: &str, law: &str, setting: &Setting) -> Applied {
        let effect = find(effect).unwrap();
        let law = effect.laws.iter().find(|it| it.name == law).unwrap();
        law.applied(effect, setting)
    }

    /// The forces of a chain of a bonded specimen that rubs, in a joint that yields c (F/F0)^m, and those sample by sample.
    fn pulled(q: f64, (c, m): (f64, f64), friction: f64) -> (Vec<f64>, Vec<f64>) {
        const FULL: f64 = 0.88;
        let time: Vec<f64> = (0..600).map(|k| 0.05 * f64::from(k)).collect();
        let course = |t: &f64| (0.5 * t).min(9.0 - 0.5 * (t - 18.0)).max(0.0);
        let x: Vec<f64> = time.iter().map(course).collect();
        let scales = Scales { force: FULL, compression: 9.0, speed: 0.5, ..Scales::default() };
        let setting = Setting { scales, ..Setting::default() };
        let rubs = applied("load-friction", "dahl", &setting);
        let joint = applied("fixture-compliance", "joint", &setting);
        let base = BaseLaw::fung(2, Separation::Bonded);
        let of_law = [0.15, q, 0.25, 0.24, 4.0, 0.55];
        let chain = Chain::new(base).with(rubs.clone()).with(joint);
        let of_rubbing = [friction, 0.05];
        let parameters = [&of_law[..], &of_rubbing, &[c, m, FULL]].concat();
        let motion =
            Motion { time: (&time[..]).into(), displacement: (&x[..]).into(), rest_before: None };
        let zero = vec![0.0; x.len()];
        let scene = Scene {
            trace: 0,
            motion: &motion,
            since: (&time[..]).into(),
            begin: 0.0,
            velocity: (&zero[..]).into(),
            acceleration: (&zero[..]).into(),
            loadings: (&zero[..]).into(),
            largest: (&zero[..]).into(),
            warmth: None,
            channels: &[],
            measured: &[],
        };
        let mut force = Vec::new();
        let (mut history, mut elasticity) = (History::default(), Elasticity::default());
        chain.run(&parameters, &scene, &mut history, &mut elasticity, &mut force);

        let Act::Force(rub) = &rubs.act else { panic!("friction acts on the force") };
        let mut times = vec![1.0; x.len()];
        rub(&scene, &of_rubbing, &mut Vec::new(), &mut times);
        let response = base.response(&of_law);
        let mut state = HereditaryState::default();
        let one_by_one = (0..x.len()).map(|k| {
            let carried = |state: &mut HereditaryState, z: f64| match k {
                0 => response.begin(state, z),
                _ => response.advance(state, time[k] - time[k - 1], z),
            };
            let yields = |z: f64| {
                let force = times[k] * carried(&mut state.clone(), z);
                c * force.signum() * (force / FULL).abs().powf(m)
            };
            let (mut below, mut above) = (x[k] - 20.0, x[k] + 20.0);
            for _ in 0..200 {
                let middle = 0.5 * (below + above);
                if middle + yields(middle) < x[k] { below = middle } else { above = middle }
            }
            times[k] * carried(&mut state, 0.5 * (below + above))
        });
        (force, one_by_one.collect())
    }

    #[test]
    fn a_joint_that_closes_under_a_specimen_that_rubs_settles_where_its_samples_do() {
        for q in [-0.5, -0.1, 0.5] {
            for joint in [(3.0, 0.45), (2.0, 0.5), (1.0, 0.7), (1.0, 1.0), (0.5, 2.0)] {
                for friction in [0.0, 0.1, 0.3] {
                    let (force, expected) = pulled(q, joint, friction);
                    let most = expected.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
                    let off = force.iter().zip(&expected).map(|(a, b)| (a - b).abs());
                    let off = off.fold(0.0, f64::max);
                    assert!(
                        off < 1e-4 * most,
                        "{q} {joint:?} {friction}: {off:.1e} of {most:.1e} N"
                    );
                }
            }
        }
    }
}
