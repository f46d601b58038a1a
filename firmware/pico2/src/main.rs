//! The palpate fingertip on a Raspberry Pi Pico 2 (RP2350), with nothing but its USB cable to the host.
//!
//! What it does is in the crate `device`; here is what drives it. One interrupt reads the converter into a queue; everything else
//! is done in turn by [`device::Runner`], and the bus of USB holds the host back where it must.
//!
//! | signal | pin | function |
//! |-|-|-|
//! | converter MISO, CS, SCK, MOSI | GP16, GP17, GP18, GP19 | SPI0 |
//! | converter SYNC/RESET | GP20 | |
//! | converter CLKIN | GP21 | clock output 0: 8 MHz, a sixth of the 48 MHz of USB |
//! | converter DRDY | GP22 | falling edge |
//! | with the feature `nau7802`: SDA, SCL | GP16, GP17 | I2C0; DRDY as above, the others free |
//! | lamp | GP25 | on the board |
#![no_std]
#![no_main]

mod converter;
mod flash;
mod hardware;

use core::cell::RefCell;
use core::iter::from_fn;

use cortex_m::singleton;
use critical_section::Mutex;
use device::{
    Converter, Device, FrontEnd, Identity, Link, Restart, Room, Runner, Sample, begin_with,
};
use embedded_hal::digital::OutputPin;
use hal::fugit::ExtU32;
use hal::gpio::bank0::Gpio22;
use hal::gpio::{FunctionSioInput, FunctionSioOutput, Interrupt, Pin, PullNone, PullUp};
use hal::pac::{self, interrupt};
use hal::reboot::{RebootArch, RebootKind, reboot};
use heapless::spsc::{Consumer, Producer, Queue};
use rp235x_hal as hal;
use shared::wire::{ClockSource, ResetCause, Settings};
use usb::{Frame, SerialNumber, UsbLine};
use usb_device::bus::UsbBusAllocator;

use converter::{CLOCK_HZ, Chip, Parts, chip};
use flash::Memory;
use hardware::{Hardware, Time, with_edge};

/// What the loader in ROM must know of this image.
#[unsafe(link_section = ".start_block")]
#[used]
static IMAGE: hal::block::ImageDef = hal::block::ImageDef::secure_exe();

/// The board's crystal, Hz.
const CRYSTAL_HZ: u32 = 12_000_000;
/// The watchdog's patience, ms.
const PATIENCE_MS: u32 = 8_000;
/// Time between two looks at what has no event of its own, µs.
const TICK_US: u64 = 10_000;

/// Rows that may wait for the filter, plus one.
const SAMPLES: usize = 65;
/// Bytes that may wait to be understood, plus one.
const BYTES: usize = 513;
/// Frames that may wait for the bus, plus one.
const FRAMES: usize = 4;

/// What the interrupt of the converter needs.
struct Edge {
    time: Time,
    drdy: Pin<Gpio22, FunctionSioInput, PullUp>,
    front_end: FrontEnd<Chip, Time>,
    samples: Producer<'static, Sample>,
}

static EDGE: Mutex<RefCell<Option<Edge>>> = Mutex::new(RefCell::new(None));

/// The queues of the cable, as the device's line.
struct Cable {
    bytes: Consumer<'static, u8>,
    frames: Producer<'static, Frame>,
}

impl Link for Cable {
    fn receive(&mut self) -> Option<u8> {
        self.bytes.dequeue()
    }

    fn has_room(&self) -> bool {
        self.frames.ready()
    }

    fn send(&mut self, frame: &[u8]) {
        if let Ok(frame) = Frame::from_slice(frame) {
            // There is room.
            let _ = self.frames.enqueue(frame);
        }
    }
}

