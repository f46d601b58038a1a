//! The independent watchdog: it resets the chip unless every stage makes progress.

use core::sync::atomic::{AtomicU32, Ordering};

use stm32f4xx_hal::pac::{DBGMCU, IWDG};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Longer than an erasure of a flash sector, during which nothing runs, even if the watchdog's oscillator is fast: its 32 kHz may
/// be 47 kHz, which makes this 5.4 s.
const PATIENCE_MS: u32 = 8_000;

/// A stage that must make progress.
#[derive(Clone, Copy)]
#[repr(u32)]
pub enum Stage {
    /// The interrupt that reads the converter; not while it need not.
    Read = 1,
    /// Filtering.
    Filter = 1 << 1,
    /// Commands.
    Command = 1 << 2,
    /// Sending.
    Send = 1 << 3,
}

const ALL: u32 =
    Stage::Read as u32 | Stage::Filter as u32 | Stage::Command as u32 | Stage::Send as u32;

static PROGRESS: AtomicU32 = AtomicU32::new(0);

/// Notes that a stage made progress, or had nothing to do.
pub fn progress(stage: Stage) {
    PROGRESS.fetch_or(stage as u32, Ordering::Relaxed);
}

/// The watchdog.
pub struct Watchdog(IndependentWatchdog);

impl Watchdog {
    /// Starts it; nothing but a debugger that holds the processor can stop it any more.
    pub fn start(watchdog: IWDG, debug: &DBGMCU) -> Self {
        let mut watchdog = IndependentWatchdog::new(watchdog);
        watchdog.stop_on_debug(debug, true);
        // Without it a probe loses the processor whenever there is nothing to do.
        debug.cr().modify(|_, w| w.dbg_sleep().set_bit());
        watchdog.start(PATIENCE_MS.millis());
        Self(watchdog)
    }

    /// Feeds it if every stage made progress since the last time it was fed.
    pub fn feed(&mut self) {
        if PROGRESS.load(Ordering::Relaxed) & ALL == ALL {
            PROGRESS.store(0, Ordering::Relaxed);
            self.0.feed();
        }
    }
}

/// Feeds it in any case, before something that is known to take long.
pub fn feed_now() {
    // SAFETY: the register takes keys only, and this one does nothing but feed.
    unsafe { (*IWDG::ptr()).kr().write(|w| w.key().feed()) };
}
