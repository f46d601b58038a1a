//! `palpate sensor`.

use std::path::PathBuf;

use clap::Subcommand;
use serde_json::Value;

use super::Failure;
use super::convert::Form;
use super::output::{Output, OverwriteOnly, print_json, print_sections, write_report};
use palpate_contact::sensor::{
    Composition, Fingertip, Indenter, Press, Ridges, Shake, Silicone, Slide, Slip, Tones, Touch,
};
use palpate_present::answers::{
    self, SensorFrequencyAnswer, SensorPressAnswer, SensorShakeAnswer, SensorSlideAnswer,
    SensorSlipAnswer, SensorSpecimenAnswer,
};
use palpate_present::summary::{
    sensor_press_sections, sensor_shake_sections, sensor_slide_sections, sensor_slip_sections,
    sensor_tones_sections,
};
use palpate_report::Section;
use palpate_trace::files::plan::COMPUTED_OR_RECORDING;

/// Simulate a fingertip: four gauges in silicone, pressed, shaken or slid over.
#[derive(clap::Args)]
#[command(after_help = "\
Readings come with the relaxation of the silicone, the limit of the converter and seeded noise. A file
that ends in .palpate is a recording as a device makes it, one in .csv or .parquet a trace; every other
command takes either.

Examples:
  palpate sensor press --indenter sharp               a sharp tip saturates the gauge below
  palpate sensor press --indenter blunt -o blunt.csv  a blunt one of the same force does not
  palpate sensor press --composition 5:5 --thickness 8 -o press.palpate
  palpate sensor frequency --report tones.html        gain and phase of FA and SA, 0.1 to 400 Hz
  palpate sensor slide --speed 30 --ridges 0.4        the hum of a fingerprint
  palpate sensor slip -o pull.csv                     pulled until it slides, for `palpate events`
  palpate sensor shake --part 0.05 -o shake.csv       held by a hand that shakes")]
pub struct Args {
    #[command(subcommand)]
    stimulus: Stimulus,
}

#[derive(Subcommand)]
enum Stimulus {
    /// Press, hold, release
    Press(PressArgs),
    /// Sinusoidal stimuli from slow to fast
    Frequency(FrequencyArgs),
    /// Slide over a fingerprint
    Slide(SlideArgs),
    /// Press, then pull sideways until it slides: the rim of the contact slips first
    Slip(SlipArgs),
    /// Press, then shake as a hand does
    Shake(ShakeArgs),
}

/// The fingertip and where its readings go.
#[derive(clap::Args)]
struct FingertipArgs {
    /// Parts of silicone and thinner, 5:5 to 9:1, or the share of silicone
    #[arg(long, default_value = "7:3", value_name = "PARTS")]
    composition: Composition,
    /// Thickness of the silicone, mm
    #[arg(long, default_value_t = 4.0, value_name = "MM")]
    thickness: f64,
    /// Silicone above the gauges, mm; half the thickness by default
    #[arg(long, value_name = "MM")]
    cover: Option<f64>,
    /// Part of the silicone's strain that a gauge takes up
    #[arg(long, value_name = "SHARE")]
    transfer: Option<f64>,
    /// Part of a reading that follows stress, and so relaxes
    #[arg(long, value_name = "SHARE")]
    stress_share: Option<f64>,
    /// Cut readings off here, µε; where the converter's rail is by default
    #[arg(long, value_name = "USTRAIN")]
    limit: Option<f64>,
    /// Standard deviation of the noise, µε
    #[arg(long, value_name = "USTRAIN")]
    noise: Option<f64>,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write what the gauges read: .palpate, .csv or .parquet
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output<OverwriteOnly>,
}

#[derive(clap::Args)]
struct PressArgs {
    /// sharp (0.5 mm), blunt (5 mm), or the radius of the tip, mm
    #[arg(long, default_value = "blunt", value_name = "TIP", value_parser = parse_indenter)]
    indenter: Indenter,
    /// Force that a press too fast to relax would reach, N
    #[arg(long, default_value_t = 0.2, value_name = "N")]
    force: f64,
    /// Where, mm; above the first gauge by default
    #[arg(long, value_name = "X,Y", value_parser = parse_place, allow_hyphen_values = true)]
    at: Option<[f64; 2]>,
    /// Speed of the indenter, mm/s
    #[arg(long, default_value_t = 20.0, value_name = "MM/S")]
    speed: f64,
    /// How long it stays down, s
    #[arg(long, default_value_t = 4.0, value_name = "S")]
    hold: f64,
    /// How long to wait after the release, s
    #[arg(long, default_value_t = 6.0, value_name = "S")]
    after: f64,
    /// Samples per second
    #[arg(long, default_value_t = 1000.0, value_name = "HZ")]
    rate: f64,
    #[command(flatten)]
    fingertip: FingertipArgs,
}

