//! A survey in the Lab: its groups, and the traces of one of them.

use std::path::Path;

use serde_json::{Value, json};

use super::error::LabError;
use super::folder::Folder;
use palpate_present::answers::{self, SurveyAnswer};
use palpate_survey::overview::Overview;
use palpate_survey::results::{about, group, read_rows};
use palpate_survey::{Group, Place, Row, Status, apart};
use palpate_trace::write;

/// Most groups that are listed, those first that are not as the others.
const LISTED: usize = 2_000;

/// The folder that the traces of a group are put into, below that opened.
#[must_use]
pub fn group_folder(survey: &str, group: u64) -> String {
    match survey {
        "" => format!("group-{group}"),
        survey => format!("{survey}-group-{group}"),
    }
}

/// What all rows of a survey say together, and each of its groups: what failed and what misses an effect first.
///
/// # Errors
/// When there is no survey in the folder, or it is damaged.
pub fn surveyed(folder: &Folder, name: &str) -> Result<Value, LabError> {
    let path = folder.existing(name)?;
    let about = about(&path)?;
    let mut overview = Overview::new(&about);
    let mut rows = Vec::new();
    read_rows(&path, &about, |row, worked| {
        overview.add(&row, worked);
        rows.push(row);
    })?;
    overview.finish();
    rows.sort_by_key(|row| (place(row), row.group));
    let all = rows.len();
    rows.truncate(LISTED);
    let groups: Vec<Value> = rows.iter().map(|row| group_json(row, &about.by)).collect();
    let mut answer = answers::json(&SurveyAnswer::of(&about, &overview, &folder.shown(name)));
    answer["name"] = name.into();
    answer["groups_in_all"] = all.into();
    answer["listed"] = groups.into();
    Ok(answer)
}

/// What is looked at first: failures, then missing effects, then what is unknown.
fn place(row: &Row) -> u8 {
    match (row.status, row.said.effects.is_empty(), row.said.verdict.as_deref()) {
        (Status::Failed | Status::Refused, ..) => 0,
        (_, false, _) => 1,
        (_, true, Some("unknown")) => 2,
        _ => 3,
    }
}

fn group_json(row: &Row, by: &[String]) -> Value {
    let said = &row.said;
    json!({
        "group": row.group,
        "key": palpate_survey::group::in_words(by, &row.key),
        "status": row.status.word(),
        "reason": row.reason,
        "traces": row.traces,
        "verdict": said.verdict,
        "effects": said.effects,
        "credible_set": said.credible_set,
        "rms": said.residual_rms,
        "unit": said.unit,
    })
}

/// Puts the traces of a group into a folder of their own, unless they are there: its name.
///
/// # Errors
/// When there is no such group, one of its files lies outside the folder that was opened, or cannot be read or written.
pub fn take_group(folder: &Folder, survey: &str, number: u64) -> Result<String, LabError> {
    let results = folder.existing(survey)?;
    let group = group(&results, number)?;
    check_inside(folder, &group)?;
    let name = group_folder(survey, number);
    let target = folder.to_write(&name)?;
    if target.is_dir() {
        return Ok(name);
    }
    let traces = apart(&about(&results)?, &group)?;
    let failed = |source| LabError::Io { path: target.clone(), source };
    // Hidden until all are there; what a killed server left goes.
    let unfinished = folder.to_write(&format!(".{name}"))?;
    if unfinished.is_dir() {
        std::fs::remove_dir_all(&unfinished).map_err(failed)?;
    }
    std::fs::create_dir(&unfinished).map_err(failed)?;
    for (file, trace) in &traces {
        write(&unfinished.join(file), trace)?;
    }
    std::fs::rename(&unfinished, &target).map_err(failed)?;
    Ok(name)
}

/// Nothing outside the folder that was opened is read, also not where a survey names it.
fn check_inside(folder: &Folder, group: &Group) -> Result<(), LabError> {
    let root = folder.existing("")?;
    for place in &group.places {
        let (Place::File(path) | Place::Rows { path, .. }) = place;
        let real =
            path.canonicalize().map_err(|source| LabError::Io { path: path.clone(), source })?;
        if !real.starts_with(&root) {
            return Err(LabError::Elsewhere { path: path.clone(), above: above(&root, &real) });
        }
    }
    Ok(())
}

/// The folder that holds both.
fn above(one: &Path, other: &Path) -> std::path::PathBuf {
    let both = one.components().zip(other.components()).take_while(|(one, other)| one == other);
    both.map(|(part, _)| part).collect()
}
