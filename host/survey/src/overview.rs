//! What all rows of a survey say together.

use std::collections::BTreeMap;

use super::group::in_words;
use super::results::About;
use super::row::{Row, Status, Worked};

/// Keys that put groups in an order of time.
const ORDERS: [&str; 8] =
    ["date", "day", "time", "start_s", "session", "sequence", "order", "cycle"];
/// A value is far out beyond so many times the spread of its kind, the median absolute deviation made comparable with a
/// standard deviation.
pub const FAR: f64 = 6.0;
const AS_DEVIATION: f64 = 1.4826;
/// Fewest values that tell what is far out.
const MIN_VALUES: usize = 8;

/// What all rows say together; of each row its keys and the values of its estimates are kept, and of failures the reason.
#[derive(Clone, Debug)]
pub struct Overview {
    by: Vec<String>,
    /// Which key tells the order of time, if one does.
    order: Option<usize>,
    /// The groups in words, in order.
    pub groups: Vec<String>,
    keys: Vec<Vec<Option<String>>>,
    /// Number of rows of each status.
    pub status: BTreeMap<Status, u64>,
    /// Number of rows of each verdict.
    pub verdicts: BTreeMap<String, u64>,
    /// Number of traces.
    pub traces: u64,
    /// Number of samples.
    pub samples: u64,
    /// Processor time, s.
    pub seconds: f64,
    /// The longest for one group, s.
    pub longest: f64,
    /// Every kind of estimate, in the order in which they came.
    pub kinds: Vec<Kind>,
    /// The groups in which an effect is missing, by the effect; those that cannot be told from it are beside it.
    pub effects: BTreeMap<String, Effect>,
    /// What failed or was refused: which row, and why.
    pub failures: Vec<(usize, Status, String)>,
}

/// One kind of estimate over all groups.
#[derive(Clone, Debug, Default)]
pub struct Kind {
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Which row, and the value.
    pub values: Vec<(usize, f64)>,
    /// The same in order of size.
    sorted: Vec<f64>,
}

/// One effect over all groups.
#[derive(Clone, Debug, Default)]
pub struct Effect {
    /// The rows in which it is missing.
    pub rows: Vec<usize>,
    /// Number of these in which others cannot be told from it.
    pub ambiguous: u64,
}

impl Overview {
    /// Takes all rows in.
    #[must_use]
    pub fn new(about: &About) -> Self {
        let order = ORDERS.iter().find_map(|name| about.by.iter().position(|key| key == name));
        Self {
            by: about.by.clone(),
            order,
            groups: Vec::new(),
            keys: Vec::new(),
            status: BTreeMap::new(),
            verdicts: BTreeMap::new(),
            traces: 0,
            samples: 0,
            seconds: 0.0,
            longest: 0.0,
            kinds: Vec::new(),
            effects: BTreeMap::new(),
            failures: Vec::new(),
        }
    }

    /// Takes one row in.
    pub fn add(&mut self, row: &Row, worked: Worked) {
        let index = self.groups.len();
        self.groups.push(in_words(&self.by, &row.key));
        self.keys.push(row.key.clone());
        *self.status.entry(row.status).or_default() += 1;
        self.traces += row.traces;
        self.samples += row.samples;
        self.seconds += worked.seconds;
        self.longest = self.longest.max(worked.seconds);
        if row.status != Status::Done {
            self.failures.push((index, row.status, row.reason.clone().unwrap_or_default()));
            return;
        }
        let said = &row.said;
        if let Some(verdict) = &said.verdict {
            *self.verdicts.entry(verdict.clone()).or_default() += 1;
        }
        let unit = said.unit.as_deref().unwrap_or_default();
        for (name, value) in
            [("residual RMS", said.residual_rms), ("held-out RMS", said.heldout_rms)]
        {
            if let Some(value) = value {
                self.take(index, name, unit, value);
            }
        }
        for estimate in &said.estimates {
            self.take(index, &estimate.kind(), &estimate.unit, estimate.value);
        }
        for (k, effect) in said.effects.iter().enumerate() {
            let known = self.effects.entry(effect.clone()).or_default();
            known.rows.push(index);
            let last = k + 1 == said.effects.len();
            known.ambiguous += u64::from(last && said.credible_set.len() > 1);
        }
    }

