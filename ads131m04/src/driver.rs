//! Reset, configuration and reading of the part.

use embedded_hal::{
    delay::DelayNs,
    digital::{self, OutputPin},
    spi::{self, SpiDevice},
};

use crate::{
    CHANNELS, Config, Error, Inputs, Register, Status,
    command::{Command, RESET_RESPONSE},
    frame::{self, Frame, Reply},
    register,
};

/// Clock idles low, data are sampled on its falling edge. Up to 25 MHz at 2.7 V to 3.6 V (§6.6).
pub const SPI_MODE: spi::Mode = spi::MODE_1;

/// Samples after a change of gain or rate that still mix old and new: the length of the sinc³ filter (§8.3.7).
pub const SETTLING_SAMPLES: usize = 3;

/// From a stable supply to the first command (t_POR, §6.7).
const POWER_ON_US: u32 = 250;

/// SYNC/RESET low for so many periods of CLKIN (t_w(RSL), §6.6): a shorter pulse synchronises the conversions and resets
/// nothing.
const RESET_PULSE_PERIODS: u32 = 2_048;

/// From a reset to the first command (t_REGACQ, §6.7).
const REGISTERS_US: u32 = 5;

/// The four counts of one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading {
    /// The status that came with them.
    pub status: Status,
    /// −2²³ to 2²³ − 1 for −full scale to +full scale; full scale is 1.2 V divided by the gain. An input beyond it clips.
    pub counts: [i32; CHANNELS],
}

/// An ADS131M04 on a bus device `SPI` (with chip select, [`SPI_MODE`]) and a pin `RESET` to SYNC/RESET.
#[derive(Debug)]
pub struct Ads131m04<SPI, RESET> {
    spi: SPI,
    reset: RESET,
}

type Outcome<T, SPI, RESET> =
    Result<T, Error<<SPI as spi::ErrorType>::Error, <RESET as digital::ErrorType>::Error>>;

impl<SPI: SpiDevice, RESET: OutputPin> Ads131m04<SPI, RESET> {
    /// The driver; nothing is sent before [`init`](Self::init).
    pub const fn new(spi: SPI, reset: RESET) -> Self {
        Self { spi, reset }
    }

    /// Gives the bus and the pin back.
    pub fn release(self) -> (SPI, RESET) {
        (self.spi, self.reset)
    }

    /// Resets the part by pin and by command, verifies that it is an ADS131M04, and configures it. CLKIN must run.
    /// Waits half a millisecond at 8 MHz, 7 ms at the slowest clock.
    ///
    /// # Errors
    /// [`Error::NoChip`], [`Error::NotReset`] and [`Error::WrongChip`] when the part is not there or not the right one;
    /// otherwise as [`configure`](Self::configure).
    pub fn init(&mut self, delay: &mut impl DelayNs, config: &Config) -> Outcome<(), SPI, RESET> {
        self.reset(delay, config)?;
        self.begin(delay, config)
    }

    /// The first half of [`init`](Self::init), most of its time: resets the part by its pin, which is silent.
    ///
    /// # Errors
    /// [`Error::ResetPin`].
    pub fn reset(&mut self, delay: &mut impl DelayNs, config: &Config) -> Outcome<(), SPI, RESET> {
        self.pulse_reset(delay, config).map_err(Error::ResetPin)
    }

    /// The second half of [`init`](Self::init): resets a part that was reset by its pin by command too, verifies that it is an
    /// ADS131M04, and configures it.
    ///
    /// # Errors
    /// As [`init`](Self::init).
    pub fn begin(&mut self, delay: &mut impl DelayNs, config: &Config) -> Outcome<(), SPI, RESET> {
        self.command_reset(delay)?;
        self.verify_identity()?;
        self.configure(config)
    }

