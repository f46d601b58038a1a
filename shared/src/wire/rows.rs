//! One row after the other as bytes, each in terms of the one before.
//!
//! | bytes | what |
//! |-|-|
//! | 1 | head: bits 0 to 2 the class of the counts, 3 to 5 that of FA, 6 and 7 whether interval and news follow |
//! | … | counts, then FA, as [`Differences`] codes them |
//! | … | if asked for: a byte with the classes of elastic input and equilibrium, as in the head, then these |
//! | 1 … 5 | interval: µs since the row before, less what this was there, or less 0 in the first; zigzag, varint |
//! | n | news: states, one byte for each of the n gauges; without news, as in the row before |
//! | 1 | news: from bit 0 on, whether a region was found on each gauge |
//! | … | news: how many samples ago each of these was entered; varint |

use super::Columns;
use super::differences::{CodingError, Differences, Gauges, LONGEST, length};
use super::samples::Made;
use crate::pipeline::{GAUGES, Output};

const INTERVAL: u8 = 1 << 6;
const NEWS: u8 = 1 << 7;

/// What is remembered from row to row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coder {
    parts: Pair,
    rest: Pair,
    interval: u32,
    /// None before the first row.
    states: Option<[u8; GAUGES]>,
    /// Whether the next row has more than its parts in any case: the first one, and all if all columns are asked for.
    has_more: bool,
    pub(super) columns: Columns,
    /// Gauges of a row; the others read 0.
    pub(super) gauges: u8,
}

/// A row as it is coded, without its number.
pub(super) struct Coded {
    pub(super) interval: u32,
    pub(super) parts: (Gauges, Gauges),
    pub(super) rest: (Gauges, Gauges),
    pub(super) states: [u8; GAUGES],
    pub(super) entered: [Option<u32>; GAUGES],
}

impl Coder {
    /// Before the first row.
    pub(super) const fn new(columns: Columns, gauges: u8) -> Self {
        Self {
            parts: Pair::NEW,
            rest: Pair::NEW,
            interval: 0,
            states: None,
            has_more: true,
            columns,
            gauges,
        }
    }

    /// Puts a row into the beginning of `room` and gives its length; `None` if there is too little, of which a row asks for
    /// [`PAIR`] more than it takes. The first one has news in any case.
    #[inline(always)]
    pub(super) fn put(
        &mut self,
        interval: u32,
        counts: &Gauges,
        made: &impl Made,
        room: &mut [u8],
    ) -> Option<usize> {
        let place = room.first_chunk_mut()?;
        let bytes =
            self.parts.put(self.gauges, *counts, || made.outputs().map(|out| out.fa), place)?;
        if self.has_more | made.is_news() | (interval != self.interval) {
            return self.put_more(interval, made, bytes, room);
        }
        Some(bytes)
    }

    /// Beyond what every row has, so that this costs no more than it must.
    #[cold]
    #[inline(never)]
    fn put_more(
        &mut self,
        interval: u32,
        made: &impl Made,
        bytes: usize,
        room: &mut [u8],
    ) -> Option<usize> {
        let all = room.len();
        let (row, mut room) = room.split_at_mut_checked(bytes)?;
        let head = row.first_mut()?;
        let outputs = made.outputs();
        if self.columns == Columns::All {
            let elastic = outputs.map(|out| out.elastic);
            let equilibrium = || outputs.map(|out| out.equilibrium);
            let bytes =
                self.rest.put(self.gauges, elastic, equilibrium, room.first_chunk_mut()?)?;
            room = room.get_mut(bytes..)?;
        }
        if interval != self.interval {
            *head |= INTERVAL;
            room = put_varint(zigzag(interval.wrapping_sub(self.interval)), room)?;
            self.interval = interval;
        }
        let states = outputs.map(|out| out.state().byte());
        let found_a_region = outputs.iter().any(|out| out.entered_samples_ago.is_some());
        if found_a_region || self.states != Some(states) {
            *head |= NEWS;
            room = put_news(states, &outputs, self.gauges, room)?;
            self.states = Some(states);
        }
        self.has_more = self.columns == Columns::All;
        Some(all.wrapping_sub(room.len()))
    }

