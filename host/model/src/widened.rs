//! How a compressed specimen widens.

/// How much wider a specimen is than without load at a compression, mm, of its height, mm (eq. 5.5, where Δl
/// is negative in compression).
#[must_use]
pub fn widened(compression: f64, height: f64, poisson: f64) -> f64 {
    1.0 + poisson * compression / height
}
