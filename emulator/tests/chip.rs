//! The chip itself: clocks from any crystal, pins, faults that leave words, settings over a loss of power.

use std::sync::atomic::Ordering::Relaxed;

use emulator::{BOOT_MS, Board, MS, Setup};
use shared::wire::{Oversampling, Refusal, StoreFault, ToDevice};

const RCC_CFGR: u64 = 0x4002_3808;
const GPIOB_OSPEEDR: u64 = 0x4002_0408;
const GPIOC_OSPEEDR: u64 = 0x4002_0808;
const GPIOC_MODER: u64 = 0x4002_0800;
const TIM8_CR1: u64 = 0x4001_0400;
const TIM8_PSC: u64 = 0x4001_0428;
const TIM8_ARR: u64 = 0x4001_042c;
const ADC_CCR: u64 = 0x4001_2304;
const DBGMCU_APB1_FZ: u64 = 0xe004_2008;
const FLASH_CR: u64 = 0x4002_3c10;
const LOW: u32 = 0;

/// Speed of a pin, 0 to 3.
fn speed(board: &Board, port: u64, pin: u32) -> u32 {
    board.peek(port) >> (2 * pin) & 3
}

#[test]
fn from_every_crystal_the_same_image_makes_the_same_clocks() {
    for (crystal_mhz, internal_hz) in
        [(8, 16_000_000), (12, 16_500_000), (16, 16_160_000), (25, 15_200_000)]
    {
        let mut board = Board::new(&Setup { crystal_mhz, internal_hz, ..Setup::new() });
        board.run_ns(BOOT_MS * MS);
        assert_eq!(board.clock_hz("sysclk"), 168e6, "{crystal_mhz} MHz");
        let periods = (board.peek(TIM8_PSC) + 1) * (board.peek(TIM8_ARR) + 1);
        assert_eq!(board.clock_hz("timclk2") / f64::from(periods), 8e6, "{crystal_mhz} MHz");
        assert_eq!(board.hello().tries, 1, "{crystal_mhz} MHz");
        assert_eq!(board.wire().misframed, 0, "{crystal_mhz} MHz");
    }
}

#[test]
fn a_crystal_that_is_none_of_those_in_use_is_not_trusted() {
    let mut board = Board::new(&Setup { crystal_mhz: 10, ..Setup::new() });
    // Ten times as slow.
    board.run_ns(10 * BOOT_MS * MS);
    assert_eq!(board.clock_hz("sysclk"), 16e6);
    assert_eq!(board.hello().tries, 1);
    let hello = board.heard.hello.clone().unwrap();
    assert!(hello.contains("Internal"), "{hello}");
}

#[test]
fn the_pins_of_bus_and_clock_are_fast_enough_for_them() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X4096);
    for (port, pin) in [(GPIOB_OSPEEDR, 13), (GPIOB_OSPEEDR, 15), (GPIOC_OSPEEDR, 6)] {
        assert_ne!(speed(&board, port, pin), LOW, "pin {pin} of {port:#x}");
    }
}

#[test]
fn a_finger_whose_converter_another_one_clocks_leaves_that_line_alone() {
    for is_clocked in [false, true] {
        let mut board = Board::started(&Setup { is_clocked, ..Setup::new() });
        board.stream(Oversampling::X1024);
        board.listen_ms(50);
        assert!(board.heard.rows.len() > 100, "{} rows", board.heard.rows.len());
        // Alternate function, or an input as after a reset.
        let mode = board.peek(GPIOC_MODER) >> 12 & 3;
        let runs = board.peek(TIM8_CR1) & 1;
        assert_eq!((mode, runs), if is_clocked { (0, 0) } else { (2, 1) });
    }
}

#[test]
fn the_converter_on_the_chip_is_clocked_within_its_limit_and_read_many_times_a_second() {
    let mut board = Board::started(&Setup::new());
    let divider = 2 * ((board.peek(ADC_CCR) >> 16 & 3) + 1);
    let hz = board.clock_hz("pclk2") / f64::from(divider);
    assert!(hz <= 36e6, "{hz} Hz");
    assert_eq!(board.peek(RCC_CFGR) >> 2 & 3, 2, "from the PLL");
    board.listen_ms(1_200);
    let conversions = board.thermometer.conversions.load(Relaxed);
    assert!(conversions >= 64, "{conversions}");
}

#[test]
fn a_stack_that_leaves_its_memory_leaves_its_words() {
    let mut board = Board::started(&Setup::new());
    let mut registers = board.cpu().regs();
    (registers.msp, registers.r[13]) = (0x2000_0008, 0x2000_0008);
    board.cpu().set_regs(registers);
    board.run_ns(BOOT_MS * MS);
    assert_eq!(board.resets(), 1);
    board.hello();
    assert!(board.heard.last_words.contains("stack"), "{:?}", board.heard.last_words);
}

