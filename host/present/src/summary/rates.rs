//! Runs at several loading rates: chapter 5 for one's own data.

use super::holds::chance;
use super::{CONCISE, concise, estimate};
use palpate_analysis::geometry::{Faces, Geometry};
use palpate_analysis::rates::{Course, Group, Run, Study, Trend};
use palpate_fit::consistency::Consistency;
use palpate_report::number::{counted, percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::Trace;

/// Seconds around the end of the loading in the close-up.
const CLOSE_UP: f64 = 0.5;
/// Residuals over noise from which on a hold counts as not described.
const MISFIT: f64 = 1.3;
/// Chance below which a test says that something differs.
const SIGNIFICANCE_LEVEL: f64 = 0.01;

/// Stiffness, strains, asymptotes and stiffening.
#[must_use]
pub fn rates_sections(study: &Study, traces: &[Trace]) -> Vec<Section> {
    let mut first = Section::new("Loading rates")
        .paragraph(geometry_words(&study.geometry))
        .table(run_table(study))
        .table(property_table(study))
        .table(group_table(study));
    for group in study.groups.iter().filter(|group| group.runs.len() > 1) {
        first = first.callout(Callout::Finding, "Asymptotes and stiffening", group_words(group));
    }
    for words in warnings(study) {
        first = first.callout(Callout::Warning, "Beware", words);
    }
    for plot in force_plots(study, traces) {
        first = first.figure(plot, "");
    }
    let mut strains = Section::new("Strain of the surface").table(strain_table(study, traces));
    if let Some((run, course)) = fastest(study, traces) {
        strains = strains.figure(
            course_panels(run, &course),
            "As in Figs 5.13 and 5.14: during the loading the surface runs ahead of the equilibrium, in the hold it comes back to it.",
        );
    }
    vec![first, strains]
}

/// The geometry in words.
pub(super) fn geometry_words(geometry: &Geometry) -> String {
    match geometry {
        Geometry::Cylinder { radius_mm, height_mm, poisson } => format!(
            "Cylinder of radius {radius_mm} mm and height {height_mm} mm; its area grows with Poisson's ratio {poisson} (5.5)."
        ),
        Geometry::Block { length_mm, width_mm, height_mm, poisson } => format!(
            "Block of {length_mm} mm × {width_mm} mm and height {height_mm} mm; its area grows with Poisson's ratio {poisson} (5.5)."
        ),
        Geometry::Ball { radius_mm, faces } => format!(
            "Ball of radius {radius_mm} mm; d of (7.7) is {}.",
            match faces {
                Faces::One => "the whole displacement, as the equation is printed",
                Faces::Each =>
                    "half the displacement, on each of two faces, as in the simulation of 7.4",
            }
        ),
    }
}

fn run_table(study: &Study) -> Table {
    let columns = vec![
        Column::text("run"),
        Column::number("rate", "mm/s"),
        Column::number("displacement", "mm"),
        Column::number("peak", "N"),
        Column::number("asymptote", "N"),
        Column::number("v1", "1/s"),
        Column::number("area", "mm²"),
        Column::number("ε_e", ""),
        Column::number("k_s", "Pa"),
        Column::number("R²", ""),
    ];
    let mut table = Table::new("Every loading with its hold (5.3, 5.5–5.8)", columns);
    for run in &study.runs {
        table = table.row([
            run.trace.clone(),
            significant(run.rate_mm_per_s, 4),
            significant(run.displacement_mm, 4),
            concise(run.peak_n.0, run.peak_n.1),
            concise(run.asymptote_n.0, run.asymptote_n.1),
            concise(run.v1.0, run.v1.1),
            significant(run.area_mm2, 4),
            significant(run.equilibrium_strain, 4),
            concise(run.stiffness_pa.0, run.stiffness_pa.1),
            format!("{:.4}", run.fit.r_squared),
        ]);
    }
    table.note(CONCISE)
}

fn property_table(study: &Study) -> Table {
    let columns = vec![
        Column::text("property"),
        Column::text("over all runs"),
        Column::text("unit"),
        Column::number("χ² per degree", ""),
        Column::text("p"),
    ];
    let row = |name: &str, value: (f64, Option<f64>), unit: &str, test: Option<Consistency>| {
        [
            name.to_owned(),
            estimate(value.0, value.1),
            unit.to_owned(),
            test.map_or("–".into(), |t| {
                significant(t.chi_square / t.degrees_of_freedom as f64, 3)
            }),
            test.map_or("–".into(), |t| chance(t.p_value)),
        ]
    };
    Table::new("The specimen (Table 5.2)", columns)
        .row(row("v1", study.v1, "1/s", study.agreement.0))
        .row(row("k_s, specific stiffness", study.stiffness_pa, "Pa", study.agreement.1))
        .note("p: the chance of so much difference between the runs from their standard errors alone. k_s = σ/ε at the asymptote (5.6); strain is σ/k_s (5.7).")
}

fn group_table(study: &Study) -> Table {
    let columns = vec![
        Column::text("at"),
        Column::whole("runs"),
        Column::number("asymptote", "N"),
        Column::text("p that they agree"),
        Column::number("asymptote per decade", "N"),
        Column::text("p"),
        Column::text("p that the peaks agree"),
        Column::number("peak per decade", "N"),
        Column::text("p"),
    ];
    let mut table = Table::new("Over the loading rate, at each displacement", columns);
    for group in &study.groups {
        let slope = |trend: &Option<Trend>| {
            trend.map_or("–".into(), |t| estimate(t.slope_n.0, t.slope_n.1))
        };
        let p = |trend: &Option<Trend>| trend.map_or("–".into(), |t| chance(t.p_value));
        table = table.row([
            format!("{} mm", significant(group.displacement_mm, 4)),
            group.runs.len().to_string(),
            group.asymptotes.map_or("–".into(), |t| estimate(t.mean, Some(t.standard_error))),
            group.asymptotes.map_or("–".into(), |t| chance(t.p_value)),
            slope(&group.asymptote_trend),
            p(&group.asymptote_trend),
            group.peaks.map_or("–".into(), |t| chance(t.p_value)),
            slope(&group.peak_trend),
            p(&group.peak_trend),
        ]);
    }
    table.note("Slopes are over the logarithm of the rate, for ten times the rate, from three different rates on; their errors are from the standard errors of the runs, and where a run has none from the scatter about the line.")
}

fn group_words(group: &Group) -> String {
    let asymptotes = match group.asymptotes {
        None => "The asymptotes have no standard errors to compare them by.".to_owned(),
        Some(test) if test.p_value >= SIGNIFICANCE_LEVEL => format!(
            "The asymptotes of {} runs agree within their standard errors (p {}).",
            group.runs.len(),
            chance(test.p_value)
        ),
        Some(test) => {
            let along = match group.asymptote_trend {
                Some(trend) if trend.p_value < SIGNIFICANCE_LEVEL => "and they go with the rate",
                Some(_) => "without a trend that so few runs show",
                None => "at too few rates to say whether along the rate",
            };
            format!(
                "The asymptotes of {} runs differ by more than their standard errors (p {}), {along}.",
                group.runs.len(),
                chance(test.p_value)
            )
        }
    };
    let peaks = peak_words(group);
    format!("At {} mm: {asymptotes} {peaks}", significant(group.displacement_mm, 4))
}

/// Whether the peak stiffens with the rate, and by how much.
fn peak_words(group: &Group) -> String {
    let Some(trend) = group.peak_trend else {
        return "Too few different rates for a trend of the peak.".to_owned();
    };
    let mean = group.peaks.map_or(f64::NAN, |peaks| peaks.mean);
    let part = trend.slope_n.0 / mean;
    let slope = format!(
        "{} N for ten times the rate{} (p {})",
        estimate(trend.slope_n.0, trend.slope_n.1),
        if part.is_finite() { format!(", {} of it", percent(part, 2)) } else { String::new() },
        chance(trend.p_value)
    );
    let differ = group.peaks.filter(|test| test.p_value < SIGNIFICANCE_LEVEL);
    let verdict = match (trend.p_value < SIGNIFICANCE_LEVEL, differ) {
        (true, _) if trend.slope_n.0 > 0.0 => format!("The peak stiffens with the rate: {slope}."),
        (true, _) => format!("The peak falls with the rate: {slope}."),
        (false, Some(test)) => format!(
            "The peaks differ by more than their standard errors (p {}), but not along the rate: {slope}.",
            chance(test.p_value)
        ),
        (false, None) if group.peaks.is_some() => {
            format!("The peaks agree within their standard errors: {slope}.")
        }
        (false, None) => format!("A trend of the peak is not shown by so few runs: {slope}."),
    };
    let off = trend.off_line.filter(|off| off.p_value < SIGNIFICANCE_LEVEL).map(|off| {
        format!(
            " They lie off that line by more than their errors (χ² {} with {} degree{} of freedom, p {}): the change is no straight line over the logarithm of the rate, or runs differ by more than their noise.",
            significant(off.chi_square, 3),
            off.degrees_of_freedom,
            if off.degrees_of_freedom == 1 { "" } else { "s" },
            chance(off.p_value)
        )
    });
    verdict + &off.unwrap_or_default()
}

/// What to beware of.
pub fn warnings(study: &Study) -> Vec<String> {
    let alone = study.groups.iter().all(|group| group.runs.len() == 1);
    let alone = alone.then(|| {
        "Every displacement has one run only: nothing to compare over the rates.".to_owned()
    });
    let stiffness = study.agreement.1.filter(|test| test.p_value < SIGNIFICANCE_LEVEL).map(|_| {
        let of = study.runs.iter().map(|run| run.stiffness_pa.0);
        let (low, high) = of.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), k| (low.min(k), high.max(k)));
        format!(
            "k_s is not one number: {} to {} Pa over the runs. (5.7) takes one, so the strain of the surface is off by as much.",
            significant(low, 4),
            significant(high, 4)
        )
    });
    alone.into_iter().chain(stiffness).chain(misfit_words(study)).collect()
}

