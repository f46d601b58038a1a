//! Parts of the chip of which the firmware needs little: the timer that measures the crystal, the one that clocks the
//! converter, the converter on the chip, the watch over the supply, and who resets whom.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};

use rsemu::core::device::{DeviceClass, ResetKind};
use rsemu::core::wire::WireSource;
use rsemu::machine::validate::{ClassSchema, PortDir};

use crate::part::{Clock, Part, Wires, class};

static STORE: DeviceClass = class("palpate.registers", "registers that keep what is written");
static ADC: DeviceClass = class("palpate.adc", "ADC1, whose conversions are done at once");
static POWER: DeviceClass = class("palpate.power", "the watch over the supply");
static CAPTURE: DeviceClass =
    class("palpate.capture", "TIM11, which captures edges of the crystal");
static SUPERVISOR: DeviceClass = class("palpate.supervisor", "resets");

/// Registers that keep what is written, as those of a timer that nobody needs to see run.
#[derive(Debug)]
pub struct Kept(Mutex<[u32; 32]>);

impl Kept {
    /// All zero.
    #[must_use]
    pub fn new() -> Arc<Self> {
        Arc::new(Self(Mutex::new([0; 32])))
    }
}

impl Part for Kept {
    fn class() -> &'static DeviceClass {
        &STORE
    }

    fn peek(&self, at: u64) -> u32 {
        self.0.lock().unwrap().get(at as usize / 4).copied().unwrap_or(0)
    }

    fn write(&self, at: u64, value: u32) {
        if let Some(place) = self.0.lock().unwrap().get_mut(at as usize / 4) {
            *place = value;
        }
    }

    fn reset(&self, _: ResetKind) {
        *self.0.lock().unwrap() = [0; 32];
    }
}

/// ADC1 with the temperature sensor: every conversion is done at once. The common registers lie in the same window.
#[derive(Debug)]
pub struct Adc {
    registers: Mutex<[u32; 256]>,
    /// What the sensor reads, counts of 12 bits.
    pub reading: AtomicU32,
    /// Conversions since power came.
    pub conversions: AtomicU32,
}

const ADC_SR: usize = 0x00;
const ADC_CR2: usize = 0x08;
const ADC_DR: u64 = 0x4c;
const EOC: u32 = 1 << 1;
const SWSTART: u32 = 1 << 30;
/// The sensor's reading at 30 °C and 110 °C, as the factory writes them beside the serial number.
pub const FACTORY_READINGS: [u16; 2] = [936, 1_200];

impl Adc {
    /// At 34 °C.
    #[must_use]
    pub fn new() -> Arc<Self> {
        Arc::new(Self {
            registers: Mutex::new([0; 256]),
            reading: AtomicU32::new(950),
            conversions: AtomicU32::new(0),
        })
    }
}

impl Part for Adc {
    fn class() -> &'static DeviceClass {
        &ADC
    }

    fn peek(&self, at: u64) -> u32 {
        if at == ADC_DR {
            return self.reading.load(Relaxed);
        }
        self.registers.lock().unwrap().get(at as usize / 4).copied().unwrap_or(0)
    }

    fn read(&self, at: u64) -> u32 {
        if at == ADC_DR {
            self.registers.lock().unwrap()[ADC_SR / 4] &= !EOC;
        }
        self.peek(at)
    }

    fn write(&self, at: u64, value: u32) {
        let mut registers = self.registers.lock().unwrap();
        if let Some(place) = registers.get_mut(at as usize / 4) {
            *place = value;
        }
        if at == ADC_CR2 as u64 && value & SWSTART != 0 {
            registers[ADC_CR2 / 4] &= !SWSTART;
            registers[ADC_SR / 4] |= EOC;
            self.conversions.fetch_add(1, Relaxed);
        }
    }
}

/// PWR with its voltage detector (RM0090 §5.4).
#[derive(Debug)]
pub struct Power {
    control: AtomicU32,
    /// The supply, mV.
    pub supply_mv: AtomicU32,
}

const PWR_CR: u64 = 0x00;
const PWR_CSR: u64 = 0x04;
const PVDE: u32 = 1 << 4;
const PVDO: u32 = 1 << 2;
const VOSRDY: u32 = 1 << 14;
/// Thresholds of a falling supply by PLS, mV, typical (data sheet of the STM32F405, table 19).
const FALLING_MV: [u32; 8] = [2_040, 2_190, 2_350, 2_510, 2_660, 2_840, 2_930, 3_030];

impl Power {
    /// At 3.3 V.
    #[must_use]
    pub fn new() -> Arc<Self> {
        Arc::new(Self { control: AtomicU32::new(0), supply_mv: AtomicU32::new(3_300) })
    }
}

impl Part for Power {
    fn class() -> &'static DeviceClass {
        &POWER
    }

    fn peek(&self, at: u64) -> u32 {
        let control = self.control.load(Relaxed);
        let threshold = FALLING_MV[((control >> 5) & 7) as usize];
        let low = control & PVDE != 0 && self.supply_mv.load(Relaxed) < threshold;
        match at {
            PWR_CR => control,
            PWR_CSR => VOSRDY | (PVDO * u32::from(low)),
            _ => 0,
        }
    }

    fn write(&self, at: u64, value: u32) {
        if at == PWR_CR {
            self.control.store(value, Relaxed);
        }
    }

    fn reset(&self, _: ResetKind) {
        self.control.store(0, Relaxed);
    }
}

