//! Who may ask, and what the page may do.
//!
//! Other pages in the same browser reach this server too. So every request is checked:
//!
//! - The host it names is this computer by number or `localhost`, at our port. A name that was made to point here (DNS
//!   rebinding) is refused.
//! - An origin, which a browser adds to cross-site requests and to every websocket, is our own.
//! - Everything under `/api/` carries the token that is printed at the start: in the header [`TOKEN_HEADER`], or as a
//!   protocol of a websocket, which cannot have headers.
//!
//! Every answer tells the browser to run and show nothing but what this server gives.

use std::fmt::Write as _;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::body::{Body, to_bytes};
use axum::extract::{Request, State};
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::http::uri::Authority;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use tokio::sync::Semaphore;

use super::Problem;
use super::connections::BODY_TIME;

/// Header of a request that carries the token.
pub const TOKEN_HEADER: &str = "x-palpate-token";
/// Protocol of the websockets.
pub const PROTOCOL: &str = "palpate";
/// A websocket offers this and the token as a second protocol.
const TOKEN_PROTOCOL: &str = "token.";
/// Most bytes of a request's body.
pub const BODY_LIMIT: usize = 256 * 1024;
/// Most bytes of a file that is dropped on the page, the one body that may be larger.
pub const UPLOAD_LIMIT: usize = 64 * 1024 * 1024;
/// Where it goes.
const UPLOAD: &str = "/api/lab/drop";
/// Files that are taken at the same time; others wait.
const UPLOADS: usize = 2;
/// Most bytes of a message from a page over a websocket.
pub const MESSAGE_LIMIT: usize = 4 * 1024;
/// Random bytes of the token.
const TOKEN_BYTES: usize = 16;

/// What a browser is told with every answer.
const RESPONSE_HEADERS: [(HeaderName, &str); 6] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
];

/// The system gives no random numbers.
#[derive(Debug, thiserror::Error)]
#[error("the system gives no random numbers for a token: {0}")]
pub struct TokenError(String);

/// What requests are checked against.
pub struct Guard {
    at: SocketAddr,
    token: String,
    uploads: Semaphore,
}

impl Guard {
    /// With a new token, for a server that listens there.
    ///
    /// # Errors
    /// [`TokenError`].
    pub fn new(at: SocketAddr) -> Result<Self, TokenError> {
        let mut random = [0; TOKEN_BYTES];
        getrandom::fill(&mut random).map_err(|error| TokenError(error.to_string()))?;
        let token = random.iter().fold(String::new(), |mut token, byte| {
            let _ = write!(token, "{byte:02x}");
            token
        });
        Ok(Self { at, token, uploads: Semaphore::new(UPLOADS) })
    }

    /// The address to open. The token stands behind `#`, which browsers do not send and do not log.
    #[must_use]
    pub fn url(&self) -> String {
        let mut at = self.at;
        if at.ip().is_unspecified() {
            at.set_ip(if at.is_ipv4() {
                [127, 0, 0, 1].into()
            } else {
                [0, 0, 0, 0, 0, 0, 0, 1].into()
            });
        }
        format!("http://{at}/#token={}", self.token)
    }

