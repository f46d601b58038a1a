//! The ladder: errors after each addition to a model, down towards the noise.

use palpate_model::{Model, Rung};
use palpate_report::{Axis, BarSeries, Bars, Block, Colour, Level, Section};

/// The ladder of a model file.
#[must_use]
pub fn ladder(model: &Model) -> Option<Section> {
    let fit = model.fit.as_ref()?;
    let rungs = &model.ladder;
    let bars = ladder_bars(rungs, &fit.unit, fit.noise_rms);
    let block = Block::Figure { figure: Box::new(bars.into()), caption: ABOUT.into() };
    (!rungs.is_empty()).then(|| Section::new("The ladder").block(block))
}

/// What the errors of a ladder are.
pub(super) const ABOUT: &str = "On the traces the model was fitted to; held out is each trace predicted by a fit to the others.";

/// The errors of the rungs beside the noise, in `unit`.
pub(super) fn ladder_bars(rungs: &[Rung], unit: &str, noise: Option<f64>) -> Bars {
    let names = rungs.iter().enumerate().map(rung_name).collect();
    Bars {
        title: "Error at each rung".into(),
        summary: "Root mean square error after each addition to the model".into(),
        ..error_bars(names, rungs, unit, noise)
    }
}

/// The errors of several models beside the noise, in `unit`.
pub(super) fn error_bars(
    names: Vec<String>,
    rungs: &[Rung],
    unit: &str,
    noise: Option<f64>,
) -> Bars {
    let bar = |name: &str, values: Vec<f64>, colour| BarSeries {
        name: name.into(),
        values,
        errors: Vec::new(),
        colour,
    };
    let held_out = rungs.iter().map(|rung| rung.heldout_rms.unwrap_or(f64::NAN)).collect();
    let noise = noise.map(|y| Level { y, label: "noise".into() });
    Bars {
        title: String::new(),
        summary: "Root mean square error of each model".into(),
        axis: Axis::new("root mean square error", unit),
        groups: names,
        series: vec![
            bar("fitted", rungs.iter().map(|rung| rung.fitted_rms).collect(), Colour::Hue(0)),
            bar("held out", held_out, Colour::Hue(1)),
        ],
        levels: noise.into_iter().collect(),
    }
}

/// The base law by its name, what was added with a plus.
pub(super) fn rung_name((index, rung): (usize, &Rung)) -> String {
    if index == 0 { rung.add.clone() } else { format!("+ {}", rung.add) }
}
