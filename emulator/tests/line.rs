//! The line while samples stream: what the host says is heard, whatever the converter's interrupt does meanwhile.

use emulator::{Board, MS, Setup};
use shared::adaptation::Relaxation;
use shared::wire::{FRAME_MAX, Head, Oversampling, Refusal, ToDevice, encode};

const FILTER: ToDevice<'_> =
    ToDevice::SetFilter(Relaxation { c1: 0.2472, v1: 3.981, c2: 0.2676, v2: 0.5325 });

/// The same numbers in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, most: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }
}

#[test]
fn every_command_is_answered_at_the_first_try_at_the_fastest_rate_and_no_byte_is_lost() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X1024);
    board.listen_ms(10);
    board.heard.clear();
    let mut random = Random(1);
    for command in [ToDevice::Status, FILTER, ToDevice::Settings] {
        for _ in 0..10 {
            board.run_ns(random.below(MS));
            let asked = board.ask(&command, 10);
            assert_eq!((asked.tries, asked.outcome.is_ok()), (1, true), "{command:?}: {asked:?}");
        }
    }
    let status = board.status();
    assert_eq!(board.wire().overruns, 0);
    assert_eq!((status.counters.bytes_lost, board.heard.left_out), (0, 0));
}

#[test]
fn after_an_overrun_at_the_worst_instant_rows_go_on_and_the_byte_is_counted() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X4096);
    board.listen_ms(50);
    board.wire().overrun_at_worst = true;
    board.send(&[0]);
    board.listen_ms(20);
    let rows = board.heard.rows.len();
    board.listen_ms(100);
    assert!(
        board.heard.rows.len() >= rows + 90,
        "{} rows in 100 ms",
        board.heard.rows.len() - rows
    );
    assert_eq!(board.status().counters.bytes_lost, 1);
}

/// How often the host is killed; `cargo xtask emulate` says more.
fn kills() -> u64 {
    std::env::var("PALPATE_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(20)
}

#[test]
fn a_host_that_comes_after_one_that_was_killed_at_any_moment_reaches_sets_and_stops_the_device() {
    let mut board = Board::started(&Setup::new());
    let mut random = Random(2);
    for kill in 0..kills() {
        if kill % 10 == 0 {
            board.stream(Oversampling::X1024);
        }
        // Killed while it wrote: some of a frame is on the line, the device streams on.
        let mut room = [0; FRAME_MAX];
        let frame = encode(Head { sequence: 1, time_us: 0 }, &FILTER, &mut room).unwrap();
        board.send(&frame[..random.below(frame.len() as u64) as usize]);
        board.run_ns(random.below(2 * MS));
        assert_eq!(board.hello().tries, 1, "kill {kill}");
        assert_eq!(board.ask(&FILTER, 10).tries, 1, "kill {kill}");
        if kill % 10 == 9 {
            assert_eq!(board.ask(&ToDevice::Stop, 10).tries, 1, "kill {kill}");
            assert_eq!(board.ask(&ToDevice::Stop, 10).outcome, Err(Refusal::NotStreaming));
        }
    }
}
