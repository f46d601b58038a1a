//! How soon touch, release and incipient slip are told, how many are missed, and how many false alarms there are: on
//! simulated presses, pulls and shakes with noise of several sizes, and on recordings of others.
//!
//! `cargo bench -p palpate-tests --bench events` prints the tables of docs/measured.md. The recordings are those of the
//! folder `PALPATE_TRACES`; without it there is no second table.

use std::path::{Path, PathBuf};

use palpate::decomposition::default_relaxation;
use palpate::events::{Asked, Events, events, happened, judge};
use palpate::sensor::{Fingertip, Indenter, Press, SensorError, Shake, Silicone, Slip, Touch};
use palpate::trace::{FORCE, GAUGES, Kind as Way, Mapping, Trace, import_parts, segments};
use rayon::prelude::*;
use shared::events::Kind;

const SEEDS: u64 = 20;

fn fingertip(noise_ustrain: f64) -> Fingertip {
    let silicone = Silicone::of("7:3".parse().expect("a composition"));
    Fingertip { noise_ustrain, ..Fingertip::new(silicone, 4.0).expect("a thickness") }
}

/// What came of all runs of one stimulus.
#[derive(Default)]
struct Sum {
    delays: Vec<(Kind, Option<f64>)>,
    /// From the slip that was told to the slide of the whole contact, s; none where it came too late.
    leads: Vec<Option<f64>>,
    false_alarms: usize,
    minutes: f64,
}

impl Sum {
    fn add(mut self, other: Self) -> Self {
        self.delays.extend(other.delays);
        self.leads.extend(other.leads);
        self.false_alarms += other.false_alarms;
        self.minutes += other.minutes;
        self
    }

    /// How many of a kind happened, how many were missed, median and worst delay in ms.
    fn of(&self, kind: Kind) -> String {
        let delays: Vec<Option<f64>> =
            self.delays.iter().filter(|delay| delay.0 == kind).map(|delay| delay.1).collect();
        if delays.is_empty() {
            return "–".into();
        }
        let missed = delays.iter().filter(|delay| delay.is_none()).count();
        match ends(delays.into_iter().flatten().collect()) {
            Some((_, median, worst)) => {
                format!("{missed} · {:.0} · {:.0}", 1e3 * median, 1e3 * worst)
            }
            None => format!("{missed} · – · –"),
        }
    }

    fn leads(&self) -> String {
        match ends(self.leads.iter().copied().flatten().collect()) {
            Some((least, median, _)) => format!("{:.0} · {:.0}", 1e3 * median, 1e3 * least),
            None => "–".into(),
        }
    }
}

/// Least, median and largest.
fn ends(mut values: Vec<f64>) -> Option<(f64, f64, f64)> {
    values.sort_by(f64::total_cmp);
    Some((*values.first()?, values[values.len() / 2], *values.last()?))
}

fn judged(tip: &Fingertip, touch: &Touch, slides_s: Option<f64>) -> Sum {
    let gauges = GAUGES.map(String::from);
    let found = events(&touch.trace, &gauges, &tip.relaxation_of_readings(), &Asked::default())
        .expect("a simulated fingertip can be heard");
    let known = happened(&touch.trace);
    let judged = judge(&known, &found.found);
    let slip = found.found.iter().find(|found| found.kind == Kind::Slip);
    let lead = |slides_s: f64| slip.map(|slip| slides_s - slip.told_s).filter(|lead| *lead > 0.0);
    Sum {
        delays: judged.delay_s,
        leads: slides_s.map(lead).into_iter().collect(),
        false_alarms: judged.false_alarms.len(),
        minutes: touch.trace.duration() / 60.0,
    }
}

type Made = Result<(Touch, Option<f64>), SensorError>;

fn row(what: &str, tip: &Fingertip, seeds: u64, make: impl Fn(u64) -> Made + Sync) {
    let one = |seed: u64| {
        let (touch, slides_s) = make(seed).expect("it can be simulated");
        judged(tip, &touch, slides_s)
    };
    let runs: Vec<Sum> = (1..=seeds).into_par_iter().map(one).collect();
    let sum = runs.into_iter().fold(Sum::default(), Sum::add);
    println!(
        "| {} | {what} | {seeds} | {} | {} | {} | {} | {} in {:.1} min |",
        tip.noise_ustrain,
        sum.of(Kind::Touch),
        sum.of(Kind::Release),
        sum.of(Kind::Slip),
        sum.leads(),
        sum.false_alarms,
        sum.minutes,
    );
}

fn simulated(noise_ustrain: f64) {
    let tip = &fingertip(noise_ustrain);
    for (name, indenter) in [("sharp", Indenter::SHARP), ("blunt", Indenter::BLUNT)] {
        row(&format!("press, {name}, 2 to 40 mm/s"), tip, SEEDS, |seed| {
            let speed_mm_per_s = 2.0 * seed as f64;
            let press = Press { speed_mm_per_s, ..Press::over_first_gauge(tip, indenter) };
            Ok((press.run(tip, seed)?.touch, None))
        });
    }
    for pull_s in [0.3, 1.0, 3.0] {
        row(&format!("pull of {pull_s} s until it slides"), tip, SEEDS, |seed| {
            // Elsewhere each time, and held for another time.
            let place = f64::from(u32::try_from(seed).unwrap_or(0));
            let standard = Slip::beside_first_gauge(tip);
            let [x, y] = standard.place_mm;
            let place_mm = [x - 0.05 * place, y - 0.1 * place];
            let slip = Slip { pull_s, place_mm, hold_s: 1.0 + 0.1 * place, ..standard };
            let result = slip.run(tip, seed)?;
            Ok((result.touch, Some(result.slides_s)))
        });
    }
    for part in [0.02, 0.05, 0.1] {
        row(&format!("shaken by {:.0} %, 1 to 12 Hz", 100.0 * part), tip, SEEDS, |seed| {
            Ok((Shake { part, ..Shake::above_first_gauge(tip) }.run(tip, seed)?, None))
        });
    }
    row("held for 5 minutes", tip, 4, |seed| {
        let still = Shake { part: 0.0, duration_s: 300.0, ..Shake::above_first_gauge(tip) };
        Ok((still.run(tip, seed)?, None))
    });
    row("5 minutes in the air after a press", tip, 4, |seed| {
        let press = Press { after_s: 300.0, ..Press::over_first_gauge(tip, Indenter::BLUNT) };
        Ok((press.run(tip, seed)?.touch, None))
    });
}

