//! Messages of ROS 2 as bytes (CDR): numbers at places that are multiples of their size.

use super::columns::Columns;
use super::schema::{Count, Kind, Message, Schema};

/// How deep messages within messages are followed.
const DEPTH: usize = 32;
/// Most numbers of one array that become columns; longer ones are images and clouds and are passed over.
const MEMBERS: usize = 64;

/// Walks through one message and puts its numbers into columns.
pub(super) struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    swapped: bool,
    /// Largest multiple that is kept to.
    align: usize,
}

/// What a type measures by its definition: type, field, unit.
const UNITS: [(&str, &str, &str); 6] = [
    ("geometry_msgs/Wrench", "force", "N"),
    ("geometry_msgs/Wrench", "torque", "Nm"),
    ("sensor_msgs/Temperature", "temperature", "C"),
    ("sensor_msgs/FluidPressure", "fluid_pressure", "Pa"),
    ("sensor_msgs/Range", "range", "m"),
    ("geometry_msgs/Pose", "position", "m"),
];

impl<'a> Cdr<'a> {
    /// Begins behind the four bytes that say how the rest is written.
    pub(super) fn new(message: &'a [u8]) -> Result<Self, String> {
        let (head, bytes) = message.split_at_checked(4).ok_or("the message is empty")?;
        let (swapped, align) = match head[1] {
            0 => (true, 8),
            1 => (false, 8),
            6 => (true, 4),
            7 => (false, 4),
            other => return Err(format!("CDR of kind {other} is not read")),
        };
        Ok(Self { bytes, at: 0, swapped, align })
    }

    /// Takes a message of the type at that place in the schema; its columns begin with `path`.
    pub(super) fn message(
        &mut self,
        schema: &Schema,
        at: usize,
        path: &mut String,
        unit: Option<&'static str>,
        out: &mut Columns,
        depth: usize,
    ) -> Result<(), String> {
        if depth > DEPTH {
            return Err(format!("messages within messages, more than {DEPTH} deep"));
        }
        let message = schema.message(at);
        if is_time(message) {
            let seconds = self.number(Kind::Signed(4))?;
            let nanoseconds = self.number(Kind::Unsigned(4))?;
            out.time(path, seconds as i64, nanoseconds as u32);
            return Ok(());
        }
        // What holds nothing is one byte.
        if message.fields.is_empty() {
            self.take(1)?;
        }
        let mut names = Vec::new();
        for field in &message.fields {
            let kept = path.len();
            if kept > 0 {
                path.push('.');
            }
            path.push_str(&field.name);
            let own = UNITS.iter().find(|(of, name, _)| *of == message.name && *name == field.name);
            let unit = own.map(|(.., unit)| *unit).or(unit);
            let count = match field.count {
                Count::One => None,
                Count::Fixed(count) => Some(count),
                Count::Any => Some(self.number(Kind::Unsigned(4))? as usize),
            };
            match (count, field.kind) {
                (None, kind) => self.one(schema, kind, path, unit, out, depth)?,
                (Some(count), Kind::Text) if field.name == "name" => names = self.names(count)?,
                (Some(count), kind) => {
                    let names = if names.len() == count { &names[..] } else { &[] };
                    self.array(schema, kind, count, names, path, unit, out, depth)?;
                }
            }
            path.truncate(kept);
        }
        Ok(())
    }

    /// Takes the members of an array; they are called by their names where the message gives some, else by number.
    #[allow(clippy::too_many_arguments)]
    fn array(
        &mut self,
        schema: &Schema,
        kind: Kind,
        count: usize,
        names: &[String],
        path: &mut String,
        unit: Option<&'static str>,
        out: &mut Columns,
        depth: usize,
    ) -> Result<(), String> {
        let size = match kind {
            Kind::Bool => 1,
            Kind::Unsigned(size) | Kind::Signed(size) | Kind::Float(size) => size,
            Kind::Text | Kind::Wide => 4,
            Kind::Message(_) => 1,
        };
        if count > 0 {
            let most = (self.bytes.len() - self.at.min(self.bytes.len())) / size;
            if count > most {
                return Err(format!("`{path}` is to have {count} members, {most} are there"));
            }
        }
        // Long ones are walked through for what comes after them.
        let mut nowhere = Columns::nowhere();
        let out = if count > MEMBERS { &mut nowhere } else { out };
        for index in 0..count {
            let kept = path.len();
            path.push('.');
            match names.get(index) {
                Some(name) => path.push_str(name),
                None => path.push_str(&index.to_string()),
            }
            self.one(schema, kind, path, unit, out, depth)?;
            path.truncate(kept);
        }
        Ok(())
    }

    fn one(
        &mut self,
        schema: &Schema,
        kind: Kind,
        path: &mut String,
        unit: Option<&'static str>,
        out: &mut Columns,
        depth: usize,
    ) -> Result<(), String> {
        match kind {
            Kind::Text => self.text().map(drop),
            Kind::Wide => Err(format!("`{path}` is text of wide letters, which is not read")),
            Kind::Message(at) => self.message(schema, at, path, unit, out, depth + 1),
            number => {
                let value = self.number(number)?;
                out.number(path, unit, value);
                Ok(())
            }
        }
    }

    fn names(&mut self, count: usize) -> Result<Vec<String>, String> {
        (0..count).map(|_| self.text()).collect()
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.number(Kind::Unsigned(4))? as usize;
        let bytes = self.take(length)?;
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(length);
        Ok(String::from_utf8_lossy(&bytes[..end]).into_owned())
    }

    fn number(&mut self, kind: Kind) -> Result<f64, String> {
        let size = match kind {
            Kind::Unsigned(size) | Kind::Signed(size) | Kind::Float(size) => size,
            _ => 1,
        };
        self.at = self.at.next_multiple_of(size.min(self.align));
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(self.take(size)?);
        if self.swapped {
            bytes[..size].reverse();
        }
        let whole = u64::from_le_bytes(bytes);
        Ok(match kind {
            Kind::Float(4) => f64::from(f32::from_bits(whole as u32)),
            Kind::Float(_) => f64::from_bits(whole),
            Kind::Signed(1) => f64::from(whole as i8),
            Kind::Signed(2) => f64::from(whole as i16),
            Kind::Signed(4) => f64::from(whole as i32),
            Kind::Signed(_) => (whole as i64) as f64,
            _ => whole as f64,
        })
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.bytes.len());
        let end = end.ok_or_else(|| format!("it ends after {} bytes", self.bytes.len()))?;
        let bytes = &self.bytes[self.at..end];
        self.at = end;
        Ok(bytes)
    }
}

/// Whether a message is seconds and nanoseconds.
fn is_time(message: &Message) -> bool {
    let fields = message.fields.iter().map(|field| field.name.as_str());
    message.name.starts_with("builtin_interfaces/") && fields.eq(["sec", "nanosec"])
}
