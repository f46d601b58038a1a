//! Every kind of figure, table and block on one page, with made-up data: a press, four gauges, a ladder.
//!
//! `cargo run -p palpate-report --example report_gallery -- DIRECTORY` writes `gallery.html`, one SVG file for
//! each figure, and shows the terminal's side.

use std::path::PathBuf;

use palpate_report::{
    Axis, BarSeries, Bars, Block, Callout, CellFormat, Colour, Column, Dash, Figure, HeatMap,
    Legend, Level, Origin, Page, Panels, Plot, Section, Series, Table, Terminal, number,
};
use rand::{RngExt, SeedableRng};

const REGIONS: [(f64, f64, &str); 6] = [
    (0.2, 0.8, "OA"),
    (0.8, 5.1, "AB"),
    (5.1, 5.4, "BC"),
    (5.4, 9.6, "CD"),
    (9.6, 9.9, "DE"),
    (9.9, 12.0, "EF"),
];

fn main() -> std::io::Result<()> {
    let directory =
        PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "target/gallery".into()));
    std::fs::create_dir_all(&directory)?;
    let press = Press::new();
    let figures = [
        ("overlay", Figure::from(overlay(&press))),
        ("gauges", gauges(&press).into()),
        ("loop", force_loop(&press).into()),
        ("rates", rates().into()),
        ("spectrum", spectrum().into()),
        ("long", long().into()),
        ("where", share().into()),
        ("ladder", ladder().into()),
    ];
    for (name, figure) in &figures {
        std::fs::write(directory.join(format!("{name}.svg")), figure.to_svg())?;
    }
    let page = page(&press, &figures);
    std::fs::write(directory.join("gallery.html"), page.to_html())?;
    let terminal = Terminal { width: 80, unicode: true, colour: false };
    print!("{}", terminal.table(&parameters()));
    print!("{}", terminal.chart(&press.time, &press.force, "force (N)", "time (s)", 8));
    println!("{}", terminal.sparkline(&press.force, 60));
    let plain = Terminal { unicode: false, ..terminal };
    print!("{}", plain.table(&parameters()));
    print!("{}", plain.chart(&press.time, &press.force, "force (N)", "time (s)", 8));
    println!("wrote {}", directory.join("gallery.html").display());
    Ok(())
}

/// A load, hold, partial unload, hold, unload at 200 Hz.
struct Press {
    time: Vec<f64>,
    displacement: Vec<f64>,
    force: Vec<f64>,
    model: Vec<f64>,
    fast: Vec<f64>,
    slow: Vec<f64>,
}

impl Press {
    fn new() -> Self {
        let time: Vec<f64> = (0..2401).map(|i| f64::from(i) * 0.005).collect();
        let at = |t: f64| match t {
            t if t < 0.2 => 0.0,
            t if t < 0.8 => 20.0 * (t - 0.2),
            t if t < 5.1 => 12.0,
            t if t < 5.4 => 12.0 - 20.0 * (t - 5.1),
            t if t < 9.6 => 6.0,
            t if t < 9.9 => 6.0 - 20.0 * (t - 9.6),
            _ => 0.0,
        };
        let displacement: Vec<f64> = time.iter().map(|t| at(*t)).collect();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let (mut fast_state, mut slow_state, mut before) = (0.0, 0.0, 0.0);
        let mut press =
            Self { time, displacement, force: vec![], model: vec![], fast: vec![], slow: vec![] };
        for (index, x) in press.displacement.iter().enumerate() {
            let elastic = 0.02 * x * x + 0.09 * x;
            fast_state = fast_state * (-2.5f64 * 0.005).exp() + elastic - before;
            slow_state = slow_state * (-0.25f64 * 0.005).exp() + elastic - before;
            before = elastic;
            let model = (0.72 * elastic + 0.16 * fast_state + 0.12 * slow_state).max(0.0);
            let noise: f64 = (0..6).map(|_| random.random_range(-0.5..0.5)).sum::<f64>() * 0.028;
            let t = press.time[index];
            let mullins = if (5.1..9.9).contains(&t) && *x > 0.0 { -0.05 * *x / 6.0 } else { 0.0 };
            press.force.push(model + noise + mullins);
            press.model.push(model);
            press.fast.push(0.16 * fast_state);
            press.slow.push(0.72 * elastic + 0.12 * slow_state);
        }
        press
    }
}

