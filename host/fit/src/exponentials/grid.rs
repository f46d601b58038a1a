//! Starts for every number of terms, from a coarse grid over all sets of rates.
//!
//! For each set of grid rates the share of the trace it explains is Σ (q·p)², q being the
//! exponentials made orthonormal one after another. Each q is a fixed combination of the grid's
//! exponentials, so that with d = (exponential · p) of each grid rate a set costs a few
//! multiply-adds: q·p = s d_last + Σ m_j d_j.

use super::table::Table;
use super::vector::{add_scaled, dot, scale};

/// Spacing in ln v that the grids of 1 to 4 terms aim at, and the most rates they may have.
const SPACING: [(f64, usize); 4] = [(0.2, 96), (0.3, 64), (0.4, 32), (0.5, 24)];

/// Part of an exponential, left of it beside others, that is made orthogonal to them again: twice is enough.
const LITTLE: f64 = 1e-3;

/// All sets of `m` grid rates, in lexicographic order, for one m.
#[derive(Clone, Debug, Default)]
struct Level {
    /// Factor of the last rate's product.
    last: Vec<f64>,
    /// Factors of the products of the rates before it.
    before: Vec<Vec<f64>>,
    /// Sets that share all but the last rate.
    runs: Vec<Run>,
}

/// Consecutive sets that share all but their last rate.
#[derive(Clone, Copy, Debug)]
struct Run {
    before: [u8; 4],
    /// Last rate of the first set; the others follow one by one to the end of the grid.
    first: usize,
    /// Place of the first set in the level.
    start: usize,
    /// Place of the set without its last rate in the level before.
    base: usize,
}

/// A grid for sets of up to `levels.len()` rates.
#[derive(Clone, Debug)]
pub(super) struct Grid<const R: usize> {
    /// Logarithms of the rates, ascending.
    u: Vec<f64>,
    /// Exponentials of unit length at these rates.
    atoms: Vec<[f64; R]>,
    levels: Vec<Level>,
}

/// What each set of the grid explains of one trace.
pub(super) struct Scores<'a, const R: usize> {
    grid: &'a Grid<R>,
    terms: usize,
    values: Vec<f64>,
}

impl<const R: usize> Grid<R> {
    /// Prepares sets of up to `terms` rates, beside a constant or without one.
    pub fn new(table: &Table<R>, terms: usize, constant: bool) -> Self {
        let (spacing, most) = SPACING[terms - 1];
        let wanted = ((table.highest - table.lowest) / spacing).ceil() as usize + 1;
        let u = table.coarse(wanted.clamp(terms + 2, most));
        let atoms = u
            .iter()
            .map(|u| {
                let mut atom = table.at(*u).value;
                if constant {
                    atom[0] = 0.0;
                }
                let norm = dot(&atom, &atom).sqrt();
                scale(&mut atom, 1.0 / norm);
                atom
            })
            .collect();
        let mut grid = Self { u, atoms, levels: vec![Level::default(); terms] };
        grid.extend(&mut Vec::new());
        grid
    }

    /// Adds all sets that begin with `prefix`: index, orthonormal vector and its combination.
    fn extend(&mut self, prefix: &mut Vec<(usize, [f64; R], [f64; 4])>) {
        let size = prefix.len();
        let first = prefix.last().map_or(0, |last| last.0 + 1);
        if size == self.levels.len() || first == self.u.len() {
            return;
        }
        let mut before = [0; 4];
        for (slot, (index, ..)) in before.iter_mut().zip(prefix.iter()) {
            *slot = *index as u8;
        }
        // The set without its last rate is the one just added.
        let base = if size == 0 { 0 } else { self.levels[size - 1].last.len() - 1 };
        let level = &mut self.levels[size];
        level.before.resize(size, Vec::new());
        level.runs.push(Run { before, first, start: level.last.len(), base });
        for index in first..self.u.len() {
            let mut q = self.atoms[index];
            let mut combination = [0.0; 4];
            combination[size] = 1.0;
            let mut norm = 1.0;
            for _ in 0..2 {
                for (_, vector, mix) in prefix.iter() {
                    let along = dot(vector, &q);
                    add_scaled(&mut q, -along, vector);
                    for (c, m) in combination.iter_mut().zip(mix) {
                        *c -= along * m;
                    }
                }
                norm = dot(&q, &q).sqrt();
                // What is left after one pass has its digits unless it is little.
                if norm > LITTLE {
                    break;
                }
            }
            // Too close to the others to tell from rounding: such a set explains no more.
            let inverse = if norm > 1e-8 { 1.0 / norm } else { 0.0 };
            scale(&mut q, inverse);
            combination.iter_mut().for_each(|c| *c *= inverse);
            let level = &mut self.levels[size];
            level.last.push(combination[size]);
            for (factors, factor) in level.before.iter_mut().zip(combination) {
                factors.push(factor);
            }
            prefix.push((index, q, combination));
            self.extend(prefix);
            prefix.pop();
        }
    }

    /// What every set of `terms` rates explains of a target.
    #[inline]
    pub fn scores(&self, target: &[f64; R], terms: usize) -> Scores<'_, R> {
        let products: Vec<f64> = self.atoms.iter().map(|atom| dot(atom, target)).collect();
        let mut values: Vec<f64> = products.iter().map(|product| product * product).collect();
        for level in &self.levels[1..terms] {
            values = level.scores(&products, &values);
        }
        Scores { grid: self, terms, values }
    }
}

