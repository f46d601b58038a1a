//! `palpate rates`.

use std::path::PathBuf;

use super::Failure;
use super::output::Output;
use super::specimen::SpecimenArgs;
use palpate_analysis::rates::rates;
use palpate_present::answers::{self, RatesAnswer};
use palpate_present::summary::rates_sections;
use palpate_trace::{Trace, read_set};

/// One specimen at several loading rates: stiffness, surface strain, asymptotes, stiffening.
#[derive(clap::Args)]
#[command(after_help = "\
Chapter 5: the nominal area of contact with the Poisson effect, specific stiffness from the asymptotic
force, strain of the surface and latent strain rate, whether the asymptotes agree over the rates, and
how much the peak force grows with the rate. The traces are runs of one specimen; each loading that is
followed by a hold counts.

Examples:
  palpate rates 20mms.csv 60mms.csv 100mms.csv
  palpate rates runs/ --shape cylinder --radius 25 --height 30 --poisson 0.48
  palpate rates runs/ --report rates.html
  palpate rates runs/ --json | jq '.groups[].asymptotes_agree_p_value'")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Exponentials fitted to each hold; (5.3) has one
    #[arg(long, default_value = "1", value_parser = clap::value_parser!(u8).range(1..=4))]
    terms: u8,
    #[command(flatten)]
    specimen: SpecimenArgs,
    #[command(flatten)]
    result: Output,
}

/// Compares and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.traces)?;
    let mut traces = read_set(&args.traces).map_err(Failure::input)?;
    args.specimen.apply(&mut traces);
    let study =
        rates(&traces, usize::from(args.terms), args.specimen.faces()).map_err(Failure::input)?;
    let sections = rates_sections(&study, &traces);
    let names = traces.iter().map(Trace::label).collect();
    let json = || answers::json(&RatesAnswer::from(&study));
    args.result.give("Loading rates", "", names, &sections, json)
}
