//! Keys in the names of files: `{specimen}/{finger}-*.csv`.

use std::path::Path;
use std::str::FromStr;

/// A pattern for the end of a path, component by component.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    text: String,
    components: Vec<Vec<Piece>>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    /// As it stands.
    Literal(String),
    /// One character or more, of which the key is the name.
    Key(String),
    /// Any characters, or none.
    Any,
}

impl FromStr for Names {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let components: Vec<_> = text.split('/').map(pieces).collect::<Result<_, _>>()?;
        let names = Self { text: text.into(), components };
        let mut keys: Vec<&str> = names.keys().collect();
        if keys.is_empty() {
            return Err("name at least one key in braces, as in `{finger}-*.csv`".into());
        }
        keys.sort_unstable();
        match keys.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(format!("`{}` stands in it twice", pair[0])),
            None => Ok(names),
        }
    }
}

fn pieces(component: &str) -> Result<Vec<Piece>, String> {
    let mut pieces = Vec::new();
    let mut rest = component;
    while !rest.is_empty() {
        let end = rest.find(['{', '}', '*']).unwrap_or(rest.len());
        if end > 0 {
            pieces.push(Piece::Literal(rest[..end].into()));
        }
        rest = &rest[end..];
        if let Some(after) = rest.strip_prefix('*') {
            pieces.push(Piece::Any);
            rest = after;
        } else if let Some(after) = rest.strip_prefix('{') {
            let close = after.find('}').filter(|&close| close > 0 && !after[..close].contains('{'));
            let close = close.ok_or("a brace stands alone, or with no name in it")?;
            if matches!(pieces.last(), Some(Piece::Key(_))) {
                return Err("two keys stand side by side with nothing between them".into());
            }
            pieces.push(Piece::Key(after[..close].into()));
            rest = &after[close + 1..];
        } else if rest.starts_with('}') {
            return Err("a brace stands alone, or with no name in it".into());
        }
    }
    Ok(pieces)
}

impl Names {
    /// The pattern as it was given.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// The keys, in order.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.components.iter().flatten().filter_map(|piece| match piece {
            Piece::Key(key) => Some(&key[..]),
            _ => None,
        })
    }

    /// The value of a key in a path; none where the path is not of this pattern. A key takes as little as it can.
    #[must_use]
    pub fn value<'a>(&self, path: &'a Path, key: &str) -> Option<&'a str> {
        let components: Vec<&str> =
            path.components().map(|part| part.as_os_str().to_str()).collect::<Option<_>>()?;
        let from = components.len().checked_sub(self.components.len())?;
        let mut found = None;
        for (pieces, text) in self.components.iter().zip(&components[from..]) {
            let mut values = Vec::new();
            if !matches(pieces, text, &mut values) {
                return None;
            }
            found = found.or_else(|| values.iter().find(|(name, _)| *name == key).map(|(_, v)| *v));
        }
        found
    }
}

/// Whether a text is of these pieces, and the values of the keys.
fn matches<'a, 'b>(
    pieces: &'b [Piece],
    text: &'a str,
    values: &mut Vec<(&'b str, &'a str)>,
) -> bool {
    let Some((piece, rest)) = pieces.split_first() else { return text.is_empty() };
    let ends = |least: usize| {
        let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]);
        ends.skip(least)
    };
    match piece {
        Piece::Literal(literal) => {
            text.strip_prefix(&literal[..]).is_some_and(|text| matches(rest, text, values))
        }
        Piece::Any => ends(0).any(|end| matches(rest, &text[end..], values)),
        Piece::Key(key) => ends(1).any(|end| {
            let known = values.len();
            values.push((key, &text[..end]));
            let fits = matches(rest, &text[end..], values);
            if !fits {
                values.truncate(known);
            }
            fits
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_in_the_end_of_a_path() {
        let names: Names = "{specimen}/f{finger}-*_{date}.csv".parse().unwrap();
        let value = |path: &str, key: &str| names.value(Path::new(path), key).map(str::to_owned);
        let path = "lab/silicone 4/f03-take-2_2026-11-02.csv";
        assert_eq!(value(path, "finger").as_deref(), Some("03"));
        assert_eq!(value(path, "date").as_deref(), Some("2026-11-02"));
        assert_eq!(value(path, "specimen").as_deref(), Some("silicone 4"));
        assert_eq!(value(path, "operator"), None);
        assert_eq!(value("lab/g03-take_1.csv", "finger"), None);
        assert_eq!(value("f03-take_1.csv", "finger"), None);
        assert_eq!(names.keys().collect::<Vec<_>>(), ["specimen", "finger", "date"]);
    }

    #[test]
    fn a_pattern_that_cannot_be_is_refused() {
        for text in ["*.csv", "{a}{b}.csv", "{}.csv", "{a", "a}", "{a}/{a}.csv"] {
            assert!(text.parse::<Names>().is_err(), "{text}");
        }
    }
}