/// Where the exponentials leave more than noise in a hold.
fn misfit_words(study: &Study) -> Option<String> {
    let over =
        |run: &Run| run.noise_n.filter(|noise| *noise > 0.0).map(|noise| run.fit.noise / noise);
    let worst = study.runs.iter().filter_map(|run| Some((run, over(run)?)));
    let (run, over) = worst.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (over > MISFIT).then(|| {
        let terms = run.fit.sum.terms.len();
        let leave = if terms == 1 { "leaves" } else { "leave" };
        format!(
            "{} {leave} {} times the noise in the hold of {}: the asymptote and v1 then depend on how long the hold lasted, and standard errors are too small. `--terms` takes up to four.",
            counted(terms, "exponential"),
            significant(over, 2),
            run.trace
        )
    })
}

/// The run, its trace, and the forces of the run on a time that begins with the hold.
fn forces<'a>(study: &'a Study, traces: &'a [Trace]) -> Vec<(&'a Run, Vec<f64>, Vec<f64>)> {
    let of = |run: &'a Run| {
        let trace = traces.iter().find(|trace| trace.label() == run.trace)?;
        let samples = run.loading.start..run.hold.end.min(trace.len());
        let begin = trace.time[run.hold.start];
        let time = trace.time[samples.clone()].iter().map(|t| t - begin).collect();
        Some((run, time, trace.force()?[samples].to_vec()))
    };
    study.runs.iter().filter_map(of).collect()
}

