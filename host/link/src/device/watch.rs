//! Rows of a device as they come, kept nowhere.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use shared::wire::{Columns, Row, Source, Start, ToDevice};

use super::heard::Said;
use super::session::{LinkError, Session};
use super::stream::{Stream, Tally};

/// How long to listen before asking whether to end.
const SLICE: Duration = Duration::from_millis(50);
/// Nothing came for so long: the converter stands still.
const STANDSTILL: Duration = Duration::from_secs(2);

/// Streams all columns until `ended`, or until `each`, which sees every row, breaks off. Tells what came and
/// what did not.
///
/// # Errors
/// [`LinkError`]; [`LinkError::NoRows`].
pub fn watch(
    session: &mut Session,
    ended: impl Fn() -> bool,
    mut each: impl FnMut(&Row) -> ControlFlow<()>,
) -> Result<Tally, LinkError> {
    session.settle()?;
    let start = Start { source: Source::Converter, columns: Columns::All };
    session.command(&ToDevice::Start(start))?;
    let mut stream = Stream::default();
    let mut last = Instant::now();
    while !ended() {
        if last.elapsed() > STANDSTILL {
            return Err(LinkError::NoRows);
        }
        let Some(heard) = session.hear(Instant::now() + SLICE)? else { continue };
        stream.take(&heard);
        if let Ok((_, Said::Rows(rows))) = &heard.said {
            last = Instant::now();
            let mut rows = session.rows(rows).into_iter().flatten();
            if rows.try_for_each(|row| each(&row)).is_break() {
                break;
            }
        }
    }
    session.quiet()?;
    Ok(*stream.tally())
}
