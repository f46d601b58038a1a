//! Chapter 8.1: relaxation and creep as two sides of one law (conclusion 1), and soft contact against rigid (conclusion 4).

use std::f64::consts::FRAC_PI_2;

use super::simulated::trace;
use super::{Chapter, Check, Comparison, Evidence};
use palpate_analysis::creep::creep;
use palpate_contact::grasp::{Contact, PressureLaw, Shape, limit_curve};
use palpate_fit::exponentials::Parameter;
use palpate_fit::hold::Terms;
use palpate_model::{
    BaseLaw, EQUATION_3_6, Family, ForceProfile, ForceStep, Hold, Loading, Separation,
};
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};
use palpate_trace::{Control, DISPLACEMENT};

/// The chapter.
#[must_use]
pub fn chapter() -> Chapter {
    let sides = Sides::new();
    let contacts = contacts();
    Chapter {
        title: "Chapter 8: conclusions",
        comparisons: vec![sides.comparison(), held(&contacts)],
        sections: vec![sides.section(), soft_or_rigid(&contacts)],
    }
}

/// Relaxation (3.6) and the creep of the same specimen.
struct Sides {
    shares: [f64; 3],
    rates: [f64; 2],
    /// Creep by the same law: coefficients beside a constant of one (6.2), and rates, 1/s, the faster first.
    coefficients: [f64; 2],
    retardation: [f64; 2],
    /// Rates found in a hold of the force, 1/s, with standard errors.
    found: Option<[(f64, Option<f64>); 2]>,
    /// Largest difference of ∫ g dJ from one.
    residual: f64,
}

/// Stiffness of the specimen that is pressed under control of the force, N/mm, held force, N, rate of loading, N/s, and
/// length of the hold, s.
const STIFFNESS: f64 = 0.3;
const FORCE: f64 = 2.0;
const LOADING: f64 = 50.0;
const HOLD: f64 = 30.0;
const SAMPLING: f64 = 500.0;

impl Sides {
    fn new() -> Self {
        let (shares, rates) = EQUATION_3_6;
        let retardation = retardation(&shares, &rates);
        let coefficients = retardation.map(|rate| coefficient(&shares, &rates, rate));
        let mut sides =
            Self { shares, rates, coefficients, retardation, found: None, residual: 0.0 };
        sides.residual = sides.inverse();
        sides.found = sides.crept();
        sides
    }

    /// Relaxation function (3.4).
    fn g(&self, t: f64) -> f64 {
        let [c0, c1, c2] = self.shares;
        c0 + c1 * (-self.rates[0] * t).exp() + c2 * (-self.rates[1] * t).exp()
    }

    /// Creep function (6.2): where it ends is one.
    fn h(&self, t: f64) -> f64 {
        let term = |k: usize| self.coefficients[k] * (-self.retardation[k] * t).exp();
        1.0 + term(0) + term(1)
    }

    /// How far one law undoes the other: the stress of the strain h(t)/c0, which should be one at all times, by the
    /// integral of (2.1) over fine steps.
    fn inverse(&self) -> f64 {
        let (step, count) = (2e-3, 5000);
        let j = |k: usize| self.h(k as f64 * step) / self.shares[0];
        let changes: Vec<f64> = (0..count).map(|k| j(k + 1) - j(k)).collect();
        [10, 100, 1000, count]
            .into_iter()
            .map(|n| {
                let at = |k: usize| self.g((n as f64 - k as f64 - 0.5) * step);
                let stress: f64 = self.g(n as f64 * step) * j(0)
                    + (0..n).map(|k| at(k) * changes[k]).sum::<f64>();
                (stress - 1.0).abs()
            })
            .fold(0.0, f64::max)
    }

