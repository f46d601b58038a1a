//! The rows of a part that is not finished, one line each: what a kill leaves of it is taken up again.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::row::{Row, Worked};

/// A part under way.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Opens the journal of a part, with the rows that an earlier run left in it. A line that was cut off counts as none.
    pub(super) fn open(path: &Path) -> io::Result<(Self, Vec<(Row, Worked)>)> {
        let known = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(error),
        };
        let lines =
            known.split_inclusive(|&byte| byte == b'\n').filter(|line| line.ends_with(b"\n"));
        let rows = lines.filter_map(|line| serde_json::from_slice(line).ok()).collect();
        let mut file = File::options().create(true).append(true).open(path)?;
        if known.last().is_some_and(|&byte| byte != b'\n') {
            file.write_all(b"\n")?;
        }
        Ok((Self { path: path.into(), file }, rows))
    }

    /// Adds a row; when this returns it survives the end of the process.
    pub(super) fn add(&mut self, row: &Row, worked: Worked) -> io::Result<()> {
        let mut line = serde_json::to_vec(&(row, worked))?;
        line.push(b'\n');
        self.file.write_all(&line)
    }

    /// Removes the journal of a part that lies in its place.
    pub(super) fn finish(self) -> io::Result<()> {
        drop(self.file);
        fs::remove_file(&self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::rows;

    #[test]
    fn what_a_kill_leaves_is_there_to_the_last_bit_and_half_a_line_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part-00000.jsonl");
        let worked = Worked { seconds: 0.1 + 0.2, attempts: 1 };
        let (mut journal, known) = Journal::open(&path).unwrap();
        assert!(known.is_empty());
        for row in &rows()[..2] {
            journal.add(row, worked).unwrap();
        }
        drop(journal);
        let mut bytes = fs::read(&path).unwrap();
        bytes.extend(serde_json::to_vec(&(&rows()[2], worked)).unwrap());
        bytes.truncate(bytes.len() - 5);
        fs::write(&path, bytes).unwrap();
        let (mut journal, known) = Journal::open(&path).unwrap();
        assert_eq!(known, rows()[..2].iter().map(|row| (row.clone(), worked)).collect::<Vec<_>>());
        journal.add(&rows()[3], worked).unwrap();
        let (_, known) = Journal::open(&path).unwrap();
        assert_eq!((known.len(), &known[2].0), (3, &rows()[3]));
    }
}
