//! The Lab over HTTP: each route is one function of the [`Session`].

use std::sync::{Arc, Mutex, PoisonError};

use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use serde_json::{Value, json};

use super::choices::choices;
use super::drawing::View;
use super::dropped::Import;
use super::error::LabError;
use super::own_law::OwnLaw;
use super::session::Session;
use super::task::Task;
use crate::guard::UPLOAD_LIMIT;

type Shared = Arc<Mutex<Session>>;

/// The routes of the Lab over one session, to be nested where the page expects them.
pub fn routes<S: Clone + Send + Sync + 'static>(session: Session) -> Router<S> {
    Router::new()
        .route("/choices", get(async || Json(choices())))
        .route("/state", get(state))
        .route("/progress", get(progress))
        .route("/overlay", get(overlay))
        .route("/closer", get(closer))
        .route("/forecast", get(forecast))
        .route("/report", get(report))
        .route("/relaxation", get(relaxation))
        .route("/command", post(command))
        .route("/start", post(start))
        .route("/cancel", post(cancel))
        .route("/choose", post(choose))
        .route("/law", post(law))
        .route("/check", post(check))
        .route("/undo", post(undo))
        .route("/save", post(save))
        .route("/alone", post(alone))
        .route("/reveal", post(reveal))
        .route("/drop", post(drop_file).layer(DefaultBodyLimit::max(UPLOAD_LIMIT)))
        .route("/import", post(import))
        .with_state(Arc::new(Mutex::new(session)))
}

/// An error in words, 422.
struct Refused(LabError);

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let message = json!({"message": self.0.to_string()});
        (StatusCode::UNPROCESSABLE_ENTITY, Json(message)).into_response()
    }
}

type Answer = Result<Json<Value>, Refused>;

/// Does something with the session, off the threads that serve.
async fn with(
    session: Shared,
    act: impl FnOnce(&mut Session) -> Result<Value, LabError> + Send + 'static,
) -> Answer {
    let locked = move || act(&mut session.lock().unwrap_or_else(PoisonError::into_inner));
    let answer = tokio::task::spawn_blocking(locked).await;
    answer.unwrap_or(Err(LabError::BrokeOff)).map(Json).map_err(Refused)
}

async fn state(State(session): State<Shared>) -> Answer {
    with(session, |session| Ok(session.state())).await
}

async fn progress(State(session): State<Shared>) -> Answer {
    with(session, |session| Ok(session.progress())).await
}

async fn overlay(State(session): State<Shared>, Query(view): Query<View>) -> Answer {
    with(session, move |session| session.overlay(&view)).await
}

#[derive(Deserialize)]
struct Which {
    trace: usize,
}

async fn closer(State(session): State<Shared>, Query(which): Query<Which>) -> Answer {
    with(session, move |session| session.closer(which.trace)).await
}

#[derive(Deserialize)]
struct Named {
    effect: String,
}

async fn forecast(
    State(session): State<Shared>,
    Query(named): Query<Named>,
    Query(view): Query<View>,
) -> Answer {
    with(session, move |session| session.forecast(&named.effect, &view)).await
}

#[derive(Deserialize)]
struct Kind {
    kind: String,
}

async fn report(State(session): State<Shared>, Query(of): Query<Kind>) -> Answer {
    with(session, move |session| session.report(&of.kind)).await
}

async fn relaxation(State(session): State<Shared>) -> Answer {
    with(session, Session::relaxation).await
}

async fn command(State(session): State<Shared>, Json(task): Json<Task>) -> Answer {
    with(session, move |session| Ok(json!({"command": session.command(&task)?}))).await
}

async fn start(State(session): State<Shared>, Json(task): Json<Task>) -> Answer {
    with(session, move |session| {
        session.start(task)?;
        Ok(session.progress())
    })
    .await
}

async fn cancel(State(session): State<Shared>) -> Answer {
    with(session, |session| {
        session.cancel();
        Ok(session.progress())
    })
    .await
}

/// What to choose; what is not named stays.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Choose {
    set: Option<String>,
    traces: Option<Vec<usize>>,
    signal: Option<String>,
    model: Option<String>,
}

async fn choose(State(session): State<Shared>, Json(wanted): Json<Choose>) -> Answer {
    with(session, move |session| {
        if let Some(set) = &wanted.set {
            session.choose_set(set)?;
        }
        if let Some(signal) = &wanted.signal {
            session.choose_signal(signal)?;
        }
        if let Some(traces) = &wanted.traces {
            session.choose_traces(traces)?;
        }
        if let Some(model) = &wanted.model {
            session.open_model(model)?;
        }
        Ok(session.state())
    })
    .await
}

async fn law(State(session): State<Shared>, Json(law): Json<OwnLaw>) -> Answer {
    with(session, move |session| {
        session.add_candidate(&law)?;
        Ok(session.state())
    })
    .await
}

/// What is wrong with a law, and the lines that put it into a model file.
async fn check(Json(law): Json<OwnLaw>) -> Json<Value> {
    Json(json!({"fault": law.fault(), "toml": law.toml()}))
}

async fn undo(State(session): State<Shared>) -> Answer {
    with(session, |session| {
        session.undo()?;
        Ok(session.state())
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Save {
    file: Option<String>,
}

async fn save(State(session): State<Shared>, Json(wanted): Json<Save>) -> Answer {
    with(session, move |session| session.save(wanted.file.as_deref())).await
}

async fn alone(State(session): State<Shared>) -> Answer {
    with(session, |session| {
        session.alone();
        Ok(session.state())
    })
    .await
}

/// What a file is called, and the folder of those that were dropped with it; empty for the first.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DroppedFile {
    name: String,
    #[serde(default)]
    into: String,
}

async fn drop_file(
    State(session): State<Shared>,
    Query(file): Query<DroppedFile>,
    bytes: Bytes,
) -> Answer {
    with(session, move |session| session.drop_file(&file.name, &file.into, &bytes)).await
}

async fn import(State(session): State<Shared>, Json(import): Json<Import>) -> Answer {
    with(session, move |session| session.import(&import)).await
}

async fn reveal(State(session): State<Shared>) -> Answer {
    with(session, |session| session.reveal()).await
}
