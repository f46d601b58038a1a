//! The palpate fingertip: four strain gauges in silicone, read, decomposed and streamed.
//!
//! What it does is in the crate `device`, which the host's simulated device shares. Here is what drives it:
//!
//! ```text
//! priority 5   line       USART interrupt: one byte in, one byte out               ── queue of bytes ──┐
//! priority 4   SysTick    every 1 ms: wakes what sleeps                                                │
//! priority 3   read       DRDY interrupt: stamps the time, reads the converter     ── queue of samples ┼─┐
//! priority 2   command    cuts frames, carries out commands                        ◄───────────────────┘ │
//! priority 2   send       asks the device for frames                               ── queue of frames ─► line
//! priority 2   tick       every 10 ms: status, watchdog, temperature                                     │
//! priority 1   filter     calibrates and decomposes                                ◄─────────────────────┘
//! ```
//!
//! The line comes first because it waits least: at 1 Mbaud a byte must be fetched within 10 µs, and to read the converter takes
//! longer; so does the timer's interrupt at 16 MHz, which after a reset would come before all others. The converter keeps two
//! samples. Its driver is locked only while it is spoken to.
//!
//! Interrupts do the least; nothing waits for the host; what finds a queue full is counted. The device's state is shared by
//! the lower priorities, one row or one command at a time, so settings change between two rows.
#![no_std]
#![no_main]

