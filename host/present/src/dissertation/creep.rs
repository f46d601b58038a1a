//! Chapter 6, creep: force control at several loading rates, Type I and II, dissipation, asymptotes. The
//! fits themselves are in the appendices.

use super::simulated::{course, noisy, times, trace};
use super::{Chapter, Check, Comparison, Evidence, force_control};
use palpate_analysis::creep::{Hold, creep};
use palpate_analysis::cycles::segment;
use palpate_analysis::regions::numeral;
use palpate_fit::consistency::consistency;
use palpate_fit::exponentials::Parameter;
use palpate_fit::hold::Terms;
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};
use palpate_trace::{Control, DISPLACEMENT, Trace};

/// Loading rates of chapter 6, N/s.
const RATES: [f64; 4] = [0.092, 0.85, 1.96, 2.71];
/// Held force, N, and length of a hold, s.
const FORCE_HELD: f64 = 2.0;
const HOLD: f64 = 9.5;
/// (B.1) as a compliance: D at 2 N, mm, share and rate, 1/s.
const D: f64 = 6.480;
const SHARE: f64 = -0.6787 / 6.480;
const RATE: f64 = 0.5907;
/// Samples per second, and noise of the displacement, mm: its accuracy of 1 µm.
const SAMPLING: f64 = 200.0;
const NOISE: f64 = 1e-3;

/// The creep of chapter 6.
#[must_use]
pub fn chapter() -> Chapter {
    Chapter {
        title: "Chapter 6: creep",
        comparisons: vec![inertia()],
        sections: vec![claim(), force_control::section(), types(), rates()],
    }
}

fn inertia() -> Comparison {
    Comparison {
        source: "Section 6.3.1",
        evidence: Evidence::Derived,
        reason: "half of the last printed digit".into(),
        checks: vec![Check::exact(
            "inertial force of 14 g at 100 mm/s²",
            "N",
            (0.0014, 1e-4),
            14e-3 * 0.1,
        )],
    }
}

fn claim() -> Section {
    Section::new("What was claimed")
        .paragraph("A block of silicone was pressed with a controlled force, and its displacement recorded while the force was held. It was written as δ = D (1 + Σ ci e^(−vi t)) (6.1, 6.2): here the constant is one, not the sum, because where the displacement ends is the same whatever the loading, and how it begins is not. After loading it grows, ci < 0 (Type I, 6.3), after partial unloading it falls, ci > 0 (Type II, 6.4). Faster loading leaves more to creep, looks stiffer and dissipates more.")
        .paragraph(format!("The recordings are not printed. Here a specimen with the compliance of (B.1), {D} mm at {FORCE_HELD} N with a rate of {RATE} 1/s, follows the printed loading rates; `palpate creep` and `palpate segment` look at it. Appendix B has the fits that are printed."))
}

/// The answer of the specimen to a force through corners of (time, force).
fn recording(name: &str, corners: &[(f64, f64)], seed: u64) -> Trace {
    let last = corners[corners.len() - 1].0;
    let time = times(last, SAMPLING);
    let force: Vec<f64> = time.iter().map(|t| course(corners, *t)).collect();
    let decay = (-RATE / SAMPLING).exp();
    // Exact for a force that is straight between samples.
    let gain = SAMPLING * (1.0 - decay) / RATE;
    let mut z = 0.0;
    let displacement = (0..force.len())
        .map(|k| {
            z = z * decay + gain * if k == 0 { 0.0 } else { force[k] - force[k - 1] };
            D / FORCE_HELD * (force[k] + SHARE * z)
        })
        .collect();
    trace(name, Control::Force, time, noisy(displacement, NOISE, seed), force)
}

fn once(rate: f64, seed: u64) -> Trace {
    let ramp = FORCE_HELD / rate;
    let hold = 0.5 + ramp + HOLD;
    let corners = [
        (0.0, 0.0),
        (0.5, 0.0),
        (0.5 + ramp, FORCE_HELD),
        (hold, FORCE_HELD),
        (hold + ramp, 0.0),
        (hold + ramp + 8.0, 0.0),
    ];
    recording(&format!("{rate} N/s"), &corners, seed)
}

/// Fig. 6.6 in kind: 4 N and 2 N by turns at 0.85 N/s.
fn by_turns() -> Trace {
    let rate = RATES[1];
    let mut corners = vec![(0.0, 0.0), (0.5, 0.0)];
    let (mut now, mut at) = (0.5, 0.0);
    for level in [4.0, 2.0, 4.0, 2.0, 0.0] {
        now += f64::abs(level - at) / rate;
        at = level;
        corners.push((now, at));
        now += HOLD;
        corners.push((now, at));
    }
    recording("4 N and 2 N by turns", &corners, 9)
}

fn holds(trace: &Trace) -> Vec<Hold> {
    creep(trace, DISPLACEMENT, Terms::Fixed(1), false).map(|found| found.holds).unwrap_or_default()
}

