//! What a term can come from, told by its shape, and the experiment that would confirm it.

use super::grammar::Term;
use palpate_model::Stage;

/// A cause of terms of some kind.
#[derive(Debug, PartialEq, Eq)]
pub struct Cause {
    /// Beginnings of the names of the shapes; any where there is none.
    shapes: &'static [&'static str],
    /// Symbols that the quantity contains; any where there is none.
    quantities: &'static [&'static str],
    /// Stages; any where there is none.
    stages: &'static [Stage],
    /// What it can come from.
    pub cause: &'static str,
    /// What would confirm it.
    pub experiment: &'static str,
}

/// Causes; the first that fits is told.
pub const CAUSES: [Cause; 28] = [
    Cause {
        shapes: &[],
        quantities: &["since((0.5 - abs(sign(v))) * total(abs(v)))"],
        stages: &[],
        cause: "what moved goes on after each stop: the frame swings out, the drive settles, a fluid comes to rest",
        experiment: "stop from three speeds at one place, on the specimen and off it",
    },
    Cause {
        shapes: &[],
        quantities: &["F * v"],
        stages: &[],
        cause: "the work that is done turns to heat in the specimen or the sensor",
        experiment: "repeat one press without pauses, then with pauses ten times as long",
    },
    Cause {
        shapes: &["periodic"],
        quantities: &["x", "total"],
        stages: &[Stage::Motion],
        cause: "the drive does not move as it says: a screw or a belt that errs once a turn",
        experiment: "measure the motion with a second sensor over several turns of the drive",
    },
    Cause {
        shapes: &["periodic"],
        quantities: &["x", "total"],
        stages: &[],
        cause: "teeth, poles or a screw of the drive, or a surface with ridges",
        experiment: "run the same stroke without contact: what stays belongs to the drive, not to the specimen",
    },
    Cause {
        shapes: &["periodic"],
        quantities: &["t_set"],
        stages: &[Stage::Motion, Stage::Elasticity, Stage::Relaxation, Stage::Contact],
        cause: "what surrounds the specimen swings over the session: the room's temperature or humidity, a supply",
        experiment: "log temperature and humidity beside the recordings, and repeat one press every ten minutes",
    },
    Cause {
        shapes: &["periodic"],
        quantities: &["t", "since", "t_set"],
        stages: &[],
        cause: "something vibrates or hums at a steady rate",
        experiment: "record at rest off the specimen with the drive on, then off",
    },
    Cause {
        shapes: &["sawtooth"],
        quantities: &["F"],
        stages: &[],
        cause: "the converter's codes are uneven, or the signal was rounded to coarse steps",
        experiment: "load slowly through a few periods: jumps at the same values of the signal belong to the converter",
    },
    Cause {
        shapes: &["sawtooth"],
        quantities: &["x", "total"],
        stages: &[],
        cause: "something catches and slips at even distances: a ratchet, teeth, a surface with ridges",
        experiment: "run the same stroke without contact, then at a tenth of the speed",
    },
    Cause {
        shapes: &["worn by"],
        quantities: &["v"],
        stages: &[],
        cause: "motion breaks a structure down that rest builds up again: thixotropy, a filler network",
        experiment: "press after rests of 1, 10 and 100 s, and at three speeds after the same rest",
    },
    Cause {
        shapes: &["worn by"],
        quantities: &[],
        stages: &[],
        cause: "load drives something out that comes back: a fluid, bonds that open, a zero that creeps",
        experiment: "hold at two depths for ten times as long, and rest as long after each",
    },
    Cause {
        shapes: &["switched"],
        quantities: &[],
        stages: &[],
        cause: "something snaps over and back at another load: a dome or a strut that buckles, a latch, a bond that opens",
        experiment: "press slowly to just before that place and back, then to just beyond it and back",
    },
    Cause {
        shapes: &["bump"],
        quantities: &["x"],
        stages: &[Stage::Elasticity, Stage::Contact, Stage::Motion],
        cause: "something gives way or catches at one compression: a strut that buckles, an inclusion, a seam",
        experiment: "press slowly through that place, then with the specimen turned: what moves with it belongs to the specimen",
    },
    Cause {
        shapes: &["bump"],
        quantities: &["x"],
        stages: &[],
        cause: "something gives way or catches at one place of the stroke",
        experiment: "run the same stroke without contact: what stays belongs to the drive",
    },
    Cause {
        shapes: &["step", "from one"],
        quantities: &["x", "F"],
        stages: &[],
        cause: "a second body is met from there on: a stop, a backing, another layer",
        experiment: "press to just before that place and to just beyond it",
    },
    Cause {
        shapes: &["step", "from one", "bump"],
        quantities: &["t", "T", "n"],
        stages: &[],
        cause: "something changed once: a bond that broke, a mount that moved, a range that was switched",
        experiment: "repeat the first recording: what has changed for good shows at once",
    },
    Cause {
        shapes: &["decaying"],
        quantities: &["x"],
        stages: &[],
        cause: "something acts near the first contact only: a film, roughness, a tilted face",
        experiment: "touch ten times at a tenth of the depth, and clean or level the faces",
    },
    Cause {
        shapes: &["decaying", "saturating"],
        quantities: &["t"],
        stages: &[],
        cause: "something settles after the recording begins: an amplifier that warms up, a mount that creeps",
        experiment: "wait ten times as long before the first touch",
    },
    Cause {
        shapes: &["behind"],
        quantities: &[],
        stages: &[],
        cause: "something follows with a delay: a filter, trapped air or fluid, a thermal mass",
        experiment: "press the same stroke at a tenth and at ten times the speed",
    },
    Cause {
        shapes: &[],
        quantities: &["T"],
        stages: &[],
        cause: "the specimen or the sensor answers to temperature",
        experiment: "step the temperature by 5 K, wait, and repeat one press",
    },
    Cause {
        shapes: &[],
        quantities: &["n", "x_max"],
        stages: &[],
        cause: "the specimen changes with what it has been through",
        experiment: "rest an hour, then repeat one cycle three times; or take a new specimen",
    },
    Cause {
        shapes: &[],
        quantities: &["t_set"],
        stages: &[],
        cause: "specimen or sensor drift over the session",
        experiment: "repeat the first recording at the end of the session",
    },
    Cause {
        shapes: &[],
        quantities: &["sign(v)"],
        stages: &[],
        cause: "dry friction of the drive, the guide or the contact",
        experiment: "run small cycles about one place, slow and fast: dry friction does not depend on the speed",
    },
    Cause {
        shapes: &[],
        quantities: &["v", "a"],
        stages: &[Stage::Sensor, Stage::Contact],
        cause: "a resistance to the motion itself: a bearing, a seal, air or fluid that is displaced",
        experiment: "run the same stroke without contact at three speeds",
    },
    Cause {
        shapes: &[],
        quantities: &["v"],
        stages: &[],
        cause: "a dependence on the rate that the law of relaxation lacks",
        experiment: "triangles without holds over three decades of speed",
    },
    Cause {
        shapes: &[],
        quantities: &["t"],
        stages: &[],
        cause: "something goes on within each recording: drift, drying, heating",
        experiment: "record for ten times as long at one depth",
    },
    Cause {
        shapes: &[],
        quantities: &["F"],
        stages: &[],
        cause: "the characteristic of the sensor is not straight",
        experiment: "hang dead weights on the sensor, up and down",
    },
    Cause {
        shapes: &[],
        quantities: &["x"],
        stages: &[Stage::Elasticity, Stage::Contact, Stage::Relaxation],
        cause: "the specimen answers to the compression in another form than the base law has",
        experiment: "presses to four depths at one speed, with a hold at each",
    },
    Cause {
        shapes: &[],
        quantities: &[],
        stages: &[],
        cause: "the set-up adds a force along its stroke: a cable, a spring, a slope",
        experiment: "run the same stroke without contact",
    },
];

/// What a term can come from.
#[must_use]
pub fn cause_of(term: &Term) -> &'static Cause {
    let symbols: Vec<&str> =
        term.quantity.symbol.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let fits = |cause: &&Cause| {
        let shape = cause.shapes.is_empty()
            || cause.shapes.iter().any(|it| term.shape.name.starts_with(it));
        let quantity = cause.quantities.is_empty()
            || cause
                .quantities
                .iter()
                .any(|it| symbols.contains(it) || term.quantity.symbol == *it);
        let stage = cause.stages.is_empty() || cause.stages.contains(&term.stage);
        shape && quantity && stage
    };
    CAUSES.iter().find(fits).unwrap_or(&CAUSES[CAUSES.len() - 1])
}
