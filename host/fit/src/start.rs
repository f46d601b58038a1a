//! A start for the fit of a whole motion, so that nobody is asked for one.
//!
//! For a given shape of the elastic response (the exponent q) and given rates the law is linear in the
//! force that each branch carries. So shape and rates go over a grid, the branch forces come from linear
//! least squares, and every valley that the grid shows is handed on, up to a few. A coarse grid of shapes hides what the rates explain:
//! on demand, so are all valleys of the rates at a shape that is nearly right. Each law says where it starts from there; a kernel that is
//! no sum of exponentials goes over a grid of its own.

use nalgebra::{DMatrix, DVector};

use super::columns::{BLOCK, Column, Products};
use super::data::Data;
use super::many_exp::exp;
use palpate_model::kernel::MemoryOf;
use palpate_model::laws::Beginning;
use palpate_model::{BaseLaw, Branch, Constants, Elastic, Form, LawOption, MAX_TERMS, Span};

/// A start: shape of the elastic response, rates (1/s, fast to slow) and order of the kernel, and branch
/// forces (the equilibrium first) at the reference compression.
#[derive(Clone, Debug, PartialEq)]
struct Start {
    shape: f64,
    rates: Vec<f64>,
    order: f64,
    forces: Vec<f64>,
    cost: f64,
}

/// Which starts are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The likeliest.
    Likely,
    /// Those in other valleys of the rates too.
    Every,
}

impl Wanted {
    /// Most starts.
    pub const fn most(self) -> usize {
        match self {
            Self::Likely => 3,
            Self::Every => 12,
        }
    }
}

/// Parameters of the law to start from, the best first. The samples of each stretch weigh as the squares of their `roots`, or all the
/// same where there are none.
pub fn starts(law: &BaseLaw, data: &Data, roots: &[&[f64]], wanted: Wanted) -> Vec<Vec<f64>> {
    let reference = data.largest_compression();
    let mut found = linear_starts(law, (data, roots), reference, wanted);
    found.truncate(wanted.most());
    let scales = data.scales();
    let beginning = Beginning {
        linear: found.iter().map(|start| start.constants(law.elastic, reference)).collect(),
        reference,
        force: scales.force,
        speed: scales.speed,
    };
    let starts = (law.family.starts)(law, &beginning);
    starts.iter().map(|constants| law.parameters_of(constants)).collect()
}

impl Start {
    /// What all laws share of it.
    fn constants(&self, elastic: Elastic, reference: f64) -> Constants {
        let total: f64 = self.forces.iter().sum();
        let p = total / elastic.unit(self.shape, reference);
        Constants {
            shares: self.forces[1..].iter().map(|force| force / total).collect(),
            rates: self.rates.clone(),
            order: self.order,
            ..Constants::new(p, self.shape)
        }
    }
}

const RATES: usize = 16;
/// The first of the rates by which next to nothing relaxes within a stretch.
const SLOW: usize = 15;
/// Columns of a sample: the elastic response, the answer at each rate, and the signal.
const COLUMNS: usize = RATES + 2;
/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;

/// The starts of Fung's law, the best first: each valley of the grid, or where the law is not quite Fung's the best of each shape.
fn linear_starts(law: &BaseLaw, set: Set, reference: f64, wanted: Wanted) -> Vec<Start> {
    let rates = rate_grid(set.0);
    let has_shapes = law.family.takes(LawOption::Elastic);
    let shapes = if has_shapes { law.elastic.shapes(reference) } else { vec![law.family.shape] };
    let of = |shapes: &[f64]| grams(set, law, shapes, (&rates, reference));
    let grid = Grid { grams: of(&shapes), terms: law.terms, rates };
    let mut found: Vec<Start> = match law.kernel.memory {
        MemoryOf::Exponentials => {
            let mut lowest: Vec<Cell> =
                (0..shapes.len()).filter_map(|shape| grid.lowest(shape)).collect();
            let itself = law.family.form == Form::Force && !law.family.retarded;
            if itself && law.family.linear_memory {
                lowest = grid.valleys(lowest);
            }
            let between = |cell: &Cell| grid.between(&shapes, cell);
            let shapes: &[f64] = &lowest.iter().map(between).collect::<Vec<f64>>();
            // Which rates are best shows only where the shape is nearly right.
            let refined = &Grid { grams: of(shapes), terms: law.terms, rates };
            let starts = |(place, own): (usize, &Cell)| {
                let mut cells = match wanted {
                    Wanted::Likely => Vec::new(),
                    Wanted::Every => refined.minima(place),
                };
                if !cells.iter().any(|cell| cell.chosen == own.chosen) {
                    cells.extend(refined.at(place, own.chosen.clone()));
                }
                cells.into_iter().filter_map(move |cell| refined.start(shapes[place], &cell))
            };
            lowest.iter().enumerate().flat_map(starts).collect()
        }
        memory => {
            let best = |(gram, &shape): (&Gram, &f64)| {
                best_kernel(gram, shape, &rates, (memory, law.span))
            };
            grid.grams.iter().zip(&shapes).filter_map(best).collect()
        }
    };
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}

