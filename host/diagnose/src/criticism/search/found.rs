//! What a search found: the steps, the model and the evidence after each, and what was refused.

use super::{SURE, Search};
use crate::criticism::evidence::{Evidence, Judged, Refusal, Refused};
use crate::criticism::fitted::Fitted;
use crate::criticism::screen::Screen;
use palpate_fit::problem::Problem;

/// Part of all that was explained so far that a further effect must explain to be tried beside the others: one that is right
/// may take their place.
const WORTH_TRYING: f64 = 0.04;

/// One effect of a model and what speaks for it.
#[derive(Clone, Debug)]
pub struct Step {
    /// Name of the effect.
    pub effect: String,
    /// Chance under noise alone of a score as large, over the whole library.
    pub p_value: f64,
    /// Every effect that was refitted in its place, best first.
    pub rivals: Vec<Rival>,
    /// Names that the data do not tell apart, the effect first.
    pub credible: Vec<String>,
    /// Whether the rivals were refitted beside the other effects of the model.
    pub(in crate::criticism) fresh: bool,
}

impl Step {
    /// An effect that was chosen among rivals beside the last model.
    #[must_use]
    pub fn chosen(effect: String, p_value: f64, rivals: Vec<Rival>, credible: Vec<String>) -> Self {
        Self { effect, p_value, rivals, credible, fresh: true }
    }
}

/// An effect refitted beside the others of a model.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Which candidate.
    pub candidate: usize,
    /// Name of the effect.
    pub effect: String,
    /// The model with it.
    pub fitted: Fitted,
    /// Part of the resamplings of the data in which it is best.
    pub won: f64,
}

impl Rival {
    /// Its own law: other effects may stand beside it in the model.
    #[must_use]
    pub fn law(&self) -> Option<&str> {
        let mut effects = self.fitted.chain.effects.iter();
        effects.find(|effect| effect.name == self.effect).map(|effect| effect.law.as_str())
    }
}

/// What a search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The model without effects of the search.
    pub base: Fitted,
    /// The effects found.
    pub steps: Vec<Step>,
    /// The model after each.
    pub models: Vec<Fitted>,
    /// The last screen: what could still be missing.
    pub last: Screen,
    /// The screen of the base.
    pub first: Screen,
    /// Whether what the last model leaves need not be noise: names were chosen by the traces left out,
    /// and p values are those of the agreement between parts of the data.
    pub inexact: bool,
    /// The evidence beside the fit for the base and for the model after each step.
    pub evidence: Vec<Evidence>,
    /// What was tried and refused.
    pub refused: Vec<Refused>,
}

impl Found {
    /// The model with all effects found.
    #[must_use]
    pub fn model(&self) -> &Fitted {
        self.models.last().unwrap_or(&self.base)
    }

    /// Error of the last model on traces, or on sections of a single one, left out.
    #[must_use]
    pub fn held_out_rms(&self) -> Option<f64> {
        Some(self.evidence.last()?.left_out()?.rms)
    }

