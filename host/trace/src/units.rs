//! Units a recording may be in, by name.

/// What a unit measures; only units of one quantity convert into each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Base unit s.
    Time,
    /// Base unit m.
    Length,
    /// Base unit N.
    Force,
    /// Stress or modulus, base unit Pa.
    Stress,
    /// Base unit 1/Pa.
    Compliance,
    /// Base unit K.
    Temperature,
    /// Strain or any other ratio, base unit 1.
    Ratio,
    /// Base unit V.
    Voltage,
    /// Base unit Ω.
    Resistance,
    /// Base unit N m.
    Torque,
}

/// A named unit: `base = factor * value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name, as written in a mapping or after the last underscore of a column's name.
    pub name: &'static str,
    /// What it measures.
    pub quantity: Quantity,
    /// Base units in one of it.
    pub factor: f64,
    /// Base value at its zero; only scales of temperature have one.
    pub offset: f64,
}

const fn unit(name: &'static str, quantity: Quantity, factor: f64) -> Unit {
    Unit { name, quantity, factor, offset: 0.0 }
}

/// Every unit known, by quantity.
pub const UNITS: &[Unit] = &[
    unit("ns", Quantity::Time, 1e-9),
    unit("us", Quantity::Time, 1e-6),
    unit("µs", Quantity::Time, 1e-6),
    unit("ms", Quantity::Time, 1e-3),
    unit("s", Quantity::Time, 1.0),
    unit("min", Quantity::Time, 60.0),
    unit("h", Quantity::Time, 3600.0),
    unit("nm", Quantity::Length, 1e-9),
    unit("um", Quantity::Length, 1e-6),
    unit("µm", Quantity::Length, 1e-6),
    unit("mm", Quantity::Length, 1e-3),
    unit("cm", Quantity::Length, 1e-2),
    unit("m", Quantity::Length, 1.0),
    unit("in", Quantity::Length, 0.0254),
    unit("pN", Quantity::Force, 1e-12),
    unit("nN", Quantity::Force, 1e-9),
    unit("uN", Quantity::Force, 1e-6),
    unit("µN", Quantity::Force, 1e-6),
    unit("mN", Quantity::Force, 1e-3),
    unit("N", Quantity::Force, 1.0),
    unit("kN", Quantity::Force, 1e3),
    unit("gf", Quantity::Force, 9.806_65e-3),
    unit("kgf", Quantity::Force, 9.806_65),
    unit("lbf", Quantity::Force, 4.448_221_615_260_5),
    unit("Pa", Quantity::Stress, 1.0),
    unit("kPa", Quantity::Stress, 1e3),
    unit("MPa", Quantity::Stress, 1e6),
    unit("GPa", Quantity::Stress, 1e9),
    unit("mbar", Quantity::Stress, 1e2),
    unit("bar", Quantity::Stress, 1e5),
    unit("psi", Quantity::Stress, 6_894.757_293_168_361),
    unit("1/Pa", Quantity::Compliance, 1.0),
    unit("per_Pa", Quantity::Compliance, 1.0),
    unit("1/kPa", Quantity::Compliance, 1e-3),
    unit("per_kPa", Quantity::Compliance, 1e-3),
    unit("1/MPa", Quantity::Compliance, 1e-6),
    unit("per_MPa", Quantity::Compliance, 1e-6),
    unit("K", Quantity::Temperature, 1.0),
    Unit { name: "C", quantity: Quantity::Temperature, factor: 1.0, offset: 273.15 },
    Unit { name: "°C", quantity: Quantity::Temperature, factor: 1.0, offset: 273.15 },
    Unit {
        name: "F",
        quantity: Quantity::Temperature,
        factor: 5.0 / 9.0,
        offset: 273.15 - 32.0 * 5.0 / 9.0,
    },
    unit("1", Quantity::Ratio, 1.0),
    unit("strain", Quantity::Ratio, 1.0),
    unit("%", Quantity::Ratio, 1e-2),
    unit("percent", Quantity::Ratio, 1e-2),
    unit("mstrain", Quantity::Ratio, 1e-3),
    unit("ustrain", Quantity::Ratio, 1e-6),
    unit("µstrain", Quantity::Ratio, 1e-6),
    unit("ppm", Quantity::Ratio, 1e-6),
    unit("uV", Quantity::Voltage, 1e-6),
    unit("µV", Quantity::Voltage, 1e-6),
    unit("mV", Quantity::Voltage, 1e-3),
    unit("V", Quantity::Voltage, 1.0),
    unit("mohm", Quantity::Resistance, 1e-3),
    unit("ohm", Quantity::Resistance, 1.0),
    unit("Ω", Quantity::Resistance, 1.0),
    unit("Ohm", Quantity::Resistance, 1.0),
    unit("kohm", Quantity::Resistance, 1e3),
    unit("kΩ", Quantity::Resistance, 1e3),
    unit("uNm", Quantity::Torque, 1e-6),
    unit("mNm", Quantity::Torque, 1e-3),
    unit("Nm", Quantity::Torque, 1.0),
];

