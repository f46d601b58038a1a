//! Headers of Parquet files, in Thrift's compact protocol, looked through before the library reads them. It passes one by one over the
//! elements of a list that it does not know, and booleans take no bytes there, however many are declared: 5 kB can take hours.

use std::io::{self, ErrorKind, Read};

/// Most elements without a byte of their own: as many as a list can have whose length has no byte of its own either.
const MOST_EMPTY: u64 = 15;
/// Deepest values within values; the library goes less deep.
const DEEPEST: u8 = 100;

/// Looks through a header from its first byte to its end. Damage is left to the library to tell.
///
/// # Errors
/// [`ErrorKind::InvalidData`] where it declares more elements than it can have bytes for.
pub(super) fn look_through(header: impl Read) -> io::Result<()> {
    match Header(header).fields(DEEPEST) {
        Err(error) if error.kind() == ErrorKind::InvalidData => Err(error),
        _ => Ok(()),
    }
}

struct Header<R>(R);

impl<R: Read> Header<R> {
    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.0.read_exact(&mut byte)?;
        Ok(byte[0])
    }

    /// An integer of any length; what exceeds 64 bits is lost.
    fn number(&mut self) -> io::Result<u64> {
        let (mut number, mut shift) = (0, 0_u32);
        loop {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f).checked_shl(shift).unwrap_or(0);
            if byte & 0x80 == 0 {
                return Ok(number);
            }
            shift = shift.saturating_add(7);
        }
    }

    fn pass(&mut self, count: u64) -> io::Result<()> {
        let passed = io::copy(&mut self.0.by_ref().take(count), &mut io::sink())?;
        if passed < count { Err(ErrorKind::UnexpectedEof.into()) } else { Ok(()) }
    }

    /// The fields of a struct, and its end.
    fn fields(&mut self, depth: u8) -> io::Result<()> {
        loop {
            let field = self.byte()?;
            if field & 0xf == 0 {
                return Ok(());
            }
            if field >> 4 == 0 {
                self.number()?;
            }
            self.value(field & 0xf, depth)?;
        }
    }

    fn value(&mut self, kind: u8, depth: u8) -> io::Result<()> {
        match kind {
            // A boolean is its kind.
            1 | 2 => Ok(()),
            3 => self.pass(1),
            4..=6 => self.number().map(drop),
            7 => self.pass(8),
            8 => {
                let length = self.number()?;
                self.pass(length)
            }
            9 | 10 => {
                let list = self.byte()?;
                let count = if list >> 4 == 15 { self.number()? } else { (list >> 4).into() };
                self.elements(count, &[list & 0xf], depth)
            }
            11 => {
                let count = self.number()?;
                let kinds = if count > 0 { self.byte()? } else { 0 };
                self.elements(count, &[kinds >> 4, kinds & 0xf], depth)
            }
            12 if depth > 0 => self.fields(depth - 1),
            13 => self.pass(16),
            _ => Err(ErrorKind::UnexpectedEof.into()),
        }
    }

    /// As many values of these kinds as are declared.
    fn elements(&mut self, count: u64, kinds: &[u8], depth: u8) -> io::Result<()> {
        if count > MOST_EMPTY && kinds.iter().all(|kind| matches!(kind, 1 | 2)) {
            let problem = format!("a header declares {count} values that have no bytes");
            return Err(io::Error::new(ErrorKind::InvalidData, problem));
        }
        let Some(deeper) = depth.checked_sub(1) else {
            return Err(ErrorKind::UnexpectedEof.into());
        };
        for _ in 0..count {
            kinds.iter().try_for_each(|kind| self.value(*kind, deeper))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_without_bytes_are_refused_and_damage_is_not_told_here() {
        let refused = |bytes: &[u8]| look_through(bytes).is_err();
        // Field 1 is a list of 2^28 booleans, by itself and in a list of a struct.
        assert!(refused(&[0x19, 0xf1, 0x80, 0x80, 0x80, 0x80, 0x01, 0]));
        assert!(refused(&[0x19, 0x1c, 0x19, 0xf2, 0x80, 0x80, 0x80, 0x80, 0x01, 0, 0]));
        // A map of as many to as many.
        assert!(refused(&[0x1b, 0x80, 0x80, 0x80, 0x80, 0x01, 0x12, 0]));
        // Fifteen of them, a text, a number of any length, and the end.
        assert!(!refused(&[0x19, 0xe1, 0x18, 2, b'a', b'b', 0x16, 0xff, 0x7f, 0]));
        // A list and a text that go on beyond the end; values in values in values.
        assert!(!refused(&[0x19, 0xf5, 0x80, 0x80, 0x80, 0x80, 0x01]));
        assert!(!refused(&[0x18, 0x7f]));
        assert!(!refused(&[0x1c; 1000]) && !refused(&[0x19; 1000]));
    }

    proptest! {
        #[test]
        fn every_header_is_looked_through(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = look_through(&bytes[..]);
        }
    }
}
