//! A start for the fit of a whole motion, so that nobody is asked for one.
//!
//! For a given shape of the elastic response (the exponent q) and given rates the law is linear in the
//! force that each branch carries. So shape and rates go over a grid, the branch forces come from linear
//! least squares, and the best few distinct starts are handed on. Each law says where it starts from there; a kernel that is no sum of exponentials goes over a grid of its own.

use nalgebra::{DMatrix, DMatrixView, DVector};

use super::data::Data;
use palpate_model::kernel::MemoryOf;
use palpate_model::laws::Beginning;
use palpate_model::{BaseLaw, Branch, Constants, Elastic, LawOption, Memory, Relaxation, Span};

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

/// Most starts from different shapes.
const MOST: usize = 3;

/// Parameters of the law to start from, the best first.
pub fn starts(law: &BaseLaw, data: &Data) -> Vec<Vec<f64>> {
    let reference = data.largest_compression();
    let mut found = linear_starts(law, data, reference);
    found.truncate(MOST);
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
/// Samples whose products are taken at a time.
const AT_A_TIME: usize = 256;

/// The best start of Fung's law for each shape of the elastic response, best first.
fn linear_starts(law: &BaseLaw, data: &Data, reference: f64) -> Vec<Start> {
    let rates = rate_grid(data);
    let shapes = match law.family.takes(LawOption::Elastic) {
        true => law.elastic.shapes(reference),
        false => vec![law.family.shape],
    };
    let best = |&shape: &f64| {
        let gram = Gram::of(data, (law.elastic, shape), &rates, reference);
        match law.kernel.memory {
            MemoryOf::Exponentials => best_rates(&gram, shape, &rates, law.terms),
            memory => best_kernel(&gram, shape, &rates, (memory, law.span)),
        }
    };
    let mut found: Vec<Start> = shapes.iter().filter_map(best).collect();
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}

/// The best order, and rate where it has one, of a kernel.
fn best_kernel(
    gram: &Gram,
    shape: f64,
    rates: &[f64],
    (memory, span): (MemoryOf, Span),
) -> Option<Start> {
    let MemoryOf::Spectrum { of, has_rate, orders, .. } = memory else {
        let (forces, cost) = gram.solve(&[0])?;
        return Some(Start { shape, rates: Vec::new(), order: 1.0, forces, cost });
    };
    let own_rates = if has_rate { rates } else { &[1.0] };
    let mut best: Option<Start> = None;
    for &rate in own_rates {
        for &order in orders {
            let shares = on_grid(&of(rate, order, span).branches, rates);
            let Some((forces, cost)) = gram.combined(&shares).solve(&[0, 1]) else { continue };
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
fn rate_grid(data: &Data) -> Vec<f64> {
    let fastest = (0.5 / data.shortest_interval()).min(1e4 / data.longest());
    let slowest = 0.5 / data.longest();
    let ratio = (slowest / fastest).powf(1.0 / (RATES - 1) as f64);
    (0..RATES).map(|k| fastest * ratio.powi(k as i32)).collect()
}

/// Inner products of the measured signal and of every branch's answer to the motion, in contact.
struct Gram {
    products: DMatrix<f64>,
    measured: DVector<f64>,
    total: f64,
}

impl Gram {
    fn of(data: &Data, (elastic, shape): (Elastic, f64), rates: &[f64], reference: f64) -> Self {
        let size = rates.len() + 1;
        let mut gram = Self {
            products: DMatrix::zeros(size, size),
            measured: DVector::zeros(size),
            total: 0.0,
        };
        let p = 1.0 / elastic.unit(shape, reference);
        // Each branch by itself: a relaxation function whose whole response decays at its rate.
        let alone: Vec<Relaxation> =
            rates.iter().map(|&rate| Relaxation::new(&[1.0], &[rate])).collect();
        // The signal counts as one more branch: one product of a few hundred rows gives all.
        let mut rows = Vec::with_capacity(AT_A_TIME * (size + 1));
        let mut sums = DMatrix::zeros(size + 1, size + 1);
        let mut add = |rows: &mut Vec<f64>| {
            let part = DMatrixView::from_slice(rows, size + 1, rows.len() / (size + 1));
            sums.gemm(1.0, &part, &part.transpose(), 1.0);
            rows.clear();
        };
        for piece in &data.pieces {
            let mut memories = vec![Memory::rested(1); rates.len()];
            let mut before = piece.motion.time[0];
            let samples =
                piece.motion.time.iter().zip(piece.motion.displacement.iter()).zip(piece.measured);
            for ((&time, &x), &y) in samples {
                let response = p * elastic.unit(shape, x);
                let first = rows.len();
                rows.push(response);
                for (memory, relaxation) in memories.iter_mut().zip(&alone) {
                    rows.push(if time > before {
                        memory.step(relaxation, response, time - before)
                    } else {
                        memory.jump(relaxation, response)
                    });
                }
                before = time;
                if x > 0.0 {
                    rows.push(y);
                } else {
                    rows.truncate(first);
                }
                if rows.len() == AT_A_TIME * (size + 1) {
                    add(&mut rows);
                }
            }
        }
        add(&mut rows);
        gram.products.copy_from(&sums.view((0, 0), (size, size)));
        gram.measured.copy_from(&sums.view((0, size), (size, 1)));
        gram.total = sums[(size, size)];
        gram
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

    /// Nonnegative forces of the branches `chosen`, and the sum of squares they leave.
    fn solve(&self, chosen: &[usize]) -> Option<(Vec<f64>, f64)> {
        let mut active: Vec<usize> = chosen.to_vec();
        loop {
            let size = active.len();
            let matrix = DMatrix::from_fn(size, size, |a, b| {
                let entry = self.products[(active[a], active[b])];
                if a == b { entry * (1.0 + 1e-12) } else { entry }
            });
            let right = DVector::from_fn(size, |a, _| self.measured[active[a]]);
            let forces = matrix.cholesky()?.solve(&right);
            let (worst, least) = forces.argmin();
            if least >= 0.0 {
                let cost = self.total - right.dot(&forces);
                let force_of =
                    |branch| active.iter().position(|&a| a == branch).map_or(0.0, |a| forces[a]);
                return Some((chosen.iter().map(|&branch| force_of(branch)).collect(), cost));
            }
            active.remove(worst);
            if active.is_empty() {
                return None;
            }
        }
    }
}

fn best_rates(gram: &Gram, shape: f64, rates: &[f64], terms: usize) -> Option<Start> {
    let mut best: Option<Start> = None;
    let mut chosen: Vec<usize> = (0..=terms).collect();
    loop {
        if let Some((forces, cost)) = gram.solve(&chosen)
            && best.as_ref().is_none_or(|best| cost < best.cost)
        {
            let rates = chosen[1..].iter().map(|&k| rates[k - 1]).collect();
            best = Some(Start { shape, rates, order: 1.0, forces, cost });
        }
        if !next_combination(&mut chosen[1..], rates.len()) {
            return best;
        }
    }
}

/// The next choice of distinct numbers 1…`count` in rising order; false after the last.
fn next_combination(chosen: &mut [usize], count: usize) -> bool {
    let size = chosen.len();
    let Some(place) = (0..size).rev().find(|&k| chosen[k] < count - (size - 1 - k)) else {
        return false;
    };
    chosen[place] += 1;
    for k in place + 1..size {
        chosen[k] = chosen[k - 1] + 1;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_choice_comes_once() {
        let mut chosen = [1, 2, 3];
        let mut count = 1;
        while next_combination(&mut chosen, 6) {
            assert!(chosen.windows(2).all(|pair| pair[0] < pair[1]) && chosen[2] <= 6);
            count += 1;
        }
        assert_eq!(count, 20);
    }
}
