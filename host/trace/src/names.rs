//! Which names a header row may have.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::units::{self, Quantity};
use super::{DISPLACEMENT, FORCE, GAUGES, TANGENTIAL, TEMPERATURE, TIME};

/// Quantities with a fixed name and unit: word, what it measures, name in a trace.
const KNOWN: [(&str, Quantity, &str); 9] = [
    ("time", Quantity::Time, TIME),
    ("displacement", Quantity::Length, DISPLACEMENT),
    ("force", Quantity::Force, FORCE),
    ("temperature", Quantity::Temperature, TEMPERATURE),
    ("tangential", Quantity::Force, TANGENTIAL),
    ("gauge1", Quantity::Ratio, GAUGES[0]),
    ("gauge2", Quantity::Ratio, GAUGES[1]),
    ("gauge3", Quantity::Ratio, GAUGES[2]),
    ("gauge4", Quantity::Ratio, GAUGES[3]),
];

/// What is wrong with the names of a header row, and with which of them (from 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// Empty, or with a control character.
    Unnamed(usize),
    /// The same as an earlier one.
    Duplicate { index: usize, first: usize },
    /// A known quantity in another unit, without one, or spelled otherwise.
    Unit { index: usize, expected: &'static str },
}

/// Checks all names of a header row.
pub(super) fn check<S: AsRef<str>>(names: &[S]) -> Result<(), Fault> {
    let mut seen = HashMap::with_capacity(names.len());
    for (index, name) in names.iter().enumerate() {
        let name = name.as_ref();
        if name.trim().is_empty() || name.trim() != name || name.chars().any(char::is_control) {
            return Err(Fault::Unnamed(index));
        }
        match seen.entry(name) {
            Entry::Occupied(first) => return Err(Fault::Duplicate { index, first: *first.get() }),
            Entry::Vacant(place) => place.insert(index),
        };
        if let Some(expected) = expected(name) {
            return Err(Fault::Unit { index, expected });
        }
    }
    Ok(())
}

/// The name a trace has for what `name` means, where that is a known quantity in other dress:
/// `force_mN`, `Time (ms)`, `displacement`. A name with more to it (`force_setpoint_N`) is its own.
fn expected(name: &str) -> Option<&'static str> {
    let lower = name.to_lowercase();
    KNOWN.into_iter().find_map(|(word, quantity, known)| {
        let rest = lower.strip_prefix(word)?;
        let unit = rest.trim_matches(|c: char| c.is_whitespace() || "_()[]/.,".contains(c));
        let same_quantity = || {
            units::UNITS
                .iter()
                .any(|known| known.quantity == quantity && known.name.to_lowercase() == unit)
        };
        (name != known && (unit.is_empty() || same_quantity())).then_some(known)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_quantity_in_another_unit_is_told_its_name() {
        for (name, known) in [
            ("force_mN", FORCE),
            ("Force (N)", FORCE),
            ("time_ms", TIME),
            ("Time", TIME),
            ("displacement_m", DISPLACEMENT),
            ("temperature_K", TEMPERATURE),
            ("gauge2_strain", GAUGES[1]),
        ] {
            assert_eq!(check(&[name]), Err(Fault::Unit { index: 0, expected: known }), "{name}");
        }
    }

    #[test]
    fn names_of_other_quantities_pass() {
        let names =
            [TIME, FORCE, "force_setpoint_N", "gauge1_FA_ustrain", "time_device_s", "force_V"];
        assert_eq!(check(&names), Ok(()));
    }

    #[test]
    fn duplicates_and_empty_names_are_found() {
        assert_eq!(check(&[TIME, "a", "a"]), Err(Fault::Duplicate { index: 2, first: 1 }));
        assert_eq!(check(&[TIME, ""]), Err(Fault::Unnamed(1)));
        assert_eq!(check(&[TIME, "a\nb"]), Err(Fault::Unnamed(1)));
    }
}
