//! The converter and its data-ready line.

use ads131m04::{Ads131m04, Clock, Config, DrdyWatch, Error, Gain, PowerMode};
use defmt::{Debug2Format, info, warn};
use device::{Lost, Sample};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use shared::pipeline::GAUGES;
use shared::wire::{ConverterFault, Oversampling};

use crate::board::{CONVERTER_CLOCK_HZ, time};

/// The converter, read once per edge of its data-ready line.
pub struct FrontEnd<SPI, RESET> {
    converter: Ads131m04<SPI, RESET>,
    watch: DrdyWatch,
    begun: bool,
    listening: bool,
    lost: Lost,
    delay: Cycles,
}

impl<SPI: SpiDevice, RESET: OutputPin> FrontEnd<SPI, RESET> {
    /// The converter on a bus and its reset line; nothing is sent before [`Self::configure`].
    pub fn new(spi: SPI, reset: RESET, delay: Cycles) -> Self {
        Self {
            converter: Ads131m04::new(spi, reset),
            watch: DrdyWatch::new(u32::MAX, 0),
            begun: false,
            listening: false,
            lost: Lost::default(),
            delay,
        }
    }

    /// Sets rate and gains; resets and checks the converter first if it was not begun.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn configure(
        &mut self,
        oversampling: Oversampling,
        gain: [u8; GAUGES],
    ) -> Result<(), ConverterFault> {
        let config = config(oversampling, gain).ok_or(ConverterFault::Register)?;
        let done = if self.begun {
            self.converter.configure(&config)
        } else {
            self.converter.init(&mut self.delay, &config)
        };
        self.begun = done.is_ok();
        self.watch = DrdyWatch::new(config.sample_interval_ns(), time::now_us());
        match done {
            Ok(()) => info!("converter runs at {} mHz", config.data_rate_millihertz()),
            Err(ref error) => warn!("converter: {}", Debug2Format(&fault(error))),
        }
        done.map_err(|error| fault(&error))
    }

    /// Lets samples through from now on, or not.
    pub fn listen(&mut self, listening: bool) {
        self.listening = listening && self.begun;
        if self.listening {
            // What it kept meanwhile is old.
            let _ = self.converter.discard_stale();
            self.watch.edge(time::now_us());
            self.lost = Lost::default();
        }
    }

    /// What is wrong while samples should come.
    pub fn fault(&self) -> Option<ConverterFault> {
        let stuck = self.listening && self.watch.is_stuck(time::now_us());
        stuck.then_some(ConverterFault::Stuck)
    }

    /// Whether samples should come.
    pub fn is_listening(&self) -> bool {
        self.listening
    }

    /// Answers an edge of the data-ready line: the sample, with what was lost before it.
    pub fn ready(&mut self) -> Option<Sample> {
        if !self.listening {
            return None;
        }
        let time_us = time::now_us();
        let missed = self.watch.edge(time_us);
        self.lost.missed = self.lost.missed.saturating_add(missed as u32);
        if missed > 0 {
            // Samples lie in wait in the converter, and its line is not to be relied upon until they are read.
            let _ = self.converter.discard_stale();
            self.lost.missed = self.lost.missed.saturating_add(1);
            return None;
        }
        match self.converter.read() {
            Ok(reading) => {
                let lost = core::mem::take(&mut self.lost);
                Some(Sample { time_us, counts: reading.counts, lost })
            }
            Err(_) => {
                self.lost.damaged = self.lost.damaged.saturating_add(1);
                None
            }
        }
    }

    /// A sample found the queue full: it is told with the next.
    pub fn found_queue_full(&mut self, sample: &Sample) {
        self.lost = sample.lost;
        self.lost.queue_full = self.lost.queue_full.saturating_add(1);
    }
}

fn config(oversampling: Oversampling, gain: [u8; GAUGES]) -> Option<Config> {
    let clock = Clock::new(CONVERTER_CLOCK_HZ, PowerMode::HighResolution).ok()?;
    let ratio =
        |wanted: u32| ads131m04::Oversampling::ALL.into_iter().find(|each| each.ratio() == wanted);
    let factor = |wanted: u8| Gain::ALL.into_iter().find(|each| each.factor() == u32::from(wanted));
    let [a, b, c, d] = gain;
    Some(Config {
        clock,
        oversampling: ratio(oversampling.ratio())?,
        gains: [factor(a)?, factor(b)?, factor(c)?, factor(d)?],
    })
}

fn fault<SPI, RESET>(error: &Error<SPI, RESET>) -> ConverterFault {
    match error {
        Error::NoChip { .. } => ConverterFault::Missing,
        Error::NotReset { response } => ConverterFault::Wrong(*response),
        Error::WrongChip { read, .. } => ConverterFault::Wrong(*read),
        Error::Refused { .. } | Error::ReadBack { .. } | Error::ConfigurationLost { .. } => {
            ConverterFault::Register
        }
        Error::Crc { .. } | Error::NoNewData { .. } => ConverterFault::Damaged,
        _ => ConverterFault::Bus,
    }
}

/// Waits by counting cycles of the processor.
pub struct Cycles {
    /// Clock of the processor, MHz.
    pub per_us: u32,
}

impl DelayNs for Cycles {
    fn delay_ns(&mut self, ns: u32) {
        let cycles = u64::from(ns).saturating_mul(u64::from(self.per_us)) / 1_000;
        cortex_m::asm::delay(cycles as u32);
    }
}
