//! What the specimens of a survey have in common, and how much they differ, as tables and a plot.

use super::{MOST_LISTED, more, shown};
use crate::answers::population::METHOD;
use palpate_report::number::significant;
use palpate_report::{Axis, BarSeries, Bars, Colour, Column, Section, Table};
use palpate_survey::population::{Between, Correlations, EffectInAll, InAll, Population, Spread};

/// The population in short, its parameters, their correlations, its effects.
#[must_use]
pub fn population_sections(population: &Population) -> Vec<Section> {
    let mut sections = vec![in_short(population)];
    if !population.parameters.is_empty() {
        sections.push(parameters(population));
    }
    sections.extend(population.correlations.as_ref().map(correlations));
    if !population.effects.is_empty() {
        sections.push(effects(&population.effects));
    }
    sections
}

fn in_short(population: &Population) -> Section {
    let Population { specimens, groups, occasions, .. } = population;
    let (vary, shared): (Vec<&InAll>, Vec<&InAll>) =
        population.parameters.iter().partition(|it| it.varies);
    let names = |of: &[&InAll]| of.iter().map(|it| it.name.as_str()).collect::<Vec<_>>().join(", ");
    let mut words = match occasions {
        Some(key) => format!("{specimens} specimens in {groups} groups, told apart by {key}. "),
        None => format!("{specimens} specimens. "),
    };
    if !vary.is_empty() {
        words += &format!("They differ in {}. ", names(&vary));
    }
    if !shared.is_empty() {
        words += &format!("Nothing shows that they differ in {}. ", names(&shared));
    }
    let there: Vec<&str> =
        population.effects.iter().filter(|it| it.is_there).map(|it| it.effect.as_str()).collect();
    if !there.is_empty() {
        words += &format!("Some lack {}. ", there.join(", "));
    }
    words += &format!("Estimated in {METHOD}.");
    Section::new("The population").paragraph(words)
}

/// A spread, or an error beside it: a part in percent, or in the unit.
fn amount(value: f64, relative: bool) -> String {
    if relative { format!("{} %", significant(100.0 * value, 3)) } else { significant(value, 3) }
}

fn interval(of: &Spread, relative: bool) -> String {
    let Between { lower, upper, .. } = of.deviation;
    let lower = if lower > 0.0 { amount(lower, relative) } else { "0".into() };
    format!("{lower} … {}", amount(upper, relative))
}

fn parameters(population: &Population) -> Section {
    let occasions = population.occasions.as_deref();
    let mut columns = vec![
        Column::text("parameter"),
        Column::number("typical", ""),
        Column::text("95 % interval"),
        Column::text("unit"),
        Column::number("between specimens", ""),
        Column::text("95 % interval"),
    ];
    if occasions.is_some() {
        columns.push(Column::number("between occasions", ""));
    }
    columns.extend([Column::number("error of a group", ""), Column::text("varies?")]);
    let mut table = Table::new("Parameters over the population", columns);
    for it in population.parameters.iter().take(MOST_LISTED) {
        let Between { value, lower, upper } = it.typical;
        let mut cells = vec![
            it.name.clone(),
            shown(value),
            format!("{} … {}", shown(lower), shown(upper)),
            it.unit.clone(),
            amount(it.spread.deviation.value, it.relative),
            interval(&it.spread, it.relative),
        ];
        if occasions.is_some() {
            let own = it.occasions.map(|own| amount(own.deviation.value, it.relative));
            cells.push(own.unwrap_or_default());
        }
        let varies = if it.varies { "yes" } else { "not shown" };
        cells.extend([amount(it.error, it.relative), varies.into()]);
        table = table.row(cells);
    }
    let note = "Spreads are standard deviations beyond the errors of the fits; in percent where all values are above 0 and their logarithm is taken as normal. Varies: at 5 % over all parameters (Holm).";
    let section =
        Section::new("Parameters").table(more(table, population.parameters.len()).note(note));
    let relative: Vec<&InAll> = population.parameters.iter().filter(|it| it.relative).collect();
    if relative.is_empty() { section } else { section.figure(bars(&relative), "") }
}

fn bars(parameters: &[&InAll]) -> Bars {
    let series = |name: &str, hue, of: &dyn Fn(&InAll) -> f64| BarSeries {
        name: name.into(),
        values: parameters.iter().map(|it| 100.0 * of(it)).collect(),
        errors: Vec::new(),
        colour: Colour::Hue(hue),
    };
    Bars {
        title: "Spread of the specimens beside the error of a single group".into(),
        summary: "Standard deviation between specimens and standard error of one group, in percent"
            .into(),
        axis: Axis::new("standard deviation", "%"),
        groups: parameters.iter().map(|it| it.name.clone()).collect(),
        series: vec![
            series("between specimens", 0, &|it| it.spread.deviation.value),
            series("error of a group", 1, &|it| it.error),
        ],
        levels: Vec::new(),
    }
}

fn correlations(found: &Correlations) -> Section {
    let names = found.order.iter().map(|name| Column::number(name.clone(), ""));
    let columns = [Column::text("")].into_iter().chain(names).collect();
    let mut table = Table::new("Correlations over the specimens", columns);
    for (name, row) in found.order.iter().zip(found.matrix.row_iter()) {
        let cells = row.iter().map(|value| format!("{value:.2}"));
        table = table.row([name.clone()].into_iter().chain(cells).collect::<Vec<_>>());
    }
    let note = format!(
        "Of what varies, over {} specimens, the errors of the fits taken off (global two-stage method).",
        found.specimens
    );
    Section::new("Together").table(table.note(note))
}

fn effects(effects: &[EffectInAll]) -> Section {
    let columns = vec![
        Column::text("effect"),
        Column::whole("groups"),
        Column::whole("specimens"),
        Column::number("share of the specimens", "%"),
        Column::text("95 % interval"),
        Column::number("p value", ""),
        Column::text("there?"),
    ];
    let mut table = Table::new("Missing effects over the population", columns);
    for it in effects.iter().take(MOST_LISTED) {
        let percent = |share: f64| significant(100.0 * share, 3);
        table = table.row([
            it.effect.clone(),
            it.groups.to_string(),
            it.specimens.len().to_string(),
            percent(it.share.value),
            format!("{} … {} %", percent(it.share.lower), percent(it.share.upper)),
            significant(it.p_value, 2),
            if it.is_there { "yes" } else { "not shown" }.into(),
        ]);
    }
    let note = "p value: of as many groups where each is a false alarm of one in a hundred. There: at 5 % over all effects (Holm).";
    Section::new("Effects").table(more(table, effects.len()).note(note))
}
