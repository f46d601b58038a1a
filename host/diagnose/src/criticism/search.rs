//! The search for what is missing: screen, refit the best few, keep the one that the evidence names,
//! go on; then ask of every one kept whether another would do better in its place.

use std::cmp::Ordering;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::adequacy::{Adequacy, LEVEL, adequacy};
use super::agreement;
use super::evidence::{Evidence, Judged, Refusal, Refused, weigh, weigh_fit, weigh_left_out};
use super::fitted::Fitted;
use super::held_out::{held_out_in_one_step, held_out_on, over_sections};
use super::noise::is_noise;
use super::options::Options;
use super::residuals::Residuals;
use super::screen::{Direction, Screen, screen};
use super::touch::begun_at_touch;
use palpate_fit::data::Data;
use palpate_fit::least_squares::{Effort, LeastSquares, Solution, minimise_with};
use palpate_fit::problem::Problem;
use palpate_fit::remembering::Remembering;
use palpate_fit::watch;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::{Candidate, Needs, find};
use palpate_model::{Applied, Chain};

/// Fall of the information criterion that decides between models.
pub const DECISIVE: f64 = 10.0;
/// Standard errors over the traces by which a gain on traces left out is sure.
pub(crate) const SURE: f64 = 2.0;
/// Standard errors over the parts of the data from which on a strength is determined.
const DETERMINED: f64 = 3.0;
/// Chance of as much agreement between the parts of the data above which they do not agree.
pub(crate) const DISAGREEMENT: f64 = 0.1;
/// Chance of as much agreement about one effect by itself, where the parts agree about any, up to which that speaks for it.
const OWN_AGREEMENT: f64 = 0.05;
/// Rivals that are refitted without each trace in earnest: those that one step speaks for most.
const IN_EARNEST: usize = 4;
/// Rivals that are refitted without each trace in earnest whatever one step says: the likeliest, and those on which the parts of
/// the data agree most.
const LIKELIEST: usize = 2;
/// Part of all that was explained so far that a further effect must explain to be tried beside the others: one that is right
/// may take their place.
const WORTH_TRYING: f64 = 0.04;
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
/// Which laws are refitted in a step.
struct Breadth {
    /// Most laws.
    refits: usize,
    /// Most laws of one effect.
    laws: usize,
    /// A law whose predicted gain is below this part of the best is not refitted.
    worth: f64,
    /// A law whose gain after a few steps is below this part of the best is given up, but not among
    /// the first few.
    close: f64,
}
/// Where the likelihood of the noise ranks.
const NARROW: Breadth = Breadth { refits: 12, laws: 12, worth: 0.25, close: 0.5 };
/// Where traces left out rank, and a law that fits less may predict more.
const BROAD: Breadth = Breadth { refits: 16, laws: 2, worth: 0.1, close: 0.2 };
/// A law whose search has not come to its end goes on with it where it explains this part of what the best does.
const CONTENDS: f64 = 0.8;
/// Other shapes that a law on a bound is fitted from.
const ELSEWHERE: usize = 3;
/// Effects that are always refitted.
const FEWEST: usize = 3;
/// Most replacements of effects already found.
const MOST_ROUNDS: usize = 5;
/// Most times that all that was found gives way to another effect, or to other laws of its own.
const MOST_LOOKS: usize = 3;
/// Resamplings of the blocks.
pub const RESAMPLES: usize = 200;
/// Part of the resamplings that a single name must win.
const WON: f64 = 0.9;
/// Part of the resamplings that a credible set must hold.
const COVERED: f64 = 0.975;

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
    pub(super) fresh: bool,
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

/// A rival with the evidence for it.
pub(crate) struct Weighed<'a> {
    pub(crate) rival: &'a Rival,
    pub(crate) evidence: Evidence,
    /// Whether what it leaves is noise.
    pub(crate) exact: bool,
}

