//! A file that is written as devices are heard, by one or by several.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use palpate_trace::recording::{Note, Opened, Writer};

/// A recording that is being written.
#[derive(Clone)]
pub struct File(Arc<Mutex<Option<Writer<fs::File>>>>);

/// A device's share of it.
pub struct Share {
    file: File,
    /// Its number from 0, where there are several.
    device: Option<u8>,
}

impl File {
    /// Begins a recording, of one device or of several.
    ///
    /// # Errors
    /// When it cannot be made; without `overwrite` also where something is there.
    pub fn create(
        path: &Path,
        overwrite: bool,
        opened: &Opened<'_>,
        of_several: bool,
    ) -> io::Result<Self> {
        let create = if of_several { Writer::create_for_several } else { Writer::create };
        Ok(Self(Arc::new(Mutex::new(Some(create(path, overwrite, opened)?)))))
    }

    /// The share of the only device.
    #[must_use]
    pub fn alone(&self) -> Share {
        Share { file: self.clone(), device: None }
    }

    /// The share of one of several devices, which count from 0.
    #[must_use]
    pub fn of_device(&self, device: u8) -> Share {
        Share { file: self.clone(), device: Some(device) }
    }

    /// Ends the recording in order.
    ///
    /// # Errors
    /// When the last of it cannot be written.
    pub fn close(&self, now_us: u64) -> io::Result<()> {
        let writer = self.lock().take();
        writer.map_or(Ok(()), |writer| writer.close(now_us))
    }

    fn lock(&self) -> MutexGuard<'_, Option<Writer<fs::File>>> {
        // Whoever panicked left whole frames: it panicked elsewhere.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Share {
    /// Appends a frame of this device.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn frame(&self, arrived_us: u64, frame: &[u8]) -> io::Result<()> {
        self.write(arrived_us, |writer| writer.frame(arrived_us, frame))
    }

    /// Appends a note of the host about this device.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn note(&self, host_us: u64, note: &Note<'_>) -> io::Result<()> {
        self.write(host_us, |writer| writer.note(host_us, note))
    }

    /// Writes what has waited long enough.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn tick(&self, now_us: u64) -> io::Result<()> {
        self.file.lock().as_mut().map_or(Ok(()), |writer| writer.tick(now_us))
    }

    fn write(
        &self,
        now_us: u64,
        work: impl FnOnce(&mut Writer<fs::File>) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut file = self.file.lock();
        let Some(writer) = file.as_mut() else { return Ok(()) };
        if let Some(device) = self.device {
            writer.of_device(now_us, device)?;
        }
        work(writer)
    }
}
