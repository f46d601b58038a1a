//! A converter that fails while it is read: what status, counters and rows say, and that it comes back.

use emulator::{Board, CONVERTER_CLOCK_HZ, Fault, MS, Setup};
use shared::wire::{
    Columns, ConverterFault, Done, Inputs, Oversampling, PerGauge, SelfTest, Source, Start, Status,
    ToDevice,
};

/// Edges that wait for their interrupt, and the one of the data-ready line.
const EXTI_PR: u64 = 0x4001_3c14;
const DRDY: u32 = 1 << 7;

fn streaming() -> Board {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X4096);
    board.listen_ms(50);
    board.heard.clear();
    board
}

/// The row of every conversion since these came or was counted; a few may be on their way.
fn all_are_accounted_for(board: &mut Board, (conversions, rows): (u64, u64)) -> Status {
    let status = board.status();
    let (converted, counted) = (board.converter().conversions - conversions, status.rows - rows);
    assert!(counted.abs_diff(converted) <= 3, "{converted} conversions, {counted} rows");
    let lost = &status.counters;
    let lost =
        lost.conversions_missed + lost.conversions_damaged + lost.queue_full + lost.link_full;
    assert!(
        u64::from(lost).abs_diff(board.heard.left_out) <= 1,
        "{lost}, {}",
        board.heard.left_out
    );
    status
}

fn now(board: &mut Board) -> (u64, u64) {
    let rows = board.status().rows;
    (board.converter().conversions, rows)
}

#[test]
fn one_that_resets_itself_is_set_anew_and_the_gap_is_counted() {
    let mut board = streaming();
    let before = now(&mut board);
    board.converter().reset();
    board.listen_ms(200);
    let gain = board.converter().gains();
    assert_eq!(gain, [128; 4], "set as before");
    let rows = board.heard.rows.len();
    board.listen_ms(100);
    assert!(board.heard.rows.len() > rows + 60, "rows go on");
    // It ran at four times the rate meanwhile, so conversions are more than rows.
    let status = board.status();
    assert_eq!(status.converter, None);
    assert!(status.rows - before.1 >= 280 && board.heard.left_out >= 3, "{status:?}");
}

#[test]
fn a_broken_wire_is_said_and_every_conversion_counted_and_when_it_is_mended_rows_go_on() {
    let mut board = streaming();
    let before = now(&mut board);
    board.converter().fault = Fault::WireBroken;
    board.listen_ms(100);
    let status = board.status();
    assert_eq!(status.converter, Some(ConverterFault::Missing));
    assert!(status.counters.conversions_damaged >= 80, "counted though nothing comes: {status:?}");
    board.converter().fault = Fault::None;
    board.listen_ms(30);
    let rows = board.heard.rows.len();
    board.listen_ms(100);
    assert!(board.heard.rows.len() >= rows + 60, "rows go on");
    let status = all_are_accounted_for(&mut board, before);
    assert_eq!(status.converter, None);
}

#[test]
fn of_frames_with_a_wrong_checksum_each_is_counted() {
    let mut board = streaming();
    let before = now(&mut board);
    board.converter().fault = Fault::DamagedOnceIn(10);
    board.listen_ms(100);
    board.converter().fault = Fault::None;
    board.listen_ms(20);
    let status = all_are_accounted_for(&mut board, before);
    assert!(status.counters.conversions_damaged >= 9, "{status:?}");
    assert_eq!(status.converter, None, "one frame in ten is a noisy wire, not a broken one");
}

#[test]
fn a_data_ready_line_that_stands_still_is_said_and_when_it_moves_rows_go_on() {
    let mut board = streaming();
    board.converter().fault = Fault::DrdyStuck;
    board.listen_ms(100);
    assert_eq!(board.status().converter, Some(ConverterFault::Stuck));
    board.converter().fault = Fault::None;
    board.listen_ms(30);
    let rows = board.heard.rows.len();
    board.listen_ms(100);
    assert!(board.heard.rows.len() >= rows + 60, "rows go on");
    assert_eq!(board.status().converter, None);
}

#[test]
fn a_data_ready_line_that_stands_still_for_long_resets_nothing() {
    // Ten times as slow, with a watchdog of 1.3 s.
    let setup = Setup { crystal_mhz: 10, watchdog_hz: 6 * 32_000, ..Setup::new() };
    let mut board = Board::new(&setup);
    board.run_ns(500 * MS);
    board.hello();
    board.ask(&ToDevice::SetRatio(Oversampling::X16384), 400).outcome.unwrap();
    let start = Start { source: Source::Converter, columns: Columns::Parts };
    board.ask(&ToDevice::Start(start), 400).outcome.unwrap();
    board.listen_ms(200);
    board.converter().fault = Fault::DrdyStuck;
    board.listen_ms(3_000);
    assert_eq!(board.resets(), 0);
    assert_eq!(board.status().converter, Some(ConverterFault::Stuck));
}

#[test]
fn a_change_of_rate_under_load_is_no_press_and_what_it_costs_is_counted() {
    let mut board = Board::started(&Setup::new());
    board.converter().input = |_| [1_000_000; 4];
    board.stream(Oversampling::X4096);
    board.listen_ms(300);
    let before = *board.heard.rows.last().unwrap();
    board.heard.clear();
    board.ask(&ToDevice::SetRatio(Oversampling::X1024), 20).outcome.unwrap();
    board.listen_ms(100);
    let steps: Vec<_> =
        board.heard.rows.windows(2).map(|rows| rows[1].time_us - rows[0].time_us).collect();
    let fast = steps.iter().rposition(|us| us.abs_diff(256) > 20).unwrap();
    assert!(steps.len() - fast > 300, "{} rows of the new rate", steps.len() - fast);
    assert!(steps[..fast].iter().all(|us| us.abs_diff(1_024) <= 20), "{steps:?}");
    for row in &board.heard.rows {
        assert!((row.fa[0] - before.fa[0]).abs() <= 256, "FA moved by a microstrain: {row:?}");
        assert_eq!(row.states[0].region, before.states[0].region, "{row:?}");
    }
    let missed = u64::from(board.status().counters.conversions_missed);
    assert!(missed >= 3, "the converter settles: {missed}");
    assert_eq!(board.heard.left_out, missed);
}

