//! The palpate fingertip: four strain gauges in silicone, read, decomposed and streamed.
//!
//! What it does is in the crate `device`, which the host's simulated device shares. Here is what drives it:
//!
//! ```text
//! priority 4   read       DRDY interrupt: reads the converter, stamps the time     ── queue of samples ──┐
//! priority 3   line       USART interrupt: one byte in, one byte out               ── queue of bytes ──┐ │
//! priority 2   command    cuts frames, carries out commands                        ◄───────────────────┘ │
//! priority 2   send       asks the device for frames                               ── queue of frames ─► line
//! priority 2   tick       every 10 ms: status, watchdog, temperature                                     │
//! priority 1   filter     calibrates and decomposes                                ◄─────────────────────┘
//! ```
//!
//! Interrupts do the least; nothing waits for the host; what finds a queue full is counted. The device's state is shared by
//! the lower priorities, one row or one command at a time, so settings change between two rows.
#![no_std]
#![no_main]

mod board;
mod front_end;
mod hardware;
mod log;
mod memory;
mod wake;

defmt::timestamp!("{=u64:us}", board::time::now_us());

/// Rows that may wait for the filter, plus one.
const SAMPLES: usize = 65;
/// Bytes that may wait for the command task, plus one.
const BYTES: usize = 513;
/// Frames that may wait for the line, plus one.
const FRAMES: usize = 4;

/// Bytes on their way to the line.
type Frame = heapless::Vec<u8, { shared::wire::FRAME_MAX }>;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [EXTI0, EXTI1])]
mod app {
    use core::mem::MaybeUninit;
    use core::sync::atomic::{AtomicU32, Ordering};
    use defmt::{info, warn};
    use device::{Blocks, Device, Identity, Sample, begin_with};
    use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
    use embedded_hal_nb::serial::{Read, Write};
    use heapless::spsc::{Consumer, Producer, Queue};
    use rtic_monotonics::{Timebase, fugit, systick_monotonic};
    use rtic_sync::signal::SignalReader;
    use shared::wire::{Accumulated, Accumulator, BAUD, FRAME_MAX, Hello};
    use stm32f4xx_hal::gpio::{Edge, Input, Output, PB8, PB9, PC7, Speed};
    use stm32f4xx_hal::pac::{Interrupt, SPI2, USART3};
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::serial::{self, Rx, RxISR, RxListen, Serial, Tx, TxISR, TxListen};
    use stm32f4xx_hal::spi::Spi;

    use crate::board::temperature::Thermometer;
    use crate::board::watchdog::{Stage, Watchdog, progress};
    use crate::board::{self, clocks, fingerprint, reset, stack, time};
    use crate::front_end::{Cycles, FrontEnd};
    use crate::hardware::Hardware;
    use crate::memory::Memory;
    use crate::wake::{self, give_way, wake};
    use crate::{BYTES, FRAMES, Frame, SAMPLES, log};

    systick_monotonic!(Mono, 1_000);

    async fn sleep_ms(time: u32) {
        <Mono as Timebase>::delay(fugit::TimerDurationU32::from_ticks(time)).await;
    }

    type Board = Hardware<ExclusiveDevice<Spi<SPI2>, PB9<Output>, NoDelay>, PB8<Output>>;

    #[shared]
    struct Shared {
        device: &'static mut Device<'static>,
        hardware: Board,
    }

    #[local]
    struct Local {
        drdy: PC7<Input>,
        samples_in: Producer<'static, Sample>,
        samples: Consumer<'static, Sample>,
        rx: Rx<USART3>,
        tx: Tx<USART3>,
        bytes_in: Producer<'static, u8>,
        bytes: Consumer<'static, u8>,
        frames_in: Producer<'static, Frame>,
        frames: Consumer<'static, Frame>,
        filter_wakes: SignalReader<'static, ()>,
        command_wakes: SignalReader<'static, ()>,
        send_wakes: SignalReader<'static, ()>,
        thermometer: Option<Thermometer>,
        watchdog: Watchdog,
    }

    #[init(local = [
        sample_queue: Queue<Sample, SAMPLES> = Queue::new(),
        byte_queue: Queue<u8, BYTES> = Queue::new(),
        frame_queue: Queue<Frame, FRAMES> = Queue::new(),
        blocks: Blocks = Blocks::new(),
        device_place: MaybeUninit<Device<'static>> = MaybeUninit::uninit(),
        panic: [u8; Hello::PANIC] = [0; Hello::PANIC],
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let p = cx.device;
        let panic = reset::last_words(cx.local.panic, &p.RCC, &p.SYSCFG);
        let why = reset::cause(&p.RCC);
        let fingerprint = fingerprint::read(&p.RCC);
        let (mut rcc, clock) = clocks::start(p.RCC);
        let sysclk = rcc.clocks.sysclk();
        time::start(p.TIM2, &mut rcc);
        Mono::start(cx.core.SYST, sysclk.raw());

