//! The supply: whether it is high enough to write the flash. The chip's own brown-out reset is off as it leaves the factory, and
//! below 2.7 V a word of 32 bits is not programmed (data sheet, table 40).

use stm32f4xx_hal::pac::{PWR, RCC};

/// PLS: a supply that falls is low below 2.75 to 2.92 V, one that rises is not above 2.86 to 2.99 V (data sheet, table 19).
const THRESHOLD: u8 = 0b101;

/// Starts to watch it.
pub fn watch(power: &PWR, rcc: &RCC) {
    rcc.apb1enr().modify(|_, w| w.pwren().enabled());
    // The clock of a peripheral runs two cycles after it was enabled (RM0090 §7.3.13).
    cortex_m::asm::delay(2);
    // SAFETY: a field of three bits that takes any value.
    power.cr().modify(|_, w| unsafe { w.pls().bits(THRESHOLD).pvde().set_bit() });
}

/// Whether it is too low now.
pub fn is_low() -> bool {
    // SAFETY: a read of a status register, which has no effect.
    unsafe { (*PWR::ptr()).csr().read().pvdo().bit_is_set() }
}
