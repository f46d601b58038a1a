//! The ADS131M04.

use ads131m04::{Ads131m04, Clock, Config, Error, Gain, PowerMode, SETTLING_SAMPLES};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use shared::wire::ConverterFault;

use crate::front_end::{Converter, ReadError, Setting};

/// An ADS131M04 with its clock.
#[derive(Debug)]
pub struct FourChannels<SPI, RESET> {
    part: Ads131m04<SPI, RESET>,
    clock_hz: u32,
}

impl<SPI: SpiDevice, RESET: OutputPin> FourChannels<SPI, RESET> {
    /// The part on its bus and reset line, with the clock at CLKIN, Hz.
    pub const fn new(spi: SPI, reset: RESET, clock_hz: u32) -> Self {
        Self { part: Ads131m04::new(spi, reset), clock_hz }
    }

    fn config(&self, setting: &Setting) -> Option<Config> {
        let clock = Clock::new(self.clock_hz, PowerMode::HighResolution).ok()?;
        let ratio = setting.oversampling.ratio();
        let oversampling = ads131m04::Oversampling::ALL.into_iter().find(|it| it.ratio() == ratio);
        let gain = |wanted: u8| Gain::ALL.into_iter().find(|it| it.factor() == u32::from(wanted));
        let [a, b, c, d] = setting.gain;
        Some(Config {
            clock,
            oversampling: oversampling?,
            gains: [gain(a)?, gain(b)?, gain(c)?, gain(d)?],
        })
    }
}

impl<SPI: SpiDevice, RESET: OutputPin> Converter for FourChannels<SPI, RESET> {
    const SETTLING: u8 = SETTLING_SAMPLES as u8;

    fn reset(&mut self, delay: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault> {
        let config = self.config(setting).ok_or(ConverterFault::Register)?;
        self.part.reset(delay, &config).map_err(|error| fault(&error))
    }

    fn begin(&mut self, delay: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault> {
        let config = self.config(setting).ok_or(ConverterFault::Register)?;
        self.part.begin(delay, &config).map_err(|error| fault(&error))
    }

    fn configure(&mut self, setting: &Setting) -> Result<(), ConverterFault> {
        let config = self.config(setting).ok_or(ConverterFault::Register)?;
        self.part.configure(&config).map_err(|error| fault(&error))
    }

    fn read(&mut self) -> Result<[i32; shared::pipeline::GAUGES], ReadError> {
        match self.part.read() {
            Ok(reading) => Ok(reading.counts),
            Err(Error::ConfigurationLost { .. }) => Err(ReadError::SettingsLost),
            Err(error) => Err(ReadError::Fault(fault(&error))),
        }
    }

    fn discard_stale(&mut self) {
        // A line that is dead will say so when it is read.
        let _ = self.part.discard_stale();
    }

    fn interval_ns(&self, setting: &Setting) -> u32 {
        self.config(setting).map_or(0, |config| config.sample_interval_ns())
    }
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
