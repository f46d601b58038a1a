//! Texts and numbers as TDMS stores them.

/// Seconds from 1904, where LabVIEW's time begins, to 1970.
const TO_1970_S: i64 = 2_082_844_800;
/// Times that are counted from farther than this, s, count from their first whole second instead.
const AFAR_S: i64 = 1_000_000;

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
    /// Seconds since 1904 and a fraction.
    Time,
    Text,
}

impl Kind {
    /// The kind of that number in the file.
    pub(super) fn of(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::Signed(1),
            2 => Self::Signed(2),
            3 => Self::Signed(4),
            4 => Self::Signed(8),
            5 | 0x21 => Self::Unsigned(1),
            6 => Self::Unsigned(2),
            7 => Self::Unsigned(4),
            8 => Self::Unsigned(8),
            9 | 0x19 => Self::Float(4),
            10 | 0x1A => Self::Float(8),
            0x44 => Self::Time,
            0x20 => Self::Text,
            _ => return None,
        })
    }

    /// Bytes of one; texts have none of their own.
    pub(super) fn size(self) -> Option<usize> {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Float(size) => Some(size),
            Self::Time => Some(16),
            Self::Text => None,
        }
    }

    pub(super) fn is_number(self) -> bool {
        self != Self::Text
    }

    /// The number in as many bytes as it has. The first time sets the whole second from which times count.
    pub(super) fn number(self, raw: &[u8], swapped: bool, origin: &mut Option<i64>) -> f64 {
        let mut bytes = [0; 16];
        bytes[..raw.len()].copy_from_slice(raw);
        if swapped {
            bytes[..raw.len()].reverse();
        }
        let [low, high] = [0, 8].map(|at| {
            let mut eight = [0; 8];
            eight.copy_from_slice(&bytes[at..at + 8]);
            u64::from_le_bytes(eight)
        });
        match self {
            Self::Signed(1) => f64::from(low as i8),
            Self::Signed(2) => f64::from(low as i16),
            Self::Signed(4) => f64::from(low as i32),
            Self::Signed(_) => (low as i64) as f64,
            Self::Float(4) => f64::from(f32::from_bits(low as u32)),
            Self::Float(_) => f64::from_bits(low),
            Self::Time => {
                let seconds = (high as i64).saturating_sub(TO_1970_S);
                let afar = seconds.checked_abs().is_none_or(|size| size > AFAR_S);
                let origin = *origin.get_or_insert(if afar { seconds } else { 0 });
                seconds.saturating_sub(origin) as f64 + low as f64 / 2_f64.powi(64)
            }
            _ => low as f64,
        }
    }
}

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Text(String),
}

impl Value {
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Text(_) => None,
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text.trim()),
            Self::Number(_) => None,
        }
    }
}

/// Bytes from which numbers and texts are cut; none where they end.
pub(super) struct Bytes<'a> {
    pub(super) rest: &'a [u8],
    pub(super) swapped: bool,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        let four: [u8; 4] = self.take(4)?.try_into().ok()?;
        Some(if self.swapped { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        let eight: [u8; 8] = self.take(8)?.try_into().ok()?;
        Some(if self.swapped { u64::from_be_bytes(eight) } else { u64::from_le_bytes(eight) })
    }

    pub(super) fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        self.take(length).map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }

    /// The value of a property, its type in front.
    pub(super) fn value(&mut self) -> Option<Value> {
        let kind = Kind::of(self.u32()?)?;
        match kind.size() {
            None => self.text().map(Value::Text),
            Some(size) => {
                let raw = self.take(size)?;
                Some(Value::Number(kind.number(raw, self.swapped, &mut Some(0))))
            }
        }
    }
}
