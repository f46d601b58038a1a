//! Samples in blocks: each whole in itself, so that one that is lost costs its own rows and no others.

use core::ops::Range;

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::columns::{BLOCK_ROWS, CodingError, Column};
use super::{Columns, FRAME_MAX, FrameError, Head, ToHost, encode};
use crate::calibration::Calibration;
use crate::flags::Flags;
use crate::phase::{Region, RelaxationType};
use crate::pipeline::{GAUGES, Output, Pipeline};

/// Temperature at which a calibration is applied where none is measured, 2^-8 °C.
pub const REFERENCE_TEMPERATURE: i16 = 25 * 256;
/// Room for packed rows in a frame; the rest is for its head and the fields of [`Block`].
const PACKED: usize = 212;

/// Values of one kind, gauge by gauge.
type Gauges = [i32; GAUGES];

/// Some rows as they travel; device time of the first is in the head of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Block<'a> {
    /// Number of the first row since the start of the stream; a gap means rows that were lost.
    pub first: u64,
    /// Which settings made it: grows by one with every change.
    pub generation: u32,
    /// Temperature at the first row, 2^-8 °C; none without a sensor.
    pub temperature: Option<i16>,
    /// Rows, at most [`BLOCK_ROWS`].
    pub rows: u8,
    /// What each row holds.
    pub columns: Columns,
    /// Whether a region was found at any row.
    pub found_a_region: bool,
    /// Columns, as [`Column`] packs them: µs since the row before; states, one byte for each gauge; raw counts; FA; then, if
    /// asked for, elastic input and equilibrium; then, if a region was found, samples since it was entered plus one, or 0.
    /// SA is not sent: it is the calibrated strain of the counts less FA, bit for bit, and [`Rows::iter`] gives it.
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
}

impl Made for Pipeline {
    #[inline(always)]
    fn outputs(&self) -> [Output; GAUGES] {
        Pipeline::outputs(self)
    }
}

impl Made for [Output; GAUGES] {
    fn outputs(&self) -> [Output; GAUGES] {
        *self
    }
}

