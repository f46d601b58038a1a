//! A USART of the STM32F4 and the line to the host: byte times, one receive register, overrun, frames of another speed, requests for
//! bytes by DMA.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

use rsemu::core::device::{DeviceClass, ExportId, ResetKind};
use rsemu::core::wire::WireSource;
use rsemu::dev::stm32::rcc::{ClockOutput, Clocks};
use rsemu::machine::BindCtx;
use rsemu::machine::validate::{ClassSchema, PortDir};

use crate::part::{Clock, Part, Wires, class};

static USART: DeviceClass = class("palpate.usart", "USART of the STM32F4");
static LINE: DeviceClass = class("palpate.line", "the host's end of the line");

// Registers and bits, RM0090 §30.6.
const SR: u64 = 0x00;
const DR: u64 = 0x04;
const BRR: u64 = 0x08;
const CR1: u64 = 0x0c;
const CR3: u64 = 0x14;
const FE: u32 = 1 << 1;
const ORE: u32 = 1 << 3;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
const RE: u32 = 1 << 2;
const RXNEIE: u32 = 1 << 5;
const UE: u32 = 1 << 13;
const DMAT: u32 = 1 << 7;
/// EIE and DMAR: errors interrupt on their own only with both.
const ERRORS: u32 = 1 | 1 << 6;

/// Speed of the host's line, bits per second.
pub const BAUD: u64 = 1_000_000;
/// Of the clock of the host's line.
pub const LINE_HZ: u64 = 100_000_000;
const BYTE_TICKS: u64 = LINE_HZ * 10 / BAUD;
/// A receiver follows speeds that differ by so much.
const TOLERANCE: f64 = 0.04;

/// What passed over the line.
#[derive(Debug, Default)]
pub struct Wire {
    /// Bytes from the device.
    pub sent: Vec<u8>,
    /// Bytes to the device that wait for their turn.
    pub queue: VecDeque<u8>,
    /// Bytes that found the receive register full.
    pub overruns: u64,
    /// Bytes of another speed.
    pub misframed: u64,
    /// Bytes that came to the receiver.
    pub received: u64,
    /// A byte shall end between the next read of SR and the read of DR that follows it.
    pub overrun_at_worst: bool,
}

#[derive(Debug, Default)]
struct State {
    sr: u32,
    /// Errors that the last read of SR saw: a read of DR clears them.
    seen: u32,
    control: [u32; 3],
    brr: u32,
    received: u8,
    waiting: Option<u8>,
    /// The byte on the line, and when it ends.
    leaving: Option<(u8, u64)>,
}

/// The USART.
#[derive(Debug)]
pub struct Usart {
    state: Mutex<State>,
    wire: Mutex<Wire>,
    clock: Clock,
    pins: Wires,
    clocks: Mutex<Option<Arc<Clocks>>>,
}

impl Usart {
    /// After a reset.
    #[must_use]
    pub fn new() -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::new(State { sr: TXE | TC, ..State::default() }),
            wire: Mutex::default(),
            clock: Clock::new(),
            pins: Wires::default(),
            clocks: Mutex::default(),
        })
    }

    /// The line.
    pub fn wire(&self) -> MutexGuard<'_, Wire> {
        self.wire.lock().unwrap()
    }

    fn baud(&self, brr: u32) -> f64 {
        let clocks = self.clocks.lock().unwrap();
        let rate = clocks.as_ref().map_or(0.0, |clocks| {
            let rate = clocks.rate(ClockOutput::PCLK1);
            rate.num() as f64 / rate.den() as f64
        });
        rate / f64::from(brr.max(1))
    }

    /// A byte of the host has ended.
    fn receive(&self, mut byte: u8) {
        self.clock.sync();
        {
            let mut state = self.state.lock().unwrap();
            if state.control[0] & (UE | RE) != UE | RE {
                return;
            }
            let mut wire = self.wire();
            wire.received += 1;
            if (self.baud(state.brr) / BAUD as f64 - 1.0).abs() > TOLERANCE {
                state.sr |= FE;
                wire.misframed += 1;
                byte = byte.rotate_left(3) ^ 0x55;
            }
            if state.sr & RXNE == 0 {
                state.received = byte;
                state.sr |= RXNE;
            } else {
                state.sr |= ORE;
                wire.overruns += 1;
            }
        }
        self.interrupt();
    }

    fn interrupt(&self) {
        let (wanted, asks) = {
            let State { sr, control: [cr1, _, cr3], .. } = *self.state.lock().unwrap();
            let byte = sr & (RXNE | ORE) != 0 && cr1 & RXNEIE != 0;
            let error = sr & (ORE | FE) != 0 && cr3 & ERRORS == ERRORS;
            let sent = sr & cr1 & (TXE | TC) != 0;
            let is_on = cr1 & UE != 0;
            (is_on && (sent || byte || error), is_on && cr3 & DMAT != 0 && sr & TXE != 0)
        };
        self.pins.drive("irq", wanted);
        self.pins.drive("asks", asks);
    }

    fn load(&self, state: &mut State) {
        if state.leaving.is_none()
            && let Some(byte) = state.waiting.take()
        {
            let end = self.clock.now() + 10 * u64::from(state.brr.max(1));
            state.leaving = Some((byte, end));
            state.sr = state.sr & !TC | TXE;
        }
        self.clock.due(state.leaving.map(|(_, end)| end));
    }
}

