//! The global minimum: every promising start of the grid is refined, and signs are imposed only
//! where the free minimum breaks them.

use super::covariance::significance;
use super::grid::{Grid, Scores};
use super::point::{Problem, Signs};
use super::refine::{Refined, refine};
use super::table::Table;
use super::vector::{add_scaled, dot};
use std::sync::OnceLock;

/// A start is refined when its sum of squares exceeds the least found so far by at most so many
/// times what refining gained for the best start …
const REACH_GAIN: f64 = 5.0;
/// … plus so many variances of the noise.
const REACH_NOISE: f64 = 20.0;
/// Most starts refined beside the best.
const MOST_STARTS: usize = 12;

/// A term stands out of the noise when leaving it out, or merging it with another, would raise the
/// sum of squares by more than so many variances of the noise.
const CERTAIN: f64 = 100.0;
/// Rates tried when one term is moved, and how often all terms are.
const SCANNED_RATES: usize = 48;
const MOST_EXCHANGES: usize = 4;

/// Grids for the starts, made when they are asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Grids<const R: usize> {
    with_constant: OnceLock<Grid<R>>,
    without_constant: OnceLock<Grid<R>>,
}

impl<const R: usize> Grids<R> {
    /// For sets of `N` rates beside a constant of any size.
    fn with_constant<const N: usize>(&self, table: &Table<R>) -> &Grid<R> {
        self.with_constant.get_or_init(|| Grid::new(table, N, true))
    }

    /// The same without a constant, where its sign can hold it at 0.
    fn without_constant<const N: usize>(&self, problem: &Problem<R>) -> Option<&Grid<R>> {
        let held = problem.signs.constant != 0.0;
        held.then(|| self.without_constant.get_or_init(|| Grid::new(problem.table, N, false)))
    }
}

/// Logarithms of the rates at the minimum with one term less, for amplitudes of any sign and of
/// the allowed ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Fewer {
    pub free: Vec<f64>,
    pub signed: Vec<f64>,
}

impl Fewer {
    pub fn from<const N: usize, const R: usize>(found: &Found<N, R>) -> Self {
        Self { free: found.free.to_vec(), signed: found.signed.point.u.to_vec() }
    }
}

/// The global minimum for amplitudes of any sign and of the allowed signs.
pub(super) struct Found<const N: usize, const R: usize> {
    pub free: [f64; N],
    pub signed: Refined<N, R>,
}

/// Finds the global minimum; `degrees` of freedom are for the scale of the noise, `fewer` is
/// asked only where it is needed.
///
/// Where every term stands out of the noise, a sum of squares that a rival could undercut has one
/// wide basin, which the grid shows. Where one does not, there are about as many minima as there
/// are ways to fit noise with it: then the minimum with one term less is extended by a term
/// anywhere. So are three and more terms, whose grids are coarse.
pub(super) fn search<const N: usize, const R: usize>(
    problem: &Problem<R>,
    grids: &Grids<R>,
    degrees: f64,
    fewer: impl FnOnce() -> Fewer,
) -> Found<N, R> {
    let free = Problem { signs: Signs::FREE, ..*problem };
    let mut target = *problem.target;
    target[0] = 0.0;
    let scores = grids.with_constant::<N>(problem.table).scores(&target, N);
    let inside = problem.outside + dot(&target, &target);

    let first = scores.best();
    let mut best = refine(&free, start(&scores, first));
    let gain = (inside - scores.value(first) - best.point.rss).max(0.0);
    let reach = best.point.rss * (1.0 + REACH_NOISE / degrees) + REACH_GAIN * gain;
    for place in scores.peaks(inside - reach).into_iter().take(MOST_STARTS) {
        if place != first {
            keep_better(&mut best, refine(&free, start(&scores, place)));
        }
    }
    let allowed = problem.allows(&best.point);
    let certain = significance(problem, &best) * degrees >= CERTAIN * best.point.rss;
    if allowed && (N == 1 || (N == 2 && certain)) {
        return Found { free: best.point.u, signed: best };
    }
    let fewer = fewer();
    best = exchange(&free, one_more(&free, best, &fewer.free));
    if problem.allows(&best.point) {
        return Found { free: best.point.u, signed: best };
    }
    let allowed = one_more(problem, signed(problem, grids), &fewer.signed);
    Found { free: best.point.u, signed: exchange(problem, allowed) }
}

/// A set of the grid; terms beyond it start at the ends of the range.
fn start<const N: usize, const R: usize>(scores: &Scores<R>, place: usize) -> [f64; N] {
    let mut rates = scores.rates(place);
    let mut last = 0.0;
    std::array::from_fn(|_| {
        last = rates.next().unwrap_or(last);
        last
    })
}

