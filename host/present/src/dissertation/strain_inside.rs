//! Fig. 5.15 in kind: strain inside a specimen at a high and at a low loading rate, by segments (4.2.3, 7.4.1).

use super::simulated::times;
use palpate_model::{Equilibrium, Segments};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Panels, Plot, Section, Series};

/// v1 of the soft silicone, 1/s (Table 5.2), its height, mm, and the compression, mm.
const RATE: f64 = 0.493;
const HEIGHT: f64 = 30.0;
const COMPRESSION: f64 = 3.0;
/// A high and a low rate, mm/s: the highest of 5.3.1, and one that leaves time.
const SPEEDS: [f64; 2] = [100.0, 2.0];
/// Segments, and length of the hold, s.
const SEGMENTS: usize = 4;
const HOLD: f64 = 60.0;
/// Samples per second.
const SAMPLING: f64 = 500.0;

/// Strain of each segment half way down, at the end of loading and at the end of the hold.
struct Inside {
    speed: f64,
    strains: [Vec<f64>; 3],
}

impl Inside {
    fn new(speed: f64) -> Self {
        let down = COMPRESSION / speed;
        let time = times(down + HOLD, SAMPLING);
        let x: Vec<f64> = time.iter().map(|t| (speed * t).min(COMPRESSION)).collect();
        let segments = Segments {
            count: SEGMENTS,
            rate: RATE,
            exponent: 1.0,
            equilibrium: Equilibrium::OwnNode,
        };
        let nodes = segments.displacements(&time, &x);
        let length = HEIGHT / SEGMENTS as f64;
        let strains = [0.5 * down, down, down + HOLD].map(|at| {
            let k = ((at * SAMPLING).round() as usize).min(time.len() - 1);
            let inner = |segment: usize| nodes.get(segment + 1).map_or(0.0, |node| node[k]);
            (0..SEGMENTS).map(|segment| (nodes[segment][k] - inner(segment)) / length).collect()
        });
        Self { speed, strains }
    }

    /// Of the segment at the contact.
    fn at_contact(&self, instant: usize) -> f64 {
        self.strains[instant][0]
    }
}

/// The figure and what it says.
pub(super) fn section() -> Section {
    let [high, low] = SPEEDS.map(Inside::new);
    Section::new("Strain inside at two loading rates (5.4.3)")
        .figure(
            figure(&[&high, &low]),
            "Fig. 5.15 in kind: strain over depth, from the contact (0) to the far end (1), in four segments. From top to \
             bottom: half way (I), at the end of loading (II), after the hold (III).",
        )
        .callout(
            Callout::Finding,
            "Stiffening without stiffness",
            format!(
                "At the end of loading the surface is strained {} at {} mm/s and {} at {} mm/s, {} times as much: that is the \
                 higher force. {HOLD} s later it is {} and {}; even would be {}.",
                significant(high.at_contact(1), 3),
                high.speed,
                significant(low.at_contact(1), 3),
                low.speed,
                significant(high.at_contact(1) / low.at_contact(1), 3),
                significant(high.at_contact(2), 4),
                significant(low.at_contact(2), 4),
                significant(COMPRESSION / HEIGHT, 3),
            ),
        )
}

fn figure(runs: &[&Inside]) -> Panels {
    // One scale for all, so that even looks even.
    let strains = runs.iter().flat_map(|run| run.strains.iter().flatten());
    let most = 1.05 * strains.copied().fold(0.0, f64::max);
    let panels = Panels::new("")
        .summary("Strain over depth at three instants for a fast and a slow loading: uneven first, even at last");
    (0..3).zip(["I", "II", "III"]).fold(panels, |panels, (instant, name)| {
        let mut plot = Plot::new(
            "",
            Axis::new("depth, of the height", ""),
            Axis { range: Some((0.0, most)), ..Axis::new(format!("strain ({name})"), "") },
        )
        .height(120.0)
        .level(COMPRESSION / HEIGHT * if instant == 0 { 0.5 } else { 1.0 }, "even");
        for (k, run) in runs.iter().enumerate() {
            // A step function from the contact inwards: each value holds to the end of its segment.
            let (mut depth, mut strain) = (Vec::new(), Vec::new());
            for (segment, value) in run.strains[instant].iter().enumerate() {
                depth.extend([segment, segment + 1].map(|it| it as f64 / SEGMENTS as f64));
                strain.extend([*value; 2]);
            }
            let line = Series::line(format!("{} mm/s", run.speed), depth, strain);
            plot = plot.series(line.colour(Colour::Hue(k)));
        }
        panels.plot(if instant == 0 { plot } else { plot.legend(palpate_report::Legend::Hidden) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strain_is_less_even_at_the_higher_rate_and_even_at_last() {
        let [high, low] = SPEEDS.map(Inside::new);
        assert!(high.at_contact(1) > 1.2 * low.at_contact(1));
        for run in [&high, &low] {
            let mean = run.strains[2].iter().sum::<f64>() / SEGMENTS as f64;
            assert!((mean - COMPRESSION / HEIGHT).abs() < 1e-6, "{mean}");
            assert!((run.at_contact(2) / mean - 1.0).abs() < 0.02, "{}", run.at_contact(2));
        }
    }
}
