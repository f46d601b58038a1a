//! The text that says what a message of ROS 2 is made of.

use std::collections::HashMap;

/// A type of message with all that it is made of.
#[derive(Debug)]
pub(super) struct Schema {
    /// Types by full name (`geometry_msgs/Wrench`); the first is the message's own.
    types: Vec<Message>,
}

/// One type of message.
#[derive(Debug)]
pub(super) struct Message {
    /// `geometry_msgs/Wrench`.
    pub(super) name: String,
    pub(super) fields: Vec<Field>,
}

/// One field.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) count: Count,
}

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    Unsigned(usize),
    Signed(usize),
    Float(usize),
    Text,
    /// Of 16-bit letters.
    Wide,
    /// A message, by its place in the schema.
    Message(usize),
}

/// How many of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    /// As many as the message says.
    Any,
}

impl Schema {
    /// Reads the definition of the type `name`, those of its parts below it, each after a line `MSG: name`.
    pub(super) fn parse(name: &str, text: &str) -> Result<Self, String> {
        let mut sections = vec![(short(name), Vec::new())];
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or("").trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                sections.push((short(name), Vec::new()));
            } else if !line.is_empty() && !line.chars().all(|c| c == '=') {
                sections.last_mut().ok_or("no section")?.1.push(line);
            }
        }
        let places: HashMap<String, usize> =
            sections.iter().enumerate().rev().map(|(at, (name, _))| (name.clone(), at)).collect();
        let mut types = Vec::with_capacity(sections.len());
        for (name, lines) in sections {
            let package = name.split('/').next().unwrap_or("").to_owned();
            let fields =
                lines.into_iter().filter_map(|line| field(line, &package, &places).transpose());
            types.push(Message { fields: fields.collect::<Result<_, _>>()?, name });
        }
        Ok(Self { types })
    }

    pub(super) fn message(&self, at: usize) -> &Message {
        &self.types[at]
    }
}

/// `geometry_msgs/msg/Wrench` as `geometry_msgs/Wrench`.
fn short(name: &str) -> String {
    name.trim().replace("/msg/", "/")
}

/// A field of a line; none if the line is a constant.
fn field(
    line: &str,
    package: &str,
    places: &HashMap<String, usize>,
) -> Result<Option<Field>, String> {
    let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(|| format!("`{line}`"))?;
    let rest = rest.trim();
    let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    if rest[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let (base, count) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
        None => (kind, Count::One),
        Some((base, "")) => (base, Count::Any),
        Some((base, most)) if most.starts_with("<=") => (base, Count::Any),
        Some((base, exact)) => {
            let count = exact.parse().map_err(|_| format!("`{kind}`"))?;
            (base, Count::Fixed(count))
        }
    };
    let base = base.split("<=").next().unwrap_or(base);
    let kind = match base {
        "bool" => Kind::Bool,
        "byte" | "char" | "uint8" => Kind::Unsigned(1),
        "uint16" => Kind::Unsigned(2),
        "uint32" => Kind::Unsigned(4),
        "uint64" => Kind::Unsigned(8),
        "int8" => Kind::Signed(1),
        "int16" => Kind::Signed(2),
        "int32" => Kind::Signed(4),
        "int64" => Kind::Signed(8),
        "float32" => Kind::Float(4),
        "float64" => Kind::Float(8),
        "string" => Kind::Text,
        "wstring" => Kind::Wide,
        other => {
            let full =
                if other.contains('/') { short(other) } else { format!("{package}/{other}") };
            let found = places.get(&full).copied();
            let found = found.or_else(|| builtin(other).and_then(|name| places.get(name).copied()));
            Kind::Message(found.ok_or_else(|| format!("type `{other}` is not defined"))?)
        }
    };
    Ok(Some(Field { name, kind, count }))
}

/// Names that stand without their package.
fn builtin(name: &str) -> Option<&'static str> {
    match name {
        "Header" => Some("std_msgs/Header"),
        "time" => Some("builtin_interfaces/Time"),
        "duration" => Some("builtin_interfaces/Duration"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_bounds_defaults_and_constants_are_told_apart() {
        let text = "uint8 A=1 # constant\nstring<=10[<=3] names\nfloat64[3] xyz [1.0, 2.0, 3.0]\n\
                    Inner inner # a part\nint32 n -5\n====\nMSG: p/msg/Inner\nbool b\n";
        let schema = Schema::parse("p/msg/Outer", text).unwrap();
        let fields: Vec<_> =
            schema.message(0).fields.iter().map(|f| (&f.name[..], f.kind, f.count)).collect();
        assert_eq!(
            fields,
            [
                ("names", Kind::Text, Count::Any),
                ("xyz", Kind::Float(8), Count::Fixed(3)),
                ("inner", Kind::Message(1), Count::One),
                ("n", Kind::Signed(4), Count::One)
            ]
        );
        assert!(Schema::parse("p/A", "q/B b\n").unwrap_err().contains("q/B"));
        assert!(Schema::parse("p/A", "nonsense\n").is_err());
    }
}
