//! A recording that is injected comes back in the very bytes that the device's program gives on this computer: the guard against
//! a fault of the emulated processor. On QEMU the same program is held to the same arithmetic.

use device::{Board as Hardware, Device, Identity, Lost, Restart, Room, Setting, begin_with};
use emulator::{Board, Setup};
use shared::pipeline::GAUGES;
use shared::wire::{
    Accumulated, Accumulator, Capabilities, ClockSource, Columns, ConverterFault, FRAME_MAX, Head,
    HelloToDevice, INJECT_ROWS, Inject, ResetCause, SCHEMA, Source, Start, StoreFault, ToDevice,
    ToHost, decode, encode, pack,
};

const ROWS: usize = 640;
const START: ToDevice<'_> = ToDevice::Start(Start {
    source: Source::Link { interval_ns: 1_000_000 },
    columns: Columns::All,
});

/// A press with the noise of a real one, held, then released.
fn counts(row: usize) -> [i32; GAUGES] {
    let noise = (row as i32).wrapping_mul(-1_640_531_535) >> 22;
    let pressed = 10_000 * row.min(80).min(ROWS.saturating_sub(row)) as i32;
    [pressed + noise, pressed / 2 - noise, -pressed + 2 * noise, noise]
}

/// A block of rows as it went over the line.
#[derive(Debug, PartialEq)]
struct Sent {
    time_us: u64,
    first: u64,
    generation: u32,
    temperature: Option<i16>,
    packed: Vec<u8>,
}

/// The blocks in what a device sent.
fn blocks(bytes: &[u8]) -> Vec<Sent> {
    let mut accumulator = Accumulator::default();
    let mut blocks = Vec::new();
    for byte in bytes {
        let Accumulated::Frame(frame) = accumulator.push(*byte) else { continue };
        if let Ok((Head { time_us, .. }, ToHost::Samples(block))) = decode(frame) {
            let packed = block.packed.to_vec();
            let (first, generation, temperature) =
                (block.first, block.generation, block.temperature);
            blocks.push(Sent { time_us, first, generation, temperature, packed });
        }
    }
    blocks
}

/// Gives each piece of the recording to `say`.
fn inject(mut say: impl FnMut(&ToDevice<'_>)) {
    let rows: Vec<_> = (0..ROWS).map(counts).collect();
    for (piece, rows) in rows.chunks(INJECT_ROWS).enumerate() {
        let mut room = [0; 512];
        let counts = pack(rows, GAUGES as u8, &mut room).unwrap();
        let temperature = Some(25 * 256 + piece as i16);
        say(&ToDevice::Inject(Inject { temperature, counts }));
    }
}

struct Nothing;

impl Hardware for Nothing {
    fn configure(&mut self, _: Setting) -> Result<(), ConverterFault> {
        Ok(())
    }

    fn listen(&mut self, _: bool) -> Lost {
        Lost::NONE
    }

    fn store(&mut self, _: &[u8]) -> Result<(), StoreFault> {
        Ok(())
    }

    fn can_restart(&self, _: Restart) -> bool {
        false
    }
}

/// What the device's program says on this computer.
fn here() -> Vec<u8> {
    let identity = Identity {
        version: "",
        git: "",
        board: "",
        serial: [0; 3],
        converter_clock_hz: 8_000_000,
        converter: "ADS131M04",
        capabilities: Capabilities::ads131m04(8_000_000),
        clock: ClockSource::Simulated,
        reset: ResetCause::PowerOn,
        panic: "",
    };
    let beginning = begin_with(None, &identity.capabilities).unwrap();
    let mut room = Room::new();
    let mut device = Device::new(identity, &beginning, &mut room);
    let (mut said, mut sequence) = (Vec::new(), 0);
    let mut say = |command: &ToDevice<'_>| {
        sequence += 1;
        let mut frame = [0; FRAME_MAX];
        let length = encode(Head { sequence, time_us: 0 }, command, &mut frame).unwrap().len();
        device.receive(&mut frame[..length - 1], 0, &mut Nothing);
        loop {
            while device.process_injected() {}
            let mut frame = [0; FRAME_MAX];
            while let Some(bytes) = device.next_frame(0, &mut (), &mut frame) {
                said.extend_from_slice(bytes);
            }
            if !device.has_injected() {
                break;
            }
        }
    };
    say(&ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "" }));
    say(&START);
    inject(say);
    said
}

#[test]
fn a_recording_comes_back_in_the_bytes_that_the_same_program_gives_here() {
    let mut board = Board::started(&Setup::new());
    board.ask(&START, 40).outcome.unwrap();
    inject(|command| {
        board.ask(command, 40).outcome.unwrap();
        board.listen_ms(3);
    });
    board.listen_ms(20);
    let there = blocks(&board.wire().sent);
    let here = blocks(&here());
    assert!(here.len() >= ROWS / INJECT_ROWS, "{} blocks", here.len());
    for (number, (there, here)) in there.iter().zip(&here).enumerate() {
        assert_eq!(there, here, "block {number}");
    }
    assert_eq!(there.len(), here.len());
}
