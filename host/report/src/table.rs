//! A table as plain data, for pages and terminals alike.

use super::number::beside;

/// How a column of a table is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// Text: flush left.
    #[default]
    Left,
    /// Whole numbers: flush right.
    Right,
    /// Numbers with decimals or standard errors: their decimal points below each other.
    Decimal,
}

/// One column of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Column {
    /// What it shows.
    pub name: String,
    /// Its unit, shown in the header; empty for none.
    pub unit: String,
    /// How its cells are set.
    pub align: Align,
}

impl Column {
    /// A column of text.
    #[must_use]
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// A column of whole numbers.
    #[must_use]
    pub fn whole(name: impl Into<String>) -> Self {
        Self { name: name.into(), align: Align::Right, ..Self::default() }
    }

    /// A column of numbers in a unit (empty for plain numbers), set on their decimal points.
    #[must_use]
    pub fn number(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), align: Align::Decimal }
    }

    /// Name with unit: `Force (N)`.
    pub(super) fn title(&self) -> String {
        match (self.name.is_empty(), self.unit.is_empty()) {
            (_, true) => self.name.clone(),
            (true, false) => format!("({})", self.unit),
            (false, false) => format!("{} ({})", self.name, self.unit),
        }
    }
}

/// A table. Its first column names the rows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// What the table shows; empty for none.
    pub caption: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The cells of each row, written with [`number`](super::number); missing ones are empty.
    pub rows: Vec<Vec<String>>,
    /// Remarks below the table.
    pub notes: Vec<String>,
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new(caption: impl Into<String>, columns: Vec<Column>) -> Self {
        Self { caption: caption.into(), columns, ..Self::default() }
    }

    /// The same table with one more row.
    #[must_use]
    pub fn row(mut self, cells: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    /// The same table with numbers of one kind alike: in each of these columns the largest has so many significant digits, and the
    /// others its decimals. The cells are numbers in full (`{value}`); what is none stays as it is.
    #[must_use]
    pub fn alike(mut self, columns: impl IntoIterator<Item = usize>, digits: usize) -> Self {
        for column in columns {
            let cells = self.rows.iter_mut().filter_map(|row| row.get_mut(column));
            let mut numbers: Vec<(&mut String, f64)> =
                cells.filter_map(|cell| cell.parse().ok().map(|value| (cell, value))).collect();
            let largest = numbers.iter().fold(0.0_f64, |most, (_, value)| most.max(value.abs()));
            for (cell, value) in &mut numbers {
                **cell = beside(*value, largest, digits);
            }
        }
        self
    }

    /// The same table with a remark below it.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// The text of a cell; empty where the row is short.
    pub(super) fn cell(&self, row: usize, column: usize) -> &str {
        self.rows.get(row).and_then(|r| r.get(column)).map_or("", String::as_str)
    }

    /// The widest text after the decimal point in a column, the point included, in characters.
    pub(super) fn tail(&self, column: usize) -> usize {
        let tail = |row| split_decimal(self.cell(row, column)).1.chars().count();
        (0..self.rows.len()).map(tail).max().unwrap_or(0)
    }
}

/// Splits a number before its decimal point, or after its digits where it has none; text that is no number
/// stays whole.
pub(super) fn split_decimal(cell: &str) -> (&str, &str) {
    let number = |c: char| c.is_ascii_digit() || matches!(c, '-' | '−' | '(' | '+');
    if !cell.starts_with(number) {
        return (cell, "");
    }
    cell.split_at(cell.find(|c| !number(c)).unwrap_or(cell.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_one_kind_have_one_number_of_decimals() {
        let column = |cells: &[&str]| {
            let empty = Table::new("", vec![Column::number("force", "N")]);
            let table = cells.iter().fold(empty, |table, cell| table.row([*cell])).alike([0], 4);
            table.rows.concat()
        };
        assert_eq!(column(&["0.00254", "-2.3041", "0", "–"]), ["0.003", "-2.304", "0.000", "–"]);
        assert_eq!(column(&["NaN", "477.31", "0.4"]), ["–", "477.3", "0.4"]);
        assert_eq!(column(&["35041", "12.3"]), ["35040", "10"]);
        assert_eq!(column(&["1.2e-9", "3e-10"]), ["1.200e-9", "3.000e-10"]);
        assert_eq!(column(&["0", "0"]), ["0", "0"]);
    }

    #[test]
    fn numbers_split_where_their_decimal_point_is_or_would_be() {
        assert_eq!(split_decimal("3.981 ± 0.074"), ("3", ".981 ± 0.074"));
        assert_eq!(split_decimal("122130 ± 340"), ("122130", " ± 340"));
        assert_eq!(split_decimal("(-2.00 ± 0.10)e-9"), ("(-2", ".00 ± 0.10)e-9"));
        assert_eq!(split_decimal("–"), ("–", ""));
        assert_eq!(split_decimal("61 %"), ("61", " %"));
    }
}
