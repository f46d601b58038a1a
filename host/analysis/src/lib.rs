//! What the dissertation's chapters ask of holds and rates, of anybody's recordings.
//!
//! - [`cycles`]: the six regions of every cycle, their points, work and dissipation (3.4.1, 4.4.3).
//! - [`relaxation`]: what every hold of a displacement shows (chapters 3 and 4, appendix A).
//! - [`creep`]: what every hold of a force shows (chapter 6, appendix B).
//! - [`conditioning`]: the Butterworth filter of 6.3.3.
//! - [`rates`]: one specimen at several loading rates (chapter 5).
//! - [`strain_rate`]: strain and strain rate, and the power law of every hold (chapter 7).
//! - [`markers`]: markers that a camera follows, and the latency model of the gaps between them (4.3, 6.3).
//! - [`segment_run`]: the simulation of 7.4 along one's own motion, with (7.11).
//! - [`pull_off`]: how an adhesive contact comes off: force, work, separation; [`pull_off_growth`]: their growth with speed.
//! - [`geometry`]: area of contact (5.5), (7.7).
//! - [`terms`]: how many exponentials a hold shows, by criterion and by samples left out.
//! - [`derivative`]: the derivative of noisy data, with its bandwidth.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let press = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/traces/press.csv");
//! use palpate_analysis::press::analyse;
//! use palpate_trace::read;
//!
//! let trace = read(press.as_ref())?;
//! let found = analyse(&trace, || ())?;
//! assert!(found.fit.r_squared > 0.99 && found.channels.len() == 4);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod conditioning;
pub mod controlled;
pub mod creep;
pub mod cycles;
pub mod decomposition;
pub mod derivative;
pub mod events;
pub mod geometry;
pub mod markers;
pub mod press;
pub mod pull_off;
pub mod pull_off_growth;
pub mod rates;
pub mod regions;
pub mod relaxation;
pub mod segment_run;
pub mod strain_rate;
pub mod terms;