    fn take(&mut self, row: usize, name: &str, unit: &str, value: f64) {
        let known = self.kinds.iter().position(|kind| kind.name == name);
        let at = known.unwrap_or_else(|| {
            self.kinds.push(Kind { name: name.into(), unit: unit.into(), ..Kind::default() });
            self.kinds.len() - 1
        });
        self.kinds[at].values.push((row, value));
    }

    /// No more rows come.
    pub fn finish(&mut self) {
        for kind in &mut self.kinds {
            kind.sorted = kind.values.iter().map(|(_, value)| *value).collect();
            kind.sorted.sort_by(f64::total_cmp);
        }
    }

    /// Number of rows of a status.
    #[must_use]
    pub fn count(&self, status: Status) -> u64 {
        self.status.get(&status).copied().unwrap_or(0)
    }

    /// The effects that are missing, most frequent first.
    #[must_use]
    pub fn most_frequent_effects(&self) -> Vec<(&str, &Effect)> {
        let mut all: Vec<_> =
            self.effects.iter().map(|(name, effect)| (name.as_str(), effect)).collect();
        all.sort_by_key(|(_, effect)| std::cmp::Reverse(effect.rows.len()));
        all
    }

    /// The key that tells the order of time.
    #[must_use]
    pub fn order(&self) -> Option<&str> {
        self.order.map(|order| self.by[order].as_str())
    }

    /// When a row was recorded, as its key has it.
    #[must_use]
    pub fn when(&self, row: usize) -> Option<&str> {
        self.keys[row].get(self.order?)?.as_deref()
    }

    /// A row without when it was recorded: the specimen.
    #[must_use]
    pub fn specimen(&self, row: usize) -> String {
        let others = |k: &usize| Some(*k) != self.order;
        let pick = (0..self.by.len()).filter(others);
        let (by, key): (Vec<String>, Vec<Option<String>>) =
            pick.map(|k| (self.by[k].clone(), self.keys[row][k].clone())).unzip();
        in_words(&by, &key)
    }

    /// All times at which was recorded, in order.
    #[must_use]
    pub fn times(&self) -> Vec<&str> {
        let mut times: Vec<&str> = (0..self.keys.len()).filter_map(|row| self.when(row)).collect();
        times.sort_by(|a, b| by_time(a, b));
        times.dedup();
        times
    }

    /// In which specimens an effect is missing, with the first and last time and how often; in the order of the first.
    #[must_use]
    pub fn since(&self, effect: &Effect) -> Vec<Since> {
        let mut found: Vec<Since> = Vec::new();
        for &row in &effect.rows {
            let (specimen, when) = (self.specimen(row), self.when(row).map(str::to_owned));
            match found.iter_mut().find(|since| since.specimen == specimen) {
                Some(known) => {
                    known.rows += 1;
                    let (a, b) =
                        (when.as_deref().unwrap_or(""), known.first.as_deref().unwrap_or(""));
                    if by_time(a, b).is_lt() {
                        known.first = when;
                        known.row = row;
                    }
                }
                None => found.push(Since { specimen, row, first: when, rows: 1 }),
            }
        }
        let first = |since: &Since| since.first.clone().unwrap_or_default();
        found.sort_by(|a, b| by_time(&first(a), &first(b)));
        found
    }

    /// The values that lie far from the others of their kind, farthest first.
    #[must_use]
    pub fn far_out(&self) -> Vec<FarOut> {
        let mut found = Vec::new();
        for (index, kind) in self.kinds.iter().enumerate() {
            let Some((median, spread)) = kind.median_and_spread() else { continue };
            let far = |(row, value): &(usize, f64)| {
                let spreads = (value - median) / spread;
                (spreads.abs() > FAR).then_some(FarOut {
                    kind: index,
                    row: *row,
                    value: *value,
                    spreads,
                })
            };
            found.extend(kind.values.iter().filter_map(far));
        }
        found.sort_by(|a, b| b.spreads.abs().total_cmp(&a.spreads.abs()));
        found
    }

    /// The median of a kind at each time, with the number of values; none where no key tells the time.
    #[must_use]
    pub fn over_time(&self, kind: &Kind) -> Vec<(&str, f64, usize)> {
        let mut at: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for &(row, value) in &kind.values {
            if let Some(when) = self.when(row) {
                at.entry(when).or_default().push(value);
            }
        }
        let mut found: Vec<_> = at
            .into_iter()
            .map(|(when, mut values)| {
                values.sort_by(f64::total_cmp);
                (when, quantile(&values, 0.5), values.len())
            })
            .collect();
        found.sort_by(|a, b| by_time(a.0, b.0));
        found
    }
}

