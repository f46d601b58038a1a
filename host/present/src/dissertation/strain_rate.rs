//! Chapter 7: the power law of a ball's strain. Tables 7.1 and 7.2, Fig. 7.6 in kind.

use super::comparison::{decimals, digits};
use super::simulated::{course, noisy, times, trace};
use super::{Chapter, Check, Comparison, Evidence};
use crate::summary::strain_rate_sections;
use palpate_analysis::geometry::{Faces, Geometry};
use palpate_analysis::strain_rate::{Order, Study, strain_rate};
use palpate_model::latency::Power;
use palpate_report::number::significant;
use palpate_report::{Block, Callout, Column, Section, Table};
use palpate_trace::{Control, Shape, Trace};

/// Radius of the ball, mm, and its modulus, Pa.
const RADIUS: f64 = 35.0;
const MODULUS: f64 = 2.8e4;
/// Order n.
const ORDER: f64 = 5.0;
/// Speed between the holds, mm/s: 500 mm/min.
const SPEED: f64 = 500.0 / 60.0;
/// Length of a hold, s.
const HOLD: f64 = 10.0;
/// Samples per second: not printed.
const SAMPLING: f64 = 100.0;
/// Distance from equilibrium at which a hold begins: not printed. After loading, and after unloading.
const GAPS: (f64, f64) = (0.10, -0.06);
/// Noise of the force for the second look, N: a tenth of the load cell's accuracy.
const NOISE: f64 = 0.02;

/// A hold of Tables 7.1 and 7.2: displacement, mm; |ε_e|; ν, 1/s.
type Row = (f64, f64, f64);

/// Table 7.1, loading.
const LOADING: [Row; 5] = [
    (5.0, 0.1661, 4.1e4),
    (10.0, 0.2193, 2.6e4),
    (15.0, 0.2623, 2.0e4),
    (20.0, 0.3031, 1.4e4),
    (25.0, 0.3144, 1.2e3),
];
/// Table 7.2, unloading; its first hold ends the loading.
const UNLOADING: [Row; 5] = [
    (25.0, 0.3144, 1.4e3),
    (20.0, 0.3031, 1.4e6),
    (15.0, 0.2623, 1.4e5),
    (10.0, 0.2193, 7.0e4),
    (5.0, 0.1661, 2.8e4),
];

/// Chapter 7.
#[must_use]
pub fn chapter() -> Chapter {
    let study = |rows: &[Row], noise: f64, order: Order| {
        strain_rate(&[recording(rows, noise)], MODULUS, order, Faces::One).ok()
    };
    let tables = [("Table 7.1", LOADING), ("Table 7.2", UNLOADING)];
    let comparisons = tables
        .iter()
        .map(|(source, rows)| {
            compared(source, rows, study(rows, 0.0, Order::Fixed(ORDER)).as_ref())
        })
        .collect();
    let mut sections = vec![claim(), slip()];
    for (source, rows) in tables {
        let Some(noisy) = study(&rows, NOISE, Order::LowestOdd) else { continue };
        for section in strain_rate_sections(&noisy) {
            let title = format!("{source} with noise of {NOISE} N");
            sections.push(folded(Section { title, ..section }));
        }
    }
    Chapter { title: "Chapter 7: strain rate over strain", comparisons, sections }
}

/// The section with the figures of its first hold; those of the others are folded away.
fn folded(section: Section) -> Section {
    let (mut shown, mut others) = (Section::new(section.title), Vec::new());
    let mut figures = 0;
    for block in section.blocks {
        let figure = matches!(block, Block::Figure { .. });
        figures += usize::from(figure);
        if figure && figures > 2 { others.push(block) } else { shown.blocks.push(block) }
    }
    shown.block(Block::Details { summary: "The other holds".into(), blocks: others })
}

/// The law of a row; the first hold of a run and all deeper ones follow a loading.
fn law(rows: &[Row], index: usize) -> Power {
    let (displacement, equilibrium, rate) = rows[index];
    let loaded = index == 0 || displacement > rows[index - 1].0;
    let gap = if loaded { GAPS.0 } else { GAPS.1 };
    Power { rate, order: ORDER, equilibrium, initial: equilibrium + gap }
}

