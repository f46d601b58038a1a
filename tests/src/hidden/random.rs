//! Seeded chance: one stream of random numbers for each subject, so that one can change alone.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What a stream of random numbers decides.
#[derive(Clone, Copy, Debug)]
pub enum Subject {
    /// Order, motion, pauses and air.
    Session,
    /// Parameters of the specimen.
    Base,
    /// Size of the noise and its correlation.
    Size,
    /// The noise itself.
    Noise,
    /// Inner parameters of the hidden laws.
    Laws,
}

/// The stream of a subject for a seed.
#[must_use]
pub fn stream(seed: u64, subject: Subject) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(subject as u64);
    random
}

/// Evenly between two values.
pub fn even(random: &mut ChaCha8Rng, from: f64, to: f64) -> f64 {
    random.random_range(from..to)
}

/// Evenly in the logarithm between two values above 0.
pub fn log_even(random: &mut ChaCha8Rng, from: f64, to: f64) -> f64 {
    even(random, from.ln(), to.ln()).exp()
}

/// Plus or minus one.
pub fn sign(random: &mut ChaCha8Rng) -> f64 {
    if random.random_bool(0.5) { 1.0 } else { -1.0 }
}
