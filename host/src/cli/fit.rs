//! `palpate fit`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::output::Output;
use super::preparation::Prepare;
use super::{Failure, progress};
use crate::criticism::noise::noise_of;
use crate::files::plan::MODEL;
use crate::fit::choice::{Choice, Exponent};
use crate::fit::data::Data;
use crate::fit::hold::{self, HoldFit};
use crate::fit::least_squares::Stop;
use crate::fit::ranking::rank;
use crate::fit::warning::{Warning, warnings};
use crate::fit::whole_motion::{self, MotionFit};
use crate::fit::{elastic_law, hold::Terms};
use crate::meant::did_you_mean;
use crate::model::{
    BaseLaw, EXPONENTS_N, Elastic, Family, Gauge, Hyperelastic, Kernel, MAX_TERMS, Model, POWER,
    Separation,
};
use crate::summary::{
    FitSummary, Preparation, Refit, hold_json, hold_sections, ranking_json, ranking_sections,
};
use crate::trace::{FORCE, Trace};

/// Fit a contact model.
#[derive(clap::Args)]
#[command(
    override_usage = "palpate fit [OPTIONS] <LAW> <TRACE>...\n       palpate fit [OPTIONS] --all <TRACE>...",
    after_help = "\
Laws:
  kelvin-voigt         spring and damper side by side (eq. 2.3)
  maxwell              spring and damper in a row (eq. 2.4)
  generalized-maxwell  a spring beside --terms springs with dampers (2.2)
  fung                 quasi-linear: power-law elastic response, exponentials (eqs 2.1, 3.2, 3.3)
  latency              linear latency model (eqs 4.1 to 4.11); c0 free, or 1/m with --segments m
  latency-power        nonlinear latency model (eqs 7.2, 7.11); n free, given, or auto
  creep                what settles late (eqs 6.1, 6.2), solved for the force

The traces named are one data set: one specimen in one set-up. All are fitted together; what the
specimen still remembers from one trace to the next is carried over where the heads say when each
began (`start_s`).

`fung` takes another relaxation than exponentials (--relaxation), and all but the linear laws another
elastic response than the power law (--elastic): for rubber at large strain, with the gauge length
(height_mm) and mode (tension, compression, shear) in the head of every trace.

Examples:
  palpate fit fung traces/                         load, hold and unload of every trace together
  palpate fit fung traces/ -o model.toml           ... and keep the model
  palpate fit fung traces/ --terms auto            let the data choose the number of exponentials
  palpate fit latency-power traces/ --exponent auto
  palpate fit fung traces/ --relaxation power-law  a springpot beside a spring
  palpate fit fung pulls/ --elastic gent --relaxation stretched --separation bonded
  palpate fit --all traces/                        every law, ranked on traces left out
  palpate fit fung take-*.csv --hold-only          eq. 3.4 for each hold, and their spread
  palpate fit fung step.csv --hold-only --signal relaxation_modulus_Pa
  palpate fit fung traces/ --json | jq .parameters.v1"
)]
pub struct Args {
    /// The base law, then traces, or folders of traces
    #[arg(required = true, value_name = "LAW TRACE")]
    names: Vec<PathBuf>,
    /// Fit every law, and rank them by their error on traces left out
    #[arg(long, conflicts_with_all = ["hold_only", "output", "segments", "exponent", "elastic", "relaxation"])]
    all: bool,
    /// Fit each hold by itself with eq. 3.4, not the whole motion
    #[arg(long)]
    hold_only: bool,
    /// Number of exponentials or branches: 1 to 4, or auto
    #[arg(long, default_value = "2", value_parser = parse_terms)]
    terms: Terms,
    /// With --hold-only: let no share ci have the wrong sign for its type, nor c0 be negative
    #[arg(long, requires = "hold_only")]
    signs: bool,
    /// Of a latency model: number m of segments, so that c0 = 1/m
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(2..), conflicts_with = "hold_only")]
    segments: Option<u32>,
    /// Of latency-power: the exponent n, 1 to 9, or auto for the lowest of 1, 3, 5, 7, 9 that fits best
    #[arg(long, value_name = "N", value_parser = parse_exponent, conflicts_with = "hold_only")]
    exponent: Option<Exponent>,
    /// Elastic response: power (of the compression), neo-hooke, mooney-rivlin, ogden or gent
    #[arg(long, value_name = "LAW", default_value = POWER, value_parser = parse_elastic, conflicts_with = "hold_only")]
    elastic: ElasticArg,
    /// How fung relaxes: exponentials, power-law, stretched (exponential) or none
    #[arg(long, value_name = "KIND", default_value = "exponentials", value_parser = parse_kernel, conflicts_with = "hold_only")]
    relaxation: Kernel,
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
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// A law of the stretch; none for the power law.
type ElasticArg = Option<Hyperelastic>;

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

