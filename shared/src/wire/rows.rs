//! One row after the other as bytes, each in terms of the one before.
//!
//! | bytes | what |
//! |-|-|
//! | 1 | head: bits 0 to 2 the class of the counts, 3 to 5 that of FA, 6 and 7 whether interval and news follow |
//! | … | counts, then FA, as [`Differences`] codes them |
//! | … | if asked for: a byte with the classes of elastic input and equilibrium, as in the head, then these |
//! | 1 … 5 | interval: µs since the row before, less what this was there, or less 0 in the first; zigzag, varint |
//! | 4 | news: states, one byte for each gauge; without news, as in the row before |
//! | 1 | news: from bit 0 on, whether a region was found on each gauge |
//! | … | news: how many samples ago each of these was entered; varint |

use super::Columns;
use super::differences::{CodingError, Differences, Gauges};
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
    pub(super) const fn new(columns: Columns) -> Self {
        Self {
            parts: Pair::NEW,
            rest: Pair::NEW,
            interval: 0,
            states: None,
            has_more: true,
            columns,
        }
    }

    /// Puts a row into the beginning of `room` and gives what is left; `None` if there is too little. The first one has
    /// news in any case.
    #[inline(always)]
    pub(super) fn put<'b>(
        &mut self,
        interval: u32,
        counts: &Gauges,
        made: &impl Made,
        room: &'b mut [u8],
    ) -> Option<&'b mut [u8]> {
        let (head, room) = room.split_first_mut()?;
        let (of_counts, room) = self.parts.0.put(*counts, room)?;
        let (of_fa, room) = self.parts.1.put(made.outputs().map(|out| out.fa), room)?;
        *head = of_counts | of_fa << 3;
        if self.has_more | made.is_news() | (interval != self.interval) {
            return self.put_more(interval, made, head, room);
        }
        Some(room)
    }

    /// Beyond what every row has, so that this costs no more than it must.
    #[cold]
    #[inline(never)]
    fn put_more<'b>(
        &mut self,
        interval: u32,
        made: &impl Made,
        head: &mut u8,
        mut room: &'b mut [u8],
    ) -> Option<&'b mut [u8]> {
        let outputs = made.outputs();
        if self.columns == Columns::All {
            let rest = (outputs.map(|out| out.elastic), outputs.map(|out| out.equilibrium));
            let (classes, codes) = room.split_first_mut()?;
            (*classes, room) = self.rest.put(rest, codes)?;
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
            room = put_news(states, &outputs, room)?;
            self.states = Some(states);
        }
        self.has_more = self.columns == Columns::All;
        Some(room)
    }

    /// Reads a row from the beginning of `bytes`; also gives those behind it.
    pub(super) fn take<'b>(&mut self, bytes: &'b [u8]) -> Result<(Coded, &'b [u8]), CodingError> {
        let (head, left) = bytes.split_first().ok_or(CodingError)?;
        let (parts, mut left) = self.parts.take(*head, left)?;
        let mut rest = Default::default();
        if self.columns == Columns::All {
            let (classes, codes) = left.split_first().ok_or(CodingError)?;
            (rest, left) = self.rest.take(*classes, codes)?;
        }
        if head & INTERVAL != 0 {
            let code;
            (code, left) = take_varint(left)?;
            self.interval = self.interval.wrapping_add(unzigzag(code));
        }
        let mut entered = [None; GAUGES];
        if head & NEWS != 0 {
            let (states, after) = left.split_first_chunk().ok_or(CodingError)?;
            let (found, after) = after.split_first().ok_or(CodingError)?;
            (self.states, left) = (Some(*states), after);
            for (gauge, entered) in entered.iter_mut().enumerate() {
                if found.wrapping_shr(gauge as u32) & 1 != 0 {
                    let (ago, after) = take_varint(left)?;
                    (*entered, left) = (Some(ago), after);
                }
            }
        }
        let (interval, states) = (self.interval, self.states.unwrap_or_default());
        Ok((Coded { interval, parts, rest, states, entered }, left))
    }
}

/// States, and how long ago regions were entered that were found.
fn put_news<'b>(
    states: [u8; GAUGES],
    outputs: &[Output; GAUGES],
    room: &'b mut [u8],
) -> Option<&'b mut [u8]> {
    let (place, room) = room.split_first_chunk_mut()?;
    *place = states;
    let (found, mut room) = room.split_first_mut()?;
    *found = 0;
    for (gauge, out) in outputs.iter().enumerate() {
        if let Some(ago) = out.entered_samples_ago {
            *found |= 1_u8.wrapping_shl(gauge as u32);
            room = put_varint(ago, room)?;
        }
    }
    Some(room)
}

/// Two quantities whose classes share a byte.
#[derive(Clone, Copy, Debug)]
struct Pair(Differences, Differences);

impl Pair {
    const NEW: Self = Self(Differences::new(), Differences::new());

    fn put<'b>(
        &mut self,
        (a, b): (Gauges, Gauges),
        room: &'b mut [u8],
    ) -> Option<(u8, &'b mut [u8])> {
        let (of_a, room) = self.0.put(a, room)?;
        let (of_b, room) = self.1.put(b, room)?;
        Some((of_a | of_b << 3, room))
    }

    fn take<'b>(
        &mut self,
        classes: u8,
        bytes: &'b [u8],
    ) -> Result<((Gauges, Gauges), &'b [u8]), CodingError> {
        let (a, left) = self.0.take(classes & 7, bytes)?;
        let (b, left) = self.1.take(classes >> 3 & 7, left)?;
        Ok(((a, b), left))
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
