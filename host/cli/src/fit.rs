//! `palpate fit`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::ValueEnum;
use serde_json::Value;

use super::answer::{Answer, labels};
use super::output::Output;
use super::preparation::{Prepare, Prepared};
use super::{Failure, progress};
use palpate_diagnose::criticism::noise::noise_of;
use palpate_fit::choice::{Choice, Exponent};
use palpate_fit::data::Data;
use palpate_fit::hold::{self, HoldError, HoldFit};
use palpate_fit::least_squares::Stop;
use palpate_fit::ranking::{Ranking, rank};
use palpate_fit::warning::{Warning, warnings};
use palpate_fit::watch;
use palpate_fit::whole_motion::{self, MotionFit};
use palpate_fit::{elastic_law, hold::Terms};
use palpate_model::elastic::ELASTIC_LAWS;
use palpate_model::kernel::KERNELS;
use palpate_model::laws::FAMILIES;
use palpate_model::{
    BaseLaw, EXPONENTS_N, Elastic, ElasticLaw, Family, Gauge, Kernel, Laws, MAX_TERMS, Model,
    Separation,
};
use palpate_present::answers::{self, FitAnswer, HoldsAnswer, RankingAnswer};
use palpate_present::summary::{FitSummary, Preparation, Refit, hold_sections, ranking_sections};
use palpate_report::Section;
use palpate_trace::files::plan::MODEL;
use palpate_trace::meant::did_you_mean;
use palpate_trace::{FORCE, Noise, Trace, read_set};

/// Fit a contact model.
#[derive(clap::Args)]
#[command(
    override_usage = "palpate fit [OPTIONS] <LAW> <TRACE>...\n       palpate fit [OPTIONS] --all <TRACE>...",
    after_help = after_help()
)]
pub struct Args {
    /// The base law, then traces, or folders of traces
    #[arg(required = true, value_name = "LAW TRACE")]
    names: Vec<PathBuf>,
    #[command(flatten)]
    options: Options,
    /// Write the model
    #[arg(short, long, value_name = "MODEL.toml", conflicts_with = "all")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

const DATA_AND_EXAMPLES: &str = "\
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
  palpate fit fung traces/ --json | jq .parameters.v1";

/// The laws as they declare themselves, each with its small drawing, and what else a fit asks for.
fn after_help() -> String {
    let laws: String = FAMILIES.iter().map(|family| described(family)).collect();
    format!("Laws:\n{laws}\n{DATA_AND_EXAMPLES}")
}

/// What a law is, its formula, and its springs and dampers.
fn described(family: &Family) -> String {
    let Family { name, meaning, source, formula, .. } = family;
    let drawing: String = family.drawing.lines().map(|line| format!("      {line}\n")).collect();
    format!("  {name}: {meaning} ({source})\n      {formula}\n{drawing}")
}

/// What is to be fitted and how.
#[derive(clap::Args)]
pub struct Options {
    /// Fit every law, and rank them by their error on traces left out
    #[arg(long, conflicts_with_all = ["hold_only", "segments", "exponent", "elastic", "relaxation"])]
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
    #[arg(long, value_name = "LAW", default_value = ElasticLaw::POWER.name, value_parser = parse_elastic, conflicts_with = "hold_only")]
    elastic: &'static ElasticLaw,
    /// How fung relaxes: exponentials, power-law, stretched (exponential) or none
    #[arg(long, value_name = "KIND", default_value = "exponentials", value_parser = parse_kernel, conflicts_with = "hold_only")]
    relaxation: &'static Kernel,
    /// What happens where contact breaks
    #[arg(long, value_enum, default_value = "clamp", conflicts_with = "hold_only")]
    separation: SeparationArg,
    /// The column to fit
    #[arg(long, default_value = FORCE, value_name = "COLUMN")]
    signal: String,
    #[command(flatten)]
    prepare: Prepare,
}

#[derive(Clone, Copy, ValueEnum)]
enum SeparationArg {
    /// The integral runs over the commanded motion; the force is its positive part
    Clamp,
    /// The parted surface recovers by itself until the indenter meets it
    Free,
    /// The specimen is glued or clamped: it may be moved to either side, and the force may turn to tension
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

fn parse_elastic(text: &str) -> Result<&'static ElasticLaw, String> {
    let known: Vec<&str> = ELASTIC_LAWS.iter().map(|law| law.name).collect();
    Laws::library().elastic_law(text).ok_or_else(|| format!("give {}", known.join(", ")))
}

fn parse_kernel(text: &str) -> Result<&'static Kernel, String> {
    let known: Vec<&str> = KERNELS.iter().map(|kernel| kernel.name).collect();
    Laws::library().kernel(text).ok_or_else(|| format!("give one of {}", known.join(", ")))
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let options = &args.options;
    let (law, traces) = match args.names.split_first() {
        Some((law, traces)) if !options.all => (Some(law.to_string_lossy()), traces),
        _ => (None, &args.names[..]),
    };
    let mut files = args.result.files(traces)?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    // What cannot be is said before a trace is read.
    options.family(law.as_deref())?;
    if traces.is_empty() {
        return Err(wrong("name traces, or folders of traces, after the law"));
    }
    let traces = Arc::new(read_set(traces).map_err(Failure::input)?);
    let found = ask(options, law.as_deref(), traces)?;
    if let Some(path) = &args.output
        && let Some(model) = found.model()?
    {
        model.write(path).map_err(Failure::work)?;
    }
    args.result.show(&*found)
}