fn parse_exponent(text: &str) -> Result<Exponent, String> {
    let (lower, upper) = EXPONENTS_N;
    match text.parse() {
        Ok(n) if (lower..=upper).contains(&n) => Ok(Exponent::Given(n)),
        _ if text == "auto" => Ok(Exponent::Auto),
        _ => Err(format!("give a number from {lower} to {upper}, or auto")),
    }
}

fn parse_elastic(text: &str) -> Result<ElasticArg, String> {
    if text == POWER {
        return Ok(None);
    }
    let known = || Hyperelastic::ALL.map(Hyperelastic::name).join(", ");
    Hyperelastic::named(text).map(Some).ok_or_else(|| format!("give {POWER}, {}", known()))
}

fn parse_kernel(text: &str) -> Result<Kernel, String> {
    let known = || Kernel::ALL.map(Kernel::name).join(", ");
    Kernel::named(text).ok_or_else(|| format!("give one of {}", known()))
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let traces = if args.all { &args.names[..] } else { &args.names[1..] };
    let mut files = args.result.files(traces)?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    if args.all {
        let (traces, preparation) = args.prepare.read(&args.names, &args.signal)?;
        return all(args, &traces, &preparation);
    }
    let family = family(&args.names[0])?;
    let wrong = |problem: String| Err(Failure::Input(miette::miette!("{problem}")));
    if traces.is_empty() {
        return wrong("name traces, or folders of traces, after the law".into());
    }
    if args.hold_only && family != Family::Fung {
        return wrong(format!(
            "--hold-only fits eq. 3.4, which is `fung`, not `{}`",
            family.name()
        ));
    }
    // What cannot be is said before a trace is read.
    args.choice(family, Elastic::Power).laws().map_err(Failure::input)?;
    let (traces, preparation) = args.prepare.read(traces, &args.signal)?;
    let elastic = match args.elastic {
        None => Elastic::Power,
        Some(law) => Elastic::Stretch(law, Gauge::of(&traces).map_err(Failure::input)?),
    };
    let laws = args.choice(family, elastic).laws().map_err(Failure::input)?;
    if args.hold_only {
        holds(args, &traces, &preparation)
    } else {
        whole(args, &laws, &traces, preparation)
    }
}

fn family(name: &Path) -> Result<Family, Failure> {
    let known = || Family::ALL.map(Family::name).join(", ");
    name.to_str().and_then(Family::named).ok_or_else(|| {
        let meant = did_you_mean(&name.to_string_lossy(), Family::ALL.map(Family::name));
        Failure::Input(miette::miette!("no law `{}`{meant}; known: {}", name.display(), known()))
    })
}

impl Args {
    fn separation(&self) -> Separation {
        match self.separation {
            SeparationArg::Clamp => Separation::Clamp,
            SeparationArg::Free => Separation::Free,
            SeparationArg::Bonded => Separation::Bonded,
        }
    }

    fn choice(&self, family: Family, elastic: Elastic) -> Choice {
        Choice {
            family,
            terms: self.terms,
            separation: self.separation(),
            segments: self.segments,
            exponent: self.exponent,
            elastic,
            kernel: self.relaxation,
        }
    }
}

