//! Figs 6.3 to 6.5 in kind: a PI controller keeps a force, four markers creep inside, the force is filtered, and two
//! exponentials are fitted to each hold (6.3).

use super::simulated::{noisy, trace};
use palpate_analysis::conditioning::Butterworth;
use palpate_analysis::creep::{Hold, creep};
use palpate_analysis::regions::numeral;
use palpate_fit::hold::Terms;
use palpate_model::{
    BaseLaw, Equilibrium, Family, ForceProfile, ForceStep, Loading, Segments, Separation,
};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::{Control, DISPLACEMENT, Trace};

/// A specimen that creeps: where it ends at 2 N, mm, and the share and rate, 1/s, of each exponential.
struct Specimen {
    settled: f64,
    terms: &'static [(f64, f64)],
}

/// (B.2), two exponentials, and (B.1), one.
const EQUATION_B_2: Specimen =
    Specimen { settled: 8.100, terms: &[(-0.5977 / 8.100, 0.8229), (-1.733 / 8.100, 0.007_805)] };
const EQUATION_B_1: Specimen = Specimen { settled: 6.480, terms: &[(-0.6787 / 6.480, 0.5907)] };
/// Held force, N, and length of a hold, s (6.3.2).
const FORCE: f64 = 2.0;
const HOLD: f64 = 9.5;
/// Samples per second; bandwidth of the controller, Hz.
const SAMPLING: f64 = 200.0;
const BANDWIDTH: f64 = 20.0;
/// Noise of the load cell, N, a third of its accuracy; of the displacement, mm, its accuracy; of a marker, mm, half of the
/// camera's 50 µm.
const FORCE_NOISE: f64 = 0.08;
const NOISE: f64 = 1e-3;
const SCATTER: f64 = 0.025;
/// The filter of 6.3.3: the text names the kind, not the cut-off.
const FILTER: Butterworth = Butterworth { cutoff_hz: 5.0, order: 4, zero_phase: true };
/// Markers inside.
const MARKERS: usize = 4;

/// A run under force control as it would be recorded.
struct Run {
    /// With the noise of every instrument.
    trace: Trace,
    /// Force that was asked for, N.
    wanted: Vec<f64>,
    /// Force of the specimen, without noise, N.
    force: Vec<f64>,
    /// Force after the filter, N.
    filtered: Vec<f64>,
    /// Places that markers reach, mm, from the moving face inwards.
    markers: Vec<Vec<f64>>,
    holds: Vec<Hold>,
}

impl Run {
    /// To each force in turn at a rate, N/s, with a hold after each but the last.
    fn new(specimen: &Specimen, forces: &[f64], rate: f64, seed: u64) -> Self {
        let mut steps = Vec::new();
        for (place, to) in forces.iter().enumerate() {
            steps.push(ForceStep::Load(Loading { to: *to, rate: None }));
            if place + 1 < forces.len() {
                steps.push(ForceStep::Hold(palpate_model::Hold { hold_s: HOLD }));
            }
        }
        let profile = ForceProfile {
            version: 1,
            rate_hz: SAMPLING,
            loading: rate,
            bandwidth_hz: BANDWIDTH,
            steps,
        };
        let terms = specimen.terms;
        let law = BaseLaw::new(Family::CREEP, terms.len(), Separation::Clamp);
        let mut parameters = vec![FORCE / specimen.settled, 0.0];
        parameters.extend(terms.iter().map(|term| term.0));
        parameters.extend(terms.iter().map(|term| term.1));
        let run = profile.run(&law, &parameters);
        let inside = Segments {
            count: MARKERS + 1,
            rate: terms[0].1,
            exponent: 1.0,
            equilibrium: Equilibrium::Common,
        };
        let nodes = inside.displacements(&run.time, &run.displacement);
        let markers = nodes.into_iter().skip(1).enumerate();
        let markers = markers.map(|(k, node)| noisy(node, SCATTER, seed + 10 + k as u64)).collect();
        let name = format!("{rate} N/s");
        let mut made = trace(
            name,
            Control::Force,
            run.time.clone(),
            noisy(run.displacement, NOISE, seed),
            noisy(run.force.clone(), FORCE_NOISE, seed + 1),
        );
        let raw = made.force().unwrap_or_default().to_vec();
        let filtered = FILTER.filter(&made, &raw).unwrap_or(raw.clone());
        // Holds are looked for in the filtered force, as with `palpate creep --cutoff`.
        made.set_column(palpate_trace::FORCE, filtered.clone());
        let holds = creep(&made, DISPLACEMENT, Terms::Fixed(terms.len()), false)
            .map(|it| it.holds)
            .unwrap_or_default();
        made.set_column(palpate_trace::FORCE, raw);
        Self { trace: made, wanted: run.wanted, force: run.force, filtered, markers, holds }
    }

