//! The temperature sensor on the chip.

use device::Smoothed;
use stm32f4xx_hal::adc::config::{AdcConfig, Clock, SampleTime, Sequence};
use stm32f4xx_hal::adc::{Adc, Temperature};
use stm32f4xx_hal::pac::ADC1;
use stm32f4xx_hal::rcc::Rcc;

/// A thermometer that never waits: each reading is one that was begun before.
pub struct Thermometer {
    adc: Adc<ADC1>,
    at_30_and_110: [i32; 2],
    begun: bool,
    smoothed: Smoothed,
}

impl Thermometer {
    /// Sets the sensor up, with the chip's own readings at 30 °C and 110 °C.
    pub fn new(adc: ADC1, rcc: &mut Rcc, at_30_and_110: [u16; 2]) -> Self {
        let config = AdcConfig::default()
            .default_sample_time(SampleTime::Cycles_480)
            // 21 MHz; the limit is 36 MHz (data sheet, table 67).
            .clock(Clock::Pclk2_div_4);
        let mut adc = Adc::new(adc, true, config, rcc);
        adc.enable_temperature_and_vref();
        adc.configure_channel(&Temperature, Sequence::One, SampleTime::Cycles_480);
        let at_30_and_110 = at_30_and_110.map(i32::from);
        Self { adc, at_30_and_110, begun: false, smoothed: Smoothed::default() }
    }

    /// Temperature, 2^-8 °C, smoothed, with the conversion that was begun the last time; begins another.
    pub fn read(&mut self) -> Option<i16> {
        let done = self.begun && adc_done();
        let reading = done.then(|| i32::from(self.adc.current_sample()));
        self.adc.start_conversion();
        self.begun = true;
        let [cold, warm] = self.at_30_and_110;
        let span = warm.wrapping_sub(cold);
        let above = reading?.wrapping_sub(cold).wrapping_mul(80 * 256).checked_div(span)?;
        self.smoothed.take(i16::try_from(above.wrapping_add(30 * 256)).ok()?)
    }
}

fn adc_done() -> bool {
    // SAFETY: a read of the status register, which has no effect.
    unsafe { (*ADC1::ptr()).sr().read().eoc().bit_is_set() }
}
