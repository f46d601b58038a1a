//! The room of a fingertip: what it feels while it feels it.
//!
//! ```text
//! device, simulated device or trace ── feed ── store ──┬── push: rows and health to each page
//!                                      └─ wishes ──────┴── views of the whole session
//! ```
//!
//! - `GET /api/live/about`: where it comes from.
//! - `GET /api/live/stream`: a websocket, see the module `push`.
//! - `GET /api/live/view?from=S&to=S&bins=N`: the session from one time to another; f64 n and f64 signals, then of n bins the
//!   time of the first row, that of the last, and how long nothing was known before (s, f64), then of each signal n first
//!   values, n extremes that came first, n others and n last values (µε, f32), little-endian.
//! - `GET /api/live/events?from=S&to=S`: what happened then.
//! - `GET /api/live/foretold?from=S&to=S`: the presses that were held then, and what a model foretold of them.
//! - `POST /api/live/wish`: a [`Wish`].

pub mod bench;
mod care;
mod counts;
mod feed;
pub mod foretold;
pub mod grasp;
mod hand;
pub mod log;
mod push;
pub mod pyramid;
mod recorder;
mod replay;
pub mod store;
pub mod wish;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Instant;

use axum::extract::{Query, State, WebSocketUpgrade};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::sync::{Semaphore, oneshot};

use self::counts::Counts;
use self::feed::Feed;
pub(super) use self::feed::lock;
use self::foretold::Foretelling;
pub use self::foretold::Given;
use self::grasp::Grasp;
pub use self::hand::Hand;
pub use self::log::Elf;
use self::log::Log;
use self::pyramid::{Bin, Course, SIGNALS};
use self::replay::Replay;
use self::store::{Event, Store};
use self::wish::{Request, Wish};
use super::Problem;
use super::guard::{MESSAGE_LIMIT, PROTOCOL};
use palpate_link::device::session::Session;
#[cfg(unix)]
use palpate_link::device::simulate::{Simulated, Simulation, SimulationError};
use palpate_link::device::stream::Stream;
use palpate_link::robots::Listener;
use palpate_trace::Trace;
use palpate_trace::recordable::{RecordableError, Samples, samples};

/// Pages that are sent rows at once.
pub const MAX_PAGES: usize = 32;
/// Most bins of a view.
const BINS: usize = 5_000;

/// Where the rows come from.
pub enum Source {
    /// A device on a port.
    Device {
        /// The port.
        port: PathBuf,
        /// The conversation; none if the device could not be talked with yet.
        session: Option<Box<Session>>,
    },
    /// A simulated device.
    #[cfg(unix)]
    Simulated {
        /// Seed of its noise.
        seed: u64,
        /// Which finger of a simulated hand it is, from 0.
        finger: u8,
    },
    /// A trace, put into a simulated device.
    #[cfg(unix)]
    Replay {
        /// The trace.
        trace: Box<Trace>,
        /// Times as fast as it was recorded.
        speed: f64,
    },
}

