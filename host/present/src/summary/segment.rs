//! Cycles and regions of a recording, as tables and plots.

use shared::phase::{Region, RelaxationType};

use super::pull_off::pull_off_table;
use super::{estimate, region_spans, shaded};
use palpate_analysis::cycles::{Cycle, Inertia, Piece, Segmentation, Turn};
use palpate_analysis::regions::{name, type_name};
use palpate_report::number::{counted, percent, significant};
use palpate_report::{Axis, Block, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::{Control, Trace};

/// Most cycles whose regions are listed one by one in print; JSON has them all.
const MOST_LISTED: usize = 12;

/// What the drawings of a cycle show.
const LOOP_WORDS: &str =
    "Points as in Fig. 3.10. A loop that runs clockwise dissipates what it encloses.";
const TIME_WORDS: &str = "The regions, shaded.";

/// Points, regions, work and inertia: of several recordings, work and inertia side by side before each.
#[must_use]
pub fn segment_sections(each: &[(&Trace, &Segmentation)]) -> Vec<Section> {
    if let [(trace, found)] = *each {
        let mut section = Section::new(trace.label()).paragraph(introduction(trace, found));
        section = beware(section.table(cycle_table(each)), found);
        if let Some(inertia) = &found.inertia {
            section = section.paragraph(inertia_words(inertia));
        }
        return vec![drawn(section, trace, found, [LOOP_WORDS, TIME_WORDS])];
    }
    let mut overview = Section::new("Every cycle").table(cycle_table(each));
    if each.iter().any(|(_, found)| found.inertia.is_some()) {
        overview = overview.table(inertia_table(each));
    }
    let of_one = |(index, (trace, found)): (usize, &(&Trace, &Segmentation))| {
        let section = Section::new(trace.label()).paragraph(introduction(trace, found));
        let words = if index == 0 { [LOOP_WORDS, TIME_WORDS] } else { [""; 2] };
        drawn(beware(section, found), trace, found, words)
    };
    std::iter::once(overview).chain(each.iter().enumerate().map(of_one)).collect()
}

/// The pull where the specimen adheres, and what is odd.
fn beware(mut section: Section, found: &Segmentation) -> Section {
    if let Some(table) = pull_off_table(found) {
        section = section.table(table);
    }
    for warning in warnings(found) {
        section = section.callout(Callout::Warning, "Beware", warning);
    }
    section
}

fn drawn(
    section: Section,
    trace: &Trace,
    found: &Segmentation,
    [of_loop, of_time]: [&str; 2],
) -> Section {
    let folded = Block::Details {
        summary: "Points and regions of each cycle".into(),
        blocks: vec![Block::Table(point_table(found)), Block::Table(piece_table(trace, found))],
    };
    section
        .figure(loop_plot(trace, found), of_loop)
        .figure(time_panels(trace, found), of_time)
        .block(folded)
}

fn introduction(trace: &Trace, found: &Segmentation) -> String {
    let source = if found.control_told { "the head says so" } else { "derived from the data" };
    format!(
        "{}: {}, {} controlled ({source}); noise of the force {} N.",
        trace.label(),
        counted(found.cycles.len(), "cycle"),
        word(found.control),
        significant(found.force_noise_n, 2),
    )
}

/// The points and the name of a piece; a hold of a controlled force is one of creep, and an unloading of a
/// specimen that adheres ends in a pull.
pub fn region_of(piece: &Piece, cycle: &Cycle, control: Control) -> (&'static str, &'static str) {
    match (piece.region, control) {
        (Region::Unloading, _) if piece.pulls => ("ZE", "pull-off"),
        (Region::Unloading, _) if cycle.pull_off.is_some() => ("DZ", "unloading"),
        (Region::Relaxation, Control::Force) => ("CD", "creep"),
        (region, _) => name(region),
    }
}

fn word(control: Control) -> &'static str {
    match control {
        Control::Displacement => "displacement",
        Control::Force => "force",
    }
}

fn listed(found: &Segmentation) -> impl Iterator<Item = &Cycle> {
    found.cycles.iter().take(MOST_LISTED)
}

fn shortened(table: Table, found: &Segmentation) -> Table {
    match found.cycles.len().checked_sub(MOST_LISTED) {
        Some(more) if more > 0 => {
            table.note(format!("{more} more cycles are not listed; --json has all."))
        }
        _ => table,
    }
}

