//! Symbols with an index as they are printed: the e of `ε_e` stands lower.

/// A part of a text, and whether it stands lower.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Part<'a> {
    pub(super) text: &'a str,
    pub(super) is_index: bool,
}

/// The parts of a text. An index follows a single letter: a short word after `_`, or one or two digits; names such as `force_N` have
/// none.
pub(super) fn parts(text: &str) -> Vec<Part<'_>> {
    let mut parts = Vec::new();
    let (mut begun, mut from) = (0, 0);
    while let Some(found) = text[from..].find(|c: char| c == '_' || c.is_ascii_digit()) {
        let at = from + found;
        let index = at + usize::from(text[at..].starts_with('_'));
        let run = text[index..].find(|c: char| !c.is_ascii_alphanumeric());
        let length = run.unwrap_or(text.len() - index);
        from = index + length;
        if !is_index(text, at, index, length) {
            continue;
        }
        parts.push(Part { text: &text[begun..at], is_index: false });
        parts.push(Part { text: &text[index..from], is_index: true });
        begun = from;
    }
    parts.push(Part { text: &text[begun..], is_index: false });
    parts.retain(|part| !part.text.is_empty());
    parts
}

/// Whether so many bytes from `index` on are the index of the one letter that ends at `at`.
fn is_index(text: &str, at: usize, index: usize, length: usize) -> bool {
    let mut before = text[..at].chars().rev();
    let is_symbol = before.next().is_some_and(char::is_alphabetic);
    let stands_alone = before.next().is_none_or(|c| !(c.is_alphanumeric() || "_-.".contains(c)));
    let is_short = if index > at {
        (1..=4).contains(&length)
    } else {
        length <= 2 && text[index..index + length].bytes().all(|b| b.is_ascii_digit())
    };
    let mut behind = text[index + length..].chars();
    let goes_on = match behind.next() {
        Some('_' | '-') => true,
        Some('.') => behind.next().is_some_and(char::is_alphanumeric),
        _ => false,
    };
    is_symbol && stands_alone && is_short && !goes_on
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> String {
        let part = |part: &Part| {
            if part.is_index { format!("[{}]", part.text) } else { part.text.to_owned() }
        };
        parts(text).iter().map(part).collect()
    }

    #[test]
    fn an_index_stands_lower_and_names_of_columns_and_files_stay() {
        for (text, expected) in [
            ("ε_e", "ε[e]"),
            ("ε_0 − ε_e", "ε[0] − ε[e]"),
            ("ε_c = F/(A k_s), with k_s.", "ε[c] = F/(A k[s]), with k[s]."),
            ("largest x_max (mm)", "largest x[max] (mm)"),
            ("force_N", "force_N"),
            ("x_max.csv", "x_max.csv"),
            ("a_b_c", "a_b_c"),
            ("t_1-2", "t_1-2"),
            ("_e", "_e"),
            ("no index", "no index"),
            ("v1 (1/s), c12", "v[1] (1/s), c[12]"),
            ("c1.csv, row-01, 3e5, mm2, v123, A4x", "c1.csv, row-01, 3e5, mm2, v123, A4x"),
        ] {
            assert_eq!(shown(text), expected);
        }
    }
}
