//! `palpate sensor`: what a simulated fingertip felt.

use palpate_contact::sensor::{
    Felt, Fingertip, Indenter, PressResult, Response, SlideResult, SlipResult, Tone, TonesResult,
    Touch,
};
use serde::Serialize;
use shared::adaptation::Relaxation;

/// What the fingertip felt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SensorStimulus {
    /// A press, a hold and a release.
    Press,
    /// Sinusoidal stimuli from slow to fast.
    Frequency,
    /// A slide over a fingerprint.
    Slide,
    /// A press and a pull sideways until it slides.
    Slip,
    /// A press that shakes as a hand does.
    Shake,
}

/// A simulated fingertip and what it was touched with.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorSpecimenAnswer {
    /// Share of silicone in the mixture of silicone and thinner, 0.5 to 0.9.
    pub share_of_silicone: f64,
    /// Thickness of the silicone, mm.
    pub thickness_mm: f64,
    /// Silicone above the gauges, mm.
    pub cover_mm: f64,
    /// Young's modulus of the silicone at once, before anything relaxes, Pa.
    #[serde(rename = "modulus_Pa")]
    pub modulus_pa: f64,
    /// Relaxation function of the readings.
    pub relaxation: SensorRelaxationAnswer,
    /// Radius of the indenter's tip, mm.
    pub tip_radius_mm: f64,
    /// Readings are cut off here, µε.
    pub limit_ustrain: f64,
    /// Standard deviation of a reading's noise, µε.
    pub noise_ustrain: f64,
    /// Seed of the noise.
    pub seed: u64,
}

/// A relaxation function g(t) = c0 + c1 e^(−v1 t) + c2 e^(−v2 t) (eq. 3.4).
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorRelaxationAnswer {
    /// Share c0 at equilibrium, 0 to 1.
    pub c0: f64,
    /// Share c1 of the fast exponential, 0 to 1.
    pub c1: f64,
    /// Share c2 of the slow exponential, 0 to 1.
    pub c2: f64,
    /// Fast rate v1, 1/s.
    pub v1: f64,
    /// Slow rate v2, 1/s.
    pub v2: f64,
}

/// A press on a simulated fingertip.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorPressAnswer {
    /// Version of this answer.
    pub palpate_sensor: u32,
    /// Always `press`.
    pub stimulus: SensorStimulus,
    /// The fingertip and the indenter.
    pub specimen: SensorSpecimenAnswer,
    /// Depth that was held, mm.
    pub depth_mm: f64,
    /// Largest force, N.
    #[serde(rename = "peak_force_N")]
    pub peak_force_n: f64,
    /// What each of the four gauges read.
    pub gauges: [SensorGaugeAnswer; 4],
}

/// What one gauge read of a press.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorGaugeAnswer {
    /// Reading of largest size, µε.
    pub peak_ustrain: f64,
    /// Reading at the end of the hold, µε.
    pub end_of_hold_ustrain: f64,
    /// When the reading was first cut off, s since the press began; null where it never was.
    pub saturated_after_s: Option<f64>,
    /// Reading when the indenter has just left, µε.
    pub after_release_ustrain: f64,
    /// Time until half of that was gone, s; null where the recording ends before.
    pub half_recovered_s: Option<f64>,
    /// Largest fast adapting part (FA) in size, µε.
    pub peak_fa_ustrain: f64,
}

/// Sinusoidal stimuli on a simulated fingertip.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorFrequencyAnswer {
    /// Version of this answer.
    pub palpate_sensor: u32,
    /// Always `frequency`.
    pub stimulus: SensorStimulus,
    /// The fingertip and the indenter.
    pub specimen: SensorSpecimenAnswer,
    /// Responses, from slow to fast.
    pub tones: Vec<SensorToneAnswer>,
}

/// Responses of FA and SA at one frequency.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorToneAnswer {
    /// Frequency, Hz.
    #[serde(rename = "frequency_Hz")]
    pub frequency_hz: f64,
    /// FA as measured.
    pub fa: SensorResponseAnswer,
    /// SA as measured.
    pub sa: SensorResponseAnswer,
    /// FA by the formula of the filter.
    pub fa_formula: SensorResponseAnswer,
    /// SA by the formula of the filter.
    pub sa_formula: SensorResponseAnswer,
    /// Largest distance between measurement and formula in the complex plane, of FA and SA.
    pub distance: f64,
}

/// Gain and phase, relative to the reading of silicone without memory.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorResponseAnswer {
    /// Amplitude over that of the reading without memory.
    pub gain: f64,
    /// Phase lead, degrees.
    pub phase_deg: f64,
}

/// A slide over a fingerprint.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorSlideAnswer {
    /// Version of this answer.
    pub palpate_sensor: u32,
    /// Always `slide`.
    pub stimulus: SensorStimulus,
    /// The fingertip and the indenter.
    pub specimen: SensorSpecimenAnswer,
    /// Frequency at which ridges pass, speed over period, Hz.
    #[serde(rename = "expected_Hz")]
    pub expected_hz: f64,
    /// Frequency of the highest line of FA above half the expected frequency, Hz; null where the spectrum does not reach it.
    #[serde(rename = "line_Hz")]
    pub line_hz: Option<f64>,
    /// Amplitude of that line, µε; null where there is none.
    pub line_ustrain: Option<f64>,
    /// Part of the ridges' wave that the contact lets through, below 1 in size and of either sign.
    pub through_contact: f64,
}

