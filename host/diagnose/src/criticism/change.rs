//! One effect more in a model, or one less, and everything refitted: the ladder gains or loses a rung.

use super::fitted::Fitted;
use super::noise::{noise_model, noise_of};
use super::options::Options;
use super::screen::{ABSORBED, screen};
use super::search::{Search, is_line};
use super::slow_hum::SlowHum;
use super::touch::begun_at_touch;
use palpate_fit::data::{Data, DataError};
use palpate_fit::least_squares::Effort;
use palpate_fit::problem::Problem;
use palpate_fit::warning::{Warning, warnings};
use palpate_fit::whitening::Whitening;
use palpate_fit::whole_motion::{MotionFit, fit, held_out, over_traces, refit};
use palpate_model::effects::{Candidate, EffectError, candidates, chain_of, meant, store};
use palpate_model::{Chain, Model, Rung, StoredEffect};
use palpate_trace::{Noise, Trace, units};

/// A model before and after a change.
#[derive(Clone, Debug)]
pub struct Change {
    /// The effect that was added or taken out.
    pub effect: String,
    /// Whether it was added.
    pub added: bool,
    /// Errors before.
    pub before: Rung,
    /// Errors after.
    pub after: Rung,
    /// The model after.
    pub model: Model,
    /// Its fit.
    pub fit: MotionFit,
    /// Noise of the signal, where the recordings tell.
    pub noise: Option<Noise>,
    /// The laws of the effect that were tried, best first.
    pub laws: Vec<Tried>,
    /// What was done besides.
    pub notes: Vec<String>,
    /// Reasons to be careful.
    pub warnings: Vec<String>,
}

/// A law that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Name of the law.
    pub law: String,
    /// Bayesian information criterion over that of the best.
    pub over_best: f64,
}

/// Why a model cannot be changed so.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ChangeError {
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("`{0}` is in the model already; `palpate drop` takes it out")]
    Present(String),
    #[error(
        "no effect of the library is called `{0}`, and the model file has no [[candidate]] of that name{like}; `palpate effects` lists the library",
        like = meant(.0)
    )]
    Unknown(String),
    #[error("`{effect}` cannot be fitted to these traces: {reason}")]
    Untestable { effect: String, reason: &'static str },
    #[error("`{effect}` is not in the model; it has: {present}")]
    Absent { effect: String, present: String },
    #[error("`{effect}` makes the model worse: {worse}; the model stays as it was")]
    Worse { effect: String, worse: Worse },
}

/// A model that describes its data worse than the one before.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the error on the traces {which} rises from {} to {} {unit}", figure(.before), figure(.after))]
pub struct Worse {
    /// "fitted" or "left out".
    pub which: &'static str,
    /// Root mean square error before.
    pub before: f64,
    /// After.
    pub after: f64,
    /// Unit of the signal.
    pub unit: String,
}

/// An error in four decimals, or as a power of ten where these say nothing.
fn figure(error: &f64) -> String {
    if (1e-2..1e6).contains(error) { format!("{error:.4}") } else { format!("{error:.3e}") }
}

/// A rise of an error by less than this factor is chance on traces left out, and rounding on those
/// fitted.
const RISE: f64 = 1.01;

/// Whether a rung stands below the one before: its error on the traces fitted or on those left out is
/// more than 1 % larger, or is no number.
#[must_use]
pub fn worse(before: &Rung, after: &Rung, unit: &str) -> Option<Worse> {
    let rises = |which, before: f64, after: f64| {
        let rises = !after.is_finite() || after > RISE * before;
        rises.then(|| Worse { which, before, after, unit: unit.into() })
    };
    let left_out = || {
        let (before, after) = before.heldout_rms.zip(after.heldout_rms)?;
        rises("left out", before, after)
    };
    rises("fitted", before.fitted_rms, after.fitted_rms).or_else(left_out)
}

