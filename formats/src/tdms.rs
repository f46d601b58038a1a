//! TDMS, what LabVIEW and FlexLogger write: a part for each group and length of channels.
//!
//! A file is segments. Each has a head that says where the next begins, a list of the objects that changed since the one before,
//! and numbers: those of one channel after those of another, as many rounds as fit. A channel of a waveform has no times but a
//! step between them; it becomes the column `time`.

mod bytes;
mod scale;

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::panic::AssertUnwindSafe;
use std::path::Path;

use crate::error::guarded;
use crate::gather::{Array, gather};
use crate::limits::Budget;
use crate::{Contents, Error};
use bytes::{Bytes, Kind, Value};

const FORMAT: &str = "TDMS";
/// Bytes of a segment's head.
const HEAD: u64 = 28;
/// Most bytes of a list of objects.
const LIST: u64 = 16 << 20;
/// Bits of a head: a list of objects, a new one, numbers, row by row, the most significant byte first.
const LISTED: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const NUMBERS: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
/// Where the next segment begins while the recorder does not know it yet.
const UNKNOWN: u64 = u64::MAX;
/// Bytes that are read at a time.
const STRETCH: usize = 1 << 20;

/// Reads the tables of a TDMS file, or the one of that name. Scales that are straight lines or polynomials are applied.
///
/// # Errors
/// See [`Error`]. A last segment that its recorder did not end is no error: it is read as far as whole rounds are there.
pub fn tdms(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    guarded(
        FORMAT,
        AssertUnwindSafe(|| {
            let mut reader = Reader {
                file: BufReader::new(file),
                length,
                channels: Vec::new(),
                places: HashMap::new(),
                listed: Vec::new(),
                budget: Budget::new(FORMAT),
            };
            let mut at = 0;
            while at < length {
                at = reader.segment(at)?;
            }
            let mut arrays = Vec::new();
            for channel in reader.channels.into_iter().filter(|channel| !channel.values.is_empty())
            {
                arrays.push(channel.into_array()?);
            }
            add_times(&mut arrays);
            gather(arrays, "file", wanted, |array| Ok(vec![array.source.values.clone()]))
        }),
    )
}

/// A channel as far as it has been read.
struct Channel {
    group: String,
    name: String,
    properties: HashMap<String, Value>,
    /// How its numbers are stored in this segment and how many there are in a round.
    index: Option<Index>,
    values: Vec<f64>,
    /// The whole second from which times count.
    origin: Option<i64>,
}

#[derive(Clone, Copy)]
struct Index {
    kind: Kind,
    count: u64,
    /// Bytes of them all.
    bytes: u64,
}

/// The numbers of a channel and their clock.
struct Waveform {
    values: Vec<f64>,
    /// Time of the first sample and from one to the next, s.
    clock: Option<(f64, f64)>,
}

impl Channel {
    fn into_array(self) -> Result<Array<Waveform>, Error> {
        let place = format!("channel `{}/{}`", self.group, self.name);
        let values = scale::scaled(self.values, &self.properties)
            .map_err(|what| Error::unread(FORMAT, place, what))?;
        let number = |name: &str| self.properties.get(name).and_then(Value::number);
        let step = number("wf_increment").filter(|&step| step > 0.0 && step.is_finite());
        let clock = step.map(|step| (number("wf_start_offset").unwrap_or(0.0), step));
        let unit = self.properties.get("unit_string").and_then(Value::text);
        let unit = unit.filter(|unit| !unit.is_empty()).map(Into::into);
        let unit = if self.origin.is_some() { Some("s".into()) } else { unit };
        let (group, name, rows) = (self.group, self.name, values.len());
        Ok(Array { group, name, unit, rows, source: Waveform { values, clock } })
    }
}

/// Adds the times of waveforms: to each group and length whose channels all have one clock.
fn add_times(arrays: &mut Vec<Array<Waveform>>) {
    let mut times: Vec<Array<Waveform>> = Vec::new();
    for array in arrays.iter() {
        let same =
            |other: &&Array<Waveform>| other.group == array.group && other.rows == array.rows;
        let one_clock =
            arrays.iter().filter(same).all(|other| other.source.clock == array.source.clock);
        let Some((start, step)) = array.source.clock.filter(|_| one_clock) else { continue };
        if times.iter().any(|other| same(&other)) {
            continue;
        }
        let values = (0..array.rows).map(|row| start + row as f64 * step).collect();
        times.push(Array {
            group: array.group.clone(),
            name: "time".into(),
            unit: Some("s".into()),
            rows: array.rows,
            source: Waveform { values, clock: None },
        });
    }
    // In front, so that an even clock is met before anything else that rises.
    arrays.splice(0..0, times);
}

