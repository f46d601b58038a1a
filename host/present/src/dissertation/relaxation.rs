//! Chapter 3: relaxation of grasped sushi. Tables 3.1–3.4, eqs 3.5–3.10, inertia.

use super::comparison::decimals;
use super::grasp_courses;
use super::{
    Chapter, Check, Comparison, EQUATION_3_5, Evidence, RelaxationRow, Statistic, TABLE_3_1,
    TABLE_3_2, TABLE_3_3, TABLE_3_4,
};
use crate::bundled::grasps;
use palpate_analysis::cycles::segment;
use palpate_fit::exponentials::Parameter;
use palpate_fit::hold::{HoldFit, Spread, Terms, fit_holds, spreads};
use palpate_fit::ranks::kruskal_wallis;
use palpate_fit::welch::{Repeats, welch};
use palpate_model::EQUATION_3_6;
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};
use palpate_trace::{FORCE, Trace};

/// Standard errors within which a refitted value must lie.
const ERRORS: f64 = 4.0;
/// Moving mass of the gripper, g (3.3.1).
const MASS_G: f64 = 14.0;
/// Accelerations and inertial forces of 3.3.4 for 12, 8 and 4 mm: m/s², N, and its last digit.
const INERTIA: [(f64, f64, f64, f64); 3] =
    [(12.0, 0.6990, 9.786e-3, 1e-6), (8.0, 0.7263, 1.017e-2, 1e-5), (4.0, 0.7110, 9.954e-3, 1e-6)];

/// Chapter 3.
#[must_use]
pub fn chapter() -> Chapter {
    let tables = [TABLE_3_1, TABLE_3_2, TABLE_3_3];
    let traces: Vec<Vec<Trace>> = (0..3).map(grasps).collect();
    let fits: Vec<Vec<HoldFit>> = traces.iter().map(|traces| fitted(traces)).collect();
    let sources = ["Table 3.1", "Table 3.2", "Table 3.3"];
    let mut comparisons: Vec<Comparison> =
        (0..3).map(|k| rows(sources[k], &tables[k], &fits[k])).collect();
    comparisons.push(statistics(&tables));
    comparisons.push(best_fits(&tables));
    comparisons.push(inertia());
    let all: Vec<HoldFit> = fits.iter().flatten().cloned().collect();
    let sections = vec![
        claim(),
        courses(&traces),
        consistency_section(&spreads(&all), &fits),
        figures(&traces[0], &fits[0]),
    ];
    Chapter { title: "Chapter 3: the relaxation of a grasp", comparisons, sections }
}

fn fitted(traces: &[Trace]) -> Vec<HoldFit> {
    let fit = |trace: &Trace| fit_holds(trace, FORCE, Terms::Fixed(2), false).ok();
    traces.iter().filter_map(fit).flat_map(|found| found.holds).collect()
}

/// The printed values of a row by parameter.
fn printed(row: &RelaxationRow) -> [(Parameter, f64); 6] {
    let ([c0, c1, c2], [v1, v2]) = (row.shares, row.rates);
    [
        (Parameter::Scale, row.force),
        (Parameter::Coefficient(0), c0),
        (Parameter::Coefficient(1), c1),
        (Parameter::Coefficient(2), c2),
        (Parameter::Rate(1), v1),
        (Parameter::Rate(2), v2),
    ]
}

fn unit(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Scale => "N",
        Parameter::Coefficient(_) => "",
        Parameter::Rate(_) => "1/s",
    }
}

/// One unit of the last printed digit of a row: shares and v2 have four decimals, v1 three, and the force
/// four where it is below 1 N in Table 3.3.
fn digit(parameter: Parameter, compression: f64) -> f64 {
    match parameter {
        Parameter::Coefficient(_) | Parameter::Rate(2) => decimals(4),
        Parameter::Scale if compression < 8.0 => decimals(4),
        Parameter::Scale | Parameter::Rate(_) => decimals(3),
    }
}

/// The values of one row beside those of the refit.
fn row_checks(row: &RelaxationRow, fit: &HoldFit) -> Vec<Check> {
    let name = format!("row {:02}", row.number);
    let check = |(parameter, value): (Parameter, f64)| {
        let found = fit.fit.value(parameter).unwrap_or(f64::NAN);
        let error = fit.fit.standard_error(parameter).unwrap_or(0.0);
        let printed = (value, digit(parameter, row.compression));
        let name = format!("{name}, {parameter}");
        Check::new(name, unit(parameter), printed, found, ERRORS * error)
    };
    let scatter = 0.15 * (1.0 - row.r_squared) + 0.5 * decimals(4);
    let printed_r_squared = (row.r_squared, decimals(4));
    let r_squared =
        Check::new(format!("{name}, R²"), "", printed_r_squared, fit.fit.r_squared, scatter);
    printed(row).into_iter().map(check).chain([r_squared]).collect()
}

