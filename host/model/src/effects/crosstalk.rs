//! `crosstalk`: other channels leak into the signal.

use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Channel, Stage};

/// Largest part of the signal's range that leaks from one channel. All channels answer to the same
/// motion: what explains more than this is no leak but a misfit that they share.
const MAX_LEAK: f64 = 0.15;

const LEAK: Strength = Strength {
    name: "leak",
    unit: "",
    meaning: "part of this channel, in its unit, that is added to the signal",
    sign: Sign::Either,
    typical: |_| 0.01,
    most: |scales| MAX_LEAK * scales.force,
    count: Count::Channels,
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "crosstalk",
    stage: Stage::Sensor,
    meaning: "Channels leak into each other, or a gauge is strained by a load that another one is meant for.",
    signature: "Copies of another channel, at every phase.",
    against: Covariate::Displacement,
    confused_with: &[],
    experiment: "Load so that one channel answers alone, and watch the others.",
    needs: Needs::Channels,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + Σ k_j channel_j",
            strength: LEAK,
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                for (leak, channel) in parameters.iter().zip(scene.channels) {
                    for (force, value) in force.iter_mut().zip(channel.values) {
                        *force += leak * value;
                    }
                }
            }),
        },
        Law {
            name: "zeroed",
            formula: "F → F + Σ k_j (channel_j − channel_j at the first sample of the set)",
            strength: LEAK,
            shapes: &[],
            act: Act::Added(|scene, parameters, first, force| {
                if first.is_empty() {
                    let begin =
                        |channel: &Channel| channel.values.first().copied().unwrap_or_default();
                    *first = scene.channels.iter().map(begin).collect();
                }
                let leaks = parameters.iter().zip(first.iter());
                for ((leak, first), channel) in leaks.zip(scene.channels) {
                    for (force, value) in force.iter_mut().zip(channel.values) {
                        *force += leak * (value - first);
                    }
                }
            }),
        },
        Law {
            name: "capacitive",
            formula: "F → F + Σ k_j dchannel_j/dt",
            strength: Strength {
                unit: "s",
                meaning: "part of the other channel's slope that leaks in",
                typical: |scales| scales.interval,
                most: |scales| MAX_LEAK * scales.force * 10.0 * scales.interval,
                ..LEAK
            },
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                for (leak, channel) in parameters.iter().zip(scene.channels) {
                    for (force, slope) in force.iter_mut().zip(&channel.slope) {
                        *force += leak * slope;
                    }
                }
            }),
        },
    ],
};
