//! What all models of parts have in common: registers, pins and a clock, as the emulator wants them.

use std::fmt::Debug;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};

use rsemu::core::device::{Device, DeviceClass, RealizeCtx, ResetKind, SinkPin};
use rsemu::core::sched::{AccessKind, LazyHandle};
use rsemu::core::space::{AccessConstraints, MemAttrs, MemOps, MemResult, Region, RegionRef};
use rsemu::core::value::{Endian, Width};
use rsemu::core::wire::{Level, WireId, WireSink, WireSource};
use rsemu::machine::{BindCtx, Instance};

/// No event is due.
const NEVER: u64 = u64::MAX;

/// The model of a part. What it does not have it leaves to the defaults.
pub trait Part: Debug + Send + Sync + 'static {
    /// Its name in the machine's description.
    fn class() -> &'static DeviceClass
    where
        Self: Sized;

    /// Bytes of address space that its registers take.
    fn window() -> u64
    where
        Self: Sized,
    {
        0x400
    }

    /// A register as it reads, without effect.
    fn peek(&self, _at: u64) -> u32 {
        0
    }

    /// The processor reads a register.
    fn read(&self, at: u64) -> u32 {
        self.peek(at)
    }

    /// The processor writes a register.
    fn write(&self, _at: u64, _value: u32) {}

    /// An input pin changes.
    fn input(&self, _pin: u32, _high: bool) {}

    /// Number of an input pin.
    fn input_named(&self, _port: &str) -> Option<u32> {
        None
    }

    /// What an output pin drives.
    fn connect(&self, _port: &str, _wire: WireSource) {}

    /// Drives the output pins anew.
    fn announce(&self) {}

    /// Its clock, if it has one.
    fn clock(&self) -> Option<&Clock> {
        None
    }

    /// Time has come to a tick of its clock.
    fn advance(&self, _to: u64) {}

    /// A reset of the whole chip, or power that comes.
    fn reset(&self, _kind: ResetKind) {}

    /// What it needs of other parts.
    ///
    /// # Errors
    /// The emulator's, where they are not there.
    fn bind(&self, _context: &BindCtx<'_>) -> rsemu::Result<()> {
        Ok(())
    }
}

/// Where a part stands in time, in ticks of its own clock.
#[derive(Debug)]
pub struct Clock {
    now: AtomicU64,
    next: AtomicU64,
    handle: Mutex<Option<LazyHandle>>,
}

impl Clock {
    /// At 0, with nothing due.
    #[must_use]
    pub const fn new() -> Self {
        Self { now: AtomicU64::new(0), next: AtomicU64::new(NEVER), handle: Mutex::new(None) }
    }

    /// The present tick.
    pub fn now(&self) -> u64 {
        self.now.load(Relaxed)
    }

    /// Comes to a tick.
    pub fn set(&self, now: u64) {
        self.now.fetch_max(now, Relaxed);
    }

    /// Says when the next event is due.
    pub fn due(&self, next: Option<u64>) {
        self.next.store(next.unwrap_or(NEVER), Relaxed);
    }

    /// Catches up with the processor, which looks at the part now.
    pub fn sync(&self) {
        let handle = self.handle.lock().unwrap().clone();
        if let Some(handle) = handle {
            let _ = handle.sync(AccessKind::Guest);
        }
    }
}

impl Default for Clock {
    fn default() -> Self {
        Self::new()
    }
}

/// Output pins: what each drives.
#[derive(Debug, Default)]
pub struct Wires(Mutex<Vec<(String, WireSource)>>);

impl Wires {
    /// One more.
    pub fn add(&self, port: &str, wire: WireSource) {
        self.0.lock().unwrap().push((port.to_owned(), wire));
    }

    /// Drives a pin.
    pub fn drive(&self, port: &str, high: bool) {
        let wires: Vec<_> = {
            let all = self.0.lock().unwrap();
            all.iter().filter(|(name, _)| name == port).map(|(_, wire)| wire.clone()).collect()
        };
        for wire in wires {
            if wire.level().as_bool() != high {
                wire.set(Level::from_bool(high));
            }
        }
    }
}

