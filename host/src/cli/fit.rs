//! `palpate fit`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::output::{Output, print_json, print_sections, write_report};
use super::{Failure, progress};
use crate::fit::data::Data;
use crate::fit::hold::{self, HoldFit};
use crate::fit::whole_motion::{self, MotionFit};
use crate::fit::{elastic_law, hold::Terms};
use crate::model::{Fung, MAX_TERMS, Model, Separation};
use crate::summary::{FitSummary, hold_json, hold_sections};
use crate::trace::{FORCE, Trace, pooled_noise, read_set};

/// Fit a contact model.
#[derive(clap::Args)]
#[command(after_help = "\
The traces named are one data set: one specimen in one set-up. All are fitted together; what the
specimen still remembers from one trace to the next is carried over where the heads say when each
began (`start_s`).

Examples:
  palpate fit fung traces/                         load, hold and unload of every trace together
  palpate fit fung traces/ -o model.toml           ... and keep the model
  palpate fit fung traces/ --terms auto            let the data choose the number of exponentials
  palpate fit fung take-*.csv --hold-only          eq. 3.4 for each hold, and their spread
  palpate fit fung step.csv --hold-only --signal relaxation_modulus_Pa
  palpate fit fung traces/ --json | jq .parameters.v1")]
pub struct Args {
    /// The base law
    #[arg(value_enum)]
    law: Law,
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Fit each hold by itself with eq. 3.4, not the whole motion
    #[arg(long)]
    hold_only: bool,
    /// Number of exponentials: 1 to 4, or auto
    #[arg(long, default_value = "2", value_parser = parse_terms)]
    terms: Terms,
    /// With --hold-only: let no share ci have the wrong sign for its type, nor c0 be negative
    #[arg(long, requires = "hold_only")]
    signs: bool,
    /// What happens where contact breaks
    #[arg(long, value_enum, default_value = "clamp", conflicts_with = "hold_only")]
    separation: SeparationArg,
    /// The column to fit
    #[arg(long, default_value = FORCE, value_name = "COLUMN")]
    signal: String,
    /// Write the model
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

#[derive(Clone, Copy, ValueEnum)]
enum Law {
    /// Quasi-linear: power-law elastic response, sum of exponentials (eqs 2.1, 3.2, 3.3)
    Fung,
}

#[derive(Clone, Copy, ValueEnum)]
enum SeparationArg {
    /// The integral runs over the commanded motion; the force is its positive part
    Clamp,
    /// The parted surface recovers by itself until the indenter meets it
    Free,
    /// The specimen is glued or clamped: the force may turn to tension
    Bonded,
}

/// Reads a number of exponentials.
pub(super) fn parse_terms(text: &str) -> Result<Terms, String> {
    match text.parse() {
        Ok(terms) if (1..=MAX_TERMS).contains(&terms) => Ok(Terms::Fixed(terms)),
        _ if text == "auto" => Ok(Terms::Auto),
        _ => Err(format!("give a number from 1 to {MAX_TERMS}, or auto")),
    }
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let Law::Fung = args.law;
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    if args.hold_only { holds(args, &traces) } else { whole(args, &traces) }
}

fn whole(args: &Args, traces: &[Trace]) -> Result<(), Failure> {
    let data = Data::of(traces, &args.signal).map_err(Failure::input)?;
    let separation = match args.separation {
        SeparationArg::Clamp => Separation::Clamp,
        SeparationArg::Free => Separation::Free,
        SeparationArg::Bonded => Separation::Bonded,
    };
    let candidates = candidates(args.terms, separation, &data)?;
    let best = candidates
        .iter()
        .min_by(|a, b| a.bic().total_cmp(&b.bic()))
        .ok_or_else(|| Failure::Work(miette::miette!("no number of exponentials was tried")))?;
    let wait = progress::spinner("leaving out each trace in turn");
    let held_out = if traces.len() > 1 { whole_motion::held_out(best, &data) } else { Vec::new() };
    wait.finish_and_clear();
    let summary = FitSummary {
        fit: best,
        data: &data,
        signal: &args.signal,
        noise: pooled_noise(traces, &args.signal),
        held_out: &held_out,
        candidates: &candidates,
    };
    if let Some(path) = &args.output {
        summary.model().write(path).map_err(Failure::work)?;
    }
    if let Some(path) = &args.result.report {
        write_report(
            path,
            "A fit over whole motions",
            &args.signal,
            names(traces),
            summary.sections(),
        )?;
    }
    if args.result.json {
        print_json(&summary.json())?;
    } else {
        print_sections(&summary.sections())?;
    }
    if best.stop.converged() {
        Ok(())
    } else {
        Err(Failure::Work(miette::miette!("{}", best.stop)))
    }
}

/// The fit with the number of exponentials asked for, or with each number.
fn candidates(
    terms: Terms,
    separation: Separation,
    data: &Data,
) -> Result<Vec<MotionFit>, Failure> {
    let numbers = match terms {
        Terms::Fixed(terms) => terms..=terms,
        Terms::Auto => 1..=MAX_TERMS,
    };
    let wait = progress::bar(numbers.clone().count(), "fitting");
    let fits = numbers
        .map(|terms| {
            let fit = whole_motion::fit(Fung { terms, separation }, data);
            wait.inc(1);
            fit
        })
        .collect::<Result<Vec<_>, _>>();
    wait.finish_and_clear();
    fits.map_err(Failure::input)
}

fn holds(args: &Args, traces: &[Trace]) -> Result<(), Failure> {
    let wait = progress::bar(traces.len(), "fitting holds");
    let mut fits: Vec<HoldFit> = Vec::new();
    for trace in traces {
        let found = hold::fit_holds(trace, &args.signal, args.terms, args.signs);
        fits.extend(found.map_err(Failure::input)?);
        wait.inc(1);
    }
    wait.finish_and_clear();
    if let Some(path) = &args.output {
        model_of_holds(&fits, &args.signal)?.write(path).map_err(Failure::work)?;
    }
    let sections = hold_sections(&fits, traces, &args.signal);
    if let Some(path) = &args.result.report {
        write_report(
            path,
            "Relaxation during holds",
            &args.signal,
            names(traces),
            sections.clone(),
        )?;
    }
    if args.result.json {
        print_json(&hold_json(&fits, &args.signal))
    } else {
        print_sections(&sections)
    }
}

fn model_of_holds(fits: &[HoldFit], signal: &str) -> Result<Model, Failure> {
    elastic_law::model_of_holds(fits, signal).map_err(Failure::input)
}

fn names(traces: &[Trace]) -> Vec<String> {
    traces.iter().map(Trace::label).collect()
}
