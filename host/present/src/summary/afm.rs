//! Force curves of a tip: what they say of the specimen.

use super::{CONCISE, concise, estimate};
use palpate_contact::Tip;
use palpate_contact::afm::curve::ForceCurve;
use palpate_contact::afm::fit::{CurveFit, Held, Options, Retreat, TERMS};
use palpate_contact::afm::hold::{Latency, Relaxed};
use palpate_contact::afm::pressure::modulus_factor;
use palpate_contact::afm::rough::{Rough, Spread, Spreads, Trial};
use palpate_contact::afm::{AfmError, Estimate};
use palpate_contact::grasp::PressureLaw;
use palpate_report::number::{engineering, significant};
use palpate_report::{Axis, Callout, Colour, Column, Legend, Panels, Plot, Section, Series, Table};

/// A curve with its fit, or why there is none.
pub type FittedCurve = (ForceCurve, Result<CurveFit, AfmError>);

/// Most curves that a report draws one by one.
const MOST_DRAWN: usize = 12;

fn scaled(found: Estimate, factor: f64) -> String {
    concise(found.value * factor, Some(found.standard_error * factor))
}

/// All curves in one table, what is to be said of each, and figures.
#[must_use]
pub fn afm_sections(curves: &[FittedCurve], options: &Options) -> Vec<Section> {
    let mut section =
        Section::new("Force curves").paragraph(tip_in_words(options)).table(table(curves));
    for (curve, fit) in curves {
        let mut points = curve.notes.clone();
        match fit {
            Ok(fit) => points.extend(curve_remarks(fit)),
            Err(error) => {
                section = section.callout(Callout::Warning, "Not analysed", error.to_string());
            }
        }
        let points = points.iter().map(|point| format!("{}: {point}", curve.label)).collect();
        section = section.block(palpate_report::Block::List(points));
    }
    for (curve, fit) in curves {
        let Ok(fit) = fit else { continue };
        if !fit.relaxation.is_empty() {
            section = section.table(relaxation_table(&curve.label, fit));
        }
        for held in &fit.holds {
            if let Ok(relaxed) = &held.relaxed {
                section = section.table(hold_table(&hold_name(curve, fit, held), relaxed));
            }
        }
    }
    let fitted = curves.iter().filter_map(|(curve, fit)| Some((curve, fit.as_ref().ok()?)));
    for (curve, fit) in fitted.take(MOST_DRAWN) {
        section = section.figure(curve_figure(curve, fit), curve.label.clone());
        for held in &fit.holds {
            if let Ok(relaxed) = &held.relaxed {
                section = section.figure(hold_figure(relaxed), hold_name(curve, fit, held));
            }
        }
    }
    vec![section]
}

/// The curve's name, and which of its pauses it is where there are several.
fn hold_name(curve: &ForceCurve, fit: &CurveFit, held: &Held) -> String {
    match fit.holds.len() {
        1 => curve.label.clone(),
        _ => format!("{} from {} s", curve.label, significant(curve.time_s[held.range.start], 4)),
    }
}

fn tip_in_words(options: &Options) -> String {
    let shape = match options.tip {
        Tip::Paraboloid { radius_m } => format!("paraboloid of radius {} nm", radius_m * 1e9),
        Tip::Sphere { radius_m } => format!("sphere of radius {} nm", radius_m * 1e9),
        Tip::Cone { half_angle_rad } => {
            format!("cone of half angle {}°", significant(half_angle_rad.to_degrees(), 4))
        }
    };
    let mut words = format!("Tip: {shape}. Poisson's ratio {}.", options.poisson_ratio);
    if options.pressure != PressureLaw::HERTZ {
        words += &format!(
            " Pressure with exponent k = {}: the modulus is {} times that of Hertz's law.",
            options.pressure.exponent(),
            significant(modulus_factor(options.pressure), 4)
        );
    }
    words
}

fn table(curves: &[FittedCurve]) -> Table {
    let columns = vec![
        Column::text("curve"),
        Column::number("modulus", "kPa"),
        Column::number("that remains", "kPa"),
        Column::number("contact", "nm"),
        Column::number("depth", "nm"),
        Column::number("force", "nN"),
        Column::number("pull-off", "nN"),
        Column::number("noise", "pN"),
        Column::number("left by the fit", "pN"),
    ];
    let mut table = Table::new("Force curves of a tip", columns);
    for (curve, fit) in curves {
        let Ok(fit) = fit else { continue };
        let pull = match &fit.retreat {
            Some(retreat) if retreat.adheres => significant(retreat.pull_off_n * 1e9, 3),
            Some(_) => "none".into(),
            None => "–".into(),
        };
        table = table.row([
            curve.label.clone(),
            fit.modulus_pa.map_or("–".into(), |modulus| scaled(modulus, 1e-3)),
            fit.equilibrium_modulus_pa.map_or("–".into(), |modulus| scaled(modulus, 1e-3)),
            scaled(fit.contact_m, 1e9),
            significant(fit.depth_m * 1e9, 3),
            significant(fit.force_n * 1e9, 3),
            pull,
            significant(fit.noise_n * 1e12, 3),
            significant(fit.residual_rms_n * 1e12, 3),
        ]);
    }
    table.note("In parentheses: the standard error in units of the last digits, without those of spring constant, sensitivity and tip. Modulus: at once, before anything relaxes; that remains after all has. Contact: on the piezo's way, as recorded.")
}

