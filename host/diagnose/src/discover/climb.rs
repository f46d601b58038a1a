//! The search for formulas: the grammar is screened in portions, the likeliest terms are refitted, and the one is kept that traces
//! left out bear out, again and again until only noise is left.
//!
//! Free curves are screened beside the laws. What they foretell beyond the best law leads to laws near them; a curve itself is kept only
//! where no law predicts as well.

use rayon::prelude::*;

use super::grammar::{Grammar, Term};
use super::reach::{Quantity, Reach};
use super::{simplify, vary};
use crate::criticism::agreement;
use crate::criticism::evidence::{Evidence, Judged, Refusal};
use crate::criticism::fitted::Fitted;
use crate::criticism::held_out::{held_out_in_one_step, over_sections};
use crate::criticism::screen::{DRAWS, Direction, Screen, screen};
use crate::criticism::search::{
    DECISIVE, DISAGREEMENT, Found, Rival, SURE, Search, Step, Weighed, refused,
};
use nalgebra::DMatrix;
use palpate_fit::least_squares::{Effort, Solution, minimise_with};
use palpate_model::Chain;

/// Sensitivities that are screened at a time: what is counted of every two of them grows with their square.
const PORTION: usize = 96;
/// Least chance that is told.
const LEAST: f64 = 1.0 / (DRAWS as f64 + 1.0);
/// Most starts of laws that are tried, and most of one term.
const TRIED: usize = 12;
const OF_A_TERM: usize = 2;
/// Most free curves that are tried.
const CURVES: usize = 3;
/// A start is tried from this part of the best foretold gain on.
const WORTH: f64 = 0.1;
/// Most terms that are refitted, in all and of one quantity at one stage, of those that gain this part of the best after a few steps.
const REFITTED: usize = 7;
const ALIKE: usize = 2;
const CLOSE: f64 = 0.3;
/// Terms whose traces left out are predicted by refits in earnest: those that one step speaks for most.
const IN_EARNEST: usize = 2;

/// Times that a term is changed to one near it.
const VARIED: usize = 2;

/// A search over the terms of the grammar.
pub(super) struct Climb<'a> {
    pub(super) search: &'a Search<'a>,
    pub(super) grammar: &'a Grammar,
    /// The quantities with a power of which a term may change.
    pub(super) powers: &'a [(&'static Quantity, Reach)],
}

/// What a search has found.
pub(super) struct Climbed {
    pub(super) found: Found,
    /// Terms near those of the grammar that it has taken in their place.
    pub(super) varied: Vec<Term>,
}

/// What a screen says of every term.
struct Told {
    /// Chance of as large a score under noise alone; of a law near a free curve that of the curve.
    chance: Vec<f64>,
    /// Chance of as much agreement between the parts of the data; none where they have not voted.
    agreement: Vec<Option<f64>>,
}

/// A term after a few steps of a fit.
struct Trial {
    term: usize,
    chain: Chain,
    fit: Solution,
}

/// A term refitted beside the last model.
struct Tried {
    rival: Rival,
    /// Whether what it leaves is noise.
    exact: bool,
    /// Whether it is weighed whatever comes of the others.
    promising: bool,
}

