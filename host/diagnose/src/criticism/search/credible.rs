//! The names that the data do not tell apart, by drawing their blocks anew.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::{DECISIVE, Rival};
use palpate_fit::problem::Problem;

/// Resamplings of the blocks.
pub const RESAMPLES: usize = 200;
/// Part of the resamplings that a single name must win.
const WIN_SHARE: f64 = 0.9;
/// Part of the resamplings that a credible set must hold.
const SET_SHARE: f64 = 0.975;

/// How often each rival is best when the blocks of the data are drawn anew.
pub(super) fn resample(problem: &Problem, rivals: &mut [Rival], seed: u64) {
    let Some(first) = rivals.first() else { return };
    let blocks = first.fitted.blocks.len();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let draws: Vec<Vec<f64>> = (0..RESAMPLES)
        .map(|_| {
            let mut weights = vec![0.0; blocks];
            for _ in 0..blocks {
                weights[random.random_range(0..blocks)] += 1.0;
            }
            weights
        })
        .collect();
    let best = |weights: &Vec<f64>| {
        let criteria: Vec<f64> =
            rivals.iter().map(|rival| rival.fitted.weighted_bic(problem, weights)).collect();
        (0..criteria.len()).min_by(|&a, &b| criteria[a].total_cmp(&criteria[b])).unwrap_or(0)
    };
    let winners: Vec<usize> = draws.par_iter().map(best).collect();
    for (index, rival) in rivals.iter_mut().enumerate() {
        let wins = winners.iter().filter(|&&winner| winner == index).count();
        rival.won = wins as f64 / RESAMPLES as f64;
    }
}

/// The names that the data do not tell apart: one alone if it wins nearly always and by far.
pub(super) fn credible(effect: &str, rivals: &[Rival]) -> Vec<String> {
    let Some(best) = rivals.first() else { return vec![effect.to_owned()] };
    let close = |rival: &&Rival| rival.fitted.bic() - best.fitted.bic() < DECISIVE;
    let near = rivals.iter().filter(close).count();
    let mut by_wins: Vec<&Rival> = rivals.iter().collect();
    by_wins.sort_by(|a, b| b.won.total_cmp(&a.won));
    let mut set: Vec<String> = vec![effect.to_owned()];
    set.extend(rivals.iter().filter(close).map(|rival| rival.effect.clone()));
    let own = rivals.iter().find(|rival| rival.effect == effect).map_or(0.0, |rival| rival.won);
    if near > 1 || own < WIN_SHARE {
        let mut covered = 0.0;
        for rival in by_wins {
            if covered >= SET_SHARE {
                break;
            }
            covered += rival.won;
            set.push(rival.effect.clone());
        }
    }
    let mut unique: Vec<String> = Vec::new();
    for name in set {
        if !unique.contains(&name) {
            unique.push(name);
        }
    }
    unique
}