/// What is to be said of a fit.
pub(crate) fn curve_remarks(fit: &CurveFit) -> Vec<String> {
    let mut remarks = Vec::new();
    if let Some(why) = &fit.no_modulus {
        remarks.push(format!("no modulus: {why}"));
    }
    if fit.residual_rms_n > 2.0 * fit.noise_n {
        remarks.push(format!(
            "the fit leaves {} times the noise: the law is not that of this contact, or it changes on the way",
            significant(fit.residual_rms_n / fit.noise_n, 2)
        ));
    }
    if let Tip::Paraboloid { radius_m } = fit.law.tip
        && fit.depth_m > 0.3 * radius_m
        && fit.modulus_pa.is_some()
    {
        remarks.push("deeper than 0.3 radii: if the tip is a ball, give --shape sphere".into());
    }
    if let Some(pull) = fit.approach_pull_n {
        remarks.push(format!("a jump into contact of {} nN", scaled(pull, 1e9)));
    }
    if let Some(retreat) = &fit.retreat {
        remarks.push(match (retreat.adheres, fit.follows_back) {
            (_, true) => "the way back is fitted with the rest (Ting)".into(),
            _ => "the tip adheres on the way back: of it only the baseline is fitted".to_owned(),
        });
    }
    if fit.relaxation.len() == TERMS {
        remarks.push(format!(
            "{TERMS} exponentials are the most that are tried: the specimen relaxes in a spectrum that is at least so wide"
        ));
    }
    if fit.left_out > 0 {
        remarks.push(format!("{} outliers of the baseline were left out", fit.left_out));
    }
    remarks.extend(fit.retreat.as_ref().and_then(adhesion));
    for held in &fit.holds {
        if let Err(why) = &held.relaxed {
            remarks.push(format!("a hold is not fitted: {why}"));
        }
    }
    remarks
}

fn adhesion(retreat: &Retreat) -> Option<String> {
    let (dmt, jkr) = retreat.work_dmt.zip(retreat.work_jkr)?;
    let (dmt, jkr) = (significant(dmt * 1e6, 3), significant(jkr * 1e6, 3));
    let energy = engineering(retreat.energy_j, "J", 2);
    Some(match retreat.tabor {
        Some(number) if number < 0.1 => {
            format!(
                "work of adhesion {dmt} µJ/m² (DMT: Tabor's number is below 0.1); the pull takes {energy}"
            )
        }
        Some(number) if number > 5.0 => format!(
            "work of adhesion {jkr} µJ/m² (JKR: Tabor's number is {}); the pull takes {energy}",
            significant(number, 2)
        ),
        _ => format!(
            "work of adhesion between {dmt} (DMT) and {jkr} µJ/m² (JKR); the pull takes {energy}"
        ),
    })
}

/// The relaxation function that the whole curve tells.
fn relaxation_table(label: &str, fit: &CurveFit) -> Table {
    let columns = vec![
        Column::number("share of the modulus", ""),
        Column::number("rate", "1/s"),
        Column::number("time constant", "s"),
    ];
    let mut table = Table::new(format!("Relaxation of {label}, from the whole curve"), columns);
    for term in &fit.relaxation {
        table = table.row([
            scaled(term.share, 1.0),
            scaled(term.rate, 1.0),
            significant(1.0 / term.rate.value, 3),
        ]);
    }
    table.note(CONCISE)
}

fn hold_table(label: &str, held: &Relaxed) -> Table {
    let columns = vec![
        Column::text("model"),
        Column::text("parameters"),
        Column::number("left", "% of the start"),
    ];
    let sum = &held.exponentials.sum;
    let mut words = format!("c0 {}", significant(sum.constant, 3));
    for (k, term) in sum.terms.iter().enumerate() {
        words += &format!(
            ", c{} {} at {} 1/s",
            k + 1,
            significant(term.coefficient, 3),
            significant(term.rate, 3)
        );
    }
    let force_rms = held.exponentials.residual_rms / sum.scale.abs() * 100.0;
    let latency = |latency: &Latency| {
        format!(
            "n {}, ν {} 1/s, εe {}",
            latency.order,
            estimate(latency.rate.value, Some(latency.rate.standard_error)),
            estimate(latency.equilibrium.value, Some(latency.equilibrium.standard_error))
        )
    };
    let percent = |latency: &Latency| significant(latency.rms * 100.0, 2);
    Table::new(format!("The hold of {label}"), columns)
        .row(["force, two exponentials (3.4)".into(), words, significant(force_rms, 2)])
        .row(["strain, linear latency (4.9)".into(), latency(&held.linear), percent(&held.linear)])
        .row(["strain, power latency (7.2)".into(), latency(&held.power), percent(&held.power)])
        .note("Strain: the depth that the force needs, over that at the start of the hold.")
}

