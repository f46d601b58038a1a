//! Half-words and bytes for a peripheral of the emulator that takes words only: RM0090 allows all of them.

use std::sync::Arc;

use rsemu::core::device::{Device, DeviceClass, RealizeCtx, ResetKind, SinkPin};
use rsemu::core::sched::LazyHandle;
use rsemu::core::space::{
    AccessConstraints, AddressSpace, MemAttrs, MemOps, MemResult, Region, RegionRef,
};
use rsemu::core::value::{Endian, Width};
use rsemu::core::wire::{WireId, WireSource};
use rsemu::machine::{BindCtx, Instance};

#[derive(Debug)]
struct Words(AddressSpace);

impl MemOps for Words {
    fn read(&self, at: u64, bytes: &mut [u8], attributes: MemAttrs) -> MemResult {
        let word = self.0.read(at & !3, Width::U32, attributes)? as u32;
        bytes.copy_from_slice(&word.to_le_bytes()[(at & 3) as usize..][..bytes.len()]);
        Ok(())
    }

    fn write(&self, at: u64, bytes: &[u8], attributes: MemAttrs) -> MemResult {
        let mut word = [0; 4];
        word[(at & 3) as usize..][..bytes.len()].copy_from_slice(bytes);
        self.0.write(at & !3, Width::U32, u32::from_le_bytes(word).into(), attributes)
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::ANY.with_widths(Width::U8, Width::U32).with_endian(Endian::Little)
    }
}

/// The peripheral with its registers within reach of every width.
#[derive(Debug)]
pub struct Widened(Arc<dyn Instance>, RegionRef);

impl Widened {
    /// Around a peripheral.
    pub fn new(inner: Arc<dyn Instance>) -> Self {
        let space = AddressSpace::new("widened", 32);
        space.topology().map(inner.region("").unwrap(), 0).unwrap();
        Self(inner, Arc::new(Region::io("widened", 0x400, Arc::new(Words(space)))))
    }
}

impl Device for Widened {
    fn class(&self) -> &'static DeviceClass {
        self.0.class()
    }

    fn realize(&self, context: &mut RealizeCtx<'_>) -> rsemu::Result<()> {
        self.0.realize(context)
    }

    fn reset(&self, kind: ResetKind) {
        self.0.reset(kind);
    }

    fn region(&self, _: &str) -> Option<RegionRef> {
        Some(self.1.clone())
    }

    fn sink(&self, port: &str, sources: &[WireId]) -> Option<SinkPin> {
        self.0.sink(port, sources)
    }

    fn connect(&self, port: &str, source: WireSource) -> rsemu::Result<()> {
        self.0.connect(port, source)
    }

    fn announce(&self, port: &str) {
        self.0.announce(port);
    }

    fn is_lazy(&self) -> bool {
        self.0.is_lazy()
    }

    fn current_tick(&self) -> u64 {
        self.0.current_tick()
    }

    fn advance_to(&self, tick: u64) {
        self.0.advance_to(tick);
    }

    fn next_event_tick(&self) -> Option<u64> {
        self.0.next_event_tick()
    }

    fn attach_lazy(&self, handle: LazyHandle) {
        self.0.attach_lazy(handle);
    }
}

impl Instance for Widened {
    fn bind(&self, context: &BindCtx<'_>) -> rsemu::Result<()> {
        self.0.bind(context)
    }
}
