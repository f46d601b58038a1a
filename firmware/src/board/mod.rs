//! The board: clocks, pins, and what else is soldered. Every board with an STM32F405 that brings these pins out will do.
//!
//! | signal | pin | Feather | function |
//! |-|-|-|-|
//! | converter SCK, MISO, MOSI | PB13, PB14, PB15 | SCK, MI, MO | SPI2 |
//! | converter CS | PB9 | 10 | |
//! | converter SYNC/RESET | PB8 | 9 | |
//! | converter DRDY | PC7 | 5 | EXTI7, falling; TIM3 channel 2 catches its time |
//! | converter CLKIN | PC6 | 6 | TIM8 channel 1, 8 MHz; left alone if PB6 is joined to ground |
//! | clock of another finger | PB6 | SCL | joined to ground where CLKIN comes from there |
//! | USB D−, D+ | PA11, PA12 | the socket | OTG_FS |
//! | line that fingers share, what this one hears | PA6 | A2 | TIM3 channel 1 catches when it rises |
//! | the same, what this one says | PA7 | A3 | joined to the line on one finger only |
//! | lamp | PC1 | on the board | |
//! | link TX, RX | PB10, PB11 | TX, RX | USART3, 1,000,000 baud, 8N1; DMA1 stream 3 carries what is sent |

pub mod clocks;
mod crystal;
pub mod edge;
pub mod fingerprint;
pub mod flash;
pub mod receiver;
pub mod reset;
pub mod shared_line;
pub mod socket;
pub mod stack;
pub mod supply;
pub mod temperature;
pub mod time;
pub mod transmitter;
pub mod watchdog;

/// Clock of the converter, Hz: the timer's 168 MHz by 21, or the internal 16 MHz by 2.
pub const CONVERTER_CLOCK_HZ: u32 = 8_000_000;
/// Clock of the converter's bus, Hz, at most.
pub const SPI_HZ: u32 = 11_000_000;

/// Name of the chip; the boards that have it differ in the crystal, which is measured.
pub const NAME: &str = "stm32f405";