fn rows(source: &'static str, table: &[RelaxationRow; 10], fits: &[HoldFit]) -> Comparison {
    let checks = table.iter().zip(fits).flat_map(|(row, fit)| row_checks(row, fit)).collect();
    Comparison {
        source,
        evidence: Evidence::FoundAgain,
        reason: format!(
            "{ERRORS} standard errors of the fit: only the rows are printed, so each recording was rebuilt from its row at 200 Hz with noise that gives the printed R², and the fit has to find under that noise what was fed in. R² itself scatters with the noise, by 15 % of what it lacks to 1."
        ),
        checks,
    }
}

/// Table 3.4 from the printed rows.
fn statistics(tables: &[[RelaxationRow; 10]; 3]) -> Comparison {
    let of = |line: &Statistic| {
        let table = match line.compression {
            12.0 => &tables[0],
            8.0 => &tables[1],
            _ => &tables[2],
        };
        let named = |(parameter, _): &(Parameter, f64)| parameter.to_string() == line.coefficient;
        let value = |row: &RelaxationRow| printed(row).into_iter().find(named).map(|found| found.1);
        let values: Vec<f64> = table.iter().filter_map(value).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let deviation = (square / (values.len() - 1) as f64).sqrt();
        let place = format!("{} mm, {}", line.compression, line.coefficient);
        // Half of the last digit of the rows and half of that of the line; v1 has one digit less.
        let rounding = if line.coefficient == "v1" { 5.5e-4 } else { 1e-4 };
        let check = |name: &str, printed, found| {
            Check::new(format!("{place}, {name}"), "", (printed, decimals(4)), found, rounding)
        };
        [check("mean", line.mean, mean), check("deviation", line.deviation, deviation)]
    };
    Comparison {
        source: "Table 3.4",
        evidence: Evidence::Derived,
        reason: "half of the last digit of the rows and half of that of the table; the deviation is that of a sample (n − 1)".into(),
        checks: TABLE_3_4.iter().flat_map(of).collect(),
    }
}

/// Eqs 3.5–3.10 are the sixth rows.
fn best_fits(tables: &[[RelaxationRow; 10]; 3]) -> Comparison {
    let (shares, rates) = EQUATION_3_6;
    let equations = [
        ("12 mm (3.5, 3.6)", row_of(EQUATION_3_5, shares, rates, 0.9986), 4),
        ("8 mm (3.7, 3.8)", row_of(0.957, [0.5275, 0.2313, 0.2411], [3.493, 0.4247], 0.9941), 4),
        ("4 mm (3.9, 3.10)", row_of(0.4254, [0.6186, 0.1651, 0.2161], [3.786, 0.6427], 0.965), 3),
    ];
    let checks = equations.iter().zip(tables).flat_map(|((name, equation, places), table)| {
        let row = &table[5];
        let one = move |((parameter, value), (_, found)): ((Parameter, f64), (Parameter, f64))| {
            // The equations give v1 one digit more than the rows.
            let digit = match parameter {
                Parameter::Rate(1) => decimals(4),
                _ => digit(parameter, row.compression),
            };
            let allowed = 0.5 * self::digit(parameter, row.compression);
            let name = format!("{name}, {parameter}");
            Check::new(name, unit(parameter), (value, digit), found, allowed)
        };
        let r_squared = (equation.r_squared, decimals(*places));
        let r_squared = Check::exact(format!("{name}, R²"), "", r_squared, row.r_squared);
        printed(equation).into_iter().zip(printed(row)).map(one).chain([r_squared])
    });
    Comparison {
        source: "Eqs 3.5–3.10",
        evidence: Evidence::Derived,
        reason: "half of the last digit of the sixth rows of Tables 3.1–3.3, which these are"
            .into(),
        checks: checks.collect(),
    }
}

fn row_of(force: f64, shares: [f64; 3], rates: [f64; 2], r_squared: f64) -> RelaxationRow {
    RelaxationRow { compression: 0.0, number: 6, shares, rates, force, r_squared }
}

fn inertia() -> Comparison {
    let force = |(mm, acceleration, printed, digit): &(f64, f64, f64, f64)| {
        let name = format!("inertial force at {mm} mm");
        Check::exact(name, "N", (*printed, *digit), MASS_G * 1e-3 * acceleration)
    };
    Comparison {
        source: "Section 3.3.4",
        evidence: Evidence::Derived,
        reason: "half of the last printed digit".into(),
        checks: INERTIA.iter().map(force).collect(),
    }
}

