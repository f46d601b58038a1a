//! The way up the ladder, rung by rung.

use std::path::Path;

use super::{DiagnosisSummary, listed, rung_name};
use palpate_diagnose::criticism::diagnose::Verdict;
use palpate_diagnose::criticism::search::Step;
use palpate_report::{Block, Callout, Section};

impl DiagnosisSummary<'_> {
    /// Every rung on a line, why it ends there, and the effects found. `written` is the file of the
    /// model at the top.
    #[must_use]
    pub fn exploration(&self, written: Option<&Path>) -> Vec<Section> {
        let mut top = Section::new("The ladder").block(Block::Code(self.rung_lines().join("\n")));
        let (kind, text) = self.end();
        top = top.callout(kind, "The end", text);
        for note in &self.diagnosis.notes {
            top = top.callout(Callout::Warning, "Note", super::sentence(note));
        }
        for (text, command) in self.after_the_end(written) {
            top = top.paragraph(text);
            if let Some(command) = command {
                top = top.block(Block::Code(command));
            }
        }
        let steps = 0..self.diagnosis.found.steps.len();
        std::iter::once(top).chain(steps.map(|index| self.step_in_short(index))).collect()
    }

    fn rung_lines(&self) -> Vec<String> {
        let unit = self.unit();
        let rungs = self.rungs();
        let names: Vec<String> = rungs.iter().enumerate().map(rung_name).collect();
        let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        let mut lines = Vec::new();
        for (index, rung) in rungs.iter().enumerate() {
            let below = index.checked_sub(1).map(|below| &rungs[below]);
            let fall = |from: Option<f64>, to: f64| match from {
                Some(from) => format!("{} → {} {unit}", self.level(from), self.level(to)),
                None => format!("{} {unit}", self.level(to)),
            };
            let mut line = format!(
                "rung {index}: {:<width$}   error {}",
                names[index],
                fall(below.map(|rung| rung.fitted_rms), rung.fitted_rms)
            );
            if let Some(rms) = rung.heldout_rms {
                line +=
                    &format!(", held out {}", fall(below.and_then(|rung| rung.heldout_rms), rms));
            }
            lines.push(line);
        }
        let mut line = |name: &str, level: f64| {
            lines.push(format!("{name:<12}{:<width$}     {} {unit}", "", self.level(level)));
        };
        line("noise:", self.noise());
        if let Some(discrepancy) = self.discrepancy() {
            line("discrepancy:", discrepancy);
        }
        lines
    }

    /// Why the ladder ends here.
    fn end(&self) -> (Callout, String) {
        let steps = &self.diagnosis.found.steps;
        let noise = self.rest_in_words().replace("What remains is noise.", "Only noise is left.");
        match self.diagnosis.verdict {
            Verdict::Adequate | Verdict::Named if self.suspect_rest() => (Callout::Warning, noise),
            Verdict::Adequate => (Callout::Finding, format!("{noise} Nothing needs to be added.")),
            Verdict::Named => (Callout::Finding, noise),
            Verdict::Ambiguous => {
                let undecided = steps.iter().filter(|step| step.credible.len() > 1);
                let sets: Vec<String> =
                    undecided.map(|step: &Step| listed(&step.credible, "or")).collect();
                let text = format!(
                    "{noise} But these traces do not distinguish whether it is {}.",
                    sets.join(", and whether it is ")
                );
                (Callout::Warning, text)
            }
            Verdict::Unknown => {
                let text = format!(
                    "It does not know what is missing: no effect of the library explains the rest. {}",
                    self.place_in_words()
                );
                (Callout::Warning, text)
            }
        }
    }

    /// What to do then.
    fn after_the_end(&self, written: Option<&Path>) -> Vec<(String, Option<String>)> {
        let mut next: Vec<(String, Option<String>)> = Vec::new();
        match written.map(|path| path.display().to_string()) {
            Some(model) => {
                next.push((format!("See what {model} leaves:"), Some(self.next.compare(&model))));
            }
            None if !self.diagnosis.found.steps.is_empty() => {
                next.push(("Keep the model:".into(), Some(self.next.explore())));
            }
            None => {}
        }
        next.extend(self.experiment_in_words());
        if self.diagnosis.verdict == Verdict::Unknown {
            next.push(self.law_of_ones_own());
        }
        next
    }
}
