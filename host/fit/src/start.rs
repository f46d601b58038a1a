//! A start for the fit of a whole motion, so that nobody is asked for one.
//!
//! For a given shape of the elastic response (the exponent q) and given rates the law is linear in the
//! force that each branch carries. So shape and rates go over a grid, the branch forces come from linear
//! least squares, and the best few distinct starts are handed on. The other laws start from what Fung's
//! law makes of the data; a kernel that is no sum of exponentials goes over a grid of its own.

use nalgebra::{DMatrix, DMatrixView, DVector};

use super::data::Data;
use palpate_model::{
    BaseLaw, Branch, Constants, Elastic, Family, Kernel, Memory, Relaxation, Span,
};

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
/// Powers n of the nonlinear latency model that are tried.
const POWERS: [f64; 4] = [1.2, 2.0, 3.0, 5.0];
/// Latent compressions, as parts of the largest compression, at which its rate may be that of the linear
/// model.
const LATENT: [f64; 2] = [0.5, 0.15];

/// Parameters of the law to start from, the best first.
pub fn starts(law: &BaseLaw, data: &Data) -> Vec<Vec<f64>> {
    let reference = data.largest_compression();
    let mut found = linear_starts(law, data, reference);
    found.truncate(MOST);
    let constants = |start: &Start| start.constants(law.elastic, reference);
    match law.family {
        Family::KelvinVoigt => vec![damped(data, reference)],
        // The spring of the equilibrium is not there: the branch carries all.
        Family::Maxwell => found
            .iter()
            .map(|start| law.parameters_of(&Constants { shares: vec![1.0], ..constants(start) }))
            .collect(),
        Family::LatencyPower => {
            let powers = law.exponent.map_or(POWERS.to_vec(), |power| vec![power]);
            let bent = |start: &Start, power: f64, latent: f64| {
                let mut constants = constants(start);
                constants.exponent = power;
                constants.rates[0] /= (latent * reference).powf(power - 1.0);
                law.parameters_of(&constants)
            };
            let each = found.iter().take(2).flat_map(|start| {
                powers
                    .iter()
                    .flat_map(move |&power| LATENT.map(|latent| bent(start, power, latent)))
            });
            each.collect()
        }
        // What relaxes by the share c creeps by it too, slower by the share that is left.
        Family::Creep => found
            .iter()
            .map(|start| {
                let mut constants = constants(start);
                let left = 1.0 - constants.shares.iter().sum::<f64>();
                constants.p *= left;
                constants.rates.iter_mut().for_each(|rate| *rate *= left.max(0.1));
                law.parameters_of(&constants)
            })
            .collect(),
        _ => found.iter().map(|start| law.parameters_of(&constants(start))).collect(),
    }
}

/// Stiffness and damping of eq. 2.3, as large as the forces.
fn damped(data: &Data, reference: f64) -> Vec<f64> {
    let scales = data.scales();
    vec![scales.force / reference, 0.1 * scales.force / scales.speed.max(f64::MIN_POSITIVE)]
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
    let shapes = if law.family.is_linear() { vec![0.0] } else { law.elastic.shapes(reference) };
    let best = |&shape: &f64| {
        let gram = Gram::of(data, (law.elastic, shape), &rates, reference);
        match law.kernel {
            Kernel::Exponentials => best_rates(&gram, shape, &rates, law.terms),
            kernel => best_kernel(&gram, shape, &rates, (kernel, law.span)),
        }
    };
    let mut found: Vec<Start> = shapes.iter().filter_map(best).collect();
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}

/// Orders β that are tried.
const ORDERS: [f64; 5] = [0.08, 0.2, 0.35, 0.5, 0.75];

/// The best order, and rate where it has one, of a kernel.
fn best_kernel(
    gram: &Gram,
    shape: f64,
    rates: &[f64],
    (kernel, span): (Kernel, Span),
) -> Option<Start> {
    if kernel == Kernel::None {
        let (forces, cost) = gram.solve(&[0])?;
        return Some(Start { shape, rates: Vec::new(), order: 1.0, forces, cost });
    }
    let own_rates = if kernel == Kernel::Stretched { rates } else { &[1.0] };
    let mut best: Option<Start> = None;
    for &rate in own_rates {
        for order in ORDERS {
            let shares = on_grid(&kernel.spectrum(rate, order, span).branches, rates);
            let Some((forces, cost)) = gram.combined(&shares).solve(&[0, 1]) else { continue };
            if forces.iter().sum::<f64>() > 0.0 && best.as_ref().is_none_or(|b| cost < b.cost) {
                let rates = if kernel == Kernel::Stretched { vec![rate] } else { Vec::new() };
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
