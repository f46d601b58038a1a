//! Numbers that change little from row to row, one of each gauge, in few bits and few instructions.
//!
//! Of each row the differences from the row before are coded, of the first those from zero. They wrap, so that any numbers
//! are coded without loss. All of a row take the same number of bits, as many as the largest of them needs:
//!
//! | class | 0 | 1 | 2 | … | 7 |
//! |-|-|-|-|-|-|
//! | bits of a difference, in two's complement | 4 | 8 | 12 | … | 32 |
//! | bytes of all four of four gauges, the first in the lowest bits, the lowest byte first | 2 | 4 | 6 | … | 16 |
//! | bytes of n gauges, rounded up | n/2 | n | 3n/2 | … | 4n |

use core::fmt;

use crate::pipeline::GAUGES;

/// Values of one kind, gauge by gauge.
pub type Gauges = [i32; GAUGES];

/// Most bytes that a row takes.
pub(super) const LONGEST: usize = 16;

/// Bytes that a row of a class takes of so many gauges.
#[inline(always)]
pub(super) const fn length(class: u8, gauges: u8) -> usize {
    let quarters = (class as usize & 7).wrapping_add(1).wrapping_mul(gauges as usize);
    quarters.wrapping_add(1).wrapping_shr(1)
}

/// Why bytes are not rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CodingError;

impl fmt::Display for CodingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rows that do not end where their bytes do")
    }
}

impl core::error::Error for CodingError {}

/// Codes rows, or reads them: remembers the last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Differences {
    last: Gauges,
}

impl Differences {
    /// Before the first row.
    pub(super) const fn new() -> Self {
        Self { last: [0; GAUGES] }
    }

    /// Puts the next row into the beginning of `place`; its class, which with the number of gauges gives its length.
    #[inline(always)]
    pub(super) fn put(&mut self, values: Gauges, place: &mut [u8; LONGEST]) -> u8 {
        let mut changes = values;
        let mut seen = 1_u32;
        for (change, last) in changes.iter_mut().zip(self.last) {
            *change = change.wrapping_sub(last);
            // The highest bit that is not like its lower neighbour.
            seen |= (*change ^ change.wrapping_shl(1)).cast_unsigned();
        }
        self.last = values;
        let class = seen.ilog2().wrapping_shr(2) as u8;
        match class {
            0 => put_pairs::<1>(changes, place),
            1 => put_each::<1>(changes, place),
            2 => put_pairs::<3>(changes, place),
            3 => put_each::<2>(changes, place),
            4 => put_pairs::<5>(changes, place),
            5 => put_each::<3>(changes, place),
            6 => put_pairs::<7>(changes, place),
            _ => put_each::<4>(changes, place),
        }
        class
    }

    /// Reads the next row, of this class and so many gauges, from the beginning of `bytes`; also gives those behind it.
    ///
    /// # Errors
    /// [`CodingError`] if it is not there.
    pub(super) fn take<'b>(
        &mut self,
        class: u8,
        gauges: u8,
        bytes: &'b [u8],
    ) -> Result<(Gauges, &'b [u8]), CodingError> {
        let (codes, left) = bytes.split_at_checked(length(class, gauges)).ok_or(CodingError)?;
        let mut word = [0; LONGEST];
        for (to, from) in word.iter_mut().zip(codes) {
            *to = *from;
        }
        let mut word = u128::from_le_bytes(word);
        let bits = u32::from(class & 7).wrapping_add(1).wrapping_mul(4);
        let unused = 32_u32.wrapping_sub(bits);
        for last in self.last.iter_mut().take(gauges.into()) {
            let change = (word as i32).wrapping_shl(unused).wrapping_shr(unused);
            *last = last.wrapping_add(change);
            word = word.wrapping_shr(bits);
        }
        Ok((self.last, left))
    }
}

/// Four codes of `WIDTH` bytes each.
#[inline(always)]
fn put_each<const WIDTH: usize>(changes: Gauges, place: &mut [u8; LONGEST]) {
    for (place, change) in place.as_chunks_mut::<WIDTH>().0.iter_mut().zip(changes) {
        *place = lowest(u64::from(change.cast_unsigned()));
    }
}

