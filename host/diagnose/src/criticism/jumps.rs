//! Samples of the signal that jump away and back while the motion is smooth: what they leave is the recorder's, and no model's.

use palpate_fit::data::{Data, Piece};
use palpate_model::Motion;
use palpate_trace::bridged;

/// Part of the misfit from which on samples that jump are what is missing.
pub(super) const MOST_JUMPS: f64 = 0.5;

/// Mean square, over all samples, by which those that jump are off the line between their neighbours, in the squared unit of the signal.
#[must_use]
pub(super) fn jumps(data: &Data) -> f64 {
    let square = |piece: &Piece| {
        let Motion { time, displacement, .. } = &piece.motion;
        let bridged = bridged(time, displacement, piece.measured);
        bridged.iter().zip(piece.measured).map(|(to, from)| (from - to).powi(2)).sum::<f64>()
    };
    data.pieces.iter().map(square).sum::<f64>() / (data.samples() as f64).max(1.0)
}
