//! 6.4.5: how creep under a constant force makes a grasp more stable (eqs 6.7–6.10, Figs 6.9 and 6.10).

use std::f64::consts::FRAC_PI_2;

use super::{Chapter, Check, Comparison, Evidence};
use crate::summary::{growth_sections, pressure_plot};
use palpate_contact::grasp::growth::{creep, growth};
use palpate_contact::grasp::{
    Body, Contact, Grown, Motion, PressureLaw, Shape, SurfacePoint, limit_curve,
};
use palpate_model::Branch;
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Plot, Section, Series};

/// Coefficient of friction μ of Fig. 6.10.
pub const FRICTION: f64 = 0.7;
/// Normal force of Fig. 6.10, N.
pub const NORMAL: f64 = 2.0;
/// Exponent k of the pressure (6.4.5).
pub const EXPONENT: f64 = 4.0;
/// Length and width of the contact at the beginning and at the end of Fig. 6.10, mm.
pub const SIZES: [[f64; 2]; 2] = [[42.22, 26.38], [42.39, 26.50]];
/// The block of 6.3.1, pressed along its longest side, with Poisson's ratio of Table 5.2.
pub const BLOCK: Body = Body::Block { length: 40.0, width: 25.0, height: 50.0, poisson: 0.48 };
/// Compression that creep under 2 N settles at, mm, and its exponentials, mm and 1/s (eq. B.2).
const EQUATION_B_2: (f64, [(f64, f64); 2]) = (8.100, [(-0.5977, 0.8229), (-1.733, 0.007_805)]);
/// How long the force was held, s (6.3.2).
const HELD: f64 = 9.5;
/// One unit of the last printed digit of a size, mm, and half of it.
const DIGIT: f64 = 0.01;
const ROUNDING: f64 = 0.5 * DIGIT;
/// Points of a drawn curve.
const CURVE_POINTS: usize = 161;

/// What 6.4.5 claims, computed anew.
#[must_use]
pub fn chapter() -> Chapter {
    let [before, after] = SIZES.map(printed_contact);
    let course = crept();
    let comparisons = vec![sizes(&course), tangential(&before, &after), at_last(&course)];
    let gain = after.arm() / before.arm() - 1.0;
    let section = Section::new("A limit surface that grows with creep (6.4.5)")
        .paragraph(
            "A contact of finite area holds a tangential force and a moment about its normal at once, up to \
             the friction limit surface: all loads at which it slips with some centre of rotation. The \
             claim: under a constant normal force the object creeps, its contact widens by the Poisson \
             effect, and the surface grows in the direction of the moment while the largest tangential \
             force stays.",
        )
        .callout(
            Callout::Finding,
            "The claim holds",
            format!(
                "From the first to the last printed size the largest moment grows from {} to {} N mm, by \
                 {}, which is the growth of the length and width; the largest tangential force is μN = {} \
                 N whatever the size.",
                significant(limit() * before.arm(), 4),
                significant(limit() * after.arm(), 4),
                percent(gain, 2),
                significant(limit(), 3),
            ),
        )
        .figure(surfaces(&before, &after), "Fig. 6.10 in kind: force along y, the centre of rotation on the x axis.")
        .figure(
            gains(&before, &after),
            "The two curves differ by less than a line is wide; this is how much the moment gains.",
        )
        .figure(pressure_plot(&before, NORMAL), "Eq. 6.10 with k = 4 at the beginning, along the length.")
        .callout(Callout::Warning, "Slips in eq. 6.10", slips(&before))
        .callout(Callout::Finding, "Where the printed sizes come from", origin(&course));
    let mut sections = vec![section];
    sections.extend(
        growth_sections(&course).into_iter().map(|section| Section {
            title: "The same from the creep of eq. B.2".into(),
            ..section
        }),
    );
    Chapter { title: "Chapter 6: the stability of a grasp", comparisons, sections }
}

/// μN, N.
fn limit() -> f64 {
    FRICTION * NORMAL
}

