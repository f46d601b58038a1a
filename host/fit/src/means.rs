//! Recordings in block means, as effects see them: what a contact model can tell apart, whatever the rate.
//!
//! Blocks end where the motion, or what can be remembered of it, bends (`straight`); so a hold of half an hour is told by a
//! few hundred means, and a slow ramp by as many as a fast one. Samples count by their number and by the noise between
//! them: the means are whitened as their samples are (`whitened_blocks`), so that the sum of squares is that of all
//! samples. Searches go far on the means; what they find is confirmed on all samples.

use std::ops::Range;

use super::data::{Data, Known, Piece};
use super::slope::velocity;
use super::straight::{Reach, USUAL_NOISE, begins};
use palpate_model::{Channel, Motion};

/// Samples of a set up to which a search on all of them takes no time.
const SHORT: usize = 4000;
/// Samples for each mean from which on a search on the means is worth it.
const WORTH: usize = 3;
/// Fewest blocks of the longest stretch: laws of slow effects have kinks in time.
const FEWEST: usize = 100;
/// Blocks that a set at rest throughout would have where its noise is not known, and the fewest of a trace. There each mean counts
/// as one sample, and long holds keep their weight beside the motions.
const EVEN: usize = 3000;
const FEWEST_EVEN: usize = 300;

/// Slopes on both sides of a block that differ by more than this factor have a jump between them.
const JUMP: f64 = 4.0;

/// The block means of a data set.
#[derive(Clone, Debug)]
pub struct Means {
    stretches: Vec<Blocks>,
}

/// The block means of one stretch.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    /// Where the blocks begin, and the number of samples.
    pub begins: Vec<usize>,
    time: Vec<f64>,
    displacement: Vec<f64>,
    measured: Vec<f64>,
    temperature: Option<Vec<f64>>,
    /// Values and slopes.
    channels: Vec<(Vec<f64>, Vec<f64>)>,
    /// What follows from the motion, as the means of what follows from its samples.
    known: Known,
}

impl Means {
    /// The means of a data set as effects see it, for a search, with the standard deviation of its noise where that is known; none where
    /// all samples can be searched as well.
    #[must_use]
    pub fn of(data: &Data, noise: Option<f64>) -> Option<Self> {
        Self::finer(data, noise, 1.0)
    }

    /// The same with blocks over which so many times less may change.
    #[must_use]
    pub fn finer(data: &Data, noise: Option<f64>, times: f64) -> Option<Self> {
        let samples = data.samples();
        if samples <= SHORT {
            return None;
        }
        let values = data.pieces.iter().flat_map(|piece| piece.measured);
        let most = values.fold(0.0, |most: f64, value| most.max(value.abs()));
        let even = (EVEN / data.labels.len().max(1)).max(FEWEST_EVEN);
        let fewest = noise.map_or(even, |_| FEWEST) as f64;
        let noise = noise.map_or(USUAL_NOISE, |noise| noise / most.max(f64::MIN_POSITIVE));
        let speeds = data.pieces.iter().flat_map(|piece| velocity(&piece.motion));
        let reach = Reach {
            compression: data.largest_compression(),
            speed: speeds.fold(0.0, |most, speed| speed.abs().max(most)),
            rates: (0.5 / data.shortest_interval(), 1.0 / data.longest()),
            noise,
            longest: data.longest() / fewest,
            either: data.below.is_some(),
            finer: times,
        };
        let stretch = |piece: &Piece| Blocks::of(data, piece, reach);
        let found = Self { stretches: data.pieces.iter().map(stretch).collect() };
        (WORTH * found.len() <= samples).then_some(found)
    }

    /// Number of means.
    #[must_use]
    pub fn len(&self) -> usize {
        self.stretches.iter().map(|blocks| blocks.time.len()).sum()
    }

    /// Whether there is no mean.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The blocks, stretch by stretch.
    pub(super) fn stretches(&self) -> &[Blocks] {
        &self.stretches
    }

