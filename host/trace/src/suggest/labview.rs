//! What the head of a LabVIEW measurement file (`.lvm`) says of units: they stand far above the names of the columns.

use super::super::mapping::Delimiter;
use super::guess::cells;

/// First words of the row with the units of the signals, and of that with what the first column is.
const UNITS: &str = "Y_Unit_Label";
const FIRST_COLUMN: &str = "X_Dimension";

/// The units of the columns, in their order, as far as the head gives them; of a time it is the second.
pub(super) fn units(head: &[String], delimiter: Delimiter) -> Vec<Option<String>> {
    let row = |words: &str| {
        head.iter()
            .map(|line| cells(line, delimiter))
            .find(|row| row.first().is_some_and(|it| it == words))
    };
    let of_signals = row(UNITS).unwrap_or_default();
    let in_time = row(FIRST_COLUMN).is_some_and(|row| row.get(1).is_some_and(|it| it == "Time"));
    let first = in_time.then(|| "s".to_owned());
    let others = of_signals.into_iter().skip(1).map(|unit| Some(unit).filter(|it| !it.is_empty()));
    [first].into_iter().chain(others).collect()
}
