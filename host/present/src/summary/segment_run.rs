//! The simulation of 7.4 beside the force that was measured.

use super::rates::geometry_words;
use palpate_analysis::segment_run::SegmentRun;
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Colour, Panels, Plot, Section, Series};

/// What was simulated, how far it is off, and both forces over time.
#[must_use]
pub fn segment_run_section(run: &SegmentRun) -> Section {
    let setting = &run.setting;
    let largest = run.measured_n.iter().copied().fold(0.0, f64::max);
    let rate = if run.fitted { "fitted to this force" } else { "as asked" };
    let words = format!(
        "{} {} segments of {} mm from the face to what does not move relax by ε' = −ν (ε − εe)^{} with ν = {} 1/s, {rate}; \
         the force is E ε1 A with E = {} Pa (7.11). Root mean square difference {} N, {} of the largest force; with \
         this ν the modulus that fits best is {} Pa.",
        geometry_words(&setting.geometry),
        setting.segments,
        significant(setting.length_mm() / setting.segments as f64, 3),
        setting.order,
        significant(setting.rate, 3),
        significant(setting.modulus_pa, 3),
        significant(run.rms_n, 3),
        percent(run.rms_n / largest, 2),
        significant(run.best_modulus_pa, 3),
    );
    Section::new(format!("Simulated: {}", run.trace))
        .paragraph(words)
        .figure(figure(run), "As in Fig. 7.8: the motion is the recording's own.")
}

fn figure(run: &SegmentRun) -> Panels {
    let time = || Axis::new("time", "s");
    let force = Plot::new("", time(), Axis::new("force", "N"))
        .series(
            Series::line("measured", &run.time[..], &run.measured_n[..]).colour(Colour::MEASURED),
        )
        .series(Series::line("simulated", &run.time[..], &run.force_n[..]).colour(Colour::MODEL));
    let motion = Plot::new("", time(), Axis::new("displacement", "mm"))
        .series(Series::line("displacement", &run.time[..], &run.displacement_mm[..]))
        .height(130.0);
    Panels::new("")
        .summary("Measured and simulated force over time, and the displacement of both")
        .plot(force)
        .plot(motion)
}
