use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Map;

use super::*;
use crate::row::Said;

fn about(asked: Asked, by: &[&str]) -> About {
    let inputs = crate::manifest::Inputs { list: String::new(), files: 0, bytes: 0 };
    About {
        palpate_survey: 1,
        version: String::new(),
        asked,
        by: by.iter().map(|key| (*key).to_owned()).collect(),
        options: Map::new(),
        command: String::new(),
        seeds: BTreeMap::new(),
        inputs,
        groups: 0,
        groups_in_a_part: 1000,
        parts: Vec::new(),
        finished: true,
    }
}

fn row(group: usize, key: &[String], said: Said) -> Row {
    Row {
        group: group as u64,
        key: key.iter().cloned().map(Some).collect(),
        status: Status::Done,
        reason: None,
        traces: 1,
        samples: 1,
        said,
    }
}

fn estimate(name: &str, value: f64, error: f64) -> Estimate {
    let (of, name, unit) = (String::new(), name.to_owned(), "N".to_owned());
    Estimate { of, name, value, standard_error: Some(error), unit }
}

/// Fits of fingers whose stiffness `p` is spread by 20 %, while `q` is the same in all; their errors go together by 0.8.
fn fits(count: usize) -> Vec<Row> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let mut fit = |k: usize| {
        let error = normal();
        let p = 0.08 * (0.2 * normal()).exp() * (1.0 + 0.05 * error);
        let q = 0.5 + 0.02 * (0.8 * error + 0.6 * normal());
        let estimates = vec![estimate("p", p, 0.05 * p), estimate("q", q, 0.02)];
        let said = Said { estimates, correlations: vec![0.8], ..Said::default() };
        row(k, &[k.to_string()], said)
    };
    (0..count).map(&mut fit).collect()
}

#[test]
fn what_varies_is_told_with_how_much_and_what_is_shared_with_how_little() {
    let found = Population::of(&about(Asked::Fit, &["finger"]), &fits(60));
    assert_eq!((found.specimens, found.groups, found.occasions), (60, 60, None));
    let [p, q] = &found.parameters[..] else { panic!("{:?}", found.parameters) };
    assert!(p.varies && p.relative && p.spread.p_value < 1e-6, "{p:?}");
    assert!(p.spread.deviation.lower < 0.2 && p.spread.deviation.upper > 0.2, "{p:?}");
    assert!(p.typical.lower < 0.08 && p.typical.upper > 0.08, "{p:?}");
    assert!(!q.varies && q.spread.deviation.upper < q.error, "{q:?}");
    assert!(found.correlations.is_none(), "only one varies");
}

#[test]
fn fingers_on_several_days_have_a_spread_of_fingers_and_one_of_days() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let mut rows = Vec::new();
    for finger in 0..30 {
        let own = 0.3 * normal();
        for day in ["2026-11-01", "2026-11-02", "2026-11-03"] {
            let value = 5.0 + own + 0.1 * normal() + 0.05 * normal();
            let said = Said { estimates: vec![estimate("p", value, 0.05)], ..Said::default() };
            rows.push(row(rows.len(), &[finger.to_string(), day.to_owned()], said));
        }
    }
    let found = Population::of(&about(Asked::Fit, &["finger", "date"]), &rows);
    assert_eq!((found.specimens, found.groups), (30, 90));
    assert_eq!(found.occasions.as_deref(), Some("date"));
    let days = found.parameters[0].occasions.unwrap();
    let relative = found.parameters[0].relative;
    assert!(relative && (5.0 * days.deviation.value - 0.1).abs() < 0.03, "{days:?}");
    assert!((5.0 * found.parameters[0].spread.deviation.value - 0.3).abs() < 0.1);
}

#[test]
fn an_effect_in_a_few_of_many_fingers_is_there_and_one_alarm_is_not() {
    let effects = |k: usize| match k {
        3 | 40 | 41 | 77 | 90 => vec!["mullins".to_owned()],
        12 => vec!["drift".to_owned()],
        _ => Vec::new(),
    };
    let said = |k: usize| Said { effects: effects(k), ..Said::default() };
    let rows: Vec<Row> = (0..100).map(|k| row(k, &[k.to_string()], said(k))).collect();
    let found = Population::of(&about(Asked::Diagnose, &["finger"]), &rows).effects;
    let told: Vec<(&str, bool)> = found.iter().map(|it| (&it.effect[..], it.is_there)).collect();
    assert_eq!(told, [("mullins", true), ("drift", false)]);
    assert!(found[0].share.lower < 0.05 && found[0].share.upper < 0.12, "{:?}", found[0].share);
}

#[test]
fn what_has_no_standard_error_is_left_out_with_the_reason() {
    let said = |k: usize| {
        let plain = Estimate { standard_error: None, ..estimate("loads", k as f64, 0.0) };
        Said { estimates: vec![plain], ..Said::default() }
    };
    let rows: Vec<Row> = (0..9).map(|k| row(k, &[k.to_string()], said(k))).collect();
    let found = Population::of(&about(Asked::Segment, &["finger"]), &rows);
    assert_eq!(found.left_out, [("loads".to_owned(), "without standard errors")]);
}