#[derive(clap::Args)]
struct FrequencyArgs {
    /// sharp (0.5 mm), blunt (5 mm), or the radius of the tip, mm
    #[arg(long, default_value = "blunt", value_name = "TIP", value_parser = parse_indenter)]
    indenter: Indenter,
    /// Lowest frequency, Hz
    #[arg(long, default_value_t = 0.1, value_name = "HZ")]
    from: f64,
    /// Highest frequency, Hz
    #[arg(long, default_value_t = 400.0, value_name = "HZ")]
    to: f64,
    /// How many frequencies
    #[arg(long, default_value_t = 19)]
    count: usize,
    /// Mean depth, mm
    #[arg(long, default_value_t = 0.4, value_name = "MM")]
    depth: f64,
    /// Amplitude, mm
    #[arg(long, default_value_t = 0.02, value_name = "MM")]
    amplitude: f64,
    /// Samples per second
    #[arg(long, default_value_t = 4000.0, value_name = "HZ")]
    rate: f64,
    #[command(flatten)]
    fingertip: FingertipArgs,
}

#[derive(clap::Args)]
struct SlideArgs {
    /// sharp (0.5 mm), blunt (5 mm), or the radius of the tip, mm
    #[arg(long, default_value = "sharp", value_name = "TIP", value_parser = parse_indenter)]
    indenter: Indenter,
    /// From crest to crest of the fingerprint, mm
    #[arg(long, default_value_t = 0.5, value_name = "MM")]
    ridges: f64,
    /// From trough to crest, mm; 0 for a smooth fingertip
    #[arg(long, default_value_t = 0.1, value_name = "MM")]
    ridge_height: f64,
    /// Depth below the mean surface, mm
    #[arg(long, default_value_t = 0.1, value_name = "MM")]
    depth: f64,
    /// Speed, mm/s
    #[arg(long, default_value_t = 20.0, value_name = "MM/S")]
    speed: f64,
    /// How far, mm
    #[arg(long, default_value_t = 16.0, value_name = "MM")]
    distance: f64,
    /// Samples per second
    #[arg(long, default_value_t = 4000.0, value_name = "HZ")]
    rate: f64,
    #[command(flatten)]
    fingertip: FingertipArgs,
}

#[derive(clap::Args)]
struct SlipArgs {
    /// sharp (0.5 mm), blunt (5 mm), or the radius of the tip, mm
    #[arg(long, default_value = "blunt", value_name = "TIP", value_parser = parse_indenter)]
    indenter: Indenter,
    /// Depth that is held, mm
    #[arg(long, default_value_t = 0.3, value_name = "MM")]
    depth: f64,
    /// Where, mm; 2.5 mm before the first gauge by default
    #[arg(long, value_name = "X,Y", value_parser = parse_place, allow_hyphen_values = true)]
    at: Option<[f64; 2]>,
    /// From nub to nub of the surface, mm
    #[arg(long, default_value_t = 0.5, value_name = "MM")]
    nubs: f64,
    /// Friction coefficient of sticking
    #[arg(long, default_value_t = 0.7)]
    friction: f64,
    /// Part of its friction that a nub loses when it lets go
    #[arg(long, default_value_t = 0.15, value_name = "SHARE")]
    lost: f64,
    /// Time from the press to the pull, s
    #[arg(long, default_value_t = 2.0, value_name = "S")]
    hold: f64,
    /// Time in which the pull grows until it slides, s
    #[arg(long, default_value_t = 1.0, value_name = "S")]
    pull: f64,
    /// Speed of the slide, mm/s
    #[arg(long, default_value_t = 10.0, value_name = "MM/S")]
    speed: f64,
    /// How far it slides, mm
    #[arg(long, default_value_t = 4.0, value_name = "MM")]
    distance: f64,
    /// Samples per second
    #[arg(long, default_value_t = 1000.0, value_name = "HZ")]
    rate: f64,
    #[command(flatten)]
    fingertip: FingertipArgs,
}