    fn check(&self, path: &str, headers: &HeaderMap) -> Result<(), Problem> {
        let host = one(headers, header::HOST)
            .filter(|host| self.is_here(host))
            .ok_or_else(|| Problem::forbidden("this is not the host of this page"))?;
        if headers.contains_key(header::ORIGIN) {
            let ours =
                one(headers, header::ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
            if ours != Some(host) {
                return Err(Problem::forbidden("another site may not ask"));
            }
        }
        let is_data = path == "/api" || path.starts_with("/api/");
        if is_data && !token(headers).is_some_and(|token| self.is_token(token)) {
            return Err(Problem::forbidden(
                "the token is missing or of another start; open the address that `palpate serve` printed",
            ));
        }
        Ok(())
    }

    /// Whether a host is this computer by number or `localhost`, at our port.
    fn is_here(&self, host: &str) -> bool {
        let Ok(authority) = host.parse::<Authority>() else { return false };
        if authority.as_str().contains('@') {
            return false;
        }
        let name = authority.host().trim_start_matches('[').trim_end_matches(']');
        let here = match name.parse::<IpAddr>() {
            Ok(ip) => ip.is_loopback() || !self.at.ip().is_loopback(),
            Err(_) => name.eq_ignore_ascii_case("localhost"),
        };
        here && authority.port_u16().unwrap_or(80) == self.at.port()
    }

    /// In a time that does not tell how much of it was right.
    fn is_token(&self, token: &str) -> bool {
        let differing = self.token.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        token.len() == self.token.len() && differing == 0
    }
}

/// The value of a header that is there once.
fn one(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut all = headers.get_all(name).iter();
    let first = all.next()?.to_str().ok()?;
    all.next().is_none().then_some(first)
}

/// The token of a request: its header, or a protocol of a websocket.
fn token(headers: &HeaderMap) -> Option<&str> {
    one(headers, HeaderName::from_static(TOKEN_HEADER)).or_else(|| {
        let offered = one(headers, header::SEC_WEBSOCKET_PROTOCOL)?;
        offered.split(',').find_map(|offer| offer.trim().strip_prefix(TOKEN_PROTOCOL))
    })
}

/// Checks a request, and tells the browser what the answer may do.
pub async fn guard(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    let mut response = match guard.check(request.uri().path(), request.headers()) {
        Ok(()) => guard.pass(request, next).await,
        Err(problem) => problem.into_response(),
    };
    for (name, value) in RESPONSE_HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

impl Guard {
    /// Lets a request in once all of it is there; few large ones at a time.
    async fn pass(&self, request: Request, next: Next) -> Response {
        let is_upload = request.uri().path() == UPLOAD;
        // It is closed never.
        let _place = if is_upload { self.uploads.acquire().await.ok() } else { None };
        match whole(request, if is_upload { UPLOAD_LIMIT } else { BODY_LIMIT }).await {
            Ok(request) => next.run(request).await,
            Err(problem) => problem.into_response(),
        }
    }
}

/// The request with its body, once all of it is there.
async fn whole(request: Request, limit: usize) -> Result<Request, Problem> {
    let (head, body) = request.into_parts();
    match tokio::time::timeout(BODY_TIME, to_bytes(body, limit)).await {
        Ok(Ok(bytes)) => Ok(Request::from_parts(head, Body::from(bytes))),
        Ok(Err(_)) => Err(Problem::too_large(format!("a body has at most {limit} bytes"))),
        Err(_) => Err(Problem::too_slow("the body of the request did not come in time")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard_at(at: &str) -> Guard {
        Guard { at: at.parse().unwrap(), token: "abc".into(), uploads: Semaphore::new(UPLOADS) }
    }

    #[test]
    fn only_this_computer_by_number_or_as_localhost_is_here() {
        let guard = guard_at("127.0.0.1:8000");
        for host in ["127.0.0.1:8000", "localhost:8000", "LOCALHOST:8000", "[::1]:8000"] {
            assert!(guard.is_here(host), "{host}");
        }
        for host in [
            "127.0.0.1",
            "127.0.0.1:8001",
            "evil.example:8000",
            "10.0.0.1:8000",
            "",
            "a b",
            "evil@localhost:8000",
        ] {
            assert!(!guard.is_here(host), "{host}");
        }
        let open = guard_at("0.0.0.0:8000");
        assert!(open.is_here("10.0.0.1:8000") && !open.is_here("evil.example:8000"));
    }

    #[test]
    fn a_token_is_right_only_as_a_whole() {
        let guard = guard_at("127.0.0.1:8000");
        assert!(guard.is_token("abc"));
        assert!(!["", "a", "ab", "abd", "abcd"].iter().any(|token| guard.is_token(token)));
    }

    #[test]
    fn two_tokens_are_not_the_same() {
        let token = || Guard::new("127.0.0.1:1".parse().unwrap()).unwrap().token;
        let (a, b) = (token(), token());
        assert_eq!(a.len(), 2 * TOKEN_BYTES);
        assert_ne!(a, b);
    }

    #[test]
    fn the_address_to_open_is_one_that_can_be_opened() {
        assert_eq!(guard_at("127.0.0.1:80").url(), "http://127.0.0.1:80/#token=abc");
        assert_eq!(guard_at("0.0.0.0:81").url(), "http://127.0.0.1:81/#token=abc");
        assert_eq!(guard_at("[::]:82").url(), "http://[::1]:82/#token=abc");
    }
}
