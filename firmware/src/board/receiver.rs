//! The link's receiver, by its registers: what the driver of the HAL does not tell, and must be told here, is what was lost.

use stm32f4xx_hal::pac::USART3;

/// What the receiver had.
#[derive(Clone, Copy, Default)]
pub struct Received {
    /// A byte.
    pub byte: Option<u8>,
    /// Bytes that were lost on the line.
    pub lost: u32,
}

/// Takes what the receiver has. Both registers are always read: an overrun may stand alone, without a byte, and interrupts
/// until they are (RM0090 §30.6.1).
pub fn take() -> Received {
    // SAFETY: the interrupt of the line alone reads these registers, and nothing else of them is written here.
    let usart = unsafe { &*USART3::ptr() };
    let status = usart.sr().read();
    let is_new = status.rxne().bit_is_set();
    let has_overrun = status.ore().bit_is_set();
    if !is_new && !has_overrun {
        return Received::default();
    }
    let byte = usart.dr().read().dr().bits() as u8;
    let is_whole = status.fe().bit_is_clear() && status.nf().bit_is_clear();
    let damaged = is_new && !is_whole;
    Received {
        byte: (is_new && is_whole).then_some(byte),
        lost: u32::from(has_overrun) + u32::from(damaged),
    }
}