/// Recordings of others, with the mapping that brings them in; of a folder, every table is one.
const RECORDINGS: [(&str, &str); 5] = [
    ("vhb4910", "tape-tension.toml"),
    ("vhb4910/holds", "tape-tension.toml"),
    ("soro-tensile", "silicone-tension.toml"),
    ("ecoflex-adhesive/*", "adhesive-pad.toml"),
    ("rubber-membrane-24h", "rubber-tension.toml"),
];

/// The tables of a folder, or each folder in it as one recording in parts.
fn parts(folder: &Path) -> Vec<Vec<PathBuf>> {
    let entries = |folder: &Path| -> Vec<PathBuf> {
        let found = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut found: Vec<PathBuf> = found.map(|entry| entry.path()).collect();
        found.sort();
        found
    };
    let is_table = |path: &PathBuf| path.extension().is_some_and(|it| it == "csv");
    let tables = |folder: &Path| entries(folder).into_iter().filter(is_table).collect::<Vec<_>>();
    match folder.file_name() {
        Some(name) if name == "*" => {
            let folder = folder.parent().unwrap_or(folder);
            entries(folder).iter().filter(|path| path.is_dir()).map(|path| tables(path)).collect()
        }
        _ => tables(folder).into_iter().map(|table| vec![table]).collect(),
    }
}

fn recorded(folder: &Path) {
    println!(
        "\n| recordings | samples a second | minutes | loadings · touches reported in them · force then, of the largest | other touches | releases | slips |"
    );
    println!("|-|-|-|-|-|-|-|");
    for (name, mapping) in RECORDINGS {
        let mapping = Path::new(env!("CARGO_MANIFEST_DIR")).join("mappings").join(mapping);
        let mapping = Mapping::read(&mapping).expect("a bundled mapping");
        let traces: Vec<Trace> = parts(&folder.join(name))
            .iter()
            .filter_map(|files| Some(import_parts(files, &mapping).ok()?.trace))
            .filter(|trace| trace.force().is_some() && trace.displacement().is_some())
            .collect();
        let heard: Vec<(&Trace, Events)> = traces
            .iter()
            .filter_map(|trace| {
                let force = [FORCE.to_owned()];
                let found = events(trace, &force, &default_relaxation(), &Asked::default());
                Some((trace, found.ok()?))
            })
            .collect();
        println!("{}", recordings_row(name, &heard));
    }
}

fn recordings_row(name: &str, heard: &[(&Trace, Events)]) -> String {
    let (mut loadings, mut forces, mut others) = (0, Vec::new(), 0);
    let mut count = [0; 2];
    for (trace, found) in heard {
        let (force, displacement) =
            (trace.force().unwrap_or_default(), trace.displacement().unwrap_or_default());
        let ways = segments(&trace.time, displacement);
        let loads: Vec<_> = ways.iter().filter(|it| it.kind == Way::Load).collect();
        loadings += loads.len();
        let mut touched = vec![false; loads.len()];
        for event in &found.found {
            let at = trace.time.partition_point(|t| *t < event.told_s);
            match event.kind {
                Kind::Touch => match loads.iter().position(|it| it.range.contains(&at)) {
                    Some(load) if !touched[load] => {
                        touched[load] = true;
                        let force = &force[loads[load].range.clone()];
                        let largest = force.iter().copied().fold(0.0, f64::max);
                        forces.push(trace.force().unwrap_or_default()[at] / largest);
                    }
                    _ => others += 1,
                },
                Kind::Release => count[0] += 1,
                Kind::Slip => count[1] += 1,
            }
        }
    }
    let told = forces.len();
    let force =
        ends(forces).map_or("–".into(), |(_, median, _)| format!("{:.1} %", 100.0 * median));
    let rates = ends(heard.iter().map(|(_, found)| found.rate_hz).collect());
    let rates = match rates {
        Some((least, _, most)) if most > 1.01 * least => format!("{least:.3} to {most:.3}"),
        Some((_, median, _)) => format!("{median:.3}"),
        None => "–".into(),
    };
    let minutes: f64 = heard.iter().map(|(trace, _)| trace.duration() / 60.0).sum();
    format!(
        "| `{name}`, {} | {rates} | {minutes:.0} | {loadings} · {told} · {force} | {others} | {} | {} |",
        heard.len(),
        count[0],
        count[1]
    )
}

fn main() {
    println!(
        "| noise (µε) | stimulus | runs | touch: missed · median · worst (ms) | release: the same | slip: the same | reported before it slides: median · least (ms) | false alarms |"
    );
    println!("|-|-|-|-|-|-|-|-|");
    for noise_ustrain in [0.1, 0.3, 1.0] {
        simulated(noise_ustrain);
    }
    if let Some(folder) = std::env::var_os("PALPATE_TRACES") {
        recorded(Path::new(&folder));
    }
}
