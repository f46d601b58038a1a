//! JPK: `.jpk-force`, and maps of curves (`.jpk-force-map`, `.jpk-qi-data`).
//!
//! A ZIP archive: for each segment of a curve a list of properties and, for each channel, a file of whole numbers, the most
//! significant byte first. A chain of linear conversions leads from the counts over volts and deflection to force; in newer files
//! it stands once for all segments, in `shared-data/`.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::AssertUnwindSafe;
use std::path::Path;

use zip::ZipArchive;

use super::{Curve, Sample, Stretch, whole_numbers};
use crate::error::guarded;
use crate::limits::Budget;
use crate::{Contents, Error};

const JPK: &str = "JPK force curve";
/// Most bytes of a list of properties.
const PROPERTIES_LIMIT: u64 = 16 << 20;
/// Most conversions in a chain.
const CHAIN: usize = 8;
/// Channels of height, the best first: measured ones before the one that was commanded. All fall towards the specimen.
const HEIGHTS: [&str; 4] =
    ["capacitiveSensorHeight", "strainGaugeHeight", "measuredHeight", "height"];

/// Reads the curves of a file of JPK, or the one of that name.
///
/// # Errors
/// See [`Error`]; also where a curve is not calibrated to force.
pub fn jpk(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    let file = BufReader::new(File::open(path)?);
    guarded(
        JPK,
        AssertUnwindSafe(|| {
            let archive =
                ZipArchive::new(file).map_err(|error| Error::damaged(JPK, "archive", error))?;
            Archive::new(archive)?.contents(wanted)
        }),
    )
}

/// Keys and their values.
type Properties = HashMap<String, String>;

struct Archive {
    files: ZipArchive<BufReader<File>>,
    /// What all segments share.
    shared: Properties,
    budget: Budget,
}

impl Archive {
    fn new(mut files: ZipArchive<BufReader<File>>) -> Result<Self, Error> {
        let shared = "shared-data/header.properties";
        let shared = match files.index_for_name(shared) {
            Some(_) => properties(&mut files, shared)?,
            None => Properties::new(),
        };
        Ok(Self { files, shared, budget: Budget::new(JPK) })
    }

    fn contents(mut self, wanted: Option<&str>) -> Result<Contents, Error> {
        let mut contents = Contents::default();
        for (folder, name) in self.curves() {
            contents.names.push(name.clone());
            if wanted.is_none_or(|wanted| wanted == name) {
                let (curve, spring) = self.curve(&folder)?;
                contents.parts.push(curve.into_part(name, spring));
            }
        }
        Ok(contents)
    }

    /// Folder and name of each curve.
    fn curves(&self) -> Vec<(String, String)> {
        let indexed = self.numbers("index/");
        if indexed.is_empty() {
            return vec![(String::new(), "curve".into())];
        }
        let curve = |number| (format!("index/{number}/"), format!("curve {number}"));
        indexed.into_iter().map(curve).collect()
    }

    /// The numbers that folders in a folder have as names.
    fn numbers(&self, folder: &str) -> BTreeSet<u32> {
        let number = |name: &str| name.strip_prefix(folder)?.split('/').next()?.parse().ok();
        self.files.file_names().filter_map(|name| number(&name.ok()?)).collect()
    }

    /// A curve, with the spring constant of its cantilever.
    fn curve(&mut self, folder: &str) -> Result<(Curve, f64), Error> {
        let mut segments = Vec::new();
        for number in self.numbers(&format!("{folder}segments/")) {
            let place = format!("{folder}segments/{number}/");
            let own = properties(&mut self.files, &format!("{place}segment-header.properties"))?;
            segments.push(Segment { place, own });
        }
        let Some(first) = segments.first() else {
            return Err(Error::damaged(JPK, format!("`{folder}segments/`"), "there is no segment"));
        };
        let everywhere = |name: &&str| segments.iter().all(|segment| segment.has(name));
        let height = HEIGHTS.into_iter().find(everywhere).ok_or_else(|| {
            Error::unread(JPK, &first.place, "no channel of height in all segments")
        })?;
        let spring = first.number(
            &self.shared,
            "vDeflection",
            "conversion-set.conversion.force.scaling.multiplier",
        );
        let mut curve = Curve::default();
        let mut begin_s = 0.0;
        for segment in &segments {
            let heights = self.channel(segment, height, "m")?;
            let forces = self.channel(segment, "vDeflection", "N")?;
            if heights.len() != forces.len() || forces.is_empty() {
                let message = format!("{} heights, {} forces", heights.len(), forces.len());
                return Err(Error::damaged(JPK, &segment.place, message));
            }
            let duration_s = segment.duration_s(&self.shared)?;
            let step_s = duration_s / forces.len() as f64;
            let sample = |(index, (height, force)): (usize, (&f64, &f64))| Sample {
                // In the middle of its step, as JPK's text export has it.
                time_s: begin_s + (index as f64 + 0.5) * step_s,
                way_m: -height,
                force_n: *force,
            };
            let samples = heights.iter().zip(&forces).enumerate().map(sample);
            curve.extend(segment.stretch(&self.shared)?, samples);
            begin_s += duration_s;
        }
        Ok((curve, spring?))
    }

