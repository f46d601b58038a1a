//! Tables 3.1–3.4 come back from the rebuilt grasps.

use palpate::dissertation::{RelaxationRow, TABLE_3_1, TABLE_3_2, TABLE_3_3, TABLE_3_4};
use palpate_tests::{bundled, palpate};
use serde_json::Value;

fn fit(table: u32) -> Value {
    let traces = (1..=10).map(|row| bundled(&format!("table-3.{table}-row-{row:02}.csv")));
    let output = palpate().args(["fit", "fung", "--hold-only", "--json"]).args(traces).output();
    let output = output.expect("palpate runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// The printed values of a row by the names of the fit.
fn printed(row: &RelaxationRow) -> [(&'static str, f64); 6] {
    let ([c0, c1, c2], [v1, v2]) = (row.shares, row.rates);
    [("N", row.force), ("c0", c0), ("c1", c1), ("c2", c2), ("v1", v1), ("v2", v2)]
}

#[test]
fn every_row_comes_back_within_its_standard_errors() {
    let mut deviations = Vec::new();
    for (table, rows) in [(1, TABLE_3_1), (2, TABLE_3_2), (3, TABLE_3_3)] {
        let fitted = fit(table);
        for (row, hold) in rows.iter().zip(fitted["holds"].as_array().unwrap()) {
            assert_eq!(hold["type"], "Type I");
            for (name, value) in printed(row) {
                let estimate = &hold["parameters"][name];
                let error = estimate["standard_error"].as_f64().unwrap();
                let deviation = (estimate["value"].as_f64().unwrap() - value) / error;
                // 180 values: one in a thousand would lie beyond 3.3, none beyond 5.
                assert!(deviation.abs() < 5.0, "table 3.{table} {row:?}: {name} {estimate}");
                deviations.push(deviation);
            }
            // The noise was made for the printed R²; it scatters by about (1 − R²)/√N.
            let missed = (hold["r_squared"].as_f64().unwrap() - row.r_squared).abs();
            assert!(missed < 0.15 * (1.0 - row.r_squared) + 5e-5, "{row:?}: {}", hold["r_squared"]);
        }
    }
    let square = deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64;
    assert!((0.5..1.7).contains(&square), "mean square deviation {square} standard errors");
}

#[test]
fn table_3_4_comes_back_within_the_scatter_it_prints() {
    for (table, compression) in [(1, 12.0), (2, 8.0), (3, 4.0)] {
        let fitted = fit(table);
        let spread = fitted["spread"].as_array().unwrap();
        for line in TABLE_3_4.iter().filter(|line| line.compression == compression) {
            let found = spread.iter().find(|s| s["parameter"] == line.coefficient).unwrap();
            let number = |key: &str| found[key].as_f64().unwrap();
            assert_eq!(found["holds"], 10);
            // The noise of ten fits moves the mean by expected/√10 and adds to the deviation.
            let noise = number("expected_from_noise");
            let tolerance = 4.0 * noise / 10f64.sqrt() + 1e-4;
            assert!((number("mean") - line.mean).abs() < tolerance, "{line:?} {found}");
            let wider = line.deviation.hypot(noise);
            let moved = (number("standard_deviation") - wider).abs();
            assert!(moved < 3.0 * noise / 18f64.sqrt() + 0.35 * line.deviation, "{line:?} {found}");
        }
    }
}
