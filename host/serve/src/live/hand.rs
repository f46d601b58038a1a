//! Files that the fingers of a hand write together, on the clock of this computer.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use palpate_link::device::record::since_us;
use palpate_link::device::share::{File, Share};
use palpate_trace::recording::Opened;

/// The fingers of a server. Clones are of the same hand.
#[derive(Clone, Default)]
pub struct Hand(Arc<Mutex<Known>>);

#[derive(Default)]
struct Known {
    /// Port of each finger, in their order.
    ports: Vec<String>,
    files: Vec<Joint>,
}

/// A file, and how many fingers write it.
struct Joint {
    path: PathBuf,
    file: File,
    began: Instant,
    fingers: usize,
}

impl Hand {
    /// One more finger; its number from 0.
    pub(super) fn enter(&self, port: &Path) -> u8 {
        let mut known = self.known();
        known.ports.push(port.to_string_lossy().into_owned());
        u8::try_from(known.ports.len() - 1).unwrap_or(u8::MAX)
    }

    /// A finger's share of a file, which the first of them begins.
    pub(super) fn join(&self, path: &Path, device: u8) -> io::Result<(Share, Membership)> {
        let mut known = self.known();
        if !known.files.iter().any(|joint| joint.path == path) {
            let opened = known.ports.join(", ");
            let file = File::create(path, false, &Opened::now(&opened), true)?;
            let (path, began) = (path.to_owned(), Instant::now());
            known.files.push(Joint { path, file, began, fingers: 0 });
        }
        let joint = known.files.iter_mut().find(|joint| joint.path == path);
        let joint = joint.ok_or_else(|| io::Error::other("the file is closed"))?;
        joint.fingers += 1;
        let (share, began) = (joint.file.of_device(device), joint.began);
        Ok((share, Membership { hand: Some(self.clone()), path: path.to_owned(), began }))
    }

    /// A finger writes no more; the last one ends the file in order.
    fn leave(&self, path: &Path) -> io::Result<()> {
        let mut known = self.known();
        let Some(index) = known.files.iter().position(|joint| joint.path == path) else {
            return Ok(());
        };
        known.files[index].fingers -= 1;
        if known.files[index].fingers > 0 {
            return Ok(());
        }
        let Joint { file, began, .. } = known.files.swap_remove(index);
        file.close(since_us(began, Instant::now()))
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// That a finger writes a file; it leaves when this goes, whatever ended it.
pub(super) struct Membership {
    /// None once it has left.
    hand: Option<Hand>,
    path: PathBuf,
    began: Instant,
}

impl Membership {
    /// When the file began.
    pub(super) fn began(&self) -> Instant {
        self.began
    }

    /// The finger writes no more; the last one ends the file in order.
    pub(super) fn end(mut self) -> io::Result<()> {
        self.hand.take().map_or(Ok(()), |hand| hand.leave(&self.path))
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        if let Some(hand) = self.hand.take() {
            // What made it go has been told.
            let _ = hand.leave(&self.path);
        }
    }
}
