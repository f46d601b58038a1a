//! Arrays of a tree of groups become tables: those of one group that are as long as each other.

use crate::{Column, Contents, Error, Part};

/// An array in a file that has not been read yet.
pub(crate) struct Array<T> {
    /// Path of its group, without a `/` at either end; empty at the top.
    pub(crate) group: String,
    /// Its name in the group.
    pub(crate) name: String,
    /// Its unit, where the file says it.
    pub(crate) unit: Option<String>,
    /// Numbers in a column.
    pub(crate) rows: usize,
    /// Where it is.
    pub(crate) source: T,
}

impl<T> Array<T> {
    pub(crate) fn path(&self) -> String {
        match self.group.as_str() {
            "" => self.name.clone(),
            group => format!("{group}/{}", self.name),
        }
    }
}

/// Makes a part of the arrays of one group and length, and reads those that are wanted: `read` gives the columns of an array.
/// Arrays that are alone in their group are taken together at the top. Arrays of fewer than two numbers are left out.
pub(crate) fn gather<T>(
    arrays: Vec<Array<T>>,
    top: &str,
    wanted: Option<&str>,
    mut read: impl FnMut(&Array<T>) -> Result<Vec<Vec<f64>>, Error>,
) -> Result<Contents, Error> {
    let mut contents = Contents::default();
    for (name, members) in parts(arrays, top) {
        contents.names.push(name.clone());
        if wanted.is_some_and(|wanted| wanted != name) {
            continue;
        }
        let mut columns = Vec::new();
        for (shown, array) in members {
            let read = read(&array)?;
            let several = read.len() > 1;
            for (index, values) in read.into_iter().enumerate() {
                let name = if several { format!("{shown}_{}", index + 1) } else { shown.clone() };
                columns.push(Column { name, unit: array.unit.clone(), values });
            }
        }
        contents.parts.push(Part::columns(name, columns));
    }
    Ok(contents)
}

/// The arrays of a part, each with what it is called in it.
type Members<T> = Vec<(String, Array<T>)>;

/// Names of the parts, each with its arrays and what these are called in it.
fn parts<T>(arrays: Vec<Array<T>>, top: &str) -> Vec<(String, Members<T>)> {
    let arrays: Vec<Array<T>> = arrays.into_iter().filter(|array| array.rows > 1).collect();
    let mut sizes = std::collections::HashMap::<String, usize>::new();
    for array in &arrays {
        *sizes.entry(array.group.clone()).or_default() += 1;
    }
    let mut found: Vec<((String, usize), Members<T>)> = Vec::new();
    for array in arrays {
        let alone = sizes.get(&array.group) == Some(&1);
        let shown = if alone { array.path() } else { array.name.clone() };
        let group = if alone { String::new() } else { array.group.clone() };
        let key = (group, array.rows);
        match found.iter_mut().find(|(other, _)| *other == key) {
            Some((_, members)) => members.push((shown, array)),
            None => found.push((key, vec![(shown, array)])),
        }
    }
    let groups: Vec<String> = found.iter().map(|((group, _), _)| group.clone()).collect();
    let named = |((group, rows), members): ((String, usize), Members<T>)| {
        let name = if group.is_empty() { top.to_owned() } else { group.clone() };
        let lengths = groups.iter().filter(|other| **other == group).count();
        (if lengths > 1 { format!("{name} ({rows} rows)") } else { name }, members)
    };
    found.into_iter().map(named).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(arrays: &[(&str, &str, usize)]) -> Vec<(String, Vec<String>)> {
        let array = |&(group, name, rows): &(&str, &str, usize)| Array {
            group: group.into(),
            name: name.into(),
            unit: None,
            rows,
            source: (),
        };
        let contents = gather(arrays.iter().map(array).collect(), "/", None, |array| {
            Ok(vec![vec![0.0; array.rows]])
        });
        let shown = |part: Part| match part.content {
            crate::Content::Columns(columns) => {
                (part.name, columns.into_iter().map(|column| column.name).collect())
            }
            crate::Content::Cells(_) => unreachable!(),
        };
        contents.unwrap().parts.into_iter().map(shown).collect()
    }

    #[test]
    fn a_group_is_a_table_for_each_length_and_lonely_arrays_are_one() {
        let part = |name: &str, columns: &[&str]| {
            (name.to_owned(), columns.iter().map(|&name| name.to_owned()).collect())
        };
        assert_eq!(
            names(&[("run", "t", 9), ("run", "f", 9), ("run", "gain", 1), ("run", "slow", 3)]),
            [part("run (9 rows)", &["t", "f"]), part("run (3 rows)", &["slow"])]
        );
        assert_eq!(
            names(&[("time", "data", 9), ("force", "data", 9), ("", "x", 9)]),
            [part("/", &["time/data", "force/data", "x"])]
        );
    }
}
