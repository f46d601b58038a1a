//! What a simulated fingertip felt: a press, tones, a slide, a pull, shaking.

use palpate_contact::sensor::{
    Fingertip, Indenter, PressResult, Response, SlideResult, SlipResult, Tone, TonesResult, Touch,
};
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Legend, Panels, Plot, Section, Series, Table};
use palpate_trace::GAUGES;

/// What was pressed with what, and the relaxation that its readings follow.
fn specimen(fingertip: &Fingertip, indenter: Indenter) -> String {
    let silicone = &fingertip.silicone;
    let g = fingertip.relaxation_of_readings();
    format!(
        "Silicone and thinner {}, {} mm thick, gauges below {} mm: modulus {} kPa at once, {} kPa settled. Readings \
         relax with shares {} and {}, rates {} and {} 1/s. The tip has a radius of {} mm.",
        silicone.composition,
        fingertip.thickness_mm,
        fingertip.cover_mm,
        significant(silicone.elastic.modulus_pa * 1e-3, 3),
        significant(silicone.elastic.modulus_pa * silicone.relaxation.c0() * 1e-3, 3),
        significant(g.c1, 3),
        significant(g.c2, 3),
        significant(g.v1, 3),
        significant(g.v2, 3),
        indenter.radius_mm,
    )
}

/// A press in words, as a table and as a figure.
#[must_use]
pub fn sensor_press_sections(
    fingertip: &Fingertip,
    indenter: Indenter,
    result: &PressResult,
) -> Vec<Section> {
    let columns = vec![
        Column::text("gauge"),
        Column::number("peak", "µε"),
        Column::number("end of hold", "µε"),
        Column::number("cut off after", "s"),
        Column::number("after release", "µε"),
        Column::number("half gone after", "s"),
        Column::number("peak of FA", "µε"),
    ];
    let or_dash = |value: Option<f64>| value.map_or("–".into(), |value| significant(value, 3));
    let mut table = Table::new("A press, felt by four gauges", columns);
    for (k, felt) in result.felt.iter().enumerate() {
        table = table.row([
            (k + 1).to_string(),
            significant(felt.peak, 4),
            significant(felt.end_of_hold, 4),
            or_dash(felt.saturated_after_s),
            significant(felt.left, 3),
            or_dash(felt.half_recovered_s),
            significant(felt.peak_fa, 3),
        ]);
    }
    let limit = significant(fingertip.limit_ustrain, 4);
    let table = table.note(format!(
        "Readings are cut off at {limit} µε. After release: when the indenter has just left, and how long until half of that is gone."
    ));
    let depth = format!(
        "The indenter went {} mm deep; the force reached {} N.",
        significant(result.depth_mm, 3),
        significant(result.peak_force_n, 3)
    );
    let section = Section::new("A press")
        .paragraph(specimen(fingertip, indenter))
        .paragraph(depth)
        .table(table)
        .figure(press_figure(result), "What the gauges read, and FA and SA of the first.");
    let cut = result.felt.iter().filter(|felt| felt.saturated_after_s.is_some()).count();
    vec![if cut > 0 {
        let words =
            format!("{cut} of 4 gauges were at their limit. Press less, or with a blunter tip.");
        section.callout(Callout::Warning, "Saturated", words)
    } else {
        section
    }]
}

fn press_figure(result: &PressResult) -> Panels {
    let trace = &result.touch.trace;
    let time = || Axis::new("Time", "s");
    let mut readings = Plot::new("", time(), Axis::new("Reading", "µε"));
    for (k, name) in GAUGES.into_iter().enumerate() {
        let values = trace.column(name).unwrap_or_default();
        let line = Series::line(format!("gauge {}", k + 1), &trace.time[..], values);
        readings = readings.series(line.colour(Colour::Hue(k)));
    }
    let [first, ..] = &result.channels;
    let parts = Plot::new("", time(), Axis::new("Gauge 1", "µε"))
        .series(Series::line("FA", &trace.time[..], &first.fa[..]))
        .series(Series::line("SA", &trace.time[..], &first.sa[..]).colour(Colour::Hue(1)));
    let force = trace.force().unwrap_or_default();
    let force = Plot::new("", time(), Axis::new("Force", "N"))
        .series(Series::line("force", &trace.time[..], force))
        .height(110.0);
    Panels::new("A press, felt by a simulated fingertip")
        .summary("Readings of four gauges, FA and SA of the first, and the force over time")
        .plot(readings)
        .plot(parts)
        .plot(force)
}

