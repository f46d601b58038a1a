//! HDF5, and with it MATLAB 7.3: a part for each group and length of arrays.

use std::path::Path;

use hdf5_pure::{CompoundMember, DType, Dataset, Datatype, DatatypeByteOrder, File, Group};

use crate::error::guarded;
use crate::gather::{Array, gather};
use crate::limits::Budget;
use crate::{Contents, Error};

const HDF5: &str = "HDF5";
const MATLAB: &str = "MATLAB 7.3";
/// What the table of the arrays at the top is called.
const TOP: &str = "/";
/// How deep groups are followed; they may be linked in a ring.
const DEPTH: usize = 16;
/// Most columns that one array becomes: more is an image.
const COLUMNS: u64 = 256;
/// Attributes that hold a unit.
const UNITS: [&str; 4] = ["units", "unit", "Units", "Unit"];

/// Reads the tables of an HDF5 file, or the one of that name. Rows run along the first dimension; in a file of MATLAB (7.3),
/// which keeps its matrices transposed, along the last. Compound records give a column a field.
///
/// # Errors
/// See [`Error`].
pub fn hdf5(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    read(path, wanted, false)
}

/// The same of a file that MATLAB wrote (`save -v7.3`).
///
/// # Errors
/// See [`Error`].
pub fn matlab(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    read(path, wanted, true)
}

fn read(path: &Path, wanted: Option<&str>, transposed: bool) -> Result<Contents, Error> {
    let format = if transposed { MATLAB } else { HDF5 };
    std::fs::File::open(path)?;
    guarded(format, || {
        let file =
            File::open_streaming(path).map_err(|error| Error::damaged(format, "file", error))?;
        let end = file.superblock().eof_address;
        if file.file_size() < end {
            let message = format!("{} of {end} bytes are there", file.file_size());
            return Err(Error::damaged(format, "end of the file", message));
        }
        let attributes =
            file.root().attrs().map_err(|error| Error::damaged(format, "file", error))?;
        if attributes.keys().any(|name| name.starts_with("nsf_file_version")) {
            let what = "a file of Nanosurf Studio (.nhf), whose numbers are counts: export the curves as text or .nid";
            return Err(Error::unread(format, "file", what));
        }
        let mut walk = Walk { format, transposed, arrays: Vec::new() };
        walk.group(&file.root(), "", 0)?;
        let mut budget = Budget::new(format);
        let top = if transposed { "workspace" } else { TOP };
        gather(walk.arrays, top, wanted, |array| {
            let place = format!("array `/{}`", array.source.path);
            budget.take(array.rows * array.source.width, &place)?;
            array
                .source
                .columns(&file, array.rows, transposed)
                .map_err(|error| Error::damaged(format, place, error))
        })
    })
}

/// An array of numbers as it is stored.
struct Stored {
    /// Where it is in the file.
    path: String,
    /// Columns that it has.
    width: usize,
    /// Of records: the field.
    field: Option<Field>,
}

impl Stored {
    fn columns(
        &self,
        file: &File,
        rows: usize,
        transposed: bool,
    ) -> Result<Vec<Vec<f64>>, hdf5_pure::Error> {
        let dataset = file.dataset(&self.path)?;
        if let Some(field) = &self.field {
            return Ok(vec![field.read(&dataset, rows)?]);
        }
        let values = dataset.read_f64()?;
        Ok(match (self.width, transposed) {
            (1, _) => vec![values],
            (_, true) => values.chunks(rows).map(<[f64]>::to_vec).collect(),
            (width, false) => (0..width)
                .map(|column| values.iter().skip(column).step_by(width).copied().collect())
                .collect(),
        })
    }
}

/// A number within a record.
struct Field {
    name: String,
    offset: usize,
    record: usize,
    kind: DType,
    swapped: bool,
}

/// Records that are read at a time.
const RECORDS: usize = 1 << 12;

