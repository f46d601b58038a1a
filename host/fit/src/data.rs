//! Measurements as a fit takes them: motions with the signal that answered.

use std::borrow::Cow;
use std::sync::OnceLock;

use palpate_model::Laws;
use palpate_model::effects::{Effects, Scales, Setting};
use palpate_model::{
    Channel, Gauge, GaugeError, Model, Motion, MotionError, Past, Scene, Separation, Span,
};
use palpate_trace::{
    FORCE, GAUGES, SignalError, TANGENTIAL, TEMPERATURE, Trace, elapsed, motion_noise, ordered_by,
    repeats, runs,
};

use super::line::{Line, line_near};
use super::slope::{acceleration, slope, velocity};

/// One stretch of recording without a gap, with its motion.
#[derive(Clone, Debug)]
pub struct Piece<'a> {
    /// Which trace of the set it is from.
    pub trace: usize,
    /// What was done, over the time since the trace began, s.
    pub motion: Motion<'a>,
    /// What was measured at each sample.
    pub measured: &'a [f64],
    /// Whether that is the signal, sample by sample: no motion alone, and no means.
    is_signal: bool,
    /// Time of the trace's first sample, s.
    first: f64,
    /// When the trace began since the data set began, s.
    begin: f64,
    /// What the specimen has been through before.
    past: Past,
    /// Temperature at each sample, °C.
    temperature: Option<&'a [f64]>,
    /// The other channels at each sample.
    channels: Vec<Channel<'a>>,
    /// What follows from it without a model, once it was asked for.
    known: OnceLock<Known>,
}

/// What follows from a stretch and its past alone, at each sample.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
    pub loadings: Vec<f64>,
    pub largest: Vec<f64>,
    /// Temperature above the reference, K; absent where it was not recorded.
    pub warmth: Option<Vec<f64>>,
}

impl Piece<'_> {
    /// The same stretch with other samples of its motion and its signal, and nothing else recorded.
    pub(super) fn with_samples<'b>(&self, motion: Motion<'b>, measured: &'b [f64]) -> Piece<'b> {
        let Self { trace, first, begin, past, .. } = *self;
        Piece {
            trace,
            motion,
            measured,
            is_signal: false,
            first,
            begin,
            past,
            temperature: None,
            channels: vec![],
            known: OnceLock::new(),
        }
    }

    /// The same stretch with other samples of all that was recorded: its motion; signal, temperature and other channels; and
    /// what is known to follow from them.
    pub(super) fn with_means<'b>(
        &self,
        motion: Motion<'b>,
        (measured, temperature, channels): (&'b [f64], Option<&'b [f64]>, Vec<Channel<'b>>),
        known: Known,
    ) -> Piece<'b> {
        let known = OnceLock::from(known);
        Piece { temperature, channels, known, ..self.with_samples(motion, measured) }
    }

    /// Temperature at each sample, °C; none where it was not recorded.
    pub(super) const fn temperature(&self) -> Option<&[f64]> {
        self.temperature
    }

    /// The other channels at each sample.
    pub(super) fn channels(&self) -> &[Channel<'_>] {
        &self.channels
    }

    /// Time of each sample as it was recorded, s.
    #[must_use]
    pub fn recorded_time(&self) -> Vec<f64> {
        self.motion.time.iter().map(|time| self.first + time).collect()
    }

    /// Time of each sample since the data set began, s.
    #[must_use]
    pub fn set_time(&self) -> Vec<f64> {
        self.motion.time.iter().map(|time| self.begin + time).collect()
    }

    /// Loadings completed before the one at hand and largest displacement so far, mm, at each sample.
    pub(super) fn history(&self) -> (Vec<f64>, Vec<f64>) {
        let mut past = self.past;
        past.follow(&self.motion)
    }

    /// Velocity and all else that effects know of the stretch, temperature counted from `reference`, °C.
    pub(super) fn derive(&self, reference: Option<f64>) -> Known {
        let reference = reference.unwrap_or_default();
        let warmth = |values: &[f64]| values.iter().map(|value| value - reference).collect();
        let (loadings, largest) = self.history();
        let velocity = velocity(&self.motion);
        Known {
            acceleration: acceleration(&self.motion, &velocity),
            velocity,
            loadings,
            largest,
            warmth: self.temperature.map(warmth),
        }
    }
}