struct Reader {
    file: BufReader<File>,
    length: u64,
    channels: Vec<Channel>,
    places: HashMap<String, usize>,
    /// Channels with numbers in this segment, in their order.
    listed: Vec<usize>,
    budget: Budget,
}

fn damaged(at: u64, message: impl std::fmt::Display) -> Error {
    Error::damaged(FORMAT, format!("segment at byte {at}"), message)
}

impl Reader {
    /// Takes the segment that begins at a byte; returns where the next one does.
    fn segment(&mut self, at: u64) -> Result<u64, Error> {
        self.file.seek(SeekFrom::Start(at))?;
        let mut head = [0; HEAD as usize];
        self.file.read_exact(&mut head).map_err(|error| damaged(at, error))?;
        if &head[..4] != b"TDSm" {
            return Err(damaged(at, "it does not begin with `TDSm`"));
        }
        let flags = u32::from_le_bytes([head[4], head[5], head[6], head[7]]);
        let swapped = flags & BIG_ENDIAN != 0;
        let mut rest = Bytes { rest: &head[12..], swapped };
        let (next, start) = rest.u64().zip(rest.u64()).unwrap_or_default();
        let ended = next != UNKNOWN;
        let after = at + HEAD;
        let end = if ended { after.checked_add(next) } else { Some(self.length) };
        let end = end.filter(|&end| end <= self.length).ok_or_else(|| {
            damaged(at, format!("{next} bytes announced, {} left", self.length - after))
        })?;
        let start = after.checked_add(start).filter(|&start| start <= end);
        let start = start.ok_or_else(|| damaged(at, "its numbers begin after its end"))?;
        if flags & LISTED != 0 {
            let size = start - after;
            if size > LIST {
                return Err(damaged(at, format!("a list of objects of {size} bytes")));
            }
            let mut list = vec![0; size as usize];
            self.file.read_exact(&mut list).map_err(|error| damaged(at, error))?;
            if flags & NEW_LIST != 0 {
                self.listed.clear();
            }
            let cut = || damaged(at, "the list of objects ends too early");
            self.list(&mut Bytes { rest: &list, swapped })
                .ok_or_else(cut)?
                .map_err(|what| damaged(at, what))?;
        }
        if flags & NUMBERS != 0 {
            self.file.seek(SeekFrom::Start(start))?;
            self.rounds(at, end - start, flags, ended)?;
        }
        Ok(end)
    }

    /// Takes the list of objects; none if it ends too early.
    fn list(&mut self, list: &mut Bytes) -> Option<Result<(), String>> {
        for _ in 0..list.u32()? {
            let path = list.text()?;
            let at = self.object(&path);
            match list.u32()? {
                // No numbers in this segment.
                u32::MAX => {
                    if let Some(at) = at {
                        self.listed.retain(|&other| other != at);
                    }
                }
                // As in the segment before.
                0 => match at.filter(|&at| self.channels[at].index.is_some()) {
                    Some(at) if !self.listed.contains(&at) => self.listed.push(at),
                    Some(_) => {}
                    None => return Some(Err(format!("`{path}` is as before and was not before"))),
                },
                0x1269 | 0x126A => {
                    let what = "raw numbers of a card (DAQmx) are not read; export as CSV";
                    return Some(Err(format!("`{path}`: {what}")));
                }
                _ => {
                    let kind = list.u32()?;
                    let (dimension, count) = (list.u32()?, list.u64()?);
                    let Some(kind) = Kind::of(kind) else {
                        return Some(Err(format!("`{path}` holds numbers of type {kind:#x}")));
                    };
                    let bytes = match kind.size() {
                        Some(size) => count.checked_mul(size as u64)?,
                        None => list.u64()?,
                    };
                    let Some(at) = at.filter(|_| dimension == 1) else {
                        return Some(Err(format!("`{path}` is no channel of numbers in a row")));
                    };
                    self.channels[at].index = Some(Index { kind, count, bytes });
                    if !self.listed.contains(&at) {
                        self.listed.push(at);
                    }
                }
            }
            for _ in 0..list.u32()? {
                let (name, value) = (list.text()?, list.value()?);
                if let Some(at) = at {
                    self.channels[at].properties.insert(name, value);
                }
            }
        }
        Some(Ok(()))
    }

