//! The local page as its user sees and handles it, in a real browser: `cargo xtask browser`.
#![cfg(unix)]

mod axe;
mod device;
mod hand;
mod lab;
mod live;
mod pictures;
mod plots;
mod reports;
mod rooms;

use palpate_tests::browser::Browser;
use palpate_tests::server::Server;

/// A window as on a desk.
const WIDTH: u32 = 1280;
const HEIGHT: u32 = 900;

/// The page, once it knows its rooms: before, it does not hear their keys.
fn opened(server: &Server) -> Browser {
    let browser = Browser::open(&server.url(), WIDTH, HEIGHT);
    browser.until("a room is open", "document.querySelector('#rooms [aria-current]') !== null");
    browser
}
