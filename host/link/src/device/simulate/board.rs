//! The simulated board: a converter that is never in doubt, and a file for flash.

use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::Duration;

use device::{Lost, Restart, Setting};
use shared::pipeline::GAUGES;
use shared::wire::{ConverterFault, Inputs, Kept, Settings, StoreFault};

use super::SimulationError;
use palpate_trace::files::write_whole;

/// With nothing to do, it looks so often for something.
const IDLE: Duration = Duration::from_millis(5);
/// With samples overdue, it waits so long before it takes more.
const BEHIND: Duration = Duration::from_millis(1);

/// The hardware of a simulated device.
pub(super) struct Board {
    settings: Option<PathBuf>,
    setting: Setting,
    /// The next sample is the first of its setting.
    exchanged: bool,
    listening: bool,
    /// Time of the next sample, µs; none before the first.
    next_us: Option<u64>,
}

impl Board {
    pub(super) fn new(settings: Option<PathBuf>) -> Self {
        let Settings { interval_ns, gain, .. } = Settings::DEFAULT;
        let setting = Setting { interval_ns, gain, inputs: Inputs::Gauges };
        Self { settings, setting, exchanged: false, listening: false, next_us: None }
    }

    /// As after power-on.
    pub(super) fn reset(&mut self) {
        *self = Self::new(self.settings.take());
    }

    /// The record of the settings that are kept, if any are.
    pub(super) fn record(&self) -> Result<Option<Vec<u8>>, SimulationError> {
        let Some(path) = &self.settings else { return Ok(None) };
        let refused = |reason: String| SimulationError::Settings { path: path.clone(), reason };
        match std::fs::read(path) {
            // A file that is none may be somebody's.
            Ok(record) if Settings::from_record(&record).1 == Kept::Discarded => {
                Err(refused("it is of another version, or no settings".into()))
            }
            Ok(record) => Ok(Some(record)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(refused(error.to_string())),
        }
    }

    pub(super) const fn gain(&self) -> [u8; GAUGES] {
        self.setting.gain
    }

    /// What the converter measures.
    pub(super) const fn inputs(&self) -> Inputs {
        self.setting.inputs
    }

    /// What happened between the sample before and the next.
    pub(super) fn lost(&mut self) -> Lost {
        Lost { exchanged: std::mem::take(&mut self.exchanged), ..Lost::NONE }
    }

    fn interval_us(&self) -> u64 {
        u64::from(self.setting.interval_ns) / 1_000
    }

    /// Time of the sample that comes next, µs; none before the first.
    pub(super) const fn due_us(&self) -> Option<u64> {
        self.next_us
    }

    /// Time of the next sample that is due, µs.
    pub(super) fn next_sample(&mut self, now_us: u64) -> Option<u64> {
        if !self.listening {
            return None;
        }
        let time_us = *self.next_us.get_or_insert(now_us);
        (time_us <= now_us).then(|| {
            self.next_us = Some(time_us + self.interval_us());
            time_us
        })
    }

    /// How long there is nothing to do.
    pub(super) fn wait(&self, now_us: u64) -> Duration {
        match self.next_us {
            Some(next_us) if self.listening && next_us > now_us => {
                Duration::from_micros(next_us - now_us).min(IDLE)
            }
            Some(_) if self.listening => BEHIND,
            _ => IDLE,
        }
    }
}

impl device::Board for Board {
    fn configure(&mut self, setting: Setting) -> Result<(), ConverterFault> {
        (self.setting, self.exchanged) = (setting, self.listening);
        Ok(())
    }

    fn listen(&mut self, to_converter: bool) -> Lost {
        (self.listening, self.next_us, self.exchanged) = (to_converter, None, false);
        Lost::NONE
    }

    fn store(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        let Some(path) = &self.settings else { return Ok(()) };
        write_whole(path, |file| file.write_all(record)).map_err(|_| StoreFault::NotWritten)
    }

    fn can_restart(&self, _: Restart) -> bool {
        true
    }
}
