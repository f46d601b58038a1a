//! What a model foretells of a press while it is held, and whether it fails: [`held`](crate::held) of each gauge.

use std::collections::VecDeque;

use serde_json::{Value, json};
use shared::adaptation::Relaxation;
use shared::pipeline::GAUGES;
use shared::wire::Row;

use crate::held::{Failure, Follower, Hold, Law, Sample, Standing};
use palpate_report::number::{significant, typographic, with_error};

/// Holds kept; older ones are forgotten first.
const HOLDS: usize = 4_096;
/// Holds that a page is told with each message: the last of each gauge, and those before.
const MAX_HOLDS: usize = 4 * GAUGES;

/// A model that was named.
#[derive(Clone, Debug)]
pub struct Given {
    /// Its file.
    pub name: String,
    /// What of it holds of a press that stands.
    pub law: Law,
}

/// Follows all gauges with the model that was named, or with the filter of the device.
#[derive(Debug, Default)]
pub(super) struct Foretelling {
    given: Option<Given>,
    filter: Option<Relaxation>,
    followers: Option<[Follower; GAUGES]>,
    /// Session time less device time, s.
    offset: f64,
}

impl Foretelling {
    pub(super) fn new(given: Option<Given>) -> Self {
        Self { given, ..Self::default() }
    }

    /// What comes next does not go on from what was felt.
    pub(super) fn begin(&mut self, told: &mut Foretold) {
        let offset = self.offset;
        for (gauge, follower) in self.followers.iter_mut().flatten().enumerate() {
            if let Some(hold) = follower.begin() {
                told.keep(hold_json(gauge, &hold, offset));
            }
        }
    }

    /// Takes rows, `interval_s` apart, that end at a time of the session, s, of a device with this filter.
    pub(super) fn take(
        &mut self,
        rows: &[Row],
        (interval_s, now_s): (f64, f64),
        filter: &Relaxation,
        told: &mut Foretold,
    ) {
        let Some(end) = rows.last() else { return };
        let changed = self.given.is_none() && self.filter.as_ref() != Some(filter);
        if changed || self.followers.is_none() {
            self.begin(told);
            let law = || {
                self.given
                    .as_ref()
                    .map_or_else(|| Law::of_filter(filter), |given| given.law.clone())
            };
            told.law = law_json(self.given.as_ref(), &law());
            self.followers = Some(std::array::from_fn(|_| Follower::new(law())));
            self.filter = Some(*filter);
        }
        self.offset = now_s - end.time_us as f64 * 1e-6;
        let Some(followers) = &mut self.followers else { return };
        for row in rows {
            for (gauge, follower) in followers.iter_mut().enumerate() {
                let sample = Sample {
                    time: row.time_us as f64 * 1e-6,
                    signal: shared::fixed::microstrain(row.fa[gauge] + row.sa[gauge]),
                    region: row.states[gauge].region,
                    entered_ago: row.entered[gauge].map(|samples| f64::from(samples) * interval_s),
                };
                if let Some(hold) = follower.take(sample) {
                    told.keep(hold_json(gauge, &hold, self.offset));
                }
            }
        }
        told.now = followers
            .iter()
            .enumerate()
            .filter_map(|(gauge, follower)| {
                let mut hold = hold_json(gauge, follower.hold_now()?, self.offset);
                hold["goes_on"] = true.into();
                Some(hold)
            })
            .collect();
        told.gauges = followers.iter().map(|follower| standing_json(follower.standing())).collect();
        told.words = words(followers);
    }
}

/// What pages are told of it.
#[derive(Debug, Default)]
pub struct Foretold {
    law: Value,
    gauges: Vec<Value>,
    words: String,
    now: Vec<Value>,
    holds: VecDeque<Value>,
}

impl Foretold {
    fn keep(&mut self, hold: Value) {
        if self.holds.len() >= HOLDS {
            self.holds.pop_front();
        }
        self.holds.push_back(hold);
    }

    /// As the page reads it, with the last holds.
    #[must_use]
    pub fn json(&self) -> Value {
        let last = self.holds.range(self.holds.len().saturating_sub(MAX_HOLDS)..);
        json!({
            "law": self.law,
            "gauges": self.gauges,
            "words": self.words,
            "holds": last.chain(&self.now).collect::<Vec<_>>(),
        })
    }

    /// The holds of a stretch of the session, s.
    #[must_use]
    pub fn holds_of(&self, from_s: f64, to_s: f64) -> Vec<&Value> {
        let time = |hold: &Value, name: &str| hold[name].as_f64().unwrap_or(f64::NAN);
        let reaches = |hold: &&Value| time(hold, "from_s") <= to_s && time(hold, "to_s") >= from_s;
        self.holds.iter().chain(&self.now).filter(reaches).collect()
    }
}

