//! What commands ask of the hardware.

use device::{Board, Converter, FrontEnd, Lost, Restart, Setting};
use rtic::Mutex;
use shared::wire::{ConverterFault, StoreFault};

use crate::board::fingerprint::is_emulated;
use crate::board::time::{self, Delay};
use crate::memory::Memory;

/// The converter and the memory for settings.
pub struct Hardware<C> {
    /// The converter.
    pub front_end: FrontEnd<C, Delay>,
    /// The memory for settings.
    pub memory: Memory,
}

/// Hardware that is locked for as long as it takes and no longer: while a command is carried out, its arithmetic above all, the
/// converter is read on.
pub struct Locked<'m, M>(pub &'m mut M);

impl<C: Converter, M: Mutex<T = Hardware<C>>> Board for Locked<'_, M> {
    fn configure(&mut self, setting: Setting) -> Result<(), ConverterFault> {
        // In two steps, so that no interrupt waits for both.
        self.0.lock(|hardware| hardware.front_end.prepare(setting))?;
        self.0.lock(|hardware| hardware.front_end.configure(time::now_us(), setting))
    }

    fn listen(&mut self, to_converter: bool) -> Lost {
        self.0.lock(|hardware| hardware.front_end.listen(time::now_us(), to_converter))
    }

    fn store(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        self.0.lock(|hardware| hardware.memory.save(record))
    }

    fn can_restart(&self, into: Restart) -> bool {
        into == Restart::Firmware || !is_emulated()
    }
}
