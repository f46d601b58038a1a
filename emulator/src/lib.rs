//! The fingertip's board as a model: the very bytes that are flashed run on an emulated STM32F405 with a crystal, the pins'
//! interrupts, a bus with an ADS131M04 that can fail, and a line on which a byte that is not fetched in time is lost.
//!
//! Time is the model's own, so every run gives the same bytes; nothing waits for the clock on the wall.

mod cable;
mod conversation;
mod converter;
mod load;
mod part;
mod shared_line;
mod small_parts;
mod usart;
mod usb;
mod widened;

pub use cable::{Cable, Over};
pub use conversation::{Asked, BOOT_MS, Heard, sheet};
pub use converter::{CLOCK_HZ as CONVERTER_CLOCK_HZ, Chip, Converter, Fault};
pub use load::Load;
pub use shared_line::SharedLine;
pub use small_parts::{Adc, FACTORY_READINGS, Power};
pub use usart::Wire;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

use rsemu::bus::spi::buses;
use rsemu::core::clock::GlobalTime;
use rsemu::core::device::{Device, ResetKind};
use rsemu::core::space::MemAttrs;
use rsemu::core::value::Width;
use rsemu::cpu::arm::v7m::ArmV7m;
use rsemu::dev::stm32::iwdg::Iwdg;
use rsemu::machine::{Instance, Machine, build, catalog};

use cable::ROUND_NS;
use part::{Model, Part};
use small_parts::{Capture, Kept, Supervisor};
use usart::{Line, Usart};
use usb::Usb;

/// A thousandth of a second, ns.
pub const MS: u64 = 1_000_000;

/// Flash and its size.
const FLASH: u64 = 0x0800_0000;
const FLASH_BYTES: usize = 1 << 20;
/// Resets that the processor or the watchdog asks for are done this late at most, ns.
const RESET_NS: u64 = 200_000;

/// What the board is made of.
#[derive(Clone, Debug)]
pub struct Setup {
    /// What its flash holds, from its beginning on.
    pub flash: Vec<u8>,
    /// Frequency of its crystal, MHz.
    pub crystal_mhz: u32,
    /// How much faster than that its crystal is, parts per million.
    pub crystal_ppm: i64,
    /// True frequency of its internal oscillator, which should be 16 MHz, Hz: it sets what the crystal seems to be.
    pub internal_hz: u64,
    /// Whether its USB core works.
    pub has_usb: bool,
    /// Frequency of the watchdog's oscillator, which should be 32 kHz, Hz: a faster one makes the watchdog less patient.
    pub watchdog_hz: u32,
    /// Whether the converter's clock is another finger's, which is said by a joint to ground.
    pub is_clocked: bool,
    /// Parts see events of each other this late at most, ns; a core that they wake stands still for as long.
    pub quantum_ns: u64,
}

impl Setup {
    /// A board with a crystal of 12 MHz and the firmware that `cargo xtask firmware` left.
    ///
    /// # Panics
    /// If it is not there.
    #[must_use]
    pub fn new() -> Self {
        let path = firmware();
        let flash = std::fs::read(&path).unwrap_or_else(|error| {
            panic!("{}: {error}; cargo xtask firmware makes it", path.display())
        });
        Self {
            flash,
            crystal_mhz: 12,
            crystal_ppm: 0,
            internal_hz: 16_000_000,
            has_usb: true,
            watchdog_hz: 32_000,
            is_clocked: false,
            quantum_ns: 2_000,
        }
    }
}

impl Default for Setup {
    fn default() -> Self {
        Self::new()
    }
}

/// The image that is flashed.
#[must_use]
pub fn firmware() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/firmware/palpate.bin")
}