/// Adds an effect of the library, or a law of one's own among the candidates of the model, and refits
/// everything. Without a named law, each of the effect's laws is tried at every point of its grid.
///
/// # Errors
/// When model or traces are not usable, or the effect is unknown, in the model, or beyond these traces,
/// and [`ChangeError::Worse`] where the model with it describes them worse than without.
pub fn add(
    model: &Model,
    effect: &str,
    law: Option<&str>,
    traces: &[Trace],
) -> Result<Change, ChangeError> {
    let data = Data::of_model(model, traces)?;
    let (chain, values) = chain_of(model, &data.setting())?;
    if chain.effects.iter().any(|present| present.name == effect) {
        return Err(ChangeError::Present(effect.into()));
    }
    let candidate = candidate(model, effect, law, (&data, &chain, &values))?;
    let mut notes = Vec::new();
    let (mut ladder, values) = standing(model, &chain, values, &data, &mut notes)?;
    let trial = try_laws(&chain, &values, &data, &candidate);
    let fit = refit(&trial.chain, &trial.values, &data)?;
    let before = ladder.last().cloned().unwrap_or_else(|| rung(fit.chain.base.name(), &fit, &data));
    let after = rung(effect, &fit, &data);
    if let Some(worse) = worse(&before, &after, units::printed(&model.base.signal)) {
        return Err(ChangeError::Worse { effect: effect.into(), worse });
    }
    ladder.push(after.clone());
    let mut candidates = model.candidates.clone();
    candidates.retain(|own| own.name != effect);
    let noise = noise_of(&data, traces);
    let mut warnings = reasons_for_care(&fit, &data, noise.as_ref());
    if trial.absorbed {
        warnings.insert(0, format!("the model's own parameters absorb `{effect}` on these traces: what it could explain, they explain too, so its values mean nothing"));
    }
    if before.heldout_rms.zip(after.heldout_rms).is_some_and(|(before, after)| after >= before) {
        warnings.push(format!(
            "the error on traces left out does not fall: these traces do not ask for `{effect}`"
        ));
    }
    Ok(Change {
        effect: effect.into(),
        added: true,
        model: rebuilt(model, candidates, &fit, &data, noise.as_ref(), ladder),
        before,
        after,
        fit,
        noise,
        laws: trial.laws,
        notes,
        warnings,
    })
}

/// Takes an effect out of a model and refits what remains, rung by rung. A law of one's own becomes a
/// candidate again.
///
/// # Errors
/// When model or traces are not usable, or the effect is not in the model.
pub fn drop(model: &Model, effect: &str, traces: &[Trace]) -> Result<Change, ChangeError> {
    let data = Data::of_model(model, traces)?;
    let (chain, values) = chain_of(model, &data.setting())?;
    let Some(index) = chain.effects.iter().position(|present| present.name == effect) else {
        let names: Vec<&str> = chain.effects.iter().map(|effect| effect.name.as_str()).collect();
        let present = if names.is_empty() { "none".into() } else { names.join(", ") };
        return Err(ChangeError::Absent { effect: effect.into(), present });
    };
    let before = match (model.ladder.last(), stale(model, &chain, &values, &data)) {
        (Some(last), None) => last.clone(),
        _ => rung(effect, &refit(&chain, &values, &data)?, &data),
    };
    let mut kept = values.clone();
    kept.drain(chain.range(index));
    let (ladder, fit) = climb(&chain.without(index), &kept, &data)?;
    let after = ladder.last().cloned().unwrap_or_else(|| rung(fit.chain.base.name(), &fit, &data));
    let mut candidates = model.candidates.clone();
    let mut notes = Vec::new();
    if let Some(own) = model.effects.get(index).filter(|stored| stored.expression.is_some()) {
        candidates.push(own.clone());
        notes.push(format!("`{effect}` stays in the model file as a [[candidate]]"));
    }
    let noise = noise_of(&data, traces);
    Ok(Change {
        effect: effect.into(),
        added: false,
        model: rebuilt(model, candidates, &fit, &data, noise.as_ref(), ladder),
        before,
        after,
        warnings: reasons_for_care(&fit, &data, noise.as_ref()),
        fit,
        noise,
        laws: Vec::new(),
        notes,
    })
}