fn with_regions(plot: Plot) -> Plot {
    REGIONS.into_iter().fold(plot, |plot, (from, to, name)| plot.span(from, to, name))
}

fn time() -> Axis {
    Axis::new("Time", "s")
}

fn overlay(press: &Press) -> Panels {
    let residual: Vec<f64> = press.force.iter().zip(&press.model).map(|(f, m)| f - m).collect();
    let force = Plot::new("", time(), Axis::new("Force", "N"))
        .series(
            Series::line("measured", press.time.clone(), press.force.clone())
                .colour(Colour::MEASURED)
                .width(1.2),
        )
        .series(
            Series::line("Fung model", press.time.clone(), press.model.clone())
                .colour(Colour::MODEL)
                .width(2.0),
        )
        .annotation(0.8, press.force[160], "peak 3.98 N");
    let residual = Plot::new("", time(), Axis::new("Residual", "N"))
        .series(Series::line("", press.time.clone(), residual).colour(Colour::RESIDUAL).width(0.9))
        .level(0.04, "noise ± 2 RMS")
        .level(-0.04, "")
        .height(110.0);
    Panels::new("Measured force and the fitted model")
        .summary("The model follows loading and the first hold, and lies above the force while unloading")
        .plot(with_regions(force))
        .plot(REGIONS.into_iter().fold(residual, |plot, (from, to, _)| plot.span(from, to, "")))
}

fn gauges(press: &Press) -> Panels {
    let gains = [310.0, 285.0, 120.0, 96.0];
    let panel = |index: usize| {
        let scaled = |values: &[f64]| values.iter().map(|v| v * gains[index]).collect::<Vec<_>>();
        let title = format!("Gauge {}", index + 1);
        let plot = Plot::new(title, time(), Axis::new("Strain", "µε"))
            .series(
                Series::line("signal", press.time.clone(), scaled(&press.force))
                    .colour(Colour::MEASURED)
                    .width(1.0),
            )
            .series(Series::line("SA", press.time.clone(), scaled(&press.slow)).colour(Colour::SA))
            .series(Series::line("FA", press.time.clone(), scaled(&press.fast)).colour(Colour::FA))
            .height(90.0);
        let plot = if index == 0 { with_regions(plot) } else { plot.legend(Legend::Hidden) };
        if index == 1 { plot.mark(0.2, "").mark(9.9, "") } else { plot }
    };
    (0..4).fold(Panels::new("Four gauges: fast and slowly adapting parts"), |panels, i| {
        panels.plot(panel(i))
    })
}

fn force_loop(press: &Press) -> Plot {
    Plot::new("Force over displacement", Axis::new("Displacement", "mm"), Axis::new("Force", "N"))
        .series(
            Series::line("measured", press.displacement.clone(), press.force.clone())
                .colour(Colour::MEASURED)
                .width(1.2),
        )
        .series(
            Series::line("model", press.displacement.clone(), press.model.clone())
                .colour(Colour::MODEL),
        )
        .legend(Legend::Right)
        .mark(6.0, "second hold")
        .mark(0.0, "first touch")
        .mark(12.0, "full stroke")
}

