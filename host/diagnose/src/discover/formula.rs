//! A term that was found, with its numbers and the evidence for it.

use super::grammar::Term;
use crate::criticism::diagnose::Diagnosis;
use crate::criticism::fitted::Fitted;
use crate::criticism::screen::screen;
use crate::criticism::search::{Found, Step};
use palpate_fit::data::Data;
use palpate_fit::problem::Problem;
use palpate_model::StoredEffect;
use palpate_model::effects::{candidates, store};

/// A formula that lowers the error on traces left out.
#[derive(Clone, Debug)]
pub struct Formula {
    /// Name under which it is added: `found-1`.
    pub name: String,
    /// The term of the grammar.
    pub term: Term,
    /// The law with its parameters, as a model file holds it.
    pub law: StoredEffect,
    /// Chance of as much where nothing is missing, over the whole grammar.
    pub p_value: f64,
    /// Other terms that these traces do not tell from it.
    pub alternatives: Vec<Alternative>,
    /// Effects of the library whose mark on these traces looks most alike, with the cosine between the two.
    pub resembles: Vec<(String, f64)>,
    /// How much of it there is in parts of the data, 1 being all.
    pub shares: Shares,
}

/// Another term in the place of a formula.
#[derive(Clone, Debug)]
pub struct Alternative {
    /// The term of the grammar.
    pub term: Term,
    /// Its law with its parameters.
    pub law: StoredEffect,
    /// By how much its information criterion is larger.
    pub delta_bic: f64,
}

/// How much of a term there is in parts of the data: the factor by which least squares would multiply it there.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    /// While pressing, with the standard error over the traces.
    pub pressing: (f64, f64),
    /// While releasing.
    pub releasing: (f64, f64),
    /// In each trace; NaN where it does nothing.
    pub traces: Vec<f64>,
}

/// Cosine from which on an effect counts as alike.
const ALIKE: f64 = 0.7;
/// A trace in which a term does less than this part of what it does in others, in squares, says nothing of its size.
const FELT: f64 = 0.05;
/// Most effects that are told as alike.
const MOST_ALIKE: usize = 3;
/// Most alternatives that are told.
const MOST_ALTERNATIVES: usize = 5;

/// The formulas of a search, in the order in which they were found.
#[must_use]
pub fn formulas(
    found: &Found,
    terms: &[Term],
    problem: &Problem,
    data: &Data,
    diagnosis: &Diagnosis,
) -> Vec<Formula> {
    let first = found.base.chain.effects.len();
    let last = found.model();
    let errors = last.standard_errors(&problem.with_chain(&last.chain), true);
    let laws = store(&last.chain, &last.values, &errors);
    let formula = |(index, step): (usize, &Step)| {
        let term = terms.iter().find(|term| term.candidate.name == step.effect)?;
        let name = format!("found-{}", index + 1);
        let law = named(&laws[first + index], &name, term);
        Some(Formula {
            resembles: resembling(&law, found, problem, data, diagnosis),
            shares: shares(last, first + index, problem, data),
            alternatives: alternatives(step, terms, first + index),
            p_value: step.p_value,
            term: term.clone(),
            name,
            law,
        })
    };
    found.steps.iter().enumerate().filter_map(formula).collect()
}

/// A law under the name by which it is added, with what it means.
fn named(law: &StoredEffect, name: &str, term: &Term) -> StoredEffect {
    let meaning = Some(term.name());
    let law = term.knots.as_ref().map_or_else(|| law.clone(), |knots| knots.law(law));
    StoredEffect { name: name.to_owned(), meaning, ..law }
}

fn alternatives(step: &Step, terms: &[Term], place: usize) -> Vec<Alternative> {
    let Some(own) = step.rivals.iter().find(|rival| rival.effect == step.effect) else {
        return Vec::new();
    };
    let alternative = |name: &String| {
        let rival = step.rivals.iter().find(|rival| rival.effect == *name)?;
        let term = terms.iter().find(|term| term.candidate.name == *name)?;
        let errors = vec![None; rival.fitted.values.len()];
        let laws = store(&rival.fitted.chain, &rival.fitted.values, &errors);
        let law = named(laws.get(place)?, name, term);
        let delta_bic = rival.fitted.bic() - own.fitted.bic();
        Some(Alternative { term: term.clone(), law, delta_bic })
    };
    let others = step.credible.iter().filter(|name| **name != step.effect);
    let mut found: Vec<Alternative> = others.filter_map(alternative).collect();
    found.sort_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
    found.truncate(MOST_ALTERNATIVES);
    found
}

