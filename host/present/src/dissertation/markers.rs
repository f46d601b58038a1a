//! Markers on a silicone that is held (4.3, 5.3.2.1): Figs 4.6, 4.7 and 5.4 in kind, and the law found from the markers alone.

use super::simulated::{noisy, times, trace};
use crate::summary::{markers_figure, markers_sections};
use palpate_analysis::markers::{Study, markers};
use palpate_analysis::strain_rate::Order;
use palpate_model::{Equilibrium, Segments};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Panels, Plot, Section, Series};
use palpate_trace::{Control, Trace};

/// v1 of the soft silicone of Table 5.2, 1/s; its modulus there, as N/mm², and area, mm².
const RATE: f64 = 0.493;
const MODULUS: f64 = 3.497e-2;
const AREA: f64 = 1963.5;
/// Height, mm, compression, mm, speed of loading, mm/s, and length of the hold, s.
const HEIGHT: f64 = 30.0;
const COMPRESSION: f64 = 3.0;
const SPEED: f64 = 100.0;
const HOLD: f64 = 30.0;
/// Frames per second (6.3.1), and scatter of a marker's place, mm: half of the camera's 50 µm.
const FRAMES: f64 = 120.0;
const SCATTER: f64 = 0.025;
const NODES: usize = 5;

/// The silicone with markers on its nodes, and what `palpate markers` finds from them.
pub(super) fn section() -> Section {
    let trace = recording();
    let study = markers(std::slice::from_ref(&trace), Order::Fixed(1.0));
    let section = Section::new("Markers seen by a camera (4.3, 5.3.2.1)").paragraph(format!(
        "A cylinder of the soft silicone of Table 5.2, {HEIGHT} mm high, is pressed by {COMPRESSION} mm at {SPEED} mm/s \
         and held; {NODES} nodes relax by (4.11) with v1 = {RATE} 1/s. A camera of {FRAMES} frames a second sees a marker on \
         the jaw and on each inner node, within {SCATTER} mm. `palpate markers` fits the latency model to the gaps, from the markers alone."
    ));
    let section = section.figure(
        course(&trace),
        "Figs 4.7 and 5.4 in kind: the jaws stand, the force relaxes, the markers still move.",
    );
    let Ok(study) = study else { return section };
    let section = match study.gaps.first() {
        Some(gap) => section.figure(
            markers_figure(gap),
            "Fig. 4.6 in kind: the gap next to the moving jaw, which all of the movement closed, and the linear latency model fitted to it.",
        ),
        None => section,
    };
    let table = markers_sections(&study).into_iter().flat_map(|section| section.blocks);
    let table = table.filter(|block| matches!(block, palpate_report::Block::Table(_)));
    let section = table.fold(section, Section::block);
    section.callout(Callout::Finding, "What the markers show", words(&study))
}

fn recording() -> Trace {
    let time = times(1.0 + COMPRESSION / SPEED + HOLD, FRAMES);
    let x: Vec<f64> = time.iter().map(|t| (SPEED * (t - 1.0)).clamp(0.0, COMPRESSION)).collect();
    let segments =
        Segments { count: NODES, rate: RATE, exponent: 1.0, equilibrium: Equilibrium::Common };
    let latent = segments.at_contact(&time, &x);
    let force = x.iter().zip(&latent).map(|(x, y)| MODULUS * AREA * (x + y) / HEIGHT).collect();
    let nodes = segments.displacements(&time, &x);
    let mut made = trace("markers", Control::Displacement, time, x, force);
    // Places from the moving jaw on: each node lies a part of the height deeper.
    for (node, moved) in nodes.into_iter().enumerate() {
        let place = HEIGHT * node as f64 / NODES as f64;
        let seen = moved.iter().map(|moved| place + moved).collect();
        made.set_column(format!("marker{}_mm", node + 1), noisy(seen, SCATTER, node as u64));
    }
    made
}

fn course(trace: &Trace) -> Panels {
    let time = || Axis::new("time", "s");
    let force = trace.force().unwrap_or_default();
    let mut places = Plot::new("", time(), Axis::new("place from where the jaw began", "mm"));
    for (k, name) in palpate_analysis::markers::columns(trace).iter().enumerate() {
        let values = trace.column(name).unwrap_or_default();
        let line = Series::line(format!("marker {}", k + 1), &trace.time[..], values);
        places = places.series(line.colour(Colour::Hue(k)));
    }
    Panels::new("")
        .summary("Force and places of five markers over time: both go on changing in the hold")
        .plot(
            Plot::new("", time(), Axis::new("force", "N"))
                .series(Series::line("", &trace.time[..], force).colour(Colour::MEASURED)),
        )
        .plot(places)
}

fn words(study: &Study) -> String {
    let told: Vec<f64> = study
        .gaps
        .iter()
        .filter_map(|gap| Some((gap.fit.rate.0 / RATE).ln().abs() / gap.fit.rate.1?))
        .collect();
    let rates: Vec<String> = study.gaps.iter().map(|gap| significant(gap.fit.rate.0, 3)).collect();
    let within = told.iter().filter(|off| **off < 3.0).count();
    format!(
        "From {} gaps v1 comes out as {} 1/s; {within} of them lie within three standard errors of the {RATE} 1/s of the force's \
         relaxation. Inside and contact follow one law: what a camera sees gives the rate without a load cell.",
        study.gaps.len(),
        rates.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_of_the_force_is_found_from_the_markers() {
        let study = markers(&[recording()], Order::Fixed(1.0)).unwrap();
        assert_eq!(study.gaps.len(), NODES - 1);
        for gap in &study.gaps {
            let error = gap.fit.rate.1.unwrap();
            assert!((gap.fit.rate.0 / RATE).ln().abs() < 4.0 * error, "{:?}", gap.fit.rate);
        }
    }
}
