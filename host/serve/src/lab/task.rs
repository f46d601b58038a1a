//! What can be asked for, and the command that does the same.

use serde::Deserialize;

use super::error::LabError;
use palpate_fit::choice::{Choice, Exponent};
use palpate_fit::hold::Terms;
use palpate_model::{Elastic, Kernel, LawOption, Laws, Separation, TERMS};
use palpate_trace::FORCE;
use palpate_trace::files::quoted;

/// What can be asked for and takes long: `{"compare": null}`, `{"add": {"effect": "lag"}}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Task {
    /// Fit a base law.
    Fit(FitTask),
    /// See where the model fails.
    Compare,
    /// See what it lacks.
    Diagnose,
    /// Add what is missing until nothing is.
    Explore,
    /// Find a formula for what the library does not explain.
    Discover,
    /// Find the motion that tells apart what these traces do not.
    Motion,
    /// Add an effect.
    Add {
        /// Its name.
        effect: String,
        /// One of its laws; the best where none is named.
        #[serde(default)]
        law: Option<String>,
    },
    /// Take an effect out.
    Drop {
        /// Its name.
        effect: String,
    },
    /// Put another model beside the one at hand.
    Beside(Other),
    /// Make a practice set with a hidden effect, and open it.
    Hide(HideTask),
    /// Read what all rows of a survey say: its folder below that opened, empty for that itself.
    Survey(String),
    /// Open the traces of one group of a survey.
    Group {
        /// The folder of the survey.
        survey: String,
        /// Number of the group.
        group: u64,
    },
    /// Read the traces of a folder below that opened: its name, empty for that itself.
    Open(String),
}

/// A model that is not the one at hand: `{"version": 0}`, `{"file": "model-1.toml"}`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Other {
    /// One of this session, from 0.
    Version(usize),
    /// A model file of the folder.
    File(String),
}

/// A base law with its options, as on the command line.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitTask {
    /// Name of the law.
    pub law: String,
    /// Number of exponentials; chosen from the data where it is 0.
    #[serde(default)]
    pub terms: Option<usize>,
    /// What happens where contact breaks.
    #[serde(default)]
    pub separation: Separation,
    /// Number of segments.
    #[serde(default)]
    pub segments: Option<u32>,
    /// Exponent n; chosen from the data where it is 0.
    #[serde(default)]
    pub exponent: Option<f64>,
    /// How the response relaxes.
    #[serde(default)]
    pub relaxation: Option<String>,
}

/// A practice set, as on the command line.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HideTask {
    /// Names of the effects; drawn from the library where there is none.
    #[serde(default)]
    pub effects: Vec<String>,
    /// How many are drawn.
    #[serde(default)]
    pub any: Option<u8>,
    /// Seed; from the clock where there is none.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Misfit that each leaves, over the noise.
    #[serde(default)]
    pub size: Option<f64>,
}

/// The files that a command names.
pub struct Names {
    /// The model, where there is one.
    pub model: Option<String>,
    /// The traces.
    pub traces: String,
    /// The model file that it writes.
    pub written: String,
    /// The column that is fitted.
    pub signal: String,
    /// The model beside.
    pub other: Option<String>,
    /// The folder of a practice set, of one to read, or of a survey.
    pub set: String,
    /// The folder of the survey that a group is of.
    pub survey: String,
}

/// The file of a motion to record next.
pub const MOTION: &str = "next-motion.csv";
/// Most effects that are drawn, as on the command line.
const MOST_HIDDEN: u8 = 5;

impl FitTask {
    /// The choice of laws.
    ///
    /// # Errors
    /// When the law is unknown.
    pub fn choice(&self) -> Result<Choice, LabError> {
        let unknown = || LabError::Unknown { what: "law", name: self.law.clone() };
        let laws = Laws::library();
        let family = laws.family(&self.law).ok_or_else(unknown)?;
        let terms = match self.terms {
            Some(0) => Terms::Auto,
            terms => Terms::Fixed(terms.unwrap_or(TERMS)),
        };
        let exponent = match self.exponent {
            Some(0.0) => Some(Exponent::Auto),
            given => given.map(Exponent::Given),
        };
        let unknown = |name: &String| LabError::Unknown { what: "relaxation", name: name.clone() };
        let kernel = match &self.relaxation {
            Some(name) if family.takes(LawOption::Relaxation) => {
                laws.kernel(name).ok_or_else(|| unknown(name))?
            }
            _ => Kernel::EXPONENTIALS,
        };
        let (separation, segments, elastic) = (self.separation, self.segments, Elastic::POWER);
        Ok(Choice { family, terms, separation, segments, exponent, elastic, kernel })
    }

    fn options(&self) -> String {
        let mut text = quoted(&self.law);
        let auto = |value: f64| if value == 0.0 { "auto".into() } else { value.to_string() };
        let terms = self.terms.filter(|&terms| terms != TERMS);
        text += &terms.map_or(String::new(), |terms| format!(" --terms {}", auto(terms as f64)));
        text += &self.segments.map_or(String::new(), |m| format!(" --segments {m}"));
        text += &self.exponent.map_or(String::new(), |n| format!(" --exponent {}", auto(n)));
        let kernel = self.relaxation.as_deref().filter(|name| *name != Kernel::EXPONENTIALS.name);
        text += &kernel.map_or(String::new(), |name| format!(" --relaxation {}", quoted(name)));
        if self.separation != Separation::default() {
            text += &format!(" --separation {}", self.separation.name());
        }
        text
    }
}

