//! Every effect that could be tried, ranked.

use super::{DiagnosisSummary, chance};
use crate::report::number::significant;
use crate::report::{Column, Section, Table};

/// What the first screen said of one candidate.
pub(super) struct Ranked<'a> {
    /// Name of the effect.
    pub name: &'a str,
    /// Largest foretold fall of the whitened sum of squares over its laws.
    pub gain: f64,
    /// Chance under noise alone of a score as large.
    pub chance: f64,
}

impl DiagnosisSummary<'_> {
    /// The candidates by what the first screen foretells for them, the largest gain first.
    pub(super) fn ranked(&self) -> Vec<Ranked<'_>> {
        let screen = &self.diagnosis.found.first;
        let ranked = |(index, candidate)| {
            let candidate: &crate::effects::Candidate = candidate;
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
            Column::number("gain foretold", "χ²"),
            Column::number("chance", ""),
            Column::number("error after refit", unit),
            Column::number("ΔBIC to the best", ""),
            Column::text("in place of"),
        ];
        let mut table = Table::new("Every effect of the library, by its gain", columns);
        for ranked in self.ranked() {
            let mut cells = vec![ranked.name.to_owned()];
            if self.untestable(ranked.name).is_some() {
                cells.extend(["–".into(), "–".into(), String::new(), String::new()]);
                cells.push("not testable here, see below".into());
                table = table.row(cells);
                continue;
            }
            cells.extend([significant(ranked.gain, 3), chance(ranked.chance)]);
            let tried = found.steps.iter().filter_map(|step| {
                let rival = step.rivals.iter().find(|rival| rival.effect == ranked.name)?;
                let behind = rival.fitted.bic() - step.rivals[0].fitted.bic();
                Some((behind, rival.fitted.rms(), &step.effect))
            });
            if let Some((behind, rms, of)) = tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
                let place = if of == ranked.name { "" } else { of };
                cells.extend([self.level(rms), format!("{behind:.0}"), place.to_owned()]);
            }
            table = table.row(cells);
        }
        let table = table.note(
            "Gain foretold: fall of the whitened sum of squares that the score test foretells before \
             any refit, for the model without the effects found. Chance: that noise alone would show \
             as much anywhere in the library. The best were refitted, each in the place of an effect \
             found and beside the others found.",
        );
        Section::new("Every effect").table(table)
    }
}