impl Climb<'_> {
    /// Adds terms to a model, and no further than to the first that leaves only noise; then takes away what is no longer needed.
    pub(super) fn from(&self, base: &Fitted) -> Climbed {
        // A diagnosis may have been searched on means, whose sums of squares are those of all rows but for a little.
        let problem = self.search.problem.with_chain(&base.chain);
        let base = Fitted::new(&problem, &problem.point(&base.values), Effort::QUICK);
        let screened = self.screened(&base);
        let evidence = vec![Evidence::of(self.search.problem, &base)];
        let mut found = Found {
            base,
            steps: Vec::new(),
            models: Vec::new(),
            last: screened.clone(),
            first: screened,
            inexact: true,
            evidence,
            refused: Vec::new(),
        };
        let mut varied = Vec::new();
        while self.step_up(&mut found) {
            tracing::debug!("step: {:?}", found.steps.last().map(|step| &step.effect));
            self.vary(&mut found, &mut varied);
            let enough = found.steps.len() >= self.search.options.max_effects
                || self.search.leaves_noise(found.model());
            if enough {
                break;
            }
            found.last = self.screened(found.model());
        }
        self.without_the_superfluous(&mut found);
        if let Some(rows) = self.search.rows {
            found.score(self.search, rows);
        }
        Climbed { found, varied }
    }

    /// Takes terms near the last one in its place as long as traces left out bear them out and more than noise is left.
    fn vary(&self, found: &mut Found, varied: &mut Vec<Term>) {
        for _ in 0..VARIED {
            if self.search.leaves_noise(found.model()) {
                return;
            }
            match self.near_the_last(found, varied) {
                Some(term) => {
                    tracing::debug!("varied: {}", term.candidate.name);
                    varied.push(term);
                }
                None => return,
            }
        }
    }

    /// The term near a model's last one that gains most in its place, and the model with it.
    fn likeliest_near(&self, term: &Term, model: &Fitted) -> Option<(Term, Fitted)> {
        let place = model.chain.effects.len() - 1;
        let (kept, values) = model.point.split_at(model.chain.range(place).start);
        let without = model.chain.without(place);
        let tried = vary::near(term, values, self.grammar, self.powers).into_par_iter().map(|it| {
            let chain = without.with(it.term.candidate.forms[0].applied.clone());
            let problem = self.search.problem.with_chain(&chain);
            let fit = minimise_with(&problem, &[kept, &it.start].concat(), Effort::TRIAL);
            (it.term, chain, fit)
        });
        let tried: Vec<(Term, Chain, Solution)> = tried.collect();
        let best = tried
            .into_iter()
            .filter(|(_, _, fit)| fit.normal.cost.is_finite())
            .min_by(|a, b| a.2.normal.cost.total_cmp(&b.2.normal.cost));
        let (term, chain, fit) = best?;
        let problem = self.search.problem.with_chain(&chain);
        let mut fitted = Fitted::new(&problem, &fit.point, Effort::QUICK);
        fitted.go_on(self.search.problem);
        Some((term, fitted))
    }

    /// Puts the likeliest term near the last one in its place, if traces left out bear it out.
    fn near_the_last(&self, found: &mut Found, varied: &[Term]) -> Option<Term> {
        let (model, step) = (found.model(), found.steps.last()?);
        let known = |term: &&Term| term.candidate.name == step.effect;
        let last = self.grammar.terms.iter().chain(varied).find(known)?;
        let (term, fitted) = self.likeliest_near(last, model)?;
        let before = Judged { fitted: model, evidence: found.evidence.last()? };
        let exact = self.search.leaves_noise(&fitted);
        let (evidence, refusal) = self.search.weigh(before, &fitted, exact, None);
        let effect = term.candidate.name.clone();
        let rival = Rival {
            candidate: step.rivals.first()?.candidate,
            effect: effect.clone(),
            fitted,
            won: 0.0,
        };
        let it = Weighed { rival: &rival, evidence, exact };
        if let Err(reason) = refusal.and_then(|()| it.gains_surely(before, None)) {
            tracing::debug!("refused: {effect} ({reason:?})");
            return None;
        }
        let (evidence, fitted) = (it.evidence, rival.fitted.clone());
        let rivals = [&step.rivals[..], &[rival]].concat();
        let varied = Step::chosen(effect.clone(), step.p_value, rivals, vec![effect]);
        *found.steps.last_mut()? = varied;
        *found.models.last_mut()? = fitted;
        *found.evidence.last_mut()? = evidence;
        Some(term)
    }

    fn term(&self, index: usize) -> &Term {
        &self.grammar.terms[index]
    }

    fn is_free(&self, index: usize) -> bool {
        self.term(index).shape.is_free()
    }

    /// Screens the grammar beside a model. The chances are those of the largest score of a portion under noise alone, times the
    /// number of portions; or those of a score by itself, times the number of all, where that is less: draws know no chance below one
    /// in their number.
    fn screened(&self, fitted: &Fitted) -> Screen {
        let Search { data, candidates, whitening, problem, .. } = *self.search;
        let candidates = &candidates[..self.grammar.screened];
        let problem = problem.with_chain(&fitted.chain);
        let portions = portions(candidates.iter().map(|candidate| {
            candidate.forms.iter().map(|form| form.grid.len() * form.applied.strengths).sum()
        }));
        let mut whole = Screen {
            directions: Vec::new(),
            chance: Vec::new(),
            cosines: DMatrix::zeros(0, 0),
            scores: DMatrix::zeros(0, 0),
        };
        let (mut scores, mut columns) = (Vec::new(), 0);
        for portion in &portions {
            let own = &candidates[portion.clone()];
            let found = screen(&problem, data, &fitted.point, whitening, own);
            let times = portions.len() as f64;
            whole.chance.extend(found.chance.iter().map(|chance| (times * chance).min(1.0)));
            whole.directions.extend(found.directions.into_iter().map(|mut direction| {
                direction.candidate += portion.start;
                direction.columns =
                    direction.columns.start + columns..direction.columns.end + columns;
                direction
            }));
            columns += found.scores.ncols();
            scores.push(found.scores);
        }
        whole.scores = side_by_side(&scores);
        for direction in &whole.directions {
            let chance = &mut whole.chance[direction.candidate];
            *chance = chance.min(by_number(direction.log_chance, whole.directions.len()));
        }
        whole
    }

    /// Adds the term that the traces left out bear out best; of several that do as well, a law before a free curve, and then the one
    /// with the lowest information criterion. False where there is none.
    fn step_up(&self, found: &mut Found) -> bool {
        let level = 0.5 * self.search.options.false_alarms;
        if found.last.chance.iter().all(|chance| *chance > level) {
            return false;
        }
        let mut told = self.told(&found.last);
        let mut tried = self.tried(found, &mut told);
        tried.retain(|it| told.chance[it.rival.candidate] <= level);
        let without =
            Judged { fitted: found.model(), evidence: &found.evidence[found.steps.len()] };
        let mut refusals = Vec::new();
        let mut borne_out: Vec<Weighed> = Vec::new();
        for Tried { rival, exact, promising } in &tried {
            if !(*promising || borne_out.is_empty()) {
                continue;
            }
            let agreement = told.agreement[rival.candidate];
            let (evidence, refusal) = self.search.weigh(without, &rival.fitted, *exact, None);
            let it = Weighed { rival, evidence, exact: *exact };
            match refusal.and_then(|()| it.gains_surely(without, agreement)) {
                Ok(()) => borne_out.push(it),
                Err(reason) => {
                    tracing::debug!("refused: {} ({reason:?})", rival.effect);
                    refusals.push(refused(&rival.effect, without, it.judged(), reason));
                }
            }
        }
        let Some((chosen, as_good)) = self.best_of(&borne_out) else {
            found.refuse(refusals);
            return false;
        };
        let candidate = chosen.rival.candidate;
        let voted = told.agreement[candidate].filter(|_| !chosen.exact);
        let p_value = voted.unwrap_or(told.chance[candidate]);
        let (effect, model) = (chosen.rival.effect.clone(), chosen.rival.fitted.clone());
        let evidence = chosen.evidence.clone();
        let rivals = tried.iter().map(|it| it.rival.clone()).collect();
        found.refuse(refusals);
        found.refused.retain(|refused| refused.effect != effect);
        found.models.push(model);
        found.evidence.push(evidence);
        found.steps.push(Step::chosen(effect, p_value, rivals, as_good));
        true
    }

    /// The best of the terms that are borne out, and the names of those that predict traces left out as well.
    fn best_of<'b>(&self, borne_out: &'b [Weighed<'b>]) -> Option<(&'b Weighed<'b>, Vec<String>)> {
        let all: Vec<&Weighed> = borne_out.iter().collect();
        let laws: Vec<&Weighed> =
            all.iter().copied().filter(|it| !self.is_free(it.rival.candidate)).collect();
        let ahead = |of: &[&'b Weighed<'b>]| {
            of.iter().copied().min_by(|a, b| a.error().total_cmp(&b.error()))
        };
        let best = ahead(&all)?;
        // A free curve has to predict better than every law, and surely.
        let best = match ahead(&laws) {
            Some(law) if law.exact || !best.gains_over(law, SURE) => law,
            _ => best,
        };
        let mut as_good: Vec<&Weighed> =
            all.into_iter().filter(|it| !best.gains_over(it, 1.0)).collect();
        let is_free = self.is_free(best.rival.candidate);
        as_good.retain(|it| is_free || !self.is_free(it.rival.candidate));
        as_good.sort_by(|a, b| a.rival.fitted.bic().total_cmp(&b.rival.fitted.bic()));
        let chosen = as_good.first().copied().unwrap_or(best);
        Some((chosen, as_good.iter().map(|it| it.rival.effect.clone()).collect()))
    }

    fn told(&self, screened: &Screen) -> Told {
        let terms = self.grammar.terms.len();
        let of_screened = agreement::chances(screened, self.search.candidates);
        let voted = |k: usize| k < self.grammar.screened && !self.is_free(k);
        let mut chance = screened.chance.clone();
        chance.resize(terms, 1.0);
        let agreement = (0..terms).map(|k| voted(k).then(|| of_screened[k])).collect();
        Told { chance, agreement }
    }

    /// The terms that are worth it, refitted.
    fn tried(&self, found: &Found, told: &mut Told) -> Vec<Tried> {
        let from = found.model();
        let (laws, curves) = self.worth_a_try(&found.last);
        let mut laws = self.trials(from, &laws);
        let curves = self.trials(from, &curves);
        let gain = |trial: &Trial| from.cost - trial.fit.normal.cost;
        let best = |of: &[Trial]| of.iter().map(gain).fold(0.0, f64::max);
        let ahead: Vec<&Trial> = curves.iter().filter(|it| gain(it) > best(&laws)).collect();
        let near: Vec<Direction> = ahead.iter().flat_map(|curve| self.near(from, curve)).collect();
        for (direction, curve) in near.iter().flat_map(|it| ahead.iter().map(move |c| (it, c))) {
            if self.term(direction.candidate).beside(self.term(curve.term)) {
                let chance = &mut told.chance[direction.candidate];
                *chance = chance.min(found.last.chance[curve.term]);
            }
        }
        laws.extend(self.trials(from, &near.iter().collect::<Vec<_>>()));
        let mut tried = self.refitted(from, laws);
        // Where a law leaves only noise no curve is wanted, which takes long to refit.
        if !tried.iter().any(|it| it.exact && it.promising) {
            let likeliest =
                curves.into_iter().min_by(|a, b| a.fit.normal.cost.total_cmp(&b.fit.normal.cost));
            tried.extend(self.refitted(from, likeliest.into_iter().collect()));
        }
        // Those that promise less come last.
        tried.sort_by_key(|it| !it.promising);
        tried
    }

    /// Laws near a free curve, as starts.
    fn near(&self, from: &Fitted, curve: &Trial) -> Vec<Direction> {
        let term = self.term(curve.term);
        let heights = term.candidate.forms[0].applied.strengths;
        let point = &curve.fit.point;
        let shift: Vec<f64> =
            point.iter().zip(&from.point).map(|(there, here)| there - here).collect();
        let near = simplify::Found::of(&curve.fit, heights).near(term, &self.grammar.terms);
        let start = |near: simplify::Near| Direction {
            candidate: near.term,
            form: 0,
            shapes: near.shapes,
            columns: 0..1,
            left: 1.0,
            log_chance: 0.0,
            gain: near.gain,
            strengths: vec![near.strength],
            shift: shift.clone(),
        };
        near.into_iter().map(start).collect()
    }

    /// The starts that the screen foretells most for, of laws and of free curves.
    fn worth_a_try<'b>(&self, screened: &'b Screen) -> (Vec<&'b Direction>, Vec<&'b Direction>) {
        let mut directions: Vec<&Direction> =
            screened.directions.iter().filter(|direction| direction.gain > 0.0).collect();
        directions.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let least = WORTH * directions.first().map_or(0.0, |direction| direction.gain);
        directions.retain(|direction| direction.gain >= least);
        let (mut curves, laws): (Vec<&Direction>, Vec<&Direction>) =
            directions.into_iter().partition(|direction| self.is_free(direction.candidate));
        curves.sort_by(|a, b| a.log_chance.total_cmp(&b.log_chance));
        curves.truncate(CURVES);
        let mut chosen: Vec<&Direction> = Vec::new();
        for direction in laws {
            let of_term = chosen.iter().filter(|it| it.candidate == direction.candidate).count();
            if of_term < OF_A_TERM && chosen.len() < TRIED {
                chosen.push(direction);
            }
        }
        (chosen, curves)
    }

    /// A few steps from each start.
    fn trials(&self, from: &Fitted, chosen: &[&Direction]) -> Vec<Trial> {
        let trial = |direction: &&Direction| {
            let (chain, fit) = self.search.try_out(from, direction);
            Trial { term: direction.candidate, chain, fit }
        };
        let tried: Vec<Trial> = chosen.par_iter().map(trial).collect();
        for it in &tried {
            let gain = from.cost - it.fit.normal.cost;
            tracing::debug!("tried: {}: gain {gain:.1}", self.term(it.term).candidate.name);
        }
        tried.into_iter().filter(|trial| trial.fit.normal.cost.is_finite()).collect()
    }

    /// The terms that gain most after a few steps, refitted; of these the ones that traces left out, each in one step from the fit to
    /// all, and the likelihood speak for most.
    fn refitted(&self, from: &Fitted, mut tried: Vec<Trial>) -> Vec<Tried> {
        tried.sort_by(|a, b| a.fit.normal.cost.total_cmp(&b.fit.normal.cost));
        let gain = |trial: &Trial| from.cost - trial.fit.normal.cost;
        let most = tried.first().map_or(0.0, gain);
        let mut seen: Vec<usize> = Vec::new();
        tried.retain(|trial| {
            let alike =
                seen.iter().filter(|term| self.term(**term).acts_like(self.term(trial.term)));
            let is_new = !seen.contains(&trial.term) && alike.count() < ALIKE;
            let kept = is_new && gain(trial) >= CLOSE * most && seen.len() < REFITTED;
            if kept {
                seen.push(trial.term);
            }
            kept
        });
        let mut rivals: Vec<Rival> = tried
            .into_par_iter()
            .map(|Trial { term, chain, fit }| {
                let problem = self.search.problem.with_chain(&chain);
                let fitted = Fitted::new(&problem, &fit.point, Effort::QUICK);
                let effect = self.term(term).candidate.name.clone();
                Rival { candidate: term, effect, fitted, won: 0.0 }
            })
            .filter(|rival| rival.fitted.bic().is_finite() && rival.fitted.rms().is_finite())
            .collect();
        rivals.sort_by(|a, b| a.fitted.bic().total_cmp(&b.fitted.bic()));
        self.most_promising(rivals)
    }

    fn most_promising(&self, rivals: Vec<Rival>) -> Vec<Tried> {
        let problem = self.search.problem;
        let error = |rival: &Rival| {
            let left_out = held_out_in_one_step(problem, &rival.fitted);
            left_out.unwrap_or_else(|| over_sections(problem, &rival.fitted)).rms
        };
        let mut errors: Vec<(usize, f64)> = rivals.iter().map(error).enumerate().collect();
        errors.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut kept: Vec<usize> =
            errors.iter().take(IN_EARNEST).map(|(index, _)| *index).collect();
        // The likeliest may do better once it is refitted in earnest.
        kept.push(0);
        let seen = |(index, mut rival): (usize, Rival)| {
            let promising = kept.contains(&index);
            if promising {
                rival.fitted.go_on(problem);
            }
            Tried { exact: self.search.leaves_noise(&rival.fitted), promising, rival }
        };
        rivals.into_par_iter().enumerate().map(seen).collect()
    }

    /// Takes away every term beside which a later one has made it superfluous: without it, everything refitted, traces left out are
    /// predicted as well.
    fn without_the_superfluous(&self, found: &mut Found) {
        let mut index = 0;
        while index + 1 < found.steps.len() {
            match self.without(found, index) {
                Some(fewer) => *found = fewer,
                None => index += 1,
            }
        }
    }

    /// The search as if a step had not been taken, where that predicts as well.
    fn without(&self, found: &Found, index: usize) -> Option<Found> {
        let place = found.base.chain.effects.len() + index;
        let (mut models, mut evidence) =
            (found.models[..index].to_vec(), found.evidence[..=index].to_vec());
        for model in &found.models[index + 1..] {
            let range = model.chain.range(place);
            let chain = model.chain.without(place);
            let mut start = model.point.clone();
            start.drain(range);
            let problem = self.search.problem.with_chain(&chain);
            models.push(Fitted::new(&problem, &start, Effort::QUICK));
        }
        let (last, with) = (models.last()?, found.model());
        let own = Evidence::of(self.search.problem, last);
        let worse = found.evidence.last()?.left_out()?.gain(own.left_out()?).exceeds(1.0);
        if worse || with.beats_inexact(last, DECISIVE) {
            return None;
        }
        let between = &models[index..models.len() - 1];
        evidence.extend(between.iter().map(|model| Evidence::of(self.search.problem, model)));
        evidence.push(own);
        let mut steps = found.steps.clone();
        steps.remove(index);
        Some(Found { steps, models, evidence, ..found.clone() })
    }
}

