//! Nanosurf `.nid`: a header of sections, `#!`, then for each channel its rows of whole numbers, a row a curve.
//!
//! The rows of the way back run along the same axis as those of the way in: their last number was recorded first.

use std::collections::HashMap;
use std::path::Path;

use super::{Curve, Sample, Stretch, whole, whole_numbers};
use crate::error::guarded;
use crate::limits::Budget;
use crate::{Contents, Error};

const NID: &str = "Nanosurf file";
/// What divides the header from the numbers.
const END_OF_HEADER: &[u8] = b"\n#!";
/// Names of the channel of height, the best first.
const HEIGHTS: [&str; 3] = ["Z-Axis Sensor", "Z-AxisSensor", "Z-Axis"];
/// The channel of force.
const DEFLECTION: &str = "Deflection";
/// The stretches in the order of time: what they are, their rows, and the beginning of their settings' names.
const FRAMES: [(Stretch, &str, &str); 3] = [
    (Stretch::Approach, "Spec forward", "FwMod"),
    (Stretch::Pause, "Spec fwd pause", "FwPause"),
    (Stretch::Retract, "Spec backward", "BwMod"),
];

/// Reads the force curves of a file of Nanosurf, or the one of that name.
///
/// # Errors
/// See [`Error`]; also where there are only images, or the deflection is not calibrated.
pub fn nid(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    let bytes = whole(path, NID)?;
    guarded(NID, || {
        let file = Nid::parse(&bytes)?;
        let mut contents = Contents::default();
        let mut budget = Budget::new(NID);
        for row in 0..file.rows()? {
            let name = format!("curve {row}");
            contents.names.push(name.clone());
            if wanted.is_none_or(|wanted| wanted == name) {
                let curve = file.curve(row)?;
                budget.take(4 * curve.samples.len(), &name)?;
                contents.parts.push(curve.into_part(name, file.spring()?));
            }
        }
        Ok(contents)
    })
}

/// Keys and values of a section.
type Section = HashMap<String, String>;

/// A channel of a frame.
struct Channel {
    /// The section of the header that describes it.
    name: String,
    frame: String,
    signal: String,
    unit: String,
    points: usize,
    rows: usize,
    /// Bytes of a number.
    size: usize,
    least: f64,
    range: f64,
    /// Where its numbers begin.
    at: usize,
}

struct Nid<'a> {
    bytes: &'a [u8],
    sections: HashMap<String, Section>,
    channels: Vec<Channel>,
}

