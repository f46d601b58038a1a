//! Appending to a recording.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use shared::wire::{FRAME_MAX, Head};

use super::note::{Note, Opened, encode_note};
use super::{BEGINNING, BEGINNING_OF_SEVERAL};
use crate::files;

/// Least time between two notes of arrival, µs.
pub const ANCHOR_US: u64 = 20_000;
/// Bytes that wait for the disk at most; frames come in pieces of up to [`FRAME_MAX`].
const WAITING: usize = 32 * 1024;
/// Longest time that bytes wait in memory, µs: what a kill can cost.
const FLUSH_US: u64 = 200_000;
/// Longest time until the disk is told to keep what was written, µs: what a loss of power can cost.
const SYNC_US: u64 = 2_000_000;

/// Writes a recording: whole frames only, in the order they are given.
///
/// Bytes wait in memory for at most 0.2 s or 32 KiB. The first error of the file system ends the recording: what was written
/// until then stays readable, and every later call fails the same way. Dropping a writer writes what waits; [`Writer::close`]
/// also says that the recording ended in order, and whether all of it was written.
#[derive(Debug)]
pub struct Writer<W: Write> {
    out: W,
    sync: fn(&mut W) -> io::Result<()>,
    waiting: Vec<u8>,
    notes: u32,
    /// The device whose frames are written, and when a frame of each was last noted to have arrived.
    device: Option<u8>,
    anchored_us: BTreeMap<Option<u8>, u64>,
    flushed_us: u64,
    synced_us: u64,
    failed: Option<io::ErrorKind>,
    bytes: u64,
}

impl Writer<File> {
    /// Begins a recording in a new file; an existing one is replaced only if `overwrite` says so. No other recording is
    /// written to it meanwhile. What is no regular file (a device, a pipe) is written into.
    ///
    /// # Errors
    /// [`io::ErrorKind::AlreadyExists`], [`io::ErrorKind::ResourceBusy`] while another recording is written to it, or
    /// whatever else the file system answers.
    pub fn create(path: &Path, overwrite: bool, opened: &Opened<'_>) -> io::Result<Self> {
        Self::begin(files::begin(path, overwrite)?, files::keep, opened, BEGINNING)
    }

    /// The same for several devices in one file: [`Writer::of_device`] says whose frames follow.
    ///
    /// # Errors
    /// As [`Writer::create`].
    pub fn create_for_several(
        path: &Path,
        overwrite: bool,
        opened: &Opened<'_>,
    ) -> io::Result<Self> {
        Self::begin(files::begin(path, overwrite)?, files::keep, opened, BEGINNING_OF_SEVERAL)
    }
}

impl<W: Write> Writer<W> {
    /// Begins a recording in anything that takes bytes.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(out: W, opened: &Opened<'_>) -> io::Result<Self> {
        Self::begin(out, |_| Ok(()), opened, BEGINNING)
    }

    /// The same for several devices: [`Writer::of_device`] says whose frames follow.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn for_several(out: W, opened: &Opened<'_>) -> io::Result<Self> {
        Self::begin(out, |_| Ok(()), opened, BEGINNING_OF_SEVERAL)
    }

    fn begin(
        out: W,
        sync: fn(&mut W) -> io::Result<()>,
        opened: &Opened<'_>,
        beginning: &[u8],
    ) -> io::Result<Self> {
        let mut writer = Self {
            out,
            sync,
            waiting: Vec::with_capacity(WAITING + 2 * FRAME_MAX),
            notes: 0,
            device: None,
            anchored_us: BTreeMap::new(),
            flushed_us: 0,
            synced_us: 0,
            failed: None,
            bytes: 0,
        };
        writer.waiting.extend(beginning);
        writer.note(0, &Note::Opened(*opened))?;
        writer.flush()?;
        Ok(writer)
    }

    /// Appends a frame of the device as it came over the line, not yet decoded, without its zero byte. `arrived_us` is when
    /// its last byte was read, µs since the recording was opened; it is noted if [`ANCHOR_US`] passed since the last was.
    ///
    /// # Errors
    /// Those of the file; [`io::ErrorKind::InvalidInput`] if the bytes cannot be one frame.
    pub fn frame(&mut self, arrived_us: u64, frame: &[u8]) -> io::Result<()> {
        if frame.is_empty() || frame.len() >= FRAME_MAX || frame.contains(&0) {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        let due = |last: &u64| arrived_us.saturating_sub(*last) >= ANCHOR_US;
        if self.anchored_us.get(&self.device).is_none_or(due) {
            self.anchored_us.insert(self.device, arrived_us);
            self.append_note(arrived_us, &Note::Arrived)?;
        }
        self.waiting.extend(frame);
        self.waiting.push(0);
        self.tick(arrived_us)
    }

    /// The frames and gaps that follow are of this device, in a recording of several.
    ///
    /// # Errors
    /// Those of the file.
    pub fn of_device(&mut self, host_us: u64, device: u8) -> io::Result<()> {
        if self.device != Some(device) {
            self.device = Some(device);
            self.append_note(host_us, &Note::Device(device))?;
        }
        Ok(())
    }

    /// Appends a note of the host, made `host_us` µs since the recording was opened.
    ///
    /// # Errors
    /// Those of the file.
    pub fn note(&mut self, host_us: u64, note: &Note<'_>) -> io::Result<()> {
        self.append_note(host_us, note)?;
        self.tick(host_us)
    }

    fn append_note(&mut self, host_us: u64, note: &Note<'_>) -> io::Result<()> {
        let head = Head { sequence: self.notes, time_us: host_us };
        self.notes = self.notes.wrapping_add(1);
        let mut frame = [0; FRAME_MAX];
        self.waiting.extend(encode_note(head, note, &mut frame).map_err(io::Error::other)?);
        Ok(())
    }

    /// Writes what has waited long enough. Appending does this too; call it while nothing arrives.
    ///
    /// # Errors
    /// Those of the file.
    pub fn tick(&mut self, now_us: u64) -> io::Result<()> {
        if self.waiting.len() >= WAITING || now_us.saturating_sub(self.flushed_us) >= FLUSH_US {
            self.flushed_us = now_us;
            self.flush()?;
        }
        if now_us.saturating_sub(self.synced_us) >= SYNC_US {
            self.synced_us = now_us;
            self.checked(|writer| (writer.sync)(&mut writer.out))?;
        }
        Ok(())
    }

    /// Writes everything that waits.
    ///
    /// # Errors
    /// Those of the file.
    pub fn flush(&mut self) -> io::Result<()> {
        self.checked(|writer| {
            let waiting = std::mem::take(&mut writer.waiting);
            writer.out.write_all(&waiting)?;
            writer.bytes += waiting.len() as u64;
            writer.waiting = waiting;
            writer.waiting.clear();
            writer.out.flush()
        })
    }

    /// Remembers the first failure; nothing is tried after it.
    fn checked(&mut self, work: impl FnOnce(&mut Self) -> io::Result<()>) -> io::Result<()> {
        if let Some(kind) = self.failed {
            self.waiting.clear();
            return Err(kind.into());
        }
        work(self).inspect_err(|error| self.failed = Some(error.kind()))
    }

    /// Bytes written so far.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Ends the recording in order.
    ///
    /// # Errors
    /// Those of the file: not all of the recording may have been written.
    pub fn close(mut self, host_us: u64) -> io::Result<()> {
        self.append_note(host_us, &Note::Closed)?;
        self.flush()?;
        self.checked(|writer| (writer.sync)(&mut writer.out))
    }
}