    /// A channel in its unit.
    fn channel(&mut self, segment: &Segment, name: &str, unit: &str) -> Result<Vec<f64>, Error> {
        let chain = segment.conversions(&self.shared, name, unit)?;
        let kind = segment.text(&self.shared, name, "encoder.type")?;
        let (size, signed) = match kind.as_str() {
            "signedshort" => (2, true),
            "unsignedshort" => (2, false),
            "signedinteger" => (4, true),
            "unsignedinteger" => (4, false),
            "signedlong" => (8, true),
            other => {
                let what = format!("channel `{name}` is stored as `{other}`");
                return Err(Error::unread(JPK, &segment.place, what));
            }
        };
        let count = segment.number(&self.shared, name, "data.num-points").ok();
        let path = segment.text(&self.shared, name, "data.file.name")?;
        let path = format!("{}{path}", segment.place);
        let most = crate::NUMBERS as u64 * size as u64;
        let bytes = unpacked(&mut self.files, &path, most)?;
        let there = bytes.len() / size;
        if bytes.len() % size > 0 || count.is_some_and(|count| count != there as f64) {
            let message = format!("{there} numbers where {} should be", count.unwrap_or_default());
            return Err(Error::damaged(JPK, path, message));
        }
        self.budget.take(there, &path)?;
        let wrapped = (1_i64 << (8 * size - 1)) as f64 * 2.0;
        let value = |count: i64| {
            let count = count as f64;
            let count = if !signed && count < 0.0 { count + wrapped } else { count };
            chain.iter().fold(count, |value, (multiplier, offset)| value * multiplier + offset)
        };
        Ok(whole_numbers(&bytes, size, true).into_iter().map(value).collect())
    }
}

/// A segment of a curve.
struct Segment {
    /// Its folder.
    place: String,
    own: Properties,
}

impl Segment {
    fn has(&self, channel: &str) -> bool {
        self.own.get("channels.list").is_some_and(|all| all.split(' ').any(|one| one == channel))
    }

    /// A property of a channel: of the segment itself, or where it points to in what all share.
    fn find<'a>(&'a self, shared: &'a Properties, channel: &str, key: &str) -> Option<&'a str> {
        let own = || {
            let key = |inner: &str| format!("channel.{channel}.{inner}{key}");
            self.own.get(&key("")).or_else(|| self.own.get(&key("data.")))
        };
        let pointed = || {
            let number = self.own.get(&format!("channel.{channel}.lcd-info.*"))?;
            shared.get(&format!("lcd-info.{number}.{key}"))
        };
        own().or_else(pointed).map(String::as_str)
    }

    fn text(&self, shared: &Properties, channel: &str, key: &str) -> Result<String, Error> {
        let missing = || {
            Error::unread(JPK, &self.place, format!("channel `{channel}` has no property `{key}`"))
        };
        self.find(shared, channel, key).map(Into::into).ok_or_else(missing)
    }

