//! Effects one by one, each borne out by what it was not fitted to: for data that no law describes to the noise, where its likelihood
//! says nothing about names.

use super::credible::resample;
use super::found::{Found, Rival, Step, refused, rises};
use super::refit::{BROAD, by_criterion};
use super::{DECISIVE, MINOR, SURE, Search, is_line};
use crate::criticism::agreement;
use crate::criticism::evidence::{
    Evidence, Judged, Refusal, Refused, weigh, weigh_fit, weigh_left_out,
};
use crate::criticism::fitted::Fitted;
use crate::criticism::held_out::{held_out_in_one_step, held_out_on, over_sections};
use crate::criticism::screen::Screen;
use palpate_fit::problem::Problem;

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

impl Search<'_> {
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
    pub(super) fn voted(&self, screen: &Screen) -> Vec<f64> {
        let library = agreement::chances(screen, self.candidates);
        let own = agreement::protected_chances(screen, self.candidates);
        let voted = |(library, own)| if own <= OWN_AGREEMENT { own } else { library };
        library.into_iter().zip(own).map(voted).collect()
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

    pub(super) fn evidence(&self, fitted: &Fitted) -> Evidence {
        Evidence::of(self.problem, fitted)
    }

    /// Takes back the last step where it does not lower the errors over all rows as it does those over their means; of those on traces
    /// left out only where means that stand for the rows tell them.
    pub(super) fn holds_on_rows(&self, found: &mut Found) -> bool {
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
    pub(super) fn take_errors_of(
        &self,
        rows: &Problem,
        fitted: &mut Fitted,
        evidence: &mut Evidence,
    ) {
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
}

/// Whether the mean square error is hardly less than without the last effect.
fn hardly_lowers(without: &Fitted, with: &Fitted) -> bool {
    with.rms().powi(2) > (1.0 - MINOR) * without.rms().powi(2)
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
