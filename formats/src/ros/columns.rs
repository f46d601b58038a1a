//! The numbers of the messages of one topic, message by message.

use std::collections::HashMap;

use crate::Column;

/// Times that are counted from farther than this, s, count from their first whole second instead.
const AFAR_S: i64 = 1_000_000;
/// Most columns of a topic.
const MAX_COLUMNS: usize = 1024;

/// Columns that grow by one number with each message; one that a message lacks is missing there.
#[derive(Default)]
pub(super) struct Columns {
    columns: Vec<Column>,
    places: HashMap<String, usize>,
    /// The whole second from which a column of time counts.
    origins: HashMap<usize, i64>,
    /// The column that the last number went to: messages are mostly alike.
    last: usize,
    messages: usize,
    /// Takes nothing.
    nowhere: bool,
}

impl Columns {
    /// Columns into which nothing goes.
    pub(super) fn nowhere() -> Self {
        Self { nowhere: true, ..Self::default() }
    }

    /// Begins the next message.
    pub(super) fn begin(&mut self) {
        self.messages += 1;
        self.last = usize::MAX;
    }

    /// Puts a number into the column of that name.
    pub(super) fn number(&mut self, name: &str, unit: Option<&str>, value: f64) {
        if let Some(at) = self.place(name, unit) {
            let values = &mut self.columns[at].values;
            values.resize(self.messages - 1, f64::NAN);
            values.push(value);
        }
    }

    /// Puts a time into the column of that name. Near zero none of its digits are lost.
    pub(super) fn time(&mut self, name: &str, seconds: i64, nanoseconds: u32) {
        let Some(at) = self.place(name, Some("s")) else { return };
        let afar = seconds.checked_abs().is_none_or(|size| size > AFAR_S);
        let origin = *self.origins.entry(at).or_insert(if afar { seconds } else { 0 });
        let value =
            (i128::from(seconds) - i128::from(origin)) as f64 + f64::from(nanoseconds) / 1e9;
        self.number(name, Some("s"), value);
    }

    fn place(&mut self, name: &str, unit: Option<&str>) -> Option<usize> {
        if self.nowhere {
            return None;
        }
        let next = self.last.wrapping_add(1);
        let at = match self.columns.get(next) {
            Some(column) if column.name == name => next,
            _ => match self.places.get(name) {
                Some(&at) => at,
                None if self.columns.len() >= MAX_COLUMNS => return None,
                None => {
                    let unit = unit.map(Into::into);
                    self.columns.push(Column { name: name.into(), unit, values: Vec::new() });
                    self.places.insert(name.into(), self.columns.len() - 1);
                    self.columns.len() - 1
                }
            },
        };
        self.last = at;
        Some(at)
    }

    /// Numbers so far.
    pub(super) fn size(&self) -> usize {
        self.columns.len() * self.messages
    }

    /// All columns, each as long as there are messages.
    pub(super) fn finish(mut self) -> Vec<Column> {
        for column in &mut self.columns {
            column.values.resize(self.messages, f64::NAN);
        }
        self.columns
    }
}
