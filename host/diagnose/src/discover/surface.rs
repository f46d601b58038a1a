//! What a residual depends on without any law: a free surface over two quantities, taken apart into what each does by itself and
//! what only both together do.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::criticism::covariate::Covariate;
use crate::criticism::residuals::{Residuals, Values};

/// A residual over two quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The quantities.
    pub of: [Covariate; 2],
    /// Middles of the classes of each.
    pub at: [Vec<f64>; 2],
    /// Mean residual in each class of the first, by class of the second; none where there is no sample.
    pub means: Vec<Vec<Option<f64>>>,
    /// Share of the residual's mean square that the surface explains.
    pub explained: f64,
    /// Share that the sum of one curve over each explains.
    pub additive: f64,
    /// Share that it explains on traces left out, of a surface of the others; below 0 where it would do harm.
    pub held_out: f64,
    /// Chance of explaining as much if residual and quantities had nothing to do with each other.
    pub p_value: f64,
}

impl Surface {
    /// What only both together explain.
    #[must_use]
    pub fn interaction(&self) -> f64 {
        (self.explained - self.additive).max(0.0)
    }
}

/// Classes of a quantity.
const CLASSES: usize = 10;
/// Pairs that are told.
const MOST: usize = 6;
/// Shifts that a p value is counted from.
const SHIFTS: usize = 99;
/// Seed of the shifts.
pub const SEED: u64 = 17;
/// Sweeps in which the curves of an additive surface settle.
const SWEEPS: usize = 50;
/// Samples that pull the mean of a class towards none on traces left out.
const PULL: f64 = 5.0;

/// The surfaces that explain most on traces left out, the best first.
#[must_use]
pub fn surfaces(left: &Residuals) -> Vec<Surface> {
    let classed = |it| Classed::of(it, &left.covariate(it)?);
    let classed: Vec<Classed> = Covariate::ALL.into_iter().filter_map(classed).collect();
    surfaces_of(&left.values(), &left.traces().collect::<Vec<_>>(), &classed)
}

/// The same of residuals stretch by stretch, with the trace of each and the quantities.
fn surfaces_of(residuals: &[Vec<f64>], traces: &[usize], classed: &[Classed]) -> Vec<Surface> {
    let pairs: Vec<(&Classed, &Classed)> = classed
        .iter()
        .enumerate()
        .flat_map(|(k, a)| classed[k + 1..].iter().map(move |b| (a, b)))
        .collect();
    let mut found: Vec<(f64, (&Classed, &Classed))> = pairs
        .into_par_iter()
        .map(|pair| (Cells::by_trace(pair, residuals, traces).held_out(), pair))
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(MOST);
    found.into_par_iter().map(|(held_out, pair)| surface(pair, held_out, residuals)).collect()
}

/// A quantity in classes of equal width, or around its values where they are few.
struct Classed {
    covariate: Covariate,
    at: Vec<f64>,
    /// Class of each sample, stretch by stretch.
    places: Vec<Vec<usize>>,
}

impl Classed {
    fn of(covariate: Covariate, values: &Values) -> Option<Self> {
        let all = || values.iter().flat_map(|values| values.iter().copied());
        let (least, most) =
            (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        let width = (most - least) / CLASSES as f64;
        if !width.is_finite() || width <= 0.0 {
            return None;
        }
        let place = |value: &f64| (((value - least) / width) as usize).min(CLASSES - 1);
        Some(Self {
            covariate,
            at: (0..CLASSES).map(|k| least + (k as f64 + 0.5) * width).collect(),
            places: values.iter().map(|values| values.iter().map(place).collect()).collect(),
        })
    }
}

/// Sums of residuals in each cell of two quantities.
#[derive(Clone)]
struct Cells {
    /// Sum and number of samples, the first quantity outside.
    sums: Vec<[f64; 2]>,
    square: f64,
}

impl Cells {
    const NONE: [f64; 2] = [0.0; 2];

    fn empty() -> Self {
        Self { sums: vec![Self::NONE; CLASSES * CLASSES], square: 0.0 }
    }

    fn add(&mut self, a: &[usize], b: &[usize], residual: impl Iterator<Item = f64>) {
        for ((a, b), r) in a.iter().zip(b).zip(residual) {
            let cell = &mut self.sums[a * CLASSES + b];
            *cell = [cell[0] + r, cell[1] + 1.0];
            self.square += r * r;
        }
    }

    fn by_trace((a, b): (&Classed, &Classed), residuals: &[Vec<f64>], traces: &[usize]) -> ByTrace {
        let count = traces.iter().max().map_or(0, |last| last + 1);
        let mut cells = vec![Self::empty(); count];
        for (k, residual) in residuals.iter().enumerate() {
            cells[traces[k]].add(&a.places[k], &b.places[k], residual.iter().copied());
        }
        ByTrace(cells)
    }

    /// Share of the mean square that the means of the cells explain.
    fn explained(&self) -> f64 {
        let of_means =
            self.sums.iter().filter(|cell| cell[1] > 0.0).map(|cell| cell[0] * cell[0] / cell[1]);
        if self.square > 0.0 { of_means.sum::<f64>() / self.square } else { 0.0 }
    }

