//! The search for what is missing: screen, refit the best few, keep the one that the evidence names,
//! go on; then ask of every one kept whether another would do better in its place.
//!
//! - `found`: what a search found, step by step.
//! - `refit`: which laws are refitted in a step, from where, and which stands for its effect.
//! - `polish`: what is asked of the effects that were found.
//! - `credible`: the names that the data do not tell apart.
//! - `climb`: the same search by what predicts traces left out.
//! - `reorder`: the effects of one search in another order.

mod climb;
mod credible;
mod found;
mod polish;
mod refit;
mod reorder;

use super::adequacy::{Adequacy, LEVEL, adequacy};
use super::fitted::Fitted;
use super::noise::is_noise;
use super::options::Options;
use super::residuals::Residuals;
use super::screen::{Screen, screen};
use palpate_fit::data::Data;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::{Candidate, Needs, find};

pub(crate) use climb::{DISAGREEMENT, Weighed};
pub use credible::RESAMPLES;
use credible::{credible, resample};
pub(crate) use found::refused;
pub use found::{Found, Rival, Step};
use refit::NARROW;

/// Fall of the information criterion that decides between models.
pub const DECISIVE: f64 = 10.0;
/// Standard errors over the traces by which a gain on traces left out is sure.
pub(crate) const SURE: f64 = 2.0;
/// Part of all that is explained, of the sum of squares and of that of the whitened residual, below which the last effect is
/// how the law of another differs from the specimen's: with one effect in another law it is less, and the smaller of two
/// effects explains more (docs/measured.md). Where the law is inexact, the part of the mean square error that such an effect must lower.
const MINOR: f64 = 0.12;
/// Part of all that is explained which one strength for all may leave of it and yet stand for one of each trace: that many strengths
/// lie by chance where one law for all puts them is less likely.
const AS_GOOD: f64 = 0.01;
/// Mean square of the whitened residual, in variances of the noise, below which a model describes the data but for the form of a law.
const CLOSE_TO_NOISE: f64 = 2.0;
/// Mean square of the whitened residual, in variances of the noise, above which it is clearly more than noise.
const CLEARLY_MORE: f64 = 1.2;
/// Most times that all that was found gives way to another effect, or to other laws of its own.
const MOST_LOOKS: usize = 3;

/// A search over a data set.
pub struct Search<'a> {
    /// The data.
    pub data: &'a Data<'a>,
    /// What can be tried.
    pub candidates: &'a [Candidate],
    /// The filter that makes the noise white.
    pub whitening: &'a Whitening,
    /// The problem whose scenes are shared.
    pub problem: &'a Problem<'a>,
    /// The same on all samples where those are searched on means that stand for them: what is noise is told there.
    pub samples: &'a Problem<'a>,
    /// All rows, as they are, where those are searched on their means.
    pub rows: Option<&'a Problem<'a>>,
    /// What is asked for.
    pub options: &'a Options,
}