/// A press and a pull sideways until it slides.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorSlipAnswer {
    /// Version of this answer.
    pub palpate_sensor: u32,
    /// Always `slip`.
    pub stimulus: SensorStimulus,
    /// The fingertip and the indenter.
    pub specimen: SensorSpecimenAnswer,
    /// Radius of the contact, mm.
    pub contact_radius_mm: f64,
    /// When each nub let go before the slide, s, in order.
    pub nubs_let_go_s: Vec<f64>,
    /// When the whole contact began to slide, s.
    pub slides_s: f64,
}

/// A press that shakes as a hand does.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SensorShakeAnswer {
    /// Version of this answer.
    pub palpate_sensor: u32,
    /// Always `shake`.
    pub stimulus: SensorStimulus,
    /// The fingertip and the indenter.
    pub specimen: SensorSpecimenAnswer,
    /// When the indenter first left the fingertip, s; null where it never did.
    pub left_at_s: Option<f64>,
}

impl SensorSpecimenAnswer {
    /// A fingertip that is touched with an indenter and reads with the noise of a seed.
    #[must_use]
    pub fn of(fingertip: &Fingertip, indenter: Indenter, seed: u64) -> Self {
        let silicone = &fingertip.silicone;
        Self {
            share_of_silicone: silicone.composition.share(),
            thickness_mm: fingertip.thickness_mm,
            cover_mm: fingertip.cover_mm,
            modulus_pa: silicone.elastic.modulus_pa,
            relaxation: fingertip.relaxation_of_readings().into(),
            tip_radius_mm: indenter.radius_mm,
            limit_ustrain: fingertip.limit_ustrain,
            noise_ustrain: fingertip.noise_ustrain,
            seed,
        }
    }
}

impl From<Relaxation> for SensorRelaxationAnswer {
    fn from(g: Relaxation) -> Self {
        Self { c0: g.c0(), c1: g.c1, c2: g.c2, v1: g.v1, v2: g.v2 }
    }
}

impl SensorPressAnswer {
    /// What a specimen felt of a press.
    #[must_use]
    pub fn of(specimen: SensorSpecimenAnswer, result: &PressResult) -> Self {
        Self {
            palpate_sensor: 1,
            stimulus: SensorStimulus::Press,
            specimen,
            depth_mm: result.depth_mm,
            peak_force_n: result.peak_force_n,
            gauges: result.felt.each_ref().map(SensorGaugeAnswer::from),
        }
    }
}

impl From<&Felt> for SensorGaugeAnswer {
    fn from(felt: &Felt) -> Self {
        Self {
            peak_ustrain: felt.peak,
            end_of_hold_ustrain: felt.end_of_hold,
            saturated_after_s: felt.saturated_after_s,
            after_release_ustrain: felt.left,
            half_recovered_s: felt.half_recovered_s,
            peak_fa_ustrain: felt.peak_fa,
        }
    }
}

impl SensorFrequencyAnswer {
    /// What a specimen felt of tones.
    #[must_use]
    pub fn of(specimen: SensorSpecimenAnswer, result: &TonesResult) -> Self {
        Self {
            palpate_sensor: 1,
            stimulus: SensorStimulus::Frequency,
            specimen,
            tones: result.tones.iter().map(SensorToneAnswer::from).collect(),
        }
    }
}

impl From<&Tone> for SensorToneAnswer {
    fn from(tone: &Tone) -> Self {
        Self {
            frequency_hz: tone.frequency_hz,
            fa: tone.fa.into(),
            sa: tone.sa.into(),
            fa_formula: tone.fa_formula.into(),
            sa_formula: tone.sa_formula.into(),
            distance: tone.distance,
        }
    }
}

impl From<Response> for SensorResponseAnswer {
    fn from(Response { gain, phase_deg }: Response) -> Self {
        Self { gain, phase_deg }
    }
}

impl SensorSlideAnswer {
    /// What a specimen felt of a slide.
    #[must_use]
    pub fn of(specimen: SensorSpecimenAnswer, result: &SlideResult) -> Self {
        let (line_hz, line_ustrain) = result.line.unzip();
        Self {
            palpate_sensor: 1,
            stimulus: SensorStimulus::Slide,
            specimen,
            expected_hz: result.expected_hz,
            line_hz,
            line_ustrain,
            through_contact: result.through_contact,
        }
    }
}

impl SensorSlipAnswer {
    /// What a specimen felt of a pull.
    #[must_use]
    pub fn of(specimen: SensorSpecimenAnswer, result: &SlipResult) -> Self {
        Self {
            palpate_sensor: 1,
            stimulus: SensorStimulus::Slip,
            specimen,
            contact_radius_mm: result.contact_mm,
            nubs_let_go_s: result.let_go_s.clone(),
            slides_s: result.slides_s,
        }
    }
}

impl SensorShakeAnswer {
    /// What a specimen felt of shaking.
    #[must_use]
    pub fn of(specimen: SensorSpecimenAnswer, touch: &Touch) -> Self {
        Self {
            palpate_sensor: 1,
            stimulus: SensorStimulus::Shake,
            specimen,
            left_at_s: touch.left_at_s,
        }
    }
}
