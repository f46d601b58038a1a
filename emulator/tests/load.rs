//! What a row costs on the whole chip: interrupts, bus, filter, frames and line together. Cycles are counted without wait states of
//! the flash; every run counts the same.

use emulator::{BOOT_MS, Board, Load, MS, Setup};
use shared::wire::{Columns, Oversampling, Source, Start, ToDevice};

/// The processor's clock, Hz.
const CLOCK_HZ: f64 = 168e6;
/// 49 rows at the slowest rate.
const MEASURED_MS: u64 = 50;
const RATES: [(Oversampling, f64); 3] = [
    (Oversampling::X4096, 976.5625),
    (Oversampling::X2048, 1_953.125),
    (Oversampling::X1024, 3_906.25),
];

fn measured(line: &str, board: &mut Board, columns: Columns) -> Vec<Load> {
    let mut loads = Vec::new();
    for (rate, hz) in RATES {
        board.ask(&ToDevice::SetRatio(rate), 40).outcome.unwrap();
        let start = Start { source: Source::Converter, columns };
        board.ask(&ToDevice::Start(start), 100).outcome.unwrap();
        board.listen_ms(30);
        let load = board.load(MEASURED_MS);
        let row = load.whole * CLOCK_HZ / hz;
        let parts =
            load.parts.iter().map(|(name, share)| format!("{name} {:.0}", share * CLOCK_HZ / hz));
        let parts: Vec<_> = parts.collect();
        println!(
            "{line}, {hz:.0} Hz: {:.1} % of the processor, {row:.0} cycles a row: {}",
            100.0 * load.whole,
            parts.join(", ")
        );
        board.ask(&ToDevice::Stop, 100).outcome.unwrap();
        loads.push(load);
    }
    loads
}

#[test]
fn at_the_fastest_rate_half_of_the_processor_is_free() {
    // A tenth of the usual one, which would count as work.
    let fine = Setup { quantum_ns: 200, ..Setup::new() };
    let mut serial = Board::started(&fine);
    let mut plugged_in = Board::new(&fine);
    plugged_in.run_ns(BOOT_MS * MS);
    plugged_in.plug_in();
    plugged_in.hello();
    for (line, board) in [("serial line", &mut serial), ("USB", &mut plugged_in)] {
        let loads = measured(line, board, Columns::Parts);
        assert!(loads.iter().all(|load| load.whole < 0.5), "{line}: {loads:?}");
        assert!(loads[2].whole > 0.01, "{line}: nothing was seen");
        // An interrupt for each byte takes 1,400 cycles a row.
        let line_alone = loads[2].parts.get("line").copied().unwrap_or_default();
        let sending = line_alone * CLOCK_HZ / RATES[2].1;
        assert!(sending < 300.0, "{line}: {sending:.0} cycles of a row are spent on sending it");
    }
}
