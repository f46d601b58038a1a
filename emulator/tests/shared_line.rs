//! The line that the fingers of a hand share: when it rose, in the time of each.

use emulator::{Board, MS, Setup};
use shared::wire::Oversampling;

/// Pulses of another finger, µs since power came: at any phase of this finger's own rounds.
const PULSES_US: [u64; 5] = [301_234, 402_617, 500_003, 617_999, 700_500];
/// How long each lasts, ns.
const LASTS_NS: u64 = 10 * MS;

/// A board that streams, with pulses to come.
fn streaming(crystal_ppm: i64) -> Board {
    let mut board = Board::started(&Setup { crystal_ppm, ..Setup::new() });
    board.stream(Oversampling::X1024);
    assert!(board.now_ns() < 1_000 * PULSES_US[0], "it began in {} ns", board.now_ns());
    PULSES_US.iter().for_each(|at_us| board.shared_line.pulse(1_000 * at_us, LASTS_NS));
    board
}

fn heard_until(board: &mut Board, until_us: u64) -> Vec<u64> {
    board.run_ns(1_000 * until_us - board.now_ns());
    board.listen();
    std::mem::take(&mut board.heard.pulses)
}

/// Between every two pulses, what the device's clock says less what it should, µs.
fn errors_us(pulses: &[u64], crystal_ppm: i64) -> Vec<f64> {
    assert_eq!(pulses.len(), PULSES_US.len(), "{pulses:?}");
    let passed = |times: &[u64]| times.windows(2).map(|it| (it[1] - it[0]) as f64).collect();
    let (own, all): (Vec<f64>, Vec<f64>) = (passed(pulses), passed(&PULSES_US));
    let fast = 1.0 + crystal_ppm as f64 * 1e-6;
    own.iter().zip(all).map(|(own, all)| own - all * fast).collect()
}

#[test]
fn every_finger_says_to_a_microsecond_when_the_line_rose_at_the_highest_rate() {
    for crystal_ppm in [0, 300, -300] {
        let mut board = streaming(crystal_ppm);
        let pulses = heard_until(&mut board, 750_000);
        let errors = errors_us(&pulses, crystal_ppm);
        assert!(errors.iter().all(|error| error.abs() <= 1.01), "{crystal_ppm} ppm: {errors:?}");
        assert_eq!(board.heard.left_out, 0);
    }
}

#[test]
fn a_line_that_bounces_and_one_that_only_twitches_say_nothing() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X4096);
    // Half a microsecond, and twice within a round of 10 ms.
    board.shared_line.pulse(300 * MS, 500);
    board.shared_line.pulse(351 * MS, 1_000_000);
    board.shared_line.pulse(353 * MS, 1_000_000);
    assert_eq!(heard_until(&mut board, 400_000), []);
    board.shared_line.pulse(450 * MS, LASTS_NS);
    assert_eq!(heard_until(&mut board, 500_000).len(), 1, "the next one counts");
}

#[test]
fn the_finger_whose_output_is_joined_to_the_line_raises_it_and_hears_it_as_all_do() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X4096);
    board.shared_line.join();
    let pulses = heard_until(&mut board, 1_250_000);
    let raised = board.shared_line.raised_ns();
    let [.., before, last] = raised[..] else { panic!("{raised:?}") };
    let apart_ms = (last - before) / MS;
    assert!((1_000..1_200).contains(&apart_ms), "{apart_ms} ms");
    // The first was before anyone listened.
    assert_eq!(pulses.len(), raised.len() - 1);
}

#[test]
fn an_output_that_is_joined_to_nothing_raises_nothing() {
    let mut board = Board::started(&Setup::new());
    board.stream(Oversampling::X4096);
    assert_eq!(heard_until(&mut board, 1_250_000), []);
    assert!(board.shared_line.raised_ns().len() > 1);
}
