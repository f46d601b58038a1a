//! Pull-offs of adhesive contacts, and their growth with the speed, as tables and a figure.

use super::{CONCISE, concise, estimate};
use palpate_analysis::cycles::Segmentation;
use palpate_analysis::pull_off_growth::{Growth, Law};
use palpate_analysis::rates::Estimate;
use palpate_report::number::significant;
use palpate_report::{Axis, Colour, Column, Plot, Section, Series, Table};

/// Points of the curve of the law.
const CURVE_POINTS: usize = 100;

/// How the contact of each cycle came off; none where nothing adheres.
pub(super) fn pull_off_table(found: &Segmentation) -> Option<Table> {
    let columns = vec![
        Column::text("cycle"),
        Column::number("speed", "mm/s"),
        Column::number("pull-off force", "N"),
        Column::number("at", "mm"),
        Column::number("work of adhesion", "mJ"),
        Column::number("separation", "mm"),
        Column::number("zero", "N"),
    ];
    let mut table = Table::new("Pull-off of each cycle", columns);
    let mut any = false;
    for cycle in &found.cycles {
        let Some(pull) = &cycle.pull_off else { continue };
        any = true;
        table = table.row([
            cycle.number.to_string(),
            significant(pull.speed_mm_per_s, 3),
            concise(pull.force_n, Some(pull.force_error_n)),
            significant(pull.displacement_mm, 3),
            concise(pull.work_mj, Some(pull.work_error_mj)),
            significant(pull.separation_mm, 3),
            significant(pull.zero_n, 2),
        ]);
    }
    any.then(|| {
        table.note(format!(
            "The largest pull, counted from the force after the separation (zero); the area under the pull; the displacement at which it has gone. Speed: the mean while it pulls. {CONCISE}"
        ))
    })
}

/// Pull-offs over the speed.
#[must_use]
pub fn growth_section(growth: &Growth) -> Section {
    let columns = vec![
        Column::number("speed", "mm/s"),
        Column::number("pull-offs", ""),
        Column::number("force", "N"),
        Column::number("work of adhesion", "mJ"),
        Column::number("separation", "mm"),
    ];
    let mut table = Table::new("Pull-off over the speed of the retreat", columns);
    for speed in &growth.speeds {
        let told = |(value, error): Estimate| concise(value, error);
        table = table.row([
            significant(speed.speed_mm_per_s, 3),
            speed.count.to_string(),
            told(speed.force_n),
            told(speed.work_mj),
            told(speed.separation_mm),
        ]);
    }
    let table = table.note(format!("Means of the pull-offs at one speed; their standard errors are from the scatter, of a single one from the noise. {CONCISE}"));
    let mut section = Section::new("Pull-off and speed").table(table);
    for words in [growth.slope.map(slope_words), Some(law_words(&growth.law))] {
        section = words.into_iter().fold(section, Section::paragraph);
    }
    section.figure(growth_plot(growth), "Mean pull-off force at each speed.")
}

fn slope_words((slope, error): (f64, f64)) -> String {
    format!(
        "Over these speeds the force grows as v to the power of {} (line of ln F over ln v).",
        estimate(slope, Some(error))
    )
}

fn law_words(law: &Result<Law, String>) -> String {
    match law {
        Ok(law) => {
            let told = |(value, error): (f64, f64)| estimate(value, Some(error));
            format!(
                "F = F0 (1 + (v/v0)^n): F0 {} N, v0 {} mm/s, n {}.",
                told(law.force_n),
                told(law.speed_mm_per_s),
                told(law.exponent)
            )
        }
        Err(why) => format!("F = F0 (1 + (v/v0)^n) is not identifiable: {why}."),
    }
}

fn growth_plot(growth: &Growth) -> Plot {
    let (speeds, forces): (Vec<f64>, Vec<f64>) =
        growth.speeds.iter().map(|s| (s.speed_mm_per_s, s.force_n.0)).unzip();
    let mut plot = Plot::new(
        "Pull-off force over speed",
        Axis::new("speed", "mm/s").log(),
        Axis::new("pull-off force", "N"),
    )
    .summary("Pull-off force over the speed, logarithmic")
    .series(Series::points("measured", speeds.clone(), forces).colour(Colour::MEASURED));
    if let Ok(law) = &growth.law {
        let (first, last) = (speeds[0].ln(), speeds[speeds.len() - 1].ln());
        let at = |k: usize| (first + (last - first) * k as f64 / CURVE_POINTS as f64).exp();
        let speeds: Vec<f64> = (0..=CURVE_POINTS).map(at).collect();
        let forces = speeds.iter().map(|v| law.at(*v)).collect::<Vec<f64>>();
        plot = plot.series(Series::line("law", speeds, forces).colour(Colour::Hue(0)));
    }
    plot
}