/// A data set: traces of one specimen in one set-up, in order of recording.
#[derive(Clone, Debug)]
pub struct Data<'a> {
    /// The column that is fitted.
    pub signal: String,
    /// Name of each trace.
    pub labels: Vec<String>,
    /// The stretches, in order of recording.
    pub pieces: Vec<Piece<'a>>,
    /// Stretches that were left out, in words.
    pub left_out: Vec<String>,
    /// How long each value of the signal stays, s, where it was recorded more slowly than the rows.
    pub signal_stays: Option<f64>,
    /// Temperature from which effects count it, °C: the mean of the set; none where a trace has no
    /// temperature.
    pub reference_temperature: Option<f64>,
    /// Columns of the other channels that every trace has: what could leak into the signal.
    pub channels: Vec<&'static str>,
    /// Whether there are several traces and neither their heads nor a common clock say in which order they were recorded.
    pub unordered: bool,
    /// The effects that can be tried on it.
    pub effects: Effects,
    /// The base laws that a model of it may name.
    pub laws: Laws,
    /// Displacement, mm, below which the specimen is loaded too: where it is bonded and moved to either side.
    pub(super) below: Option<f64>,
    pub(super) keeps: bool,
}

/// Samples up to which what follows from the motions is kept: some 60 MB.
const KEPT: usize = 1_500_000;
/// A value this many times what nine of ten are below stands far out.
const FAR_OUT: f64 = 100.0;

/// Parts of the largest displacement to the positive side: a motion to the negative side that is no scatter, and what still is rest.
const ON_PURPOSE: f64 = 0.05;
const AT_REST: f64 = 1e-3;
/// Part of the largest displacement that is surely on one side of the touch.
const ASIDE: f64 = 0.1;

/// Samples in which a hum is looked for.
const HEARD: usize = 200_000;

/// A trace on its way into a data set.
struct Part<'a> {
    index: usize,
    trace: &'a Trace,
    measured: &'a [f64],
    begin: f64,
}

/// Why traces cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum DataError {
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error(transparent)]
    Gauge(#[from] GaugeError),
    #[error("no trace reaches the specimen: displacement stays at or below 0")]
    NoContact,
    #[error(
        "{signal} is negative while the specimen is pressed (mean {mean:.3e}): compression counts as positive; turn the sign with `negate = true` in `palpate import`"
    )]
    Negative { signal: String, mean: f64 },
    #[error("the fit of {law} ends in numbers that are not finite{hint}")]
    NotFinite { law: String, hint: String },
    #[error("{samples} samples for {parameters} parameters: record more, or fit fewer terms")]
    TooFew { samples: usize, parameters: usize },
    #[error(
        "nothing left to fit: every stretch begins in contact after a gap, so what the specimen remembers is unknown"
    )]
    NothingLeft,
}

impl<'a> Data<'a> {
    /// Takes `signal` and the motion from the traces of a set, in order of recording.
    ///
    /// Nothing is interpolated across a gap: the stretch after it is taken as a recording of its own
    /// where it begins off the specimen, and left out where it begins in contact. A displacement whose noise the signal would show
    /// and does not follow is taken without it.
    ///
    /// # Errors
    /// When a trace lacks the signal or a motion or is constant, when no trace reaches the specimen, or
    /// the signal is negative in compression.
    pub fn of(traces: &'a [Trace], signal: &str) -> Result<Self, DataError> {
        let mut motions = Motion::of_set(traces)?;
        for own in motion_noise(traces, signal) {
            if let Some(smoothed) = own.smoothed(&traces[own.index]) {
                motions[own.index].displacement = smoothed.into();
            }
        }
        let mut data = Self::gather(traces, signal, &motions, |trace| trace.changing(signal))?;
        let stays = repeats(traces, signal).into_iter().map(|own| own.seconds);
        data.signal_stays = stays.reduce(f64::max);
        data.check_contact(signal)?;
        Ok(data)
    }

