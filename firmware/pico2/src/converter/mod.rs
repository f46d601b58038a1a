//! The converter on the board's pins: an ADS131M04, or with the feature `nau7802` one for a single gauge.

#[cfg(not(feature = "nau7802"))]
mod ads131m04;
#[cfg(feature = "nau7802")]
mod nau7802;

#[cfg(not(feature = "nau7802"))]
pub use self::ads131m04::{CLOCK_HZ, Chip, chip};
#[cfg(feature = "nau7802")]
pub use self::nau7802::{CLOCK_HZ, Chip, chip};

use hal::clocks::ClocksManager;
use hal::gpio::bank0::{Gpio16, Gpio17, Gpio18, Gpio19, Gpio20, Gpio21};
use hal::gpio::{FunctionNull, Pin, PullDown};
use hal::pac::{I2C0, RESETS, SPI0};
use rp235x_hal as hal;

/// A pin as it is after a reset.
type Free<I> = Pin<I, FunctionNull, PullDown>;

/// What a converter may take of the board.
#[allow(dead_code, reason = "each converter takes its own")]
pub struct Parts<'p> {
    pub spi: SPI0,
    pub i2c: I2C0,
    pub gp16: Free<Gpio16>,
    pub gp17: Free<Gpio17>,
    pub gp18: Free<Gpio18>,
    pub gp19: Free<Gpio19>,
    pub gp20: Free<Gpio20>,
    pub gp21: Free<Gpio21>,
    pub clocks: &'p mut ClocksManager,
    pub resets: &'p mut RESETS,
}