#[derive(clap::Args)]
struct ShakeArgs {
    /// sharp (0.5 mm), blunt (5 mm), or the radius of the tip, mm
    #[arg(long, default_value = "blunt", value_name = "TIP", value_parser = parse_indenter)]
    indenter: Indenter,
    /// Depth about which it shakes, mm
    #[arg(long, default_value_t = 0.3, value_name = "MM")]
    depth: f64,
    /// Root mean square of the shaking, as a part of the depth
    #[arg(long, default_value_t = 0.05, value_name = "SHARE")]
    part: f64,
    /// Slowest of the shaking, Hz
    #[arg(long, default_value_t = 1.0, value_name = "HZ")]
    from: f64,
    /// Fastest of the shaking, Hz
    #[arg(long, default_value_t = 12.0, value_name = "HZ")]
    to: f64,
    /// How long it shakes, s
    #[arg(long, default_value_t = 20.0, value_name = "S")]
    duration: f64,
    /// Samples per second
    #[arg(long, default_value_t = 1000.0, value_name = "HZ")]
    rate: f64,
    #[command(flatten)]
    fingertip: FingertipArgs,
}

fn parse_indenter(text: &str) -> Result<Indenter, String> {
    match text {
        "sharp" => Ok(Indenter::SHARP),
        "blunt" => Ok(Indenter::BLUNT),
        _ => text
            .parse()
            .ok()
            .filter(|radius: &f64| radius.is_finite() && *radius > 0.0)
            .map(|radius_mm| Indenter { radius_mm })
            .ok_or_else(|| "give sharp, blunt, or a radius in mm".into()),
    }
}

fn parse_place(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    text.split_once(',')
        .and_then(|(x, y)| Some([number(x)?, number(y)?]))
        .ok_or_else(|| "give a place as X,Y in mm, such as 3,-3".into())
}

/// Simulates, writes and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    match &args.stimulus {
        Stimulus::Press(args) => press(args),
        Stimulus::Frequency(args) => frequency(args),
        Stimulus::Slide(args) => slide(args),
        Stimulus::Slip(args) => slip(args),
        Stimulus::Shake(args) => shake(args),
    }
}

fn press(args: &PressArgs) -> Result<(), Failure> {
    let fingertip = args.fingertip.make()?;
    let press = Press {
        indenter: args.indenter,
        force_n: args.force,
        place_mm: args.at.unwrap_or(fingertip.gauges_mm[0]),
        speed_mm_per_s: args.speed,
        hold_s: args.hold,
        after_s: args.after,
        rate_hz: args.rate,
    };
    let seed = args.fingertip.seed;
    let result = press.run(&fingertip, seed).map_err(Failure::input)?;
    let sections = sensor_press_sections(&fingertip, args.indenter, &result);
    let specimen = SensorSpecimenAnswer::of(&fingertip, args.indenter, seed);
    let json = answers::json(&SensorPressAnswer::of(specimen, &result));
    args.fingertip.give("A press on a simulated fingertip", &result.touch, sections, &json)
}

fn frequency(args: &FrequencyArgs) -> Result<(), Failure> {
    let fingertip = args.fingertip.make()?;
    let tones = Tones {
        indenter: args.indenter,
        from_hz: args.from,
        to_hz: args.to,
        count: args.count,
        depth_mm: args.depth,
        amplitude_mm: args.amplitude,
        rate_hz: args.rate,
    };
    let seed = args.fingertip.seed;
    let result = tones.run(&fingertip, seed).map_err(Failure::input)?;
    let sections = sensor_tones_sections(&fingertip, args.indenter, &result);
    let specimen = SensorSpecimenAnswer::of(&fingertip, args.indenter, seed);
    let json = answers::json(&SensorFrequencyAnswer::of(specimen, &result));
    args.fingertip.give("Tones on a simulated fingertip", &result.touch, sections, &json)
}

