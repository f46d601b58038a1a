//! What an answer is as a row of a table.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::flat;

/// One group with what is known of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its place in the survey, from 0.
    pub group: u64,
    /// The value of each key that traces are grouped by.
    pub key: Vec<Option<String>>,
    /// Whether there is an answer.
    pub status: Status,
    /// Why there is none, or why it is not to be used.
    pub reason: Option<String>,
    /// Number of its traces; 0 where they could not be read.
    pub traces: u64,
    /// Number of their samples.
    pub samples: u64,
    /// What the answer says.
    pub said: Said,
}

/// Whether there is an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// There is: the single command ends with status 0.
    Done,
    /// The traces cannot be used: the single command ends with status 2.
    Refused,
    /// The work failed: the single command ends with status 1, or gave up in the middle.
    Failed,
}

impl Status {
    /// All.
    pub const ALL: [Self; 3] = [Self::Done, Self::Refused, Self::Failed];

    /// In one word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Refused => "refused",
            Self::Failed => "failed",
        }
    }
}

/// What an answer says, as far as it says that.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Said {
    /// Unit of the errors.
    pub unit: Option<String>,
    /// Root mean square of the residual.
    pub residual_rms: Option<f64>,
    /// Noise of one sample.
    pub noise_rms: Option<f64>,
    /// Root mean square error on traces left out.
    pub heldout_rms: Option<f64>,
    /// Coefficient of determination.
    pub r_squared: Option<f64>,
    /// The verdict in a word or two.
    pub verdict: Option<String>,
    /// The effects that are missing, in the order in which they were found.
    pub effects: Vec<String>,
    /// The effects that the traces cannot tell from the last of these, itself included.
    pub credible_set: Vec<String>,
    /// The answer in words.
    pub in_words: Option<String>,
    /// What to record next.
    pub next_experiment: Option<String>,
    /// What to beware of.
    pub warnings: Vec<String>,
    /// Every number that was estimated.
    pub estimates: Vec<Estimate>,
    /// Correlations between the errors of these, above the diagonal, row by row; empty where the answer does not tell them.
    #[serde(default)]
    pub correlations: Vec<f64>,
}

/// A number that was estimated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// What it is of: an effect, a trace with its cycle, a hold; empty for the whole group.
    pub of: String,
    /// What it is.
    pub name: String,
    /// The number.
    pub value: f64,
    /// Its standard error, where the data tell one.
    pub standard_error: Option<f64>,
    /// Its unit; empty for none.
    pub unit: String,
}

impl Estimate {
    /// What is alike in all groups: the name, with the effect that it is of.
    #[must_use]
    pub fn kind(&self) -> String {
        if self.of.is_empty() { self.name.clone() } else { format!("{}: {}", self.of, self.name) }
    }
}

/// What the answer to one group cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Worked {
    /// Processor time, s.
    pub seconds: f64,
    /// How often it was tried.
    pub attempts: u64,
}

/// What was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Asked {
    /// `palpate fit`.
    Fit,
    /// `palpate compare`.
    Compare,
    /// `palpate diagnose`.
    Diagnose,
    /// `palpate segment`.
    Segment,
    /// `palpate relaxation`.
    Relaxation,
    /// `palpate decompose`.
    Decompose,
}

impl Asked {
    /// The name of the command.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Fit => "fit",
            Self::Compare => "compare",
            Self::Diagnose => "diagnose",
            Self::Segment => "segment",
            Self::Relaxation => "relaxation",
            Self::Decompose => "decompose",
        }
    }
}

impl Said {
    /// What an answer says, from the object that the single command prints with `--json`.
    #[must_use]
    pub fn of(asked: Asked, answer: &Value) -> Self {
        let mut said = match asked {
            // A fit of holds, or of every law, has no parameters of its own.
            Asked::Fit if answer.get("parameters").is_some() => of_fit(answer),
            Asked::Compare => of_comparison(answer),
            Asked::Diagnose => of_diagnosis(answer),
            Asked::Fit | Asked::Segment | Asked::Relaxation | Asked::Decompose => {
                Self { estimates: flat::estimates(answer), ..Self::default() }
            }
        };
        said.unit = text(answer, "unit");
        said.warnings = flat::warnings(answer);
        said
    }

