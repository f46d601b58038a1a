//! What was found impossible in traces before anything was fitted to them, and what was done about it.

use palpate_fit::data::Data;
use palpate_fit::whole_motion::{self, MotionFit};
use palpate_report::number::significant;
use palpate_report::{Callout, Column, Section, Table};
use palpate_trace::{Outlier, Trace, outliers, without};

/// Most samples that a table lists.
const MOST_LISTED: usize = 20;

/// The state of the traces that an answer rests on.
#[derive(Clone, Debug, Default)]
pub struct Preparation {
    /// Samples that cannot be.
    pub outliers: Vec<Outlier>,
    /// Whether they were left out.
    pub dropped: bool,
    /// What was taken off the signal of each trace, by its name.
    pub tared: Vec<(String, f64)>,
    /// What a fit is with the impossible samples and without them.
    pub refit: Option<Refit>,
}

/// A fit with impossible samples, and without.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refit {
    /// R² with and without.
    pub r_squared: [f64; 2],
    /// Root mean square of the residual with and without, in the unit of the signal.
    pub residual_rms: [f64; 2],
}

impl Refit {
    /// A fit and the same without the impossible samples of the traces; none where nothing is left to fit.
    #[must_use]
    pub fn of(fit: &MotionFit, traces: &[Trace], signal: &str) -> Option<Self> {
        let left: Vec<Trace> =
            traces.iter().map(|trace| without(trace, &outliers(trace, signal))).collect();
        let data = Data::of(&left, signal).ok()?;
        let other = whole_motion::fit(fit.chain.base, &data).ok()?;
        Some(Self {
            r_squared: [fit.r_squared, other.r_squared],
            residual_rms: [fit.rms(), other.rms()],
        })
    }
}

impl Preparation {
    /// What is impossible in traces that are taken as they are.
    #[must_use]
    pub fn of(traces: &[Trace], signal: &str) -> Self {
        let outliers = traces.iter().flat_map(|trace| outliers(trace, signal)).collect();
        Self { outliers, ..Self::default() }
    }

    /// The sections of an answer with one before them on the traces, where there is something to tell.
    #[must_use]
    pub fn before(&self, mut sections: Vec<Section>) -> Vec<Section> {
        if let Some(own) = self.section() {
            sections.insert(0, own);
        }
        sections
    }

    fn section(&self) -> Option<Section> {
        if self.outliers.is_empty() {
            return None;
        }
        let mut columns = vec![Column::text("trace"), Column::number("row", "")];
        columns.extend([Column::number("time", "s"), Column::text("column")]);
        columns.extend([Column::number("value", ""), Column::number("between neighbours", "")]);
        let mut table = Table::new("Impossible samples", columns);
        for out in self.outliers.iter().take(MOST_LISTED) {
            table = table.row([
                out.trace.clone(),
                out.row.to_string(),
                format!("{:.4}", out.time_s),
                out.column.clone(),
                significant(out.value, 5),
                significant(out.expected, 5),
            ]);
        }
        if let Some(more @ 1..) = self.outliers.len().checked_sub(MOST_LISTED) {
            table = table.note(format!("And {more} more; `--json` lists them all."));
        }
        Some(
            Section::new("Impossible samples")
                .callout(Callout::Warning, "Impossible samples", self.in_words())
                .table(table),
        )
    }

    fn in_words(&self) -> String {
        let samples = match self.outliers.len() {
            1 => "1 sample jumps".to_owned(),
            count => format!("{count} samples jump"),
        };
        let what =
            format!("{samples} away and back faster than this motion or this signal ever goes");
        if self.dropped {
            return format!("{what}; left out, as asked.");
        }
        let matter = self.refit.map_or_else(String::new, |refit| {
            format!(
                " Without them R² would be {:.3} instead of {:.3}.",
                refit.r_squared[1], refit.r_squared[0]
            )
        });
        format!("{what}.{matter} `--drop-outliers` leaves them out.")
    }
}
