//! What a page may ask of a device, and the command that does the same.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Deserialize;
use serde_json::Value;
use shared::adaptation::Relaxation;
use shared::pipeline::GAUGES;
use tokio::sync::oneshot;

use super::grasp::Holding;
use palpate_link::device::calibrate::{Point, Points, by_gauge, points_of};
use palpate_link::device::change::{Change, Threshold};
use palpate_trace::recording::EXTENSION;

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
        /// Whether other fingers of the hand write the same file.
        #[serde(default)]
        together: bool,
    },
    /// End the file.
    EndRecording,
    /// Change the settings.
    Set(Setting),
    /// The device tests itself.
    SelfTest,
    /// Average the raw counts for a time, s.
    Average(f64),
    /// What calibration follows from this.
    Fit(Basis),
    /// Set what follows from this, and save it.
    Calibrate(Basis),
    /// Tell the margin of a grasp, or no longer.
    Grasp(Option<Holding>),
}

/// Settings to change.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Setting {
    /// The relaxation function: c1, v1 (1/s), c2, v2 (1/s).
    pub filter: Option<[f64; 4]>,
    /// Thresholds by name, in their units.
    pub thresholds: BTreeMap<String, f64>,
    /// Sample rate, Hz; the nearest of those possible is taken.
    pub rate_hz: Option<f64>,
    /// Gains of the converter.
    pub gain: Option<[u8; GAUGES]>,
    /// First take the settings that the device was made with.
    pub defaults: bool,
    /// Keep all settings over a loss of power.
    pub save: bool,
}

/// What a calibration follows from.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Basis {
    /// Known strains and their counts.
    Points(Vec<Known>),
    /// The same, as the text of a CSV file.
    Csv(String),
    /// Gain and offset themselves.
    Numbers {
        /// The gauge, from 1.
        gauge: u8,
        /// µε per count.
        gain: f64,
        /// Counts.
        offset: i32,
    },
}

/// A known strain, and the counts that it gave.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// The gauge, from 1.
    pub gauge: u8,
    /// µε.
    pub strain: f64,
    /// Mean of the raw counts.
    pub counts: f64,
}

impl Basis {
    /// The points, gauge by gauge; none of bare numbers.
    ///
    /// # Errors
    /// Says what is wrong with them.
    pub fn points(&self) -> Result<Points, String> {
        match self {
            Self::Points(known) => by_gauge(known.iter().map(|known| {
                Ok((known.gauge, Point { strain: known.strain, counts: known.counts }))
            })),
            Self::Csv(text) => points_of(text.as_bytes()),
            Self::Numbers { .. } => Ok(Points::new()),
        }
    }
}

/// A wish, and where its answer goes.
pub struct Request {
    /// What is asked for.
    pub wish: Wish,
    /// What became of it, as the page reads it, or why not.
    pub answer: oneshot::Sender<Result<Value, String>>,
}

/// The change that settings are.
///
/// # Errors
/// Names a threshold that does not exist, or a rate that is none.
pub fn change(setting: &Setting) -> Result<Change, String> {
    let Setting { filter, thresholds, rate_hz, gain, defaults, save: _ } = setting;
    if rate_hz.is_some_and(|rate| !(rate > 0.0 && rate.is_finite())) {
        return Err("the rate must be a number above 0".into());
    }
    let relaxation = filter.map(|[c1, v1, c2, v2]| Relaxation { c1, v1, c2, v2 });
    let found = thresholds.iter().map(|(name, value)| {
        let known = Threshold::ALL.into_iter().find(|(_, known, _)| known == name);
        known
            .map(|(threshold, ..)| (threshold, *value))
            .ok_or_else(|| format!("there is no threshold `{name}`"))
    });
    let thresholds = found.collect::<Result<_, _>>()?;
    Ok(Change { defaults: *defaults, rate_hz: *rate_hz, gain: *gain, relaxation, thresholds })
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
        Wish::Start | Wish::Stop | Wish::EndRecording | Wish::Average(_) | Wish::Grasp(None) => {
            return None;
        }
        // One command with a port for each finger.
        Wish::Record { together: true, .. } => return None,
        Wish::Tare => format!("palpate device tare --port {port}"),
        Wish::Untare => format!("palpate device tare --undo --port {port}"),
        Wish::Record { file, .. } => {
            format!("palpate record --port {port} --all -o {}", file_name(file).ok()?)
        }
        Wish::Set(setting) => format!("palpate device set --port {port}{}", options(setting)),
        Wish::SelfTest => format!("palpate device self-test --port {port}"),
        Wish::Fit(basis) => format!("{} --dry-run", calibrate(basis, port)),
        Wish::Calibrate(basis) => calibrate(basis, port),
        Wish::Grasp(Some(holding)) => {
            format!("palpate grasp watch --port {port}{}", holding.options())
        }
    })
}

