//! The search for formulas: the grammar is screened in portions, the likeliest terms are refitted, and the one is kept that traces
//! left out bear out, again and again until only noise is left.

use rayon::prelude::*;

use super::grammar::Term;
use crate::criticism::agreement;
use crate::criticism::evidence::{Evidence, Judged, Refusal, Refused, weigh};
use crate::criticism::fitted::Fitted;
use crate::criticism::held_out::{held_out_in_one_step, over_sections};
use crate::criticism::screen::{Direction, Screen, screen};
use crate::criticism::search::{DECISIVE, Found, Rival, Search, Step};
use nalgebra::DMatrix;
use palpate_fit::least_squares::Effort;

/// Sensitivities that are screened at a time: what is counted of every two of them grows with their square.
const PORTION: usize = 96;
/// Most starts that are tried, and most of one term.
const TRIED: usize = 20;
const OF_A_TERM: usize = 4;
/// A start is tried from this part of the best foretold gain on.
const WORTH: f64 = 0.1;
/// Most terms that are refitted, of those that gain this part of the best after a few steps.
const REFITTED: usize = 6;
const CLOSE: f64 = 0.3;
/// Terms whose traces left out are predicted by refits in earnest: those that one step speaks for most.
const IN_EARNEST: usize = 2;
/// Chance of as much agreement between the parts of the data above which they do not agree.
const DISAGREEMENT: f64 = 0.1;
/// Standard errors over the traces that a free curve, on which parts cannot vote, has to gain.
const SURE: f64 = 2.0;

/// A search over the terms of the grammar.
pub(super) struct Climb<'a> {
    pub(super) search: &'a Search<'a>,
    pub(super) terms: &'a [Term],
}

/// A term refitted beside the last model, with the evidence for it.
struct Weighed {
    rival: Rival,
    evidence: Evidence,
    /// Whether what it leaves is noise.
    exact: bool,
}