/// TIM11 with its first channel on the crystal (RM0090 §19.4.13): the counter runs with the timer's clock, an edge of
/// HSE/RTCPRE captures it. Times are computed when they are looked at.
#[derive(Debug)]
pub struct Capture {
    registers: Mutex<[u32; 32]>,
    clock: Clock,
    /// Clock of the timer while it measures, Hz: the internal oscillator's.
    counter_hz: u64,
    crystal_hz: u64,
    began: AtomicU64,
    taken: AtomicU64,
}

const TIM_CR1: usize = 0x00;
const TIM_SR: u64 = 0x10;
const TIM_CCMR1: usize = 0x18;
const TIM_CCER: usize = 0x20;
const TIM_CNT: u64 = 0x24;
const TIM_CCR1: u64 = 0x34;
const TIM_OR: usize = 0x50;
const CC1IF: u32 = 1 << 1;
/// OR: input 1 is the crystal, divided as for the clock of the RTC.
const FROM_CRYSTAL: u32 = 2;

impl Capture {
    /// With a crystal, and with an internal oscillator of this frequency; 0 is a crystal that does not swing.
    #[must_use]
    pub fn new(crystal_hz: u64, counter_hz: u64) -> Arc<Self> {
        Arc::new(Self {
            registers: Mutex::new([0; 32]),
            clock: Clock::new(),
            counter_hz,
            crystal_hz,
            began: AtomicU64::new(0),
            taken: AtomicU64::new(0),
        })
    }

    fn register(&self, at: usize) -> u32 {
        self.registers.lock().unwrap()[at / 4]
    }

    fn count(&self) -> u64 {
        self.clock.now().saturating_sub(self.began.load(Relaxed))
    }

    /// Captures so far: every so-many-th edge, as the prescaler of the capture wants it.
    fn captures(&self) -> u64 {
        let is_on = self.register(TIM_CR1) & 1 != 0 && self.register(TIM_CCER) & 1 != 0;
        if !is_on || self.register(TIM_OR) & 3 != FROM_CRYSTAL {
            return 0;
        }
        self.count() * self.crystal_hz / (self.counter_hz * self.edges())
    }

    /// Periods of the crystal from one capture to the next; the RTC's divider is modelled at 31.
    fn edges(&self) -> u64 {
        31 << (self.register(TIM_CCMR1) >> 2 & 3)
    }
}

impl Part for Capture {
    fn class() -> &'static DeviceClass {
        &CAPTURE
    }

    fn peek(&self, at: u64) -> u32 {
        match at {
            TIM_SR => CC1IF * u32::from(self.captures() > self.taken.load(Relaxed)),
            TIM_CNT => self.count() as u32 & 0xffff,
            TIM_CCR1 if self.crystal_hz > 0 => {
                let at = self.captures() * self.edges() * self.counter_hz / self.crystal_hz;
                at as u32 & 0xffff
            }
            _ => self.registers.lock().unwrap().get(at as usize / 4).copied().unwrap_or(0),
        }
    }

    fn read(&self, at: u64) -> u32 {
        self.clock.sync();
        let value = self.peek(at);
        if at == TIM_CCR1 {
            self.taken.store(self.captures(), Relaxed);
        }
        value
    }

    fn write(&self, at: u64, value: u32) {
        self.clock.sync();
        if at == TIM_CR1 as u64 && value & 1 != 0 && self.register(TIM_CR1) & 1 == 0 {
            self.began.store(self.clock.now(), Relaxed);
        }
        if let Some(place) = self.registers.lock().unwrap().get_mut(at as usize / 4) {
            *place = value;
        }
    }

    fn clock(&self) -> Option<&Clock> {
        Some(&self.clock)
    }

    fn advance(&self, to: u64) {
        self.clock.set(to);
    }

    fn reset(&self, _: ResetKind) {
        *self.registers.lock().unwrap() = [0; 32];
        self.taken.store(0, Relaxed);
    }
}

/// Hears the watchdog, and writes the causes of resets where the firmware finds them.
#[derive(Debug, Default)]
pub struct Supervisor {
    watchdog: AtomicBool,
    pins: Wires,
}

impl Supervisor {
    /// Has heard nothing.
    #[must_use]
    pub fn new() -> Arc<Self> {
        Arc::default()
    }

    /// Whether the watchdog has bitten since the last call.
    pub fn has_bitten(&self) -> bool {
        self.watchdog.swap(false, Relaxed)
    }

    /// Writes a cause: `"software"` or `"watchdog"`.
    pub fn was_reset_by(&self, cause: &str) {
        self.pins.drive(cause, true);
        self.pins.drive(cause, false);
    }
}

impl Part for Supervisor {
    fn class() -> &'static DeviceClass {
        &SUPERVISOR
    }

    fn input_named(&self, _: &str) -> Option<u32> {
        Some(0)
    }

    fn input(&self, _: u32, high: bool) {
        if high {
            self.watchdog.store(true, Relaxed);
        }
    }

    fn connect(&self, port: &str, wire: WireSource) {
        self.pins.add(port, wire);
    }
}

/// Pins and registers of all.
pub fn schemas() -> [ClassSchema; 5] {
    [
        ClassSchema::new(STORE.name).region(""),
        ClassSchema::new(ADC.name).region(""),
        ClassSchema::new(POWER.name).region(""),
        ClassSchema::new(CAPTURE.name).region(""),
        ClassSchema::new(SUPERVISOR.name)
            .port("bitten", PortDir::In)
            .port("software", PortDir::Out)
            .port("watchdog", PortDir::Out),
    ]
}