fn claim() -> Section {
    let columns = vec![
        Column::text("compression"),
        Column::number("inertial force", "N"),
        Column::number("N of the sixth row", "N"),
        Column::text("share"),
    ];
    let forces = [EQUATION_3_5, 0.957, 0.4254];
    let mut table = Table::new("Inertia beside the force of the grasp (3.3.4)", columns);
    for ((mm, acceleration, _, _), force) in INERTIA.iter().zip(forces) {
        let inertial = MASS_G * 1e-3 * acceleration;
        table = table.row([
            format!("{mm} mm"),
            significant(inertial, 4),
            significant(force, 4),
            percent(inertial / force, 2),
        ]);
    }
    Section::new("What was claimed")
        .paragraph("A gripper pressed sushi by 12, 8 and 4 mm at 20 mm/s and held still. The force of the hold was written as N (c0 + c1 e^(−v1 t) + c2 e^(−v2 t)) with shares that sum to one (3.4), ten grasps for each compression. The claim is that shares and rates hardly scatter within a compression, unlike the constants of springs and dampers, and that the gripper's inertia does not matter.")
        .table(table)
}

/// The repeats, within each compression and between them.
fn consistency_section(spreads: &[Spread], fits: &[Vec<HoldFit>]) -> Section {
    let columns = vec![
        Column::text("compression"),
        Column::text("coefficient"),
        Column::number("mean", ""),
        Column::number("deviation", ""),
        Column::text("of the mean"),
        Column::number("from noise alone", ""),
        Column::text("p"),
    ];
    let mut table = Table::new("Refitted: scatter over ten grasps (as Table 3.4)", columns);
    for spread in spreads {
        table = table.row([
            spread.level.map_or("–".into(), |x| format!("{} mm", significant(x, 3))),
            spread.parameter.to_string(),
            significant(spread.mean, 4),
            significant(spread.deviation, 3),
            percent(spread.deviation / spread.mean, 2),
            spread.expected.map_or("–".into(), |e| significant(e, 3)),
            spread.consistency.map_or("–".into(), |test| chance(test.p_value)),
        ]);
    }
    let between = between(fits);
    Section::new("How consistent the coefficients are")
        .table(
            table.note("p: the chance of so much scatter from the noise of the recordings alone."),
        )
        .table(between.0)
        .callout(Callout::Finding, "How far the coefficients scatter", within(spreads))
        .callout(Callout::Finding, "Between compressions", between.1)
}

/// Chance below which a test says that something differs.
const SIGNIFICANCE_LEVEL: f64 = 0.01;

/// What the repeats at one compression say.
fn within(spreads: &[Spread]) -> String {
    let shapes: Vec<&Spread> =
        spreads.iter().filter(|spread| spread.parameter != Parameter::Scale).collect();
    let part = |spread: &&Spread| spread.deviation / spread.mean;
    let by_size = |a: &&&Spread, b: &&&Spread| part(a).total_cmp(&part(b));
    let (Some(least), Some(most)) = (shapes.iter().min_by(by_size), shapes.iter().max_by(by_size))
    else {
        return "Too few repeats to compare.".into();
    };
    let place = |spread: &Spread| {
        let at = spread.level.map_or(String::new(), |x| format!(" at {} mm", significant(x, 3)));
        format!("{}{at}", spread.parameter)
    };
    let told = |spread: &&&Spread| {
        spread.consistency.is_some_and(|test| test.p_value < SIGNIFICANCE_LEVEL)
    };
    format!(
        "Shares and rates scatter from grasp to grasp by {} ({}) to {} ({}) of their mean. In {} of {} cases that is more than the noise of a recording explains (p < {SIGNIFICANCE_LEVEL}): there one sushi differs from the next.",
        percent(part(least), 2),
        place(least),
        percent(part(most), 2),
        place(most),
        shapes.iter().filter(told).count(),
        shapes.len()
    )
}