impl Climb<'_> {
    /// Adds terms to a model, and no further than to the first that leaves only noise.
    pub(super) fn from(&self, base: Fitted) -> Found {
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
        while self.step_up(&mut found) {
            let enough = found.steps.len() >= self.search.options.max_effects
                || self.search.leaves_noise(found.model());
            if enough {
                break;
            }
            found.last = self.screened(found.model());
        }
        found
    }

    /// Screens the grammar beside a model. The chances are those of the largest score of a portion under noise alone, times the
    /// number of portions.
    fn screened(&self, fitted: &Fitted) -> Screen {
        let Search { data, candidates, whitening, problem, .. } = *self.search;
        let problem = problem.with_chain(&fitted.chain);
        let portions = portions(candidates.iter().map(|candidate| {
            candidate.forms.iter().map(|form| form.grid.len() * form.applied.strengths).sum()
        }));
        let (mut directions, mut chance, mut scores): (
            Vec<Direction>,
            Vec<f64>,
            Vec<DMatrix<f64>>,
        ) = Default::default();
        let mut columns = 0;
        for portion in &portions {
            let own = &candidates[portion.clone()];
            let found = screen(&problem, data, &fitted.point, whitening, own);
            let times = portions.len() as f64;
            chance.extend(found.chance.iter().map(|chance| (times * chance).min(1.0)));
            directions.extend(found.directions.into_iter().map(|mut direction| {
                direction.candidate += portion.start;
                direction.columns =
                    direction.columns.start + columns..direction.columns.end + columns;
                direction
            }));
            columns += found.scores.ncols();
            scores.push(found.scores);
        }
        Screen { directions, chance, cosines: DMatrix::zeros(0, 0), scores: beside(&scores) }
    }

    /// Adds the term that the traces left out bear out best; of several that do as well, the one with the lowest information
    /// criterion. False where there is none.
    fn step_up(&self, found: &mut Found) -> bool {
        let level = 0.5 * self.search.options.false_alarms;
        if found.last.chance.iter().all(|chance| *chance > level) {
            return false;
        }
        let without =
            Judged { fitted: found.model(), evidence: &found.evidence[found.steps.len()] };
        let agreement = agreement::chances(&found.last, self.search.candidates);
        let with_evidence = |rivals: Vec<Rival>| -> Vec<Weighed> {
            let shown = |rival: &Rival| found.last.chance[rival.candidate] <= level;
            let weighed = |rival: Rival| Weighed {
                evidence: Evidence::of(self.search.problem, &rival.fitted),
                exact: self.search.leaves_noise(&rival.fitted),
                rival,
            };
            rivals.into_iter().filter(shown).map(weighed).collect()
        };
        let (laws, curve) = self.worth_a_try(&found.last);
        let mut weighed = with_evidence(self.refitted(found.model(), &laws));
        // Where a law leaves only noise no curve is wanted, which takes long to refit.
        if !weighed.iter().any(|it| it.exact) {
            weighed.extend(with_evidence(self.refitted(found.model(), &curve)));
        }
        let mut refusals = Vec::new();
        let mut borne_out: Vec<&Weighed> = Vec::new();
        for it in &weighed {
            match self.weigh(without, it, agreement[it.rival.candidate]) {
                Ok(()) => borne_out.push(it),
                Err(reason) => refusals.push(refused(without, it, reason)),
            }
        }
        let error =
            |it: &Weighed| it.evidence.left_out().map_or(f64::INFINITY, |errors| errors.rms);
        let Some(best) = borne_out.iter().min_by(|a, b| error(a).total_cmp(&error(b))).copied()
        else {
            found.refuse(refusals);
            return false;
        };
        let as_good = |it: &&&Weighed| match (best.evidence.left_out(), it.evidence.left_out()) {
            (Some(best), Some(own)) => !best.gain(own).exceeds(1.0),
            _ => false,
        };
        let mut as_good: Vec<&Weighed> = borne_out.iter().filter(as_good).copied().collect();
        as_good.sort_by(|a, b| a.rival.fitted.bic().total_cmp(&b.rival.fitted.bic()));
        let chosen = as_good.first().copied().unwrap_or(best);
        let names = as_good.iter().map(|it| it.rival.effect.clone()).collect();
        let candidate = chosen.rival.candidate;
        let p_value =
            if chosen.exact { found.last.chance[candidate] } else { agreement[candidate] };
        let (effect, model) = (chosen.rival.effect.clone(), chosen.rival.fitted.clone());
        let evidence = chosen.evidence.clone();
        let rivals = weighed.iter().map(|it| it.rival.clone()).collect();
        found.refuse(refusals);
        found.refused.retain(|refused| refused.effect != effect);
        found.models.push(model);
        found.evidence.push(evidence);
        found.steps.push(Step::chosen(effect, p_value, rivals, names));
        true
    }

    /// What speaks against a term. Where it leaves more than noise, its fit must gain by the samples that are independent in what it
    /// leaves, and the parts of the data must agree.
    fn weigh(&self, without: Judged, it: &Weighed, agreement: f64) -> Result<(), Refusal> {
        let with = Judged { fitted: &it.rival.fitted, evidence: &it.evidence };
        weigh(without, with, it.exact)?;
        if it.exact {
            return Ok(());
        }
        if !with.fitted.beats_inexact(without.fitted, DECISIVE) {
            return Err(Refusal::FitUncertain);
        }
        if !self.terms[it.rival.candidate].shape.is_free() {
            return if agreement > DISAGREEMENT {
                Err(Refusal::Disagreement(agreement))
            } else {
                Ok(())
            };
        }
        let gain = with.evidence.left_out().zip(without.evidence.left_out());
        match gain.map(|(after, before)| after.gain(before)) {
            Some(gain) if !gain.exceeds(SURE) => Err(Refusal::HeldOutUncertain(gain)),
            _ => Ok(()),
        }
    }

    /// The terms that traces left out, each in one step from the fit to all, and the likelihood speak for most, refitted.
    fn refitted(&self, from: &Fitted, chosen: &[&Direction]) -> Vec<Rival> {
        let mut tried: Vec<_> = chosen
            .par_iter()
            .map(|direction| (*direction, self.search.try_out(from, direction)))
            .filter(|(_, (_, trial))| trial.normal.cost.is_finite())
            .collect();
        tried.sort_by(|a, b| a.1.1.normal.cost.total_cmp(&b.1.1.normal.cost));
        let gain = |cost: f64| from.cost - cost;
        let most = tried.first().map_or(0.0, |(_, (_, trial))| gain(trial.normal.cost));
        let mut seen: Vec<usize> = Vec::new();
        tried.retain(|(direction, (_, trial))| {
            let is_new = !seen.contains(&direction.candidate);
            let close = gain(trial.normal.cost) >= CLOSE * most;
            if is_new && close {
                seen.push(direction.candidate);
            }
            is_new && close && seen.len() <= REFITTED
        });
        let mut rivals: Vec<Rival> = tried
            .into_par_iter()
            .map(|(direction, (chain, trial))| {
                let problem = self.search.problem.with_chain(&chain);
                let fitted = Fitted::new(&problem, &trial.point, Effort::QUICK);
                let effect = self.search.candidates[direction.candidate].name.clone();
                Rival { candidate: direction.candidate, effect, fitted, won: 0.0 }
            })
            .filter(|rival| rival.fitted.bic().is_finite() && rival.fitted.rms().is_finite())
            .collect();
        rivals.sort_by(|a, b| a.fitted.bic().total_cmp(&b.fitted.bic()));
        self.most_promising(rivals)
    }

    /// The starts that the screen foretells most for, and the best free curve: where no law has the shape, that predicts.
    fn worth_a_try<'b>(&self, screened: &'b Screen) -> (Vec<&'b Direction>, Vec<&'b Direction>) {
        let mut directions: Vec<&Direction> =
            screened.directions.iter().filter(|direction| direction.gain > 0.0).collect();
        directions.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let least = WORTH * directions.first().map_or(0.0, |direction| direction.gain);
        let is_free = |direction: &&Direction| self.terms[direction.candidate].shape.is_free();
        let free = directions.iter().copied().find(is_free).filter(|it| it.gain >= least);
        let mut chosen: Vec<&Direction> = Vec::new();
        for direction in directions.iter().copied().filter(|it| !is_free(it)) {
            let of_term = chosen.iter().filter(|it| it.candidate == direction.candidate).count();
            if direction.gain >= least && of_term < OF_A_TERM && chosen.len() < TRIED {
                chosen.push(direction);
            }
        }
        (chosen, free.into_iter().collect())
    }

    fn most_promising(&self, rivals: Vec<Rival>) -> Vec<Rival> {
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
        let place = |(index, rival)| kept.contains(&index).then_some(rival);
        rivals.into_iter().enumerate().filter_map(place).collect()
    }
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
fn beside(parts: &[DMatrix<f64>]) -> DMatrix<f64> {
    let rows = parts.first().map_or(0, DMatrix::nrows);
    let columns = parts.iter().map(DMatrix::ncols).sum();
    let values = parts.iter().flat_map(|part| part.iter().copied());
    DMatrix::from_iterator(rows, columns, values)
}

fn refused(without: Judged, it: &Weighed, reason: Refusal) -> Refused {
    let held_out = |evidence: &Evidence| evidence.held_out.as_ref().map(|held_out| held_out.rms);
    Refused {
        effect: it.rival.effect.clone(),
        law: "own".into(),
        reason,
        rms: (without.fitted.rms(), it.rival.fitted.rms()),
        held_out: held_out(without.evidence).zip(held_out(&it.evidence)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn portions_hold_all_terms_in_order() {
        let columns = [60, 30, 6, 1, 200, 90, 7];
        let found = portions(columns.into_iter());
        assert_eq!(found, [0..3, 3..4, 4..5, 5..6, 6..7]);
    }

    #[test]
    fn matrices_stand_side_by_side() {
        let parts = [DMatrix::from_element(2, 1, 1.0), DMatrix::from_element(2, 2, 2.0)];
        assert_eq!(beside(&parts), DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 2.0, 1.0, 2.0, 2.0]));
    }
}
