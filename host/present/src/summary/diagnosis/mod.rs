//! A diagnosis as words, tables and plots.
//!
//! - [`words`]: the verdict and what to do next.
//! - [`step`]: the evidence for one effect.
//! - [`candidates`]: every effect, ranked.
//! - [`places`]: where the misfit sat and sits.
//! - [`refused`]: what was tried and refused.
//! - [`rest`]: what is left beside the noise, and how all was done.
//! - [`explore`]: the way up the ladder.
//! - [`paper`]: all in one figure.

mod candidates;
mod explore;
mod paper;
mod places;
mod refused;
mod rest;
mod step;
mod words;

use std::cell::OnceCell;

pub(crate) use candidates::Ranked;

use super::ladder::{ABOUT, ladder_bars, rung_name};
use super::unit_of;
use palpate_diagnose::criticism::diagnose::{Diagnosis, Verdict};
use palpate_diagnose::criticism::explore::rungs;
use palpate_diagnose::criticism::leftover::{Leftover, leftover};
use palpate_diagnose::criticism::leftover_curve::LeftoverCurve;
use palpate_diagnose::criticism::screen::DRAWS;
use palpate_diagnose::criticism::search::DECISIVE;
use palpate_fit::data::Data;
use palpate_fit::fold::Fold;
use palpate_model::Rung;
use palpate_report::number::significant;
use palpate_report::{Block, Callout, Column, Level, Section, Table};

/// Decimals beyond which an error is written as a power of ten.
const MOST_DECIMALS: f64 = 9.0;
/// Relative change of the error by a refit that is worth a word.
const MOVED: f64 = 0.005;

/// A diagnosis with all that is told about it.
pub struct DiagnosisSummary<'a> {
    pub(crate) diagnosis: &'a Diagnosis,
    pub(crate) data: &'a Data<'a>,
    /// What the model leaves without the effects found, once asked for.
    before: OnceCell<Leftover<'a>>,
    /// What it leaves with them, once asked for.
    after: OnceCell<Leftover<'a>>,
    /// That as a curve over what it depends on most, once asked for.
    curve: OnceCell<Option<LeftoverCurve>>,
    next: NextCommand,
}

/// How model and traces were named, so that the next command can be told.
#[derive(Clone, Debug)]
pub struct NextCommand {
    /// The model file.
    pub model: String,
    /// The traces, as on the command line.
    pub traces: String,
}

impl NextCommand {
    /// Puts a law of one's own, a candidate of another model file, into that model.
    pub(super) fn add_to(&self, name: &str, model: &str) -> String {
        format!("palpate add {name} {model} {} -o better.toml", self.traces)
    }

    /// Puts one effect into the model.
    fn add(&self, effect: &str, law: Option<&str>) -> String {
        let law = law.map(|law| format!(" --law {law}")).unwrap_or_default();
        format!("palpate add {effect} {} {}{law} -o better.toml", self.model, self.traces)
    }

    /// Puts all effects found into the model.
    fn explore(&self) -> String {
        format!("palpate explore --model {} {} -o better.toml", self.model, self.traces)
    }

    /// Sees where a model fails.
    fn compare(&self, model: &str) -> String {
        format!("palpate compare {model} {}", self.traces)
    }

    /// Diagnoses again.
    pub(super) fn diagnose(&self) -> String {
        format!("palpate diagnose --model {} {}", self.model, self.traces)
    }
}

impl<'a> DiagnosisSummary<'a> {
    /// Lays a diagnosis beside the data it was made of.
    #[must_use]
    pub fn new(diagnosis: &'a Diagnosis, data: &'a Data<'a>, next: NextCommand) -> Self {
        let (before, after, curve) = (OnceCell::new(), OnceCell::new(), OnceCell::new());
        Self { diagnosis, data, before, after, curve, next }
    }