    /// The specimen of the relaxation under a PI controller, and what `palpate creep` finds in its hold.
    fn crept(&self) -> Option<[(f64, Option<f64>); 2]> {
        let law = BaseLaw::new(Family::FUNG, 2, Separation::Clamp);
        let [_, c1, c2] = self.shares;
        let profile = ForceProfile {
            version: 1,
            rate_hz: SAMPLING,
            loading: LOADING,
            bandwidth_hz: 20.0,
            steps: vec![
                ForceStep::Load(Loading { to: FORCE, rate: None }),
                ForceStep::Hold(Hold { hold_s: HOLD }),
            ],
        };
        let run = profile.run(&law, &[STIFFNESS, 0.0, c1, c2, self.rates[0], self.rates[1]]);
        let made = trace("creep", Control::Force, run.time, run.displacement, run.force);
        let holds = creep(&made, DISPLACEMENT, Terms::Fixed(2), false).ok()?.holds;
        let fit = &holds.first()?.fit.fit;
        let rate =
            |k| Some((fit.value(Parameter::Rate(k))?, fit.standard_error(Parameter::Rate(k))));
        let (a, b) = (rate(1)?, rate(2)?);
        Some(if a.0 > b.0 { [a, b] } else { [b, a] })
    }

    fn comparison(&self) -> Comparison {
        let found = self.found.map_or([f64::NAN; 2], |found| found.map(|rate| rate.0));
        let check = |k: usize| {
            let predicted = self.retardation[k];
            let name = format!("rate {} of the creep, from that of the relaxation", k + 1);
            Check::new(name, "1/s", (predicted, predicted), found[k], 0.03 * predicted)
        };
        Comparison {
            source: "8.1, conclusion 1",
            evidence: Evidence::Said,
            reason: "3 %: the controller takes some tenths of a second to reach the force, and a fit of a hold that begins \
                     then is no step"
                .into(),
            checks: vec![check(0), check(1)],
        }
    }

    fn section(&self) -> Section {
        let columns = vec![
            Column::text("mode"),
            Column::number("relaxes at", "1/s"),
            Column::number("share of the force", ""),
            Column::number("creeps at", "1/s"),
            Column::number("coefficient (6.2)", ""),
            Column::number("found under force control", "1/s"),
        ];
        let mut table = Table::new("One law, two responses", columns);
        for (k, name) in ["fast", "slow"].into_iter().enumerate() {
            table = table.row([
                name.to_owned(),
                significant(self.rates[k], 4),
                significant(self.shares[k + 1], 4),
                significant(self.retardation[k], 4),
                significant(self.coefficients[k], 4),
                self.found.map_or("–".into(), |found| significant(found[k].0, 4)),
            ]);
        }
        let times: Vec<f64> = (0..=300).map(|k| 0.04 * f64::from(k)).collect();
        let course = |of: &dyn Fn(f64) -> f64| times.iter().map(|t| of(*t)).collect::<Vec<f64>>();
        let plot = Plot::new("", Axis::new("time", "s"), Axis::new("part of its end, or of its beginning", ""))
            .summary("Relaxation falls from one to its share, creep rises from the same share to one, more slowly")
            .series(Series::line("force at a held displacement, of the first", &times[..], course(&|t| self.g(t))))
            .series(
                Series::line("displacement at a held force, of the last", &times[..], course(&|t| self.h(t)))
                    .colour(Colour::Hue(1)),
            )
            .level(self.shares[0], "c0");
        let slower = |k: usize| self.rates[k] / self.retardation[k];
        Section::new("Relaxation and creep, two sides of one law")
            .paragraph(
                "A linear specimen that relaxes by g(t) of (3.6) creeps by h(t) of (6.2), and by no other: the Laplace \
                 transforms satisfy s² ĝ ĥ = c0. With two exponentials on one side there are two on the other, at the \
                 zeros of c0 + Σ ci s/(s + vi).",
            )
            .figure(plot, "Force at a held displacement (3.6) and displacement at a held force that follows from it.")
            .table(table.note(format!(
                "Last column: the same specimen, {STIFFNESS} N/mm, pressed by a PI controller to {FORCE} N and held for {HOLD} s, looked at by `palpate creep`."
            )))
            .callout(
                Callout::Finding,
                "Two sides of the same coin (conclusion 1)",
                format!(
                    "The response of g to the strain h/c0 is one at all times, to {}. Creep is the slower of the two: the fast \
                     mode {} times, the slow one {} times. What creeps at first is c0 = {} of where it ends, the share that \
                     relaxation leaves.",
                    significant(self.residual, 1),
                    significant(slower(0), 3),
                    significant(slower(1), 3),
                    significant(self.h(0.0), 4)
                ),
            )
    }
}

