//! One press in words, tables and plots.

use super::{
    CONCISE, FitSummary, concise, estimate, hold_sections, name_of, part_panels, region_spans,
    region_table, shaded, unit_of,
};
use palpate_analysis::press::Press;
use palpate_analysis::regions::{numeral, type_name};
use palpate_fit::exponentials::Parameter;
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::{FORCE, GAUGES, Trace, pooled_noise};

/// The whole press: what was done, the regions, FA and SA, relaxation and creep, the model.
#[must_use]
pub fn press_sections(trace: &Trace, press: &Press) -> Vec<Section> {
    let traces = std::slice::from_ref(trace);
    let mut sections = vec![overview(trace, press), parts(trace, press)];
    sections.push(relaxation(trace, press));
    sections.push(recovery(trace, press));
    let summary = FitSummary {
        fit: &press.fit,
        data: &press.data,
        signal: FORCE,
        noise: pooled_noise(traces, FORCE),
        held_out: &[],
        candidates: &[],
    };
    sections.extend(summary.sections());
    sections
}

/// What was done, what answered, and where the regions lie.
fn overview(trace: &Trace, press: &Press) -> Section {
    let section = Section::new("The press").paragraph(format!(
        "A {}: {} samples over {} s, {} gauges. The six regions are those of Fig. 3.10: OA preloading, \
         AB loading, BC transition, CD relaxation, DE unloading, EF recovery.",
        trace.head.name.as_deref().unwrap_or("a press"),
        trace.len(),
        significant(trace.duration(), 4),
        trace.gauges().len(),
    ));
    let Some((channel, regions)) = press.channels.first() else { return section };
    let spans = region_spans(trace, regions);
    let time = || Axis::new("time", "s");
    let mut panels = Panels::new("Motion, force and gauges").summary("The recording over time");
    for name in ["displacement_mm", FORCE] {
        if let Some(values) = trace.column(name) {
            let line =
                Series::line(name_of(name), &trace.time[..], values).colour(Colour::MEASURED);
            let plot = Plot::new("", time(), Axis::new(name_of(name), unit_of(name))).series(line);
            let labelled = panels.plots.is_empty();
            panels = panels.plot(shaded(plot.height(150.0), &spans, labelled));
        }
    }
    let mut gauges = Plot::new("", time(), Axis::new("strain", "µε")).height(190.0);
    for (hue, name) in GAUGES.into_iter().enumerate() {
        if let Some(values) = trace.column(name) {
            let line = Series::line(name_of(name), &trace.time[..], values);
            gauges = gauges.series(line.colour(Colour::Hue(hue)));
        }
    }
    section.figure(panels.plot(shaded(gauges, &spans, false)), "").table(region_table(
        trace,
        channel,
        &regions.stretches(),
    ))
}

/// FA and SA of every gauge.
fn parts(trace: &Trace, press: &Press) -> Section {
    let relaxation = &press.relaxation;
    let text = format!(
        "Every sample went through the filter of the device, in the device's 24-bit numbers, set to the \
         relaxation function that was fitted to the force: c0 {:.3}, c1 {:.3} at {:.3} 1/s, c2 {:.3} at {:.3} 1/s. \
         FA + SA is the signal, bit for bit.",
        relaxation.c0(),
        relaxation.c1,
        relaxation.v1,
        relaxation.c2,
        relaxation.v2
    );
    Section::new("Fast and slow adapting parts").paragraph(text).figure(
        part_panels(trace, &press.channels),
        "FA (fast adapting) answers to change and is gone in a steady hold; SA (slow adapting) keeps what is \
         held. The equilibrium is where the signal would settle if the motion stopped.",
    )
}