impl<'a> Nid<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, Error> {
        let end = bytes.windows(END_OF_HEADER.len()).position(|window| window == END_OF_HEADER);
        let end = end.ok_or_else(|| Error::damaged(NID, "header", "its end `#!` is missing"))?;
        let sections = sections(&String::from_utf8_lossy(&bytes[..end]));
        let mut file = Self { bytes, sections, channels: Vec::new() };
        let mut at = end + END_OF_HEADER.len();
        for name in file.listed()? {
            let channel = file.channel(name, at)?;
            let length = channel
                .points
                .checked_mul(channel.rows)
                .and_then(|count| count.checked_mul(channel.size));
            at = length.and_then(|length| at.checked_add(length)).unwrap_or(usize::MAX);
            file.channels.push(channel);
        }
        if at != bytes.len() {
            let message = format!("{} of {at} bytes are there", bytes.len());
            return Err(Error::damaged(NID, "numbers", message));
        }
        Ok(file)
    }

    fn find(&self, section: &str, key: &str) -> Result<&str, Error> {
        let value = self.sections.get(section).and_then(|section| section.get(key));
        value.map(String::as_str).ok_or_else(|| {
            Error::damaged(NID, format!("section `{section}`"), format!("there is no `{key}`"))
        })
    }

    fn number<T: std::str::FromStr>(&self, section: &str, key: &str) -> Result<T, Error> {
        let text = self.find(section, key)?;
        text.parse().map_err(|_| {
            Error::damaged(NID, format!("section `{section}`"), format!("`{key}` is `{text}`"))
        })
    }

    /// A value such as `D[2.72]*[N/m]`, in that unit.
    fn measured(&self, section: &str, key: &str, unit: &str) -> Option<f64> {
        let text = self.find(section, key).ok()?;
        let (value, rest) = text.split_once('[')?.1.split_once(']')?;
        let found = rest.strip_prefix("*[")?.strip_suffix(']')?;
        let value: f64 = value.parse().ok()?;
        (found == unit && value > 0.0 && value.is_finite()).then_some(value)
    }

    /// The sections of all channels, in the order of their numbers.
    fn listed(&self) -> Result<Vec<String>, Error> {
        let top = "DataSet";
        let mut found = Vec::new();
        for group in 0..self.number::<u16>(top, "GroupCount")? {
            for channel in 0..self.number::<u16>(top, &format!("Gr{group}-Count"))? {
                found
                    .extend(self.find(top, &format!("Gr{group}-Ch{channel}")).ok().map(Into::into));
            }
        }
        Ok(found)
    }

    fn channel(&self, name: String, at: usize) -> Result<Channel, Error> {
        let text = |key: &str| self.find(&name, key).map(str::to_owned);
        let bits: usize = self.number(&name, "SaveBits")?;
        if !matches!(bits, 16 | 32)
            || text("SaveSign")? != "Signed"
            || text("SaveOrder")? != "Intel"
        {
            let what = "numbers that are not of 16 or 32 bits with a sign, the least byte first";
            return Err(Error::unread(NID, format!("section `{name}`"), what));
        }
        let channel = Channel {
            frame: text("Frame")?,
            signal: text("Dim2Name")?,
            unit: text("Dim2Unit")?,
            points: self.number(&name, "Points")?,
            rows: self.number(&name, "Lines")?,
            size: bits / 8,
            least: self.number(&name, "Dim2Min")?,
            range: self.number(&name, "Dim2Range")?,
            at,
            name,
        };
        Ok(channel)
    }

    fn signal(&self, frame: &str, names: &[&str]) -> Option<&Channel> {
        let named = |name: &&str| {
            self.channels.iter().find(|channel| channel.frame == frame && channel.signal == **name)
        };
        names.iter().find_map(named)
    }

    /// Curves that were recorded.
    fn rows(&self) -> Result<usize, Error> {
        let forward = self.signal(FRAMES[0].1, &[DEFLECTION]).ok_or_else(|| {
            Error::unread(NID, "file", "no force curve in it; images are not read")
        })?;
        let last: usize = self.number(&forward.name, "CurLine").unwrap_or(usize::MAX - 1);
        Ok(forward.rows.min(last + 1))
    }

    /// Spring constant of the cantilever, N/m.
    fn spring(&self) -> Result<f64, Error> {
        let section = "DataSet\\Calibration\\Cantilever";
        self.measured(section, "Prop0", "N/m").ok_or_else(|| {
            Error::unread(NID, format!("section `{section}`"), "no spring constant in N/m")
        })
    }

    /// The numbers of a row in their unit, as many as were recorded.
    fn row(&self, channel: &Channel, row: usize) -> Result<Vec<f64>, Error> {
        if row >= channel.rows {
            let message = format!("there is no row {row}");
            return Err(Error::damaged(NID, format!("section `{}`", channel.name), message));
        }
        let length = channel.points * channel.size;
        let start = channel.at + row * length;
        let counts = whole_numbers(&self.bytes[start..start + length], channel.size, false);
        let full = 2.0_f64.powi(8 * channel.size as i32);
        let value = |count: i64| (count as f64 / full + 0.5) * channel.range + channel.least;
        let recorded = self.number(&channel.name, &format!("LineDim{row}Points"));
        let recorded = recorded.unwrap_or(channel.points).min(channel.points);
        Ok(counts[..recorded].iter().map(|&count| value(count)).collect())
    }

    fn curve(&self, row: usize) -> Result<Curve, Error> {
        let mut curve = Curve::default();
        let mut begin_s = 0.0;
        for (stretch, frame, settings) in FRAMES {
            let Some(deflection) = self.signal(frame, &[DEFLECTION]) else { continue };
            let height = self.signal(frame, &HEIGHTS).filter(|height| height.unit == "m");
            let height = height.ok_or_else(|| {
                Error::unread(NID, format!("`{frame}`"), "no channel `Z-Axis` in metres")
            })?;
            let force_per_unit = match deflection.unit.as_str() {
                "N" => 1.0,
                "m" => self.spring()?,
                other => {
                    let what = format!(
                        "the deflection is in {other}: calibrate the curve and save it anew"
                    );
                    return Err(Error::unread(NID, format!("`{frame}`"), what));
                }
            };
            let (mut way, mut force) = (self.row(height, row)?, self.row(deflection, row)?);
            if way.len() != force.len() {
                let message = format!("{} heights, {} forces", way.len(), force.len());
                return Err(Error::damaged(NID, format!("`{frame}`, row {row}"), message));
            }
            if stretch == Stretch::Retract {
                way.reverse();
                force.reverse();
            }
            let step_s = self.step_s(settings, deflection)?;
            let sample = |(index, (way_m, force)): (usize, (&f64, &f64))| Sample {
                time_s: begin_s + index as f64 * step_s,
                way_m: *way_m,
                force_n: force * force_per_unit,
            };
            curve.extend(stretch, way.iter().zip(&force).enumerate().map(sample));
            begin_s += step_s * force.len() as f64;
        }
        Ok(curve)
    }

    /// Seconds from a sample to the next: the time of the whole stretch by its points.
    fn step_s(&self, settings: &str, channel: &Channel) -> Result<f64, Error> {
        let section = "DataSet\\Parameters\\Spectroscopy";
        let time_s = self.measured(section, &format!("{settings}Time"), "s").ok_or_else(|| {
            let what = format!("no `{settings}Time` in seconds");
            Error::unread(NID, format!("section `{section}`"), what)
        })?;
        Ok(time_s / channel.points as f64)
    }
}

