//! Why a device did not carry out a command, and what to do about it.

use std::fmt;

use shared::wire::{ConverterFault, Refusal, StoreFault};

/// A command that was refused; nothing was changed on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused(pub Refusal);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the device refused: ")?;
        match self.0 {
            Refusal::NoHello => f.write_str("it was reset meanwhile; call again"),
            Refusal::Schema(schema) => {
                write!(f, "its schema is {schema:#018x}; take firmware and program of one release")
            }
            Refusal::Streaming => f.write_str("not while it streams; stop the recording first"),
            Refusal::NotStreaming => f.write_str("only while it streams"),
            Refusal::NotFromLink => f.write_str("its samples come from the converter"),
            Refusal::Gauge(gauge) => {
                write!(f, "there is no gauge {}; they are 1 to 4", u16::from(gauge) + 1)
            }
            Refusal::Interval => f.write_str("the interval between rows must be positive"),
            Refusal::Rate => f.write_str(
                "the converter has no such rate; `palpate device info` lists those it has",
            ),
            Refusal::Gain => f.write_str("a gain must be a power of two from 1 to 128"),
            Refusal::Filter => f.write_str(
                "the relaxation function is out of range or too fast for the sample rate",
            ),
            Refusal::Thresholds => f.write_str("the thresholds are out of range"),
            Refusal::Calibration => f.write_str("the calibration is out of range"),
            Refusal::Rows => f.write_str("it could not read the injected rows"),
            Refusal::NoSample => f.write_str("no sample has come yet that could read zero"),
            Refusal::Converter(fault) => {
                write!(f, "{}", Fault(fault))
            }
            Refusal::Store(StoreFault::NotWritten) => {
                f.write_str("its flash did not keep the settings; those before are still there")
            }
            Refusal::Store(StoreFault::Flash) => {
                f.write_str("its flash failed; the settings before are still there")
            }
            Refusal::Store(StoreFault::Supply) => f.write_str(
                "its supply is too low to write its flash (it needs 3 V); the settings before are still there",
            ),
            Refusal::NotHere => f.write_str("this device cannot do that"),
        }
    }
}

impl std::error::Error for Refused {}

/// What is wrong with the converter, and where to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault(pub ConverterFault);

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            ConverterFault::Missing => {
                f.write_str("the converter does not answer; check its supply, clock and SPI lines")
            }
            ConverterFault::Wrong(identity) => {
                write!(f, "the converter answers as {identity:#06x}; an ADS131M04 is expected")
            }
            ConverterFault::Register => {
                f.write_str("the converter did not keep a register; check its supply and SPI lines")
            }
            ConverterFault::Damaged => {
                f.write_str("the converter's replies are damaged; check SPI lines and ground")
            }
            ConverterFault::Stuck => {
                f.write_str("no sample comes; check the data-ready line and the converter's clock")
            }
            ConverterFault::Bus => f.write_str("the SPI bus failed"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauges_are_counted_from_one_in_words() {
        let words = Refused(Refusal::Gauge(255)).to_string();
        assert_eq!(words, "the device refused: there is no gauge 256; they are 1 to 4");
    }
}
