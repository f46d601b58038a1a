//! One trace looked at more closely: force over displacement, and what its residual is like beside the noise.

use serde_json::{Value, json};

use palpate_diagnose::criticism::character::character;
use palpate_diagnose::criticism::leftover::Leftover;
use palpate_diagnose::criticism::residuals::Stretch;

/// Most points of a loop.
const POINTS: usize = 1500;
/// Points of the noise's distribution.
const CURVE: usize = 61;

/// What is drawn of one trace. The loop has one list of points for each stretch without a gap.
#[must_use]
pub fn closer_json(left: &Leftover, trace: usize) -> Value {
    let stretches = left.residuals.of_trace(trace);
    let samples: usize = stretches.iter().map(|stretch| stretch.time.len()).sum();
    let step = samples.div_ceil(POINTS).max(1);
    let course = |stretch: &Stretch| {
        let thin = |values: &[f64]| values.iter().step_by(step).copied().collect::<Vec<f64>>();
        json!({
            "displacement": thin(&stretch.displacement),
            "measured": thin(&stretch.measured),
            "predicted": thin(&stretch.predicted),
        })
    };
    let found = character(&stretches).map(|found| {
        let noise = left.comparison.noise.as_ref();
        let (first, last) = (found.edges[0], found.edges[found.edges.len() - 1]);
        let at = |k: usize| first + (last - first) * k as f64 / (CURVE - 1) as f64;
        let values: Vec<f64> = (0..CURVE).map(at).collect();
        let lag = |k: usize| k as f64 * found.interval_s;
        json!({
            "lag_s": (0..found.correlation.len()).map(lag).collect::<Vec<_>>(),
            "correlation": found.correlation,
            "noise_correlation": noise.map(|noise| found.correlation_of(noise)),
            "frequency_hz": found.frequency_hz,
            "density": found.density,
            "noise_density": noise.map(|noise| found.density_of(noise)),
            "edges": found.edges,
            "shares": found.shares,
            "noise_values": values,
            "noise_shares": noise.map(|noise| found.shares_of(noise, &values)),
        })
    });
    json!({"loop": stretches.iter().map(course).collect::<Vec<_>>(), "residual": found})
}