    /// Writes all settings and reads each back. Two samples are dropped on the way, and the next [`SETTLING_SAMPLES`] mix old
    /// and new settings. 14 frames.
    ///
    /// # Errors
    /// [`Error::Refused`] or [`Error::ReadBack`] when the part does not take them, as when it is locked; [`Error::Crc`].
    pub fn configure(&mut self, config: &Config) -> Outcome<(), SPI, RESET> {
        self.write_verified(Register::Mode, register::MODE)?;
        self.write_verified(Register::Clock, config.clock_register())?;
        self.write_verified(Register::Gain1, config.gain_register())?;
        self.write_verified(Register::Cfg, config.cfg_register())?;
        self.discard_stale()
    }

    /// Chooses what all channels measure; a reset chooses their pins. As [`configure`](Self::configure) it drops samples, and the
    /// next [`SETTLING_SAMPLES`] mix old and new. 14 frames.
    ///
    /// # Errors
    /// As [`configure`](Self::configure).
    pub fn select(&mut self, inputs: Inputs) -> Outcome<(), SPI, RESET> {
        use Register::{Channel0, Channel1, Channel2, Channel3};
        for channel in [Channel0, Channel1, Channel2, Channel3] {
            self.write_verified(channel, inputs as u16)?;
        }
        self.discard_stale()
    }

    /// Reads the four counts in one transaction of 18 bytes. Call it once per falling edge of DRDY.
    ///
    /// # Errors
    /// [`Error::Crc`] for a damaged frame, [`Error::NoNewData`] when a channel had nothing new,
    /// [`Error::ConfigurationLost`] when the part was reset and needs [`init`](Self::init), [`Error::NoChip`] for a dead
    /// line. After any of them the next read is good again if its cause has gone.
    pub fn read(&mut self) -> Outcome<Reading, SPI, RESET> {
        let mut frame = frame::NULL;
        let reply = self.verified(&mut frame)?;
        let status = Status(reply.response());
        if status.was_reset() {
            return Err(Error::ConfigurationLost { status });
        }
        if !status.all_ready() {
            return Err(Error::NoNewData { status });
        }
        Ok(Reading { status, counts: reply.counts() })
    }

    /// Empties the two samples that the part keeps for each channel. Call it after any pause in reading, then wait for the
    /// next edge of DRDY; a [`read`](Self::read) at once would find nothing new.
    ///
    /// When a sample is not read in time both places fill. A read then gives the older one, the ready bits stay set, and
    /// DRDY is not to be relied upon, until two frames in quick succession have emptied them (§8.5.1.9.1). The datasheet's
    /// other way, a pulse on SYNC/RESET, restarts the filters when it falls out of step with the conversions (§8.5.2).
    ///
    /// # Errors
    /// [`Error::Spi`] or [`Error::NoChip`].
    pub fn discard_stale(&mut self) -> Outcome<(), SPI, RESET> {
        self.transfer(&mut { frame::NULL })?;
        self.transfer(&mut { frame::NULL })?;
        Ok(())
    }

    /// The value of a register. Drops two samples.
    ///
    /// # Errors
    /// [`Error::Crc`], [`Error::NoChip`] or [`Error::Spi`].
    pub fn read_register(&mut self, register: Register) -> Outcome<u16, SPI, RESET> {
        self.exchange(Command::ReadRegister(register))
    }

    /// Stops the conversions and saves current; settings are kept.
    ///
    /// # Errors
    /// [`Error::Refused`] and as [`read_register`](Self::read_register).
    pub fn standby(&mut self) -> Outcome<(), SPI, RESET> {
        self.acknowledged(Command::Standby)
    }

    /// Resumes the conversions.
    ///
    /// # Errors
    /// [`Error::Refused`] and as [`read_register`](Self::read_register).
    pub fn wakeup(&mut self) -> Outcome<(), SPI, RESET> {
        self.acknowledged(Command::Wakeup)
    }

    /// Protects the settings from disturbances on the bus: until [`unlock`](Self::unlock), only readings and registers can
    /// be read. A reset by pin unlocks.
    ///
    /// # Errors
    /// [`Error::Refused`] and as [`read_register`](Self::read_register).
    pub fn lock(&mut self) -> Outcome<(), SPI, RESET> {
        self.acknowledged(Command::Lock)
    }

