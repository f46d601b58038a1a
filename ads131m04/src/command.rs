//! The commands of the part and the responses that it owes (§8.5.1.10, table 8-11).

use crate::Register;

/// A command, with what it carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Command {
    /// All registers to their defaults.
    Reset,
    /// Conversions off, least current.
    Standby,
    /// Conversions on.
    Wakeup,
    /// From now on only nothing, `Unlock` and `ReadRegister` are obeyed.
    Lock,
    /// Obey every command again.
    Unlock,
    /// RREG of one register.
    ReadRegister(Register),
    /// WREG of one register.
    WriteRegister(Register, u16),
}

/// Response to [`Command::Reset`] but for the number of channels, its last digit.
pub(crate) const RESET_RESPONSE: u16 = 0xFF20;

impl Command {
    /// The command word.
    pub(crate) const fn word(self) -> u16 {
        match self {
            Self::Reset => 0x0011,
            Self::Standby => 0x0022,
            Self::Wakeup => 0x0033,
            Self::Lock => 0x0555,
            Self::Unlock => 0x0655,
            Self::ReadRegister(register) => 0xA000 | register.address_bits(),
            Self::WriteRegister(register, _) => 0x6000 | register.address_bits(),
        }
    }

    /// What the part answers in the next frame when it has obeyed a command other than a read or a reset.
    pub(crate) const fn acknowledgement(self) -> u16 {
        match self {
            Self::WriteRegister(register, _) => 0x4000 | register.address_bits(),
            other => other.word(),
        }
    }
}