fn point_table(found: &Segmentation) -> Table {
    let columns = vec![
        Column::text("cycle"),
        Column::text("point"),
        Column::number("time", "s"),
        Column::number("displacement", "mm"),
        Column::number("force", "N"),
    ];
    let mut table = Table::new("Points of each cycle (Fig. 3.10)", columns);
    for cycle in listed(found) {
        for point in &cycle.points {
            table = table.row([
                cycle.number.to_string(),
                point.name.clone(),
                format!("{:.3}", point.time_s),
                point.displacement_mm.to_string(),
                point.force_n.to_string(),
            ]);
        }
    }
    let pulls = match found.cycles.iter().any(|cycle| cycle.pull_off.is_some()) {
        true => " Z the force passes zero, P the largest pull,",
        false => "",
    };
    let table = table.alike([3, 4], 4).note(format!(
        "O the approach begins, A touch, B end of loading or its largest force, C and D the hold begins and ends,{pulls} E contact is lost, F recovered.",
    ));
    shortened(table, found)
}

fn piece_table(trace: &Trace, found: &Segmentation) -> Table {
    let columns = vec![
        Column::text("cycle"),
        Column::text(""),
        Column::text("region"),
        Column::number("lasts", "s"),
        Column::number("displacement changes", "mm"),
        Column::number("force changes", "N"),
        Column::number("work", "mJ"),
    ];
    let mut table = Table::new("Regions: what changes over each, and ∫F dx", columns);
    let (Some(x), Some(force)) = (trace.displacement(), trace.force()) else { return table };
    for cycle in listed(found) {
        for piece in &cycle.pieces {
            let (points, region) = region_of(piece, cycle, found.control);
            let change =
                |values: &[f64]| values[*piece.samples.end()] - values[*piece.samples.start()];
            table = table.row([
                cycle.number.to_string(),
                points.to_owned(),
                format!("{region}{}", of_type(piece)),
                change(&trace.time).to_string(),
                change(x).to_string(),
                change(force).to_string(),
                piece.work_mj.to_string(),
            ]);
        }
    }
    let table = table.alike(3..7, 4);
    shortened(table.note("Work is positive where it goes into the specimen."), found)
}

fn of_type(piece: &Piece) -> String {
    match piece.relaxation {
        RelaxationType::None => String::new(),
        relaxation => format!(", {}", type_name(relaxation)),
    }
}

/// The type of a hold in words; none for other regions.
pub fn type_of(relaxation: RelaxationType) -> Option<String> {
    (relaxation != RelaxationType::None).then(|| type_name(relaxation))
}

/// Work of each cycle, with the recording where there are several.
fn cycle_table(each: &[(&Trace, &Segmentation)]) -> Table {
    let several = each.len() > 1;
    let columns = vec![
        Column::text("cycle"),
        Column::number("largest force", "N"),
        Column::number("at", "s"),
        Column::number("work in", "mJ"),
        Column::number("work out", "mJ"),
        Column::number("difference", "mJ"),
        Column::text("share of work in"),
        Column::text("loop"),
    ];
    let columns = several.then(|| Column::text("trace")).into_iter().chain(columns).collect();
    let mut table = Table::new("Work of each cycle", columns);
    for (trace, found) in each {
        for cycle in &found.cycles {
            let share = cycle.dissipated_mj() / cycle.work_in_mj.max(f64::MIN_POSITIVE);
            let open = if cycle.closed { "" } else { ", open" };
            let row = [
                cycle.number.to_string(),
                significant(cycle.peak_force_n, 4),
                format!("{:.3}", trace.time[cycle.peak]),
                significant(cycle.work_in_mj, 4),
                significant(cycle.work_out_mj, 4),
                estimate(cycle.dissipated_mj(), Some(cycle.work_error_mj)),
                percent(share, 3),
                format!("{}{open}", turn_word(cycle.turn())),
            ];
            table = table.row(several.then(|| trace.label()).into_iter().chain(row));
        }
    }
    table.note("The difference is what a closed loop dissipates; an open one also stores some of it. ± is what the noise of the force makes.")
}

/// What the moving mass adds to the force of several recordings.
fn inertia_table(each: &[(&Trace, &Segmentation)]) -> Table {
    let columns = vec![
        Column::text("trace"),
        Column::number("mass", "g"),
        Column::number("acceleration", "mm/s²"),
        Column::number("of it scatter", "mm/s²"),
        Column::number("force", "N"),
        Column::text("share of largest"),
        Column::number("hidden below", "N"),
        Column::text("shows"),
    ];
    let mut table = Table::new("Inertia (3.3.4)", columns);
    for (trace, inertia) in each.iter().filter_map(|(t, found)| Some((t, found.inertia.as_ref()?)))
    {
        let shows = if inertia.force_n > inertia.resolution_n { "yes" } else { "no" };
        let row = std::iter::once(trace.label()).chain(inertia_cells(inertia));
        table = table.row(row.chain([shows.to_owned()]));
    }
    table.note("Mass times largest acceleration, beside the resolution of the force, or its noise where the head gives none.")
}

