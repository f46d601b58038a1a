//! The local page under load: connections that say nothing, bodies that never end, pages without number.
#![cfg(unix)]

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;

use palpate::serve::connections::MAX_CONNECTIONS;
use palpate::serve::guard::PROTOCOL;
use palpate::serve::live::MAX_PAGES;
use palpate_tests::bundled;
use palpate_tests::server::{PATIENCE, Server};

/// The page over a folder with one trace.
fn server() -> Server {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(bundled("press.csv"), folder.path().join("press.csv")).unwrap();
    Server::begin_in(folder, &["."])
}

fn connect(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    stream
}

/// Head of a request with a body of so many bytes.
fn head(server: &Server, bytes: u64) -> String {
    let mut head =
        String::from("POST /api/lab/check HTTP/1.1\r\ncontent-type: application/json\r\n");
    for (name, value) in server.headers() {
        head += &format!("{name}: {value}\r\n");
    }
    head + &format!("content-length: {bytes}\r\n\r\n")
}

/// What a connection says until it is closed; fails where it stays open.
fn until_closed(stream: &mut TcpStream) -> String {
    let mut said = Vec::new();
    match stream.read_to_end(&mut said) {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::ConnectionReset => {}
        Err(error) => panic!("the connection stays open: {error}"),
    }
    String::from_utf8_lossy(&said).into_owned()
}

#[test]
fn who_says_nothing_or_half_of_it_is_shown_out() {
    let server = server();
    let mut silent: Vec<TcpStream> = (0..8).map(|_| connect(&server)).collect();
    let mut half_head = connect(&server);
    half_head.write_all(b"GET / HTTP/1.1\r\nhost: loc").unwrap();
    let mut half_body = connect(&server);
    half_body.write_all(format!("{}{{", head(&server, 1000)).as_bytes()).unwrap();
    // One that was answered, and asks no more.
    let mut idle = connect(&server);
    idle.write_all(format!("GET / HTTP/1.1\r\nhost: {}\r\n\r\n", server.host()).as_bytes())
        .unwrap();
    assert!(until_closed(&mut idle).starts_with("HTTP/1.1 200"));
    assert!(until_closed(&mut half_body).starts_with("HTTP/1.1 408"));
    until_closed(&mut half_head);
    silent.iter_mut().for_each(|stream| assert_eq!(until_closed(stream), ""));
    assert_eq!(server.get("/api/rooms").status, 200);
}

#[test]
fn more_connections_than_there_are_places_wait_for_one() {
    let server = server();
    let held: Vec<TcpStream> = (0..MAX_CONNECTIONS).map(|_| connect(&server)).collect();
    // This one is answered once the silent ones were shown out.
    assert_eq!(server.get("/api/rooms").status, 200);
    drop(held);
}

#[test]
fn a_body_of_a_gigabyte_is_refused_and_not_kept() {
    let server = server();
    let mut stream = connect(&server);
    stream.write_all(head(&server, 1 << 30).as_bytes()).unwrap();
    let piece = vec![b' '; 1 << 20];
    let sent = (0..1024).take_while(|_| stream.write_all(&piece).is_ok()).count();
    assert!(sent < 1024, "all of it was taken");
    assert_eq!(server.get("/api/rooms").status, 200);
    #[cfg(target_os = "linux")]
    assert!(palpate_tests::server::memory_mb(&server, "VmHWM") < 200.0);
}

#[test]
fn one_page_too_many_is_told_so_and_a_place_is_free_again_when_one_closes() {
    let server = Server::simulated();
    let token = format!("token.{}", server.token);
    let open = || server.socket_with("/api/live/stream", &[], &[PROTOCOL, &token]);
    let mut pages: Vec<_> = (0..MAX_PAGES).map(|_| open().unwrap()).collect();
    let refused = open().map(drop).unwrap_err();
    assert!(refused.contains("503"), "{refused}");
    pages.clear();
    let begun = std::time::Instant::now();
    while open().is_err() {
        assert!(begun.elapsed() < PATIENCE, "no place becomes free");
    }
}