    /// Ends the protection of [`lock`](Self::lock).
    ///
    /// # Errors
    /// [`Error::Refused`] and as [`read_register`](Self::read_register).
    pub fn unlock(&mut self) -> Outcome<(), SPI, RESET> {
        self.acknowledged(Command::Unlock)
    }

    fn pulse_reset(
        &mut self,
        delay: &mut impl DelayNs,
        config: &Config,
    ) -> Result<(), RESET::Error> {
        self.reset.set_high()?;
        delay.delay_us(POWER_ON_US);
        self.reset.set_low()?;
        delay.delay_us(config.clock.duration_us(RESET_PULSE_PERIODS));
        self.reset.set_high()?;
        delay.delay_us(REGISTERS_US);
        Ok(())
    }

    /// The pin alone is silent; only the command is acknowledged (§8.4.1.3). A part with fewer channels has shorter frames,
    /// so the checksum is not where we look for it, and the response must be judged without.
    fn command_reset(&mut self, delay: &mut impl DelayNs) -> Outcome<(), SPI, RESET> {
        self.transfer(&mut frame::request(Command::Reset))?;
        delay.delay_us(REGISTERS_US);
        let response = self.transfer(&mut { frame::NULL })?.response();
        if response & 0xFFF0 == RESET_RESPONSE {
            self.expect_four(response, (response & 0xF) as u8)
        } else {
            Err(Error::NotReset { response })
        }
    }

    fn verify_identity(&mut self) -> Outcome<(), SPI, RESET> {
        let id = self.read_register(Register::Id)?;
        self.expect_four(id, register::channels_of_id(id))
    }

    fn expect_four(&self, read: u16, channels: u8) -> Outcome<(), SPI, RESET> {
        if usize::from(channels) == CHANNELS {
            Ok(())
        } else {
            Err(Error::WrongChip { read, channels })
        }
    }

    /// The part obeys a WREG even when its checksum is wrong (§8.3.12): only reading back tells.
    fn write_verified(&mut self, register: Register, written: u16) -> Outcome<(), SPI, RESET> {
        let write = Command::WriteRegister(register, written);
        self.transfer(&mut frame::request(write))?;
        // The acknowledgement comes with the frame that asks for the value.
        let ask = Command::ReadRegister(register);
        let response = self.verified(&mut frame::request(ask))?.response();
        expect(write, response)?;
        let read = self.verified(&mut { frame::NULL })?.response();
        if read == written { Ok(()) } else { Err(Error::ReadBack { register, written, read }) }
    }

    fn acknowledged(&mut self, command: Command) -> Outcome<(), SPI, RESET> {
        let response = self.exchange(command)?;
        expect(command, response)
    }

    /// Sends a command and fetches the response, which comes one frame later.
    fn exchange(&mut self, command: Command) -> Outcome<u16, SPI, RESET> {
        self.transfer(&mut frame::request(command))?;
        Ok(self.verified(&mut { frame::NULL })?.response())
    }

    /// Exchanges a frame and holds the reply to its checksum.
    fn verified<'f>(&mut self, frame: &'f mut Frame) -> Outcome<Reply<'f>, SPI, RESET> {
        let reply = self.transfer(frame)?;
        let (computed, received) = reply.checksums();
        if computed == received { Ok(reply) } else { Err(Error::Crc { computed, received }) }
    }

    /// Exchanges a frame where it stands: the reply takes the place of the request.
    fn transfer<'f>(&mut self, frame: &'f mut Frame) -> Outcome<Reply<'f>, SPI, RESET> {
        self.spi.transfer_in_place(frame.as_flattened_mut()).map_err(Error::Spi)?;
        let reply = Reply(frame);
        match reply.stuck_at() {
            Some(read) => Err(Error::NoChip { read }),
            None => Ok(reply),
        }
    }
}

/// Whether a response is the one that a command owes.
fn expect<SPI, PIN>(command: Command, response: u16) -> Result<(), Error<SPI, PIN>> {
    let expected = command.acknowledgement();
    if response == expected {
        Ok(())
    } else {
        Err(Error::Refused { command: command.word(), expected, response })
    }
}
