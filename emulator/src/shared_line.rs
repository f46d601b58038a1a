//! The wire that the fingers of a hand share: this board's two ends of it, and what another finger does with it.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};

use rsemu::core::device::DeviceClass;
use rsemu::core::wire::WireSource;
use rsemu::machine::validate::{ClassSchema, PortDir};

use crate::part::{Clock, Part, Wires, class};

static CLASS: DeviceClass = class("palpate.shared_line", "the wire that fingers share");

/// Nanoseconds of a tick of the wire's clock.
const TICK_NS: u64 = 10;

/// The wire.
#[derive(Debug, Default)]
pub struct SharedLine {
    clock: Clock,
    pins: Wires,
    /// When another finger changes its level, and to what, in order.
    changes: Mutex<VecDeque<(u64, bool)>>,
    /// Whether this finger's output is joined to it.
    is_joined: AtomicBool,
    /// What this finger's output says.
    own: AtomicBool,
    other: AtomicBool,
    /// When this finger's output rose, ticks.
    raised: Mutex<Vec<u64>>,
}

impl SharedLine {
    /// Low, and joined to nothing but this finger's input.
    #[must_use]
    pub fn new() -> Arc<Self> {
        Arc::default()
    }

    /// Joins this finger's output to it.
    pub fn join(&self) {
        self.is_joined.store(true, Relaxed);
        self.announce();
    }

    /// Another finger raises it at a time since power came, ns, for so long; later than all before.
    pub fn pulse(&self, at_ns: u64, lasts_ns: u64) {
        let mut changes = self.changes.lock().unwrap();
        changes.extend([(at_ns / TICK_NS, true), ((at_ns + lasts_ns) / TICK_NS, false)]);
        self.clock.due(changes.front().map(|(at, _)| *at));
    }

    /// When this finger's output rose, ns since power came.
    #[must_use]
    pub fn raised_ns(&self) -> Vec<u64> {
        self.raised.lock().unwrap().iter().map(|tick| tick * TICK_NS).collect()
    }
}

impl Part for SharedLine {
    fn class() -> &'static DeviceClass {
        &CLASS
    }

    fn input_named(&self, _: &str) -> Option<u32> {
        Some(0)
    }

    fn input(&self, _: u32, high: bool) {
        self.clock.sync();
        if high && !self.own.swap(high, Relaxed) {
            self.raised.lock().unwrap().push(self.clock.now());
        }
        self.own.store(high, Relaxed);
        self.announce();
    }

    fn connect(&self, port: &str, wire: WireSource) {
        self.pins.add(port, wire);
    }

    fn announce(&self) {
        let own = self.own.load(Relaxed) && self.is_joined.load(Relaxed);
        self.pins.drive("level", own || self.other.load(Relaxed));
    }

    fn clock(&self) -> Option<&Clock> {
        Some(&self.clock)
    }

    fn advance(&self, to: u64) {
        loop {
            let mut changes = self.changes.lock().unwrap();
            let due = changes.front().copied().filter(|(at, _)| *at <= to);
            let Some((at, high)) = due else {
                self.clock.due(changes.front().map(|(at, _)| *at));
                break;
            };
            changes.pop_front();
            drop(changes);
            self.clock.set(at);
            self.other.store(high, Relaxed);
            self.announce();
        }
        self.clock.set(to);
    }
}

/// Its pins.
pub fn schema() -> ClassSchema {
    ClassSchema::new(CLASS.name).region("").port("own", PortDir::In).port("level", PortDir::Out)
}
