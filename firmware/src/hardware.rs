//! What commands ask of the hardware.

use device::{Board, Restart};
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use shared::pipeline::GAUGES;
use shared::wire::{ConverterFault, Oversampling, StoreFault};

use crate::front_end::FrontEnd;
use crate::memory::Memory;

/// The converter and the memory for settings.
pub struct Hardware<SPI, RESET> {
    /// The converter.
    pub front_end: FrontEnd<SPI, RESET>,
    /// The memory for settings.
    pub memory: Memory,
}

impl<SPI: SpiDevice, RESET: OutputPin> Board for Hardware<SPI, RESET> {
    fn configure(
        &mut self,
        oversampling: Oversampling,
        gain: [u8; GAUGES],
    ) -> Result<(), ConverterFault> {
        self.front_end.configure(oversampling, gain)
    }

    fn listen(&mut self, to_converter: bool) {
        self.front_end.listen(to_converter);
    }

    fn store(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        self.memory.save(record)
    }

    fn can_restart(&self, into: Restart) -> bool {
        into == Restart::Firmware || self.memory.is_real()
    }
}