/// A board under power.
pub struct Board {
    machine: Machine,
    cpu: Arc<ArmV7m>,
    converter: Arc<Converter>,
    usart: Arc<Usart>,
    line: Arc<Line>,
    usb: Arc<Usb>,
    supervisor: Arc<Supervisor>,
    /// The converter on the chip.
    pub thermometer: Arc<Adc>,
    /// The supply.
    pub power: Arc<Power>,
    /// The wire that it shares with other fingers.
    pub shared_line: Arc<SharedLine>,
    /// The cable in its socket.
    pub cable: Cable,
    over: Over,
    /// The talk with it.
    pub heard: Heard,
    resets: u32,
}

impl Board {
    /// Power comes.
    ///
    /// # Panics
    /// If the emulator refuses the machine's description.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        let mut options = catalog::build_options().unwrap();
        let mut registry = catalog::registry().unwrap();
        let converter =
            Converter::new(buses::open(&options.realize.hosts, "spi2").unwrap(), setup.is_clocked);
        let usart = Usart::new();
        let line = Line::new(usart.clone());
        let usb = Usb::new(setup.has_usb);
        let supervisor = Supervisor::new();
        let thermometer = Adc::new();
        let power = Power::new();
        let shared_line = SharedLine::new();
        let crystal_hz = (i64::from(setup.crystal_mhz) * (1_000_000 + setup.crystal_ppm)) as u64;
        let capture = Capture::new(crystal_hz, setup.internal_hz);

