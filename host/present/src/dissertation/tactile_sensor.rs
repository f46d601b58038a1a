//! Section 8.2.1: a tactile sensor of silicone with four gauges in it.

use super::Chapter;
use crate::summary::{spectrum_figure, tones_figure};
use palpate_contact::sensor::{
    Fingertip, Indenter, Press, PressResult, SensorError, Silicone, Slide, SlideResult, TABLE_8_2,
    Tones, TonesResult,
};
use palpate_report::number::significant;
use palpate_report::{Axis, Colour, Column, Plot, Section, Series, Table};
use palpate_trace::GAUGES;

/// Seed of everything here.
const SEED: u64 = 8;
/// Speeds of the slides, mm/s.
const SPEEDS: [f64; 4] = [10.0, 20.0, 40.0, 80.0];

/// The sensor of section 8.2.1 simulated: the specimens of Table 8.2 under a sharp and a blunt indenter, their answer to
/// tones, and what a fingerprint adds.
///
/// # Errors
/// [`SensorError`] if a specimen cannot be simulated, which would be a fault of this program.
pub fn chapter() -> Result<Chapter, SensorError> {
    let presses = presses()?;
    let tones = Tones::default().run(&specimen("7:3", 4.0)?, SEED)?;
    let slides = slides()?;
    let sections = vec![introduction(), indenters(&presses), frequencies(&tones), ridges(&slides)];
    Ok(Chapter { title: "Chapter 8: a tactile sensor", comparisons: Vec::new(), sections })
}

fn specimen(composition: &str, thickness_mm: f64) -> Result<Fingertip, SensorError> {
    Fingertip::new(Silicone::of(composition.parse()?), thickness_mm)
}

/// Each specimen of Table 8.2 with both indenters.
fn presses() -> Result<Vec<(Fingertip, Indenter, PressResult)>, SensorError> {
    let mut presses = Vec::new();
    for (composition, thickness_mm) in TABLE_8_2 {
        for indenter in [Indenter::SHARP, Indenter::BLUNT] {
            let fingertip = specimen(composition, thickness_mm)?;
            let press = Press::over_first_gauge(&fingertip, indenter).run(&fingertip, SEED)?;
            presses.push((fingertip, indenter, press));
        }
    }
    Ok(presses)
}

fn slides() -> Result<Vec<(f64, SlideResult)>, SensorError> {
    let fingertip = specimen("7:3", 4.0)?;
    let slide = |speed_mm_per_s| {
        let slide = Slide { speed_mm_per_s, ..Slide::over_first_gauges(&fingertip) };
        Ok((speed_mm_per_s, slide.run(&fingertip, SEED)?))
    };
    SPEEDS.into_iter().map(slide).collect()
}

fn introduction() -> Section {
    Section::new("A fingertip with four gauges")
        .paragraph(
            "Skin has receptors that adapt fast and others that adapt slowly (Table 8.1 lists two classes of each), and \
             viscoelastic material has a fast and a slow time constant. The proposal is a sensor that uses one for the other: \
             strain gauges between two layers of silicone. Four specimens were made, pressed with a sharp and a blunt \
             indenter; a study of frequencies and of a fingerprint were left for later. Here the sensor is simulated, so that \
             what was seen can be asked for its cause, and what was left can be tried.",
        )
        .paragraph(
            "The simulation is our own physics: Hertz's contact on a layer of silicone, Huber's stress at the gauge, the \
             relaxation of eq. 3.4, stiffness and slow rate between those of Table 5.2. What Table 8.2 and Figs 8.3 and 8.4 do \
             not say is assumed: the depth of the gauges (half the thickness), the radii of the tips (0.5 and 5 mm), how much \
             of the silicone's strain a foil takes up. Figures are redrawn in kind, not in number.",
        )
}

fn indenters(presses: &[(Fingertip, Indenter, PressResult)]) -> Section {
    let columns = vec![
        Column::text("silicone:thinner"),
        Column::number("thickness", "mm"),
        Column::text("tip"),
        Column::number("depth", "mm"),
        Column::number("peak", "µε"),
        Column::number("cut off after", "s"),
        Column::number("after release", "µε"),
        Column::number("half gone after", "s"),
    ];
    let caption = "The specimens of Table 8.2 pressed to 0.2 N above a gauge";
    let mut table = Table::new(caption, columns);
    let or_dash = |value: Option<f64>| value.map_or("–".into(), |value| significant(value, 2));
    for (fingertip, indenter, press) in presses {
        let felt = press.felt[0];
        table = table.row([
            fingertip.silicone.composition.to_string(),
            significant(fingertip.thickness_mm, 1),
            tip(*indenter).into(),
            significant(press.depth_mm, 3),
            significant(felt.peak, 4),
            or_dash(felt.saturated_after_s),
            significant(felt.left, 3),
            or_dash(felt.half_recovered_s),
        ]);
    }
    Section::new("Sharp and blunt")
        .paragraph(
            "Both tips are pressed until the fingertip bears the same force. Below the sharp one stress is concentrated: in the \
             thin soft specimen its gauge is at the converter's limit before the press is over, while the blunt tip stays \
             within range. A thicker or stiffer specimen has room for both. After the indenter has left, every specimen creeps: \
             the dent is free of force but not gone, and the gauge below still feels it. That agrees with what was observed of \
             both tips.",
        )
        .figure(figure_8_4(presses), "Fig. 8.4 in kind: the gauge below the tip, specimen 1 of Table 8.2.")
        .table(table)
}