/// Fits a law, or with `all` every law, to traces in memory.
pub fn ask(
    options: &Options,
    law: Option<&str>,
    traces: Arc<Vec<Trace>>,
) -> Result<Box<dyn Answer>, Failure> {
    let family = options.family(law)?;
    let prepared = options.prepare.take(traces, &options.signal)?;
    let Some(family) = family else { return ranked(options, prepared) };
    let law = options.elastic;
    let gauge = law.needs_gauge().then(|| Gauge::of(&prepared.0));
    let elastic = Elastic { law, gauge: gauge.transpose().map_err(Failure::input)? };
    let laws = options.choice(family, elastic).laws().map_err(Failure::input)?;
    if options.hold_only { holds(options, prepared) } else { whole(options, &laws, prepared) }
}

fn wrong(problem: &str) -> Failure {
    Failure::Input(miette::miette!("{problem}"))
}

fn family(name: &str) -> Result<&'static Family, Failure> {
    let laws = Laws::library();
    laws.family(name).ok_or_else(|| {
        let (known, meant) = (laws.names(), did_you_mean(name, laws.names()));
        wrong(&format!("no law `{name}`{meant}; known: {}", known.join(", ")))
    })
}

impl Options {
    /// The family of that name, none where all are meant, if it has the options.
    pub(super) fn family(&self, law: Option<&str>) -> Result<Option<&'static Family>, Failure> {
        let Some(name) = law else { return Ok(None) };
        let family = family(name)?;
        if self.hold_only && family != Family::FUNG {
            let name = family.name;
            let problem = format!("--hold-only fits eq. 3.4, which is `fung`, not `{name}`");
            return Err(wrong(&problem));
        }
        self.choice(family, Elastic::POWER).laws().map_err(Failure::input)?;
        Ok(Some(family))
    }

    fn separation(&self) -> Separation {
        match self.separation {
            SeparationArg::Clamp => Separation::Clamp,
            SeparationArg::Free => Separation::Free,
            SeparationArg::Bonded => Separation::Bonded,
        }
    }

    fn choice(&self, family: &'static Family, elastic: Elastic) -> Choice {
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

/// A fit over whole motions.
struct Fitted {
    traces: Arc<Vec<Trace>>,
    preparation: Preparation,
    signal: String,
    /// The fit of each law that was tried.
    candidates: Vec<MotionFit>,
    /// Which of them is best.
    best: usize,
    noise: Option<Noise>,
    held_out: Vec<f64>,
}

fn whole(
    options: &Options,
    laws: &[BaseLaw],
    (traces, mut preparation): Prepared,
) -> Result<Box<dyn Answer>, Failure> {
    let signal = &options.signal;
    let data = Data::of(&traces, signal).map_err(Failure::input)?;
    let data = data.with_separation(options.separation());
    let mut candidates = candidates(laws, &data)?;
    let (index, best) = candidates
        .iter()
        .enumerate()
        .min_by(|(_, a), (_, b)| a.bic().total_cmp(&b.bic()))
        .ok_or_else(|| Failure::Work(miette::miette!("no law was tried")))?;
    let held_out = match traces.len() {
        1 => Vec::new(),
        _ => progress::watched("leaving out each trace in turn", || {
            whole_motion::held_out(best, &data)
        })?,
    };
    if best.stop == Stop::NoBetter {
        return Err(wrong(&no_better(best, &data, signal)));
    }
    if !preparation.outliers.is_empty() && !preparation.dropped {
        preparation.refit = Refit::of(best, &traces, signal);
    }
    let noise = noise_of(&data, &traces);
    let deviation = noise.map(|noise| noise.standard_deviation);
    candidates[index] = candidates[index].clone().allowing_for_misfit(&data, deviation);
    let signal = signal.clone();
    let traces = traces.clone();
    Ok(Box::new(Fitted { traces, preparation, signal, candidates, best: index, noise, held_out }))
}

/// Why a search that found nothing better than it began with is no fit.
fn no_better(best: &MotionFit, data: &Data, signal: &str) -> String {
    let resting = || {
        let found = warnings(best, data, None);
        found.iter().find(|it| matches!(it, Warning::Resting { .. })).map(|it| format!(": {it}"))
    };
    let why = data.outlier().or_else(resting).unwrap_or_else(|| {
        let r_squared = best.r_squared;
        format!(
            ": R² is {r_squared:.3}. Look at the recording (palpate plot): is {signal} zero off the specimen, and its sign right?"
        )
    });
    format!("{}, and no model is written{why}", best.stop)
}

impl Fitted {
    fn fit(&self) -> &MotionFit {
        &self.candidates[self.best]
    }

    fn with<T>(&self, tell: impl FnOnce(&FitSummary) -> T) -> T {
        let data = Data::of(&self.traces, &self.signal).expect("these traces were fitted");
        let data = data.with_separation(self.fit().chain.base.separation);
        tell(&FitSummary {
            fit: self.fit(),
            data: &data,
            signal: &self.signal,
            noise: self.noise,
            held_out: &self.held_out,
            candidates: &self.candidates,
        })
    }
}

impl Answer for Fitted {
    fn title(&self) -> &'static str {
        "A fit over whole motions"
    }

    fn subtitle(&self) -> String {
        self.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        self.with(|summary| answers::json(&self.preparation.with(FitAnswer::from(summary))))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(self.with(|summary| self.preparation.before(summary.sections())))
    }

    fn model(&self) -> Result<Option<Model>, Failure> {
        Ok(self.with(|summary| Some(summary.model())))
    }

    fn failed(&self) -> Option<String> {
        let stop = &self.fit().stop;
        (!stop.converged()).then(|| stop.to_string())
    }
}

