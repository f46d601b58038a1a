//! A simulated fingertip: four gauges in silicone, and what they say of a touch (8.2.1).
//!
//! # The chain
//! An indenter follows a path: depth and place over time ([`Stroke`]). A paraboloid of its tip radius presses the silicone
//! as Hertz has it, stiffened by the rigid base below ([`bonded_layer_factor`](crate::bonded_layer_factor)); the
//! stress where a gauge lies is Huber's, that of a half space, and Hooke's law makes it the strain ε_e along the gauge
//! that silicone without memory would show.
//!
//! Silicone remembers. The force relaxes with g(t) = c0 + c1 e^(−v1 t) + c2 e^(−v2 t) (eq. 3.4). A foil gauge is stiffer
//! than what it lies in: it takes the part `transfer` of the strain around it, and reads something between the strain of the
//! silicone (a gauge as soft as silicone would) and its stress (one that is rigid beside it would). With w, the
//! `stress_share`, the reading is transfer × ((1 − w) ε_e + w ∫ g dε_e): again eq. 3.4, with shares w c1 and w c2. So it
//! relaxes during a hold, and what is left of a dent after the release is still felt: while the surface is free of force
//! (∫ g dF_e = 0) and above the indenter, ε_e follows the dent, which creeps back.
//!
//! What is left out: strains are small by assumption though a sharp tip makes large ones; no friction; the base acts on the
//! force only; gauges are points.

mod channels;
mod fingertip;
mod press;
mod shake;
mod silicone;
mod slide;
mod slip;
mod spectrum;
mod tones;
mod touch;

pub use channels::{Channels, channels};
pub use fingertip::{Fingertip, Indenter};
pub use press::{Felt, Press, PressResult};
pub use shake::Shake;
pub use silicone::{Composition, Silicone, TABLE_8_2};
pub use slide::{Ridges, Slide, SlideResult};
pub use slip::{Slip, SlipResult};
pub use spectrum::{Spectrum, spectrum};
pub use tones::{Response, Tone, Tones, TonesResult};
pub use touch::{Stroke, Touch, feel};

use shared::wire::SettingsError;

/// Why a touch cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum SensorError {
    #[error(
        "a composition of {given} is no share of silicone between {least} and {most}: give parts of silicone and thinner such as 7:3"
    )]
    Composition { given: String, least: f64, most: f64 },
    #[error("{name} is {value}; it must lie between {least} and {most}")]
    Range { name: &'static str, value: f64, least: f64, most: f64 },
    #[error(
        "{samples:.3e} samples; at most {most:.0e} are simulated: make it shorter, or the rate lower"
    )]
    Samples { samples: f64, most: f64 },
    #[error(
        "the tip goes {depth_mm:.2} mm deep, beyond {most_mm:.2} mm, nine tenths of the silicone above the gauges: press less, or take thicker silicone"
    )]
    TooDeep { depth_mm: f64, most_mm: f64 },
    #[error("a device cannot run so: {0}")]
    Settings(SettingsError),
}

impl From<SettingsError> for SensorError {
    fn from(source: SettingsError) -> Self {
        Self::Settings(source)
    }
}

/// Most samples of one simulation.
const MOST_SAMPLES: f64 = 2e6;

/// Whether a number lies in its range.
fn within(name: &'static str, value: f64, least: f64, most: f64) -> Result<(), SensorError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(SensorError::Range { name, value, least, most })
    }
}

/// Times of so many seconds at a rate, s.
fn clock(duration_s: f64, rate_hz: f64) -> Result<Vec<f64>, SensorError> {
    let samples = (duration_s * rate_hz).round();
    if samples > MOST_SAMPLES {
        return Err(SensorError::Samples { samples, most: MOST_SAMPLES });
    }
    Ok((0..=samples as usize).map(|index| index as f64 / rate_hz).collect())
}
