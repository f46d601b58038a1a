//! NanoScope of Veeco and Bruker (`.spm`, `.000` …): force curves and force volumes.
//!
//! A header of lists, then whole numbers, the least byte first. A curve is its way in and its way back, both from the position
//! nearest to the specimen outwards. A number becomes volts by the hard scale (V for a count) and nm by the soft scale that this
//! names in brackets; the way of the piezo follows from the size of its ramp.

use std::path::Path;

use super::{Curve, Sample, Stretch, whole, whole_numbers};
use crate::error::guarded;
use crate::limits::Budget;
use crate::{Contents, Error};

const NANOSCOPE: &str = "NanoScope file";
const END_OF_HEADER: &[u8] = b"\\*File list end";
/// The list that describes the numbers of one signal.
const SIGNAL: &str = "Ciao force image list";
/// The list that describes the ramp.
const RAMP: &str = "Ciao force list";
/// How far the hard scale may be from full scale by the bits of a number.
const AGREES: f64 = 0.01;

/// Reads the force curves of a file of NanoScope, or the one of that name.
///
/// # Errors
/// See [`Error`]; also for captures of PeakForce, whose motion is no ramp, and for curves without a calibration.
pub fn nanoscope(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    let bytes = whole(path, NANOSCOPE)?;
    guarded(NANOSCOPE, || {
        let header = Header::parse(&bytes)?;
        let ramp = header.ramp()?;
        let numbers = header.numbers(&bytes, &ramp)?;
        let several = numbers.len() > 1;
        let mut budget = Budget::new(NANOSCOPE);
        let mut contents = Contents::default();
        for (index, numbers) in numbers.into_iter().enumerate() {
            let name = if several { format!("curve {index}") } else { "curve".into() };
            contents.names.push(name.clone());
            if wanted.is_none_or(|wanted| wanted == name) {
                budget.take(8 * ramp.points, &name)?;
                contents.parts.push(ramp.curve(numbers).into_part(name, ramp.spring_n_per_m));
            }
        }
        Ok(contents)
    })
}

/// A list of the header: its name, and keys with their values.
type List<'a> = (&'a str, Vec<(&'a str, &'a str)>);

struct Header<'a> {
    lists: Vec<List<'a>>,
}

/// How the curves of a file were recorded.
struct Ramp {
    /// Numbers of the way in, and of the way back.
    points: usize,
    /// Bytes of a number.
    size: usize,
    /// Piezo from sample to sample, m.
    step_m: f64,
    forward_step_s: f64,
    reverse_step_s: f64,
    force_per_count_n: f64,
    spring_n_per_m: f64,
}