    /// Largest distance of the specimen's force from the one asked for, N, from a second into the first hold on.
    fn off_in_hold(&self) -> f64 {
        let Some(hold) = self.holds.first() else { return f64::NAN };
        let range = hold.fit.range.clone();
        let from = range.start + SAMPLING as usize;
        (from..range.end).fold(0.0, |most: f64, k| most.max((self.force[k] - self.wanted[k]).abs()))
    }

    fn figure(&self) -> Panels {
        let time = &self.trace.time[..];
        let axis = || Axis::new("time", "s");
        let raw = self.trace.force().unwrap_or_default();
        let force = Plot::new("", axis(), Axis::new("force", "N"))
            .series(Series::line("load cell", time, raw).colour(Colour::Muted))
            .series(Series::line("filtered", time, &self.filtered[..]).colour(Colour::Hue(1)))
            .series(Series::line("asked for", time, &self.wanted[..]).colour(Colour::Ink));
        let face = self.trace.displacement().unwrap_or_default();
        let mut places = Plot::new("", axis(), Axis::new("displacement", "mm"))
            .series(Series::line("face", time, face).colour(Colour::Ink));
        for (k, marker) in self.markers.iter().enumerate() {
            let line = Series::line(format!("marker {}", k + 1), time, &marker[..]);
            places = places.series(line.colour(Colour::Hue(k)));
        }
        Panels::new("")
            .summary("Force as measured, filtered and asked for, and displacement of the face and of four markers")
            .plot(force)
            .plot(places)
    }

    /// The first hold with its two exponentials.
    fn fitted(&self) -> Option<Plot> {
        let hold = self.holds.first()?;
        let range = hold.fit.range.clone();
        let since: Vec<f64> =
            self.trace.time[range.clone()].iter().map(|t| t - hold.fit.from_s).collect();
        let values = &self.trace.displacement()?[range];
        let last = since.last().copied()?;
        let (t, curve): (Vec<f64>, Vec<f64>) = (0..=200)
            .map(|k| last * f64::from(k) / 200.0)
            .map(|t| (t, hold.fit.fit.sum.at(t)))
            .unzip();
        let axes = (Axis::new("time in the hold", "s"), Axis::new("displacement", "mm"));
        Some(
            Plot::new("", axes.0, axes.1)
                .summary("Displacement in the hold and the fit of two exponentials")
                .series(Series::points("recorded", since, values).colour(Colour::MEASURED))
                .series(Series::line("(6.1), two exponentials", t, curve).colour(Colour::MODEL)),
        )
    }
}

/// The figures.
pub(super) fn section() -> Section {
    let once = |rate, seed| Run::new(&EQUATION_B_2, &[FORCE, 0.0], rate, seed);
    let (low, high) = (once(1.96, 1), once(2.71, 2));
    let turns = Run::new(&EQUATION_B_1, &[4.0, 2.0, 4.0, 2.0, 0.0], 0.092, 3);
    let mut section = Section::new("Under a PI controller (6.3.2, 6.3.3)").paragraph(format!(
        "A specimen with the creep of (B.2) is pressed by a PI controller of {BANDWIDTH} Hz that samples at {SAMPLING} Hz. \
         The load cell reads with {FORCE_NOISE} N of noise; its force is filtered forward and backward (Butterworth, order {}, \
         {} Hz). Markers follow the face by the latency model. The noise, the cut-off and the controller's gains are not printed: \
         these are assumptions.",
        FILTER.order, FILTER.cutoff_hz
    ));
    for (run, number, rate) in [(&low, "6.3", "1.96"), (&high, "6.4", "2.71")] {
        section = section.figure(
            run.figure(),
            format!("Fig. {number} in kind: loading at {rate} N/s to 2 N, hold, unloading."),
        );
        if let Some(plot) = run.fitted() {
            section = section.figure(
                plot,
                format!(
                    "Fig. {number} in kind, right: the creep of the hold at {rate} N/s and its fit."
                ),
            );
        }
    }
    section
        .figure(
            turns.figure(),
            "Fig. 6.5 in kind: 4 N and 2 N by turns at 0.092 N/s, with the one exponential of (B.1), because the slow one of (B.2) would still creep on from the way up.",
        )
        .table(table(&[("1.96 N/s", &low), ("2.71 N/s", &high), ("0.092 N/s, by turns", &turns)]))
        .callout(Callout::Finding, "Lower and higher rate", words(&low, &high))
}