impl Field {
    /// The fields of a record that are numbers.
    fn all(dataset: &Dataset, kinds: &[(String, DType)]) -> Result<Vec<Self>, hdf5_pure::Error> {
        let record = usize::try_from(dataset.element_size()?).unwrap_or(usize::MAX);
        let Datatype::Compound { members, .. } = dataset.datatype()? else { return Ok(Vec::new()) };
        let field = |(member, (name, kind)): (CompoundMember, &(String, DType))| {
            let swapped = match member.datatype {
                Datatype::FixedPoint { byte_order, .. }
                | Datatype::FloatingPoint { byte_order, .. } => {
                    byte_order == DatatypeByteOrder::BigEndian
                }
                _ => return None,
            };
            let (offset, size) = (usize::try_from(member.byte_offset).ok()?, size_of(kind)?);
            let within = offset.checked_add(size).is_some_and(|end| end <= record);
            within.then(|| Self { name: name.clone(), offset, record, kind: kind.clone(), swapped })
        };
        Ok(members.into_iter().zip(kinds).filter_map(field).collect())
    }

    fn read(&self, dataset: &Dataset, rows: usize) -> Result<Vec<f64>, hdf5_pure::Error> {
        let mut values = Vec::new();
        for start in (0..rows).step_by(RECORDS) {
            let raw = dataset.read_raw_rows(start as u64, RECORDS as u64)?;
            values.extend(raw.chunks_exact(self.record).map(|record| self.number(record)));
        }
        Ok(values)
    }

    fn number(&self, record: &[u8]) -> f64 {
        let mut bytes = [0; 8];
        let size = size_of(&self.kind).unwrap_or(0);
        bytes[..size].copy_from_slice(&record[self.offset..self.offset + size]);
        if self.swapped {
            bytes[..size].reverse();
        }
        let whole = u64::from_le_bytes(bytes);
        match self.kind {
            DType::F64 => f64::from_bits(whole),
            DType::F32 => f64::from(f32::from_bits(whole as u32)),
            DType::I8 => f64::from(whole as i8),
            DType::I16 => f64::from(whole as i16),
            DType::I32 => f64::from(whole as i32),
            DType::I64 => (whole as i64) as f64,
            _ => whole as f64,
        }
    }
}

/// Bytes of a number; none of what is not one.
fn size_of(kind: &DType) -> Option<usize> {
    use DType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
    match kind {
        I8 | U8 => Some(1),
        I16 | U16 => Some(2),
        F32 | I32 | U32 => Some(4),
        F64 | I64 | U64 => Some(8),
        _ => None,
    }
}

struct Walk {
    format: &'static str,
    transposed: bool,
    arrays: Vec<Array<Stored>>,
}