    fn number(&self, shared: &Properties, channel: &str, key: &str) -> Result<f64, Error> {
        let text = self.text(shared, channel, key)?;
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| {
            Error::damaged(JPK, &self.place, format!("`{key}` of `{channel}` is `{text}`"))
        })
    }

    /// A property of the segment as a whole.
    fn header<'a>(&'a self, shared: &'a Properties, key: &str) -> Option<&'a str> {
        let own = self.own.get(&format!("force-segment-header.{key}"));
        let pointed = || {
            let number = self.own.get("force-segment-header.force-segment-header-info.*")?;
            shared.get(&format!("force-segment-header-info.{number}.{key}"))
        };
        own.or_else(pointed).map(String::as_str)
    }

    fn duration_s(&self, shared: &Properties) -> Result<f64, Error> {
        let duration = self.header(shared, "duration").and_then(|text| text.parse().ok());
        duration.filter(|duration: &f64| *duration > 0.0 && duration.is_finite()).ok_or_else(|| {
            Error::damaged(JPK, &self.place, "the segment does not say how long it lasts")
        })
    }

    fn stretch(&self, shared: &Properties) -> Result<Stretch, Error> {
        let keys = ["settings.style", "settings.segment-settings.style"];
        match keys.iter().find_map(|key| self.header(shared, key)) {
            Some("extend") => Ok(Stretch::Approach),
            Some("pause") => Ok(Stretch::Pause),
            Some("retract") => Ok(Stretch::Retract),
            other => {
                let what = format!(
                    "a segment `{}`; only extend, pause and retract are read",
                    other.unwrap_or("of no kind")
                );
                Err(Error::unread(JPK, &self.place, what))
            }
        }
    }

    /// Factor and offset of each step from the counts of a channel to a unit.
    fn conversions(
        &self,
        shared: &Properties,
        channel: &str,
        unit: &str,
    ) -> Result<Vec<(f64, f64)>, Error> {
        let set = |key: &str| format!("conversion-set.{key}");
        let linear = |key: &str| -> Result<(f64, f64), Error> {
            let part = |part| self.number(shared, channel, &format!("{key}.scaling.{part}"));
            Ok((part("multiplier")?, part("offset")?))
        };
        let base = self.text(shared, channel, &set("conversions.base"))?;
        let mut slot = match unit {
            "N" => "force".to_owned(),
            _ => self.text(shared, channel, &set("conversions.default"))?,
        };
        let of = |slot: &str, key: &str| {
            self.find(shared, channel, &set(&format!("conversion.{slot}.{key}")))
        };
        if slot != base && of(&slot, "defined") != Some("true") {
            let what = format!(
                "channel `{channel}` is not calibrated to `{slot}`: calibrate the curve with JPK's data processing, save it and read it again"
            );
            return Err(Error::unread(JPK, &self.place, what));
        }
        let found = match slot == base {
            true => self.find(shared, channel, "encoder.scaling.unit.unit"),
            false => of(&slot, "scaling.unit.unit").or_else(|| of(&slot, "scaling.unit")),
        };
        if found != Some(unit) {
            let what = format!("channel `{channel}` is in {}, not in {unit}", found.unwrap_or("?"));
            return Err(Error::unread(JPK, &self.place, what));
        }
        let mut chain = Vec::new();
        while slot != base {
            if chain.len() == CHAIN {
                let message = format!("the conversions of `{channel}` do not lead to `{base}`");
                return Err(Error::damaged(JPK, &self.place, message));
            }
            chain.push(linear(&set(&format!("conversion.{slot}")))?);
            let next = set(&format!("conversion.{slot}.base-calibration-slot"));
            slot = self.text(shared, channel, &next)?;
        }
        chain.push(linear("encoder")?);
        chain.reverse();
        Ok(chain)
    }
}

/// A list of properties, in the notation of Java. Marks behind a stroke are left as they are: none is in what is asked for.
fn properties(files: &mut ZipArchive<BufReader<File>>, path: &str) -> Result<Properties, Error> {
    let bytes = unpacked(files, path, PROPERTIES_LIMIT)?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.lines().filter(|line| !line.starts_with(['#', '!']));
    let pair = |line: &str| {
        let (key, value) = line.split_once('=')?;
        Some((key.trim().to_owned(), value.trim().to_owned()))
    };
    Ok(lines.filter_map(pair).collect())
}

