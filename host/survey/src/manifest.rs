//! What a folder of results is the result of.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::row::Asked;

/// Its name in the folder.
pub const NAME: &str = "manifest.json";
/// Version of the folder.
pub const VERSION: u32 = 1;

/// The head of a folder of results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the folder.
    pub palpate_survey: u32,
    /// Version of palpate.
    pub version: String,
    /// What was asked.
    pub asked: Asked,
    /// What the traces were grouped by.
    pub by: Vec<String>,
    /// Every option that the rows depend on, by its name.
    pub options: Map<String, Value>,
    /// The command that makes the results, or goes on with them.
    pub command: String,
    /// The seeds of what is random in the answers, by what they are for.
    pub seeds: BTreeMap<String, u64>,
    /// What was read.
    pub inputs: Inputs,
    /// Number of groups.
    pub groups: u64,
    /// Number of groups in a part.
    pub groups_in_a_part: u64,
    /// The parts that are finished.
    pub parts: Vec<Part>,
    /// Whether all are.
    pub finished: bool,
}

/// What was read: sizes and times are in the list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Inputs {
    /// The list of files, beside the manifest.
    pub list: String,
    /// Number of files.
    pub files: u64,
    /// Their size, bytes.
    pub bytes: u64,
}

/// A part that is finished.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// The file of what was found.
    pub file: String,
    /// Number of its rows.
    pub groups: u64,
    /// Its size, bytes.
    pub bytes: u64,
}

/// Whether a folder holds the results of a survey.
pub fn is_there(folder: &Path) -> bool {
    fs::read(folder.join(NAME)).is_ok_and(|bytes| {
        let known = serde_json::from_slice::<Value>(&bytes);
        known.is_ok_and(|manifest| manifest.get("palpate_survey").is_some())
    })
}

impl Manifest {
    /// Reads the manifest of a folder.
    ///
    /// # Errors
    /// In words, when there is none or it is of another version.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let bytes = fs::read(folder.join(NAME)).map_err(|error| error.to_string())?;
        let value: Value = serde_json::from_slice(&bytes).map_err(|error| error.to_string())?;
        match value.get("palpate_survey").and_then(Value::as_u64) {
            Some(version) if version > u64::from(VERSION) => {
                Err(format!("version {version}, this program reads up to version {VERSION}"))
            }
            Some(_) => serde_json::from_value(value).map_err(|error| error.to_string()),
            None => Err("is not of a survey".into()),
        }
    }

    /// What is not as in another manifest, in words: what it is there, then what it is here.
    #[must_use]
    pub fn difference(&self, here: &Self) -> Option<String> {
        let differ = |what: &str, there: String, here: String| {
            (there != here).then(|| format!("{what} {there}, this call has {here}"))
        };
        let list = |keys: &[String]| keys.join(",");
        let mut names: Vec<&String> = self.options.keys().chain(here.options.keys()).collect();
        names.sort();
        let option = |name: &String| {
            let (there, this) = (self.options.get(name), here.options.get(name));
            if there == this {
                return None;
            }
            let shown = |value: Option<&Value>| match value {
                None => "no such option".to_owned(),
                Some(Value::String(text)) if text.contains('\n') => "other contents".into(),
                Some(Value::String(text)) => format!("`{text}`"),
                Some(other) => format!("`{other}`"),
            };
            differ(&format!("with {name}"), shown(there), shown(this))
                .or_else(|| Some(format!("with another content of {name}")))
        };
        differ("by `survey", self.asked.word().to_owned() + "`", here.asked.word().to_owned() + "`")
            .or_else(|| differ("by palpate", self.version.clone(), here.version.clone()))
            .or_else(|| differ("--by", list(&self.by), list(&here.by)))
            .or_else(|| names.into_iter().find_map(option))
            .or_else(|| {
                let parts = |it: &Self| format!("parts of {} groups", it.groups_in_a_part);
                differ("with", parts(self), parts(here))
            })
    }
}
