//! The ADS131M04.

use ads131m04::{Ads131m04, Clock, Config, Error, Gain, Oversampling, PowerMode};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use shared::wire::{Capabilities, ConverterFault, Inputs};

use crate::front_end::{Converter, ReadError, Setting};

/// An ADS131M04 with its clock.
#[derive(Debug)]
pub struct FourChannels<SPI, RESET> {
    part: Ads131m04<SPI, RESET>,
    clock_hz: u32,
    /// What it measures now.
    inputs: Inputs,
}

impl<SPI: SpiDevice, RESET: OutputPin> FourChannels<SPI, RESET> {
    /// The part on its bus and reset line, with the clock at CLKIN, Hz.
    pub const fn new(spi: SPI, reset: RESET, clock_hz: u32) -> Self {
        Self { part: Ads131m04::new(spi, reset), clock_hz, inputs: Inputs::Gauges }
    }

    fn config(&self, setting: &Setting) -> Option<Config> {
        let clock = Clock::new(self.clock_hz, PowerMode::HighResolution).ok()?;
        let gain = |wanted: u8| Gain::ALL.into_iter().find(|it| it.factor() == u32::from(wanted));
        let [a, b, c, d] = setting.gain;
        let gains = [gain(a)?, gain(b)?, gain(c)?, gain(d)?];
        let with = |chop| move |oversampling| Config { clock, oversampling, chop, gains };
        let is_set = |config: &Config| config.sample_interval_ns() == setting.interval_ns;
        let plain = Oversampling::ALL.into_iter().map(with(false));
        plain.chain(Oversampling::ALL.into_iter().map(with(true))).find(is_set)
    }

    fn select(&mut self, inputs: Inputs) -> Result<(), ConverterFault> {
        if inputs != self.inputs {
            let chosen = match inputs {
                Inputs::Gauges => ads131m04::Inputs::Pins,
                Inputs::Shorted => ads131m04::Inputs::Shorted,
                Inputs::TestSignal => ads131m04::Inputs::TestSignal,
            };
            self.part.select(chosen).map_err(|error| fault(&error))?;
            self.inputs = inputs;
        }
        Ok(())
    }
}

impl<SPI: SpiDevice, RESET: OutputPin> Converter for FourChannels<SPI, RESET> {
    const PART: &'static str = "ADS131M04";

    fn capabilities(&self) -> Capabilities {
        Capabilities::ads131m04(self.clock_hz)
    }

    fn reset(&mut self, delay: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault> {
        let config = self.config(setting).ok_or(ConverterFault::Register)?;
        self.inputs = Inputs::Gauges;
        self.part.reset(delay, &config).map_err(|error| fault(&error))
    }

    fn begin(&mut self, delay: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault> {
        let config = self.config(setting).ok_or(ConverterFault::Register)?;
        self.part.begin(delay, &config).map_err(|error| fault(&error))?;
        self.select(setting.inputs)
    }

    fn configure(&mut self, setting: &Setting) -> Result<(), ConverterFault> {
        let config = self.config(setting).ok_or(ConverterFault::Register)?;
        self.part.configure(&config).map_err(|error| fault(&error))?;
        self.select(setting.inputs)
    }

    fn read(&mut self) -> Result<[i32; shared::pipeline::GAUGES], ReadError> {
        match self.part.read() {
            Ok(reading) => Ok(reading.counts),
            Err(Error::ConfigurationLost { .. }) => Err(ReadError::SettingsLost),
            Err(Error::NoNewData { .. }) => Err(ReadError::Stale),
            Err(error) => Err(ReadError::Fault(fault(&error))),
        }
    }

    fn discard_stale(&mut self) {
        // A line that is dead will say so when it is read.
        let _ = self.part.discard_stale();
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
