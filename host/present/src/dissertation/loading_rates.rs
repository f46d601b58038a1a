//! Chapter 5: two silicones at 20 to 100 mm/s. Table 5.2, Figs 5.6–5.14 in kind.

use super::comparison::digits;
use super::simulated::{noisy, times, trace};
use super::{Chapter, Check, Comparison, Evidence};
use super::{motion, strain_inside};
use crate::summary::rates_sections;
use palpate_analysis::geometry::{Faces, Geometry};
use palpate_analysis::rates::{Study, rates};
use palpate_report::{Block, Callout, Section};
use palpate_trace::{Control, Shape, Trace};

/// Loading rates of 5.3.1, mm/s.
const RATES: [f64; 5] = [20.0, 40.0, 60.0, 80.0, 100.0];
/// Compression, mm: not printed.
const COMPRESSION: f64 = 6.0;
/// Noise of the force, N: not printed; the sensor's accuracy is 0.25 N.
const NOISE: f64 = 0.05;
/// Standard errors within which a value must come back.
const ERRORS: f64 = 4.0;
/// Samples per second.
const SAMPLING: f64 = 500.0;
/// Height of the cylinders, mm.
const HEIGHT: f64 = 30.0;

/// A line of Table 5.2.
#[derive(Clone, Copy, Debug)]
struct Silicone {
    name: &'static str,
    /// v1, 1/s.
    rate: f64,
    /// k_s, Pa.
    stiffness: f64,
    /// Poisson's ratio.
    poisson: f64,
    /// How far the surface runs ahead of a step, as a share of it: not printed. The soft silicone
    /// stiffened visibly with the rate (Fig. 5.8), the hard one hardly (Fig. 5.9).
    ahead: f64,
}

const SILICONES: [Silicone; 2] = [
    Silicone { name: "soft silicone", rate: 0.493, stiffness: 3.497e4, poisson: 0.48, ahead: 0.30 },
    Silicone { name: "hard silicone", rate: 0.695, stiffness: 1.221e5, poisson: 0.48, ahead: 0.03 },
];

impl Silicone {
    /// One run: loading at a rate (mm/s), 10 s of hold, unloading.
    ///
    /// The surface follows the linear latency model: ε_c = ε_e + z with z' = −v1 z + `ahead` ε_e'.
    fn run(&self, speed: f64, seed: u64) -> Trace {
        let (begin, lasts) = (0.2, COMPRESSION / speed);
        let time = times(begin + 2.0 * lasts + 10.5, SAMPLING);
        let at = |t: f64| {
            let back = begin + lasts + 10.0;
            (speed * (t - begin)).min(speed * (back - t) + COMPRESSION).clamp(0.0, COMPRESSION)
        };
        let x: Vec<f64> = time.iter().map(|t| at(*t)).collect();
        let geometry =
            Geometry::Cylinder { radius_mm: 25.0, height_mm: HEIGHT, poisson: self.poisson };
        let decay = (-self.rate / SAMPLING).exp();
        // Exact for displacement that is straight between samples.
        let gain = self.ahead * SAMPLING * (1.0 - decay) / self.rate;
        let mut z = 0.0;
        let force = (0..x.len())
            .map(|k| {
                let step = if k == 0 { 0.0 } else { (x[k] - x[k - 1]) / HEIGHT };
                z = z * decay + gain * step;
                let strain = (geometry.equilibrium_strain(x[k]) + z).max(0.0);
                self.stiffness * strain * geometry.area_mm2(x[k]) * 1e-6
            })
            .collect();
        let force = noisy(force, NOISE, seed);
        let name = format!("{speed} mm/s");
        let mut trace = trace(name, Control::Displacement, time, x, force);
        trace.head.specimen.shape = Some(Shape::Cylinder);
        trace.head.specimen.radius_mm = Some(25.0);
        trace.head.specimen.height_mm = Some(HEIGHT);
        trace.head.specimen.poisson_ratio = Some(self.poisson);
        trace
    }

    fn runs(&self) -> Vec<Trace> {
        RATES.iter().zip(1..).map(|(speed, seed)| self.run(*speed, seed)).collect()
    }
}

