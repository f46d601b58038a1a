//! The host's end of a USB cable: it sets the device up as an operating system does, and moves the bytes of its serial port.

use std::collections::VecDeque;

use crate::usb::PACKET;
use crate::{Board, MS};

/// Endpoints of the serial port, as the device describes them.
const TO_DEVICE: usize = 1;
const TO_HOST: usize = 2;
/// Most packets of full speed in a round: 19 bulk packets fit a frame of 1 ms (USB 2.0, table 5-9).
const PACKETS: usize = 1;
/// A round of the host's controller, ns.
pub const ROUND_NS: u64 = MS / 19;

/// Which line the host speaks over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Over {
    /// The adapter on the USART.
    #[default]
    Serial,
    /// The cable in the board's own socket.
    Usb,
}

/// What passed over the cable.
#[derive(Debug, Default)]
pub struct Cable {
    /// Bytes from the device.
    pub sent: Vec<u8>,
    /// Bytes to the device that wait for their turn.
    pub queue: VecDeque<u8>,
    /// Whether a program reads what comes.
    pub is_read: bool,
    /// Whether the device is set up.
    configured: bool,
}

impl Board {
    /// The cable is plugged in and the host sets the device up.
    ///
    /// # Panics
    /// If the device does not do as it must.
    pub fn plug_in(&mut self) {
        assert!(self.usb.is_connected(), "no device on the cable");
        self.cable = Cable { is_read: true, ..Cable::default() };
        self.usb.reset_bus();
        self.run_ns(MS);
        self.request([0, 5, 9, 0, 0, 0, 0, 0], &[]);
        assert_eq!(self.usb.address(), 9);
        self.request([0, 9, 1, 0, 0, 0, 0, 0], &[]);
        self.cable.configured = true;
        self.speak_over(Over::Usb);
    }

    /// A descriptor of the device.
    pub fn descriptor(&mut self, kind: u8, number: u8) -> Vec<u8> {
        // Texts are asked for in English.
        let [low, high] = if kind == 3 { [0x09, 0x04] } else { [0, 0] };
        assert!(self.usb.request([0x80, 6, number, kind, low, high, 0xff, 0]));
        let mut data = Vec::new();
        loop {
            let packet = self.packet().expect("a descriptor");
            data.extend_from_slice(&packet);
            if packet.len() < PACKET {
                break;
            }
        }
        assert!(self.usb.give(0, &[]));
        self.run_ns(MS);
        data
    }

    /// A program sets the speed of the port, and opens or closes it.
    pub fn set_port(&mut self, baud: u32, open: bool) {
        let coding = [&baud.to_le_bytes()[..], &[0, 0, 8]].concat();
        self.request([0x21, 0x20, 0, 0, 0, 0, 7, 0], &coding);
        self.request([0x21, 0x22, u8::from(open), 0, 0, 0, 0, 0], &[]);
    }

    /// A request with data for the device.
    fn request(&mut self, setup: [u8; 8], data: &[u8]) {
        assert!(self.usb.request(setup));
        self.run_ns(MS);
        if !data.is_empty() {
            assert!(self.usb.give(0, data));
        }
        assert_eq!(self.packet().as_deref(), Some(&[][..]), "{setup:02x?}");
        self.run_ns(MS);
    }

    /// The next packet of the control endpoint.
    fn packet(&mut self) -> Option<Vec<u8>> {
        for _ in 0..20 {
            self.run_ns(MS / 4);
            assert!(!self.usb.refuses());
            if let Some(packet) = self.usb.take(0) {
                return Some(packet);
            }
        }
        None
    }

    /// One round of the host's controller.
    pub(crate) fn move_packets(&mut self) {
        let Cable { sent, queue, is_read, configured } = &mut self.cable;
        if !*configured {
            return;
        }
        for _ in 0..PACKETS {
            if *is_read && let Some(packet) = self.usb.take(TO_HOST) {
                sent.extend(packet);
            }
            let length = queue.len().min(PACKET);
            let packet: Vec<u8> = queue.iter().take(length).copied().collect();
            if length > 0 && self.usb.give(TO_DEVICE, &packet) {
                queue.drain(..length);
            }
        }
    }
}
