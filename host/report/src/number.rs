//! Numbers as text: standard errors, significant digits, SI prefixes, percentages, durations.
//!
//! Every function returns plain text that a program can read back (`-1.2e-7`); [`typographic`] turns
//! it into what a person likes to read (`−1.2×10⁻⁷`). NaN is `–`, infinity `∞`, and zero never has a sign.

/// Decimal exponents that are written out in full; beyond them scientific notation takes over.
const PLAIN: std::ops::Range<i32> = -4..7;

/// A number to `digits` significant digits (at least 1): `0.0493`, `-12.0`, `35000`, `1.22e-7`.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    if let Some(text) = special(value) {
        return text;
    }
    let (mantissa, exponent) = scientific(value, digits.max(1));
    if !PLAIN.contains(&exponent) {
        return format!("{mantissa}e{exponent}");
    }
    let decimals = digits.max(1) as i32 - 1 - exponent;
    round_to(value, decimals)
}

/// A number with the decimals that the largest beside it has with so many significant digits.
pub(super) fn beside(value: f64, largest: f64, digits: usize) -> String {
    let (_, exponent) = scientific(largest, digits.max(1));
    if largest == 0.0 || (value != 0.0 && special(value).is_some()) || !PLAIN.contains(&exponent) {
        return significant(value, digits);
    }
    round_to(value, digits.max(1) as i32 - 1 - exponent)
}

/// A value with its standard error: the error has two significant digits and decides the decimals,
/// `3.981 ± 0.074`, `122100 ± 340`, `(1.221 ± 0.034)e8`.
///
/// An error of zero (a value held fixed) is left out. One that is not known (NaN) is written `± –`,
/// an infinite one `± ∞`, and the value then has four significant digits. An error too small to show
/// beside the value in the digits that `f64` holds is written on its own scale.
#[must_use]
pub fn with_error(value: f64, standard_error: f64) -> String {
    let error = standard_error.abs();
    if !value.is_finite() || error == 0.0 {
        return significant(value, 6);
    }
    if !error.is_finite() {
        return format!("{} ± {}", significant(value, 4), significant(error, 2));
    }
    let (_, error_exponent) = scientific(error, 2);
    let value_exponent = if value == 0.0 { error_exponent } else { scientific(value, 15).1 };
    if value_exponent - error_exponent > 13 {
        return format!("{} ± {}", significant(value, 15), significant(error, 2));
    }
    let decimals = 1 - error_exponent;
    let largest = value_exponent.max(error_exponent);
    if PLAIN.contains(&largest) && decimals <= 8 {
        return format!("{} ± {}", round_to(value, decimals), round_to(error, decimals));
    }
    let shifted = |number| round_to(shift(number, -largest), decimals + largest);
    format!("({} ± {})e{largest}", shifted(value), shifted(error))
}

/// A quantity with an SI prefix, `35.0 kPa`, `-12.0 mN`; `unit` is a plain unit such as `N` or `Pa`.
/// Beyond pico and tera it is scientific.
#[must_use]
pub fn engineering(value: f64, unit: &str, digits: usize) -> String {
    if let Some(text) = special(value) {
        return format!("{text} {unit}");
    }
    let thousands = scientific(value, digits.max(1)).1.div_euclid(3);
    match si_prefix(3 * thousands) {
        Some(prefix) => {
            format!("{} {prefix}{unit}", significant(shift(value, -3 * thousands), digits))
        }
        None => format!("{} {unit}", significant(value, digits)),
    }
}

/// The SI prefix of a power of ten, pico to tera: `si_prefix(-3)` is `m`.
#[must_use]
pub fn si_prefix(exponent: i32) -> Option<&'static str> {
    Some(match exponent {
        -12 => "p",
        -9 => "n",
        -6 => "µ",
        -3 => "m",
        0 => "",
        3 => "k",
        6 => "M",
        9 => "G",
        12 => "T",
        _ => return None,
    })
}

/// A fraction as a percentage with `digits` significant digits: `0.613` is `61 %`.
#[must_use]
pub fn percent(fraction: f64, digits: usize) -> String {
    format!("{} %", significant(fraction * 100.0, digits))
}