fn rates() -> Plot {
    let rate = [20.0, 40.0, 60.0, 80.0, 100.0];
    let stiffness = [3.497e4, 4.31e4, 5.02e4, 5.6e4, 6.21e4];
    let dense: Vec<f64> = (0..60).map(|i| 18.0 + 85.0 * f64::from(i) / 59.0).collect();
    let law = |v: &f64| 3.45e4 * (v / 20.0).powf(0.36);
    let fit: Vec<f64> = dense.iter().map(law).collect();
    let edge = |k: f64| fit.iter().map(|v| v * k).collect::<Vec<_>>();
    Plot::new(
        "Specific stiffness grows with the rate of loading",
        Axis::new("Rate of loading", "mm/s"),
        Axis::new("Specific stiffness", "Pa").range(0.0, 1.3e5),
    )
    .series(Series::band("95 % band", dense.clone(), edge(0.94), edge(1.06)).colour(Colour::Hue(2)))
    .series(Series::line("power law", dense.clone(), fit.clone()).colour(Colour::Hue(2)))
    .series(
        Series::error_bars("specimen 1", rate, stiffness, [1.5e3, 1.2e3, 2.0e3, 2.4e3, 1.1e3])
            .colour(Colour::Hue(0)),
    )
    .series(Series::points("specimen 2", rate, stiffness.map(|s| 1.8 * s)).colour(Colour::Hue(1)))
    .series(Series::points("specimen 3", rate, stiffness.map(|s| 1.5 * s)).colour(Colour::Hue(2)))
    .series(Series::points("specimen 4", rate, stiffness.map(|s| 1.3 * s)).colour(Colour::Hue(3)))
    .series(Series::points("specimen 5", rate, stiffness.map(|s| 0.6 * s)).colour(Colour::Hue(4)))
    .series(
        Series::step("steps", rate, stiffness.map(|s| 0.4 * s))
            .colour(Colour::Hue(5))
            .dash(Dash::Auto),
    )
}

fn spectrum() -> Plot {
    let x: Vec<f64> = (1..400).map(|i| 0.05 * 1.02f64.powi(i)).collect();
    let y: Vec<f64> = x
        .iter()
        .map(|f| {
            3e-2 / (1.0 + (f / 0.4).powi(2)) + 2e-6 + 4e-3 * (-((f - 50.0) / 0.6).powi(2)).exp()
        })
        .collect();
    Plot::new(
        "Spectrum of the residual",
        Axis::new("Frequency", "Hz").log(),
        Axis::new("Power density", "N²/Hz").log(),
    )
    .series(Series::line("residual", x.clone(), y).colour(Colour::RESIDUAL))
    .series(
        Series::points("check", x.clone(), x.iter().map(|f| 1e-3 / f).collect::<Vec<_>>())
            .colour(Colour::Hue(3)),
    )
    .level(2e-6, "white noise")
    .legend(Legend::Inside)
    .annotation(50.0, 4e-3, "mains hum")
    .height(200.0)
}

fn long() -> Plot {
    let x: Vec<f64> = (0..600_000).map(|i| f64::from(i) / 1000.0).collect();
    let mut y: Vec<f64> =
        x.iter().map(|t| 20.0 * (t * 0.05).sin() + 2.0 * (t * 61.0).sin() + 1000.0).collect();
    y[371_113] = 1060.0;
    y[200_000..230_000].fill(f64::NAN);
    Plot::new(
        "Ten minutes at 1 kHz, one spike of a single sample, one gap",
        time(),
        Axis::new("Strain", "µε"),
    )
    .series(Series::line("gauge 1", x, y).dash(Dash::Solid).width(1.0))
    .height(150.0)
}

fn share() -> HeatMap {
    let names = [
        "hold-12mm-20mms.csv",
        "hold-12mm-40mms.csv",
        "hold-12mm-60mms-after-a-rest-of-ten-minutes.csv",
        "ramp-6mm.csv",
    ];
    HeatMap {
        title: "Where the excess error is".into(),
        summary: "Unloading carries most of it".into(),
        row_label: "Trace".into(),
        column_label: "Share of the excess error in each region".into(),
        rows: names.map(String::from).to_vec(),
        columns: REGIONS.map(|r| r.2.to_owned()).to_vec(),
        values: vec![
            vec![0.02, 0.04, 0.31, 0.10, 0.44, 0.0],
            vec![0.05, 0.02, 0.25, 0.12, 0.61, -0.05],
            vec![0.08, 0.01, 0.20, 0.004, 0.38, 0.0],
            vec![0.11, f64::NAN, 0.18, f64::NAN, 0.22, 0.01],
        ],
        format: CellFormat::Percent,
        strongest: None,
    }
}

