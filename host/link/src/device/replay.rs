//! Rows put into a device as if its converter had given them.

use std::time::{Duration, Instant};

use shared::pipeline::GAUGES;
use shared::wire::{
    self, Columns, Done, FRAME_MAX, FrameError, INJECT_ROWS, Inject, Row, Source, Start, Status,
    ToDevice,
};

use super::heard::Said;
use super::session::{LinkError, Session};
use super::stream::{Stream, Tally};

/// Rows that a device can take without being asked for its room, if they have all been heard.
const UNDER_WAY: u64 = 2 * INJECT_ROWS as u64;
/// Rows that are not heard after so long are lost.
const LOST_AFTER: Duration = Duration::from_millis(500);

/// What a device made of rows.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The rows that came back.
    pub rows: Vec<Row>,
    /// What came and what did not.
    pub tally: Tally,
    /// How the device was at the end.
    pub status: Status,
}

/// Sends rows of counts, `interval_ns` apart, and gathers what comes back. A stream that is on is ended.
///
/// # Errors
/// [`LinkError`] if the device refuses or falls silent.
pub fn replay(
    session: &mut Session,
    interval_ns: u32,
    columns: Columns,
    temperature: Option<i16>,
    counts: &[[i32; GAUGES]],
) -> Result<Replayed, LinkError> {
    session.settle()?;
    let start = Start { source: Source::Link { interval_ns }, columns };
    session.command(&ToDevice::Start(start))?;
    let mut hearing = Hearing { stream: Stream::default(), rows: Vec::new() };
    let (mut sent, mut room) = (0_u64, INJECT_ROWS);
    for rows in counts.chunks(INJECT_ROWS) {
        hearing.until(session, Duration::ZERO, |_| false)?;
        if room < rows.len() {
            let few = UNDER_WAY - rows.len() as u64;
            let few = |stream: &Stream| sent.saturating_sub(stream.next_row()) <= few;
            hearing.until(session, LOST_AFTER, few)?;
        }
        room = inject(session, rows, temperature)?.1.into();
        sent += rows.len() as u64;
    }
    hearing.until(session, LOST_AFTER, |stream| stream.next_row() >= sent)?;
    session.quiet()?;
    let status = session.status()?;
    hearing.until(session, Duration::ZERO, |_| false)?;
    Ok(Replayed { rows: hearing.rows, tally: *hearing.stream.tally(), status })
}

/// Sends a few rows, 1 to [`INJECT_ROWS`]; how many found room, and how many would next.
///
/// # Errors
/// [`LinkError`].
pub fn inject(
    session: &mut Session,
    rows: &[[i32; GAUGES]],
    temperature: Option<i16>,
) -> Result<(u8, u8), LinkError> {
    let mut packed = [0; FRAME_MAX];
    let gauges = session.identity().channels;
    match session.command(&ToDevice::Inject(message(rows, gauges, temperature, &mut packed)?))? {
        Done::Injected { taken, room, .. } => Ok((taken, room)),
        other => Err(LinkError::Unsuited(other)),
    }
}

/// The message that carries a few rows, 1 to [`INJECT_ROWS`], for a device with so many gauges.
///
/// # Errors
/// [`LinkError::TooLong`].
pub fn message<'b>(
    rows: &[[i32; GAUGES]],
    gauges: u8,
    temperature: Option<i16>,
    packed: &'b mut [u8; FRAME_MAX],
) -> Result<Inject<'b>, LinkError> {
    let counts = wire::pack(rows, gauges, packed).ok_or(FrameError::TooLong)?;
    Ok(Inject { temperature, counts })
}

/// What comes back.
struct Hearing {
    stream: Stream,
    rows: Vec<Row>,
}

impl Hearing {
    /// Hears until `enough`, or until no row has come for so long; what else a device says does not prolong it.
    fn until(
        &mut self,
        session: &mut Session,
        patience: Duration,
        enough: impl Fn(&Stream) -> bool,
    ) -> Result<(), LinkError> {
        let mut deadline = Instant::now() + patience;
        while !enough(&self.stream) {
            let Some(heard) = session.hear(deadline)? else { break };
            self.stream.take(&heard);
            if let Ok((_, Said::Rows(rows))) = &heard.said {
                self.rows.extend(session.rows(rows).into_iter().flatten());
                deadline = Instant::now() + patience;
            }
        }
        Ok(())
    }
}
