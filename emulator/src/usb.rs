//! The USB core of the STM32F4 (OTG_FS) as a device, and the host at the other end of its cable: packets, the FIFOs between them
//! and the processor, and what the host asks of a serial port.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

use rsemu::core::device::{DeviceClass, ResetKind};
use rsemu::core::wire::WireSource;
use rsemu::machine::validate::{ClassSchema, PortDir};

use crate::part::{Part, Wires, class};

static CORE: DeviceClass = class("palpate.usb", "OTG_FS as a device");

/// Most bytes of a packet.
pub const PACKET: usize = 64;
const ENDPOINTS: usize = 4;
/// Words of all FIFOs.
const FIFO_WORDS: usize = 320;

// Registers and bits, RM0090 §34.16.
const GAHBCFG: u64 = 0x008;
const GRSTCTL: u64 = 0x010;
const GINTSTS: u64 = 0x014;
const GINTMSK: u64 = 0x018;
const GRXSTSR: u64 = 0x01c;
const GRXSTSP: u64 = 0x020;
const GRXFSIZ: u64 = 0x024;
const GCCFG: u64 = 0x038;
const CID: u64 = 0x03c;
const DCFG: u64 = 0x800;
const DCTL: u64 = 0x804;
const DIEPMSK: u64 = 0x810;
const DAINT: u64 = 0x818;
const DAINTMSK: u64 = 0x81c;
const IN: u64 = 0x900;
const OUT: u64 = 0xb00;
const FIFO: u64 = 0x1000;
const CONTROL: u64 = 0x00;
const INTERRUPT: u64 = 0x08;
const SIZE: u64 = 0x10;
const FIFO_STATUS: u64 = 0x18;

const AHB_IDLE: u32 = 1 << 31;
const FLUSHES: u32 = 1 << 4 | 1 << 5;
const RXFLVL: u32 = 1 << 4;
const USBRST: u32 = 1 << 12;
const ENUMDNE: u32 = 1 << 13;
const IEPINT: u32 = 1 << 18;
const XFRC: u32 = 1;
const POWERED: u32 = 1 << 16;
const SOFT_DISCONNECT: u32 = 1 << 1;
const EPENA: u32 = 1 << 31;
const EPDIS: u32 = 1 << 30;
const SNAK: u32 = 1 << 27;
const CNAK: u32 = 1 << 26;
const STALL: u32 = 1 << 21;
const NAKSTS: u32 = 1 << 17;

// What an entry of the receive FIFO is (PKTSTS).
const OUT_RECEIVED: u32 = 2;
const OUT_DONE: u32 = 3;
const SETUP_DONE: u32 = 4;
const SETUP_RECEIVED: u32 = 6;

#[derive(Debug)]
struct State {
    answers: bool,
    registers: VecDeque<(u64, u32)>,
    interrupts: u32,
    entries: VecDeque<u32>,
    words: VecDeque<u32>,
    to_host: [Vec<u8>; ENDPOINTS],
    in_control: [u32; ENDPOINTS],
    in_interrupt: [u32; ENDPOINTS],
    in_size: [u32; ENDPOINTS],
    out_control: [u32; ENDPOINTS],
}

impl State {
    fn new(answers: bool) -> Self {
        Self {
            answers,
            registers: VecDeque::new(),
            interrupts: 0,
            entries: VecDeque::new(),
            words: VecDeque::new(),
            to_host: Default::default(),
            in_control: [0; ENDPOINTS],
            in_interrupt: [0; ENDPOINTS],
            in_size: [0; ENDPOINTS],
            out_control: [NAKSTS; ENDPOINTS],
        }
    }

    /// A register that keeps what is written.
    fn kept(&self, at: u64) -> u32 {
        self.registers.iter().find(|(place, _)| *place == at).map_or(0, |(_, value)| *value)
    }

    fn keep(&mut self, at: u64, value: u32) {
        self.registers.retain(|(place, _)| *place != at);
        self.registers.push_back((at, value));
    }

    fn endpoints(&self) -> u32 {
        let all = self.in_interrupt.iter().enumerate();
        let mask = self.kept(DIEPMSK);
        all.fold(0, |all, (at, flags)| all | u32::from(flags & mask != 0) << at)
    }