fn table(runs: &[(&str, &Run)]) -> Table {
    let columns = vec![
        Column::text("run"),
        Column::number("from", "s"),
        Column::number("force", "N"),
        Column::text("type"),
        Column::number("at first", "mm"),
        Column::number("creeps by", "mm"),
        Column::number("v1", "1/s"),
        Column::number("off by at most", "N"),
    ];
    let mut table = Table::new("Holds under the controller", columns);
    for (name, run) in runs {
        for (place, hold) in run.holds.iter().enumerate() {
            let sum = &hold.fit.fit.sum;
            table = table.row([
                (*name).to_owned(),
                significant(hold.fit.from_s, 4),
                hold.force.map_or("–".into(), |force| significant(force.0, 3)),
                numeral(hold.fit.relaxation).to_owned(),
                significant(sum.at(0.0), 4),
                significant(sum.at(HOLD) - sum.at(0.0), 3),
                sum.terms.first().map_or("–".into(), |term| significant(term.rate, 3)),
                if place == 0 { significant(run.off_in_hold(), 2) } else { "–".into() },
            ]);
        }
    }
    table.note(format!(
        "Creeps by: over {HOLD} s, by the fit. v1 of the fit; that of (B.2), fed in, is {} 1/s. Off by: the specimen's force from the one asked for, a second into the first hold and later.",
        EQUATION_B_2.terms[0].1
    ))
}

/// What the loading rate changes (6.3.3.1), by the numbers.
fn words(low: &Run, high: &Run) -> String {
    let at_first = |run: &Run| run.holds.first().map_or(f64::NAN, |hold| hold.fit.fit.sum.at(0.0));
    let (a, b) = (at_first(low), at_first(high));
    let holds = if a > b {
        "the lower rate begins its hold at the larger displacement, as 6.3.3.1 says"
    } else {
        "the lower rate does not begin its hold at the larger displacement, against 6.3.3.1"
    };
    format!(
        "At 1.96 N/s the hold begins at {} mm, at 2.71 N/s at {} mm: {holds}. What has crept on the way up is no longer left to creep.",
        significant(a, 4),
        significant(b, 4)
    )
}

#[cfg(test)]
mod tests {
    use shared::phase::RelaxationType::{TypeI, TypeII};

    use super::*;

    #[test]
    fn the_controller_keeps_the_force_and_the_creep_is_found_through_noise_and_filter() {
        for (rate, seed) in [(1.96, 1), (2.71, 2)] {
            let run = Run::new(&EQUATION_B_2, &[FORCE, 0.0], rate, seed);
            assert_eq!(run.holds.len(), 1);
            assert!(run.off_in_hold() < 0.02, "{}", run.off_in_hold());
            let hold = &run.holds[0];
            assert!((hold.fit.from_s - FORCE / rate).abs() < 0.5, "{}", hold.fit.from_s);
            assert_eq!(hold.fit.relaxation, TypeI);
            let sum = &hold.fit.fit.sum;
            let fastest = sum.terms.iter().map(|term| term.rate).fold(0.0, f64::max);
            assert!((fastest / 0.8229 - 1.0).abs() < 0.25, "{fastest}");
        }
    }

    #[test]
    fn by_turns_the_types_alternate_at_the_lowest_rate_too() {
        let run = Run::new(&EQUATION_B_1, &[4.0, 2.0, 4.0, 2.0, 0.0], 0.092, 3);
        let types: Vec<_> = run.holds.iter().map(|hold| hold.fit.relaxation).collect();
        assert_eq!(types, [TypeI, TypeII, TypeI, TypeII]);
    }
}
