//! Where the misfit sat, and where what is left sits.

use super::DiagnosisSummary;
use crate::criticism::compare::Comparison;
use crate::criticism::residuals::Stretch;
use crate::report::number::significant;
use crate::report::{Axis, Colour, HeatMap, Panels, Plot, Section, Series};
use crate::summary::compare::{heat_map, spans};

/// Most traces whose residual is drawn.
const MOST_DRAWN: usize = 4;

impl DiagnosisSummary<'_> {
    /// Heat maps and residuals over time, before and after.
    pub(super) fn places(&self) -> Section {
        let steps = &self.diagnosis.found.steps;
        let mut section = Section::new("Where it sits").paragraph(format!(
            "{}: {}",
            if steps.is_empty() { "What the model leaves" } else { "Without the effects found" },
            self.before.in_words()
        ));
        section = section.figure(self.map(&self.before, &self.base_name()), "");
        if !steps.is_empty() {
            let name = self.top_name();
            section = section.figure(
                self.map(&self.after, &name),
                "What is left beyond the noise is small here where the error is that of the noise: its \
                 shares then mean little.",
            );
        }
        for trace in self.worst() {
            section = section.figure(self.residuals(trace), "");
        }
        section
    }

    /// The model with all effects found.
    fn top_name(&self) -> String {
        let steps = self.diagnosis.found.steps.iter().map(|step| step.effect.clone());
        std::iter::once(self.base_name()).chain(steps).collect::<Vec<_>>().join(" + ")
    }

    fn map(&self, comparison: &Comparison, model: &str) -> HeatMap {
        let title = format!(
            "Share of what {model} leaves beyond the noise (error {} {})",
            self.level(comparison.rms),
            self.unit()
        );
        HeatMap { title, ..heat_map(comparison) }
    }

    /// The traces with the most of the misfit before, the worst first.
    fn worst(&self) -> Vec<usize> {
        let share = |trace: usize| -> f64 {
            let own = self.before.cells.iter().filter(|cell| cell.trace == trace);
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
        let plots = self.panels(trace);
        let most = |comparison: &Comparison| {
            let own = comparison.stretches.iter().filter(|stretch| stretch.trace == trace);
            own.flat_map(Stretch::residual).fold(0.0, |most: f64, r| most.max(r.abs()))
        };
        let most = 1.05 * most(&self.before).max(most(&self.after));
        let mut panels = Panels::new(label.as_str()).summary(format!(
            "{label}: the residual over time, {}",
            plots
                .iter()
                .map(|(name, comparison)| {
                    let rms = significant(comparison.trace_rms[trace], 3);
                    format!("{rms} {} RMS with {name}", self.unit())
                })
                .collect::<Vec<_>>()
                .join(" and ")
        ));
        for (index, (name, comparison)) in plots.iter().enumerate() {
            panels = panels.plot(self.residual(trace, name, comparison, most, index == 0));
        }
        panels
    }

    fn panels(&self, _: usize) -> Vec<(String, &Comparison)> {
        let mut plots = vec![(self.base_name(), &self.before)];
        if !self.diagnosis.found.steps.is_empty() {
            plots.push((self.top_name(), &self.after));
        }
        plots
    }

    fn residual(
        &self,
        trace: usize,
        name: &str,
        comparison: &Comparison,
        most: f64,
        first: bool,
    ) -> Plot {
        let noise = self.noise();
        let axis = Axis::new("measured − model", self.unit()).range(-most, most);
        let mut plot = Plot::new(name, Axis::new("time", "s"), axis).height(150.0);
        for stretch in comparison.stretches.iter().filter(|stretch| stretch.trace == trace) {
            plot = plot.series(
                Series::line("residual", &stretch.time[..], stretch.residual())
                    .colour(Colour::RESIDUAL),
            );
            for (from, to, region) in spans(&stretch.time, &stretch.regions) {
                plot = plot.span(from, to, if first { region.name() } else { "" });
            }
        }
        plot.level(noise, "noise").level(-noise, "")
    }
}
