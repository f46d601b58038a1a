//! The room of the device itself: which there are, who this one is, its settings, its calibration, its test.
//!
//! It is there wherever [`live`](super::live) is, and asks the device through it: there is one port.
//!
//! - `GET /api/device/ports`: what answers on the serial ports, as `palpate device list` says.
//! - `GET /api/device/watch`: a websocket that tells five times a second, as JSON, what health tells, and what
//!   [`Bench`](super::live::bench::Bench) has.
//!
//! What is asked of the device is a [`Wish`](super::live::wish::Wish), at `POST /api/live/wish`.

mod ports;
mod watch;

use std::path::PathBuf;
use std::sync::Arc;

use axum::extract::{State, WebSocketUpgrade};
use axum::response::Response;
use axum::routing::get;
use axum::{Json, Router};
use serde_json::Value;

use super::guard::{MESSAGE_LIMIT, PROTOCOL};
use super::live::Live;

/// Held while ports are asked, so that two pages do not open the same one.
pub type Asking = Arc<tokio::sync::Mutex<()>>;

/// What the room needs of the device.
#[derive(Clone)]
struct Room {
    live: Arc<Live>,
    /// Ports of the other fingers.
    beside: Arc<[PathBuf]>,
    asking: Asking,
}

/// What the page asks of the room of one finger; ports of the others, `beside`, are left alone. `asking` is that of all fingers.
pub fn routes(live: Arc<Live>, beside: Arc<[PathBuf]>, asking: Asking) -> Router {
    let room = Room { live, beside, asking };
    Router::new().route("/ports", get(list)).route("/watch", get(follow)).with_state(room)
}

async fn list(State(room): State<Room>) -> Json<Value> {
    let _asking = room.asking.lock().await;
    let (live, beside) = (Arc::clone(&room.live), Arc::clone(&room.beside));
    let asked = tokio::task::spawn_blocking(move || ports::list(&live.port, &beside, &live.store));
    // A thread that panicked has said so.
    Json(asked.await.unwrap_or_default())
}

async fn follow(State(room): State<Room>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .protocols([PROTOCOL])
        .max_message_size(MESSAGE_LIMIT)
        .max_frame_size(MESSAGE_LIMIT)
        .on_upgrade(move |socket| watch::watch(socket, Arc::clone(&room.live.store)))
}
