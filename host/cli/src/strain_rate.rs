//! `palpate strain-rate`.

use std::path::PathBuf;

use super::Failure;
use super::output::Output;
use super::specimen::{SpecimenArgs, positive};
use palpate_analysis::geometry::Geometry;
use palpate_analysis::segment_run::{SegmentRun, Setting, segment_run};
use palpate_analysis::strain_rate::{Order, Study, strain_rate};
use palpate_present::answers::{self, StrainRateAnswer};
use palpate_present::summary::{segment_run_section, strain_rate_sections};
use palpate_trace::{Trace, read_set};

/// Strain and strain rate from force, and the power law ε̇ = −ν (ε − ε_e)^n of every hold.
#[derive(clap::Args)]
#[command(after_help = "\
Chapter 7: strain of a ball, cylinder or block from its force, its area of contact and a modulus; for
each hold ν, n and ε_e. The strain is fitted with the closed forms (7.4, 7.5), not its derivative; that
is drawn, with its bandwidth. Strain is positive in compression.

Examples:
  palpate strain-rate ball.csv --modulus 2.8e4 --order 5
  palpate strain-rate ball.csv --modulus 2.8e4               the lowest odd order that fits
  palpate strain-rate ball.csv --modulus 2.8e4 --order free  n as a parameter
  palpate strain-rate steps.csv --modulus 2.8e4 --shape sphere --radius 35 --report rate.html
  palpate strain-rate steps.csv --modulus 2.8e4 --simulate 8   and the run of Fig. 7.8 by (7.11)")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Young's modulus E (7.6)
    #[arg(long, value_name = "PA", value_parser = positive)]
    modulus: f64,
    /// n: a number from 1 to 25, free, or odd: the lowest odd one that fits all holds as well as the best
    #[arg(long, default_value = "odd", value_parser = parse_order)]
    order: Order,
    /// Also simulate each trace's own motion with so many segments from face to middle (7.4, eq. 7.11)
    #[arg(long, value_name = "SEGMENTS", value_parser = clap::value_parser!(u16).range(2..=512))]
    simulate: Option<u16>,
    /// ν of that simulation, 1/s; without it, the one whose force is nearest to the measured one
    #[arg(long, value_name = "PER_S", requires = "simulate", value_parser = positive)]
    rate: Option<f64>,
    #[command(flatten)]
    specimen: SpecimenArgs,
    #[command(flatten)]
    result: Output,
}

pub(super) fn parse_order(text: &str) -> Result<Order, String> {
    match (text, text.parse::<f64>()) {
        ("free", _) => Ok(Order::Free),
        ("odd", _) => Ok(Order::LowestOdd),
        (_, Ok(order)) if (1.0..=25.0).contains(&order) => Ok(Order::Fixed(order)),
        _ => Err("give a number from 1 to 25, free or odd".into()),
    }
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.traces)?;
    let mut traces = read_set(&args.traces).map_err(Failure::input)?;
    args.specimen.apply(&mut traces);
    let study = strain_rate(&traces, args.modulus, args.order, args.specimen.faces())
        .map_err(Failure::input)?;
    let mut sections = strain_rate_sections(&study);
    let runs = simulated(args, &traces, &study)?;
    sections.extend(runs.iter().map(segment_run_section));
    let names = traces.iter().map(Trace::label).collect();
    let simulated = args.simulate.map(|_| &runs[..]);
    let json = || answers::json(&StrainRateAnswer::of(&study, simulated));
    args.result.give("Strain and strain rate", "", names, &sections, json)
}

/// The motion of each trace through segments, where that is asked for.
fn simulated(args: &Args, traces: &[Trace], study: &Study) -> Result<Vec<SegmentRun>, Failure> {
    let Some(segments) = args.simulate else { return Ok(Vec::new()) };
    let Some(order) = study.order else {
        return Err(Failure::Input(miette::miette!(
            "--simulate needs one order for all holds: give --order a number, or odd"
        )));
    };
    let run = |(trace, geometry): (&Trace, &Geometry)| {
        let setting = Setting {
            geometry: *geometry,
            faces: args.specimen.faces(),
            modulus_pa: args.modulus,
            segments: segments.into(),
            order,
            rate: f64::NAN,
        };
        segment_run(trace, &setting, args.rate).map_err(Failure::input)
    };
    traces.iter().zip(&study.geometry).map(run).collect()
}
