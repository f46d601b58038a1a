//! `palpate device calibrate`.

use std::io::{BufRead, IsTerminal};
use std::path::{Path, PathBuf};
use std::time::Duration;

use miette::miette;
use shared::wire::ToDevice;

use super::{At, failed};
use crate::Failure;
use crate::output::{print_json, print_sections};
use palpate_link::device::answers::CalibrationAnswer;
use palpate_link::device::calibrate::{Calibrated, Point, Points, read_points};
use palpate_link::device::measure;
use palpate_link::device::session::Session;
use palpate_present::answers;
use palpate_report::number::significant;
use palpate_report::{Block, Column, Section, Table};

/// Find gain and offset of the gauges, and set them.
#[derive(clap::Args)]
#[command(after_help = "\
strain = gain (counts − offset), by least squares over known strains; two are enough, more show
how far the gauge is from a line. With --gauge alone it asks: apply a strain, type it in µε, Enter;
the counts are averaged; an empty line ends. With weights, type them and give --per-load, the
strain of a load of one. The result is sent to the device and saved; the tare of the gauge is taken
back.

The file of --points is CSV with the columns gauge, strain_ustrain, counts.

Examples:
  palpate device calibrate --gauge 1
  palpate device calibrate --gauge 1 --per-load 2.35    loads in g, 2.35 µε per g
  palpate device calibrate --points bench.csv --dry-run
  palpate device calibrate --gauge 2 --gain 0.00068 --offset 1200")]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// The gauge, 1 to 4
    #[arg(long, value_name = "GAUGE", value_parser = clap::value_parser!(u8).range(1..=4))]
    #[arg(required_unless_present = "points")]
    gauge: Option<u8>,
    /// Known strains and their counts, of any gauges
    #[arg(long, value_name = "FILE.csv", conflicts_with = "gauge")]
    points: Option<PathBuf>,
    /// Set this gain, µε per count
    #[arg(long, value_name = "GAIN", requires = "offset", conflicts_with = "points")]
    #[arg(allow_hyphen_values = true)]
    gain: Option<f64>,
    /// Set this offset, counts
    #[arg(long, value_name = "COUNTS", requires = "gain", allow_hyphen_values = true)]
    offset: Option<i32>,
    /// Strain of a load of one, µε; then loads are typed in place of strains
    #[arg(long, value_name = "STRAIN", default_value_t = 1.0, allow_hyphen_values = true)]
    per_load: f64,
    /// How long to average, s
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    seconds: f64,
    /// Only print
    #[arg(long)]
    dry_run: bool,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// Measures, prints, sets and saves.
pub fn run(args: &Args) -> Result<(), Failure> {
    let points = args.points.as_deref().map(points_of).transpose()?;
    let (_, mut session) = args.at.open()?;
    let before = session.settings().1.calibration;
    let fitted = |(gauge, points): (u8, Vec<Point>)| {
        Calibrated::by_points(gauge, &points, &before[usize::from(gauge)]).map_err(Failure::input)
    };
    let calibrated: Vec<Calibrated> = match (points, args.gauge, args.gain, args.offset) {
        (Some(points), ..) => points.into_iter().map(fitted).collect::<Result<_, _>>()?,
        (None, Some(gauge), Some(gain), Some(offset)) => {
            let sheet = &before[usize::from(gauge - 1)];
            vec![Calibrated::by_numbers(gauge - 1, gain, offset, sheet).map_err(Failure::input)?]
        }
        (None, Some(gauge), ..) => vec![fitted((gauge - 1, ask(&mut session, gauge, args)?))?],
        (None, None, ..) => Vec::new(),
    };
    give(&calibrated, args.json)?;
    if args.dry_run {
        return Ok(());
    }
    session.quiet().map_err(failed)?;
    for &Calibrated { gauge, sheet, .. } in &calibrated {
        session.command(&ToDevice::SetCalibration { gauge, sheet }).map_err(failed)?;
    }
    session.command(&ToDevice::Save).map_err(failed)?;
    eprintln!("set and saved");
    Ok(())
}

fn points_of(path: &Path) -> Result<Points, Failure> {
    read_points(path).map_err(Failure::input)
}

/// Asks for strains until an empty line, and averages the counts of each.
fn ask(session: &mut Session, gauge: u8, args: &Args) -> Result<Vec<Point>, Failure> {
    let mut points = Vec::new();
    let over = Duration::try_from_secs_f64(args.seconds)
        .map_err(|_| Failure::Input(miette!("--seconds must be a time above 0")))?;
    let mut lines = std::io::stdin().lock().lines();
    loop {
        if std::io::stdin().is_terminal() {
            eprint!("strain or load, or Enter to end: ");
        }
        let typed = lines.next().transpose().map_err(Failure::work)?.unwrap_or_default();
        let typed = typed.trim();
        if typed.is_empty() {
            return Ok(points);
        }
        let Ok(load) = typed.parse::<f64>() else {
            eprintln!("! `{typed}` is no number");
            continue;
        };
        let mean = measure::mean(session, over).map_err(failed)?[usize::from(gauge - 1)];
        let strain = load * args.per_load;
        eprintln!(
            "  {strain} µε: {:.1} counts ± {:.1} over {} samples",
            mean.counts, mean.deviation, mean.samples
        );
        points.push(Point { strain, counts: mean.counts });
    }
}

fn give(calibrated: &[Calibrated], json: bool) -> Result<(), Failure> {
    if json {
        return print_json(&answers::json(&CalibrationAnswer::from(calibrated)));
    }
    let columns = vec![
        Column::text("Gauge"),
        Column::number("Gain", "µε per 1000 counts"),
        Column::number("± s.e.", ""),
        Column::number("Offset", "counts"),
        Column::number("± s.e.", ""),
        Column::number("Nonlinearity", "% of range"),
    ];
    let table = calibrated.iter().fold(Table::new("", columns), |table, of| {
        let Calibrated { gauge, sheet, line } = of;
        let errors = line.and_then(|line| line.errors);
        let shown = |value: Option<f64>| value.map_or(String::new(), |value| significant(value, 3));
        table.row([
            (gauge + 1).to_string(),
            significant(sheet.gain * 1e3, 6),
            shown(errors.map(|(gain, _)| gain * 1e3)),
            sheet.offset.to_string(),
            shown(errors.map(|(_, offset)| offset)),
            shown(line.map(|line| line.nonlinearity * 100.0)),
        ])
    });
    print_sections(&[Section { title: "Calibration".into(), blocks: vec![Block::Table(table)] }])
}
