//! A device: who it is, how it is set, how it is, and what its test of itself found.

use shared::fixed::{celsius, microstrain};
use shared::wire::{Counters, Settings, Status};

use palpate_link::device::change::{Threshold, rate_hz};
use palpate_link::device::describe::{
    clock_in_words, kept_in_words, named, one_line, reset_in_words,
};
use palpate_link::device::heard::Identity;
use palpate_link::device::refusal::Fault;
use palpate_link::device::self_test::{Tested, faults, noise};
use palpate_report::number::significant;
use palpate_report::{Block, Callout, Column, Section, Table};

/// Who a device is, its settings and how it is.
#[must_use]
pub fn device_sections(identity: &Identity, settings: &Settings, status: &Status) -> Vec<Section> {
    let text = |name: &str, value: String| (name.to_owned(), value);
    let mut who = vec![
        text("device", one_line(identity)),
        text("clock", clock_in_words(identity.clock).into()),
        text("reset cause", reset_in_words(identity.reset).into()),
    ];
    if !identity.panic.is_empty() {
        who.push(text("last panic", identity.panic.clone()));
    }
    if let Some(words) = identity.kept.and_then(kept_in_words) {
        who.push(text("settings", words.into()));
    }
    let temperature = status
        .temperature
        .map_or("no sensor".into(), |temperature| format!("{:.1} °C", celsius(temperature)));
    who.push(text("temperature", temperature));
    let health = status.converter.map_or("OK".into(), |fault| Fault(fault).to_string());
    who.push(text("converter", format!("{}, {health}", identity.converter)));
    let capabilities = &identity.capabilities;
    let rates = capabilities.intervals_ns().map(|ns| match capabilities.is_chopped(ns) {
        true => format!("{:.2} chopped", 1e9 / f64::from(ns)),
        false => (1e9 / f64::from(ns)).to_string(),
    });
    who.push(text("rates", format!("{} Hz", rates.collect::<Vec<_>>().join(", "))));
    if status.stack_used > 0 {
        who.push(text("stack used", format!("{} bytes at most", status.stack_used)));
    }
    let mut blocks = vec![Block::Definitions(who)];
    blocks.extend(settings_blocks(settings));
    blocks.push(Block::Table(counters(&status.counters)));
    vec![Section { title: "Device".into(), blocks }]
}

/// The settings of a device.
#[must_use]
pub fn settings_blocks(settings: &Settings) -> Vec<Block> {
    let rate = rate_hz(settings);
    let relaxation = settings.relaxation;
    let filter = format!(
        "c1 {}, v1 {} 1/s, c2 {}, v2 {} 1/s",
        relaxation.c1, relaxation.v1, relaxation.c2, relaxation.v2
    );
    let thresholds = Threshold::ALL
        .map(|(threshold, name, unit)| format!("{name} {} {unit}", threshold.of(settings)));
    let mut gauges = Table::new(
        "",
        vec![
            Column::text("Gauge"),
            Column::whole("Gain"),
            Column::number("Calibration", "µε per 1000 counts"),
            Column::whole("Offset (counts)"),
            Column::number("Tare", "µε"),
        ],
    );
    for (gauge, sheet) in settings.calibration.iter().enumerate() {
        gauges = gauges.row([
            (gauge + 1).to_string(),
            settings.gain[gauge].to_string(),
            significant(sheet.gain * 1e3, 6),
            sheet.offset.to_string(),
            format!("{:.1}", microstrain(settings.tare[gauge])),
        ]);
    }
    vec![
        Block::Definitions(vec![
            ("rate".into(), format!("{rate} Hz")),
            ("filter".into(), filter),
            ("thresholds".into(), thresholds.join(", ")),
        ]),
        Block::Table(gauges),
    ]
}

fn counters(counters: &Counters) -> Table {
    let columns = vec![Column::text("Lost since the reset"), Column::whole("Count")];
    named(counters).into_iter().fold(Table::new("", columns), |table, (name, count)| {
        table.row([name.replace('_', " "), count.to_string()])
    })
}

/// What a self-test found.
#[must_use]
pub fn self_test_sections(tested: &Tested, settings: &Settings) -> Vec<Section> {
    let test = &tested.gauges;
    let mut table = Table::new(
        "",
        vec![
            Column::text("Gauge"),
            Column::whole("Mean (counts)"),
            Column::number("Noise", "counts"),
            Column::number("Noise", "µε"),
        ],
    )
    .note(format!(
        "{} samples, at {:.4} times the rate that is set",
        test.samples, test.rate_ratio
    ));
    for (gauge, noise) in noise(tested, settings).into_iter().enumerate() {
        table = table.row([
            (gauge + 1).to_string(),
            test.mean_counts[gauge].to_string(),
            format!("{:.1}", test.noise_counts[gauge]),
            format!("{noise:.3}"),
        ]);
    }
    if let Some(own) = &tested.own {
        let noise = own.shorted.noise_counts.iter().copied().fold(0.0, f32::max);
        table = table.note(format!(
            "The converter alone: inputs joined, {:.2} % of full scale at most, noise of {noise:.1} counts at most; its own test \
             signal, {:.4} of what it is",
            100.0 * own.offset(),
            own.signal_ratio()
        ));
    }
    let kind = Callout::Warning;
    let warn = |text| Block::Callout { kind, title: String::new(), text };
    let blocks = std::iter::once(Block::Table(table)).chain(faults(tested).into_iter().map(warn));
    vec![Section { title: "Self-test".into(), blocks: blocks.collect() }]
}