/// Figs 5.6–5.11 in kind: whole, end of loading, end of hold.
fn force_plots(study: &Study, traces: &[Trace]) -> Vec<Plot> {
    let runs = forces(study, traces);
    let shortest =
        runs.iter().filter_map(|run| run.1.last()).copied().fold(f64::INFINITY, f64::min);
    if !shortest.is_finite() {
        return Vec::new();
    }
    let windows = [
        ("Force at every loading rate (Figs 5.6, 5.7)", f64::NEG_INFINITY, f64::INFINITY),
        ("End of the loading (Figs 5.8, 5.9)", -CLOSE_UP.min(shortest), CLOSE_UP.min(shortest)),
        ("End of the hold (Figs 5.10, 5.11)", 0.8 * shortest, shortest),
    ];
    let plot = |(title, from, to): (&str, f64, f64)| {
        let axis = Axis::new("time since the hold began", "s");
        let mut plot = Plot::new(title, axis, Axis::new("force", "N")).summary(title);
        for (index, (run, time, force)) in runs.iter().enumerate() {
            let (x, y): (Vec<f64>, Vec<f64>) = time
                .iter()
                .zip(force)
                .filter(|(t, _)| (from..=to).contains(*t))
                .map(|(t, f)| (*t, *f))
                .unzip();
            let label = format!("{} mm/s", significant(run.rate_mm_per_s, 3));
            plot = plot.series(Series::line(label, x, y).colour(Colour::Hue(index)));
        }
        plot
    };
    windows.into_iter().map(plot).collect()
}

