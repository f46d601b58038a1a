//! `palpate diagnose` and `palpate explore`: what a model lacks, with the evidence.

use std::collections::BTreeMap;

use palpate_diagnose::criticism::adequacy::Adequacy;
use palpate_diagnose::criticism::compare::Cell;
use palpate_diagnose::criticism::diagnose::Verdict;
use palpate_diagnose::criticism::evidence::Refused;
use palpate_diagnose::criticism::incident::Change;
use palpate_diagnose::criticism::noise::NoiseModel;
use palpate_diagnose::criticism::outside::Outside;
use palpate_diagnose::criticism::search::Rival;
use palpate_diagnose::criticism::swing::Swing;
use palpate_diagnose::criticism::vibration::Vibration;
use palpate_diagnose::criticism::{agreement, dependence, screen};
use serde::Serialize;

use super::{DependenceAnswer, Estimate, NextMotionAnswer, finite};
use crate::summary::DiagnosisSummary;

/// What a model lacks.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DiagnosisAnswer {
    /// Version of this answer.
    pub palpate_diagnosis: u32,
    /// The answer in one word.
    pub verdict: VerdictAnswer,
    /// The column that was diagnosed.
    pub signal: String,
    /// Unit of the signal, and of every error.
    pub unit: String,
    /// Standard deviation of the noise.
    pub noise_rms: f64,
    /// Root mean square error of the model as it was given.
    pub given_rms: f64,
    /// Root mean square error of the model refitted to whitened residuals, without the effects found.
    pub base_rms: f64,
    /// Root mean square error with all effects found.
    pub final_rms: f64,
    /// Root mean square of what the last model leaves beyond the noise; 0 where it leaves noise.
    pub discrepancy_rms: f64,
    /// What the p values of the effects rest on.
    pub p_values: PValueBasis,
    /// What the standard errors rest on.
    pub standard_errors: ErrorBasis,
    /// The effects found, in the order in which they were added.
    pub steps: Vec<StepAnswer>,
    /// Effects that were tried and refused.
    pub refused: Vec<RefusedAnswer>,
    /// Where what the last model leaves lies.
    #[serde(rename = "where")]
    pub places: Vec<LeftoverPlace>,
    /// What the residual of the last model depends on, strongest first.
    pub depends_on: Vec<DependenceAnswer>,
    /// A change at one instant, which no effect is; absent where none was found or effects are named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub incident: Option<IncidentAnswer>,
    /// A slow sine through all traces, which no effect is; absent where none was found or effects are named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swing: Option<SwingAnswer>,
    /// A faster sine that is there at rest as well, which no effect is; absent where none was found or effects are named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vibration: Option<SwingAnswer>,
    /// What the specimen remembers of before the recording, which no effect is; absent where no trace begins in motion, that describes
    /// little, or effects are named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub past: Option<PastAnswer>,
    /// Effects that these traces cannot show.
    pub untestable: Vec<UntestableAnswer>,
    /// The experiment that would decide, or show more; null where there is nothing to decide.
    pub next_experiment: Option<String>,
    /// The findings in sentences.
    pub in_words: String,
    /// Every effect that could be tried, the largest predicted gain first.
    pub candidates: Vec<CandidateAnswer>,
    /// What is known of the noise.
    pub noise: NoiseAnswer,
    /// Whether what is left is noise.
    pub adequacy: AdequacyPair,
    /// What was done that a reader should know.
    pub notes: Vec<String>,
    /// Traces or parts that could not be used, with the reason.
    pub left_out: Vec<String>,
    /// Seeds of everything random.
    pub seeds: Seeds,
    /// The motion that tells the remaining effects apart; absent where none was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_motion: Option<NextMotionAnswer>,
    /// The same as `noise_rms`, N; absent where the unit is another.
    #[serde(rename = "noise_rms_N", skip_serializing_if = "Option::is_none")]
    pub noise_rms_n: Option<f64>,
    /// The same as `base_rms`, N; absent where the unit is another.
    #[serde(rename = "base_rms_N", skip_serializing_if = "Option::is_none")]
    pub base_rms_n: Option<f64>,
    /// The same as `final_rms`, N; absent where the unit is another.
    #[serde(rename = "final_rms_N", skip_serializing_if = "Option::is_none")]
    pub final_rms_n: Option<f64>,
}

/// What a model lacks, and where the model with it was written.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ExplorationAnswer {
    /// What the first model lacks.
    #[serde(flatten)]
    pub diagnosis: DiagnosisAnswer,
    /// The file of the model with all effects found; null where none was written.
    pub model: Option<String>,
}

