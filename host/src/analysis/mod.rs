//! What the dissertation's chapters ask of holds and rates, of anybody's recordings.
//!
//! - [`cycles`]: the six regions of every cycle, their points, work and dissipation (3.4.1, 4.4.3).

pub mod cycles;