/// The fit of each law.
fn candidates(laws: &[BaseLaw], data: &Data) -> Result<Vec<MotionFit>, Failure> {
    let wait = progress::bar(laws.len(), "fitting");
    watch::stage("laws fitted", laws.len());
    let fits = laws
        .iter()
        .map(|&law| {
            let fit = whole_motion::fit(law, data);
            watch::done();
            wait.inc(1);
            fit
        })
        .collect::<Result<Vec<_>, _>>();
    wait.finish_and_clear();
    fits.map_err(Failure::input)
}

/// Every law, ranked.
struct Ranked {
    traces: Arc<Vec<Trace>>,
    preparation: Preparation,
    signal: String,
    ranking: Ranking,
}

fn ranked(options: &Options, (traces, preparation): Prepared) -> Result<Box<dyn Answer>, Failure> {
    let terms = match options.terms {
        Terms::Fixed(terms) => terms,
        Terms::Auto => {
            let problem = "--all compares laws of one number of exponentials: give it with --terms";
            return Err(wrong(problem));
        }
    };
    let signal = options.signal.clone();
    let ranking = progress::watched("fitting every law, leaving out each trace in turn", || {
        rank(&Laws::library(), &traces, &signal, terms, options.separation())
    })?;
    let mut ranking = ranking.map_err(Failure::input)?;
    if let Ok(data) = Data::of(&traces, &signal) {
        ranking.noise = noise_of(&data.with_separation(options.separation()), &traces);
    }
    Ok(Box::new(Ranked { traces, preparation, signal, ranking }))
}

impl Answer for Ranked {
    fn title(&self) -> &'static str {
        "Laws ranked"
    }

    fn subtitle(&self) -> String {
        self.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        answers::json(&self.preparation.with(RankingAnswer::of(&self.ranking, &self.signal)))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(self.preparation.before(ranking_sections(&self.ranking, &self.signal)))
    }
}

/// Eq. 3.4 for each hold.
struct Holds {
    traces: Arc<Vec<Trace>>,
    preparation: Preparation,
    signal: String,
    fits: Vec<HoldFit>,
    left_out: Vec<HoldError>,
}

fn holds(options: &Options, (traces, preparation): Prepared) -> Result<Box<dyn Answer>, Failure> {
    let wait = progress::bar(traces.len(), "fitting holds");
    let (mut fits, mut left_out) = (Vec::<HoldFit>::new(), Vec::new());
    for trace in &*traces {
        let found = hold::fit_holds(trace, &options.signal, options.terms, options.signs);
        let found = found.map_err(Failure::input)?;
        fits.extend(found.holds);
        left_out.extend(found.left_out);
        wait.inc(1);
    }
    wait.finish_and_clear();
    let signal = options.signal.clone();
    Ok(Box::new(Holds { traces, preparation, signal, fits, left_out }))
}

impl Answer for Holds {
    fn title(&self) -> &'static str {
        "Relaxation during holds"
    }

    fn subtitle(&self) -> String {
        self.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        let answer = HoldsAnswer::of(&self.fits, &self.left_out, &self.signal);
        answers::json(&self.preparation.with(answer))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        let Self { fits, left_out, traces, signal, .. } = self;
        Ok(self.preparation.before(hold_sections(fits, left_out, traces, signal)))
    }

    fn model(&self) -> Result<Option<Model>, Failure> {
        elastic_law::model_of_holds(&self.fits, &self.signal).map(Some).map_err(Failure::input)
    }
}
