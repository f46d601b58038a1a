//! The Lab over HTTP: what the page asks for, what it is refused, and the same answers as the commands.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use palpate::serve::guard::{BODY_LIMIT, TOKEN_HEADER};
use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::palpate;
use serde_json::{Value, json};

const PATIENCE: Duration = Duration::from_secs(300);

fn program() -> Command {
    let mut command = Command::new(palpate().get_program());
    command.env("NO_COLOR", "1").env_remove("PALPATE_LOG");
    command
}

/// `palpate serve FOLDER` as a process, in the folder above.
struct Lab {
    process: Child,
    above: tempfile::TempDir,
    port: u16,
    token: String,
}

impl Lab {
    fn open(above: tempfile::TempDir, arguments: &[&str]) -> Self {
        let mut process = program()
            .arg("serve")
            .args(arguments)
            .current_dir(above.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut url).unwrap();
        let (at, token) = url.trim().split_once("/#token=").expect("the address is printed");
        let port = at.rsplit_once(':').unwrap().1.parse().unwrap();
        Self { process, above, port, token: token.into() }
    }

    /// Status and body of the answer to a request.
    fn ask(&self, method: &str, path: &str, body: Option<&[u8]>) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut head = format!(
            "{method} /api/lab/{path} HTTP/1.1\r\nconnection: close\r\nhost: 127.0.0.1:{}\r\n{TOKEN_HEADER}: {}\r\n",
            self.port, self.token
        );
        if let Some(body) = body {
            let length = body.len();
            head += &format!("content-type: application/json\r\ncontent-length: {length}\r\n");
        }
        stream.write_all(format!("{head}\r\n").as_bytes()).unwrap();
        // A server that refuses may close before it has read everything.
        let _ = stream.write_all(body.unwrap_or_default());
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").expect("there is a head");
        let head = String::from_utf8_lossy(&bytes[..end]);
        (head.split(' ').nth(1).unwrap().parse().unwrap(), bytes[end + 4..].to_vec())
    }

    fn get(&self, path: &str) -> Value {
        let (status, body) = self.ask("GET", path, None);
        let answer: Value = serde_json::from_slice(&body).unwrap();
        assert_eq!(status, 200, "{path}: {answer}");
        answer
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        // One that has ended on its own is as good.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Presses of a viscoelastic specimen, one every ten seconds at 1 kHz.
fn long_trace(samples: usize) -> Trace {
    let mut trace =
        Trace { time: (0..samples).map(|k| k as f64 / 1e3).collect(), ..Trace::default() };
    let depth = |time: f64| -> f64 {
        let within = time % 10.0;
        let up = within.min(10.0 - within) - 1.0;
        up.clamp(-0.5, 2.0)
    };
    let mut state = 1_u64;
    let mut noise = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24) - 0.5
    };
    let displacement: Vec<f64> = trace.time.iter().map(|&time| depth(time)).collect();
    let force = displacement.iter().map(|x| x.max(0.0).powf(1.5) + 0.01 * noise()).collect();
    trace.set_column(DISPLACEMENT, displacement);
    trace.set_column(FORCE, force);
    trace
}

/// Times of opening and of panning, for docs/measured.md.
#[test]
#[ignore = "ten million samples: run it with --release"]
fn ten_million_samples_open_and_pan() {
    let trace = long_trace(10_000_000);
    for format in ["parquet", "csv"] {
        let above = tempfile::tempdir().unwrap();
        std::fs::create_dir(above.path().join("traces")).unwrap();
        let file = above.path().join(format!("traces/long.{format}"));
        write(&file, &trace).unwrap();
        let bytes = std::fs::metadata(&file).unwrap().len();
        let begun = Instant::now();
        let lab = Lab::open(above, &["traces"]);
        let printed = begun.elapsed();
        lab.get("state");
        lab.get("overlay?trace=0&width=1200");
        let opened = begun.elapsed();
        let mut pans: Vec<Duration> = (0..200)
            .map(|k| {
                let (from, to) = (f64::from(k) * 40.0, f64::from(k) * 40.0 + 2_000.0);
                let begun = Instant::now();
                lab.get(&format!("overlay?trace=0&width=1200&from={from}&to={to}"));
                begun.elapsed()
            })
            .collect();
        pans.sort();
        println!(
            "{format}: {:.0} MB, address after {printed:.2?}, drawn after {opened:.2?}, pan median {:.1?}, worst {:.1?}, {} MB",
            bytes as f64 / 1e6,
            pans[100],
            pans[199],
            memory_mb(&lab.process),
        );
    }
}

/// Resident memory, MB.
fn memory_mb(process: &Child) -> u64 {
    let status =
        std::fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok()).unwrap_or(0)
        / 1024
}
