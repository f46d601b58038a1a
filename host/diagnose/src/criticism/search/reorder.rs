//! The effects of a search by likelihood in another order, or those that predict one by one.

use super::found::{Found, Rival, Step, refused};
use super::{DECISIVE, Search};
use crate::criticism::evidence::Judged;
use crate::criticism::fitted::Fitted;
use palpate_fit::least_squares::Effort;
use palpate_model::{Applied, Chain};

impl Search<'_> {
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