impl Weighed<'_> {
    pub(crate) fn judged(&self) -> Judged<'_> {
        Judged { fitted: &self.rival.fitted, evidence: &self.evidence }
    }

    /// Its error on what it was not fitted to.
    pub(crate) fn error(&self) -> f64 {
        self.evidence.left_out().map_or(f64::INFINITY, |errors| errors.rms)
    }

    /// Whether it predicts better than another by more than this many standard errors.
    pub(crate) fn gains_over(&self, other: &Self, standard_errors: f64) -> bool {
        let both = self.evidence.left_out().zip(other.evidence.left_out());
        both.is_none_or(|(own, other)| own.gain(other).exceeds(standard_errors))
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
    pub(super) fn keep_what_surely_predicts(&mut self) {
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
    fn go_back_to(&mut self, steps: usize, denied: Refused) {
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
    fn hardly_explains(&self, with: &Fitted) -> bool {
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
    fn judged(&self, steps: usize) -> Judged<'_> {
        let fitted = steps.checked_sub(1).map_or(&self.base, |last| &self.models[last]);
        Judged { fitted, evidence: &self.evidence[steps] }
    }
}

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

    /// Gathers the evidence beside the fit for every rung, and says what speaks against the first one
    /// that is not borne out.
    pub fn examine(&self, found: &mut Found, exact: bool) -> Option<Refused> {
        found.evidence = vec![self.evidence(&found.base)];
        for index in 0..found.steps.len() {
            found.evidence.push(self.evidence(&found.models[index]));
            let refusal = weigh(found.judged(index), found.judged(index + 1), exact).err();
            if let Some(reason) = refusal {
                tracing::debug!(
                    "refused: {} ({reason:?}), mean squares on each trace left out {:?}, {:?}",
                    found.steps[index].effect,
                    found.judged(index).evidence.left_out().map(|it| &it.squares),
                    found.judged(index + 1).evidence.left_out().map(|it| &it.squares),
                );
                let (without, with) = (found.judged(index), found.judged(index + 1));
                return Some(refused(&found.steps[index].effect, without, with, reason));
            }
        }
        None
    }

    /// The candidate of this name.
    fn candidate(&self, effect: &str) -> Option<usize> {
        self.candidates.iter().position(|candidate| candidate.name == effect)
    }

    fn evidence(&self, fitted: &Fitted) -> Evidence {
        Evidence::of(self.problem, fitted)
    }

    /// Adds effects to the base for as long as they are borne out: by the error on traces left out, by
    /// their parameters and by the rest. For data that no law describes to the noise, where the
    /// likelihood of the noise says nothing about names.
    #[must_use]
    pub fn climb(&self, base: Fitted) -> Found {
        self.climb_until(base, |_| false)
    }

    /// The same, and no further than to the first model that leaves only noise.
    #[must_use]
    pub fn climb_to_the_noise(&self, base: Fitted) -> Found {
        self.climb_until(base, |fitted| self.leaves_noise(fitted))
    }

    fn climb_until(&self, base: Fitted, enough: impl Fn(&Fitted) -> bool) -> Found {
        let mut found = Found { inexact: true, ..self.begin(base) };
        found.evidence.push(self.evidence(&found.base));
        let climbing = |found: &Found| {
            found.steps.len() < self.options.max_effects
                && found.models.last().is_none_or(|it| !enough(it))
        };
        while climbing(&found) && self.step_up(&mut found) {}
        found
    }

    /// Takes back the last step where it does not lower the errors over all rows as it does those over their means; of those on traces
    /// left out only where means that stand for the rows tell them.
    fn holds_on_rows(&self, found: &mut Found) -> bool {
        let (Some(rows), Some(before)) = (self.rows, found.steps.len().checked_sub(1)) else {
            return true;
        };
        let on_rows = |judged: Judged| {
            let (mut fitted, mut evidence) = (judged.fitted.clone(), judged.evidence.clone());
            if self.problem.stands_for_samples() {
                self.take_errors_of(rows, &mut fitted, &mut evidence);
            } else {
                fitted.score(rows);
                evidence.held_out = None;
            }
            (fitted, evidence)
        };
        let (without, with) = (on_rows(found.judged(before)), on_rows(found.judged(before + 1)));
        let without = Judged { fitted: &without.0, evidence: &without.1 };
        let with = Judged { fitted: &with.0, evidence: &with.1 };
        let Some(reason) = rises(without, with) else { return true };
        let denied = refused(&found.steps[before].effect, without, with, reason);
        tracing::debug!("taken back over all rows: {denied:?}");
        found.go_back_to(before, denied);
        false
    }

    /// Takes the errors of a model over all rows, where it was fitted to their means.
    fn take_errors_of(&self, rows: &Problem, fitted: &mut Fitted, evidence: &mut Evidence) {
        let on_rows = fitted.score(rows);
        evidence.held_out = match evidence.held_out.take() {
            // Means that stand for their samples tell how the error changes when a trace is left out; all that is left to take from
            // the rows is the error of the fit to all.
            Some(errors) if self.problem.stands_for_samples() => {
                Some(errors.over_rows(self.problem, fitted, &on_rows))
            }
            _ => held_out_on(self.problem, fitted, rows),
        };
    }

    /// The steps that are borne out on the data of a search by likelihood: its own effects in another
    /// order or those that predict traces left out best one by one, whichever ends lower there.
    #[must_use]
    pub fn borne_out(&self, likeliest: &Found) -> Found {
        let climbed = self.without_idle(self.climb(likeliest.base.clone()));
        // No order of its effects predicts better than all of them leave, fitted to all.
        if climbed.held_out_rms().is_some_and(|error| error < likeliest.model().rms()) {
            return climbed;
        }
        match self.reordered(likeliest) {
            Some(reordered) if reordered.held_out_rms() < climbed.held_out_rms() => reordered,
            _ => climbed,
        }
    }

    /// The steps without the first one that has nothing left to explain beside those after it, as far as they are borne out so.
    fn without_idle(&self, found: Found) -> Found {
        let last = found.steps.len().saturating_sub(1);
        let fewer = (0..last).find_map(|index| {
            let without = self.fitted_without(&found, index);
            let idle = without.bic() - found.model().bic() < DECISIVE;
            idle.then(|| {
                let mut fewer = found.clone();
                tracing::debug!("idle beside those after it: {}", found.steps[index].effect);
                fewer.steps.remove(index);
                fewer.models = vec![without; last];
                fewer
            })
        });
        fewer.and_then(|fewer| self.reordered(&fewer)).unwrap_or(found)
    }

    /// The same effects as those of another search in the order, and as many of them, in which every one
    /// is borne out: an effect may predict only beside another. The one that predicts traces left out
    /// best; none where no order begins with an effect that is borne out.
    #[must_use]
    pub fn reordered(&self, other: &Found) -> Option<Found> {
        let mut best: Option<Found> = None;
        for first in 0..other.steps.len() {
            let mut found = Found { inexact: true, ..self.begin(other.base.clone()) };
            found.evidence.push(self.evidence(&found.base));
            let mut left: Vec<usize> = (0..other.steps.len()).collect();
            left.rotate_left(first);
            for index in left {
                self.try_on(&mut found, other, index);
            }
            let error = |found: &Found| found.held_out_rms().unwrap_or(f64::INFINITY);
            if !found.steps.is_empty()
                && best.as_ref().is_none_or(|best| error(&found) < error(best))
            {
                best = Some(found);
            }
        }
        best
    }

    /// Adds an effect of another search, as it stands at its end, if it is borne out.
    fn try_on(&self, found: &mut Found, other: &Found, index: usize) {
        let effect = other.steps[index].effect.clone();
        let Some(candidate) = self.candidate(&effect) else { return };
        let (chain, start) = with_effect_of(found.model(), other, index);
        let fitted = Fitted::new(&self.problem.with_chain(&chain), &start, Effort::LONG);
        let p_value = self.voted(&found.last)[candidate];
        let exact = self.leaves_noise(&fitted);
        let without = found.judged(found.steps.len());
        let (evidence, refusal) = self.weigh(without, &fitted, exact, Some(p_value));
        if let Err(reason) = refusal {
            let with = Judged { fitted: &fitted, evidence: &evidence };
            let refused = refused(&effect, without, with, reason);
            found.refuse([refused]);
            return;
        }
        let credible = other.steps[index].credible.clone();
        let rival = Rival { candidate, effect: effect.clone(), fitted: fitted.clone(), won: 1.0 };
        found.models.push(fitted);
        found.evidence.push(evidence);
        found.steps.push(Step { effect, p_value, rivals: vec![rival], credible, fresh: true });
        if self.holds_on_rows(found) {
            found.last = self.screen(found.model());
        }
    }

    /// Adds the effect that lowers the error on traces left out most, if one is borne out.
    fn step_up(&self, found: &mut Found) -> bool {
        let least = found.last.least_chance();
        if least > 0.5 * self.options.false_alarms {
            return false;
        }
        let mut rivals = self.refit(found.model(), &found.last, &BROAD);
        resample(self.problem, &mut rivals, self.options.seed);
        // Where the law is inexact, noise alone is no measure of chance: the parts of the data vote.
        let agreement = self.voted(&found.last);
        self.most_promising(&mut rivals, &agreement);
        rivals.retain(|it| found.last.chance[it.candidate] <= 0.5 * self.options.false_alarms);
        rivals.retain(|it| {
            let minor =
                found.hardly_explains(&it.fitted) && hardly_lowers(found.model(), &it.fitted);
            !minor || is_line(&it.effect)
        });
        let without = found.judged(found.steps.len());
        let (borne_out, refusals) = self.borne_out_of(without, &rivals, &agreement);
        found.refuse(refusals);
        let Some(ahead) = borne_out.first() else { return false };
        // Where none predicts surely better, one that the parts agree on by the measure of the whole library.
        let library = agreement::chances(&found.last, self.candidates);
        let agreed = |it: &&Weighed| it.exact || library[it.rival.candidate] <= DISAGREEMENT;
        let sure = borne_out.iter().filter(agreed).find(|it| !ahead.gains_over(it, SURE));
        let best = sure.unwrap_or(ahead);
        let names_of = borne_out.iter().filter(|it| !best.gains_over(it, 1.0));
        let mut names: Vec<String> = names_of.map(|it| it.rival.effect.clone()).collect();
        let Rival { candidate, effect, fitted, .. } = best.rival.clone();
        names.retain(|name| *name != effect);
        names.insert(0, effect.clone());
        let p_value = if best.exact { found.last.chance[candidate] } else { agreement[candidate] };
        found.models.push(fitted);
        found.evidence.push(best.evidence.clone());
        rivals.sort_by(|a, b| {
            (a.candidate != candidate).cmp(&(b.candidate != candidate)).then(by_criterion(a, b))
        });
        found.refused.retain(|refused| refused.effect != effect);
        found.steps.push(Step { effect, p_value, rivals, credible: names, fresh: true });
        let holds = self.holds_on_rows(found);
        if holds {
            found.last = self.screen(found.model());
        }
        holds
    }

    /// The rivals that are borne out, the one that predicts best first, and what speaks against others. Where one predicts surely better
    /// than another leaves that is fitted to all, leaving traces out of that one would tell nothing.
    fn borne_out_of<'b>(
        &self,
        without: Judged,
        rivals: &'b [Rival],
        agreement: &[f64],
    ) -> (Vec<Weighed<'b>>, Vec<Refused>) {
        let mut order: Vec<&Rival> = rivals.iter().collect();
        order.sort_by(|a, b| a.fitted.rms().total_cmp(&b.fitted.rms()));
        let (mut borne_out, mut refusals): (Vec<Weighed>, Vec<Refused>) = (Vec::new(), Vec::new());
        for rival in order {
            let Rival { candidate, effect, fitted, .. } = rival;
            let beats = |it: &Weighed| {
                it.evidence.left_out().is_some_and(|errors| errors.surely_beats(fitted, SURE))
            };
            if borne_out.iter().any(beats) {
                continue;
            }
            let exact = self.leaves_noise(fitted);
            let (evidence, refusal) =
                self.weigh(without, fitted, exact, Some(agreement[*candidate]));
            let it = Weighed { rival, evidence, exact };
            match refusal {
                Ok(()) => borne_out.push(it),
                Err(reason) => refusals.push(refused(effect, without, it.judged(), reason)),
            }
        }
        borne_out.sort_by(|a, b| a.error().total_cmp(&b.error()));
        for it in &borne_out {
            tracing::debug!("borne out: {}, left out {:.6e}", it.rival.effect, it.error());
        }
        (borne_out, refusals)
    }

    /// The evidence for a rival, and what speaks against it. Refits without traces take most of the time: there are none where
    /// something else refuses it.
    pub(crate) fn weigh(
        &self,
        without: Judged,
        fitted: &Fitted,
        exact: bool,
        agreement: Option<f64>,
    ) -> (Evidence, Result<(), Refusal>) {
        let mut evidence = Evidence::without_refits(self.problem, fitted);
        let with = Judged { fitted, evidence: &evidence };
        let uncertain = || exact && !self.is_certain(without.fitted, fitted);
        let refusal = weigh_without_refits(exact, without, with, agreement).err();
        let refusal = refusal.or_else(|| uncertain().then_some(Refusal::FitUncertain));
        if let Some(reason) = refusal {
            return (evidence, Err(reason));
        }
        evidence.leave_out(self.problem, fitted);
        let refusal = weigh_left_out(without, Judged { fitted, evidence: &evidence }, exact);
        (evidence, refusal)
    }

    /// Whether a model with one more effect is decisively likelier, and the parts of the data determine its strength.
    fn is_certain(&self, without: &Fitted, with: &Fitted) -> bool {
        let determined = with.strength_over_error(self.problem);
        without.bic() - with.bic() > DECISIVE && determined.is_none_or(|ratio| ratio > DETERMINED)
    }

    /// Chance of as much agreement between the parts of the data about each candidate: about any of the library, or about it by itself
    /// where that is small.
    fn voted(&self, screen: &Screen) -> Vec<f64> {
        let library = agreement::chances(screen, self.candidates);
        let own = agreement::protected_chances(screen, self.candidates);
        let voted = |(library, own)| if own <= OWN_AGREEMENT { own } else { library };
        library.into_iter().zip(own).map(voted).collect()
    }

    /// Keeps the rivals that traces left out, each in one step from the fit to all, the likelihood, and the parts of the data speak
    /// for most: a refit to the others in earnest is for these.
    fn most_promising(&self, rivals: &mut Vec<Rival>, agreement: &[f64]) {
        let error = |rival: &Rival| {
            let left_out = held_out_in_one_step(self.problem, &rival.fitted);
            left_out.unwrap_or_else(|| over_sections(self.problem, &rival.fitted)).rms
        };
        let errors: Vec<f64> = rivals.iter().map(error).collect();
        let chances: Vec<f64> = rivals.iter().map(|rival| agreement[rival.candidate]).collect();
        let mut kept: Vec<usize> = (0..rivals.len()).take(LIKELIEST).collect();
        for (measure, count) in [(errors, IN_EARNEST), (chances, LIKELIEST)] {
            let mut order: Vec<usize> = (0..rivals.len()).collect();
            order.sort_by(|&a, &b| measure[a].total_cmp(&measure[b]));
            kept.extend(order.into_iter().take(count));
        }
        let mut index = 0;
        rivals.retain(|_| {
            index += 1;
            kept.contains(&(index - 1))
        });
    }

    /// Whether what a model leaves is noise.
    #[must_use]
    pub fn leaves_noise(&self, fitted: &Fitted) -> bool {
        let problem = self.samples.with_chain(&fitted.chain);
        let found = adequacy(&problem, &fitted.point, self.whitening);
        found.p_value >= LEVEL && !self.whitening.is_guess()
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

    pub(super) fn screen(&self, fitted: &Fitted) -> Screen {
        let problem = self.problem.with_chain(&fitted.chain);
        screen(&problem, self.data, &fitted.point, self.whitening, self.candidates)
    }

    /// Refits the laws that the screen foretells the most for, and names their effects, best first.
    fn refit(&self, from: &Fitted, screen: &Screen, breadth: &Breadth) -> Vec<Rival> {
        let present = |direction: &&Direction| {
            let name = &self.candidates[direction.candidate].name;
            from.chain.effects.iter().all(|effect| effect.name != *name)
        };
        let mut directions: Vec<&Direction> =
            screen.directions.iter().filter(|d| d.gain > 0.0).filter(present).collect();
        directions.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let most = directions.first().map_or(0.0, |d| d.gain);
        let mut chosen: Vec<&Direction> = Vec::new();
        for direction in directions {
            let same =
                |d: &&&Direction| (d.candidate, d.form) == (direction.candidate, direction.form);
            let of_effect = chosen.iter().filter(|d| d.candidate == direction.candidate).count();
            let wanted = direction.gain >= breadth.worth * most && of_effect < breadth.laws;
            if wanted && !chosen.iter().any(|d| same(&d)) && chosen.len() < breadth.refits {
                chosen.push(direction);
            }
        }
        for direction in &chosen {
            tracing::debug!(
                "worth a try: {} ({}), shapes {:?}, predicted gain {:.1}, strengths {:?}, left {:.3}",
                self.candidates[direction.candidate].name,
                self.candidates[direction.candidate].forms[direction.form].applied.law,
                direction.shapes,
                direction.gain,
                direction.strengths,
                direction.left
            );
        }
        // A few steps for all tell which are worth going on with.
        watch::stage("laws tried", chosen.len());
        let mut tried: Vec<(&Direction, Chain, Solution)> = chosen
            .par_iter()
            .map(|direction| {
                let (chain, found) = self.try_out(from, direction);
                watch::done();
                (*direction, chain, found)
            })
            .collect();
        tried.retain(|(.., found)| found.normal.cost.is_finite());
        tried.sort_by(|a, b| a.2.normal.cost.total_cmp(&b.2.normal.cost));
        let gain = |found: &Solution| from.cost - found.normal.cost;
        for (direction, _, found) in &tried {
            tracing::debug!(
                "tried: {} ({}): gain {:.1}, {}",
                self.candidates[direction.candidate].name,
                self.candidates[direction.candidate].forms[direction.form].applied.law,
                gain(found),
                found.stop
            );
        }
        let most = tried.first().map_or(0.0, |(.., found)| gain(found));
        let mut names: Vec<usize> = Vec::new();
        tried.retain(|(direction, _, found)| {
            let new = !names.contains(&direction.candidate);
            let kept = gain(found) >= breadth.close * most || (new && names.len() < FEWEST);
            if kept && new {
                names.push(direction.candidate);
            }
            kept
        });
        let mut rivals = self.refitted(from, tried, Effort::QUICK);
        self.begin_elsewhere(from, screen, &chosen, &mut rivals);
        self.begin_at_touch(from, &mut rivals);
        rivals
    }

    /// Begins the offset of the contact where the touch shows as well.
    fn begin_at_touch(&self, from: &Fitted, rivals: &mut Vec<Rival>) {
        let begun = begun_at_touch(self.problem, self.data, from, self.candidates);
        let Some((candidate, fitted)) = begun else { return };
        let gain = from.cost - fitted.cost;
        tracing::debug!("begun at the touch: {}, gain {gain:.1}", self.candidates[candidate].name);
        self.enter(rivals, candidate, fitted, from);
        rivals.sort_by(by_criterion);
    }

    /// Fits those that may be the best and stand on a bound from the other shapes of the screen as well: what pushes them there
    /// may be the wrong one of two minima.
    fn begin_elsewhere(
        &self,
        from: &Fitted,
        screen: &Screen,
        begun: &[&Direction],
        rivals: &mut [Rival],
    ) {
        let gain = |fitted: &Fitted| from.cost - fitted.cost;
        let most = rivals.iter().map(|rival| gain(&rival.fitted)).fold(0.0, f64::max);
        for rival in rivals.iter_mut() {
            let contends = gain(&rival.fitted) > CONTENDS * most;
            if !contends || rival.fitted.last_effect_at_bound().is_none() {
                continue;
            }
            let new =
                |direction: &&Direction| !begun.iter().any(|it| std::ptr::eq(*it, *direction));
            let mut others: Vec<&Direction> = screen
                .directions
                .iter()
                .filter(|direction| direction.candidate == rival.candidate && direction.gain > 0.0)
                .filter(new)
                .collect();
            others.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            others.truncate(ELSEWHERE);
            let tried = self.tried(from, others.par_iter().copied());
            let found = self.refitted(from, tried, Effort::LONG);
            let inside = |other: &Rival| other.fitted.last_effect_at_bound().is_none();
            let better = |other: &Rival| stands_better(&other.fitted, &rival.fitted, from);
            if let Some(other) = found.into_iter().find(|other| inside(other) && better(other)) {
                tracing::debug!(
                    "begun elsewhere: {}, gain {:.1}",
                    other.effect,
                    gain(&other.fitted)
                );
                rival.fitted = other.fitted;
            }
        }
        rivals.sort_by(by_criterion);
    }

    /// Fits each from where it was tried, and to its end those that may be the best; the best law of each effect, best
    /// effect first.
    pub(super) fn refitted(
        &self,
        from: &Fitted,
        tried: Vec<(&Direction, Chain, Solution)>,
        effort: Effort,
    ) -> Vec<Rival> {
        watch::stage("laws refitted", tried.len());
        let mut fits: Vec<(usize, Fitted)> = tried
            .into_par_iter()
            .map(|(direction, chain, trial)| {
                let problem = self.problem.with_chain(&chain);
                let fitted = Fitted::new(&problem, &trial.point, effort);
                watch::done();
                (direction.candidate, fitted)
            })
            .collect();
        let gain = |fitted: &Fitted| from.cost - fitted.cost;
        let most = fits.iter().map(|(_, fitted)| gain(fitted)).fold(0.0, f64::max);
        fits.par_iter_mut().for_each(|(_, fitted)| {
            if gain(fitted) > CONTENDS * most {
                fitted.go_on(self.problem);
            }
        });
        self.by_effect(fits, from)
    }

    /// The best law of each effect, best effect first.
    pub(super) fn by_effect(&self, fits: Vec<(usize, Fitted)>, from: &Fitted) -> Vec<Rival> {
        let mut rivals: Vec<Rival> = Vec::new();
        for (candidate, fitted) in fits {
            self.enter(&mut rivals, candidate, fitted, from);
        }
        rivals.sort_by(by_criterion);
        rivals
    }

    /// Lets a fit stand for its effect where none does yet, or a worse one.
    fn enter(&self, rivals: &mut Vec<Rival>, candidate: usize, fitted: Fitted, from: &Fitted) {
        if !fitted.bic().is_finite() || !fitted.rms().is_finite() {
            return;
        }
        match rivals.iter_mut().find(|rival| rival.candidate == candidate) {
            Some(rival) if stands_better(&fitted, &rival.fitted, from) => rival.fitted = fitted,
            Some(_) => {}
            None => {
                let effect = self.candidates[candidate].name.clone();
                rivals.push(Rival { candidate, effect, fitted, won: 0.0 });
            }
        }
    }

    /// A few steps with each of these laws, in their order.
    pub(super) fn tried<'d>(
        &self,
        from: &Fitted,
        directions: impl ParallelIterator<Item = &'d Direction>,
    ) -> Vec<(&'d Direction, Chain, Solution)> {
        let tried = |direction: &'d Direction| {
            let (chain, trial) = self.try_out(from, direction);
            (direction, chain, trial)
        };
        directions.map(tried).collect()
    }

    /// A few steps with one more law, from what the screen foretells.
    #[must_use]
    pub fn try_out(&self, from: &Fitted, direction: &Direction) -> (Chain, Solution) {
        let form = &self.candidates[direction.candidate].forms[direction.form];
        let chain = from.chain.with(form.applied.clone());
        let problem = self.problem.with_chain(&chain);
        // A forecast beyond the reach of its straight line would start worse than half of it; where even that is worse than none, the
        // search goes on from both.
        let part = |part: f64| -> Vec<f64> {
            let model = from.point.iter().zip(&direction.shift).map(|(x, step)| x + part * step);
            let strengths = direction.strengths.iter().map(|strength| part * strength);
            let point = model.chain(strengths).chain(direction.shapes.iter().copied());
            point.zip(problem.bounds()).map(|(x, (lower, upper))| x.clamp(*lower, *upper)).collect()
        };
        let search = Remembering::new(&problem);
        let (whole, half) = (part(1.0), part(0.5));
        let (of_whole, of_half) = (search.cost(&whole), search.cost(&half));
        let start = if of_whole <= of_half { whole } else { half };
        let found = minimise_with(&search, &start, Effort::TRIAL);
        if of_whole.min(of_half) < from.cost {
            return (chain, found);
        }
        let from_none = minimise_with(&search, &part(0.0), Effort::TRIAL);
        let fell = from_none.normal.cost < found.normal.cost || found.normal.cost.is_nan();
        (chain, if fell { from_none } else { found })
    }

    /// Asks of every effect whether another would do better in its place, and whether it is still
    /// needed; true if the model has changed.
    fn polish(&self, found: &mut Found) -> bool {
        let mut changed = self.collapse(found);
        let mut rounds = 0;
        while let Some(index) = found.steps.iter().rposition(|step| !step.fresh) {
            rounds += 1;
            let (without, screen) = self.without(found, index);
            if without.bic() - found.model().bic() < DECISIVE {
                found.steps.remove(index);
                self.rebuild(found, without);
                changed = true;
                continue;
            }
            let mut rivals = self.refit(&without, &screen, &NARROW);
            let effect = found.steps[index].effect.clone();
            let better = |best: &Rival| best.fitted.bic() + 1e-3 < found.model().bic();
            match rivals.first() {
                Some(best) if better(best) && rounds <= MOST_ROUNDS => {
                    let other = best.effect != effect;
                    let (fitted, effect) = (best.fitted.clone(), best.effect.clone());
                    let p_value = screen.chance[best.candidate];
                    found.steps.remove(index);
                    found.steps.push(Step {
                        effect,
                        p_value,
                        rivals,
                        credible: Vec::new(),
                        fresh: true,
                    });
                    self.rebuild(found, fitted);
                    if other {
                        changed = true;
                        let last = found.steps.len() - 1;
                        found.steps[..last].iter_mut().for_each(|step| step.fresh = false);
                    }
                }
                _ => {
                    // The model at hand may be the better fit with the same effect, or one that the screen did not foretell.
                    let candidate = self.candidate(&effect);
                    rivals.retain(|rival| rival.effect != effect);
                    rivals.extend(candidate.map(|candidate| Rival {
                        candidate,
                        effect,
                        fitted: found.model().clone(),
                        won: 0.0,
                    }));
                    rivals.sort_by(by_criterion);
                    found.steps[index].rivals = rivals;
                    found.steps[index].fresh = true;
                }
            }
        }
        if changed {
            found.last = self.screen(found.model());
        }
        changed && rounds <= MOST_ROUNDS
    }

    /// Puts the effects of a model that is close to the noise in the order in which each explains most beside those before it.
    fn order(&self, found: &mut Found) {
        if found.steps.len() < 2 || !self.is_close_to_noise(found.model()) {
            return;
        }
        let (base, end) = (&found.base, found.model());
        let first = base.chain.effects.len();
        let with = |places: &[usize]| {
            let effects = places.iter().map(|place| end.chain.effects[first + place].clone());
            let chain = effects.fold(base.chain.clone(), |chain, effect| chain.with(effect));
            let own = places.iter().flat_map(|place| &end.point[end.chain.range(first + place)]);
            let point: Vec<f64> =
                end.point[..base.point.len()].iter().chain(own).copied().collect();
            Fitted::new(&self.problem.with_chain(&chain), &point, Effort::QUICK)
        };
        let (mut order, mut models): (Vec<usize>, Vec<Fitted>) = (Vec::new(), Vec::new());
        while order.len() < found.steps.len() {
            let left = (0..found.steps.len()).filter(|place| !order.contains(place));
            let fits = left.map(|place| (place, with(&[&order[..], &[place]].concat())));
            let best = fits.min_by(|(_, a), (_, b)| a.bic().total_cmp(&b.bic()));
            let Some((place, fitted)) = best else { return };
            order.push(place);
            models.push(fitted);
        }
        if !order.is_sorted() {
            found.steps = order.iter().map(|&place| found.steps[place].clone()).collect();
            found.models = models;
        }
    }

    /// Takes back the last effect for as long as it explains next to nothing beside the others.
    fn drop_minor(&self, found: &mut Found) {
        let mut changed = false;
        while let [.., before, last] = &found.models[..]
            && !found.steps.last().is_some_and(|step| is_line(&step.effect))
            && self.is_close_to_noise(before)
            && is_minor(&found.base, before, last)
            && !self.completes(before, last)
        {
            found.steps.pop();
            found.models.pop();
            changed = true;
        }
        if changed {
            found.steps.iter_mut().for_each(|step| step.fresh = false);
            found.last = self.screen(found.model());
            self.polish(found);
        }
    }

    /// Whether one more effect leaves noise of what was clearly more: the form of a law leaves hardly ever what one effect makes up for.
    fn completes(&self, without: &Fitted, with: &Fitted) -> bool {
        without.cost > CLEARLY_MORE * without.samples as f64 && self.leaves_noise(with)
    }

    /// Whether a model describes the data but for the form of a law, where their noise is known.
    fn is_close_to_noise(&self, fitted: &Fitted) -> bool {
        !self.whitening.is_guess() && fitted.cost < CLOSE_TO_NOISE * fitted.samples as f64
    }

    /// The model without one of its effects, refitted and screened.
    fn without(&self, found: &Found, index: usize) -> (Fitted, Screen) {
        let fitted = self.fitted_without(found, index);
        let screen = self.screen(&fitted);
        (fitted, screen)
    }

    /// The model without one of its effects, refitted.
    fn fitted_without(&self, found: &Found, index: usize) -> Fitted {
        let model = found.model();
        let place = found.base.chain.effects.len() + index;
        let range = model.chain.range(place);
        let chain = model.chain.without(place);
        let mut start = model.point.clone();
        start.drain(range);
        Fitted::new(&self.problem.with_chain(&chain), &start, Effort::QUICK)
    }

    /// Refits the models on the way to the last, one effect more in each.
    pub(super) fn rebuild(&self, found: &mut Found, last: Fitted) {
        let first = found.base.chain.effects.len();
        let count = last.chain.effects.len() - first;
        found.models = vec![last; count];
        for step in (0..count.saturating_sub(1)).rev() {
            let next = &found.models[step + 1];
            let range = next.chain.range(first + step + 1);
            let chain = next.chain.without(first + step + 1);
            let mut start = next.point.clone();
            start.drain(range);
            let problem = self.problem.with_chain(&chain);
            found.models[step] = Fitted::new(&problem, &start, Effort::QUICK);
        }
    }
}

