//! The TOML head of a trace.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Error;

/// Major version of the trace format this program reads and writes.
pub const VERSION: i64 = 1;

/// What a trace's head says; every key is optional and unknown keys are passed through.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// Major version of the trace format.
    #[serde(rename = "palpate-trace", skip_serializing_if = "Option::is_none")]
    pub version: Option<i64>,
    /// Name of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The command of palpate that computed it, `palpate simulate`; none where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub computed_by: Option<String>,
    /// Which quantity the machine controlled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control: Option<Control>,
    /// What was pressed.
    #[serde(default, skip_serializing_if = "Specimen::is_empty")]
    pub specimen: Specimen,
    /// What pressed and measured.
    #[serde(default, skip_serializing_if = "Setup::is_empty")]
    pub setup: Setup,
    /// Keys this version does not know.
    #[serde(flatten)]
    pub other: toml::Table,
}

/// Which quantity the machine controlled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Control {
    /// Displacement followed a programme, force answered.
    Displacement,
    /// Force followed a programme, displacement answered.
    Force,
}

/// Shape of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Pressed along its axis; `radius_mm`, `height_mm`.
    Cylinder,
    /// `length_mm`, `width_mm`, `height_mm`.
    Block,
    /// `radius_mm`.
    Sphere,
}

/// What was pressed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Specimen {
    /// Free text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Shape, which says which sizes apply.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Radius, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Height, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
    /// Length, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Width, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_mm: Option<f64>,
    /// Poisson's ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poisson_ratio: Option<f64>,
    /// Keys this version does not know.
    #[serde(flatten)]
    pub other: toml::Table,
}

impl Specimen {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// What pressed and measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// Mass that moves with the force sensor, g.
    #[serde(skip_serializing_if = "Option::is_none", rename = "moving_mass_g")]
    pub moving_mass_g: Option<f64>,
    /// Smallest step of the force channel, N.
    #[serde(skip_serializing_if = "Option::is_none", rename = "force_resolution_N")]
    pub force_resolution_n: Option<f64>,
    /// Order of recording within the data set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sequence: Option<i64>,
    /// Time of the first sample since the data set began, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_s: Option<f64>,
    /// Keys this version does not know.
    #[serde(flatten)]
    pub other: toml::Table,
}

impl Setup {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Reads the TOML of a head that stands for itself.
#[cfg(feature = "parquet")]
pub(super) fn from_toml(path: &Path, toml: &str) -> Result<Head, Error> {
    let lines: Vec<String> = toml.lines().map(|line| format!("# {line}")).collect();
    parse(path, &lines.iter().map(String::as_str).collect::<Vec<_>>())
}

/// The head as TOML, with the version even if it does not say it.
pub(super) fn to_toml(head: &Head) -> Result<String, toml::ser::Error> {
    let mut head = head.clone();
    head.version.get_or_insert(VERSION);
    toml::to_string(&head)
}

/// Reads the lines before the header row: blank, or TOML behind a `#`.
pub(super) fn parse(path: &Path, lines: &[&str]) -> Result<Head, Error> {
    // The mark keeps its line, so that a place in the TOML is a place in the file.
    let toml: Vec<&str> = lines.iter().map(|line| uncommented(line)).collect();
    let fault = |line: usize, column: usize, message: &str| Error::Head {
        path: path.into(),
        line,
        column,
        message: message.trim().replace('\n', ", "),
    };
    let text = toml.join("\n");
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let at = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = text[..at].matches('\n').count();
        let within = text[..at].chars().rev().take_while(|&c| c != '\n').count();
        let mark = lines[line].chars().count() - toml[line].chars().count();
        fault(line + 1, within + mark + 1, error.message())
    })?;
    let line_of = |key: &str| 1 + toml.iter().position(|l| l.contains(key)).unwrap_or_default();
    if let Some(found) = table.get("palpate-trace").and_then(toml::Value::as_integer)
        && found > VERSION
    {
        let line = line_of("palpate-trace");
        return Err(Error::NewerVersion { path: path.into(), line, found, supported: VERSION });
    }
    let head = table.try_into::<Head>().map_err(|error| error.message().to_owned());
    head.and_then(|head| head.check().map(|()| head))
        .map_err(|message| fault(culprit(&toml), 1, &message))
}

