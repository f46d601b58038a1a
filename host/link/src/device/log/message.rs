//! One message of a log: its bytes and its string make its words.

use std::collections::BTreeMap;
use std::fmt::Write;

use defmt_parser::{DisplayHint, Fragment, ParserMode, TimePrecision, Type, parse};

use super::strings::Strings;

/// Deepest nesting of a value: a frame that was damaged must not lead deeper.
const MAX_NESTING: usize = 32;
/// Most elements of a list.
const MAX_ELEMENTS: usize = 4096;
/// Widest number, in digits: as many as the largest has bits.
const MAX_DIGITS: usize = 130;

/// A value that a message brings.
enum Value<'s> {
    Bool(bool),
    Char(char),
    /// A number as it is printed.
    Float(String),
    Unsigned(u128),
    /// A number, and how many bits it has.
    Signed(i128, u32),
    Text(String),
    Bytes(Vec<u8>),
    /// A value that says how it is put into words.
    Nested(Nested<'s>),
    /// Several, one behind the other.
    Sequence(Vec<Nested<'s>>),
    /// Several, as a list.
    List(Vec<Nested<'s>>),
}

struct Nested<'s> {
    format: &'s str,
    values: Vec<Value<'s>>,
}

/// The words of a frame: time, level, message; none where its bytes have no meaning.
pub(super) fn words(strings: &Strings, frame: &[u8]) -> Option<String> {
    let mut reader = Reader { strings, bytes: frame };
    let address = reader.address()?;
    let mut line = String::new();
    if let Some(format) = &strings.timestamp {
        let values = reader.values(format, 0)?;
        line = in_words(format, &values, None)? + " ";
    }
    let text = strings.at(address)?;
    let values = reader.values(&text.format, 0)?;
    if let Some(level) = text.level {
        line += level;
        line.push(' ');
    }
    Some(line + &in_words(&text.format, &values, None)?)
}

/// The bytes of a frame that are not yet read.
struct Reader<'s, 'b> {
    strings: &'s Strings,
    bytes: &'b [u8],
}

impl<'s> Reader<'s, '_> {
    fn take(&mut self, count: usize) -> Option<&[u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    /// A number of so many bytes, least first.
    fn number(&mut self, bytes: usize) -> Option<u128> {
        let mut whole = [0; 16];
        whole.get_mut(..bytes)?.copy_from_slice(self.take(bytes)?);
        Some(u128::from_le_bytes(whole))
    }

    fn signed(&mut self, bytes: usize) -> Option<Value<'s>> {
        let bits = 8 * u32::try_from(bytes).ok()?;
        let above = 128 - bits;
        let number = (self.number(bytes)? << above).cast_signed() >> above;
        Some(Value::Signed(number, bits))
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(self.number(4)?).ok()
    }

    fn address(&mut self) -> Option<u16> {
        u16::try_from(self.number(2)?).ok()
    }

    /// The values that a format asks for, in the order of their numbers.
    fn values(&mut self, format: &str, depth: usize) -> Option<Vec<Value<'s>>> {
        if depth > MAX_NESTING {
            return None;
        }
        types(format)?.into_values().map(|kind| self.value(&kind, depth)).collect()
    }

    fn value(&mut self, kind: &Type, depth: usize) -> Option<Value<'s>> {
        Some(match kind {
            Type::Bool => Value::Bool(match self.number(1)? {
                0 => false,
                1 => true,
                _ => return None,
            }),
            Type::Char => Value::Char(u32::try_from(self.number(4)?).ok()?.try_into().ok()?),
            Type::F32 => {
                let number = f32::from_bits(u32::try_from(self.number(4)?).ok()?);
                Value::Float(format!("{number:?}"))
            }
            Type::F64 => {
                let number = f64::from_bits(u64::try_from(self.number(8)?).ok()?);
                Value::Float(format!("{number:?}"))
            }
            Type::U8 => Value::Unsigned(self.number(1)?),
            Type::U16 => Value::Unsigned(self.number(2)?),
            Type::U32 | Type::Usize => Value::Unsigned(self.number(4)?),
            Type::U64 => Value::Unsigned(self.number(8)?),
            Type::U128 => Value::Unsigned(self.number(16)?),
            Type::I8 => self.signed(1)?,
            Type::I16 => self.signed(2)?,
            Type::I32 | Type::Isize => self.signed(4)?,
            Type::I64 => self.signed(8)?,
            Type::I128 => self.signed(16)?,
            Type::BitField(range) => {
                let lowest = range.start / 8;
                let bytes = usize::from((range.end.checked_sub(1)? / 8).checked_sub(lowest)? + 1);
                Value::Unsigned(self.number(bytes.next_power_of_two())? << (8 * lowest))
            }
            Type::Str => {
                let length = self.count()?;
                Value::Text(text(self.take(length)?)?)
            }
            Type::IStr => {
                let address = self.address()?;
                Value::Text(self.strings.part(address)?.to_owned())
            }
            // Text that the device made, up to a byte that text never has.
            Type::Debug | Type::Display => {
                let length = self.bytes.iter().position(|byte| *byte == 0xff)?;
                let made = text(self.take(length)?)?;
                self.take(1)?;
                Value::Text(made)
            }
            Type::U8Slice => {
                let length = self.count()?;
                Value::Bytes(self.take(length)?.to_vec())
            }
            Type::U8Array(length) => Value::Bytes(self.take(*length)?.to_vec()),
            Type::Format => {
                let address = self.address()?;
                Value::Nested(self.nested(self.strings.part(address)?, depth)?)
            }
            Type::FormatSequence => {
                let mut sequence = Vec::new();
                loop {
                    match self.address()? {
                        0 => break,
                        address => {
                            let format = self.strings.part(address)?;
                            let values = self.values(format, depth + 1)?;
                            sequence.push(Nested { format, values });
                        }
                    }
                }
                Value::Sequence(sequence)
            }
            Type::FormatSlice => {
                let length = self.count()?;
                self.list(length, depth)?
            }
            Type::FormatArray(length) => self.list(*length, depth)?,
        })
    }

    /// A value that says how it is put into words; of an enumeration a number chooses one of the formats.
    fn nested(&mut self, format: &'s str, depth: usize) -> Option<Nested<'s>> {
        let format = match format.matches('|').count() {
            0 => format,
            others => {
                let bytes = if others < 1 << 8 { 1 } else { 2 };
                format.split('|').nth(usize::try_from(self.number(bytes)?).ok()?)?
            }
        };
        Some(Nested { format, values: self.values(format, depth + 1)? })
    }

    fn list(&mut self, length: usize, depth: usize) -> Option<Value<'s>> {
        let address = self.address()?;
        let format = self.strings.part(address)?;
        if length > MAX_ELEMENTS {
            return None;
        }
        let elements = (0..length).map(|_| self.nested(format, depth));
        elements.collect::<Option<_>>().map(Value::List)
    }
}

