//! 7.4: the run of Fig. 7.8 with segments, and what becomes of it when there are many of them.

use super::{Chapter, Check, Comparison, Evidence};
use palpate_analysis::geometry::{Faces, Geometry};
use palpate_analysis::segment_run::Setting;
use palpate_model::latency::Power;
use palpate_model::{Equilibrium, Hold, Move, Profile, Segments, Step};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Panels, Plot, Scale, Section, Series, Table};

/// Radius of the ball, mm (7.3.1).
const RADIUS: f64 = 35.0;
/// Young's modulus, N/mm²: 2.8e4 Pa (7.3.3).
const MODULUS: f64 = 2.8e-2;
/// Power n of eq. 7.10.
const POWER: f64 = 5.0;
/// Rate ν, 1/s, at a latent strain of one: the third curve of Table 7.1, the one in the middle.
const RATE: f64 = 2.0e4;
/// Segments of Fig. 7.7.
const SEGMENTS: usize = 8;
/// Time between samples, s.
const INTERVAL: f64 = 0.005;
/// Numbers of segments that are compared.
const NUMBERS: [usize; 7] = [2, 4, 8, 16, 32, 64, 128];

/// The chapter.
#[must_use]
pub fn chapter() -> Chapter {
    let loading = Run::new(&[5.0, 10.0, 15.0, 20.0, 25.0], SEGMENTS);
    let unloading = Run::new(&[25.0, 20.0, 15.0, 10.0, 5.0], SEGMENTS);
    let section = Section::new("Segments between contact and middle (7.4)")
        .paragraph(format!(
            "A ball of {RADIUS} mm radius between two plates, E = 2.8e4 Pa, is cut into {SEGMENTS} segments from \
             the contact to the plane of symmetry. Each relaxes by eq. 7.10, ε' = −ν (ε − εe)^5, towards the \
             strain that it would have if all further inside were even; the force is E ε1 A (eq. 7.11). Steps \
             of 5 mm at 500 mm/min, holds of 10 s. Each face moves by half of the plates' approach, d/2 (7.4), \
             while eq. 7.7 takes the whole of it from one side: the area here is that of d/2. The text prints \
             no ν for the run; it is that of the third curve of Table 7.1, {} 1/s.",
            significant(RATE, 2)
        ))
        .figure(laws(), "Fig. 7.2 in kind: the linear law and higher odd powers, each with the same rate at a distance of 0.1.")
        .figure(loading.figure(), "Fig. 7.8 in kind: the run of Fig. 7.4(a). `palpate strain-rate --simulate 8` does the same along a recording.")
        .figure(loading.inside(), "Fig. 7.7 in kind: how far the outer end of each segment has moved, from the face inwards.")
        .figure(unloading.figure(), "The run of Fig. 7.4(b): successive unloading, Type II.")
        .table(steps_table(&loading, &unloading))
        .callout(
            Callout::Finding,
            "More relaxes where more is compressed (7.5.1)",
            format!(
                "From the first to the fifth step the force falls by {} N in the hold: more area, more force, \
                 more of it latent. As a part of the force at the start of the hold it shrinks, from {} to {} %.",
                loading
                    .drops()
                    .iter()
                    .map(|(_, drop)| significant(*drop, 3))
                    .collect::<Vec<_>>()
                    .join(", "),
                significant(100.0 * loading.relative_drop(0), 3),
                significant(100.0 * loading.relative_drop(4), 3)
            ),
        );
    let comparisons = vec![growing(&loading)];
    Chapter {
        title: "Chapter 7: the simulation",
        comparisons,
        sections: vec![section, convergence()],
    }
}

/// Strain rate over the distance of the strain from its equilibrium for several powers (7.2).
fn laws() -> Plot {
    let distance: Vec<f64> = (-150..=150).map(|k| 1e-3 * f64::from(k)).collect();
    let plot = Plot::new(
        "",
        Axis::new("strain − equilibrium strain", ""),
        Axis::new("strain rate", "1/s"),
    )
    .summary(
        "Strain rate over the distance from equilibrium: a line, and curves that are flat near it",
    )
    .level(0.0, "");
    [1.0, 3.0, 5.0].into_iter().enumerate().fold(plot, |plot, (k, order)| {
        let law =
            Power { rate: 1.0 / 0.1f64.powf(order - 1.0), order, equilibrium: 0.0, initial: 0.1 };
        let rates: Vec<f64> = distance.iter().map(|e| law.strain_rate_at(*e)).collect();
        plot.series(
            Series::line(format!("n = {order}"), &distance[..], rates).colour(Colour::Hue(k)),
        )
    })
}