impl Walk {
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), Error> {
        let format = self.format;
        let damaged =
            |error: hdf5_pure::Error| Error::damaged(format, format!("group `/{path}`"), error);
        if depth > DEPTH {
            let what = format!("groups within groups, more than {DEPTH} deep");
            return Err(Error::unread(format, format!("group `/{path}`"), what));
        }
        for name in group.datasets().map_err(damaged)? {
            let dataset = group.dataset(&name).map_err(damaged)?;
            self.dataset(&dataset, path, &name)?;
        }
        for name in group.groups().map_err(damaged)? {
            // MATLAB keeps what cells and objects refer to in these.
            if self.transposed && name.starts_with('#') {
                continue;
            }
            let inner = group.group(&name).map_err(damaged)?;
            let path = if path.is_empty() { name } else { format!("{path}/{name}") };
            self.group(&inner, &path, depth + 1)?;
        }
        Ok(())
    }

    fn dataset(&mut self, dataset: &Dataset, group: &str, name: &str) -> Result<(), Error> {
        let inner = if group.is_empty() { name.to_owned() } else { format!("{group}/{name}") };
        let place = format!("array `/{inner}`");
        let damaged = |error: hdf5_pure::Error| Error::damaged(self.format, place.clone(), error);
        let shape = dataset.shape().map_err(damaged)?;
        let (rows, width) = match (&shape[..], self.transposed) {
            (&[rows], _) => (rows, 1),
            // A row of MATLAB is as good a column.
            (&[rows, 1] | &[1, rows], true) => (rows, 1),
            (&[width, rows], true) | (&[rows, width], false) => (rows, width),
            _ => return Ok(()),
        };
        let Ok(rows) = usize::try_from(rows) else { return Ok(()) };
        if width == 0 || width > COLUMNS {
            return Ok(());
        }
        let width = width as usize;
        let attributes = dataset.attrs().map_err(damaged)?;
        // MATLAB keeps text as numbers.
        if attributes.get("MATLAB_class").and_then(|class| class.as_str()) == Some("char") {
            return Ok(());
        }
        let unit = UNITS.iter().find_map(|name| attributes.get(*name)?.as_str());
        let unit = unit.map(|unit| unit.trim().to_owned()).filter(|unit| !unit.is_empty());
        let mut add = |group: &str, name: &str, unit, field| {
            let source = Stored { path: inner.clone(), width, field };
            let (group, name) = (group.to_owned(), name.to_owned());
            self.arrays.push(Array { group, name, unit, rows, source });
        };
        match &dataset.dtype().map_err(damaged)? {
            DType::Compound(kinds) if width == 1 => {
                for field in Field::all(dataset, kinds).map_err(damaged)? {
                    add(&inner, &field.name.clone(), None, Some(field));
                }
            }
            kind if size_of(kind).is_some() => add(group, name, unit, None),
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Column, Content};

    fn written() -> Vec<u8> {
        let mut file = hdf5_pure::FileBuilder::new();
        let mut run = file.create_group("run");
        let time = run.create_dataset("t");
        time.with_f64_data(&[0.0, 0.5, 1.0]);
        time.set_attr("units", hdf5_pure::AttrValue::String("s".into()));
        run.create_dataset("xy").with_i32_data(&[1, 2, 3, 4, 5, 6]).with_shape(&[3, 2]);
        run.create_dataset("gain").with_f64_data(&[2.0]);
        file.add_group(run.finish());
        file.finish().unwrap()
    }

    fn tables(bytes: &[u8], transposed: bool) -> Result<Contents, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.h5");
        std::fs::write(&path, bytes).unwrap();
        read(&path, None, transposed)
    }

    #[test]
    fn a_group_is_a_table_with_the_units_of_its_attributes() {
        let contents = tables(&written(), false).unwrap();
        assert_eq!(contents.names, ["run"]);
        let column = |name: &str, unit: Option<&str>, values: [f64; 3]| Column {
            name: name.into(),
            unit: unit.map(Into::into),
            values: values.into(),
        };
        let columns = vec![
            column("t", Some("s"), [0.0, 0.5, 1.0]),
            column("xy_1", None, [1.0, 3.0, 5.0]),
            column("xy_2", None, [2.0, 4.0, 6.0]),
        ];
        assert_eq!(contents.parts[0].content, Content::Columns(columns));
        // In a file of MATLAB the same array is two rows of three, transposed.
        let names = tables(&written(), true).unwrap().names;
        assert_eq!(names, ["run (3 rows)", "run (2 rows)"]);
    }

    #[test]
    fn counts_of_nanosurf_are_not_taken_for_forces() {
        let mut file = hdf5_pure::FileBuilder::new();
        file.set_attr("nsf_file_version_major", hdf5_pure::AttrValue::I64(2));
        file.create_dataset("deflection").with_i32_data(&[1, 2, 3]);
        let error = tables(&file.finish().unwrap(), false).unwrap_err().to_string();
        assert!(error.contains("Nanosurf Studio (.nhf)"), "{error}");
    }

    #[test]
    fn every_cut_is_refused() {
        let whole = written();
        for end in 0..whole.len() {
            let error = tables(&whole[..end], false).map(|found| found.names).unwrap_err();
            assert!(error.to_string().starts_with("HDF5, "), "{end}: {error}");
        }
    }
}