/// Four codes, two of them in `WIDTH` bytes.
#[inline(always)]
fn put_pairs<const WIDTH: usize>([a, b, c, d]: Gauges, place: &mut [u8; LONGEST]) {
    let bits = WIDTH.wrapping_mul(4) as u32;
    let mask = 1_u64.wrapping_shl(bits).wrapping_sub(1);
    for (place, (low, high)) in place.as_chunks_mut::<WIDTH>().0.iter_mut().zip([(a, b), (c, d)]) {
        *place = lowest(low as u64 & mask | (high as u64).wrapping_shl(bits));
    }
}

/// The lowest bytes.
#[inline(always)]
fn lowest<const BYTES: usize>(word: u64) -> [u8; BYTES] {
    word.to_le_bytes().first_chunk().copied().unwrap_or([0; BYTES])
}

/// Packs rows of the first so many gauges into `room`, each with its class in front; the bytes, or `None` if there is too little.
#[must_use]
pub fn pack<'b>(rows: &[Gauges], gauges: u8, room: &'b mut [u8]) -> Option<&'b [u8]> {
    let mut differences = Differences::new();
    let mut bytes: usize = 0;
    for row in rows {
        let mut codes = [0; LONGEST];
        let mut row = *row;
        row.iter_mut().skip(gauges.into()).for_each(|value| *value = 0);
        let class = differences.put(row, &mut codes);
        let end = bytes.wrapping_add(1).wrapping_add(length(class, gauges));
        let (first, rest) = room.get_mut(bytes..end)?.split_first_mut()?;
        *first = class;
        rest.copy_from_slice(codes.get(..length(class, gauges))?);
        bytes = end;
    }
    room.get(..bytes)
}

/// The rows of so many gauges that [`pack`] packed; the other gauges read 0.
pub fn unpack(mut bytes: &[u8], gauges: u8) -> impl Iterator<Item = Result<Gauges, CodingError>> {
    let mut differences = Differences::new();
    core::iter::from_fn(move || {
        let (class, codes) = bytes.split_first()?;
        let row =
            if *class < 8 { differences.take(*class, gauges, codes) } else { Err(CodingError) };
        bytes = row.map_or(&[], |(_, left)| left);
        Some(row.map(|(values, _)| values))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_bytes_are_those_of_the_head_comment() {
        let rows = [[1, -1, 7, -8], [1, -1, 7, -8], [1, -1, 7, 120]];
        let mut room = [0; 20];
        assert_eq!(
            pack(&rows, 4, &mut room).unwrap(),
            [0, 0xf1, 0x87, 0, 0, 0, 2, 0, 0, 0, 0, 0, 8]
        );
    }

    #[test]
    fn rows_without_room_are_refused() {
        let mut room = [0; 17];
        let row = [i32::MIN, i32::MAX, 0, 0];
        assert_eq!(pack(&[row], 4, &mut room).map(<[u8]>::len), Some(17));
        assert_eq!(pack(&[row], 4, &mut room[1..]), None);
        assert_eq!(pack(&[row, row], 4, &mut room), None);
    }

    fn any_values() -> impl Strategy<Value = Gauges> {
        let of_bits = |bits: u32| any::<i32>().prop_map(move |value| value >> (32 - bits));
        (1_u32..=32).prop_flat_map(move |bits| prop::array::uniform4(of_bits(bits)))
    }

    proptest! {
        #[test]
        fn any_rows_of_any_number_of_gauges_come_back(
            mut rows in prop::collection::vec(any_values(), 0..20),
            gauges in 0..=GAUGES as u8,
        ) {
            let mut room = [0; 17 * 20];
            let packed = pack(&rows, gauges, &mut room).unwrap();
            let read: Result<Vec<_>, _> = unpack(packed, gauges).collect();
            rows.iter_mut().for_each(|row| row[gauges.into()..].fill(0));
            prop_assert_eq!(read, Ok(rows));
        }

        #[test]
        fn any_bytes_are_read_or_refused(
            bytes in prop::collection::vec(any::<u8>(), 0..64),
            gauges in any::<u8>(),
        ) {
            unpack(&bytes, gauges).for_each(drop);
        }
    }
}
