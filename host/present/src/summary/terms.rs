//! How many exponentials each hold shows, as a table and a plot.

use super::{name_of, unit_of};
use palpate_analysis::terms::Terms;
use palpate_fit::hold::HoldFit;
use palpate_report::number::significant;
use palpate_report::{Axis, Colour, Column, Plot, Series, Table};

/// Most holds whose numbers of exponentials are compared row by row; JSON has them all.
const MOST_COMPARED: usize = 3;

/// The number of exponentials of every hold, and how it came about for the first of them.
pub(super) fn terms_tables(holds: &[(&HoldFit, &Terms)], signal: &str) -> Vec<Table> {
    let mut tables = vec![chosen_table(holds)];
    tables.extend(
        holds.iter().take(MOST_COMPARED).map(|(hold, terms)| comparison_table(hold, terms, signal)),
    );
    let last = tables.pop().unwrap_or_default();
    tables.push(last.note(
        "BIC: Bayesian information criterion. Left out: every other of 14 inner blocks predicted from the rest; forecast: the last third from the first two. Identifiable: no term at a limit, none vanishes or coincides, every share at least two standard errors from 0. R² never falls with more terms and decides nothing; used is the lesser of the least BIC among the identifiable ones and the least number whose left-out error is the best within one standard error.",
    ));
    tables
}

fn chosen_table(holds: &[(&HoldFit, &Terms)]) -> Table {
    let columns = vec![
        Column::text("hold"),
        Column::whole("used"),
        Column::whole("by BIC"),
        Column::whole("by left-out"),
        Column::text("identifiable"),
    ];
    let mut table = Table::new("How many exponentials (appendices A and B)", columns);
    for (hold, terms) in holds {
        table = table.row([
            place(hold),
            terms.decided().to_string(),
            terms.by_criterion.to_string(),
            terms.by_held_out.map_or("–".into(), |number| number.to_string()),
            if terms.best().identified { "yes" } else { "no" }.to_owned(),
        ]);
    }
    table
}

fn comparison_table(hold: &HoldFit, terms: &Terms, signal: &str) -> Table {
    number_table(format!("One to four exponentials: {}", place(hold)), terms, unit_of(signal))
}

/// A row for each number of exponentials; errors in `unit`.
#[must_use]
pub fn number_table(caption: impl Into<String>, terms: &Terms, unit: &str) -> Table {
    let columns = vec![
        Column::whole("n"),
        Column::number("R²", ""),
        Column::number("BIC over the best", ""),
        Column::number("left out", unit),
        Column::number("forecast", unit),
        Column::text("time constants, s"),
        Column::text("identifiable"),
        Column::text(""),
    ];
    let mut table = Table::new(caption, columns);
    let best = terms.rows.iter().map(|row| row.bic).fold(f64::INFINITY, f64::min);
    for row in &terms.rows {
        let number = row.fit.sum.terms.len();
        let constants = row.fit.sum.terms.iter().map(|term| significant(1.0 / term.rate, 3));
        let error = |value: Option<f64>| value.map_or("–".into(), |value| significant(value, 3));
        table = table.row([
            number.to_string(),
            format!("{:.5}", row.fit.r_squared),
            format!("{:.1}", row.bic - best),
            error(row.held_out_rms),
            error(row.forecast_rms),
            constants.collect::<Vec<_>>().join(", "),
            if row.identified { "yes" } else { "no" }.to_owned(),
            marks(terms, number),
        ]);
    }
    table
}

/// Which criteria chose this number.
fn marks(terms: &Terms, number: usize) -> String {
    let said = [
        (terms.by_criterion == number, "BIC"),
        (terms.by_held_out == Some(number), "left-out"),
        (terms.decided() == number, "used"),
    ];
    said.iter().filter(|(said, _)| *said).map(|(_, word)| *word).collect::<Vec<_>>().join(", ")
}

/// Where a hold is.
pub(super) fn place(hold: &HoldFit) -> String {
    format!("{} from {:.2} s", hold.trace, hold.from_s)
}

/// What every number of exponentials leaves, over time (in place of Figs A.1 and B.1, where they cannot
/// be told apart).
pub(super) fn residual_plot(
    hold: &HoldFit,
    terms: &Terms,
    time: &[f64],
    values: &[f64],
    signal: &str,
) -> Plot {
    let since: Vec<f64> = time[hold.range.clone()].iter().map(|t| t - hold.from_s).collect();
    let measured = &values[hold.range.clone()];
    let title = format!("What one to four exponentials leave: {}", place(hold));
    let mut plot = Plot::new(
        title,
        Axis::new("time in the hold", "s"),
        Axis::new(format!("{} less fit", name_of(signal)), unit_of(signal)),
    )
    .summary(
        "Residuals of fits with one to four exponentials, smoothed over fiftieths of the hold",
    );
    for row in &terms.rows {
        let number = row.fit.sum.terms.len();
        let residual: Vec<f64> =
            since.iter().zip(measured).map(|(t, y)| y - row.fit.sum.at(*t)).collect();
        let (x, y) = fiftieths(&since, &residual);
        plot = plot
            .series(Series::line(format!("n = {number}"), x, y).colour(Colour::Hue(number - 1)));
    }
    plot.level(0.0, "")
}

/// Means over fiftieths of the samples.
fn fiftieths(time: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let size = time.len().div_ceil(50).max(1);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    time.chunks(size).map(mean).zip(values.chunks(size).map(mean)).unzip()
}
