//! The palpate fingertip: four strain gauges in silicone, read, decomposed and streamed.
//!
//! What it does is in the crate `device`, which the host's simulated device shares. Here is what drives it:
//!
//! ```text
//! priority 5   line       USART interrupt: one byte in, one frame out              ── queue of bytes ──┐
//! priority 4   SysTick    every 1 ms: wakes what sleeps                                                │
//! priority 3   read       DRDY interrupt: stamps the time, reads the converter     ── queue of samples ┼─┐
//! priority 2   command    cuts frames, carries out commands                        ◄───────────────────┘ │
//! priority 2   send       asks the device for frames                               ── queue of frames ─► line or cable
//! priority 2   cable      on the bus: packets of the host, packets for it          ── queue of bytes ──► command
//! priority 2   tick       every 10 ms: status, watchdog, temperature                                     │
//! priority 1   filter     calibrates and decomposes                                ◄─────────────────────┘
//! ```
//!
//! The line comes first because it waits least: at 1 Mbaud a byte must be fetched within 10 µs, and to read the converter takes
//! longer; so does the timer's interrupt at 16 MHz, which after a reset would come before all others. The converter keeps two
//! samples. Its driver is locked only while it is spoken to.
//!
//! USB waits for us: what finds no room stays with the host. Frames go to the line over which a host last said something, and
//! each line has queues of its own.
//!
//! Interrupts do the least; nothing waits for the host; what finds a queue full is counted. The device's state is shared by
//! the lower priorities, one row or one command at a time, so settings change between two rows.
#![no_std]
#![no_main]

mod board;
mod hardware;
mod lines;
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

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [EXTI0, EXTI1])]
mod app {
    use core::mem::MaybeUninit;
    use core::sync::atomic::{AtomicU32, Ordering};
    use cortex_m::peripheral::scb::SystemHandler;
    use defmt::{Debug2Format, info, warn};
    use device::converters::FourChannels;
    use device::{Converter, Device, FrontEnd, Identity, Restart, Room, Sample, begin_with};
    use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
    use heapless::spsc::{Consumer, Producer, Queue};
    use rtic_monotonics::{Timebase, fugit, systick_monotonic};
    use rtic_sync::signal::SignalReader;
    use shared::wire::{Accumulated, BAUD, FRAME_MAX, Hello, Settings};
    use stm32f4xx_hal::gpio::{Alternate, Edge, Output, PB8, PB9, PC1, PC7, Speed};
    use stm32f4xx_hal::otg_fs::UsbBusType;
    use stm32f4xx_hal::pac::{Interrupt, NVIC, SPI2, USART3};
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::serial::{self, RxListen, Serial};
    use stm32f4xx_hal::spi::Spi;
    use usb::{Frame, SerialNumber, UsbLine};
    use usb_device::bus::UsbBusAllocator;

    use crate::board::shared_line::SharedLine;
    use crate::board::temperature::Thermometer;
    use crate::board::transmitter::Transmitter;
    use crate::board::watchdog::{Stage, Watchdog, progress};
    use crate::board::{
        self, clocks, edge, fingerprint, receiver, reset, socket, stack, supply, time,
    };
    use crate::hardware::{Hardware, Locked};
    use crate::lines::{self, Inlet, Line, Outlets};
    use crate::memory::Memory;
    use crate::wake::{self, give_way, wake};
    use crate::{BYTES, FRAMES, SAMPLES, log};

    systick_monotonic!(Mono, 1_000);

    async fn sleep_ms(time: u32) {
        <Mono as Timebase>::delay(fugit::TimerDurationU32::from_ticks(time)).await;
    }

    type Bus = ExclusiveDevice<Spi<SPI2>, PB9<Output>, NoDelay>;
    type Chip = FourChannels<Bus, PB8<Output>>;
    type Board = Hardware<Chip>;

    #[shared]
    struct Shared {
        device: &'static mut Device<'static>,
        hardware: Board,
    }

