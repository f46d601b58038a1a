//! MATLAB's files of version 5 (`save -v6` and `-v7`): a part for each structure and length of arrays.
//!
//! A file is a header of 128 bytes and then elements: a tag with type and size, and so many bytes. Those at the top must tile
//! the file exactly, or it was cut off.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use crate::error::guarded;
use crate::gather::{Array, gather};
use crate::limits::{Budget, NUMBERS};
use crate::{Contents, Error};

const FORMAT: &str = "MATLAB 5";
const HEADER: u64 = 128;
/// What the table of the variables at the top is called.
const TOP: &str = "workspace";
/// Most bytes of one variable.
const LIMIT: u64 = 8 * NUMBERS as u64 + (1 << 20);
/// How deep structures are followed.
const DEPTH: usize = 16;
/// Most columns that one matrix becomes: more is an image.
const COLUMNS: usize = 256;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Classes of matrices.
const STRUCTURE: u8 = 2;
const NUMBERS_FROM: u8 = 6;
const NUMBERS_TO: u8 = 15;
/// Flag of a matrix with an imaginary part.
const COMPLEX: u8 = 0x08;

/// Reads the tables of a file of MATLAB 5, or the one of that name: columns are its vectors and the columns of its matrices, a
/// part its variables or the fields of a structure. Text, cells, objects and sparse matrices are left out.
///
/// # Errors
/// See [`Error`].
pub fn mat(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    guarded(
        FORMAT,
        std::panic::AssertUnwindSafe(|| {
            let arrays = variables(BufReader::new(file), length)?;
            gather(arrays, TOP, wanted, |array| {
                Ok(array.source.chunks(array.rows.max(1)).map(<[f64]>::to_vec).collect())
            })
        }),
    )
}

type Numbers = Array<Vec<f64>>;

fn variables(mut file: impl Read, length: u64) -> Result<Vec<Numbers>, Error> {
    let mut header = [0; HEADER as usize];
    file.read_exact(&mut header).map_err(|error| damaged(0, error))?;
    let swapped = match &header[126..] {
        b"IM" => false,
        b"MI" => true,
        _ => return Err(damaged(126, "no mark of the order of bytes")),
    };
    let mut reader = Reader { swapped, arrays: Vec::new(), budget: Budget::new(FORMAT) };
    let mut at = HEADER;
    while at < length {
        let mut tag = [0; 8];
        file.read_exact(&mut tag).map_err(|error| damaged(at, error))?;
        let (kind, size) = (reader.u32(&tag, 0), u64::from(reader.u32(&tag, 4)));
        if at + 8 + size > length {
            let message = format!("{size} bytes announced, {} left", length - at - 8);
            return Err(damaged(at, message));
        }
        reader.variable(kind, size, &mut file, at)?;
        at += 8 + size;
    }
    Ok(reader.arrays)
}

fn damaged(at: u64, message: impl std::fmt::Display) -> Error {
    Error::damaged(FORMAT, format!("byte {at}"), message)
}

struct Reader {
    swapped: bool,
    arrays: Vec<Numbers>,
    budget: Budget,
}

/// An element within a matrix.
struct Element<'a> {
    kind: u32,
    bytes: &'a [u8],
}

impl Reader {
    /// Takes an element at the top: a variable, or one that is packed.
    fn variable(
        &mut self,
        kind: u32,
        size: u64,
        file: &mut impl Read,
        at: u64,
    ) -> Result<(), Error> {
        let place = format!("variable at byte {at}");
        let too_large = || {
            let limit = format!("{} MiB in one variable", LIMIT >> 20);
            Error::TooLarge { format: FORMAT, place: place.clone(), limit }
        };
        let mut bytes = Vec::new();
        let mut packed = file.take(size);
        match kind {
            MATRIX if size > LIMIT => return Err(too_large()),
            MATRIX => packed.read_to_end(&mut bytes).map_err(|error| damaged(at, error))?,
            COMPRESSED => {
                let mut unpacked = flate2::read::ZlibDecoder::new(&mut packed).take(LIMIT + 1);
                unpacked.read_to_end(&mut bytes).map_err(|error| damaged(at, error))?
            }
            // Nothing else holds variables.
            other => return Err(damaged(at, format!("element of type {other}"))),
        };
        if bytes.len() as u64 > LIMIT {
            return Err(too_large());
        }
        // The checksum of what was packed has been read with its last byte.
        std::io::copy(&mut packed, &mut std::io::sink())?;
        let cut = || damaged(at, "a variable ends before its elements");
        if kind == MATRIX {
            return self.matrix(&bytes, "", None, 0).ok_or_else(cut)?;
        }
        let mut rest = &bytes[..];
        let inner = self.element(&mut rest).ok_or_else(cut)?;
        match inner.kind {
            MATRIX => self.matrix(inner.bytes, "", None, 0).ok_or_else(cut)?,
            other => Err(damaged(at, format!("packed element of type {other}"))),
        }
    }

