//! How the device is, to a page, five times a second.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use tokio::time::MissedTickBehavior;

use crate::live::lock;
use crate::live::store::Store;

/// Between two messages.
const TICK: Duration = Duration::from_millis(200);

/// Tells until the page goes away.
pub(super) async fn watch(mut socket: WebSocket, store: Arc<Mutex<Store>>) {
    let mut ticks = tokio::time::interval(TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut next = 0;
    loop {
        tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => {}
            },
            _ = ticks.tick() => {
                let told = told(&mut lock(&store), &mut next);
                if socket.send(Message::text(told)).await.is_err() {
                    return;
                }
            }
        }
    }
}

/// Health and bench, with the readings that this page has not been told.
fn told(store: &mut Store, next: &mut u64) -> String {
    let mut all = store.health_json();
    all["bench"] = store.bench.json(*next);
    *next = store.bench.readings.taken();
    all.to_string()
}