/// The answer in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum VerdictAnswer {
    /// Nothing is missing.
    Adequate,
    /// Single effects are missing, and what remains is noise.
    Named,
    /// Effects are missing that the traces cannot distinguish.
    Ambiguous,
    /// Something is missing that no effect of the library explains.
    Unknown,
}

/// What p values rest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub enum PValueBasis {
    /// What the noise alone would show.
    #[serde(rename = "noise")]
    Noise,
    /// How well the parts of the data agree: what the last model leaves is not noise alone.
    #[serde(rename = "agreement between parts of the data")]
    Agreement,
}

/// What standard errors rest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub enum ErrorBasis {
    /// The noise.
    #[serde(rename = "noise")]
    Noise,
    /// The jackknife: what the last model leaves is not noise alone.
    #[serde(rename = "jackknife over parts of the data")]
    Jackknife,
}

/// One effect found, and what speaks for it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct StepAnswer {
    /// Name of the effect.
    pub effect: String,
    /// Name of its law.
    pub law: String,
    /// Effects that the traces cannot distinguish in this place, the effect first.
    pub credible_set: Vec<String>,
    /// Its parameters by name, in the last model.
    pub parameters: BTreeMap<String, Estimate>,
    /// Root mean square error before it was added.
    pub rms_before: f64,
    /// Root mean square error after.
    pub rms_after: f64,
    /// Held-out error before; null for a single trace.
    pub heldout_rms_before: Option<f64>,
    /// Held-out error after; null for a single trace.
    pub heldout_rms_after: Option<f64>,
    /// Whether the fall of the held-out error exceeds two standard errors over the traces.
    pub heldout_gain_sure: bool,
    /// Fall of the Bayesian information criterion on whitened residuals.
    pub delta_bic: f64,
    /// p value of the effect over the whole library.
    pub p_value: f64,
    /// Every effect that was refitted in this place, best first.
    pub rivals: Vec<RivalAnswer>,
    /// The same as `rms_before`, N; absent where the unit is another.
    #[serde(rename = "rms_before_N", skip_serializing_if = "Option::is_none")]
    pub rms_before_n: Option<f64>,
    /// The same as `rms_after`, N; absent where the unit is another.
    #[serde(rename = "rms_after_N", skip_serializing_if = "Option::is_none")]
    pub rms_after_n: Option<f64>,
    /// The same as `heldout_rms_before`, N; absent where the unit is another.
    #[serde(rename = "heldout_rms_before_N", skip_serializing_if = "Option::is_none")]
    pub heldout_rms_before_n: Option<Option<f64>>,
    /// The same as `heldout_rms_after`, N; absent where the unit is another.
    #[serde(rename = "heldout_rms_after_N", skip_serializing_if = "Option::is_none")]
    pub heldout_rms_after_n: Option<Option<f64>>,
}

/// An effect refitted in the place of one found.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RivalAnswer {
    /// Name of the effect.
    pub effect: String,
    /// Name of its law; null where the refitted model does not have it.
    pub law: Option<String>,
    /// Its Bayesian information criterion over that of the best in this place.
    pub delta_bic_to_best: f64,
    /// Share of the resamplings of the data in which it is the best, 0 to 1.
    pub won: f64,
    /// Root mean square error with it.
    pub rms: f64,
    /// The same as `rms`, N; absent where the unit is another.
    #[serde(rename = "rms_N", skip_serializing_if = "Option::is_none")]
    pub rms_n: Option<f64>,
}

/// An effect that was tried and refused.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RefusedAnswer {
    /// Name of the effect.
    pub effect: String,
    /// Name of its law.
    pub law: String,
    /// Why it was refused.
    pub reason: String,
    /// Root mean square error without it.
    pub rms_before: f64,
    /// Root mean square error with it.
    pub rms_after: f64,
    /// Held-out error without it; null for a single trace.
    pub heldout_rms_before: Option<f64>,
    /// Held-out error with it; null for a single trace.
    pub heldout_rms_after: Option<f64>,
}

/// What the last model leaves in one region of one trace.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct LeftoverPlace {
    /// Name of the trace.
    pub trace: String,
    /// Name of the region, such as `loading`.
    pub phase: String,
    /// Share of all squared error beyond the noise that lies here, 0 to 1.
    pub share_of_excess: f64,
    /// Root mean square error.
    pub rms: f64,
    /// The same as `rms`, N; absent where the unit is another.
    #[serde(rename = "rms_N", skip_serializing_if = "Option::is_none")]
    pub rms_n: Option<f64>,
}