#[test]
fn a_fault_leaves_its_place() {
    let mut board = Board::started(&Setup::new());
    board.cpu().set_pc(0x1000_0000);
    board.run_ns(BOOT_MS * MS);
    assert_eq!(board.resets(), 1);
    board.hello();
    let words = &board.heard.last_words;
    assert!(words.contains("hard fault at 0x10000000"), "{words:?}");
}

/// Runs from the internal oscillator, which is ten times as slow and quickly emulated, with a watchdog of 1.3 s instead of 8 s.
fn impatient() -> Setup {
    Setup { crystal_mhz: 10, watchdog_hz: 6 * 32_000, ..Setup::new() }
}

#[test]
fn a_processor_that_hangs_is_reset_by_the_watchdog_and_says_so() {
    let mut setup = impatient();
    let place = 0x9_0000;
    setup.flash.resize(place, 0xff);
    // A branch to itself.
    setup.flash.extend([0xfe, 0xe7]);
    let mut board = Board::new(&setup);
    board.run_ns(3_000 * MS);
    assert_eq!(board.resets(), 0, "fed");
    let mut registers = board.cpu().regs();
    registers.primask = true;
    board.cpu().set_regs(registers);
    board.cpu().set_pc(0x0800_0000 + place as u32);
    board.run_ns(2_000 * MS);
    assert_eq!(board.resets(), 1);
    board.hello();
    let hello = board.heard.hello.clone().unwrap();
    assert!(hello.contains("Watchdog"), "{hello}");
}

#[test]
fn a_breakpoint_stops_the_watchdog_too() {
    let board = Board::started(&Setup::new());
    assert_eq!(board.peek(DBGMCU_APB1_FZ) >> 12 & 1, 1);
}

fn rate(board: &mut Board) -> Oversampling {
    board.ask(&ToDevice::Settings, 20);
    board.listen_ms(10);
    Oversampling::nearest(board.heard.settings.unwrap().interval_ns, 8_000_000)
}

#[test]
fn settings_outlive_a_loss_of_power_and_one_while_they_are_saved_leaves_old_or_new() {
    let mut board = Board::started(&Setup::new());
    board.ask(&ToDevice::SetRatio(Oversampling::X2048), 40).outcome.unwrap();
    board.ask(&ToDevice::Save, 200).outcome.unwrap();
    let kept = Setup { flash: board.flash(), ..Setup::new() };
    let mut board = Board::started(&kept);
    assert_eq!(rate(&mut board), Oversampling::X2048);
    for cut_us in [300, 700, 1_100] {
        let mut board = Board::started(&kept);
        board.ask(&ToDevice::SetRatio(Oversampling::X1024), 40).outcome.unwrap();
        board.tell(&ToDevice::Save);
        board.run_ns(cut_us * 1_000);
        let cut = Setup { flash: board.flash(), ..Setup::new() };
        let found = rate(&mut Board::started(&cut));
        assert!([Oversampling::X1024, Oversampling::X2048].contains(&found), "{found:?}");
    }
}

#[test]
fn the_flash_is_written_in_words_of_32_bits_which_halves_the_time_of_an_erasure() {
    let mut board = Board::started(&Setup::new());
    board.ask(&ToDevice::Save, 200).outcome.unwrap();
    assert_eq!(board.peek(FLASH_CR) >> 8 & 3, 0b10);
}

#[test]
fn with_a_supply_too_low_to_write_the_flash_nothing_is_saved_and_that_is_said() {
    let mut board = Board::started(&Setup::new());
    board.ask(&ToDevice::SetRatio(Oversampling::X2048), 40).outcome.unwrap();
    board.ask(&ToDevice::Save, 200).outcome.unwrap();
    let before = board.flash();
    // Words of 32 bits need 2.7 V.
    board.power.supply_mv.store(2_750, Relaxed);
    let refused = board.ask(&ToDevice::Save, 200).outcome;
    assert_eq!(refused, Err(Refusal::Store(StoreFault::Supply)));
    assert!(board.flash() == before);
    board.power.supply_mv.store(3_000, Relaxed);
    board.ask(&ToDevice::Save, 200).outcome.unwrap();
}

#[test]
fn behind_a_loader_that_shows_a_disk_it_runs_as_well() {
    let path = emulator::firmware().with_extension("uf2");
    let file = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut flash = vec![0xff; 1 << 20];
    for block in file.chunks(512) {
        let at = u32::from_le_bytes(block[12..16].try_into().unwrap()) as usize - 0x0800_0000;
        flash[at..at + 256].copy_from_slice(&block[32..288]);
    }
    // The loader begins the program with its stack pointer and entry.
    flash.copy_within(0x1_0000..0x1_0008, 0);
    let mut board = Board::started(&Setup { flash, ..Setup::new() });
    board.stream(Oversampling::X4096);
    board.listen_ms(100);
    assert!(board.heard.rows.len() > 80, "{}", board.heard.rows.len());
}