/// Since when an effect is missing in a specimen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Since {
    /// The specimen.
    pub specimen: String,
    /// The first row in which it is.
    pub row: usize,
    /// When that was.
    pub first: Option<String>,
    /// In how many rows it is.
    pub rows: usize,
}

/// A value that lies far from the others of its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarOut {
    /// Which kind.
    pub kind: usize,
    /// Which row.
    pub row: usize,
    /// The value.
    pub value: f64,
    /// How far it lies from the median, in spreads of its kind.
    pub spreads: f64,
}

impl Kind {
    /// The value below which a part of all lie.
    #[must_use]
    pub fn quantile(&self, part: f64) -> f64 {
        quantile(&self.sorted, part)
    }

    /// The middle, and how far values lie from it; none where that tells nothing.
    #[must_use]
    pub fn median_and_spread(&self) -> Option<(f64, f64)> {
        if self.sorted.len() < MIN_VALUES {
            return None;
        }
        let median = self.quantile(0.5);
        let mut off: Vec<f64> = self.sorted.iter().map(|value| (value - median).abs()).collect();
        off.sort_by(f64::total_cmp);
        let spread = AS_DEVIATION * quantile(&off, 0.5);
        (spread > 0.0).then_some((median, spread))
    }
}

/// By number where both are numbers, else as text.
fn by_time(a: &str, b: &str) -> std::cmp::Ordering {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => a.total_cmp(&b),
        _ => a.cmp(b),
    }
}

/// The value below which a part of all lie, between neighbours in proportion; not a number where there is none.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = part * last as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    low + (high - low) * at.fract()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::{Asked, Estimate, Said};
    use serde_json::Map;

    fn about() -> About {
        let inputs = crate::manifest::Inputs { list: String::new(), files: 0, bytes: 0 };
        About {
            palpate_survey: 1,
            version: String::new(),
            asked: Asked::Diagnose,
            by: vec!["finger".into(), "day".into()],
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

    /// Ten fingers on three days; finger 4 lacks an effect from day 10 on, finger 7 is stiff, finger 9 fails on day 2.
    fn overview() -> Overview {
        let mut overview = Overview::new(&about());
        for day in ["1", "2", "10"] {
            for finger in 0..10_u32 {
                let stiff = if finger == 7 { 9.0 } else { 1.0 + 0.01 * f64::from(finger) };
                let (name, unit) = ("p".to_owned(), "N/mm".to_owned());
                let estimate =
                    Estimate { of: String::new(), name, value: stiff, standard_error: None, unit };
                let lacks = finger == 4 && day != "1";
                let effects = if lacks { vec!["mullins".to_owned()] } else { Vec::new() };
                let said = Said { estimates: vec![estimate], effects, ..Said::default() };
                let failed = finger == 9 && day == "2";
                let row = Row {
                    group: overview.groups.len() as u64,
                    key: vec![Some(finger.to_string()), Some(day.into())],
                    status: if failed { Status::Refused } else { Status::Done },
                    reason: failed.then(|| "no contact".into()),
                    traces: 1,
                    samples: 10,
                    said,
                };
                overview.add(&row, Worked { seconds: 0.5, attempts: 1 });
            }
        }
        overview.finish();
        overview
    }

    #[test]
    fn what_is_missing_is_told_with_its_first_day() {
        let overview = overview();
        assert_eq!(overview.times(), ["1", "2", "10"]);
        let since = overview.since(&overview.effects["mullins"]);
        let known =
            Since { specimen: "finger 4".into(), row: 14, first: Some("2".into()), rows: 2 };
        assert_eq!(since, [known]);
        assert_eq!(overview.failures, [(19, Status::Refused, "no contact".into())]);
        assert_eq!((overview.samples, overview.seconds), (300, 15.0));
    }

    #[test]
    fn what_lies_far_out_is_told_and_the_rest_is_not() {
        let overview = overview();
        let far: Vec<&str> =
            overview.far_out().iter().map(|far| overview.groups[far.row].as_str()).collect();
        assert_eq!(far, ["finger 7, day 1", "finger 7, day 2", "finger 7, day 10"]);
        let kind = &overview.kinds[0];
        assert_eq!(overview.over_time(kind)[2].0, "10");
        assert!((kind.quantile(0.5) - 1.04).abs() < 0.011);
    }
}