#[test]
fn a_change_of_gain_under_load_is_no_press() {
    let mut board = Board::started(&Setup::new());
    board.converter().input = |_| [1_000_000; 4];
    board.stream(Oversampling::X4096);
    // Long enough for the thresholds of the regions.
    board.listen_ms(300);
    let before = *board.heard.rows.last().unwrap();
    board.heard.clear();
    board.ask(&ToDevice::SetGain(PerGauge([64; 4])), 20).outcome.unwrap();
    board.listen_ms(100);
    let halved = board.heard.rows.iter().filter(|row| row.counts[0] == 500_000).count();
    assert!(halved >= 60, "{halved}");
    for row in &board.heard.rows {
        assert!(row.counts[0] == 1_000_000 || row.counts[0] == 500_000, "settling: {row:?}");
        assert!((row.fa[0] - before.fa[0]).abs() <= 256, "FA moved by a microstrain: {row:?}");
        assert_eq!(row.states[0].region, before.states[0].region, "{row:?}");
    }
}

/// What a test found with these inputs.
fn tested(board: &mut Board, inputs: Inputs) -> SelfTest {
    match board.ask(&ToDevice::TestInputs(inputs), 200).outcome {
        Ok(Done::Tested(test)) => test,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_converter_is_tested_without_its_gauges_and_then_reads_them_again() {
    let mut board = Board::started(&Setup::new());
    board.ask(&ToDevice::SetRatio(Oversampling::X1024), 20).outcome.unwrap();
    board.converter().offset = 300;
    let shorted = tested(&mut board, Inputs::Shorted);
    assert_eq!((shorted.converter, shorted.mean_counts.0), (Ok(()), [300; 4]));
    let signal = tested(&mut board, Inputs::TestSignal);
    assert_eq!(signal.mean_counts, [(1 << 24) / 15 + 300; 4]);
    board.converter().input = |_| [1_000_000; 4];
    board.stream(Oversampling::X1024);
    board.listen_ms(20);
    let counts = board.heard.rows.last().unwrap().counts;
    assert_eq!(counts, [1_000_300; 4]);
}

#[test]
fn the_chop_takes_the_converters_own_offset_away() {
    let mut board = Board::started(&Setup::new());
    board.converter().input = |_| [1_000_000; 4];
    board.converter().offset = 3_000;
    board.ask(&ToDevice::SetInterval { ns: 772_000 }, 20).outcome.unwrap();
    let start = Start { source: Source::Converter, columns: Columns::Parts };
    board.ask(&ToDevice::Start(start), 100).outcome.unwrap();
    board.listen_ms(100);
    let rows = &board.heard.rows;
    assert!(rows.len() > 100 && rows.iter().all(|row| row.counts == [1_000_000; 4]));
    assert!(rows.windows(2).all(|pair| pair[1].time_us - pair[0].time_us == 772));
    assert_eq!(board.heard.left_out, 0);
}

#[test]
fn the_first_start_keeps_no_edge_of_the_converter_waiting_for_a_millisecond() {
    let mut board = Board::started(&Setup::new());
    board.tell(&ToDevice::Start(Start { source: Source::Converter, columns: Columns::Parts }));
    let (mut waits, mut longest, mut edges) = (0, 0, 0);
    for _ in 0..2_000 {
        board.run_ns(MS / 50);
        let pending = board.peek(EXTI_PR) & DRDY != 0;
        waits = if pending { waits + 20 } else { 0 };
        edges += u32::from(waits == 20);
        longest = longest.max(waits);
    }
    board.listen();
    assert_eq!(board.heard.answers.len(), 2, "Hello and Start");
    assert!(edges > 0, "none was ever seen to wait");
    println!("{edges} edges, none waited for more than {longest} µs");
    assert!(longest < 1_000, "{longest} µs");
}

#[test]
fn at_the_fastest_rate_a_command_delays_no_answer_to_the_converter_by_an_interval() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X1024);
    board.listen_ms(20);
    board.heard.clear();
    board.converter().slowest_answer = 0;
    for _ in 0..5 {
        let filter = shared::adaptation::Relaxation { c1: 0.25, v1: 4.0, c2: 0.25, v2: 0.5 };
        board.ask(&ToDevice::SetFilter(filter), 10);
        board.run_ns(MS / 3);
    }
    let slowest_us = board.converter().slowest_answer * 1_000_000 / CONVERTER_CLOCK_HZ;
    println!("from an edge to the frame that answers it at most {slowest_us} µs");
    assert!(slowest_us <= 20, "{slowest_us} µs");
    assert_eq!(board.heard.left_out, 0);
}

#[test]
fn rows_carry_the_time_of_their_edge_however_late_its_interrupt_comes() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X1024);
    board.listen_ms(20);
    board.heard.clear();
    for _ in 0..20 {
        // Bytes of the host come before the converter, and commands lock its driver.
        board.ask(&ToDevice::Status, 10);
        board.listen_ms(5);
    }
    let times: Vec<u64> = board.heard.rows.iter().map(|row| row.time_us).collect();
    let apart: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // 2 × 1024 periods of 8 MHz.
    assert!(apart.len() > 380 && apart.iter().all(|it| *it == 256), "{apart:?}");
}