    /// Reads a row from the beginning of `bytes`; also gives those behind it.
    pub(super) fn take<'b>(&mut self, bytes: &'b [u8]) -> Result<(Coded, &'b [u8]), CodingError> {
        let head = bytes.first().ok_or(CodingError)?;
        let (counts, fa, mut left) = self.parts.take(self.gauges, bytes)?;
        let (mut elastic, mut equilibrium) = Default::default();
        if self.columns == Columns::All {
            (elastic, equilibrium, left) = self.rest.take(self.gauges, left)?;
        }
        if head & INTERVAL != 0 {
            let code;
            (code, left) = take_varint(left)?;
            self.interval = self.interval.wrapping_add(unzigzag(code));
        }
        let mut entered = [None; GAUGES];
        if head & NEWS != 0 {
            let (said, after) = left.split_at_checked(self.gauges.into()).ok_or(CodingError)?;
            let (found, after) = after.split_first().ok_or(CodingError)?;
            let mut states = [0; GAUGES];
            states.iter_mut().zip(said).for_each(|(state, said)| *state = *said);
            (self.states, left) = (Some(states), after);
            for (gauge, entered) in entered.iter_mut().enumerate() {
                if found.wrapping_shr(gauge as u32) & 1 != 0 {
                    let (ago, after) = take_varint(left)?;
                    (*entered, left) = (Some(ago), after);
                }
            }
        }
        let (interval, states) = (self.interval, self.states.unwrap_or_default());
        let (parts, rest) = ((counts, fa), (elastic, equilibrium));
        Ok((Coded { interval, parts, rest, states, entered }, left))
    }
}

/// States, and how long ago regions were entered that were found.
fn put_news<'b>(
    states: [u8; GAUGES],
    outputs: &[Output; GAUGES],
    gauges: u8,
    room: &'b mut [u8],
) -> Option<&'b mut [u8]> {
    let (place, room) = room.split_at_mut_checked(gauges.into())?;
    place.iter_mut().zip(states).for_each(|(place, state)| *place = state);
    let (found, mut room) = room.split_first_mut()?;
    *found = 0;
    for (gauge, out) in outputs.iter().enumerate().take(gauges.into()) {
        if let Some(ago) = out.entered_samples_ago {
            *found |= 1_u8.wrapping_shl(gauge as u32);
            room = put_varint(ago, room)?;
        }
    }
    Some(room)
}

/// Most bytes of two quantities and the byte of their classes.
pub(super) const PAIR: usize = 2 * LONGEST + 1;

/// Two quantities whose classes share a byte, the first in bits 0 to 2, the second in 3 to 5.
#[derive(Clone, Copy, Debug)]
struct Pair(Differences, Differences);

impl Pair {
    const NEW: Self = Self(Differences::new(), Differences::new());

    /// How many bytes it takes. The second quantity is asked for when the first is done with.
    #[inline(always)]
    fn put(
        &mut self,
        gauges: u8,
        a: Gauges,
        b: impl FnOnce() -> Gauges,
        [classes, codes @ ..]: &mut [u8; PAIR],
    ) -> Option<usize> {
        let of_a = self.0.put(a, codes.first_chunk_mut()?);
        let behind = length(of_a, gauges);
        let of_b = self.1.put(b(), codes.get_mut(behind..)?.first_chunk_mut()?);
        *classes = of_a | of_b << 3;
        Some(behind.wrapping_add(length(of_b, gauges)).wrapping_add(1))
    }

    /// Also gives what is behind them.
    fn take<'b>(
        &mut self,
        gauges: u8,
        bytes: &'b [u8],
    ) -> Result<(Gauges, Gauges, &'b [u8]), CodingError> {
        let (classes, left) = bytes.split_first().ok_or(CodingError)?;
        let (a, left) = self.0.take(classes & 7, gauges, left)?;
        let (b, left) = self.1.take(classes >> 3 & 7, gauges, left)?;
        Ok((a, b, left))
    }
}

/// 0, −1, 1, −2 … as 0, 1, 2, 3 …
const fn zigzag(value: u32) -> u32 {
    value.wrapping_shl(1) ^ value.wrapping_shr(31).wrapping_neg()
}

const fn unzigzag(code: u32) -> u32 {
    code.wrapping_shr(1) ^ (code & 1).wrapping_neg()
}

/// Seven bits a byte, the lowest first, with the eighth set where more follow.
fn put_varint(mut value: u32, mut room: &mut [u8]) -> Option<&mut [u8]> {
    loop {
        let (byte, left) = room.split_first_mut()?;
        room = left;
        *byte = value as u8 & 0x7f;
        value = value.wrapping_shr(7);
        if value == 0 {
            return Some(room);
        }
        *byte |= 0x80;
    }
}

fn take_varint(mut bytes: &[u8]) -> Result<(u32, &[u8]), CodingError> {
    let mut value = 0;
    for shift in [0_u32, 7, 14, 21, 28] {
        let (byte, left) = bytes.split_first().ok_or(CodingError)?;
        bytes = left;
        value |= u32::from(byte & 0x7f).wrapping_shl(shift);
        if byte & 0x80 == 0 {
            return Ok((value, bytes));
        }
    }
    Err(CodingError)
}