/// The law of 6.4.5.
fn law() -> PressureLaw {
    PressureLaw::new(EXPONENT).unwrap_or(PressureLaw::HERTZ)
}

fn printed_contact([length, width]: [f64; 2]) -> Contact {
    contact(length, width, law())
}

fn contact(length: f64, width: f64, law: PressureLaw) -> Contact {
    Contact::new(Shape::Rectangle { length, width }, law).expect("the printed sizes are above 0")
}

/// The block over the hold of Appendix B.
fn crept() -> Vec<Grown> {
    let (settled, terms) = EQUATION_B_2;
    let shares = terms.map(|(amplitude, rate)| Branch { share: amplitude / settled, rate });
    let times: Vec<f64> = (0..=95).map(|k| HELD * f64::from(k) / 95.0).collect();
    growth(&BLOCK, law(), FRICTION, &creep(&times, settled, &shares, NORMAL))
}

fn sides(grown: &Grown) -> [f64; 2] {
    match grown.shape {
        Shape::Rectangle { length, width } => [length, width],
        Shape::Circle { radius } => [2.0 * radius; 2],
        Shape::Ellipse { x, y } => [2.0 * x, 2.0 * y],
    }
}

fn sizes(course: &[Grown]) -> Comparison {
    let [length, width] = course.first().map_or([0.0; 2], sides);
    let grown = SIZES[1][0] / SIZES[0][0] * SIZES[0][1];
    // The same factor on both sides, each printed size being off by half a digit.
    let ratio = SIZES[0][1] / SIZES[0][0];
    let spread = ROUNDING * (2.0 + 2.0 * ratio);
    Comparison {
        source: "Fig. 6.10",
        evidence: Evidence::Derived,
        reason: "half a unit of the last printed digit; of all sizes used, for the width that follows from them"
            .into(),
        checks: vec![
            Check::new("length at first, from eqs B.2 and 5.5", "mm", (SIZES[0][0], DIGIT), length, ROUNDING),
            Check::new("width at first, from eqs B.2 and 5.5", "mm", (SIZES[0][1], DIGIT), width, ROUNDING),
            Check::new("width at last, grown as the length", "mm", (SIZES[1][1], DIGIT), grown, spread),
        ],
    }
}

/// The length after the hold, which does not follow.
fn at_last(course: &[Grown]) -> Comparison {
    let [length, _] = course.last().map_or([f64::NAN; 2], sides);
    Comparison {
        source: "Fig. 6.10, length at last",
        evidence: Evidence::NotReproduced,
        reason: format!(
            "the creep of (B.2) and Poisson's ratio, which give the first sizes to the digit, give this one after the {HELD} s of a hold; the text does not say at which time its last size is taken"
        ),
        checks: vec![Check::exact("length at last", "mm", (SIZES[1][0], DIGIT), length)],
    }
}

fn tangential(before: &Contact, after: &Contact) -> Comparison {
    let largest = |contact: &Contact| {
        let curve = limit_curve(contact, limit(), FRAC_PI_2, 2);
        curve.last().map_or(0.0, |point| point.load.tangential())
    };
    Comparison {
        source: "6.4.5",
        evidence: Evidence::Said,
        reason: "it is claimed to be unaffected, and is exactly".into(),
        checks: vec![Check::new(
            "change of the largest tangential force",
            "N",
            (0.0, 1.0),
            largest(after) - largest(before),
            1e-12,
        )],
    }
}

fn surfaces(before: &Contact, after: &Contact) -> Plot {
    let line = |name: &str, contact: &Contact, colour| {
        let curve = limit_curve(contact, limit(), FRAC_PI_2, CURVE_POINTS);
        let (force, moment) = columns(&curve);
        Series::line(name, force, moment).colour(colour)
    };
    Plot::new(
        "",
        Axis::new("tangential force", "N"),
        Axis::new("moment about the normal", "N mm"),
    )
    .series(line("42.22 × 26.38 mm", before, Colour::Hue(0)))
    .series(line("42.39 × 26.50 mm", after, Colour::Hue(1)))
    .summary("Two limit curves from the largest moment to the largest force, the later one just outside")
}

