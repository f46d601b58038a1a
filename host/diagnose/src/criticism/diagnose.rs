//! What a model lacks: the whole procedure from the noise to the verdict.

use super::adequacy::{Adequacy, LEVEL, adequacy};
use super::compare::{Cell, cells_of};
use super::evidence::{Evidence, Refused};
use super::experiment::next_experiment;
use super::fitted::Fitted;
use super::held_out::HeldOut;
use super::noise::{NoiseModel, Seen, noise_model, residual_noise, samples_at_rest};
use super::options::Options;
use super::search::{Found, Search, Step};
use super::separation::Rivals;
use palpate_fit::data::{Data, DataError};
use palpate_fit::least_squares::Effort;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::{Candidate, EffectError, candidates, chain_of};
use palpate_model::{BaseLaw, Chain, Model, Separation};
use palpate_trace::{Noise, Trace, block_means, pooled_noise};

/// What a model lacks on a data set.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// In one word.
    pub verdict: Verdict,
    /// Names of the traces.
    pub labels: Vec<String>,
    /// The column.
    pub signal: String,
    /// What is known of the noise.
    pub noise: NoiseModel,
    /// What happens when contact breaks, as the model has it.
    pub separation: Separation,
    /// What the search found.
    pub found: Found,
    /// Root mean square error of the model as it was given, before it was refitted to whitened residuals.
    pub given_rms: f64,
    /// Standard errors of the parameters of the last model.
    pub standard_errors: Vec<Option<f64>>,
    /// Error on traces left out, before any step and after each; none for a single trace.
    pub held_out: Vec<Option<HeldOut>>,
    /// Whether each step's gain on traces left out is beyond chance.
    pub sure: Vec<bool>,
    /// The residual of the model without effects beside noise.
    pub before: Adequacy,
    /// The residual of the last model beside noise.
    pub after: Adequacy,
    /// Part of the misfit of the model without effects that the last one leaves.
    pub unexplained: f64,
    /// Root mean square of what the last model leaves beyond the noise, in the unit of the signal: how
    /// inexact the law is. 0 where what it leaves is noise.
    pub discrepancy: f64,
    /// Where what the last model leaves sits.
    pub places: Vec<Cell>,
    /// Effects that these data cannot show, with the reason.
    pub untestable: Vec<(String, String)>,
    /// What could be tried.
    pub candidates: Vec<Candidate>,
    /// The experiment that would decide, or show more.
    pub next_experiment: Option<String>,
    /// What was done that a reader should know.
    pub notes: Vec<String>,
    /// What was asked for.
    pub options: Options,
}

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

/// Why a diagnosis cannot be made.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum DiagnoseError {
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("{0}")]
    Options(String),
}

/// Part of the misfit that may remain after effects are named: a law's form differs from the
/// specimen's by as much.
const FORM: f64 = 0.2;

/// Times the scatter of neighbours up to which a residual can be noise that correlates.
const FAR: f64 = 5.0;
/// An error on traces left out within this many times the noise is at the noise.
const AT_THE_NOISE: f64 = 1.1;

/// Says what a model lacks on the traces of a data set, in order of recording, by the effects of the library.
///
/// # Errors
/// When the model or the traces are not usable.
pub fn diagnose(model: &Model, traces: &[Trace]) -> Result<Diagnosis, DiagnoseError> {
    diagnose_with(model, traces, &Options::default())
}