/// A part as the emulator takes it.
#[derive(Debug)]
pub struct Model<P> {
    part: Arc<P>,
    region: RegionRef,
    pins: Mutex<Vec<Arc<Pin<P>>>>,
}

impl<P: Part> Model<P> {
    /// The model of a part.
    pub fn new(part: Arc<P>) -> Self {
        let registers: Arc<dyn MemOps> = Arc::new(Registers(part.clone()));
        let region = Arc::new(Region::io(P::class().name, P::window(), registers));
        Self { part, region, pins: Mutex::default() }
    }
}

#[derive(Debug)]
struct Registers<P>(Arc<P>);

impl<P: Part> MemOps for Registers<P> {
    fn read(&self, at: u64, bytes: &mut [u8], attributes: MemAttrs) -> MemResult {
        let word = if attributes.debug { self.0.peek(at & !3) } else { self.0.read(at & !3) };
        let from = (at & 3) as usize;
        bytes.copy_from_slice(&word.to_le_bytes()[from..][..bytes.len()]);
        Ok(())
    }

    fn write(&self, at: u64, bytes: &[u8], _: MemAttrs) -> MemResult {
        let mut word = self.0.peek(at & !3).to_le_bytes();
        word[(at & 3) as usize..][..bytes.len()].copy_from_slice(bytes);
        self.0.write(at & !3, u32::from_le_bytes(word));
        Ok(())
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::ANY.with_widths(Width::U8, Width::U32).with_endian(Endian::Little)
    }
}

#[derive(Debug)]
struct Pin<P>(Arc<P>);

impl<P: Part> WireSink for Pin<P> {
    fn set_level(&self, _: WireId, pin: u32, level: Level) {
        self.0.input(pin, level.as_bool());
    }
}

impl<P: Part> Device for Model<P> {
    fn class(&self) -> &'static DeviceClass {
        P::class()
    }

    fn realize(&self, _: &mut RealizeCtx<'_>) -> rsemu::Result<()> {
        Ok(())
    }

    fn reset(&self, kind: ResetKind) {
        self.part.reset(kind);
    }

    fn region(&self, name: &str) -> Option<RegionRef> {
        name.is_empty().then(|| self.region.clone())
    }

    fn sink(&self, port: &str, _: &[WireId]) -> Option<SinkPin> {
        let line = self.part.input_named(port)?;
        let sink = Arc::new(Pin(self.part.clone()));
        self.pins.lock().unwrap().push(sink.clone());
        Some(SinkPin { sink, line })
    }

    fn connect(&self, port: &str, wire: WireSource) -> rsemu::Result<()> {
        self.part.connect(port, wire);
        Ok(())
    }

    fn announce(&self, _: &str) {
        self.part.announce();
    }

    fn is_lazy(&self) -> bool {
        self.part.clock().is_some()
    }

    fn current_tick(&self) -> u64 {
        self.part.clock().map_or(0, Clock::now)
    }

    fn advance_to(&self, tick: u64) {
        self.part.advance(tick);
    }

    fn next_event_tick(&self) -> Option<u64> {
        let next = self.part.clock()?.next.load(Relaxed);
        (next != NEVER).then_some(next)
    }

    fn attach_lazy(&self, handle: LazyHandle) {
        if let Some(clock) = self.part.clock() {
            *clock.handle.lock().unwrap() = Some(handle);
        }
    }
}

impl<P: Part> Instance for Model<P> {
    fn bind(&self, context: &BindCtx<'_>) -> rsemu::Result<()> {
        self.part.bind(context)
    }
}

/// The class of a part of ours; it is made by binding, never by name.
pub const fn class(name: &'static str, summary: &'static str) -> DeviceClass {
    DeviceClass {
        name,
        version: 1,
        summary,
        properties: &[],
        construct: |_| Err(rsemu::Error::Property("made by the board alone".into())),
    }
}
