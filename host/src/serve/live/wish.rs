//! What a page may ask of a device, and the command that does the same.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;
use shared::adaptation::Relaxation;
use tokio::sync::oneshot;

use crate::device::change::{Change, Threshold};
use crate::recording::EXTENSION;

/// What a page asks for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Wish {
    /// Begin the stream.
    Start,
    /// End the stream.
    Stop,
    /// Read zero from now on.
    Tare,
    /// Take the tare back.
    Untare,
    /// Write what comes into a file.
    Record {
        /// Its name, without a folder.
        file: String,
    },
    /// End the file.
    EndRecording,
    /// Change filter and thresholds.
    Set {
        /// The relaxation function: c1, v1 (1/s), c2, v2 (1/s).
        #[serde(default)]
        filter: Option<[f64; 4]>,
        /// Thresholds by name, in their units.
        #[serde(default)]
        thresholds: BTreeMap<String, f64>,
    },
}

/// A wish, and where its answer goes.
pub struct Request {
    /// What is asked for.
    pub wish: Wish,
    /// What became of it, as the page reads it, or why not.
    pub answer: oneshot::Sender<Result<Value, String>>,
}

/// The change that filter and thresholds are.
///
/// # Errors
/// Names a threshold that does not exist.
pub fn change(
    filter: Option<[f64; 4]>,
    thresholds: &BTreeMap<String, f64>,
) -> Result<Change, String> {
    let relaxation = filter.map(|[c1, v1, c2, v2]| Relaxation { c1, v1, c2, v2 });
    let found = thresholds.iter().map(|(name, value)| {
        let known = Threshold::ALL.into_iter().find(|(_, known, _)| known == name);
        known
            .map(|(threshold, ..)| (threshold, *value))
            .ok_or_else(|| format!("there is no threshold `{name}`"))
    });
    Ok(Change { relaxation, thresholds: found.collect::<Result<_, _>>()?, ..Change::default() })
}

/// The name of a recording, with its extension: letters, digits and `.`, `-`, `_`, so that it stays in the folder.
///
/// # Errors
/// Says what a name may be.
pub fn file_name(name: &str) -> Result<String, String> {
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '.' | '-' | '_');
    if name.is_empty() || name.len() > 100 || name.starts_with('.') || !name.chars().all(allowed) {
        return Err(
            "a name has letters, digits, `-`, `_` and `.`, and does not begin with one".into()
        );
    }
    let stem = name.strip_suffix(&format!(".{EXTENSION}")).unwrap_or(name);
    Ok(format!("{stem}.{EXTENSION}"))
}

/// The command that does the same on a port; none for what only a page does.
#[must_use]
pub fn command(wish: &Wish, port: &str) -> Option<String> {
    Some(match wish {
        Wish::Start | Wish::Stop | Wish::EndRecording => return None,
        Wish::Tare => format!("palpate device tare --port {port}"),
        Wish::Untare => format!("palpate device tare --undo --port {port}"),
        Wish::Record { file } => {
            format!("palpate record --port {port} --all -o {}", file_name(file).ok()?)
        }
        Wish::Set { filter, thresholds } => {
            let filter = filter
                .map_or(String::new(), |[c1, v1, c2, v2]| format!(" --filter {c1} {v1} {c2} {v2}"));
            let each =
                thresholds.iter().map(|(name, value)| format!(" --threshold {name}={value}"));
            format!("palpate device set --port {port}{filter}{}", each.collect::<String>())
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_stays_in_its_folder() {
        assert_eq!(file_name("press").unwrap(), "press.palpate");
        assert_eq!(file_name("press.palpate").unwrap(), "press.palpate");
        for name in ["", "..", "../press", "/tmp/press", "a/b", "a\\b", ".hidden", "C:x", "a\nb"] {
            assert!(file_name(name).is_err(), "{name}");
        }
    }

    #[test]
    fn a_wish_is_read_strictly() {
        let wish = |text: &str| serde_json::from_str::<Wish>(text);
        assert_eq!(wish(r#""end-recording""#).unwrap(), Wish::EndRecording);
        assert!(wish(r#"{"record":{"file":"a","force":true}}"#).is_err());
        assert!(wish(r#""reboot""#).is_err());
    }

    #[test]
    fn a_change_names_the_threshold_it_does_not_know_and_has_a_command() {
        let thresholds = BTreeMap::from([("touch".to_owned(), 40.0)]);
        let filter = Some([0.2, 8.0, 0.3, 0.5]);
        assert_eq!(change(filter, &thresholds).unwrap().thresholds, [(Threshold::Touch, 40.0)]);
        assert_eq!(
            command(&Wish::Set { filter, thresholds }, "p").unwrap(),
            "palpate device set --port p --filter 0.2 8 0.3 0.5 --threshold touch=40"
        );
        assert!(
            change(None, &BTreeMap::from([("grip".to_owned(), 1.0)])).unwrap_err().contains("grip")
        );
    }
}
