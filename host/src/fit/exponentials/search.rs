//! The global minimum: every promising start of the grid is refined, and signs are imposed only
//! where the free minimum breaks them.

use super::grid::{Grid, Scores};
use super::point::{Problem, Signs};
use super::refine::{Refined, refine};
use super::vector::{add_scaled, dot};

/// A start is refined when its sum of squares exceeds the least found so far by at most so many
/// times what refining gained for the best start …
const REACH_GAIN: f64 = 5.0;
/// … plus so many variances of the noise.
const REACH_NOISE: f64 = 20.0;
/// Most starts refined beside the best.
const MOST_STARTS: usize = 12;

/// Grids for the starts.
#[derive(Clone, Debug)]
pub(super) struct Grids<const R: usize> {
    /// Beside a constant of any size.
    pub with_constant: Grid<R>,
    /// Without a constant, where its sign can hold it at 0.
    pub without_constant: Option<Grid<R>>,
}

/// Finds the global minimum; `degrees` of freedom are for the scale of the noise.
pub(super) fn search<const N: usize, const R: usize>(
    problem: &Problem<R>,
    grids: &Grids<R>,
    degrees: f64,
) -> Refined<N, R> {
    let free = Problem { signs: Signs::FREE, ..*problem };
    let mut target = *problem.target;
    target[0] = 0.0;
    let scores = grids.with_constant.scores(&target, N);
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
    if problem.allows(&best.point) {
        return best;
    }
    signed(problem, grids)
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
fn signed<const N: usize, const R: usize>(
    problem: &Problem<R>,
    grids: &Grids<R>,
) -> Refined<N, R> {
    let middle = 0.5 * (problem.table.lowest + problem.table.highest);
    let mut best = insert(problem, refine(problem, [middle; N]));
    let mut centred = *problem.target;
    centred[0] = 0.0;
    let faces = [
        (Some(&grids.with_constant), centred),
        (grids.without_constant.as_ref(), *problem.target),
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