    /// Takes the motions alone, for a prediction of `signal`; what is measured is the displacement.
    ///
    /// # Errors
    /// When a trace lacks a motion.
    pub fn of_motions(traces: &'a [Trace], signal: &str) -> Result<Self, DataError> {
        let motions = Motion::of_set(traces)?;
        let measured = |trace: &'a Trace| Ok(trace.displacement().unwrap_or_default());
        let mut data = Self::gather(traces, signal, &motions, measured)?;
        data.pieces.iter_mut().for_each(|piece| piece.is_signal = false);
        Ok(data)
    }

    fn gather(
        traces: &'a [Trace],
        signal: &str,
        motions: &[Motion<'a>],
        measured: impl Fn(&'a Trace) -> Result<&'a [f64], SignalError>,
    ) -> Result<Self, DataError> {
        let begins = begins(traces);
        let mut data = Self {
            signal: signal.into(),
            labels: traces.iter().map(Trace::label).collect(),
            pieces: Vec::new(),
            left_out: Vec::new(),
            signal_stays: None,
            reference_temperature: mean_temperature(traces),
            channels: others(traces, signal),
            unordered: traces.len() > 1 && ordered_by(traces).is_none(),
            effects: Effects::library(),
            laws: Laws::library(),
            below: None,
            keeps: true,
        };
        let mut past = Past::default();
        for (index, (trace, motion)) in traces.iter().zip(motions).enumerate() {
            let part = Part { index, trace, measured: measured(trace)?, begin: begins[index] };
            data.add(&part, motion, &mut past);
        }
        if data.pieces.is_empty() {
            return Err(DataError::NothingLeft);
        }
        data.keeps = data.samples() <= KEPT;
        Ok(data)
    }

    /// The specimen is pressed somewhere, and pushes back.
    fn check_contact(&self, signal: &str) -> Result<(), DataError> {
        let (mut sum, mut count) = (0.0, 0.0);
        for piece in &self.pieces {
            for (&x, &value) in piece.motion.displacement.iter().zip(piece.measured) {
                if x > 0.0 {
                    sum += value;
                    count += 1.0;
                }
            }
        }
        if count == 0.0 {
            Err(DataError::NoContact)
        } else if sum < 0.0 {
            Err(DataError::Negative { signal: signal.into(), mean: sum / count })
        } else {
            Ok(())
        }
    }

    fn add(&mut self, part: &Part<'a>, motion: &Motion<'a>, past: &mut Past) {
        let Part { index, trace, measured, begin } = *part;
        let displacement = &motion.displacement;
        let elapsed = elapsed(&trace.time);
        let temperature = self.reference_temperature.and_then(|_| trace.column(TEMPERATURE));
        for (number, run) in runs(&trace.time).into_iter().enumerate() {
            if number > 0 && displacement[run.start] > 0.0 {
                self.left_out.push(format!(
                    "{}: from {:.3} s on, {} samples after a gap begin in contact, so what the specimen remembers is unknown; they are left out",
                    trace.label(),
                    trace.time[run.start],
                    run.len(),
                ));
                continue;
            }
            let time = match &elapsed {
                Cow::Borrowed(time) => time[run.clone()].into(),
                Cow::Owned(time) => time[run.clone()].to_vec().into(),
            };
            let motion = Motion {
                time,
                displacement: match displacement {
                    Cow::Borrowed(x) => x[run.clone()].into(),
                    Cow::Owned(x) => x[run.clone()].to_vec().into(),
                },
                rest_before: if number == 0 { motion.rest_before } else { None },
            };
            let before = *past;
            let _ = past.follow(&motion);
            let channel = |name: &&str| {
                let values = &trace.column(name)?[run.clone()];
                Some(Channel { values, slope: slope(&motion.time, values) })
            };
            let channels = self.channels.iter().filter_map(channel).collect();
            self.pieces.push(Piece {
                trace: index,
                motion,
                measured: &measured[run.clone()],
                is_signal: true,
                first: trace.time[0],
                begin,
                past: before,
                temperature: temperature.map(|values| &values[run.clone()]),
                channels,
                known: OnceLock::new(),
            });
        }
    }

    /// The traces of a data set as a model sees them: its signal, its reference temperature.
    ///
    /// # Errors
    /// When a trace lacks the signal or a motion, or is of a specimen of another gauge than the model's.
    pub fn of_model(model: &Model, traces: &'a [Trace]) -> Result<Self, DataError> {
        if let (Some(length_mm), Some(deformation)) =
            (model.base.gauge_length_mm, model.base.deformation)
        {
            Gauge { length_mm, deformation }.check("the model", traces)?;
        }
        let data = Self::of(traces, &model.base.signal)?;
        let data = data.with_separation(model.base.separation);
        Ok(data.with_reference(model.reference_temperature))
    }

    /// This data set of a specimen that is bonded or not: a bonded one is loaded also to the negative side, where it is moved there on
    /// purpose.
    #[must_use]
    pub fn with_separation(mut self, separation: Separation) -> Self {
        self.below = None;
        if separation == Separation::Bonded {
            let all = self.pieces.iter().flat_map(|piece| piece.motion.displacement.iter());
            let lowest = all.copied().fold(0.0, f64::min);
            let largest = self.largest_compression();
            let either = -lowest > ON_PURPOSE * largest;
            self.below = either.then_some(-AT_REST * largest.max(-lowest));
        }
        self
    }

    /// Whether a displacement, mm, loads the specimen.
    #[must_use]
    pub fn loads(&self, x: f64) -> bool {
        x > 0.0 || self.below.is_some_and(|below| x < below)
    }

    /// The first sample of a stretch in which the specimen is loaded.
    #[must_use]
    pub fn touch(&self, piece: &Piece) -> Option<usize> {
        piece.motion.displacement.iter().position(|&x| self.loads(x))
    }

    /// This data set with these effects to be tried, which a model of it may name.
    #[must_use]
    pub fn with_effects(mut self, effects: &Effects) -> Self {
        self.effects = effects.clone();
        self
    }

    /// This data set with base laws beside those of the library, which a model of it may name.
    #[must_use]
    pub fn with_laws(mut self, laws: &Laws) -> Self {
        self.laws = laws.clone();
        self
    }

    /// This data set with another signal, stretch by stretch.
    #[must_use]
    pub fn with_measured<'b>(&'b self, measured: &'b [Vec<f64>]) -> Data<'b> {
        let mut data: Data<'b> = self.clone();
        for (piece, measured) in data.pieces.iter_mut().zip(measured) {
            piece.measured = measured;
        }
        data
    }

    /// This data set with the temperature counted from this one, °C, where it is given.
    #[must_use]
    pub fn with_reference(mut self, temperature: Option<f64>) -> Self {
        if self.reference_temperature.is_some() && temperature.is_some() {
            self.reference_temperature = temperature;
            self.pieces.iter_mut().for_each(|piece| piece.known = OnceLock::new());
        }
        self
    }

    /// What effects need to know of this data set.
    #[must_use]
    pub fn setting(&self) -> Setting {
        let (traces, channels) = (self.labels.clone(), self.channels.clone());
        let mut scales = self.scales();
        let heard = self.heard();
        let lines = [50.0, 60.0].map(|mains| (mains, line_near(&heard, mains)));
        let found = lines.iter().filter_map(|(_, line)| *line);
        if let Some(strongest) = found.max_by(|a, b| a.over.total_cmp(&b.over)) {
            let frequency =
                |(mains, line): (f64, Option<Line>)| line.map_or(mains, |it| it.frequency);
            scales.mains = Some(lines.map(frequency));
            scales.line = Some(strongest.frequency);
        }
        let channel_ranges = (0..channels.len()).map(|place| self.channel_range(place)).collect();
        let (effects, laws) = (self.effects.clone(), self.laws.clone());
        Setting { scales, traces, channels, channel_ranges, effects, laws }
    }

    /// Largest less smallest value of another channel, in its unit.
    fn channel_range(&self, place: usize) -> f64 {
        let channels = self.pieces.iter().filter_map(|piece| piece.channels.get(place));
        let values = channels.flat_map(|channel| channel.values.iter().copied());
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| {
            (least.min(v), most.max(v))
        });
        (most - least).max(0.0)
    }

    /// Interval between samples that nine of ten do not exceed, s.
    fn common_interval(&self) -> f64 {
        let times = self.pieces.iter().map(|piece| &piece.motion.time);
        let mut intervals: Vec<f64> =
            times.flat_map(|time| time.windows(2).map(|pair| pair[1] - pair[0])).collect();
        let place = intervals.len() * 9 / 10;
        if intervals.is_empty() {
            return 0.0;
        }
        let last = intervals.len() - 1;
        *intervals.select_nth_unstable_by(place.min(last), f64::total_cmp).1
    }

    /// Time since the data set began, s, and the signal, as much as it takes to find a hum.
    fn heard(&self) -> Vec<(Vec<f64>, &[f64])> {
        let mut samples = 0;
        let enough = |piece: &&Piece| {
            samples += piece.measured.len();
            samples <= HEARD.max(piece.measured.len())
        };
        let timed = |piece: &Piece<'a>| (piece.set_time(), piece.measured);
        self.pieces.iter().take_while(enough).map(timed).collect()
    }

    /// Whether what follows from the traces alone is kept once it is known; a longer data set derives it anew each time.
    #[must_use]
    pub const fn keeps(&self) -> bool {
        self.keeps
    }

    /// What follows from a stretch without a model, where it is kept.
    pub(super) fn known<'b>(&self, piece: &'b Piece) -> Option<&'b Known> {
        self.keeps.then(|| piece.known.get_or_init(|| piece.derive(self.reference_temperature)))
    }

    /// Everything that is known at every sample of a stretch without a model.
    #[must_use]
    pub fn scene<'b>(&self, piece: &'b Piece<'a>) -> Scene<'b> {
        let bare = Scene {
            trace: piece.trace,
            motion: &piece.motion,
            since: (&piece.motion.time[..]).into(),
            begin: piece.begin,
            velocity: Cow::default(),
            acceleration: Cow::default(),
            loadings: Cow::default(),
            largest: Cow::default(),
            warmth: None,
            channels: &piece.channels,
            measured: if piece.is_signal { piece.measured } else { &[] },
        };
        if let Some(known) = self.known(piece) {
            Scene {
                velocity: (&known.velocity).into(),
                acceleration: (&known.acceleration).into(),
                loadings: (&known.loadings).into(),
                largest: (&known.largest).into(),
                warmth: known.warmth.as_deref().map(Cow::from),
                ..bare
            }
        } else {
            let known = piece.derive(self.reference_temperature);
            Scene {
                velocity: known.velocity.into(),
                acceleration: known.acceleration.into(),
                loadings: known.loadings.into(),
                largest: known.largest.into(),
                warmth: known.warmth.map(Cow::from),
                ..bare
            }
        }
    }

    /// The sizes of what happens in this data set, from which effects take theirs.
    #[must_use]
    pub fn scales(&self) -> Scales {
        let mut scales = Scales {
            has_temperature: self.reference_temperature.is_some(),
            unordered: self.unordered,
            compression: self.largest_compression(),
            duration: self.longest(),
            interval: self.shortest_interval(),
            common_interval: self.common_interval(),
            ..Scales::default()
        };
        let mut end = f64::NEG_INFINITY;
        for piece in &self.pieces {
            let scene = self.scene(piece);
            let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            scales.force = scales.force.max(most(piece.measured));
            let least = piece.motion.displacement.iter().copied().fold(0.0, f64::min);
            scales.parting = scales.parting.max(-least);
            scales.speed = scales.speed.max(most(&scene.velocity));
            scales.acceleration = scales.acceleration.max(most(&scene.acceleration));
            scales.loadings = scales.loadings.max(most(&scene.loadings));
            scales.warmth = scales.warmth.max(scene.warmth.as_deref().map_or(0.0, most));
            end = end.max(scene.set_time(scene.len() - 1));
        }
        scales.set_duration = end.max(scales.duration);
        scales
    }

    /// Time from the beginning of the data set to the middle of each trace, s.
    #[must_use]
    pub fn middles(&self) -> Vec<f64> {
        let middle = |trace: usize| {
            let own = self.pieces.iter().filter(|piece| piece.trace == trace);
            let ends = own.flat_map(|piece| {
                let time = &piece.motion.time;
                let since = |time: &f64| piece.begin + time;
                time.first().into_iter().chain(time.last()).map(since).collect::<Vec<_>>()
            });
            let (least, most) = ends
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), t| {
                    (least.min(t), most.max(t))
                });
            if least <= most { 0.5 * (least + most) } else { 0.0 }
        };
        (0..self.labels.len()).map(middle).collect()
    }

    /// The largest value in words where it stands far out of all others.
    #[must_use]
    pub fn outlier(&self) -> Option<String> {
        let mut sizes: Vec<f64> =
            self.pieces.iter().flat_map(|piece| piece.measured).map(|value| value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let usual = *sizes.get(sizes.len() * 9 / 10)?;
        let largest = *sizes.last()?;
        if largest < FAR_OUT * usual {
            return None;
        }
        self.pieces.iter().find_map(|piece| {
            let place = piece.measured.iter().position(|value| value.abs() == largest)?;
            Some(format!(
                ": {} has {} = {:.3e} at {:.3} s, where nine of ten values are below {usual:.3e}: correct that row or take it out",
                self.labels[piece.trace],
                self.signal,
                piece.measured[place],
                piece.first + piece.motion.time[place],
            ))
        })
    }

    /// Times, s, over which what the specimen remembers counts.
    #[must_use]
    pub fn span(&self) -> Span {
        let end = |piece: &Piece| piece.begin + piece.motion.time.last().unwrap_or(&0.0);
        let end = self.pieces.iter().map(end).fold(0.0, f64::max);
        Span::of(self.shortest_interval(), end.max(self.longest()))
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.pieces.iter().map(|piece| piece.measured.len()).sum()
    }

    /// Largest compression of the set, mm.
    #[must_use]
    pub fn largest_compression(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.motion.largest_compression()).fold(0.0, f64::max)
    }

    /// Displacement, mm, that is surely on one side of the touch: a tenth of the largest.
    #[must_use]
    pub fn aside(&self) -> f64 {
        ASIDE * self.largest_compression()
    }

    /// Displacement, mm, off the specimen up to which it tells anything: as far as the specimen is compressed at most. A tool may go many
    /// times as far, and the range in which something happens would be the smaller for it.
    #[must_use]
    pub fn farthest_off(&self) -> f64 {
        match self.largest_compression() {
            largest if largest > 0.0 && self.below.is_none() => -largest,
            _ => f64::NEG_INFINITY,
        }
    }

    /// Longest stretch, s.
    #[must_use]
    pub fn longest(&self) -> f64 {
        let duration = |piece: &Piece| {
            let time = &piece.motion.time;
            time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first)
        };
        self.pieces.iter().map(duration).fold(0.0, f64::max)
    }

    /// Shortest interval between samples, s.
    #[must_use]
    pub fn shortest_interval(&self) -> f64 {
        let intervals = |piece: &Piece| {
            piece.motion.time.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
        };
        self.pieces.iter().map(intervals).fold(f64::INFINITY, f64::min)
    }
}