/// A share of a whole: `61 %`, `0.4 %`, `0 %`; whole from ten percent on and one decimal below, so that shares beside each other
/// have the same.
#[must_use]
pub fn share(fraction: f64) -> String {
    let percent = fraction * 100.0;
    if !percent.is_finite() {
        return format!("{} %", significant(percent, 1));
    }
    let decimals = if percent.abs() < 9.95 { 1 } else { 0 };
    let text = round_to(percent, decimals);
    format!("{} %", if text == "0.0" { "0" } else { &text })
}

/// A length of time: `12.0 ms`, `4.30 s`, `4 min 12 s`, `3 h 14 min`, `2 d 3 h`.
#[must_use]
pub fn duration(seconds: f64) -> String {
    let sign = if seconds < 0.0 { "-" } else { "" };
    let length = seconds.abs();
    if !length.is_finite() || length < 59.95 {
        return engineering(seconds, "s", 3);
    }
    let (large, small, ratio, unit) = match length {
        s if s < 3599.5 => ("min", "s", 60.0, 1.0),
        s if s < 24.0 * 3600.0 - 30.0 => ("h", "min", 60.0, 60.0),
        _ => ("d", "h", 24.0, 3600.0),
    };
    let count = (length / unit).round();
    let (whole, rest) = ((count / ratio).floor(), count % ratio);
    format!("{sign}{whole} {large} {rest} {small}")
}

/// So many of something: `1 hold`, `2 holds`.
#[must_use]
pub fn counted(count: usize, of: &str) -> String {
    format!("{count} {of}{}", if count == 1 { "" } else { "s" })
}

/// A number of this module with one decimal less: `0.00785` is `0.0079`, `3.981 ± 0.074` is `3.98 ± 0.07`, `1.1187(18)` is
/// `1.119(2)`. None where a plain number would be left with one digit, an error with none, or there are no decimals.
#[must_use]
pub fn with_a_digit_less(text: &str) -> Option<String> {
    let value_end = text.find(|c: char| !matches!(c, '-' | '.' | '0'..='9')).unwrap_or(text.len());
    let (value, rest) = text.split_at(value_end);
    let decimals = i32::try_from(value.split_once('.')?.1.len()).ok()? - 1;
    let less = round_to(value.parse().ok()?, decimals);
    let is_zero = |text: &str| !text.bytes().any(|digit| matches!(digit, b'1'..=b'9'));
    if let Some(error) = rest.strip_prefix(" ± ") {
        let error = round_to(error.parse().ok()?, decimals);
        return (!is_zero(&error)).then(|| format!("{less} ± {error}"));
    }
    if let Some(error) = rest.strip_prefix('(') {
        let error: f64 = error.strip_suffix(')')?.parse().ok()?;
        // In units of the last digit, unless it has a point of its own.
        let error = if rest.contains('.') { error } else { error / 10.0 };
        let error = round_to(error, if rest.contains('.') { decimals } else { 0 });
        return (!is_zero(&error)).then(|| format!("{less}({error})"));
    }
    let digits = value.trim_start_matches(['-', '0', '.']).bytes().filter(u8::is_ascii_digit);
    (digits.count() > 2).then(|| less + rest)
}

/// Sets a number from this module for reading: a true minus sign, and `×10⁻⁷` for `e-7`.
#[must_use]
pub fn typographic(number: &str) -> String {
    let mut out = String::with_capacity(number.len() + 4);
    let mut characters = number.chars().peekable();
    let mut previous = ' ';
    while let Some(c) = characters.next() {
        let next = characters.peek().copied().unwrap_or(' ');
        match c {
            '-' if next.is_ascii_digit() && matches!(previous, ' ' | '(' | '±') => out.push('−'),
            'e' if matches!(previous, '0'..='9' | ')')
                && (next == '-' || next.is_ascii_digit()) =>
            {
                out.push_str("×10");
                while let Some(&d) = characters.peek().filter(|d| **d == '-' || d.is_ascii_digit())
                {
                    out.push(superscript(d));
                    characters.next();
                }
            }
            other => out.push(other),
        }
        previous = c;
    }
    out
}

/// A whole number as superscript, for `10⁻⁷`.
#[must_use]
pub fn superscripts(exponent: i32) -> String {
    exponent.to_string().chars().map(superscript).collect()
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + (digit as u32 - '0' as u32)).unwrap_or(digit),
    }
}

