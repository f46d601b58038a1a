//! Numbers that change little from row to row, in few bits and few instructions.
//!
//! A column has `L` lanes, as one number for each of four gauges. Of the first row the numbers themselves are coded, of every
//! later one the differences from the row before, zigzag (0, −1, 1, −2 … as 0, 1, 2, 3 …). Differences wrap, so every column
//! is coded without loss. On the wire:
//!
//! | bytes | what |
//! |-|-|
//! | 1 | w: bytes that two codes of the first row take together, 0 … 8; a code has 4 w bits |
//! | 1 | the same for the later rows |
//! | … | codes of the first row, lane by lane, in pairs: the first in the lower 4 w bits, lowest byte first; a last one without partner is paired with 0 |
//! | … | codes of the later rows, row by row, likewise |

use core::fmt;
use core::ops::Range;

/// Most rows in a column.
pub const BLOCK_ROWS: usize = 16;
/// Bytes of the two widths.
const HEAD: usize = 2;

/// Why bytes are not a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodingError {
    /// The bytes end before the column, or have no room for it.
    Length,
    /// Two codes claim more than 8 bytes.
    Width(u8),
}

impl fmt::Display for CodingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length => write!(f, "a column of other length than its bytes"),
            Self::Width(bytes) => write!(f, "two codes of {bytes} bytes; there are no more than 8"),
        }
    }
}

impl core::error::Error for CodingError {}

const fn zigzag(value: i32) -> u32 {
    (value.wrapping_shl(1) ^ value.wrapping_shr(31)).cast_unsigned()
}

const fn unzigzag(code: u32) -> i32 {
    (code.wrapping_shr(1) ^ (code & 1).wrapping_neg()).cast_signed()
}

/// Bytes for two codes, none longer than all bits `seen` in them.
const fn width(seen: u32) -> u8 {
    35_u32.wrapping_sub(seen.leading_zeros()).wrapping_shr(2) as u8
}

/// Bytes of so many codes.
const fn length(codes: usize, width: u8) -> usize {
    codes.div_ceil(2).saturating_mul(width as usize)
}

/// Some rows of `L` numbers each, coded as they come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column<const L: usize> {
    first: [i32; L],
    last: [i32; L],
    /// Of every row; that of the first is not used.
    codes: [[u32; L]; BLOCK_ROWS],
    /// All bits of the codes.
    seen: u32,
}

impl<const L: usize> Column<L> {
    /// One row of zeros.
    #[must_use]
    pub const fn new() -> Self {
        Self { first: [0; L], last: [0; L], codes: [[0; L]; BLOCK_ROWS], seen: 0 }
    }

    /// Begins with this row, number 0.
    #[inline]
    pub const fn begin(&mut self, values: [i32; L]) {
        (self.first, self.last, self.seen) = (values, values, 0);
    }

    /// Sets the next row, whose number is `at`. Beyond [`BLOCK_ROWS`] nothing happens.
    #[inline]
    pub fn set(&mut self, at: usize, values: [i32; L]) {
        let Some(codes) = self.codes.get_mut(at) else { return };
        for ((code, last), value) in codes.iter_mut().zip(&self.last).zip(&values) {
            *code = zigzag(value.wrapping_sub(*last));
            self.seen |= *code;
        }
        self.last = values;
    }

    /// The numbers, row by row.
    pub fn iter(&self) -> impl Iterator<Item = [i32; L]> {
        let later = self.codes.iter().skip(1).scan(self.first, |values, codes| {
            for (value, code) in values.iter_mut().zip(codes) {
                *value = value.wrapping_add(unzigzag(*code));
            }
            Some(*values)
        });
        core::iter::once(self.first).chain(later)
    }

    /// Packs rows into the beginning of `room`: the bytes, and the room that is left; `None` if there is too little.
    #[inline]
    pub fn pack<'b>(
        &self,
        rows: Range<usize>,
        room: &'b mut [u8],
    ) -> Option<(&'b [u8], &'b mut [u8])> {
        let first = if rows.start == 0 { self.first } else { self.iter().nth(rows.start)? };
        let first = first.map(zigzag);
        let later = self.codes.get(rows.start.wrapping_add(1)..rows.end)?.as_flattened();
        let of_first = width(first.iter().fold(0, |seen, code| seen | code));
        let of_later = width(self.seen);
        let first_length = length(L, of_first);
        let bytes = HEAD.wrapping_add(first_length).wrapping_add(length(later.len(), of_later));
        let (packed, left) = room.split_at_mut_checked(bytes)?;
        let (head, body) = packed.split_first_chunk_mut::<HEAD>()?;
        *head = [of_first, of_later];
        let (first_body, later_body) = body.split_at_mut_checked(first_length)?;
        put(&first, of_first, first_body);
        put(later, of_later, later_body);
        Some((packed, left))
    }

    /// Reads so many rows, at least one, from the beginning of `bytes`; also gives the bytes behind them. Rows cannot be set
    /// in what was read.
    ///
    /// # Errors
    /// [`CodingError`] if they are not there.
    pub fn unpack(bytes: &[u8], rows: usize) -> Result<(Self, &[u8]), CodingError> {
        let mut column = Self::new();
        let codes = column.codes.get_mut(..rows).ok_or(CodingError::Length)?;
        let ([of_first, of_later], body) =
            bytes.split_first_chunk::<HEAD>().ok_or(CodingError::Length)?;
        let (first, later) = codes.split_first_mut().ok_or(CodingError::Length)?;
        let body = take(body, *of_first, first)?;
        let left = take(body, *of_later, later.as_flattened_mut())?;
        column.first = first.map(unzigzag);
        Ok((column, left))
    }
}