    fn status(&self) -> u32 {
        let received = if self.entries.is_empty() { 0 } else { RXFLVL };
        let given = if self.endpoints() & self.kept(DAINTMSK) == 0 { 0 } else { IEPINT };
        self.interrupts | received | given
    }

    fn interrupts(&self) -> bool {
        self.kept(GAHBCFG) & 1 != 0 && self.status() & self.kept(GINTMSK) != 0
    }

    fn is_connected(&self) -> bool {
        self.kept(GCCFG) & POWERED != 0 && self.kept(DCTL) & SOFT_DISCONNECT == 0
    }

    fn has_room(&self, bytes: usize) -> bool {
        self.entries.len() + self.words.len() + bytes.div_ceil(4) + 2 <= self.kept(GRXFSIZ) as usize
    }

    fn receive(&mut self, endpoint: usize, packet: &[u8], kinds: [u32; 2]) {
        let [data, done] = kinds.map(|kind| kind << 17 | endpoint as u32);
        self.entries.push_back(data | (packet.len() as u32) << 4);
        for bytes in packet.chunks(4) {
            let mut word = [0; 4];
            word[..bytes.len()].copy_from_slice(bytes);
            self.words.push_back(u32::from_le_bytes(word));
        }
        self.entries.push_back(done);
    }
}

/// The core.
#[derive(Debug)]
pub struct Usb {
    state: Mutex<State>,
    pins: Wires,
}

impl Usb {
    /// With nothing at the cable's other end; a core that does not answer reads zero everywhere.
    #[must_use]
    pub fn new(answers: bool) -> Arc<Self> {
        Arc::new(Self { state: Mutex::new(State::new(answers)), pins: Wires::default() })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap()
    }

    fn with<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        let result = change(&mut self.state());
        let wanted = self.state().interrupts();
        self.pins.drive("irq", wanted);
        result
    }

    /// Whether the device shows itself on the cable.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.state().is_connected()
    }

    /// Address that the device has taken.
    #[must_use]
    pub fn address(&self) -> u32 {
        self.state().kept(DCFG) >> 4 & 0x7f
    }

    /// The host resets the bus.
    pub fn reset_bus(&self) {
        self.with(|state| {
            state.entries.clear();
            state.words.clear();
            state.to_host = Default::default();
            state.interrupts |= USBRST | ENUMDNE;
        });
    }

    /// The host begins a request; whether the device took it, which it must.
    pub fn request(&self, setup: [u8; 8]) -> bool {
        self.with(|state| {
            let fits = state.has_room(setup.len());
            if fits {
                state.receive(0, &setup, [SETUP_RECEIVED, SETUP_DONE]);
                state.in_control[0] &= !STALL;
            }
            fits
        })
    }

    /// The host gives a packet; whether the device took it.
    pub fn give(&self, endpoint: usize, packet: &[u8]) -> bool {
        self.with(|state| {
            let control = state.out_control[endpoint];
            let takes =
                control & EPENA != 0 && control & NAKSTS == 0 && state.has_room(packet.len());
            if takes {
                state.receive(endpoint, packet, [OUT_RECEIVED, OUT_DONE]);
                state.out_control[endpoint] = control & !EPENA | NAKSTS;
            }
            takes
        })
    }

    /// The host takes a packet.
    pub fn take(&self, endpoint: usize) -> Option<Vec<u8>> {
        self.with(|state| {
            let size = (state.in_size[endpoint] & 0x7_ffff) as usize;
            let waits = state.in_control[endpoint] & EPENA != 0
                && state.to_host[endpoint].len() >= size.next_multiple_of(4);
            if !waits {
                return None;
            }
            let mut packet = std::mem::take(&mut state.to_host[endpoint]);
            packet.truncate(size);
            state.in_control[endpoint] &= !EPENA;
            state.in_size[endpoint] = 0;
            state.in_interrupt[endpoint] |= XFRC;
            Some(packet)
        })
    }

    /// Whether the device refuses the request.
    #[must_use]
    pub fn refuses(&self) -> bool {
        self.state().in_control[0] & STALL != 0
    }
}