impl Part for Usart {
    fn class() -> &'static DeviceClass {
        &USART
    }

    fn peek(&self, at: u64) -> u32 {
        let state = self.state.lock().unwrap();
        match at {
            SR => state.sr,
            DR => state.received.into(),
            BRR => state.brr,
            CR1..=CR3 => state.control[(at - CR1) as usize / 4],
            _ => 0,
        }
    }

    fn read(&self, at: u64) -> u32 {
        self.clock.sync();
        let value = self.peek(at);
        {
            let mut state = self.state.lock().unwrap();
            match at {
                SR => state.seen = state.sr & (ORE | FE),
                DR => {
                    let mut wire = self.wire();
                    if state.sr & RXNE != 0 && std::mem::take(&mut wire.overrun_at_worst) {
                        state.sr |= ORE;
                        wire.overruns += 1;
                    }
                    // Errors are cleared by a read of SR, then of DR (§30.6.1); one between the two stays.
                    state.sr &= !(RXNE | std::mem::take(&mut state.seen));
                }
                _ => {}
            }
        }
        self.interrupt();
        value
    }

    fn write(&self, at: u64, value: u32) {
        self.clock.sync();
        {
            let mut state = self.state.lock().unwrap();
            match at {
                SR => state.sr &= value | !(TC | RXNE),
                DR => {
                    state.waiting = Some(value as u8);
                    state.sr &= !(TXE | TC);
                    self.load(&mut state);
                }
                BRR => state.brr = value & 0xffff,
                CR1..=CR3 => state.control[(at - CR1) as usize / 4] = value,
                _ => {}
            }
        }
        self.interrupt();
    }

    fn connect(&self, port: &str, wire: WireSource) {
        self.pins.add(port, wire);
    }

    fn clock(&self) -> Option<&Clock> {
        Some(&self.clock)
    }

    fn advance(&self, to: u64) {
        loop {
            let mut state = self.state.lock().unwrap();
            let Some((byte, end)) = state.leaving.filter(|(_, end)| *end <= to) else { break };
            self.clock.set(end);
            self.wire().sent.push(byte);
            state.leaving = None;
            if state.waiting.is_none() {
                state.sr |= TC;
            }
            self.load(&mut state);
            drop(state);
            self.interrupt();
        }
        self.clock.set(to);
    }

    fn reset(&self, _: ResetKind) {
        *self.state.lock().unwrap() = State { sr: TXE | TC, ..State::default() };
        self.clock.due(None);
        self.interrupt();
    }

    fn bind(&self, context: &BindCtx<'_>) -> rsemu::Result<()> {
        let clocks = context.export_as::<Clocks>("rcc", ExportId::CLOCK_TREE)?;
        *self.clocks.lock().unwrap() = Some(clocks);
        Ok(())
    }
}

/// The host's transmitter: bytes back to back, each ten bits of its own oscillator.
#[derive(Debug)]
pub struct Line {
    to: Arc<Usart>,
    clock: Clock,
}

impl Line {
    /// To a USART.
    #[must_use]
    pub fn new(to: Arc<Usart>) -> Arc<Self> {
        Arc::new(Self { to, clock: Clock::new() })
    }

    /// Bytes that leave as soon as those before them have left.
    pub fn send(&self, bytes: &[u8]) {
        self.clock.sync();
        self.to.wire().queue.extend(bytes);
        self.clock.due(Some(self.next_end()));
    }

    /// End of the byte that the line carries or could carry next.
    fn next_end(&self) -> u64 {
        (self.clock.now() / BYTE_TICKS + 1) * BYTE_TICKS
    }
}

impl Part for Line {
    fn class() -> &'static DeviceClass {
        &LINE
    }

    fn clock(&self) -> Option<&Clock> {
        Some(&self.clock)
    }

    fn advance(&self, to: u64) {
        while self.next_end() <= to {
            let byte = self.to.wire().queue.pop_front();
            let Some(byte) = byte else { break };
            self.clock.set(self.next_end());
            self.to.receive(byte);
        }
        self.clock.set(to);
        let more = !self.to.wire().queue.is_empty();
        self.clock.due(more.then(|| self.next_end()));
    }
}

/// Pins of both.
pub fn schemas() -> [ClassSchema; 2] {
    let usart = ClassSchema::new(USART.name).region("");
    [usart.port("irq", PortDir::Out).port("asks", PortDir::Out), ClassSchema::new(LINE.name)]
}