fn text(bytes: &[u8]) -> Option<String> {
    std::str::from_utf8(bytes).ok().map(str::to_owned)
}

/// What a format asks for, by the number of the value. Bit fields of one value are read as one.
fn types(format: &str) -> Option<BTreeMap<usize, Type>> {
    let mut types = BTreeMap::new();
    for fragment in parse(format, ParserMode::ForwardsCompatible).ok()? {
        let Fragment::Parameter(parameter) = fragment else { continue };
        match (types.get_mut(&parameter.index), parameter.ty) {
            (Some(Type::BitField(known)), Type::BitField(more)) => {
                *known = known.start.min(more.start)..known.end.max(more.end);
            }
            (Some(_), _) => {}
            (None, kind) => {
                types.insert(parameter.index, kind);
            }
        }
    }
    Some(types)
}

/// A format with its values put in. How a value is to be shown is said with it, or else by `outer`, where it is a part of another.
fn in_words(format: &str, values: &[Value], outer: Option<&DisplayHint>) -> Option<String> {
    let mut words = String::new();
    for fragment in parse(format, ParserMode::ForwardsCompatible).ok()? {
        match fragment {
            Fragment::Literal(literal) => words += &literal,
            Fragment::Parameter(parameter) => {
                let hint = parameter.hint.as_ref().or(outer);
                words += &match (values.get(parameter.index)?, &parameter.ty) {
                    (Value::Unsigned(whole), Type::BitField(range)) => {
                        let above = 128_u32.checked_sub(range.end.into())?;
                        let bits = (whole << above) >> (above + u32::from(range.start));
                        match hint {
                            Some(DisplayHint::Ascii) => {
                                let unused = ((above + u32::from(range.start)) / 8) as usize;
                                in_ascii(bits.to_be_bytes().get(unused..)?)
                            }
                            _ => unsigned(bits, hint),
                        }
                    }
                    (Value::Unsigned(number), _) => match hint {
                        Some(DisplayHint::Debug) => unsigned(*number, outer),
                        _ => unsigned(*number, hint),
                    },
                    (Value::Nested(nested), _) => match outer {
                        Some(DisplayHint::Ascii) => nested.in_words(outer)?,
                        _ => nested.in_words(hint)?,
                    },
                    (value, _) => value.in_words(hint)?,
                };
            }
        }
    }
    Some(words)
}

impl Nested<'_> {
    fn in_words(&self, hint: Option<&DisplayHint>) -> Option<String> {
        in_words(self.format, &self.values, hint)
    }
}

impl Value<'_> {
    fn in_words(&self, hint: Option<&DisplayHint>) -> Option<String> {
        let all = |parts: &[Nested]| -> Option<Vec<String>> {
            parts.iter().map(|part| part.in_words(hint)).collect()
        };
        Some(match self {
            Self::Bool(value) => value.to_string(),
            Self::Char(value) => value.to_string(),
            Self::Float(value) => value.clone(),
            Self::Unsigned(value) => unsigned(*value, hint),
            Self::Signed(value, bits) => signed(*value, *bits, hint),
            Self::Text(value) if hint == Some(&DisplayHint::Debug) => format!("{value:?}"),
            Self::Text(value) => value.clone(),
            Self::Bytes(bytes) => of_bytes(bytes, hint),
            Self::Nested(nested) => nested.in_words(hint)?,
            Self::Sequence(parts) => all(parts)?.concat(),
            Self::List(parts) => match (hint, letters(parts)) {
                (Some(DisplayHint::Ascii), Some(bytes)) => in_ascii(&bytes),
                _ => format!("[{}]", all(parts)?.join(", ")),
            },
        })
    }
}