    /// Takes a matrix; none if its bytes end too early. `name` is given for a field, which has none of its own.
    fn matrix(
        &mut self,
        mut bytes: &[u8],
        group: &str,
        name: Option<&str>,
        depth: usize,
    ) -> Option<Result<(), Error>> {
        // An empty field has no bytes at all.
        if bytes.is_empty() || depth > DEPTH {
            return Some(Ok(()));
        }
        let flags = self.element(&mut bytes)?.bytes;
        let flags = self.u32(flags.get(..4)?, 0).to_le_bytes();
        let (class, complex) = (flags[0], flags[1] & COMPLEX != 0);
        if !(class == STRUCTURE || (NUMBERS_FROM..=NUMBERS_TO).contains(&class)) {
            return Some(Ok(()));
        }
        let dimensions = self.element(&mut bytes)?.bytes;
        let dimensions: Vec<usize> =
            dimensions.chunks_exact(4).map(|four| self.u32(four, 0) as usize).collect();
        let own = self.element(&mut bytes)?.bytes;
        let own = String::from_utf8_lossy(own).into_owned();
        let name = name.map_or(own, Into::into);
        if class == STRUCTURE {
            return self.structure(bytes, &dimensions, group, &name, depth);
        }
        let real = self.element(&mut bytes)?;
        let place = format!("variable `{name}`");
        let count = dimensions.iter().try_fold(1_usize, |all, &one| all.checked_mul(one))?;
        if let Err(error) = self.budget.take(count, &place) {
            return Some(Err(error));
        }
        let values = self.numbers(&real, count)?;
        let (rows, columns) = match dimensions[..] {
            [rows, 1] | [1, rows] => (rows, 1),
            [rows, columns] => (rows, columns),
            _ => return Some(Ok(())),
        };
        // A spectrum is no recording.
        if !complex && columns <= COLUMNS {
            self.arrays.push(Array { group: group.into(), name, unit: None, rows, source: values });
        }
        Some(Ok(()))
    }

    /// Takes the fields of a structure, or of each in an array of them.
    fn structure(
        &mut self,
        mut bytes: &[u8],
        dimensions: &[usize],
        group: &str,
        name: &str,
        depth: usize,
    ) -> Option<Result<(), Error>> {
        let width = self.u32(self.element(&mut bytes)?.bytes.get(..4)?, 0) as usize;
        let names = self.element(&mut bytes)?.bytes;
        let text = |name: &[u8]| {
            let end = name.iter().position(|&byte| byte == 0).unwrap_or(name.len());
            String::from_utf8_lossy(&name[..end]).into_owned()
        };
        let names: Vec<String> = names.chunks_exact(width.max(1)).map(text).collect();
        let count = dimensions.iter().try_fold(1_usize, |all, &one| all.checked_mul(one))?;
        let inner = if group.is_empty() { name.to_owned() } else { format!("{group}.{name}") };
        if names.is_empty() {
            return Some(Ok(()));
        }
        for index in 0..count {
            let group = if count > 1 { format!("{inner}({})", index + 1) } else { inner.clone() };
            for name in &names {
                let field = self.element(&mut bytes)?;
                if field.kind != MATRIX {
                    return None;
                }
                if let Err(error) = self.matrix(field.bytes, &group, Some(name), depth + 1)? {
                    return Some(Err(error));
                }
            }
        }
        Some(Ok(()))
    }