    /// Share that the sum of a curve over each quantity explains: least squares by turns.
    fn additive(&self) -> f64 {
        let (mut a, mut b) = ([0.0; CLASSES], [0.0; CLASSES]);
        for _ in 0..SWEEPS {
            for (i, value) in a.iter_mut().enumerate() {
                *value = mean((0..CLASSES).map(|j| (self.sums[i * CLASSES + j], b[j])));
            }
            for (j, value) in b.iter_mut().enumerate() {
                *value = mean((0..CLASSES).map(|i| (self.sums[i * CLASSES + j], a[i])));
            }
        }
        let mut taken = 0.0;
        for (k, cell) in self.sums.iter().enumerate() {
            let level = a[k / CLASSES] + b[k % CLASSES];
            taken += 2.0 * level * cell[0] - level * level * cell[1];
        }
        if self.square > 0.0 { taken / self.square } else { 0.0 }
    }
}

/// Mean over cells of what is left beside the other curve.
fn mean(cells: impl Iterator<Item = ([f64; 2], f64)>) -> f64 {
    let (sum, count) = cells.fold((0.0, 0.0), |(sum, count), (cell, other)| {
        (sum + cell[0] - other * cell[1], count + cell[1])
    });
    if count > 0.0 { sum / count } else { 0.0 }
}

struct ByTrace(Vec<Cells>);

impl ByTrace {
    /// Share of the mean square on traces left out that the means of the others' cells explain; 0 for a single trace.
    fn held_out(&self) -> f64 {
        let cells = CLASSES * CLASSES;
        let mut all = vec![Cells::NONE; cells];
        for own in &self.0 {
            for (sum, cell) in all.iter_mut().zip(&own.sums) {
                *sum = [sum[0] + cell[0], sum[1] + cell[1]];
            }
        }
        let (mut taken, mut square) = (0.0, 0.0);
        for own in &self.0 {
            square += own.square;
            for (sum, cell) in all.iter().zip(&own.sums) {
                let level = (sum[0] - cell[0]) / (sum[1] - cell[1] + PULL);
                taken += 2.0 * level * cell[0] - level * level * cell[1];
            }
        }
        if square > 0.0 { taken / square } else { 0.0 }
    }
}

fn surface(pair: (&Classed, &Classed), held_out: f64, residuals: &[Vec<f64>]) -> Surface {
    let (a, b) = pair;
    let shifted = |shifts: &[usize]| {
        let mut cells = Cells::empty();
        for (k, residual) in residuals.iter().enumerate() {
            let (head, tail) = residual.split_at(shifts[k].min(residual.len()));
            cells.add(&a.places[k], &b.places[k], tail.iter().chain(head).copied());
        }
        cells
    };
    let cells = shifted(&vec![0; residuals.len()]);
    let explained = cells.explained();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let as_much = (0..SHIFTS)
        .filter(|_| {
            let shift = |r: &Vec<f64>| random.random_range(0..r.len().max(1));
            let shifts: Vec<usize> = residuals.iter().map(shift).collect();
            shifted(&shifts).explained() >= explained
        })
        .count();
    let mean = |cell: &[f64; 2]| (cell[1] > 0.0).then(|| cell[0] / cell[1]);
    Surface {
        of: [a.covariate, b.covariate],
        at: [a.at.clone(), b.at.clone()],
        means: cells.sums.chunks(CLASSES).map(|row| row.iter().map(mean).collect()).collect(),
        explained,
        additive: cells.additive().min(explained),
        held_out,
        p_value: (as_much + 1) as f64 / (SHIFTS + 1) as f64,
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;

    /// The surfaces of four traces with a residual of this law of displacement and velocity, and noise.
    fn found(law: fn(f64, f64) -> f64) -> Vec<Surface> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let time: Vec<f64> = (0..800).map(|k| f64::from(k) * 0.01).collect();
        let (mut x, mut v, mut residuals) = (Vec::new(), Vec::new(), Vec::new());
        for trace in 0..4 {
            let turn = |t: &f64| t * (1.0 + 0.3 * f64::from(trace));
            let own: (Vec<f64>, Vec<f64>) = time.iter().map(|t| turn(t).sin_cos()).unzip();
            let noisy = |(x, v): (&f64, &f64)| law(*x, *v) + random.random_range(-0.3..0.3);
            residuals.push(own.0.iter().zip(&own.1).map(noisy).collect());
            x.push(own.0.into());
            v.push(own.1.into());
        }
        let time = vec![Cow::from(time); 4];
        let quantities =
            [(Covariate::Displacement, x), (Covariate::Velocity, v), (Covariate::Time, time)];
        let classed = quantities.iter().filter_map(|(it, values)| Classed::of(*it, values));
        surfaces_of(&residuals, &[0, 1, 2, 3], &classed.collect::<Vec<_>>())
    }

    #[test]
    fn a_product_is_an_interaction_and_a_sum_is_none() {
        let pair = [Covariate::Displacement, Covariate::Velocity];
        let product = found(|x, v| 2.0 * x * v);
        assert_eq!(product[0].of, pair);
        assert!(product[0].interaction() > 0.8 && product[0].held_out > 0.8, "{product:?}");
        assert!(product[0].p_value <= 0.01);
        let sum = found(|x, v| 2.0 * x + v);
        let of_pair = sum.iter().find(|surface| surface.of == pair).unwrap();
        assert!(of_pair.explained > 0.9 && of_pair.interaction() < 0.05, "{of_pair:?}");
    }

    #[test]
    fn noise_predicts_nothing_on_traces_left_out() {
        let found = found(|_, _| 0.0);
        assert!(found.iter().all(|surface| surface.held_out < 0.02), "{found:?}");
        assert!(found[0].p_value > 0.02, "{:?}", found[0]);
    }
}
