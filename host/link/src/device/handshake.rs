//! Two programs introduce themselves, and part if they speak different languages.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use shared::pipeline::GAUGES;
use shared::wire::{
    Capabilities, EARLIER, FRAME_MAX, Head, HelloToDevice, Kept, Refusal, SCHEMA, Settings,
    ToDevice, encode,
};

use super::heard::{Heard, Identity, Said};
use super::line::Line;
use super::session::{LinkError, VERSION};

/// `Hello` is said again after so long.
const REPEAT: Duration = Duration::from_millis(250);

/// A device that was met.
pub(super) struct Met {
    pub(super) identity: Identity,
    pub(super) generation: u32,
    pub(super) settings: Settings,
}

/// Says `Hello` until the device has said who it is and what its settings are, or `patience` is over. All that is heard
/// meanwhile goes to `kept`.
pub(super) fn introduce(
    line: &mut Line,
    sequence: &mut u32,
    kept: &mut VecDeque<Heard>,
    patience: Duration,
) -> Result<Met, LinkError> {
    let until = Instant::now() + patience;
    let mut meeting = Meeting { schema: SCHEMA, ..Meeting::default() };
    while Instant::now() < until {
        *sequence = sequence.wrapping_add(1);
        meeting.answered = false;
        let mut frame = [0; FRAME_MAX];
        let hello = ToDevice::Hello(HelloToDevice { schema: meeting.schema, version: VERSION });
        let hello = encode(Head { sequence: *sequence, time_us: 0 }, &hello, &mut frame)?;
        // The zero byte ends whatever was on the line before.
        line.send(&[0])?;
        line.send(hello)?;
        let deadline = until.min(Instant::now() + REPEAT);
        let spoken = meeting.schema;
        while let Some(heard) = line.receive(deadline)?.and_then(Heard::of) {
            meeting.hear(&heard, *sequence)?;
            kept.push_back(heard);
            if let Some(met) = meeting.met() {
                return Ok(met);
            }
            if meeting.schema != spoken {
                break;
            }
        }
    }
    Err(meeting.failure())
}

/// What is known so far.
#[derive(Default)]
struct Meeting {
    /// The one that we speak; that of the device's release once it is known to be an earlier one.
    schema: u64,
    identity: Option<Identity>,
    settings: Option<(u32, Settings)>,
    kept: Option<Kept>,
    converter: Option<(String, Capabilities)>,
    answered: bool,
    refused: Option<u64>,
    damaged: usize,
}

impl Meeting {
    fn hear(&mut self, heard: &Heard, sequence: u32) -> Result<(), LinkError> {
        match &heard.said {
            Ok((_, Said::Foreign { schema, version })) => {
                return Err(LinkError::Schema { theirs: version.clone(), their_schema: *schema });
            }
            Ok((_, Said::Hello(identity))) if usize::from(identity.channels) > GAUGES => {
                return Err(LinkError::Gauges { theirs: identity.channels });
            }
            Ok((_, Said::Hello(identity))) => self.identity = Some((**identity).clone()),
            Ok((_, Said::Kept(kept))) => self.kept = Some(*kept),
            Ok((_, Said::Converter(part, capabilities))) => {
                self.converter = Some((part.clone(), **capabilities));
            }
            Ok((_, Said::Settings(generation, settings))) => {
                self.settings = Some((*generation, **settings));
            }
            Ok((_, Said::Answer(answer))) if answer.to == sequence => match answer.outcome {
                Err(Refusal::Schema(schema)) if EARLIER.contains(&schema) => self.schema = schema,
                Err(Refusal::Schema(schema)) => self.refused = Some(schema),
                _ => self.answered = true,
            },
            Ok(_) => {}
            Err(_) => self.damaged += 1,
        }
        Ok(())
    }

    fn met(&mut self) -> Option<Met> {
        if !self.answered || self.identity.is_none() {
            return None;
        }
        let (generation, settings) = self.settings?;
        let mut identity = Identity { kept: self.kept, ..self.identity.take()? };
        if let Some((converter, capabilities)) = self.converter.take() {
            identity = Identity { converter, capabilities, ..identity };
        }
        Some(Met { generation, settings, identity })
    }

    fn failure(&self) -> LinkError {
        match self.refused {
            // Its own Hello was lost on the line each time.
            Some(their_schema) => {
                LinkError::Schema { theirs: "of unknown version".into(), their_schema }
            }
            None => LinkError::Silent { damaged: self.damaged },
        }
    }
}