fn gains(before: &Contact, after: &Contact) -> Plot {
    let pairs = limit_curve(before, limit(), FRAC_PI_2, CURVE_POINTS);
    let (force, gain): (Vec<f64>, Vec<f64>) = pairs
        .iter()
        .map(|point| {
            let force = point.load.tangential();
            (force, moment_at(after, force) - moment_at(before, force))
        })
        .unzip();
    Plot::new("", Axis::new("tangential force", "N"), Axis::new("gain of the moment", "N mm"))
        .series(Series::line("gain", force, gain).colour(Colour::Hue(2)))
        .height(140.0)
        .summary("The gain of the moment is largest without a tangential force and vanishes at the largest")
}

/// The moment that holds beside a tangential force along y, N mm: along the curve the force falls as the turn
/// grows, so bisection finds its motion.
fn moment_at(contact: &Contact, force: f64) -> f64 {
    let at = |slope: f64| {
        let turn = slope.sin() / contact.arm();
        contact.slipping(&Motion { velocity: [0.0, slope.cos()], turn }).times(limit())
    };
    let (mut translation, mut turn) = (0.0, FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (translation + turn);
        let side = if at(middle).tangential() > force { &mut translation } else { &mut turn };
        *side = middle;
    }
    at(turn).moment
}

fn columns(curve: &[SurfacePoint]) -> (Vec<f64>, Vec<f64>) {
    curve.iter().map(|point| (point.load.tangential(), point.load.moment)).unzip()
}

/// What is wrong with eq. 6.10 as it is printed, in numbers.
fn slips(before: &Contact) -> String {
    let [length, width] = SIZES[0];
    let uniform = contact(length, width, PressureLaw::UNIFORM);
    let round = law().circular_constant() / law().strip_constant();
    format!(
        "It divides x by the full length of Fig. 6.9, so the pressure at the edge would still be {} of that in \
         the middle, next to uniform; to vanish there, x must be divided by half the length, as it is here. And \
         its Ck is not that of eq. 8.2, which belongs to a round contact: in a strip that would carry {} \
         times the normal force. Its own is Γ(1 + 2/k)/Γ(1 + 1/k)², {} for k = 4. A uniform pressure would hold \
         a moment of {} N mm at first, in place of {} N mm.",
        significant(law().shape(0.5), 3),
        significant(round, 4),
        significant(law().strip_constant(), 5),
        significant(limit() * uniform.arm(), 4),
        significant(limit() * before.arm(), 4),
    )
}

/// The printed sizes are those of the block of 6.3.1.
fn origin(course: &[Grown]) -> String {
    let Body::Block { length, height, poisson, .. } = BLOCK else { return String::new() };
    let compression = |printed: f64| (printed / length - 1.0) * height / poisson;
    let last = compression(SIZES[1][0]);
    let reached = course.iter().find(|grown| grown.held.compression >= last);
    let end = course.last().map_or([0.0; 2], sides);
    format!(
        "The text gives the sizes without their origin. A block of 40 × 25 mm, 50 mm high (6.3.1), with ν = 0.48 \
         has the first ones to the printed digit at the compression of {} mm with which eq. B.2 begins. The \
         last ones need {} mm, which that creep reaches after {} s; after the {HELD} s of a hold it would have \
         {} × {} mm, and {} more moment than at first.",
        significant(course.first().map_or(0.0, |grown| grown.held.compression), 4),
        significant(last, 3),
        reached.map_or("–".into(), |grown| significant(grown.held.time, 2)),
        significant(end[0], 4),
        significant(end[1], 4),
        percent(end[0] / SIZES[0][0] - 1.0, 2),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moment_gains_at_every_force_below_the_largest() {
        let [before, after] = SIZES.map(printed_contact);
        for force in [0.0, 0.3, 0.9, 1.3] {
            assert!(moment_at(&after, force) > moment_at(&before, force) * 1.003, "{force}");
        }
    }
}
