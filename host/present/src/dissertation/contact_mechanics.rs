//! Section 8.2.2: contact mechanics of a tip, for force curves on soft tissue.

use shared::latency::{Law, LawError};

use super::{Chapter, Check, Comparison, Evidence};
use crate::summary::hold_figure;
use palpate_contact::afm::AfmError;
use palpate_contact::afm::curve::ForceCurve;
use palpate_contact::afm::fit::{CurveFit, Held, Options, fit};
use palpate_contact::afm::pressure::{modulus_factor, surface};
use palpate_contact::afm::rough::{Rough, Trial, spread};
use palpate_contact::afm::simulate::Practice;
use palpate_contact::grasp::{ExponentError, PressureLaw};
use palpate_model::Relaxation;
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};

/// Table 8.3: exponent k, Ck as printed, and half a unit of its last digit.
const TABLE_8_3: [(f64, f64, f64); 6] = [
    (1.8, 1.6080, 5e-5),
    (2.0, 1.5000, 5e-5),
    (3.0, 1.2405, 5e-5),
    (4.0, 1.1441, 5e-5),
    (10.0, 1.0274, 5e-5),
    (100.0, 1.00032, 5e-6),
];
/// Exponents that are drawn.
const DRAWN_EXPONENTS: [f64; 5] = [1.8, 2.0, 4.0, 10.0, f64::INFINITY];
/// Seed of everything here.
const SEED: u64 = 8;
/// Heights of the rough surfaces, nm.
const ROUGHNESS: [f64; 4] = [5.0, 20.0, 50.0, 100.0];