/// The same with what is asked for.
///
/// # Errors
/// When the model, the traces or the options are not usable.
pub fn diagnose_with(
    model: &Model,
    traces: &[Trace],
    options: &Options,
) -> Result<Diagnosis, DiagnoseError> {
    options.check()?;
    let signal = &model.base.signal;
    // Long recordings are searched on their means; the errors are those of all rows in the end.
    let means = block_means(traces);
    let searched = means.as_deref().unwrap_or(traces);
    let data =
        Data::of_model(model, searched)?.with_effects(&options.effects).with_laws(&options.laws);
    let setting = data.setting();
    let (chain, values) = chain_of(model, &setting)?;
    let candidates = candidates(&setting, &model.candidates)?;
    let white = Whitening::none();
    let plain = Problem::new(&chain, &data, &white, None);
    let start = plain.point(&values);
    let all =
        Data::of_model(model, traces)?.with_effects(&options.effects).with_laws(&options.laws);
    let rows = Problem::new(&chain, &all, &white, None);
    let given: f64 =
        rows.trace_squares(&rows.point(&values)).iter().map(|(squares, _)| squares).sum();
    let given_rms = (given / all.samples() as f64).sqrt();
    let noise = noise_model(&data).unwrap_or_else(|| {
        noise_of_residual(&plain, &start, pooled_noise(traces, signal), means.is_some())
    });
    let problem = Problem::new(&chain, &data, &noise.whitening, None);
    let search = Search {
        data: &data,
        candidates: &candidates,
        whitening: &noise.whitening,
        problem: &problem,
        options,
    };
    let mut notes = Vec::new();
    let (separation, before, mut found) = likeliest(&search, &start, &mut notes);
    let mut assessed = Assessed::of(&search, &found, &before, &noise);
    // What fits best need not predict best where no law describes the data to the noise.
    let single = data.labels.len() == 1;
    let exact = assessed.verdict != Verdict::Unknown && !(single && assessed.discrepancy > 0.0);
    let denied = search.examine(&mut found, exact);
    let inexact = denied.is_some() || (!exact && !found.steps.is_empty());
    if inexact {
        found = borne_out(&search, &found, denied);
        assessed = Assessed::of(&search, &found, &before, &noise);
    }
    if noise.seen == Seen::Residual && data.labels.len() == 1 && beside_others(&mut found) {
        let rest = match samples_at_rest(&data) {
            0 => "without a stretch at rest off the specimen".to_owned(),
            samples => {
                format!("with {samples} samples at rest off the specimen, too few or too still,")
            }
        };
        notes.push(format!(
            "one trace {rest} does not show its noise, and so does not single out an effect: the next best stands beside it"
        ));
        assessed = Assessed::of(&search, &found, &before, &noise);
    }
    if means.is_some() {
        let steps = found.steps.len();
        found.score(&problem, &rows);
        if found.steps.len() < steps {
            // What describes the means to the noise need not describe the rows.
            if !inexact {
                let denied = std::mem::take(&mut found.refused);
                found = borne_out(&search, &found, denied);
                found.score(&problem, &rows);
            }
            assessed = Assessed::of(&search, &found, &before, &noise);
        }
        notes.push(format!(
            "searched on {} means of the {} rows, each over at most a twentieth of the time since the motion before it; the errors are those of all rows",
            data.samples(),
            all.samples()
        ));
    }
    let Assessed { verdict, unexplained, discrepancy, after } = assessed;
    let discrepancy = if discrepancy > 0.0 { beyond_noise(found.model(), &noise) } else { 0.0 };
    let final_problem = problem.with_chain(&found.model().chain);
    let standard_errors = found.model().standard_errors(&final_problem, found.inexact);
    let final_rows = rows.with_chain(&found.model().chain);
    let places = cells_of(&final_rows, &all, &final_rows.point(&found.model().values), noise.level);
    let untestable = untestable(&candidates, &found);
    let next_experiment = match verdict {
        Verdict::Adequate | Verdict::Named => None,
        Verdict::Ambiguous => deciding(&found, &data, searched, &noise.whitening),
        Verdict::Unknown => repeating(&places, &data.labels),
    };
    Ok(Diagnosis {
        next_experiment,
        verdict,
        labels: data.labels.clone(),
        signal: signal.clone(),
        separation,
        standard_errors,
        held_out: found.evidence.iter().map(|evidence| evidence.held_out.clone()).collect(),
        sure: found.evidence.windows(2).map(|pair| is_sure(&pair[0], &pair[1])).collect(),
        before,
        after,
        unexplained,
        discrepancy,
        places,
        untestable,
        notes,
        noise,
        found,
        given_rms,
        candidates,
        options: options.clone(),
    })
}

