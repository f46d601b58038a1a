//! Effects that were tried and refused, and why.

use super::DiagnosisSummary;
use palpate_diagnose::criticism::evidence::{Refusal, Refused};
use palpate_report::number::significant;
use palpate_report::{Column, Table};

impl DiagnosisSummary<'_> {
    /// Every effect that was tried and refused, with the reason; none where there is none.
    pub(super) fn refused_table(&self) -> Option<Table> {
        let refused = &self.diagnosis.found.refused;
        if refused.is_empty() {
            return None;
        }
        let columns = vec![
            Column::text("refused"),
            Column::number("error with it", self.unit()),
            Column::number("held out", self.unit()),
            Column::text("why"),
        ];
        let table = Table::new("Tried and refused", columns);
        Some(refused.iter().fold(table, |table, refused| {
            table.row([
                refused.effect.clone(),
                self.level(refused.rms.1),
                refused.held_out.map_or("–".into(), |(_, with)| self.level(with)),
                self.reason(refused),
            ])
        }))
    }

    /// Why an effect was refused, in words.
    pub(crate) fn reason(&self, refused: &Refused) -> String {
        let unit = self.unit();
        match &refused.reason {
            Refusal::FittedError => "the error of the fit does not fall".into(),
            Refusal::FitUncertain => {
                "the error of the fit falls by no more than chance explains in a residual whose neighbours agree".into()
            }
            Refusal::HeldOutError => "the error on traces left out rises".into(),
            Refusal::SectionError => "the error on sections left out of the trace rises".into(),
            Refusal::HeldOutUncertain(_) => {
                "the error on traces left out falls by less than its uncertainty over the traces"
                    .into()
            }
            Refusal::Disagreement(chance) => format!(
                "the parts of the data do not agree about it (p = {})",
                significant(*chance, 2)
            ),
            Refusal::AtBound { parameter, value, unit } => format!(
                "{parameter} runs to its bound of {}, beyond which the law is no longer this effect",
                format!("{} {unit}", significant(*value, 3)).trim_end()
            ),
            Refusal::WithinScatter { width, scatter } => format!(
                "its play of {} mm only smooths the displacement, which scatters by {} mm",
                significant(*width, 2),
                significant(*scatter, 2)
            ),
            Refusal::WithinRepeats { delay, stays } => format!(
                "each value of the signal stays for {} s, which looks like its delay of {} s; `--drop-repeats` leaves out what repeats",
                significant(*stays, 2),
                significant(*delay, 2)
            ),
            Refusal::Rest { without, with } => format!(
                "the signal off the specimen denies it: the error there would rise from {} {unit} to {} {unit}",
                self.level(*without),
                self.level(*with)
            ),
        }
    }
}