impl Search<'_> {
    /// Adds effects to the base for as long as noise alone would not show as much.
    #[must_use]
    pub fn run(&self, base: Fitted) -> Found {
        let mut found = self.begin(base);
        let mut budget = 0.5 * self.options.false_alarms;
        let mut looks = 0;
        loop {
            while found.steps.len() < self.options.max_effects && self.advance(&mut found, budget) {
                budget *= 0.5;
            }
            if self.polish(&mut found) {
                continue;
            }
            if looks == MOST_LOOKS || !self.look_through(&mut found) {
                break;
            }
            looks += 1;
        }
        self.order(&mut found);
        self.drop_minor(&mut found);
        let undecided = self.take_one_for_all(&mut found);
        for step in &mut found.steps {
            resample(self.problem, &mut step.rivals, self.options.seed);
            step.credible = credible(&step.effect, &step.rivals);
        }
        if let (Some(names), Some(last)) = (undecided, found.steps.last_mut()) {
            last.credible = names;
        }
        found
    }

    /// A search that has found nothing yet.
    fn begin(&self, base: Fitted) -> Found {
        let first = self.screen(&base);
        Found {
            base,
            steps: Vec::new(),
            models: Vec::new(),
            last: first.clone(),
            first,
            inexact: false,
            evidence: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// Adds the effect that is missed most, if one is missed beyond the chance of `budget`.
    fn advance(&self, found: &mut Found, budget: f64) -> bool {
        let least = found.last.least_chance();
        if least > budget {
            return false;
        }
        let current = found.model();
        let rivals = self.refit(current, &found.last, &NARROW);
        let Some(winner) = rivals.first() else { return false };
        let fell = current.bic() - winner.fitted.bic();
        let hardly = found.hardly_explains(&winner.fitted)
            && !is_line(&winner.effect)
            && !self.completes(current, &winner.fitted);
        if hardly || fell < DECISIVE {
            return false;
        }
        for step in &mut found.steps {
            step.fresh = false;
        }
        let (model, effect) = (winner.fitted.clone(), winner.effect.clone());
        let p_value = found.last.chance_of_step(winner.candidate, budget);
        found.models.push(model);
        found.steps.push(Step { effect, p_value, rivals, credible: Vec::new(), fresh: true });
        found.last = self.screen(found.model());
        true
    }

    /// Puts in the place of an effect of which every trace has its own strength one with a strength for all that explains as much but for
    /// the form of a law: the many strengths take on more of that. The names that are not told apart so, that one first.
    fn take_one_for_all(&self, found: &mut Found) -> Option<Vec<String>> {
        let model = found.model();
        let explained = found.base.cost - model.cost;
        let beyond = if self.leaves_noise(model) { 0.0 } else { model.cost - model.samples as f64 };
        let form = beyond.max(AS_GOOD * explained).min(MINOR * explained);
        let as_much = |rival: &&Rival| {
            rival.fitted.chain.own_of_trace(0).is_empty() && rival.fitted.cost - model.cost < form
        };
        let (index, mut simpler) = found.steps.iter().enumerate().find_map(|(index, step)| {
            let own = step.rivals.iter().find(|rival| rival.effect == step.effect)?;
            let for_all = own.fitted.chain.own_of_trace(0).is_empty();
            let simpler: Vec<Rival> = step.rivals.iter().filter(as_much).cloned().collect();
            (!for_all && !simpler.is_empty()).then_some((index, simpler))
        })?;
        // Among these as well the form of a law speaks for many parameters.
        simpler.sort_by_key(|rival| rival.fitted.values.len());
        let beats = |place: usize, best: usize| {
            simpler[place].fitted.beats_inexact(&simpler[best].fitted, DECISIVE)
        };
        let best =
            (1..simpler.len()).fold(0, |best, place| if beats(place, best) { place } else { best });
        simpler.swap(0, best);
        let Step { effect, p_value, rivals, credible, fresh } = found.steps.remove(index);
        let names: Vec<String> =
            simpler.iter().map(|rival| rival.effect.clone()).chain([effect]).collect();
        tracing::debug!("one strength for all, or one for each trace: {names:?}");
        found.steps.push(Step { effect: names[0].clone(), p_value, rivals, credible, fresh });
        self.rebuild(found, simpler.swap_remove(0).fitted);
        found.last = self.screen(found.model());
        Some(names)
    }

    /// The candidate of this name.
    fn candidate(&self, effect: &str) -> Option<usize> {
        self.candidates.iter().position(|candidate| candidate.name == effect)
    }

    pub(in crate::criticism) fn screen(&self, fitted: &Fitted) -> Screen {
        let problem = self.problem.with_chain(&fitted.chain);
        screen(&problem, self.data, &fitted.point, self.whitening, self.candidates)
    }

    /// Whether what a model leaves is noise.
    #[must_use]
    pub fn leaves_noise(&self, fitted: &Fitted) -> bool {
        let problem = self.samples.with_chain(&fitted.chain);
        let found = adequacy(&problem, &fitted.point, self.whitening);
        found.p_value >= LEVEL && !self.whitening.is_guess()
    }

    /// Whether one more effect leaves noise of what was clearly more: the form of a law leaves hardly ever what one effect makes up for.
    fn completes(&self, without: &Fitted, with: &Fitted) -> bool {
        without.cost > CLEARLY_MORE * without.samples as f64 && self.leaves_noise(with)
    }

    /// Whether a model describes the data but for the form of a law, where their noise is known.
    fn is_close_to_noise(&self, fitted: &Fitted) -> bool {
        !self.whitening.is_guess() && fitted.cost < CLOSE_TO_NOISE * fitted.samples as f64
    }

    /// What a model leaves beside noise. Where the noise is seen nowhere else, what correlates for a few samples is noise.
    #[must_use]
    pub fn left_by(&self, fitted: &Fitted) -> Adequacy {
        let problem = self.samples.with_chain(&fitted.chain);
        let mut found = adequacy(&problem, &fitted.point, self.whitening);
        let left = || Residuals::new(&fitted.chain, &fitted.values, self.rows()).values();
        if self.whitening.is_guess() && is_noise(left()) {
            found.p_value = 1.0;
            found.excess = 0.0;
        }
        found
    }

    /// Whether the search is on means each of which counts as one sample, because the noise is not known.
    #[must_use]
    pub fn counts_means_as_samples(&self) -> bool {
        self.rows.is_some() && !self.problem.stands_for_samples()
    }

    /// The recordings as they are.
    #[must_use]
    pub fn rows(&self) -> &Data<'_> {
        self.rows.unwrap_or(self.samples).data()
    }
}

/// Whether an effect is a line in the spectrum, which the form of another effect's law cannot look like.
pub(in crate::criticism) fn is_line(effect: &str) -> bool {
    find(effect).is_some_and(|effect| effect.needs == Needs::FastSampling)
}
