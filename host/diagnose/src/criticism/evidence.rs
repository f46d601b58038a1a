//! Whether an effect that fits better is also borne out: by the traces left out, by its own parameters,
//! and by the rest.

use super::fitted::Fitted;
use super::held_out::{Gain, HeldOut, held_out, over_sections};
use super::rest::Rest;
use palpate_fit::data::{Data, Piece};
use palpate_fit::problem::Problem;
use palpate_trace::scatter;

/// An effect that was tried and refused.
#[derive(Clone, Debug)]
pub struct Refused {
    /// Name of the effect.
    pub effect: String,
    /// Name of its law.
    pub law: String,
    /// What speaks against it.
    pub reason: Refusal,
    /// Root mean square error of the fit without and with it, in the unit of the signal.
    pub rms: (f64, f64),
    /// The same on traces left out; none for a single trace.
    pub held_out: Option<(f64, f64)>,
}

/// What speaks against an effect.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The error of the fit does not fall.
    FittedError,
    /// The error of the fit falls by no more than chance explains where neighbours in the residual
    /// agree.
    FitUncertain,
    /// The error on traces left out does not fall.
    HeldOutError,
    /// The error on sections left out of a single trace does not fall.
    SectionError,
    /// The error on traces left out falls by less than its uncertainty over the traces.
    HeldOutUncertain(Gain),
    /// The parts of the data do not agree about it: the chance that parts which know nothing of it agree
    /// as much.
    Disagreement(f64),
    /// A parameter runs to the bound beyond which the law is no longer this effect.
    AtBound {
        /// Name of the parameter.
        parameter: String,
        /// The bound, in its unit.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// It is a play no wider than the displacement scatters: what it does is to smooth that.
    WithinScatter {
        /// The play, mm.
        width: f64,
        /// Standard deviation of the scatter, mm.
        scatter: f64,
    },
    /// It is a delay no longer than a slow signal takes to be recorded anew: what repeats meanwhile lags behind.
    WithinRepeats {
        /// The delay, s.
        delay: f64,
        /// How long each value of the signal stays, s.
        stays: f64,
    },
    /// The signal off the specimen denies it: root mean square error there without and with it.
    Rest {
        /// Without it, in the unit of the signal.
        without: f64,
        /// With it.
        with: f64,
    },
}

/// What a model is judged by beside its fit.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Errors on traces left out; none for a single trace.
    pub held_out: Option<HeldOut>,
    /// Errors on sections left out of a single trace; none for several traces.
    pub sections: Option<HeldOut>,
    /// Errors off the specimen.
    pub rest: Rest,
    /// Width of the play that the last effect is, and the standard deviation of the displacement's scatter, both in mm; none where it is
    /// another.
    pub play: Option<(f64, f64)>,
    /// How long the last effect delays the signal, and how long each value of that stays, both in s; none where it is another, or nothing
    /// repeats.
    pub delay: Option<(f64, f64)>,
}

/// Name of the effect that is a play.
const PLAY: &str = "backlash";
/// Names of the effects that delay the signal.
const DELAYS: [&str; 2] = ["sensor-lag", "sync-delay"];
/// Standard deviations of the displacement's scatter within which a play is no wider than that.
const WITHIN: f64 = 6.0;

impl Evidence {
    /// Gathers the evidence for a fitted model.
    #[must_use]
    pub fn of(problem: &Problem, fitted: &Fitted) -> Self {
        let mut evidence = Self::without_refits(problem, fitted);
        evidence.leave_out(problem, fitted);
        evidence
    }

    /// What needs no refit: nothing of traces left out.
    #[must_use]
    pub fn without_refits(problem: &Problem, fitted: &Fitted) -> Self {
        let data = problem.data();
        let (play, delay) = (play(data, fitted), delay(data, fitted));
        Self { held_out: None, sections: None, rest: Rest::of(problem, fitted), play, delay }
    }

    /// Adds the errors on traces, or on sections of a single one, left out.
    pub fn leave_out(&mut self, problem: &Problem, fitted: &Fitted) {
        self.held_out = held_out(problem, fitted);
        self.sections = self.held_out.is_none().then(|| over_sections(problem, fitted));
    }

