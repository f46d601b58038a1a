//! Every effect that could be tried, ranked.

use super::DiagnosisSummary;
use palpate_report::number::significant;
use palpate_report::{Column, Section, Table};

/// What the first screen said of one candidate.
pub struct Ranked<'a> {
    /// Name of the effect.
    pub name: &'a str,
    /// Largest foretold fall of the whitened sum of squares over its laws.
    pub gain: f64,
    /// Chance under noise alone of a score as large.
    pub chance: f64,
}

impl DiagnosisSummary<'_> {
    /// The candidates by what the first screen foretells for them, the largest gain first.
    pub(crate) fn ranked(&self) -> Vec<Ranked<'_>> {
        let screen = &self.diagnosis.found.first;
        let ranked = |(index, candidate)| {
            let candidate: &palpate_model::effects::Candidate = candidate;
            let own = screen.directions.iter().filter(|d| d.candidate == index);
            Ranked {
                name: &candidate.name,
                gain: own.map(|direction| direction.gain).fold(0.0, f64::max),
                chance: screen.chance[index],
            }
        };
        let mut all: Vec<Ranked> =
            self.diagnosis.candidates.iter().enumerate().map(ranked).collect();
        all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        all
    }

    /// What the first screen foretold for this effect.
    pub(super) fn foretold(&self, name: &str) -> Option<f64> {
        self.ranked().iter().find(|ranked| ranked.name == name).map(|ranked| ranked.gain)
    }

    pub(super) fn candidates(&self) -> Section {
        let unit = self.unit();
        let found = &self.diagnosis.found;
        let columns = vec![
            Column::text("effect"),
            Column::number("predicted", "Δχ²"),
            Column::number("p value", ""),
            Column::number("refitted", unit),
            Column::number("ΔBIC behind", ""),
            Column::text(if found.steps.is_empty() { "" } else { "in place of" }),
        ];
        let mut table = Table::new("", columns);
        for ranked in self.ranked() {
            let mut cells = vec![ranked.name.to_owned()];
            if self.untestable(ranked.name).is_some() {
                cells.extend(["–", "–", "–", "–", "not testable here"].map(String::from));
                table = table.row(cells);
                continue;
            }
            cells.extend([format!("{:.0}", ranked.gain), significant(ranked.chance, 2)]);
            let tried = found.steps.iter().filter_map(|step| {
                let rival = step.rivals.iter().find(|rival| rival.effect == ranked.name)?;
                let behind = rival.fitted.bic() - step.rivals[0].fitted.bic();
                Some((behind, rival.fitted.rms(), &step.effect))
            });
            if let Some((behind, rms, of)) = tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
                let place = if of == ranked.name { "found" } else { of };
                cells.extend([self.level(rms), format!("{behind:.0}"), place.to_owned()]);
            } else {
                cells.extend(["–", "–", ""].map(String::from));
            }
            table = table.row(cells);
        }
        let table = table.note(
            "Predicted: fall of the whitened sum of squares by the score test, before any refit, for the \
             model without the effects found. p value: chance that noise alone shows as much anywhere \
             in the library. Refitted: the error of the best few after a refit, each in the place of an \
             effect found and beside the others found; behind: to the best in that place.",
        );
        Section::new("Every effect").table(table)
    }
}