impl Level {
    /// Scores of this level from those of the level before.
    #[inline]
    fn scores(&self, products: &[f64], shorter: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.last.len()];
        for run in &self.runs {
            let ends = &products[run.first..];
            let range = run.start..run.start + ends.len();
            let last = &self.last[range.clone()];
            let before =
                |j: usize| (&self.before[j][range.clone()], products[run.before[j] as usize]);
            let base = shorter[run.base];
            let out = values[range.clone()].iter_mut().zip(ends).zip(last).enumerate();
            // One loop for each number of terms keeps the sums in registers.
            match self.before.len() {
                1 => {
                    let (a, da) = before(0);
                    for (k, ((out, end), last)) in out {
                        let along = last * end + a[k] * da;
                        *out = base + along * along;
                    }
                }
                2 => {
                    let ((a, da), (b, db)) = (before(0), before(1));
                    for (k, ((out, end), last)) in out {
                        let along = last * end + (a[k] * da + b[k] * db);
                        *out = base + along * along;
                    }
                }
                _ => {
                    let ((a, da), (b, db), (c, dc)) = (before(0), before(1), before(2));
                    for (k, ((out, end), last)) in out {
                        let along = (last * end + a[k] * da) + (b[k] * db + c[k] * dc);
                        *out = base + along * along;
                    }
                }
            }
        }
        values
    }
}

impl<const R: usize> Scores<'_, R> {
    /// Place of the set that explains most.
    #[inline]
    pub fn best(&self) -> usize {
        // The largest value first, in lanes; then where it is.
        let (chunks, tail) = self.values.as_chunks::<8>();
        let mut largest = [0.0; 8];
        for chunk in chunks {
            for lane in 0..8 {
                largest[lane] =
                    if chunk[lane] > largest[lane] { chunk[lane] } else { largest[lane] };
            }
        }
        let most = largest.iter().chain(tail).fold(0.0, |a: f64, b| a.max(*b));
        let within = |chunk: &[f64]| chunk.iter().fold(false, |any, value| any | (*value == most));
        let chunk = self.values.chunks(8).position(within).unwrap_or(0);
        let rest = &self.values[8 * chunk..];
        8 * chunk + rest.iter().position(|value| *value == most).unwrap_or(0)
    }

    /// What a set explains.
    pub fn value(&self, place: usize) -> f64 {
        self.values[place]
    }

    /// Places of the sets that explain more than `threshold` and more than all their
    /// neighbours, best first.
    pub fn peaks(&self, threshold: f64) -> Vec<usize> {
        let mut peaks = Vec::new();
        for run in &self.grid.levels[self.terms - 1].runs {
            let values = &self.values[run.start..run.start + self.grid.u.len() - run.first];
            // Most runs are below; without short cuts this is done in lanes.
            if !values.iter().fold(false, |any, value| any | (*value > threshold)) {
                continue;
            }
            let last = values.len() - 1;
            let mut check = |k: usize, candidate: bool| {
                if candidate && values[k] > threshold && self.is_peak(run.start + k) {
                    peaks.push(run.start + k);
                }
            };
            check(0, last == 0 || values[0] >= values[1]);
            for (k, window) in values.windows(3).enumerate() {
                // Without short cuts, so that most sets fail without a mispredicted branch.
                let [before, value, after] = [window[0], window[1], window[2]];
                if (value > threshold) & (value >= before) & (value >= after) {
                    check(k + 1, true);
                }
            }
            if last > 0 {
                check(last, values[last] >= values[last - 1]);
            }
        }
        peaks.sort_by(|a, b| self.values[*b].total_cmp(&self.values[*a]));
        peaks
    }

    /// Logarithms of the rates of a set.
    pub fn rates(&self, place: usize) -> impl Iterator<Item = f64> {
        self.indices(place).into_iter().take(self.terms).map(|index| self.grid.u[index])
    }

    fn indices(&self, place: usize) -> [usize; 4] {
        let level = &self.grid.levels[self.terms - 1];
        let run = &level.runs[level.runs.partition_point(|run| run.start <= place) - 1];
        let mut indices = run.before.map(usize::from);
        indices[self.terms - 1] = run.first + place - run.start;
        indices
    }

    /// Place of a set; none where its rates are not ascending or not in the grid.
    fn place(&self, indices: &[usize]) -> Option<usize> {
        let mut place = indices[0];
        for (size, pair) in indices.windows(2).enumerate() {
            let runs = &self.grid.levels[size + 1].runs;
            let run = runs.get(runs.partition_point(|run| run.base < place))?;
            if pair[1] <= pair[0] || pair[1] >= self.grid.u.len() {
                return None;
            }
            place = run.start + pair[1] - run.first;
        }
        (place < self.values.len()).then_some(place)
    }

    /// Whether no set that differs by one grid step in any of its rates explains more.
    fn is_peak(&self, place: usize) -> bool {
        let indices = self.indices(place);
        let steps = 3_usize.pow(self.terms as u32);
        (0..steps).all(|code| {
            let mut moved = [0; 4];
            let mut rest = code;
            for (to, from) in moved.iter_mut().zip(indices).take(self.terms) {
                // One step down from 0 wraps around to a rate that is not in the grid.
                *to = (from + rest % 3).wrapping_sub(1);
                rest /= 3;
            }
            if moved[..self.terms].iter().any(|index| *index >= self.grid.u.len()) {
                return true;
            }
            self.place(&moved[..self.terms])
                .is_none_or(|neighbour| self.values[neighbour] <= self.values[place])
        })
    }
}