mod board;
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
    use cortex_m::peripheral::scb::SystemHandler;
    use defmt::{Debug2Format, info, warn};
    use device::converters::FourChannels;
    use device::{Device, FrontEnd, Identity, Lost, Room, Sample, begin_with};
    use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
    use embedded_hal_nb::serial::Write;
    use heapless::spsc::{Consumer, Producer, Queue};
    use rtic_monotonics::{Timebase, fugit, systick_monotonic};
    use rtic_sync::signal::SignalReader;
    use shared::wire::{Accumulated, Accumulator, BAUD, FRAME_MAX, Hello, Settings};
    use stm32f4xx_hal::gpio::{Edge, Input, Output, PB8, PB9, PC7, Speed};
    use stm32f4xx_hal::pac::{Interrupt, SPI2, USART3};
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::serial::{self, RxListen, Serial, Tx, TxISR, TxListen};
    use stm32f4xx_hal::spi::Spi;

    use crate::board::temperature::Thermometer;
    use crate::board::watchdog::{Stage, Watchdog, progress};
    use crate::board::{self, clocks, fingerprint, receiver, reset, stack, supply, time};
    use crate::hardware::{Hardware, Locked};
    use crate::memory::Memory;
    use crate::wake::{self, give_way, wake};
    use crate::{BYTES, FRAMES, Frame, SAMPLES, log};

    systick_monotonic!(Mono, 1_000);

    async fn sleep_ms(time: u32) {
        <Mono as Timebase>::delay(fugit::TimerDurationU32::from_ticks(time)).await;
    }

    type Bus = ExclusiveDevice<Spi<SPI2>, PB9<Output>, NoDelay>;
    type Board = Hardware<FourChannels<Bus, PB8<Output>>>;

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
        room: Room = Room::new(),
        device_place: MaybeUninit<Device<'static>> = MaybeUninit::uninit(),
        panic: [u8; Hello::PANIC] = [0; Hello::PANIC],
    ])]
    fn init(mut cx: init::Context) -> (Shared, Local) {
        let p = cx.device;
        let panic = reset::last_words(cx.local.panic, &p.RCC, &p.SYSCFG);
        let why = reset::cause(&p.RCC);
        let fingerprint = fingerprint::read();
        supply::watch(&p.PWR, &p.RCC);
        let (mut rcc, clock) = clocks::start(p.RCC, p.TIM11);
        let sysclk = rcc.clocks.sysclk();
        time::start(p.TIM2, &mut rcc);
        let beat = rtic::export::cortex_logical2hw(4, stm32f4xx_hal::pac::NVIC_PRIO_BITS);
        // SAFETY: no lock rests on its priority; its queue is locked by critical sections.
        unsafe { cx.core.SCB.set_priority(SystemHandler::SysTick, beat) };
        Mono::start(cx.core.SYST, sysclk.raw());

        let (b, c) = (p.GPIOB.split(&mut rcc), p.GPIOC.split(&mut rcc));
        // Its clock must run before the converter is spoken to.
        let (_, (clkin, ..)) = p.TIM8.pwm_hz(board::CONVERTER_CLOCK_HZ.Hz(), &mut rcc);
        // The pins of clock and bus are slow after a reset: 2 to 8 MHz (data sheet, table 50).
        let mut clkin = clkin.with(c.pc6.into_alternate().speed(Speed::High));
        clkin.set_duty(clkin.get_max_duty() / 2);
        clkin.enable();
        let spi = Spi::new(
            p.SPI2,
            (
                Some(b.pb13.into_alternate().speed(Speed::High)),
                Some(b.pb14),
                Some(b.pb15.into_alternate().speed(Speed::High)),
            ),
            ads131m04::SPI_MODE,
            board::SPI_HZ.Hz(),
            &mut rcc,
        );
        let select = b.pb9.into_push_pull_output_in_state(stm32f4xx_hal::gpio::PinState::High);
        let mut reset_line = b.pb8.into_push_pull_output();
        reset_line.set_speed(Speed::Low);
        let Ok(bus) = ExclusiveDevice::new_no_delay(spi, select);
        let converter = FourChannels::new(bus, reset_line, board::CONVERTER_CLOCK_HZ);
        let front_end = FrontEnd::new(converter, time::Delay);
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
        let mut record = [0; Settings::RECORD];
        let kept = memory.load(&mut record);
        let Ok(beginning) = begin_with(kept, board::CONVERTER_CLOCK_HZ) else {
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
        let device = cx.local.device_place.write(Device::new(identity, &beginning, cx.local.room));
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
                tx,
                bytes_in,
                bytes,
                frames_in,
                frames,
                filter_wakes: wake::FILTER.take_reader(),
                command_wakes: wake::COMMAND.take_reader(),
                send_wakes: wake::SEND.take_reader(),
                thermometer,
                watchdog: Watchdog::start(p.IWDG, &p.DBGMCU),
            },
        )
    }

    /// An edge of the converter's data-ready line.
    #[task(binds = EXTI9_5, priority = 3, local = [drdy, samples_in], shared = [hardware])]
    fn read(mut cx: read::Context) {
        let now_us = time::now_us();
        cx.local.drdy.clear_interrupt_pending_bit();
        cx.shared.hardware.lock(|Hardware { front_end, .. }| {
            let Some(sample) = front_end.ready(now_us) else { return };
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
    #[task(binds = USART3, priority = 5, local = [tx, bytes_in, frames, sent: usize = 0])]
    fn line(cx: line::Context) {
        let line::LocalResources { tx, bytes_in, frames, sent, .. } = cx.local;
        let received = receiver::take();
        // The line cannot be held back: without room the byte is lost, and counted.
        let found_no_room = received.byte.is_some_and(|byte| bytes_in.enqueue(byte).is_err());
        let lost = received.lost + u32::from(found_no_room);
        if lost > 0 {
            BYTES_LOST.fetch_add(lost, Ordering::Relaxed);
        }
        if received.byte.is_some() {
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
                let mut board = Locked(&mut cx.shared.hardware);
                cx.shared.device.lock(|device| device.receive(frame, time::now_us(), &mut board));
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
            let (found, listens, expects_edges) = cx.shared.hardware.lock(|hardware| {
                let front_end = &mut hardware.front_end;
                let found = front_end.look_after(time::now_us());
                (found, front_end.is_listening(), front_end.expects_edges())
            });
            if !expects_edges {
                progress(Stage::Read);
            }
            let temperature = cx.local.thermometer.as_mut().and_then(Thermometer::read);
            let stack_used = count.is_multiple_of(100).then(stack::used);
            let mut board = Locked(&mut cx.shared.hardware);
            cx.shared.device.lock(|device| {
                device.count_bytes_lost(BYTES_LOST.swap(0, Ordering::Relaxed));
                device.count_log_lost(log::lost());
                if found.lost != Lost::NONE {
                    device.count_lost(found.lost);
                }
                if listens && device.converter() != found.fault {
                    if let Some(fault) = found.fault {
                        warn!("converter: {}", Debug2Format(&fault));
                    }
                    device.set_converter(found.fault);
                }
                if count.is_multiple_of(10) {
                    device.set_temperature(temperature);
                }
                if let Some(bytes) = stack_used {
                    device.set_stack_used(bytes);
                }
                device.tick(time::now_us(), &mut board);
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
            cx.shared.device.lock(|device| device.drained());
            while cx.shared.device.lock(|device| device.process_injected()) {}
            wake(&wake::SEND);
        }
    }
}
