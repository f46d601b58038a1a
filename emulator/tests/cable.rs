//! One cable: the board's own USB socket as a serial port that carries what the line carries.

use emulator::{BOOT_MS, Board, MS, Over, Setup};
use shared::wire::{
    Columns, FRAME_MAX, Head, Oversampling, Refusal, Source, Start, ToDevice, USB_NAME,
    USB_PRODUCT, USB_VENDOR, encode,
};

const SYSTEM_MEMORY: u32 = 0x1fff_0000;

fn plugged_in() -> Board {
    let mut board = Board::new(&Setup::new());
    board.run_ns(BOOT_MS * MS);
    board.plug_in();
    board
}

fn stream(board: &mut Board, rate: Oversampling, columns: Columns) {
    board.ask(&ToDevice::SetRatio(rate), 40).outcome.unwrap();
    let start = Start { source: Source::Converter, columns };
    board.ask(&ToDevice::Start(start), 100).outcome.unwrap();
}

#[test]
fn it_is_a_serial_port_with_the_number_of_its_chip() {
    let mut board = plugged_in();
    let device = board.descriptor(1, 0);
    let word = |at: usize| u16::from_le_bytes([device[at], device[at + 1]]);
    assert_eq!((word(8), word(10)), (USB_VENDOR, USB_PRODUCT));
    let text = |descriptor: &[u8]| {
        let units = descriptor[2..].chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
        String::from_utf16(&units.collect::<Vec<_>>()).unwrap()
    };
    assert_eq!(text(&board.descriptor(3, device[15])), USB_NAME);
    // "a model only" as three words.
    assert_eq!(text(&board.descriptor(3, device[16])), "6f6d2061206c6564796c6e6f");
    assert_eq!(board.hello().tries, 1);
}

#[test]
fn at_the_fastest_rate_every_row_comes_with_every_column_and_every_command_is_answered() {
    let mut board = plugged_in();
    board.hello();
    stream(&mut board, Oversampling::X1024, Columns::All);
    board.listen_ms(20);
    board.heard.clear();
    board.listen_ms(300);
    let rows = board.heard.rows.len();
    assert!((1_100..1_250).contains(&rows), "{rows} rows in 300 ms");
    for command in [ToDevice::Status, ToDevice::Settings, ToDevice::Untare] {
        assert_eq!(board.ask(&command, 10).tries, 1, "{command:?}");
    }
    let status = board.status();
    assert_eq!((status.counters.link_full, board.heard.left_out, board.heard.damaged), (0, 0, 0));
    assert_eq!(status.counters.conversions_missed, 0);
}

#[test]
fn a_host_that_sleeps_holds_nothing_up_and_is_told_how_many_rows_it_lost() {
    let mut board = plugged_in();
    board.hello();
    stream(&mut board, Oversampling::X1024, Columns::Parts);
    board.listen_ms(50);
    board.cable.is_read = false;
    board.run_ns(200 * MS);
    board.cable.is_read = true;
    board.listen_ms(50);
    let status = board.status();
    assert!(board.heard.left_out > 500, "{}", board.heard.left_out);
    assert_eq!(u64::from(status.counters.link_full), board.heard.left_out);
    assert_eq!((status.counters.conversions_missed, board.heard.damaged), (0, 0));
}

#[test]
fn whichever_line_speaks_is_answered() {
    let mut board = Board::started(&Setup::new());
    stream(&mut board, Oversampling::X4096, Columns::Parts);
    board.listen_ms(50);
    board.plug_in();
    board.heard.clear();
    board.listen_ms(100);
    assert_eq!(board.heard.rows.len(), 0, "it speaks to the one that spoke");
    assert_eq!(board.hello().tries, 1);
    board.heard.clear();
    board.listen_ms(100);
    assert!(board.heard.rows.len() > 80, "{}", board.heard.rows.len());
    board.speak_over(Over::Serial);
    // Half a frame, and noise, are nobody.
    board.send(b"\x00noise\x00");
    let quiet = board.wire().sent.len();
    board.run_ns(50 * MS);
    assert_eq!(board.wire().sent.len(), quiet);
    assert_eq!(board.hello().tries, 1);
    board.heard.clear();
    board.listen_ms(100);
    assert!(board.heard.rows.len() > 80, "{}", board.heard.rows.len());
}

#[test]
fn after_a_host_that_was_killed_or_a_cable_that_was_pulled_the_next_one_reaches_it() {
    let mut board = plugged_in();
    board.hello();
    for kill in 0..10 {
        stream(&mut board, Oversampling::X1024, Columns::Parts);
        let mut room = [0; FRAME_MAX];
        let frame = encode(Head { sequence: 1, time_us: 0 }, &ToDevice::Stop, &mut room).unwrap();
        board.send(&frame[..kill]);
        board.run_ns(kill as u64 * MS / 3);
        if kill % 2 == 0 {
            board.plug_in();
        }
        assert_eq!(board.hello().tries, 1, "kill {kill}");
        assert_eq!(board.ask(&ToDevice::Stop, 10).tries, 1, "kill {kill}");
        assert_eq!(board.ask(&ToDevice::Stop, 10).outcome, Err(Refusal::NotStreaming));
    }
}

#[test]
fn a_flood_of_the_host_is_held_back_and_no_byte_of_it_is_lost() {
    let mut board = plugged_in();
    board.hello();
    let mut room = [0; FRAME_MAX];
    for number in 0..200 {
        let head = Head { sequence: 1_000 + number, time_us: 0 };
        let frame = encode(head, &ToDevice::Status, &mut room).unwrap().to_vec();
        board.send(&frame);
    }
    board.listen_ms(300);
    let answered = board.heard.answers.iter().filter(|(to, _)| *to >= 1_000).count();
    assert_eq!(answered, 200);
    let counters = board.status().counters;
    assert_eq!((counters.bytes_lost, counters.frames_damaged), (0, 0));
}

#[test]
fn a_port_opened_at_1200_baud_and_closed_begins_the_loader() {
    let mut board = plugged_in();
    board.hello();
    board.set_port(1_200, true);
    board.run_ns(50 * MS);
    assert_eq!(board.resets(), 0);
    board.set_port(1_200, false);
    board.run_ns(100 * MS);
    assert_eq!(board.resets(), 1);
    let at = board.cpu().regs().r[15];
    assert!((SYSTEM_MEMORY..SYSTEM_MEMORY + 0x100).contains(&at), "{at:#010x}");
    assert!(!board.is_on_usb());
}

#[test]
fn where_the_core_does_not_answer_or_has_no_clock_the_serial_line_does() {
    let dead = Setup { has_usb: false, ..Setup::new() };
    let mut board = Board::started(&dead);
    assert!(!board.is_on_usb());
    assert_eq!(board.hello().tries, 1);
    let no_crystal = Setup { crystal_mhz: 10, ..Setup::new() };
    let mut board = Board::new(&no_crystal);
    board.run_ns(10 * BOOT_MS * MS);
    assert!(!board.is_on_usb());
    assert_eq!(board.hello().tries, 1);
}