fn whole(
    args: &Args,
    laws: &[BaseLaw],
    traces: &[Trace],
    mut preparation: Preparation,
) -> Result<(), Failure> {
    let data = Data::of(traces, &args.signal).map_err(Failure::input)?;
    let candidates = candidates(laws, &data)?;
    let best = candidates
        .iter()
        .min_by(|a, b| a.bic().total_cmp(&b.bic()))
        .ok_or_else(|| Failure::Work(miette::miette!("no law was tried")))?;
    let held_out = match traces.len() {
        1 => Vec::new(),
        _ => progress::watched("leaving out each trace in turn", || {
            whole_motion::held_out(best, &data)
        })?,
    };
    let summary = FitSummary {
        fit: best,
        data: &data,
        signal: &args.signal,
        noise: noise_of(&data, traces),
        held_out: &held_out,
        candidates: &candidates,
    };
    if best.stop == Stop::NoBetter {
        let resting = || {
            let found = warnings(best, &data, None);
            found
                .iter()
                .find(|it| matches!(it, Warning::Resting { .. }))
                .map(|it| format!(": {it}"))
        };
        let why = data.outlier().or_else(resting).unwrap_or_else(|| {
            let r_squared = best.r_squared;
            format!(
                ": R² is {r_squared:.3}. Look at the recording (palpate plot): is {} zero off the specimen, and its sign right?",
                args.signal
            )
        });
        return Err(Failure::Input(miette::miette!("{}, and no model is written{why}", best.stop)));
    }
    if let Some(path) = &args.output {
        summary.model().write(path).map_err(Failure::work)?;
    }
    if !preparation.outliers.is_empty() && !preparation.dropped {
        preparation.refit = Refit::of(best, traces, &args.signal);
    }
    let title = "A fit over whole motions";
    let sections = preparation.before(summary.sections());
    let json = || preparation.within(summary.json());
    args.result.give(title, &args.signal, names(traces), &sections, json)?;
    if best.stop.converged() {
        Ok(())
    } else {
        Err(Failure::Work(miette::miette!("{}", best.stop)))
    }
}

/// The fit of each law.
fn candidates(laws: &[BaseLaw], data: &Data) -> Result<Vec<MotionFit>, Failure> {
    let wait = progress::bar(laws.len(), "fitting");
    let fits = laws
        .iter()
        .map(|&law| {
            let fit = whole_motion::fit(law, data);
            wait.inc(1);
            fit
        })
        .collect::<Result<Vec<_>, _>>();
    wait.finish_and_clear();
    fits.map_err(Failure::input)
}

/// Every law, ranked.
fn all(args: &Args, traces: &[Trace], preparation: &Preparation) -> Result<(), Failure> {
    let terms = match args.terms {
        Terms::Fixed(terms) => terms,
        Terms::Auto => {
            let problem = "--all compares laws of one number of exponentials: give it with --terms";
            return Err(Failure::Input(miette::miette!(problem)));
        }
    };
    let ranking = progress::watched("fitting every law, leaving out each trace in turn", || {
        rank(traces, &args.signal, terms, args.separation())
    })?;
    let mut ranking = ranking.map_err(Failure::input)?;
    if let Ok(data) = Data::of(traces, &args.signal) {
        ranking.noise = noise_of(&data, traces);
    }
    let sections = preparation.before(ranking_sections(&ranking, &args.signal));
    let json = || preparation.within(ranking_json(&ranking, &args.signal));
    args.result.give("Laws ranked", &args.signal, names(traces), &sections, json)
}

fn holds(args: &Args, traces: &[Trace], preparation: &Preparation) -> Result<(), Failure> {
    let wait = progress::bar(traces.len(), "fitting holds");
    let (mut fits, mut left_out) = (Vec::<HoldFit>::new(), Vec::new());
    for trace in traces {
        let found = hold::fit_holds(trace, &args.signal, args.terms, args.signs);
        let found = found.map_err(Failure::input)?;
        fits.extend(found.holds);
        left_out.extend(found.left_out);
        wait.inc(1);
    }
    wait.finish_and_clear();
    if let Some(path) = &args.output {
        model_of_holds(&fits, &args.signal)?.write(path).map_err(Failure::work)?;
    }
    let sections = preparation.before(hold_sections(&fits, &left_out, traces, &args.signal));
    let json = || preparation.within(hold_json(&fits, &left_out, &args.signal));
    args.result.give("Relaxation during holds", &args.signal, names(traces), &sections, json)
}

fn model_of_holds(fits: &[HoldFit], signal: &str) -> Result<Model, Failure> {
    elastic_law::model_of_holds(fits, signal).map_err(Failure::input)
}

fn names(traces: &[Trace]) -> Vec<String> {
    traces.iter().map(Trace::label).collect()
}