/// Chapter 5.
#[must_use]
pub fn chapter() -> Chapter {
    let studies: Vec<(Silicone, Vec<Trace>, Study)> = SILICONES
        .into_iter()
        .filter_map(|silicone| {
            let runs = silicone.runs();
            let study = rates(&runs, 1, Faces::One).ok()?;
            Some((silicone, runs, study))
        })
        .collect();
    let fastest = studies.first().and_then(|(_, runs, _)| runs.last());
    let mut sections = vec![claim(), motion::section(fastest)];
    for (silicone, runs, study) in &studies {
        for section in rates_sections(study, runs) {
            sections.push(Section {
                title: format!("{}: {}", silicone.name, section.title),
                ..section
            });
        }
    }
    sections.push(strain_inside::section());
    let compared: Vec<(Silicone, &Study)> =
        studies.iter().map(|(s, _, study)| (*s, study)).collect();
    Chapter {
        title: "Chapter 5: loading rates",
        comparisons: vec![table_5_2(&compared), inertia()],
        sections,
    }
}

fn claim() -> Section {
    let mut section = Section::new("What was claimed")
        .paragraph("Cylinders of a hard and a soft silicone, 25 mm in radius and 30 mm high, were pressed at 20 to 100 mm/s and held. The peak of the soft one grew with the rate, that of the hard one hardly; where the force settled did not depend on the rate. From the settled force follow a specific stiffness (5.6) and from it the strain of the surface (5.7), which runs ahead of the equilibrium during loading.")
        .paragraph(format!("The recordings are not printed. Here both silicones are simulated with the v1, k_s and Poisson's ratio of Table 5.2 and noise of {NOISE} N, and `palpate rates` has to find them. The compression ({COMPRESSION} mm) and how far the surface runs ahead are not printed either: {} of a step for the soft silicone, {} for the hard one, to give peaks like those of Figs 5.8 and 5.9.", SILICONES[0].ahead, SILICONES[1].ahead));
    section.blocks.push(Block::Callout {
        kind: Callout::Warning,
        title: "A slip".into(),
        text: "Section 5.4.1 writes ε = k_s σ in passing; (5.7) has it right, ε = σ/k_s, and is what is computed.".into(),
    });
    section
}

fn table_5_2(studies: &[(Silicone, &Study)]) -> Comparison {
    let checks = studies
        .iter()
        .flat_map(|(silicone, study)| {
            let tolerance = |error: Option<f64>| ERRORS * error.unwrap_or(0.0);
            [
                Check::new(
                    format!("{}, v1", silicone.name),
                    "1/s",
                    (silicone.rate, digits(silicone.rate, 3)),
                    study.v1.0,
                    tolerance(study.v1.1),
                ),
                Check::new(
                    format!("{}, k_s", silicone.name),
                    "Pa",
                    (silicone.stiffness, digits(silicone.stiffness, 4)),
                    study.stiffness_pa.0,
                    tolerance(study.stiffness_pa.1),
                ),
            ]
        })
        .collect();
    Comparison {
        source: "Table 5.2",
        evidence: Evidence::FoundAgain,
        reason: format!(
            "{ERRORS} standard errors of the mean over five simulated runs with noise of {NOISE} N"
        ),
        checks,
    }
}

fn inertia() -> Comparison {
    let force = 14e-3 * 5.0;
    Comparison {
        source: "Section 5.3.1",
        evidence: Evidence::Derived,
        reason: "half of the last printed digit".into(),
        checks: vec![Check::exact(
            "inertial force of 14 g at 5000 mm/s²",
            "N",
            (0.07, 0.01),
            force,
        )],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_analysis::rates::Group;

    #[test]
    fn asymptotes_agree_over_the_rates_and_the_soft_silicone_stiffens() {
        for silicone in SILICONES {
            let study = rates(&silicone.runs(), 1, Faces::One).unwrap();
            let group = &study.groups[0];
            assert!(group.asymptotes.unwrap().p_value > 1e-3, "{}", silicone.name);
            let slope = group.peak_trend.unwrap();
            if silicone.ahead > 0.1 {
                assert!(slope.slope_n.0 > 0.0 && slope.p_value < 1e-6, "{slope:?}");
            } else {
                // The contrast of Figs 5.8 and 5.9: the hard one hardly stiffens.
                let of =
                    |group: &Group| group.peak_trend.unwrap().slope_n.0 / group.peaks.unwrap().mean;
                let soft = rates(&SILICONES[0].runs(), 1, Faces::One).unwrap();
                assert!(of(group) < 0.3 * of(&soft.groups[0]), "{slope:?}");
            }
        }
    }
}