/// Consecutive rows, on their way into a frame or out of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rows {
    /// Number of the first row.
    pub first: u64,
    /// Device time of the first row, µs.
    pub time_us: u64,
    /// Which settings made them.
    pub generation: u32,
    /// Temperature at the first row, 2^-8 °C.
    pub temperature: Option<i16>,
    columns: Columns,
    count: usize,
    last_us: u64,
    found_a_region: bool,
    /// Time since the row before, µs.
    intervals: Column<1>,
    /// One byte for each gauge.
    states: Column<1>,
    counts: Column<GAUGES>,
    fa: Column<GAUGES>,
    elastic: Column<GAUGES>,
    equilibrium: Column<GAUGES>,
    /// Samples since a region was entered, plus one, where one is found; set for all rows as soon as one is.
    entered: Column<GAUGES>,
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
            columns: Columns::Parts,
            count: 0,
            last_us: 0,
            found_a_region: false,
            intervals: Column::new(),
            states: Column::new(),
            counts: Column::new(),
            fa: Column::new(),
            elastic: Column::new(),
            equilibrium: Column::new(),
            entered: Column::new(),
        }
    }

    /// Forgets the rows and begins again with a row of this number and time, and the time of the row before it.
    pub const fn begin(&mut self, columns: Columns, first: u64, time_us: u64, last_us: u64) {
        (self.first, self.time_us, self.last_us) = (first, time_us, last_us);
        (self.columns, self.count, self.found_a_region) = (columns, 0, false);
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

    /// Whether no more rows fit.
    #[must_use]
    pub const fn is_full(&self) -> bool {
        self.count >= BLOCK_ROWS
    }

    /// Time from the first row to the last, µs.
    #[must_use]
    pub const fn span_us(&self) -> u64 {
        self.last_us.wrapping_sub(self.time_us)
    }

    /// Appends the next row, counts and what was made of them; dropped if there is no room.
    #[inline]
    pub fn push(&mut self, time_us: u64, counts: Gauges, made: &impl Made) {
        let at = self.count;
        let outputs = made.outputs();
        let interval = [time_us.wrapping_sub(self.last_us) as i32];
        let states = [i32::from_le_bytes(outputs.map(|out| out.state().byte()))];
        let fa = outputs.map(|out| out.fa);
        if at == 0 {
            self.intervals.begin(interval);
            self.states.begin(states);
            self.counts.begin(counts);
            self.fa.begin(fa);
        } else {
            self.intervals.set(at, interval);
            self.states.set(at, states);
            self.counts.set(at, counts);
            self.fa.set(at, fa);
        }
        if self.columns == Columns::All {
            self.note_rest(at, made);
        }
        if self.found_a_region || outputs.iter().any(|out| out.entered_samples_ago.is_some()) {
            self.note_regions(at, made);
        }
        self.last_us = time_us;
        self.count = at.wrapping_add(1);
    }

    /// Beyond the values of every row, so that those cost no more than they must.
    #[cold]
    #[inline(never)]
    fn note_rest(&mut self, at: usize, made: &impl Made) {
        let outputs = made.outputs();
        let elastic = outputs.map(|out| out.elastic);
        let equilibrium = outputs.map(|out| out.equilibrium);
        if at == 0 {
            self.elastic.begin(elastic);
            self.equilibrium.begin(equilibrium);
        } else {
            self.elastic.set(at, elastic);
            self.equilibrium.set(at, equilibrium);
        }
    }

    #[cold]
    #[inline(never)]
    fn note_regions(&mut self, at: usize, made: &impl Made) {
        if !core::mem::replace(&mut self.found_a_region, true) {
            self.entered.begin([0; GAUGES]);
            for before in 1..at {
                self.entered.set(before, [0; GAUGES]);
            }
        }
        let code = |ago: u32| ago.saturating_add(1).cast_signed();
        let codes = made.outputs().map(|out| out.entered_samples_ago.map_or(0, code));
        if at == 0 { self.entered.begin(codes) } else { self.entered.set(at, codes) }
    }

    /// Puts the rows from `from` on into a frame, as many as fit; returns it and how many they are.
    ///
    /// # Errors
    /// [`FrameError::TooLong`] if not even one row fits; no row is that long.
    pub fn encode<'f>(
        &self,
        from: usize,
        sequence: u32,
        frame: &'f mut [u8; FRAME_MAX],
    ) -> Result<(&'f [u8], usize), FrameError> {
        let mut packed = [0; PACKED];
        let mut rows = from..self.count;
        loop {
            if let Some(block) = self.block(rows.clone(), &mut packed) {
                let head = Head { sequence, time_us: self.time_of(from) };
                return Ok((encode(head, &ToHost::Samples(block), frame)?, rows.len()));
            }
            // Three quarters of what was too much may fit.
            let fewer = rows.len().saturating_mul(3) / 4;
            if fewer == 0 {
                return Err(FrameError::TooLong);
            }
            rows.end = from.saturating_add(fewer);
        }
    }

    /// A block of the rows, if they fit.
    fn block<'b>(&self, rows: Range<usize>, packed: &'b mut [u8]) -> Option<Block<'b>> {
        let room = packed.len();
        let (_, left) = self.intervals.pack(rows.clone(), packed)?;
        let (_, left) = self.states.pack(rows.clone(), left)?;
        let (_, left) = self.counts.pack(rows.clone(), left)?;
        let (_, mut left) = self.fa.pack(rows.clone(), left)?;
        if self.columns == Columns::All {
            (_, left) = self.elastic.pack(rows.clone(), left)?;
            (_, left) = self.equilibrium.pack(rows.clone(), left)?;
        }
        if self.found_a_region {
            (_, left) = self.entered.pack(rows.clone(), left)?;
        }
        let length = room.checked_sub(left.len())?;
        Some(Block {
            first: self.first.saturating_add(rows.start as u64),
            generation: self.generation,
            temperature: self.temperature,
            rows: rows.len() as u8,
            columns: self.columns,
            found_a_region: self.found_a_region,
            packed: packed.get(..length)?,
        })
    }

    fn time_of(&self, row: usize) -> u64 {
        let later = self.intervals.iter().take(row.saturating_add(1)).skip(1);
        later.fold(self.time_us, |time, [interval]| after(time, interval))
    }

    /// The rows of a block whose frame had this head.
    ///
    /// # Errors
    /// [`CodingError`] if the block contradicts itself.
    pub fn decode(head: Head, block: &Block<'_>) -> Result<Self, CodingError> {
        let mut rows = Self::new();
        let count = usize::from(block.rows);
        rows.begin(block.columns, block.first, head.time_us, 0);
        (rows.generation, rows.temperature) = (block.generation, block.temperature);
        (rows.count, rows.found_a_region) = (count, block.found_a_region);
        let left = block.packed;
        let (intervals, left) = Column::unpack(left, count)?;
        let (states, left) = Column::unpack(left, count)?;
        let (counts, left) = Column::unpack(left, count)?;
        let (fa, mut left) = Column::unpack(left, count)?;
        (rows.intervals, rows.states) = (intervals, states);
        (rows.counts, rows.fa) = (counts, fa);
        if block.columns == Columns::All {
            (rows.elastic, left) = Column::unpack(left, count)?;
            (rows.equilibrium, left) = Column::unpack(left, count)?;
        }
        if block.found_a_region {
            (rows.entered, left) = Column::unpack(left, count)?;
        }
        rows.last_us = rows.time_of(count.saturating_sub(1));
        if left.is_empty() { Ok(rows) } else { Err(CodingError::Length) }
    }

    /// The rows one by one, with the calibration of the settings that made them ([`Self::generation`]).
    pub fn iter(&self, calibration: &[Calibration; GAUGES]) -> impl Iterator<Item = Row> {
        let temperature = self.temperature.unwrap_or(REFERENCE_TEMPERATURE);
        let parts = self.counts.iter().zip(self.fa.iter());
        let rest = self.elastic.iter().zip(self.equilibrium.iter()).zip(self.entered.iter());
        let course = self.intervals.iter().zip(self.states.iter());
        let mut time_us = self.time_us;
        (self.first..).zip(course.zip(parts).zip(rest)).take(self.count).map(
            move |(number, ((([interval], [states]), (counts, fa)), (rest, entered)))| {
                if number != self.first {
                    time_us = after(time_us, interval);
                }
                let ago = |code: i32| {
                    let found = self.found_a_region;
                    code.cast_unsigned().checked_sub(1).filter(|_| found)
                };
                let mut sa = fa;
                for ((sa, counts), calibration) in sa.iter_mut().zip(counts).zip(calibration) {
                    *sa = calibration.apply(counts, temperature).strain.wrapping_sub(*sa);
                }
                Row {
                    number,
                    time_us,
                    counts,
                    fa,
                    sa,
                    rest: (self.columns == Columns::All).then_some(rest),
                    states: states.to_le_bytes().map(RowState::from_byte),
                    entered: entered.map(ago),
                }
            },
        )
    }
}