/// One run through the holds of a table: straight between them, the law within each.
fn recording(rows: &[Row], noise: f64) -> Trace {
    let mut corners = vec![(0.0, 0.0), (0.5, 0.0)];
    let mut begins = Vec::new();
    let (mut now, mut at) = (0.5, 0.0);
    for (displacement, _, _) in rows {
        now += f64::abs(displacement - at) / SPEED;
        at = *displacement;
        begins.push(now);
        corners.push((now, at));
        now += HOLD;
        corners.push((now, at));
    }
    let mut strains = vec![(0.0, 0.0), (0.5, 0.0)];
    for (index, begin) in begins.iter().enumerate() {
        strains.push((*begin, law(rows, index).initial));
        strains.push((begin + HOLD, law(rows, index).strain(HOLD)));
    }
    now += at / SPEED;
    corners.push((now, 0.0));
    strains.push((now, 0.0));
    let time = times(now + 1.0, SAMPLING);
    let ball = Geometry::Ball { radius_mm: RADIUS, faces: Faces::One };
    let strain = |t: f64| {
        let hold = begins.iter().position(|begin| (*begin..=begin + HOLD).contains(&t));
        hold.map_or_else(|| course(&strains, t), |index| law(rows, index).strain(t - begins[index]))
    };
    let x: Vec<f64> = time.iter().map(|t| course(&corners, *t)).collect();
    let force =
        time.iter().zip(&x).map(|(t, x)| MODULUS * strain(*t) * ball.area_mm2(*x) * 1e-6).collect();
    let force = noisy(force, noise, 7);
    let mut trace = trace("holds of a ball", Control::Displacement, time, x, force);
    trace.head.specimen.shape = Some(Shape::Sphere);
    trace.head.specimen.radius_mm = Some(RADIUS);
    trace
}

fn compared(source: &'static str, rows: &[Row], study: Option<&Study>) -> Comparison {
    let mut checks = Vec::new();
    for (index, (_, equilibrium, rate)) in rows.iter().enumerate() {
        let fit = study.and_then(|study| study.holds.get(index)).map(|hold| &hold.fit.law);
        let (found, pace) = fit.map_or((f64::NAN, f64::NAN), |law| (law.equilibrium, law.rate));
        let n = index + 1;
        let strain = (*equilibrium, decimals(4));
        checks.push(Check::exact(format!("curve {n}, |ε_e|"), "", strain, found));
        let rate = (*rate, digits(*rate, 2));
        checks.push(Check::exact(format!("curve {n}, ν"), "1/s", rate, pace));
    }
    Comparison {
        source,
        evidence: Evidence::FoundAgain,
        reason: "half of the last printed digit: the forces were simulated from the printed ν and ε_e without noise, and both must come back through (7.7), (7.8) and the fit".into(),
        checks,
    }
}

fn claim() -> Section {
    Section::new("What was claimed")
        .paragraph("A rubber ball of 35 mm radius was pressed in steps of 5 mm and held for 10 s at each, and let back in the same steps. Strain was taken as force over the area of contact and a modulus of 28 kPa (7.6)–(7.8). Its rate does not fall in proportion to the distance from equilibrium, as the linear latency model has it, but with its fifth power: ε̇ = −ν (ε − ε_e)⁵, the lowest odd power that fitted best. ν fell from step to step in loading and was erratic in unloading.")
        .paragraph(format!("The recordings are not printed. Here each hold is simulated with the printed ν and ε_e; how far from equilibrium it begins is not printed and taken as {} after loading and {} after unloading. First without noise: the printed digits must come back. Then with noise of {NOISE} N, a tenth of the accuracy of the load cell, and the order chosen by the data: that shows what such holds can determine.", GAPS.0, GAPS.1))
        .paragraph("Printed strains are negative in compression; here compression is positive. The law is the same for both.")
}

fn slip() -> Section {
    let one = Geometry::Ball { radius_mm: RADIUS, faces: Faces::One };
    let each = Geometry::Ball { radius_mm: RADIUS, faces: Faces::Each };
    let columns = vec![
        Column::number("displacement", "mm"),
        Column::number("area, one face", "mm²"),
        Column::number("area, each face", "mm²"),
        Column::number("strain, each over one", ""),
    ];
    let mut table = Table::new("Two meanings of d in (7.7)", columns);
    for (displacement, _, _) in LOADING {
        let (a, b) = (one.area_mm2(displacement), each.area_mm2(displacement));
        table = table.row([
            significant(displacement, 2),
            significant(a, 4),
            significant(b, 4),
            significant(a / b, 3),
        ]);
    }
    let mut section = Section::new("One face or each");
    section.blocks.push(Block::Callout {
        kind: Callout::Warning,
        title: "A slip".into(),
        text: "(7.7) and (7.8) take d as the whole displacement, pressed into one side; the simulation of 7.4 moves each of two faces by d/2. The same force is then up to twice the strain. `palpate strain-rate --faces one` is the first, `--faces each` the second; Tables 7.1 and 7.2 follow (7.8) and are recomputed with the first.".into(),
    });
    section.table(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fifth_power_is_found_again_under_noise() {
        let traces = [recording(&LOADING, NOISE), recording(&UNLOADING, NOISE)];
        let study = strain_rate(&traces, MODULUS, Order::LowestOdd, Faces::One).unwrap();
        assert_eq!((study.order, study.holds.len()), (Some(ORDER), 10));
    }
}
