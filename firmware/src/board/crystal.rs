//! Which crystal is on the board: its edges are counted with the oscillator on the chip, so that one program suits all.

use stm32f4xx_hal::pac::{RCC, TIM11};

/// Crystals in use on boards with an STM32F405, MHz: a third apart, while the oscillator on the chip is good to 8 %.
const KNOWN_MHZ: [u32; 4] = [8, 12, 16, 25];
/// A crystal is taken for a known one that it differs from by so much, %.
const TOLERANCE_PERCENT: u32 = 9;
/// The oscillator on the chip, MHz.
const INTERNAL_MHZ: u32 = 16;

/// RTCPRE, at most 1 MHz of 26 MHz (RM0090 §7.3.3), and the prescaler of the capture.
const DIVIDER: u32 = 31;
const PRESCALER: u32 = 8;
/// Intervals that are measured: 0.33 ms with 12 MHz.
const INTERVALS: u32 = 16;
/// Looks at the flag before a capture counts as one that never comes.
const PATIENCE: u32 = 10_000;

/// TI1_RMP: the timer's input is HSE/RTCPRE (RM0090 §19.4.13).
const FROM_CRYSTAL: u8 = 0b10;
/// IC1PSC: every eighth edge.
const EVERY_EIGHTH: u8 = 0b11;

/// Frequency of the crystal, which runs while the processor still does on the internal oscillator; none if it is no known one.
pub fn megahertz(rcc: &RCC, timer: &TIM11) -> Option<u32> {
    rcc.apb2enr().modify(|_, w| w.tim11en().enabled());
    // The clock of a peripheral runs two cycles after it was enabled (RM0090 §7.3.14).
    cortex_m::asm::delay(2);
    rcc.cfgr().modify(|_, w| w.rtcpre().set(DIVIDER as u8));
    // SAFETY: a field of two bits that takes any value.
    timer.or().write(|w| unsafe { w.rmp().bits(FROM_CRYSTAL) });
    // SAFETY: a field of two bits that takes any value.
    timer.ccmr1_input().write(|w| unsafe { w.cc1s().ti1().ic1psc().bits(EVERY_EIGHTH) });
    timer.ccer().write(|w| w.cc1e().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
    let ticks = ticks_of_intervals(timer);
    timer.cr1().reset();
    rcc.cfgr().modify(|_, w| w.rtcpre().set(0));
    rcc.apb2enr().modify(|_, w| w.tim11en().disabled());
    nearest(ticks?)
}

/// Ticks of the internal oscillator in all intervals; the counter has 16 bits, an interval at most 500 ticks.
fn ticks_of_intervals(timer: &TIM11) -> Option<u32> {
    // The first may have begun before the crystal was connected.
    captured(timer)?;
    let mut last = captured(timer)?;
    let mut ticks = 0_u32;
    for _ in 0..INTERVALS {
        let now = captured(timer)?;
        ticks = ticks.wrapping_add(now.wrapping_sub(last).into());
        last = now;
    }
    Some(ticks)
}

fn captured(timer: &TIM11) -> Option<u16> {
    let came = (0..PATIENCE).any(|_| timer.sr().read().cc1if().bit_is_set());
    // Reading the capture clears its flag.
    came.then(|| timer.ccr1().read().ccr().bits())
}

fn nearest(ticks: u32) -> Option<u32> {
    let periods = DIVIDER * PRESCALER * INTERVALS;
    // Hundredths of a megahertz.
    let measured = (periods * INTERNAL_MHZ * 100).checked_div(ticks)?;
    let known = |mhz: &u32| (mhz * 100).abs_diff(measured) <= mhz * TOLERANCE_PERCENT;
    KNOWN_MHZ.into_iter().find(known)
}
