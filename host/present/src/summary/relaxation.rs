//! What holds of a displacement show: chapters 3 and 4 and appendix A for one's own data.

use super::holds::{coefficient_table, left_out_words, plot, spread_table, warnings};
use super::terms::{place, residual_plot, terms_tables};
use super::{CONCISE, concise, unit_of};
use palpate_analysis::relaxation::{Hold, Latency, OVER, StrainScale};
use palpate_fit::exponentials::{MOST_TERMS, Parameter};
use palpate_fit::hold::{HoldError, HoldFit, spreads};
use palpate_fit::relaxation_form::Form;
use palpate_report::number::{counted, significant};
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};
use palpate_trace::Trace;

/// Most holds that a report draws one by one.
const MOST_DRAWN: usize = 6;

/// Coefficients, repeats, latency model and number of exponentials of every hold.
#[must_use]
pub fn relaxation_sections(
    holds: &[Hold],
    left_out: &[HoldError],
    traces: &[Trace],
    signal: &str,
) -> Vec<Section> {
    let fits: Vec<HoldFit> = holds.iter().map(|hold| hold.fit.clone()).collect();
    let mut first = Section::new("Relaxation function").table(coefficient_table(&fits, signal));
    for warning in warnings(&fits) {
        first = first.callout(Callout::Warning, "Beware", warning);
    }
    for text in left_out_words(left_out) {
        first = first.callout(Callout::Warning, "Left out", text);
    }
    let spreads = spreads(&fits);
    if !spreads.is_empty() {
        first = first.table(spread_table(&spreads, signal, "mm"));
    }
    let pairs: Vec<_> = holds.iter().map(|hold| (&hold.fit, &hold.terms)).collect();
    let mut number = Section::new("Number of exponentials");
    for table in terms_tables(&pairs, signal) {
        number = number.table(table);
    }
    number = number.callout(Callout::Finding, "Number of exponentials", tally(holds));
    let mut form = Section::new("Form of the relaxation").table(form_table(holds, signal));
    // Holds that say the same are told together.
    let mut alike: Vec<(String, Vec<String>)> = Vec::new();
    for (hold, words) in holds.iter().filter_map(|h| form_in_words(h, signal).map(|w| (h, w))) {
        match alike.iter_mut().find(|(other, _)| *other == words) {
            Some((_, places)) => places.push(place(&hold.fit)),
            None => alike.push((words, vec![place(&hold.fit)])),
        }
    }
    for (words, places) in alike {
        let text = format!("{}: {words}", places.join(", "));
        form = form.callout(Callout::Finding, "Form", text);
    }
    let mut latency = Section::new("Latency model").table(latency_table(holds, signal));
    for hold in holds.iter().filter(|hold| hold.latency.is_none()) {
        let text = format!(
            "{}: where it settles is not significantly different from zero, so there is no equilibrium strain and no latency model. Hold longer, or the specimen flows.",
            place(&hold.fit)
        );
        latency = latency.callout(Callout::Warning, "No equilibrium", text);
    }
    for hold in holds.iter().take(MOST_DRAWN) {
        let Some(trace) = traces.iter().find(|trace| trace.label() == hold.fit.trace) else {
            continue;
        };
        first = first.figure(plot(&hold.fit, trace, signal), "");
        if let Some(values) = trace.column(signal) {
            let plot = residual_plot(&hold.fit, &hold.terms, &trace.time, values, signal);
            number = number.figure(plot, "");
        }
        if let Some(plot) = hold.latency.as_ref().and_then(|l| rate_plot(&hold.fit, l)) {
            latency = latency.figure(plot.0, plot.1);
        }
    }
    vec![first, number, form, latency]
}

/// Every form of every hold, the best first.
fn form_table(holds: &[Hold], signal: &str) -> Table {
    let unit = unit_of(signal);
    let columns = vec![
        Column::text("hold"),
        Column::text("form"),
        Column::whole("numbers"),
        Column::number("residual RMS", unit),
        Column::number("left out", unit),
        Column::text(""),
    ];
    let mut table = Table::new("Which form predicts times that it has not seen", columns);
    for hold in holds {
        let Some(forms) = &hold.forms else { continue };
        for (k, row) in forms.rows.iter().enumerate() {
            table = table.row([
                if k == 0 { place(&hold.fit) } else { String::new() },
                row.form.name(),
                row.numbers.to_string(),
                significant(row.residual_rms, 3),
                row.held_out_rms.map_or("–".into(), |rms| significant(rms, 3)),
                if row.form == forms.chosen { "used" } else { "" }.to_owned(),
            ]);
        }
    }
    table.note("Power law: A + B (1 + t/τ)^(−β). Stretched exponential: A + B e^(−(t/τ)^β). Left out: each half decade of time since the hold began predicted from all others, the last one too: the geometric mean over them. Used: the fewest numbers whose left-out error is no worse than the best by two standard errors over those spans.")
}

