//! Rows of integers in few bits: the first row as it is, then differences, each kind of value with as many bits as its
//! largest needs.
//!
//! A table has `K` kinds of `L` values in each row, as raw counts and FA of four gauges. First come 2 K bytes, the bits of
//! the first row and of the differences, kind by kind; then all values row by row without gaps, the lowest bit first, zigzag
//! coded (0, −1, 1, −2 … as 0, 1, 2, 3 …). Differences wrap, so every table is coded without loss.

use core::fmt;

/// Why bytes are not a table, or a table is no bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodingError {
    /// The bytes end before the table, or have no room for it.
    Length,
    /// A kind claims more than 32 bits.
    Bits(u8),
}

impl fmt::Display for CodingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length => write!(f, "a table of other length than its bytes"),
            Self::Bits(bits) => write!(f, "a value of {bits} bits; there are no more than 32"),
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

/// Bits of the first row and of the differences, kind by kind.
type Widths<const K: usize> = ([u8; K], [u8; K]);

fn widths<const K: usize, const L: usize>(rows: &[[[i32; L]; K]]) -> Widths<K> {
    let mut first = [0; K];
    let mut later = [0; K];
    if let Some(row) = rows.first() {
        for (seen, values) in first.iter_mut().zip(row) {
            *seen = values.iter().fold(0, |seen, value| seen | zigzag(*value));
        }
    }
    for (before, row) in rows.iter().zip(rows.iter().skip(1)) {
        for ((seen, values), before) in later.iter_mut().zip(row).zip(before) {
            for (value, before) in values.iter().zip(before) {
                *seen |= zigzag(value.wrapping_sub(*before));
            }
        }
    }
    (first.map(bits), later.map(bits))
}

const fn bits(seen: u32) -> u8 {
    32_u32.wrapping_sub(seen.leading_zeros()) as u8
}

/// Bytes that `rows` of these widths take.
fn length<const K: usize, const L: usize>((first, later): &Widths<K>, rows: usize) -> usize {
    let sum = |widths: &[u8; K]| widths.iter().map(|bits| usize::from(*bits)).sum::<usize>();
    let later = sum(later).saturating_mul(rows.saturating_sub(1));
    let bits = sum(first).saturating_add(later).saturating_mul(L);
    bits.div_ceil(8).saturating_add(K.saturating_mul(2))
}

/// Packs the rows and returns the bytes written.
///
/// # Errors
/// [`CodingError::Length`] if there is no room for them.
pub fn pack<'b, const K: usize, const L: usize>(
    rows: &[[[i32; L]; K]],
    bytes: &'b mut [u8],
) -> Result<&'b [u8], CodingError> {
    let widths = widths(rows);
    let room = bytes.get_mut(..length::<K, L>(&widths, rows.len())).ok_or(CodingError::Length)?;
    write(rows, &widths, room).ok_or(CodingError::Length)?;
    Ok(room)
}

fn write<const K: usize, const L: usize>(
    rows: &[[[i32; L]; K]],
    (first, later): &Widths<K>,
    bytes: &mut [u8],
) -> Option<()> {
    let (head, body) = bytes.split_at_mut_checked(K.checked_mul(2)?)?;
    for (place, bits) in head.iter_mut().zip(first.iter().chain(later)) {
        *place = *bits;
    }
    let mut writer = Writer { bytes: body, at: 0, held: 0, bits: 0 };
    let mut before = &[[0; L]; K];
    let mut widths = first;
    for row in rows {
        for ((values, before), width) in row.iter().zip(before).zip(widths) {
            for (value, before) in values.iter().zip(before) {
                writer.put(zigzag(value.wrapping_sub(*before)), u32::from(*width));
            }
        }
        (before, widths) = (row, later);
    }
    writer.finish();
    Some(())
}

/// Bits into bytes, the lowest first, a word at a time.
struct Writer<'b> {
    bytes: &'b mut [u8],
    at: usize,
    held: u32,
    bits: u32,
}

impl Writer<'_> {
    /// Appends `width` bits, at most 32; `code` has no others.
    #[inline]
    fn put(&mut self, code: u32, width: u32) {
        self.held |= code.wrapping_shl(self.bits);
        self.bits = self.bits.wrapping_add(width);
        if self.bits >= 32 {
            self.word();
            self.bits = self.bits.wrapping_sub(32);
            // What of the code did not fit; all of it did if no bits are left.
            let fitted = width.wrapping_sub(self.bits);
            self.held = code.checked_shr(fitted).unwrap_or(0);
        }
    }

    #[inline]
    fn word(&mut self) {
        let end = self.at.wrapping_add(4);
        if let Some(place) = self.bytes.get_mut(self.at..end) {
            place.copy_from_slice(&self.held.to_le_bytes());
        }
        self.at = end;
    }

    /// The bytes of the word that is not full.
    fn finish(self) {
        let left = self.bits.div_ceil(8) as usize;
        let held = self.held.to_le_bytes();
        let end = self.at.saturating_add(left);
        for (place, byte) in self.bytes.get_mut(self.at..end).into_iter().flatten().zip(held) {
            *place = byte;
        }
    }
}