impl HideTask {
    /// How many effects are drawn.
    ///
    /// # Errors
    /// When they are more than can be hidden.
    pub fn count(&self) -> Result<usize, LabError> {
        let count = self.any.unwrap_or(1);
        if (1..=MOST_HIDDEN).contains(&count) {
            Ok(count.into())
        } else {
            Err(LabError::Law(format!("1 to {MOST_HIDDEN} effects, not {count}")))
        }
    }

    fn options(&self) -> String {
        let mut text: String =
            self.effects.iter().map(|name| format!(" {}", quoted(name))).collect();
        text += &self.any.map_or(String::new(), |count| format!(" --any {count}"));
        text += &self.seed.map_or(String::new(), |seed| format!(" --seed {seed}"));
        text + &self.size.map_or(String::new(), |size| format!(" --size {size}"))
    }
}

impl Task {
    /// The command that does the same.
    ///
    /// # Errors
    /// When it takes a model and there is none.
    pub fn command(&self, names: &Names) -> Result<String, LabError> {
        let Names { traces, written, signal, set, .. } = names;
        let model = || names.model.as_deref().ok_or(LabError::NoModel);
        Ok(match self {
            Self::Fit(fit) => {
                let plain = signal == FORCE;
                let signal =
                    if plain { String::new() } else { format!(" --signal {}", quoted(signal)) };
                format!("palpate fit {} {traces}{signal} -o {written}", fit.options())
            }
            Self::Compare => format!("palpate compare {} {traces}", model()?),
            Self::Diagnose => format!("palpate diagnose --model {} {traces}", model()?),
            Self::Explore => format!("palpate explore --model {} {traces} -o {written}", model()?),
            Self::Discover => {
                format!("palpate discover --model {} {traces} -o {written}", model()?)
            }
            Self::Motion => {
                format!("palpate diagnose --model {} {traces} --next {MOTION}", model()?)
            }
            Self::Add { effect, law } => {
                let law =
                    law.as_ref().map_or(String::new(), |law| format!(" --law {}", quoted(law)));
                format!("palpate add {} {} {traces}{law} -o {written}", quoted(effect), model()?)
            }
            Self::Drop { effect } => {
                format!("palpate drop {} {} {traces} -o {written}", quoted(effect), model()?)
            }
            Self::Beside(_) => {
                let other = names.other.as_deref().ok_or(LabError::NoModel)?;
                format!("palpate compare {} {traces}; palpate compare {other} {traces}", model()?)
            }
            Self::Hide(hide) => format!("palpate hide{} -o {set}", hide.options()),
            Self::Survey(_) => format!("palpate survey report {set}"),
            Self::Group { group, .. } => {
                format!("palpate survey traces {} {group} -o {set}", names.survey)
            }
            Self::Open(_) => format!("palpate serve {set}"),
        })
    }

    /// Whether it can be done where there is no trace yet.
    #[must_use]
    pub const fn needs_no_traces(&self) -> bool {
        matches!(self, Self::Hide(_) | Self::Open(_) | Self::Survey(_) | Self::Group { .. })
    }

    /// What is going on while it is at work.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Self::Fit(fit) => format!("fitting {}", fit.law),
            Self::Compare => "comparing".into(),
            Self::Diagnose => "looking for what is missing".into(),
            Self::Explore => "climbing the ladder".into(),
            Self::Discover => "looking for a formula".into(),
            Self::Motion => "looking for a motion that decides".into(),
            Self::Add { effect, .. } => format!("refitting with {effect}"),
            Self::Drop { effect } => format!("refitting without {effect}"),
            Self::Beside(_) => "comparing with another model".into(),
            Self::Hide(_) => "making a practice set".into(),
            Self::Survey(_) => "reading a survey".into(),
            Self::Group { .. } | Self::Open(_) => "reading traces".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_without_options_is_read_with_and_without_their_place() {
        for text in [r#""compare""#, r#"{"compare": null}"#] {
            assert_eq!(serde_json::from_str::<Task>(text).unwrap(), Task::Compare);
        }
        assert!(serde_json::from_str::<Task>(r#"{"compare": {"more": 1}}"#).is_err());
    }

    #[test]
    fn numbers_of_a_task_are_read_as_they_are_sent() {
        let task: Task = serde_json::from_slice(
            br#"{"fit": {"law": "latency-power", "segments": 8, "exponent": 2.5}}"#,
        )
        .unwrap();
        let Task::Fit(fit) = task else { panic!("a fit") };
        assert_eq!((fit.segments, fit.exponent), (Some(8), Some(2.5)));
        let task: Task =
            serde_json::from_slice(br#"{"hide": {"any": 2, "seed": 7, "size": 0.5}}"#).unwrap();
        let Task::Hide(hide) = task else { panic!("a practice set") };
        assert_eq!((hide.any, hide.seed, hide.size), (Some(2), Some(7), Some(0.5)));
    }
}