impl<'a> Header<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, Error> {
        let end = bytes.windows(END_OF_HEADER.len()).position(|window| window == END_OF_HEADER);
        let end = end.ok_or_else(|| {
            Error::damaged(NANOSCOPE, "header", "its end `\\*File list end` is missing")
        })?;
        // Letters beyond ASCII stand in remarks alone: the header goes on behind them.
        let lines = bytes[..end]
            .split(|byte| *byte == b'\n')
            .filter_map(|line| std::str::from_utf8(line).ok());
        let mut lists: Vec<List> = Vec::new();
        for line in lines {
            let Some(line) = line.trim_end().strip_prefix('\\') else { continue };
            if let Some(name) = line.strip_prefix('*') {
                lists.push((name, Vec::new()));
            } else if let (Some((_, pairs)), Some(pair)) = (lists.last_mut(), pair(line)) {
                pairs.push(pair);
            }
        }
        Ok(Self { lists })
    }

    /// The list of the deflection.
    fn signal(&self) -> Result<&List<'a>, Error> {
        let is_deflection = |list: &&List| {
            list.0 == SIGNAL
                && value(list, "Image Data").is_some_and(|name| name.contains("Deflection"))
        };
        self.lists.iter().find(is_deflection).ok_or_else(|| {
            Error::unread(NANOSCOPE, "file", "no force curve in it; images are not read")
        })
    }

    /// A value of any list.
    fn anywhere(&self, key: &str) -> Option<&'a str> {
        self.lists.iter().find_map(|list| value(list, key))
    }

    fn ramp(&self) -> Result<Ramp, Error> {
        let signal = self.signal()?;
        if self.anywhere("PeakForce Capture") == Some("Allow") {
            let what = "a capture of PeakForce, whose motion is no ramp: export its curves as text";
            return Err(refused(what));
        }
        let points = points(signal)?;
        let size = match value(signal, "Bytes/pixel").map_or(Some(2), |size| size.parse().ok()) {
            Some(size @ (2 | 4)) => size,
            _ => return Err(refused("numbers that are not of 2 or 4 bytes")),
        };
        let spring_n_per_m = value(signal, "Spring Constant").and_then(positive);
        let spring_n_per_m = spring_n_per_m.ok_or_else(|| refused("no spring constant"))?;
        let force = self.scaled(signal, "Z scale")?;
        let count = force.volts / 2.0_f64.powi(8 * size as i32);
        if (count / force.volts_per_count - 1.0).abs() > AGREES {
            let what = "a hard scale that is not that of its numbers: export the curve as text";
            return Err(refused(what));
        }
        let way = self.scaled(signal, "Ramp size")?;
        Ok(Ramp {
            points,
            size,
            step_m: way.volts * way.nm_per_volt * 1e-9 / points as f64,
            forward_step_s: self.lasts_s("Forward vel.", way.volts)? / points as f64,
            reverse_step_s: self.lasts_s("Reverse vel.", way.volts)? / points as f64,
            force_per_count_n: force.volts_per_count * force.nm_per_volt * 1e-9 * spring_n_per_m,
            spring_n_per_m,
        })
    }

    /// How long a way of so many volts takes: by its velocity, V/s, or as half a cycle of the scan rate, Hz.
    fn lasts_s(&self, velocity: &str, volts: f64) -> Result<f64, Error> {
        let list = self.lists.iter().find(|list| list.0 == RAMP);
        let velocity = list.and_then(|list| value(list, velocity)).and_then(positive);
        let rate = || self.anywhere("Scan rate").and_then(positive);
        let by_velocity = velocity.map(|velocity| volts / velocity);
        by_velocity.or_else(|| rate().map(|rate| 0.5 / rate)).ok_or_else(|| refused("no scan rate"))
    }

    /// A value such as `V [Sens. DeflSens] (0.000375 V/LSB) 24.576 V`.
    fn scaled(&self, list: &List, key: &str) -> Result<Scaled, Error> {
        let text = value(list, key).unwrap_or_default();
        let found = || {
            let soft = text.split_once('[')?.1.split_once(']')?.0;
            let hard = text.split_once('(')?.1.split_once(')')?;
            let nm_per_volt = self.anywhere(soft)?.strip_prefix("V ")?.strip_suffix("nm/V")?;
            Some(Scaled {
                nm_per_volt: positive(nm_per_volt)?,
                volts_per_count: positive(hard.0.strip_suffix("V/LSB")?)?,
                volts: positive(hard.1.trim().strip_suffix('V')?)?,
            })
        };
        found().ok_or_else(|| {
            refused(format!(
                "`{key}` is `{text}`, without a calibration in nm/V: calibrate the curve and save it anew"
            ))
        })
    }

    /// The numbers of each curve.
    fn numbers<'b>(&self, bytes: &'b [u8], ramp: &Ramp) -> Result<Vec<&'b [u8]>, Error> {
        let signal = self.signal()?;
        let place = format!("list `{SIGNAL}`");
        let number = |key: &str| -> Result<usize, Error> {
            let found = value(signal, key).and_then(|text| text.parse().ok());
            found.ok_or_else(|| Error::damaged(NANOSCOPE, place.clone(), format!("no `{key}`")))
        };
        let (start, length) = (number("Data offset")?, number("Data length")?);
        let there = start.checked_add(length).and_then(|end| bytes.get(start..end));
        let there = there.ok_or_else(|| {
            let message =
                format!("{} bytes are there, {length} from byte {start} on should be", bytes.len());
            Error::damaged(NANOSCOPE, "numbers", message)
        })?;
        let curve = 2 * ramp.points * ramp.size;
        if there.is_empty() || !there.len().is_multiple_of(curve) {
            let message = format!("{length} bytes are no whole number of curves of {curve}");
            return Err(Error::damaged(NANOSCOPE, "numbers", message));
        }
        Ok(there.chunks_exact(curve).collect())
    }
}

/// Numbers of a way in, which are as many as those of a way back.
fn points(signal: &List) -> Result<usize, Error> {
    let places = value(signal, "Samps/line").unwrap_or_default();
    let places: Vec<&str> = places.split_whitespace().collect();
    if places.iter().any(|other| *other != places[0]) {
        let what = "a way in and a way back of different lengths: export the curve as text";
        return Err(refused(what));
    }
    let points = places.first().and_then(|number| number.parse().ok());
    points
        .filter(|points| (2..=crate::NUMBERS).contains(points))
        .ok_or_else(|| Error::damaged(NANOSCOPE, format!("list `{SIGNAL}`"), "no `Samps/line`"))
}

fn refused(what: impl Into<String>) -> Error {
    Error::unread(NANOSCOPE, format!("list `{SIGNAL}`"), what)
}

/// A value with its hard and its soft scale.
struct Scaled {
    nm_per_volt: f64,
    volts_per_count: f64,
    volts: f64,
}

impl Ramp {
    fn curve(&self, bytes: &[u8]) -> Curve {
        let counts = whole_numbers(bytes, self.size, false);
        let (forward, reverse) = counts.split_at(self.points);
        let turn_s = self.forward_step_s * self.points as f64;
        // What the tip did not reach before it turned is marked by the least count.
        let marked = -(1_i64 << (8 * self.size - 1));
        let sample = |at: usize, count: i64, time_s: f64| Sample {
            time_s,
            way_m: (self.points - 1 - at) as f64 * self.step_m,
            force_n: count as f64 * self.force_per_count_n,
        };
        let recorded = |counts: &'_ [i64]| -> Vec<(usize, i64)> {
            counts.iter().copied().enumerate().filter(|(_, count)| *count != marked).collect()
        };
        let mut curve = Curve::default();
        curve.extend(
            Stretch::Approach,
            recorded(forward).into_iter().rev().map(|(at, count)| {
                sample(at, count, (self.points - 1 - at) as f64 * self.forward_step_s)
            }),
        );
        curve.extend(
            Stretch::Retract,
            recorded(reverse)
                .into_iter()
                .map(|(at, count)| sample(at, count, turn_s + at as f64 * self.reverse_step_s)),
        );
        curve
    }
}

