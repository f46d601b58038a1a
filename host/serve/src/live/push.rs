//! Rows to a page, at the rate of its display.
//!
//! A binary message has, little-endian: f64 rows that were lost on the way from the device, f64 frames and f64 rows that
//! this page was not sent because it did not keep up, f64 when the last row arrived (ms since 1970), f64 number of the first
//! row, u32 rows n, u32 signals m; then n times and how long nothing was known before each, as f64 (s), and n values of each
//! signal as f32 (µε). A text message is JSON: `{"health": …, "events": […]}`.
//!
//! The page answers each binary message with any text. With [`IN_FLIGHT`] messages unanswered, those that follow are dropped
//! whole and counted; what was in them can still be fetched from the session.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use axum::body::Bytes;
use axum::extract::ws::{Message, WebSocket};
use serde_json::{Value, json};
use tokio::time::MissedTickBehavior;

use super::feed::lock;
use super::pyramid::{Row, SIGNALS};
use super::store::{Event, Store};

/// Between two looks for rows; they come in blocks, each of which is sent as it comes.
const TICK: Duration = Duration::from_millis(4);
/// Between two messages of health.
const HEALTH: Duration = Duration::from_millis(250);
/// Messages that may be unanswered.
const IN_FLIGHT: u32 = 16;
/// Events that a page is told at first.
const EVENTS: u64 = 200;

/// Sends until the page goes away.
pub(super) async fn push(mut socket: WebSocket, store: Arc<Mutex<Store>>) {
    let mut page = Page::new(&lock(&store));
    let mut ticks = tokio::time::interval(TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Text(_))) => page.in_flight = page.in_flight.saturating_sub(1),
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => {}
            },
            _ = ticks.tick() => {
                // The lock is not held while a message is sent.
                let due = page.due(&mut lock(&store));
                for message in due.into_iter().flatten() {
                    if socket.send(message).await.is_err() {
                        return;
                    }
                }
            }
        }
    }
}

/// What a page has been sent.
struct Page {
    next_row: u64,
    next_event: u64,
    in_flight: u32,
    frames_dropped: u64,
    rows_dropped: u64,
    told: Option<Instant>,
}

impl Page {
    fn new(store: &Store) -> Self {
        Self {
            next_row: store.pyramid.count(),
            next_event: store.happened().saturating_sub(EVENTS),
            in_flight: 0,
            frames_dropped: 0,
            rows_dropped: 0,
            told: None,
        }
    }

    /// What is to be sent now: rows, health.
    fn due(&mut self, store: &mut Store) -> [Option<Message>; 2] {
        let count = store.pyramid.count();
        if self.in_flight >= IN_FLIGHT {
            if count > self.next_row {
                self.frames_dropped += 1;
                self.rows_dropped += count - self.next_row;
                self.next_row = count;
            }
            return [None, None];
        }
        let rows = (count > self.next_row).then(|| self.rows(store));
        let is_due = self.told.is_none_or(|told| told.elapsed() >= HEALTH);
        [rows, is_due.then(|| self.health(store))]
    }

    fn rows(&mut self, store: &Store) -> Message {
        let (missing, rows) = store.pyramid.after(self.next_row);
        self.rows_dropped += missing;
        let rows: Vec<&Row> = rows.collect();
        let first = self.next_row + missing;
        let head = [
            store.health.tally.rows_lost as f64,
            self.frames_dropped as f64,
            self.rows_dropped as f64,
            store.arrived_ms(),
            first as f64,
        ];
        self.next_row = first + rows.len() as u64;
        self.in_flight += 1;
        let mut bytes = Vec::with_capacity(48 + rows.len() * (16 + 4 * SIGNALS));
        head.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend((rows.len() as u32).to_le_bytes());
        bytes.extend((SIGNALS as u32).to_le_bytes());
        rows.iter().for_each(|row| bytes.extend(row.time_s.to_le_bytes()));
        rows.iter().for_each(|row| bytes.extend(row.gap_s.to_le_bytes()));
        for signal in 0..SIGNALS {
            rows.iter().for_each(|row| bytes.extend(row.values[signal].to_le_bytes()));
        }
        Message::Binary(Bytes::from(bytes))
    }

    fn health(&mut self, store: &mut Store) -> Message {
        self.told = Some(Instant::now());
        let mut health = store.health_json();
        health["frames_dropped"] = self.frames_dropped.into();
        health["rows_dropped"] = self.rows_dropped.into();
        let events: Vec<Value> = store.events_after(self.next_event).map(Event::json).collect();
        self.next_event = store.happened();
        Message::Text(json!({ "health": health, "events": events }).to_string().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_does_not_answer_loses_whole_messages_and_is_told_how_many() {
        let mut store = Store::new();
        let mut page = Page::new(&store);
        for row in 0..28 {
            store.pyramid.push(f64::from(row), 1.0, &[0.0; SIGNALS]);
            page.due(&mut store);
        }
        assert_eq!((page.in_flight, page.frames_dropped, page.rows_dropped), (16, 12, 12));
        page.in_flight = 0;
        store.pyramid.push(28.0, 1.0, &[0.0; SIGNALS]);
        let [Some(Message::Binary(bytes)), _] = page.due(&mut store) else { panic!("no rows") };
        let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        assert_eq!([8, 16, 32].map(number), [12.0, 12.0, 28.0]);
        assert_eq!(bytes.len(), 48 + 16 + 4 * SIGNALS);
    }
}
