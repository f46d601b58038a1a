//! Whether firmware and program go together, and what to do if they do not.

use std::cmp::Ordering;

use super::session::VERSION;

/// How the firmware's release is to the program's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Whether they speak the same messages, so that anything can be done with the device.
    pub speaks: bool,
    /// Version of the firmware.
    pub firmware: String,
    /// In words.
    pub words: String,
    /// What to do.
    pub advice: String,
}

/// Of firmware of some version, whose messages are those of this program or not.
#[must_use]
pub fn verdict(firmware: &str, speaks: bool) -> Verdict {
    let order = numbers(firmware).zip(numbers(VERSION)).map(|(theirs, ours)| theirs.cmp(&ours));
    let age = match order {
        Some(Ordering::Less) => "older than",
        Some(Ordering::Greater) => "newer than",
        Some(Ordering::Equal) => "the same release as",
        None => "of another release than",
    };
    let messages = if speaks { "they speak the same messages" } else { "their messages differ" };
    let words = format!("Firmware {firmware} is {age} this program, {VERSION}; {messages}.");
    let advice = match (speaks, order) {
        (true, Some(Ordering::Equal)) => "Nothing to do.".into(),
        (true, Some(Ordering::Greater)) => {
            format!("It works as it is; palpate {firmware} is of the firmware's release.")
        }
        (true, _) => {
            format!("It works as it is; `palpate device dfu` writes firmware {VERSION} to it.")
        }
        (false, Some(Ordering::Less)) => format!(
            "Write firmware {VERSION} to it, with `palpate device dfu` of palpate {firmware} or with a probe."
        ),
        (false, Some(Ordering::Greater)) => {
            format!("Install palpate {firmware}, or write firmware {VERSION} to it with a probe.")
        }
        (false, _) => "Build firmware and program from one state of the source.".into(),
    };
    Verdict { speaks, firmware: firmware.into(), words, advice }
}

/// The three numbers of a version, without what follows them.
fn numbers(version: &str) -> Option<[u32; 3]> {
    let plain = version.split(['-', '+']).next()?;
    let parts: Option<Vec<u32>> = plain.split('.').map(|part| part.parse().ok()).collect();
    parts?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn older_newer_and_the_same_are_told_apart_with_what_to_do() {
        let same = verdict(VERSION, true);
        assert!(same.words.contains("the same release") && same.advice == "Nothing to do.");
        let older = verdict("0.0.9", true);
        assert!(older.words.contains("older") && older.advice.contains("palpate device dfu"));
        let newer = verdict("99.0.0-rc1", false);
        assert!(newer.words.contains("newer") && newer.words.contains("differ"), "{newer:?}");
        assert!(newer.advice.starts_with("Install palpate 99.0.0-rc1"), "{newer:?}");
        assert!(
            verdict("0.0.9", false).advice.contains("with `palpate device dfu` of palpate 0.0.9")
        );
        let unknown = verdict("of unknown version", false);
        assert!(unknown.words.contains("another release") && unknown.advice.contains("one state"));
    }

    #[test]
    fn numbers_are_compared_as_numbers() {
        assert_eq!(numbers("0.10.2"), Some([0, 10, 2]));
        assert!(numbers("0.10.0") > numbers("0.9.9"));
        assert_eq!((numbers("1.2"), numbers("1.2.x"), numbers("")), (None, None, None));
    }
}
