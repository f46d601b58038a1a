//! `palpate afm`: what force curves of a tip say of the specimen.

use palpate_contact::afm::curve::ForceCurve;
use palpate_contact::afm::fit::{CurveFit, Exponential, Held, Options, Retreat};
use palpate_contact::afm::hold::{Latency, Relaxed};
use palpate_contact::afm::pressure::modulus_factor;
use palpate_contact::afm::rough::{Spread, Spreads};
use palpate_fit::exponentials::Term;
use serde::Serialize;

use super::Uncertain;
use crate::summary::{FittedCurve, curve_remarks};

/// Force curves of a tip, fitted.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmAnswer {
    /// Version of this answer.
    pub palpate_afm: u32,
    /// Poisson's ratio of the specimen, as it was given.
    pub poisson_ratio: f64,
    /// The moduli are so many times those of Hertz's law: 1 for exponent k = 2 of the pressure (8.1).
    pub modulus_factor: f64,
    /// The curves, in the order given.
    pub curves: Vec<AfmCurveAnswer>,
}

/// One force curve.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum AfmCurveAnswer {
    /// A curve with its fit.
    Fitted(Box<AfmFitAnswer>),
    /// A curve that could not be analysed.
    Refused(AfmRefusedAnswer),
}

/// A force curve that could not be analysed.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmRefusedAnswer {
    /// Name of the curve.
    pub curve: String,
    /// Where spring constant, units and segments were taken from.
    pub notes: Vec<String>,
    /// Why it could not be analysed.
    pub error: String,
}

/// The fit of a force curve.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmFitAnswer {
    /// Name of the curve.
    pub curve: String,
    /// Where spring constant, units and segments were taken from.
    pub notes: Vec<String>,
    /// Remarks on the fit, a sentence each.
    pub remarks: Vec<String>,
    /// Spring constant of the cantilever, N/m; null where the displacement is that of the tip itself.
    #[serde(rename = "spring_constant_N_per_m")]
    pub spring_constant_n_per_m: Option<f64>,
    /// Young's modulus at once, E(0), Pa; null where the curve does not determine it.
    #[serde(rename = "modulus_Pa")]
    pub modulus_pa: Option<Uncertain>,
    /// Young's modulus at equilibrium, E(∞), Pa; null where nothing relaxes or the curve does not determine it.
    #[serde(rename = "equilibrium_modulus_Pa")]
    pub equilibrium_modulus_pa: Option<Uncertain>,
    /// Exponentials of the relaxation function, the fastest first; empty where no relaxation is evident.
    pub relaxation: Vec<AfmExponentialAnswer>,
    /// Whether the way back was fitted too, and not its baseline alone.
    pub way_back_fitted: bool,
    /// Drag of the medium on the cantilever, N: pushing on the way in, pulling on the way back; null without a way back.
    #[serde(rename = "drag_N")]
    pub drag_n: Option<f64>,
    /// Why the curve does not determine a modulus; null where it does.
    pub no_modulus: Option<String>,
    /// Contact point: where the straight cantilever would touch, m, on the piezo's way as recorded.
    pub contact_m: Uncertain,
    /// Force of the baseline at the contact point, N.
    #[serde(rename = "baseline_N")]
    pub baseline_n: f64,
    /// Tilt of the baseline, N per m of the piezo's way.
    #[serde(rename = "tilt_N_per_m")]
    pub tilt_n_per_m: f64,
    /// Pull of adhesion during the approach, N; null where the curve shows no jump into contact.
    #[serde(rename = "approach_pull_N")]
    pub approach_pull_n: Option<Uncertain>,
    /// Standard deviation of the force's noise out of contact, N.
    #[serde(rename = "noise_N")]
    pub noise_n: f64,
    /// Root mean square of the residual, N.
    #[serde(rename = "residual_rms_N")]
    pub residual_rms_n: f64,
    /// Number of samples fitted.
    pub samples: usize,
    /// Number of outliers of the baseline that were left out.
    pub outliers: usize,
    /// Depth where the force is largest, m.
    pub depth_m: f64,
    /// Largest force of the fit, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Slope of force over the piezo's way at the end of the way in, over the spring constant: 1 for a rigid specimen; null
    /// without a spring constant.
    pub slope_over_spring_constant: Option<f64>,
    /// Adhesion on the way back; null without a way back.
    pub retreat: Option<AfmRetreatAnswer>,
    /// The longest hold; null where there is none.
    pub hold: Option<AfmHoldAnswer>,
    /// All holds, in order.
    pub holds: Vec<AfmHoldAnswer>,
}