fn slide(args: &SlideArgs) -> Result<(), Failure> {
    let fingertip = args.fingertip.make()?;
    let slide = Slide {
        indenter: args.indenter,
        ridges: Ridges { period_mm: args.ridges, height_mm: args.ridge_height },
        depth_mm: args.depth,
        speed_mm_per_s: args.speed,
        distance_mm: args.distance,
        rate_hz: args.rate,
        ..Slide::over_first_gauges(&fingertip)
    };
    let seed = args.fingertip.seed;
    let result = slide.run(&fingertip, seed).map_err(Failure::input)?;
    let sections = sensor_slide_sections(&fingertip, args.indenter, &result);
    let specimen = SensorSpecimenAnswer::of(&fingertip, args.indenter, seed);
    let json = answers::json(&SensorSlideAnswer::of(specimen, &result));
    args.fingertip.give("A slide over a simulated fingertip", &result.touch, sections, &json)
}

fn slip(args: &SlipArgs) -> Result<(), Failure> {
    let fingertip = args.fingertip.make()?;
    let standard = Slip::beside_first_gauge(&fingertip);
    let slip = Slip {
        indenter: args.indenter,
        depth_mm: args.depth,
        place_mm: args.at.unwrap_or(standard.place_mm),
        period_mm: args.nubs,
        friction: args.friction,
        lost: args.lost,
        hold_s: args.hold,
        pull_s: args.pull,
        speed_mm_per_s: args.speed,
        distance_mm: args.distance,
        rate_hz: args.rate,
    };
    let seed = args.fingertip.seed;
    let result = slip.run(&fingertip, seed).map_err(Failure::input)?;
    let sections = sensor_slip_sections(&fingertip, args.indenter, &result);
    let specimen = SensorSpecimenAnswer::of(&fingertip, args.indenter, seed);
    let json = answers::json(&SensorSlipAnswer::of(specimen, &result));
    args.fingertip.give("A pull on a simulated fingertip", &result.touch, sections, &json)
}

fn shake(args: &ShakeArgs) -> Result<(), Failure> {
    let fingertip = args.fingertip.make()?;
    let shake = Shake {
        indenter: args.indenter,
        depth_mm: args.depth,
        part: args.part,
        band_hz: [args.from, args.to],
        duration_s: args.duration,
        rate_hz: args.rate,
        ..Shake::above_first_gauge(&fingertip)
    };
    let seed = args.fingertip.seed;
    let touch = shake.run(&fingertip, seed).map_err(Failure::input)?;
    let sections = sensor_shake_sections(&fingertip, args.indenter, &touch);
    let specimen = SensorSpecimenAnswer::of(&fingertip, args.indenter, seed);
    let json = answers::json(&SensorShakeAnswer::of(specimen, &touch));
    args.fingertip.give("A simulated fingertip that shakes", &touch, sections, &json)
}

impl FingertipArgs {
    fn make(&self) -> Result<Fingertip, Failure> {
        // Before anything is computed: a name that will not do is told at once.
        let mut files = self.result.files([""; 0])?;
        if let Some(path) = &self.output {
            files.writes(path, &COMPUTED_OR_RECORDING)?;
        }
        let silicone = Silicone::of(self.composition);
        let mut fingertip = Fingertip::new(silicone, self.thickness).map_err(Failure::input)?;
        let set = |value: &mut f64, given: Option<f64>| *value = given.unwrap_or(*value);
        set(&mut fingertip.cover_mm, self.cover);
        set(&mut fingertip.transfer, self.transfer);
        set(&mut fingertip.stress_share, self.stress_share);
        set(&mut fingertip.limit_ustrain, self.limit);
        set(&mut fingertip.noise_ustrain, self.noise);
        fingertip.check().map_err(Failure::input)?;
        Ok(fingertip)
    }

    fn give(
        &self,
        title: &str,
        touch: &Touch,
        sections: Vec<Section>,
        json: &Value,
    ) -> Result<(), Failure> {
        eprintln!("seed of the noise: {}", self.seed);
        if let Some(path) = &self.output {
            Form::of(path)?.write(path, &touch.trace)?;
            eprintln!("{}: {} samples", path.display(), touch.trace.len());
        }
        if self.result.json {
            print_json(json)?;
        } else {
            print_sections(&sections)?;
        }
        if let Some(path) = &self.result.report {
            let subtitle = touch.trace.head.name.as_deref().unwrap_or_default();
            write_report(path, title, subtitle, Vec::new(), sections)?;
        }
        Ok(())
    }
}
