//! The library of effects, and one effect in depth with a picture of its signature; the pages of the
//! documentation are the same.

use rayon::prelude::*;

use super::compare::spans;
use palpate_diagnose::criticism::region::Region;
use palpate_diagnose::criticism::residuals::Stretch;
use palpate_diagnose::criticism::signature::{Signature, signature};
use palpate_diagnose::practice::session::SPECIMEN;
use palpate_fit::data::DataError;
use palpate_model::effects::{Count, Effect, LIBRARY, Law, Needs, Sign};
use palpate_report::number::{percent, significant};
use palpate_report::{
    Axis, Block, Colour, Column, Dash, Figure, Panels, Plot, Section, Series, Table, markdown,
    stacked,
};

/// Every effect, in one table for each stage of the chain.
#[must_use]
pub fn library_section() -> Section {
    let columns = || vec![Column::text("effect"), Column::text("meaning"), Column::whole("laws")];
    let title = |effect: &Effect| format!("{}: {}", effect.stage.name(), stage_in_words(effect));
    let row = |table: Table, effect: &&Effect| {
        let laws = effect.laws.len().to_string();
        table.row([&format!("`{}`", effect.name), effect.meaning, &laws])
    };
    let stages = LIBRARY.chunk_by(|one, next| one.stage == next.stage);
    let table =
        |effects: &[&Effect]| effects.iter().fold(Table::new(title(effects[0]), columns()), row);
    stages
        .map(table)
        .fold(Section::new("The library of effects"), Section::table)
        .paragraph("The laws of an effect, its parameters and what it leaves in a residual: `palpate effects` with its name.")
}

/// Everything about one effect, in words and tables.
#[must_use]
pub fn effect_section(signature: &Signature) -> Section {
    let effect = signature.effect;
    let confused = if effect.confused_with.is_empty() {
        "nothing in the library".to_owned()
    } else {
        let names: Vec<String> =
            effect.confused_with.iter().map(|name| format!("`{name}`")).collect();
        names.join(", ")
    };
    let about = vec![
        ("Stage".into(), format!("{}; {}", effect.stage.name(), stage_in_words(effect))),
        ("Signature".into(), effect.signature.into()),
        ("Confused with".into(), confused),
        ("What separates it".into(), effect.experiment.into()),
        ("Needs".into(), needs(effect.needs).into()),
    ];
    let mut laws = Table::new("Laws", ["law", "formula"].map(Column::text).to_vec());
    for law in effect.laws {
        laws = laws.row([law.name, &format!("`{}`", law.formula)]);
    }
    Section::new(effect.name)
        .paragraph(effect.meaning)
        .block(Block::Definitions(about))
        .table(laws)
        .table(parameters(signature))
        .block(Block::Heading("The picture".into()))
        .paragraph(picture_in_words(signature))
}

fn stage_in_words(effect: &Effect) -> &'static str {
    use palpate_model::Stage;
    match effect.stage {
        Stage::Motion => "what reaches the specimen is not what was commanded",
        Stage::Elasticity => "the elastic response of the specimen",
        Stage::Relaxation => "the time-dependence of the specimen",
        Stage::Contact => "what happens where the indenter touches",
        Stage::Sensor => "the sensor and its electronics",
    }
}

/// What a data set must have for an effect to be seen.
pub fn needs(needs: Needs) -> &'static str {
    match needs {
        Needs::Nothing => "displacement and the signal",
        Needs::Temperature => "a temperature that was recorded and changes (`temperature_C`)",
        Needs::Channels => "another channel than the signal, in every trace",
        Needs::Loadings => "more than one loading",
        Needs::FastSampling => "samples at 20 Hz or faster",
    }
}

/// How many strengths a law has.
pub fn how_many(law: &Law) -> String {
    match law.strength.count {
        Count::Fixed([]) => "one".into(),
        Count::Fixed(names) => format!("{}: {}", names.len(), names.join(", ")),
        Count::Traces => "one for each trace".into(),
        Count::EachTrace(names) => format!("{} for each trace", names.join(" and ")),
        Count::Channels => "one for each other channel".into(),
    }
}