impl Weighed<'_> {
    /// Refuses a term that leaves more than noise, on which the parts of the data do not agree, and whose gain on traces left out is
    /// not sure.
    fn gains_surely(&self, without: Judged, agreement: Option<f64>) -> Result<(), Refusal> {
        if self.exact || agreement.is_some_and(|chance| chance <= DISAGREEMENT) {
            return Ok(());
        }
        let gain = self.evidence.left_out().zip(without.evidence.left_out());
        match (gain.map(|(after, before)| after.gain(before)), agreement) {
            (Some(gain), _) if gain.exceeds(SURE) => Ok(()),
            (Some(gain), None) => Err(Refusal::HeldOutUncertain(gain)),
            (_, Some(chance)) => Err(Refusal::Disagreement(chance)),
            (None, None) => Ok(()),
        }
    }
}

/// The chance that any of so many scores is as large as one whose own chance has this logarithm, at most.
fn by_number(log_chance: f64, scores: usize) -> f64 {
    (log_chance + (scores as f64).ln()).exp().clamp(LEAST, 1.0)
}

/// Neighbours whose numbers of columns sum up to a portion at most, or single ones that have more.
fn portions(columns: impl Iterator<Item = usize>) -> Vec<std::ops::Range<usize>> {
    let mut found: Vec<std::ops::Range<usize>> = Vec::new();
    let mut filled = 0;
    for (index, columns) in columns.enumerate() {
        match found.last_mut() {
            Some(last) if filled + columns <= PORTION => {
                last.end = index + 1;
                filled += columns;
            }
            _ => {
                found.push(index..index + 1);
                filled = columns;
            }
        }
    }
    found
}