fn curve_figure(curve: &ForceCurve, fit: &CurveFit) -> Panels {
    let x = || Axis::new("Way of the piezo beyond the contact", "nm");
    let way = |i: usize| (curve.piezo_m[i] - fit.contact_m.value) * 1e9;
    let series = |name: &str, range: std::ops::Range<usize>| {
        let (x, y): (Vec<f64>, Vec<f64>) =
            range.map(|i| (way(i), (curve.force_n[i] - fit.baseline_n[i]) * 1e9)).unzip();
        Series::points(name, x, y)
    };
    let approach = curve.segments.approach.clone();
    let all = 0..curve.time_s.len();
    let (at, fitted): (Vec<f64>, Vec<f64>) =
        all.clone().filter_map(|i| Some((way(i), fit.contact_n[i]? * 1e9))).unzip();
    let left = |i: usize| Some((curve.force_n[i] - fit.baseline_n[i] - fit.contact_n[i]?) * 1e12);
    let rest: Vec<f64> = all.filter_map(left).collect();
    let mut plot = Plot::new("", x(), Axis::new("Force", "nN"))
        .series(series("approach", approach).colour(Colour::Muted));
    if let Some(range) = curve.segments.retract.clone() {
        plot = plot.series(series("retreat", range).colour(Colour::Hue(1)));
    }
    plot = plot.series(Series::line("fit", &at[..], fitted).colour(Colour::Hue(0)));
    Panels::new("A force curve")
        .summary("Force over the way of the piezo, with the fitted law, and what the fit leaves")
        .plot(plot.mark(0.0, "contact"))
        .plot(
            Plot::new("", x(), Axis::new("Left", "pN"))
                .series(Series::points("left", at, rest))
                .legend(Legend::Hidden)
                .height(110.0),
        )
}

/// The strain of a hold with both latency models.
pub(crate) fn hold_figure(held: &Relaxed) -> Plot {
    let (time, strain): (Vec<f64>, Vec<f64>) = held.strain.iter().copied().unzip();
    let model = |latency: &Latency| time.iter().map(|t| latency.at(*t)).collect::<Vec<f64>>();
    let (linear, power) = (model(&held.linear), model(&held.power));
    Plot::new("The hold", Axis::new("Time", "s"), Axis::new("Strain over that at the start", ""))
        .summary("Strain during the hold with the linear and the power-law latency model")
        .series(Series::points("measured", &time[..], strain).colour(Colour::Muted))
        .series(Series::line("linear latency", &time[..], linear).colour(Colour::Hue(1)))
        .series(
            Series::line(format!("latency, n = {}", held.power.order), &time[..], power)
                .colour(Colour::Hue(0)),
        )
}

/// What a rough surface does, in words, as a table and as a figure.
#[must_use]
pub fn rough_sections(rough: &Rough, trials: &[Trial], spreads: &Spreads) -> Vec<Section> {
    let columns = vec![
        Column::text("figure"),
        Column::number("mean", ""),
        Column::number("deviation", ""),
        Column::number("5 %", ""),
        Column::number("95 %", ""),
    ];
    let row = |name: &str, spread: Spread, factor: f64| {
        [
            name.to_owned(),
            significant(spread.mean * factor, 4),
            significant(spread.deviation * factor, 3),
            significant(spread.middle.0 * factor, 3),
            significant(spread.middle.1 * factor, 3),
        ]
    };
    let table = Table::new(format!("{} places of a rough surface", trials.len()), columns)
        .row(row("apparent modulus over the true one", spreads.modulus_ratio, 1.0))
        .row(row("contact point above the mean surface (nm)", spreads.contact_m, 1e9))
        .row(row("asperities that bear", spreads.touching, 1.0));
    let words = format!(
        "Heights of {} nm RMS, {} asperities per µm² of radius {} nm, under a tip of radius {} nm, to the force that a smooth specimen bears at {} nm.",
        significant(rough.rms_m * 1e9, 4),
        significant(rough.density_per_m2 * 1e-12, 4),
        significant(rough.asperity_m * 1e9, 4),
        significant(rough.radius_m * 1e9, 4),
        significant(rough.depth_m * 1e9, 4),
    );
    vec![
        Section::new("A rough surface")
            .paragraph(words)
            .table(table)
            .figure(rough_figure(trials), "One point for each place."),
    ]
}

fn rough_figure(trials: &[Trial]) -> Plot {
    let (contact, ratio): (Vec<f64>, Vec<f64>) =
        trials.iter().map(|trial| (trial.contact_m * 1e9, trial.modulus_ratio)).unzip();
    let x = Axis::new("Apparent contact point above the mean surface", "nm");
    Plot::new(
        "What a rough surface makes of one specimen",
        x,
        Axis::new("Apparent modulus over the true one", ""),
    )
    .summary("Apparent modulus over apparent contact point at many places of a rough surface")
    .series(Series::points("places", contact, ratio))
    .level(1.0, "smooth")
}