/// One exponential of the relaxation function.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmExponentialAnswer {
    /// Share of the modulus at once, 0 to 1.
    pub share: Uncertain,
    /// Rate, 1/s.
    pub rate_per_s: Uncertain,
}

/// Adhesion on the way back.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmRetreatAnswer {
    /// Whether the pull exceeds its noise five times.
    pub adheres: bool,
    /// Largest pull below the baseline, N.
    #[serde(rename = "pull_off_N")]
    pub pull_off_n: f64,
    /// Energy that the pull takes, J.
    #[serde(rename = "energy_J")]
    pub energy_j: f64,
    /// Work of adhesion by Derjaguin, Muller and Toporov, J/m²; null where nothing adheres or the tip is not round.
    #[serde(rename = "work_DMT_J_per_m2")]
    pub work_dmt: Option<f64>,
    /// Work of adhesion by Johnson, Kendall and Roberts, J/m²; null where nothing adheres or the tip is not round.
    #[serde(rename = "work_JKR_J_per_m2")]
    pub work_jkr: Option<f64>,
    /// Tabor's number with 0.3 nm between the atoms: below 0.1 the first work holds, above 5 the second; null where it is not
    /// known.
    pub tabor: Option<f64>,
}

/// A pause of the piezo.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum AfmHoldAnswer {
    /// A hold with its fits.
    Relaxed(Box<AfmRelaxedAnswer>),
    /// A hold that could not be fitted.
    Refused(AfmRefusedHoldAnswer),
}

/// What a hold says of relaxation.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmRelaxedAnswer {
    /// When it begins, s; given in `holds` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// Scale N of the force, N: F(t) = N (c0 + Σ ci e^(−vi t)) (eq. 3.4).
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Equilibrium share c0.
    pub c0: f64,
    /// Exponentials of the force, the fastest first.
    pub terms: Vec<AfmTermAnswer>,
    /// Linear latency model of the strain, order 1 (eq. 4.9).
    pub latency_linear: AfmLatencyAnswer,
    /// Latency model of the order that fits best (eq. 7.2).
    pub latency_power: AfmLatencyAnswer,
}

/// A hold that could not be fitted.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmRefusedHoldAnswer {
    /// When it begins, s; given in `holds` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// Why it could not be fitted.
    pub error: String,
}

/// One exponential of the force in a hold.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmTermAnswer {
    /// Coefficient ci.
    pub coefficient: f64,
    /// Rate vi, 1/s.
    pub rate_per_s: f64,
}

/// The latency model of a hold: dε/dt = −ν sgn(ε − εe) |ε − εe|^n, with strain relative to that at the start of the hold.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmLatencyAnswer {
    /// Order n, from 1.
    pub order: u32,
    /// Rate ν, 1/s.
    pub rate_per_s: Uncertain,
    /// Equilibrium strain εe.
    pub equilibrium: Uncertain,
    /// Strain at the start ε0.
    pub start: Uncertain,
    /// Root mean square of the residual strain.
    pub rms: f64,
}

/// What a rough surface does to modulus and contact point, by Monte Carlo.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmRoughAnswer {
    /// Version of this answer.
    pub palpate_afm_rough: u32,
    /// Seed of the surfaces.
    pub seed: u64,
    /// Number of places that were tried.
    pub trials: usize,
    /// Apparent modulus over the true one.
    pub modulus_ratio: AfmSpreadAnswer,
    /// Apparent contact point above the mean surface, m.
    pub contact_m: AfmSpreadAnswer,
    /// Number of asperities that bear at the largest force.
    pub touching: AfmSpreadAnswer,
}

/// Spread of a quantity over the trials, in its unit.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AfmSpreadAnswer {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation.
    pub standard_deviation: f64,
    /// Fifth and ninety-fifth percentile.
    pub middle_90: [f64; 2],
}

impl AfmAnswer {
    /// The curves that were fitted with these options.
    #[must_use]
    pub fn of(curves: &[FittedCurve], options: &Options) -> Self {
        Self {
            palpate_afm: 1,
            poisson_ratio: options.poisson_ratio,
            modulus_factor: modulus_factor(options.pressure),
            curves: curves.iter().map(AfmCurveAnswer::from).collect(),
        }
    }
}