fn ladder() -> Bars {
    let series = |name: &str, values: [f64; 4], errors: [f64; 4], hue| BarSeries {
        name: name.into(),
        values: values.to_vec(),
        errors: errors.to_vec(),
        colour: Colour::Hue(hue),
    };
    Bars {
        title: "Error at each rung of the ladder".into(),
        axis: Axis::new("Residual RMS", "N"),
        groups: ["fung", "+ mullins", "+ amplitude-dependent-relaxation", "+ drift"]
            .map(String::from)
            .to_vec(),
        series: vec![
            series("fitted", [0.131, 0.052, 0.027, 0.0205], [0.006, 0.004, 0.002, 0.001], 0),
            series("held out", [0.140, 0.060, 0.031, 0.0224], [0.011, 0.008, 0.004, 0.002], 0),
        ],
        levels: vec![Level { y: 0.02, label: "noise floor".into() }],
        ..Bars::default()
    }
}

fn parameters() -> Table {
    let columns = vec![
        Column::text("Parameter"),
        Column::text("Meaning"),
        Column::number("Value", ""),
        Column::text("Unit"),
        Column::whole("Traces"),
    ];
    [
        ("p", "stiffness", 0.3981, 0.0074, "N/mm"),
        ("q", "exponent", 1.1834, 0.0122, ""),
        ("c₁", "share of the fast mode", 0.1602, 0.0019, ""),
        ("v₁", "rate of the fast mode", 2.4931, 0.047, "1/s"),
        ("v₂", "rate of the slow mode", 0.2512, f64::NAN, "1/s"),
        ("E", "modulus", 28_134.0, 341.0, "Pa"),
    ]
    .into_iter()
    .fold(
        Table::new("Fung model, all parameters jointly", columns),
        |table, (name, meaning, value, error, unit)| {
            table.row([name, meaning, &number::with_error(value, error), unit, "10"])
        },
    )
    .note("± one standard error. v₂ is not identifiable from 4.3 s of hold.")
}

fn page(press: &Press, figures: &[(&str, Figure)]) -> Page {
    let origin = Origin {
        program: "palpate 0.1.0".into(),
        command: "palpate fit fung press.csv --report press.html".into(),
        inputs: vec!["press.csv (2401 samples, 12.0 s)".into()],
    };
    let mut plots = Section::new("Figures").paragraph("Every kind of figure, with made-up data.");
    for (name, figure) in &figures[1..] {
        plots = plots.figure(figure.clone(), format!("The figure `{name}.svg`."));
    }
    Page::new("A press of a soft cylinder", "12 mm at 20 mm/s, four gauges, made-up data", origin)
        .section(
            Section::new("Result")
                .callout(Callout::Finding, "softening", "The residual is largest while unloading: the specimen remembers its greatest compression.")
                .figure(overlay(press), "Force of the press with the fitted model, and what it leaves over.")
                .table(parameters())
                .callout(Callout::Warning, "one rate cannot be told", "The hold is too short for v₂; `palpate plan` says how long to record."),
        )
        .section(plots)
        .section(
            Section::new("How it was done")
                .block(Block::Definitions(vec![
                    ("OA".into(), "loading".into()),
                    ("AB".into(), "hold at full compression".into()),
                    ("BC".into(), "partial unloading".into()),
                ]))
                .block(Block::List(vec!["All traces jointly.".into(), "Bounds from physics.".into()]))
                .block(Block::Code("cargo run --release -- demo\npalpate fit fung TRACE… -o model.toml".into()))
                .block(Block::Details { summary: "Correlations".into(), blocks: vec![Block::Paragraph("p and q: −0.98.".into()), Block::Table(parameters())] }),
        )
}
