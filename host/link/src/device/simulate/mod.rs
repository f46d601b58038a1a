//! A fingertip without hardware: the device's own program behind a pseudo-terminal.

mod board;
mod grasp;
mod pace;

use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use device::{Device, Identity, Restart, Room, Sample, begin_with};
use shared::wire::{
    Accumulated, Accumulator, Capabilities, ClockSource, FRAME_MAX, ResetCause, SettingsError,
};

use self::board::Board;
use self::grasp::Grasp;
use self::pace::Pace;
use super::pty::Pty;

/// The simulated converter's clock, Hz.
const CONVERTER_CLOCK_HZ: u32 = 8_000_000;
/// Temperature, 2^-8 °C.
const TEMPERATURE: i16 = 25 * 256;
/// Bytes that may wait for the line; then the device keeps its own. So many does Linux keep of a serial port whose program is
/// held up: a computer that is busy for half a second costs no row.
const WAITING: usize = 65_536;
const TICK_US: u64 = 10_000;
const SECOND_US: u64 = 1_000_000;

/// How to simulate.
#[derive(Clone, Debug, Default)]
pub struct Simulation {
    /// Keeps the settings here, as flash would.
    pub settings: Option<PathBuf>,
    /// Seed of the noise.
    pub seed: u64,
    /// Which finger of a hand it is, from 0: each presses a little later and more gently than the one before.
    pub finger: u8,
    /// A symbolic link to make to the pseudo-terminal, so that its path stays the same.
    pub link: Option<PathBuf>,
}

/// Why a simulation ended.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum SimulationError {
    #[error("the system gives no pseudo-terminal: {0}")]
    Terminal(#[from] std::io::Error),
    #[error("{} cannot be made a link to the pseudo-terminal: {source}", path.display())]
    Link { path: PathBuf, source: std::io::Error },
    #[error("{} holds no settings of this version: {reason}", path.display())]
    Settings { path: PathBuf, reason: String },
    #[error("the settings do not suit the converter: {0}")]
    Unsuited(#[from] SettingsError),
}

/// A simulated device, and its pseudo-terminal.
pub struct Simulated {
    pty: Pty,
    link: Option<PathBuf>,
    board: Board,
    grasp: Grasp,
}

/// What is lost with a reset.
struct Body<'b> {
    device: Device<'b>,
    began: Instant,
    line: Accumulator,
    /// What the line has no room for.
    waiting: Vec<u8>,
    pace: Pace,
    ticked_us: u64,
    released_us: u64,
    /// The last second of the computer's clock: at each of them the line rises that all simulated fingers share.
    second: u64,
}

impl Simulated {
    /// Makes a device and its pseudo-terminal.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub fn new(simulation: &Simulation) -> Result<Self, SimulationError> {
        let board = Board::new(simulation.settings.clone());
        board.record()?;
        let pty = Pty::open()?;
        if let Some(link) = &simulation.link {
            link_to(pty.path(), link)?;
        }
        let grasp = Grasp::new(simulation.seed, simulation.finger);
        Ok(Self { pty, link: simulation.link.clone(), board, grasp })
    }

    /// What to open as a serial port.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(self.pty.path())
    }

    /// Runs until `ended`, or until the host asks for the loader: whether it did.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub fn run(&mut self, ended: impl Fn() -> bool) -> Result<bool, SimulationError> {
        let mut reset = ResetCause::PowerOn;
        loop {
            let mut room = Room::new();
            match self.live(reset, &mut room, &ended)? {
                Some(Restart::Firmware) => self.board.reset(),
                Some(Restart::Bootloader) => return Ok(true),
                None => return Ok(false),
            }
            reset = ResetCause::Software;
        }
    }

    /// From one reset to the next; how it is to begin again, if it is.
    fn live(
        &mut self,
        reset: ResetCause,
        room: &mut Room,
        ended: &impl Fn() -> bool,
    ) -> Result<Option<Restart>, SimulationError> {
        let mut body = Body::new(self.board.record()?.as_deref(), reset, room)?;
        while !ended() {
            let busy = !body.waiting.is_empty();
            self.pty.wait(self.board.wait(body.now_us()), busy)?;
            self.step(&mut body)?;
            if let Some(restart) = body.device.restart_due() {
                return Ok(Some(restart));
            }
        }
        Ok(None)
    }

    fn step(&mut self, body: &mut Body<'_>) -> Result<(), SimulationError> {
        let Self { pty, board, grasp, .. } = self;
        body.receive(pty, board)?;
        let now_us = body.now_us();
        let until_us = body.pace.until(now_us, board.due_us());
        while let Some(time_us) = board.next_sample(until_us) {
            let counts = grasp.measured(board.inputs(), time_us, &board.gain());
            body.device.sample(&Sample { time_us, counts, lost: board.lost() });
            body.send(pty)?;
        }
        body.device.drained();
        while body.device.process_injected() {
            body.send(pty)?;
        }
        if now_us - body.ticked_us >= TICK_US {
            body.ticked_us = now_us;
            body.hear_the_shared_line();
            body.device.tick(now_us, board);
        }
        if now_us - body.released_us >= 500_000 {
            body.released_us = now_us;
            pty.release()?;
        }
        Ok(body.send(pty)?)
    }
}