    /// The members of the first credible set with several: their names and models, the best first.
    #[must_use]
    pub fn undecided(&self) -> Vec<(&str, &Fitted)> {
        let Some(step) = self.steps.iter().find(|step| step.credible.len() > 1) else {
            return Vec::new();
        };
        let member = |name: &'_ String| {
            let rival = step.rivals.iter().find(|rival| rival.effect == *name);
            rival.map(|rival| (rival.effect.as_str(), &rival.fitted))
        };
        step.credible.iter().filter_map(member).collect()
    }

    /// Takes the parameters of the last model from the samples that the data of the search stand for, and the errors of every rung over
    /// all rows; goes back to the rung before the first at which one of them rises.
    pub fn score(&mut self, search: &Search, rows: &Problem) {
        for index in 0..=self.steps.len() {
            self.score_rung(index, search, rows);
            let Some(step) = index.checked_sub(1) else { continue };
            let (without, with) = (self.judged(step), self.judged(index));
            if let Some(reason) = rises(without, with) {
                let denied = refused(&self.steps[step].effect, without, with, reason);
                return self.go_back_to(step, denied);
            }
        }
    }

    /// Goes back to the rung before the first step whose gain on traces left out is within two standard errors of none.
    pub(in crate::criticism) fn keep_what_surely_predicts(&mut self) {
        for step in 0..self.steps.len() {
            let (without, with) = (self.judged(step), self.judged(step + 1));
            let gain = with.evidence.gain(without.evidence);
            if let Some(gain) = gain.filter(|gain| !gain.exceeds(SURE)) {
                let reason = Refusal::HeldOutUncertain(gain);
                let denied = refused(&self.steps[step].effect, without, with, reason);
                return self.go_back_to(step, denied);
            }
        }
    }

    /// Takes back what comes after so many steps, the first of which was denied.
    pub(super) fn go_back_to(&mut self, steps: usize, denied: Refused) {
        self.steps.truncate(steps);
        self.models.truncate(steps);
        self.evidence.truncate(steps + 1);
        self.refuse([denied]);
    }

    /// The same for the model after so many steps: the last one's parameters too.
    fn score_rung(&mut self, steps: usize, search: &Search, rows: &Problem) {
        let is_last = steps == self.steps.len();
        let fitted = match steps.checked_sub(1) {
            Some(step) => &mut self.models[step],
            None => &mut self.base,
        };
        if is_last && search.problem.stands_for_samples() {
            fitted.confirm(search.samples);
        }
        search.take_errors_of(rows, fitted, &mut self.evidence[steps]);
    }

    /// Takes down what was refused, the latest trial of each effect.
    pub fn refuse(&mut self, refused: impl IntoIterator<Item = Refused>) {
        for refused in refused {
            self.refused.retain(|earlier| earlier.effect != refused.effect);
            self.refused.push(refused);
        }
    }

    /// Whether an effect is among the steps.
    #[must_use]
    pub fn names(&self, effect: &str) -> bool {
        self.steps.iter().any(|step| step.effect == effect)
    }

    /// Whether a further effect explains next to nothing of what those before it did.
    pub(super) fn hardly_explains(&self, with: &Fitted) -> bool {
        let current = self.model();
        let explained = self.base.cost - current.cost;
        !self.steps.is_empty() && current.cost - with.cost < WORTH_TRYING * explained
    }

    /// Takes back every step: what the base leaves is described better by what is no effect.
    pub fn name_nothing(&mut self) {
        self.steps.clear();
        self.models.clear();
        self.last = self.first.clone();
        self.inexact = true;
    }

    /// The model after so many steps, with its evidence.
    pub(super) fn judged(&self, steps: usize) -> Judged<'_> {
        let fitted = steps.checked_sub(1).map_or(&self.base, |last| &self.models[last]);
        Judged { fitted, evidence: &self.evidence[steps] }
    }
}

/// The error of the fit or on traces left out where one more effect makes it rise.
pub(super) fn rises(without: Judged, with: Judged) -> Option<Refusal> {
    if with.fitted.rms() >= without.fitted.rms() {
        return Some(Refusal::FittedError);
    }
    let (before, after) =
        without.evidence.held_out.as_ref().zip(with.evidence.held_out.as_ref())?;
    (after.rms >= before.rms).then_some(Refusal::HeldOutError)
}

/// What is told of a model that was refused.
pub(crate) fn refused(effect: &str, without: Judged, with: Judged, reason: Refusal) -> Refused {
    let held_out = |judged: Judged| judged.evidence.held_out.as_ref().map(|held_out| held_out.rms);
    Refused {
        effect: effect.to_owned(),
        law: with
            .fitted
            .chain
            .effects
            .last()
            .map(|effect| effect.law.to_string())
            .unwrap_or_default(),
        reason,
        rms: (without.fitted.rms(), with.fitted.rms()),
        held_out: held_out(without).zip(held_out(with)),
    }
}