impl From<&FittedCurve> for AfmCurveAnswer {
    fn from((curve, fit): &FittedCurve) -> Self {
        match fit {
            Ok(fit) => Self::Fitted(Box::new(AfmFitAnswer::of(curve, fit))),
            Err(error) => Self::Refused(AfmRefusedAnswer {
                curve: curve.label.clone(),
                notes: curve.notes.clone(),
                error: error.to_string(),
            }),
        }
    }
}

impl AfmFitAnswer {
    fn of(curve: &ForceCurve, fit: &CurveFit) -> Self {
        let held =
            |held: &Held| AfmHoldAnswer::of(&held.relaxed, Some(curve.time_s[held.range.start]));
        Self {
            curve: curve.label.clone(),
            notes: curve.notes.clone(),
            remarks: curve_remarks(fit),
            spring_constant_n_per_m: curve.spring_n_per_m,
            modulus_pa: fit.modulus_pa.map(Uncertain::from),
            equilibrium_modulus_pa: fit.equilibrium_modulus_pa.map(Uncertain::from),
            relaxation: fit.relaxation.iter().map(AfmExponentialAnswer::from).collect(),
            way_back_fitted: fit.follows_back,
            drag_n: fit.drag_n,
            no_modulus: fit.no_modulus.clone(),
            contact_m: fit.contact_m.into(),
            baseline_n: fit.offset_n,
            tilt_n_per_m: fit.tilt_n_per_m,
            approach_pull_n: fit.approach_pull_n.map(Uncertain::from),
            noise_n: fit.noise_n,
            residual_rms_n: fit.residual_rms_n,
            samples: fit.samples,
            outliers: fit.left_out,
            depth_m: fit.depth_m,
            force_n: fit.force_n,
            slope_over_spring_constant: fit.slope_over_spring,
            retreat: fit.retreat.as_ref().map(AfmRetreatAnswer::from),
            hold: fit.longest_hold().map(|held| AfmHoldAnswer::of(&held.relaxed, None)),
            holds: fit.holds.iter().map(held).collect(),
        }
    }
}

impl AfmHoldAnswer {
    /// A hold that begins at this time, s, where it is to be said.
    fn of(found: &Result<Relaxed, String>, from_s: Option<f64>) -> Self {
        match found {
            Ok(held) => Self::Relaxed(Box::new(AfmRelaxedAnswer::of(held, from_s))),
            Err(why) => Self::Refused(AfmRefusedHoldAnswer { from_s, error: why.clone() }),
        }
    }
}

impl AfmRelaxedAnswer {
    fn of(held: &Relaxed, from_s: Option<f64>) -> Self {
        let sum = &held.exponentials.sum;
        let term =
            |term: &Term| AfmTermAnswer { coefficient: term.coefficient, rate_per_s: term.rate };
        Self {
            from_s,
            duration_s: held.duration_s,
            force_n: sum.scale,
            c0: sum.constant,
            terms: sum.terms.iter().map(term).collect(),
            latency_linear: (&held.linear).into(),
            latency_power: (&held.power).into(),
        }
    }
}

impl From<&Exponential> for AfmExponentialAnswer {
    fn from(term: &Exponential) -> Self {
        Self { share: term.share.into(), rate_per_s: term.rate.into() }
    }
}

impl From<&Retreat> for AfmRetreatAnswer {
    fn from(retreat: &Retreat) -> Self {
        Self {
            adheres: retreat.adheres,
            pull_off_n: retreat.pull_off_n,
            energy_j: retreat.energy_j,
            work_dmt: retreat.work_dmt,
            work_jkr: retreat.work_jkr,
            tabor: retreat.tabor,
        }
    }
}

impl From<&Latency> for AfmLatencyAnswer {
    fn from(latency: &Latency) -> Self {
        Self {
            order: latency.order,
            rate_per_s: latency.rate.into(),
            equilibrium: latency.equilibrium.into(),
            start: latency.start.into(),
            rms: latency.rms,
        }
    }
}

impl AfmRoughAnswer {
    /// The spreads over so many trials with a seed.
    #[must_use]
    pub fn of(spreads: &Spreads, trials: usize, seed: u64) -> Self {
        Self {
            palpate_afm_rough: 1,
            seed,
            trials,
            modulus_ratio: spreads.modulus_ratio.into(),
            contact_m: spreads.contact_m.into(),
            touching: spreads.touching.into(),
        }
    }
}

impl From<Spread> for AfmSpreadAnswer {
    fn from(spread: Spread) -> Self {
        Self {
            mean: spread.mean,
            standard_deviation: spread.deviation,
            middle_90: [spread.middle.0, spread.middle.1],
        }
    }
}
