//! Raw counts as they come: what they are now, whether they stand still, and averages on request.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use shared::pipeline::GAUGES;
use shared::wire::Row;
use tokio::sync::oneshot;

use palpate_link::device::measure::{drifts, means, rows_over};
use palpate_link::device::session::LinkError;

/// What is shown is of the last so many seconds.
const WINDOW_S: f64 = 1.0;
/// It is told so often.
const UPDATE_INTERVAL: Duration = Duration::from_millis(200);
/// Longest average, s.
const LONGEST_S: f64 = 60.0;
/// Averages that may be wanted at once.
const MAX_AVERAGES: usize = 4;
/// Nothing came for so long while an average is taken: the converter stands still.
const STANDSTILL: Duration = Duration::from_secs(2);

/// Where an average goes.
pub(super) type Answer = oneshot::Sender<Result<Value, String>>;

/// An average that is being taken.
struct Average {
    /// Time of the device, s: a computer that is busy gets its rows late, and averages as many.
    over_s: f64,
    rows: Vec<[i32; GAUGES]>,
    heard: Instant,
    answer: Answer,
}

/// The counts of a stream.
pub(super) struct Counts {
    recent: VecDeque<[i32; GAUGES]>,
    averages: Vec<Average>,
    told: Instant,
}

impl Counts {
    pub(super) fn new() -> Self {
        Self { recent: VecDeque::new(), averages: Vec::new(), told: Instant::now() }
    }

    /// Averages from now on, and answers then.
    pub(super) fn average(&mut self, seconds: f64, answer: Answer) {
        let wrong = |words: &str| Err(words.to_owned());
        let refusal = if !(seconds > 0.0 && seconds <= LONGEST_S) {
            wrong("give a time above 0, up to 60 s, to average over")
        } else if self.averages.len() >= MAX_AVERAGES {
            wrong("other averages are still being taken; wait for them")
        } else {
            let (over_s, heard) = (seconds, Instant::now());
            self.averages.push(Average { over_s, rows: Vec::new(), heard, answer });
            return;
        };
        // A page that has gone away needs no answer.
        let _ = answer.send(refusal);
    }

    /// Takes rows `interval_s` apart; what the counts are now, where that is due.
    pub(super) fn take(&mut self, rows: &[Row], interval_s: f64) -> Option<Value> {
        let window = rows_over(WINDOW_S, interval_s).max(3);
        self.recent.extend(rows.iter().map(|row| row.counts));
        let beyond = self.recent.len().saturating_sub(window);
        self.recent.drain(..beyond);
        let wanted = |average: &Average| rows_over(average.over_s, interval_s);
        for average in &mut self.averages {
            // Of a slower rate, set meanwhile, enough may have come before.
            let missing = wanted(average).saturating_sub(average.rows.len());
            average.rows.extend(rows.iter().map(|row| row.counts).take(missing));
            average.heard = Instant::now();
        }
        for average in self.averages.extract_if(.., |average| average.rows.len() >= wanted(average))
        {
            let told = json!({ "command": null, "result": summary(&average.rows) });
            let _ = average.answer.send(Ok(told));
        }
        if self.told.elapsed() < UPDATE_INTERVAL {
            return None;
        }
        self.told = Instant::now();
        Some(summary(self.recent.make_contiguous()))
    }

    /// Gives up averages that no rows come for.
    pub(super) fn tick(&mut self) {
        let late = |average: &mut Average| average.heard.elapsed() > STANDSTILL;
        for average in self.averages.extract_if(.., late) {
            let _ = average.answer.send(Err(LinkError::NoRows.to_string()));
        }
    }

    /// The stream ends, and with it all that is being averaged.
    pub(super) fn end(&mut self, why: &str) {
        self.recent.clear();
        for average in self.averages.drain(..) {
            let _ = average.answer.send(Err(why.into()));
        }
    }
}

/// Mean, scatter and drift of every gauge, counts.
fn summary(rows: &[[i32; GAUGES]]) -> Value {
    let drifts = drifts(rows);
    let gauges = means(rows).into_iter().enumerate().map(|(gauge, mean)| {
        let drift = drifts.map(|drifts| drifts[gauge]);
        json!({
            "counts": mean.counts,
            "deviation": mean.deviation,
            "samples": mean.samples,
            "drift_counts": drift.map(|drift| drift.counts),
            "settled": drift.is_some_and(|drift| drift.is_settled()),
        })
    });
    gauges.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::pipeline::Pipeline;
    use shared::wire::{Columns, Rows, Settings};

    fn rows(counts: [i32; GAUGES], count: u64) -> Vec<Row> {
        let config = Settings::DEFAULT.config(1e-3).unwrap();
        let mut pipeline = Pipeline::new(&config);
        let mut all = Vec::new();
        for number in 0..count {
            pipeline.process(&counts, 25 * 256);
            let mut rows = Rows::new();
            rows.begin(Columns::All, number, number * 1_000, number * 1_000);
            assert!(rows.push(number * 1_000, &counts, &pipeline));
            all.extend(rows.iter(&config.calibration));
        }
        all
    }

    #[test]
    fn an_average_is_that_of_the_counts_from_then_on_however_late_they_come() {
        let mut counts = Counts::new();
        counts.take(&rows([7; GAUGES], 10), 1e-3);
        let (answer, mut answered) = oneshot::channel();
        counts.average(0.02, answer);
        counts.take(&rows([1_000, -5, 0, 8], 10), 1e-3);
        std::thread::sleep(Duration::from_millis(25));
        counts.take(&[], 1e-3);
        assert!(answered.try_recv().is_err(), "of its 20 rows ten have come");
        counts.take(&rows([2_000, -5, 0, 8], 15), 1e-3);
        let told = answered.try_recv().unwrap().unwrap()["result"].take();
        assert_eq!((&told[0]["counts"], &told[0]["samples"]), (&json!(1_500.0), &json!(20)));
        assert_eq!((&told[0]["settled"], &told[1]["settled"]), (&json!(false), &json!(true)));
    }

    #[test]
    fn an_average_goes_on_over_a_change_of_the_rate() {
        let mut counts = Counts::new();
        let (answer, mut answered) = oneshot::channel();
        counts.average(0.02, answer);
        counts.take(&rows([1_000; GAUGES], 10), 1e-3);
        counts.take(&rows([1_000; GAUGES], 1), 1e-2);
        let told = answered.try_recv().unwrap().unwrap()["result"].take();
        assert_eq!(told[0]["samples"], 10);
    }

    #[test]
    fn an_average_that_cannot_be_is_answered_too() {
        let mut counts = Counts::new();
        let ask = |counts: &mut Counts, seconds| {
            let (answer, answered) = oneshot::channel();
            counts.average(seconds, answer);
            answered
        };
        for wrong in [0.0, -1.0, f64::NAN, 1e9] {
            assert!(ask(&mut counts, wrong).try_recv().unwrap().is_err(), "{wrong}");
        }
        let mut waiting: Vec<_> = (0..MAX_AVERAGES).map(|_| ask(&mut counts, 10.0)).collect();
        assert!(ask(&mut counts, 10.0).try_recv().unwrap().unwrap_err().contains("wait"));
        counts.end("the device is gone");
        for answered in &mut waiting {
            assert_eq!(answered.try_recv().unwrap(), Err("the device is gone".into()));
        }
    }
}