/// Something that happened once: from an instant on, the zero or the gain of the signal is another.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct IncidentAnswer {
    /// Name of the trace.
    pub trace: String,
    /// The instant, in the time of that trace, s.
    pub time_s: f64,
    /// What is another after it.
    pub change: IncidentChange,
    /// How long: to the end of the trace or of the set.
    pub until: IncidentUntil,
    /// The change: of the zero in `unit` of the diagnosis, of the gain as a part of it.
    pub size: f64,
    /// Part of what the first model leaves beyond the noise that it describes, 0 to 1.
    pub share: f64,
    /// p value of as much at any instant under noise alone.
    pub p_value: f64,
}

/// What is another after an incident.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum IncidentChange {
    /// The zero of the signal.
    Zero,
    /// The gain of the signal, or the stiffness of the specimen.
    Gain,
}

/// How long an incident lasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum IncidentUntil {
    /// To the end of its trace.
    Trace,
    /// To the end of the set.
    Set,
}

/// A sine of one frequency: a swing through all traces and the pauses between them, or a vibration with a phase of its own in each trace.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SwingAnswer {
    /// Its frequency.
    #[serde(rename = "frequency_Hz")]
    pub frequency_hz: f64,
    /// Its amplitude, in `unit` of the diagnosis.
    pub amplitude: f64,
    /// Part of what the first model leaves beyond the noise that it describes, 0 to 1.
    pub share: f64,
    /// p value of as much at any frequency, in what else is left around it.
    pub p_value: f64,
}

/// What the specimen remembers of before the recording, where traces begin pressed and in motion.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PastAnswer {
    /// The traces that begin so.
    pub traces: Vec<String>,
    /// Time constants, s, of the force that decays in them.
    pub time_constants_s: Vec<f64>,
    /// Part of what the first model leaves beyond the noise that it describes, 0 to 1.
    pub share: f64,
    /// p value of as much under noise alone.
    pub p_value: f64,
}

/// What is no effect and describes the misfit, at most one of these.
#[derive(Default)]
struct OutsideAnswer {
    incident: Option<IncidentAnswer>,
    swing: Option<SwingAnswer>,
    vibration: Option<SwingAnswer>,
    past: Option<PastAnswer>,
}

fn outside(summary: &DiagnosisSummary) -> OutsideAnswer {
    let diagnosis = summary.diagnosis;
    let Some(outside) = &diagnosis.outside else { return OutsideAnswer::default() };
    let (share, p_value) = (outside.share(&diagnosis.found.base), outside.log_chance().exp());
    match outside {
        Outside::Incident(incident) => {
            let incident = IncidentAnswer {
                trace: diagnosis.labels[incident.trace].clone(),
                time_s: incident.time_s,
                change: match incident.change {
                    Change::Zero => IncidentChange::Zero,
                    Change::Gain => IncidentChange::Gain,
                },
                until: if incident.lasts { IncidentUntil::Set } else { IncidentUntil::Trace },
                size: incident.size,
                share,
                p_value,
            };
            OutsideAnswer { incident: Some(incident), ..OutsideAnswer::default() }
        }
        Outside::Swing(swing) => {
            let Swing { frequency_hz, amplitude, .. } = *swing;
            let swing = SwingAnswer { frequency_hz, amplitude, share, p_value };
            OutsideAnswer { swing: Some(swing), ..OutsideAnswer::default() }
        }
        Outside::Vibration(vibration) => {
            let Vibration { frequency_hz, amplitude, .. } = *vibration;
            let vibration = SwingAnswer { frequency_hz, amplitude, share, p_value };
            OutsideAnswer { vibration: Some(vibration), ..OutsideAnswer::default() }
        }
        Outside::Past(past) => {
            let label = |trace: &usize| diagnosis.labels[*trace].clone();
            let past = PastAnswer {
                traces: past.traces.iter().map(label).collect(),
                time_constants_s: past.rates.iter().map(|rate| 1.0 / rate).collect(),
                share,
                p_value,
            };
            OutsideAnswer { past: Some(past), ..OutsideAnswer::default() }
        }
    }
}

/// An effect that the traces cannot show.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct UntestableAnswer {
    /// Name of the effect.
    pub effect: String,
    /// What the traces lack.
    pub reason: String,
}

/// An effect by the score test of the first model.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CandidateAnswer {
    /// Name of the effect.
    pub effect: String,
    /// Fall of the whitened sum of squares that the score test predicts, before any refit.
    pub gain_foretold: f64,
    /// p value of such a score under noise alone, over the whole library.
    pub chance: f64,
}