/// The noise for want of rest, from what the base leaves.
fn noise_of_residual(
    plain: &Problem,
    start: &[f64],
    seen: Option<Noise>,
    means: bool,
) -> NoiseModel {
    let fitted = Fitted::new(plain, start, Effort::QUICK);
    residual_noise(&plain.residuals(&fitted.point), seen, means)
}

/// The likeliest model under the noise, with the rule of separation that it takes; what the base
/// leaves beside the noise, and what was done in `notes`.
fn likeliest(
    search: &Search,
    start: &[f64],
    notes: &mut Vec<String>,
) -> (Separation, Adequacy, Found) {
    let chain = search.problem.chain;
    let attempt = |separation: Separation| {
        let base = BaseLaw { separation, ..chain.base };
        let chain = Chain { base, ..chain.clone() };
        let problem = search.problem.with_chain(&chain);
        let base = Fitted::new(&problem, start, Effort::QUICK);
        (adequacy(&problem, &base.point, search.whitening), base)
    };
    let separation = chain.base.separation;
    let (before, base) = attempt(separation);
    let found = search.run(base);
    if found.steps.is_empty() || separation == Separation::Bonded {
        return (separation, before, found);
    }
    // Where contact breaks in another way than the model says, effects would be named in its stead.
    let other = match separation {
        Separation::Clamp => Separation::Free,
        _ => Separation::Clamp,
    };
    let (_, base) = attempt(other);
    if base.bic() >= found.model().bic() {
        return (separation, before, found);
    }
    notes.push(format!(
        "with separation = \"{}\" the model explains these traces better than with any effect added; that was used",
        other.name()
    ));
    (other, before, search.run(base))
}

/// What the last model of a search leaves, and the verdict on it.
struct Assessed {
    verdict: Verdict,
    unexplained: f64,
    discrepancy: f64,
    after: Adequacy,
}

impl Assessed {
    fn of(search: &Search, found: &Found, before: &Adequacy, noise: &NoiseModel) -> Self {
        let problem = search.problem.with_chain(&found.model().chain);
        let after = adequacy(&problem, &found.model().point, search.whitening);
        let explained = (found.base.cost - found.model().cost).max(0.0);
        let leftover = after.excess.max(0.0);
        let named = !found.steps.is_empty();
        let share = if named { leftover / (explained + leftover).max(1.0) } else { 0.0 };
        let ahead = beyond(&found.evidence, noise.level);
        let unexplained = if after.p_value < LEVEL { share.max(ahead) } else { ahead };
        // Without rest to see noise in, a residual far beyond that of neighbours is not noise.
        let far = |fitted: &Fitted| fitted.rms().powi(2) - (FAR * noise.level).powi(2);
        let (first, last) = (far(&found.base), far(found.model()));
        let guessed = noise.seen == Seen::Residual && last > 0.0;
        let unexplained =
            if guessed { unexplained.max((last / first).min(1.0)) } else { unexplained };
        let verdict = match verdict(found, before, unexplained, search.options) {
            Verdict::Adequate if guessed => Verdict::Unknown,
            verdict => verdict,
        };
        let inexact = after.p_value < LEVEL || guessed;
        let discrepancy = if inexact { beyond_noise(found.model(), noise) } else { 0.0 };
        Self { verdict, unexplained, discrepancy, after }
    }
}

/// Root mean square of what a model leaves beyond the noise, in the unit of the signal.
fn beyond_noise(fitted: &Fitted, noise: &NoiseModel) -> f64 {
    (fitted.rms().powi(2) - noise.level.powi(2)).max(0.0).sqrt()
}

/// Whether the mean square error on traces left out falls by more than two standard errors over them.
fn is_sure(before: &Evidence, after: &Evidence) -> bool {
    let (Some(before), Some(after)) = (&before.held_out, &after.held_out) else { return false };
    after.gain(before).exceeds(2.0)
}

