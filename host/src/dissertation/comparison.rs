//! What the dissertation prints beside what is computed here.

use crate::report::number::significant;
use crate::report::{Column, Table};

/// One printed figure and the same figure computed here.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What it is a figure of.
    pub quantity: String,
    /// Its unit, empty for a pure number.
    pub unit: &'static str,
    /// As it is printed.
    pub printed: f64,
    /// As it is computed here.
    pub recomputed: f64,
    /// How far the two may lie apart.
    pub tolerance: f64,
}

impl Check {
    /// A printed figure, the same one computed here, and how far the two may lie apart.
    #[must_use]
    pub fn new(
        quantity: impl Into<String>,
        unit: &'static str,
        printed: f64,
        recomputed: f64,
        tolerance: f64,
    ) -> Self {
        Self { quantity: quantity.into(), unit, printed, recomputed, tolerance }
    }

    /// Recomputed less printed.
    #[must_use]
    pub fn difference(&self) -> f64 {
        self.recomputed - self.printed
    }

    /// Whether the two agree within the tolerance.
    #[must_use]
    pub fn agrees(&self) -> bool {
        // Rounding must not decide where the tolerance is half of the last printed digit.
        self.difference().abs() <= self.tolerance * (1.0 + 1e-9)
    }
}

/// The figures of one table or equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Where they are printed: "Table 3.4".
    pub source: &'static str,
    /// Why the tolerances are what they are.
    pub reason: String,
    /// The figures.
    pub checks: Vec<Check>,
}

impl Comparison {
    /// The figures that do not agree.
    pub fn missed(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|check| !check.agrees())
    }

    /// Printed, recomputed and difference, a row for each figure.
    #[must_use]
    pub fn table(&self) -> Table {
        let columns = vec![
            Column::text("quantity"),
            Column::number("printed", ""),
            Column::number("recomputed", ""),
            Column::number("difference", ""),
            Column::number("allowed", ""),
            Column::text("unit"),
            Column::text("agrees"),
        ];
        let mut table = Table::new(format!("{} recomputed", self.source), columns);
        for check in &self.checks {
            table = table.row([
                check.quantity.clone(),
                significant(check.printed, 5),
                significant(check.recomputed, 5),
                significant(check.difference(), 2),
                significant(check.tolerance, 2),
                check.unit.to_owned(),
                if check.agrees() { "yes" } else { "no" }.to_owned(),
            ]);
        }
        table.note(format!("Allowed difference: {}", self.reason))
    }
}
