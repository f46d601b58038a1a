//! How many exponentials a hold shows: fit, information criterion and error on samples left out, side by
//! side (appendices A and B).

use palpate_fit::exponentials::{Error, Fit, Options, Prepared, most_terms};

/// Blocks into which a hold is cut; every other inner one is left out, then the rest of the inner ones. The
/// first and the last always stay: what lies beyond the samples is the forecast's question.
const BLOCKS: usize = 16;
/// Share of the samples from which the rest is forecast.
const FIRST: f64 = 2.0 / 3.0;

/// One number of exponentials.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The fit to the whole hold.
    pub fit: Fit,
    /// Bayesian information criterion; the smaller the better.
    pub bic: f64,
    /// Whether the data tell every term.
    pub identified: bool,
    /// Root mean square error on blocks that the fit did not see, in the unit of the signal.
    pub held_out_rms: Option<f64>,
    /// Root mean square error on the last third when the first two were fitted.
    pub forecast_rms: Option<f64>,
}

/// Fits with one to four exponentials, and what decides between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// A row for each number of terms, from 1.
    pub rows: Vec<Row>,
    /// Number with the least criterion among those whose every term is identifiable.
    pub by_criterion: usize,
    /// Least number whose error on left-out blocks is that of the best within one standard error.
    pub by_held_out: Option<usize>,
}

impl Terms {
    /// The number to use: the lesser of the two, for a term has to pass both.
    #[must_use]
    pub fn decided(&self) -> usize {
        self.by_held_out.map_or(self.by_criterion, |other| other.min(self.by_criterion))
    }

    /// The fit with that number.
    #[must_use]
    pub fn best(&self) -> &Row {
        &self.rows[self.decided() - 1]
    }
}

/// Fits one to four exponentials (as many as the samples allow) to a hold.
///
/// # Errors
/// As [`Prepared::fit`].
pub fn terms(time: &[f64], values: &[f64], options: &Options) -> Result<Terms, Error> {
    let most = most_terms(time.len()).max(1);
    let options = Options { terms: most, ..options.clone() };
    let prepared = Prepared::new(time, &options)?;
    let (slowest, fastest) = prepared.rate_limits();
    let same = Options { slowest: Some(slowest), fastest: Some(fastest), ..options };
    let compared = prepared.compare_terms(values)?.allowing_for_correlation(time, values);
    let squares = held_out(time, values, &same);
    let forecasts = forecasts(time, values, &same);
    let rows: Vec<Row> = compared
        .rows
        .into_iter()
        .enumerate()
        .map(|(index, row)| Row {
            held_out_rms: squares.get(index).map(|blocks| mean(blocks).sqrt()),
            forecast_rms: forecasts.get(index).copied().flatten(),
            fit: row.fit,
            bic: row.bic,
            identified: row.identified,
        })
        .collect();
    Ok(Terms { by_criterion: compared.chosen, by_held_out: least_as_good(&squares), rows })
}

/// Mean squared error of every block, left out of the fit, for each number of terms; empty where the
/// samples are too few.
fn held_out(time: &[f64], values: &[f64], options: &Options) -> Vec<Vec<f64>> {
    let block = |k: usize| k * BLOCKS / time.len();
    let inner = |block: usize| (1..BLOCKS - 1).contains(&block);
    let without = |parity: usize| {
        // A weight of 0 leaves a sample out, and time still counts from the first one.
        let left_out = |k: usize| inner(block(k)) && block(k) % 2 == parity;
        let weights: Vec<f64> =
            (0..time.len()).map(|k| if left_out(k) { 0.0 } else { 1.0 }).collect();
        Prepared::weighted(time, &weights, options).ok()?.compare_terms(values).ok()
    };
    let (Some(without_even), Some(without_odd)) = (without(0), without(1)) else {
        return Vec::new();
    };
    let squares = |(without_even, without_odd): (&Fit, &Fit)| {
        let mut sums = vec![(0.0, 0.0); BLOCKS];
        for (k, (t, y)) in time.iter().zip(values).enumerate().filter(|(k, _)| inner(block(*k))) {
            let fit = if block(k) % 2 == 0 { without_even } else { without_odd };
            let sum = &mut sums[block(k)];
            *sum = (sum.0 + (y - fit.sum.at(t - time[0])).powi(2), sum.1 + 1.0);
        }
        sums.into_iter().filter(|sum| sum.1 > 0.0).map(|sum| sum.0 / sum.1).collect()
    };
    let rows = without_even.rows.iter().zip(&without_odd.rows);
    rows.map(|(even, odd)| squares((&even.fit, &odd.fit))).collect()
}