    /// The channel of a path `/'group'/'channel'`; none of the file and of groups.
    fn object(&mut self, path: &str) -> Option<usize> {
        if let Some(&at) = self.places.get(path) {
            return Some(at);
        }
        let inner = path.strip_prefix("/'")?.strip_suffix('\'')?;
        let (group, name) = inner.split_once("'/'")?;
        let plain = |text: &str| text.replace("''", "'");
        self.channels.push(Channel {
            group: plain(group),
            name: plain(name),
            properties: HashMap::new(),
            index: None,
            values: Vec::new(),
            origin: None,
        });
        self.places.insert(path.to_owned(), self.channels.len() - 1);
        Some(self.channels.len() - 1)
    }

    /// Takes `size` bytes of numbers.
    fn rounds(&mut self, at: u64, size: u64, flags: u32, ended: bool) -> Result<(), Error> {
        let indices: Vec<(usize, Index)> = self
            .listed
            .iter()
            .filter_map(|&place| Some((place, self.channels[place].index?)))
            .collect();
        let round = indices.iter().try_fold(0_u64, |sum, (_, index)| sum.checked_add(index.bytes));
        let round = round.ok_or_else(|| damaged(at, "more numbers than any file has"))?;
        if round == 0 {
            let none = size == 0;
            return if none { Ok(()) } else { Err(damaged(at, "numbers of no channel")) };
        }
        if ended && !size.is_multiple_of(round) {
            let message = format!("{size} bytes of numbers are no multiple of {round}");
            return Err(damaged(at, message));
        }
        let swapped = flags & BIG_ENDIAN != 0;
        for _ in 0..size / round {
            if flags & INTERLEAVED != 0 {
                self.rows(at, &indices, swapped)?;
                continue;
            }
            for &(place, index) in &indices {
                self.channel(at, place, index, swapped)?;
            }
        }
        Ok(())
    }

    /// Takes the numbers of one channel in one round.
    fn channel(&mut self, at: u64, place: usize, index: Index, swapped: bool) -> Result<(), Error> {
        let Some(size) = index.kind.size().filter(|_| index.kind.is_number()) else {
            let bytes = i64::try_from(index.bytes).map_err(|error| damaged(at, error))?;
            self.file.seek_relative(bytes)?;
            return Ok(());
        };
        self.count(index.count, place)?;
        let mut left = index.bytes;
        let mut raw = Vec::new();
        while left > 0 {
            let now = left.min((STRETCH / size * size) as u64);
            raw.resize(now as usize, 0);
            self.file.read_exact(&mut raw).map_err(|error| damaged(at, error))?;
            let channel = &mut self.channels[place];
            for number in raw.chunks_exact(size) {
                channel.values.push(index.kind.number(number, swapped, &mut channel.origin));
            }
            left -= now;
        }
        Ok(())
    }

    /// Takes a round whose numbers stand row by row.
    fn rows(&mut self, at: u64, indices: &[(usize, Index)], swapped: bool) -> Result<(), Error> {
        let count = indices.first().map_or(0, |(_, index)| index.count);
        let sizes: Option<Vec<usize>> =
            indices.iter().map(|(_, index)| index.kind.size()).collect();
        let sizes = sizes.filter(|_| indices.iter().all(|(_, index)| index.count == count));
        let sizes = sizes.ok_or_else(|| damaged(at, "rows of channels of different lengths"))?;
        for &(place, _) in indices {
            self.count(count, place)?;
        }
        let mut row = vec![0; sizes.iter().sum()];
        for _ in 0..count {
            self.file.read_exact(&mut row).map_err(|error| damaged(at, error))?;
            let mut rest = &row[..];
            for (&(place, index), &size) in indices.iter().zip(&sizes) {
                let (number, after) = rest.split_at(size);
                let channel = &mut self.channels[place];
                if index.kind.is_number() {
                    channel.values.push(index.kind.number(number, swapped, &mut channel.origin));
                }
                rest = after;
            }
        }
        Ok(())
    }

