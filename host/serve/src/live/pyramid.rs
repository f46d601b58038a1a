//! The rows of a session in bounded memory: the last ones as they came, older ones by first, least, greatest and last.
//!
//! A level has one bin for so many (`EACH`) rows or bins of the level before, and keeps `BINS` of them, so that 1 kHz is
//! kept for 33 s row by row, for 2 minutes in bins of 32 ms, for 17 minutes in a quarter of a second, for 2 hours in 2 s and
//! for 18 hours in 16 s; 9 MB in all. No bin reaches over a gap that is as long as the bin.

use std::collections::VecDeque;

/// Signals of a row: calibrated strain, FA, SA, elastic input and equilibrium, each of four gauges.
pub const SIGNALS: usize = 20;
/// Rows kept as they came.
pub const ROWS: usize = 32_768;
/// What a bin of each level is made of: rows, then bins of the level before.
const EACH: [u32; 4] = [32, 8, 8, 8];
const BINS: usize = 4_096;
/// A row that comes after so many intervals is late: others before it are missing.
const LATE: f64 = 1.5;

/// The signals of a row, µε.
pub type Values = [f32; SIGNALS];

/// A signal over a stretch of time, µε: its first and last value, and its extremes in the order in which they came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// First value.
    pub first: f32,
    /// The extreme that came first.
    pub early: f32,
    /// The other extreme.
    pub late: f32,
    /// Last value.
    pub last: f32,
}

impl Course {
    const fn of(value: f32) -> Self {
        Self { first: value, early: value, late: value, last: value }
    }

    /// Least value, µε.
    #[must_use]
    pub const fn least(&self) -> f32 {
        self.early.min(self.late)
    }

    /// Greatest value, µε.
    #[must_use]
    pub const fn greatest(&self) -> f32 {
        self.early.max(self.late)
    }

    /// Goes on with what comes after it.
    const fn add(&mut self, later: &Self) {
        let (least, greatest) = (self.least(), self.greatest());
        (self.early, self.late) = match (later.least() < least, later.greatest() > greatest) {
            (true, true) => (later.early, later.late),
            (true, false) => (greatest, later.least()),
            (false, true) => (least, later.greatest()),
            (false, false) => (self.early, self.late),
        };
        self.last = later.last;
    }
}

/// All signals over a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Time of its first row, s.
    pub from_s: f64,
    /// Time of its last row, s.
    pub to_s: f64,
    /// Nothing is known of so long before it, s; 0 where it goes on from the row before.
    pub gap_s: f64,
    /// Each signal.
    pub signals: [Course; SIGNALS],
}

impl Bin {
    fn of(row: &Row) -> Self {
        let Row { time_s, gap_s, values } = *row;
        Self { from_s: time_s, to_s: time_s, gap_s, signals: values.map(Course::of) }
    }

    fn add(&mut self, later: &Self) {
        self.to_s = later.to_s;
        for (signal, later) in self.signals.iter_mut().zip(&later.signals) {
            signal.add(later);
        }
    }
}

/// A row as it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Session time, s.
    pub time_s: f64,
    /// Nothing is known of so long before it, s; 0 where it goes on from the row before.
    pub gap_s: f64,
    /// Its signals, µε.
    pub values: Values,
}

/// Bins of one width, and the one that is being filled.
#[derive(Clone, Debug, Default)]
struct Level {
    bins: VecDeque<Bin>,
    open: Option<Bin>,
    filled: u32,
}

impl Level {
    /// Adds; the bin that this completes. It is made of `each`, or of fewer where something as long as the whole bin, `width_s`,
    /// is missing behind it: then it ends there.
    fn add(&mut self, bin: &Bin, each: u32, width_s: f64) -> Option<Bin> {
        let ended = if bin.gap_s >= width_s { self.close() } else { None };
        match &mut self.open {
            Some(open) => open.add(bin),
            empty => *empty = Some(*bin),
        }
        self.filled += 1;
        if self.filled < each { ended } else { self.close() }
    }

    fn close(&mut self) -> Option<Bin> {
        self.filled = 0;
        let full = self.open.take()?;
        push(&mut self.bins, full, BINS);
        Some(full)
    }

    fn range(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = &Bin> {
        let begin = self.bins.partition_point(|bin| bin.from_s < from_s).saturating_sub(1);
        let end = self.bins.partition_point(|bin| bin.from_s <= to_s);
        self.bins.range(begin.min(end)..end)
    }
}

fn push<T>(queue: &mut VecDeque<T>, item: T, most: usize) {
    if queue.len() >= most {
        queue.pop_front();
    }
    queue.push_back(item);
}

/// All rows of a session.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    rows: VecDeque<Row>,
    count: u64,
    levels: [Level; EACH.len()],
}