/// Gain and phase over frequency in words, as a table and as a figure.
#[must_use]
pub fn sensor_tones_sections(
    fingertip: &Fingertip,
    indenter: Indenter,
    result: &TonesResult,
) -> Vec<Section> {
    let columns = vec![
        Column::number("frequency", "Hz"),
        Column::number("gain of FA", ""),
        Column::number("phase of FA", "°"),
        Column::number("gain of SA", ""),
        Column::number("phase of SA", "°"),
        Column::number("from the formula", ""),
    ];
    let mut table = Table::new("FA and SA over frequency", columns);
    for tone in &result.tones {
        table = table.row([
            significant(tone.frequency_hz, 3),
            significant(tone.fa.gain, 3),
            format!("{:.1}", tone.fa.phase_deg),
            significant(tone.sa.gain, 3),
            format!("{:.1}", tone.sa.phase_deg),
            format!("{:.5}", tone.distance),
        ]);
    }
    let table = table.note(
        "Relative to what silicone without memory would read. Last column: largest distance of FA and SA from the formula of the filter, in the complex plane.",
    );
    let g = fingertip.relaxation_of_readings();
    let corner = g.v1 / std::f64::consts::TAU;
    let words = format!(
        "FA passes what is faster than {} Hz, the rate of the fast mode over 2π, and reaches the share {} there; SA passes all, \
         from {} slow to {} fast. Above that corner both are flat: what changes with frequency below it is the material's own.",
        significant(corner, 3),
        significant(g.c1, 3),
        significant(g.c0(), 3),
        significant(g.c0() + g.c2, 3),
    );
    vec![
        Section::new("Tones")
            .paragraph(specimen(fingertip, indenter))
            .paragraph(words)
            .table(table)
            .figure(tones_figure(&result.tones), "Points: measured. Lines: the filter's formula."),
    ]
}

/// Gain and phase of measured tones, and of the filter's formula.
pub(crate) fn tones_figure(tones: &[Tone]) -> Panels {
    let frequency = || Axis::new("Frequency", "Hz").log();
    let over = |value: fn(&Response) -> f64, of: fn(&Tone) -> &Response| {
        tones.iter().map(|tone| value(of(tone))).collect::<Vec<f64>>()
    };
    let at: Vec<f64> = tones.iter().map(|tone| tone.frequency_hz).collect();
    let plot = |axis: Axis, value: fn(&Response) -> f64| {
        Plot::new("", frequency(), axis)
            .series(Series::line("FA, formula", &at[..], over(value, |tone| &tone.fa_formula)))
            .series(
                Series::line("SA, formula", &at[..], over(value, |tone| &tone.sa_formula))
                    .colour(Colour::Hue(1)),
            )
            .series(Series::points("FA", &at[..], over(value, |tone| &tone.fa)))
            .series(
                Series::points("SA", &at[..], over(value, |tone| &tone.sa)).colour(Colour::Hue(1)),
            )
    };
    Panels::new("FA and SA over frequency")
        .summary("Gain and phase of the fast and slow adapting channels from slow to fast stimuli")
        .plot(plot(Axis::new("Gain", "").log(), |response| response.gain))
        .plot(plot(Axis::new("Phase", "°"), |response| response.phase_deg).legend(Legend::Hidden))
}