/// Error on the last third of what the first two thirds say, for each number of terms that they allow.
fn forecasts(time: &[f64], values: &[f64], options: &Options) -> Vec<Option<f64>> {
    let cut = (FIRST * time.len() as f64) as usize;
    let ((seen, later), (seen_values, later_values)) = (time.split_at(cut), values.split_at(cut));
    let most = options.terms.min(most_terms(cut));
    let Ok(prepared) = Prepared::new(seen, &Options { terms: most, ..options.clone() }) else {
        return Vec::new();
    };
    let error = |fit: Fit| {
        let later = later.iter().zip(later_values);
        let squares: Vec<f64> = later.map(|(t, y)| (y - fit.sum.at(t - time[0])).powi(2)).collect();
        (!squares.is_empty()).then(|| mean(&squares).sqrt())
    };
    let fits = (1..=most).map(|terms| prepared.fit_terms(seen_values, terms));
    fits.map(|fit| fit.ok().and_then(error)).collect()
}

/// Least number of terms whose blocks are no worse than the best's by more than one standard error.
fn least_as_good(squares: &[Vec<f64>]) -> Option<usize> {
    let best = squares.iter().min_by(|a, b| mean(a).total_cmp(&mean(b)))?;
    let worse = |blocks: &[f64]| {
        let excess: Vec<f64> = blocks.iter().zip(best).map(|(a, b)| a - b).collect();
        let (middle, count) = (mean(&excess), excess.len() as f64);
        let scatter = excess.iter().map(|e| (e - middle).powi(2)).sum::<f64>() / (count - 1.0);
        middle > (scatter / count).sqrt()
    };
    squares.iter().position(|blocks| !worse(blocks)).map(|index| index + 1)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;

    /// A hold of 4.3 s at 200 Hz with these shares and rates, and noise.
    fn hold(parts: &[(f64, f64)], noise: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, noise).unwrap();
        (0..860)
            .map(|k| f64::from(k) / 200.0)
            .map(|t| {
                let sum: f64 = parts.iter().map(|(share, rate)| share * (-rate * t).exp()).sum();
                (t, 1.0 + sum + normal.sample(&mut random))
            })
            .unzip()
    }

    #[test]
    fn both_criteria_find_how_many_there_are() {
        for seed in 0..6 {
            let (time, values) = hold(&[(0.8, 1.2)], 0.01, seed);
            assert_eq!(terms(&time, &values, &Options::default()).unwrap().decided(), 1);
            let (time, values) = hold(&[(0.48, 3.7), (0.51, 0.51)], 0.005, seed);
            let found = terms(&time, &values, &Options::default()).unwrap();
            assert_eq!(
                found.decided(),
                2,
                "seed {seed}: {:?} {:?}",
                found.by_criterion,
                found.by_held_out
            );
            let rms = found.rows[1].held_out_rms.unwrap();
            assert!((rms / 0.005 - 1.0).abs() < 0.1, "{rms}");
            assert!(found.rows[0].held_out_rms.unwrap() > 2.0 * rms);
        }
    }

    #[test]
    fn a_few_samples_are_fitted_with_few_terms() {
        let time = [0.0, 1.0, 2.0, 3.0, 4.0];
        let found = terms(&time, &[2.0, 1.5, 1.2, 1.1, 1.05], &Options::default()).unwrap();
        assert_eq!(found.rows.len(), 1);
        assert_eq!(found.by_held_out, None);
    }
}