/// Part of the misfit on traces left out that the last model leaves there; 0 where it is at the noise.
fn beyond(evidence: &[Evidence], noise: f64) -> f64 {
    let held_out = |evidence: Option<&Evidence>| evidence?.held_out.clone();
    let (Some(first), Some(last)) = (held_out(evidence.first()), held_out(evidence.last())) else {
        return 0.0;
    };
    let excess = |held_out: &HeldOut| held_out.rms.powi(2) - noise * noise;
    if last.rms < AT_THE_NOISE * noise || excess(&first) <= 0.0 {
        return 0.0;
    }
    (excess(&last) / excess(&first)).min(1.0)
}

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

/// Puts the next best effect beside every one that stands alone; true if there was one.
fn beside_others(found: &mut Found) -> bool {
    let mut changed = false;
    for step in found.steps.iter_mut().filter(|step| step.credible.len() == 1) {
        let other = step.rivals.iter().find(|rival| rival.effect != step.effect);
        changed |= other.is_some();
        step.credible.extend(other.map(|rival| rival.effect.clone()));
    }
    changed
}

/// The steps that are borne out where no law describes the data to the noise, beside what was refused before.
fn borne_out(search: &Search, found: &Found, denied: impl IntoIterator<Item = Refused>) -> Found {
    let mut climbed = search.borne_out(found);
    let known = |denied: &Refused| {
        let refused = &climbed.refused;
        climbed.names(&denied.effect) || refused.iter().any(|it| it.effect == denied.effect)
    };
    let denied: Vec<Refused> = denied.into_iter().filter(|denied| !known(denied)).collect();
    climbed.refuse(denied);
    climbed
}

/// The members of the first credible set with several: their names and models, the best first.
#[must_use]
pub fn undecided(found: &Found) -> Vec<(&str, &Fitted)> {
    let Some(step) = found.steps.iter().find(|step| step.credible.len() > 1) else {
        return Vec::new();
    };
    let member = |name: &'_ String| {
        let rival = step.rivals.iter().find(|rival| rival.effect == *name);
        rival.map(|rival| (rival.effect.as_str(), &rival.fitted))
    };
    step.credible.iter().filter_map(member).collect()
}

/// The experiment that would decide between the members of the first credible set with several.
fn deciding(found: &Found, data: &Data, traces: &[Trace], whitening: &Whitening) -> Option<String> {
    let members = undecided(found);
    let (name, _) = members.first()?;
    let models: Vec<&Fitted> = members.iter().map(|(_, fitted)| *fitted).collect();
    let rivals = Rivals {
        members: &models,
        signal: &data.signal,
        reference_temperature: data.reference_temperature,
        traces,
        whitening,
    };
    let proposal = next_experiment(&rivals, data);
    // Where no simulation tells them apart, the effect's own declaration may know a way.
    let declared = || data.effects.find(name).map(|effect| effect.experiment.to_owned());
    proposal.map(|proposal| proposal.text).or_else(declared)
}

/// A repetition of the recording in which most is left: what repeats is no accident.
fn repeating(places: &[Cell], labels: &[String]) -> Option<String> {
    let most = places.iter().max_by(|a, b| a.share_of_excess.total_cmp(&b.share_of_excess))?;
    Some(format!(
        "repeat {} twice: what comes back in the {} is the specimen's or the sensor's, what does not was an accident",
        labels[most.trace],
        most.region.name()
    ))
}

/// Effects that the first screen could not test.
fn untestable(candidates: &[Candidate], found: &Found) -> Vec<(String, String)> {
    let reason = |(index, candidate): (usize, &Candidate)| {
        let name = || candidate.name.clone();
        if let Some(missing) = candidate.missing {
            return Some((name(), missing.to_owned()));
        }
        let mut own = found.first.directions.iter().filter(|d| d.candidate == index);
        let absorbed = own.all(|direction| direction.left < super::screen::ABSORBED);
        absorbed
            .then(|| (name(), "absorbed by the model's own parameters on these traces".to_owned()))
    };
    candidates.iter().enumerate().filter_map(reason).collect()
}