fn special(value: f64) -> Option<String> {
    let text = match value {
        v if v.is_nan() => "–",
        f64::INFINITY => "∞",
        f64::NEG_INFINITY => "-∞",
        0.0 => "0",
        _ => return None,
    };
    Some(text.to_owned())
}

/// Mantissa and exponent after rounding, so that 9.99 to two digits is `1.0` and 1.
fn scientific(value: f64, digits: usize) -> (String, i32) {
    let text = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    (mantissa.to_owned(), exponent.parse().unwrap_or(0))
}

/// value · 10^exponent by moving the decimal point, so no binary rounding creeps in.
fn shift(value: f64, exponent: i32) -> f64 {
    let text = format!("{value:e}");
    let (mantissa, own) = text.split_once('e').unwrap_or((&text, "0"));
    let own: i32 = own.parse().unwrap_or(0);
    format!("{mantissa}e{}", own + exponent).parse().unwrap_or(value)
}

/// Rounds to a decimal place: two decimals for 2, whole hundreds for −2. Never `-0`.
pub(super) fn round_to(value: f64, decimals: i32) -> String {
    let text = if decimals >= 0 {
        format!("{value:.*}", decimals as usize)
    } else {
        let units = format!("{:.0}", shift(value, decimals));
        let zeros = if units.trim_start_matches('-') == "0" { 0 } else { -decimals as usize };
        units + &"0".repeat(zeros)
    };
    let is_zero = !text.bytes().any(|b| matches!(b, b'1'..=b'9'));
    if is_zero { text.trim_start_matches('-').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn two_digits_of_the_error_decide_the_decimals() {
        assert_eq!(with_error(3.98123, 0.0743), "3.981 ± 0.074");
        assert_eq!(with_error(-0.4931, 0.0099), "-0.4931 ± 0.0099");
        assert_eq!(with_error(122_134.0, 341.0), "122130 ± 340");
        assert_eq!(with_error(3.2, 0.0999), "3.20 ± 0.10");
        assert_eq!(with_error(0.01, 34.0), "0 ± 34");
        assert_eq!(with_error(-0.01, 3.4), "0.0 ± 3.4");
        assert_eq!(with_error(1.221e8, 3.4e6), "(1.221 ± 0.034)e8");
        assert_eq!(with_error(-2.0e-9, 1.0e-10), "(-2.00 ± 0.10)e-9");
    }

    #[test]
    fn an_error_that_is_not_a_number_is_said_not_hidden() {
        assert_eq!(with_error(1.5, f64::NAN), "1.500 ± –");
        assert_eq!(with_error(1.5, f64::INFINITY), "1.500 ± ∞");
        assert_eq!(with_error(1.5, 0.0), "1.50000");
        assert_eq!(with_error(f64::NAN, 0.1), "–");
        assert_eq!(with_error(1.0, 1e-20), "1.00000000000000 ± 1.0e-20");
    }

    #[test]
    fn significant_digits_carry_when_rounding_up() {
        assert_eq!(significant(0.04932, 3), "0.0493");
        assert_eq!(significant(9.996, 3), "10.0");
        assert_eq!(significant(999_999.6, 6), "1000000");
        assert_eq!(significant(122_134.0, 3), "122000");
        assert_eq!(significant(1.224e-7, 3), "1.22e-7");
        assert_eq!(significant(-0.0, 3), "0");
    }

    #[test]
    fn quantities_take_the_prefix_that_keeps_one_to_three_digits_before_the_point() {
        assert_eq!(engineering(34_970.0, "Pa", 3), "35.0 kPa");
        assert_eq!(engineering(-0.012, "N", 3), "-12.0 mN");
        assert_eq!(engineering(999.96, "Hz", 3), "1.00 kHz");
        assert_eq!(engineering(0.0, "N", 3), "0 N");
        assert_eq!(engineering(1e-15, "m", 2), "1.0e-15 m");
    }

    #[test]
    fn durations_read_like_a_clock() {
        assert_eq!(duration(0.012), "12.0 ms");
        assert_eq!(duration(4.3), "4.30 s");
        assert_eq!(duration(59.99), "1 min 0 s");
        assert_eq!(duration(252.0), "4 min 12 s");
        assert_eq!(duration(3599.9), "1 h 0 min");
        assert_eq!(duration(11_628.0), "3 h 14 min");
        assert_eq!(duration(183_600.0), "2 d 3 h");
        assert_eq!(duration(86_399.0), "1 d 0 h");
    }

    #[test]
    fn percentages_keep_small_shares_visible() {
        assert_eq!(percent(0.613, 2), "61 %");
        assert_eq!(percent(0.0004, 2), "0.040 %");
        assert_eq!(percent(1.0, 2), "100 %");
    }

    #[test]
    fn shares_beside_each_other_have_one_number_of_decimals() {
        let texts = [0.0, 0.0004, 0.0009, 0.005, 0.0099, 0.0994, 0.0996, 0.613, -0.02].map(share);
        let wanted = ["0 %", "0 %", "0.1 %", "0.5 %", "1.0 %", "9.9 %", "10 %", "61 %", "-2.0 %"];
        assert_eq!(texts, wanted);
    }

    #[test]
    fn one_is_not_many() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "hold")), ["0 holds", "1 hold", "2 holds"]);
    }

    #[test]
    fn typographic_numbers_have_a_minus_sign_and_powers_of_ten() {
        assert_eq!(typographic("-1.20e-7"), "−1.20×10⁻⁷");
        assert_eq!(typographic("(-2.00 ± 0.10)e13"), "(−2.00 ± 0.10)×10¹³");
        assert_eq!(typographic("hold-12mm"), "hold-12mm");
        assert_eq!(superscripts(-40), "⁻⁴⁰");
    }

    #[test]
    fn a_digit_less_is_the_same_number_rounded() {
        let cases = [
            ("0.00786", Some("0.0079")),
            ("12.6", Some("13")),
            ("-12.6", Some("-13")),
            ("0.12", None),
            ("120", None),
            ("3.981 ± 0.074", Some("3.98 ± 0.07")),
            ("3.98 ± 0.07", Some("4.0 ± 0.1")),
            ("4.00 ± 0.04", None),
            ("1.1187(18)", Some("1.119(2)")),
            ("53.2(1.4)", Some("53(1)")),
            ("881(24)", None),
            ("61.3 %", Some("61 %")),
            ("1.22e-7", Some("1.2e-7")),
            ("–", None),
            ("trace", None),
        ];
        for (text, less) in cases {
            assert_eq!(with_a_digit_less(text).as_deref(), less, "{text}");
        }
    }

    fn read_back(text: &str) -> (f64, f64) {
        let (value, error) = text.split_once(" ± ").expect("a value and an error");
        let (factor, error) = match (value.strip_prefix('('), error.split_once(")e")) {
            (Some(_), Some((error, exponent))) => (format!("e{exponent}"), error),
            _ => (String::new(), error),
        };
        let number = |s: &str| format!("{}{factor}", s.trim_start_matches('(')).parse().unwrap();
        (number(value), number(error))
    }

    proptest! {
        #[test]
        fn a_value_with_error_never_loses_its_magnitude(
            mantissa in -10.0..10.0f64, power in -250..250i32, ratio in 1e-12..1e3f64,
        ) {
            let value = mantissa * 10f64.powi(power);
            let error = 10f64.powi(power) * ratio;
            let text = with_error(value, error);
            let (value_read, error_read) = read_back(&text);
            prop_assert!((error_read / error - 1.0).abs() < 0.051, "{text}");
            prop_assert!((value_read - value).abs() <= 0.0501 * error, "{text} of {value} ± {error}");
            prop_assert!(!text.starts_with("-0 ") && !text.contains("-0.0 "), "{text}");
        }

        #[test]
        fn significant_digits_are_within_half_a_unit(value in proptest::num::f64::NORMAL, digits in 1..16usize) {
            let text = significant(value, digits);
            let read: f64 = text.parse().unwrap();
            prop_assert!((read / value - 1.0).abs() <= 0.51 * 10f64.powi(1 - digits as i32), "{text}");
        }

        #[test]
        fn nothing_prints_a_negative_zero(value in -1e-3..1e-3f64, decimals in -3..9i32) {
            let text = round_to(value, decimals);
            prop_assert!(!text.starts_with('-') || text.bytes().any(|b| matches!(b, b'1'..=b'9')), "{text}");
        }
    }
}
