//! Which program's format a file is of, by what is in it.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use crate::has_extension;

/// Bytes looked at from the beginning of a file, and from its end if it is an archive.
const LOOKED_AT: u64 = 1 << 16;

/// A format that is not plain text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Format {
    /// What it is called.
    pub(super) name: &'static str,
    /// What can be done with it.
    pub(super) reader: Reader,
}

/// What can be done with a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reader {
    /// Packed text.
    Gzip,
    /// Packed text.
    Zstandard,
    /// A workbook, a part a sheet.
    Excel,
    /// A workbook, a part a sheet.
    OpenDocument,
    /// A part for each group and length of arrays.
    Hdf5,
    /// The same, as MATLAB writes it.
    Matlab73,
    /// A part for each structure and length of arrays.
    Matlab5,
    /// A part a topic.
    Mcap,
    /// A part a topic, in SQLite.
    Bag,
    /// A part for each group and length of channels.
    Tdms,
    /// Columns of any names, a part an episode.
    Parquet,
    /// Force curves, a part a curve.
    Jpk,
    /// Force curves, a part a curve.
    Nid,
    /// Force curves, a part a curve.
    Nanoscope,
    /// Nothing reads it; what to do instead.
    None(&'static str),
}

const CSV: &str = "Export the table as text (CSV) with the program that wrote it.";
const PYTHON: &str =
    "Save the columns as CSV or Parquet (`pandas.DataFrame(...).to_csv(\"run.csv\")`).";

/// Formats by the bytes that they begin with.
const BEGINNINGS: &[(&[u8], &str, Reader)] = &[
    (b"\x1F\x8B", "a gzip file", Reader::Gzip),
    (b"\x28\xB5\x2F\xFD", "a Zstandard file", Reader::Zstandard),
    (b"\x89HDF\r\n\x1A\n", "an HDF5 file", Reader::Hdf5),
    (b"MATLAB 7.3 MAT-file", "a MATLAB file (7.3)", Reader::Matlab73),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file (5)", Reader::Matlab5),
    (b"\x89MCAP0\r\n", "an MCAP file", Reader::Mcap),
    (b"SQLite format 3\0", "a bag of ROS 2 (SQLite)", Reader::Bag),
    (b"TDSm", "a TDMS file", Reader::Tdms),
    (b"PAR1", "a Parquet file", Reader::Parquet),
    (b"BZh", "a bzip2 file", Reader::None("Unpack it with `bunzip2`.")),
    (b"\xFD7zXZ\0", "an xz file", Reader::None("Unpack it with `unxz`.")),
    (b"7z\xBC\xAF\x27\x1C", "a 7-Zip archive", Reader::None("Unpack it and name the files in it.")),
    (
        b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1",
        "a file of an old Office program (.xls) or another compound document",
        Reader::None("Save it as .xlsx or export the table as text (CSV)."),
    ),
    (b"ARROW1", "an Arrow (Feather) file", Reader::None("Save it as Parquet or CSV.")),
    (b"\x93NUMPY", "an array of NumPy (.npy)", Reader::None(PYTHON)),
    (b"\x80\x04\x95", "a Python pickle", Reader::None(PYTHON)),
    (
        b"#ROSBAG",
        "a bag of ROS 1",
        Reader::None("Convert it with `mcap convert run.bag run.mcap`."),
    ),
    (b"MDF     ", "an ASAM MDF measurement file", Reader::None(CSV)),
    (b"%PDF", "a PDF document", Reader::None(CSV)),
    (b"\\*Force file list", "a NanoScope file of Bruker or Veeco", Reader::Nanoscope),
    (b"\\*File list", "a NanoScope file of Bruker or Veeco", Reader::Nanoscope),
    (b"[DataSet]", "a file of Nanosurf", Reader::Nid),
];

/// Formats whose files are archives (ZIP), by what stands in them.
const ARCHIVES: &[(&[u8], &str, Reader)] = &[
    (b"opendocument.spreadsheet", "an OpenDocument spreadsheet", Reader::OpenDocument),
    (b"xl/workbook", "an Excel workbook", Reader::Excel),
    (b"header.properties", "a force curve of JPK", Reader::Jpk),
    (b".npy", "arrays of NumPy (.npz)", Reader::None(PYTHON)),
];