fn parameters(signature: &Signature) -> Table {
    let columns = ["law", "parameter", "unit", "meaning", "values"].map(Column::text).to_vec();
    let mut table = Table::new("Parameters", columns);
    let scales = &signature.scales;
    for law in signature.effect.laws {
        let strength = &law.strength;
        let most = significant((strength.most)(scales), 2);
        let range = match strength.sign {
            Sign::Positive | Sign::Part => format!("0 (absent) to {most}"),
            Sign::Either => format!("0 (absent), of either sign up to {most}"),
        };
        let values = match strength.count {
            Count::Fixed([]) => range,
            _ => format!("{}; {range}", how_many(law)),
        };
        let name = format!("`{}`", strength.name);
        table = table.row([law.name, &name, strength.unit, strength.meaning, &values]);
        for shape in law.shapes {
            let values = match shape.role.bounds(scales) {
                Some((lower, upper)) => {
                    format!("{} to {}", significant(lower, 2), significant(upper, 2))
                }
                None => "taken from the data, not fitted".into(),
            };
            let name = format!("`{}`", shape.name);
            table = table.row([law.name, &name, shape.unit, shape.meaning, &values]);
        }
    }
    table.note("The first of each law is its strength. Where the ranges follow the data, they are those of the traces in the picture.")
}

fn picture_in_words(signature: &Signature) -> String {
    let named = |(name, value, unit): (&str, f64, &str)| {
        format!(
            "{name} = {}{}{unit}",
            significant(value, 3),
            if unit.is_empty() { "" } else { " " }
        )
    };
    let base: Vec<String> = SPECIMEN
        .0
        .parameters()
        .iter()
        .zip(SPECIMEN.1)
        .map(|(parameter, value)| named((&parameter.name, value, &parameter.unit)))
        .collect();
    let own: Vec<String> = signature
        .parameters
        .iter()
        .map(|(parameter, value)| named((&parameter.name, *value, &parameter.unit)))
        .collect();
    let mut text = format!(
        "A made-up press to 8 mm at 20 mm/s with a hold of 4 s, and four cycles to 6 mm at 60 mm/s: the base law `fung` with {}, \
         and the reference law of the effect with {}. Then the base law alone is refitted to both. The effect changes the force by {} of its largest, {} N; \
         what the refitted law leaves of that is {}",
        base.join(", "),
        own.join(", "),
        percent(signature.whole / signature.force, 2),
        significant(signature.force, 2),
        percent(signature.left / signature.whole, 2),
    );
    if signature.absorbed() {
        text += ": the base law takes the effect up, and two traces like these cannot show it";
    }
    text + &format!(
        ". The plots: the force of the press, what is left of both over time, and what is left against the {}.",
        signature.effect.against.name()
    )
}

/// The residual over time with its regions, and against what it depends on most.
#[must_use]
pub fn effect_figures(signature: &Signature) -> Vec<Figure> {
    let seconds = || Axis::new("time in the trace", "s");
    let mut panels = Panels::new(signature.effect.name).summary(format!(
        "A press and four cycles with the effect, and what the refitted base law leaves of them. {}",
        signature.effect.signature
    ));
    for (number, stretch) in signature.stretches.iter().enumerate() {
        if number == 0 {
            let (with, base) =
                (thinned(stretch, &stretch.measured), thinned(stretch, &stretch.predicted));
            let mut force = Plot::new("", seconds(), Axis::new("force", "N"))
                .series(Series::line("with the effect", with.0, with.1).colour(Colour::MEASURED))
                .series(Series::line("base law, refitted", base.0, base.1).colour(Colour::MODEL))
                .height(120.0);
            for (from, to, region) in spans(&stretch.time, &stretch.regions) {
                force = force.span(from, to, region.name());
            }
            panels = panels.plot(force);
        }
        let (time, residual) = thinned(stretch, &stretch.residual());
        let what = if number == 0 { "residual, press" } else { "residual, cycles" };
        let mut left = Plot::new("", seconds(), Axis::new(what, "mN"))
            .series(Series::line("", time, thousand(&residual)).colour(Colour::RESIDUAL))
            .level(0.0, "")
            .height(130.0);
        for (from, to, _) in spans(&stretch.time, &stretch.regions) {
            left = left.span(from, to, "");
        }
        panels = panels.plot(left);
    }
    vec![panels.into(), against(signature).into()]
}

