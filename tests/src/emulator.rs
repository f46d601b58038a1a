//! The fingertip's firmware on an emulated STM32F405, with a pseudo-terminal as its serial port.

use std::io::{BufRead, BufReader, Error, ErrorKind, Result};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::workspace;

/// The program that emulates; Debian has it in `qemu-system-arm`.
pub const QEMU: &str = "qemu-system-arm";

/// The executable of the firmware, as `cargo xtask firmware` leaves it.
#[must_use]
pub fn firmware() -> PathBuf {
    workspace().join("target/firmware/palpate.elf")
}

/// The very bytes that are flashed.
fn image() -> PathBuf {
    firmware().with_extension("bin")
}

/// A running device. It ends with this value.
#[derive(Debug)]
pub struct Emulated {
    qemu: Child,
    folder: tempfile::TempDir,
}

impl Emulated {
    /// Starts the firmware.
    ///
    /// # Errors
    /// When the emulator or the firmware is not there, or the emulator ends at once.
    pub fn start() -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let qemu = boot(&link(folder.path()), None)?;
        Ok(Self { qemu, folder })
    }

    /// Starts the firmware with these bytes at an address of its RAM, as if a reset had left them there.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_with_memory(address: u32, bytes: &[u8]) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let left = folder.path().join("left-in-memory.bin");
        std::fs::write(&left, bytes)?;
        let qemu = boot(&link(folder.path()), Some((address, &left)))?;
        Ok(Self { qemu, folder })
    }

    /// Path of its serial port; stays the same over [`Self::restart`].
    #[must_use]
    pub fn port(&self) -> PathBuf {
        link(self.folder.path())
    }

    /// Cuts its power, and gives it back.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn restart(&mut self) -> Result<()> {
        self.stop()?;
        std::thread::sleep(Duration::from_millis(300));
        self.qemu = boot(&self.port(), None)?;
        Ok(())
    }

    fn stop(&mut self) -> Result<()> {
        self.qemu.kill()?;
        self.qemu.wait()?;
        match std::fs::remove_file(self.port()) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        let _ = self.stop();
    }
}

fn link(folder: &Path) -> PathBuf {
    folder.join("port")
}

/// Boots the firmware and links its pseudo-terminal to `port`. The link is the third serial port, USART3.
fn boot(port: &Path, memory: Option<(u32, &Path)>) -> Result<Child> {
    let mut command = Command::new(QEMU);
    if let Some((address, file)) = memory {
        let loader = format!("loader,addr={address:#x},force-raw=on,file={}", file.display());
        command.args(["-device", &loader]);
    }
    let mut qemu = command
        .args(["-machine", "netduinoplus2", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-serial", "null", "-serial", "pty", "-kernel"])
        .arg(image())
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .spawn()?;
    let said = qemu.stdout.take().map(BufReader::new);
    let terminal = said.into_iter().flat_map(BufRead::lines).find_map(|line| {
        let line = line.ok()?;
        line.split_whitespace().find(|word| word.starts_with("/dev/")).map(PathBuf::from)
    });
    let Some(terminal) = terminal else {
        let _ = qemu.kill();
        let status = qemu.wait()?;
        return Err(Error::other(format!(
            "{QEMU} with {} ended with {status} before it had a serial port",
            image().display()
        )));
    };
    symlink(terminal, port)?;
    Ok(qemu)
}