impl Pyramid {
    /// Rows that ever came.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Time of the last row, s.
    #[must_use]
    pub fn last_s(&self) -> Option<f64> {
        self.rows.back().map(|row| row.time_s)
    }

    /// Time of the first row that can still be looked at, s.
    #[must_use]
    pub fn since_s(&self) -> Option<f64> {
        let oldest = self.levels.iter().rev().find_map(|level| level.bins.front());
        oldest.map(|bin| bin.from_s).or_else(|| self.rows.front().map(|row| row.time_s))
    }

    /// Takes a row of a stream whose rows are `interval_s` apart; times do not go back. What is missing before it is a gap.
    pub fn push(&mut self, time_s: f64, interval_s: f64, values: &Values) {
        let passed_s = self.last_s().map_or(0.0, |last_s| time_s - last_s);
        let gap_s = if passed_s > LATE * interval_s { passed_s } else { 0.0 };
        let row = Row { time_s, gap_s, values: *values };
        push(&mut self.rows, row, ROWS);
        self.count += 1;
        let mut full = Some(Bin::of(&row));
        let mut width_s = interval_s;
        for (level, each) in self.levels.iter_mut().zip(EACH) {
            let Some(bin) = full else { break };
            width_s *= f64::from(each);
            full = level.add(&bin, each, width_s);
        }
    }

    /// The rows from number `from` on that are still there, and how many are not.
    pub fn after(&self, from: u64) -> (u64, impl ExactSizeIterator<Item = &Row>) {
        let first = self.count - self.rows.len() as u64;
        let missing = first.saturating_sub(from);
        let skip = (from.max(first) - first).min(self.rows.len() as u64) as usize;
        (missing, self.rows.range(skip..))
    }

    /// The session from one time to another, s, in `most` bins, as fine as it is still known. A bin ends where as much is missing as
    /// it is wide, so that there are more bins by the number of such gaps.
    #[must_use]
    pub fn view(&self, from_s: f64, to_s: f64, most: usize) -> Vec<Bin> {
        let most = most.max(1);
        let begin = self.rows.partition_point(|row| row.time_s < from_s);
        let end = self.rows.partition_point(|row| row.time_s <= to_s).max(begin);
        let whole = self.count as usize == self.rows.len() || begin > 0;
        if whole && end - begin <= EACH[0] as usize * most {
            let rows = || self.rows.range(begin..end);
            let span_s = rows().next_back().zip(rows().next()).map(|(b, a)| b.time_s - a.time_s);
            return merged(rows().map(Bin::of), end - begin, span_s.unwrap_or(0.0), most);
        }
        let reaches = |level: &Level| level.bins.front().is_some_and(|bin| bin.from_s <= from_s);
        let complete = |level: &Level| level.bins.len() < BINS;
        let last = EACH.len() - 1;
        let finest = (0..last).find(|&index| {
            let level = &self.levels[index];
            (reaches(level) || complete(level))
                && level.range(from_s, to_s).count() <= EACH[index + 1] as usize * most
        });
        let level = finest.unwrap_or(last);
        // What the level has not yet is in the open bins, the finest of which is the latest.
        let open = self.levels[..=level].iter().rev().filter_map(|level| level.open.as_ref());
        let open = open.filter(|bin| bin.from_s >= from_s && bin.from_s <= to_s);
        let bins: Vec<Bin> = self.levels[level].range(from_s, to_s).chain(open).copied().collect();
        let (count, ends) = (bins.len(), bins.last().zip(bins.first()));
        let span_s = ends.map_or(0.0, |(b, a)| b.to_s - a.from_s);
        merged(bins.into_iter(), count, span_s, most)
    }
}