/// The line's TOML: what follows the `#` and one space.
fn uncommented(line: &str) -> &str {
    let text = line.trim_start().strip_prefix('#').unwrap_or_default();
    text.strip_prefix(' ').unwrap_or(text)
}

/// The line (from 1) with a value that a head cannot have: the last of the shortest beginning that
/// is TOML but no head.
fn culprit(toml: &[&str]) -> usize {
    (1..=toml.len())
        .find(|&count| {
            let table = toml[..count].join("\n").parse::<toml::Table>();
            table
                .is_ok_and(|table| !table.try_into::<Head>().is_ok_and(|head| head.check().is_ok()))
        })
        .unwrap_or(1)
}

impl Head {
    /// Whether the numbers can be what they stand for.
    ///
    /// # Errors
    /// What cannot be, in words.
    pub fn check(&self) -> Result<(), String> {
        if self.version.is_some_and(|version| version < 1) {
            return Err("palpate-trace is a version, from 1".into());
        }
        let (specimen, setup) = (&self.specimen, &self.setup);
        let sizes = [
            ("radius_mm", specimen.radius_mm),
            ("height_mm", specimen.height_mm),
            ("length_mm", specimen.length_mm),
            ("width_mm", specimen.width_mm),
        ];
        let not_negative = [
            ("moving_mass_g", setup.moving_mass_g),
            ("force_resolution_N", setup.force_resolution_n),
        ];
        let bad = |value: Option<f64>, good: fn(f64) -> bool| value.filter(|&value| !good(value));
        for (key, value) in sizes {
            if let Some(value) = bad(value, |value| value > 0.0 && value.is_finite()) {
                return Err(format!("{key} = {value}, a size is above 0"));
            }
        }
        for (key, value) in not_negative {
            if let Some(value) = bad(value, |value| value >= 0.0 && value.is_finite()) {
                return Err(format!("{key} = {value} cannot be below 0"));
            }
        }
        if let Some(value) = bad(specimen.poisson_ratio, |value| value > -1.0 && value <= 0.5) {
            return Err(format!("poisson_ratio = {value}, it lies above -1 and up to 0.5"));
        }
        match bad(setup.start_s, f64::is_finite) {
            Some(value) => Err(format!("start_s = {value} is not a time")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_head(text: &str) -> Result<Head, Error> {
        parse(Path::new("press.csv"), &text.lines().collect::<Vec<_>>())
    }

    #[test]
    fn the_head_of_the_format_reads() {
        let head = parse_head(
            "# palpate-trace = 1\n# control = \"force\"   # or the other\n## a remark\n# [specimen]\n\
             # shape = \"cylinder\"\n# radius_mm = 25\n# batch = 7\n# [setup]\n# sequence = 3",
        )
        .unwrap();
        assert_eq!(head.control, Some(Control::Force));
        assert_eq!(head.specimen.radius_mm, Some(25.0));
        assert_eq!(head.specimen.other["batch"].as_integer(), Some(7));
        assert_eq!(head.setup.sequence, Some(3));
    }

    #[test]
    fn a_wrong_value_is_found_by_its_line() {
        for (text, line) in [
            ("# name = 3", 1),
            ("# [specimen]\n# height_mm = 30\n# shape = \"cone\"\n# radius_mm = 2", 3),
            ("# [specimen]\n# height_mm = -30.0", 2),
            ("# [specimen]\n# material =\n# height_mm = 3", 2),
            ("# taken on Monday", 1),
        ] {
            match parse_head(text) {
                Err(Error::Head { line: found, .. }) => assert_eq!(found, line, "{text}"),
                other => panic!("{text}: {other:?}"),
            }
        }
    }

    #[test]
    fn a_newer_version_is_refused_by_name() {
        let error = parse_head("# name = 3\n# palpate-trace = 2").unwrap_err();
        assert!(matches!(error, Error::NewerVersion { line: 2, found: 2, supported: 1, .. }));
    }
}