impl Drop for Simulated {
    fn drop(&mut self) {
        if let Some(link) = &self.link {
            // Another simulation may have taken the name over.
            if std::fs::read_link(link).is_ok_and(|to| to == self.pty.path()) {
                let _ = std::fs::remove_file(link);
            }
        }
    }
}

impl<'b> Body<'b> {
    fn new(
        kept: Option<&[u8]>,
        reset: ResetCause,
        room: &'b mut Room,
    ) -> Result<Self, SimulationError> {
        let identity = Identity {
            version: env!("CARGO_PKG_VERSION"),
            git: "",
            board: "simulated",
            serial: [0; 3],
            converter_clock_hz: CONVERTER_CLOCK_HZ,
            converter: "ADS131M04",
            capabilities: Capabilities::ads131m04(CONVERTER_CLOCK_HZ),
            clock: ClockSource::Simulated,
            reset,
            panic: "",
        };
        let beginning = begin_with(kept, &identity.capabilities)?;
        let mut device = Device::new(identity, &beginning, room);
        device.set_temperature(Some(TEMPERATURE));
        Ok(Self {
            device,
            began: Instant::now(),
            line: Accumulator::new(),
            waiting: Vec::new(),
            pace: Pace::default(),
            ticked_us: 0,
            released_us: 0,
            second: since_1970_us() / SECOND_US,
        })
    }

    /// Time since the reset, µs.
    fn now_us(&self) -> u64 {
        self.began.elapsed().as_micros() as u64
    }

    /// Notes when the shared line rose, if it did.
    fn hear_the_shared_line(&mut self) {
        let (now_us, since_1970_us) = (self.now_us(), since_1970_us());
        let second = since_1970_us / SECOND_US;
        if second == self.second + 1
            && let Some(time_us) = now_us.checked_sub(since_1970_us % SECOND_US)
        {
            self.device.note_pulse(time_us);
        }
        self.second = second;
    }

    /// Takes what the host sent, as long as there is room for the answers.
    fn receive(&mut self, pty: &mut Pty, board: &mut Board) -> std::io::Result<()> {
        let mut bytes = [0; 64];
        // A host that never pauses does not keep it from everything else.
        for _ in 0..64 {
            let length = pty.read(&mut bytes)?;
            for byte in &bytes[..length] {
                match self.line.push(*byte) {
                    Accumulated::Nothing => {}
                    Accumulated::TooLong => self.device.count_damaged(),
                    Accumulated::Frame(frame) => {
                        let now_us = self.began.elapsed().as_micros() as u64;
                        if self.device.can_receive() {
                            self.device.receive(frame, now_us, board);
                        } else {
                            self.device.count_bytes_lost(frame.len() as u32 + 1);
                        }
                    }
                }
            }
            self.send(pty)?;
            if length == 0 || !self.waiting.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Sends what the line has room for.
    fn send(&mut self, pty: &mut Pty) -> std::io::Result<()> {
        let mut frame = [0; FRAME_MAX];
        let now_us = self.now_us();
        while self.waiting.len() < WAITING
            && let Some(bytes) = self.device.next_frame(now_us, &mut (), &mut frame)
        {
            self.waiting.extend_from_slice(bytes);
        }
        if !self.waiting.is_empty() {
            let written = pty.write(&self.waiting)?;
            self.waiting.drain(..written);
        }
        Ok(())
    }
}

/// The computer's clock, which all simulated fingers see, µs; 0 before 1970.
fn since_1970_us() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_micros() as u64)
}

/// Makes a symbolic link, in place of one that is there; never of another file.
fn link_to(terminal: &Path, link: &Path) -> Result<(), SimulationError> {
    let failed = |source| SimulationError::Link { path: link.into(), source };
    if link.is_symlink() {
        std::fs::remove_file(link).map_err(failed)?;
    }
    std::os::unix::fs::symlink(terminal, link).map_err(failed)
}