#[hal::entry]
fn main() -> ! {
    let Some(mut p) = pac::Peripherals::take() else { begin_again(Restart::Firmware) };
    let why = cause(&p.POWMAN, &p.WATCHDOG);
    let mut watchdog = hal::Watchdog::new(p.WATCHDOG);
    let clocks = hal::clocks::init_clocks_and_plls(
        CRYSTAL_HZ,
        p.XOSC,
        p.CLOCKS,
        p.PLL_SYS,
        p.PLL_USB,
        &mut p.RESETS,
        &mut watchdog,
    );
    let Ok(mut clocks) = clocks else { begin_again(Restart::Firmware) };
    let time = Time(hal::Timer::new_timer0(p.TIMER0, &mut p.RESETS, &clocks));
    let pins = hal::gpio::Pins::new(
        p.IO_BANK0,
        p.PADS_BANK0,
        hal::Sio::new(p.SIO).gpio_bank0,
        &mut p.RESETS,
    );

    let parts = Parts {
        spi: p.SPI0,
        i2c: p.I2C0,
        gp16: pins.gpio16,
        gp17: pins.gpio17,
        gp18: pins.gpio18,
        gp19: pins.gpio19,
        gp20: pins.gpio20,
        gp21: pins.gpio21,
        clocks: &mut clocks,
        resets: &mut p.RESETS,
    };
    let Some(converter) = chip(parts) else { begin_again(Restart::Firmware) };
    let capabilities = converter.capabilities();
    let drdy: Pin<Gpio22, FunctionSioInput, PullUp> = pins.gpio22.reconfigure();
    drdy.set_interrupt_enabled(Interrupt::EdgeLow, true);
    let mut lamp: Pin<_, FunctionSioOutput, PullNone> = pins.gpio25.reconfigure();

    let mut memory = Memory;
    let mut record = [0; Settings::RECORD];
    let kept = memory.load(&mut record);
    let Ok(beginning) = begin_with(kept, &capabilities) else { begin_again(Restart::Firmware) };
    let identity = Identity {
        version: env!("CARGO_PKG_VERSION"),
        git: env!("PALPATE_GIT"),
        board: "pico2",
        serial: serial(),
        converter_clock_hz: CLOCK_HZ,
        converter: <Chip as Converter>::PART,
        capabilities,
        clock: ClockSource::Crystal,
        reset: why,
        panic: "",
    };

    let samples = singleton!(: Queue<Sample, SAMPLES> = Queue::new());
    let bytes = singleton!(: Queue<u8, BYTES> = Queue::new());
    let frames = singleton!(: Queue<Frame, FRAMES> = Queue::new());
    let (Some(samples), Some(bytes), Some(frames)) = (samples, bytes, frames) else {
        begin_again(Restart::Firmware)
    };
    let (samples_in, mut samples) = samples.split();
    let (mut bytes_in, bytes) = bytes.split();
    let (frames_in, mut frames) = frames.split();
    let bus = hal::usb::UsbBus::new(p.USB, p.USB_DPRAM, clocks.usb_clock, true, &mut p.RESETS);
    let bus = UsbBusAllocator::new(bus);
    let number = SerialNumber::new(identity.serial);
    let Some(mut usb) = UsbLine::new(&bus, &number) else { begin_again(Restart::Firmware) };
    let mut cable = Cable { bytes, frames: frames_in };
    let mut room = Room::new();
    let mut runner = Runner::new(Device::new(identity, &beginning, &mut room));

    let front_end = FrontEnd::new(converter, time);
    let edge = Edge { time, drdy, front_end, samples: samples_in };
    critical_section::with(|section| EDGE.borrow(section).replace(Some(edge)));
    // SAFETY: what the interrupt needs is in its place.
    unsafe { cortex_m::peripheral::NVIC::unmask(pac::Interrupt::IO_IRQ_BANK0) };
    watchdog.start(PATIENCE_MS.millis());

    let mut ticked_us = 0;
    let mut restart_at_us = None;
    loop {
        let now_us = time.now_us();
        let polled = usb.poll(&mut bytes_in, &mut frames);
        let mut hardware = Hardware { time, memory: &mut memory };
        let mut came = from_fn(|| samples.dequeue());
        let asked = runner.turn(now_us, &mut cable, &mut came, &mut hardware, &mut ());
        let asked = asked.or(polled.touched.then_some(Restart::Bootloader));
        // What is on its way to the host takes no longer than this.
        restart_at_us = restart_at_us.or(asked.map(|into| (now_us + 20_000, into)));
        if let Some((at_us, into)) = restart_at_us
            && now_us >= at_us
        {
            begin_again(into);
        }
        if now_us - ticked_us >= TICK_US {
            ticked_us = now_us;
            if let Some((found, listens)) =
                with_edge(|edge| (edge.front_end.look_after(now_us), edge.front_end.is_listening()))
            {
                runner.device.look(found, listens);
            }
            let Ok(()) = lamp.set_state(runner.device.lamp().is_lit(now_us).into());
            watchdog.feed();
        }
    }
}

/// The converter has something to read.
#[interrupt]
fn IO_IRQ_BANK0() {
    with_edge(|edge| {
        let now_us = edge.time.now_us();
        edge.drdy.clear_interrupt(Interrupt::EdgeLow);
        let Some(sample) = edge.front_end.ready(now_us) else { return };
        if let Err(sample) = edge.samples.enqueue(sample) {
            edge.front_end.found_queue_full(&sample);
        }
    });
}

/// Why the chip began.
fn cause(power: &pac::POWMAN, watchdog: &pac::WATCHDOG) -> ResetCause {
    let why = power.chip_reset().read();
    if watchdog.reason().read().timer().bit_is_set() {
        ResetCause::Watchdog
    } else if watchdog.reason().read().force().bit_is_set() {
        ResetCause::Software
    } else if why.had_bor().bit_is_set() {
        ResetCause::BrownOut
    } else if why.had_run_low().bit_is_set() {
        ResetCause::Pin
    } else {
        ResetCause::PowerOn
    }
}

/// 64 bits that no other chip has, with 32 more of its package (RP2350 data sheet, `get_sys_info`).
fn serial() -> [u32; 3] {
    const CHIP_INFO: u32 = 1;
    let mut words = [0_u32; 4];
    // SAFETY: the function in ROM writes no more words than it is told there are.
    let written = unsafe { hal::rom_data::get_sys_info(words.as_mut_ptr(), 4, CHIP_INFO) };
    let [_, package, device, wafer] = words;
    if written >= 4 { [package, device, wafer] } else { [0; 3] }
}

/// Begins again, as after power-on or in the loader in ROM.
fn begin_again(into: Restart) -> ! {
    let kind = match into {
        Restart::Firmware => RebootKind::Normal,
        Restart::Bootloader => {
            RebootKind::BootSel { picoboot_disabled: false, msd_disabled: false }
        }
    };
    reboot(kind, RebootArch::Normal)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    begin_again(Restart::Firmware)
}
