use super::*;
use crate::part::tests::rows;
use crate::row::Status;

fn plan(groups: u64) -> Plan {
    let group = |number| Group { number, key: vec![Some(number.to_string())], places: Vec::new() };
    let input = Input { path: "a.csv".into(), bytes: 10, modified_ns: 5 };
    let groups = (0..groups).map(group).collect();
    Plan {
        asked: Asked::Fit,
        by: vec!["finger".into()],
        options: [("--terms".to_owned(), "2".into())].into_iter().collect(),
        command: "palpate survey fit".into(),
        seeds: BTreeMap::new(),
        sources: Sources { inputs: vec![input], groups },
    }
}

fn row(group: u64) -> (Row, Worked) {
    let (key, said) = (vec![Some(group.to_string())], rows()[1].said.clone());
    let row = Row { group, key, status: Status::Done, reason: None, traces: 1, samples: 9, said };
    (row, Worked { seconds: 0.25, attempts: 1 })
}

fn numbers(groups: &[Group]) -> Vec<u64> {
    groups.iter().map(|group| group.number).collect()
}

#[test]
fn a_survey_that_ends_early_goes_on_where_it_was_and_doubles_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("results");
    let all = 2 * GROUPS_IN_A_PART + 3;
    let mut results = Results::begin(&at, plan(all), false).unwrap();
    // The first part, all but one of the second, and one of the third, in an order of their own.
    let done = (1..2 * GROUPS_IN_A_PART).rev().chain([0, all - 1]);
    for group in done {
        if group != GROUPS_IN_A_PART + 7 {
            let (row, worked) = row(group);
            results.add(row, worked).unwrap();
        }
    }
    drop(results);
    assert!(!about(&at).unwrap().finished);
    let mut results = Results::begin(&at, plan(all), false).unwrap();
    let missing = numbers(&results.missing());
    assert_eq!(missing, [GROUPS_IN_A_PART + 7, all - 3, all - 2]);
    for group in missing {
        let (row, worked) = row(group);
        results.add(row, worked).unwrap();
    }
    drop(results);
    let about = about(&at).unwrap();
    assert!(about.finished);
    assert_eq!(about.parts.iter().map(|part| part.groups).sum::<u64>(), all);
    let mut back = Vec::new();
    read_rows(&at, &about, |row, worked| back.push((row, worked))).unwrap();
    assert_eq!(back, (0..all).map(row).collect::<Vec<_>>());
    assert_eq!(fs::read_dir(at.join(UNFINISHED)).unwrap().count(), 0);
}

#[test]
fn the_same_rows_make_the_same_bytes_in_whatever_order_they_came() {
    let made = |order: [u64; 4]| {
        let folder = tempfile::tempdir().unwrap();
        let mut results = Results::begin(folder.path(), plan(4), false).unwrap();
        for group in order {
            let (row, worked) = row(group);
            results.add(row, worked).unwrap();
        }
        fs::read(folder.path().join(FOUND).join("part-00000.parquet")).unwrap()
    };
    assert_eq!(made([0, 1, 2, 3]), made([3, 1, 0, 2]));
}

#[test]
fn results_of_another_call_are_refused_with_what_is_other() {
    let folder = tempfile::tempdir().unwrap();
    drop(Results::begin(folder.path(), plan(4), false).unwrap());
    let refused = |plan| {
        let Err(error) = Results::begin(folder.path(), plan, false) else { panic!("was taken") };
        error.to_string()
    };
    let mut other = plan(4);
    other.options.insert("--terms".into(), "3".into());
    assert!(refused(other.clone()).contains("with --terms `2`, this call has `3`"));
    let mut changed = plan(4);
    changed.sources.inputs[0].modified_ns = 6;
    assert!(refused(changed).contains("a.csv is new, changed or gone"));
    let mut by = plan(4);
    by.by = vec!["specimen".into()];
    assert!(refused(by).contains("--by finger, this call has specimen"));
    Results::begin(folder.path(), other, true).unwrap();
}

#[test]
fn a_folder_of_anything_else_is_left_alone_and_one_that_is_written_to_as_well() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("thesis.tex"), "years of work").unwrap();
    for anew in [false, true] {
        let error = Results::begin(folder.path(), plan(1), anew).err().unwrap();
        assert!(matches!(error, ResultsError::NotEmpty(_)), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let folder = tempfile::tempdir().unwrap();
    let writing = Results::begin(folder.path(), plan(1), false).unwrap();
    let error = Results::begin(folder.path(), plan(1), false).err().unwrap();
    assert!(matches!(error, ResultsError::Busy(_)), "{error}");
    drop(writing);
    Results::begin(folder.path(), plan(1), false).unwrap();
    let mut reserved = plan(1);
    reserved.by = vec!["status".into()];
    let error = Results::begin(folder.path(), reserved, true).err().unwrap();
    assert!(matches!(error, ResultsError::Reserved(_)), "{error}");
}
