//! `palpate serve` as a process, and questions to it byte by byte. What cannot be done fails the test.
#![allow(clippy::missing_panics_doc, clippy::must_use_candidate)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use palpate::serve::guard::TOKEN_HEADER;
use serde_json::Value;
use tungstenite::client::client;
use tungstenite::{ClientRequestBuilder, WebSocket};

use crate::palpate;

/// How long an answer may take.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// `palpate serve` as a process.
pub struct Server {
    /// The process.
    pub process: Child,
    /// Where it runs.
    pub folder: tempfile::TempDir,
    /// Its port.
    pub port: u16,
    /// Its token.
    pub token: String,
}

/// The command, without what the tests' own surroundings set.
pub fn program() -> Command {
    let mut command = Command::new(palpate().get_program());
    command.env("NO_COLOR", "1").env_remove("PALPATE_LOG");
    command
}

impl Server {
    /// Begins in a folder of its own.
    pub fn begin(arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self::begin_in(folder, arguments)
    }

    /// Begins in this folder.
    pub fn begin_in(folder: tempfile::TempDir, arguments: &[&str]) -> Self {
        let mut process = program()
            .arg("serve")
            .args(arguments)
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut url).unwrap();
        let Some((at, token)) = url.trim().split_once("/#token=") else {
            let mut said = String::new();
            process.stderr.take().unwrap().read_to_string(&mut said).unwrap();
            panic!("instead of its address the server says {url:?}, and {said:?}");
        };
        let port = at.rsplit_once(':').unwrap().1.parse().unwrap();
        Self { process, folder, port, token: token.into() }
    }

    /// With a simulated device.
    pub fn simulated() -> Self {
        Self::begin(&["--simulate"])
    }

    /// The host as a browser names it.
    pub fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// What a request of the page itself carries.
    pub fn headers(&self) -> Vec<(String, String)> {
        vec![("host".into(), self.host()), (TOKEN_HEADER.into(), self.token.clone())]
    }

    /// The answer to a request with exactly these headers.
    pub fn ask(
        &self,
        method: &str,
        path: &str,
        headers: &[(String, String)],
        body: &[u8],
    ) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut head = format!("{method} {path} HTTP/1.1\r\nconnection: close\r\n");
        for (name, value) in headers {
            head += &format!("{name}: {value}\r\n");
        }
        if !body.is_empty() {
            head +=
                &format!("content-type: application/json\r\ncontent-length: {}\r\n", body.len());
        }
        stream.write_all(format!("{head}\r\n").as_bytes()).unwrap();
        // A server that refuses may close before it has read everything.
        let _ = stream.write_all(body);
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        Answer::read(&bytes)
    }

    /// Asks as the page does.
    pub fn get(&self, path: &str) -> Answer {
        self.ask("GET", path, &self.headers(), &[])
    }

    /// The JSON of an answer that is there.
    pub fn json(&self, path: &str) -> Value {
        let answer = self.get(path);
        assert_eq!(answer.status, 200, "{path}");
        serde_json::from_slice(&answer.body).unwrap()
    }

    /// Status and answer of a wish to the first device.
    pub fn wish(&self, wish: &Value) -> (u16, Value) {
        self.wish_at("/api/live/wish", wish)
    }

    /// Those of a wish to a finger of a hand, from 1.
    pub fn wish_of(&self, finger: usize, wish: &Value) -> (u16, Value) {
        self.wish_at(&format!("/api/fingers/{finger}/live/wish"), wish)
    }

    fn wish_at(&self, path: &str, wish: &Value) -> (u16, Value) {
        let body = wish.to_string();
        let answer = self.ask("POST", path, &self.headers(), body.as_bytes());
        (answer.status, serde_json::from_slice(&answer.body).unwrap_or_default())
    }

    /// A websocket, asked for with these headers and protocols.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn socket_with(
        &self,
        path: &str,
        headers: &[(&str, &str)],
        protocols: &[&str],
    ) -> Result<WebSocket<TcpStream>, String> {
        let uri = format!("ws://{}{path}", self.host()).parse().unwrap();
        let mut request = ClientRequestBuilder::new(uri);
        for (name, value) in headers {
            request = request.with_header(*name, *value);
        }
        for protocol in protocols {
            request = request.with_sub_protocol(*protocol);
        }
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        client(request, stream).map(|(socket, _)| socket).map_err(|error| error.to_string())
    }

    /// The address that it printed.
    pub fn url(&self) -> String {
        format!("http://{}/#token={}", self.host(), self.token)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // One that has ended on its own is as good.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The answer to a request.
pub struct Answer {
    /// Status.
    pub status: u16,
    head: String,
    /// Content.
    pub body: Vec<u8>,
}

impl Answer {
    fn read(bytes: &[u8]) -> Self {
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").expect("there is a head");
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap().to_lowercase();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Self { status, head, body: bytes[end + 4..].to_vec() }
    }

    /// The value of a header; empty where it is not there.
    pub fn header(&self, name: &str) -> &str {
        let line = self.head.lines().find_map(|line| line.strip_prefix(&format!("{name}: ")));
        line.unwrap_or_default()
    }

    /// So many numbers of the content from a byte on.
    pub fn numbers(&self, from: usize, count: usize) -> Vec<f64> {
        let bytes = &self.body[from..from + 8 * count];
        bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }
}

/// `palpate device simulate` as a process, at the path `fingertip` of a folder, where it keeps its settings.
pub fn simulate(folder: &Path) -> Child {
    let mut process = program()
        .args(["device", "simulate", "--link", "fingertip", "--settings", "settings.bin"])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // It says its path when it is there.
    let mut path = String::new();
    BufReader::new(process.stdout.take().unwrap()).read_line(&mut path).unwrap();
    assert_eq!(path.trim(), "fingertip");
    process
}

/// What the server holds in memory, MB: `VmRSS` now, `VmHWM` at most.
#[cfg(target_os = "linux")]
pub fn memory_mb(server: &Server, kind: &str) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.process.id())).unwrap();
    let line = status.lines().find(|line| line.starts_with(kind)).expect("it runs");
    line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1024.0
}
