//! When the converter's data-ready line fell, and when the line that fingers share rose: a timer catches both instants, so that an
//! interrupt that comes late makes no error in time, and intervals are what the converter's clock makes them.
//!
//! TIM3 counts as TIM2 does, from the same instant on, so that what it catches are the lower 16 bits of the device's time.

use stm32f4xx_hal::pac::TIM3;
use stm32f4xx_hal::rcc::{BusTimerClock, Enable, Rcc, Reset};

/// Alternate function of PC7 that is TIM3_CH2, and of PA6 that is TIM3_CH1 (data sheet, table 9).
pub const FUNCTION: u8 = 2;
/// How long the shared line must be up to have risen: 8 samples at an eighth of the timer's clock, 0.8 µs, the same on all fingers.
const SETTLED: u8 = 0b1001;
/// The flag that says that the line rose again before the first time was read.
const ROSE_AGAIN: u32 = 1 << 9;

/// Sets the timer up; it does not count yet.
pub fn prepare(timer: &TIM3, rcc: &mut Rcc) {
    TIM3::enable(rcc);
    TIM3::reset(rcc);
    let megahertz = TIM3::timer_clock(&rcc.clocks).to_MHz() as u16;
    timer.psc().write(|w| w.psc().set(megahertz.saturating_sub(1)));
    timer.arr().write(|w| w.arr().set(u16::MAX));
    timer.egr().write(|w| w.ug().set_bit());
    timer.ccmr1_input().write(|w| w.cc1s().ti1().ic1f().set(SETTLED).cc2s().ti2());
    timer.ccer().write(|w| w.cc1e().set_bit().cc2p().set_bit().cc2e().set_bit());
}

/// When the converter's line last fell, µs, if it did since the last call; `now_us` must be less than 65 ms later.
pub fn caught(now_us: u64) -> Option<u64> {
    // SAFETY: the interrupt of the edge alone reads these registers.
    let timer = unsafe { &*TIM3::ptr() };
    timer.sr().read().cc2if().bit_is_set().then(|| {
        // Reading the capture clears its flag.
        time_of(timer.ccr2().read().ccr().bits(), now_us)
    })
}

/// When the shared line rose, µs, if it did once since the last call; `now_us` must be less than 65 ms later.
pub fn rose(now_us: u64) -> Option<u64> {
    // SAFETY: whoever looks after the shared line alone reads this channel, and writes this flag.
    let timer = unsafe { &*TIM3::ptr() };
    let state = timer.sr().read();
    let caught = state.cc1if().bit_is_set().then(|| timer.ccr1().read().ccr().bits())?;
    if state.cc1of().bit_is_set() {
        // SAFETY: a flag is cleared by a zero, and kept by a one.
        timer.sr().write(|w| unsafe { w.bits(!ROSE_AGAIN) });
        return None;
    }
    Some(time_of(caught, now_us))
}

/// Device time, µs, of which the lower 16 bits were caught less than 65 ms ago.
fn time_of(caught: u16, now_us: u64) -> u64 {
    now_us.saturating_sub((now_us as u16).wrapping_sub(caught).into())
}
