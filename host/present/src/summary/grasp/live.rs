//! The margin as it comes, line by line.

use serde_json::{Value, json};

use super::finite;
use palpate_contact::grasp::live::{Hold, Reading};

/// How a grasp is, in a word.
const fn state(held: bool, slips: bool, will_slip: bool) -> (&'static str, &'static str) {
    match (held, slips, will_slip) {
        (false, ..) => ("none", "no grasp"),
        (true, true, _) => ("slips", "SLIPS"),
        (true, false, true) => ("will-slip", "will slip once settled"),
        (true, false, false) => ("holds", "holds"),
    }
}

/// One line for a person.
#[must_use]
pub fn reading_line(reading: &Reading) -> String {
    let margin = |hold: &Hold| match hold.margin {
        None => "    –".into(),
        Some(margin) if margin > 99.0 => "  >99".into(),
        Some(margin) => format!("{margin:5.2}"),
    };
    let now = &reading.now;
    let (_, words) = state(now.margin.is_some(), reading.slips(), reading.will_slip());
    let words = match (reading.slips_in, reading.tighten) {
        (Some(time), Some(more)) if !reading.slips() => {
            format!("slips in {time:.1} s, needs {more:.3} N more")
        }
        (Some(time), _) if !reading.slips() => format!("slips in {time:.1} s"),
        (_, Some(more)) => format!("{words}, needs {more:.3} N more"),
        _ => words.to_owned(),
    };
    format!(
        "{:9.3} s  N {:7.3} N  f {:7.3} N  m {:7.3} N mm  margin {}  settled {}  {words}",
        reading.time,
        now.normal,
        now.load.tangential(),
        now.load.moment,
        margin(now),
        margin(&reading.settled),
    )
}

/// One JSON object for a program. A margin is none without a grasp and without a load.
#[must_use]
pub fn reading_json(reading: &Reading) -> Value {
    let hold = |hold: &Hold| {
        json!({
            "normal_N": hold.normal,
            "force_N": hold.load.force[0],
            "moment_Nmm": hold.load.moment,
            "margin": hold.margin.and_then(finite),
            "used": hold.margin.and_then(|margin| finite(margin.recip())),
        })
    };
    let (name, _) = state(reading.now.margin.is_some(), reading.slips(), reading.will_slip());
    json!({
        "palpate_grasp_reading": 1,
        "time_s": reading.time,
        "state": name,
        "now": hold(&reading.now),
        "settled": hold(&reading.settled),
        "compression_mm": reading.compression,
        "slips_in_s": reading.slips_in,
        "tighten_N": reading.tighten,
    })
}
