//! A line that flips, loses and doubles.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use palpate::device::pty::Pty;
use palpate::device::replay::replay;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serialport::SerialPort;
use shared::wire::Columns;

use super::recordings::{TEMPERATURE, compare};
use super::{Checked, Report, open, require};

/// How often something happens to a byte: a third each of a flipped bit, a lost and a doubled byte.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Chance for each byte.
    pub rate: f64,
    /// Seed.
    pub seed: u64,
}

/// A pseudo-terminal in front of a port, with noise both ways.
pub struct NoisyLine {
    /// What to open in place of the port.
    pub path: PathBuf,
    shared: Arc<Hits>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

/// What happened so far.
#[derive(Debug, Default)]
struct Hits {
    ended: AtomicBool,
    to_host: AtomicU64,
    to_device: AtomicU64,
}

impl NoisyLine {
    /// Puts itself in front of a port.
    ///
    /// # Errors
    /// If the port cannot be opened, or without pseudo-terminals.
    pub fn before(port: &Path, noise: Noise) -> io::Result<Self> {
        let far = serialport::new(port.to_string_lossy(), shared::wire::BAUD)
            .timeout(Duration::from_millis(1))
            .open()?;
        let near = Pty::open()?;
        let path = near.path().to_owned();
        let shared = Arc::new(Hits::default());
        let hits = shared.clone();
        let thread = std::thread::spawn(move || carry(near, far, noise, &hits));
        Ok(Self { path, shared, thread: Some(thread) })
    }

    /// Bytes that something happened to on the way to the host, and to the device.
    #[must_use]
    pub fn hits(&self) -> (u64, u64) {
        let hits = |count: &AtomicU64| count.load(Ordering::Relaxed);
        (hits(&self.shared.to_host), hits(&self.shared.to_device))
    }
}

impl Drop for NoisyLine {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn carry(mut near: Pty, mut far: Box<dyn SerialPort>, noise: Noise, hits: &Hits) -> io::Result<()> {
    let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
    let (mut bytes, mut to_host) = ([0; 1_024], Vec::new());
    while !hits.ended.load(Ordering::Relaxed) {
        let length = near.read(&mut bytes)?;
        let mut to_device = Vec::new();
        corrupt(&bytes[..length], noise.rate, &mut random, &mut to_device, &hits.to_device);
        far.write_all(&to_device)?;
        match far.read(&mut bytes) {
            Ok(length) => {
                corrupt(&bytes[..length], noise.rate, &mut random, &mut to_host, &hits.to_host);
            }
            Err(error) if error.kind() == io::ErrorKind::TimedOut => {}
            Err(error) => return Err(error),
        }
        let written = near.write(&to_host)?;
        to_host.drain(..written);
    }
    Ok(())
}

fn corrupt(bytes: &[u8], rate: f64, random: &mut ChaCha8Rng, out: &mut Vec<u8>, hits: &AtomicU64) {
    for &byte in bytes {
        if !random.random_bool(rate) {
            out.push(byte);
            continue;
        }
        hits.fetch_add(1, Ordering::Relaxed);
        match random.random_range(0..3) {
            0 => out.push(byte ^ 1 << random.random_range(0..8)),
            1 => {}
            _ => out.extend([byte, byte]),
        }
    }
}

/// Rows are injected and come back over a noisy line, at several rates of noise. Every command is carried out once; no row
/// that arrives differs from the host's own; no hit costs more than two frames.
///
/// # Errors
/// What went wrong, with the rate of the noise.
pub fn check_noisy_line(port: &Path, rates: &[f64], rows: usize, seed: u64) -> Checked {
    let mut report = Report::new("noisy line");
    for &rate in rates {
        let figures = at_rate(port, Noise { rate, seed }, rows)
            .map_err(|error| format!("noise of {rate} a byte, seed {seed}: {error}"))?;
        report = report.with("", format!("[{rate} a byte: {figures}]"));
    }
    Ok(report)
}

fn at_rate(
    port: &Path,
    noise: Noise,
    rows: usize,
) -> Result<String, Box<dyn std::error::Error + Send + Sync>> {
    const INTERVAL_NS: u32 = 1_024_000;
    let before = open(port)?.status()?.counters;
    let line = NoisyLine::before(port, noise)?;
    let mut session = open(&line.path)?;
    let counts: Vec<[i32; 4]> = (0..rows as i32)
        .map(|row| [row * 5_000 % 4_000_000, row * row % 90_001, -3 * row, 1 << (row % 23)])
        .collect();
    let began = Instant::now();
    let replayed = replay(&mut session, INTERVAL_NS, Columns::All, Some(TEMPERATURE), &counts)?;
    let passed = began.elapsed();
    let config = session.settings().1.config(f64::from(INTERVAL_NS) * 1e-9)?;
    drop(session);
    let (to_host, to_device) = line.hits();
    drop(line);
    let status = open(port)?.status()?;
    compare(&config, INTERVAL_NS, &counts, &replayed)?;
    require(replayed.status.rows == rows as u64, || {
        format!("{rows} rows were injected and the device took {}", replayed.status.rows)
    })?;
    let tally = replayed.tally;
    require(tally.frames_lost <= 2 * to_host, || {
        format!("{to_host} hits cost {} frames to the host", tally.frames_lost)
    })?;
    let damaged = u64::from(status.counters.frames_damaged - before.frames_damaged);
    require(damaged <= 2 * to_device, || {
        format!("{to_device} hits damaged {damaged} frames to the device")
    })?;
    Ok(format!(
        "{} of {rows} rows heard, all right; {to_host} + {to_device} hits cost {} + {damaged} frames; {:.1} s",
        tally.rows,
        tally.frames_lost,
        passed.as_secs_f64()
    ))
}
