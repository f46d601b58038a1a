//! The chain *motion → elasticity → relaxation → contact → sensor*: a base law with effects, run over
//! motions.

use std::borrow::Cow;
use std::sync::Arc;

use super::act::{Act, Remembered, Stage};
use super::hereditary::HereditaryState;
use super::tangent::Tangent;
use super::yielding::StretchYielding;
use super::{BaseLaw, Elastic, Parameter, Response, Scene, Separation};

/// An effect in a model: its name, the law chosen for it, its parameters and how it acts.
#[derive(Clone, Debug)]
pub struct Applied {
    /// Name of the effect.
    pub name: String,
    /// Name of the law where the effect has more than one.
    pub law: String,
    /// Where in the chain it acts.
    pub stage: Stage,
    /// Its parameters, strengths first.
    pub parameters: Vec<Parameter>,
    /// Number of strengths among the parameters: at zero strength the effect is absent.
    pub strengths: usize,
    /// Number of strengths that every trace has of its own, trace by trace; 0 where all share them.
    pub each_trace: usize,
    /// How it acts.
    pub act: Act,
}

/// A base law with the effects added to it.
#[derive(Clone, Debug)]
pub struct Chain {
    /// The base law.
    pub base: BaseLaw,
    /// The effects, in the order in which they were added.
    pub effects: Vec<Applied>,
}

/// What specimen and sensor remember from stretch to stretch.
#[derive(Debug, Default)]
pub struct History {
    pub(super) relaxation: HereditaryState,
    effects: Vec<Remembered>,
}

impl Clone for History {
    fn clone(&self) -> Self {
        Self { relaxation: self.relaxation.clone(), effects: self.effects.clone() }
    }

    fn clone_from(&mut self, other: &Self) {
        self.relaxation.clone_from(&other.relaxation);
        self.effects.clone_from(&other.effects);
    }
}

/// What most of the runs of a fit have in common: the elastic response of a unit stiffness at the compressions
/// it was last asked for, which copies share, and where a set-up that yields came to.
#[derive(Clone, Debug, Default)]
pub struct Elasticity {
    unit: Arc<Unit>,
    pub(super) yielding: StretchYielding,
    pub(super) tangent: Arc<Tangent>,
    /// Along which the elastic response is followed in a run nearby.
    near: Option<Arc<Tangent>>,
}

#[derive(Debug, Default)]
struct Unit {
    law: (Elastic, Separation),
    shape: f64,
    x: Vec<f64>,
    response: Vec<f64>,
}

impl Elasticity {
    /// That of this shape at these displacements x, mm, so far as the specimen feels them.
    #[must_use]
    pub fn at(law: (Elastic, Separation), shape: f64, x: &[f64]) -> Self {
        let (elastic, separation) = law;
        let response = x.iter().map(|&x| elastic.unit(shape, separation.felt(x))).collect();
        Self { unit: Arc::new(Unit { law, shape, x: x.to_vec(), response }), ..Self::default() }
    }

    /// The same for a run whose parameters differ a little from those of the last one: where a set-up yields, what is nearby is
    /// followed to a hundredth of the difference.
    #[must_use]
    pub fn nearby(&self) -> Self {
        Self {
            unit: Arc::clone(&self.unit),
            yielding: self.yielding.nearby(),
            tangent: Arc::clone(&self.tangent),
            near: Some(Arc::clone(&self.tangent)),
        }
    }

    /// The next run is over the last stretch with the same numbers: what yields stays where it came to.
    pub fn stay(&mut self) {
        self.yielding.stay();
    }

    /// Elastic response N, N, of this stiffness and shape at each displacement x, mm, so far as the specimen feels it.
    pub(super) fn response(
        &mut self,
        law: (Elastic, Separation),
        (p, shape): (f64, f64),
        x: &[f64],
    ) -> Vec<f64> {
        let same = self.unit.shape.to_bits() == shape.to_bits() && self.unit.law == law;
        let slopes = self.near.as_deref().map_or(&[][..], Tangent::elastic);
        if same && slopes.len() == x.len() && self.unit.x.len() == x.len() {
            let unit = self.unit.response.iter().zip(&self.unit.x).zip(slopes).zip(x);
            return unit.map(|(((unit, at), slope), x)| p * (unit + slope * (x - at))).collect();
        }
        if !same || self.unit.x != x {
            self.unit = Self::at(law, shape, x).unit;
        }
        self.unit.response.iter().map(|unit| p * unit).collect()
    }
}

impl Chain {
    /// The base law alone.
    #[must_use]
    pub fn new(base: BaseLaw) -> Self {
        Self { base, effects: Vec::new() }
    }

    /// This chain with one more effect.
    #[must_use]
    pub fn with(&self, effect: Applied) -> Self {
        let mut chain = self.clone();
        chain.effects.push(effect);
        chain
    }