/// What is known of the noise.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct NoiseAnswer {
    /// Standard deviation of one sample, in the unit of the signal.
    pub standard_deviation: f64,
    /// Coefficients of the autoregression that makes it white; empty for white noise.
    pub autoregression: Vec<f64>,
    /// Whether it has a flicker (1/f) part.
    pub flicker: bool,
    /// Whether it was seen at rest off the specimen, and not in the residual of the model.
    pub seen_off_the_specimen: bool,
    /// Number of samples it was estimated from.
    pub samples: usize,
}

/// Whether what is left is noise, before and after the effects found.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AdequacyPair {
    /// The residual without the effects found.
    pub before: AdequacyAnswer,
    /// The residual of the last model.
    pub after: AdequacyAnswer,
    /// Share of the misfit of the first model that the last one leaves, 0 to 1.
    pub unexplained: f64,
}

/// A whitened residual beside noise.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AdequacyAnswer {
    /// p value of its block sums under noise alone.
    pub p_value: f64,
    /// Ljung–Box statistic over its 20 distances; 1 for noise.
    pub ljung_box: f64,
    /// Durbin–Watson statistic; 2 for noise.
    pub durbin_watson: f64,
    /// Number of runs of one sign over that expected; 1 for noise.
    pub runs: f64,
    /// How many times louder the noise is where the specimen is loaded than off it, by the scatter of neighbouring samples; 1 where it is
    /// the same.
    pub louder_loaded: f64,
}

/// Seeds of everything random in a diagnosis.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct Seeds {
    /// Of the draws of noise behind the p values of the score test.
    pub null: u64,
    /// Of the resamplings of the data.
    pub resampling: u64,
    /// Of the circular shifts behind the p values of the dependences.
    pub dependence: u64,
    /// Of the agreement between parts of the data.
    pub agreement: u64,
}

impl From<&DiagnosisSummary<'_>> for DiagnosisAnswer {
    fn from(summary: &DiagnosisSummary) -> Self {
        let diagnosis = summary.diagnosis;
        let found = &diagnosis.found;
        let (base_rms, final_rms) = (found.base.rms(), found.model().rms());
        let untestable = |(effect, reason): &(String, String)| UntestableAnswer {
            effect: effect.clone(),
            reason: reason.clone(),
        };
        let (p_values, standard_errors) = if found.inexact {
            (PValueBasis::Agreement, ErrorBasis::Jackknife)
        } else {
            (PValueBasis::Noise, ErrorBasis::Noise)
        };
        let dependences = &summary.after().comparison.dependences;
        let OutsideAnswer { incident, swing, vibration, past } = outside(summary);
        Self {
            palpate_diagnosis: 1,
            verdict: diagnosis.verdict.into(),
            signal: diagnosis.signal.clone(),
            unit: summary.unit().to_owned(),
            noise_rms: summary.noise(),
            given_rms: diagnosis.given_rms,
            base_rms,
            final_rms,
            discrepancy_rms: diagnosis.discrepancy,
            p_values,
            standard_errors,
            steps: (0..found.steps.len()).map(|index| StepAnswer::of(summary, index)).collect(),
            refused: found.refused.iter().map(|it| RefusedAnswer::of(summary, it)).collect(),
            places: diagnosis.places.iter().map(|cell| LeftoverPlace::of(summary, cell)).collect(),
            depends_on: dependences.iter().map(DependenceAnswer::from).collect(),
            incident,
            swing,
            vibration,
            past,
            untestable: diagnosis.untestable.iter().map(untestable).collect(),
            next_experiment: summary.next_experiment(),
            in_words: summary.verdict_in_words().replace('`', ""),
            candidates: candidates(summary),
            noise: NoiseAnswer::from(&diagnosis.noise),
            adequacy: AdequacyPair {
                before: AdequacyAnswer::from(&diagnosis.before),
                after: AdequacyAnswer::from(&diagnosis.after),
                unexplained: diagnosis.unexplained,
            },
            notes: diagnosis.notes.clone(),
            left_out: summary.data.left_out.clone(),
            seeds: Seeds {
                null: screen::SEED,
                resampling: diagnosis.options.seed,
                dependence: dependence::SEED,
                agreement: agreement::SEED,
            },
            next_motion: None,
            noise_rms_n: in_newtons(summary, summary.noise()),
            base_rms_n: in_newtons(summary, base_rms),
            final_rms_n: in_newtons(summary, final_rms),
        }
    }
}