    /// By how much it predicts traces left out better than a model with this evidence; none for a single trace.
    #[must_use]
    pub fn gain(&self, before: &Self) -> Option<Gain> {
        Some(self.held_out.as_ref()?.gain(before.held_out.as_ref()?))
    }

    /// Errors on what the model was not fitted to: traces, or sections of a single one.
    #[must_use]
    pub fn left_out(&self) -> Option<&HeldOut> {
        self.held_out.as_ref().or(self.sections.as_ref())
    }
}

/// The first parameter of the last effect, where that is one of these.
fn first_of(fitted: &Fitted, names: &[&str]) -> Option<f64> {
    let last = fitted.chain.effects.len().checked_sub(1)?;
    let value = fitted.values[fitted.chain.range(last).start];
    names.contains(&&*fitted.chain.effects[last].name).then_some(value)
}

/// The delay of the last effect beside the time for which each value of the signal stays, s.
fn delay(data: &Data, fitted: &Fitted) -> Option<(f64, f64)> {
    Some((first_of(fitted, &DELAYS)?.abs(), data.signal_stays?))
}

/// The play of the last effect beside the scatter of the displacement, mm; none where it is another effect.
fn play(data: &Data, fitted: &Fitted) -> Option<(f64, f64)> {
    let width = first_of(fitted, &[PLAY])?;
    let of = |piece: &Piece| scatter(&piece.motion.time, &piece.motion.displacement).powi(2);
    let squares = || data.pieces.iter().map(|piece| piece.measured.len() as f64 * of(piece));
    Some((width, (squares().sum::<f64>() / data.samples() as f64).sqrt()))
}

/// A fitted model with the evidence for it.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// The model.
    pub fitted: &'a Fitted,
    /// Its evidence.
    pub evidence: &'a Evidence,
}

/// Weighs a model with one more effect, its last, against the one without. `exact` says that what it
/// leaves is noise: then the likelihood of the noise tells how sure the gain is, and traces left out
/// need only agree. Otherwise the gain must exceed its uncertainty over the traces.
///
/// # Errors
/// What speaks against the effect.
pub fn weigh(without: Judged, with: Judged, exact: bool) -> Result<(), Refusal> {
    weigh_fit(without, with)?;
    weigh_left_out(without, with, exact)
}

/// The same by what needs no refit.
///
/// # Errors
/// What speaks against the effect.
pub fn weigh_fit(without: Judged, with: Judged) -> Result<(), Refusal> {
    if with.fitted.rms() >= without.fitted.rms() {
        return Err(Refusal::FittedError);
    }
    if let Some((parameter, value)) = with.fitted.last_effect_at_bound() {
        let (parameter, unit) = (parameter.name.to_string(), parameter.unit.to_string());
        return Err(Refusal::AtBound { parameter, value, unit });
    }
    if let Some((width, scatter)) = with.evidence.play.filter(|(w, s)| *w < WITHIN * s) {
        return Err(Refusal::WithinScatter { width, scatter });
    }
    if let Some((delay, stays)) = with.evidence.delay.filter(|(delay, stays)| delay <= stays) {
        return Err(Refusal::WithinRepeats { delay, stays });
    }
    if with.evidence.rest.denies(&without.evidence.rest) {
        let (without, with) = (without.evidence.rest.rms(), with.evidence.rest.rms());
        return Err(Refusal::Rest { without, with });
    }
    Ok(())
}

/// The same by the errors on traces, or on sections of a single one, left out.
///
/// # Errors
/// What speaks against the effect.
pub fn weigh_left_out(without: Judged, with: Judged, exact: bool) -> Result<(), Refusal> {
    let (Some(before), Some(after)) = (&without.evidence.held_out, &with.evidence.held_out) else {
        let error = |judged: Judged| judged.evidence.left_out().map_or(0.0, |errors| errors.rms);
        let falls = exact || error(with) < error(without);
        return if falls { Ok(()) } else { Err(Refusal::SectionError) };
    };
    let gain = if exact { after.gain_in_noise(before) } else { after.gain(before) };
    if after.rms >= before.rms || gain.mean <= 0.0 {
        return Err(Refusal::HeldOutError);
    }
    if !exact && !gain.exceeds(1.0) {
        return Err(Refusal::HeldOutUncertain(gain));
    }
    Ok(())
}