    /// The data set with its means in the place of its samples.
    #[must_use]
    pub fn data<'b>(&'b self, data: &'b Data<'_>) -> Data<'b> {
        let mean = |(piece, blocks): (&'b Piece<'_>, &'b Blocks)| {
            let motion = Motion {
                time: (&blocks.time).into(),
                displacement: (&blocks.displacement).into(),
                rest_before: piece.motion.rest_before,
            };
            let channel = |(values, slope): &'b (Vec<f64>, Vec<f64>)| Channel {
                values,
                slope: slope.clone(),
            };
            let channels = blocks.channels.iter().map(channel).collect();
            let recorded = (&blocks.measured[..], blocks.temperature.as_deref(), channels);
            piece.with_means(motion, recorded, blocks.known.clone())
        };
        Data {
            signal: data.signal.clone(),
            labels: data.labels.clone(),
            pieces: data.pieces.iter().zip(&self.stretches).map(mean).collect(),
            left_out: data.left_out.clone(),
            signal_stays: data.signal_stays,
            reference_temperature: data.reference_temperature,
            channels: data.channels.clone(),
            unordered: data.unordered,
            effects: data.effects.clone(),
            laws: data.laws.clone(),
            below: data.below,
            keeps: true,
        }
    }
}

impl Blocks {
    fn of(data: &Data, piece: &Piece, reach: Reach) -> Self {
        let known = piece.derive(data.reference_temperature);
        let (time, x) = (&piece.motion.time[..], &piece.motion.displacement[..]);
        let channels = piece.channels().iter().map(|channel| channel.values);
        let recorded: Vec<&[f64]> = piece.temperature().into_iter().chain(channels).collect();
        let begins = begins(time, (x, &known.velocity), &recorded, reach);
        let of = |values: &[f64]| means(&begins, values);
        let channel = |channel: &Channel| (of(channel.values), of(&channel.slope));
        let known = Known {
            velocity: of(&known.velocity),
            acceleration: of(&known.acceleration),
            // Loadings are counted from their beginning.
            loadings: begins[..begins.len() - 1].iter().map(|k| known.loadings[*k]).collect(),
            largest: of(&known.largest),
            warmth: known.warmth.as_deref().map(of),
        };
        Self {
            time: of(time),
            displacement: of(x),
            measured: of(piece.measured),
            temperature: piece.temperature().map(of),
            channels: piece.channels().iter().map(channel).collect(),
            known,
            begins,
        }
    }

    /// Root of the number of samples in each block.
    pub fn roots(&self) -> Vec<f64> {
        self.begins.windows(2).map(|pair| ((pair[1] - pair[0]) as f64).sqrt()).collect()
    }

    /// What the means do not tell of a signal: its samples less the line through the means of its blocks, about
    /// zero in every block.
    pub fn scatter(&self, piece: &Piece) -> Vec<f64> {
        let time = &piece.motion.time;
        let mut found = Vec::with_capacity(time.len());
        for (block, pair) in self.begins.windows(2).enumerate() {
            let range = pair[0]..pair[1];
            if range.len() == 1 {
                found.push(0.0);
                continue;
            }
            let slope = self.slope(block);
            let line = |k: usize| self.measured[block] + slope * (time[k] - self.time[block]);
            found.extend(range.map(|k| piece.measured[k] - line(k)));
        }
        found
    }

    /// Slope of the signal over a block, from the means of its neighbours; where a jump stands beside it, which is no slope within, the
    /// smaller of the slopes to the two, or none where they differ in sign.
    fn slope(&self, block: usize) -> f64 {
        let last = self.time.len() - 1;
        let (before, after) = (block.saturating_sub(1), (block + 1).min(last));
        let between = |a: usize, b: usize| {
            let apart = self.time[b] - self.time[a];
            if apart > 0.0 { (self.measured[b] - self.measured[a]) / apart } else { 0.0 }
        };
        let (into, out_of) = (between(before, block), between(block, after));
        let (least, most) = (into.abs().min(out_of.abs()), into.abs().max(out_of.abs()));
        match into * out_of > 0.0 {
            true if most < JUMP * least => between(before, after),
            true => least.copysign(into),
            false => 0.0,
        }
    }
}