fn sections(header: &str) -> HashMap<String, Section> {
    let mut found = HashMap::<String, Section>::new();
    let mut name = String::new();
    for line in header.lines() {
        if let Some(next) =
            line.trim_end().strip_prefix('[').and_then(|line| line.strip_suffix(']'))
        {
            name = next.to_owned();
        } else if let Some((key, value)) = line.split_once('=') {
            let section = found.entry(name.clone()).or_default();
            section.insert(key.trim().to_owned(), value.trim().to_owned());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Content;

    /// A curve of two numbers on the way in and two on the way back.
    fn written(unit: &str) -> Vec<u8> {
        let mut text = String::from("[DataSet]\r\nGroupCount=2\r\nGr0-Count=2\r\nGr1-Count=2\r\n");
        for (group, channel) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            text += &format!("Gr{group}-Ch{channel}=DataSet-{group}:{channel}\r\n");
        }
        text += "[DataSet\\Calibration\\Cantilever]\r\nProp0=D[0.5]*[N/m]\r\n";
        text +=
            "[DataSet\\Parameters\\Spectroscopy]\r\nFwModTime=D[2]*[s]\r\nBwModTime=D[1]*[s]\r\n";
        for (group, frame) in [(0, "Spec forward"), (1, "Spec backward")] {
            for (channel, signal, unit) in [(0, "Deflection", unit), (1, "Z-Axis", "m")] {
                text += &format!(
                    "[DataSet-{group}:{channel}]\r\nFrame={frame}\r\nPoints=2\r\nLines=1\r\nCurLine=0\r\nDim2Name={signal}\r\n\
                     Dim2Unit={unit}\r\nDim2Min=-1\r\nDim2Range=2\r\nSaveBits=16\r\nSaveSign=Signed\r\nSaveOrder=Intel\r\n"
                );
            }
        }
        let mut bytes = (text + "\r\n\r\n#!").into_bytes();
        // Counts of a quarter and three quarters of full scale, each channel after the other.
        for count in [0_i16, 16_384, 8_192, 16_384, 0, 16_384, 8_192, 16_384] {
            bytes.extend(count.to_le_bytes());
        }
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Contents, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.nid");
        std::fs::write(&path, bytes).unwrap();
        nid(&path, None)
    }

    #[test]
    fn a_row_is_a_curve_and_its_way_back_is_turned_round() {
        for (unit, factor) in [("N", 1.0), ("m", 0.5)] {
            let found = read(&written(unit)).unwrap();
            let Content::Columns(columns) = &found.parts[0].content else { panic!() };
            assert_eq!(columns[0].values, [0.0, 1.0, 2.0, 2.5]);
            assert_eq!(columns[1].values, [250.0, 500.0, 500.0, 250.0]);
            assert_eq!(columns[2].values, [0.0, 0.5 * factor, 0.5 * factor, 0.0]);
            assert_eq!(found.parts[0].setup, [("spring_constant_N_per_m", 0.5)]);
        }
    }

    #[test]
    fn volts_images_and_every_cut_are_refused() {
        assert!(read(&written("V")).unwrap_err().to_string().contains("the deflection is in V"));
        let image = String::from_utf8_lossy(&written("N")).replace("Spec ", "Scan ");
        assert!(read(image.as_bytes()).unwrap_err().to_string().contains("images are not read"));
        let whole = written("N");
        for end in 0..whole.len() {
            let error = read(&whole[..end]).unwrap_err().to_string();
            assert!(error.starts_with("Nanosurf file, "), "{end}: {error}");
        }
    }
}