    /// What the model leaves without the effects found.
    fn before(&self) -> &Leftover<'a> {
        let base = &self.diagnosis.found.base;
        self.before.get_or_init(|| leftover(self.diagnosis, base, self.data))
    }

    /// What it leaves with them.
    pub(crate) fn after(&self) -> &Leftover<'a> {
        let found = &self.diagnosis.found;
        if found.steps.is_empty() {
            return self.before();
        }
        self.after.get_or_init(|| leftover(self.diagnosis, found.model(), self.data))
    }

    /// What a terminal shows: the verdict, what to do next, the ladder and the evidence in short.
    #[must_use]
    pub fn in_short(&self) -> Vec<Section> {
        let mut sections = vec![self.verdict()];
        let steps = 0..self.diagnosis.found.steps.len();
        sections.extend(steps.map(|index| self.step_in_short(index)));
        sections
    }

    /// What a report shows: all.
    #[must_use]
    pub fn sections(&self) -> Vec<Section> {
        let mut verdict = self.verdict();
        if !self.diagnosis.found.steps.is_empty() {
            verdict = verdict.figure(self.ladder_bars(), ABOUT);
        }
        let mut sections = vec![verdict];
        let steps = 0..self.diagnosis.found.steps.len();
        sections.extend(steps.map(|index| self.step(index)));
        sections.push(self.candidates());
        if let Some(table) = self.refused_table() {
            sections.push(Section::new("What was tried and refused").table(table));
        }
        sections.push(self.places());
        sections.push(self.rest());
        sections
    }

    fn verdict(&self) -> Section {
        let kind = match self.diagnosis.verdict {
            _ if self.suspect_rest() => Callout::Warning,
            Verdict::Adequate | Verdict::Named => Callout::Finding,
            Verdict::Ambiguous | Verdict::Unknown => Callout::Warning,
        };
        let title = match self.diagnosis.verdict {
            Verdict::Adequate => "Adequate",
            Verdict::Named => "Named",
            Verdict::Ambiguous => "Ambiguous",
            Verdict::Unknown => "Unknown",
        };
        let mut section = Section::new("Verdict").callout(kind, title, self.verdict_in_words());
        for (text, command) in self.what_next() {
            section = section.paragraph(text);
            if let Some(command) = command {
                section = section.block(Block::Code(command));
            }
        }
        for note in &self.diagnosis.notes {
            section = section.callout(Callout::Warning, "Note", sentence(note));
        }
        for what in &self.data.left_out {
            section = section.callout(Callout::Warning, "Left out", what.clone());
        }
        section.table(self.ladder_table())
    }

    fn rungs(&self) -> Vec<Rung> {
        let mut rungs = rungs(self.diagnosis);
        if let Some(first) = rungs.first_mut() {
            first.add = self.base_name();
        }
        rungs
    }

    /// The model that was diagnosed: its law and the effects that it had.
    fn base_name(&self) -> String {
        let chain = &self.diagnosis.found.base.chain;
        let names = chain.effects.iter().map(|effect| effect.name.as_str());
        std::iter::once(chain.base.name()).chain(names).collect::<Vec<_>>().join(" + ")
    }

    fn ladder_table(&self) -> Table {
        let unit = self.unit();
        let found = &self.diagnosis.found;
        let noise = self.noise();
        let mut columns = vec![
            Column::text("model"),
            Column::number("error", unit),
            Column::number("held out", unit),
            Column::number("error / noise", ""),
        ];
        if !found.steps.is_empty() {
            columns.extend([Column::number("ΔBIC", ""), Column::number("p value", "")]);
        }
        let mut table = Table::new("The ladder", columns);
        let models: Vec<_> = std::iter::once(&found.base).chain(&found.models).collect();
        for (index, rung) in self.rungs().iter().enumerate() {
            let mut cells = vec![
                rung_name((index, rung)),
                self.level(rung.fitted_rms),
                rung.heldout_rms.map_or("–".into(), |rms| self.level(rms)),
                format!("{:.2}", rung.fitted_rms / noise),
            ];
            if let Some(step) = index.checked_sub(1) {
                let fell = models[step].bic() - models[index].bic();
                cells.extend([format!("{fell:.0}"), significant(found.steps[step].p_value, 2)]);
            }
            table = table.row(cells);
        }
        let traces = self.data.labels.len();
        let held_out = match Fold::count(traces) {
            1 => "One trace: none can be held out.".to_owned(),
            folds if folds < traces => {
                format!(
                    "Held out: each of {folds} folds of the traces predicted by a fit to the others."
                )
            }
            _ => "Held out: each trace predicted by a fit to the others.".to_owned(),
        };
        table = table.note(format!("Noise: {} {unit}. {held_out}", self.level(noise)));
        if let Some(discrepancy) = self.discrepancy() {
            table = table.note(format!(
                "Discrepancy: {} {unit}, what the last model leaves beyond the noise: how inexact its law is.",
                self.level(discrepancy)
            ));
        }
        if let Some(moved) = self.refit_in_words() {
            table = table.note(moved);
        }
        if found.steps.is_empty() {
            return table;
        }
        table.note(format!(
            "ΔBIC: fall of the Bayesian information criterion; {DECISIVE:.0} is decisive. p value: chance that \
             noise alone shows as much anywhere in the library, {} at the least.",
            significant(1.0 / (DRAWS + 1) as f64, 2)
        ))
    }

    /// What the refit to whitened residuals, on which the evidence rests, did to the error of the model.
    fn refit_in_words(&self) -> Option<String> {
        let (given, refitted) = (self.diagnosis.given_rms, self.diagnosis.found.base.rms());
        let moved = (refitted / given - 1.0).abs() > MOVED;
        moved.then(|| {
            format!(
                "The model as it was given leaves {} {unit}. Here it is refitted so that the noise counts as \
                 white, which p values and ΔBIC ask for: its parameters moved, and it leaves {} {unit}.",
                self.level(given),
                self.level(refitted),
                unit = self.unit(),
            )
        })
    }

    fn ladder_bars(&self) -> palpate_report::Bars {
        let mut bars = ladder_bars(&self.rungs(), self.unit(), Some(self.noise()));
        let level = |y| Level { y, label: "discrepancy".into() };
        bars.levels.extend(self.discrepancy().map(level));
        bars
    }

    /// What the last model leaves beyond the noise; none where it leaves noise.
    fn discrepancy(&self) -> Option<f64> {
        Some(self.diagnosis.discrepancy).filter(|&discrepancy| discrepancy > 0.0)
    }

    pub(crate) fn unit(&self) -> &str {
        unit_of(&self.diagnosis.signal)
    }

    /// Standard deviation of the noise.
    pub(crate) fn noise(&self) -> f64 {
        self.diagnosis.noise.level
    }

    /// An error with as many decimals as the noise has in three significant digits.
    fn level(&self, rms: f64) -> String {
        let noise = self.noise();
        let decimals = if noise > 0.0 { (2.0 - noise.log10().floor()).max(0.0) } else { 5.0 };
        if decimals > MOST_DECIMALS {
            return significant(rms, 3);
        }
        format!("{rms:.0$}", decimals as usize)
    }
}

/// A remark as a sentence.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    format!("{first}{}.", letters.as_str().trim_end_matches('.'))
}

/// Names as `a`, `b` and `c`, with the word between the last two.
fn listed(names: &[String], word: &str) -> String {
    let coded: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match coded.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, before)) => format!("{} {word} {last}", before.join(", ")),
    }
}
