//! The board's own USB socket: the chip's USB core, which wants a clock of 48 MHz that is right to 0.25 % (USB 2.0, §7.1.11). Only
//! the crystal gives one; without it, or where the core does not answer, there is the serial line alone.

use stm32f4xx_hal::gpio::{PA11, PA12};
use stm32f4xx_hal::otg_fs::{USB, UsbBus, UsbBusType};
use stm32f4xx_hal::pac::{OTG_FS_DEVICE, OTG_FS_GLOBAL, OTG_FS_PWRCLK};
use stm32f4xx_hal::rcc::{Enable, Rcc};
use usb_device::bus::UsbBusAllocator;

/// Words of memory for packets of the host: one for requests, one of data.
pub const WORDS: usize = 2 * usb::PACKET / 4;
/// Reads of a ready bit before the core counts as one that does not answer.
const PATIENCE: u32 = 10_000;

/// Registers of the core.
type Core = (OTG_FS_GLOBAL, OTG_FS_DEVICE, OTG_FS_PWRCLK);

/// The bus behind the socket, if there is one.
pub fn start(
    core: Core,
    pins: (PA11, PA12),
    memory: &'static mut [u32],
    rcc: &mut Rcc,
) -> Option<UsbBusAllocator<UsbBusType>> {
    if !rcc.clocks.is_pll48clk_valid() || !answers(&core.0, rcc) {
        return None;
    }
    Some(UsbBus::new(USB::new(core, pins, &rcc.clocks), memory))
}

/// Whether the core is there and its bus at rest, for which its driver would wait for ever.
fn answers(global: &OTG_FS_GLOBAL, rcc: &mut Rcc) -> bool {
    OTG_FS_GLOBAL::enable(rcc);
    let is_there = global.cid().read().bits() != 0;
    is_there && (0..PATIENCE).any(|_| global.grstctl().read().ahbidl().bit_is_set())
}