fn law_json(given: Option<&Given>, law: &Law) -> Value {
    json!({
        "file": given.map(|given| &given.name),
        "formula": law.formula(),
        "left_out": law.left_out,
    })
}

fn standing_json(standing: Standing) -> Value {
    json!(match standing {
        Standing::NoHistory => "no-history",
        Standing::Rests => "rests",
        Standing::Moves => "moves",
        Standing::Begins => "begins",
        Standing::Agrees => "agrees",
        Standing::Fails => "fails",
    })
}

/// A hold in times of the session.
fn hold_json(gauge: usize, hold: &Hold, offset: f64) -> Value {
    json!({
        "gauge": gauge,
        "entered_s": hold.entered + offset,
        "from_s": hold.from + offset,
        "to_s": hold.to + offset,
        "level": hold.level,
        "parts": hold.parts,
        "residual": hold.residual.map(|(residual, _)| residual),
        "standard_error": hold.residual.map(|(_, error)| error),
        "failure": hold.failure.map(|failure| json!({
            "after_s": failure.after,
            "residual": failure.residual,
            "changes_less": failure.changes_less,
            "acting_s": failure.acting,
        })),
    })
}

/// What is said of all gauges: the most telling of what is said of each.
fn words(followers: &[Follower; GAUGES]) -> String {
    let holds: Vec<(usize, &Hold)> = followers
        .iter()
        .enumerate()
        .filter_map(|(gauge, follower)| Some((gauge, follower.hold_now()?)))
        .collect();
    if let Some(words) = failure_words(&holds) {
        return words;
    }
    let any = |standing| followers.iter().any(|follower| follower.standing() == standing);
    let sentence = [
        (Standing::Agrees, "The model holds: what is left is within the noise."),
        (
            Standing::Begins,
            "The motion has come to stand; what is felt now is taken for the start.",
        ),
        (
            Standing::Moves,
            "The finger moves, or has let go. How it moves is not measured, so nothing is predicted until it stands in contact.",
        ),
        (Standing::Rests, "At rest. A press is predicted while it is held."),
    ];
    let said = sentence.into_iter().find(|(standing, _)| any(*standing));
    let unknown = "What was felt before is not known; a rest, or some time, is needed first.";
    said.map_or(unknown, |(_, words)| words).to_owned()
}

/// Where the model fails and in which direction; none where it does not.
fn failure_words(holds: &[(usize, &Hold)]) -> Option<String> {
    let failed = |(gauge, hold): &(usize, &Hold)| Some((*gauge, hold.failure?, hold.residual?));
    let failed: Vec<(usize, Failure, (f64, f64))> = holds.iter().filter_map(failed).collect();
    let (_, first, _) = failed.iter().min_by(|(_, a, _), (_, b, _)| a.after.total_cmp(&b.after))?;
    let where_now = failed.iter().map(|(gauge, _, (residual, error))| {
        let side = if *residual > 0.0 { "above" } else { "below" };
        let size = typographic(&with_error(residual.abs(), *error));
        format!("gauge {} is {size} µε {side} it", gauge + 1)
    });
    let less = failed.iter().filter(|(_, failure, _)| failure.changes_less).count();
    let change = match less {
        0 => "The signal changes more than the model predicts",
        _ if less == failed.len() => "The signal changes less than the model predicts",
        _ => "The signal changes more than the model predicts at some gauges and less at others",
    };
    let acting = first.acting.map_or(String::new(), |acting| {
        format!(", first while its part of {} s relaxed", typographic(&significant(acting, 2)))
    });
    Some(format!(
        "The model fails now, in region CD, since {:.1} s into the hold: {}. {change}{acting}.",
        first.after,
        where_now.collect::<Vec<_>>().join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_holds_are_forgotten_and_those_of_a_stretch_are_found() {
        let mut told = Foretold::default();
        for number in 0..HOLDS + 10 {
            let begin = number as f64;
            told.keep(json!({ "from_s": begin, "to_s": begin + 0.5 }));
        }
        assert_eq!(told.holds.len(), HOLDS);
        assert_eq!(told.json()["holds"].as_array().unwrap().len(), MAX_HOLDS);
        let found = told.holds_of(100.4, 101.2);
        assert_eq!(found.iter().map(|hold| &hold["from_s"]).collect::<Vec<_>>(), [100.0, 101.0]);
        assert!(told.holds_of(0.0, 9.4).is_empty());
    }
}