/// The effects of the library whose sensitivities look most like that of a law, the model's own derivatives taken off both.
fn resembling(
    law: &StoredEffect,
    found: &Found,
    problem: &Problem,
    data: &Data,
    diagnosis: &Diagnosis,
) -> Vec<(String, f64)> {
    let Ok(tried) = candidates(&data.setting(), std::slice::from_ref(law)) else {
        return Vec::new();
    };
    let Some(own) = tried.iter().position(|candidate| candidate.name == law.name) else {
        return Vec::new();
    };
    let base = problem.with_chain(&found.base.chain);
    let screened = screen(&base, data, &found.base.point, &diagnosis.noise.whitening, &tried);
    let Some(column) =
        screened.directions.iter().find(|d| d.candidate == own).map(|d| d.columns.start)
    else {
        return Vec::new();
    };
    let mut alike: Vec<(String, f64)> = Vec::new();
    for direction in screened.directions.iter().filter(|d| d.candidate != own) {
        let cosines = direction.columns.clone().map(|k| screened.cosines[(column, k)].abs());
        // Where a law has several strengths, their sum of squares bounds what they can do together.
        let cosine = cosines.map(|c| c * c).sum::<f64>().sqrt().min(1.0);
        let name = &tried[direction.candidate].name;
        match alike.iter_mut().find(|(known, _)| known == name) {
            Some((_, best)) => *best = best.max(cosine),
            None => alike.push((name.clone(), cosine)),
        }
    }
    alike.retain(|(_, cosine)| *cosine >= ALIKE);
    alike.sort_by(|a, b| b.1.total_cmp(&a.1));
    alike.truncate(MOST_ALIKE);
    alike
}

/// How much of a term there is in parts of the data, everything else left as it is.
fn shares(fitted: &Fitted, place: usize, problem: &Problem, data: &Data) -> Shares {
    let problem = problem.with_chain(&fitted.chain);
    let first = fitted.chain.range(place).start;
    let mut without = fitted.values.clone();
    without[first..first + fitted.chain.effects[place].strengths].fill(0.0);
    let points = [problem.point(&fitted.values), problem.point(&without)];
    let traces = data.labels.len();
    // Products of what the term does with what is there without it, and of what it does with itself.
    let mut sums = [vec![[0.0; 2]; traces], vec![[0.0; 2]; traces], vec![[0.0; 2]; traces]];
    problem.each_piece(&points, |piece, forces| {
        let scene = data.scene(piece);
        let samples =
            forces[0].iter().zip(&forces[1]).zip(piece.measured).zip(scene.velocity.iter());
        for (((with, without), measured), velocity) in samples {
            let (does, left) = (with - without, measured - without);
            let way = if *velocity > 0.0 { 0 } else { 1 };
            for part in [way, 2] {
                let sum = &mut sums[part][piece.trace];
                *sum = [sum[0] + does * left, sum[1] + does * does];
            }
        }
    });
    let [pressing, releasing, all] = sums;
    let usual = all.iter().map(|sum| sum[1]).sum::<f64>() / traces as f64;
    let share = |sum: &[f64; 2]| {
        if sum[1] > FELT * usual { sum[0] / sum[1] } else { f64::NAN }
    };
    Shares {
        pressing: over_traces(&pressing),
        releasing: over_traces(&releasing),
        traces: all.iter().map(share).collect(),
    }
}

/// The share over all traces, with its standard error by the jackknife over them.
fn over_traces(sums: &[[f64; 2]]) -> (f64, f64) {
    let total = sums.iter().fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
    let share = total[0] / total[1];
    let count = sums.len() as f64;
    let without = |part: &[f64; 2]| (total[0] - part[0]) / (total[1] - part[1]) - share;
    let squares: f64 = sums.iter().map(without).filter(|off| off.is_finite()).map(|o| o * o).sum();
    (share, (squares * (count - 1.0) / count).sqrt())
}