/// Reads a table of `rows.len()` rows.
///
/// # Errors
/// [`CodingError`] if the bytes are not exactly that table.
pub fn unpack<const K: usize, const L: usize>(
    bytes: &[u8],
    rows: &mut [[[i32; L]; K]],
) -> Result<(), CodingError> {
    let (first, bytes_left) = bytes.split_first_chunk::<K>().ok_or(CodingError::Length)?;
    let (later, body) = bytes_left.split_first_chunk::<K>().ok_or(CodingError::Length)?;
    if let Some(bits) = first.iter().chain(later).find(|bits| **bits > 32) {
        return Err(CodingError::Bits(*bits));
    }
    if length::<K, L>(&(*first, *later), rows.len()) != bytes.len() {
        return Err(CodingError::Length);
    }
    let mut reader = Reader { bytes: body.iter(), held: 0, bits: 0 };
    let mut before = [[0_i32; L]; K];
    let mut widths = first;
    for row in rows {
        for ((values, before), width) in row.iter_mut().zip(&mut before).zip(widths) {
            for (value, before) in values.iter_mut().zip(before) {
                *before = before.wrapping_add(unzigzag(reader.take(u32::from(*width))));
                *value = *before;
            }
        }
        widths = later;
    }
    Ok(())
}

/// Bytes into bits; zeros after the end.
struct Reader<'b> {
    bytes: core::slice::Iter<'b, u8>,
    held: u64,
    bits: u32,
}

impl Reader<'_> {
    fn take(&mut self, width: u32) -> u32 {
        while self.bits < width {
            let byte = self.bytes.next().copied().unwrap_or(0);
            self.held |= u64::from(byte).wrapping_shl(self.bits);
            self.bits = self.bits.wrapping_add(8);
        }
        let code = self.held & 1_u64.wrapping_shl(width).wrapping_sub(1);
        self.held = self.held.wrapping_shr(width);
        self.bits = self.bits.wrapping_sub(width);
        code as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_bits_are_those_of_the_head_comment() {
        // First row 3 and −1: codes 6 and 1 in 3 bits each; then differences 1 and 0: codes 2 and 0 in 2 bits each.
        let rows = [[[3, -1]], [[4, -1]]];
        let mut bytes = [0; 8];
        let packed = pack(&rows, &mut bytes);
        assert_eq!(packed, Ok(&[3, 2, 0b1000_1110, 0][..]));
    }

    #[test]
    fn rows_without_room_are_refused() {
        let rows = [[[i32::MAX; 4]; 3], [[i32::MIN; 4]; 3]];
        let mut bytes = [0; 6 + 2 * 12 * 4];
        assert_eq!(pack(&rows, &mut bytes).map(<[u8]>::len), Ok(6 + 12 * 4 + 12 * 2 / 8));
        assert_eq!(pack(&rows, &mut bytes[..20]), Err(CodingError::Length));
    }

    #[test]
    fn four_gauges_of_a_quiet_press_take_less_than_sixteen_bytes_a_row() {
        let rows: Vec<[[i32; 4]; 3]> = (0..16_i32)
            .map(|i| {
                [
                    [400_000 + 60 * (i * 37 % 11 - 5); 4],
                    [20 * (i % 3); 4],
                    [300_000 + 50 * (i % 5); 4],
                ]
            })
            .collect();
        let mut bytes = [0; 240];
        let packed = pack(&rows, &mut bytes).unwrap();
        assert!(packed.len() < 16 * 16, "{} bytes", packed.len());
    }

    fn any_value() -> impl Strategy<Value = i32> {
        prop_oneof![any::<i32>(), -100..100_i32, Just(0)]
    }

    proptest! {
        #[test]
        fn every_table_comes_back(
            rows in prop::collection::vec(any::<[[u8; 4]; 2]>(), 0..16),
            wide in prop::collection::vec(prop::array::uniform2(prop::array::uniform4(any_value())), 0..16),
        ) {
            let narrow: Vec<_> = rows.iter().map(|row| row.map(|kind| kind.map(i32::from))).collect();
            for rows in [narrow, wide] {
                let mut bytes = [0; 1_024];
                let mut read = vec![[[0; 4]; 2]; rows.len()];
                unpack(pack(&rows, &mut bytes).unwrap(), &mut read).unwrap();
                prop_assert_eq!(read, rows);
            }
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..64), rows in 0_usize..20) {
            let mut read = vec![[[0; 4]; 3]; rows];
            let _ = unpack(&bytes, &mut read);
        }
    }
}
