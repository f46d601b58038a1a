//! Device time: microseconds since reset, 64 bits, from TIM2.

use core::cell::Cell;

use critical_section::Mutex;
use embedded_hal::delay::DelayNs;
use stm32f4xx_hal::pac::{TIM2, TIM3};
use stm32f4xx_hal::rcc::{BusTimerClock, Enable, Rcc, Reset};

use super::edge;

/// The last reading; its upper half counts how often the timer began anew.
static LAST: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// Starts the clock, and the timer that catches edges with it.
pub fn start(timer: TIM2, edges: TIM3, rcc: &mut Rcc) {
    TIM2::enable(rcc);
    TIM2::reset(rcc);
    let megahertz = TIM2::timer_clock(&rcc.clocks).to_MHz() as u16;
    timer.psc().write(|w| w.psc().set(megahertz.saturating_sub(1)));
    timer.arr().write(|w| w.arr().set(u32::MAX));
    timer.egr().write(|w| w.ug().set_bit());
    edge::prepare(&edges, rcc);
    // A few cycles apart, always the same, far less than a count.
    critical_section::with(|_| {
        timer.cr1().modify(|_, w| w.cen().set_bit());
        edges.cr1().modify(|_, w| w.cen().set_bit());
    });
}

/// Microseconds since reset. To be read at least once in 71 minutes, or it loses as much.
pub fn now_us() -> u64 {
    critical_section::with(|section| {
        // SAFETY: a read of the counter, which has no effect.
        let low = unsafe { (*TIM2::ptr()).cnt().read().bits() };
        let last = LAST.borrow(section).get();
        let began_anew = low < last as u32;
        let high = (last >> 32).wrapping_add(u64::from(began_anew));
        let now = high << 32 | u64::from(low);
        LAST.borrow(section).set(now);
        now
    })
}

/// Waits by that clock.
#[derive(Clone, Copy, Debug)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // One more, because the present one may be over at once.
        let until = now_us().saturating_add(u64::from(ns.div_ceil(1_000)) + 1);
        while now_us() < until {}
    }
}
