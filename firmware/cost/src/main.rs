//! Instructions that a sample costs, counted on the emulated Cortex-M4 beside those of rival filters.
//!
//! Under `-icount shift=0` the emulator's clock advances by one nanosecond for each instruction, and its SysTick by one tick
//! for each 1/168 MHz of that; so the counts are the same in every run. `cargo xtask cost` runs it and compares.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::mem::MaybeUninit;

use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_semihosting::{debug, hprintln};
use device::{Beginning, Device, Identity, Lost, Room, Sample, Setting, begin_with};
use dsp_fixedpoint::Q32;
use dsp_process::SplitProcess;
use idsp::iir::{Biquad, DirectForm1, DirectForm1Wide};
use idsp::{Lowpass, LowpassState};
use panic_semihosting as _;
use shared::adaptation;
use shared::pipeline::{Config, GAUGES, Pipeline};
use shared::wire::{
    self, Capabilities, ClockSource, ConverterFault, FRAME_MAX, Head, HelloToDevice, ResetCause,
    SCHEMA, Source, Start, StoreFault, ToDevice,
};

/// Samples that are measured, after so many that are not.
const SAMPLES: u32 = 2_000;
const BEFORE: u32 = 500;
/// SysTick counts 168 MHz of the emulator's nanoseconds.
const TICKS_PER_THOUSAND_INSTRUCTIONS: u64 = 168;

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(0x00ff_ffff);
        core.SYST.clear_current();
        core.SYST.enable_counter();
        measure_all();
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

fn measure_all() {
    rivals();
    let Ok(beginning) = begin_with(None, &IDENTITY.capabilities) else { return };
    let config = black_box(*beginning.config());
    decomposition(&config.adaptation);
    pipeline(&config);
    everything(&beginning);
}

#[inline(never)]
fn rivals() {
    let lowpass = black_box(Lowpass([1 << 24]));
    rival("idsp Lowpass, first order", &lowpass, LowpassState::default);
    let biquad: Biquad<Q32<30>> = [[0.1, 0.2, 0.1], [1.0, -0.9, 0.3]].into();
    let biquad = black_box(biquad);
    rival("idsp Biquad", &biquad, DirectForm1::default);
    rival("idsp Biquad, wide state", &biquad, DirectForm1Wide::default);
}

#[inline(never)]
fn decomposition(config: &adaptation::Config) {
    // As the pipeline holds them: side by side.
    let mut channels = [(*config, adaptation::State::at_rest(0)); GAUGES];
    report("decomposition", press, |counts| {
        for ((config, state), signal) in channels.iter_mut().zip(counts) {
            black_box(state.step(config, *signal));
        }
    });
}

#[inline(never)]
fn pipeline(config: &Config) {
    let mut pipeline = Pipeline::new(config);
    report("calibration, decomposition, regions", press, |counts| {
        pipeline.process(counts, 25 * 256);
        black_box(&pipeline);
    });
}

#[inline(never)]
fn everything(beginning: &Beginning) {
    let Some(room) = cortex_m::singleton!(: Room = Room::new()) else { return };
    let Some(place) = cortex_m::singleton!(: MaybeUninit<Device<'static>> = MaybeUninit::uninit())
    else {
        return;
    };
    let device = place.write(Device::new(IDENTITY, beginning, room));
    say(device, 1, &ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "" }));
    let start = Start { source: Source::Converter, columns: wire::Columns::Parts };
    say(device, 2, &ToDevice::Start(start));
    let mut frame = [0; FRAME_MAX];
    let mut sent = 0;
    let sample = |number| {
        let time_us = u64::from(number) * 1_024;
        Sample { time_us, counts: press(number), lost: Lost::NONE }
    };
    report("whole pipeline with framing", sample, |sample| {
        device.sample(sample);
        while let Some(bytes) = device.next_frame(sample.time_us, &mut (), &mut frame) {
            sent += black_box(bytes).len();
        }
    });
    hprintln!("bytes per sample {}", sent / (SAMPLES + BEFORE) as usize);
}

/// A filter of others in the same loop.
fn rival<F: SplitProcess<i32, i32, S>, S>(name: &str, filter: &F, state: impl Fn() -> S) {
    let mut states = [state(), state(), state(), state()];
    report(name, press, |counts| {
        for (state, signal) in states.iter_mut().zip(counts) {
            black_box(filter.process(state, *signal));
        }
    });
}

/// A press, a hold and a release with noise, counts of four gauges.
fn press(sample: u32) -> [i32; GAUGES] {
    let ramp = |from: u32, over: u32| sample.saturating_sub(from).min(over) as i32;
    let up = ramp(200, 500) - ramp(1_700, 500);
    let noise = (sample.wrapping_mul(1_103_515_245).wrapping_add(12_345) >> 20) as i32 & 127;
    [up * 1_000 + noise, up * 700 - noise, up * 400 + noise / 2, noise - up * 100]
}

/// Prints instructions per gauge and sample of a step; what it is given is made beforehand.
fn report<T>(name: &str, given: impl Fn(u32) -> T, mut step: impl FnMut(&T)) {
    let mut ticks = 0;
    for sample in 0..BEFORE + SAMPLES {
        let given = black_box(given(sample));
        let before = SYST::get_current();
        step(&given);
        // It counts down, 24 bits.
        let took = before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff;
        if sample >= BEFORE {
            ticks += u64::from(took);
        }
    }
    let tenths =
        ticks * 10_000 / TICKS_PER_THOUSAND_INSTRUCTIONS / u64::from(SAMPLES) / GAUGES as u64;
    hprintln!("{} {}.{}", name, tenths / 10, tenths % 10);
}

const IDENTITY: Identity<'static> = Identity {
    version: "",
    git: "",
    board: "",
    serial: [0; 3],
    converter_clock_hz: 8_000_000,
    converter: "ADS131M04",
    capabilities: Capabilities::ads131m04(8_000_000),
    clock: ClockSource::Internal,
    reset: ResetCause::PowerOn,
    panic: "",
};

fn say(device: &mut Device<'_>, sequence: u32, command: &ToDevice<'_>) {
    let mut frame = [0; FRAME_MAX];
    if let Ok(bytes) =
        wire::encode(Head { sequence, time_us: 0 }, command, &mut frame).map(<[u8]>::len)
    {
        device.receive(&mut frame[..bytes - 1], 0, &mut Desk);
    }
}

/// No hardware.
struct Desk;

impl device::Board for Desk {
    fn configure(&mut self, _: Setting) -> Result<(), ConverterFault> {
        Ok(())
    }
    fn listen(&mut self, _: bool) -> Lost {
        Lost::NONE
    }
    fn store(&mut self, _: &[u8]) -> Result<(), StoreFault> {
        Err(StoreFault::NotWritten)
    }
    fn can_restart(&self, _: device::Restart) -> bool {
        false
    }
}