/// A model with an effect of another search beside its own, and where its search begins: with all effects of that one, where that one
/// ended.
fn with_effect_of(model: &Fitted, other: &Found, index: usize) -> (Chain, Vec<f64>) {
    let end = other.model();
    let own = |effect: &Applied| {
        let place = end.chain.effects.iter().position(|it| it.name == effect.name);
        place.map_or(&[][..], |place| &end.point[end.chain.range(place)])
    };
    let added = &end.chain.effects[other.base.chain.effects.len() + index];
    let chain = model.chain.with(added.clone());
    let start = if chain.effects.len() == end.chain.effects.len() {
        let effects = chain.effects.iter().flat_map(own);
        end.point[..chain.base.count()].iter().chain(effects).copied().collect()
    } else {
        [&model.point[..], own(added)].concat()
    };
    (chain, start)
}

/// Whether an effect is a line in the spectrum, which the form of another effect's law cannot look like.
pub(super) fn is_line(effect: &str) -> bool {
    find(effect).is_some_and(|effect| effect.needs == Needs::FastSampling)
}

/// Whether the mean square error is hardly less than without the last effect.
fn hardly_lowers(without: &Fitted, with: &Fitted) -> bool {
    with.rms().powi(2) > (1.0 - MINOR) * without.rms().powi(2)
}

