//! Recordings in block means, as long as a model cannot change within a block.
//!
//! Whatever its rates, a sum of exponentials answers ever more slowly to a motion that has come to rest: at
//! a time s after it, the answer within ε s is straight up to ε²/8 of what still relaxes. So samples at rest
//! are taken together over a small part of the time since the motion, and a hold of half an hour is told by
//! a few hundred means. With the number of samples as weight, the sum of squares is that of all samples, less
//! what scatters within blocks. Searches go far on the means; what they find is confirmed on all samples.

use super::data::{Data, Piece};
use palpate_model::Motion;
use palpate_trace::{REST, block_begins};

/// Samples for each mean from which on it is worth to search on the means first.
const WORTH: usize = 4;
/// The same of rough means, on which a search costs less than the first step on all samples.
const COARSE_WORTH: usize = 2;
/// Duration of a rough block, over the time since the motion.
const COARSE_PART: f64 = 0.1;
/// Change of the compression over a rough block, over the largest.
const COARSE_WAY: f64 = 0.03;

/// The block means of a data set.
#[derive(Clone, Debug)]
pub struct Compressed {
    blocks: Vec<Blocks>,
    /// Sum of squares of the signal about the means of its blocks.
    pub within: f64,
}

/// The block means of one stretch.
#[derive(Clone, Debug, Default)]
struct Blocks {
    time: Vec<f64>,
    displacement: Vec<f64>,
    measured: Vec<f64>,
    /// Root of the number of samples.
    roots: Vec<f64>,
}

impl Compressed {
    /// The means of a data set that tell it as well as its samples; none where they are hardly fewer.
    #[must_use]
    pub fn of(data: &Data) -> Option<Self> {
        let band = REST * data.largest_compression();
        let compressed = Self::by(data, |time, x| block_begins(time, x, band));
        (WORTH * compressed.len() <= data.samples()).then_some(compressed)
    }

    /// Means that tell a data set roughly, as it takes to find the valley of a minimum; none where they are hardly fewer.
    #[must_use]
    pub fn coarse(data: &Data) -> Option<Self> {
        let largest = data.largest_compression();
        let compressed = Self::by(data, |time, x| coarse_begins(time, x, largest));
        (COARSE_WORTH * compressed.len() <= data.samples()).then_some(compressed)
    }

    /// The means over blocks that begin where `begins` says of times and compressions.
    fn by(data: &Data, begins: impl Fn(&[f64], &[f64]) -> Vec<usize>) -> Self {
        let mut compressed = Self { blocks: Vec::new(), within: 0.0 };
        for piece in &data.pieces {
            let (time, x) = (&piece.motion.time[..], &piece.motion.displacement[..]);
            let mut blocks = Blocks::default();
            for block in ends(begins(time, x), time.len()).windows(2) {
                let range = block[0]..block[1];
                let count = range.len() as f64;
                let mean = |values: &[f64]| values[range.clone()].iter().sum::<f64>() / count;
                let measured = mean(piece.measured);
                blocks.time.push(mean(time));
                blocks.displacement.push(mean(x));
                blocks.measured.push(measured);
                blocks.roots.push(count.sqrt());
                compressed.within += piece.measured[range.clone()]
                    .iter()
                    .map(|y| (y - measured).powi(2))
                    .sum::<f64>();
            }
            compressed.blocks.push(blocks);
        }
        compressed
    }

    /// Number of means.
    #[must_use]
    pub fn len(&self) -> usize {
        self.blocks.iter().map(|blocks| blocks.time.len()).sum()
    }

    /// Root of the number of samples in every block, stretch by stretch.
    #[must_use]
    pub fn roots(&self) -> Vec<&[f64]> {
        self.blocks.iter().map(|blocks| &blocks.roots[..]).collect()
    }

    /// The data set with its means in the place of its samples, as a base law alone sees it: motion and
    /// signal.
    #[must_use]
    pub fn data<'b>(&'b self, data: &'b Data<'_>) -> Data<'b> {
        let means = |(piece, blocks): (&'b Piece<'_>, &'b Blocks)| {
            let motion = Motion {
                time: (&blocks.time).into(),
                displacement: (&blocks.displacement).into(),
                rest_before: piece.motion.rest_before,
            };
            piece.with_samples(motion, &blocks.measured)
        };
        Data {
            signal: data.signal.clone(),
            labels: data.labels.clone(),
            pieces: data.pieces.iter().zip(&self.blocks).map(means).collect(),
            left_out: Vec::new(),
            signal_stays: data.signal_stays,
            reference_temperature: None,
            channels: Vec::new(),
            unordered: data.unordered,
            effects: data.effects.clone(),
            laws: data.laws.clone(),
            below: data.below,
            keeps: data.keeps,
        }
    }
}

/// Where blocks begin, and the number of samples.
fn ends(begins: Vec<usize>, samples: usize) -> Vec<usize> {
    begins.into_iter().chain([samples]).collect()
}

/// Where rough blocks begin: each lasts a small part of the time since a motion, or over a small part of the largest compression of
/// one, and none goes from the one to the other.
fn coarse_begins(time: &[f64], x: &[f64], largest: f64) -> Vec<usize> {
    let (mut begins, mut begin) = (vec![0], 0);
    // The last place that the motion has left, and when.
    let (mut place, mut since) = (x[0], time[0]);
    let mut moving = false;
    for k in 1..time.len() {
        let moves = (x[k] - place).abs() > REST * largest;
        let over = if moves {
            !moving || (x[k] - x[begin]).abs() > COARSE_WAY * largest
        } else {
            time[k] - time[begin] > COARSE_PART * (time[begin] - since)
        };
        if over {
            begins.push(k);
            begin = k;
        }
        if moves {
            (place, since) = (x[k], time[k]);
        }
        moving = moves;
    }
    begins
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A press of a second, a hold, a release of a second, and a rest, at a rate.
    fn press(rate: f64, hold: f64) -> (Vec<f64>, Vec<f64>) {
        let count = ((2.0 + 2.0 * hold) * rate) as usize;
        let time: Vec<f64> = (0..count).map(|k| k as f64 / rate).collect();
        let x = time.iter().map(|t| (4.0 * t).min(4.0).min(4.0 * (2.0 + hold - t)).max(-0.1));
        let x = x.collect();
        (time, x)
    }

    #[test]
    fn every_sample_is_in_one_block_and_a_motion_is_left_as_it_is() {
        let (time, x) = press(100.0, 60.0);
        let ends = ends(block_begins(&time, &x, 4.0 * REST), time.len());
        assert!(ends.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!((ends[0], ends[ends.len() - 1]), (0, time.len()));
        // Samples 1 to 100 are the press: each by itself.
        assert!((0..100).all(|k| ends[k] == k));
    }

    #[test]
    fn means_grow_like_the_logarithm_of_a_hold_not_like_its_samples() {
        let blocks = |rate: f64, hold: f64| {
            let (time, x) = press(rate, hold);
            block_begins(&time, &x, 4.0 * REST).len() + 1
        };
        let (short, long) = (blocks(50.0, 60.0), blocks(50.0, 6000.0));
        assert!(long < 2 * short + 100, "{long} for {short}");
        assert!(long < 1000, "{long} of 600,000");
    }
}