/// The three compressions compared by Welch's test, which lets each have its own scatter, and by ranks, which
/// let it have any distribution.
fn between(fits: &[Vec<HoldFit>]) -> (Table, String) {
    let columns = vec![
        Column::text("coefficient"),
        Column::text("means at 12, 8 and 4 mm"),
        Column::text("deviations"),
        Column::number("p (Welch)", ""),
        Column::number("p (Kruskal and Wallis)", ""),
    ];
    let mut table = Table::new("Is it one material at every compression?", columns);
    let (mut moved, mut unsure, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    let mut stays = false;
    for parameter in Parameter::all(2).skip(1) {
        let values: Vec<Vec<f64>> = fits
            .iter()
            .map(|table| table.iter().filter_map(|hold| hold.fit.value(parameter)).collect())
            .collect();
        let groups: Vec<Repeats> = values.iter().map(|values| Repeats::of(values)).collect();
        let (Some(means), Some(ranks)) = (welch(&groups), kruskal_wallis(&values)) else {
            continue;
        };
        let told = match (means.p_value < SIGNIFICANCE_LEVEL, ranks < SIGNIFICANCE_LEVEL) {
            (true, true) => &mut moved,
            (false, false) => &mut kept,
            _ => &mut unsure,
        };
        told.push(parameter.to_string());
        stays |= parameter == Parameter::Coefficient(0)
            && moved.contains(&parameter.to_string())
            && groups.is_sorted_by(|a, b| a.mean < b.mean);
        let each = |of: fn(&Repeats) -> f64, digits| {
            let texts = groups.iter().map(|group| significant(of(group), digits));
            texts.collect::<Vec<_>>().join(", ")
        };
        table = table.row([
            parameter.to_string(),
            each(|group| group.mean, 4),
            each(|group| group.deviation, 3),
            chance(means.p_value),
            chance(ranks),
        ]);
    }
    let mut words = Vec::new();
    let mut say = |names: &[String], after: &str| {
        if !names.is_empty() {
            words.push(format!("{}: {after}.", names.join(", ")));
        }
    };
    say(
        &moved,
        "these differ between compressions by more than their repeats scatter, by both tests (p < 0.01), so that separating displacement from time (3.1) is an approximation",
    );
    say(
        &unsure,
        "one test shows a difference (p < 0.01), the other does not; neither answer is secure",
    );
    say(&kept, "no difference between compressions is shown");
    if stays {
        words.push("The larger the compression, the smaller the share that stays.".into());
    }
    (table, words.join(" "))
}

fn chance(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".into() } else { significant(p, 2) }
}

/// Figs 3.4 to 3.7 from the sixth row of each table.
fn courses(traces: &[Vec<Trace>]) -> Section {
    let sixth =
        |(compression, traces): (f64, &Vec<Trace>)| Some((compression, traces.get(5)?.clone()));
    let grasps: Vec<(f64, Trace)> =
        [12.0, 8.0, 4.0].into_iter().zip(traces).filter_map(sixth).collect();
    let grasps: Vec<(f64, &Trace)> = grasps.iter().map(|(x, trace)| (*x, trace)).collect();
    grasp_courses::section(&grasps)
}

/// Figs 3.10, 3.8 and 3.9 in kind, from the sixth row of Table 3.1.
fn figures(traces: &[Trace], fits: &[HoldFit]) -> Section {
    let mut section = Section::new("Figures in kind");
    let (Some(trace), Some(fit)) = (traces.get(5), fits.get(5)) else { return section };
    let Some(force) = trace.force() else { return section };
    if let (Ok(found), Some(x)) = (segment(trace), trace.displacement()) {
        let axes = (Axis::new("displacement", "mm"), Axis::new("force", "N"));
        let mut plot = Plot::new("Regions of a grasp (Fig. 3.10)", axes.0, axes.1)
            .summary("Loop of one grasp with the points between its regions")
            .series(Series::line("force", x, force).colour(Colour::MEASURED));
        for point in found.cycles.iter().flat_map(|cycle| &cycle.points) {
            plot = plot.annotation(point.displacement_mm, point.force_n, point.name.clone());
        }
        section = section.figure(
            plot,
            "One grasp of 12 mm, rebuilt; the regions were found by `palpate segment`.",
        );
    }
    let since: Vec<f64> = trace.time[fit.range.clone()].iter().map(|t| t - fit.from_s).collect();
    let (long, curve): (Vec<f64>, Vec<f64>) =
        (0..=300).map(|k| 20.0 * f64::from(k) / 300.0).map(|t| (t, fit.fit.sum.at(t))).unzip();
    let plot = Plot::new(
        "Relaxation and where it goes (Figs 3.8, 3.9)",
        Axis::new("time in the hold", "s"),
        Axis::new("force", "N"),
    )
    .summary("Measured force of the hold, the fit, and the fit continued to 20 s")
    .series(
        Series::points("rebuilt recording", since, &force[fit.range.clone()])
            .colour(Colour::MEASURED),
    )
    .series(Series::line("(3.4)", long, curve).colour(Colour::MODEL))
    .level(fit.fit.sum.scale * fit.fit.sum.constant, "N c0");
    section.figure(plot, "Beyond the hold the curve is an extrapolation.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_between_compressions_is_said_by_the_test_and_by_nothing_else() {
        let fits: Vec<Vec<HoldFit>> = (0..3).map(|table| fitted(&grasps(table))).collect();
        let (table, words) = between(&fits);
        assert_eq!(table.rows.len(), 5);
        for row in &table.rows {
            let told =
                |p: &str| p.trim_start_matches("< ").parse::<f64>().unwrap() < SIGNIFICANCE_LEVEL;
            let said = match (told(&row[3]), told(&row[4])) {
                (true, true) => "these differ",
                (false, false) => "no difference",
                _ => "neither answer is secure",
            };
            let sentence = words.split(". ").find(|sentence| sentence.contains(&row[0])).unwrap();
            assert!(sentence.contains(said), "{row:?}: {words}");
        }
        assert!(!words.contains("the rates do not"));
    }
}
