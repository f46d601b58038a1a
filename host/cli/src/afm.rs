//! `palpate afm`.

use std::path::PathBuf;

use clap::{Subcommand, ValueEnum};
use miette::miette;

use super::convert::Form;
use super::output::{Force, Output, print_json, print_sections, write_report};
use super::{Failure, progress};
use palpate_contact::afm::curve::ForceCurve;
use palpate_contact::afm::fit::{Options, fit};
use palpate_contact::afm::rough::{Rough, Spreads};
use palpate_contact::afm::simulate::Practice;
use palpate_contact::grasp::PressureLaw;
use palpate_contact::{Elastic, Tip};
use palpate_model::Relaxation;
use palpate_present::answers::{self, AfmAnswer, AfmRoughAnswer};
use palpate_present::summary::{FittedCurve, afm_sections, rough_sections};
use palpate_trace::files::plan::{COMPUTED_OR_RECORDING, Plan};

/// Force curves of a tip: modulus, contact point, adhesion, relaxation.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "\
A curve is a file of JPK (.jpk-force, a map, or its text export), of Nanosurf (.nid) or of NanoScope (.spm, .000),
all but the text with the feature `formats`; or a trace with displacement_mm (the piezo's way towards the specimen)
and force_N, whose spring constant stands in its head ([setup] spring_constant_N_per_m) or is given. Without one, the
displacement is that of the tip. Of a map every curve is fitted.

Examples:
  palpate afm curve.txt --tip-radius-nm 2500                   a ball, as a paraboloid
  palpate afm curves/*.csv --tip-radius-nm 2500 --shape sphere --spring 0.05
  palpate afm curve.txt --shape cone --half-angle-deg 20
  palpate afm curve.csv --tip-radius-nm 2500 --pressure-exponent 4
  palpate afm simulate --modulus-kpa 5 -o practice.csv         a curve with a known answer
  palpate afm rough --rms-nm 50                                what roughness does to the answer"
)]
pub struct Args {
    #[command(subcommand)]
    other: Option<Other>,
    #[command(flatten)]
    curves: CurveArgs,
}

#[derive(Subcommand)]
enum Other {
    /// What a rough surface does to modulus and contact point, by Monte Carlo
    Rough(RoughArgs),
    /// Make a practice curve of a known specimen
    Simulate(SimulateArgs),
}

#[derive(clap::Args)]
struct CurveArgs {
    /// Force curves
    #[arg(required = true, value_name = "CURVE")]
    curves: Vec<PathBuf>,
    #[command(flatten)]
    tip: TipArgs,
    /// Poisson's ratio of the specimen
    #[arg(long, default_value_t = 0.5, value_name = "RATIO")]
    poisson: f64,
    /// Spring constant, N/m, in place of the file's
    #[arg(long, value_name = "N/M")]
    spring: Option<f64>,
    /// Exponent k of the pressure (8.1), 1 to inf; 2 is Hertz
    #[arg(long, default_value_t = 2.0, value_name = "K")]
    pressure_exponent: f64,
    #[command(flatten)]
    result: Output,
}

#[derive(clap::Args)]
struct TipArgs {
    /// Shape of the tip
    #[arg(long, value_enum, default_value = "paraboloid")]
    shape: Shape,
    /// Radius of a round tip, nm
    #[arg(long, value_name = "NM")]
    tip_radius_nm: Option<f64>,
    /// Half angle of a cone, degrees
    #[arg(long, value_name = "DEGREES")]
    half_angle_deg: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Shape {
    /// A round tip at depths small beside its radius: Hertz's law
    Paraboloid,
    /// A ball at any depth
    Sphere,
    /// A cone
    Cone,
}

#[derive(clap::Args)]
struct RoughArgs {
    /// Radius of the tip, nm
    #[arg(long, default_value_t = 2500.0, value_name = "NM")]
    tip_radius_nm: f64,
    /// Depth of a smooth specimen's curve, nm
    #[arg(long, default_value_t = 500.0, value_name = "NM")]
    depth_nm: f64,
    /// Standard deviation of the heights, nm
    #[arg(long, default_value_t = 50.0, value_name = "NM")]
    rms_nm: f64,
    /// Asperities per square micrometre
    #[arg(long, default_value_t = 40.0, value_name = "NUMBER")]
    per_um2: f64,
    /// Radius of an asperity, nm
    #[arg(long, default_value_t = 100.0, value_name = "NM")]
    asperity_nm: f64,
    /// Modulus of the specimen, kPa; the ratios do not depend on it
    #[arg(long, default_value_t = 5.0, value_name = "KPA")]
    modulus_kpa: f64,
    /// Poisson's ratio of the specimen
    #[arg(long, default_value_t = 0.5, value_name = "RATIO")]
    poisson: f64,
    /// Places to try
    #[arg(long, default_value_t = 1000)]
    trials: usize,
    /// Seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    result: Output,
}

#[derive(clap::Args)]
struct SimulateArgs {
    /// Modulus, kPa
    #[arg(long, default_value_t = 5.0, value_name = "KPA")]
    modulus_kpa: f64,
    /// Poisson's ratio
    #[arg(long, default_value_t = 0.5, value_name = "RATIO")]
    poisson: f64,
    #[command(flatten)]
    tip: TipArgs,
    /// Spring constant, N/m
    #[arg(long, default_value_t = 0.05, value_name = "N/M")]
    spring: f64,
    /// How far the piezo goes beyond the touch, nm
    #[arg(long, default_value_t = 1000.0, value_name = "NM")]
    beyond_nm: f64,
    /// Pull of adhesion, pN
    #[arg(long, default_value_t = 0.0, value_name = "PN")]
    pull_pn: f64,
    /// How long it stays on the specimen, s
    #[arg(long, default_value_t = 0.0, value_name = "S")]
    hold: f64,
    /// Shares and rates (1/s) of its relaxation: c1,v1 or c1,v1,c2,v2
    #[arg(long, value_name = "C,V", value_delimiter = ',')]
    relaxation: Vec<f64>,
    /// Standard deviation of the noise, pN
    #[arg(long, default_value_t = 20.0, value_name = "PN")]
    noise_pn: f64,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The curve to write: .csv or .parquet
    #[arg(short, long, value_name = "CURVE")]
    output: PathBuf,
    #[command(flatten)]
    over: Force,
}

impl TipArgs {
    fn tip(&self, default_radius_nm: Option<f64>) -> Result<Tip, Failure> {
        let radius_m = || {
            let nm = self.tip_radius_nm.or(default_radius_nm);
            nm.map(|nm| nm * 1e-9).ok_or_else(|| {
                Failure::Input(miette!("how round is the tip? Give --tip-radius-nm."))
            })
        };
        let unused = match self.shape {
            Shape::Cone => self.tip_radius_nm.map(|_| "--tip-radius-nm"),
            _ => self.half_angle_deg.map(|_| "--half-angle-deg"),
        };
        if let Some(option) = unused {
            return Err(Failure::Input(miette!("{option} does not go with this --shape.")));
        }
        match self.shape {
            Shape::Paraboloid => Ok(Tip::Paraboloid { radius_m: radius_m()? }),
            Shape::Sphere => Ok(Tip::Sphere { radius_m: radius_m()? }),
            Shape::Cone => {
                let degrees = self.half_angle_deg.ok_or_else(|| {
                    Failure::Input(miette!("how sharp is the cone? Give --half-angle-deg."))
                })?;
                Ok(Tip::Cone { half_angle_rad: degrees.to_radians() })
            }
        }
    }
}

/// Analyses, simulates, prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    match &args.other {
        None => analyse(&args.curves),
        Some(Other::Rough(args)) => rough(args),
        Some(Other::Simulate(args)) => simulate(args),
    }
}

fn analyse(args: &CurveArgs) -> Result<(), Failure> {
    args.result.files(&args.curves)?;
    let pressure = PressureLaw::new(args.pressure_exponent).map_err(Failure::input)?;
    let options = Options { tip: args.tip.tip(None)?, poisson_ratio: args.poisson, pressure };
    let mut curves = Vec::new();
    for path in &args.curves {
        let read = ForceCurve::read_all(path).map_err(Failure::input)?.into_iter();
        curves
            .extend(read.map(|curve| args.spring.into_iter().fold(curve, ForceCurve::with_spring)));
    }
    let wait = progress::bar(curves.len(), "fitting");
    let fitted = curves.into_iter().map(|curve| {
        let found = fit(&curve, &options);
        wait.inc(1);
        (curve, found)
    });
    let mut fitted: Vec<FittedCurve> = fitted.collect();
    wait.finish_and_clear();
    // One bad curve among many is told of; where there is nothing else it is an error.
    if fitted.iter().all(|(_, fit)| fit.is_err())
        && let Some((_, Err(error))) = fitted.pop()
    {
        return Err(Failure::input(error));
    }
    let sections = afm_sections(&fitted, &options);
    if args.result.json {
        print_json(&answers::json(&AfmAnswer::of(&fitted, &options)))?;
    } else {
        print_sections(&sections)?;
    }
    if let Some(path) = &args.result.report {
        let inputs = fitted.iter().map(|(curve, _)| curve.label.clone()).collect();
        write_report(path, "Force curves", "modulus, contact, adhesion", inputs, sections)?;
    }
    Ok(())
}

fn rough(args: &RoughArgs) -> Result<(), Failure> {
    args.result.files([""; 0])?;
    let rough = Rough {
        specimen: Elastic { modulus_pa: args.modulus_kpa * 1e3, poisson_ratio: args.poisson },
        radius_m: args.tip_radius_nm * 1e-9,
        depth_m: args.depth_nm * 1e-9,
        rms_m: args.rms_nm * 1e-9,
        density_per_m2: args.per_um2 * 1e12,
        asperity_m: args.asperity_nm * 1e-9,
        trials: args.trials,
    };
    eprintln!("seed: {}", args.seed);
    let trials = rough.run(args.seed).map_err(Failure::input)?;
    let spreads = Spreads::of(&trials);
    let sections = rough_sections(&rough, &trials, &spreads);
    if args.result.json {
        print_json(&answers::json(&AfmRoughAnswer::of(&spreads, trials.len(), args.seed)))?;
    } else {
        print_sections(&sections)?;
    }
    if let Some(path) = &args.result.report {
        write_report(path, "A rough surface", "by Monte Carlo", Vec::new(), sections)?;
    }
    Ok(())
}

fn simulate(args: &SimulateArgs) -> Result<(), Failure> {
    Plan::reading([""; 0], args.over.into()).writes(&args.output, &COMPUTED_OR_RECORDING)?;
    let form = Form::of(&args.output)?;
    let practice = Practice {
        specimen: Elastic { modulus_pa: args.modulus_kpa * 1e3, poisson_ratio: args.poisson },
        relaxation: relaxation(&args.relaxation)?,
        tip: args.tip.tip(Some(2500.0))?,
        spring_n_per_m: args.spring,
        beyond_m: args.beyond_nm * 1e-9,
        hold_s: args.hold,
        pull_n: args.pull_pn * 1e-12,
        noise_n: args.noise_pn * 1e-12,
        ..Practice::gel()
    };
    let trace = practice.curve(args.seed).map_err(Failure::input)?;
    form.write(&args.output, &trace)?;
    eprintln!("{}: {} samples, seed {}", args.output.display(), trace.len(), args.seed);
    Ok(())
}

/// Pairs of share and rate.
fn relaxation(numbers: &[f64]) -> Result<Relaxation, Failure> {
    let (shares, rates): (Vec<f64>, Vec<f64>) =
        numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).unzip();
    let good = numbers.len().is_multiple_of(2)
        && shares.iter().all(|share| (0.0..1.0).contains(share))
        && shares.iter().sum::<f64>() < 1.0
        && rates.iter().all(|rate| *rate > 0.0 && rate.is_finite());
    if good {
        return Ok(Relaxation::new(&shares, &rates));
    }
    Err(Failure::Input(miette!(
        "--relaxation takes pairs of a share, all together below 1, and a rate above 0, such as 0.2,4,0.2,0.5"
    )))
}
