//! Axes: what they show, the range they cover, where their ticks go.

use super::number::{round_to, si_prefix, superscripts};

/// How an axis spaces its values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps.
    #[default]
    Linear,
    /// Equal ratios; values that are not positive cannot be shown and break a line.
    Log,
}

/// One axis of a plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// What it shows: `Force`.
    pub label: String,
    /// Its unit, empty for a plain number: `N`.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// From and to, in data units; `None` covers the data.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis that covers its data.
    #[must_use]
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), ..Self::default() }
    }

    /// The same axis, logarithmic.
    #[must_use]
    pub fn log(self) -> Self {
        Self { scale: Scale::Log, ..self }
    }

    /// The same axis over a fixed range, in data units. A range that is empty, not finite, or on a
    /// logarithmic axis not positive, leaves the axis to its data.
    #[must_use]
    pub fn range(self, from: f64, to: f64) -> Self {
        Self { range: Some((from, to)), ..self }
    }

    /// The fixed range, if there is one that can be drawn.
    pub(super) fn fixed(&self) -> Option<(f64, f64)> {
        self.range.filter(|&(from, to)| {
            from < to && (to - from).is_finite() && (self.scale == Scale::Linear || from > 0.0)
        })
    }

    /// Whether a value can be drawn on this axis.
    pub(super) fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    /// The range to draw: the fixed one, or that of the values, with `padding` (a share of the range)
    /// on both sides. Without values, and for a constant, a range that makes sense around it.
    pub(super) fn cover(&self, values: impl Iterator<Item = f64>, padding: f64) -> (f64, f64) {
        if let Some(range) = self.fixed() {
            return range;
        }
        let (low, high) = values
            .filter(|&v| self.shows(v))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        match self.scale {
            _ if low > high => [(0.0, 1.0), (1.0, 10.0)][usize::from(self.scale == Scale::Log)],
            Scale::Linear => {
                let (low, high) = (low.clamp(-1e300, 1e300), high.clamp(-1e300, 1e300));
                let largest = low.abs().max(high.abs());
                if high - low <= 1e-12 * largest || high == low {
                    let room = if largest == 0.0 { 1.0 } else { 0.1 * largest };
                    return (low - room, high + room);
                }
                let room = padding * (high - low);
                (low - room, high + room)
            }
            Scale::Log => {
                let ratio =
                    (high / low).powf(padding).max(if high / low < 1.0 + 1e-9 { 1.5 } else { 1.0 });
                ((low / ratio).max(1e-300), (high * ratio).min(1e300))
            }
        }
    }

    /// The power of a thousand that the tick labels leave out, for a linear axis over this range.
    pub(super) fn thousands(&self, (low, high): (f64, f64)) -> i32 {
        let largest = low.abs().max(high.abs());
        if self.scale == Scale::Log || (1e-2..1e5).contains(&largest) {
            return 0;
        }
        3 * (largest.log10() / 3.0).floor() as i32
    }

    /// Label with unit, and with the power of ten that the tick labels leave out: `Force (mN)`.
    pub(super) fn title(&self, exponent: i32) -> String {
        let prefixed =
            ["N", "Pa", "Hz", "V", "A", "s", "m", "W", "J"].contains(&self.unit.as_str());
        let unit = match (exponent, si_prefix(exponent)) {
            (0, _) => self.unit.clone(),
            // A kilosecond is correct and nobody reads it.
            (_, Some(prefix)) if prefixed && !(self.unit == "s" && exponent > 0) => {
                format!("{prefix}{}", self.unit)
            }
            _ => format!("10{} {}", superscripts(exponent), self.unit).trim_end().to_owned(),
        };
        match (self.label.is_empty(), unit.is_empty()) {
            (_, true) => self.label.clone(),
            (true, false) => unit,
            (false, false) => format!("{} ({unit})", self.label),
        }
    }
}

