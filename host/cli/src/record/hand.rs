//! Several devices, as the fingers of a hand, into one file.

use std::io::IsTerminal;
use std::path::Path;

use miette::miette;
use shared::wire::Felt;

use super::{Args, failed, summarise};
use crate::Failure;
use crate::output::print;
use palpate_link::device::answers::{EventAnswer, SecondAnswer};
use palpate_link::device::describe::{felt_in_words, live_line_of_all};
use palpate_link::device::hand::{BesideAll, record_all};
use palpate_link::device::record::{RecordError, View};
use palpate_present::answers;

/// Most devices at once.
const MOST: usize = 8;

/// What a person or a program sees of it.
struct Screen {
    live: bool,
    json: bool,
    shown_s: u64,
    /// Events of each device since the last objects.
    felt: Vec<Vec<EventAnswer>>,
    ended: fn() -> bool,
}

impl BesideAll for Screen {
    fn ended(&mut self) -> bool {
        (self.ended)()
    }

    fn feel(&mut self, device: usize, felt: &Felt) {
        if self.live {
            eprintln!("\rfinger {}: {}\x1b[K", device + 1, felt_in_words(felt));
        }
        if self.json {
            self.felt[device].push(felt.into());
        }
    }

    fn watch(&mut self, views: &[View]) {
        if self.live {
            eprint!("\r{}\x1b[K", live_line_of_all(views));
        }
        let passed_s = views.iter().map(|view| view.passed.as_secs()).min().unwrap_or_default();
        if self.json && passed_s > self.shown_s {
            self.shown_s = passed_s;
            for ((number, view), felt) in (1..).zip(views).zip(&mut self.felt) {
                let events = std::mem::take(felt);
                let object = SecondAnswer { device: Some(number), view: view.into(), events };
                // A reader that has gone away is no reason to end a recording.
                let _ = print(&format!("{}\n", answers::json(&object)));
            }
        }
    }
}

/// Records all devices until it is asked to end.
pub fn run(args: &Args, ended: fn() -> bool) -> Result<(), Failure> {
    if args.mcap.is_some() {
        return Err(Failure::Input(miette!("--mcap: topics are of one device; give one --port")));
    }
    if args.ports.len() > MOST {
        return Err(Failure::Input(miette!("--port: at most {MOST} devices go into one file")));
    }
    let devices: Result<Vec<_>, _> = args.ports.iter().map(|port| args.open(Some(port))).collect();
    let live = !args.quiet && !args.json && std::io::stderr().is_terminal();
    let felt = vec![Vec::new(); args.ports.len()];
    let mut screen = Screen { live, json: args.json, shown_s: 0, felt, ended };
    let outcome = record_all(devices?, &args.output, args.over.force, &mut screen);
    if live {
        eprintln!();
    }
    let views = outcome.map_err(|(device, error)| of_device(&args.ports[device], error))?;
    (1..).zip(&views).try_for_each(|(number, view)| summarise(args, Some(number), view))
}

/// Which device it was that failed, where the error does not name the file.
fn of_device(port: &Path, error: RecordError) -> Failure {
    match error {
        RecordError::Link(_) | RecordError::AnotherDevice { .. } => {
            Failure::Work(miette!("{}: {error}", port.display()))
        }
        _ => failed(error),
    }
}