    /// The correlation between the errors of two estimates, by their places; none where the answer does not tell it.
    #[must_use]
    pub fn correlation_of(&self, one: usize, other: usize) -> Option<f64> {
        let (row, column) = (one.min(other), one.max(other));
        if row == column {
            return Some(1.0);
        }
        let before = row * self.estimates.len() - row * (row + 1) / 2;
        self.correlations.get(before + column - row - 1).copied()
    }
}

fn number(answer: &Value, name: &str) -> Option<f64> {
    answer.get(name)?.as_f64()
}

fn text(answer: &Value, name: &str) -> Option<String> {
    Some(answer.get(name)?.as_str()?.to_owned())
}

fn texts(answer: &Value, name: &str) -> Vec<String> {
    let all = answer.get(name).and_then(Value::as_array).into_iter().flatten();
    all.filter_map(Value::as_str).map(str::to_owned).collect()
}

fn of_fit(answer: &Value) -> Said {
    let order = texts(&answer["correlation"], "order");
    let estimates = order.iter().filter_map(|name| {
        let found = &answer["parameters"][name];
        flat::estimate("", name, found)
    });
    let estimates: Vec<Estimate> = estimates.collect();
    let matrix = &answer["correlation"]["matrix"];
    let pairs = (0..order.len()).flat_map(|row| (row + 1..order.len()).map(move |it| (row, it)));
    let correlations: Option<Vec<f64>> =
        pairs.map(|(row, column)| matrix[row][column].as_f64()).collect();
    let told = correlations.filter(|_| estimates.len() == order.len());
    Said {
        correlations: told.unwrap_or_default(),
        residual_rms: number(answer, "residual_rms"),
        noise_rms: number(answer, "noise_rms"),
        heldout_rms: number(answer, "heldout_rms"),
        r_squared: number(answer, "r_squared"),
        estimates,
        ..Said::default()
    }
}

fn of_comparison(answer: &Value) -> Said {
    let only_noise = answer["only_noise"].as_bool().unwrap_or(false);
    let unit = text(answer, "unit").unwrap_or_default();
    let array = |name: &str| answer[name].as_array().into_iter().flatten();
    let of = |of: String, name: &str, value: &Value, unit: &str| {
        let (name, unit) = (name.to_owned(), unit.to_owned());
        Some(Estimate { of, name, value: value.as_f64()?, standard_error: None, unit })
    };
    // A single trace needs no name.
    let mut traces = array("where").map(|cell| &cell["trace"]);
    let first = traces.next();
    let single = traces.all(|trace| Some(trace) == first);
    let places = array("where").flat_map(|cell| {
        let part = |name: &str| text(cell, name).unwrap_or_default();
        let place = if single { part("phase") } else { part("trace") + ", " + &part("phase") };
        let share = of(place.clone(), "share_of_excess", &cell["share_of_excess"], "");
        [of(place, "rms", &cell["rms"], &unit), share]
    });
    let dependences = array("depends_on").flat_map(|found| {
        let covariate = text(found, "covariate").unwrap_or_default();
        ["explained", "p_value"].map(|name| of(covariate.clone(), name, &found[name], ""))
    });
    Said {
        residual_rms: number(answer, "rms"),
        noise_rms: number(answer, "noise_rms"),
        verdict: Some(if only_noise { "only noise" } else { "more than noise" }.into()),
        in_words: text(answer, "in_words"),
        estimates: places.chain(dependences).flatten().collect(),
        ..Said::default()
    }
}

fn of_diagnosis(answer: &Value) -> Said {
    let steps = || answer["steps"].as_array().into_iter().flatten();
    let estimates = steps().flat_map(|step| {
        let effect = text(step, "effect").unwrap_or_default();
        let parameters = step["parameters"].as_object().into_iter().flatten();
        let found = parameters.filter_map(|(name, value)| flat::estimate(&effect, name, value));
        found.collect::<Vec<_>>()
    });
    let last = steps().last();
    Said {
        residual_rms: number(answer, "final_rms"),
        noise_rms: number(answer, "noise_rms"),
        heldout_rms: last.and_then(|step| number(step, "heldout_rms_after")),
        verdict: text(answer, "verdict"),
        effects: steps().filter_map(|step| text(step, "effect")).collect(),
        credible_set: last.map_or(Vec::new(), |step| texts(step, "credible_set")),
        in_words: text(answer, "in_words"),
        next_experiment: text(answer, "next_experiment"),
        estimates: estimates.collect(),
        ..Said::default()
    }
}