/// Where an axis is marked.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ticks {
    /// Values with a label.
    pub major: Vec<(f64, String)>,
    /// Values with a small tick only.
    pub minor: Vec<f64>,
}

/// Ticks of an axis over a range: about `target` of them, never more than twice as many.
/// `exponent` is what [`Axis::thousands`] said.
pub(super) fn ticks(scale: Scale, (low, high): (f64, f64), target: usize, exponent: i32) -> Ticks {
    let target = target.max(2);
    match scale {
        Scale::Linear => linear(low, high, target, exponent),
        Scale::Log if (high / low).log10() < 0.7 => linear(low, high, target, 0),
        Scale::Log => logarithmic(low, high, target),
    }
}

/// The smallest of 1, 2, 5 times a power of ten that gives at most `target` steps: factor, exponent.
fn step(span: f64, target: usize) -> (f64, i32) {
    let raw = span / target as f64;
    let power = raw.log10().floor() as i32;
    let decade = 10f64.powi(power);
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * decade >= raw * (1.0 - 1e-9));
    factor.map_or((1.0, power + 1), |factor| (factor, power))
}

fn linear(low: f64, high: f64, target: usize, exponent: i32) -> Ticks {
    let (factor, power) = step(high - low, target);
    // Multiples are divided, not multiplied, by powers of ten below one: 3 / 10 is 0.3, 3 × 0.1 is not.
    let value = |k: f64| {
        let k = k * factor;
        if power >= 0 { k * 10f64.powi(power) } else { k / 10f64.powi(-power) }
    };
    let size = value(1.0);
    let (first, last) = ((low / size - 1e-9).ceil(), (high / size + 1e-9).floor());
    let count = (last - first).clamp(0.0, 4.0 * target as f64) as usize;
    if !size.is_normal() || !first.is_finite() || last < first {
        return Ticks::default();
    }
    let label = |k: f64| {
        let decimals = (exponent - power).max(0);
        let text = round_to(k * factor * 10f64.powi(power - exponent), decimals);
        text.replace('-', "−")
    };
    let major = (0..=count).map(|i| first + i as f64).map(|k| (value(k), label(k))).collect();
    Ticks { major, minor: Vec::new() }
}

fn logarithmic(low: f64, high: f64, target: usize) -> Ticks {
    let (from, to) = ((low.log10() - 1e-9).ceil() as i32, (high.log10() + 1e-9).floor() as i32);
    let inside = |v: &f64| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9);
    let decades = (to - from + 1).max(0) as usize;
    let every = decades.div_ceil(target).max(1) as i32;
    let factors: &[f64] = if decades * 3 <= target + 1 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let multiples = |factors: &'static [f64]| {
        (from - 1..=to).flat_map(move |d| factors.iter().map(move |f| (*f, d)))
    };
    let value = |f: f64, d: i32| if d >= 0 { f * 10f64.powi(d) } else { f / 10f64.powi(-d) };
    let mut major = Vec::new();
    for decade in from - 1..=to {
        for &factor in factors {
            let v = value(factor, decade);
            if inside(&v) && (decade - from).rem_euclid(every) == 0 {
                major.push((v, decade_label(factor, decade)));
            }
        }
    }
    let minor = if every > 1 {
        (from..=to).map(|d| value(1.0, d)).filter(inside).collect()
    } else {
        multiples(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
            .map(|(f, d)| value(f, d))
            .filter(inside)
            .collect()
    };
    Ticks { major, minor }
}