/// When each trace began since the first, s: as the heads say, else one after the other.
fn begins(traces: &[Trace]) -> Vec<f64> {
    let told: Option<Vec<f64>> = traces.iter().map(|trace| trace.head.setup.start_s).collect();
    told.unwrap_or_else(|| {
        let ends = traces.iter().scan(0.0, |end, trace| {
            let begin = *end;
            *end += trace.duration();
            Some(begin)
        });
        ends.collect()
    })
}

/// Mean temperature over all samples of a set, °C; none where a trace has none.
fn mean_temperature(traces: &[Trace]) -> Option<f64> {
    let columns: Vec<&[f64]> =
        traces.iter().map(|trace| trace.column(TEMPERATURE)).collect::<Option<_>>()?;
    let count: usize = columns.iter().map(|values| values.len()).sum();
    let sum: f64 = columns.iter().map(|values| values.iter().sum::<f64>()).sum();
    (count > 0).then(|| sum / count as f64)
}

/// Channels beside the signal that every trace has: gauges beside a gauge, the tangential force beside
/// the force.
fn others(traces: &[Trace], signal: &str) -> Vec<&'static str> {
    let candidates: &[&'static str] = match signal {
        FORCE => &[TANGENTIAL],
        gauge if GAUGES.contains(&gauge) => &GAUGES,
        _ => &[],
    };
    let everywhere =
        |name: &&&str| **name != signal && traces.iter().all(|trace| trace.changing(name).is_ok());
    candidates.iter().filter(everywhere).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::{Column, DISPLACEMENT, FORCE};

    /// A trace over whole seconds.
    fn trace(time: &[f64], displacement: &[f64], force: &[f64]) -> Trace {
        let column =
            |name: &str, values: &[f64]| Column { name: name.into(), values: values.into() };
        Trace {
            time: time.into(),
            columns: vec![column(DISPLACEMENT, displacement), column(FORCE, force)],
            ..Trace::default()
        }
    }

    const TIMES: [f64; 9] = [0.0, 1.0, 2.0, 3.0, 4.0, 50.0, 51.0, 52.0, 53.0];

    #[test]
    fn a_stretch_after_a_gap_counts_where_it_begins_off_the_specimen() {
        let press = [0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0, 1.0];
        let traces = [trace(&TIMES, &press, &press)];
        let data = Data::of(&traces, FORCE).unwrap();
        assert_eq!((data.pieces.len(), data.samples()), (2, 9));
        assert!(data.left_out.is_empty());
        let held = [0.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0, 0.0];
        let traces = [trace(&TIMES, &held, &held)];
        let data = Data::of(&traces, FORCE).unwrap();
        assert_eq!((data.pieces.len(), data.samples()), (1, 5));
        assert!(data.left_out[0].contains("4 samples after a gap"), "{:?}", data.left_out);
    }

    #[test]
    fn a_stroke_without_contact_is_welcome_beside_others_but_not_alone() {
        let (time, press) = (&TIMES[..5], [0.0, 1.0, 2.0, 1.0, 0.0]);
        let stroke = trace(time, &[-3.0, -2.0, -1.0, -2.0, -3.0], &[0.0, 0.1, 0.0, 0.0, 0.1]);
        let pressed = trace(time, &press, &press);
        assert!(Data::of(&[stroke.clone(), pressed], FORCE).is_ok());
        assert!(matches!(Data::of(&[stroke], FORCE), Err(DataError::NoContact)));
    }

    #[test]
    fn a_force_of_the_wrong_sign_is_told_not_fitted() {
        let press = [0.0, 1.0, 2.0, 1.0, 0.0];
        let pull = press.map(|force| -force);
        let traces = [trace(&TIMES[..5], &press, &pull)];
        let found = Data::of(&traces, FORCE);
        assert!(matches!(found, Err(DataError::Negative { .. })));
    }
}
