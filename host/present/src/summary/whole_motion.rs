//! The fit of a law to whole motions, as tables and plots.

use super::{estimate, name_of, unit_of};
use palpate_fit::data::Data;
use palpate_fit::warning::warnings;
use palpate_fit::whole_motion::{Basis, MotionFit, over_traces, predict};
use palpate_model::{Family, Kernel, Model};
use palpate_report::number::significant;
use palpate_report::{Axis, Block, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::{Noise, Source};

/// Most traces that a report draws one by one.
const MOST_DRAWN: usize = 12;

/// A fit with all that is told about it.
pub struct FitSummary<'a> {
    /// The fit.
    pub fit: &'a MotionFit,
    /// What was fitted.
    pub data: &'a Data<'a>,
    /// The column that was fitted.
    pub signal: &'a str,
    /// The noise of that column, where it can be told without the model.
    pub noise: Option<Noise>,
    /// Root mean square error on each trace left out of the fit in turn; empty for a single trace.
    pub held_out: &'a [f64],
    /// Fits with other numbers of exponentials that this one was chosen from.
    pub candidates: &'a [MotionFit],
}

impl FitSummary<'_> {
    /// Root mean square error over all traces left out in turn.
    #[must_use]
    pub fn held_out_rms(&self) -> Option<f64> {
        over_traces(self.held_out, self.data)
    }

    /// The model file of this fit.
    #[must_use]
    pub fn model(&self) -> Model {
        let noise = self.noise.map(|noise| noise.standard_deviation);
        self.fit.model(self.data, noise, self.held_out)
    }

    /// What a reader should beware of.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let found = warnings(self.fit, self.data, self.noise.as_ref());
        found.iter().map(ToString::to_string).collect()
    }

    /// Parameters, quality, warnings; with plots of every trace.
    #[must_use]
    pub fn sections(&self) -> Vec<Section> {
        let fit = self.fit;
        let mut parameters = Section::new(fit.chain.base.in_words())
            .paragraph(self.stop_in_words())
            .table(self.parameter_table())
            .table(self.quality_table());
        for warning in self.warnings() {
            parameters = parameters.callout(Callout::Warning, "Beware", warning);
        }
        if self.candidates.len() > 1 {
            parameters = parameters.table(self.candidate_table());
        }
        parameters = parameters.block(Block::Details {
            summary: "Correlations of the parameters".into(),
            blocks: vec![Block::Table(self.correlation_table())],
        });
        let mut traces = Section::new("Each trace").table(self.trace_table());
        for index in 0..self.data.labels.len().min(MOST_DRAWN) {
            traces = traces.figure(self.panels(index), "");
        }
        if self.data.labels.len() > MOST_DRAWN {
            traces = traces.paragraph(format!(
                "The first {MOST_DRAWN} of {} traces are drawn.",
                self.data.labels.len()
            ));
        }
        vec![parameters, traces]
    }

    fn stop_in_words(&self) -> String {
        format!(
            "{} trace{}, {} samples; {} after {} steps.",
            self.data.labels.len(),
            if self.data.labels.len() == 1 { "" } else { "s" },
            self.fit.samples,
            self.fit.stop,
            self.fit.iterations,
        )
    }

    fn parameter_table(&self) -> Table {
        let fit = self.fit;
        let columns = vec![
            Column::text("parameter"),
            Column::number("value ± standard error", ""),
            Column::text("unit"),
            Column::text("meaning"),
        ];
        let mut table = Table::new("Parameters", columns);
        for (k, parameter) in fit.parameters().iter().enumerate() {
            let value = estimate(fit.values[k], fit.standard_errors[k]);
            table =
                table.row([&parameter.name, value.as_str(), &parameter.unit, &parameter.meaning]);
        }
        if fit.chain.base.family == Family::FUNG && fit.chain.base.kernel != Kernel::NONE {
            let shares = fit.chain.base.constants(&fit.values).shares;
            let rest = significant(1.0 - shares.iter().sum::<f64>(), 4);
            table = table.row(["c0", &rest, "", "share that never relaxes, 1 − Σ ci"]);
        }
        if fit.basis == Basis::Traces {
            table = table.note(format!(
                "Standard errors from the scatter of refits without each of the {} traces (jackknife).",
                self.data.labels.len()
            ));
        } else if fit.autocorrelation > 0.02 {
            table = table.note(format!(
                "Neighbouring residuals correlate by {:.2}; the standard errors allow for it.",
                fit.autocorrelation
            ));
        }
        table
    }

    fn quality_table(&self) -> Table {
        let unit = unit_of(self.signal);
        let columns =
            vec![Column::text("quality"), Column::number("value", ""), Column::text("unit")];
        let mut table = Table::new("", columns)
            .row(["R²", &format!("{:.5}", self.fit.r_squared), ""])
            .row(["residual RMS", &significant(self.fit.rms(), 4), unit]);
        if let Some(noise) = &self.noise {
            let floor = significant(noise.standard_deviation, 4);
            let source = match noise.source {
                Source::BeforeTouch => "the rest before the touch",
                Source::WayIn => "the way to the first touch",
                Source::Holds => "second differences in the holds",
                Source::WholeTrace => "second differences of the whole trace",
            };
            table = table
                .row(["noise floor", &floor, unit])
                .note(format!("Noise from {source}, {} samples.", noise.samples));
        }
        if let Some(rms) = self.held_out_rms() {
            table = table
                .row(["held-out RMS", &significant(rms, 4), unit])
                .note("Held out: each trace predicted by a fit to the others.");
        }
        table
    }

    fn candidate_table(&self) -> Table {
        let unit = unit_of(self.signal);
        let columns = vec![
            Column::whole("exponentials"),
            Column::number("residual RMS", unit),
            Column::number("R²", ""),
            Column::number("BIC over the best", ""),
        ];
        let best = self.candidates.iter().map(MotionFit::bic).fold(f64::INFINITY, f64::min);
        let mut table = Table::new("Number of exponentials", columns);
        for candidate in self.candidates {
            table = table.row([
                candidate.chain.base.terms.to_string(),
                significant(candidate.rms(), 5),
                format!("{:.6}", candidate.r_squared),
                format!("{:.1}", candidate.bic() - best),
            ]);
        }
        table.note("The Bayesian information criterion (BIC) decides: least is best.")
    }

    fn correlation_table(&self) -> Table {
        let parameters = self.fit.parameters();
        let names: Vec<&str> = parameters.iter().map(|p| p.name.as_ref()).collect();
        let columns = std::iter::once(Column::text(""))
            .chain(names.iter().map(|name| Column::number(*name, "")))
            .collect();
        let mut table = Table::new("Correlations", columns);
        for (i, name) in names.iter().enumerate() {
            let cells = (0..=i).map(|j| format!("{:.2}", self.fit.correlation[(i, j)]));
            table = table.row(std::iter::once((*name).to_owned()).chain(cells));
        }
        table
    }

    fn trace_table(&self) -> Table {
        let unit = unit_of(self.signal);
        let columns = vec![
            Column::text("trace"),
            Column::number("residual RMS", unit),
            Column::number("held-out RMS", unit),
        ];
        let mut table = Table::new("Error of each trace", columns);
        for (k, label) in self.data.labels.iter().enumerate() {
            let held_out = self.held_out.get(k).map_or("–".into(), |rms| significant(*rms, 4));
            table = table.row([label.clone(), significant(self.fit.trace_rms[k], 4), held_out]);
        }
        table
    }

    /// Measurement and model above, what is left below.
    fn panels(&self, trace: usize) -> Panels {
        let predicted = predict(&self.fit.chain, &self.fit.values, self.data);
        let (mut time, mut measured, mut model, mut residual) = (vec![], vec![], vec![], vec![]);
        let pieces = self.data.pieces.iter().zip(&predicted);
        for (piece, predicted) in pieces.filter(|(piece, _)| piece.trace == trace) {
            time.extend(piece.recorded_time());
            measured.extend_from_slice(piece.measured);
            model.extend_from_slice(predicted);
            residual.extend(piece.measured.iter().zip(predicted).map(|(y, f)| y - f));
        }
        let (name, unit) = (name_of(self.signal), unit_of(self.signal));
        let seconds = || Axis::new("time", "s");
        let overlay = Plot::new("", seconds(), Axis::new(&name, unit))
            .series(Series::line("measured", time.clone(), measured).colour(Colour::MEASURED))
            .series(Series::line("model", time.clone(), model).colour(Colour::MODEL).width(1.8));
        let mut left = Plot::new("", seconds(), Axis::new("residual", unit))
            .series(Series::line("residual", time, residual).colour(Colour::RESIDUAL))
            .height(140.0);
        if let Some(noise) = &self.noise {
            left =
                left.level(noise.standard_deviation, "noise").level(-noise.standard_deviation, "");
        }
        let label = &self.data.labels[trace];
        Panels::new(label.as_str())
            .summary(format!(
                "{label}: {name} measured and predicted, and the residual of {} {unit} RMS",
                significant(self.fit.trace_rms[trace], 3)
            ))
            .plot(overlay)
            .plot(left)
    }
}