    #[local]
    struct Local {
        drdy: PC7<Alternate<{ edge::FUNCTION }>>,
        lamp: PC1<Output>,
        shared_line: SharedLine,
        samples_in: Producer<'static, Sample>,
        samples: Consumer<'static, Sample>,
        transmitter: Transmitter,
        bytes_in: Producer<'static, u8>,
        inlets: [Inlet; 2],
        outlets: Outlets,
        frames: Consumer<'static, Frame>,
        usb: Option<UsbLine<'static, UsbBusType>>,
        usb_bytes_in: Producer<'static, u8>,
        usb_frames: Consumer<'static, Frame>,
        usb_wakes: SignalReader<'static, ()>,
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
        usb_byte_queue: Queue<u8, BYTES> = Queue::new(),
        usb_frame_queue: Queue<Frame, FRAMES> = Queue::new(),
        usb_memory: [u32; socket::WORDS] = [0; socket::WORDS],
        usb_bus: Option<UsbBusAllocator<UsbBusType>> = None,
        usb_serial: Option<SerialNumber> = None,
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
        time::start(p.TIM2, p.TIM3, &mut rcc);
        let beat = rtic::export::cortex_logical2hw(4, stm32f4xx_hal::pac::NVIC_PRIO_BITS);
        // SAFETY: no lock rests on its priority; its queue is locked by critical sections.
        unsafe { cx.core.SCB.set_priority(SystemHandler::SysTick, beat) };
        Mono::start(cx.core.SYST, sysclk.raw());

        let a = p.GPIOA.split(&mut rcc);
        let (b, c) = (p.GPIOB.split(&mut rcc), p.GPIOC.split(&mut rcc));
        // Joined to ground where another finger of a hand clocks this converter too.
        let clocks_itself = b.pb6.into_pull_up_input();
        // 10 µs: the pull-up has some 40 kΩ, and a wire some picofarads.
        cortex_m::asm::delay(sysclk.raw() / 100_000);
        if clocks_itself.is_high() {
            // Its clock must run before the converter is spoken to.
            let (_, (clkin, ..)) = p.TIM8.pwm_hz(board::CONVERTER_CLOCK_HZ.Hz(), &mut rcc);
            // The pins of clock and bus are slow after a reset: 2 to 8 MHz (data sheet, table 50).
            let mut clkin = clkin.with(c.pc6.into_alternate().speed(Speed::High));
            clkin.set_duty(clkin.get_max_duty() / 2);
            clkin.enable();
        }
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
        let capabilities = converter.capabilities();
        let front_end = FrontEnd::new(converter, time::Delay);
        let mut drdy = c.pc7.into_alternate::<{ edge::FUNCTION }>().internal_pull_up(true);
        drdy.make_interrupt_source(&mut p.SYSCFG.constrain(&mut rcc));
        let mut exti = p.EXTI;
        drdy.trigger_on_edge(&mut exti, Edge::Falling);
        drdy.enable_interrupt(&mut exti);

        let config = serial::Config::default().baudrate(BAUD.bps());
        // Nothing may be plugged in there, and what floats would be taken for bytes.
        let received = b.pb11.into_alternate().internal_pull_up(true);
        let link: Serial<USART3> = match Serial::new(p.USART3, (b.pb10, received), config, &mut rcc)
        {
            Ok(link) => link,
            Err(_) => reset::die("the link's clock does not divide to its baud rate"),
        };
        let (tx, mut rx) = link.split();
        rx.listen();
        let transmitter = Transmitter::new(tx, p.DMA1, &mut rcc);

        let core = (p.OTG_FS_GLOBAL, p.OTG_FS_DEVICE, p.OTG_FS_PWRCLK);
        let bus = socket::start(core, (a.pa11, a.pa12), cx.local.usb_memory, &mut rcc);
        let serial = fingerprint.map_or([0; 3], |known| known.serial);
        let usb = bus.and_then(|bus| {
            let serial = cx.local.usb_serial.insert(SerialNumber::new(serial));
            UsbLine::new(cx.local.usb_bus.insert(bus), serial)
        });