        let (b, c) = (p.GPIOB.split(&mut rcc), p.GPIOC.split(&mut rcc));
        // Its clock must run before the converter is spoken to.
        let (_, (clkin, ..)) = p.TIM8.pwm_hz(board::CONVERTER_CLOCK_HZ.Hz(), &mut rcc);
        let mut clkin = clkin.with(c.pc6);
        clkin.set_duty(clkin.get_max_duty() / 2);
        clkin.enable();
        let spi = Spi::new(
            p.SPI2,
            (Some(b.pb13), Some(b.pb14), Some(b.pb15)),
            ads131m04::SPI_MODE,
            board::SPI_HZ.Hz(),
            &mut rcc,
        );
        let select = b.pb9.into_push_pull_output_in_state(stm32f4xx_hal::gpio::PinState::High);
        let mut reset_line = b.pb8.into_push_pull_output();
        reset_line.set_speed(Speed::Low);
        let Ok(bus) = ExclusiveDevice::new_no_delay(spi, select);
        let front_end = FrontEnd::new(bus, reset_line, Cycles { per_us: sysclk.to_MHz() });
        let mut drdy = c.pc7.into_pull_up_input();
        drdy.make_interrupt_source(&mut p.SYSCFG.constrain(&mut rcc));
        let mut exti = p.EXTI;
        drdy.trigger_on_edge(&mut exti, Edge::Falling);
        drdy.enable_interrupt(&mut exti);

        let config = serial::Config::default().baudrate(BAUD.bps());
        let link: Serial<USART3> = match Serial::new(p.USART3, (b.pb10, b.pb11), config, &mut rcc) {
            Ok(link) => link,
            Err(_) => reset::die("the link's clock does not divide to its baud rate"),
        };
        let (tx, mut rx) = link.split();
        rx.listen();

        let mut memory = Memory::new(p.FLASH, fingerprint.is_some());
        let Ok(settings) = begin_with(memory.load(), board::CONVERTER_CLOCK_HZ) else {
            reset::die("the default settings are out of range");
        };
        let identity = Identity {
            version: env!("CARGO_PKG_VERSION"),
            git: env!("PALPATE_GIT"),
            board: board::NAME,
            serial: fingerprint.map_or([0; 3], |known| known.serial),
            converter_clock_hz: board::CONVERTER_CLOCK_HZ,
            clock,
            reset: why,
            panic,
        };
        // Made where it stays: the stack has no room for copies.
        let device = cx.local.device_place.write(Device::new(identity, &settings, cx.local.blocks));
        info!("palpate {} on {}, {} MHz", identity.version, board::NAME, sysclk.to_MHz());

