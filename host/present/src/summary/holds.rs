//! Relaxation during holds, as tables and plots: Tables 3.1–3.4 and A.1 for one's own data.

use super::{CONCISE, concise, name_of, unit_of};
use palpate_analysis::regions::{numeral, type_name};
use palpate_fit::exponentials::{Correlated, Fit, Parameter};
use palpate_fit::hold::{HoldError, HoldFit, Spread, spreads};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::Trace;

/// Most holds that a report draws one by one.
const MOST_DRAWN: usize = 12;

/// The coefficients of every hold, their spread over repeats, and plots.
#[must_use]
pub fn hold_sections(
    fits: &[HoldFit],
    left_out: &[HoldError],
    traces: &[Trace],
    signal: &str,
) -> Vec<Section> {
    let mut section =
        Section::new("Relaxation during the holds").table(coefficient_table(fits, signal));
    for warning in warnings(fits) {
        section = section.callout(Callout::Warning, "Beware", warning);
    }
    for text in left_out_words(left_out) {
        section = section.callout(Callout::Warning, "Left out", text);
    }
    let spreads = spreads(fits);
    if !spreads.is_empty() {
        section = section.table(spread_table(&spreads, signal, "mm"));
    }
    let candidates: Vec<&HoldFit> = fits.iter().filter(|hold| hold.candidates.len() > 1).collect();
    for hold in candidates {
        section = section.table(candidate_table(hold, signal));
    }
    for hold in fits.iter().take(MOST_DRAWN) {
        if let Some(trace) = traces.iter().find(|trace| trace.label() == hold.trace) {
            section = section.figure(plot(hold, trace, signal), "");
        }
    }
    vec![section]
}

/// Why holds could not be fitted, one sentence each.
pub(super) fn left_out_words(left_out: &[HoldError]) -> Vec<String> {
    left_out.iter().map(ToString::to_string).collect()
}

/// The coefficients of every hold.
pub(super) fn coefficient_table(fits: &[HoldFit], signal: &str) -> Table {
    let most = fits.iter().map(|hold| hold.fit.sum.terms.len()).max().unwrap_or(0);
    let coefficients = std::iter::once(Parameter::Scale)
        .chain((0..=most).map(Parameter::Coefficient))
        .chain((1..=most).map(Parameter::Rate));
    let columns = [
        Column::text("trace"),
        Column::number("from", "s"),
        Column::number("at", "mm"),
        Column::text("type"),
    ]
    .into_iter()
    .chain(coefficients.clone().map(|coefficient| {
        Column::number(coefficient.to_string(), coefficient_unit(coefficient, signal))
    }))
    .chain([Column::number("R²", "")])
    .collect();
    let mut table = Table::new("Relaxation function of each hold (eq. 3.4)", columns);
    for hold in fits {
        let place = hold.displacement.map_or("–".into(), |x| significant(x, 3));
        let cells = coefficients.clone().map(|coefficient| {
            hold.fit
                .value(coefficient)
                .map_or("–".into(), |value| concise(value, hold.fit.standard_error(coefficient)))
        });
        let from = format!("{:.2}", hold.from_s);
        let head = [hold.trace.clone(), from, place, numeral(hold.relaxation).into()];
        let tail = [format!("{:.4}", hold.fit.r_squared)];
        table = table.row(head.into_iter().chain(cells).chain(tail));
    }
    table.note(format!(
        "N is the signal at the start of the hold. {CONCISE} {}",
        errors_in_words(fits.iter().map(|hold| &hold.fit))
    ))
}

/// What the standard errors allow for.
fn errors_in_words<'a>(fits: impl Iterator<Item = &'a Fit>) -> String {
    let correlated: Vec<&Correlated> = fits.filter_map(|fit| fit.correlated.as_ref()).collect();
    let most =
        |value: fn(&Correlated) -> f64| correlated.iter().map(|it| value(it)).fold(0.0, f64::max);
    if correlated.is_empty() {
        return "The standard errors are those of white noise.".into();
    }
    format!(
        "The standard errors allow for the correlation of residuals with their neighbours (up to {:.2}) and are up to {} times those of white noise.",
        most(|correlated| correlated.neighbours),
        significant(most(|correlated| correlated.inflation), 2)
    )
}

/// What is said of a fit that explains nothing.
pub const NO_BETTER: &str = "not converged: no better than a constant";

/// The unit of a coefficient of a signal.
pub(super) fn coefficient_unit(parameter: Parameter, signal: &str) -> &str {
    match parameter {
        Parameter::Scale => unit_of(signal),
        Parameter::Coefficient(_) => "",
        Parameter::Rate(_) => "1/s",
    }
}

