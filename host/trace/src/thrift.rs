//! Headers of Parquet files, in Thrift's compact protocol, looked through before the library reads them. It passes one by one over the
//! elements of a list that it does not know, and booleans take no bytes there, however many are declared: 5 kB can take hours. Fields that
//! it knows it reads without a look at the kind that the file gives them, so that another one makes it see lists that are none.

use std::io::{self, ErrorKind, Read};

/// What a field holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Bool,
    Byte,
    /// An integer of two to eight bytes.
    Number,
    Double,
    Text,
    List(&'static Kind),
    /// A struct or a union, with its fields 1, 2, … in turn.
    Struct(&'static [Kind]),
}

impl Kind {
    /// Whether this is what the protocol calls so.
    const fn is(self, code: u8) -> bool {
        match self {
            Self::Bool => matches!(code, 1 | 2),
            Self::Byte => code == 3,
            Self::Number => matches!(code, 4..=6),
            Self::Double => code == 7,
            Self::Text => code == 8,
            Self::List(_) => matches!(code, 9 | 10),
            Self::Struct(_) => code == 12,
        }
    }
}

/// Most elements without a byte of their own: as many as a list can have whose length has no byte of its own either.
const MOST_EMPTY: u64 = 15;
/// Deepest values within values; the library goes less deep.
const DEEPEST: u8 = 100;

/// Looks through a header with these fields from its first byte to its end. Damage is left to the library to tell.
///
/// # Errors
/// [`ErrorKind::InvalidData`] where it declares more elements than it can have bytes for, or a field of another kind.
pub(super) fn look_through(header: impl Read, fields: &[Kind]) -> io::Result<()> {
    match Header(header).fields(fields, DEEPEST) {
        Err(error) if error.kind() == ErrorKind::InvalidData => Err(error),
        _ => Ok(()),
    }
}

fn refused<T>(problem: String) -> io::Result<T> {
    Err(io::Error::new(ErrorKind::InvalidData, problem))
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
    fn fields(&mut self, known: &[Kind], depth: u8) -> io::Result<()> {
        let mut id = 0_i64;
        loop {
            let field = self.byte()?;
            if field & 0xf == 0 {
                return Ok(());
            }
            id = match field >> 4 {
                0 => {
                    // A number of either sign, its sign in the last bit.
                    let number = self.number()?;
                    (number >> 1) as i64 ^ -((number & 1) as i64)
                }
                more => id + i64::from(more),
            };
            let kind = id.checked_sub(1).and_then(|place| usize::try_from(place).ok());
            let kind = kind.and_then(|place| known.get(place));
            if kind.is_some_and(|kind| !kind.is(field & 0xf)) {
                return refused(format!(
                    "field {id} of a header is not of the kind it has in Parquet"
                ));
            }
            self.value(field & 0xf, kind, depth)?;
        }
    }

    fn value(&mut self, code: u8, kind: Option<&Kind>, depth: u8) -> io::Result<()> {
        match code {
            // A boolean is its kind.
            1 | 2 => Ok(()),
            3 => self.pass(1),
            4..=6 => self.number().map(drop),
            7 => self.pass(8),
            8 => {
                let length = self.number()?;
                self.pass(length)
            }
            9 | 10 => self.list(kind, depth),
            11 => {
                let count = self.number()?;
                let codes = if count > 0 { self.byte()? } else { 0 };
                self.elements(count, &[codes >> 4, codes & 0xf], None, depth)
            }
            12 if depth > 0 => {
                let known: &[Kind] = if let Some(Kind::Struct(known)) = kind { known } else { &[] };
                self.fields(known, depth - 1)
            }
            13 => self.pass(16),
            _ => Err(ErrorKind::UnexpectedEof.into()),
        }
    }

    fn list(&mut self, kind: Option<&Kind>, depth: u8) -> io::Result<()> {
        let list = self.byte()?;
        let count = if list >> 4 == 15 { self.number()? } else { (list >> 4).into() };
        let kind = if let Some(Kind::List(of)) = kind { Some(*of) } else { None };
        if count > 0 && kind.is_some_and(|kind| !kind.is(list & 0xf)) {
            return refused("a list of a header is not of the kind it has in Parquet".into());
        }
        self.elements(count, &[list & 0xf], kind, depth)
    }

    /// As many values of these kinds as are declared.
    fn elements(
        &mut self,
        count: u64,
        codes: &[u8],
        kind: Option<&Kind>,
        depth: u8,
    ) -> io::Result<()> {
        if count > MOST_EMPTY && codes.iter().all(|code| matches!(code, 1 | 2)) {
            return refused(format!("a header declares {count} values that have no bytes"));
        }
        let Some(deeper) = depth.checked_sub(1) else {
            return Err(ErrorKind::UnexpectedEof.into());
        };
        for _ in 0..count {
            codes.iter().try_for_each(|code| self.value(*code, kind, deeper))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::parquet_header::FILE;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_without_bytes_are_refused_and_damage_is_not_told_here() {
        let refused = |bytes: &[u8]| look_through(bytes, &[]).is_err();
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

    #[test]
    fn a_field_of_another_kind_than_it_has_in_the_format_is_refused() {
        let refused = |bytes: &[u8]| look_through(bytes, FILE).is_err();
        // Field 2 is a list of structs, of which the fourth field is a text; field 3 is a number.
        assert!(!refused(&[0x15, 2, 0x19, 0x1c, 0x48, 1, b'x', 0, 0x16, 0, 0]));
        assert!(refused(&[0x18, 1, b'x', 0]));
        assert!(refused(&[0x15, 2, 0x19, 0x15, 0, 0]));
        assert!(refused(&[0x15, 2, 0x19, 0x1c, 0x45, 0, 0, 0]));
        // A field by its own number, and fields that are not known.
        assert!(refused(&[0x08, 2, 1, b'x', 0]) && !refused(&[0x05, 2, 2, 0]));
        assert!(!refused(&[0x08, 30, 1, b'x', 0]) && !refused(&[0x08, 1, 1, b'x', 0]));
    }

    proptest! {
        #[test]
        fn every_header_is_looked_through(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = look_through(&bytes[..], FILE);
        }
    }
}
