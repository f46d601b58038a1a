//! Samples in blocks: each whole in itself, so that one that is lost costs its own rows and no others.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::differences::{CodingError, Gauges};
use super::per_gauge::FOUR;
use super::rows::{Coded, Coder, PAIR};
use super::{BlockOfFour, Columns, FRAME_MAX, FrameError, Head, ToHost, encode};
use crate::calibration::Calibration;
use crate::flags::Flags;
use crate::phase::{Region, RelaxationType};
use crate::pipeline::{GAUGES, Output, Pipeline};

/// Temperature at which a calibration is applied where none is measured, 2^-8 °C.
pub const REFERENCE_TEMPERATURE: i16 = 25 * 256;
/// Room for packed rows in a frame: what its head, its sum and the longest of the other fields of [`Block`] leave.
const PACKED: usize = 213;

/// Some rows as they travel; device time of the first is in the head of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Block<'a> {
    /// Gauges of each row.
    pub gauges: u8,
    /// Number of the first row since the start of the stream; a gap means rows that were lost.
    pub first: u64,
    /// Which settings made it: grows by one with every change.
    pub generation: u32,
    /// Temperature at the first row, 2^-8 °C; none without a sensor.
    pub temperature: Option<i16>,
    /// What each row holds.
    pub columns: Columns,
    /// The rows, one after the other, as the table in the module `rows` says. SA is not sent: it is
    /// the calibrated strain of the counts less FA, bit for bit, and [`Rows::iter`] gives it.
    #[serde(borrow, with = "serde_bytes")]
    pub packed: &'a [u8],
}

/// Region, type of relaxation and warnings of one gauge in one row; one byte on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowState {
    /// Region of the grasp.
    pub region: Region,
    /// Type of relaxation.
    pub relaxation: RelaxationType,
    /// Warnings.
    pub flags: Flags,
}

impl Output {
    /// Region, type of relaxation and warnings.
    #[must_use]
    pub const fn state(&self) -> RowState {
        RowState { region: self.region, relaxation: self.relaxation, flags: self.flags }
    }
}

impl RowState {
    /// Bits 0 to 2 the region in order of [`Region`], 3 and 4 the type of relaxation, 5 to 7 the flags.
    #[must_use]
    pub const fn byte(self) -> u8 {
        self.region as u8 | (self.relaxation as u8) << 3 | self.flags.bits() << 5
    }

    /// From its byte; numbers without a meaning are taken as rest and none.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Self {
        let region = match byte & 7 {
            1 => Region::Preloading,
            2 => Region::Loading,
            3 => Region::Transition,
            4 => Region::Relaxation,
            5 => Region::Unloading,
            6 => Region::Recovery,
            _ => Region::Rest,
        };
        let relaxation = match byte >> 3 & 3 {
            1 => RelaxationType::TypeI,
            2 => RelaxationType::TypeII,
            _ => RelaxationType::None,
        };
        Self { region, relaxation, flags: Flags::from_bits(byte >> 5) }
    }
}

/// One row as it was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Number since the start of the stream.
    pub number: u64,
    /// Device time, µs.
    pub time_us: u64,
    /// Raw counts.
    pub counts: Gauges,
    /// Fast adapting part, LSB.
    pub fa: Gauges,
    /// Slow adapting part, LSB; FA + SA is the strain.
    pub sa: Gauges,
    /// Elastic input and equilibrium, LSB, if asked for.
    pub rest: Option<(Gauges, Gauges)>,
    /// Regions and warnings.
    pub states: [RowState; GAUGES],
    /// Where a region was found at this row: how many samples ago it was entered.
    pub entered: [Option<u32>; GAUGES],
}

/// What knows the outputs of a row. A pipeline computes only those that are looked at.
pub trait Made {
    /// What was made of the counts, gauge by gauge.
    fn outputs(&self) -> [Output; GAUGES];

    /// Whether a region was found at this row, or its states may be others than those of the row before.
    fn is_news(&self) -> bool {
        true
    }
}

impl Made for Pipeline {
    #[inline(always)]
    fn outputs(&self) -> [Output; GAUGES] {
        Pipeline::outputs(self)
    }

    #[inline(always)]
    fn is_news(&self) -> bool {
        Pipeline::is_news(self)
    }
}

impl Made for [Output; GAUGES] {
    fn outputs(&self) -> [Output; GAUGES] {
        *self
    }
}