/// Mean and scatter over repeats; `unit` is that of what was held.
pub(super) fn spread_table(spreads: &[Spread], signal: &str, unit: &str) -> Table {
    let columns = vec![
        Column::text("at"),
        Column::text("coefficient"),
        Column::whole("holds"),
        Column::number("mean", ""),
        Column::number("standard deviation", ""),
        Column::number("from noise alone", ""),
        Column::text("unit"),
        Column::number("χ² per degree", ""),
        Column::text("p"),
    ];
    let mut table = Table::new("Over the repeats (Table 3.4)", columns);
    for spread in spreads {
        let level = spread.level.map_or("–".into(), |x| format!("{} {unit}", significant(x, 3)));
        let test = spread.consistency;
        table = table.row([
            format!("{level}, {}", type_name(spread.relaxation)),
            spread.parameter.to_string(),
            spread.holds.to_string(),
            significant(spread.mean, 4),
            significant(spread.deviation, 3),
            spread.expected.map_or("–".into(), |expected| significant(expected, 3)),
            coefficient_unit(spread.parameter, signal).to_owned(),
            test.map_or("–".into(), |test| {
                significant(test.chi_square / test.degrees_of_freedom as f64, 3)
            }),
            test.map_or("–".into(), |test| chance(test.p_value)),
        ]);
    }
    table.note(
        "Sample standard deviation (n − 1). p: the chance of so much scatter from the standard errors alone; below 0.01 the repeats differ by more than noise.",
    )
}

/// A p value in print.
pub(super) fn chance(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".into() } else { significant(p, 2) }
}

fn candidate_table(hold: &HoldFit, signal: &str) -> Table {
    let unit = unit_of(signal);
    let columns = vec![
        Column::whole("exponentials"),
        Column::number("residual RMS", unit),
        Column::number("R²", ""),
        Column::number("BIC over the best", ""),
        Column::text("identified"),
        Column::text("time constants, s"),
        Column::text("notes"),
    ];
    let title =
        format!("How many exponentials: {} from {:.2} s (appendix A)", hold.trace, hold.from_s);
    let mut table = Table::new(title, columns);
    let best = hold.candidates.iter().map(|row| row.bic).fold(f64::INFINITY, f64::min);
    for row in &hold.candidates {
        let fit = &row.fit;
        let constants = fit.sum.terms.iter().map(|term| significant(1.0 / term.rate, 4));
        let notes = fit.notes.iter().map(ToString::to_string);
        table = table.row([
            fit.sum.terms.len().to_string(),
            significant(fit.residual_rms, 4),
            format!("{:.5}", fit.r_squared),
            format!("{:.1}", row.bic - best),
            if row.identified { "yes" } else { "no" }.to_owned(),
            constants.collect::<Vec<_>>().join(", "),
            notes.collect::<Vec<_>>().join("; "),
        ]);
    }
    table.note(format!(
        "Chosen: {}, the least BIC (Bayesian information criterion) among those whose every term is identifiable.",
        hold.fit.sum.terms.len()
    ))
}

/// What to beware of, each remark with its hold.
pub fn warnings(fits: &[HoldFit]) -> Vec<String> {
    fits.iter()
        .flat_map(|hold| {
            let place = format!("{} from {:.2} s", hold.trace, hold.from_s);
            let useless = (!hold.fit.explains()).then(|| format!(
                "{place}: the fit is no better than a constant (R² {:.4}): nothing relaxes beyond the scatter, or a single sample outweighs all others",
                hold.fit.r_squared
            ));
            let notes = hold.fit.notes.iter().map(move |note| format!("{place}: {note}"));
            useless.into_iter().chain(notes)
        })
        .collect()
}

/// A hold as measured and fitted over the logarithm of time, which shows the fast and the slow part alike, and what the fit leaves.
pub(super) fn plot(hold: &HoldFit, trace: &Trace, signal: &str) -> Panels {
    let measured = trace.column(signal).map_or(&[][..], |values| &values[hold.range.clone()]);
    // A logarithm has no zero: the first sample of a hold is not drawn.
    let since = trace.time[hold.range.clone()].iter().map(|time| time - hold.from_s);
    let (time, measured): (Vec<f64>, Vec<f64>) =
        since.zip(measured).filter(|(time, _)| *time > 0.0).unzip();
    let residual: Vec<f64> =
        time.iter().zip(&measured).map(|(time, y)| y - hold.fit.sum.at(*time)).collect();
    let first = time.first().copied().unwrap_or(hold.duration_s);
    let fitted = smooth(&hold.fit, (first, hold.duration_s));
    let title = format!("{}: {} from {:.2} s", hold.trace, type_name(hold.relaxation), hold.from_s);
    let settled = hold.fit.sum.scale * hold.fit.sum.constant;
    let axis = || Axis::new("time in the hold", "s").log();
    let above = Plot::new("", axis(), Axis::new(name_of(signal), unit_of(signal)))
        .series(Series::points("measured", &time[..], measured).colour(Colour::MEASURED))
        .series(Series::line("eq. 3.4", fitted.0, fitted.1).colour(Colour::MODEL).width(1.8))
        .level(settled, "where it settles")
        .height(180.0);
    let below = Plot::new("", axis(), Axis::new("residual", unit_of(signal)))
        .series(Series::points("measured − fitted", time, residual).colour(Colour::RESIDUAL))
        .level(0.0, "")
        .height(105.0);
    let summary = format!(
        "Measured and fitted {} over a hold of {:.2} s, and what the fit leaves; R² {:.4}",
        name_of(signal),
        hold.duration_s,
        hold.fit.r_squared
    );
    Panels::new(title).summary(summary).plot(above).plot(below)
}

/// The fitted function at 200 instants, as dense at every decade.
fn smooth(fit: &Fit, (from, to): (f64, f64)) -> (Vec<f64>, Vec<f64>) {
    let at = |k: u32| from * (to / from).powf(f64::from(k) / 200.0);
    (0..=200).map(at).map(|time| (time, fit.sum.at(time))).unzip()
}