/// Mass, acceleration, its scatter, force, share of the largest force and resolution, in the digits that they are told with.
fn inertia_cells(inertia: &Inertia) -> [String; 6] {
    [
        significant(inertia.mass_g, 3),
        significant(inertia.acceleration_mm_per_s2, 3),
        significant(inertia.scatter_mm_per_s2, 2),
        significant(inertia.force_n, 3),
        percent(inertia.share_of_peak, 2),
        significant(inertia.resolution_n, 2),
    ]
}

fn turn_word(turn: Turn) -> &'static str {
    match turn {
        Turn::Clockwise => "clockwise",
        Turn::Counterclockwise => "counterclockwise",
        Turn::Neither => "none beyond noise",
    }
}

fn inertia_words(inertia: &Inertia) -> String {
    let against = if inertia.resolution_told { "resolution" } else { "noise" };
    let verdict = match (inertia.force_n <= inertia.resolution_n, inertia.force_n) {
        (true, _) => "it hides below that".to_owned(),
        _ => format!(
            "it is {} times that and shows in the force",
            significant(inertia.force_n / inertia.resolution_n.max(f64::MIN_POSITIVE), 2)
        ),
    };
    let [mass, acceleration, scatter, force, share, resolution] = inertia_cells(inertia);
    format!(
        "Inertia (3.3.4): {mass} g times at most {acceleration} mm/s² is {force} N, {share} of the largest force; the {against} of the force is {resolution} N: {verdict}. (The scatter of the displacement alone shows {scatter} mm/s².)"
    )
}

/// What to beware of.
pub fn warnings(found: &Segmentation) -> Vec<String> {
    found
        .cycles
        .iter()
        .filter(|cycle| cycle.turn() == Turn::Counterclockwise && cycle.closed)
        .map(|cycle| {
            format!(
                "cycle {} runs counterclockwise: it gives {} mJ more than it took, which no passive specimen does. Check the sign of the force, the time between the two channels, or whether it was still recovering.",
                cycle.number,
                significant(-cycle.dissipated_mj(), 3)
            )
        })
        .collect()
}

fn loop_plot(trace: &Trace, found: &Segmentation) -> Plot {
    let (x, force) = (trace.displacement().unwrap_or(&[]), trace.force().unwrap_or(&[]));
    let mut plot = Plot::new(
        "Force over displacement",
        Axis::new("displacement", "mm"),
        Axis::new("force", "N"),
    )
    .summary(format!(
        "Force over displacement of {} with their points",
        counted(found.cycles.len(), "cycle")
    ));
    for (index, cycle) in listed(found).enumerate() {
        let samples = || cycle.pieces.iter().flat_map(|piece| piece.samples.clone());
        let (xs, ys): (Vec<f64>, Vec<f64>) = samples().map(|k| (x[k], force[k])).unzip();
        let label = format!("cycle {}", cycle.number);
        plot = plot.series(Series::line(label, xs, ys).colour(Colour::Hue(index)));
    }
    if let Some(first) = found.cycles.first() {
        let at: (Vec<f64>, Vec<f64>) =
            first.points.iter().map(|point| (point.displacement_mm, point.force_n)).unzip();
        plot = plot.series(Series::points("", at.0, at.1).colour(Colour::Ink));
        for point in &first.points {
            plot = plot.annotation(point.displacement_mm, point.force_n, point.name.clone());
        }
    }
    plot
}

fn time_panels(trace: &Trace, found: &Segmentation) -> Panels {
    let spans = region_spans(trace, &found.regions);
    let panel = |label: &str, unit: &str, values: Option<&[f64]>| {
        Plot::new("", Axis::new("time", "s"), Axis::new(label, unit))
            .series(
                Series::line(label, &trace.time[..], values.unwrap_or(&[]))
                    .colour(Colour::MEASURED),
            )
            .height(100.0)
    };
    Panels::new("Force and displacement over time")
        .summary("Force and displacement over time, regions shaded")
        .plot(shaded(panel("force", "N", trace.force()), &spans, true))
        .plot(shaded(panel("displacement", "mm", trace.displacement()), &spans, false))
}
