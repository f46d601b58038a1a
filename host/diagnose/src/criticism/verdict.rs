//! The verdict on what was found: adequate, named, ambiguous or unknown.

use super::adequacy::{Adequacy, LEVEL};
use super::evidence::Evidence;
use super::fitted::Fitted;
use super::held_out::HeldOut;
use super::jumps::jumps;
use super::noise::NoiseModel;
use super::options::Options;
use super::outside::Outside;
use super::search::{Found, Search, Step};
use palpate_fit::data::Data;

/// The answer in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is missing.
    Adequate,
    /// Single effects, and what remains is noise.
    Named,
    /// The data cannot separate the members of a step's credible set.
    Ambiguous,
    /// Something is missing that no effect of the library explains.
    Unknown,
}

impl Verdict {
    /// The word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::Named => "named",
            Self::Ambiguous => "ambiguous",
            Self::Unknown => "unknown",
        }
    }
}

/// Part of the misfit that may remain after effects are named: a law's form differs from the
/// specimen's by as much.
const FORM: f64 = 0.2;

/// Part of the misfit beyond which what is left of it is missing, however fast it changes.
const HALF: f64 = 0.5;

/// Times the scatter of neighbours up to which a residual can be noise that correlates.
pub(super) const FAR_BEYOND_NEIGHBOURS: f64 = 5.0;
/// An error within this many times the noise is at the noise.
pub(super) const AT_THE_NOISE: f64 = 1.1;

/// What the last model of a search leaves, and the verdict on it.
pub(super) struct Assessed {
    pub(super) verdict: Verdict,
    /// Part of the misfit of the model without effects that the last one leaves.
    pub(super) unexplained: f64,
    /// Whether what it leaves is more than noise.
    pub(super) inexact: bool,
    /// The residual of the last model beside noise.
    pub(super) after: Adequacy,
}

impl Assessed {
    /// Weighs what was found; `before` is what the model without effects leaves, and `outside` what
    /// describes that and is no effect.
    pub(super) fn of(
        search: &Search,
        found: &Found,
        before: &Adequacy,
        noise: &NoiseModel,
        outside: Option<&Outside>,
    ) -> Self {
        let after = search.left_by(found.model());
        let explained = (found.base.cost - found.model().cost).max(0.0);
        let leftover = after.excess.max(0.0);
        let named = !found.steps.is_empty();
        let share = if named { leftover / (explained + leftover).max(1.0) } else { 0.0 };
        let level = noise.level * after.louder;
        let ahead = beyond_held_out(&found.evidence, level);
        // What changes faster than the blocks in which neighbours are summed adds to the error alone; of corners another form of a law
        // leaves as well.
        let left = left_of((before.rms, 0.0), (after.rms, 0.0), level);
        let share = if named && noise.is_known() && left > HALF { left.max(share) } else { share };
        let unexplained = if after.p_value < LEVEL { share.max(ahead) } else { ahead };
        // Without rest to see noise in, a residual far beyond that of neighbours is not noise.
        let far = |fitted: &Fitted| fitted.rms().powi(2) - (FAR_BEYOND_NEIGHBOURS * level).powi(2);
        let (first, last) = (far(&found.base), far(found.model()));
        let guessed = !noise.is_known() && last > 0.0;
        let unexplained =
            if guessed { unexplained.max((last / first).min(1.0)) } else { unexplained };
        let verdict = match verdict(found, before, unexplained, search.options) {
            Verdict::Adequate if guessed || outside.is_some() => Verdict::Unknown,
            Verdict::Adequate if jumps_show(search.rows(), noise) => Verdict::Unknown,
            verdict => verdict,
        };
        tracing::debug!(
            "{} effects: explained {explained:.0}, left beyond noise {leftover:.0} (p = {:.2e}), noise {:.2} times as loud in contact, unexplained {unexplained:.3}, ahead {ahead:.3}",
            found.steps.len(),
            after.p_value,
            after.louder_loaded,
        );
        let inexact = after.p_value < LEVEL || guessed;
        Self { verdict, unexplained, inexact, after }
    }
}

/// Whether samples that jump away and back leave more than is at the noise.
fn jumps_show(data: &Data, noise: &NoiseModel) -> bool {
    noise.is_known() && jumps(data) > (AT_THE_NOISE.powi(2) - 1.0) * noise.level.powi(2)
}

/// Root mean square of what a model leaves beyond the noise, in the unit of the signal.
pub(super) fn beyond_noise(fitted: &Fitted, noise: f64) -> f64 {
    (fitted.rms().powi(2) - noise * noise).max(0.0).sqrt()
}

/// Part of the mean square of an error beyond the noise that a later one leaves; 0 where that is at the noise. With each error the part
/// of its mean square that is no misfit.
fn left_of(before: (f64, f64), after: (f64, f64), noise: f64) -> f64 {
    let excess = |(rms, no_misfit): (f64, f64)| rms * rms - noise * noise - no_misfit;
    let at_the_noise = after.0 < AT_THE_NOISE * noise || excess(before) <= 0.0;
    if at_the_noise { 0.0 } else { (excess(after) / excess(before)).clamp(0.0, 1.0) }
}

/// Part of the misfit on traces left out that the last model leaves there beyond what the uncertainty of its parameters
/// explains; 0 where it is at the noise.
pub(super) fn beyond_held_out(evidence: &[Evidence], noise: f64) -> f64 {
    let held_out = |evidence: Option<&Evidence>| evidence?.held_out.clone();
    let (Some(first), Some(last)) = (held_out(evidence.first()), held_out(evidence.last())) else {
        return 0.0;
    };
    let error = |held_out: &HeldOut| (held_out.rms, held_out.by_uncertainty);
    left_of(error(&first), error(&last), noise)
}

/// The word for what was found.
fn verdict(found: &Found, before: &Adequacy, unexplained: f64, options: &Options) -> Verdict {
    if found.steps.is_empty() {
        let missed = found.first.chance.iter().any(|&chance| chance <= 0.5 * options.false_alarms);
        let level = if missed { LEVEL } else { 0.1 * LEVEL };
        return if before.p_value < level { Verdict::Unknown } else { Verdict::Adequate };
    }
    if unexplained > FORM {
        return Verdict::Unknown;
    }
    let single = |step: &Step| step.credible.len() == 1;
    if found.steps.iter().all(single) { Verdict::Named } else { Verdict::Ambiguous }
}