/// The candidate of this name with the laws that are wanted.
fn candidate(
    model: &Model,
    effect: &str,
    law: Option<&str>,
    (data, chain, values): (&Data, &Chain, &[f64]),
) -> Result<Candidate, ChangeError> {
    let own: Vec<StoredEffect> =
        model.candidates.iter().filter(|own| own.name == effect).cloned().collect();
    let mut setting = data.setting();
    let noise = is_line(effect).then(|| noise_model(data)).flatten();
    let slow = |noise| SlowHum::of(data, &setting.scales, (chain, values), &noise);
    if let Some(slow) = noise.and_then(slow) {
        setting.scales.mains = Some(slow.mains);
    }
    let mut found = candidates(&setting, &own)?
        .into_iter()
        .find(|candidate| candidate.name == effect)
        .ok_or_else(|| ChangeError::Unknown(effect.into()))?;
    if let Some(reason) = found.missing {
        return Err(ChangeError::Untestable { effect: effect.into(), reason });
    }
    if let Some(law) = law {
        let known: Vec<String> = found.forms.iter().map(|form| form.applied.law.clone()).collect();
        found.forms.retain(|form| form.applied.law == law);
        if found.forms.is_empty() {
            let (effect, law, known) = (effect.into(), law.into(), known.join(", "));
            return Err(EffectError::UnknownLaw { effect, law, known }.into());
        }
    }
    Ok(found)
}

/// The best law of an effect beside a model, refitted in short.
struct Trial {
    chain: Chain,
    values: Vec<f64>,
    laws: Vec<Tried>,
    absorbed: bool,
}

/// Refits the chain with each law of a candidate, from what the screen foretells at every point of its
/// grid, on residuals that are whitened where the recordings show the noise.
fn try_laws(chain: &Chain, values: &[f64], data: &Data, candidate: &Candidate) -> Trial {
    let whitening = noise_model(data).map_or_else(Whitening::none, |noise| noise.whitening);
    let problem = Problem::new(chain, data, &whitening, None);
    let candidates = std::slice::from_ref(candidate);
    let options = Options::default();
    let search = Search {
        data,
        candidates,
        whitening: &whitening,
        problem: &problem,
        samples: &problem,
        options: &options,
        rows: None,
    };
    let from = Fitted::new(&problem, &problem.point(values), Effort::QUICK);
    let directions = screen(&problem, data, &from.point, &whitening, candidates).directions;
    let absorbed = directions.iter().all(|direction| direction.left < ABSORBED);
    let mut fits = search.fits_of(&from, &directions.iter().collect::<Vec<_>>());
    fits.extend(begun_at_touch(&problem, data, &from, candidates).map(|(_, fitted)| fitted));
    fits.sort_by(|a, b| a.bic().total_cmp(&b.bic()));
    let law = |fitted: &Fitted| fitted.chain.effects.last().map(|effect| effect.law.clone());
    let least = fits.first().map_or(0.0, Fitted::bic);
    let mut laws: Vec<Tried> = Vec::new();
    for fitted in &fits {
        if let Some(law) = law(fitted)
            && laws.iter().all(|tried| tried.law != law)
        {
            laws.push(Tried { law, over_best: fitted.bic() - least });
        }
    }
    let best = search.with_base_anew(fits.first().unwrap_or(&from));
    Trial { chain: best.chain, values: best.values, laws, absorbed }
}

/// The ladder of a model with the values of its last rung; fitted anew, and said so, where it does not
/// stand on these data.
fn standing(
    model: &Model,
    chain: &Chain,
    values: Vec<f64>,
    data: &Data,
    notes: &mut Vec<String>,
) -> Result<(Vec<Rung>, Vec<f64>), DataError> {
    let Some(reason) = stale(model, chain, &values, data) else {
        return Ok((model.ladder.clone(), values));
    };
    notes.push(format!(
        "{reason}: the ladder was fitted anew on these traces, from the base law up"
    ));
    let (ladder, fit) = climb(chain, &values, data)?;
    Ok((ladder, fit.values))
}

/// Relative difference of errors that is none.
const SAME: f64 = 1e-4;

