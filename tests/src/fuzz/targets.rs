//! Everything that takes bytes from outside.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use palpate::afm::curve::ForceCurve;
use palpate::device::heard::Heard;
use palpate::device::line::Arrival;
use palpate::model::{Expression, ForceProfile, Model, Profile};
use palpate::recording::Reader;
use palpate::serve::lab::{OwnLaw, Task, View};
use palpate::serve::live::wish::Wish;
use palpate::trace::recorded::{Options, to_traces};
use palpate::trace::{self, Mapping};
use shared::wire::{Accumulated, Accumulator, FRAME_MAX};

use super::{Target, desk, resealed};

/// Every parser, and the device.
pub const TARGETS: [Target; 11] = [
    Target {
        name: "trace",
        run: of_trace,
        words: &[
            "# ",
            "[specimen]",
            "time_s",
            "force_N",
            "\"",
            ",",
            "\r\n",
            "1e400",
            "# palpate-trace = 1\n",
        ],
    },
    Target {
        name: "mapping",
        run: mapping,
        words: &["[[column]]", "[time]", "[text]", "from = ", "unit = \"s\"", "every = "],
    },
    Target {
        name: "import",
        run: import,
        words: &[
            "\n----\n",
            ";",
            "\t",
            "from = 1",
            "header_line = ",
            "\u{feff}",
            "encoding = \"utf-16le\"",
        ],
    },
    Target {
        name: "model",
        run: model,
        words: &[
            "[[effect]]",
            "[[candidate]]",
            "value = ",
            "expression = \"x\"",
            "stage = \"contact\"",
            "nan",
            "[fit]",
        ],
    },
    Target {
        name: "profile",
        run: profile,
        words: &["[[step]]", "to_mm = ", "hold_s = ", "repeat = ", "rate_hz = ", "bandwidth_hz = "],
    },
    Target {
        name: "expression",
        run: expression,
        words: &["x", "x_max", "sin(", "^", "(", ")", "-", "F", "t_set", "1e"],
    },
    Target { name: "recording", run: recording, words: &[] },
    Target { name: "frames", run: frames, words: &[] },
    Target { name: "parquet", run: parquet, words: &["PAR1", "time_s"] },
    Target {
        name: "afm",
        run: afm,
        words: &[
            "# units: m N",
            "# segment: retract",
            "# springConstant: ",
            "time_s,displacement_mm,force_N\n",
        ],
    },
    Target {
        name: "requests",
        run: requests,
        words: &["{", "}", "[", "\"fit\"", "\"law\"", "null", "-1", "\"add\"", "\"parameters\""],
    },
];

/// Where inputs lie that are read from a file.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| tempfile::tempdir().unwrap());
    let path = folder.path().join(name);
    // Written over in place: some file systems write a file through to the disk once it was emptied first.
    let mut file = OpenOptions::new().create(true).truncate(false).write(true).open(&path).unwrap();
    file.write_all(bytes).unwrap();
    file.set_len(bytes.len() as u64).unwrap();
    path
}

fn of_trace(bytes: &[u8]) {
    let Ok(read) = trace::parse(Path::new("t.csv"), bytes) else { return };
    let mut text = Vec::new();
    trace::write_to(&mut text, &read).expect("what was read can be written");
    let again = trace::parse(Path::new("t.csv"), &text).expect("what was written can be read");
    assert_eq!((again.time, again.columns), (read.time, read.columns));
}

fn mapping(bytes: &[u8]) {
    let _ = Mapping::parse(Path::new("m.toml"), &String::from_utf8_lossy(bytes));
}

/// A mapping and a recording, with a line between them.
fn import(bytes: &[u8]) {
    const LINE: &[u8] = b"\n----\n";
    let Some(at) = bytes.windows(LINE.len()).position(|bytes| bytes == LINE) else { return };
    let recording = file("lab.txt", &bytes[at + LINE.len()..]);
    let _ = trace::suggest(&recording, None);
    let text = String::from_utf8_lossy(&bytes[..at]);
    let Ok(mapping) = Mapping::parse(Path::new("m.toml"), &text) else { return };
    if let Ok(imported) = trace::import(&recording, &mapping) {
        trace::write_to(Vec::new(), &imported.trace).expect("what was imported can be written");
    }
}

fn model(bytes: &[u8]) {
    let Ok(model) = Model::parse(Path::new("m.toml"), &String::from_utf8_lossy(bytes)) else {
        return;
    };
    let path = file("model.toml", b"");
    model.write(&path).expect("what was read can be written");
    assert_eq!(Model::read(&path).expect("what was written can be read"), model);
}

fn profile(bytes: &[u8]) {
    let path = file("profile.toml", bytes);
    let _ = ForceProfile::read(&path);
    if let Ok(profile) = Profile::read(&path)
        && profile.samples() < 1e5
    {
        let motion = profile.motion();
        assert_eq!(motion.time.len(), motion.displacement.len());
    }
}

fn expression(bytes: &[u8]) {
    let _ = Expression::parse(&String::from_utf8_lossy(bytes), &["a", "b", "depth"]);
}

fn recording(bytes: &[u8]) {
    for bytes in [bytes.to_vec(), resealed(bytes)] {
        for skip_damaged in [false, true] {
            let Ok(reader) = Reader::new(&bytes[..]) else { continue };
            let options = Options { skip_damaged, host_time: skip_damaged };
            let Ok(found) = to_traces(Path::new("t.palpate"), reader, &options) else { continue };
            for trace in &found.traces {
                trace::write_to(Vec::new(), trace).expect("what was recorded can be written");
            }
        }
    }
}

/// What comes over a line, to the device and to the host.
fn frames(bytes: &[u8]) {
    for bytes in [bytes.to_vec(), resealed(bytes)] {
        for piece in bytes.split(|byte| *byte == 0) {
            let _ = Heard::of(Arrival::Frame(std::time::Instant::now(), piece.to_vec()));
        }
        desk(|device, board| {
            let mut line = Accumulator::new();
            let mut out = [0; FRAME_MAX];
            for (byte, now_us) in bytes.iter().zip((0..).step_by(100)) {
                if let Accumulated::Frame(frame) = line.push(*byte) {
                    device.receive(frame, now_us, board);
                }
                device.process_injected();
                device.tick(now_us, board);
                while device.next_frame(now_us, &mut (), &mut out).is_some() {}
            }
        });
    }
}

fn parquet(bytes: &[u8]) {
    let _ = trace::read(&file("t.parquet", bytes));
}

fn afm(bytes: &[u8]) {
    let _ = ForceCurve::read(&file("curve.txt", bytes));
    let _ = ForceCurve::read(&file("curve.csv", bytes));
}

/// Bodies and queries of the local page.
fn requests(bytes: &[u8]) {
    let _ = serde_json::from_slice::<Task>(bytes);
    let _ = serde_json::from_slice::<View>(bytes);
    let _ = serde_json::from_slice::<Wish>(bytes);
    if let Ok(law) = serde_json::from_slice::<OwnLaw>(bytes) {
        let _ = law.fault();
        let _ = law.toml();
    }
}
