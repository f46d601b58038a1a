//! Where the misfit sat, and where what is left sits.

use super::DiagnosisSummary;
use crate::summary::compare::{heat_map, spans};
use palpate_diagnose::criticism::compare::Cell;
use palpate_diagnose::criticism::dependence::Bin;
use palpate_diagnose::criticism::diagnose::Verdict;
use palpate_diagnose::criticism::leftover::Leftover;
use palpate_diagnose::criticism::leftover_curve::LeftoverCurve;
use palpate_diagnose::criticism::region::Region;
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Colour, HeatMap, Panels, Plot, Section, Series};

/// Most traces whose residual is drawn.
const MOST_DRAWN: usize = 4;
/// What the curve of the rest is for.
const CURVE: &str = "Its cubics are the law of one's own that is offered above.";
/// Most regions of a trace whose names are shown.
const MOST_NAMED: usize = 8;

impl DiagnosisSummary<'_> {
    /// Heat maps and residuals over time, before and after.
    pub(super) fn places(&self) -> Section {
        let steps = &self.diagnosis.found.steps;
        let mut section = Section::new("Where it sits").paragraph(format!(
            "{}: {}",
            if steps.is_empty() { "What the model leaves" } else { "Without the effects found" },
            self.before().comparison.in_words()
        ));
        let before = heat_map(&self.before().comparison);
        let strongest = before.values.iter().flatten().copied().fold(0.0, f64::max);
        let title = format!("Share of what {} leaves beyond the noise", self.base_name());
        if !self.before().comparison.only_noise {
            section = section.figure(HeatMap { title, ..before.clone() }, "");
        }
        if !steps.is_empty() {
            let title = format!("What {} still leaves of that", self.top_name());
            let (values, summary) = (self.still_left(), self.after().comparison.in_words());
            let strongest = Some(strongest);
            let map = HeatMap { title, values, summary, strongest, ..before };
            section = section.figure(map, "In the same unit and colours: all above is 100 %.");
        }
        for trace in self.worst() {
            section = section.figure(self.residuals(trace), "");
        }
        match self.curve().filter(|_| self.diagnosis.verdict == Verdict::Unknown) {
            Some(curve) => section.figure(self.curve_plot(curve), CURVE),
            None => section,
        }
    }

    /// The mean residual over the quantity it depends on most, each way by itself.
    fn curve_plot(&self, curve: &LeftoverCurve) -> Plot {
        let unit = self.unit();
        let name = curve.covariate.name();
        let series = |way: &str, bins: &[Bin], colour| {
            let column = |value: fn(&Bin) -> f64| bins.iter().map(value).collect::<Vec<f64>>();
            Series::line(way, column(|bin| bin.at), column(|bin| bin.mean)).colour(colour)
        };
        let split = !curve.loading.is_empty() && !curve.unloading.is_empty();
        Plot::new(
            format!("Mean residual over the {name}"),
            Axis::new(name, curve.covariate.unit(unit)),
            Axis::new("mean residual", unit),
        )
        .summary(format!(
            "Mean residual over the {name}{}; cubics through it explain {}",
            if split { ", pressed and released" } else { "" },
            percent(curve.explained, 2)
        ))
        .series(series("pressed", &curve.loading, Colour::Hue(0)))
        .series(series("released", &curve.unloading, Colour::Hue(1)))
        .level(0.0, "")
        .height(200.0)
    }

    /// The model with all effects found.
    fn top_name(&self) -> String {
        let steps = self.diagnosis.found.steps.iter().map(|step| step.effect.clone());
        std::iter::once(self.base_name()).chain(steps).collect::<Vec<_>>().join(" + ")
    }

    /// What is left beyond the noise in every region of every trace, as a share of all that was there
    /// before.
    fn still_left(&self) -> Vec<Vec<f64>> {
        let noise = self.noise();
        let excess =
            |cell: &Cell| ((cell.rms * cell.rms - noise * noise) * cell.samples as f64).max(0.0);
        let all: f64 = self.before().comparison.cells.iter().map(excess).sum();
        let mut values = vec![vec![f64::NAN; Region::ALL.len()]; self.data.labels.len()];
        for cell in &self.after().comparison.cells {
            values[cell.trace][cell.region as usize] =
                if all > 0.0 { excess(cell) / all } else { 0.0 };
        }
        values
    }

    /// The traces with the most of the misfit before, the worst first.
    pub(super) fn worst(&self) -> Vec<usize> {
        let share = |trace: usize| -> f64 {
            let own = self.before().comparison.cells.iter().filter(|cell| cell.trace == trace);
            own.map(|cell| cell.share_of_excess).sum()
        };
        let mut traces: Vec<usize> = (0..self.data.labels.len()).collect();
        traces.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
        traces.truncate(MOST_DRAWN);
        traces
    }

    /// The residual of one trace over time, before above after, on one scale.
    fn residuals(&self, trace: usize) -> Panels {
        let label = &self.data.labels[trace];
        let plots = self.models();
        let most = self.most_left(trace);
        let mut panels = Panels::new(label.as_str()).summary(format!(
            "{label}: the residual over time, {}",
            plots
                .iter()
                .map(|(name, left)| {
                    let rms = significant(left.comparison.trace_rms[trace], 3);
                    format!("{rms} {} RMS with {name}", self.unit())
                })
                .collect::<Vec<_>>()
                .join(" and ")
        ));
        for (index, (name, left)) in plots.iter().enumerate() {
            panels = panels.plot(self.residual(trace, name, left, most, index == 0));
        }
        panels
    }

    /// The largest residual of a trace before and after, with a little room.
    pub(super) fn most_left(&self, trace: usize) -> f64 {
        let both = [self.before(), self.after()];
        let stretches = both.iter().flat_map(|left| left.residuals.of_trace(trace));
        let residual = stretches.flat_map(|stretch| stretch.residual());
        1.05 * residual.fold(0.0, |most: f64, r| most.max(r.abs()))
    }

    /// The model before and after, each with what it leaves.
    pub(super) fn models(&self) -> Vec<(String, &Leftover<'_>)> {
        let mut plots = vec![(self.base_name(), self.before())];
        if !self.diagnosis.found.steps.is_empty() {
            plots.push((self.top_name(), self.after()));
        }
        plots
    }

    pub(super) fn residual(
        &self,
        trace: usize,
        name: &str,
        left: &Leftover,
        most: f64,
        first: bool,
    ) -> Plot {
        let noise = self.noise();
        let axis = Axis::new("residual", self.unit()).range(-most, most);
        let mut plot = Plot::new(name, Axis::new("time", "s"), axis).height(175.0);
        for stretch in left.residuals.of_trace(trace) {
            plot = plot.series(
                Series::line("residual", &stretch.time[..], stretch.residual())
                    .colour(Colour::RESIDUAL),
            );
            let spans = spans(&stretch.time, &stretch.regions);
            // Names of many short regions would cover the plot.
            let named = first && spans.len() <= MOST_NAMED;
            for (from, to, region) in spans {
                plot = plot.span(from, to, if named { region.name() } else { "" });
            }
        }
        plot.level(noise, "noise").level(-noise, "")
    }
}
