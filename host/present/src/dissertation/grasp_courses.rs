//! Figs 3.4 to 3.7 in kind: grasps of 4, 8 and 12 mm over time, and force over displacement.

use palpate_analysis::cycles::segment;
use palpate_report::{Axis, Colour, Panels, Plot, Section, Series};
use palpate_trace::Trace;

/// The figures of three grasps with their compression, mm, the largest first.
pub(super) fn section(grasps: &[(f64, &Trace)]) -> Section {
    let words = "Rebuilt from the sixth rows of Tables 3.1 to 3.3, which are (3.5) to (3.10). Only the hold is printed: \
                 loading and unloading are made up from the speed of 20 mm/s, and the force in them from the model.";
    let mut section = Section::new("Grasps over time")
        .paragraph(words)
        .figure(forces(grasps), "Fig. 3.4 in kind.");
    for ((compression, trace), number) in grasps.iter().zip(["3.5", "3.6", "3.7"]) {
        section = section
            .figure(course(trace), format!("Fig. {number} in kind: a grasp of {compression} mm over time."))
            .figure(
                looped(trace),
                format!("Fig. {number} in kind: force over displacement, with the points found by `palpate segment`."),
            );
    }
    section
}

fn forces(grasps: &[(f64, &Trace)]) -> Plot {
    let plot = Plot::new("", Axis::new("time", "s"), Axis::new("force", "N"))
        .summary("Force over time of grasps of three compressions: up, relaxing, off");
    grasps.iter().enumerate().fold(plot, |plot, (k, (compression, trace))| {
        let force = trace.force().unwrap_or_default();
        let line = Series::line(format!("{compression} mm"), &trace.time[..], force);
        plot.series(line.colour(Colour::Hue(k)))
    })
}

fn course(trace: &Trace) -> Panels {
    let line =
        |values: Option<&[f64]>| Series::line("", &trace.time[..], values.unwrap_or_default());
    let plot =
        |name: &str, unit: &str| Plot::new("", Axis::new("time", "s"), Axis::new(name, unit));
    Panels::new("")
        .summary("Force and displacement of one grasp over time")
        .plot(plot("force", "N").series(line(trace.force()).colour(Colour::MEASURED)))
        .plot(plot("displacement", "mm").series(line(trace.displacement())).height(130.0))
}

fn looped(trace: &Trace) -> Plot {
    let (x, force) = (trace.displacement().unwrap_or_default(), trace.force().unwrap_or_default());
    let mut plot = Plot::new("", Axis::new("displacement", "mm"), Axis::new("force", "N"))
        .summary("Loop of one grasp with the points between its regions")
        .series(Series::line("", x, force).colour(Colour::MEASURED));
    let found = segment(trace).map(|found| found.cycles).unwrap_or_default();
    for point in found.iter().flat_map(|cycle| &cycle.points) {
        plot = plot.annotation(point.displacement_mm, point.force_n, point.name.clone());
    }
    plot
}
