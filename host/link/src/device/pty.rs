//! A pseudo-terminal: what is read and written here comes from and goes to whoever opens its path as a serial port.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, ioctl_tiocnxcl, tcgetattr, tcsetattr};

/// A pseudo-terminal that carries bytes as they are.
#[derive(Debug)]
pub struct Pty {
    inner: File,
    /// Kept open, so that one user after the other can come and go.
    outer: OwnedFd,
    path: PathBuf,
}

impl Pty {
    /// Makes one.
    ///
    /// # Errors
    /// What the system answers.
    pub fn open() -> io::Result<Self> {
        let inner = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&inner)?;
        unlockpt(&inner)?;
        let name = ptsname(&inner, Vec::new())?.into_string().map_err(io::Error::other)?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let outer = open(name.as_str(), flags, Mode::empty())?;
        let mut mode = tcgetattr(&outer)?;
        mode.make_raw();
        tcsetattr(&outer, OptionalActions::Now, &mode)?;
        fcntl_setfl(&inner, fcntl_getfl(&inner)? | OFlags::NONBLOCK)?;
        Ok(Self { inner: inner.into(), outer, path: name.into() })
    }

    /// What to open as a serial port.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Waits until there is something to read, at most so long; also until there is room to write, if `to_write`.
    ///
    /// # Errors
    /// What the system answers.
    pub fn wait(&self, most: Duration, to_write: bool) -> io::Result<()> {
        let room = if to_write { PollFlags::OUT } else { PollFlags::empty() };
        let most = Timespec { tv_sec: 0, tv_nsec: most.subsec_nanos().into() };
        match poll(&mut [PollFd::new(&self.inner, PollFlags::IN | room)], Some(&most)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Reads what is there; 0 if nothing is.
    ///
    /// # Errors
    /// What the system answers.
    pub fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        none_if_busy(self.inner.read(bytes))
    }

    /// Writes as much as there is room for.
    ///
    /// # Errors
    /// What the system answers.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        none_if_busy(self.inner.write(bytes))
    }

    /// Lets others open it whose predecessor was killed while it had the port to itself.
    ///
    /// # Errors
    /// What the system answers.
    pub fn release(&self) -> io::Result<()> {
        Ok(ioctl_tiocnxcl(&self.outer)?)
    }
}

fn none_if_busy(done: io::Result<usize>) -> io::Result<usize> {
    match done {
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(0),
        done => done,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::line::{Arrival, Line};
    use std::time::Instant;

    #[test]
    fn what_is_written_arrives_as_it_was_at_whoever_opens_the_path() {
        let mut pty = Pty::open().unwrap();
        let mut line = Line::open(pty.path()).unwrap();
        // Bytes that a terminal would take for commands.
        let bytes: Vec<u8> = (1..=255).rev().collect();
        let whole = [&bytes[..], &[0]].concat();
        assert_eq!(pty.write(&whole).unwrap(), whole.len());
        let soon = Instant::now() + Duration::from_secs(2);
        let Ok(Some(Arrival::Frame(_, frame))) = line.receive(soon) else { panic!("no frame") };
        assert_eq!(frame, bytes);
        line.send(&whole).unwrap();
        let (mut heard, mut place) = (Vec::new(), [0; 400]);
        while heard.len() < whole.len() && Instant::now() < soon {
            pty.wait(Duration::from_millis(20), false).unwrap();
            let length = pty.read(&mut place).unwrap();
            heard.extend_from_slice(&place[..length]);
        }
        assert_eq!(heard, whole);
    }
}