fn types() -> Section {
    let trace = by_turns();
    let columns = vec![
        Column::number("from", "s"),
        Column::number("force", "N"),
        Column::text("type"),
        Column::number("D", "mm"),
        Column::number("c1", ""),
        Column::number("v1", "1/s"),
    ];
    let mut table = Table::new("Holds by turns (Figs 6.5–6.7 in kind)", columns);
    for hold in holds(&trace) {
        let sum = &hold.fit.fit.sum;
        table = table.row([
            significant(hold.fit.from_s, 4),
            hold.force.map_or("–".into(), |force| significant(force.0, 3)),
            numeral(hold.fit.relaxation).to_owned(),
            significant(sum.scale, 4),
            significant(sum.terms[0].coefficient, 3),
            significant(sum.terms[0].rate, 3),
        ]);
    }
    let plot = Plot::new(
        "Displacement under 4 N and 2 N by turns (Fig. 6.6)",
        Axis::new("time", "s"),
        Axis::new("displacement", "mm"),
    )
    .summary("Displacement creeping up after loading and down after unloading")
    .series(
        Series::line("displacement", &trace.time[..], trace.displacement().unwrap_or(&[]))
            .colour(Colour::MEASURED),
    );
    Section::new("Type I and Type II creep")
        .table(table.note("Signs are found, not imposed: c1 < 0 after loading (6.3), c1 > 0 after unloading (6.4)."))
        .figure(plot, "Figs 6.6 and 6.7 in kind: creep of Type I at 4 N, of Type II at 2 N.")
}

fn rates() -> Section {
    let columns = vec![
        Column::number("loading rate", "N/s"),
        Column::number("at the start of the hold", "mm"),
        Column::text("left to creep"),
        Column::number("D", "mm"),
        Column::number("dissipated", "mJ"),
        Column::text("of the work in"),
    ];
    let mut table = Table::new("The same force reached at the printed rates", columns);
    let axes = (Axis::new("displacement", "mm"), Axis::new("force", "N"));
    let mut plot = Plot::new("Loops at the printed rates (Fig. 6.8)", axes.0, axes.1)
        .summary("Force over displacement at four loading rates");
    let mut asymptotes = (Vec::new(), Vec::new());
    for (index, rate) in RATES.into_iter().enumerate() {
        let trace = once(rate, index as u64 + 1);
        let (Some(hold), Ok(found)) = (holds(&trace).into_iter().next(), segment(&trace)) else {
            continue;
        };
        let Some(cycle) = found.cycles.first() else { continue };
        let sum = &hold.fit.fit.sum;
        asymptotes.0.push(sum.scale);
        asymptotes.1.extend(hold.fit.fit.standard_error(Parameter::Scale));
        table = table.row([
            significant(rate, 3),
            significant(sum.at(0.0), 4),
            percent(1.0 - sum.at(0.0) / sum.scale, 2),
            significant(sum.scale, 4),
            significant(cycle.dissipated_mj(), 3),
            percent(cycle.dissipated_mj() / cycle.work_in_mj, 2),
        ]);
        let line = Series::line(
            format!("{rate} N/s"),
            trace.displacement().unwrap_or(&[]),
            trace.force().unwrap_or(&[]),
        );
        plot = plot.series(line.colour(Colour::Hue(index)));
    }
    let agree = (asymptotes.0.len() == asymptotes.1.len())
        .then(|| consistency(&asymptotes.0, &asymptotes.1))
        .flatten();
    let words = format!(
        "A higher rate begins its hold at a smaller displacement and looks stiffer (6.5), dissipates more, and ends where every other ends{} (6.6). In a linear specimen like this one that is no property of a rate-dependent elastic response: the elastic response is one, what differs is how much had time to creep on the way.",
        agree.map_or(String::new(), |test| format!(
            ", χ² {} with {} degrees of freedom, p {}",
            significant(test.chi_square, 2),
            test.degrees_of_freedom,
            significant(test.p_value, 2)
        ))
    );
    Section::new("Loading rate, stiffness and dissipation")
        .table(table)
        .figure(plot, "Fig. 6.8 in kind. Clockwise: what a loop encloses is dissipated.")
        .callout(Callout::Finding, "What the rate changes", words)
}

#[cfg(test)]
mod tests {
    use shared::phase::RelaxationType;

    use super::*;

    #[test]
    fn dissipation_grows_with_the_loading_rate_and_the_asymptote_does_not() {
        let dissipated: Vec<f64> = RATES
            .iter()
            .map(|rate| segment(&once(*rate, 1)).unwrap().cycles[0].dissipated_mj())
            .collect();
        assert!(dissipated.windows(2).all(|pair| pair[0] < pair[1]), "{dissipated:?}");
        for rate in RATES {
            let hold = &holds(&once(rate, 1))[0];
            let error = hold.fit.fit.standard_error(Parameter::Scale).unwrap();
            assert!((hold.fit.fit.sum.scale - D).abs() < 5.0 * error, "{rate} N/s");
        }
    }

    #[test]
    fn types_alternate_with_the_direction_of_the_force() {
        let types: Vec<RelaxationType> =
            holds(&by_turns()).iter().map(|hold| hold.fit.relaxation).collect();
        use RelaxationType::{TypeI, TypeII};
        assert_eq!(types[..4], [TypeI, TypeII, TypeI, TypeII]);
    }
}