    /// Cuts the next element off; none if it is not all there.
    fn element<'a>(&self, rest: &mut &'a [u8]) -> Option<Element<'a>> {
        let tag = self.u32(rest.get(..4)?, 0);
        // A small one has its size and its bytes within the tag.
        let (kind, start, size, padded): (_, usize, _, _) = match tag >> 16 {
            0 => {
                let size = self.u32(rest.get(4..8)?, 0) as usize;
                (tag, 8, size, size.checked_next_multiple_of(8)?)
            }
            small => (tag & 0xFFFF, 4, small as usize, 4),
        };
        let bytes = rest.get(start..start.checked_add(size)?).filter(|_| size <= padded)?;
        *rest = &rest[rest.len().min(start + padded)..];
        Some(Element { kind, bytes })
    }

    /// Exactly `count` numbers; MATLAB stores whole ones in as few bytes as they need.
    fn numbers(&self, element: &Element, count: usize) -> Option<Vec<f64>> {
        let size = match element.kind {
            1 | 2 => 1,
            3 | 4 => 2,
            5..=7 => 4,
            9 | 12 | 13 => 8,
            _ => return None,
        };
        if element.bytes.len() != count.checked_mul(size)? {
            return None;
        }
        let number = |raw: &[u8]| {
            let mut bytes = [0; 8];
            bytes[..size].copy_from_slice(raw);
            if self.swapped {
                bytes[..size].reverse();
            }
            let whole = u64::from_le_bytes(bytes);
            match element.kind {
                1 => f64::from(whole as i8),
                3 => f64::from(whole as i16),
                5 => f64::from(whole as i32),
                7 => f64::from(f32::from_bits(whole as u32)),
                9 => f64::from_bits(whole),
                12 => (whole as i64) as f64,
                _ => whole as f64,
            }
        };
        Some(element.bytes.chunks_exact(size).map(number).collect())
    }

    fn u32(&self, bytes: &[u8], at: usize) -> u32 {
        let four = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
        if self.swapped { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use crate::{Column, Content};

    fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
        let mut out = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
        out.extend(bytes);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    }

    fn start(class: u8, rows: u32, columns: u32, name: &str) -> Vec<u8> {
        let dimensions = [rows.to_le_bytes(), columns.to_le_bytes()].concat();
        let flags = element(6, &[class, 0, 0, 0, 0, 0, 0, 0]);
        [flags, element(5, &dimensions), element(1, name.as_bytes())].concat()
    }

    fn doubles(rows: u32, columns: u32, name: &str, values: &[f64]) -> Vec<u8> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        element(MATRIX, &[start(6, rows, columns, name), element(9, &bytes)].concat())
    }

    /// Two variables, a structure with two fields, and one packed variable in small integers.
    fn written() -> Vec<u8> {
        let mut file = vec![b' '; 124];
        file.extend(b"\0\x01IM");
        file.extend(doubles(3, 1, "t", &[0.0, 0.5, 1.0]));
        file.extend(doubles(3, 2, "xy", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        // Names of four bytes, in a small element.
        let width = [5, 0, 4, 0, 4, 0, 0, 0];
        let fields = [
            start(STRUCTURE, 1, 1, "run"),
            width.to_vec(),
            element(1, b"a\0\0\0b\0\0\0"),
            doubles(1, 2, "", &[7.0, 8.0]),
            doubles(2, 1, "", &[9.0, 10.0]),
        ];
        file.extend(element(MATRIX, &fields.concat()));
        let small =
            element(MATRIX, &[start(6, 3, 1, "n"), element(3, &[255, 255, 2, 0, 3, 0])].concat());
        let mut packed =
            flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(&small).unwrap();
        let packed = packed.finish().unwrap();
        file.extend([15_u32.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat());
        file.extend(packed);
        file
    }

    fn tables(bytes: &[u8]) -> Result<Contents, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.mat");
        std::fs::write(&path, bytes).unwrap();
        mat(&path, None)
    }

    #[test]
    fn variables_structures_and_packed_integers_are_read() {
        let contents = tables(&written()).unwrap();
        assert_eq!(contents.names, ["workspace", "run"]);
        let column = |name: &str, values: &[f64]| Column {
            name: name.into(),
            unit: None,
            values: values.into(),
        };
        let workspace = vec![
            column("t", &[0.0, 0.5, 1.0]),
            column("xy_1", &[1.0, 2.0, 3.0]),
            column("xy_2", &[4.0, 5.0, 6.0]),
            column("n", &[-1.0, 2.0, 3.0]),
        ];
        assert_eq!(contents.parts[0].content, Content::Columns(workspace));
        let run = vec![column("a", &[7.0, 8.0]), column("b", &[9.0, 10.0])];
        assert_eq!(contents.parts[1].content, Content::Columns(run));
    }

    #[test]
    fn every_cut_but_one_between_two_variables_is_refused() {
        let whole = written();
        // Where a variable ends, the file is whole: nothing in it says how many there are.
        let mut ends = vec![HEADER as usize];
        while let Some(&at) = ends.last().filter(|&&at| at < whole.len()) {
            let size = u32::from_le_bytes(whole[at + 4..at + 8].try_into().unwrap());
            ends.push(at + 8 + size as usize);
        }
        assert_eq!(ends.len(), 5);
        for end in 0..whole.len() {
            let read = tables(&whole[..end]);
            assert_eq!(read.is_ok(), ends.contains(&end), "{end}: {read:?}");
        }
    }
}
