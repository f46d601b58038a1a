//! Which laws are refitted in a step, from where, and which of them stands for its effect.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::{Rival, Search};
use crate::criticism::fitted::Fitted;
use crate::criticism::screen::{Direction, Screen};
use crate::criticism::touch::begun_at_touch;
use palpate_fit::least_squares::{Effort, LeastSquares, Solution, minimise_with};
use palpate_fit::remembering::Remembering;
use palpate_fit::watch;
use palpate_model::Chain;

/// Which laws are refitted in a step.
pub(super) struct Breadth {
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
pub(super) const NARROW: Breadth = Breadth { refits: 12, laws: 12, worth: 0.25, close: 0.5 };
/// Where traces left out rank, and a law that fits less may predict more.
pub(super) const BROAD: Breadth = Breadth { refits: 16, laws: 2, worth: 0.1, close: 0.2 };
/// A law whose search has not come to its end goes on with it where it explains this part of what the best does.
const CONTENDS: f64 = 0.8;
/// Other shapes that a law on a bound is fitted from.
const ELSEWHERE: usize = 3;
/// Effects that are always refitted.
const FEWEST: usize = 3;

impl Search<'_> {
    /// Refits the laws that the screen foretells the most for, and names their effects, best first.
    pub(super) fn refit(&self, from: &Fitted, screen: &Screen, breadth: &Breadth) -> Vec<Rival> {
        let chosen = self.worth_a_try(from, screen, breadth);
        // A few steps for all tell which are worth going on with.
        let mut tried = self.tried(from, chosen.par_iter().copied());
        self.keep_close(from, &mut tried, breadth);
        let mut rivals = self.refitted(from, tried, Effort::QUICK);
        self.begin_elsewhere(from, screen, &chosen, &mut rivals);
        self.begin_at_touch(from, &mut rivals);
        rivals
    }

    /// The laws of effects that the model lacks for which the screen foretells the most, each from its best shape.
    fn worth_a_try<'s>(
        &self,
        from: &Fitted,
        screen: &'s Screen,
        breadth: &Breadth,
    ) -> Vec<&'s Direction> {
        let lacking = |direction: &&Direction| {
            let name = &self.candidates[direction.candidate].name;
            from.chain.effects.iter().all(|effect| effect.name != *name)
        };
        let mut directions: Vec<&Direction> =
            screen.directions.iter().filter(|d| d.gain > 0.0).filter(lacking).collect();
        directions.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let most = directions.first().map_or(0.0, |d| d.gain);
        let mut chosen: Vec<&Direction> = Vec::new();
        for direction in directions {
            let same =
                |d: &&Direction| (d.candidate, d.form) == (direction.candidate, direction.form);
            let of_effect = chosen.iter().filter(|d| d.candidate == direction.candidate).count();
            let wanted = direction.gain >= breadth.worth * most && of_effect < breadth.laws;
            if wanted && !chosen.iter().any(same) && chosen.len() < breadth.refits {
                tracing::debug!(
                    "worth a try: {}, shapes {:?}, predicted gain {:.1}, strengths {:?}, left {:.3}",
                    self.law_of(direction),
                    direction.shapes,
                    direction.gain,
                    direction.strengths,
                    direction.left
                );
                chosen.push(direction);
            }
        }
        chosen
    }

    /// Keeps the laws that explain nearly as much as the best after a few steps, and the first few effects.
    fn keep_close(
        &self,
        from: &Fitted,
        tried: &mut Vec<(&Direction, Chain, Solution)>,
        breadth: &Breadth,
    ) {
        tried.retain(|(.., found)| found.normal.cost.is_finite());
        tried.sort_by(|a, b| a.2.normal.cost.total_cmp(&b.2.normal.cost));
        let gain = |found: &Solution| from.cost - found.normal.cost;
        for (direction, _, found) in &*tried {
            let law = self.law_of(direction);
            tracing::debug!("tried: {law}: gain {:.1}, {}", gain(found), found.stop);
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
    }

    /// The effect and the law of a direction, as a log names them.
    fn law_of(&self, direction: &Direction) -> String {
        let candidate = &self.candidates[direction.candidate];
        format!("{} ({})", candidate.name, candidate.forms[direction.form].applied.law)
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

    /// A few steps with each of these laws, in their order.
    pub(in crate::criticism) fn tried<'d>(
        &self,
        from: &Fitted,
        directions: impl IndexedParallelIterator<Item = &'d Direction>,
    ) -> Vec<(&'d Direction, Chain, Solution)> {
        watch::stage("laws tried", directions.len());
        let tried = |direction: &'d Direction| {
            let (chain, trial) = self.try_out(from, direction);
            watch::done();
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

    /// Fits each from where it was tried, and to its end those that may be the best; the best law of each effect, best
    /// effect first.
    pub(in crate::criticism) fn refitted(
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
    pub(in crate::criticism) fn by_effect(
        &self,
        fits: Vec<(usize, Fitted)>,
        from: &Fitted,
    ) -> Vec<Rival> {
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
}

pub(super) fn by_criterion(a: &Rival, b: &Rival) -> Ordering {
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