/// Type I and Type II, of the force and of every gauge.
fn relaxation(trace: &Trace, press: &Press) -> Section {
    let traces = std::slice::from_ref(trace);
    let mut section = Section::new("Relaxation: Type I and Type II").paragraph(
        "After loading a held specimen pushes ever less (Type I); after partial unloading it pushes ever more \
         (Type II). Both are one process: the latent part on its way to zero (4.2.1).",
    );
    for hold in &press.force_holds {
        section = section.callout(
            Callout::Finding,
            type_name(hold.relaxation),
            format!(
                "the hold at {} mm from {:.2} s is of Type {}: the force goes from {} N towards {} N",
                hold.displacement.map_or("?".into(), |x| significant(x, 3)),
                hold.from_s,
                numeral(hold.relaxation),
                significant(hold.fit.sum.scale, 3),
                significant(hold.fit.sum.scale * hold.fit.sum.constant, 3),
            ),
        );
    }
    for part in hold_sections(&press.force_holds, &[], traces, FORCE) {
        section.blocks.extend(part.blocks);
    }
    section.table(gauge_table(press))
}

fn gauge_table(press: &Press) -> Table {
    let parameters: Vec<Parameter> = Parameter::all(2).collect();
    let columns = [Column::text("gauge"), Column::number("from", "s"), Column::text("type")]
        .into_iter()
        .chain(parameters.iter().map(|parameter| {
            let unit = match parameter {
                Parameter::Scale => "µε",
                Parameter::Coefficient(_) => "",
                Parameter::Rate(_) => "1/s",
            };
            Column::number(parameter.to_string(), unit)
        }))
        .collect();
    let mut table = Table::new("The same holds as each gauge sees them", columns);
    let holds = press.gauge_holds.len() / press.channels.len().max(1);
    for (index, hold) in press.gauge_holds.iter().enumerate() {
        let gauge =
            press.channels.get(index / holds.max(1)).map_or("", |(channel, _)| &channel.signal);
        let cells = parameters.iter().map(|&parameter| {
            hold.fit
                .value(parameter)
                .map_or("–".into(), |value| concise(value, hold.fit.standard_error(parameter)))
        });
        let head = [name_of(gauge), format!("{:.2}", hold.from_s), numeral(hold.relaxation).into()];
        table = table.row(head.into_iter().chain(cells));
    }
    table.note(CONCISE)
}

/// What the gauges show after the release.
fn recovery(trace: &Trace, press: &Press) -> Section {
    let columns = vec![
        Column::text("gauge"),
        Column::number("from", "s"),
        Column::number("left at the release", "µε"),
        Column::number("time constant", "s"),
        Column::number("R²", ""),
    ];
    let mut table = Table::new("Creep after the release", columns);
    let axes = (Axis::new("time since the release", "s"), Axis::new("strain", "µε"));
    let mut plot = Plot::new("Creep after the release", axes.0, axes.1)
        .summary("Gauge signals after contact is lost, with the fitted exponentials");
    for (hue, recovery) in press.recoveries.iter().enumerate() {
        let fit = &recovery.fit;
        let rate = fit.value(Parameter::Rate(1)).unwrap_or(f64::NAN);
        let rate_error = fit.standard_error(Parameter::Rate(1));
        table = table.row([
            name_of(&recovery.signal),
            format!("{:.2}", recovery.from_s),
            estimate(fit.sum.scale, fit.standard_error(Parameter::Scale)),
            estimate(1.0 / rate, rate_error.map(|error| error / (rate * rate))),
            format!("{:.4}", fit.r_squared),
        ]);
        let Some((channel, _)) = press.channels.iter().find(|(c, _)| c.signal == recovery.signal)
        else {
            continue;
        };
        let shown =
            trace.time.iter().zip(&channel.input).filter(|(time, _)| **time >= recovery.from_s);
        let (time, values): (Vec<f64>, Vec<f64>) =
            shown.map(|(time, value)| (time - recovery.from_s, *value)).unzip();
        let fitted: Vec<f64> = time.iter().map(|&time| fit.sum.at(time)).collect();
        plot = plot
            .series(
                Series::points(name_of(&recovery.signal), time.clone(), values)
                    .colour(Colour::Hue(hue)),
            )
            .series(Series::line("", time, fitted).colour(Colour::Hue(hue)).width(2.0));
    }
    Section::new("Creep after the release")
        .paragraph(
            "Contact is lost and the force is zero, but the silicone still recovers (3.4.1.6), and the gauges in \
             it show how fast.",
        )
        .table(table)
        .figure(plot, "")
}