        let (samples_in, samples) = cx.local.sample_queue.split();
        let (bytes_in, bytes) = cx.local.byte_queue.split();
        let (frames_in, frames) = cx.local.frame_queue.split();
        let thermometer =
            fingerprint.map(|known| Thermometer::new(p.ADC1, &mut rcc, known.temperature));
        // Each of these runs for ever and is spawned once.
        let _ = (filter::spawn(), command::spawn(), send::spawn(), tick::spawn());
        (
            Shared { device, hardware: Hardware { front_end, memory } },
            Local {
                drdy,
                samples_in,
                samples,
                rx,
                tx,
                bytes_in,
                bytes,
                frames_in,
                frames,
                filter_wakes: wake::FILTER.take_reader(),
                command_wakes: wake::COMMAND.take_reader(),
                send_wakes: wake::SEND.take_reader(),
                thermometer,
                watchdog: Watchdog::start(p.IWDG),
            },
        )
    }

    /// An edge of the converter's data-ready line.
    #[task(binds = EXTI9_5, priority = 4, local = [drdy, samples_in], shared = [hardware])]
    fn read(mut cx: read::Context) {
        cx.local.drdy.clear_interrupt_pending_bit();
        cx.shared.hardware.lock(|Hardware { front_end, .. }| {
            let Some(sample) = front_end.ready() else { return };
            if let Err(sample) = cx.local.samples_in.enqueue(sample) {
                front_end.found_queue_full(&sample);
            }
        });
        progress(Stage::Read);
        wake(&wake::FILTER);
    }

    /// Bytes of the host that were lost on the line.
    static BYTES_LOST: AtomicU32 = AtomicU32::new(0);

    /// One byte of the link, in or out.
    #[task(binds = USART3, priority = 3, local = [rx, tx, bytes_in, frames, sent: usize = 0])]
    fn line(cx: line::Context) {
        let line::LocalResources { rx, tx, bytes_in, frames, sent, .. } = cx.local;
        if rx.is_rx_not_empty() {
            // The line cannot be held back: without room the byte is lost, and counted.
            let kept = rx.read().ok().and_then(|byte| bytes_in.enqueue(byte).ok());
            if kept.is_none() {
                BYTES_LOST.fetch_add(1, Ordering::Relaxed);
            }
            wake(&wake::COMMAND);
        }
        // On a real line the register is full again after a byte or two, and its interrupt brings us back here.
        while tx.is_tx_empty() {
            match frames.peek().map(|frame| frame.get(*sent)) {
                Some(Some(byte)) => {
                    *sent += 1;
                    let _ = tx.write(*byte);
                    tx.listen();
                }
                Some(None) => {
                    *sent = 0;
                    frames.dequeue();
                    wake(&wake::SEND);
                }
                None => {
                    tx.unlisten();
                    break;
                }
            }
        }
    }

    /// Cuts frames out of the bytes of the host and carries out its commands.
    #[task(priority = 2, local = [bytes, command_wakes, line: Accumulator = Accumulator::new()],
        shared = [device, hardware])]
    async fn command(mut cx: command::Context) {
        let command::LocalResources { bytes, command_wakes, line, .. } = cx.local;
        loop {
            command_wakes.wait().await;
            progress(Stage::Command);
            while let Some(byte) = bytes.dequeue() {
                let frame = match line.push(byte) {
                    Accumulated::Nothing => continue,
                    Accumulated::TooLong => {
                        cx.shared.device.lock(|device| device.count_damaged());
                        continue;
                    }
                    Accumulated::Frame(frame) => frame,
                };
                while !cx.shared.device.lock(|device| device.can_receive()) {
                    wake(&wake::SEND);
                    sleep_ms(1).await;
                }
                (&mut cx.shared.device, &mut cx.shared.hardware)
                    .lock(|device, hardware| device.receive(frame, time::now_us(), hardware));
                wake(&wake::FILTER);
                wake(&wake::SEND);
                give_way().await;
            }
        }
    }

    /// Asks the device for frames while the line has room for them.
    #[task(priority = 2, local = [frames_in, send_wakes], shared = [device])]
    async fn send(mut cx: send::Context) {
        let send::LocalResources { frames_in, send_wakes, .. } = cx.local;
        loop {
            send_wakes.wait().await;
            progress(Stage::Send);
            while frames_in.ready() {
                let mut room = [0; FRAME_MAX];
                let (frame, restart) = cx.shared.device.lock(|device| {
                    let bytes = device.next_frame(time::now_us(), &mut log::Waiting, &mut room);
                    let frame = bytes.and_then(|bytes| Frame::from_slice(bytes).ok());
                    if device.has_injected() {
                        // They may have waited for the room of this frame.
                        wake(&wake::FILTER);
                    }
                    (frame, device.restart_due())
                });
                let Some(frame) = frame else {
                    if let Some(into) = restart {
                        // Whatever the line still holds takes no longer than this.
                        sleep_ms(20).await;
                        reset::restart(into);
                    }
                    break;
                };
                let _ = frames_in.enqueue(frame);
                rtic::pend(Interrupt::USART3);
                give_way().await;
            }
        }
    }

    /// Looks after everything that has no event of its own.
    #[task(priority = 2, local = [thermometer, watchdog], shared = [device, hardware])]
    async fn tick(mut cx: tick::Context) {
        for count in (0_u32..).cycle() {
            sleep_ms(10).await;
            (&mut cx.shared.device, &mut cx.shared.hardware).lock(|device, hardware| {
                device.count_bytes_lost(BYTES_LOST.swap(0, Ordering::Relaxed));
                device.count_log_lost(log::lost());
                if !hardware.front_end.is_listening() {
                    progress(Stage::Read);
                }
                if count.is_multiple_of(100) {
                    device
                        .set_temperature(cx.local.thermometer.as_mut().and_then(Thermometer::read));
                    device.set_stack_used(stack::used());
                    if hardware.front_end.is_listening() {
                        let fault = hardware.front_end.fault();
                        if fault.is_some() {
                            warn!("the converter's data-ready line stands still");
                        }
                        device.set_converter(fault);
                    }
                }
                device.tick(time::now_us(), hardware);
            });
            for sleeper in [&wake::FILTER, &wake::COMMAND, &wake::SEND] {
                wake(sleeper);
            }
            if count.is_multiple_of(100) {
                cx.local.watchdog.feed();
            }
        }
    }

    /// Takes samples through calibration and filter into blocks.
    #[task(priority = 1, local = [samples, filter_wakes], shared = [device])]
    async fn filter(mut cx: filter::Context) {
        let filter::LocalResources { samples, filter_wakes, .. } = cx.local;
        loop {
            filter_wakes.wait().await;
            progress(Stage::Filter);
            let waiting = samples.len() as u8;
            cx.shared.device.lock(|device| device.note_queue(waiting));
            while let Some(sample) = samples.dequeue() {
                cx.shared.device.lock(|device| device.sample(&sample));
            }
            while cx.shared.device.lock(|device| device.process_injected()) {}
            wake(&wake::SEND);
        }
    }
}
