//! Times that are written as dates or as on a clock.

use serde::{Deserialize, Serialize};

/// How a column writes its times, where they are no plain numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stamp {
    /// `2024-05-31 14:03:05.25`, also with `/` or `.`, a `T` between date and time, and a zone behind (`Z`, `+02:00`).
    YearFirst,
    /// `31.05.2024 14:03:05,25`
    DayFirst,
    /// `05/31/2024 02:03:05.25 PM`
    MonthFirst,
    /// `14:03:05.25`, without a date; a recording that goes on past midnight goes on.
    Clock,
}

/// A time as whole seconds and the rest, so that a difference of two loses nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instant {
    /// Whole seconds: since 1970 (UTC where no zone is written), or since midnight.
    pub(super) whole: i64,
    /// The rest of a second, from 0 to 1.
    pub(super) rest: f64,
}

impl Stamp {
    /// All of them, the one that a text speaks for most plainly first.
    #[cfg(feature = "suggest")]
    pub(super) const ALL: [Self; 4] =
        [Self::YearFirst, Self::DayFirst, Self::MonthFirst, Self::Clock];

    /// Its name in a mapping.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::YearFirst => "year-first",
            Self::DayFirst => "day-first",
            Self::MonthFirst => "month-first",
            Self::Clock => "clock",
        }
    }

    /// Reads a time; none if the text is not written so.
    pub(super) fn read(self, text: &str) -> Option<Instant> {
        let text = text.trim();
        if self == Self::Clock {
            return clock(text);
        }
        let (date, time) = match text.find([' ', 'T']) {
            Some(at) => (&text[..at], text[at + 1..].trim()),
            None => (text, "00:00:00"),
        };
        let mut parts = date.split(['-', '/', '.']);
        let mut part = || {
            let digits = parts.next()?;
            Some((digits.parse::<i64>().ok().filter(|&number| number >= 0)?, digits.len()))
        };
        let (first, second, third) = (part()?, part()?, part()?);
        if parts.next().is_some() {
            return None;
        }
        let (year, month, day) = match self {
            Self::YearFirst => (first, second, third),
            Self::DayFirst => (third, second, first),
            _ => (third, first, second),
        };
        let fits = year.1 == 4 && (1..=12).contains(&month.0) && (1..=31).contains(&day.0);
        let (time, zone) = zone(time)?;
        let mut instant = clock(time).filter(|_| fits)?;
        instant.whole += days(year.0, month.0, day.0) * 86_400 - zone;
        Some(instant)
    }
}

/// Cuts the zone off a time of day: seconds that it is ahead of UTC.
fn zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix('Z') {
        return Some((time.trim(), 0));
    }
    let Some(at) = time.rfind(['+', '-']) else { return Some((time, 0)) };
    let digits: String = time[at + 1..].chars().filter(|&c| c != ':').collect();
    let number: i64 = digits.parse().ok()?;
    let ahead = match digits.len() {
        2 => number * 3600,
        4 => (number / 100) * 3600 + (number % 100) * 60,
        _ => return None,
    };
    Some((time[..at].trim(), if time.as_bytes()[at] == b'-' { -ahead } else { ahead }))
}

/// `14:03`, `14:03:05.25`, `02:03:05 PM`.
fn clock(text: &str) -> Option<Instant> {
    let lower = text.to_ascii_lowercase();
    let (text, half) = match lower.strip_suffix('m').map(|text| text.trim_end_matches('.')) {
        Some(text) if text.ends_with('a') => (text[..text.len() - 1].trim(), Some(0)),
        Some(text) if text.ends_with('p') => (text[..text.len() - 1].trim(), Some(12)),
        Some(_) => return None,
        None => (lower.trim(), None),
    };
    let digits = |text: &str| text.parse::<u32>().ok().map(i64::from);
    let mut parts = text.split(':');
    let (hour, minute) = (digits(parts.next()?)?, digits(parts.next()?)?);
    let seconds = parts.next().unwrap_or("0").replace(',', ".");
    let (second, rest) = seconds.split_once('.').unwrap_or((&seconds, ""));
    let rest = if rest.is_empty() { 0.0 } else { digits_after(rest)? };
    let hour = match half {
        Some(after) if (1..=12).contains(&hour) => hour % 12 + after,
        Some(_) => return None,
        None => hour,
    };
    let second = digits(second)?;
    let fits = parts.next().is_none() && hour < 1000 && minute < 60 && second < 61;
    fits.then_some(Instant { whole: hour * 3600 + minute * 60 + second, rest })
}

fn digits_after(point: &str) -> Option<f64> {
    let plain = point.bytes().all(|byte| byte.is_ascii_digit());
    plain.then(|| format!("0.{point}").parse().ok())?
}

/// Days from 1970-01-01 to a day of the Gregorian calendar. Years are counted from March, so that a leap day ends one.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month > 2 { year } else { year - 1 };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(stamp: Stamp, text: &str) -> Option<f64> {
        stamp.read(text).map(|instant| instant.whole as f64 + instant.rest)
    }

    #[test]
    fn one_instant_is_read_however_it_is_written() {
        // `date -u -d @1717164185`
        let expected = Some(1_717_164_185.25);
        for (stamp, text) in [
            (Stamp::YearFirst, "2024-05-31 14:03:05.25"),
            (Stamp::YearFirst, "2024-05-31T14:03:05.250Z"),
            (Stamp::YearFirst, "2024-05-31T16:03:05.25+02:00"),
            (Stamp::YearFirst, "2024/05/31 09:33:05,25 -0430"),
            (Stamp::DayFirst, "31.05.2024 14:03:05,25"),
            (Stamp::MonthFirst, "5/31/2024 2:03:05.25 PM"),
        ] {
            assert_eq!(seconds(stamp, text), expected, "{text}");
        }
        assert_eq!(seconds(Stamp::YearFirst, "1970-01-01"), Some(0.0));
        assert_eq!(seconds(Stamp::YearFirst, "2000-03-01"), Some(951_868_800.0));
        assert_eq!(seconds(Stamp::Clock, "12:00:00.5"), Some(43_200.5));
        assert_eq!(seconds(Stamp::Clock, "12:00:00 am"), Some(0.0));
    }

    #[test]
    fn what_is_no_time_is_none() {
        for text in
            ["", "1.5", "12", "a:b:c", "12:61:00", "1:2:3:4", "12:00:00.-5", "13:00 pm", "µm"]
        {
            assert_eq!(seconds(Stamp::Clock, text), None, "{text}");
        }
        for text in ["31.05.2024", "2024-13-01", "2024-05-31 x", "2024-5", "1.2.3", "2024-05-31 1+"]
        {
            assert_eq!(seconds(Stamp::YearFirst, text), None, "{text}");
        }
    }
}
