//! Samples of a hold taken together over steps of the logarithm of time.

use std::ops::Range;

/// Duration of a block, over the time since the first sample.
const STEP: f64 = 0.01;

/// Blocks of samples at these times, s, of which the first sample is one.
#[must_use]
pub fn log_blocks(times: &[f64]) -> Vec<Range<usize>> {
    let mut blocks = Vec::new();
    let mut begin = 0;
    while begin < times.len() {
        let reach = (times[begin] - times[0]) * (1.0 + STEP);
        let end = begin + times[begin..].partition_point(|time| time - times[0] <= reach);
        let end = end.max(begin + 1);
        blocks.push(begin..end);
        begin = end;
    }
    blocks
}
