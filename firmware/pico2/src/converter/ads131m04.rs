//! The ADS131M04 on SPI0, with its clock from the board.

use device::converters::FourChannels;
use embedded_hal::digital::OutputPin;
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use hal::Clock;
use hal::fugit::RateExtU32;
use hal::gpio::bank0::{Gpio16, Gpio17, Gpio18, Gpio19, Gpio20};
use hal::gpio::{FunctionClock, FunctionSioOutput, FunctionSpi, Pin, PullDown, PullNone};
use hal::pac::SPI0;
use hal::spi::Enabled;
use rp235x_hal as hal;

use super::Parts;

/// Clock of the converter, Hz.
pub const CLOCK_HZ: u32 = 8_000_000;
/// Clock of its bus, Hz.
const SPI_HZ: u32 = 10_000_000;

type Spi = hal::Spi<
    Enabled,
    SPI0,
    (
        Pin<Gpio19, FunctionSpi, PullNone>,
        Pin<Gpio16, FunctionSpi, PullDown>,
        Pin<Gpio18, FunctionSpi, PullNone>,
    ),
    8,
>;
type Select = Pin<Gpio17, FunctionSioOutput, PullNone>;

/// The converter.
pub type Chip =
    FourChannels<ExclusiveDevice<Spi, Select, NoDelay>, Pin<Gpio20, FunctionSioOutput, PullNone>>;

/// The converter on its pins; none where the board cannot clock it.
pub fn chip(parts: Parts) -> Option<Chip> {
    let Parts { spi, gp16, gp17, gp18, gp19, gp20, gp21, clocks, resets, .. } = parts;
    // Its clock must run before the converter is spoken to.
    clocks.gpio_output0_clock.configure_clock(&clocks.usb_clock, CLOCK_HZ.Hz()).ok()?;
    let _clkin = gp21.into_function::<FunctionClock>();
    let spi = hal::Spi::<_, _, _, 8>::new(
        spi,
        (gp19.reconfigure(), gp16.reconfigure(), gp18.reconfigure()),
    )
    .init(resets, clocks.peripheral_clock.freq(), SPI_HZ.Hz(), ads131m04::SPI_MODE);
    let mut select: Select = gp17.reconfigure();
    let Ok(()) = select.set_high();
    let Ok(bus) = ExclusiveDevice::new_no_delay(spi, select);
    Some(FourChannels::new(bus, gp20.reconfigure(), CLOCK_HZ))
}