/// Key and value of a line; the mark and the number of a group before a key are left away.
fn pair(line: &str) -> Option<(&str, &str)> {
    let line = line.strip_prefix('@').map_or(line, |line| {
        line.split_once(':')
            .filter(|(group, _)| group.len() == 1 && group.as_bytes()[0].is_ascii_digit())
            .map_or(line, |(_, rest)| rest)
    });
    let (key, value) = line.split_once(':')?;
    Some((key.trim(), value.trim()))
}

fn value<'a>(list: &List<'a>, key: &str) -> Option<&'a str> {
    list.1.iter().find(|(found, _)| found.eq_ignore_ascii_case(key)).map(|(_, value)| *value)
}

/// The number that a text begins with, if it is above 0.
fn positive(text: &str) -> Option<f64> {
    text.split_whitespace()
        .next()?
        .parse()
        .ok()
        .filter(|number: &f64| *number > 0.0 && number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Content;

    const HEADER: &str = "\\*Force file list\r\n\\*Scanner list\r\n\\@Sens. Zsens: V 20 nm/V\r\n\\*Ciao scan list\r\n\
        \\@Sens. DeflSens: V 50 nm/V\r\n\\*Ciao force list\r\n\\Scan rate: 1\r\n\\Forward vel.: 10\r\n\\Reverse vel.: 5\r\n\
        \\*Ciao force image list\r\n\\Data offset: 1024\r\n\\Data length: 12\r\n\\Bytes/pixel: 2\r\n\\Samps/line: 3 3\r\n\
        \\Spring Constant: 0.1\r\n\\@4:Image Data: S [DeflectionError] \"Deflection Error\"\r\n\
        \\@4:Z scale: V [Sens. DeflSens] (0.001 V/LSB) 65.536 V\r\n\
        \\@4:Ramp size: V [Sens. Zsens] (0.0067 V/LSB) 30 V\r\n\\*File list end\r\n";

    fn written(header: &str) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.resize(1024, 0);
        // In: nearest first, the nearest not reached. Back: nearest first.
        for count in [-32_768_i16, 200, 0, 300, 100, -50] {
            bytes.extend(count.to_le_bytes());
        }
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Contents, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.000");
        std::fs::write(&path, bytes).unwrap();
        nanoscope(&path, None)
    }

    #[test]
    fn both_ways_are_put_into_the_order_of_time_and_what_was_not_reached_left_out() {
        let found = read(&written(HEADER)).unwrap();
        let Content::Columns(columns) = &found.parts[0].content else { panic!() };
        let near = |found: &[f64], expected: [f64; 5]| {
            let pairs = found.iter().zip(&expected);
            assert!(
                found.len() == 5 && pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12),
                "{found:?}"
            );
        };
        near(&columns[0].values, [0.0, 1.0, 3.0, 5.0, 7.0]);
        // 30 V are 600 nm in three steps; 0.001 V, 50 nm/V and 0.1 N/m are 5 pN for a count.
        near(&columns[1].values, [0.0, 2e-4, 4e-4, 2e-4, 0.0]);
        near(&columns[2].values, [0.0, 1e-9, 1.5e-9, 0.5e-9, -0.25e-9]);
        assert_eq!(columns[3].values, [0.0, 0.0, 2.0, 2.0, 2.0]);
    }

    #[test]
    fn what_is_no_ramp_or_not_calibrated_is_refused() {
        let refused = |from: &str, to: &str| {
            assert!(HEADER.contains(from), "{from}");
            read(&written(&HEADER.replacen(from, to, 1))).unwrap_err().to_string()
        };
        assert!(
            refused("\\Scan rate", "\\PeakForce Capture: Allow\r\n\\Scan rate")
                .contains("PeakForce")
        );
        assert!(
            refused("Sens. DeflSens: V", "Sens. Other: V")
                .contains("without a calibration in nm/V")
        );
        assert!(
            refused("\\Spring Constant: 0.1", "\\Spring Constant: 0")
                .contains("no spring constant")
        );
        assert!(refused("0.001 V/LSB", "0.002 V/LSB").contains("a hard scale"));
        assert!(refused("Samps/line: 3 3", "Samps/line: 3 2").contains("different lengths"));
        assert!(
            refused("DeflectionError] \"Deflection Error\"", "Height] \"Height\"")
                .contains("images are not read")
        );
    }

    #[test]
    fn every_cut_is_refused() {
        let whole = written(HEADER);
        for end in 0..whole.len() {
            let error = read(&whole[..end]).unwrap_err().to_string();
            assert!(error.starts_with("NanoScope file, "), "{end}: {error}");
        }
    }
}