/// An error under its name of version 1; none where the unit is not N.
fn in_newtons<T>(summary: &DiagnosisSummary, error: T) -> Option<T> {
    (summary.unit() == "N").then_some(error)
}

fn candidates(summary: &DiagnosisSummary) -> Vec<CandidateAnswer> {
    let ranked = summary.ranked();
    let testable = ranked.iter().filter(|ranked| summary.untestable(ranked.name).is_none());
    let candidate = |ranked: &crate::summary::Ranked| CandidateAnswer {
        effect: ranked.name.to_owned(),
        gain_foretold: ranked.gain,
        chance: ranked.chance,
    };
    testable.map(candidate).collect()
}

impl StepAnswer {
    fn of(summary: &DiagnosisSummary, index: usize) -> Self {
        let diagnosis = summary.diagnosis;
        let found = &diagnosis.found;
        let step = &found.steps[index];
        let before = if index == 0 { &found.base } else { &found.models[index - 1] };
        let after = &found.models[index];
        let held_out = |index: usize| diagnosis.held_out[index].as_ref().map(|found| found.rms);
        let parameters = summary.parameters(index).into_iter();
        let best = step.rivals[0].fitted.bic();
        Self {
            effect: step.effect.clone(),
            law: summary.applied(index).law.clone(),
            credible_set: step.credible.clone(),
            parameters: parameters
                .map(|(of, value, error)| (of.name.to_string(), Estimate::of(of, value, error)))
                .collect(),
            rms_before: before.rms(),
            rms_after: after.rms(),
            heldout_rms_before: held_out(index),
            heldout_rms_after: held_out(index + 1),
            heldout_gain_sure: diagnosis.sure[index],
            delta_bic: before.bic() - after.bic(),
            p_value: step.p_value,
            rivals: step.rivals.iter().map(|it| RivalAnswer::of(summary, it, best)).collect(),
            rms_before_n: in_newtons(summary, before.rms()),
            rms_after_n: in_newtons(summary, after.rms()),
            heldout_rms_before_n: in_newtons(summary, held_out(index)),
            heldout_rms_after_n: in_newtons(summary, held_out(index + 1)),
        }
    }
}

impl RivalAnswer {
    fn of(summary: &DiagnosisSummary, rival: &Rival, best: f64) -> Self {
        let rms = rival.fitted.rms();
        Self {
            effect: rival.effect.clone(),
            law: rival.law().map(str::to_owned),
            delta_bic_to_best: rival.fitted.bic() - best,
            won: rival.won,
            rms,
            rms_n: in_newtons(summary, rms),
        }
    }
}

impl RefusedAnswer {
    fn of(summary: &DiagnosisSummary, refused: &Refused) -> Self {
        Self {
            effect: refused.effect.clone(),
            law: refused.law.clone(),
            reason: summary.reason(refused),
            rms_before: refused.rms.0,
            rms_after: refused.rms.1,
            heldout_rms_before: refused.held_out.and_then(|(before, _)| finite(before)),
            heldout_rms_after: refused.held_out.and_then(|(_, after)| finite(after)),
        }
    }
}

impl LeftoverPlace {
    fn of(summary: &DiagnosisSummary, cell: &Cell) -> Self {
        Self {
            trace: summary.diagnosis.labels[cell.trace].clone(),
            phase: cell.region.name().to_owned(),
            share_of_excess: cell.share_of_excess,
            rms: cell.rms,
            rms_n: in_newtons(summary, cell.rms),
        }
    }
}

impl From<Verdict> for VerdictAnswer {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Adequate => Self::Adequate,
            Verdict::Named => Self::Named,
            Verdict::Ambiguous => Self::Ambiguous,
            Verdict::Unknown => Self::Unknown,
        }
    }
}

impl From<&NoiseModel> for NoiseAnswer {
    fn from(noise: &NoiseModel) -> Self {
        Self {
            standard_deviation: noise.level,
            autoregression: noise.whitening.coefficients().to_vec(),
            flicker: noise.whitening.flicker() > 0.0,
            seen_off_the_specimen: noise.is_known(),
            samples: noise.samples,
        }
    }
}

impl From<&Adequacy> for AdequacyAnswer {
    fn from(found: &Adequacy) -> Self {
        Self {
            p_value: found.p_value,
            ljung_box: found.lights.ljung_box,
            durbin_watson: found.lights.durbin_watson,
            runs: found.lights.runs,
            louder_loaded: found.louder_loaded,
        }
    }
}
