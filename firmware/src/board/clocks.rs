//! The processor's clock: 168 MHz from the crystal, whichever it is, with 48 MHz for USB, or 16 MHz from the oscillator on the chip.

use shared::wire::ClockSource;
use stm32f4xx_hal::pac::{RCC, TIM11};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

use super::crystal;

/// Reads of a ready bit before an oscillator counts as dead; a crystal needs some milliseconds.
const PATIENCE: u32 = 200_000;

/// Starts the best clock there is.
pub fn start(rcc: RCC, timer: TIM11) -> (Rcc, ClockSource) {
    let crystal_mhz = crystal_starts(&rcc).then(|| crystal::megahertz(&rcc, &timer)).flatten();
    match crystal_mhz {
        Some(mhz) if pll_starts(&rcc) => {
            let config = Config::hse(mhz.MHz()).sysclk(168.MHz()).pclk1(42.MHz()).pclk2(84.MHz());
            (rcc.freeze(config.require_pll48clk()), ClockSource::Crystal)
        }
        _ => (rcc.freeze(Config::hsi()), ClockSource::Internal),
    }
}

fn crystal_starts(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    (0..PATIENCE).any(|_| rcc.cr().read().hserdy().bit_is_set())
}

/// With its settings after reset: 96 MHz from the internal oscillator.
fn pll_starts(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.pllon().set_bit());
    let starts = (0..PATIENCE).any(|_| rcc.cr().read().pllrdy().bit_is_set());
    rcc.cr().modify(|_, w| w.pllon().clear_bit());
    let stops = (0..PATIENCE).any(|_| rcc.cr().read().pllrdy().bit_is_clear());
    starts && stops
}