/// A file of the archive; its checksum was right.
fn unpacked(
    files: &mut ZipArchive<BufReader<File>>,
    path: &str,
    most: u64,
) -> Result<Vec<u8>, Error> {
    let damaged = |error: &dyn ToString| Error::damaged(JPK, path, error.to_string());
    let file = files.by_name(path).map_err(|error| damaged(&error))?;
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
    if bytes.len() as u64 > most {
        return Err(Error::TooLarge {
            format: JPK,
            place: path.into(),
            limit: format!("{most} bytes"),
        });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use zip::write::{SimpleFileOptions, ZipWriter};

    use super::*;
    use crate::Content;

    /// A channel of two counts, 1 and 3, with all its properties in the segment, as older files have it.
    fn channel(name: &str, unit: &str, slot: &str) -> String {
        let key = format!("channel.{name}");
        let set = format!("{key}.conversion-set");
        let conversion = format!("{set}.conversion.{slot}");
        format!(
            "{key}.data.file.name=channels/{name}.dat\n{key}.data.num-points=2\n{key}.data.encoder.type=signedshort\n\
             {key}.data.encoder.scaling.offset=0.5\n{key}.data.encoder.scaling.multiplier=2\n\
             {set}.conversions.base=volts\n{set}.conversions.default={slot}\n{conversion}.defined=true\n\
             {conversion}.base-calibration-slot=volts\n{conversion}.scaling.offset=0\n\
             {conversion}.scaling.multiplier=10\n{conversion}.scaling.unit.unit={unit}\n"
        )
    }

    /// A curve of segments of these styles.
    fn written(styles: &[&str], change: impl Fn(String) -> String) -> Vec<u8> {
        let mut writer = ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let mut put = |name: String, bytes: &[u8]| {
            writer.start_file(name, SimpleFileOptions::default()).unwrap();
            writer.write_all(bytes).unwrap();
        };
        put("header.properties".into(), b"file-format-version=0.10\n");
        for (number, style) in styles.iter().enumerate() {
            let header = format!(
                "#Wed\nforce-segment-header.settings.style={style}\nforce-segment-header.duration=0.5\n\
                 channels.list=height vDeflection\n{}{}",
                channel("height", "m", "nominal"),
                channel("vDeflection", "N", "force"),
            );
            let at = format!("segments/{number}");
            put(format!("{at}/segment-header.properties"), change(header).as_bytes());
            for name in ["height", "vDeflection"] {
                put(format!("{at}/channels/{name}.dat"), &[0, 1, 0, 3]);
            }
        }
        writer.finish().unwrap().into_inner()
    }

    fn read(bytes: &[u8]) -> Result<Contents, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.jpk-force");
        std::fs::write(&path, bytes).unwrap();
        jpk(&path, None)
    }

    #[test]
    fn counts_become_force_and_way_through_the_chain_of_conversions() {
        let whole = read(&written(&["extend", "pause", "retract"], |header| header)).unwrap();
        let Content::Columns(columns) = &whole.parts[0].content else { panic!() };
        let values: Vec<&[f64]> = columns.iter().map(|column| &column.values[..]).collect();
        assert_eq!(values[0], [0.125, 0.375, 0.625, 0.875, 1.125, 1.375]);
        assert_eq!(values[1][..2], [-25e3, -65e3]);
        assert_eq!(values[2][..2], [25.0, 65.0]);
        assert_eq!(values[3], [0.0, 0.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!(whole.parts[0].setup, [("spring_constant_N_per_m", 10.0)]);
    }

    #[test]
    fn what_is_not_calibrated_to_force_is_refused() {
        let refused = |from: &str, to: &str| {
            let bytes = written(&["extend"], |header| header.replacen(from, to, 1));
            read(&bytes).unwrap_err().to_string()
        };
        let uncalibrated =
            refused("conversion.force.defined=true", "conversion.force.defined=false");
        assert!(
            uncalibrated.contains("`vDeflection` is not calibrated to `force`"),
            "{uncalibrated}"
        );
        assert!(refused("scaling.unit.unit=m", "scaling.unit.unit=V").contains("in V, not in m"));
        assert!(refused("style=extend", "style=modulation").contains("a segment `modulation`"));
        assert!(refused("num-points=2", "num-points=3").contains("2 numbers where 3 should be"));
        assert!(
            refused("base-calibration-slot=volts", "base-calibration-slot=nominal")
                .contains("do not lead to")
        );
    }

    #[test]
    fn a_cut_anywhere_is_refused() {
        let whole = written(&["extend", "retract"], |header| header);
        for end in (0..whole.len()).step_by(23) {
            let error = read(&whole[..end]).unwrap_err().to_string();
            assert!(error.starts_with("JPK force curve, "), "{end}: {error}");
        }
    }
}