/// Consecutive rows, on their way into a frame or out of one; they are packed as they come.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Number of the first row.
    pub first: u64,
    /// Device time of the first row, µs.
    pub time_us: u64,
    /// Which settings made them.
    pub generation: u32,
    /// Temperature at the first row, 2^-8 °C.
    pub temperature: Option<i16>,
    count: usize,
    /// Device time of the last row, µs; its lower half.
    last_us: u32,
    coder: Coder,
    /// Bytes that are packed.
    length: usize,
    packed: [u8; PACKED + PAIR],
}

impl Rows {
    /// None yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            first: 0,
            time_us: 0,
            generation: 0,
            temperature: None,
            count: 0,
            last_us: 0,
            coder: Coder::new(Columns::Parts, GAUGES as u8),
            length: 0,
            packed: [0; PACKED + PAIR],
        }
    }

    /// Forgets the rows and begins again with a row of this number and time, and the time of the row before it.
    pub const fn begin(&mut self, columns: Columns, first: u64, time_us: u64, last_us: u64) {
        (self.first, self.time_us) = (first, time_us);
        (self.last_us, self.coder) = (last_us as u32, Coder::new(columns, self.coder.gauges));
        self.clear();
    }

    /// Forgets the rows; those to come are of the first so many gauges, at most as many as a pipeline has.
    pub const fn set_gauges(&mut self, gauges: u8) {
        self.clear();
        self.coder.gauges = gauges;
    }

    /// Forgets the rows.
    pub const fn clear(&mut self) {
        (self.count, self.length) = (0, 0);
    }

    /// How many rows there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Device time of the last row, µs. A block spans less than an hour.
    #[must_use]
    pub const fn last_us(&self) -> u64 {
        self.time_us.wrapping_add(self.span_us() as u64)
    }

    /// Time from the first row to the last, µs.
    #[must_use]
    pub const fn span_us(&self) -> u32 {
        self.last_us.wrapping_sub(self.time_us as u32)
    }

    /// Appends the next row, counts and what was made of them. If it does not fit, `false`; then none may follow before
    /// [`Self::begin`], after which the first always fits.
    #[inline(always)]
    #[must_use]
    pub fn push(&mut self, time_us: u64, counts: &Gauges, made: &impl Made) -> bool {
        let interval = (time_us as u32).wrapping_sub(self.last_us);
        let Some(room) = self.packed.get_mut(self.length..) else { return false };
        let Some(bytes) = self.coder.put(interval, counts, made, room) else { return false };
        let length = self.length.wrapping_add(bytes);
        if length > PACKED {
            return false;
        }
        self.length = length;
        self.last_us = time_us as u32;
        self.count = self.count.wrapping_add(1);
        true
    }

    /// Puts the rows into a frame.
    ///
    /// # Errors
    /// [`FrameError::TooLong`] if they do not fit; no block is that long.
    pub fn encode<'f>(
        &self,
        sequence: u32,
        frame: &'f mut [u8; FRAME_MAX],
    ) -> Result<&'f [u8], FrameError> {
        let block = Block {
            gauges: self.coder.gauges,
            first: self.first,
            generation: self.generation,
            temperature: self.temperature,
            columns: self.coder.columns,
            packed: self.bytes(),
        };
        encode(Head { sequence, time_us: self.time_us }, &ToHost::Samples(block), frame)
    }

    /// The same for a host of release 0.1, which takes every row for one of four gauges.
    ///
    /// # Errors
    /// As [`Self::encode`]; [`FrameError::Message`] if they are of another number of gauges.
    pub fn encode_of_four<'f>(
        &self,
        sequence: u32,
        frame: &'f mut [u8; FRAME_MAX],
    ) -> Result<&'f [u8], FrameError> {
        if usize::from(self.coder.gauges) != FOUR {
            return Err(FrameError::Message);
        }
        let block = BlockOfFour {
            first: self.first,
            generation: self.generation,
            temperature: self.temperature,
            columns: self.coder.columns,
            packed: self.bytes(),
        };
        encode(Head { sequence, time_us: self.time_us }, &ToHost::SamplesOfFour(block), frame)
    }

    /// The rows of a block whose frame had this head.
    ///
    /// # Errors
    /// [`CodingError`] if the block contradicts itself.
    pub fn decode(head: Head, block: &Block<'_>) -> Result<Self, CodingError> {
        if usize::from(block.gauges) > GAUGES {
            return Err(CodingError);
        }
        let mut rows = Self::new();
        rows.set_gauges(block.gauges);
        rows.begin(block.columns, block.first, head.time_us, head.time_us);
        (rows.generation, rows.temperature) = (block.generation, block.temperature);
        let place = rows.packed.get_mut(..block.packed.len()).ok_or(CodingError)?;
        place.copy_from_slice(block.packed);
        rows.length = block.packed.len();
        let (mut left, mut coder) = (block.packed, Coder::new(block.columns, block.gauges));
        while !left.is_empty() {
            let coded;
            (coded, left) = coder.take(left)?;
            if rows.count > 0 {
                rows.last_us = rows.last_us.wrapping_add(coded.interval);
            }
            rows.count = rows.count.wrapping_add(1);
        }
        Ok(rows)
    }

    /// The rows one by one, with the calibration of the settings that made them ([`Self::generation`]).
    pub fn iter(&self, calibration: &[Calibration; GAUGES]) -> impl Iterator<Item = Row> {
        let temperature = self.temperature.unwrap_or(REFERENCE_TEMPERATURE);
        let (mut next, mut time_us) = (self.first, self.time_us);
        self.coded().map(move |coded| {
            let number = next;
            next = next.wrapping_add(1);
            if number != self.first {
                time_us = time_us.wrapping_add(coded.interval.into());
            }
            let (counts, fa) = coded.parts;
            let mut sa = fa;
            let there = sa.iter_mut().take(self.coder.gauges.into());
            for ((sa, counts), calibration) in there.zip(counts).zip(calibration) {
                *sa = calibration.apply(counts, temperature).strain.wrapping_sub(*sa);
            }
            Row {
                number,
                time_us,
                counts,
                fa,
                sa,
                rest: (self.coder.columns == Columns::All).then_some(coded.rest),
                states: coded.states.map(RowState::from_byte),
                entered: coded.entered,
            }
        })
    }

    fn bytes(&self) -> &[u8] {
        self.packed.get(..self.length).unwrap_or_default()
    }

    fn coded(&self) -> impl Iterator<Item = Coded> {
        let (mut left, mut coder) =
            (self.bytes(), Coder::new(self.coder.columns, self.coder.gauges));
        core::iter::from_fn(move || {
            let coded;
            (coded, left) = coder.take(left).ok()?;
            Some(coded)
        })
    }
}