fn tip(indenter: Indenter) -> &'static str {
    if indenter == Indenter::SHARP { "sharp" } else { "blunt" }
}

fn figure_8_4(presses: &[(Fingertip, Indenter, PressResult)]) -> Plot {
    let (x, y) = (Axis::new("Time", "s"), Axis::new("Reading of gauge 1", "µε"));
    let mut plot = Plot::new("A press with a sharp and a blunt tip", x, y)
        .summary("The sharp tip's reading is cut off at the limit, the blunt one's is not; both creep after the release");
    for (hue, (_, indenter, press)) in presses.iter().take(2).enumerate() {
        let trace = &press.touch.trace;
        let reading = trace.column(GAUGES[0]).unwrap_or_default();
        let line = Series::line(tip(*indenter), &trace.time[..], reading);
        plot = plot.series(line.colour(Colour::Hue(hue)));
    }
    match presses.first() {
        Some((fingertip, _, _)) => plot.level(fingertip.limit_ustrain, "limit"),
        None => plot,
    }
}

fn frequencies(tones: &TonesResult) -> Section {
    let farthest = tones.tones.iter().map(|tone| tone.distance).fold(0.0, f64::max);
    Section::new("Stimuli of different frequency")
        .paragraph(format!(
            "Tones from 0.1 to 400 Hz about a mean depth, through the filter that runs on the device. FA is small for slow \
             stimuli and grows to the share of the fast mode within a decade about its rate; SA passes all. Measured gains and \
             phases lie on the filter's own formula within {} of the reading. The expectation that the material shows itself \
             in its answer to frequency holds below some 10 Hz, where the modes are; above, both channels are flat and show no \
             more of it.",
            significant(farthest, 2)
        ))
        .figure(tones_figure(&tones.tones), "Points: measured through the device's filter. Lines: its formula.")
}

fn ridges(slides: &[(f64, SlideResult)]) -> Section {
    let columns = vec![
        Column::number("speed", "mm/s"),
        Column::number("speed / period", "Hz"),
        Column::number("line of FA", "Hz"),
        Column::number("its amplitude", "µε"),
    ];
    let mut table = Table::new("A tip slides over ridges of 0.5 mm", columns);
    for (speed, slide) in slides {
        let (frequency, amplitude) = slide.line.unwrap_or((f64::NAN, f64::NAN));
        table = table.row([
            significant(*speed, 3),
            significant(slide.expected_hz, 3),
            significant(frequency, 3),
            significant(amplitude, 2),
        ]);
    }
    let mut section = Section::new("A fingerprint").paragraph(
        "Ridges turn a slide into a vibration of frequency speed over period, and FA hears it: a fingertip knows how fast it is \
         slid over. The contact must be narrow, though. A tip that covers several ridges at once averages them away: their wave \
         comes through as 3 (sin q − q cos q)/q³ with q = 2π × contact radius / period.",
    );
    if let Some((_, slide)) = slides.get(1) {
        section =
            section.figure(spectrum_figure(slide), "FA of the gauge below the path, 20 mm/s.");
    }
    section.table(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_contact::sensor::Composition;

    #[test]
    fn every_figure_agrees_and_what_was_observed_is_seen() {
        for (share, rate, stiffness) in [(0.9, 0.695, 1.221e5), (0.5, 0.493, 3.497e4)] {
            let silicone = Silicone::of(Composition::new(share).unwrap());
            let settled = silicone.elastic.modulus_pa * silicone.relaxation.c0();
            assert!((silicone.relaxation.v2 - rate).abs() < 1e-9, "Table 5.2");
            assert!((settled - stiffness).abs() < 1e-3, "Table 5.2");
        }
        let presses = presses().unwrap();
        let [(_, _, sharp), (_, _, blunt), ..] = &presses[..] else { panic!("eight presses") };
        assert!(sharp.felt[0].saturated_after_s.is_some_and(|after| after < 0.2));
        assert_eq!(blunt.felt[0].saturated_after_s, None);
        for (_, _, press) in &presses {
            let felt = press.felt[0];
            assert!(felt.left > 0.02 * felt.peak && felt.half_recovered_s.is_some(), "{felt:?}");
        }
    }

    #[test]
    fn every_slide_hums_at_speed_over_period() {
        for (_, slide) in slides().unwrap() {
            let (frequency, _) = slide.line.unwrap();
            assert!((frequency / slide.expected_hz - 1.0).abs() < 0.03, "{frequency}");
        }
    }
}
