//! What the dissertation's chapters ask of holds and rates, of anybody's recordings.
//!
//! - [`cycles`]: the six regions of every cycle, their points, work and dissipation (3.4.1, 4.4.3).
//! - [`relaxation`]: what every hold of a displacement shows (chapters 3 and 4, appendix A).
//! - [`terms`]: how many exponentials a hold shows, by criterion and by samples left out.
//! - [`derivative`]: the derivative of noisy data, with its bandwidth.

pub mod cycles;
pub mod derivative;
pub mod relaxation;
pub mod terms;