    fn count(&mut self, count: u64, place: usize) -> Result<(), Error> {
        let name = format!("channel `{}`", self.channels[place].name);
        self.budget.take(usize::try_from(count).unwrap_or(usize::MAX), &name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Column, Content, Part};

    fn text(text: &str) -> Vec<u8> {
        [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
    }

    /// A segment of two channels, i16 with a scale and f64; `next` is what its head says of its length.
    fn segment(rounds: usize, next: Option<u64>) -> Vec<u8> {
        let index = |kind: u32, count: u64| {
            let words = [20_u32, kind, 1].map(u32::to_le_bytes).concat();
            [words, count.to_le_bytes().to_vec()].concat()
        };
        let double = |name: &str, value: f64| {
            [text(name), 10_u32.to_le_bytes().to_vec(), value.to_le_bytes().to_vec()].concat()
        };
        let word = |name: &str, value: &str| {
            [text(name), 0x20_u32.to_le_bytes().to_vec(), text(value)].concat()
        };
        let whole = |name: &str, value: u32| {
            [text(name), 7_u32.to_le_bytes().to_vec(), value.to_le_bytes().to_vec()].concat()
        };
        let list = [
            2_u32.to_le_bytes().to_vec(),
            text("/'g'/'force'"),
            index(2, 2),
            6_u32.to_le_bytes().to_vec(),
            whole("NI_Number_Of_Scales", 1),
            word("NI_Scale[0]_Scale_Type", "Linear"),
            double("NI_Scale[0]_Linear_Slope", 0.5),
            double("NI_Scale[0]_Linear_Y_Intercept", 5.0),
            word("unit_string", "N"),
            double("wf_increment", 0.25),
            text("/'g'/'it''s x'"),
            index(10, 2),
            1_u32.to_le_bytes().to_vec(),
            double("wf_increment", 0.25),
        ]
        .concat();
        let mut raw = Vec::new();
        for round in 0..rounds {
            let first = 2 * round as i16;
            raw.extend([first.to_le_bytes(), (first + 1).to_le_bytes()].concat());
            raw.extend([f64::from(first).to_le_bytes(), 0.0_f64.to_le_bytes()].concat());
        }
        let flags = LISTED | NEW_LIST | NUMBERS;
        let next = next.unwrap_or((list.len() + raw.len()) as u64);
        let head =
            [&b"TDSm"[..], &flags.to_le_bytes(), &4713_u32.to_le_bytes(), &next.to_le_bytes()];
        [&head.concat()[..], &(list.len() as u64).to_le_bytes(), &list, &raw].concat()
    }

    fn tables(bytes: &[u8]) -> Result<Vec<Part>, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.tdms");
        std::fs::write(&path, bytes).unwrap();
        Ok(tdms(&path, None)?.parts)
    }

    #[test]
    fn rounds_and_segments_follow_each_other_scaled_and_with_their_clock() {
        let parts = tables(&[segment(2, None), segment(1, None)].concat()).unwrap();
        let column = |name: &str, unit: Option<&str>, values: [f64; 6]| Column {
            name: name.into(),
            unit: unit.map(Into::into),
            values: values.into(),
        };
        let columns = vec![
            column("time", Some("s"), [0.0, 0.25, 0.5, 0.75, 1.0, 1.25]),
            column("force", Some("N"), [5.0, 5.5, 6.0, 6.5, 5.0, 5.5]),
            column("it's x", None, [0.0, 0.0, 2.0, 0.0, 0.0, 0.0]),
        ];
        assert_eq!((&parts[0].name[..], &parts[0].content), ("g", &Content::Columns(columns)));
    }

    #[test]
    fn a_segment_that_its_recorder_did_not_end_is_read_in_whole_rounds_and_others_must_be_whole() {
        let crashed = segment(3, Some(UNKNOWN));
        let parts = tables(&crashed[..crashed.len() - 7]).unwrap();
        let Content::Columns(columns) = &parts[0].content else { panic!() };
        assert_eq!(columns[1].values, [5.0, 5.5, 6.0, 6.5]);
        let whole = segment(3, None);
        for end in 1..whole.len() {
            let error = tables(&whole[..end]).unwrap_err().to_string();
            assert!(error.starts_with("TDMS, segment at byte 0: damaged"), "{end}: {error}");
        }
    }
}
