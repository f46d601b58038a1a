//! The evidence for one effect.

use super::super::estimate;
use super::DiagnosisSummary;
use palpate_diagnose::criticism::search::{DECISIVE, RESAMPLES, Rival, Step};
use palpate_model::effects::Law;
use palpate_model::{Applied, Parameter};
use palpate_report::number::{percent, significant};
use palpate_report::{Column, Section, Table};

impl DiagnosisSummary<'_> {
    /// Parameters and rivals.
    pub(super) fn step_in_short(&self, index: usize) -> Section {
        let step = &self.diagnosis.found.steps[index];
        let section = Section::new(&step.effect).table(self.parameter_table(index));
        if step.rivals.len() > 1 { section.table(self.rival_table(index, false)) } else { section }
    }

    /// What the effect is, what speaks for it, and what else it could be.
    pub(super) fn step(&self, index: usize) -> Section {
        let step = &self.diagnosis.found.steps[index];
        let mut section = Section::new(format!("Evidence for {}", step.effect));
        if let Some(effect) = self.diagnosis.options.effects.find(&step.effect) {
            section = section.paragraph(effect.meaning).paragraph(format!(
                "What it leaves in the residual of a model that lacks it: {}",
                effect.signature
            ));
        }
        section
            .table(self.evidence_table(index))
            .table(self.parameter_table(index))
            .table(self.rival_table(index, true))
    }

    pub(crate) fn applied(&self, index: usize) -> &Applied {
        let found = &self.diagnosis.found;
        &found.model().chain.effects[found.base.chain.effects.len() + index]
    }

    /// The law that was chosen, where it is one of the library and not its first.
    pub(super) fn law_beside_reference(&self, index: usize) -> Option<&str> {
        let first =
            self.diagnosis.options.effects.find(&self.diagnosis.found.steps[index].effect)?.laws[0]
                .name;
        Some(self.applied(index).law.as_str()).filter(|law| *law != first)
    }

    /// The law that was chosen, where the effect is one of the library.
    fn law(&self, index: usize) -> Option<&'static Law> {
        let effect =
            self.diagnosis.options.effects.find(&self.diagnosis.found.steps[index].effect)?;
        effect.laws.iter().find(|law| law.name == self.applied(index).law)
    }

    /// The parameters of the effect of a step in the last model, with value and standard error.
    pub(crate) fn parameters(&self, index: usize) -> Vec<(&Parameter, f64, Option<f64>)> {
        let found = &self.diagnosis.found;
        let range = found.model().chain.range(found.base.chain.effects.len() + index);
        let errors = &self.diagnosis.standard_errors;
        let declared = &self.applied(index).parameters;
        declared.iter().zip(range).map(|(p, k)| (p, found.model().values[k], errors[k])).collect()
    }

    fn parameter_table(&self, index: usize) -> Table {
        let step = &self.diagnosis.found.steps[index];
        let columns = vec![
            Column::text("parameter"),
            Column::number("value ± standard error", ""),
            Column::text("unit"),
            Column::text("meaning"),
        ];
        let law = self.law(index).map(|law| format!(": {}", law.formula));
        let mut table = Table::new(format!("{}{}", step.effect, law.unwrap_or_default()), columns);
        for (parameter, value, error) in self.parameters(index) {
            let given = if parameter.lower < parameter.upper { "" } else { " (given)" };
            table = table.row([
                parameter.name.to_string(),
                estimate(value, error),
                parameter.unit.to_string(),
                format!("{}{given}", parameter.meaning),
            ]);
        }
        table
    }

    fn evidence_table(&self, index: usize) -> Table {
        let (diagnosis, unit) = (self.diagnosis, self.unit());
        let found = &diagnosis.found;
        let step = &found.steps[index];
        let before = if index == 0 { &found.base } else { &found.models[index - 1] };
        let after = &found.models[index];
        let columns = vec![
            Column::text("evidence"),
            Column::text("without"),
            Column::text("with"),
            Column::text(""),
        ];
        let mut table = Table::new("", columns).row([
            &format!("error, {unit}"),
            &self.level(before.rms()),
            &self.level(after.rms()),
            &format!("noise {}", self.level(self.noise())),
        ]);
        if let (Some(before), Some(after)) =
            (&diagnosis.held_out[index], &diagnosis.held_out[index + 1])
        {
            let sure = if diagnosis.sure[index] {
                "gain beyond two standard errors over traces"
            } else {
                "gain within two standard errors over traces: not sure"
            };
            let (before, after) = (self.level(before.rms), self.level(after.rms));
            table = table.row([&format!("held out, {unit}"), &before, &after, sure]);
        }
        let fell = format!("{:.0}", before.bic() - after.bic());
        table
            .row(["ΔBIC", "", &fell, &format!("{DECISIVE:.0} is decisive")])
            .row([
                "p value",
                "",
                &significant(step.p_value, 2),
                "chance that noise alone shows as much",
            ])
            .row(["credible set", "", "", &step.credible.join(", ")])
    }

    /// What else it could be: what was refitted in its place and, if `all`, what it is known to be
    /// confused with.
    fn rival_table(&self, index: usize, all: bool) -> Table {
        let step = &self.diagnosis.found.steps[index];
        let columns = vec![
            Column::text("effect"),
            Column::number("error", self.unit()),
            Column::number("ΔBIC behind", ""),
            Column::number("wins", ""),
            Column::text("distinguished?"),
        ];
        let mut table = Table::new(format!("In place of {}", step.effect), columns);
        for rival in &step.rivals {
            table = table.row(self.rival(step, rival));
        }
        let known = self
            .diagnosis
            .options
            .effects
            .find(&step.effect)
            .map_or(&[][..], |effect| effect.confused_with);
        let refitted = |name: &str| step.rivals.iter().any(|rival| rival.effect == name);
        for name in known.iter().filter(|name| all && !refitted(name)) {
            let dash = || "–".to_owned();
            table =
                table.row([(*name).to_owned(), dash(), dash(), dash(), self.why_not(index, name)]);
        }
        table.note(format!(
            "Wins: share of {RESAMPLES} resamplings of the data in which it is best."
        ))
    }

    fn rival(&self, step: &Step, rival: &Rival) -> [String; 5] {
        let law = rival.law().unwrap_or_default();
        let form = if law == "reference" { String::new() } else { format!(" ({law})") };
        let behind = rival.fitted.bic() - step.rivals[0].fitted.bic();
        let is_refused = || self.diagnosis.found.refused.iter().any(|it| it.effect == rival.effect);
        let told = if rival.effect == step.effect {
            "named"
        } else if step.credible.contains(&rival.effect) {
            "no"
        } else if behind >= 0.0 {
            "yes"
        } else if is_refused() {
            "refused"
        } else {
            "predicts worse"
        };
        [
            format!("{}{form}", rival.effect),
            self.level(rival.fitted.rms()),
            format!("{behind:.0}"),
            format!("{:.0} %", 100.0 * rival.won),
            told.to_owned(),
        ]
    }

    /// Why an effect that could be confused with that of a step was not refitted.
    fn why_not(&self, index: usize, name: &str) -> String {
        let steps = &self.diagnosis.found.steps;
        if let Some(reason) = self.untestable(name) {
            return format!("not testable: {reason}");
        }
        if steps.iter().any(|step| step.effect == name) {
            return "found as well".into();
        }
        let own = self.foretold(&steps[index].effect).filter(|gain| *gain > 0.0);
        match (own, self.foretold(name)) {
            (Some(own), Some(gain)) if steps.len() == 1 => format!(
                "yes: it predicted {} of the gain of {}",
                percent(gain / own, 2),
                steps[index].effect
            ),
            _ => "yes: it explained too little to be refitted to the end".into(),
        }
    }
}