/// The same rows; what is behind them does not count.
impl PartialEq for Rows {
    fn eq(&self, other: &Self) -> bool {
        let fields = |rows: &Self| {
            let Coder { columns, gauges, .. } = rows.coder;
            (rows.first, rows.time_us, rows.generation, rows.temperature, columns, gauges)
        };
        fields(self) == fields(other) && self.bytes() == other.bytes()
    }
}

impl Default for Rows {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::Pipeline;
    use crate::wire::{Accumulated, Accumulator, Settings, decode};
    use proptest::prelude::*;

    fn calibration() -> [Calibration; GAUGES] {
        Settings::DEFAULT.config(1e-3).unwrap().calibration
    }

    /// What a frame of these rows says, and its length.
    fn through_the_line(rows: &Rows) -> (Vec<Row>, usize) {
        let mut line = Accumulator::new();
        let mut frame = [0; FRAME_MAX];
        let sent = rows.encode(7, &mut frame).unwrap();
        for byte in sent {
            if let Accumulated::Frame(bytes) = line.push(*byte) {
                let (head, message) = decode(bytes).unwrap();
                let ToHost::Samples(block) = message else { panic!("{message:?}") };
                let heard = Rows::decode(head, &block).unwrap();
                assert_eq!((heard.len(), heard.span_us()), (rows.len(), rows.span_us()));
                return (heard.iter(&calibration()).collect(), sent.len());
            }
        }
        panic!("no frame")
    }

    #[test]
    fn a_press_is_sent_whole_in_less_than_twenty_bytes_a_row() {
        let config = Settings::DEFAULT.config(1.024e-3).unwrap();
        let mut pipeline = Pipeline::new(&config);
        let (mut sent, mut bytes) = (0, 0);
        let mut noise = 1_u32;
        for block in 0..200_u64 {
            let mut rows = Rows::new();
            let start = block * 12 * 1_024 + 1;
            rows.begin(Columns::Parts, block * 12, start, start.saturating_sub(1_024));
            for row in 0..12 {
                let t = (block * 12 + row) as f64 * 1.024e-3;
                let press = 2e6 * (t.clamp(0.5, 1.0) - 0.5) - 1e6 * (t.clamp(2.0, 2.5) - 2.0);
                let counts = [1, 2, 3, 4].map(|gauge| {
                    noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (press / f64::from(gauge)) as i32 + (noise >> 24) as i32
                });
                let time = (block * 12 + row) * 1_024 + u64::from(row % 5 == 0);
                pipeline.process(&counts, 0);
                assert!(rows.push(time, &counts, &pipeline));
            }
            let (heard, length) = through_the_line(&rows);
            (sent, bytes) = (sent + heard.len(), bytes + length);
        }
        assert!(bytes <= 20 * sent, "{} bytes a row", bytes as f64 / sent as f64);
    }

