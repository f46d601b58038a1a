//! Who is there, and whether both sides speak one language.

use std::path::Path;
use std::time::{Duration, Instant};

use palpate::device::heard::{Heard, Said};
use palpate::device::line::Line;
use shared::wire::{
    Answer, Done, FRAME_MAX, Head, HelloToDevice, Refusal, SCHEMA, ToDevice, encode,
};

use super::{Checked, Report, open, require};

/// A device says who it is and what its settings are.
///
/// # Errors
/// What it did instead.
pub fn check_handshake(port: &Path) -> Checked {
    let began = Instant::now();
    let mut session = open(port)?;
    let took = began.elapsed();
    let identity = session.identity().clone();
    require(identity.channels == 4, || format!("{} channels", identity.channels))?;
    require(!identity.version.is_empty(), || "a firmware without version".into())?;
    let config = session.settings().1.config(session.interval_s());
    config.map_err(|error| format!("settings that do not suit the rate: {error}"))?;
    session.status()?;
    Ok(Report::new("handshake")
        .with("ms", took.as_millis())
        .with("board", &identity.board)
        .with("firmware", &identity.version))
}

/// A host of another schema is refused with the device's, every time, and can still see who the device is.
///
/// # Errors
/// What the device did instead.
pub fn check_wrong_schema_is_refused(port: &Path) -> Checked {
    let mut line = Line::open(port)?;
    let first = 0x5eed_0000;
    let wrong = HelloToDevice { schema: SCHEMA ^ 1, version: "0.0.0-other" };
    let said = talk(&mut line, first, &ToDevice::Hello(wrong))?;
    let refusal = Err(Refusal::Schema(SCHEMA));
    require(answer(&said, first) == Some(refusal), || format!("Hello was answered by {said:?}"))?;
    let knows = said.iter().find_map(|said| match said {
        Said::Hello(identity) => Some(identity.version.clone()),
        _ => None,
    });
    let version = knows.ok_or_else(|| format!("it did not say who it is: {said:?}"))?;
    let said = talk(&mut line, first + 1, &ToDevice::Settings)?;
    require(answer(&said, first + 1) == Some(refusal), || {
        format!("a command in spite of that was answered by {said:?}")
    })?;
    // What never changes is done for a host of any release.
    let said = talk(&mut line, first + 2, &ToDevice::Status)?;
    require(answer(&said, first + 2) == Some(Ok(Done::Carried)), || {
        format!("to tell the status was answered by {said:?}")
    })?;
    drop(line);
    // Nothing of it stays.
    open(port)?.status()?;
    Ok(Report::new("wrong schema")
        .with("", format!("refused by firmware {version} with schema {SCHEMA:#018x}")))
}

/// Sends a command until it is answered, and says all that was heard.
fn talk(line: &mut Line, sequence: u32, command: &ToDevice<'_>) -> Result<Vec<Said>, String> {
    let mut frame = [0; FRAME_MAX];
    let head = Head { sequence, time_us: 0 };
    let frame = encode(head, command, &mut frame).map_err(|error| error.to_string())?;
    let mut heard = Vec::new();
    for _ in 0..10 {
        line.send(&[0]).and_then(|()| line.send(frame)).map_err(|error| error.to_string())?;
        let until = Instant::now() + Duration::from_millis(500);
        while let Some(arrival) = line.receive(until).map_err(|error| error.to_string())? {
            heard.extend(Heard::of(arrival).and_then(|heard| heard.said.ok()).map(|said| said.1));
            if answer(&heard, sequence).is_some() {
                return Ok(heard);
            }
        }
    }
    Err(format!("no answer to {command:?}; heard {heard:?}"))
}

fn answer(said: &[Said], sequence: u32) -> Option<Result<Done, Refusal>> {
    said.iter().find_map(|said| match said {
        Said::Answer(Answer { to, outcome }) if *to == sequence => Some(*outcome),
        _ => None,
    })
}