/// The form of one hold with its numbers; where the sums end at their ceiling, how wide the spectrum is.
fn form_in_words(hold: &Hold, signal: &str) -> Option<String> {
    let forms = hold.forms.as_ref()?;
    let best = forms.best()?;
    let mut words = best.form.name();
    if let Some(own) = best.parameters {
        words += &format!(
            ", τ = {} s, β = {}, settles at {} {}",
            concise(own.tau.0, own.tau.1),
            concise(own.beta.0, own.beta.1),
            concise(own.settles.0, own.settles.1),
            unit_of(signal)
        );
    }
    let most = hold.terms.rows.last()?;
    if hold.terms.decided() == MOST_TERMS || best.form == Form::Exponentials(MOST_TERMS) {
        let rates = || most.fit.sum.terms.iter().map(|term| 1.0 / term.rate);
        let (least, most) = (rates().fold(f64::INFINITY, f64::min), rates().fold(0.0, f64::max));
        words += &format!(
            ". {MOST_TERMS} exponentials are the most that are tried: their number is no finding; the hold shows a spectrum at least as wide as from {} to {} s",
            significant(least, 3),
            significant(most, 3)
        );
    }
    Some(words + ".")
}

/// How many holds show how many exponentials.
fn tally(holds: &[Hold]) -> String {
    let told = (1..=4).filter_map(|number| {
        let count = holds.iter().filter(|hold| hold.terms.decided() == number).count();
        let least = if number == MOST_TERMS { " or more" } else { "" };
        (count > 0)
            .then(|| format!("{number}{least} in {count} of {}", counted(holds.len(), "hold")))
    });
    let untold = holds.iter().filter(|hold| !hold.terms.best().identified).count();
    let untold = match untold {
        0 => String::new(),
        _ => format!(" In {} not even that one is identifiable.", counted(untold, "hold")),
    };
    format!("Exponentials that the data show: {}.{untold}", told.collect::<Vec<_>>().join(", "))
}

fn latency_table(holds: &[Hold], signal: &str) -> Table {
    let columns = vec![
        Column::text("hold"),
        Column::number("v1", "1/s"),
        Column::number("c0", ""),
        Column::number("settles at", unit_of(signal)),
        Column::number("half", "s"),
        Column::number("99 %", "s"),
        Column::number("ε_e", ""),
        Column::number("R²", ""),
    ];
    let mut table =
        Table::new("Linear latency model: strain rate = −v1 (ε − ε_e) (4.4–4.10)", columns);
    let mut relative = false;
    for hold in holds {
        let Some(latency) = &hold.latency else { continue };
        relative |= latency.scale == StrainScale::OfEquilibrium;
        let error = |parameter| latency.fit.standard_error(parameter);
        let time = |left| latency.time_with_left(left).map_or("–".into(), |t| significant(t, 3));
        table = table.row([
            place(&hold.fit),
            concise(latency.law.rate, error(Parameter::Rate(1))),
            concise(latency.law.constant, error(Parameter::Coefficient(0))),
            concise(latency.settles.0, latency.settles.1),
            time(0.5),
            time(1.0 - OVER),
            significant(latency.law.equilibrium(), 4),
            format!("{:.4}", latency.fit.r_squared),
        ]);
    }
    let table = table.note(format!(
        "Half and 99 % of the way to where it settles. One exponential, so its R² beside that of more says how straight the line of Fig. 4.3 is. {CONCISE}"
    ));
    if relative {
        table.note("Without displacement and height_mm in the head, strain is in units of the equilibrium strain.")
    } else {
        table.note("ε_e is the displacement over height_mm (5.8); compression is negative.")
    }
}

/// Fig. 4.3: strain rate over strain, with the line.
fn rate_plot(hold: &HoldFit, latency: &Latency) -> Option<(Plot, String)> {
    let measured = latency.measured.as_ref()?;
    let of = match latency.scale {
        StrainScale::OfHeight => "strain",
        StrainScale::OfEquilibrium => "strain over equilibrium strain",
    };
    let ends = [latency.law.strain(0.0), latency.law.equilibrium()];
    let line = ends.map(|strain| latency.law.strain_rate_at(strain));
    let plot = Plot::new(
        format!("Strain rate over strain: {}", place(hold)),
        Axis::new(of, ""),
        Axis::new("strain rate", "1/s"),
    )
    .summary("Measured strain rate over strain, with the straight line of the linear latency model")
    .series(
        Series::points("measured", &measured.smoothed[..], &measured.slope[..])
            .colour(Colour::MEASURED),
    )
    .series(Series::line("linear latency model (4.7)", ends, line).colour(Colour::MODEL))
    .mark(latency.law.equilibrium(), "ε_e");
    Some((plot, super::bandwidth_words(measured)))
}