fn keep_better<const N: usize, const R: usize>(best: &mut Refined<N, R>, other: Refined<N, R>) {
    let iterations = best.iterations + other.iterations;
    if other.point.rss < best.point.rss {
        *best = other;
    }
    best.iterations = iterations;
}

/// The global minimum among amplitudes of the allowed signs. It lies in a face, some amplitudes
/// being 0, and is a free minimum of that face: so all faces are searched for starts.
fn signed<const N: usize, const R: usize>(problem: &Problem<R>, grids: &Grids<R>) -> Refined<N, R> {
    let middle = 0.5 * (problem.table.lowest + problem.table.highest);
    let mut best = insert(problem, refine(problem, [middle; N]));
    let mut centred = *problem.target;
    centred[0] = 0.0;
    let faces = [
        (Some(grids.with_constant::<N>(problem.table)), centred),
        (grids.without_constant::<N>(problem), *problem.target),
    ];
    for (grid, target) in faces {
        let Some(grid) = grid else { continue };
        for terms in (1..=N).rev() {
            let scores = grid.scores(&target, terms);
            for place in scores.peaks(0.0).into_iter().take(MOST_STARTS / 2) {
                let refined = refine(problem, start(&scores, place));
                keep_better(&mut best, insert(problem, refined));
            }
        }
    }
    best
}

/// Moves one rate at a time over the whole range, the others staying, and refines every minimum
/// met on the way, until that brings nothing.
fn exchange<const N: usize, const R: usize>(
    problem: &Problem<R>,
    mut best: Refined<N, R>,
) -> Refined<N, R> {
    for _ in 0..MOST_EXCHANGES {
        let from = best.point;
        for moved in 0..N {
            scan(problem, &mut best, from.u, moved);
        }
        if best.point.rss >= from.rss * (1.0 - 1e-9) {
            break;
        }
    }
    best
}

/// Adds a term anywhere to the minimum with one less.
fn one_more<const N: usize, const R: usize>(
    problem: &Problem<R>,
    mut best: Refined<N, R>,
    fewer: &[f64],
) -> Refined<N, R> {
    let u = std::array::from_fn(|i| fewer.get(i).copied().unwrap_or(problem.table.highest));
    scan(problem, &mut best, u, N - 1);
    best
}

/// Moves one rate over the whole range and refines every minimum of the sum of squares.
fn scan<const N: usize, const R: usize>(
    problem: &Problem<R>,
    best: &mut Refined<N, R>,
    from: [f64; N],
    moved: usize,
) {
    let at = |rate: f64| {
        let mut u = from;
        u[moved] = rate;
        u
    };
    let rates = problem.table.coarse(SCANNED_RATES);
    let sums: Vec<f64> = rates.iter().map(|rate| problem.point(at(*rate)).rss).collect();
    for (k, rate) in rates.iter().enumerate() {
        let before = k.checked_sub(1).map_or(f64::INFINITY, |before| sums[before]);
        let after = sums.get(k + 1).copied().unwrap_or(f64::INFINITY);
        if sums[k] <= before && sums[k] < after {
            keep_better(best, refine(problem, at(*rate)));
        }
    }
}

/// While a term is at 0, gives it the rate at which it would help most. When no rate helps, the
/// minimum is global: sums of exponentials of one sign, of any number of terms, are a convex set.
fn insert<const N: usize, const R: usize>(
    problem: &Problem<R>,
    mut refined: Refined<N, R>,
) -> Refined<N, R> {
    if problem.signs.terms == 0.0 {
        return refined;
    }
    for _ in 0..2 * N {
        let point = &refined.point;
        let Some(idle) = point.face.terms.iter().position(|free| !free) else { break };
        let mut most = 1e-9 * point.rss;
        let mut rate = None;
        for u in problem.table.coarse(96) {
            let mut column = problem.table.at(u).value;
            if point.face.constant {
                column[0] = 0.0;
            }
            for q in &point.q {
                let along = dot(q, &column);
                add_scaled(&mut column, -along, q);
            }
            let length = dot(&column, &column).sqrt();
            let along = problem.signs.terms * dot(&column, &point.residual) / length;
            if length > 1e-7 && along > 0.0 && along * along > most {
                most = along * along;
                rate = Some(u);
            }
        }
        let Some(rate) = rate else { break };
        let mut u = point.u;
        u[idle] = rate;
        let next = refine(problem, u);
        if next.point.rss >= point.rss * (1.0 - 1e-10) {
            break;
        }
        keep_better(&mut refined, next);
    }
    refined
}
