//! A device of another release.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use palpate::device::pty::Pty;
use palpate::device::session::{LinkError, Session};
use shared::wire::{
    Accumulated, Accumulator, ClockSource, Counters, FRAME_MAX, Formats, Head, Hello, ResetCause,
    SCHEMA, ToHost, encode,
};

use super::{Checked, Report, require};

/// A device that says `Hello` in another schema to whatever it hears.
pub struct Foreign {
    /// Its port.
    pub port: std::path::PathBuf,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<std::io::Result<()>>>,
}

impl Foreign {
    /// Version that its firmware has.
    pub const VERSION: &'static str = "99.0.0";
    /// Schema that it speaks.
    pub const SCHEMA: u64 = !SCHEMA;

    /// Begins it.
    ///
    /// # Errors
    /// Without pseudo-terminals.
    pub fn begin() -> std::io::Result<Self> {
        let words = Words { version: Self::VERSION, board: "of another release", rest: "" };
        Self::speaking(words)
    }

    /// Begins one that says these words wherever a device says words.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn that_says(words: &'static str) -> std::io::Result<Self> {
        Self::speaking(Words { version: words, board: words, rest: words })
    }

    fn speaking(words: Words) -> std::io::Result<Self> {
        let pty = Pty::open()?;
        let ended = Arc::new(AtomicBool::new(false));
        let (port, flag) = (pty.path().to_owned(), ended.clone());
        Ok(Self {
            port,
            ended,
            thread: Some(std::thread::spawn(move || speak(pty, &words, &flag))),
        })
    }
}

impl Drop for Foreign {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What it says of itself.
struct Words {
    version: &'static str,
    board: &'static str,
    /// Revision, and the panic before.
    rest: &'static str,
}

fn speak(mut pty: Pty, words: &Words, ended: &AtomicBool) -> std::io::Result<()> {
    let mut frame = [0; FRAME_MAX];
    let hello = ToHost::Hello(Hello {
        schema: Foreign::SCHEMA,
        version: words.version,
        git: words.rest,
        board: words.board,
        serial: [0; 3],
        channels: 4,
        converter_clock_hz: 8_000_000,
        clock: ClockSource::Simulated,
        formats: Formats::OURS,
        reset: ResetCause::PowerOn,
        panic: words.rest,
        counters: Counters::default(),
    });
    let hello = encode(Head::default(), &hello, &mut frame).map_err(std::io::Error::other)?;
    let mut line = Accumulator::new();
    let mut bytes = [0; 256];
    while !ended.load(Ordering::Relaxed) {
        pty.wait(Duration::from_millis(20), false)?;
        let length = pty.read(&mut bytes)?;
        for byte in &bytes[..length] {
            if let Accumulated::Frame(_) = line.push(*byte) {
                pty.write(hello)?;
            }
        }
    }
    Ok(())
}

/// A device of another schema is refused by the host with both versions and schemas named.
///
/// # Errors
/// What the host did instead.
pub fn check_foreign_device_is_refused() -> Checked {
    let foreign = Foreign::begin()?;
    match Session::open(&foreign.port, Duration::from_secs(2)) {
        Err(error @ LinkError::Schema { .. }) => {
            let words = error.to_string();
            let (theirs, ours) = (format!("{:#018x}", Foreign::SCHEMA), format!("{SCHEMA:#018x}"));
            for part in [Foreign::VERSION, env!("CARGO_PKG_VERSION"), &theirs, &ours] {
                require(words.contains(part), || format!("`{words}` does not name {part}"))?;
            }
            Ok(Report::new("foreign device").with("", words))
        }
        Err(other) => Err(other.into()),
        Ok(_) => Err("a device of another schema was accepted".into()),
    }
}
