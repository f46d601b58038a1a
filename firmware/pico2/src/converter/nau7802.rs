//! The NAU7802 on I2C0: one gauge. Its clock is its own.

use device::converters::OneChannel;
use hal::Clock;
use hal::fugit::RateExtU32;
use hal::gpio::bank0::{Gpio16, Gpio17};
use hal::gpio::{FunctionI2C, Pin, PullUp};
use hal::i2c::I2C;
use hal::pac::I2C0;
use rp235x_hal as hal;

use super::Parts;

/// Clock of the converter, Hz.
pub const CLOCK_HZ: u32 = 4_915_200;
/// Clock of its bus, Hz, at most.
const I2C_HZ: u32 = 400_000;

/// The converter.
pub type Chip =
    OneChannel<I2C<I2C0, (Pin<Gpio16, FunctionI2C, PullUp>, Pin<Gpio17, FunctionI2C, PullUp>)>>;

/// The converter on its pins, which are pulled up; boards with it have pull-ups of their own.
pub fn chip(parts: Parts) -> Option<Chip> {
    let Parts { i2c, gp16, gp17, clocks, resets, .. } = parts;
    let system = clocks.system_clock.freq();
    let (sda, scl) = (gp16.reconfigure(), gp17.reconfigure());
    Some(OneChannel::new(I2C::new_controller(i2c, sda, scl, I2C_HZ.Hz(), resets, system)))
}
