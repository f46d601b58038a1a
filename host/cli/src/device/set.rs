//! `palpate device set`.

use std::path::PathBuf;

use shared::adaptation::Relaxation;
use shared::pipeline::GAUGES;
use shared::wire::ToDevice;

use super::{At, failed};
use crate::Failure;
use crate::output::{print_json, print_sections};
use palpate_analysis::decomposition::relaxation_of;
use palpate_link::device::answers::SetAnswer;
use palpate_link::device::change::{Change, Threshold, rate_note};
use palpate_model::Model;
use palpate_present::answers;
use palpate_present::summary::settings_blocks;
use palpate_report::Section;

/// Set rate, gain, filter and thresholds.
#[derive(clap::Args)]
#[command(after_help = "\
Everything is checked before it is sent. What is set is lost with the power unless --save keeps
it. The calibration follows the gain, so that strain stays what it is.

Thresholds in µε: touch, release, peak-drop, motion-step, dead-band.
Thresholds in s: smoothing, dwell, recovery.

Examples:
  palpate device set --rate 2000                       the nearest rate that is possible
  palpate device set --gain 64 --save                  one gain for all gauges
  palpate device set --model model.toml --save         the relaxation function of a fitted model
  palpate device set --filter 0.25 4.0 0.27 0.53       or by its numbers: c1 v1 c2 v2
  palpate device set --threshold touch=30 --threshold dwell=0.3
  palpate device set --defaults --save                 as it was made")]
#[command(group = clap::ArgGroup::new("change").multiple(true).required(true))]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// Samples in a second
    #[arg(long, value_name = "HZ", group = "change", value_parser = parse_rate)]
    rate: Option<f64>,
    /// Gain of the converter, 1, 2, 4 … 128: one for all gauges, or four
    #[arg(long, value_name = "GAIN", group = "change", value_delimiter = ',')]
    gain: Vec<u8>,
    /// The relaxation function: c1 v1 (1/s) c2 v2 (1/s)
    #[arg(long, value_names = ["C1", "V1", "C2", "V2"], num_args = 4, group = "change")]
    filter: Vec<f64>,
    /// Take the relaxation function from this model
    #[arg(long, value_name = "MODEL.toml", group = "change", conflicts_with = "filter")]
    model: Option<PathBuf>,
    /// A threshold of the regions, by name
    #[arg(long, value_name = "NAME=VALUE", group = "change", value_parser = parse_threshold)]
    threshold: Vec<(Threshold, f64)>,
    /// First take the settings that the device was made with
    #[arg(long, group = "change")]
    defaults: bool,
    /// Keep the settings over a loss of power
    #[arg(long, group = "change")]
    save: bool,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

fn parse_rate(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|rate: &f64| rate.is_finite() && *rate > 0.0)
        .ok_or_else(|| "give a number above 0".into())
}

fn parse_threshold(text: &str) -> Result<(Threshold, f64), String> {
    let names = || Threshold::ALL.map(|(_, name, unit)| format!("{name} ({unit})")).join(", ");
    let wrong = || format!("give NAME=VALUE, with one of {}", names());
    let (name, value) = text.split_once('=').ok_or_else(wrong)?;
    let found = Threshold::ALL.into_iter().find(|(_, known, _)| *known == name);
    let (threshold, ..) = found.ok_or_else(wrong)?;
    Ok((threshold, value.parse().map_err(|_| wrong())?))
}

/// Checks, sets and prints the settings as they are now.
pub fn run(args: &Args) -> Result<(), Failure> {
    let change = change(args)?;
    let (_, mut session) = args.at.open()?;
    let (_, before) = session.settings();
    let (_, commands) = change.of(before, session.identity()).map_err(Failure::input)?;
    session.quiet().map_err(failed)?;
    for command in &commands {
        session.command(command).map_err(failed)?;
    }
    if args.save {
        session.command(&ToDevice::Save).map_err(failed)?;
    }
    session.command(&ToDevice::Settings).map_err(failed)?;
    session.status().map_err(failed)?;
    let (_, now) = session.settings();
    if let Some(note) = args.rate.and_then(|wanted| rate_note(wanted, now)) {
        eprintln!("! {note}");
    }
    if args.json {
        return print_json(&answers::json(&SetAnswer::of(now, args.save)));
    }
    let blocks = settings_blocks(now);
    print_sections(&[Section { title: "Settings".into(), blocks }])
}

fn change(args: &Args) -> Result<Change, Failure> {
    let gain = match args.gain[..] {
        [] => None,
        [all] => Some([all; GAUGES]),
        [a, b, c, d] => Some([a, b, c, d]),
        _ => {
            return Err(Failure::Input(miette::miette!(
                "give one gain, or four: --gain 64,64,32,32"
            )));
        }
    };
    let relaxation = match (&args.model, &args.filter[..]) {
        (Some(path), _) => {
            let model = Model::read(path).map_err(Failure::input)?;
            Some(relaxation_of(&model).map_err(Failure::input)?)
        }
        (None, &[c1, v1, c2, v2]) => Some(Relaxation { c1, v1, c2, v2 }),
        (None, _) => None,
    };
    Ok(Change {
        defaults: args.defaults,
        rate_hz: args.rate,
        gain,
        relaxation,
        thresholds: args.threshold.clone(),
    })
}