/// Why the chapter cannot be computed, which would be a fault of this program.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ContactError {
    #[error(transparent)]
    Exponent(#[from] ExponentError),
    #[error(transparent)]
    Afm(#[from] AfmError),
    #[error("{0}")]
    Latency(LawError),
}

/// The general pressure law, the latency model in place of Kelvin and Voigt, and rough surfaces.
///
/// # Errors
/// [`ContactError`].
pub fn chapter() -> Result<Chapter, ContactError> {
    let sections = vec![pressures()?, latency()?, roughness()?];
    Ok(Chapter {
        title: "Chapter 8: contact mechanics of a tip",
        comparisons: vec![table_8_3()?],
        sections,
    })
}

fn table_8_3() -> Result<Comparison, ContactError> {
    let check = |(k, printed, tolerance)| {
        let constant = PressureLaw::new(k)?.circular_constant();
        Ok(Check::exact(format!("Ck for k = {k}"), "", (printed, 2.0 * tolerance), constant))
    };
    let checks = TABLE_8_3.into_iter().map(check).collect::<Result<Vec<_>, ContactError>>()?;
    let reason = "half a unit of the last printed digit: eq. 8.2 is exact";
    Ok(Comparison {
        source: "Table 8.3",
        evidence: Evidence::Derived,
        reason: reason.into(),
        checks,
    })
}

fn name(law: PressureLaw) -> String {
    if law.exponent().is_infinite() { "k = ∞".into() } else { format!("k = {}", law.exponent()) }
}

fn pressures() -> Result<Section, ContactError> {
    let laws = DRAWN_EXPONENTS.map(PressureLaw::new).into_iter().collect::<Result<Vec<_>, _>>()?;
    let radii: Vec<f64> = (0..=200).map(|i| f64::from(i) / 200.0).collect();
    let coarse: Vec<f64> = (0..=40).map(|i| f64::from(i) / 40.0).collect();
    let radius = || Axis::new("Radius over that of the contact", "");
    let mut pressure =
        Plot::new("Fig. 8.7 in kind", radius(), Axis::new("Pressure over mean pressure", ""));
    let mut depth =
        Plot::new("The surface below", radius(), Axis::new("Depth over Hertz's in the middle", ""));
    for (hue, &law) in laws.iter().enumerate() {
        let profile: Vec<f64> = radii.iter().map(|r| law.circular(*r)).collect();
        let below: Vec<f64> = coarse.iter().map(|r| surface(law, *r)).collect();
        let line = |x: &[f64], y: Vec<f64>| Series::line(name(law), x, y).colour(Colour::Hue(hue));
        pressure = pressure.series(line(&radii, profile));
        depth = depth.series(line(&coarse, below));
    }
    let columns = vec![Column::text("exponent"), Column::number("Ck", ""), Column::number("κ", "")];
    let mut table = Table::new("What the exponent does to the depth", columns);
    for &law in &laws {
        table = table.row([
            name(law),
            significant(law.circular_constant(), 5),
            significant(modulus_factor(law), 4),
        ]);
    }
    Ok(Section::new("The general pressure law")
        .paragraph(
            "The law (8.1) has Hertz's pressure as k = 2 and a uniform one as its limit; softer materials are said to have more. \
             What that does to a force curve is not said. The Boussinesq kernel shows it: in the middle of the contact the \
             surface sinks κ times as deep as under Hertz's pressure of the same force and radius. With the radius of the contact \
             given by the tip, the force still grows with the power 3/2 of the depth, and a modulus found with Hertz's law is to \
             be multiplied by κ.",
        )
        .callout(
            Callout::Finding,
            "A force curve does not determine k",
            "Only a factor between 1.03 (k = 1.8) and 0.85 (uniform) on the modulus depends on it. To measure k one has to see \
             the pressure or the shape of the surface.",
        )
        .figure(pressure, "Pressure over the contact.")
        .figure(depth, "The surface under each pressure. Only k = 2 makes a parabola, the shape of a round tip: for other exponents the tip, or the small strains, are not those of Hertz.")
        .table(table))
}

/// A tip that goes in, stays and comes back: force by Kelvin and Voigt, and by the latency model of an order.
struct Course {
    time: Vec<f64>,
    kelvin_voigt: Vec<f64>,
    linear: Vec<f64>,
    power: Vec<f64>,
}

/// Share of the strain that stays in equilibrium, and end of the way in and of the hold, s.
const STAYS: f64 = 0.6;
const IN_S: f64 = 0.3;
const HELD_S: f64 = 3.3;

fn course() -> Result<Course, ContactError> {
    let interval = 1e-3;
    let law = |rate, order| Law::<f64>::new(rate, order, interval).map_err(ContactError::Latency);
    let (linear, power) = (law(2.0, 1.0)?, law(120.0, 4.0)?);
    let depth = |t: f64| (t / IN_S).min(1.0).min((HELD_S + IN_S - t) / IN_S).max(0.0);
    let time: Vec<f64> = (0..=4000).map(|i| f64::from(i) * interval).collect();
    let depths: Vec<f64> = time.iter().map(|t| depth(*t)).collect();
    // Hertz's force of a strain that follows the tip at once and then goes towards its equilibrium.
    let latent = |law: &Law<f64>| -> Vec<f64> {
        let mut strain = 0.0_f64;
        let mut before = 0.0;
        let follow = |&depth: &f64| {
            strain += depth - before;
            before = depth;
            let equilibrium = STAYS * depth;
            strain = equilibrium + law.step(strain - equilibrium);
            strain.max(0.0).powf(1.5)
        };
        depths.iter().map(follow).collect()
    };
    let elastic: Vec<f64> = depths.iter().map(|depth| (STAYS * depth).powf(1.5)).collect();
    let kelvin_voigt = (0..elastic.len())
        .map(|i| {
            let rate = (elastic[i] - elastic[i.saturating_sub(1)]) / interval;
            (elastic[i] + 0.1 * rate).max(0.0)
        })
        .collect();
    Ok(Course { kelvin_voigt, linear: latent(&linear), power: latent(&power), time })
}

/// A force curve with a hold of two exponentials, fitted.
fn held_curve() -> Result<CurveFit, ContactError> {
    let practice = Practice {
        relaxation: Relaxation::new(&[0.2, 0.2], &[8.0, 0.6]),
        hold_s: 6.0,
        noise_n: 5e-12,
        rate_hz: 400.0,
        ..Practice::gel()
    };
    let curve = ForceCurve::of(&practice.curve(SEED)?)?;
    let options = Options { tip: practice.tip, poisson_ratio: 0.5, pressure: PressureLaw::HERTZ };
    Ok(fit(&curve, &options)?)
}

fn latency() -> Result<Section, ContactError> {
    let course = course()?;
    let line = |name: &str, values: Vec<f64>, hue| {
        Series::line(name, &course.time[..], values).colour(Colour::Hue(hue))
    };
    let plot = Plot::new(
        "Fig. 8.8 in kind: a tip goes in, stays, comes back",
        Axis::new("Time", "s"),
        Axis::new("Force over that without memory", ""),
    )
    .summary("Kelvin and Voigt's force is constant during the hold; the latency model's falls, fast at first and then slowly")
    .series(line("Kelvin–Voigt", course.kelvin_voigt.clone(), 2))
    .series(line("latency, n = 1", course.linear.clone(), 1))
    .series(line("latency, n = 4", course.power.clone(), 0));
    let mut section = Section::new("The latency model as the contact of a tip")
        .paragraph(
            "The proposal is to put the latency model where Kelvin and Voigt's stood. During a hold a spring beside a damper \
             feels nothing: its force jumps down when the motion stops and stays. The latency model relaxes: its strain \
             follows the tip at once and then goes towards its equilibrium, at a rate set by how far away that is, linearly or \
             with a power n. On the way back the tip leaves before the surface has recovered.",
        )
        .figure(plot, "All three settle at the same force.");
    if let Some(Held { relaxed: Ok(held), .. }) = held_curve()?.longest_hold() {
        let words = format!(
            "A practice curve of a gel with two exponentials, held for 6 s: the linear law leaves {} of the strain, the order n = {} \
             that fits best {}. A power stands in for several rates, as chapter 7 found.",
            percent(held.linear.rms, 2),
            held.power.order,
            percent(held.power.rms, 2),
        );
        section =
            section.paragraph(words).figure(hold_figure(held), "The hold of a practice curve.");
    }
    Ok(section)
}

fn rough(rms_nm: f64) -> Result<Vec<Trial>, AfmError> {
    let practice = Practice::gel();
    Rough {
        specimen: practice.specimen,
        radius_m: 2.5e-6,
        depth_m: 5e-7,
        rms_m: rms_nm * 1e-9,
        density_per_m2: 4e13,
        asperity_m: 1e-7,
        trials: 200,
    }
    .run(SEED)
}

fn roughness() -> Result<Section, ContactError> {
    let columns = vec![
        Column::number("heights, RMS", "nm"),
        Column::number("apparent modulus", "of the true one"),
        Column::number("scatter", "of the true one"),
        Column::number("contact point", "nm"),
        Column::number("its scatter", "nm"),
    ];
    let caption = "A gel of 5 kPa with asperities under a ball of 2.5 µm, 200 places each";
    let mut table = Table::new(caption, columns);
    for rms_nm in ROUGHNESS {
        let trials = rough(rms_nm)?;
        let (modulus, contact) =
            (spread(&trials, |t| t.modulus_ratio), spread(&trials, |t| t.contact_m * 1e9));
        table = table.row([
            significant(rms_nm, 3),
            significant(modulus.mean, 3),
            significant(modulus.deviation, 2),
            significant(contact.mean, 3),
            significant(contact.deviation, 2),
        ]);
    }
    Ok(Section::new("A rough surface as a stochastic model")
        .paragraph(
            "The real surface has asperities, and a stochastic model is called for. Ours: 40 asperities on a square micrometre, \
             balls of 100 nm on Gaussian heights; the tip bears on those that it reaches, each by Hertz, in series with the \
             specimen below. Every place of the surface gives another curve, read as if it were smooth.",
        )
        .table(table)
        .paragraph(
            "Even asperities of nearly equal height give in by themselves: the specimen seems softer, and the contact to begin \
             later than at the mean surface. The more their heights scatter, the earlier the first one is met, the softer the \
             specimen seems, and the more both change from place to place. So a scatter of the modulus over a map is not yet one \
             of the material.",
        ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kelvin_and_voigt_rest_during_the_hold_and_latency_relaxes() {
        let course = course().unwrap();
        let (early, late) = (400, 3200);
        assert!((course.kelvin_voigt[early] - course.kelvin_voigt[late]).abs() < 1e-12);
        for force in [&course.linear, &course.power] {
            assert!(force[early] > 1.05 * force[late]);
            assert!(force[4000] < 1e-9, "the tip has left");
        }
    }

    #[test]
    fn roughness_softens_and_scatters_more_the_higher_it_is() {
        let modulus = ROUGHNESS.map(|rms| spread(&rough(rms).unwrap(), |t| t.modulus_ratio));
        for pair in modulus.windows(2) {
            assert!(pair[1].mean < pair[0].mean && pair[1].deviation > pair[0].deviation);
        }
    }
}