fn courses<'a>(study: &'a Study, traces: &[Trace]) -> Vec<(&'a Run, Course)> {
    let of = |run: &'a Run| {
        let trace = traces.iter().find(|trace| trace.label() == run.trace)?;
        Some((run, study.course(run, trace)?))
    };
    study.runs.iter().filter_map(of).filter(|(_, course)| !course.time.is_empty()).collect()
}

fn fastest<'a>(study: &'a Study, traces: &[Trace]) -> Option<(&'a Run, Course)> {
    let rate = |run: &Run| run.rate_mm_per_s;
    courses(study, traces).into_iter().max_by(|a, b| rate(a.0).total_cmp(&rate(b.0)))
}

fn strain_table(study: &Study, traces: &[Trace]) -> Table {
    let columns = vec![
        Column::text("run"),
        Column::number("rate", "mm/s"),
        Column::number("ε_e of the hold", ""),
        Column::number("largest ε_c", ""),
        Column::number("fastest latent rate", "1/s"),
        Column::number("ε_c at the end", ""),
    ];
    let mut table = Table::new(
        "Strain of the surface from the force (5.7), and latent strain rate (5.1)",
        columns,
    );
    for (run, course) in courses(study, traces) {
        let largest = course.surface.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let fastest = course
            .latent_rate
            .iter()
            .copied()
            .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        table = table.row([
            run.trace.clone(),
            significant(run.rate_mm_per_s, 4),
            significant(run.equilibrium_strain, 4),
            significant(largest, 4),
            significant(fastest, 3),
            course.surface.last().map_or("–".into(), |strain| significant(*strain, 4)),
        ]);
    }
    table.note("Compression is positive. ε_c = F/(A k_s), with k_s and v1 over all runs.")
}

fn course_panels(run: &Run, course: &Course) -> Panels {
    let time: Vec<f64> = course.time.iter().map(|t| t - course.time[0]).collect();
    let title = format!("Strain at {} mm/s: {}", significant(run.rate_mm_per_s, 3), run.trace);
    Panels::new(title)
        .summary("Strain of the surface and of the equilibrium, and the latent strain rate")
        .plot(
            Plot::new("", Axis::new("time", "s"), Axis::new("strain", ""))
                .series(
                    Series::line("surface ε_c", &time[..], &course.surface[..])
                        .colour(Colour::Hue(0)),
                )
                .series(
                    Series::line("equilibrium ε_e", &time[..], &course.equilibrium[..])
                        .colour(Colour::Hue(1)),
                )
                .height(170.0),
        )
        .plot(
            Plot::new("", Axis::new("time", "s"), Axis::new("latent strain rate", "1/s"))
                .series(
                    Series::line("latent rate", &time[..], &course.latent_rate[..])
                        .colour(Colour::Ink),
                )
                .height(140.0),
        )
}
