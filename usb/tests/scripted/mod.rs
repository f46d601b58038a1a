//! A bus that a test drives: the host's side of USB as calls, with packets that wait where hardware lets them wait, one for each
//! endpoint and direction.

use std::sync::{Arc, Mutex, MutexGuard};

use usb_device::bus::{PollResult, UsbBus};
use usb_device::endpoint::{EndpointAddress, EndpointType};
use usb_device::{Result, UsbDirection, UsbError};

const ENDPOINTS: usize = 4;

/// What is on its way on the wires.
#[derive(Debug, Default)]
pub struct Wires {
    /// A packet of the host that the device has not read.
    from_host: [Option<Vec<u8>>; ENDPOINTS],
    /// Whether the packet on endpoint 0 begins a request.
    is_setup: bool,
    /// A packet of the device that the host has not taken.
    to_host: [Option<Vec<u8>>; ENDPOINTS],
    /// Endpoints whose packet was taken since the last look.
    taken: u16,
    reset: bool,
    /// The host lets the bus sleep, or wakes it.
    sleep: Option<bool>,
    /// Endpoints that are set up, both directions.
    allocated: [usize; 2],
    /// Endpoints, from the device, that refuse.
    stalled: [bool; ENDPOINTS],
    /// The address that the host gave.
    pub address: u8,
}

/// The device's side.
#[derive(Clone, Debug, Default)]
pub struct Bus(Arc<Mutex<Wires>>);

impl Bus {
    /// The wires, to look at.
    pub fn wires(&self) -> MutexGuard<'_, Wires> {
        self.0.lock().unwrap()
    }

    /// The host resets the bus: what was on its way is gone.
    pub fn reset_by_host(&self) {
        let mut wires = self.wires();
        let allocated = wires.allocated;
        *wires = Wires { reset: true, allocated, ..Wires::default() };
    }

    /// The host lets the bus sleep, or wakes it.
    pub fn let_sleep(&self, asleep: bool) {
        self.wires().sleep = Some(asleep);
    }

    /// The host begins a request.
    pub fn request(&self, setup: [u8; 8]) {
        let mut wires = self.wires();
        (wires.from_host[0], wires.is_setup) = (Some(setup.into()), true);
        wires.stalled[0] = false;
    }

    /// The host gives a packet; not while the last one was not read.
    pub fn give(&self, endpoint: usize, packet: &[u8]) -> bool {
        let mut wires = self.wires();
        let is_free = wires.from_host[endpoint].is_none();
        if is_free {
            wires.from_host[endpoint] = Some(packet.into());
        }
        is_free
    }

    /// The host takes a packet.
    pub fn take(&self, endpoint: usize) -> Option<Vec<u8>> {
        let mut wires = self.wires();
        let packet = wires.to_host[endpoint].take();
        wires.taken |= u16::from(packet.is_some()) << endpoint;
        packet
    }

    /// Whether the device refuses the request.
    pub fn refuses(&self) -> bool {
        self.wires().stalled[0]
    }
}

impl UsbBus for Bus {
    fn alloc_ep(
        &mut self,
        direction: UsbDirection,
        address: Option<EndpointAddress>,
        _: EndpointType,
        _: u16,
        _: u8,
    ) -> Result<EndpointAddress> {
        let mut wires = self.wires();
        let next = &mut wires.allocated[usize::from(direction == UsbDirection::In)];
        let index = address.map_or_else(|| (*next).max(1), |wanted| wanted.index());
        *next = index + 1;
        if index < ENDPOINTS {
            Ok(EndpointAddress::from_parts(index, direction))
        } else {
            Err(UsbError::EndpointOverflow)
        }
    }

    fn enable(&mut self) {}

    fn reset(&self) {}

    fn set_device_address(&self, address: u8) {
        self.wires().address = address;
    }

    fn write(&self, endpoint: EndpointAddress, packet: &[u8]) -> Result<usize> {
        let place = &mut self.wires().to_host[endpoint.index()];
        if place.is_some() {
            return Err(UsbError::WouldBlock);
        }
        *place = Some(packet.into());
        Ok(packet.len())
    }

    fn read(&self, endpoint: EndpointAddress, room: &mut [u8]) -> Result<usize> {
        let mut wires = self.wires();
        let packet = wires.from_host[endpoint.index()].take().ok_or(UsbError::WouldBlock)?;
        if endpoint.index() == 0 {
            wires.is_setup = false;
        }
        room.get_mut(..packet.len()).ok_or(UsbError::BufferOverflow)?.copy_from_slice(&packet);
        Ok(packet.len())
    }

    fn set_stalled(&self, endpoint: EndpointAddress, stalled: bool) {
        self.wires().stalled[endpoint.index()] = stalled;
    }

    fn is_stalled(&self, endpoint: EndpointAddress) -> bool {
        self.wires().stalled[endpoint.index()]
    }

    fn suspend(&self) {}

    fn resume(&self) {}

    fn poll(&self) -> PollResult {
        let mut wires = self.wires();
        if std::mem::take(&mut wires.reset) {
            return PollResult::Reset;
        }
        match wires.sleep.take() {
            Some(true) => return PollResult::Suspend,
            Some(false) => return PollResult::Resume,
            None => {}
        }
        let waiting = (0..ENDPOINTS).filter(|at| wires.from_host[*at].is_some());
        let ep_out = waiting.fold(0, |all, at| all | 1 << at);
        let ep_setup = u16::from(wires.is_setup);
        let ep_in_complete = std::mem::take(&mut wires.taken);
        if ep_out | ep_setup | ep_in_complete == 0 {
            return PollResult::None;
        }
        PollResult::Data { ep_out: ep_out & !ep_setup, ep_in_complete, ep_setup }
    }
}