/// The bytes of a list that has nothing else, and at least one.
fn letters(parts: &[Nested]) -> Option<Vec<u8>> {
    let letter = |part: &Nested| match (part.format, &*part.values) {
        ("{=u8}", [Value::Unsigned(byte)]) => u8::try_from(*byte).ok(),
        _ => None,
    };
    (!parts.is_empty()).then(|| parts.iter().map(letter).collect()).flatten()
}

fn of_bytes(bytes: &[u8], hint: Option<&DisplayHint>) -> String {
    match hint {
        Some(DisplayHint::Ascii) => in_ascii(bytes),
        Some(
            DisplayHint::Hexadecimal { .. }
            | DisplayHint::Octal { .. }
            | DisplayHint::Binary { .. },
        ) => {
            let all: Vec<String> =
                bytes.iter().map(|byte| unsigned((*byte).into(), hint)).collect();
            format!("[{}]", all.join(", "))
        }
        _ => format!("{bytes:?}"),
    }
}

/// As a byte string of Rust.
fn in_ascii(bytes: &[u8]) -> String {
    let mut words = String::from("b\"");
    for byte in bytes {
        match byte {
            b'\t' => words += "\\t",
            b'\n' => words += "\\n",
            b'\r' => words += "\\r",
            b'"' => words += "\\\"",
            b'\\' => words += "\\\\",
            b' '..=b'~' => words.push(char::from(*byte)),
            // A text takes every byte.
            _ => drop(write!(words, "\\x{byte:02x}")),
        }
    }
    words + "\""
}

fn unsigned(x: u128, hint: Option<&DisplayHint>) -> String {
    let pad = |digits: &usize| (*digits).min(MAX_DIGITS);
    match hint {
        Some(DisplayHint::NoHint { zero_pad }) => format!("{x:0pad$}", pad = pad(zero_pad)),
        Some(DisplayHint::Binary { alternate, zero_pad }) => match (pad(zero_pad), alternate) {
            (pad, true) => format!("{x:#0pad$b}"),
            (pad, false) => format!("{x:0pad$b}"),
        },
        Some(DisplayHint::Octal { alternate, zero_pad }) => match (pad(zero_pad), alternate) {
            (pad, true) => format!("{x:#0pad$o}"),
            (pad, false) => format!("{x:0pad$o}"),
        },
        Some(DisplayHint::Hexadecimal { alternate, uppercase, zero_pad }) => {
            match (pad(zero_pad), alternate, uppercase) {
                (pad, true, true) => format!("{x:#0pad$X}"),
                (pad, true, false) => format!("{x:#0pad$x}"),
                (pad, false, true) => format!("{x:0pad$X}"),
                (pad, false, false) => format!("{x:0pad$x}"),
            }
        }
        Some(DisplayHint::Seconds(TimePrecision::Micros)) => {
            format!("{}.{:06}", x / 1_000_000, x % 1_000_000)
        }
        Some(DisplayHint::Seconds(TimePrecision::Millis)) => {
            format!("{}.{:03}", x / 1_000, x % 1_000)
        }
        Some(DisplayHint::Time(precision)) => clock(x, precision),
        _ => x.to_string(),
    }
}

fn signed(x: i128, bits: u32, hint: Option<&DisplayHint>) -> String {
    match hint {
        Some(DisplayHint::NoHint { zero_pad }) => {
            format!("{x:0pad$}", pad = (*zero_pad).min(MAX_DIGITS))
        }
        Some(DisplayHint::Binary { .. } | DisplayHint::Octal { .. }) => {
            unsigned(x.cast_unsigned(), hint)
        }
        Some(DisplayHint::Hexadecimal { .. }) => {
            unsigned(x.cast_unsigned() & (u128::MAX >> (128 - bits)), hint)
        }
        _ => x.to_string(),
    }
}

/// A time as days, hours, minutes, seconds.
fn clock(time: u128, precision: &TimePrecision) -> String {
    let (seconds, part) = match precision {
        TimePrecision::Micros => (time / 1_000_000, format!(".{:06}", time % 1_000_000)),
        TimePrecision::Millis => (time / 1_000, format!(".{:03}", time % 1_000)),
        TimePrecision::Seconds => (time, String::new()),
    };
    let (minutes, hours) = (seconds / 60, seconds / 3600);
    let days = match hours / 24 {
        0 => String::new(),
        days => format!("{days}:"),
    };
    format!("{days}{:02}:{:02}:{:02}{part}", hours % 24, minutes % 60, seconds % 60)
}