    #[test]
    fn a_state_is_one_byte_and_comes_back() {
        for byte in 0..=u8::MAX {
            let state = RowState::from_byte(byte);
            assert_eq!(RowState::from_byte(state.byte()), state);
        }
        let settled = RowState {
            region: Region::Recovery,
            relaxation: RelaxationType::TypeII,
            flags: Flags::FILTER_SATURATED,
        };
        assert_eq!(settled.byte(), 0b1001_0110);
    }

    fn any_output() -> impl Strategy<Value = Output> {
        let number = prop_oneof![-(1 << 24)..1 << 24, -1_000..1_000_i32, any::<i32>()];
        let entered = prop_oneof![9 => Just(None), 1 => (0..u32::MAX - 1).prop_map(Some)];
        (prop::array::uniform4(number), any::<u8>(), entered).prop_map(
            |(values, state, entered)| {
                let [strain, fa, elastic, equilibrium] = values;
                let RowState { region, relaxation, flags } = RowState::from_byte(state);
                Output {
                    strain,
                    fa,
                    elastic,
                    equilibrium,
                    region,
                    entered_samples_ago: entered,
                    relaxation,
                    flags,
                }
            },
        )
    }

    proptest! {
        #[test]
        fn whatever_the_rows_are_they_arrive_as_they_were(
            given in prop::collection::vec(
                (prop::array::uniform4(any::<i32>()), prop::array::uniform4(any_output()), 0..100_000_u64),
                1..=20,
            ),
            first in any::<u32>(),
            all in any::<bool>(),
            gauges in 1..=GAUGES,
        ) {
            let mut rows = Rows::new();
            rows.set_gauges(gauges as u8);
            let columns = if all { Columns::All } else { Columns::Parts };
            let (mut time, mut number) = (1_000_000, u64::from(first));
            rows.begin(columns, number, time + given[0].2, time);
            (rows.generation, rows.temperature) = (3, Some(-5));
            let mut heard = Vec::new();
            for (counts, outputs, interval) in &given {
                time += interval;
                if !rows.push(time, counts, outputs) {
                    heard.extend(through_the_line(&rows).0);
                    rows.begin(columns, number, time, time - interval);
                    prop_assert!(rows.push(time, counts, outputs));
                }
                number += 1;
            }
            heard.extend(through_the_line(&rows).0);
            prop_assert_eq!(heard.len(), given.len());
            let (mut time, mut number) = (1_000_000, u64::from(first));
            for (row, (counts, outputs, interval)) in heard.iter().zip(&given) {
                time += interval;
                prop_assert_eq!((row.number, row.time_us), (number, time));
                number += 1;
                prop_assert_eq!(&row.counts[..gauges], &counts[..gauges]);
                prop_assert!(row.counts[gauges..].iter().chain(&row.sa[gauges..]).all(|it| *it == 0));
                for (gauge, output) in outputs.iter().enumerate().take(gauges) {
                    prop_assert_eq!(row.fa[gauge], output.fa);
                    prop_assert_eq!(row.states[gauge], output.state());
                    prop_assert_eq!(row.entered[gauge], output.entered_samples_ago);
                    if let Some((elastic, equilibrium)) = row.rest {
                        prop_assert_eq!(elastic[gauge], output.elastic);
                        prop_assert_eq!(equilibrium[gauge], output.equilibrium);
                    }
                }
            }
        }

        #[test]
        fn no_block_panics(
            packed in prop::collection::vec(prop_oneof![0_u8..9, any::<u8>()], 0..250),
            gauges in any::<u8>(),
        ) {
            let block = Block {
                gauges, first: u64::MAX, generation: 0, temperature: None,
                columns: Columns::All, packed: &packed,
            };
            if let Ok(rows) = Rows::decode(Head::default(), &block) {
                rows.iter(&calibration()).for_each(drop);
            }
        }
    }
}
