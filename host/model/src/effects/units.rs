//! Units of parameters, taken apart into base units: `N s/mm` is force · time / length.

/// The base units that laws are stated in.
pub const BASE: [&str; 4] = ["mm", "s", "N", "K"];

/// Powers of the base units.
pub type Powers = [f64; BASE.len()];

/// Units with their powers of the base units. A signal in another unit than N is a response like a force.
const KNOWN: [(&str, Powers); 8] = [
    ("mm", [1.0, 0.0, 0.0, 0.0]),
    ("s", [0.0, 1.0, 0.0, 0.0]),
    ("N", [0.0, 0.0, 1.0, 0.0]),
    ("µε", [0.0, 0.0, 1.0, 0.0]),
    ("Ω", [0.0, 0.0, 1.0, 0.0]),
    ("K", [0.0, 0.0, 0.0, 1.0]),
    ("Hz", [0.0, -1.0, 0.0, 0.0]),
    ("1", [0.0; 4]),
];

/// The powers of a unit such as `N s/mm^2` or `1/(mm s)`; none where a part of it is not known. What stands behind a stroke is
/// below it, up to the next one.
#[must_use]
pub fn powers(unit: &str) -> Option<Powers> {
    let mut found = [0.0; BASE.len()];
    for (index, part) in unit.split('/').enumerate() {
        let sign = if index == 0 { 1.0 } else { -1.0 };
        let part = part.trim().trim_start_matches('(').trim_end_matches(')');
        for factor in part.split([' ', '·', '*']).filter(|factor| !factor.is_empty()) {
            let (name, power) = power_of(factor)?;
            let (_, powers) = KNOWN.iter().find(|(known, _)| *known == name)?;
            for (found, own) in found.iter_mut().zip(powers) {
                *found += sign * power * own;
            }
        }
    }
    Some(found)
}

/// `mm^2`, `mm²` and `mm`.
fn power_of(factor: &str) -> Option<(&str, f64)> {
    if let Some((name, power)) = factor.split_once('^') {
        return Some((name, power.parse().ok()?));
    }
    let raised = [('²', 2.0), ('³', 3.0)];
    let end = raised.iter().find_map(|(sign, power)| Some((factor.strip_suffix(*sign)?, *power)));
    Some(end.unwrap_or((factor, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_taken_apart() {
        assert_eq!(powers(""), Some([0.0; 4]));
        assert_eq!(powers("N s/mm^2"), Some([-2.0, 1.0, 1.0, 0.0]));
        assert_eq!(powers("1/(mm s)"), Some([-1.0, -1.0, 0.0, 0.0]));
        assert_eq!(powers("mm/s²"), Some([1.0, -2.0, 0.0, 0.0]));
        assert_eq!(powers("furlong"), None);
        assert_eq!(powers("N^x"), None);
    }
}
