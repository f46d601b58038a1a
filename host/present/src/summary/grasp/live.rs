//! The margin as it comes, line by line.

use crate::answers::GraspState;
use palpate_contact::grasp::live::{Hold, Reading};

/// How a grasp is, in words.
const fn words_of(state: GraspState) -> &'static str {
    match state {
        GraspState::None => "no grasp",
        GraspState::Slips => "SLIPS",
        GraspState::WillSlip => "will slip once settled",
        GraspState::Holds => "holds",
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
    let words = words_of(GraspState::from(reading));
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