impl<const L: usize> Default for Column<L> {
    fn default() -> Self {
        Self::new()
    }
}

/// Writes codes, two of them in `width` bytes.
#[inline]
fn put(codes: &[u32], width: u8, bytes: &mut [u8]) {
    match width {
        1 => put_pairs::<1>(codes, bytes),
        2 => put_pairs::<2>(codes, bytes),
        3 => put_pairs::<3>(codes, bytes),
        4 => put_pairs::<4>(codes, bytes),
        5 => put_pairs::<5>(codes, bytes),
        6 => put_pairs::<6>(codes, bytes),
        7 => put_pairs::<7>(codes, bytes),
        8 => put_pairs::<8>(codes, bytes),
        _ => {}
    }
}

fn put_pairs<const W: usize>(codes: &[u32], bytes: &mut [u8]) {
    let (pairs, alone) = codes.as_chunks::<2>();
    let (places, _) = bytes.as_chunks_mut::<W>();
    for (place, [low, high]) in places.iter_mut().zip(pairs) {
        *place = joined(*low, *high);
    }
    if let (Some(place), Some(low)) = (places.get_mut(pairs.len()), alone.first()) {
        *place = joined(*low, 0);
    }
}

/// Two codes of 4 W bits as W bytes.
#[inline]
fn joined<const W: usize>(low: u32, high: u32) -> [u8; W] {
    let both = u64::from(low) | u64::from(high).wrapping_shl(W.wrapping_mul(4) as u32);
    let bytes = both.to_le_bytes();
    bytes.first_chunk().copied().unwrap_or([0; W])
}

/// Reads codes, two of them in `width` bytes; gives the bytes behind them.
fn take<'b>(bytes: &'b [u8], width: u8, codes: &mut [u32]) -> Result<&'b [u8], CodingError> {
    if width > 8 {
        return Err(CodingError::Width(width));
    }
    let (body, left) =
        bytes.split_at_checked(length(codes.len(), width)).ok_or(CodingError::Length)?;
    if width > 0 {
        let mask = 1_u64.wrapping_shl(u32::from(width).wrapping_mul(4)).wrapping_sub(1);
        for (pair, place) in codes.chunks_mut(2).zip(body.chunks_exact(width.into())) {
            let mut word = [0; 8];
            for (to, from) in word.iter_mut().zip(place) {
                *to = *from;
            }
            let mut both = u64::from_le_bytes(word);
            for code in pair {
                *code = (both & mask) as u32;
                both = both.wrapping_shr(u32::from(width).wrapping_mul(4));
            }
        }
    }
    Ok(left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn column<const L: usize>(rows: &[[i32; L]]) -> Column<L> {
        let mut column = Column::new();
        column.begin(rows[0]);
        for (at, row) in rows.iter().enumerate().skip(1) {
            column.set(at, *row);
        }
        column
    }

    #[test]
    fn the_bytes_are_those_of_the_head_comment() {
        // First row 3 and −100: codes 6 and 199 of 8 bits; then differences 1 and 0, 0 and −3: codes 2 and 0, 0 and 5.
        let coded = column(&[[3, -100], [4, -100], [4, -103]]);
        let mut room = [0; 20];
        let (packed, left) = coded.pack(0..3, &mut room).unwrap();
        assert_eq!(packed, [2, 1, 6, 199, 0x02, 0x50]);
        assert_eq!(left.len(), 14);
    }

    #[test]
    fn a_column_without_room_is_refused() {
        let coded = column(&[[i32::MIN; 4], [i32::MAX; 4]]);
        let mut room = [0; 20];
        assert_eq!(coded.pack(0..2, &mut room).map(|(packed, _)| packed.len()), Some(2 + 16 + 2));
        assert!(coded.pack(0..2, &mut room[1..]).is_none());
    }

    #[test]
    fn what_does_not_change_takes_no_bytes() {
        let mut room = [0; 20];
        let (packed, _) = column(&[[7]; 16]).pack(0..16, &mut room).unwrap();
        assert_eq!(packed, [1, 0, 14]);
    }

    fn any_value() -> impl Strategy<Value = i32> {
        prop_oneof![any::<i32>(), -100..100_i32, Just(0)]
    }

    proptest! {
        #[test]
        fn any_part_of_any_column_comes_back(
            gauges in prop::collection::vec(prop::array::uniform4(any_value()), 1..=BLOCK_ROWS),
            from in 0..BLOCK_ROWS,
        ) {
            let from = from % gauges.len();
            let mut room = [0; 300];
            let (packed, _) = column(&gauges).pack(from..gauges.len(), &mut room).unwrap();
            let rows = gauges.len() - from;
            let (read, left) = Column::<4>::unpack(packed, rows).unwrap();
            prop_assert!(left.is_empty());
            prop_assert_eq!(read.iter().take(rows).collect::<Vec<_>>(), &gauges[from..]);

            let single: Vec<[i32; 1]> = gauges.iter().map(|row| [row[0]]).collect();
            let (packed, _) = column(&single).pack(from..single.len(), &mut room).unwrap();
            let (read, _) = Column::<1>::unpack(packed, rows).unwrap();
            prop_assert_eq!(read.iter().take(rows).collect::<Vec<_>>(), &single[from..]);
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..64), rows in 0_usize..20) {
            let _ = Column::<4>::unpack(&bytes, rows);
        }
    }
}