/// Matrices of as many rows side by side.
fn side_by_side(parts: &[DMatrix<f64>]) -> DMatrix<f64> {
    let rows = parts.first().map_or(0, DMatrix::nrows);
    let columns = parts.iter().map(DMatrix::ncols).sum();
    let values = parts.iter().flat_map(|part| part.iter().copied());
    DMatrix::from_iterator(rows, columns, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_draw_reaches_is_significant_in_however_many_portions() {
        // A draw tells no less than this, which so many portions would make more than chance allows.
        const { assert!(40.0 * LEAST > 0.005) };
        assert!(by_number(-60.0, 3000) < 0.005);
        assert!(by_number(-5.0, 3000) > 0.5);
    }

    #[test]
    fn portions_hold_all_terms_in_order() {
        let columns = [60, 30, 6, 1, 200, 90, 7];
        let found = portions(columns.into_iter());
        assert_eq!(found, [0..3, 3..4, 4..5, 5..6, 6..7]);
    }

    #[test]
    fn matrices_stand_side_by_side() {
        let parts = [DMatrix::from_element(2, 1, 1.0), DMatrix::from_element(2, 2, 2.0)];
        assert_eq!(
            side_by_side(&parts),
            DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 2.0, 1.0, 2.0, 2.0])
        );
    }
}