/// One run: steps with holds, then off the ball.
struct Run {
    time: Vec<f64>,
    /// Approach of the plates, mm.
    approach: Vec<f64>,
    force: Vec<f64>,
    /// First and last sample of each hold.
    holds: Vec<(usize, usize)>,
}

impl Run {
    fn new(places: &[f64], segments: usize) -> Self {
        let to = |to_mm| Step::Move(Move { to_mm, speed_mm_per_s: None });
        let mut steps: Vec<Step> = places
            .iter()
            .flat_map(|place| [to(*place), Step::Hold(Hold { hold_s: 10.0 })])
            .collect();
        steps.push(to(0.0));
        let speed = 500.0 / 60.0;
        let motion = Profile {
            version: 1,
            rate_hz: 1.0 / INTERVAL,
            start_mm: 0.0,
            speed_mm_per_s: speed,
            acceleration_mm_per_s2: None,
            repeat: 1,
            steps,
        }
        .motion();
        let time = motion.time.to_vec();
        let approach = motion.displacement.to_vec();
        let setting = Setting {
            geometry: BALL,
            faces: Faces::Each,
            modulus_pa: 1e6 * MODULUS,
            segments,
            order: POWER,
            rate: RATE,
        };
        let force = setting.force(&time, &approach);
        let mut holds = Vec::new();
        let (mut at, mut from) = (0.0, 0.0);
        for place in places {
            at += (place - from).abs() / speed;
            from = *place;
            let first = (at / INTERVAL).ceil() as usize;
            at += 10.0;
            holds.push((first, ((at / INTERVAL).floor() as usize).min(time.len() - 1)));
        }
        Self { time, approach, force, holds }
    }

    /// Force at the start of each hold and by how much it falls, N.
    fn drops(&self) -> Vec<(f64, f64)> {
        let drop = |(first, last): &(usize, usize)| {
            (self.force[*first], self.force[*first] - self.force[*last])
        };
        self.holds.iter().map(drop).collect()
    }

    fn relative_drop(&self, hold: usize) -> f64 {
        let (force, drop) = self.drops()[hold];
        drop / force
    }

    /// Displacement of the outer end of each segment, from the face inwards.
    fn inside(&self) -> Plot {
        let face: Vec<f64> = self.approach.iter().map(|d| 0.5 * d).collect();
        let nodes = ball(SEGMENTS).displacements(&self.time, &face);
        let plot = Plot::new("", Axis::new("time", "s"), Axis::new("displacement", "mm"))
            .summary("Displacement of eight nodes over time: each deeper one later and less");
        nodes.iter().enumerate().fold(plot, |plot, (k, node)| {
            let name = if k == 0 { "face".into() } else { format!("node {}", k + 1) };
            plot.series(Series::line(name, self.time.clone(), node.clone()).colour(Colour::Hue(k)))
        })
    }

    fn figure(&self) -> Panels {
        let force = Plot::new("", Axis::new("time", "s"), Axis::new("force", "N")).series(
            Series::line("force", self.time.clone(), self.force.clone()).colour(Colour::Hue(0)),
        );
        let motion =
            Plot::new("", Axis::new("time", "s"), Axis::new("approach of the plates", "mm"))
                .series(Series::line("approach", self.time.clone(), self.approach.clone()))
                .height(130.0);
        Panels::new("")
            .summary("Simulated force and displacement in steps")
            .plot(force)
            .plot(motion)
    }
}

/// The ball cut into segments, in mm of displacement of a face.
fn ball(segments: usize) -> Segments {
    Segments {
        count: segments,
        rate: RATE / RADIUS.powf(POWER - 1.0),
        exponent: POWER,
        equilibrium: Equilibrium::OwnNode,
    }
}

/// The ball between two plates: each face is pressed in by half of their approach.
const BALL: Geometry = Geometry::Ball { radius_mm: RADIUS, faces: Faces::Each };

