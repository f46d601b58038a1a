//! Which effect is missing in how many groups, and since when.

use super::{MOST_LISTED, more};
use palpate_report::{Axis, BarSeries, Bars, Colour, Column, Section, Table};
use palpate_survey::overview::Overview;

/// Which effects are missing and where; none where nothing is.
pub(super) fn section(overview: &Overview) -> Option<Section> {
    if overview.effects.is_empty() {
        return None;
    }
    let mut section = Section::new("What is missing").table(effects(overview));
    if overview.effects.len() > 1 {
        section = section.figure(bars(overview), "");
    }
    Some(section.table(specimens(overview)))
}

fn effects(overview: &Overview) -> Table {
    let mut columns = vec![Column::text("effect"), Column::whole("groups")];
    if overview.order().is_some() {
        columns.push(Column::whole("specimens"));
        columns.push(Column::text("first"));
    }
    columns.push(Column::whole("not distinguished from"));
    let mut table = Table::new("Missing effects", columns);
    for (name, effect) in overview.most_frequent_effects() {
        let mut cells = vec![name.to_owned(), effect.rows.len().to_string()];
        if overview.order().is_some() {
            let since = overview.since(effect);
            cells.push(since.len().to_string());
            cells.push(since.first().and_then(|since| since.first.clone()).unwrap_or_default());
        }
        cells.push(effect.ambiguous.to_string());
        table = table.row(cells);
    }
    table
}

fn specimens(overview: &Overview) -> Table {
    let mut columns = vec![Column::text("in"), Column::text("effect")];
    if let Some(order) = overview.order() {
        columns.push(Column::text(format!("since ({order})")));
        columns.push(Column::whole("groups"));
    }
    columns.push(Column::whole("first group"));
    let mut table = Table::new("Where", columns);
    let mut all = 0;
    for (name, effect) in overview.most_frequent_effects() {
        for since in overview.since(effect) {
            all += 1;
            if all > MOST_LISTED {
                continue;
            }
            let mut cells = vec![since.specimen, name.to_owned()];
            if overview.order().is_some() {
                cells.push(since.first.unwrap_or_default());
                cells.push(since.rows.to_string());
            }
            cells.push(since.row.to_string());
            table = table.row(cells);
        }
    }
    more(table, all)
}

fn bars(overview: &Overview) -> Bars {
    let ranked = overview.most_frequent_effects();
    let series = BarSeries {
        name: "groups".into(),
        values: ranked.iter().map(|(_, effect)| effect.rows.len() as f64).collect(),
        errors: Vec::new(),
        colour: Colour::Hue(0),
    };
    Bars {
        title: "Groups in which an effect is missing".into(),
        summary: "Number of groups in which each effect is missing".into(),
        axis: Axis::new("groups", ""),
        groups: ranked.iter().map(|(name, _)| (*name).to_owned()).collect(),
        series: vec![series],
        levels: Vec::new(),
    }
}