/// A slide in words and as figures.
#[must_use]
pub fn sensor_slide_sections(
    fingertip: &Fingertip,
    indenter: Indenter,
    result: &SlideResult,
) -> Vec<Section> {
    let line = match result.line {
        Some((frequency, amplitude)) => format!(
            "Ridges pass at {} Hz. The highest line of FA is at {} Hz, {} µε high. The contact lets {} of the ridges' wave through: a wide contact covers several ridges at once.",
            significant(result.expected_hz, 4),
            significant(frequency, 4),
            significant(amplitude, 3),
            percent(result.through_contact.abs(), 2),
        ),
        None => "The spectrum of FA does not reach the frequency of the ridges.".into(),
    };
    vec![
        Section::new("A slide over the fingerprint")
            .paragraph(specimen(fingertip, indenter))
            .paragraph(line)
            .figure(slide_figure(result), "Gauge 1.")
            .figure(spectrum_figure(result), "Spectrum of FA of gauge 1."),
    ]
}

fn slide_figure(result: &SlideResult) -> Panels {
    let trace = &result.touch.trace;
    let time = || Axis::new("Time", "s");
    let reading = trace.column(GAUGES[0]).unwrap_or_default();
    Panels::new("A slide over the fingerprint")
        .summary("The reading of the first gauge, and its fast adapting part, over time")
        .plot(Plot::new("", time(), Axis::new("Reading", "µε")).series(Series::line(
            "reading",
            &trace.time[..],
            reading,
        )))
        .plot(Plot::new("", time(), Axis::new("FA", "µε")).series(Series::line(
            "FA",
            &trace.time[..],
            &result.channels.fa[..],
        )))
}

/// The spectrum of FA, with the frequency at which ridges pass.
pub(crate) fn spectrum_figure(result: &SlideResult) -> Plot {
    let spectrum = &result.spectrum;
    let (x, y) = (Axis::new("Frequency", "Hz").log(), Axis::new("Amplitude of FA", "µε").log());
    Plot::new("Spectrum of FA", x, y)
        .summary("Amplitude of the fast adapting part over frequency")
        .series(Series::line("FA", &spectrum.frequency_hz[1..], &spectrum.amplitude[1..]))
        .mark(result.expected_hz, "speed / period")
}

/// A pull until it slides in words and as a figure.
#[must_use]
pub fn sensor_slip_sections(
    fingertip: &Fingertip,
    indenter: Indenter,
    result: &SlipResult,
) -> Vec<Section> {
    let first = result.let_go_s.first().copied().unwrap_or(result.slides_s);
    let words = format!(
        "The contact has a radius of {} mm and holds by {} nubs. The first at the rim lets go at {:.3} s, the whole slides at \
         {:.3} s: {} ms are left between them.",
        significant(result.contact_mm, 3),
        result.let_go_s.len(),
        first,
        result.slides_s,
        significant(1e3 * (result.slides_s - first), 3),
    );
    let marks = [(first, "rim slips"), (result.slides_s, "slides")];
    vec![
        Section::new("A pull until it slides")
            .paragraph(specimen(fingertip, indenter))
            .paragraph(words)
            .figure(
                readings_figure("A pull until it slides", &result.touch, &marks),
                "What the gauges read.",
            ),
    ]
}

/// A fingertip that shakes in words and as a figure.
#[must_use]
pub fn sensor_shake_sections(
    fingertip: &Fingertip,
    indenter: Indenter,
    touch: &Touch,
) -> Vec<Section> {
    vec![
        Section::new("Held while it shakes")
            .paragraph(specimen(fingertip, indenter))
            .figure(readings_figure("Held while it shakes", touch, &[]), "What the gauges read."),
    ]
}

/// Readings of all gauges over time.
fn readings_figure(title: &str, touch: &Touch, marks: &[(f64, &str)]) -> Plot {
    let trace = &touch.trace;
    let mut plot = Plot::new(title, Axis::new("Time", "s"), Axis::new("Reading", "µε"))
        .summary("Readings of four gauges over time");
    for (k, name) in GAUGES.into_iter().enumerate() {
        let values = trace.column(name).unwrap_or_default();
        let line = Series::line(format!("gauge {}", k + 1), &trace.time[..], values);
        plot = plot.series(line.colour(Colour::Hue(k)));
    }
    marks.iter().fold(plot, |plot, (at, words)| plot.mark(*at, *words))
}
