//! Four numbers that change little from row to row, in few bits and few instructions.
//!
//! Of each row the differences from the row before are coded, of the first those from zero. They wrap, so that any numbers
//! are coded without loss. All four take the same number of bits, as many as the largest of them needs:
//!
//! | class | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 |
//! |-|-|-|-|-|-|-|-|-|
//! | bits of a difference, in two's complement | 0 | 4 | 8 | 12 | 16 | 20 | 24 | 32 |
//! | bytes of all four, the first in the lowest bits, the lowest byte first | 0 | 2 | 4 | 6 | 8 | 10 | 12 | 16 |

use core::fmt;

use crate::pipeline::GAUGES;

/// Values of one kind, gauge by gauge.
pub type Gauges = [i32; GAUGES];

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Differences {
    last: Gauges,
}

impl Differences {
    /// Before the first row.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: [0; GAUGES] }
    }

    /// Puts the next row into the beginning of `room`: its class, and the room that is left; `None` if there is too little.
    #[inline(always)]
    pub fn put<'b>(&mut self, values: Gauges, room: &'b mut [u8]) -> Option<(u8, &'b mut [u8])> {
        let mut changes = values;
        let mut seen = 0;
        for (change, last) in changes.iter_mut().zip(self.last) {
            *change = change.wrapping_sub(last);
            // The highest bit that is not like its lower neighbour.
            seen |= *change ^ change.wrapping_shl(1);
        }
        self.last = values;
        let quarters = 35_u32.wrapping_sub(seen.leading_zeros()).wrapping_shr(2);
        match quarters {
            0 => Some((0, room)),
            1 => Some((1, put_pairs::<1, 2>(changes, room)?)),
            2 => Some((2, put_each::<1, 4>(changes, room)?)),
            3 => Some((3, put_pairs::<3, 6>(changes, room)?)),
            4 => Some((4, put_each::<2, 8>(changes, room)?)),
            5 => Some((5, put_pairs::<5, 10>(changes, room)?)),
            6 => Some((6, put_each::<3, 12>(changes, room)?)),
            _ => Some((7, put_each::<4, 16>(changes, room)?)),
        }
    }

    /// Reads the next row, of this class, from the beginning of `bytes`; also gives those behind it.
    ///
    /// # Errors
    /// [`CodingError`] if it is not there.
    pub fn take<'b>(
        &mut self,
        class: u8,
        bytes: &'b [u8],
    ) -> Result<(Gauges, &'b [u8]), CodingError> {
        let bits = match class {
            0..7 => u32::from(class).wrapping_mul(4),
            7 => 32,
            _ => return Err(CodingError),
        };
        let (codes, left) = bytes.split_at_checked(bits as usize / 2).ok_or(CodingError)?;
        let mut word = [0; 16];
        for (to, from) in word.iter_mut().zip(codes) {
            *to = *from;
        }
        let mut word = u128::from_le_bytes(word);
        let unused = 32_u32.wrapping_sub(bits);
        for last in &mut self.last {
            // Twice, for a shift by 32 would be none.
            let change = (word as i32).wrapping_shl(unused / 2).wrapping_shl(unused.div_ceil(2));
            let change = change.wrapping_shr(unused / 2).wrapping_shr(unused.div_ceil(2));
            *last = last.wrapping_add(change);
            word = word.wrapping_shr(bits);
        }
        Ok((self.last, left))
    }
}

/// Four codes of `WIDTH` bytes each.
#[inline(always)]
fn put_each<const WIDTH: usize, const ALL: usize>(
    changes: Gauges,
    room: &mut [u8],
) -> Option<&mut [u8]> {
    let (place, left) = room.split_first_chunk_mut::<ALL>()?;
    for (code, change) in place.as_chunks_mut().0.iter_mut().zip(changes) {
        *code = *change.to_le_bytes().first_chunk::<WIDTH>()?;
    }
    Some(left)
}

/// Four codes, two of them in `WIDTH` bytes.
#[inline(always)]
fn put_pairs<const WIDTH: usize, const ALL: usize>(
    [a, b, c, d]: Gauges,
    room: &mut [u8],
) -> Option<&mut [u8]> {
    let (place, left) = room.split_first_chunk_mut::<ALL>()?;
    let bits = WIDTH.wrapping_mul(4) as u32;
    let mask = 1_u64.wrapping_shl(bits).wrapping_sub(1);
    for (codes, (low, high)) in place.as_chunks_mut().0.iter_mut().zip([(a, b), (c, d)]) {
        let both = low as u64 & mask | (high as u64).wrapping_shl(bits);
        *codes = *both.to_le_bytes().first_chunk::<WIDTH>()?;
    }
    Some(left)
}

/// Packs rows into `room`, each with its class in front; the bytes, or `None` if there is too little.
#[must_use]
pub fn pack<'b>(rows: &[Gauges], room: &'b mut [u8]) -> Option<&'b [u8]> {
    let mut differences = Differences::new();
    let mut left = room.len();
    for row in rows {
        let at = room.len().checked_sub(left)?;
        let (class, codes) = room.get_mut(at..)?.split_first_mut()?;
        let (of_row, rest) = differences.put(*row, codes)?;
        (*class, left) = (of_row, rest.len());
    }
    room.get(..room.len().checked_sub(left)?)
}

/// The rows that [`pack`] packed.
pub fn unpack(mut bytes: &[u8]) -> impl Iterator<Item = Result<Gauges, CodingError>> {
    let mut differences = Differences::new();
    core::iter::from_fn(move || {
        let (class, codes) = bytes.split_first()?;
        let row = differences.take(*class, codes);
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
        assert_eq!(pack(&rows, &mut room).unwrap(), [1, 0xf1, 0x87, 0, 3, 0, 0, 0, 0, 0, 8]);
    }

    #[test]
    fn rows_without_room_are_refused() {
        let mut room = [0; 17];
        let row = [i32::MIN, i32::MAX, 0, 0];
        assert_eq!(pack(&[row], &mut room).map(<[u8]>::len), Some(17));
        assert_eq!(pack(&[row], &mut room[1..]), None);
        assert_eq!(pack(&[row, row], &mut room), None);
    }

    fn any_values() -> impl Strategy<Value = Gauges> {
        let of_bits = |bits: u32| any::<i32>().prop_map(move |value| value >> (32 - bits));
        (1_u32..=32).prop_flat_map(move |bits| prop::array::uniform4(of_bits(bits)))
    }

    proptest! {
        #[test]
        fn any_rows_come_back(rows in prop::collection::vec(any_values(), 0..20)) {
            let mut room = [0; 17 * 20];
            let packed = pack(&rows, &mut room).unwrap();
            let read: Result<Vec<_>, _> = unpack(packed).collect();
            prop_assert_eq!(read, Ok(rows));
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
            unpack(&bytes).for_each(drop);
        }
    }
}
