//! Symbols with an index or a power as they are printed: the e of `ε_e` stands lower, the q + 1 of `mm^(q+1)` higher.

/// Where a part of a text stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// On the line.
    Line,
    /// Below it.
    Index,
    /// Above it.
    Power,
}

/// A part of a text, and where it stands.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Part<'a> {
    pub(super) text: &'a str,
    pub(super) place: Place,
}

/// The parts of a text. An index follows a single letter: a short word after `_`, one or two digits, or the i of a sum (`ci`); names such as `force_N` have
/// none. A power stands between `^(` and `)`, or is one letter or digit, behind a letter, a parenthesis or the stroke of an absolute value.
pub(super) fn parts(text: &str) -> Vec<Part<'_>> {
    let mut parts = Vec::new();
    let (mut begun, mut from) = (0, 0);
    while let Some(found) =
        text[from..].find(|c: char| matches!(c, '_' | '^' | 'i') || c.is_ascii_digit())
    {
        let at = from + found;
        if text[at..].starts_with('^') {
            from = at + 1;
            if let Some(power) = power(text, at) {
                parts.push(Part { text: &text[begun..at], place: Place::Line });
                parts.push(Part { text: power, place: Place::Power });
                let marks = if text[at..].starts_with("^(") { "^()" } else { "^" };
                from = at + marks.len() + power.len();
                begun = from;
            }
            continue;
        }
        let index = at + usize::from(text[at..].starts_with('_'));
        let run = text[index..].find(|c: char| !c.is_ascii_alphanumeric());
        let length = run.unwrap_or(text.len() - index);
        from = index + length;
        if !is_index(text, at, index, length) {
            continue;
        }
        parts.push(Part { text: &text[begun..at], place: Place::Line });
        parts.push(Part { text: &text[index..from], place: Place::Index });
        begun = from;
    }
    parts.push(Part { text: &text[begun..], place: Place::Line });
    parts.retain(|part| !part.text.is_empty());
    parts
}

/// What stands between the parentheses behind a `^`, where there are none within, or the one character there.
fn power(text: &str, at: usize) -> Option<&str> {
    let is_base = |c: char| c.is_alphabetic() || matches!(c, ')' | '|');
    if !text[..at].ends_with(is_base) {
        return None;
    }
    let behind = text[at..].strip_prefix('^')?;
    if let Some(within) = behind.strip_prefix('(') {
        let (power, _) = within.split_once(')')?;
        return (!power.is_empty() && !power.contains('(')).then_some(power);
    }
    let word = behind.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(behind.len());
    (behind[..word].chars().count() == 1).then_some(&behind[..word])
}

/// Whether so many bytes from `index` on are the index of the one letter that ends at `at`.
fn is_index(text: &str, at: usize, index: usize, length: usize) -> bool {
    let mut before = text[..at].chars().rev();
    let is_symbol = before.next().is_some_and(char::is_alphabetic);
    let stands_alone = before.next().is_none_or(|c| !(c.is_alphanumeric() || "_-.".contains(c)));
    let is_short = if index > at {
        (1..=4).contains(&length)
    } else {
        let run = &text[index..index + length];
        length <= 2 && run.bytes().all(|b| b.is_ascii_digit())
            || run == "i" && !text[..at].ends_with('p')
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
        let part = |part: &Part| match part.place {
            Place::Line => part.text.to_owned(),
            Place::Index => format!("[{}]", part.text),
            Place::Power => format!("{{{}}}", part.text),
        };
        parts(text).iter().map(part).collect()
    }

    #[test]
    fn an_index_stands_lower_a_power_higher_and_names_of_columns_and_files_stay() {
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
            ("N/mm^(q+1), 1/(s·mm^(n−1))", "N/mm{q+1}, 1/(s·mm{n−1})"),
            ("w |v/V|^k, x^2, (t/1 s)^(−β)", "w |v/V|{k}, x{2}, (t/1 s){−β}"),
            ("2^(a), x^(f(a)), a^(), x^ab, x^", "2^(a), x^(f(a)), a^(), x^ab, x^"),
            ("1 − Σ ci, pi, if, in point i", "1 − Σ c[i], pi, if, in point i"),
            ("c1.csv, row-01, 3e5, mm2, v123, A4x", "c1.csv, row-01, 3e5, mm2, v123, A4x"),
        ] {
            assert_eq!(shown(text), expected);
        }
    }
}
