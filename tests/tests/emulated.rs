//! The release binary of the firmware on an emulated STM32F405, spoken to over a real serial port. Needs the emulator and the
//! firmware, which `cargo xtask test` and `cargo xtask emulate` set up.
#![cfg(unix)]

use std::time::Duration;

use object::{Object, ObjectSymbol};
use palpate::device::session::Session;
use palpate_tests::device::{
    Checked, check_every_recording, check_flooding, check_handshake, check_noisy_line,
    check_restart_while_recording, check_steady_stream, check_wrong_schema_is_refused,
};
use palpate_tests::emulator::{Emulated, firmware};
use palpate_tests::palpate;
use shared::wire::{Source, ToDevice};

fn started() -> Emulated {
    Emulated::start().unwrap()
}

fn passes(checked: Checked) {
    println!("{}", checked.unwrap());
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn it_says_who_it_is() {
    passes(check_handshake(&started().port()));
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn a_host_of_another_schema_is_refused() {
    passes(check_wrong_schema_is_refused(&started().port()));
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn every_recording_comes_back_as_the_host_decomposes_it_bit_for_bit() {
    passes(check_every_recording(&started().port()));
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn in_a_flood_what_was_sent_is_what_came_back_and_what_was_counted() {
    passes(check_flooding(&started().port()));
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn on_a_noisy_line_nothing_wrong_is_accepted_and_two_frames_are_the_most_it_costs() {
    passes(check_noisy_line(&started().port(), &[1e-5, 1e-4, 1e-3], 4_000, 1));
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn a_recording_goes_on_when_the_device_is_killed_and_started_again() {
    let mut device = started();
    let folder = tempfile::tempdir().unwrap();
    let (port, file) = (device.port(), folder.path().join("killed.palpate"));
    let source = Source::Link { interval_ns: 1_000_000 };
    let mut restart = || Ok(device.restart()?);
    passes(check_restart_while_recording(&port, source, &file, &mut restart));
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn a_steady_stream_of_a_kilohertz_loses_nothing_and_its_stack_does_not_grow() {
    let seconds = std::env::var("PALPATE_STEADY_S").ok().and_then(|text| text.parse().ok());
    passes(check_steady_stream(&started().port(), Duration::from_secs(seconds.unwrap_or(60))));
}

/// What `palpate device` and the like say about a device: standard output and error, and the exit status.
fn said(arguments: &[&str], device: &Emulated) -> (String, Option<i32>) {
    let output = palpate().args(arguments).arg("--port").arg(device.port()).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (String::from_utf8(text).unwrap(), output.status.code())
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn its_log_is_read_with_the_file_it_was_flashed_from() {
    let device = started();
    let elf = firmware();
    let (log, status) = said(&["device", "log", "--elf", elf.to_str().unwrap()], &device);
    assert_eq!(status, Some(0), "{log}");
    assert!(log.contains("palpate 0.1.0 on stm32f405, 16 MHz"), "{log}");
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn what_the_emulated_board_lacks_is_refused_in_words_and_nothing_is_left_behind() {
    let device = started();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("touch.palpate");
    let (refused, status) = said(&["record", "-o", file.to_str().unwrap()], &device);
    assert_ne!(status, Some(0), "{refused}");
    assert!(refused.contains("converter"), "{refused}");
    assert!(!file.exists(), "a recording of nothing");
    let (refused, status) = said(&["device", "set", "--rate", "500", "--save"], &device);
    assert_ne!(status, Some(0), "{refused}");
    assert!(refused.contains("flash"), "{refused}");
    let (info, _) = said(&["device", "info"], &device);
    assert!(info.contains("rate: 488.28125 Hz"), "set, though not kept: {info}");
}

/// Where the firmware keeps its note to the program after a reset.
fn address_of_note() -> u32 {
    let elf = std::fs::read(firmware()).unwrap();
    let file = object::File::parse(&*elf).unwrap();
    let name = |symbol: &object::Symbol<'_, '_>| symbol.name().unwrap_or_default().to_owned();
    let note = file.symbols().find(|symbol| {
        let name = name(symbol);
        name.contains("reset") && name.contains("NOTE")
    });
    note.unwrap().address() as u32
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn what_a_panic_said_before_the_reset_is_told() {
    let said = b"main.rs:1: the end";
    // The mark, no loader asked for, the length and the text, as `board::reset` keeps them.
    let mut note = vec![0x70, 0x6c, 0x61, 0x70, 0, 0, 0, 0, said.len() as u8, 0, 0, 0];
    note.extend(said);
    let device = Emulated::start_with_memory(address_of_note(), &note).unwrap();
    // A board that begins beside other work does not answer at once.
    let asked = || self::said(&["device", "info"], &device);
    let mut answers = (0..5).map(|_| asked());
    let (info, status) = answers.find(|(_, status)| *status == Some(0)).unwrap_or_else(asked);
    assert_eq!(status, Some(0), "{info}");
    assert!(info.contains("main.rs:1: the end"), "{info}");
}

#[test]
#[ignore = "needs the emulator: cargo xtask emulate"]
fn told_to_begin_again_it_answers_first_and_is_soon_back_as_it_was_made() {
    let device = started();
    let (changed, _) = said(&["device", "set", "--rate", "500"], &device);
    assert!(changed.contains("488.28125 Hz"), "{changed}");
    let mut session = Session::open(&device.port(), Duration::from_secs(5)).unwrap();
    session.command(&ToDevice::Reboot).unwrap();
    drop(session);
    // On a busy machine the emulator boots for longer than a user would wait.
    drop(Session::open(&device.port(), Duration::from_secs(60)).unwrap());
    let (info, status) = said(&["device", "info"], &device);
    assert_eq!(status, Some(0), "it did not come back: {info}");
    assert!(info.contains("976.5625 Hz"), "{info}");
}