/// At most `most` of `count` bins over a time, s, each of as many neighbours; more where gaps end them.
fn merged(bins: impl Iterator<Item = Bin>, count: usize, span_s: f64, most: usize) -> Vec<Bin> {
    let each = count.div_ceil(most).max(1);
    let width_s = span_s / most as f64;
    let mut merged: Vec<Bin> = Vec::with_capacity(count.min(most));
    let mut filled = each;
    for bin in bins {
        match merged.last_mut() {
            Some(last) if filled < each && bin.gap_s <= width_s => last.add(&bin),
            _ => {
                filled = 0;
                merged.push(bin);
            }
        }
        filled += 1;
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(rows: u32) -> Pyramid {
        let mut pyramid = Pyramid::default();
        for row in 0..rows {
            pyramid.push(f64::from(row) * 1e-3, 1e-3, &[row as f32; SIGNALS]);
        }
        pyramid
    }

    #[test]
    fn the_last_rows_are_there_as_they_came_and_what_is_gone_is_counted() {
        let pyramid = filled(40_000);
        let (missing, rows) = pyramid.after(39_990);
        assert_eq!((missing, rows.len()), (0, 10));
        let (missing, rows) = pyramid.after(0);
        assert_eq!((missing, rows.len()), (40_000 - ROWS as u64, ROWS));
        let (missing, rows) = pyramid.after(50_000);
        assert_eq!((missing, rows.len()), (0, 0));
    }

    #[test]
    fn a_view_has_no_more_bins_than_asked_for_and_misses_no_extreme() {
        for rows in [0, 1, 7, 100, 5_000, 40_000, 300_000] {
            let mut pyramid = filled(rows);
            let (spike_s, top) = (f64::from(rows) * 1e-3, 1e6);
            pyramid.push(spike_s, 1e-3, &[top; SIGNALS]);
            for (from_s, to_s) in [(0.0, spike_s), (spike_s / 2.0, spike_s)] {
                let view = pyramid.view(from_s, to_s, 300);
                assert!(!view.is_empty() && view.len() <= 301, "{rows}: {}", view.len());
                assert!(view.windows(2).all(|pair| pair[0].from_s < pair[1].from_s));
                let tops = view.iter().map(|bin| bin.signals[7].greatest());
                let greatest = tops.fold(0.0, f32::max);
                assert_eq!(greatest, top, "{rows} rows from {from_s} s");
            }
        }
    }

    #[test]
    fn a_short_view_of_the_last_seconds_has_every_row() {
        let view = filled(40_000).view(39.0, 39.1, 300);
        assert_eq!(view.len(), 101);
        assert!(view.iter().all(|bin| bin.signals[0].least() == bin.signals[0].greatest()));
    }

    #[test]
    fn a_bin_gives_first_extremes_and_last_in_the_order_of_time() {
        let mut pyramid = Pyramid::default();
        for (row, value) in [5.0, 9.0, 7.0, 1.0, 2.0, 2.0, 8.0, 3.0].into_iter().enumerate() {
            pyramid.push(row as f64 * 1e-3, 1e-3, &[value; SIGNALS]);
        }
        let courses: Vec<[f32; 4]> = pyramid
            .view(0.0, 1.0, 2)
            .iter()
            .map(|bin| bin.signals[0])
            .map(|Course { first, early, late, last }| [first, early, late, last])
            .collect();
        assert_eq!(courses, [[5.0, 9.0, 1.0, 1.0], [2.0, 2.0, 8.0, 3.0]]);
        let whole = pyramid.view(0.0, 1.0, 1)[0].signals[0];
        assert_eq!([whole.first, whole.early, whole.late, whole.last], [5.0, 9.0, 1.0, 3.0]);
    }

    #[test]
    fn no_bin_reaches_over_a_gap_as_long_as_itself() {
        let stop_s = 20.0;
        for rows in [10, 1_000, 40_000, 300_000] {
            let mut pyramid = filled(rows);
            let end_s = f64::from(rows - 1) * 1e-3;
            for row in 0..rows {
                let time_s = end_s + stop_s + f64::from(row) * 1e-3;
                pyramid.push(time_s, 1e-3, &[0.0; SIGNALS]);
            }
            let all_s = 2.0 * end_s + stop_s;
            for most in [300, 1_200] {
                let view = pyramid.view(0.0, all_s, most);
                let width_s = all_s / most as f64;
                let gaps: Vec<&Bin> = view.iter().filter(|bin| bin.gap_s > width_s).collect();
                assert_eq!(gaps.len(), 1, "{rows} rows in {most}");
                assert!((gaps[0].from_s - end_s - stop_s).abs() < 1e-9 && gaps[0].gap_s == stop_s);
                let over = |bin: &&Bin| bin.from_s <= end_s && bin.to_s > end_s;
                assert_eq!(view.iter().filter(over).count(), 0, "{rows} rows in {most}");
            }
        }
    }

    #[test]
    fn many_short_gaps_do_not_use_up_the_room_of_a_session() {
        let mut pyramid = Pyramid::default();
        for row in 0..1_000_000_u32 {
            // Every tenth row is lost.
            let time_s = f64::from(row + row / 9) * 1e-3;
            pyramid.push(time_s, 1e-3, &[0.0; SIGNALS]);
        }
        assert_eq!(pyramid.since_s(), Some(0.0));
        assert_eq!(pyramid.levels[3].bins.len(), 1_000_000 / 16_384);
    }

    #[test]
    fn memory_has_a_bound_and_the_session_is_still_there_from_its_beginning() {
        let pyramid = filled(1_000_000);
        assert!(pyramid.rows.len() <= ROWS);
        assert!(pyramid.levels.iter().all(|level| level.bins.len() <= BINS));
        assert_eq!(pyramid.since_s(), Some(0.0));
        assert_eq!(pyramid.view(0.0, 10.0, 300)[0].from_s, 0.0);
    }
}