        let mut memory = Memory::new(p.FLASH, fingerprint.is_some());
        let mut record = [0; Settings::RECORD];
        let kept = memory.load(&mut record);
        let Ok(beginning) = begin_with(kept, &capabilities) else {
            reset::die("the default settings are out of range");
        };
        let identity = Identity {
            version: env!("CARGO_PKG_VERSION"),
            git: env!("PALPATE_GIT"),
            board: board::NAME,
            serial,
            converter_clock_hz: board::CONVERTER_CLOCK_HZ,
            converter: <Chip as Converter>::PART,
            capabilities,
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
        let (usb_bytes_in, usb_bytes) = cx.local.usb_byte_queue.split();
        let (usb_frames_in, usb_frames) = cx.local.usb_frame_queue.split();
        let thermometer =
            fingerprint.map(|known| Thermometer::new(p.ADC1, &mut rcc, known.temperature));
        // Each of these runs for ever and is spawned once.
        let _ = (filter::spawn(), command::spawn(), send::spawn(), tick::spawn(), cable::spawn());
        (
            Shared { device, hardware: Hardware { front_end, memory } },
            Local {
                drdy,
                lamp: c.pc1.into_push_pull_output(),
                shared_line: SharedLine::new(
                    a.pa7.into_push_pull_output(),
                    a.pa6.into_alternate().internal_pull_down(true),
                ),
                samples_in,
                samples,
                transmitter,
                bytes_in,
                inlets: [Inlet::new(Line::Serial, bytes), Inlet::new(Line::Usb, usb_bytes)],
                outlets: Outlets { serial: frames_in, usb: usb_frames_in },
                frames,
                usb,
                usb_bytes_in,
                usb_frames,
                usb_wakes: wake::USB.take_reader(),
                filter_wakes: wake::FILTER.take_reader(),
                command_wakes: wake::COMMAND.take_reader(),
                send_wakes: wake::SEND.take_reader(),
                thermometer,
                watchdog: Watchdog::start(p.IWDG, &p.DBGMCU),
            },
        )
    }

