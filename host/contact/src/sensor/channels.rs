//! Readings through the device's own pipeline.

use shared::fixed::{microstrain, strain_from_microstrain};
use shared::pipeline::{GAUGES, Pipeline};
use shared::wire::Settings;

use super::SensorError;
use palpate_trace::{GAUGES as NAMES, Trace};

/// What the device makes of one gauge, µε, sample by sample; FA + SA is the reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    /// Fast adapting part.
    pub fa: Vec<f64>,
    /// Slow adapting part.
    pub sa: Vec<f64>,
}

/// Runs the gauges of an evenly sampled trace through the pipeline of a device with these settings.
///
/// # Errors
/// [`SensorError::Settings`] if no device can be set so at this rate.
pub fn channels(trace: &Trace, settings: &Settings) -> Result<[Channels; GAUGES], SensorError> {
    let interval_s = trace.duration() / trace.len().saturating_sub(1).max(1) as f64;
    let mut pipeline = Pipeline::new(&settings.config(interval_s)?);
    let readings = NAMES.map(|name| trace.column(name).unwrap_or_default());
    let mut channels: [Channels; GAUGES] = std::array::from_fn(|_| Channels::default());
    for k in 0..trace.len() {
        let strain =
            readings.map(|values| values.get(k).map_or(0, |value| strain_from_microstrain(*value)));
        pipeline.process_strain(&strain, None);
        for (channel, output) in channels.iter_mut().zip(pipeline.outputs()) {
            channel.fa.push(microstrain(output.fa));
            channel.sa.push(microstrain(output.sa()));
        }
    }
    Ok(channels)
}