        let schemas = usart::schemas().into_iter().chain(small_parts::schemas());
        for schema in schemas.chain([converter::schema(), usb::schema(), shared_line::schema()]) {
            options.classes.insert(schema);
        }
        let mut add = |class, make: Box<dyn Fn() -> Arc<dyn Instance> + Send + Sync>| {
            registry.add(class).unwrap();
            options.bindings.bind(class.name, move |_| Ok(make())).unwrap();
        };
        add(Usart::class(), one(&usart));
        add(Line::class(), one(&line));
        add(Converter::class(), one(&converter));
        add(Usb::class(), one(&usb));
        add(Supervisor::class(), one(&supervisor));
        add(Adc::class(), one(&thermometer));
        add(Power::class(), one(&power));
        add(Capture::class(), one(&capture));
        add(SharedLine::class(), one(&shared_line));
        add(Kept::class(), Box::new(|| Arc::new(Model::new(Kept::new()))));
        options.bindings.replace("st.iwdg", |properties| {
            Ok(Arc::new(widened::Widened::new(Arc::new(Iwdg::new(properties)?))))
        });
        let held: Arc<Mutex<Option<Arc<ArmV7m>>>> = Arc::default();
        let place = held.clone();
        options.bindings.replace("cpu.arm.v7m", move |properties| {
            let cpu = Arc::new(ArmV7m::from_props(properties)?);
            *place.lock().unwrap() = Some(cpu.clone());
            Ok(cpu)
        });
        options.realize.scheduler.quantum = GlobalTime::from_nanos(setup.quantum_ns);
        options.realize.media.insert("firmware", setup.flash.clone());
        options.realize.media.insert("system", system_memory());
        let description = include_str!("../board.machine")
            .replace("@HZ@", &crystal_hz.to_string())
            .replace("@MHZ@", &setup.crystal_mhz.to_string())
            .replace("@LSI@", &setup.watchdog_hz.to_string());
        let machine = match build("board.machine", &description, &registry, &options) {
            Ok(machine) => machine,
            Err(error) => panic!("{error}"),
        };
        let cpu = held.lock().unwrap().clone().unwrap();
        let heard = Heard::default();
        Self {
            machine,
            cpu,
            converter,
            usart,
            line,
            usb,
            supervisor,
            thermometer,
            power,
            shared_line,
            cable: Cable::default(),
            over: Over::Serial,
            heard,
            resets: 0,
        }
    }

    /// Time passes, ns.
    ///
    /// # Panics
    /// If the emulator fails.
    pub fn run_ns(&mut self, ns: u64) {
        let until = self.now_ns() + ns;
        while self.now_ns() < until {
            let most = if self.usb.is_connected() { ROUND_NS } else { RESET_NS };
            let step = (until - self.now_ns()).min(most);
            self.machine.run_for(GlobalTime::from_nanos(step)).unwrap();
            self.move_packets();
            let bitten = self.supervisor.has_bitten();
            if bitten || self.cpu.reset_requested() {
                self.cpu.clear_reset_request();
                self.machine.reset(ResetKind::Warm);
                // The emulator's own leaves the timer of the core and the enabled interrupts as they were.
                self.cpu.reset(ResetKind::Cold);
                self.supervisor.was_reset_by(if bitten { "watchdog" } else { "software" });
                self.resets += 1;
            }
        }
    }

    /// Time since power came, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.machine.now().as_nanos()
    }

    /// Resets since power came.
    #[must_use]
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// The converter, to look at and to break.
    pub fn converter(&self) -> MutexGuard<'_, Chip> {
        self.converter.chip()
    }

    /// The line.
    pub fn wire(&self) -> MutexGuard<'_, Wire> {
        self.usart.wire()
    }

    /// Bytes from the host.
    pub fn send(&mut self, bytes: &[u8]) {
        match self.over {
            Over::Serial => self.line.send(bytes),
            Over::Usb => self.cable.queue.extend(bytes),
        }
    }

    /// Bytes that came over the line that the host speaks over, from one of them on.
    pub(crate) fn came(&self, from: usize) -> Vec<u8> {
        match self.over {
            Over::Serial => self.wire().sent[from..].to_vec(),
            Over::Usb => self.cable.sent[from..].to_vec(),
        }
    }

    /// The host speaks over this line from now on, and hears what comes there from now on.
    pub fn speak_over(&mut self, over: Over) {
        self.over = over;
        let passed = self.came(0).len();
        self.heard.begin_at(passed);
    }

    /// Whether the device shows itself on USB.
    #[must_use]
    pub fn is_on_usb(&self) -> bool {
        self.usb.is_connected()
    }

    /// The processor.
    #[must_use]
    pub fn cpu(&self) -> &ArmV7m {
        &self.cpu
    }

    /// A word of memory or a register, without effect.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn peek(&self, address: u64) -> u32 {
        let memory = self.machine.space("mem").unwrap();
        memory.read(address, Width::U32, MemAttrs::DEBUG).unwrap() as u32
    }

    /// What the flash holds: power may be cut now, and come again with this.
    #[must_use]
    pub fn flash(&self) -> Vec<u8> {
        let words = (0..FLASH_BYTES as u64).step_by(4).map(|at| self.peek(FLASH + at));
        words.flat_map(u32::to_le_bytes).collect()
    }

    /// A clock of the chip, Hz.
    ///
    /// # Panics
    /// If there is none of this name.
    #[must_use]
    pub fn clock_hz(&self, name: &str) -> f64 {
        let domain = self.machine.device(name).unwrap().domain().unwrap();
        let rate = self.machine.clocks().domain_frequency(domain).unwrap();
        rate.num() as f64 / rate.den() as f64
    }
}

/// The one part of its kind.
fn one<P: Part>(part: &Arc<P>) -> Box<dyn Fn() -> Arc<dyn Instance> + Send + Sync> {
    let part = part.clone();
    Box::new(move || Arc::new(Model::new(part.clone())))
}

/// What the factory wrote: a loader that does nothing, serial number, size of the flash, readings of the temperature sensor.
fn system_memory() -> Vec<u8> {
    let mut memory = vec![0; 32 * 1024];
    let [stack, entry] = [0x2000_1000_u32, 0x1fff_0009].map(u32::to_le_bytes);
    memory[..8].copy_from_slice(&[stack, entry].concat());
    // A branch to itself.
    memory[8..10].copy_from_slice(&[0xfe, 0xe7]);
    memory[0x7a10..0x7a1c].copy_from_slice(b"a model only");
    memory[0x7a22..0x7a24].copy_from_slice(&1_024_u16.to_le_bytes());
    let [cold, warm] = FACTORY_READINGS.map(u16::to_le_bytes);
    memory[0x7a2c..0x7a30].copy_from_slice(&[cold, warm].concat());
    memory
}
