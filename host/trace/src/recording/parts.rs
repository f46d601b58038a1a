//! The parts of a row.

use shared::fixed::microstrain;
use shared::pipeline::GAUGES;
use shared::wire::Row;

/// FA and SA of a row, µε, gauge by gauge.
#[must_use]
pub fn parts(row: &Row) -> [(f64, f64); GAUGES] {
    let mut parts = [(0.0, 0.0); GAUGES];
    for (part, (fa, sa)) in parts.iter_mut().zip(row.fa.iter().zip(&row.sa)) {
        *part = (microstrain(*fa), microstrain(*sa));
    }
    parts
}
