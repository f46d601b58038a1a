//! A local page: rooms in a browser on this computer, over the same functions as the commands.
//!
//! ```text
//! browser ── guard: host, origin, token, policy, sizes ──┬── assets: the page, part of the program
//!                                                        └── /api/<room>/: what a room asks for
//! ```
//!
//! - [`guard`]: who may ask, and what a page may do.
//! - [`connections`]: how many, and for how long.
//! - [`assets`]: the files of the page.
//! - [`live`]: a fingertip, while it feels; of a hand every one, at `/api/fingers/N/live/`, N from 1.
//! - [`lab`]: a model beside recordings, and putting it right.
//! - [`device`]: the device behind the fingertip.
//!
//! A room is mounted only where it has something to show. `/api/live/` and `/api/device/` are those of the first finger.
//!
//! ```
//! use std::net::Ipv4Addr;
//!
//! use palpate_serve::{Options, run};
//!
//! # fn main() -> Result<(), palpate_serve::ServeError> {
//! let options = Options { bind: Ipv4Addr::LOCALHOST.into(), port: 0, fingers: Vec::new(), lab: None };
//! // It ends when it is asked: here at once.
//! run(options, |address| println!("open {address}"), || true)?;
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod assets;
pub mod connections;
pub mod device;
pub mod guard;
pub mod held;
pub mod lab;
pub mod live;
mod problem;

pub use problem::Problem;

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::Router;
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use serde_json::{Value, json};
use tokio::net::TcpListener;

use self::guard::{Guard, TokenError};
use self::lab::Session;
use self::live::Live;

/// How often to look whether to end.
const LOOK: Duration = Duration::from_millis(50);

/// Where to serve, and what.
pub struct Options {
    /// Address to listen on; only a loopback address keeps the page on this computer.
    pub bind: IpAddr,
    /// Port to listen on; 0 for any that is free.
    pub port: u16,
    /// The fingertips, those of a hand beside each other; none for the Lab alone.
    pub fingers: Vec<Live>,
    /// The room of a model and recordings, if a folder was opened.
    pub lab: Option<Session>,
}

/// Why the page cannot be served.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ServeError {
    #[error("{at} cannot be listened on: {source}")]
    Listen { at: SocketAddr, source: io::Error },
    #[error(transparent)]
    Token(#[from] TokenError),
    #[error("the server ended: {0}")]
    Server(#[from] io::Error),
}

/// Serves until `ended`; `ready` is told the address to open once, with its token.
///
/// # Errors
/// [`ServeError`].
pub fn run(
    options: Options,
    ready: impl FnOnce(&str),
    ended: impl Fn() -> bool,
) -> Result<(), ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(async {
        let at = SocketAddr::new(options.bind, options.port);
        let listener =
            TcpListener::bind(at).await.map_err(|source| ServeError::Listen { at, source })?;
        let at = listener.local_addr()?;
        let guard = Guard::new(at)?;
        ready(&guard.url());
        let router = router(options.fingers, options.lab, Arc::new(guard));
        let end = async {
            while !ended() {
                tokio::time::sleep(LOOK).await;
            }
        };
        // A browser keeps its connections open, so the server does not wait for them.
        tokio::select! {
            served = connections::serve(listener, router) => Ok(served?),
            () = end => Ok(()),
        }
    })
}

fn router(fingers: Vec<Live>, lab: Option<Session>, guard: Arc<Guard>) -> Router {
    let fingers: Vec<Arc<Live>> = fingers.into_iter().map(Arc::new).collect();
    let about = Json(about(&fingers, lab.is_some()));
    let mut api = Router::new().route("/rooms", get(async || about));
    let asking = device::Asking::default();
    for (index, finger) in fingers.iter().enumerate() {
        let beside = beside(&fingers, index);
        let rooms = Router::new()
            .nest("/live", live::routes(Arc::clone(finger)))
            .nest("/device", device::routes(Arc::clone(finger), beside, Arc::clone(&asking)));
        // Where none is named, the first.
        if index == 0 {
            api = api.merge(rooms.clone());
        }
        api = api.nest(&format!("/fingers/{}", index + 1), rooms);
    }
    if let Some(session) = lab {
        api = api.nest("/lab", lab::routes(session));
    }
    let api = api.fallback(async || Problem::not_found("there is nothing of this name"));
    Router::new()
        .nest("/api", api)
        .fallback(get(assets::serve))
        .layer(from_fn_with_state(guard, guard::guard))
}

/// Which rooms there are, which is opened first, and which fingers.
fn about(fingers: &[Arc<Live>], lab: bool) -> Value {
    let mounted = [
        ("hand", "Hand", fingers.len() > 1),
        ("live", "Live", !fingers.is_empty()),
        ("lab", "Lab", lab),
        ("device", "Device", !fingers.is_empty()),
    ];
    let rooms = mounted.iter().filter(|(.., is_there)| *is_there);
    let rooms: Vec<Value> =
        rooms.map(|(name, title, _)| json!({ "name": name, "title": title })).collect();
    // Who names a folder came for the Lab.
    let first = if lab {
        json!("lab")
    } else {
        rooms.first().map_or(Value::Null, |room| room["name"].clone())
    };
    let fingers: Vec<&Value> = fingers.iter().map(|finger| &finger.about).collect();
    json!({ "version": env!("CARGO_PKG_VERSION"), "rooms": rooms, "first": first, "fingers": fingers })
}

/// The ports of all other fingers.
fn beside(fingers: &[Arc<Live>], own: usize) -> Arc<[PathBuf]> {
    let others = fingers.iter().enumerate().filter(|(index, _)| *index != own);
    others.map(|(_, finger)| finger.port.clone()).collect()
}