/// The rates of creep: the zeros −μ of c0 + Σ ci s/(s + vi), one below each rate of relaxation; the faster first.
fn retardation(shares: &[f64; 3], rates: &[f64; 2]) -> [f64; 2] {
    let q = |rate: f64| {
        shares[0] - shares[1] * rate / (rates[0] - rate) - shares[2] * rate / (rates[1] - rate)
    };
    // Towards its pole from below q falls without end; just above the slower pole it is positive again.
    let zero = |mut low: f64, mut high: f64| {
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if q(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    [zero(rates[1] * (1.0 + 1e-12), rates[0]), zero(0.0, rates[1])]
}

/// The coefficient of a rate μ in (6.2): c0 over −μ q'(−μ).
fn coefficient(shares: &[f64; 3], rates: &[f64; 2], rate: f64) -> f64 {
    let slope: f64 = (0..2).map(|k| shares[k + 1] * rates[k] / (rates[k] - rate).powi(2)).sum();
    -shares[0] / (rate * slope)
}

/// A contact that carries an object: what it is, and its modulus, Pa.
struct Carrier {
    name: String,
    modulus_pa: f64,
    contact: Contact,
}

/// Friction coefficient and normal force, N, of Fig. 6.10, the same for all: the force is controlled.
const FRICTION: f64 = 0.7;
const NORMAL: f64 = 2.0;
/// Radius of the fingertip, mm, and Poisson's ratio of Table 5.2.
const RADIUS: f64 = 10.0;
const POISSON: f64 = 0.48;
/// Weight that one finger carries, N: half of what friction would hold.
const WEIGHT: f64 = 0.7;
const MATERIALS: [(&str, f64); 5] = [
    ("soft silicone (Table 5.2)", 3.497e4),
    ("hard silicone (Table 5.2)", 1.221e5),
    ("rubber, 3 MPa", 3e6),
    ("nylon, 3 GPa", 3e9),
    ("steel, 200 GPa", 2e11),
];

/// Radius, mm, of the contact of the fingertip with a flat rigid object (Hertz).
fn contact_radius(modulus_pa: f64) -> f64 {
    let reduced = 1e-6 * modulus_pa / (1.0 - POISSON * POISSON);
    // No wider than the fingertip.
    (0.75 * NORMAL * RADIUS / reduced).cbrt().min(RADIUS)
}

fn contacts() -> Vec<Carrier> {
    let carrier = |(name, modulus_pa): (&str, f64)| {
        let shape = Shape::Circle { radius: contact_radius(modulus_pa) };
        let contact = Contact::new(shape, PressureLaw::HERTZ).ok()?;
        Some(Carrier { name: name.into(), modulus_pa, contact })
    };
    MATERIALS.into_iter().filter_map(carrier).collect()
}

impl Carrier {
    /// Largest moment about the normal without a tangential force, N mm.
    fn moment(&self) -> f64 {
        FRICTION * NORMAL * self.contact.arm()
    }

    /// How far beside the contact the weight may hang, mm: until force and moment together are on the limit surface.
    fn reach(&self) -> f64 {
        let curve = limit_curve(&self.contact, FRICTION * NORMAL, FRAC_PI_2, 721);
        let at = |pair: &[palpate_contact::grasp::SurfacePoint]| {
            let (a, b) = (&pair[0].load, &pair[1].load);
            let (f, g) = (a.tangential(), b.tangential());
            let share = (WEIGHT - f) / (g - f);
            (0.0..=1.0).contains(&share).then_some(a.moment + share * (b.moment - a.moment))
        };
        curve.windows(2).find_map(at).map_or(f64::NAN, |moment| moment / WEIGHT)
    }
}

/// What conclusion 4 says: the softer holds more.
fn held(carriers: &[Carrier]) -> Comparison {
    let pairs = carriers.windows(2);
    let better = pairs.filter(|pair| pair[0].reach() > pair[1].reach()).count() as f64;
    let all = (carriers.len() - 1) as f64;
    Comparison {
        source: "8.1, conclusion 4",
        evidence: Evidence::Said,
        reason: "a count is exact".into(),
        checks: vec![Check::new(
            "materials of which each holds a weight farther off than the next harder one, of 4",
            "",
            (4.0, 1.0),
            better + 4.0 - all,
            0.0,
        )],
    }
}

fn soft_or_rigid(carriers: &[Carrier]) -> Section {
    let columns = vec![
        Column::text("fingertip"),
        Column::number("radius of the contact", "mm"),
        Column::number("largest moment", "N mm"),
        Column::number("weight beside it", "mm"),
    ];
    let mut table = Table::new("The same force on softer and harder fingertips", columns);
    for carrier in carriers {
        table = table.row([
            carrier.name.clone(),
            significant(contact_radius(carrier.modulus_pa), 3),
            significant(carrier.moment(), 3),
            significant(carrier.reach(), 3),
        ]);
    }
    let mut plot = Plot::new(
        "",
        Axis::new("tangential force", "N"),
        Axis::new("moment about the normal", "N mm"),
    )
    .summary("Limit curves of fingertips of five materials: all end at the same force, the softer at the larger moment");
    for (k, carrier) in carriers.iter().enumerate() {
        let curve = limit_curve(&carrier.contact, FRICTION * NORMAL, FRAC_PI_2, 161);
        let (force, moment): (Vec<f64>, Vec<f64>) =
            curve.iter().map(|point| (point.load.tangential(), point.load.moment)).unzip();
        plot =
            plot.series(Series::line(carrier.name.clone(), force, moment).colour(Colour::Hue(k)));
    }
    let words = match (carriers.first(), carriers.last()) {
        (Some(soft), Some(hard)) => format!(
            "All fingertips press with {NORMAL} N and μ = {FRICTION}, so all hold the same force; a moment they hold by the width of \
             their contact. The softest holds {} N mm and a weight of {WEIGHT} N hung {} mm beside it, the hardest {} N mm and {} mm, \
             {} of that. A rigid contact in the strict sense, a point, holds no moment at all: any weight that does not hang \
             straight below it turns. {}",
            significant(soft.moment(), 3),
            significant(soft.reach(), 3),
            significant(hard.moment(), 3),
            significant(hard.reach(), 3),
            percent(hard.reach() / soft.reach(), 2),
            if soft.reach() > hard.reach() {
                "Soft contact holds better, as conclusion 4 says."
            } else {
                "Here soft contact does not hold better, against conclusion 4."
            }
        ),
        _ => String::new(),
    };
    Section::new("Soft contact against rigid (conclusion 4)")
        .paragraph(format!(
            "A round fingertip of {RADIUS} mm radius is pressed on a flat, rigid object with a controlled force. Its contact widens \
             as Hertz has it, with the force over the modulus to the power 1/3; the limit surface is that of (6.7) to (6.9)."
        ))
        .figure(plot, "What each fingertip holds: force and moment together, the object turning about points of one line.")
        .table(table.note(format!(
            "Weight beside it: how far from the contact's centre {WEIGHT} N may hang before the contact slips."
        )))
        .callout(Callout::Finding, "Grasp stability", words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creep_undoes_relaxation_and_begins_at_the_share_that_relaxation_leaves() {
        let sides = Sides::new();
        assert!(sides.residual < 1e-5, "{}", sides.residual);
        assert!((sides.h(0.0) - sides.shares[0]).abs() < 1e-12);
        // Rates interlace: each mode creeps more slowly than it relaxes.
        let [fast, slow] = sides.retardation;
        assert!(slow < sides.rates[1] && sides.rates[1] < fast && fast < sides.rates[0]);
        let found = sides.found.unwrap();
        for (found, predicted) in found.iter().zip([fast, slow]) {
            assert!((found.0 / predicted - 1.0).abs() < 0.03, "{} {predicted}", found.0);
        }
    }

    #[test]
    fn the_moment_falls_with_the_cube_root_of_the_modulus() {
        let moments: Vec<f64> = contacts().iter().map(Carrier::moment).collect();
        let expected = (1.221e5f64 / 3e6).cbrt();
        assert!((moments[2] / moments[1] / expected - 1.0).abs() < 1e-6);
        assert!(contacts().windows(2).all(|pair| pair[0].reach() > pair[1].reach()));
    }
}
