//! What is asked of the effects that were found: whether another would do better in the place of one, whether each is still needed,
//! and in which order they explain most.

use super::refit::{NARROW, by_criterion};
use super::{DECISIVE, Found, MINOR, Rival, Search, Step, is_line};
use crate::criticism::fitted::Fitted;
use crate::criticism::screen::Screen;
use palpate_fit::least_squares::Effort;

/// Most replacements of effects already found.
const MOST_ROUNDS: usize = 5;

impl Search<'_> {
    /// Asks of every effect whether another would do better in its place, and whether it is still
    /// needed; true if the model has changed.
    pub(super) fn polish(&self, found: &mut Found) -> bool {
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
    pub(super) fn order(&self, found: &mut Found) {
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
    pub(super) fn drop_minor(&self, found: &mut Found) {
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

    /// The model without one of its effects, refitted and screened.
    fn without(&self, found: &Found, index: usize) -> (Fitted, Screen) {
        let fitted = self.fitted_without(found, index);
        let screen = self.screen(&fitted);
        (fitted, screen)
    }

    /// The model without one of its effects, refitted.
    pub(super) fn fitted_without(&self, found: &Found, index: usize) -> Fitted {
        let model = found.model();
        let place = found.base.chain.effects.len() + index;
        let range = model.chain.range(place);
        let chain = model.chain.without(place);
        let mut start = model.point.clone();
        start.drain(range);
        Fitted::new(&self.problem.with_chain(&chain), &start, Effort::QUICK)
    }

    /// Refits the models on the way to the last, one effect more in each.
    pub(in crate::criticism) fn rebuild(&self, found: &mut Found, last: Fitted) {
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

/// Whether one more effect explains next to nothing of what all explain together.
fn is_minor(base: &Fitted, without: &Fitted, with: &Fitted) -> bool {
    let share = |of: fn(&Fitted) -> f64| {
        (of(without) - of(with)) / (of(base) - of(with)).max(f64::MIN_POSITIVE)
    };
    share(|fitted| fitted.cost) < MINOR && share(|fitted| fitted.rms().powi(2)) < MINOR
}
