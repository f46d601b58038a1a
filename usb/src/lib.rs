//! The fingertip on USB: a serial port (CDC-ACM) that carries the same frames as the serial line, over the bus of any
//! microcontroller for which there is a [`UsbBus`].
//!
//! USB holds a sender back where a serial line loses bytes: a packet of the host stays in the hardware until the queue has room
//! for it, and a frame stays in its queue until the host takes it, so nothing is lost here. What finds no room in front of that
//! queue is counted there.
//!
//! A host that opens the port at 1200 baud and closes it asks for the loader, as boards of the Arduino family have it.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![deny(
    clippy::arithmetic_side_effects,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable
)]

use core::str;

use heapless::Vec;
use heapless::spsc::{Consumer, Producer};
use shared::wire::{FRAME_MAX, USB_MAKER, USB_NAME, USB_PRODUCT, USB_VENDOR};
use usb_device::bus::{UsbBus, UsbBusAllocator};
use usb_device::device::{
    StringDescriptors, UsbDevice, UsbDeviceBuilder, UsbDeviceState, UsbRev, UsbVidPid,
};
use usbd_serial::CdcAcmClass;

/// Most bytes of a packet, the most that full speed has for bulk transfers (USB 2.0, §5.8.3).
pub const PACKET: usize = 64;
/// Speed of a port that is opened to ask for the loader.
const TOUCH_BAUD: u32 = 1_200;
/// Most current that the board takes from the socket, mA.
const MOST_MA: usize = 250;
/// The bus is asked so often, at most, in one [`UsbLine::poll`]: it tells one thing at a time.
const TURNS: usize = 16;

/// A frame on its way to the host.
pub type Frame = Vec<u8, FRAME_MAX>;

/// 96 bits in hexadecimal digits.
#[derive(Clone, Copy, Debug)]
pub struct SerialNumber([u8; 24]);

impl SerialNumber {
    /// The serial number of a chip as the host writes it, too.
    #[must_use]
    pub fn new(serial: [u32; 3]) -> Self {
        let mut digits = [b'0'; 24];
        let nibbles = serial.into_iter().flat_map(|word| {
            (0..8_u32).rev().map(move |at| word.wrapping_shr(at.saturating_mul(4)))
        });
        for (place, nibble) in digits.iter_mut().zip(nibbles) {
            *place = char::from_digit(nibble & 15, 16).map_or(b'0', |digit| digit as u8);
        }
        Self(digits)
    }

    /// Its text.
    #[must_use]
    pub fn text(&self) -> &str {
        str::from_utf8(&self.0).unwrap_or_default()
    }
}

/// What a look at the bus did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Polled {
    /// Bytes of the host came.
    pub received: bool,
    /// The queue of frames has more room than before.
    pub sent: bool,
    /// The queue of bytes has no room for a packet: the host is held back until it has, and then wants another look.
    pub held_back: bool,
    /// The host asks for the loader.
    pub touched: bool,
}

/// A serial port on USB.
pub struct UsbLine<'b, B: UsbBus> {
    device: UsbDevice<'b, B>,
    port: CdcAcmClass<'b, B>,
    /// Bytes of the first frame of the queue that were given to the bus.
    given: usize,
    /// Whether the last packet was a full one: the host takes what follows for more of the same until a shorter one comes.
    is_open_ended: bool,
    /// Whether a program has the port open, as far as it says.
    is_open: bool,
}

impl<'b, B: UsbBus> UsbLine<'b, B> {
    /// Appears on the bus; none if the bus has no room for it.
    pub fn new(bus: &'b UsbBusAllocator<B>, serial: &'b SerialNumber) -> Option<Self> {
        let port = CdcAcmClass::new(bus, PACKET as u16);
        let strings = StringDescriptors::default()
            .manufacturer(USB_MAKER)
            .product(USB_NAME)
            .serial_number(serial.text());
        let device = UsbDeviceBuilder::new(bus, UsbVidPid(USB_VENDOR, USB_PRODUCT))
            .usb_rev(UsbRev::Usb200)
            .composite_with_iads()
            .max_packet_size_0(PACKET as u8)
            .and_then(|it| it.max_power(MOST_MA))
            .and_then(|it| it.strings(&[strings]))
            .ok()?
            .build();
        Some(Self { device, port, given: 0, is_open_ended: false, is_open: false })
    }

    /// Whether a host has set it up.
    #[must_use]
    pub fn is_configured(&self) -> bool {
        self.device.state() == UsbDeviceState::Configured
    }

    /// Answers the bus: bytes of the host into one queue, frames for it out of the other. To be called on every interrupt of the
    /// bus, when there is a frame, and when there is room for bytes again.
    pub fn poll(
        &mut self,
        bytes: &mut Producer<'_, u8>,
        frames: &mut Consumer<'_, Frame>,
    ) -> Polled {
        let mut polled = Polled::default();
        for _ in 0..TURNS {
            let news = self.device.poll(&mut [&mut self.port]);
            polled.touched |= self.notice_touch();
            match self.device.state() {
                UsbDeviceState::Configured => {
                    polled.received |= self.receive(bytes);
                    polled.sent |= self.send(frames);
                }
                // It goes on where it was.
                UsbDeviceState::Suspend => {}
                // What the host has of a frame it has forgotten; it gets all of it.
                UsbDeviceState::Default | UsbDeviceState::Addressed => {
                    (self.given, self.is_open_ended) = (0, false);
                }
            }
            if !news || polled.touched {
                break;
            }
        }
        polled.held_back = !has_room(bytes);
        polled
    }

    /// Whether the port was opened at 1200 baud and is closed now.
    fn notice_touch(&mut self) -> bool {
        let was_open = core::mem::replace(&mut self.is_open, self.port.dtr());
        was_open && !self.is_open && self.port.line_coding().data_rate() == TOUCH_BAUD
    }

    /// Takes packets while there is room for whole ones.
    fn receive(&mut self, bytes: &mut Producer<'_, u8>) -> bool {
        let mut packet = [0; PACKET];
        let mut any = false;
        while has_room(bytes) {
            let Ok(length) = self.port.read_packet(&mut packet) else { break };
            for byte in packet.into_iter().take(length) {
                // There is room.
                any |= bytes.enqueue(byte).is_ok();
            }
        }
        any
    }

    /// Gives packets while the bus takes them: whether a frame left the queue.
    fn send(&mut self, frames: &mut Consumer<'_, Frame>) -> bool {
        let mut any = false;
        loop {
            let rest = frames.peek().and_then(|frame| frame.get(self.given..));
            let Some(rest) = rest else {
                if self.is_open_ended && self.port.write_packet(&[]).is_ok() {
                    self.is_open_ended = false;
                }
                return any;
            };
            let packet = rest.get(..PACKET).unwrap_or(rest);
            if self.port.write_packet(packet).is_err() {
                return any;
            }
            self.is_open_ended = packet.len() == PACKET;
            self.given = self.given.saturating_add(packet.len());
            if packet.len() == rest.len() {
                self.given = 0;
                any |= frames.dequeue().is_some();
            }
        }
    }
}

fn has_room(bytes: &Producer<'_, u8>) -> bool {
    bytes.capacity().saturating_sub(bytes.len()) >= PACKET
}