fn steps_table(loading: &Run, unloading: &Run) -> Table {
    let columns = vec![
        Column::text("run"),
        Column::number("approach", "mm"),
        Column::number("force at the start", "N"),
        Column::number("falls by", "N"),
        Column::text("type"),
    ];
    let mut table = Table::new("Each hold", columns);
    for (name, run) in [("loading", loading), ("unloading", unloading)] {
        for ((first, _), (force, drop)) in run.holds.iter().zip(run.drops()) {
            table = table.row([
                name.to_owned(),
                significant(run.approach[*first], 3),
                significant(force, 3),
                significant(drop, 2),
                if drop > 0.0 { "I" } else { "II" }.to_owned(),
            ]);
        }
    }
    table
}

fn growing(loading: &Run) -> Comparison {
    let drops = loading.drops();
    let more = drops.windows(2).filter(|pair| pair[1].1 > pair[0].1).count() as f64;
    Comparison {
        source: "7.5.1",
        evidence: Evidence::Said,
        reason: "a count is exact".into(),
        checks: vec![Check::new(
            "steps of which each relaxes by more force than the one before, of 4",
            "",
            (4.0, 1.0),
            more,
            0.0,
        )],
    }
}

/// Latent strain at the contact at the end of the first loading and 1 s and 10 s into the hold.
fn latent_strains(segments: usize) -> [f64; 3] {
    let run = Run::new(&[5.0], segments);
    let (first, last) = run.holds[0];
    let second = first + (1.0 / INTERVAL) as usize;
    let strain = |k: usize| {
        let approach = run.approach[k];
        run.force[k] / (MODULUS * BALL.area_mm2(approach)) - 0.5 * approach / RADIUS
    };
    [strain(first), strain(second), strain(last)]
}

fn convergence() -> Section {
    let columns = vec![
        Column::whole("segments"),
        Column::number("latent strain at the end of loading", ""),
        Column::number("after 1 s", ""),
        Column::number("after 10 s", ""),
    ];
    let mut table = Table::new("More segments: the first step of the run", columns);
    let found = NUMBERS.map(latent_strains);
    for (number, strains) in NUMBERS.iter().zip(&found) {
        let cells = strains.iter().map(|strain| significant(*strain, 4));
        table = table.row(std::iter::once(number.to_string()).chain(cells));
    }
    // With an infinite start, (7.5) leaves ((n − 1) ν t)^(−1/(n − 1)).
    let limit = |time: f64| ((POWER - 1.0) * RATE * time).powf(-1.0 / (POWER - 1.0));
    table = table.note(format!(
        "Limit for m → ∞ by eq. 7.5 from an infinite strain: {} after 1 s, {} after 10 s.",
        significant(limit(1.0), 4),
        significant(limit(10.0), 4)
    ));
    let numbers: Vec<f64> = NUMBERS.iter().map(|number| *number as f64).collect();
    let off = |index: usize, time: f64| {
        found.iter().map(|strains| (1.0 - strains[index] / limit(time)).abs()).collect::<Vec<_>>()
    };
    let log = |name: &str, unit: &str| Axis { scale: Scale::Log, ..Axis::new(name, unit) };
    let plot =
        Plot::new("", log("segments m", ""), log("distance from the limit, as a part of it", ""))
            .summary("Distance of the latent strain from its limit over the number of segments")
            .series(Series::line("after 1 s", numbers.clone(), off(1, 1.0)).colour(Colour::Hue(0)))
            .series(Series::line("after 10 s", numbers, off(2, 10.0)).colour(Colour::Hue(1)));
    Section::new("Does the number of segments matter?").table(table).figure(plot, "").callout(
        Callout::Warning,
        "The segments are not a mesh",
        "The first segment takes all movement of the contact at once, so its strain grows with the number of \
         segments while the contact moves. For n = 5 a large strain is gone at once, so that later in the hold \
         the force converges to the limit above; the peak at the end of loading does not converge (it grows as \
         m^(1/n)). For the linear model n = 1 nothing converges: m is 1/c0 and a property of the specimen. \
         `palpate fit latency-power` therefore fits c0 unless --segments gives m.",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_seconds_into_a_hold_the_simulation_converges_as_segments_grow_in_number() {
        let limit = (4.0 * RATE * 10.0f64).powf(-0.25);
        let off = |segments| (1.0 - latent_strains(segments)[2] / limit).abs();
        assert!(
            off(16) < off(8) && off(64) < off(16) && off(128) < 1e-3,
            "{} {}",
            off(8),
            off(128)
        );
    }
}
