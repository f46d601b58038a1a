//! What would do better in the place of all that a search found: one effect alone, another law of it, or the base law begun anew
//! beside it.

use rayon::prelude::*;

use super::fitted::Fitted;
use super::screen::{Direction, Screen};
use super::search::{DECISIVE, Found, Rival, Search, Step};
use palpate_fit::base_anew::base_anew;
use palpate_fit::least_squares::{Effort, Solution};
use palpate_fit::watch;
use palpate_model::Chain;

/// One effect is tried in the place of several where a few steps with it alone explain this part of what
/// they do.
const ALONE: f64 = 0.7;
/// The base law is begun anew beside one effect where that explains this part of what several do.
const PROMISING: f64 = 0.4;
/// Most laws that are tried from where the effects found have taken the base law.
const MOST_LAWS: usize = 12;

impl Search<'_> {
    /// Puts one effect in the place of several where it alone does as well: a first step that was wrong
    /// can hide in what came after it.
    pub(super) fn collapse(&self, found: &mut Found) -> bool {
        if found.steps.len() < 2 || found.steps.iter().all(|step| step.fresh) {
            return false;
        }
        let names: Vec<&str> = found.steps.iter().map(|step| step.effect.as_str()).collect();
        let named = |direction: &&Direction| {
            names.contains(&self.candidates[direction.candidate].name.as_str())
        };
        let directions: Vec<Direction> =
            found.first.directions.iter().filter(named).cloned().collect();
        let tried = self.tried(&found.base, directions.par_iter());
        self.put_in_place(found, tried, DECISIVE)
    }

    /// The same with every law of the library, where what was found is several effects or leaves more than noise: of a law whose misfit
    /// the base law has taken on, the straight line of the screen foretells little. Then with those that it foretells most for where the
    /// effects found have taken the base law.
    pub(super) fn look_through(&self, found: &mut Found) -> bool {
        let single = found.steps.len() < 2;
        if found.steps.is_empty() {
            return false;
        }
        if single && self.leaves_noise(found.model()) {
            // A law on a bound may be the limit of another one of the same effect.
            let on_bound = found.model().last_effect_at_bound().is_some();
            return on_bound && self.put_named_in_place(found, DECISIVE);
        }
        let rise = if single { -DECISIVE } else { DECISIVE };
        let every = most_promising(&found.first);
        let tried = self.tried(&found.base, every.par_iter());
        if self.put_in_place(found, tried, rise) {
            return true;
        }
        let moved = &found.model().point[..found.base.point.len()];
        let moved = Fitted::new(&self.problem.with_chain(&found.base.chain), moved, Effort::NONE);
        let mut likely = most_promising(&self.screen(&moved));
        let named = |it: &Direction| found.names(&self.candidates[it.candidate].name);
        likely.sort_by(|a, b| named(b).cmp(&named(a)).then(b.gain.total_cmp(&a.gain)));
        likely.truncate(MOST_LAWS);
        // The base law is where it would be with an effect that is nearly right.
        likely.iter_mut().for_each(|direction| direction.shift.fill(0.0));
        let tried = self.tried(&moved, likely.par_iter());
        self.put_in_place(found, tried, rise)
            || self.put_named_in_place(found, rise)
            || self.begin_base_anew(found)
    }

    /// The same with every law of the effects that were found, from all shapes of the screen: of one that is far from straight some lead
    /// nowhere.
    fn put_named_in_place(&self, found: &mut Found, rise: f64) -> bool {
        let named =
            |direction: &&Direction| found.names(&self.candidates[direction.candidate].name);
        let directions: Vec<&Direction> = found.first.directions.iter().filter(named).collect();
        let fits = self.fits_of(&found.base, &directions);
        let mut best = best_of_each_law(
            directions.into_iter().zip(fits),
            |(direction, _)| direction,
            |(_, fitted)| -fitted.cost,
        );
        let explained = found.base.cost - found.model().cost;
        best.retain(|(_, fitted)| found.base.cost - fitted.cost > PROMISING * explained);
        let anew = |(direction, fitted): &(&Direction, Fitted)| {
            (direction.candidate, self.with_base_anew(fitted))
        };
        let rivals = self.by_effect(best.iter().map(anew).collect(), &found.base);
        self.put_best_in_place(found, rivals, rise)
    }

    /// Begins the base law anew beside all effects that were found, if that describes the data decisively better.
    fn begin_base_anew(&self, found: &mut Found) -> bool {
        let anew = self.with_base_anew(found.model());
        if anew.cost > found.model().cost - DECISIVE {
            return false;
        }
        self.rebuild(found, anew);
        found.steps.iter_mut().for_each(|step| step.fresh = false);
        found.last = self.screen(found.model());
        true
    }

    /// A model that leaves more than noise with its base law begun anew beside its effects, where that describes the data better.
    #[must_use]
    pub fn with_base_anew(&self, fitted: &Fitted) -> Fitted {
        if self.leaves_noise(fitted) {
            return fitted.clone();
        }
        let problem = self.problem.with_chain(&fitted.chain);
        let starts = base_anew(&problem, &fitted.point);
        let begun = starts.par_iter().map(|start| Fitted::new(&problem, start, Effort::QUICK));
        let best = begun.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let Some(mut best) = best.filter(|best| best.cost < fitted.cost) else {
            return fitted.clone();
        };
        best.go_on(self.problem);
        tracing::debug!("base law begun anew: gain {:.1}", fitted.cost - best.cost);
        best
    }

    /// The model with each of these laws, from what the screen foretells, and where that is nothing from its typical size.
    #[must_use]
    pub fn fits_of(&self, from: &Fitted, directions: &[&Direction]) -> Vec<Fitted> {
        watch::stage("starts of laws", directions.len());
        let start = |direction: &Direction| {
            let mut start = direction.clone();
            if start.gain <= 0.0 {
                let form = &self.candidates[start.candidate].forms[start.form];
                start.strengths.fill(form.typical);
                start.shift.fill(0.0);
            }
            start
        };
        let fitted = |direction: &&Direction| {
            let (chain, found) = self.try_out(from, &start(direction));
            let fitted = Fitted::new(&self.problem.with_chain(&chain), &found.point, Effort::QUICK);
            watch::done();
            fitted
        };
        directions.par_iter().map(fitted).collect()
    }

    /// Puts the best of these laws in the place of all effects that were found, if the information criterion rises by no more than
    /// `rise`.
    fn put_in_place(
        &self,
        found: &mut Found,
        mut tried: Vec<(&Direction, Chain, Solution)>,
        rise: f64,
    ) -> bool {
        tried.sort_by(|a, b| a.2.normal.cost.total_cmp(&b.2.normal.cost));
        let explained = found.base.cost - found.model().cost;
        let gain = |trial: &Solution| found.base.cost - trial.normal.cost;
        for (direction, _, trial) in tried.iter().take(8) {
            let candidate = &self.candidates[direction.candidate];
            let law = &candidate.forms[direction.form].applied.law;
            tracing::debug!("tried alone: {} ({law}): gain {:.1}", candidate.name, gain(trial));
        }
        tried.retain(|(.., trial)| gain(trial) > ALONE * explained);
        tried.truncate(2);
        let rivals = self.refitted(&found.base, tried, Effort::LONG);
        self.put_best_in_place(found, rivals, rise)
    }

    /// The same with the best of these rivals.
    fn put_best_in_place(&self, found: &mut Found, rivals: Vec<Rival>, rise: f64) -> bool {
        let Some(best) = rivals.first() else { return false };
        if best.fitted.bic() > found.model().bic() + rise {
            return false;
        }
        let effect = best.effect.clone();
        let p_value = found.first.chance_of_step(best.candidate, self.options.false_alarms);
        tracing::debug!("in the place of {} effects: {effect}", found.steps.len());
        found.models = vec![best.fitted.clone()];
        found.steps = vec![Step { effect, p_value, rivals, credible: Vec::new(), fresh: false }];
        found.last = self.screen(found.model());
        true
    }
}

/// Of each law the direction that explains most, where any explains something.
fn most_promising(screen: &Screen) -> Vec<Direction> {
    let some = screen.directions.iter().filter(|direction| direction.gain > 0.0);
    best_of_each_law(some, |direction| direction, |direction| direction.gain)
        .into_iter()
        .cloned()
        .collect()
}

/// Of all that begin with the same law the one of most value.
fn best_of_each_law<T>(
    all: impl Iterator<Item = T>,
    begun: impl Fn(&T) -> &Direction,
    value: impl Fn(&T) -> f64,
) -> Vec<T> {
    let law = |it: &T| (begun(it).candidate, begun(it).form);
    let mut best: Vec<T> = Vec::new();
    for it in all {
        match best.iter_mut().find(|other| law(other) == law(&it)) {
            Some(other) if value(&it) > value(other) => *other = it,
            Some(_) => {}
            None => best.push(it),
        }
    }
    best
}