/// The unit of that exact name.
#[must_use]
pub fn named(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name)
}

/// The unit at the end of a column's name: `mm` of `displacement_mm`, `per_Pa` of `creep_compliance_per_Pa`.
#[must_use]
pub fn of_column(column: &str) -> Option<&'static Unit> {
    UNITS
        .iter()
        .filter(|unit| column.strip_suffix(unit.name).is_some_and(|rest| rest.ends_with('_')))
        .max_by_key(|unit| unit.name.len())
}

/// The unit of a column, as its name gives it, in print.
#[must_use]
pub fn printed(column: &str) -> &str {
    match of_column(column).map(|unit| unit.name) {
        Some("ustrain") => "µε",
        Some("ohm" | "Ohm") => "Ω",
        Some("kohm") => "kΩ",
        Some("C") => "°C",
        Some(unit) => unit.strip_prefix("per_").map_or(unit, |_| "1/Pa"),
        None => "",
    }
}

/// From one unit to another: `value * multiply / divide + add`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    /// Factor; 1 where the step is a division.
    pub multiply: f64,
    /// Divisor; 1 where the step is a multiplication. Dividing by 1000 rounds once, 0.001 twice.
    pub divide: f64,
    /// What is added in the end, in the new unit.
    pub add: f64,
}

impl Conversion {
    /// The value in the new unit.
    #[must_use]
    pub fn apply(&self, value: f64) -> f64 {
        value * self.multiply / self.divide + self.add
    }
}

impl Unit {
    /// How values in this unit become values in `to`; none if the two measure different things.
    #[must_use]
    pub fn conversion(&self, to: &Self) -> Option<Conversion> {
        // 1e-3 / 1e-9 is not 1e6 in binary; where a ratio is a whole number, it is that number.
        let whole = |ratio: f64| {
            let rounded = ratio.round();
            if (ratio - rounded).abs() < 1e-9 * ratio { rounded } else { ratio }
        };
        (self.quantity == to.quantity).then(|| {
            let add = (self.offset - to.offset) / to.factor;
            if self.factor >= to.factor {
                Conversion { multiply: whole(self.factor / to.factor), divide: 1.0, add }
            } else {
                Conversion { multiply: 1.0, divide: whole(to.factor / self.factor), add }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn convert(value: f64, from: &str, to: &str) -> f64 {
        named(from).unwrap().conversion(named(to).unwrap()).unwrap().apply(value)
    }

    #[test]
    fn decimal_prefixes_convert_without_rounding() {
        assert_eq!(convert(3.0, "ms", "s"), 0.003);
        assert_eq!(convert(1.5, "m", "mm"), 1500.0);
        assert_eq!(convert(7.0, "MPa", "kPa"), 7000.0);
        assert_eq!(convert(7.0, "nN", "N"), 7e-9);
    }

    #[test]
    fn temperatures_convert_with_their_zero() {
        assert!((convert(20.0, "C", "K") - 293.15).abs() < 1e-9);
        assert!((convert(98.6, "F", "C") - 37.0).abs() < 1e-9);
    }

    #[test]
    fn the_unit_is_read_off_the_end_of_a_column_name() {
        assert_eq!(of_column("displacement_mm").unwrap().name, "mm");
        assert_eq!(of_column("creep_compliance_per_Pa").unwrap().name, "per_Pa");
        assert!(of_column("status").is_none());
    }

    #[test]
    fn different_quantities_do_not_convert() {
        assert!(named("mm").unwrap().conversion(named("s").unwrap()).is_none());
    }
}
