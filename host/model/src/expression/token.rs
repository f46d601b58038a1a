//! The words of an expression, each with its place.

/// A word.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Word {
    Number(f64),
    Name(String),
    /// One of `+ - * / ^ ( ) ,`.
    Sign(char),
}

/// A word and where it stands, in characters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub word: Word,
    pub at: usize,
    pub length: usize,
}

/// What is wrong, and where.
pub(super) struct Fault {
    pub at: usize,
    pub length: usize,
    pub message: String,
}

/// Splits a text into words.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, Fault> {
    let characters: Vec<char> = text.chars().collect();
    let mut found = Vec::new();
    let mut at = 0;
    while at < characters.len() {
        let c = characters[at];
        if c.is_whitespace() {
            at += 1;
            continue;
        }
        let (word, length) =
            match c {
                '+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' => (Word::Sign(c), 1),
                '−' => (Word::Sign('-'), 1),
                '·' | '×' => (Word::Sign('*'), 1),
                '0'..='9' | '.' => number(&characters[at..])
                    .map_err(|(length, message)| Fault { at, length, message })?,
                c if c.is_alphabetic() || c == '_' => {
                    let part = |c: &&char| c.is_alphanumeric() || **c == '_';
                    let name: String = characters[at..].iter().take_while(part).collect();
                    let length = name.chars().count();
                    (Word::Name(name), length)
                }
                c => {
                    let message = format!("no expression has the character `{c}`");
                    return Err(Fault { at, length: 1, message });
                }
            };
        found.push(Token { word, at, length });
        at += length;
    }
    Ok(found)
}

/// A number as `12`, `0.5`, `.5` or `1e-3`, and its length in characters.
fn number(rest: &[char]) -> Result<(Word, usize), (usize, String)> {
    let digits = |from: usize| rest[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let mut length = digits(0);
    if rest.get(length) == Some(&'.') {
        length += 1 + digits(length + 1);
    }
    if matches!(rest.get(length), Some('e' | 'E')) {
        let sign = usize::from(matches!(rest.get(length + 1), Some('+' | '-')));
        let power = digits(length + 1 + sign);
        length += if power > 0 { 1 + sign + power } else { 0 };
    }
    let text: String = rest[..length].iter().collect();
    let value: Option<f64> = text.parse().ok().filter(|value: &f64| value.is_finite());
    value
        .map(|value| (Word::Number(value), length))
        .ok_or_else(|| (length, format!("`{text}` is not a number")))
}
