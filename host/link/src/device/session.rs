//! A conversation with a device: handshake, commands, and what it says meanwhile.

use std::collections::VecDeque;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use shared::calibration::Calibration;
use shared::pipeline::GAUGES;
use shared::wire::{
    Done, FRAME_MAX, FrameError, Head, Refusal, Row, Rows, SCHEMA, Settings, Status, ToDevice,
    encode,
};

use super::handshake::introduce;
use super::heard::{Heard, Identity, Said};
use super::line::{Backlog, Line, LineError};
use super::refusal::Refused;

/// Version of this program, as devices are told.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// An answer that did not come for so long is asked for again.
const REPEAT: Duration = Duration::from_millis(300);
/// How often a command is sent before the device counts as silent.
const TRIES: usize = 10;
/// The same where the device may stand still: to save, it erases a sector of flash, two if the first is worn out, and each takes
/// up to 4 s (data sheet of the STM32F405, table 40).
const TRIES_TO_SAVE: usize = 30;

const fn tries(command: &ToDevice<'_>) -> usize {
    match command {
        ToDevice::Save => TRIES_TO_SAVE,
        _ => TRIES,
    }
}

/// Why a conversation failed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum LinkError {
    #[error(transparent)]
    Line(#[from] LineError),
    #[error("nothing answers like a fingertip{}", heard_instead(*damaged))]
    Silent { damaged: usize },
    #[error(
        "the device speaks another language: firmware {theirs} with schema {their_schema:#018x}, this program \
         {VERSION} with schema {SCHEMA:#018x}; take firmware and program of one release"
    )]
    Schema { theirs: String, their_schema: u64 },
    #[error("the device has {theirs} gauges; this program {VERSION} reads up to {GAUGES}")]
    Gauges { theirs: u8 },
    #[error(transparent)]
    Refused(#[from] Refused),
    #[error("the device answered `{0:?}`, which does not belong to the question")]
    Unsuited(Done),
    #[error("the stream brings no rows; `palpate device self-test` says more")]
    NoRows,
    #[error("the command is too long for a frame")]
    TooLong(#[from] FrameError),
}

fn heard_instead(damaged: usize) -> String {
    match damaged {
        0 => String::new(),
        _ => format!("; {damaged} damaged frames came, as from a noisy line or another speed"),
    }
}

impl LinkError {
    /// Whether the port itself went away.
    #[must_use]
    pub const fn is_gone(&self) -> bool {
        matches!(self, Self::Line(_))
    }
}

/// A conversation with a device that speaks our schema.
pub struct Session {
    line: Line,
    /// Sequence number of the last frame sent.
    sequence: u32,
    /// Heard while waiting for something else.
    kept: VecDeque<Heard>,
    identity: Identity,
    /// The latest last; what was heard while a command waited may be of those before.
    settings: VecDeque<Known>,
}

/// Settings, and what they make strain of counts with.
struct Known {
    generation: u32,
    settings: Settings,
    calibration: Option<[Calibration; GAUGES]>,
}

/// Generations that are remembered.
const GENERATIONS: usize = 4;

impl Known {
    fn new(generation: u32, settings: Settings) -> Self {
        let gauges = settings.calibration.iter().zip(settings.tare);
        let calibrated =
            gauges.map(|(sheet, tare)| Some(Calibration::new(sheet).ok()?.with_tare(tare)));
        let calibration =
            calibrated.collect::<Option<Vec<_>>>().and_then(|all| all.try_into().ok());
        Self { generation, settings, calibration }
    }
}

impl Session {
    /// Opens a port and introduces itself; a device may take `patience` to answer.
    ///
    /// # Errors
    /// [`LinkError`] says why there is no device, or none to talk to.
    pub fn open(port: &Path, patience: Duration) -> Result<Self, LinkError> {
        Self::over(Line::open(port)?, patience)
    }

    /// The same over a line that is open.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn over(mut line: Line, patience: Duration) -> Result<Self, LinkError> {
        let (mut sequence, mut kept) = (any_number(), VecDeque::new());
        let met = introduce(&mut line, &mut sequence, &mut kept, patience)?;
        let settings = VecDeque::from([Known::new(met.generation, met.settings)]);
        Ok(Self { line, sequence, kept, identity: met.identity, settings })
    }

    /// Who the device is.
    #[must_use]
    pub const fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Its settings, and their generation, as it last said them.
    #[must_use]
    pub fn settings(&self) -> (u32, &Settings) {
        // There is one from the handshake on.
        self.settings
            .back()
            .map_or((0, &Settings::DEFAULT), |known| (known.generation, &known.settings))
    }

    /// The rows of a block one by one; none if its settings have not been heard.
    #[must_use]
    pub fn rows(&self, rows: &Rows) -> Option<Vec<Row>> {
        let known = self.settings.iter().find(|known| known.generation == rows.generation)?;
        Some(rows.iter(known.calibration.as_ref()?).collect())
    }

    /// Time between two samples of the converter, s.
    #[must_use]
    pub fn interval_s(&self) -> f64 {
        self.settings().1.interval_s()
    }

    /// What was read and not yet taken.
    #[must_use]
    pub fn backlog(&self) -> &Backlog {
        self.line.backlog()
    }

    /// Next that is heard before `deadline`, in the order it came; also what came while a command waited for its answer.
    ///
    /// # Errors
    /// [`LinkError::Line`].
    pub fn hear(&mut self, deadline: Instant) -> Result<Option<Heard>, LinkError> {
        match self.kept.pop_front() {
            Some(heard) => Ok(Some(heard)),
            None => self.receive(deadline),
        }
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<Heard>, LinkError> {
        let heard = self.line.receive(deadline)?.and_then(Heard::of);
        if let Some(Heard { said: Ok((_, Said::Settings(generation, settings))), .. }) = &heard {
            self.settings.retain(|known| known.generation != *generation);
            self.settings.push_back(Known::new(*generation, **settings));
            if self.settings.len() > GENERATIONS {
                self.settings.pop_front();
            }
        }
        Ok(heard)
    }

    /// Sends a command and waits for what became of it. Without an answer the same frame is sent again; the device carries
    /// it out once.
    ///
    /// # Errors
    /// [`LinkError::Refused`] with advice, [`LinkError::Silent`], [`LinkError::Line`].
    pub fn command(&mut self, command: &ToDevice<'_>) -> Result<Done, LinkError> {
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = [0; FRAME_MAX];
        let frame = encode(Head { sequence: self.sequence, time_us: 0 }, command, &mut frame)?;
        let mut damaged = 0;
        for _ in 0..tries(command) {
            self.line.send(frame)?;
            let deadline = Instant::now() + REPEAT;
            while let Some(heard) = self.receive(deadline)? {
                let answer = match &heard.said {
                    Ok((_, Said::Answer(answer))) if answer.to == self.sequence => Some(*answer),
                    Err(_) => {
                        damaged += 1;
                        None
                    }
                    Ok(_) => None,
                };
                self.kept.push_back(heard);
                match answer.map(|answer| answer.outcome) {
                    Some(Ok(done)) => return Ok(done),
                    Some(Err(refusal)) => return Err(Refused(refusal).into()),
                    None => {}
                }
            }
        }
        Err(LinkError::Silent { damaged })
    }

    /// Asks for the status. All rows that were made before have been heard when this returns.
    ///
    /// # Errors
    /// As [`Session::command`].
    pub fn status(&mut self) -> Result<Status, LinkError> {
        for _ in 0..TRIES {
            self.command(&ToDevice::Status)?;
            let deadline = Instant::now() + REPEAT;
            while let Some(heard) = self.receive(deadline)? {
                let status = match &heard.said {
                    Ok((_, Said::Status(status))) => Some(**status),
                    _ => None,
                };
                self.kept.push_back(heard);
                if let Some(status) = status {
                    return Ok(status);
                }
            }
        }
        Err(LinkError::Silent { damaged: 0 })
    }

    /// Ends a stream that may be on, as one whose host was killed.
    ///
    /// # Errors
    /// As [`Session::command`].
    pub fn quiet(&mut self) -> Result<(), LinkError> {
        match self.command(&ToDevice::Stop) {
            Ok(_) | Err(LinkError::Refused(Refused(Refusal::NotStreaming))) => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Ends a stream that may be on, and hears and forgets all that is left of it.
    ///
    /// # Errors
    /// As [`Session::command`].
    pub fn settle(&mut self) -> Result<Status, LinkError> {
        self.quiet()?;
        let status = self.status()?;
        self.forget();
        Ok(status)
    }

    /// Introduces itself anew, as after a reset of the device.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn again(&mut self, patience: Duration) -> Result<(), LinkError> {
        let met = introduce(&mut self.line, &mut self.sequence, &mut self.kept, patience)?;
        self.identity = met.identity;
        self.settings = VecDeque::from([Known::new(met.generation, met.settings)]);
        Ok(())
    }

    /// Forgets what was heard meanwhile.
    pub fn forget(&mut self) {
        self.kept.clear();
    }
}

/// Has a device of any release carry out a command of the core ([`shared::wire::is_of_core`]), though nothing else can be said to it.
///
/// # Errors
/// As [`Session::command`].
pub fn command_of_core(port: &Path, command: &ToDevice<'_>) -> Result<(), LinkError> {
    let mut line = Line::open(port)?;
    let (mut sequence, mut kept) = (any_number(), VecDeque::new());
    match introduce(&mut line, &mut sequence, &mut kept, REPEAT * TRIES as u32) {
        Ok(_) | Err(LinkError::Schema { .. }) => {}
        Err(error) => return Err(error),
    }
    let identity = Identity::unknown();
    let mut session = Session { line, sequence, kept, identity, settings: VecDeque::new() };
    session.command(command).map(drop)
}

/// A number to begin with: hosts one after the other do not take the same, or the device would repeat an old answer.
fn any_number() -> u32 {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    now.subsec_nanos() ^ std::process::id().rotate_left(16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_save_has_time_for_two_erasures() {
        assert!(REPEAT * tries(&ToDevice::Save) as u32 > Duration::from_secs(8));
    }
}