fn options(setting: &Setting) -> String {
    let mut options = String::new();
    // Writing to a string does not fail.
    if setting.defaults {
        options += " --defaults";
    }
    if let Some(rate_hz) = setting.rate_hz {
        let _ = write!(options, " --rate {rate_hz}");
    }
    if let Some([a, b, c, d]) = setting.gain {
        let _ = write!(options, " --gain {a},{b},{c},{d}");
    }
    if let Some([c1, v1, c2, v2]) = setting.filter {
        let _ = write!(options, " --filter {c1} {v1} {c2} {v2}");
    }
    for (name, value) in &setting.thresholds {
        let _ = write!(options, " --threshold {name}={value}");
    }
    if setting.save {
        options += " --save";
    }
    options
}

fn calibrate(basis: &Basis, port: &str) -> String {
    let call = format!("palpate device calibrate --port {port}");
    match basis {
        Basis::Points(_) | Basis::Csv(_) => format!("{call} --points points.csv"),
        Basis::Numbers { gauge, gain, offset } => {
            format!("{call} --gauge {gauge} --gain {gain} --offset {offset}")
        }
    }
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
        let setting = Setting { filter, thresholds, ..Setting::default() };
        assert_eq!(change(&setting).unwrap().thresholds, [(Threshold::Touch, 40.0)]);
        assert_eq!(
            command(&Wish::Set(setting), "p").unwrap(),
            "palpate device set --port p --filter 0.2 8 0.3 0.5 --threshold touch=40"
        );
        let thresholds = BTreeMap::from([("grip".to_owned(), 1.0)]);
        let unknown = Setting { thresholds, ..Setting::default() };
        assert!(change(&unknown).unwrap_err().contains("grip"));
        let standing = Setting { rate_hz: Some(0.0), ..Setting::default() };
        assert!(change(&standing).unwrap_err().contains("above 0"));
    }

    #[test]
    fn every_setting_has_its_option() {
        let text = r#"{"set":{"rate_hz":500,"gain":[64,64,32,32],"defaults":true,"save":true}}"#;
        let wish: Wish = serde_json::from_str(text).unwrap();
        assert_eq!(
            command(&wish, "p").unwrap(),
            "palpate device set --port p --defaults --rate 500 --gain 64,64,32,32 --save"
        );
    }

    #[test]
    fn a_calibration_is_read_with_its_points_and_has_its_command() {
        let read = |text: &str| serde_json::from_str::<Wish>(text);
        let wish = read(r#"{"fit":{"points":[{"gauge":2,"strain":0,"counts":5.5}]}}"#).unwrap();
        let Wish::Fit(basis) = &wish else { panic!("{wish:?}") };
        assert_eq!(basis.points(), Ok(vec![(1, vec![Point { strain: 0.0, counts: 5.5 }])]));
        assert_eq!(
            command(&wish, "p").unwrap(),
            "palpate device calibrate --port p --points points.csv --dry-run"
        );
        let numbers = r#"{"calibrate":{"numbers":{"gauge":1,"gain":-0.00068,"offset":1200}}}"#;
        assert_eq!(
            command(&read(numbers).unwrap(), "p").unwrap(),
            "palpate device calibrate --port p --gauge 1 --gain -0.00068 --offset 1200"
        );
        assert!(Basis::Csv("gauge\n".into()).points().is_err());
    }
}
