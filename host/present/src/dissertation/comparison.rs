//! What the dissertation prints beside what is computed here, and what their agreement shows.

use palpate_report::number::significant;
use palpate_report::{Column, Table};

/// What the agreement of a computed figure with a printed one shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// It follows from other printed numbers: the text agrees with itself and with the models here.
    Derived,
    /// It was fed into a rebuilt or simulated recording and found again in it: the method works. Whether the
    /// text is right, this cannot show.
    FoundAgain,
    /// The model was fitted to the printed figures themselves.
    Fitted,
    /// No printed number: what the text says in words, counted or compared here.
    Said,
    /// It does not follow, or the recording behind it was not published.
    NotReproduced,
}

impl Evidence {
    /// All, in the order in which they are told.
    pub const ALL: [Self; 5] =
        [Self::Derived, Self::FoundAgain, Self::Fitted, Self::Said, Self::NotReproduced];

    /// The kind in a few words, and as a name for programs.
    #[must_use]
    pub const fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Derived => ("derived from other printed numbers", "derived"),
            Self::FoundAgain => ("found again from a rebuilt recording", "found_again"),
            Self::Fitted => ("fitted to the printed numbers themselves", "fitted"),
            Self::Said => ("said in words", "said"),
            Self::NotReproduced => ("not reproduced", "not_reproduced"),
        }
    }

    /// What such agreement shows.
    #[must_use]
    pub const fn shows(self) -> &'static str {
        match self {
            Self::Derived => "that the text agrees with itself and with the models here",
            Self::FoundAgain => "that the method works, not that the text is right",
            Self::Fitted => "how well the model can follow them",
            Self::Said => "that the models here do what the text says of its own",
            Self::NotReproduced => "nothing: each has its reason",
        }
    }
}

/// One printed figure and the same figure computed here.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What it is a figure of.
    pub quantity: String,
    /// Its unit, empty for a pure number.
    pub unit: &'static str,
    /// As it is printed.
    pub printed: f64,
    /// One unit of its last printed digit.
    pub digit: f64,
    /// As it is computed here; not a number where it cannot be.
    pub recomputed: f64,
    /// How far the two may lie apart.
    pub tolerance: f64,
}

impl Check {
    /// A figure printed with a last digit worth so much, the same one computed here, and how far the two
    /// may lie apart.
    #[must_use]
    pub fn new(
        quantity: impl Into<String>,
        unit: &'static str,
        (printed, digit): (f64, f64),
        recomputed: f64,
        tolerance: f64,
    ) -> Self {
        Self { quantity: quantity.into(), unit, printed, digit, recomputed, tolerance }
    }

    /// A figure that follows to half of its last digit.
    #[must_use]
    pub fn exact(
        quantity: impl Into<String>,
        unit: &'static str,
        (printed, digit): (f64, f64),
        recomputed: f64,
    ) -> Self {
        Self::new(quantity, unit, (printed, digit), recomputed, 0.5 * digit)
    }

    /// Recomputed less printed.
    #[must_use]
    pub fn difference(&self) -> f64 {
        self.recomputed - self.printed
    }

    /// The size of the difference in half units of the last printed digit.
    #[must_use]
    pub fn half_units(&self) -> f64 {
        self.difference().abs() / (0.5 * self.digit)
    }

    /// Whether the two agree within half of the last printed digit.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.half_units() <= 1.0 + ROUNDING
    }

    /// Whether the two agree within the tolerance.
    #[must_use]
    pub fn agrees(&self) -> bool {
        self.difference().abs() <= self.tolerance * (1.0 + ROUNDING)
    }
}

/// Rounding must not decide where the tolerance is half of the last printed digit.
const ROUNDING: f64 = 1e-9;

/// One unit of a digit: `decimals` places after the point.
#[must_use]
pub fn decimals(decimals: i32) -> f64 {
    10f64.powi(-decimals)
}

/// One unit of the last of so many significant digits of a value.
#[must_use]
pub fn digits(value: f64, significant: i32) -> f64 {
    10f64.powi(value.abs().log10().floor() as i32 + 1 - significant)
}

/// The figures of one table or equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Where they are printed: "Table 3.4".
    pub source: &'static str,
    /// What their agreement shows.
    pub evidence: Evidence,
    /// Why the tolerances are what they are; why figures are not reproduced.
    pub reason: String,
    /// The figures.
    pub checks: Vec<Check>,
}

impl Comparison {
    /// The figures that should agree and do not.
    pub fn missed(&self) -> impl Iterator<Item = &Check> {
        let expected = !matches!(self.evidence, Evidence::Fitted | Evidence::NotReproduced);
        self.checks.iter().filter(move |check| expected && !check.agrees())
    }

    /// Printed, recomputed and difference, a row for each figure.
    #[must_use]
    pub fn table(&self) -> Table {
        let columns = vec![
            Column::text("quantity"),
            Column::number("printed", ""),
            Column::number("recomputed", ""),
            Column::number("difference", "half units of the last digit"),
            Column::number("allowed", "the same"),
            Column::text("unit"),
            Column::text("agrees"),
        ];
        let mut table =
            Table::new(format!("{}: {}", self.source, self.evidence.names().0), columns);
        let number = |value: f64, digits| {
            if value.is_finite() { significant(value, digits) } else { "–".into() }
        };
        for check in &self.checks {
            let expected = self.evidence != Evidence::NotReproduced;
            table = table.row([
                check.quantity.clone(),
                significant(check.printed, 5),
                number(check.recomputed, 5),
                number(check.half_units(), 2),
                if expected {
                    significant(2.0 * check.tolerance / check.digit, 2)
                } else {
                    "–".into()
                },
                check.unit.to_owned(),
                if check.agrees() { "yes" } else { "no" }.to_owned(),
            ]);
        }
        let reason = if self.evidence == Evidence::NotReproduced { "" } else { "Allowed: " };
        table.note(format!("{reason}{}.", self.reason.trim_end_matches('.')))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_counts_in_half_units_of_the_last_printed_digit() {
        let check = Check::exact("c1", "", (0.239, decimals(4)), 0.2391);
        assert!((check.half_units() - 2.0).abs() < 1e-9 && !check.is_exact() && !check.agrees());
        assert!(Check::exact("v1", "1/s", (0.154, decimals(3)), 0.1544).is_exact());
        assert!((digits(1.4e6, 2) - 1e5).abs() < 1e-6 && (digits(9.95e-3, 3) - 1e-5).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_reproduced_is_not_missed() {
        let check = Check::exact("R²", "", (0.9162, 1e-4), 0.9365);
        let of = |evidence| Comparison {
            source: "Table B.1",
            evidence,
            reason: String::new(),
            checks: vec![check.clone()],
        };
        assert_eq!(of(Evidence::Derived).missed().count(), 1);
        assert_eq!(of(Evidence::NotReproduced).missed().count(), 0);
    }
}