/// Which endpoint's register this is.
fn endpoint(at: u64, base: u64) -> Option<(usize, u64)> {
    let at = at.checked_sub(base).filter(|at| *at < 0x20 * ENDPOINTS as u64)?;
    Some(((at / 0x20) as usize, at % 0x20))
}

impl Part for Usb {
    fn class() -> &'static DeviceClass {
        &CORE
    }

    fn window() -> u64 {
        0x5000
    }

    fn peek(&self, at: u64) -> u32 {
        let state = self.state();
        if !state.answers {
            return 0;
        }
        if let Some((index, register)) = endpoint(at, IN) {
            return match register {
                CONTROL => state.in_control[index],
                INTERRUPT => state.in_interrupt[index],
                SIZE => state.in_size[index],
                FIFO_STATUS => (PACKET - state.to_host[index].len().min(PACKET)) as u32 / 4,
                _ => 0,
            };
        }
        if let Some((index, register)) = endpoint(at, OUT) {
            return if register == CONTROL { state.out_control[index] } else { 0 };
        }
        match at {
            GRSTCTL => AHB_IDLE,
            GINTSTS => state.status(),
            GRXSTSR | GRXSTSP => state.entries.front().copied().unwrap_or(0),
            CID => 0x1200,
            DAINT => state.endpoints(),
            FIFO.. => state.words.front().copied().unwrap_or(0),
            _ => state.kept(at),
        }
    }

    fn read(&self, at: u64) -> u32 {
        let value = self.peek(at);
        self.with(|state| match at {
            GRXSTSP => {
                state.entries.pop_front();
            }
            FIFO.. => {
                state.words.pop_front();
            }
            _ => {}
        });
        value
    }

    fn write(&self, at: u64, value: u32) {
        self.with(|state| {
            if let Some((index, register)) = endpoint(at, IN) {
                match register {
                    CONTROL => {
                        let disabled = if value & EPDIS != 0 { EPENA } else { 0 };
                        state.in_control[index] = value & !(CNAK | SNAK | EPDIS | disabled);
                    }
                    INTERRUPT => state.in_interrupt[index] &= !value,
                    SIZE => state.in_size[index] = value,
                    _ => {}
                }
            } else if let Some((index, CONTROL)) = endpoint(at, OUT) {
                let before = state.out_control[index] & NAKSTS;
                let nak = match (value & SNAK != 0, value & CNAK != 0) {
                    (true, _) => NAKSTS,
                    (_, true) => 0,
                    _ => before,
                };
                let disabled = if value & EPDIS != 0 { EPENA } else { 0 };
                state.out_control[index] = value & !(CNAK | SNAK | EPDIS | NAKSTS | disabled) | nak;
            } else {
                match at {
                    GINTSTS => state.interrupts &= !value,
                    GRSTCTL => flush(state, value),
                    GRXFSIZ => state.keep(at, value.min(FIFO_WORDS as u32)),
                    FIFO.. => {
                        let index = ((at - FIFO) / FIFO) as usize;
                        if let Some(fifo) = state.to_host.get_mut(index) {
                            fifo.extend(value.to_le_bytes());
                        }
                    }
                    _ => state.keep(at, value),
                }
            }
        });
    }

    fn connect(&self, port: &str, wire: WireSource) {
        self.pins.add(port, wire);
    }

    fn reset(&self, _: ResetKind) {
        self.with(|state| *state = State::new(state.answers));
    }
}

/// Empties FIFOs: that of reception, one of transmission or (number 16) all of them.
fn flush(state: &mut State, value: u32) {
    if value & FLUSHES & 1 << 4 != 0 {
        state.entries.clear();
        state.words.clear();
    }
    if value & FLUSHES & 1 << 5 != 0 {
        match (value >> 6 & 31) as usize {
            16 => state.to_host = Default::default(),
            index => {
                if let Some(fifo) = state.to_host.get_mut(index) {
                    fifo.clear();
                }
            }
        }
    }
}

/// Its pins.
pub fn schema() -> ClassSchema {
    ClassSchema::new(CORE.name).region("").port("irq", PortDir::Out)
}