fn decade_label(factor: f64, decade: i32) -> String {
    if (-3..=4).contains(&decade) {
        return round_to(factor * 10f64.powi(decade), (-decade).max(0));
    }
    let power = format!("10{}", superscripts(decade));
    if factor == 1.0 { power } else { format!("{factor}×{power}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.major.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn steps_are_one_two_or_five_with_just_enough_decimals() {
        let at = |low, high| ticks(Scale::Linear, (low, high), 5, 0);
        assert_eq!(labels(&at(0.0, 10.0)), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(&at(-0.11, 0.1)), ["−0.10", "−0.05", "0.00", "0.05", "0.10"]);
        assert_eq!(labels(&at(0.0, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&at(0.0, 20_000.0)), ["0", "5000", "10000", "15000", "20000"]);
        assert_eq!(at(0.0, 0.3).major[3].0, 0.3);
    }

    #[test]
    fn large_and_small_ranges_move_the_power_of_ten_into_the_label() {
        let stiffness = Axis::new("Stiffness", "Pa");
        let range = (0.0, 1.3e5);
        assert_eq!(stiffness.title(stiffness.thousands(range)), "Stiffness (kPa)");
        assert_eq!(labels(&ticks(Scale::Linear, range, 3, 3)), ["0", "50", "100"]);
        let gap = Axis::new("Gap", "mm");
        assert_eq!(gap.title(gap.thousands((0.0, 2e-4))), "Gap (10⁻⁶ mm)");
        assert_eq!(gap.title(gap.thousands((0.0, 12.0))), "Gap (mm)");
        assert_eq!(Axis::new("Share", "").title(0), "Share");
        assert_eq!(Axis::new("Time", "s").title(3), "Time (10³ s)");
    }

    #[test]
    fn logarithmic_ticks_sit_on_decades_and_thin_out() {
        let at = |low, high, n| ticks(Scale::Log, (low, high), n, 0);
        assert_eq!(labels(&at(0.01, 100.0, 6)), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(&at(0.9, 30.0, 6)), ["1", "2", "5", "10", "20"]);
        assert_eq!(labels(&at(1e-9, 1e9, 4)), ["10⁻⁹", "10⁻⁴", "10", "10⁶"]);
        assert_eq!(labels(&at(2.0, 3.0, 5)), ["2.0", "2.2", "2.4", "2.6", "2.8", "3.0"]);
        assert!(at(1.0, 100.0, 4).minor.contains(&30.0));
    }

    #[test]
    fn an_axis_without_data_or_with_one_value_still_has_a_range() {
        let axis = Axis::new("F", "N");
        assert_eq!(axis.cover([].into_iter(), 0.05), (0.0, 1.0));
        assert_eq!(axis.cover([f64::NAN, f64::INFINITY].into_iter(), 0.05), (0.0, 1.0));
        assert_eq!(axis.cover([5.0, 5.0].into_iter(), 0.05), (4.5, 5.5));
        assert_eq!(axis.cover([0.0].into_iter(), 0.05), (-1.0, 1.0));
        assert_eq!(axis.clone().log().cover([-1.0, 0.0].into_iter(), 0.0), (1.0, 10.0));
        assert_eq!(axis.clone().range(3.0, 2.0).cover([1.0, 2.0].into_iter(), 0.0), (1.0, 2.0));
    }

    proptest! {
        #[test]
        fn ticks_are_inside_increasing_few_and_all_different(
            low in -1.0..1.0f64, power in -290..290i32, ratio in 1e-9..1e3f64, target in 2..12usize, log: bool,
        ) {
            let scale = if log { Scale::Log } else { Scale::Linear };
            let unit = 10f64.powi(power);
            let low = if log { (low + 1.5) * unit } else { low * unit };
            let axis = Axis { scale, ..Axis::new("", "") };
            let range = axis.cover([low, low + unit * ratio].into_iter(), 0.05);
            let ticks = ticks(scale, range, target, axis.thousands(range));
            prop_assert!(ticks.major.len() <= 2 * target + 2, "{ticks:?}");
            let room = 1e-6 * (range.1 - range.0);
            for (value, _) in &ticks.major {
                prop_assert!(*value >= range.0 - room && *value <= range.1 + room, "{value} {range:?}");
            }
            for pair in ticks.major.windows(2) {
                prop_assert!(pair[0].0 < pair[1].0, "{ticks:?}");
                prop_assert!(pair[0].1 != pair[1].1, "{ticks:?}");
            }
        }
    }
}