/// Whether one more effect explains next to nothing of what all explain together.
fn is_minor(base: &Fitted, without: &Fitted, with: &Fitted) -> bool {
    let share = |of: fn(&Fitted) -> f64| {
        (of(without) - of(with)) / (of(base) - of(with)).max(f64::MIN_POSITIVE)
    };
    share(|fitted| fitted.cost) < MINOR && share(|fitted| fitted.rms().powi(2)) < MINOR
}

/// Weighs a rival by what needs no refit. Where what it leaves need not be noise, the fit must gain by the samples that are
/// independent in it, whatever the number of all, and the parts of the data must agree.
fn weigh_without_refits(
    exact: bool,
    without: Judged,
    with: Judged,
    agreement: Option<f64>,
) -> Result<(), Refusal> {
    weigh_fit(without, with)?;
    if exact {
        return Ok(());
    }
    if !with.fitted.beats_inexact(without.fitted, DECISIVE) {
        return Err(Refusal::FitUncertain);
    }
    agreement
        .filter(|chance| *chance > DISAGREEMENT)
        .map_or(Ok(()), |chance| Err(Refusal::Disagreement(chance)))
}

/// The error of the fit or on traces left out where one more effect makes it rise.
fn rises(without: Judged, with: Judged) -> Option<Refusal> {
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

fn by_criterion(a: &Rival, b: &Rival) -> Ordering {
    a.fitted.bic().total_cmp(&b.fitted.bic())
}

/// Part of the gain of a law on its bound with which another law of the same effect, inside its bounds,
/// stands for it.
const INSIDE: f64 = 0.5;

/// Whether one law of an effect stands better for it than another, both added to the same model.
fn stands_better(law: &Fitted, other: &Fitted, from: &Fitted) -> bool {
    let inside = |fitted: &Fitted| fitted.last_effect_at_bound().is_none();
    let gain = |fitted: &Fitted| from.bic() - fitted.bic();
    match (inside(law), inside(other)) {
        (true, false) => gain(law) > INSIDE * gain(other),
        (false, true) => gain(other) <= INSIDE * gain(law),
        _ => law.bic() < other.bic(),
    }
}

/// How often each rival is best when the blocks of the data are drawn anew.
fn resample(problem: &Problem, rivals: &mut [Rival], seed: u64) {
    let Some(first) = rivals.first() else { return };
    let blocks = first.fitted.blocks.len();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let draws: Vec<Vec<f64>> = (0..RESAMPLES)
        .map(|_| {
            let mut weights = vec![0.0; blocks];
            for _ in 0..blocks {
                weights[random.random_range(0..blocks)] += 1.0;
            }
            weights
        })
        .collect();
    let best = |weights: &Vec<f64>| {
        let criteria: Vec<f64> =
            rivals.iter().map(|rival| rival.fitted.weighted_bic(problem, weights)).collect();
        (0..criteria.len()).min_by(|&a, &b| criteria[a].total_cmp(&criteria[b])).unwrap_or(0)
    };
    let winners: Vec<usize> = draws.par_iter().map(best).collect();
    for (index, rival) in rivals.iter_mut().enumerate() {
        let wins = winners.iter().filter(|&&winner| winner == index).count();
        rival.won = wins as f64 / RESAMPLES as f64;
    }
}

/// The names that the data do not tell apart: one alone if it wins nearly always and by far.
fn credible(effect: &str, rivals: &[Rival]) -> Vec<String> {
    let Some(best) = rivals.first() else { return vec![effect.to_owned()] };
    let close = |rival: &&Rival| rival.fitted.bic() - best.fitted.bic() < DECISIVE;
    let near = rivals.iter().filter(close).count();
    let mut by_wins: Vec<&Rival> = rivals.iter().collect();
    by_wins.sort_by(|a, b| b.won.total_cmp(&a.won));
    let mut set: Vec<String> = vec![effect.to_owned()];
    set.extend(rivals.iter().filter(close).map(|rival| rival.effect.clone()));
    let own = rivals.iter().find(|rival| rival.effect == effect).map_or(0.0, |rival| rival.won);
    if near > 1 || own < WON {
        let mut covered = 0.0;
        for rival in by_wins {
            if covered >= COVERED {
                break;
            }
            covered += rival.won;
            set.push(rival.effect.clone());
        }
    }
    let mut unique: Vec<String> = Vec::new();
    for name in set {
        if !unique.contains(&name) {
            unique.push(name);
        }
    }
    unique
}