    /// This chain without the effect with this index.
    #[must_use]
    pub fn without(&self, index: usize) -> Self {
        let mut chain = self.clone();
        chain.effects.remove(index);
        chain
    }

    /// All parameters: those of the base law, then those of each effect.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let effects = self.effects.iter().flat_map(|effect| effect.parameters.iter().cloned());
        self.base.parameters().into_iter().chain(effects).collect()
    }

    /// Where the parameters of the effect with this index stand among all.
    #[must_use]
    pub fn range(&self, index: usize) -> std::ops::Range<usize> {
        let count = |effect: &Applied| effect.parameters.len();
        let begin = self.base.count() + self.effects[..index].iter().map(count).sum::<usize>();
        begin..begin + count(&self.effects[index])
    }

    /// Predicts the signal over one stretch, sample by sample, into `force`.
    ///
    /// `parameters` are in the order of [`Chain::parameters`]. `history` is what specimen and sensor
    /// remember; it is left as the stretch leaves it. `elasticity` spares work from run to run. A stretch
    /// that starts in contact counts as having just arrived there.
    pub fn run(
        &self,
        parameters: &[f64],
        scene: &Scene,
        history: &mut History,
        elasticity: &mut Elasticity,
        force: &mut Vec<f64>,
    ) {
        let x = self.upstream(parameters, scene, history);
        let yields: Vec<_> = self
            .effects
            .iter()
            .enumerate()
            .filter_map(|(index, effect)| match effect.act {
                Act::Yield(law) => Some((law, &parameters[self.range(index)])),
                _ => None,
            })
            .collect();
        let yielded = |force: f64| yields.iter().map(|(law, own)| law(own, force)).sum::<f64>();
        let next = |x: f64, force: f64| x - yielded(force);
        let stretch = (&scene.motion.time[..], &x[..], scene.motion.rest_before);
        let start = scene.motion.time.first().copied().unwrap_or(0.0);
        if yields.is_empty() {
            self.contact(parameters, scene, (history, elasticity), &x, force);
        } else if let Some(response) = self.bare_response(parameters) {
            response.run_yielding(stretch, &mut history.relaxation, next, force);
            elasticity.yielding.came_to(start, force.iter().map(|&force| yielded(force)));
        } else {
            self.settle(parameters, scene, (history, elasticity), &x, yielded, force);
        }
        self.act_on_force(Stage::Sensor, parameters, scene, history, force);
    }

    /// The base law's response where nothing but a set-up that yields acts between the commanded motion and
    /// the contact force, and that can be followed sample by sample.
    fn bare_response(&self, parameters: &[f64]) -> Option<Response> {
        let bare = self.effects.iter().all(|effect| match effect.act {
            Act::Compression(_) | Act::Yield(_) => true,
            Act::Force(_) | Act::Added(_) => effect.stage == Stage::Sensor,
            Act::Own(_) => matches!(effect.stage, Stage::Motion | Stage::Sensor),
            _ => false,
        });
        let response = bare.then(|| self.base.response(parameters));
        response.filter(Response::can_yield)
    }

    /// Whether every effect acts before the base law or after it: on the compression that reaches the
    /// specimen, or on the force that comes of it.
    #[must_use]
    pub fn leaves_base_alone(&self) -> bool {
        self.effects.iter().all(|effect| match effect.act {
            Act::Compression(_) | Act::Force(_) | Act::Added(_) => true,
            Act::Own(_) => !matches!(effect.stage, Stage::Elasticity | Stage::Relaxation),
            _ => false,
        })
    }

    /// The compression x, mm, that reaches the specimen where nothing feeds back on it.
    pub fn upstream<'a>(
        &self,
        parameters: &[f64],
        scene: &'a Scene,
        history: &mut History,
    ) -> Cow<'a, [f64]> {
        history.effects.resize(self.effects.len(), Remembered::new());
        let mut x = Cow::Borrowed(&scene.motion.displacement[..]);
        self.each(parameters, history, |act, own, remembered, stage| match act {
            Act::Compression(law) => law(scene, own, remembered, x.to_mut()),
            Act::Own(expression) if stage == Stage::Motion => {
                expression.add(scene, own, x.to_mut());
            }
            _ => {}
        });
        x
    }

    /// Lets everything act on the force, N, of the base law that acts on it in contact and in the sensor.
    pub fn downstream(
        &self,
        parameters: &[f64],
        scene: &Scene,
        history: &mut History,
        force: &mut [f64],
    ) {
        history.effects.resize(self.effects.len(), Remembered::new());
        for stage in [Stage::Contact, Stage::Sensor] {
            self.act_on_force(stage, parameters, scene, history, force);
        }
    }

    fn act_on_force(
        &self,
        at: Stage,
        parameters: &[f64],
        scene: &Scene,
        history: &mut History,
        force: &mut [f64],
    ) {
        self.each(parameters, history, |act, own, remembered, stage| match act {
            Act::Force(law) | Act::Added(law) if stage == at => law(scene, own, remembered, force),
            Act::Own(expression) if stage == at => expression.add_to_force(scene, own, force),
            _ => {}
        });
    }

    /// Whether everything that acts on the force adds the same to it, whatever it is.
    #[must_use]
    pub fn only_adds_to_force(&self) -> bool {
        self.effects.iter().all(|effect| match &effect.act {
            Act::Force(_) => false,
            Act::Own(expression) => {
                !matches!(effect.stage, Stage::Contact | Stage::Sensor)
                    || !expression.follows_force()
            }
            _ => true,
        })
    }

    /// Whether the set-up yields under the force.
    #[must_use]
    pub fn yields(&self) -> bool {
        self.effects.iter().any(|effect| matches!(effect.act, Act::Yield(_)))
    }

    /// Whether the last effect acts on what the chain without it predicts: it changes the force, nothing acts after it, and nothing
    /// feeds back from it.
    #[must_use]
    pub fn ends_with_last(&self) -> bool {
        let Some((last, before)) = self.effects.split_last() else { return false };
        let stage = last.stage;
        let follows = |effect: &Applied| {
            effect.stage > stage || (matches!(effect.act, Act::Yield(_)) && stage < Stage::Sensor)
        };
        let on_force = match last.act {
            Act::Force(_) | Act::Added(_) => true,
            Act::Own(_) => matches!(stage, Stage::Contact | Stage::Sensor),
            _ => false,
        };
        on_force && !before.iter().any(follows)
    }

    /// Lets the last effect alone act on `force`, which the chain without it predicts: the same as a run of the whole chain where it
    /// [ends with it](Self::ends_with_last).
    pub fn run_last(
        &self,
        parameters: &[f64],
        scene: &Scene,
        history: &mut History,
        force: &mut [f64],
    ) {
        history.effects.resize(self.effects.len(), Remembered::new());
        let (Some(effect), Some(remembered)) = (self.effects.last(), history.effects.last_mut())
        else {
            return;
        };
        let own = &parameters[parameters.len() - effect.parameters.len()..];
        match &effect.act {
            Act::Force(law) | Act::Added(law) => law(scene, own, remembered, force),
            Act::Own(expression) => expression.add_to_force(scene, own, force),
            _ => {}
        }
    }

    /// From the compression to the contact force.
    pub(super) fn contact(
        &self,
        parameters: &[f64],
        scene: &Scene,
        (history, elasticity): (&mut History, &mut Elasticity),
        x: &[f64],
        force: &mut Vec<f64>,
    ) {
        let mut response = self.base.response(parameters);
        let separation = self.base.separation;
        self.each(parameters, history, |act, own, remembered, stage| match act {
            Act::Relaxation(law) => {
                law(scene, own, remembered, &separation.all_felt(x), &mut response.hereditary);
            }
            Act::Own(expression) if stage == Stage::Relaxation => {
                expression.change_rates(scene, own, x, &mut response.hereditary);
            }
            _ => {}
        });
        let mut relaxation = std::mem::take(&mut history.relaxation);
        let motion = &scene.motion;
        response.run(
            (&motion.time, x, motion.rest_before),
            (&mut relaxation, elasticity),
            |x, elastic| {
                self.each(parameters, history, |act, own, remembered, stage| match act {
                    Act::Elastic(law) => {
                        law(scene, own, remembered, &separation.all_felt(x), elastic);
                    }
                    Act::Own(expression) if stage == Stage::Elasticity => {
                        expression.add_to_elastic(scene, own, x, elastic);
                    }
                    _ => {}
                });
            },
            force,
        );
        history.relaxation = relaxation;
        self.act_on_force(Stage::Contact, parameters, scene, history, force);
    }

    /// Hands every effect its own parameters and memory.
    fn each(
        &self,
        parameters: &[f64],
        history: &mut History,
        mut act: impl FnMut(&Act, &[f64], &mut Remembered, Stage),
    ) {
        let mut begin = self.base.count();
        for (effect, remembered) in self.effects.iter().zip(&mut history.effects) {
            let own = &parameters[begin..begin + effect.parameters.len()];
            begin += own.len();
            act(&effect.act, own, remembered, effect.stage);
        }
    }

    /// Where among all parameters those stand that belong to one trace alone: none for a trace that the
    /// chain was not made for.
    #[must_use]
    pub fn own_of_trace(&self, trace: usize) -> Vec<usize> {
        let own = |index: usize| {
            let count = self.effects[index].each_trace;
            let known = (trace + 1) * count <= self.effects[index].strengths;
            let begin = self.range(index).start + trace * count;
            begin..begin + if known { count } else { 0 }
        };
        (0..self.effects.len()).flat_map(own).collect()
    }
}