impl<W: Write> Drop for Writer<W> {
    fn drop(&mut self) {
        // Whoever must know whether this succeeds calls `close`.
        let _ = self.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes so many bytes and no more.
    struct Disk {
        room: usize,
        written: Vec<u8>,
    }

    impl Write for &mut Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let taken = bytes.len().min(self.room - self.written.len());
            self.written.extend(&bytes[..taken]);
            if taken == 0 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(taken) }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn bytes_wait_for_a_fifth_of_a_second_at_most() {
        let mut disk = Disk { room: 1 << 20, written: Vec::new() };
        let mut writer = Writer::new(&mut disk, &Opened::timeless("")).unwrap();
        let begun = writer.bytes();
        writer.frame(FLUSH_US - 1, &[1; 100]).unwrap();
        assert_eq!(writer.bytes(), begun);
        writer.tick(FLUSH_US).unwrap();
        assert!(writer.bytes() > begun + 100);
    }

    #[test]
    fn what_waits_is_bounded_however_little_time_passes() {
        let mut disk = Disk { room: 1 << 20, written: Vec::new() };
        let mut writer = Writer::new(&mut disk, &Opened::timeless("")).unwrap();
        let capacity = writer.waiting.capacity();
        for _ in 0..2_000 {
            writer.frame(1, &[1; FRAME_MAX - 1]).unwrap();
        }
        assert_eq!(writer.waiting.capacity(), capacity);
    }

    #[test]
    fn dropping_a_writer_writes_what_waits() {
        let mut disk = Disk { room: 1 << 20, written: Vec::new() };
        Writer::new(&mut disk, &Opened::timeless("")).unwrap().frame(1, &[7, 8, 9]).unwrap();
        assert!(disk.written.ends_with(&[7, 8, 9, 0]));
    }

    #[test]
    fn a_full_disk_is_told_once_and_ever_after_and_nothing_more_is_written() {
        let mut disk = Disk { room: 300, written: Vec::new() };
        let mut writer = Writer::new(&mut disk, &Opened::timeless("")).unwrap();
        writer.frame(1, &[1; 250]).unwrap();
        for _ in 0..3 {
            assert_eq!(writer.flush().unwrap_err().kind(), io::ErrorKind::StorageFull);
        }
        assert_eq!(writer.close(2).unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(disk.written.len(), 300);
    }

    #[test]
    fn an_existing_file_is_replaced_only_on_demand() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("take.palpate");
        std::fs::write(&path, "precious").unwrap();
        let refused = Writer::create(&path, false, &Opened::timeless("")).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(std::fs::read(&path).unwrap(), b"precious");
        Writer::create(&path, true, &Opened::timeless("")).unwrap().close(0).unwrap();
        assert!(std::fs::read(&path).unwrap().starts_with(BEGINNING));
    }

    #[test]
    fn two_recordings_are_not_written_to_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("take.palpate");
        let mut first = Writer::create(&path, false, &Opened::timeless("first")).unwrap();
        first.flush().unwrap();
        let begun = std::fs::read(&path).unwrap();
        let refused = Writer::create(&path, true, &Opened::timeless("second")).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::ResourceBusy);
        assert_eq!(std::fs::read(&path).unwrap(), begun);
        first.close(0).unwrap();
        Writer::create(&path, true, &Opened::timeless("second")).unwrap();
    }

    #[test]
    fn what_cannot_be_one_frame_is_refused() {
        let mut disk = Disk { room: 1 << 20, written: Vec::new() };
        let mut writer = Writer::new(&mut disk, &Opened::timeless("")).unwrap();
        for bytes in [&[][..], &[1, 0, 2], &[1; FRAME_MAX]] {
            assert_eq!(writer.frame(0, bytes).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        }
    }
}
