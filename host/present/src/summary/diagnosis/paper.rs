//! A diagnosis as one figure for a paper: before, verdict, after.

use super::{DiagnosisSummary, Verdict};
use palpate_diagnose::criticism::leftover::Leftover;
use palpate_report::{Axis, Bars, Colour, Figure, Panels, Plot, Series, Sheet, stacked};

/// Heights, user units: all of it fits on a page of A4.
const SIGNAL: f64 = 130.0;
const RESIDUAL: f64 = 115.0;

impl DiagnosisSummary<'_> {
    /// The trace with most of the misfit under the model as it was, the verdict with the ladder, and the same trace with what was
    /// found: one sheet. Before and after are on one scale.
    #[must_use]
    pub fn paper_figure(&self) -> Sheet {
        let verdict = self.headline();
        let trace = self.worst().first().copied().unwrap_or(0);
        let label = &self.data.labels[trace];
        let models = self.models();
        let most = self.most_left(trace);
        let mut figures: Vec<Figure> = Vec::new();
        for ((name, left), when) in models.iter().zip(["Before", "After"]) {
            let title = format!("{when}: {label} with {name}");
            figures.push(self.beside(trace, &title, left, most).into());
        }
        let bars = Bars { title: verdict.clone(), ..self.ladder_bars() };
        figures.insert(1, bars.into());
        stacked("What the model lacks", &verdict, &figures)
    }

    /// The verdict in a sentence or two.
    fn headline(&self) -> String {
        let (unit, noise) = (self.unit(), self.noise());
        let base = &self.diagnosis.found.base;
        let text = match self.diagnosis.verdict {
            Verdict::Named | Verdict::Ambiguous => format!("{} {}", self.missing(), self.fall()),
            Verdict::Adequate => format!(
                "Nothing is missing: it leaves {} {unit}, the noise is {} {unit}.",
                self.level(base.rms()),
                self.level(noise)
            ),
            Verdict::Unknown => format!(
                "No effect of the library explains what is missing. It leaves {} {unit}, the noise is {} {unit}.",
                self.level(self.diagnosis.found.model().rms()),
                self.level(noise)
            ),
        };
        text.replace('`', "")
    }

    /// A trace with a model over it, and the residual below.
    fn beside(&self, trace: usize, title: &str, of: &Leftover, most: f64) -> Panels {
        let signal = Axis::new("signal", self.unit());
        let mut above = Plot::new("", Axis::new("time", "s"), signal).height(SIGNAL);
        for (index, stretch) in of.residuals.of_trace(trace).iter().enumerate() {
            // One entry each in the legend, however many stretches.
            let name = |text: &str| if index == 0 { text.to_owned() } else { String::new() };
            let time = || &stretch.time[..];
            above = above
                .series(
                    Series::line(name("measured"), time(), &stretch.measured[..])
                        .colour(Colour::MEASURED),
                )
                .series(
                    Series::line(name("model"), time(), &stretch.predicted[..])
                        .colour(Colour::MODEL),
                );
        }
        let below = Plot { title: String::new(), ..self.residual(trace, "", of, most, true) };
        let summary = format!("{title}: measured, model and residual over time");
        Panels::new(title).summary(summary).plot(above).plot(below.height(RESIDUAL))
    }
}
