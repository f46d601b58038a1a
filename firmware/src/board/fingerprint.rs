//! What the factory wrote into this very chip.

use stm32f4xx_hal::pac::RCC;

const IDENTITY: *const [u32; 3] = 0x1fff_7a10 as *const _;
const TEMPERATURE: *const [u16; 2] = 0x1fff_7a2c as *const _;

/// The chip's own numbers.
#[derive(Clone, Copy)]
pub struct Fingerprint {
    /// 96 bits that no other chip has.
    pub serial: [u32; 3],
    /// Readings of the temperature sensor at 30 °C and 110 °C.
    pub temperature: [u16; 2],
}

/// Whether this is an emulated chip, which has neither these numbers nor a flash that can be written nor a loader, and where
/// reading them would fault. A real one runs from an oscillator that says it is ready; the emulator has no such register.
pub fn is_emulated() -> bool {
    // SAFETY: a read of a status register, which has no effect.
    unsafe { (*RCC::ptr()).cr().read().hsirdy().bit_is_clear() }
}

/// Reads them; none on an emulated chip.
pub fn read() -> Option<Fingerprint> {
    if is_emulated() {
        return None;
    }
    // SAFETY: both addresses are in the system memory of every STM32F405 (RM0090 §39, data sheet table 70), aligned, and
    // never written.
    let (serial, temperature) = unsafe { (IDENTITY.read(), TEMPERATURE.read()) };
    Some(Fingerprint { serial, temperature })
}
