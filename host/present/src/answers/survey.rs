//! `palpate survey`: what all rows of a survey say together.

use std::collections::BTreeMap;

use palpate_survey::overview::{Effect, FarOut, Kind, Overview, Since};
use palpate_survey::results::About;
use palpate_survey::row::{Asked, Status};
use serde::Serialize;

/// Most failures, and most values far out, that the answer lists.
const MOST_LISTED: usize = 1000;

/// What all rows of a survey say together.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SurveyAnswer {
    /// Version of this answer.
    pub palpate_survey: u32,
    /// The command that was asked of every group.
    pub asked: SurveyQuestion,
    /// Folder of the results.
    pub results: String,
    /// The keys that the traces are grouped by.
    pub by: Vec<String>,
    /// Number of groups.
    pub groups: u64,
    /// Number of groups that have a row.
    pub rows: usize,
    /// Whether all groups have a row.
    pub finished: bool,
    /// Number of groups with an answer.
    pub done: u64,
    /// Number of groups whose traces cannot be used.
    pub refused: u64,
    /// Number of groups in which the work failed.
    pub failed: u64,
    /// Number of traces.
    pub traces: u64,
    /// Number of samples.
    pub samples: u64,
    /// Processor time, s.
    pub cpu_seconds: f64,
    /// Number of groups of each verdict.
    pub verdicts: BTreeMap<String, u64>,
    /// The effects that are missing, most frequent first.
    pub missing: Vec<MissingEffect>,
    /// Each kind of estimate over all groups.
    pub estimates: Vec<EstimateDistribution>,
    /// The values far from the others of their kind, farthest first; 1000 at most.
    pub far_out: Vec<FarOutAnswer>,
    /// The groups without an answer; 1000 at most.
    pub failures: Vec<GroupFailure>,
}

/// What every group is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SurveyQuestion {
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

/// An effect that is missing in some groups.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct MissingEffect {
    /// Name of the effect.
    pub effect: String,
    /// Number of groups in which it is missing.
    pub groups: usize,
    /// Number of these in which other effects explain the data as well.
    pub ambiguous: u64,
    /// Where it is missing, in the order of its first appearance.
    #[serde(rename = "in")]
    pub specimens: Vec<MissingSince>,
}

/// Since when an effect is missing in a specimen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct MissingSince {
    /// The keys of the specimen, that of the time apart.
    pub specimen: String,
    /// Number of the first group in which it is.
    pub group: usize,
    /// Time of that group by its key, such as a date; null where no key gives a time.
    pub since: Option<String>,
    /// Number of groups in which it is.
    pub groups: usize,
}

/// One kind of estimate over all groups.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct EstimateDistribution {
    /// Name of the estimate.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Number of groups that have it.
    pub groups: usize,
    /// The least value, in `unit` as all values here.
    pub least: f64,
    /// 5th percentile.
    pub p5: f64,
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// The largest value.
    pub most: f64,
    /// The median at each time; empty where no key gives a time.
    pub over_time: Vec<MedianAt>,
}

/// The median of an estimate at one time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct MedianAt {
    /// The time by its key, such as a date.
    pub at: String,
    /// The median, in the unit of the estimate.
    pub median: f64,
    /// Number of groups.
    pub groups: usize,
}

/// A value far from the others of its kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FarOutAnswer {
    /// Number of its group.
    pub group: usize,
    /// The keys of its group.
    pub key: String,
    /// Name of the estimate.
    pub estimate: String,
    /// The value, in the unit of the estimate.
    pub value: f64,
    /// Its distance from the median in spreads of its kind, 1.48 times the median absolute deviation.
    pub spreads: f64,
}

/// A group without an answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GroupFailure {
    /// Its number.
    pub group: usize,
    /// Its keys.
    pub key: String,
    /// What became of it.
    pub status: GroupStatus,
    /// Why.
    pub reason: String,
}

/// What became of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum GroupStatus {
    /// It has an answer.
    Done,
    /// Its traces cannot be used.
    Refused,
    /// The work failed.
    Failed,
}

impl SurveyAnswer {
    /// What the rows of a survey in this folder say together.
    #[must_use]
    pub fn of(about: &About, overview: &Overview, folder: &str) -> Self {
        let effect = |(name, effect)| MissingEffect::of(overview, name, effect);
        let estimate = |kind| EstimateDistribution::of(overview, kind);
        let far_out = |far: &FarOut| FarOutAnswer {
            group: far.row,
            key: overview.groups[far.row].clone(),
            estimate: overview.kinds[far.kind].name.clone(),
            value: far.value,
            spreads: far.spreads,
        };
        let failure = |(row, status, reason): &(usize, Status, String)| GroupFailure {
            group: *row,
            key: overview.groups[*row].clone(),
            status: (*status).into(),
            reason: reason.clone(),
        };
        Self {
            palpate_survey: 1,
            asked: about.asked.into(),
            results: folder.to_owned(),
            by: about.by.clone(),
            groups: about.groups,
            rows: overview.groups.len(),
            finished: about.finished,
            done: overview.count(Status::Done),
            refused: overview.count(Status::Refused),
            failed: overview.count(Status::Failed),
            traces: overview.traces,
            samples: overview.samples,
            cpu_seconds: overview.seconds,
            verdicts: overview.verdicts.clone(),
            missing: overview.most_frequent_effects().into_iter().map(effect).collect(),
            estimates: overview.kinds.iter().map(estimate).collect(),
            far_out: overview.far_out().iter().take(MOST_LISTED).map(far_out).collect(),
            failures: overview.failures.iter().take(MOST_LISTED).map(failure).collect(),
        }
    }
}

impl MissingEffect {
    fn of(overview: &Overview, name: &str, effect: &Effect) -> Self {
        Self {
            effect: name.to_owned(),
            groups: effect.rows.len(),
            ambiguous: effect.ambiguous,
            specimens: overview.since(effect).into_iter().map(MissingSince::from).collect(),
        }
    }
}

impl From<Since> for MissingSince {
    fn from(since: Since) -> Self {
        let Since { specimen, row, first, rows } = since;
        Self { specimen, group: row, since: first, groups: rows }
    }
}

impl EstimateDistribution {
    fn of(overview: &Overview, kind: &Kind) -> Self {
        let at = |(at, median, groups): (&str, f64, usize)| MedianAt {
            at: at.to_owned(),
            median,
            groups,
        };
        Self {
            name: kind.name.clone(),
            unit: kind.unit.clone(),
            groups: kind.values.len(),
            least: kind.quantile(0.0),
            p5: kind.quantile(0.05),
            median: kind.quantile(0.5),
            p95: kind.quantile(0.95),
            most: kind.quantile(1.0),
            over_time: overview.over_time(kind).into_iter().map(at).collect(),
        }
    }
}

impl From<Asked> for SurveyQuestion {
    fn from(asked: Asked) -> Self {
        match asked {
            Asked::Fit => Self::Fit,
            Asked::Compare => Self::Compare,
            Asked::Diagnose => Self::Diagnose,
            Asked::Segment => Self::Segment,
            Asked::Relaxation => Self::Relaxation,
            Asked::Decompose => Self::Decompose,
        }
    }
}

impl From<Status> for GroupStatus {
    fn from(status: Status) -> Self {
        match status {
            Status::Done => Self::Done,
            Status::Refused => Self::Refused,
            Status::Failed => Self::Failed,
        }
    }
}
