//! A trace from columns in memory, held to the same as one from a file.

use super::names::{self, Fault};
use super::{Column, Head, TIME, Trace};

/// Why columns in memory are no trace.
#[derive(Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum ColumnsError {
    #[error("no column `{TIME}`; there are {}. Name the column of time `{TIME}` if it is in seconds.", super::error::listed(.0))]
    NoTime(Vec<String>),
    #[error("a column has no name, or one with a control character or space around it: {0:?}")]
    Name(String),
    #[error("two columns are called `{0}`")]
    Twice(String),
    #[error(
        "column `{name}`: a trace has this quantity as `{expected}`; nothing is converted by its name"
    )]
    Unit { name: String, expected: &'static str },
    #[error("column `{name}` has {found} values, `{TIME}` has {expected}")]
    Length { name: String, found: usize, expected: usize },
    #[error("{0} sample(s): a trace has at least two")]
    TooShort(usize),
    #[error(
        "column `{name}`, row {row}: {value} is not a finite number. Leave the row out; a gap in time is allowed."
    )]
    NotFinite { name: String, row: usize, value: f64 },
    #[error("row {row}: time {time} s is not later than {previous} s in the row before")]
    TimeOrder { row: usize, time: f64, previous: f64 },
    #[error("the head: {0}")]
    Head(String),
}

impl Trace {
    /// A trace from named columns, [`TIME`] among them, and what its head says. Rows are counted from 0 in errors.
    ///
    /// # Errors
    /// When the columns lack time, have names that a trace cannot have, are not equally long, are shorter than two
    /// samples, hold a value that is not finite, or time does not increase; when the head cannot be.
    pub fn from_columns(head: Head, mut columns: Vec<Column>) -> Result<Self, ColumnsError> {
        head.check().map_err(ColumnsError::Head)?;
        let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
        names::check(&names).map_err(|fault| match fault {
            Fault::Unnamed(index) => ColumnsError::Name(names[index].clone()),
            Fault::Duplicate { index, .. } => ColumnsError::Twice(names[index].clone()),
            Fault::Unit { index, expected } => {
                ColumnsError::Unit { name: names[index].clone(), expected }
            }
        })?;
        let Some(at) = names.iter().position(|name| name == TIME) else {
            return Err(ColumnsError::NoTime(names));
        };
        let time = columns.remove(at).values;
        if time.len() < 2 {
            return Err(ColumnsError::TooShort(time.len()));
        }
        let named = columns.iter().map(|column| (&*column.name, &column.values[..]));
        for (name, values) in std::iter::once((TIME, &time[..])).chain(named) {
            check(name, values, time.len())?;
        }
        if let Some(row) = (1..time.len()).find(|&row| time[row] <= time[row - 1]) {
            let (time, previous) = (time[row], time[row - 1]);
            return Err(ColumnsError::TimeOrder { row, time, previous });
        }
        Ok(Self { path: None, head, time, columns })
    }
}

fn check(name: &str, values: &[f64], expected: usize) -> Result<(), ColumnsError> {
    let name = || name.to_owned();
    if values.len() != expected {
        return Err(ColumnsError::Length { name: name(), found: values.len(), expected });
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(row) => Err(ColumnsError::NotFinite { name: name(), row, value: values[row] }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FORCE, parse};

    fn column(name: &str, values: &[f64]) -> Column {
        Column { name: name.into(), values: values.into() }
    }

    fn refused(columns: Vec<Column>) -> ColumnsError {
        Trace::from_columns(Head::default(), columns).unwrap_err()
    }

    #[test]
    fn columns_make_the_same_trace_as_a_file() {
        let text = "# name = \"take 3\"\ntime_s,force_N,status\n0,1,0\n0.5,2,1\n";
        let read = parse("a.csv".as_ref(), text.as_bytes()).unwrap();
        let columns = vec![
            column(FORCE, &[1.0, 2.0]),
            column(TIME, &[0.0, 0.5]),
            column("status", &[0.0, 1.0]),
        ];
        let made = Trace::from_columns(read.head.clone(), columns).unwrap();
        assert_eq!(made, Trace { path: None, ..read });
    }

    #[test]
    fn what_is_no_trace_is_refused() {
        let time = || column(TIME, &[0.0, 1.0]);
        assert!(matches!(refused(vec![column(FORCE, &[1.0])]), ColumnsError::NoTime(_)));
        assert!(matches!(refused(vec![time(), column("", &[])]), ColumnsError::Name(_)));
        assert!(matches!(refused(vec![time(), time()]), ColumnsError::Twice(_)));
        let expected = FORCE;
        assert_eq!(
            refused(vec![time(), column("Force (mN)", &[1.0, 2.0])]),
            ColumnsError::Unit { name: "Force (mN)".into(), expected }
        );
        let name = || FORCE.to_owned();
        assert_eq!(
            refused(vec![time(), column(FORCE, &[1.0])]),
            ColumnsError::Length { name: name(), found: 1, expected: 2 }
        );
        assert_eq!(refused(vec![column(TIME, &[0.0])]), ColumnsError::TooShort(1));
        let value = f64::INFINITY;
        assert_eq!(
            refused(vec![time(), column(FORCE, &[1.0, value])]),
            ColumnsError::NotFinite { name: name(), row: 1, value }
        );
        assert_eq!(
            refused(vec![column(TIME, &[1.0, 1.0])]),
            ColumnsError::TimeOrder { row: 1, time: 1.0, previous: 1.0 }
        );
        let mut head = Head::default();
        head.specimen.height_mm = Some(-3.0);
        let refused = Trace::from_columns(head, vec![time()]).unwrap_err();
        assert!(refused.to_string().contains("height_mm = -3"), "{refused}");
    }
}
