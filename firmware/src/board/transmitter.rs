//! The link's transmitter: DMA1 carries a frame byte by byte to the USART, so that a frame costs two interrupts and not one a byte.
//! Where there is no DMA, as on the board that QEMU emulates, each byte is carried by its interrupt.

use core::sync::atomic::{Ordering, fence};

use embedded_hal_nb::serial::Write;
use stm32f4xx_hal::pac::{DMA1, USART3, usart1::RegisterBlock as Registers};
use stm32f4xx_hal::rcc::{Enable, Rcc};
use stm32f4xx_hal::serial::{Tx, TxISR, TxListen};
use usb::Frame;

/// USART3_TX is channel 4 of this stream (RM0090, table 42).
const STREAM: usize = 3;
const CHANNEL: u8 = 4;

/// Sends frames, one after the other.
pub struct Transmitter {
    tx: Tx<USART3>,
    dma: Option<DMA1>,
    is_sending: bool,
    /// Bytes of the present frame that interrupts have carried.
    carried: usize,
}

impl Transmitter {
    /// Takes the transmitter and the DMA controller, if there is one.
    pub fn new(tx: Tx<USART3>, dma: DMA1, rcc: &mut Rcc) -> Self {
        DMA1::enable(rcc);
        let stream = dma.st(STREAM);
        let register = usart().dr().as_ptr() as u32;
        // SAFETY: the stream is off, and reaches nothing but the USART's register when it is on.
        stream.par().write(|w| unsafe { w.bits(register) });
        let has_dma = stream.par().read().bits() == register;
        usart().cr3().modify(|_, w| w.dmat().bit(has_dma));
        Self { tx, dma: has_dma.then_some(dma), is_sending: false, carried: 0 }
    }

    /// Goes on with a frame, or begins it; whether all of it was sent. Until then the frame must stay where it is. To be called
    /// again at the next interrupt of the USART.
    pub fn has_sent(&mut self, frame: &Frame) -> bool {
        match &self.dma {
            Some(dma) if self.is_sending => {
                self.is_sending = !is_done(dma);
                !self.is_sending
            }
            Some(dma) => {
                begin(dma, frame);
                self.is_sending = true;
                false
            }
            None => self.has_carried(frame),
        }
    }

    /// There is no frame to send.
    pub fn rest(&mut self) {
        if self.dma.is_none() {
            self.tx.unlisten();
        }
    }

    fn has_carried(&mut self, frame: &Frame) -> bool {
        // On a real line the register is full again after a byte or two, and its interrupt brings us back here.
        while self.tx.is_tx_empty() {
            let Some(byte) = frame.get(self.carried) else {
                self.carried = 0;
                return true;
            };
            self.carried += 1;
            let _ = self.tx.write(*byte);
            self.tx.listen();
        }
        false
    }
}

/// The registers of the USART.
fn usart() -> &'static Registers {
    // SAFETY: the interrupt of the line alone uses the transmitter, once it is made.
    unsafe { &*USART3::ptr() }
}

fn begin(dma: &DMA1, frame: &Frame) {
    dma.lifcr().write(|w| {
        w.ctcif3().clear().chtif3().clear().cteif3().clear().cdmeif3().clear().cfeif3().clear()
    });
    let stream = dma.st(STREAM);
    stream.ndtr().write(|w| w.ndt().set(frame.len() as u16));
    // SAFETY: the frame stays where it is until all of it was sent.
    stream.m0ar().write(|w| unsafe { w.bits(frame.as_ptr() as u32) });
    clear_complete();
    usart().cr1().modify(|_, w| w.tcie().enabled());
    // The bytes of the frame are in memory before the stream reads them.
    fence(Ordering::Release);
    stream.cr().write(|w| {
        w.chsel().set(CHANNEL).dir().memory_to_peripheral().minc().incremented().en().enabled()
    });
}

/// Whether the last byte has left the line. If the bus is busy, the line may be idle for an instant between two bytes too.
fn is_done(dma: &DMA1) -> bool {
    if usart().sr().read().tc().bit_is_clear() {
        return false;
    }
    if dma.st(STREAM).cr().read().en().is_enabled() {
        clear_complete();
        return false;
    }
    usart().cr1().modify(|_, w| w.tcie().disabled());
    true
}

/// TC: the line is idle.
const COMPLETE: u16 = 1 << 6;

fn clear_complete() {
    // SAFETY: flags that are written as one stay.
    usart().sr().write(|w| unsafe { w.bits(!COMPLETE) });
}
