//! A NOR flash whose power fails at a chosen instant.
//!
//! Programming only clears bits, erasing a sector only sets them. One step programs or erases one word; the power can
//! fail before any step, and what becomes of the words under way is chosen by [`Tear`].
#![allow(dead_code, reason = "each test file uses a part")]

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

/// What a loss of power leaves of the words that were to be programmed or erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tear {
    /// Words before the step are done, those after it untouched.
    Clean,
    /// As [`Tear::Clean`], but last to first.
    Backwards,
    /// Programming: the word under way has some of its bits. Erasing: every bit of the sector is erased or not.
    Torn,
    /// As [`Tear::Torn`], but the bits that are not done read differently every time.
    Unstable,
    /// Programming: as [`Tear::Torn`]. Erasing: the sector reads as zeros up to the step, as before the actual erase.
    Zeroed,
}

impl Tear {
    pub const ALL: [Self; 5] =
        [Self::Clean, Self::Backwards, Self::Torn, Self::Unstable, Self::Zeroed];
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MockError {
    NoPower,
    Driver(NorFlashErrorKind),
}

impl NorFlashError for MockError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::NoPower => NorFlashErrorKind::Other,
            Self::Driver(kind) => *kind,
        }
    }
}

/// Two sectors of `SECTOR` bytes in words of `WORD` bytes.
#[derive(Clone)]
pub struct MockFlash<const WORD: usize, const SECTOR: usize> {
    pub bytes: Vec<u8>,
    /// Bits that read as anything.
    unstable: Vec<u8>,
    noise: u64,
    cut: Option<(usize, Tear)>,
    powered: bool,
    /// Words programmed or erased since the flash was made.
    pub steps: usize,
    pub erases: usize,
    pub reads: usize,
    /// Programming and erasing do nothing, without an error.
    pub ignores_writes: bool,
    /// Reads between these addresses fail.
    pub unreadable: core::ops::Range<u32>,
}

impl<const WORD: usize, const SECTOR: usize> MockFlash<WORD, SECTOR> {
    pub const RANGE: core::ops::Range<u32> = 0..2 * SECTOR as u32;

    pub fn erased() -> Self {
        Self::holding(vec![0xFF; 2 * SECTOR])
    }

    pub fn holding(bytes: Vec<u8>) -> Self {
        Self {
            unstable: vec![0; bytes.len()],
            bytes,
            noise: 0x9E37_79B9_7F4A_7C15,
            cut: None,
            powered: true,
            steps: 0,
            erases: 0,
            reads: 0,
            ignores_writes: false,
            unreadable: 0..0,
        }
    }

    /// The power will fail after that many further steps.
    pub fn cut_after(&mut self, steps: usize, tear: Tear) {
        self.cut = Some((self.steps + steps, tear));
        self.noise ^= (steps as u64) << 32 | tear as u64;
    }

    /// The power is back.
    pub fn restart(&mut self) {
        self.cut = None;
        self.powered = true;
    }

    /// A random byte (xorshift).
    fn noise(&mut self) -> u8 {
        self.noise ^= self.noise << 13;
        self.noise ^= self.noise >> 7;
        self.noise ^= self.noise << 17;
        (self.noise >> 32) as u8
    }

    /// Counts the steps of an operation on `words`; `Some` says after how many the power fails.
    fn advance(&mut self, words: usize) -> Option<(usize, Tear)> {
        let before = self.steps;
        self.steps += words;
        let (at, tear) = self.cut.filter(|&(at, _)| at < self.steps)?;
        self.powered = false;
        Some((at - before, tear))
    }

    fn program(&mut self, at: usize, bytes: &[u8]) {
        for (address, byte) in (at..).zip(bytes) {
            self.bytes[address] &= byte;
            self.unstable[address] &= byte;
        }
    }

    fn program_partly(&mut self, at: usize, bytes: &[u8], tear: Tear) {
        for (address, byte) in (at..).zip(bytes) {
            let some = self.noise();
            let under_way = self.bytes[address] & !byte;
            if tear == Tear::Unstable {
                self.unstable[address] |= under_way & some;
            } else {
                self.bytes[address] &= !(under_way & some);
            }
        }
    }

    fn erase_bytes(&mut self, range: core::ops::Range<usize>) {
        self.bytes[range.clone()].fill(0xFF);
        self.unstable[range].fill(0);
    }

    fn erase_partly(&mut self, range: core::ops::Range<usize>, done: usize, tear: Tear) {
        let done = done * WORD;
        match tear {
            Tear::Clean => self.erase_bytes(range.start..range.start + done),
            Tear::Backwards => self.erase_bytes(range.end - done..range.end),
            Tear::Zeroed => self.bytes[range.start..range.start + done].fill(0),
            Tear::Torn => {
                for address in range {
                    self.bytes[address] |= self.noise();
                }
            }
            Tear::Unstable => {
                for address in range {
                    self.unstable[address] |= self.noise();
                }
            }
        }
    }

    fn check<T>(&self, arguments: Result<T, NorFlashErrorKind>) -> Result<T, MockError> {
        if self.powered { arguments.map_err(MockError::Driver) } else { Err(MockError::NoPower) }
    }
}

impl<const WORD: usize, const SECTOR: usize> ErrorType for MockFlash<WORD, SECTOR> {
    type Error = MockError;
}

impl<const WORD: usize, const SECTOR: usize> ReadNorFlash for MockFlash<WORD, SECTOR> {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), MockError> {
        self.check(check_read(self, offset, bytes.len()))?;
        self.reads += 1;
        let end = offset + bytes.len() as u32;
        if offset < self.unreadable.end && self.unreadable.start < end {
            return Err(MockError::Driver(NorFlashErrorKind::Other));
        }
        for (address, byte) in (offset as usize..).zip(bytes) {
            let unstable = self.unstable[address];
            *byte = self.bytes[address];
            if unstable != 0 {
                *byte ^= self.noise() & unstable;
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WORD: usize, const SECTOR: usize> NorFlash for MockFlash<WORD, SECTOR> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), MockError> {
        self.check(check_write(self, offset, bytes.len()))?;
        if self.ignores_writes {
            return Ok(());
        }
        let at = offset as usize;
        let Some((done, tear)) = self.advance(bytes.len() / WORD) else {
            self.program(at, bytes);
            return Ok(());
        };
        let done = done * WORD;
        if tear == Tear::Backwards {
            let from = bytes.len() - done;
            self.program(at + from, &bytes[from..]);
        } else {
            self.program(at, &bytes[..done]);
            if tear != Tear::Clean {
                self.program_partly(at + done, &bytes[done..done + WORD], tear);
            }
        }
        Err(MockError::NoPower)
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), MockError> {
        self.check(check_erase(self, from, to))?;
        self.erases += 1;
        if self.ignores_writes {
            return Ok(());
        }
        let range = from as usize..to as usize;
        match self.advance(range.len() / WORD) {
            None => {
                self.erase_bytes(range);
                Ok(())
            }
            Some((done, tear)) => {
                self.erase_partly(range, done, tear);
                Err(MockError::NoPower)
            }
        }
    }
}
