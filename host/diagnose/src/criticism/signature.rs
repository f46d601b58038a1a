//! What an effect leaves in the residual of a base law that lacks it: a press and a few cycles, made up
//! with the effect at its typical size, and the base law refitted to them.

use std::borrow::Cow;

use super::residuals::{Residuals, Stretch};
use super::screen::ABSORBED;
use crate::practice::session::{SPECIMEN, two_traces};
use palpate_fit::data::{Data, DataError};
use palpate_fit::whole_motion::{predict, refit};
use palpate_model::effects::{Count, Effect, Scales, Shape};
use palpate_model::{Chain, Parameter};
use palpate_trace::{FORCE, Trace};

/// An effect's mark on a press with a hold and on four cycles.
#[derive(Clone)]
pub struct Signature {
    /// The effect.
    pub effect: &'static Effect,
    /// Parameters of its reference law, with the values they were given.
    pub parameters: Vec<(Parameter, f64)>,
    /// The sizes of what happens in the traces.
    pub scales: Scales,
    /// The force with the effect against the base law refitted to it.
    pub stretches: Vec<Stretch>,
    /// Values of the quantity that tells most of the effect, stretch by stretch.
    pub against: Vec<Vec<f64>>,
    /// Largest force, N.
    pub force: f64,
    /// Root mean square of what the effect adds to the force, N.
    pub whole: f64,
    /// Root mean square of what is left of it when the base law is refitted, N.
    pub left: f64,
}

impl Signature {
    /// Whether the base law takes up nearly all of the effect on these two traces.
    #[must_use]
    pub fn absorbed(&self) -> bool {
        self.left < ABSORBED * self.whole
    }
}

/// The signature of an effect.
///
/// # Errors
/// When the base law cannot be refitted to what the effect does.
pub fn signature(effect: &'static Effect) -> Result<Signature, DataError> {
    let mut traces = two_traces();
    let (base, values) = (Chain::new(SPECIMEN.0), &SPECIMEN.1);
    let bare = predict(&base, values, &Data::of_motions(&traces, FORCE)?);
    give(&mut traces, &bare);
    let law = &effect.laws[0];
    let (applied, own, force) = {
        let data = Data::of(&traces, FORCE)?;
        let setting = data.setting();
        let applied = law.applied(effect, &setting);
        let typical = (law.strength.typical)(&setting.scales);
        let strength = |k: usize| match law.strength.count {
            // One for each trace or channel: in turn of either sign.
            Count::Traces | Count::Channels if k % 2 == 1 => -typical,
            _ => typical,
        };
        let middle = |shape: &Shape| {
            let grid = (shape.grid)(&setting.scales);
            grid[grid.len() / 2]
        };
        let own: Vec<f64> =
            (0..applied.strengths).map(strength).chain(law.shapes.iter().map(middle)).collect();
        let chain = base.with(applied.clone());
        let force = predict(&chain, &[&values[..], &own].concat(), &data);
        (applied, own, force)
    };
    let change = force.iter().flatten().zip(bare.iter().flatten()).map(|(with, bare)| with - bare);
    let whole = root_mean_square(change);
    give(&mut traces, &force);
    let data = Data::of(&traces, FORCE)?;
    let found = refit(&base, values, &data)?;
    let residuals = Residuals::new(&base, &found.values, &data);
    let against = residuals.covariate(effect.against).unwrap_or_default();
    Ok(Signature {
        effect,
        parameters: applied.parameters.into_iter().zip(own).collect(),
        scales: data.scales(),
        force: force.iter().flatten().fold(0.0, |most: f64, force| most.max(force.abs())),
        whole,
        left: found.rms(),
        stretches: residuals.stretches().collect(),
        against: against.into_iter().map(Cow::into_owned).collect(),
    })
}

/// Gives every trace its force.
fn give(traces: &mut [Trace], force: &[Vec<f64>]) {
    for (trace, force) in traces.iter_mut().zip(force) {
        trace.set_column(FORCE, force.clone());
    }
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}