    /// Nothing to do: the core sleeps, which keeps the chip cool beside the silicone.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// An edge of the converter's data-ready line.
    #[task(binds = EXTI9_5, priority = 3, local = [drdy, samples_in], shared = [hardware])]
    fn read(mut cx: read::Context) {
        let now_us = time::now_us();
        let now_us = edge::caught(now_us).unwrap_or(now_us);
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

    /// One byte of the host, or a frame for it that was sent.
    #[task(binds = USART3, priority = 5, local = [transmitter, bytes_in, frames])]
    fn line(cx: line::Context) {
        let line::LocalResources { transmitter, bytes_in, frames, .. } = cx.local;
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
        while let Some(frame) = frames.peek() {
            if !transmitter.has_sent(frame) {
                return;
            }
            frames.dequeue();
            wake(&wake::SEND);
        }
        transmitter.rest();
    }

    /// Cuts frames out of the bytes of the host and carries out its commands.
    #[task(priority = 2, local = [inlets, command_wakes], shared = [device, hardware])]
    async fn command(mut cx: command::Context) {
        let command::LocalResources { inlets, command_wakes, .. } = cx.local;
        loop {
            command_wakes.wait().await;
            progress(Stage::Command);
            for Inlet { line, bytes, cut } in inlets.iter_mut() {
                while let Some(byte) = bytes.dequeue() {
                    let frame = match cut.push(byte) {
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
                    let is_host = cx
                        .shared
                        .device
                        .lock(|device| device.receive(frame, time::now_us(), &mut board));
                    if is_host {
                        lines::speak_over(*line);
                    }
                    wake(&wake::FILTER);
                    wake(&wake::SEND);
                    give_way().await;
                }
                if *line == Line::Usb {
                    // The host may be held back.
                    wake(&wake::USB);
                }
            }
        }
    }

    /// Something happened on the USB bus. Its interrupt stays on until that was seen to, for which there may be no room yet.
    #[task(binds = OTG_FS, priority = 2)]
    fn on_usb(_: on_usb::Context) {
        NVIC::mask(Interrupt::OTG_FS);
        wake(&wake::USB);
    }

    /// Packets of the host into the queue of bytes, frames out of their queue into packets for the host.
    #[task(priority = 2, local = [usb, usb_bytes_in, usb_frames, usb_wakes])]
    async fn cable(cx: cable::Context) {
        let cable::LocalResources { usb, usb_bytes_in, usb_frames, usb_wakes, .. } = cx.local;
        let Some(usb) = usb else { return };
        loop {
            usb_wakes.wait().await;
            let polled = usb.poll(usb_bytes_in, usb_frames);
            if polled.received {
                wake(&wake::COMMAND);
            }
            if polled.sent {
                wake(&wake::SEND);
            }
            if polled.touched {
                // The host hears that its request was taken.
                sleep_ms(20).await;
                reset::restart(Restart::Bootloader);
            }
            if !polled.held_back {
                // SAFETY: no lock rests on this mask; the interrupt comes again for what is not seen to.
                unsafe { NVIC::unmask(Interrupt::OTG_FS) };
            }
            give_way().await;
        }
    }

    /// Asks the device for frames while the line has room for them.
    #[task(priority = 2, local = [outlets, send_wakes], shared = [device])]
    async fn send(mut cx: send::Context) {
        let send::LocalResources { outlets, send_wakes, .. } = cx.local;
        loop {
            send_wakes.wait().await;
            progress(Stage::Send);
            while outlets.now().ready() {
                let mut frame = Frame::new();
                let mut restart = None;
                cx.shared.device.lock(|device| {
                    let mut room = [0; FRAME_MAX];
                    let bytes = device.next_frame(time::now_us(), &mut log::Waiting, &mut room);
                    // Every frame has room.
                    let _ = frame.extend_from_slice(bytes.unwrap_or_default());
                    if device.has_injected() {
                        // They may have waited for the room of this frame.
                        wake(&wake::FILTER);
                    }
                    restart = device.restart_due();
                });
                if frame.is_empty() {
                    if let Some(into) = restart {
                        // Whatever the line still holds takes no longer than this.
                        sleep_ms(20).await;
                        reset::restart(into);
                    }
                    break;
                }
                let _ = outlets.now().enqueue(frame);
                match lines::spoken_over() {
                    Line::Serial => rtic::pend(Interrupt::USART3),
                    Line::Usb => wake(&wake::USB),
                }
                give_way().await;
            }
        }
    }

    /// Looks after everything that has no event of its own.
    #[task(priority = 2, local = [lamp, shared_line, thermometer, watchdog], shared = [device, hardware])]
    async fn tick(mut cx: tick::Context) {
        for count in (0_u32..).cycle() {
            sleep_ms(10).await;
            let shared_line = &mut cx.local.shared_line;
            let pulse_us = shared_line.rose(time::now_us());
            shared_line.raise(count.is_multiple_of(100));
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
            let is_lit = cx.shared.device.lock(|device| {
                device.count_bytes_lost(BYTES_LOST.swap(0, Ordering::Relaxed));
                device.count_log_lost(log::lost());
                if device.look(found, listens) {
                    warn!("converter: {}", Debug2Format(&found.fault));
                }
                if count.is_multiple_of(10) {
                    device.set_temperature(temperature);
                }
                if let Some(time_us) = pulse_us {
                    device.note_pulse(time_us);
                }
                if let Some(bytes) = stack_used {
                    device.set_stack_used(bytes);
                }
                device.tick(time::now_us(), &mut board);
                device.lamp().is_lit(time::now_us())
            });
            cx.local.lamp.set_state(is_lit.into());
            for sleeper in [&wake::FILTER, &wake::COMMAND, &wake::SEND, &wake::USB] {
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
            // Most rows only fill a block.
            if cx.shared.device.lock(|device| device.has_frame(&log::Waiting)) {
                wake(&wake::SEND);
            }
        }
    }
}
