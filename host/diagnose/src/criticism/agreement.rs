//! Whether the parts of the data agree about an effect, whatever the law leaves.
//!
//! Under the noise alone a score is easily significant where the law is inexact. Here each part of the
//! data (a trace, or a piece of one where there are few) votes with its own score, and the signs of
//! whole parts are flipped: a wild cluster bootstrap of the score test, the largest vote over the
//! library under the same flips as its null distribution (Cameron, Gelbach and Miller 2008).

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::screen::{ABSORBED, Direction, Screen};
use super::tail::log_tail;
use palpate_model::effects::Candidate;

/// Most parts whose flips are all gone through.
const ALL_FLIPS: usize = 12;
/// Flips drawn where there are more parts.
const DRAWS: usize = 4000;
/// Seed of the flips.
pub const SEED: u64 = 17;
/// Most strengths of a law that parts can vote on: more belong to single traces.
const MOST_STRENGTHS: usize = 3;
/// Kinds of votes.
const KINDS: usize = 2 * MOST_STRENGTHS + 2;

/// A direction that parts vote on.
#[derive(Clone)]
struct Vote<'a> {
    direction: &'a Direction,
    /// Parts × strengths.
    scores: DMatrix<f64>,
    /// Inverse of the sum over parts of their squared scores: flips do not change it.
    inverse: DMatrix<f64>,
    positive: bool,
}

impl Vote<'_> {
    /// Square of the total under these signs, in its own variances; none where it has the wrong sign.
    fn square(&self, signs: &DVector<f64>) -> Option<f64> {
        if let [inverse] = self.inverse.as_slice() {
            let total = self.scores.column(0).dot(signs);
            return (!self.positive || total > 0.0).then_some(total * total * inverse);
        }
        let total = self.scores.tr_mul(signs);
        Some(total.dot(&(&self.inverse * &total)))
    }

    /// Logarithm of the nominal chance of such a square.
    fn log_chance(&self, square: f64) -> f64 {
        log_tail(square, self.scores.ncols(), self.positive)
    }

    /// What votes have in common whose chance falls alike as the square grows.
    fn kind(&self) -> usize {
        2 * self.scores.ncols() + usize::from(self.positive)
    }
}

/// Chance that parts which know nothing of any effect agree as much about one of the library, for each
/// candidate; 1 where parts cannot vote on it.
#[must_use]
pub fn chances(screen: &Screen, candidates: &[Candidate]) -> Vec<f64> {
    let votes = votes(screen, candidates);
    let null = null(&votes, &flips(screen.scores.nrows()));
    (0..candidates.len()).map(|candidate| chance(&null, of(&votes, candidate))).collect()
}

/// The same of a protected test: where the parts agree about any effect, the chance of as much agreement about this one alone, but not
/// below that of the one they agree about most.
#[must_use]
pub fn protected_chances(screen: &Screen, candidates: &[Candidate]) -> Vec<f64> {
    let any = chances(screen, candidates).into_iter().fold(1.0, f64::min);
    let votes = votes(screen, candidates);
    let flips = flips(screen.scores.nrows());
    let alone = |candidate: usize| {
        let own: Vec<Vote> = of(&votes, candidate).cloned().collect();
        chance(&null(&own, &flips), own.iter()).max(any)
    };
    (0..candidates.len()).map(alone).collect()
}

/// The least nominal chance of these votes under each of some flips.
fn null(votes: &[Vote], flips: &[DVector<f64>]) -> Vec<f64> {
    let least = |signs: &DVector<f64>| {
        // Of each kind the largest square has the least chance.
        let mut largest: [Option<(f64, &Vote)>; KINDS] = [None; KINDS];
        for vote in votes {
            let known = &mut largest[vote.kind()];
            let square = vote.square(signs).filter(|own| known.is_none_or(|(most, _)| *own > most));
            *known = square.map(|square| (square, vote)).or(*known);
        }
        let chances = largest.iter().flatten().map(|(square, vote)| vote.log_chance(*square));
        chances.fold(0.0, f64::min)
    };
    flips.par_iter().map(least).collect()
}

/// The part of the null distribution that is as extreme as the votes without flips.
fn chance<'v>(null: &[f64], votes: impl Iterator<Item = &'v Vote<'v>>) -> f64 {
    let log_chance = |vote: &Vote| {
        let unchanged = DVector::from_element(vote.scores.nrows(), 1.0);
        vote.square(&unchanged).map_or(0.0, |square| vote.log_chance(square))
    };
    let own = votes.map(log_chance).fold(0.0, f64::min);
    let as_extreme = null.iter().filter(|&&drawn| drawn <= own + 1e-9).count();
    if own < 0.0 { as_extreme.max(1) as f64 / null.len() as f64 } else { 1.0 }
}

fn votes<'a>(screen: &'a Screen, candidates: &[Candidate]) -> Vec<Vote<'a>> {
    screen.directions.iter().filter_map(|it| vote(screen, it, candidates)).collect()
}

/// The votes on one candidate.
fn of<'v, 'a>(votes: &'v [Vote<'a>], candidate: usize) -> impl Iterator<Item = &'v Vote<'a>> {
    votes.iter().filter(move |vote| vote.direction.candidate == candidate)
}

fn vote<'a>(
    screen: &Screen,
    direction: &'a Direction,
    candidates: &[Candidate],
) -> Option<Vote<'a>> {
    let count = direction.columns.len();
    if direction.left < ABSORBED || count > MOST_STRENGTHS || count >= screen.scores.nrows() {
        return None;
    }
    let scores = screen.scores.columns(direction.columns.start, count).into_owned();
    let inverse = (scores.transpose() * &scores).pseudo_inverse(1e-300).ok()?;
    let positive = candidates[direction.candidate].forms[direction.form].positive && count == 1;
    Some(Vote { direction, scores, inverse, positive })
}

/// Signs of the parts: all there are, the unchanged ones first, or a draw that begins with those.
fn flips(parts: usize) -> Vec<DVector<f64>> {
    let sign = |minus: bool| if minus { -1.0 } else { 1.0 };
    if parts <= ALL_FLIPS {
        let all = 0..1usize << parts;
        return all.map(|k| DVector::from_fn(parts, |i, _| sign(k >> i & 1 == 1))).collect();
    }
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut drawn = vec![DVector::from_element(parts, 1.0)];
    drawn.extend((1..DRAWS).map(|_| DVector::from_fn(parts, |_, _| sign(random.random_bool(0.5)))));
    drawn
}