/// A data set, and the roots of the weights of its samples, stretch by stretch; none where all weigh the same.
type Set<'a> = (&'a Data<'a>, &'a [&'a [f64]]);

/// The best forces at every shape and every set of rates.
struct Grid {
    /// For each shape.
    grams: Vec<Gram>,
    terms: usize,
    rates: [f64; RATES],
}

/// A place of the grid.
#[derive(Clone, Debug, PartialEq)]
struct Cell {
    /// Which shape.
    shape: usize,
    /// The equilibrium, which is 0, and which rates, from 1.
    chosen: Vec<usize>,
    cost: f64,
}

impl Grid {
    /// The lowest of a shape.
    fn lowest(&self, shape: usize) -> Option<Cell> {
        let mut best = None;
        self.descend(shape, &mut Elimination::default(), &mut vec![0], &mut best);
        best
    }

    /// The cells of a shape that are lower than all that are one step away in some or all rates, and the lowest of those with a rate so
    /// slow that what relaxes by it hardly shows: a search seldom finds from the one kind to the other. The lowest first.
    fn minima(&self, shape: usize) -> Vec<Cell> {
        let mut cells: Vec<Cell> = vec![];
        let mut choose = vec![vec![0]];
        while let Some(chosen) = choose.pop() {
            if chosen.len() > self.terms {
                cells.extend(self.at(shape, chosen));
                continue;
            }
            let last = chosen[chosen.len() - 1];
            choose.extend((last + 1..=RATES).map(|next| [&chosen[..], &[next]].concat()));
        }
        cells.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let beside =
            |a: &Cell, b: &Cell| a.chosen.iter().zip(&b.chosen).all(|(a, b)| a.abs_diff(*b) <= 1);
        let is_minimum = |k: usize| !cells[..k].iter().any(|lower| beside(lower, &cells[k]));
        let slow = cells.iter().position(|cell| cell.chosen.last().is_some_and(|k| *k >= SLOW));
        (0..cells.len())
            .filter(|&k| Some(k) == slow || is_minimum(k))
            .map(|k| cells[k].clone())
            .collect()
    }

    /// Takes the lowest of those that begin with these branches, of which all but the last are eliminated.
    fn descend(
        &self,
        shape: usize,
        so_far: &mut Elimination,
        chosen: &mut Vec<usize>,
        best: &mut Option<Cell>,
    ) {
        let gram = &self.grams[shape];
        let place = chosen.len() - 1;
        if !gram.eliminate(so_far, chosen, place) {
            return;
        }
        if place < self.terms {
            for next in chosen[place] + 1..=RATES {
                chosen.push(next);
                self.descend(shape, so_far, chosen, best);
                chosen.pop();
            }
            return;
        }
        let least = best.as_ref().map_or(f64::INFINITY, |best| best.cost);
        if gram.total - so_far.explained[place + 1] < least
            && let Some(Forces { cost, .. }) = gram.solve(chosen)
            && cost < least
        {
            *best = Some(Cell { shape, chosen: chosen.clone(), cost });
        }
    }

    /// Where cells come to that go on to the lowest neighbour as long as that is lower: each place once.
    fn valleys(&self, cells: Vec<Cell>) -> Vec<Cell> {
        let mut ends: Vec<Cell> = Vec::new();
        let mut passed: Vec<Cell> = Vec::new();
        for mut cell in cells {
            while !passed.contains(&cell) {
                passed.push(cell.clone());
                match self.lowest_beside(&cell).filter(|beside| beside.cost < cell.cost) {
                    Some(beside) => cell = beside,
                    None => ends.push(cell.clone()),
                }
            }
        }
        ends
    }

    /// The lowest of the cells that are one step away in some or all directions.
    fn lowest_beside(&self, cell: &Cell) -> Option<Cell> {
        let steps = 3_usize.pow(self.terms as u32 + 1);
        let beside = |code: usize| {
            let mut rest = code;
            let mut moved = |from: usize| {
                let to = (from + rest % 3).checked_sub(1);
                rest /= 3;
                to
            };
            let shape = moved(cell.shape)?;
            let rates: Option<Vec<usize>> = cell.chosen[1..].iter().map(|&k| moved(k)).collect();
            let chosen: Vec<usize> = std::iter::once(0).chain(rates?).collect();
            self.at(shape, chosen)
        };
        (0..steps).filter_map(beside).min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// The cell with this shape and these rates, where the grid has it.
    fn at(&self, shape: usize, chosen: Vec<usize>) -> Option<Cell> {
        let rising = chosen.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising || chosen.last().is_none_or(|&last| last > RATES) {
            return None;
        }
        let cost = self.grams.get(shape)?.solve(&chosen)?.cost;
        Some(Cell { shape, chosen, cost })
    }

    /// The shape at the bottom of the parabola through a cell and those beside it; its own where there is none.
    fn between(&self, shapes: &[f64], cell: &Cell) -> f64 {
        let own = shapes[cell.shape];
        let beside =
            |shape: usize| Some((*shapes.get(shape)?, self.at(shape, cell.chosen.clone())?.cost));
        let sides = cell.shape.checked_sub(1).and_then(beside).zip(beside(cell.shape + 1));
        let Some(((left, above_left), (right, above_right))) = sides else { return own };
        let (down, up) = (own - left, right - own);
        let slopes = ((above_left - cell.cost) / down, (above_right - cell.cost) / up);
        let curvature = slopes.0 + slopes.1;
        let moved = 0.5 * (slopes.0 * up - slopes.1 * down) / curvature;
        if slopes.0 >= 0.0 && slopes.1 >= 0.0 && curvature > 0.0 { own + moved } else { own }
    }

    /// The start at a cell, with the shape that it stands for.
    fn start(&self, shape: f64, cell: &Cell) -> Option<Start> {
        let Forces { values, cost } = self.grams[cell.shape].solve(&cell.chosen)?;
        let rates = cell.chosen[1..].iter().map(|&k| self.rates[k - 1]).collect();
        Some(Start { shape, rates, order: 1.0, forces: values[..=self.terms].to_vec(), cost })
    }
}

/// The best order, and rate where it has one, of a kernel.
fn best_kernel(
    gram: &Gram,
    shape: f64,
    rates: &[f64; RATES],
    (memory, span): (MemoryOf, Span),
) -> Option<Start> {
    let MemoryOf::Spectrum { of, has_rate, orders, .. } = memory else {
        let Forces { values, cost } = gram.solve(&[0])?;
        return Some(Start { shape, rates: Vec::new(), order: 1.0, forces: vec![values[0]], cost });
    };
    let own_rates = if has_rate { &rates[..] } else { &[1.0] };
    let mut best: Option<Start> = None;
    for &rate in own_rates {
        for &order in orders {
            let shares = on_grid(&of(rate, order, span).branches, rates);
            let Some(Forces { values, cost }) = gram.combined(&shares).solve(&[0, 1]) else {
                continue;
            };
            let forces = values[..2].to_vec();
            if forces.iter().sum::<f64>() > 0.0 && best.as_ref().is_none_or(|b| cost < b.cost) {
                let rates = if has_rate { vec![rate] } else { Vec::new() };
                best = Some(Start { shape, rates, order, forces, cost });
            }
        }
    }
    best
}

/// Shares of a standing part and of each rate of a falling grid that together come near these branches:
/// each goes to the rate next to its own, what is too fast for the grid is left out.
fn on_grid(branches: &[Branch], rates: &[f64]) -> DVector<f64> {
    let ratio = (rates[0] / rates[1]).sqrt();
    let mut shares = DVector::zeros(rates.len() + 1);
    for branch in branches.iter().filter(|branch| branch.rate < rates[0] * ratio) {
        let place = rates.iter().position(|rate| branch.rate > rate / ratio);
        shares[place.map_or(0, |place| place + 1)] += branch.share;
    }
    shares
}

/// Rates from slower than the longest stretch to as fast as the sampling shows, 1/s, falling.
fn rate_grid(data: &Data) -> [f64; RATES] {
    let fastest = (0.5 / data.shortest_interval()).min(1e4 / data.longest());
    let slowest = 0.5 / data.longest();
    let ratio = (slowest / fastest).powf(1.0 / (RATES - 1) as f64);
    std::array::from_fn(|k| fastest * ratio.powi(k as i32))
}

/// Inner products of the measured signal and of every branch's answer to the motion, in contact.
struct Gram {
    products: DMatrix<f64>,
    measured: DVector<f64>,
    total: f64,
}

/// What a shape of the elastic response is summed up in.
struct Shape {
    /// Stiffness of a force of one at the reference compression.
    p: f64,
    /// State of each branch: one whose whole response decays at its rate.
    states: [f64; RATES],
    driven: f64,
    block: [Column; COLUMNS],
    products: Products,
}

/// The products of every shape of the elastic response, all in one run over the motions.
fn grams(
    (data, roots): Set,
    law: &BaseLaw,
    shapes: &[f64],
    (rates, reference): (&[f64; RATES], f64),
) -> Vec<Gram> {
    let elastic = law.elastic;
    let mut sums: Vec<(f64, Shape)> =
        shapes.iter().map(|&shape| (shape, Shape::new(elastic.unit(shape, reference)))).collect();
    let mut filled = 0;
    for (index, piece) in data.pieces.iter().enumerate() {
        let roots = roots.get(index).copied().unwrap_or_default();
        sums.iter_mut().for_each(|(_, sums)| sums.rest());
        let mut steps = [(1.0, 1.0); RATES];
        let (mut before, mut interval) = (f64::NAN, f64::NAN);
        let motion = &piece.motion;
        let felt = law.separation.all_felt(&motion.displacement);
        let samples = motion.time.iter().zip(&*felt).zip(piece.measured);
        for (k, ((&time, &x), &y)) in samples.enumerate() {
            let now = time - before;
            before = time;
            let same = (now - interval).abs() <= SAME_INTERVAL * now;
            if now > 0.0 && !same {
                interval = now;
                steps = rates.map(|rate| step(rate * now));
            }
            for (shape, sums) in &mut sums {
                sums.drive(sums.p * elastic.unit(*shape, x), &steps);
                if x != 0.0 {
                    sums.keep(y, roots.get(k).copied().unwrap_or(1.0), filled);
                }
            }
            filled += usize::from(x != 0.0);
            if filled == BLOCK {
                sums.iter_mut().for_each(|(_, sums)| sums.add(BLOCK));
                filled = 0;
            }
        }
    }
    sums.iter_mut().for_each(|(_, sums)| sums.add(filled));
    sums.iter().map(|(_, sums)| Gram::of(&sums.products)).collect()
}

/// Decay and gain of a branch over so many times its own time.
fn step(turns: f64) -> (f64, f64) {
    let decay = exp(-turns);
    let gain = if turns < 1e-5 { 1.0 - 0.5 * turns } else { (1.0 - decay) / turns };
    (decay, gain)
}

impl Shape {
    fn new(unit: f64) -> Self {
        Self {
            p: 1.0 / unit,
            states: [0.0; RATES],
            driven: 0.0,
            block: [Column::ZERO; COLUMNS],
            products: Products::zeros(COLUMNS),
        }
    }

    /// The specimen has forgotten all.
    fn rest(&mut self) {
        (self.states, self.driven) = ([0.0; RATES], 0.0);
    }

    fn drive(&mut self, response: f64, steps: &[(f64, f64); RATES]) {
        let change = response - self.driven;
        self.driven = response;
        for (state, (decay, gain)) in self.states.iter_mut().zip(steps) {
            *state = *state * decay + gain * change;
        }
    }

    /// Keeps this sample with its signal, times a root, at a place of the block.
    fn keep(&mut self, signal: f64, root: f64, place: usize) {
        let values = [self.driven].into_iter().chain(self.states).chain([signal]);
        for (column, value) in self.block.iter_mut().zip(values) {
            column.0[place] = root * value;
        }
    }

    /// Adds the first so many samples of the block.
    fn add(&mut self, samples: usize) {
        self.block.iter_mut().for_each(|column| column.0[samples..].fill(0.0));
        self.products.add(&self.block);
    }
}

/// Nonnegative forces of some branches.
#[derive(Clone, Copy, Debug)]
struct Forces {
    values: [f64; MAX_TERMS + 1],
    /// The sum of squares that they leave.
    cost: f64,
}

/// Branches eliminated one after the other from the products of all.
#[derive(Clone, Copy, Default)]
struct Elimination {
    /// The triangular factor of the products, row by row.
    lower: [[f64; MAX_TERMS + 1]; MAX_TERMS + 1],
    /// The right-hand side behind it.
    values: [f64; MAX_TERMS + 1],
    /// What the first so many branches explain, whatever the sign of their forces.
    explained: [f64; MAX_TERMS + 2],
}

impl Gram {
    fn of(products: &Products) -> Self {
        let size = RATES + 1;
        Self {
            products: DMatrix::from_fn(size, size, |a, b| products.of(a, b)),
            measured: DVector::from_fn(size, |a, _| products.of(a, size)),
            total: products.of(size, size),
        }
    }

    /// The same for the elastic response and one answer that is made of these parts of all.
    fn combined(&self, shares: &DVector<f64>) -> Self {
        let all = &self.products * shares;
        let products = DMatrix::from_row_slice(
            2,
            2,
            &[self.products[(0, 0)], all[0], all[0], shares.dot(&all)],
        );
        let measured = DVector::from_vec(vec![self.measured[0], shares.dot(&self.measured)]);
        Self { products, measured, total: self.total }
    }

    /// Nonnegative forces of at most `MAX_TERMS + 1` branches `chosen`, and the sum of squares they leave.
    fn solve(&self, chosen: &[usize]) -> Option<Forces> {
        let mut kept = chosen.to_vec();
        while !kept.is_empty() {
            let Forces { values, cost } = self.solve_free(&kept)?;
            let least = (0..kept.len()).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
            if values[least] >= 0.0 {
                let mut forces = [0.0; MAX_TERMS + 1];
                for (force, branch) in forces.iter_mut().zip(chosen) {
                    let place = kept.iter().position(|kept| kept == branch);
                    *force = place.map_or(0.0, |place| values[place]);
                }
                return Some(Forces { values: forces, cost });
            }
            kept.remove(least);
        }
        None
    }

    /// Forces of branches, whatever their sign, and what they leave; none where they cannot be told apart.
    fn solve_free(&self, chosen: &[usize]) -> Option<Forces> {
        let mut all = Elimination::default();
        let told_apart = (0..chosen.len()).all(|place| self.eliminate(&mut all, chosen, place));
        let Elimination { lower, mut values, explained } = all;
        for a in (0..chosen.len()).rev() {
            let after: f64 = (a + 1..chosen.len()).map(|k| lower[k][a] * values[k]).sum();
            values[a] = (values[a] - after) / lower[a][a];
        }
        let cost = self.total - explained[chosen.len()];
        told_apart.then_some(Forces { values, cost })
    }

    /// Eliminates the branch at a place of `chosen` after those before it; false where it cannot be told from them.
    fn eliminate(&self, so_far: &mut Elimination, chosen: &[usize], a: usize) -> bool {
        let Elimination { lower, values, explained } = so_far;
        for b in 0..a {
            let sum: f64 = (0..b).map(|k| lower[a][k] * lower[b][k]).sum();
            lower[a][b] = (self.products[(chosen[a], chosen[b])] - sum) / lower[b][b];
        }
        let own = self.products[(chosen[a], chosen[a])] * (1.0 + 1e-12);
        let rest = own - lower[a][..a].iter().map(|below| below * below).sum::<f64>();
        if rest <= 0.0 || rest.is_nan() {
            return false;
        }
        lower[a][a] = rest.sqrt();
        let before: f64 = (0..a).map(|k| lower[a][k] * values[k]).sum();
        values[a] = (self.measured[chosen[a]] - before) / lower[a][a];
        explained[a + 1] = explained[a] + values[a] * values[a];
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_of_a_shape_is_that_of_all_choices() {
        // Answers that overlap, and a signal that some branches explain with a negative force alone.
        let answer = |a: usize, k: usize| (-(k as f64) / (1.5 * a as f64 + 1.0)).exp();
        let signal = |k: usize| answer(2, k) + 0.6 * answer(9, k) - 0.2 * answer(12, k);
        let value = |a: usize, k: usize| if a <= RATES { answer(a, k) } else { signal(k) };
        let product = |a: usize, b: usize| (0..60).map(|k| value(a, k) * value(b, k)).sum::<f64>();
        let size = RATES + 1;
        let gram = Gram {
            products: DMatrix::from_fn(size, size, product),
            measured: DVector::from_fn(size, |a, _| product(a, size)),
            total: product(size, size),
        };
        let mut costs = Vec::new();
        for a in 1..=RATES {
            for b in a + 1..=RATES {
                let chosen = vec![0, a, b];
                costs.extend(gram.solve(&chosen).map(|Forces { cost, .. }| (cost, chosen)));
            }
        }
        let least = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let grid = Grid { grams: vec![gram], terms: 2, rates: [0.0; RATES] };
        let found = grid.lowest(0).unwrap();
        assert_eq!((found.cost, found.chosen), least);
    }
}
