//! No bytes from outside break anything: every known input of `tests/corpus/`, and changed ones without number.
//!
//! `cargo xtask fuzz` goes on for a minute with each target. What breaks something is written to its folder. Where the process
//! itself ends, or never comes to an end, what was tried last lies in `target/fuzz/`.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::panic::catch_unwind;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use palpate_tests::fuzz::{Mutator, TARGETS, Target};
use palpate_tests::workspace;
use shared::pipeline::GAUGES;
use shared::wire::{
    Columns, FRAME_MAX, Head, HelloToDevice, INJECT_ROWS, Inject, Oversampling, PerGauge, SCHEMA,
    Source, Start, ToDevice, encode, pack,
};

/// Changed inputs of each target, where no time is given.
const CASES: u64 = 400;
const SEED: u64 = 1;

/// How long each target is tried, with which seed, and which alone: `PALPATE_FUZZ_S`, `PALPATE_FUZZ_SEED`, `PALPATE_FUZZ_TARGET`.
struct Wanted {
    time: Option<Duration>,
    seed: u64,
    target: Option<String>,
}

impl Wanted {
    fn read() -> Self {
        let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
        Self {
            time: number("PALPATE_FUZZ_S").map(Duration::from_secs),
            seed: number("PALPATE_FUZZ_SEED").unwrap_or(SEED),
            target: std::env::var("PALPATE_FUZZ_TARGET").ok(),
        }
    }
}

/// What is tried, on the disk before it is tried.
struct Last {
    path: PathBuf,
    file: File,
}

impl Last {
    fn of(target: &Target) -> Self {
        let path = workspace().join("target/fuzz").join(target.name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        Self { file: File::create(&path).unwrap(), path }
    }

    /// Written over in place: some file systems write a file through to the disk once it was emptied first.
    fn keep(&mut self, input: &[u8]) {
        self.file.seek(SeekFrom::Start(0)).unwrap();
        self.file.write_all(input).unwrap();
        self.file.set_len(input.len() as u64).unwrap();
    }
}

/// Fails with the input, once it is kept, if the target panics.
fn attempt(target: &Target, input: &[u8], last: &mut Last) {
    last.keep(input);
    if catch_unwind(|| (target.run)(input)).is_ok() {
        return;
    }
    let name =
        input.iter().fold(0_u64, |hash, byte| hash.wrapping_mul(31).wrapping_add((*byte).into()));
    let path = target.folder().join(format!("found-{name:016x}"));
    std::fs::write(&path, input).unwrap();
    panic!("{} panics; the input is kept in {}", target.name, path.display());
}

fn run(target: &Target, wanted: &Wanted) {
    let corpus = target.corpus();
    assert!(!corpus.is_empty(), "{} has no inputs", target.name);
    let mut last = Last::of(target);
    corpus.iter().for_each(|input| attempt(target, input, &mut last));
    let mut mutator = Mutator::new(wanted.seed, &corpus, target.words);
    let slowest_path = last.path.with_extension("slowest");
    let (begun, mut cases, mut slowest) = (Instant::now(), 0, Duration::ZERO);
    while wanted.time.map_or(cases < CASES, |time| begun.elapsed() < time) {
        let input = mutator.next_input();
        let tried = Instant::now();
        attempt(target, &input, &mut last);
        cases += 1;
        if tried.elapsed() > slowest {
            slowest = tried.elapsed();
            std::fs::write(&slowest_path, &input).unwrap();
        }
    }
    std::fs::remove_file(last.path).unwrap();
    println!(
        "{}: {} known inputs, {cases} changed ones with seed {} in {:.0} s, the slowest (kept in {}) {:.0} ms",
        target.name,
        corpus.len(),
        wanted.seed,
        begun.elapsed().as_secs_f64(),
        slowest_path.display(),
        slowest.as_secs_f64() * 1e3
    );
}

#[test]
fn no_bytes_from_outside_make_anything_panic() {
    let wanted = Wanted::read();
    let is_wanted =
        |target: &&Target| wanted.target.as_ref().is_none_or(|name| name == target.name);
    let targets: Vec<&Target> = TARGETS.iter().filter(is_wanted).collect();
    assert!(!targets.is_empty(), "no target is called {:?}", wanted.target);
    for target in targets {
        run(target, &wanted);
    }
}

/// Writes the one input that is not written by hand: what a host says to a device in a session.
#[test]
#[ignore = "writes tests/corpus/frames/to-device"]
fn commands_of_a_session_are_written() {
    let rows = [[1_000, -7, 70_000, 8_000_000]; INJECT_ROWS];
    let mut room = [0; FRAME_MAX];
    let counts = pack(&rows, GAUGES as u8, &mut room).unwrap();
    let link = Source::Link { interval_ns: 1_000_000 };
    let session = [
        ToDevice::Hello(HelloToDevice { schema: SCHEMA, version: "1" }),
        ToDevice::Settings,
        ToDevice::SetRatio(Oversampling::X2048),
        ToDevice::SetGain(PerGauge([1, 2, 4, 8])),
        ToDevice::Start(Start { source: Source::Converter, columns: Columns::All }),
        ToDevice::Tare,
        ToDevice::Untare,
        ToDevice::Stop,
        ToDevice::Start(Start { source: link, columns: Columns::Parts }),
        ToDevice::Inject(Inject { temperature: None, counts }),
        ToDevice::Status,
        ToDevice::Stop,
        ToDevice::SelfTest,
        ToDevice::Save,
        ToDevice::LoadDefaults,
        ToDevice::Reboot,
    ];
    let mut bytes = Vec::new();
    for (sequence, command) in (1..).zip(&session) {
        let mut frame = [0; FRAME_MAX];
        bytes.extend(encode(Head { sequence, time_us: 0 }, command, &mut frame).unwrap());
    }
    let frames = TARGETS.iter().find(|target| target.name == "frames").unwrap();
    std::fs::write(frames.folder().join("to-device"), bytes).unwrap();
}