/// Why the ladder of a model does not compare with fits to these data; none where it does.
fn stale(model: &Model, chain: &Chain, values: &[f64], data: &Data) -> Option<&'static str> {
    let Some(record) = &model.fit else { return Some("the model file has no fit") };
    let effects = chain.effects.iter().map(|effect| effect.name.as_str());
    let wanted = std::iter::once(chain.base.name()).chain(effects);
    if !model.ladder.iter().map(|rung| rung.add.as_str()).eq(wanted) {
        return Some("the ladder has not one rung for the base law and each effect");
    }
    if record.traces != data.labels || record.samples != data.samples() {
        return Some("the model was fitted to other traces");
    }
    if data.labels.len() > 1 && model.ladder.iter().any(|rung| rung.heldout_rms.is_none()) {
        return Some("the ladder has no error on traces left out");
    }
    let white = Whitening::none();
    let problem = Problem::new(chain, data, &white, None);
    let rms = problem.rms(&problem.point(values));
    ((rms / record.residual_rms - 1.0).abs() > SAME)
        .then_some("the values in the model file do not leave the error that it states")
}

/// Fits the base law alone, then with one effect more at a time.
fn climb(chain: &Chain, values: &[f64], data: &Data) -> Result<(Vec<Rung>, MotionFit), DataError> {
    let mut part = Chain::new(chain.base);
    let mut best =
        better(fit(chain.base, data)?, refit(&part, &values[..chain.base.count()], data)?);
    let mut ladder = vec![rung(chain.base.name(), &best, data)];
    for (index, effect) in chain.effects.iter().enumerate() {
        part = part.with(effect.clone());
        let range = chain.range(index);
        let onward = [&best.values, &values[range.clone()]].concat();
        best = better(refit(&part, &onward, data)?, refit(&part, &values[..range.end], data)?);
        ladder.push(rung(&effect.name, &best, data));
    }
    Ok((ladder, best))
}

fn better(a: MotionFit, b: MotionFit) -> MotionFit {
    if b.cost < a.cost { b } else { a }
}

/// The errors of a fit, on the traces fitted and on each left out in turn.
fn rung(add: &str, fit: &MotionFit, data: &Data) -> Rung {
    let left_out = if data.labels.len() > 1 { held_out(fit, data) } else { Vec::new() };
    Rung { add: add.into(), fitted_rms: fit.rms(), heldout_rms: over_traces(&left_out, data) }
}

/// The model file of a fit, with what the old one says beside its numbers.
fn rebuilt(
    old: &Model,
    candidates: Vec<StoredEffect>,
    fit: &MotionFit,
    data: &Data,
    noise: Option<&Noise>,
    ladder: Vec<Rung>,
) -> Model {
    let (signal, errors) = (&old.base.signal, &fit.standard_errors);
    let mut effects = store(&fit.chain, &fit.values, errors);
    for effect in &mut effects {
        let known = old.effects.iter().chain(&old.candidates).find(|old| old.name == effect.name);
        effect.meaning = known.and_then(|known| known.meaning.clone());
    }
    let counted = data.reference_temperature.filter(|_| !effects.is_empty());
    Model {
        name: old.name.clone(),
        reference_temperature: old.reference_temperature.or(counted),
        effects,
        candidates,
        fit: Some(fit.record(data, noise.map(|noise| noise.standard_deviation))),
        ladder,
        ..Model::of(&fit.chain.base, signal, &fit.values, errors)
    }
}

/// What to beware of in a fit with effects, in words.
fn reasons_for_care(fit: &MotionFit, data: &Data, noise: Option<&Noise>) -> Vec<String> {
    let parameters = fit.parameters();
    let of_effect = |name: &str| {
        parameters[fit.chain.base.count()..].iter().any(|parameter| parameter.name == name)
    };
    let words = |warning: Warning| match warning {
        Warning::AtBound { parameter, value } if of_effect(&parameter) => {
            format!(
                "{parameter} = {value:.3e} sits on its bound: the data ask for a value beyond it, or for none of this"
            )
        }
        other => other.to_string(),
    };
    warnings(fit, data, noise).into_iter().map(words).collect()
}