/// Fewest samples from one point drawn to the next.
const STRIDE: usize = 6;

/// The samples of a stretch that are drawn: of every few, the least and the greatest.
fn thinned(stretch: &Stretch, values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut time, mut kept) = (Vec::new(), Vec::new());
    for (times, values) in stretch.time.chunks(2 * STRIDE).zip(values.chunks(2 * STRIDE)) {
        let by_value = |&a: &usize, &b: &usize| values[a].total_cmp(&values[b]);
        let least = (0..values.len()).min_by(by_value).unwrap_or(0);
        let most = (0..values.len()).max_by(by_value).unwrap_or(0);
        for index in [least.min(most), least.max(most)] {
            time.push(times[index]);
            kept.push(values[index]);
        }
    }
    (time, kept)
}

fn thousand(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| 1e3 * value).collect()
}

/// Everything left against a quantity, by what the drive does.
fn against(signature: &Signature) -> Plot {
    let covariate = signature.effect.against;
    let groups: [(&str, &[Region]); 4] = [
        ("loading", &[Region::Loading]),
        ("hold", &[Region::EarlyHold, Region::LateHold]),
        ("unloading", &[Region::Unloading]),
        ("off the specimen", &[Region::Approach, Region::After]),
    ];
    let x = Axis::new(covariate.name(), covariate.unit("N"));
    let mut plot = Plot::new("", x, Axis::new("residual", "mN"))
        .summary(format!("What is left against the {}", covariate.name()))
        .level(0.0, "")
        .height(170.0);
    for (number, (name, regions)) in groups.into_iter().enumerate() {
        let (mut at, mut left) = (Vec::new(), Vec::new());
        for (stretch, values) in signature.stretches.iter().zip(&signature.against) {
            let residual = stretch.residual();
            for k in (0..residual.len()).step_by(STRIDE) {
                if regions.contains(&stretch.regions[k]) {
                    at.push(values[k]);
                    left.push(1e3 * residual[k]);
                }
            }
        }
        if !at.is_empty() {
            let series = Series::points(name, at, left).colour(Colour::Hue(number));
            plot = plot.series(series.dash(Dash::Solid));
        }
    }
    plot
}

/// The pages of the documentation, by file name: one with a picture for each effect, and an index.
///
/// # Errors
/// When the base law cannot be refitted to what an effect does.
pub fn effect_pages() -> Result<Vec<(String, String)>, DataError> {
    let pages = |effect: &&'static Effect| -> Result<[(String, String); 2], DataError> {
        let (signature, name) = (signature(effect)?, effect.name);
        let text = linked(&markdown(&effect_section(&signature)), name);
        let summary = effect.signature;
        let page =
            format!("{text}\n![{name}: what it leaves of a press and four cycles]({name}.svg)\n");
        let picture = stacked(name, summary, &effect_figures(&signature));
        Ok([(format!("{name}.md"), page), (format!("{name}.svg"), picture.svg)])
    };
    let mut found: Vec<(String, String)> =
        LIBRARY.par_iter().map(pages).collect::<Result<Vec<_>, _>>()?.concat();
    let about = "Each effect is one physical or measuring effect that a base law can lack, in the order of the chain from the \
                 commanded motion to the recorded number. These pages are made from the library's own declarations by \
                 `cargo xtask effects`; `palpate effects NAME --report FILE.html` shows the same.";
    let mut index = library_section();
    index.blocks.insert(0, Block::Paragraph(about.into()));
    found.push(("README.md".into(), linked(&markdown(&index), "")));
    Ok(found)
}

/// Names of effects in code, as links to their pages; `own` is the page itself.
fn linked(text: &str, own: &str) -> String {
    LIBRARY.iter().filter(|effect| effect.name != own).fold(text.to_owned(), |text, effect| {
        let name = effect.name;
        text.replace(&format!("`{name}`"), &format!("[`{name}`]({name}.md)"))
    })
}