/// The mean of every block.
fn means(begins: &[usize], values: &[f64]) -> Vec<f64> {
    let mean = |range: Range<usize>| {
        let count = range.len() as f64;
        values[range].iter().sum::<f64>() / count
    };
    begins.windows(2).map(|pair| mean(pair[0]..pair[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::{Column, DISPLACEMENT, FORCE, TEMPERATURE, Trace};

    /// Presses with a hold at a rate, with a temperature that rises.
    fn traces(rate: f64) -> Vec<Trace> {
        let press = |deep: f64| {
            let time: Vec<f64> = (0..(40.0 * rate) as usize).map(|k| k as f64 / rate).collect();
            let course = |t: &f64| (4.0 * t - 4.0).min(deep).min(120.0 - 4.0 * t).max(-0.1);
            let x: Vec<f64> = time.iter().map(course).collect();
            let force = x.iter().map(|x: &f64| 0.3 * x.max(0.0).powf(1.5)).collect();
            let celsius = time.iter().map(|t| 20.0 + 0.01 * t).collect();
            let column = |name: &str, values| Column { name: name.into(), values };
            let columns =
                vec![column(DISPLACEMENT, x), column(FORCE, force), column(TEMPERATURE, celsius)];
            Trace { time, columns, ..Trace::default() }
        };
        vec![press(4.0), press(2.0)]
    }

    #[test]
    fn means_are_as_many_at_any_rate_and_know_what_effects_see() {
        let count = |rate: f64| {
            let traces = traces(rate);
            let data = Data::of(&traces, FORCE).unwrap();
            let means = Means::of(&data, Some(0.01)).unwrap();
            let few = means.data(&data);
            let scene = few.scene(&few.pieces[0]);
            let lengths =
                [scene.velocity.len(), scene.largest.len(), scene.warmth.as_ref().unwrap().len()];
            assert!(lengths.iter().all(|length| *length == scene.len()));
            // Pressing at 4 mm/s.
            assert!(scene.velocity.iter().any(|v| (v - 4.0).abs() < 1e-6));
            means.len()
        };
        let (slow, fast) = (count(100.0), count(1000.0));
        assert!(fast < 2 * slow, "{fast} for {slow}");
    }

    #[test]
    fn a_jump_beside_a_block_is_no_scatter_within_it() {
        // A damper lets its whole force go when a motion turns round.
        let course = |t: f64| if t < 30.0 { 4.0 } else { 4.0 - 0.2 * (t - 30.0) };
        let time: Vec<f64> = (0..4500).map(|k| f64::from(k) / 100.0).collect();
        let x: Vec<f64> = time.iter().map(|t| course(*t)).collect();
        let force = time.iter().map(|t| if *t < 30.0 { 2.0 } else { 1.0 }).collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        let columns = vec![column(DISPLACEMENT, x), column(FORCE, force)];
        let traces = [Trace { time, columns, ..Trace::default() }];
        let data = Data::of(&traces, FORCE).unwrap();
        let means = Means::of(&data, Some(0.01)).unwrap();
        let scatter = means.stretches[0].scatter(&data.pieces[0]);
        assert!(scatter.iter().all(|value| value.abs() < 1e-12));
    }

    #[test]
    fn short_sets_stay_as_they_are() {
        let traces = traces(40.0);
        let data = Data::of(&traces, FORCE).unwrap();
        assert!(Means::of(&data, Some(0.01)).is_none());
        assert!(Means::of(&data, None).is_none());
    }
}