impl Default for Rows {
    fn default() -> Self {
        Self::new()
    }
}

const fn after(time_us: u64, interval: i32) -> u64 {
    time_us.wrapping_add(interval.cast_unsigned() as u64)
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

    /// Everything that frames of these rows say, and how many frames it took.
    fn through_the_line(rows: &Rows) -> (Vec<Row>, usize) {
        let (mut heard, mut from, mut frames) = (Vec::new(), 0, 0);
        let mut line = Accumulator::new();
        while from < rows.len() {
            let mut frame = [0; FRAME_MAX];
            let (bytes, held) = rows.encode(from, 7, &mut frame).unwrap();
            for byte in bytes {
                if let Accumulated::Frame(bytes) = line.push(*byte) {
                    let (head, message) = decode(bytes).unwrap();
                    let ToHost::Samples(block) = message else { panic!("{message:?}") };
                    heard.extend(Rows::decode(head, &block).unwrap().iter(&calibration()));
                }
            }
            (from, frames) = (from + held, frames + 1);
        }
        (heard, frames)
    }

    #[test]
    fn a_press_is_sent_whole_in_less_than_thirty_bytes_a_row() {
        let config = Settings::DEFAULT.config(1.024e-3).unwrap();
        let mut pipeline = Pipeline::new(&config);
        let (mut sent, mut bytes, mut frame) = (0, 0, [0; FRAME_MAX]);
        let mut noise = 1_u32;
        for block in 0..200_u64 {
            let mut rows = Rows::new();
            let start = block * 16_384;
            rows.begin(Columns::Parts, block * 16, start, start.saturating_sub(1_024));
            for row in 0..16 {
                let t = (block * 16 + row) as f64 * 1.024e-3;
                let press = 2e6 * (t.clamp(0.5, 1.0) - 0.5) - 1e6 * (t.clamp(2.0, 2.5) - 2.0);
                let counts = [1, 2, 3, 4].map(|gauge| {
                    noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (press / f64::from(gauge)) as i32 + (noise >> 24) as i32
                });
                let time = (block * 16 + row) * 1_024 + u64::from(row % 5 == 0);
                pipeline.process(&counts, 0);
                rows.push(time, counts, &pipeline);
            }
            sent += rows.len();
            let mut from = 0;
            while from < rows.len() {
                let (framed, held) = rows.encode(from, 0, &mut frame).unwrap();
                (from, bytes) = (from + held, bytes + framed.len());
            }
        }
        assert!(bytes <= 30 * sent, "{} bytes a row", bytes / sent);
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
                1..=BLOCK_ROWS,
            ),
            first in any::<u32>(),
            all in any::<bool>(),
        ) {
            let mut rows = Rows::new();
            let mut time = 1_000_000;
            rows.begin(if all { Columns::All } else { Columns::Parts }, first.into(), time, 0);
            (rows.generation, rows.temperature) = (3, Some(-5));
            for (row, (counts, outputs, interval)) in given.iter().enumerate() {
                if row > 0 {
                    time += interval;
                }
                rows.push(time, *counts, outputs);
            }
            let (heard, _) = through_the_line(&rows);
            prop_assert_eq!(&heard, &rows.iter(&calibration()).collect::<Vec<_>>());
            for (row, (counts, outputs, _)) in heard.iter().zip(&given) {
                prop_assert_eq!(row.counts, *counts);
                for (gauge, output) in outputs.iter().enumerate() {
                    prop_assert_eq!(row.fa[gauge], output.fa);
                    prop_assert_eq!(row.entered[gauge], output.entered_samples_ago);
                    if let Some((elastic, equilibrium)) = row.rest {
                        prop_assert_eq!(elastic[gauge], output.elastic);
                        prop_assert_eq!(equilibrium[gauge], output.equilibrium);
                    }
                }
            }
            prop_assert_eq!(heard.last().map(|row| row.time_us), Some(time));
        }

        #[test]
        fn no_block_panics(
            rows: u8, found_a_region: bool, packed in prop::collection::vec(0_u8..9, 0..200),
        ) {
            let block = Block {
                first: u64::MAX, generation: 0, temperature: None, rows,
                columns: Columns::All, found_a_region, packed: &packed,
            };
            if let Ok(rows) = Rows::decode(Head::default(), &block) {
                rows.iter(&calibration()).for_each(drop);
            }
        }
    }
}
