//! The device's own log, put into words as it comes.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};

use super::feed::lock;
use super::store::Store;
use palpate_link::device::heard::Identity;
use palpate_link::device::log::{Line, LogError, Words};

/// Board of a simulated device, whose program has no log.
const SIMULATED: &str = "simulated";

/// Where the words of the device's log are.
#[derive(Clone, Debug)]
pub struct Elf {
    /// ELF file of the firmware.
    pub path: PathBuf,
    /// Whether to take it even if it is not that of the device.
    pub force: bool,
}

impl Elf {
    /// Reads the words for a device of a git state; any if it is empty.
    ///
    /// # Errors
    /// [`LogError`].
    pub fn words(&self, git: &str) -> Result<Words, LogError> {
        Words::read(&self.path, if self.force { "" } else { git })
    }
}

/// The log of the device that is there.
pub(super) struct Log {
    elf: Option<Elf>,
    pieces: Option<Sender<Vec<u8>>>,
    bytes: u64,
    /// How the log stands, in words.
    stands: String,
}

impl Log {
    pub(super) fn new(elf: Option<Elf>) -> Self {
        Self { elf, pieces: None, bytes: 0, stands: String::new() }
    }

    /// A device is there, perhaps another one.
    pub(super) fn meet(&mut self, identity: &Identity, store: &Arc<Mutex<Store>>) {
        self.pieces = None;
        self.stands = match &self.elf {
            _ if identity.board == SIMULATED => "A simulated device writes no log.".into(),
            None => "Its words are in the ELF file of the firmware: start `palpate serve` with --elf palpate.elf, \
                     which `cargo xtask firmware` writes beside the binary."
                .into(),
            Some(elf) => match elf.words(&identity.git) {
                Ok(words) => {
                    let (pieces, received) = channel();
                    let store = Arc::clone(store);
                    // A decoder borrows its words, so both live on a thread that ends with the pieces.
                    std::thread::spawn(move || speak(&words, &received, &store));
                    self.pieces = Some(pieces);
                    format!("Put into words with {}.", elf.path.display())
                }
                Err(error) => format!("No words: {error}"),
            },
        };
    }

    /// Takes a piece of the log.
    pub(super) fn take(&mut self, piece: &[u8]) {
        self.bytes += piece.len() as u64;
        if let Some(pieces) = &self.pieces {
            // It listens as long as we speak.
            let _ = pieces.send(piece.to_vec());
        }
    }

    /// How the log stands, in words.
    pub(super) fn words(&self) -> String {
        match self.bytes {
            0 => self.stands.clone(),
            bytes => format!("{} {bytes} bytes came.", self.stands),
        }
    }
}

/// Says the lines of the log into that of the session.
fn speak(words: &Words, pieces: &Receiver<Vec<u8>>, store: &Mutex<Store>) {
    let mut stream = words.stream();
    let mut malformed = false;
    for piece in pieces {
        for line in stream.take(&piece) {
            match line {
                Line::Words(words) => lock(store).say(format!("device: {words}")),
                Line::Malformed if !malformed => {
                    malformed = true;
                    lock(store).say(
                        "a part of the device's log has no meaning in this ELF file; is it of another build?",
                    );
                }
                Line::Malformed => {}
            }
        }
    }
}