/// Why there is nothing to show.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum LiveError {
    #[error(transparent)]
    Recordable(#[from] RecordableError),
    #[cfg(unix)]
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    #[error("the simulated device does not answer: {0}")]
    Link(#[from] palpate_link::device::session::LinkError),
}

/// A session with a fingertip. Its end is that of the session.
pub struct Live {
    pub(super) store: Arc<Mutex<Store>>,
    pub(super) port: PathBuf,
    requests: Sender<Request>,
    pub(super) about: Value,
    pages: Arc<Semaphore>,
    ended: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Live {
    /// Begins to listen; recordings go to `folder`, the words of the device's log are in `elf`, and `given` foretells in place
    /// of the filter of the device; `listener` hears all that is shown. It becomes the next finger of `hand`.
    ///
    /// # Errors
    /// [`LiveError`].
    pub fn begin(
        source: Source,
        folder: PathBuf,
        elf: Option<Elf>,
        given: Option<Given>,
        listener: Option<Box<dyn Listener>>,
        hand: &Hand,
    ) -> Result<Self, LiveError> {
        let ended = Arc::new(AtomicBool::new(false));
        let mut threads = Vec::new();
        let (mut about, port, session, replay) = match source {
            Source::Device { port, session } => {
                let about = json!({ "source": "device" });
                (about, port, session.map(|session| *session), None)
            }
            #[cfg(unix)]
            Source::Simulated { seed, finger } => {
                let (port, session) = simulate(seed, finger, &ended, &mut threads)?;
                (json!({ "source": "simulated", "seed": seed }), port, Some(session), None)
            }
            #[cfg(unix)]
            Source::Replay { trace, speed } => {
                let samples: Samples = samples(&trace)?;
                let (port, session) = simulate(0, 0, &ended, &mut threads)?;
                let about = json!({ "source": "replay", "trace": trace.label(), "speed": speed });
                (about, port, Some(session), Some(Replay::new(samples, speed)))
            }
        };
        about["port"] = json!(port);
        let store = Arc::new(Mutex::new(Store::new()));
        let (requests, received) = channel();
        let feed = Feed {
            port: port.clone(),
            folder,
            hand: (hand.clone(), hand.enter(&port)),
            store: Arc::clone(&store),
            requests: received,
            ended: Arc::clone(&ended),
            replay,
            stream: Stream::default(),
            recorder: None,
            counts: Counts::new(),
            grasp: Grasp::default(),
            foretelling: Foretelling::new(given),
            log: Log::new(elf),
            listener,
            wanted: true,
            heard_at: Instant::now(),
        };
        // The device's end goes last, so that the stream is ended in order.
        threads.insert(0, std::thread::spawn(move || feed.run(session)));
        let pages = Arc::new(Semaphore::new(MAX_PAGES));
        Ok(Self { store, port, requests, about, pages, ended, threads })
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A thread that panicked has said so.
            let _ = thread.join();
        }
    }
}

/// A simulated device on a thread of its own, and a conversation with it.
#[cfg(unix)]
fn simulate(
    seed: u64,
    finger: u8,
    ended: &Arc<AtomicBool>,
    threads: &mut Vec<JoinHandle<()>>,
) -> Result<(PathBuf, Session), LiveError> {
    const PATIENCE: std::time::Duration = std::time::Duration::from_secs(2);
    let mut simulated = Simulated::new(&Simulation { seed, finger, ..Simulation::default() })?;
    let port = simulated.path().to_owned();
    let over = Arc::clone(ended);
    threads.push(std::thread::spawn(move || {
        if let Err(error) = simulated.run(|| over.load(Ordering::Relaxed)) {
            tracing::error!("the simulated device ended: {error}");
        }
    }));
    let session = Session::open(&port, PATIENCE);
    if session.is_err() {
        ended.store(true, Ordering::Relaxed);
    }
    Ok((port, session?))
}

/// What the page asks of the room.
pub fn routes(live: Arc<Live>) -> Router {
    Router::new()
        .route("/about", get(about))
        .route("/stream", get(stream))
        .route("/view", get(view))
        .route("/events", get(events))
        .route("/foretold", get(foretold))
        .route("/wish", post(wish))
        .with_state(live)
}

async fn about(State(live): State<Arc<Live>>) -> Json<Value> {
    Json(live.about.clone())
}

async fn stream(State(live): State<Arc<Live>>, upgrade: WebSocketUpgrade) -> Response {
    let store = Arc::clone(&live.store);
    let Ok(place) = Arc::clone(&live.pages).try_acquire_owned() else {
        let problem = format!("{MAX_PAGES} pages show this fingertip already: close one");
        return Problem::too_many(problem).into_response();
    };
    upgrade
        .protocols([PROTOCOL])
        .max_message_size(MESSAGE_LIMIT)
        .max_frame_size(MESSAGE_LIMIT)
        .on_upgrade(async |socket| {
            push::push(socket, store).await;
            drop(place);
        })
}

/// A stretch of the session.
#[derive(Deserialize)]
struct Stretch {
    /// From here, s.
    from: f64,
    /// To here, s.
    to: f64,
    /// In so many bins at most.
    #[serde(default)]
    bins: usize,
}

async fn view(State(live): State<Arc<Live>>, Query(stretch): Query<Stretch>) -> Vec<u8> {
    let most = stretch.bins.clamp(1, BINS);
    packed(&lock(&live.store).pyramid.view(stretch.from, stretch.to, most))
}

fn packed(bins: &[Bin]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(16 + bins.len() * (24 + 16 * SIGNALS));
    bytes.extend((bins.len() as f64).to_le_bytes());
    bytes.extend((SIGNALS as f64).to_le_bytes());
    for time in [|bin: &Bin| bin.from_s, |bin: &Bin| bin.to_s, |bin: &Bin| bin.gap_s] {
        bins.iter().for_each(|bin| bytes.extend(time(bin).to_le_bytes()));
    }
    let values = [
        |course: &Course| course.first,
        |course: &Course| course.early,
        |course: &Course| course.late,
        |course: &Course| course.last,
    ];
    for signal in 0..SIGNALS {
        for value in values {
            bins.iter().for_each(|bin| bytes.extend(value(&bin.signals[signal]).to_le_bytes()));
        }
    }
    bytes
}

async fn events(State(live): State<Arc<Live>>, Query(stretch): Query<Stretch>) -> Json<Value> {
    let store = lock(&live.store);
    let events = store.events_of(stretch.from, stretch.to);
    Json(events.into_iter().map(Event::json).collect())
}

async fn foretold(State(live): State<Arc<Live>>, Query(stretch): Query<Stretch>) -> Json<Value> {
    Json(json!(lock(&live.store).bench.foretold.holds_of(stretch.from, stretch.to)))
}

async fn wish(
    State(live): State<Arc<Live>>,
    Json(wish): Json<Wish>,
) -> Result<Json<Value>, Problem> {
    let (answer, answered) = oneshot::channel();
    let sent = live.requests.send(Request { wish, answer });
    let outcome = match sent {
        Ok(()) => answered.await.unwrap_or_else(|_| feed::ended()),
        Err(_) => feed::ended(),
    };
    outcome.map(Json).map_err(Problem::conflict)
}
