//! The rows of a session in bounded memory: the last ones as they came, older ones by least and greatest.
//!
//! A level has one bin for so many (`EACH`) rows or bins of the level before, and keeps `BINS` of them, so that 1 kHz is
//! kept for 33 s row by row, for 2 minutes in bins of 32 ms, for 17 minutes in a quarter of a second, for 2 hours in 2 s and
//! for 18 hours in 16 s; 6 MB in all.

use std::collections::VecDeque;

/// Signals of a row: calibrated strain, FA, SA, elastic input and equilibrium, each of four gauges.
pub const SIGNALS: usize = 20;
/// Rows kept as they came.
pub const ROWS: usize = 32_768;
/// What a bin of each level is made of: rows, then bins of the level before.
const EACH: [u32; 4] = [32, 8, 8, 8];
const BINS: usize = 4_096;

/// The signals of a row, µε.
pub type Values = [f32; SIGNALS];

/// Least and greatest of every signal from a time on, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Time of its first row, s.
    pub from_s: f64,
    /// Least, µε.
    pub least: Values,
    /// Greatest, µε.
    pub greatest: Values,
}

impl Bin {
    fn of(time_s: f64, values: &Values) -> Self {
        Self { from_s: time_s, least: *values, greatest: *values }
    }

    fn add(&mut self, other: &Self) {
        for (least, other) in self.least.iter_mut().zip(&other.least) {
            *least = least.min(*other);
        }
        for (greatest, other) in self.greatest.iter_mut().zip(&other.greatest) {
            *greatest = greatest.max(*other);
        }
    }
}

/// Bins of one width, and the one that is being filled.
#[derive(Clone, Debug, Default)]
struct Level {
    bins: VecDeque<Bin>,
    open: Option<Bin>,
    filled: u32,
}

impl Level {
    /// Adds; the bin that this completes, where it is made of `each`.
    fn add(&mut self, bin: &Bin, each: u32) -> Option<Bin> {
        match &mut self.open {
            Some(open) => open.add(bin),
            empty => *empty = Some(*bin),
        }
        self.filled += 1;
        if self.filled < each {
            return None;
        }
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
    rows: VecDeque<(f64, Values)>,
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
        self.rows.back().map(|(time_s, _)| *time_s)
    }

    /// Time of the first row that can still be looked at, s.
    #[must_use]
    pub fn since_s(&self) -> Option<f64> {
        let oldest = self.levels.iter().rev().find_map(|level| level.bins.front());
        oldest.map(|bin| bin.from_s).or_else(|| self.rows.front().map(|(time_s, _)| *time_s))
    }

    /// Takes a row; times do not go back.
    pub fn push(&mut self, time_s: f64, values: &Values) {
        push(&mut self.rows, (time_s, *values), ROWS);
        self.count += 1;
        let mut full = Some(Bin::of(time_s, values));
        for (level, each) in self.levels.iter_mut().zip(EACH) {
            let Some(bin) = full else { break };
            full = level.add(&bin, each);
        }
    }

    /// The rows from number `from` on that are still there, and how many are not.
    pub fn after(&self, from: u64) -> (u64, impl ExactSizeIterator<Item = &(f64, Values)>) {
        let first = self.count - self.rows.len() as u64;
        let missing = first.saturating_sub(from);
        let skip = (from.max(first) - first).min(self.rows.len() as u64) as usize;
        (missing, self.rows.range(skip..))
    }

    /// The session from one time to another, s, in at most `most` bins, as fine as it is still known.
    #[must_use]
    pub fn view(&self, from_s: f64, to_s: f64, most: usize) -> Vec<Bin> {
        let most = most.max(1);
        let begin = self.rows.partition_point(|(time_s, _)| *time_s < from_s);
        let end = self.rows.partition_point(|(time_s, _)| *time_s <= to_s).max(begin);
        let whole = self.count as usize == self.rows.len() || begin > 0;
        if whole && end - begin <= EACH[0] as usize * most {
            let bins = self.rows.range(begin..end).map(|(time_s, values)| Bin::of(*time_s, values));
            return merged(bins, end - begin, most);
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
        let count = bins.len();
        merged(bins.into_iter(), count, most)
    }
}

/// At most `most` of `count` bins, each of as many neighbours.
fn merged(bins: impl Iterator<Item = Bin>, count: usize, most: usize) -> Vec<Bin> {
    let each = count.div_ceil(most).max(1);
    let mut merged: Vec<Bin> = Vec::with_capacity(count.min(most));
    for (index, bin) in bins.enumerate() {
        match merged.last_mut() {
            Some(last) if index % each != 0 => last.add(&bin),
            _ => merged.push(bin),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(rows: u32) -> Pyramid {
        let mut pyramid = Pyramid::default();
        for row in 0..rows {
            pyramid.push(f64::from(row) * 1e-3, &[row as f32; SIGNALS]);
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
            pyramid.push(spike_s, &[top; SIGNALS]);
            for (from_s, to_s) in [(0.0, spike_s), (spike_s / 2.0, spike_s)] {
                let view = pyramid.view(from_s, to_s, 300);
                assert!(!view.is_empty() && view.len() <= 301, "{rows}: {}", view.len());
                assert!(view.windows(2).all(|pair| pair[0].from_s < pair[1].from_s));
                let greatest = view.iter().map(|bin| bin.greatest[7]).fold(0.0, f32::max);
                assert_eq!(greatest, top, "{rows} rows from {from_s} s");
            }
        }
    }

    #[test]
    fn a_short_view_of_the_last_seconds_has_every_row() {
        let view = filled(40_000).view(39.0, 39.1, 300);
        assert_eq!(view.len(), 101);
        assert!(view.iter().all(|bin| bin.least == bin.greatest));
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