/// Formats by the ending of the name, where the file is not text.
const ENDINGS: &[(&[&str], &str, Reader)] = &[
    (&["xlsx", "xlsm"], "an Excel workbook", Reader::Excel),
    (&["ods"], "an OpenDocument spreadsheet", Reader::OpenDocument),
    (
        &["mat"],
        "a MATLAB file (4)",
        Reader::None("Save it anew: `load run.mat; save run.mat -v7`."),
    ),
    (
        &["xlsb"],
        "a binary Excel workbook",
        Reader::None("Save it as .xlsx or export the table as text (CSV)."),
    ),
    (
        &["jpk-force", "jpk-force-map", "jpk-qi-data", "jpk-qi-series"],
        "a force curve of JPK",
        Reader::Jpk,
    ),
    (&["nid"], "a file of Nanosurf", Reader::Nid),
    (&["spm", "pfc", "000", "001"], "a NanoScope file of Bruker or Veeco", Reader::Nanoscope),
    (&["ibw", "pxp"], "a file of Igor Pro", Reader::None(CSV)),
    (&["tri"], "a file of TRIOS", Reader::None("Export it from TRIOS as text (CSV) or Excel.")),
    (&["rcp", "rhpts", "orx"], "a project of RheoCompass", Reader::None(CSV)),
    (&["zs2", "zse", "zp2"], "a file of ZwickRoell testXpert", Reader::None(CSV)),
    (
        &["is_tens", "is_comp", "is_relax", "is_cyclic", "im_tens", "im_comp", "id_tens"],
        "a file of Instron Bluehill",
        Reader::None("Let Bluehill export its raw data as text (CSV)."),
    ),
];

impl Format {
    /// The format of a file; none of plain text and of what cannot be opened, or not twice (a pipe).
    pub(super) fn of(path: &Path) -> Option<Self> {
        if !std::fs::metadata(path).is_ok_and(|about| about.is_file()) {
            return None;
        }
        let mut file = File::open(path).ok()?;
        let mut start = Vec::new();
        file.by_ref().take(LOOKED_AT).read_to_end(&mut start).ok()?;
        Self::beginning(&start)
            .or_else(|| archive(&start, &mut file))
            .or_else(|| by_ending(path, &start))
    }

    fn beginning(start: &[u8]) -> Option<Self> {
        let found = BEGINNINGS.iter().find(|(mark, ..)| start.starts_with(mark));
        found.map(|&(_, name, reader)| Self { name, reader })
    }
}

/// The format of an archive: its files are named near its beginning and at its end.
fn archive(start: &[u8], file: &mut File) -> Option<Format> {
    if !start.starts_with(b"PK\x03\x04") {
        return None;
    }
    let mut end = Vec::new();
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(LOOKED_AT))).ok()?;
    file.take(LOOKED_AT).read_to_end(&mut end).ok()?;
    let holds = |mark: &[u8]| [start, &end].iter().any(|bytes| contains(bytes, mark));
    let found = ARCHIVES.iter().find(|(mark, ..)| holds(mark));
    found.map(|&(_, name, reader)| Format { name, reader })
}

fn contains(bytes: &[u8], mark: &[u8]) -> bool {
    bytes.windows(mark.len()).any(|window| window == mark)
}

/// What the ending says, unless the file is text all the same.
fn by_ending(path: &Path, start: &[u8]) -> Option<Format> {
    if start.starts_with(b"PK\x03\x04") || start.contains(&0) && !is_utf16(start) {
        let named = |endings: &[&str]| endings.iter().any(|ending| has_extension(path, ending));
        let found = ENDINGS.iter().find(|(endings, ..)| named(endings));
        let known = found.map(|&(_, name, reader)| Format { name, reader });
        let zip = Format {
            name: "a ZIP archive",
            reader: Reader::None("Unpack it and name the files in it."),
        };
        return known.or(start.starts_with(b"PK").then_some(zip));
    }
    None
}

fn is_utf16(start: &[u8]) -> bool {
    start.starts_with(b"\xFF\xFE") || start.starts_with(b"\xFE\xFF")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn format(name: &str, bytes: &[u8]) -> Option<Format> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        Format::of(&path)
    }

    #[test]
    fn a_format_is_told_by_what_is_in_the_file_and_the_ending_only_if_that_is_not_text() {
        assert_eq!(format("a.csv", b"\x1F\x8B\x08").unwrap().reader, Reader::Gzip);
        assert_eq!(format("a.csv", b"PK\x03\x04..xl/workbook.xml").unwrap().reader, Reader::Excel);
        assert_eq!(format("a.zip", b"PK\x03\x04..").unwrap().name, "a ZIP archive");
        assert_eq!(format("a.tri", b"\x01\0\x02").unwrap().name, "a file of TRIOS");
        assert_eq!(format("a.tri", b"Filename\ta\n"), None);
        assert_eq!(format("a.xlsx", b""), None);
        assert_eq!(format("a.txt", b"\xFF\xFEa\0"), None);
        assert_eq!(Format::of(Path::new("/nowhere/a.gz")), None);
    }

    #[test]
    fn an_archive_is_known_by_the_list_of_files_at_its_end() {
        let mut bytes = b"PK\x03\x04".to_vec();
        bytes.resize(200_000, 1);
        bytes.extend(b"xl/workbook.xml");
        assert_eq!(format("a", &bytes).unwrap().reader, Reader::Excel);
    }
}
