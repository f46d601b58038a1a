//! The two lines to a host: the serial line and USB. Frames go to the one over which a host last said something.

use core::sync::atomic::{AtomicBool, Ordering};

use heapless::spsc::{Consumer, Producer};
use shared::wire::Accumulator;
use usb::Frame;

/// A line to a host.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// The USART.
    Serial,
    /// The socket.
    Usb,
}

static IS_USB: AtomicBool = AtomicBool::new(false);

/// Notes that a host said something over this line.
pub fn speak_over(line: Line) {
    IS_USB.store(line == Line::Usb, Ordering::Relaxed);
}

/// The line over which a host last said something.
pub fn spoken_over() -> Line {
    if IS_USB.load(Ordering::Relaxed) { Line::Usb } else { Line::Serial }
}

/// Bytes of a host, and the frame they are part of.
pub struct Inlet {
    /// The line that they come from.
    pub line: Line,
    /// The bytes.
    pub bytes: Consumer<'static, u8>,
    /// Cuts them into frames.
    pub cut: Accumulator,
}

impl Inlet {
    /// Of a line.
    pub const fn new(line: Line, bytes: Consumer<'static, u8>) -> Self {
        Self { line, bytes, cut: Accumulator::new() }
    }
}

/// Where frames wait for their line.
pub struct Outlets {
    /// For the USART.
    pub serial: Producer<'static, Frame>,
    /// For the socket.
    pub usb: Producer<'static, Frame>,
}

impl Outlets {
    /// That of the line over which a host last said something.
    pub fn now(&mut self) -> &mut Producer<'static, Frame> {
        match spoken_over() {
            Line::Serial => &mut self.serial,
            Line::Usb => &mut self.usb,
        }
    }
}
