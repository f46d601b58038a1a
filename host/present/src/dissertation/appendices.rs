//! Appendices A and B: how many exponentials a relaxation and a creep show.

use shared::phase::RelaxationType;

use super::comparison::{decimals, digits};
use super::simulated::{noisy, times};
use super::{Chapter, Check, Comparison, Evidence, TABLE_3_1};
use crate::bundled::grasps;
use crate::summary::number_table;
use palpate_analysis::creep::doubts;
use palpate_analysis::terms::{Terms, terms};
use palpate_fit::exponentials::{ExponentialSum, Fit, Normalisation, Options, Prepared, Term};
use palpate_report::number::counted;
use palpate_report::{Axis, Callout, Colour, Plot, Section, Series};
use palpate_trace::{FORCE, Trace, holds};

/// Length of the hold of row 05: from 0.2 s + 12 mm / 20 mm/s to 5.1 s.
const HOLD_A: f64 = 4.3;
/// Length of the hold of Fig. 6.4.
const HOLD_B: f64 = 9.5;
/// Samples per second.
const RATE: f64 = 200.0;
/// (A.1): F = a + b e^(−v t): a N, b N, v 1/s.
const A_1: [f64; 3] = [1.0870, 0.7820, 1.208];
/// (A.2): a; b, v; b, v.
const A_2: [f64; 5] = [0.9987, 0.4780, 3.672, 0.5144, 0.5145];
/// Rates of (A.1) to (A.4) and the time constants of Table A.1; s.
const TABLE_A_1: [(&str, f64, f64); 10] = [
    ("(A.1) τ1", 1.208, 0.8278),
    ("(A.2) τ1", 3.672, 0.2723),
    ("(A.2) τ2", 0.5145, 1.9436),
    ("(A.3) τ1", 4.009, 0.2494),
    ("(A.3) τ2", 0.8896, 1.1241),
    ("(A.3) τ3", 0.1758, 5.6883),
    ("(A.4) τ1", 4.206, 0.2378),
    ("(A.4) τ2", 1.4, 0.7143),
    ("(A.4) τ3", 0.3545, 2.8209),
    ("(A.4) τ4", 8.5e-5, 11628.0),
];
/// (B.1) to (B.3): D and each (coefficient in mm, rate in 1/s).
const B: [(f64, &[(f64, f64)]); 3] = [
    (6.480, &[(-0.6787, 0.5907)]),
    (8.100, &[(-0.5977, 0.8229), (-1.733, 0.007805)]),
    (7.622, &[(-0.5973, 0.8235), (-0.7719, 0.01161), (-0.4833, 0.009946)]),
];
/// Table B.1: D, then each (c, v).
const TABLE_B_1: [(f64, &[(f64, f64)]); 3] = [
    (6.48, &[(-1.05e-1, 5.91e-1)]),
    (8.10, &[(-7.38e-2, 8.23e-1), (-2.14e-1, 7.81e-3)]),
    (7.62, &[(-7.84e-2, 8.24e-1), (-1.01e-1, 1.16e-2), (-6.34e-2, 9.95e-3)]),
];
/// R² of one, two and three exponentials in Table B.1.
const R_SQUARED_B: [f64; 3] = [0.9162, 0.9411, 0.9411];
/// Seed of the noise of the rebuilt creep.
const SEED: u64 = 11;

/// Appendices A and B.
#[must_use]
pub fn chapter() -> Chapter {
    let creep = rebuilt_creep();
    let mut comparisons = vec![one_exponential(), two_exponentials(), time_constants()];
    comparisons.extend(more_exponentials());
    comparisons.extend([normalised(), one_exponential_of_two()]);
    comparisons.extend(r_squared(&creep));
    Chapter {
        title: "Appendices A and B: how many exponentials?",
        comparisons,
        sections: vec![relaxation_section(), creep_section(&creep)],
    }
}

/// Row 05 of Table 3.1 as a sum.
fn row_05() -> ExponentialSum {
    let row = TABLE_3_1[4];
    let term = |k: usize| Term { coefficient: row.shares[k + 1], rate: row.rates[k] };
    ExponentialSum { scale: row.force, constant: row.shares[0], terms: vec![term(0), term(1)] }
}

/// (A.1) from row 05: one exponential fitted to the sum of two.
fn one_exponential() -> Comparison {
    let time = times(HOLD_A, RATE);
    let force: Vec<f64> = time.iter().map(|t| row_05().at(*t)).collect();
    let options = Options { terms: 1, ..Options::default() };
    let fit = Prepared::new(&time, &options).and_then(|prepared| prepared.fit(&force));
    let found = fit.map_or([f64::NAN; 3], |fit| {
        let term = fit.sum.terms[0];
        [fit.sum.scale * fit.sum.constant, fit.sum.scale * term.coefficient, term.rate]
    });
    let check = |k: usize| {
        let (name, unit) = [("constant", "N"), ("coefficient", "N"), ("rate", "1/s")][k];
        let digit = if unit == "N" { decimals(4) } else { decimals(3) };
        Check::new(name, unit, (A_1[k], digit), found[k], 0.02 * A_1[k])
    };
    Comparison {
        source: "Eq. A.1",
        evidence: Evidence::Derived,
        reason: "2 %: the recording is not printed; row 05 of Table 3.1 stands for it, and one exponential depends on how two share what it cannot follow".into(),
        checks: (0..3).map(check).collect(),
    }
}

/// (A.2) is row 05 with its force multiplied out.
fn two_exponentials() -> Comparison {
    let sum = row_05();
    let found = [
        sum.scale * sum.constant,
        sum.scale * sum.terms[0].coefficient,
        sum.terms[0].rate,
        sum.scale * sum.terms[1].coefficient,
        sum.terms[1].rate,
    ];
    let names = [
        ("constant", "N"),
        ("first coefficient", "N"),
        ("first rate", "1/s"),
        ("second coefficient", "N"),
        ("second rate", "1/s"),
    ];
    let check = |k: usize| {
        let (name, unit) = names[k];
        // Half digits of N (5e-4 of 2 N), of a share (5e-5 of 1) and of the product.
        let tolerance =
            if unit == "N" { 5e-4 * A_2[k] / sum.scale + 5e-5 * sum.scale + 5e-5 } else { 1e-12 };
        let digit = if k == 2 { decimals(3) } else { decimals(4) };
        Check::new(name, unit, (A_2[k], digit), found[k], tolerance)
    };
    Comparison {
        source: "Eq. A.2",
        evidence: Evidence::Derived,
        reason: "half of the last digits of N, of the share and of the product; it is row 05 of Table 3.1 with N multiplied out".into(),
        checks: (0..5).map(check).collect(),
    }
}

fn time_constants() -> Comparison {
    let check = |(name, rate, printed): &(&str, f64, f64)| {
        if *printed > 1e3 {
            return Check::new(*name, "s", (*printed, decimals(1)), 1.0 / rate, 140.0);
        }
        Check::exact(*name, "s", (*printed, decimals(4)), 1.0 / rate)
    };
    Comparison {
        source: "Table A.1",
        evidence: Evidence::Derived,
        reason: "half of the last digit of 1/v; the last entry one digit of its rate, which is printed as 8.5e-5 and is 8.6e-5 behind 11628 s".into(),
        checks: TABLE_A_1.iter().map(check).collect(),
    }
}

/// Table B.1 from (B.1)–(B.3): coefficients over D.
fn normalised() -> Comparison {
    let mut checks = Vec::new();
    for (n, ((d, terms), (printed_d, printed))) in (1..).zip(B.iter().zip(TABLE_B_1)) {
        let name = |what: &str| format!("n = {n}, {what}");
        checks.push(Check::exact(name("D"), "mm", (printed_d, decimals(2)), *d));
        for (k, ((coefficient, rate), (c, v))) in (1..).zip(terms.iter().zip(printed)) {
            let share = (*c, digits(*c, 3));
            checks.push(Check::exact(name(&format!("c{k}")), "", share, coefficient / d));
            checks.push(Check::exact(name(&format!("v{k}")), "1/s", (*v, digits(*v, 3)), *rate));
        }
    }
    Comparison {
        source: "Table B.1",
        evidence: Evidence::Derived,
        reason: "half of the last printed digit".into(),
        checks,
    }
}

/// A creep of 9.5 s as (B.2) has it, with noise that gives its R².
struct Creep {
    time: Vec<f64>,
    displacement: Vec<f64>,
    terms: Option<Terms>,
}

/// (B.2), mm.
fn equation_b_2(time: &[f64]) -> Vec<f64> {
    let (d, parts) = B[1];
    let at = |t: &f64| d + parts.iter().map(|(c, v)| c * (-v * t).exp()).sum::<f64>();
    time.iter().map(at).collect()
}

fn rebuilt_creep() -> Creep {
    let time = times(HOLD_B, RATE);
    let clean = equation_b_2(&time);
    let mean = clean.iter().sum::<f64>() / clean.len() as f64;
    let variance = clean.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / clean.len() as f64;
    let noise = (variance * (1.0 / R_SQUARED_B[1] - 1.0)).sqrt();
    let displacement = noisy(clean, noise, SEED);
    let options = Options { normalisation: Normalisation::Asymptotic, ..Options::default() };
    let terms = terms(&time, &displacement, &options).ok();
    Creep { time, displacement, terms }
}

impl Creep {
    fn fit(&self, n: usize) -> Option<&Fit> {
        self.terms.as_ref()?.rows.get(n - 1).map(|row| &row.fit)
    }
}

/// (B.1): one exponential fitted to the curve of (B.2).
fn one_exponential_of_two() -> Comparison {
    let time = times(HOLD_B, RATE);
    let options =
        Options { terms: 1, normalisation: Normalisation::Asymptotic, ..Options::default() };
    let fit =
        Prepared::new(&time, &options).and_then(|prepared| prepared.fit(&equation_b_2(&time)));
    let found = fit.map_or([f64::NAN; 3], |fit| {
        let term = fit.sum.terms[0];
        [fit.sum.scale, fit.sum.scale * term.coefficient, term.rate]
    });
    let (d, [(coefficient, rate)]) = (B[0].0, [B[0].1[0]]);
    Comparison {
        source: "Eq. B.1",
        evidence: Evidence::NotReproduced,
        reason: "near, not to the last digit: one exponential fitted to the curve of (B.2). That (B.1) is not the least-squares fit of what (B.2) was fitted to is also said by R² for n = 1".into(),
        checks: vec![
            Check::exact("D", "mm", (d, decimals(3)), found[0]),
            Check::exact("coefficient", "mm", (coefficient, decimals(4)), found[1]),
            Check::exact("rate", "1/s", (rate, decimals(4)), found[2]),
        ],
    }
}

/// R² of Table B.1: of two and three exponentials, fed in as noise, and of one, which does not follow.
fn r_squared(creep: &Creep) -> [Comparison; 2] {
    let found = |n: usize| creep.fit(n).map_or(f64::NAN, |fit| fit.r_squared);
    let printed = |n: usize| (R_SQUARED_B[n - 1], decimals(4));
    let again = |n: usize| {
        let allowed = 0.1 * (1.0 - R_SQUARED_B[n - 1]);
        Check::new(format!("R², n = {n}"), "", printed(n), found(n), allowed)
    };
    [
        Comparison {
            source: "Table B.1, R² for n = 2 and 3",
            evidence: Evidence::FoundAgain,
            reason: "10 % of what R² lacks to 1: (B.2) with noise that gives its R² stands for the recording".into(),
            checks: vec![again(2), again(3)],
        },
        Comparison {
            source: "Table B.1, R² for n = 1",
            evidence: Evidence::NotReproduced,
            reason: "one exponential fitted to (B.2) with the noise of its R² loses less: (B.1) and (B.2) lie too close together for so low an R²".into(),
            checks: vec![Check::exact("R², n = 1", "", printed(1), found(1))],
        },
    ]
}

/// Coefficients of (A.3) and (A.4), N: the constant first.
const A_3: [f64; 4] = [0.8852, 0.4264, 0.3421, 0.3399];
const A_4: [f64; 5] = [0.8597, 0.3866, 0.2227, 0.4255, 0.09962];

/// (A.3) and (A.4), of a recording that was not published.
fn more_exponentials() -> [Comparison; 2] {
    let of = |source, coefficients: &[f64]| {
        let check = |(k, value): (usize, &f64)| {
            let name = if k == 0 { "constant".into() } else { format!("coefficient {k}") };
            let digit = if *value < 0.1 { decimals(5) } else { decimals(4) };
            Check::exact(name, "N", (*value, digit), f64::NAN)
        };
        Comparison {
            source,
            evidence: Evidence::NotReproduced,
            reason: "the recording is not published, and row 05 of Table 3.1, which stands for it, has two exponentials: what a third and a fourth take of its noise is chance (their rates are in Table A.1)".into(),
            checks: coefficients.iter().enumerate().map(check).collect(),
        }
    };
    [of("Eq. A.3", &A_3), of("Eq. A.4", &A_4)]
}

fn relaxation_section() -> Section {
    let section = Section::new("Appendix A: exponentials in a relaxation")
        .paragraph("The relaxation of row 05 of Table 3.1 was fitted with one to four exponentials. Two were chosen because the curves of two and more cannot be distinguished by eye, R² hardly grows, and the shortest time constant settles. R² cannot decide: it never falls with more terms. An information criterion and the error on samples that the fit did not see can.");
    let section = section.callout(
        Callout::Warning,
        "A slip",
        "The last entry of Table A.1 is 11628 s, but the rate printed in (A.4), 8.5e-5 1/s, gives 11765 s: the table comes from coefficients that were not rounded. Either is two thousand times as long as the hold: it says that the term is a constant.",
    );
    let Some(found) = row_05_terms() else { return section };
    let decided = found.decided();
    let as_printed =
        if decided == 2 { ", what appendix A chose by eye" } else { "; appendix A chose 2 by eye" };
    let section = match overlaid(&found) {
        Some(plot) => section.figure(
            plot,
            "Fig. A.1 in kind: within the hold the curves of two and more lie on each other, one exponential does not.",
        ),
        None => section,
    };
    section.table(number_table("Row 05, rebuilt: one to four exponentials", &found, "N")).callout(
        Callout::Finding,
        "Decided",
        format!(
            "{decided} exponentials{as_printed}. Terms beyond are not identifiable in a hold of {HOLD_A} s."
        ),
    )
}

/// The rebuilt hold of row 05 with the fits.
fn overlaid(found: &Terms) -> Option<Plot> {
    let trace: Trace = grasps(0).into_iter().nth(4)?;
    let range = holds(&trace, FORCE).ok()?.into_iter().next()?;
    let from = trace.time[range.start];
    let since: Vec<f64> = trace.time[range.clone()].iter().map(|t| t - from).collect();
    let last = since.last().copied()?;
    let mut plot = Plot::new("", Axis::new("time in the hold", "s"), Axis::new("force", "N"))
        .summary("Rebuilt force of a hold with fits of one to four exponentials")
        .series(
            Series::points("rebuilt recording", since, &trace.force()?[range])
                .colour(Colour::MEASURED),
        );
    for (k, row) in found.rows.iter().enumerate() {
        let (x, y): (Vec<f64>, Vec<f64>) =
            (0..=240).map(|k| last * f64::from(k) / 240.0).map(|t| (t, row.fit.sum.at(t))).unzip();
        plot = plot.series(Series::line(format!("n = {}", k + 1), x, y).colour(Colour::Hue(k)));
    }
    Some(plot)
}

/// One to four exponentials in the rebuilt recording of row 05.
fn row_05_terms() -> Option<Terms> {
    let trace: Trace = grasps(0).into_iter().nth(4)?;
    let range = holds(&trace, FORCE).ok()?.into_iter().next()?;
    terms(&trace.time[range.clone()], &trace.force()?[range], &Options::default()).ok()
}

fn creep_section(creep: &Creep) -> Section {
    let mut section = Section::new("Appendix B: exponentials in a creep")
        .paragraph("The creep of Fig. 6.4, 9.5 s at 2 N, was fitted with one to three exponentials and c0 = 1, and two were chosen. Here (B.2) with noise that gives its R² stands for the recording, and one to four exponentials are fitted to it again.");
    let Some(found) = &creep.terms else { return section };
    section = section.table(number_table("Creep rebuilt from (B.2)", found, "mm"));
    if let Some(fit) = creep.fit(1) {
        let text = format!(
            "Table B.1 gives one exponential R² {}. A fit of one to the creep of (B.2) has {:.4}, with the D, coefficient and rate of (B.1): the printed curves lie too close together for so large a loss, so the recording had something that (B.2) has not, or the fit behind that R² was not the best one.",
            R_SQUARED_B[0], fit.r_squared
        );
        section = section.callout(Callout::Warning, "R² of one exponential", text);
    }
    for n in [2, 3] {
        let Some(fit) = creep.fit(n) else { continue };
        let said = doubts(fit, HOLD_B, RelaxationType::TypeI);
        let text = if said.is_empty() { "nothing is in doubt".into() } else { said.join("; ") };
        section = section.callout(Callout::Warning, format!("n = {n}"), format!("{text}."));
    }
    let words = format!(
        "The data show {}. A time constant of 128 s cannot be distinguished from a straight line in 9.5 s, so D = 8.10 mm is an extrapolation; one exponential gives 6.48 mm. With three, Table B.1 lists v3 below v2 and both near 0.01 1/s: two names for one slow drift, of which the hold identifies neither.",
        counted(found.decided(), "exponential")
    );
    section = section.callout(Callout::Finding, "What 9.5 s determine", words);
    let (long, axes) =
        (60.0, (Axis::new("time in the hold", "s"), Axis::new("displacement", "mm")));
    let mut plot =
        Plot::new("The same 9.5 s, and what each fit makes of the rest (Fig. B.1)", axes.0, axes.1)
            .summary("Rebuilt creep and fits with one to three exponentials continued to 60 s")
            .series(
                Series::points("rebuilt recording", &creep.time[..], &creep.displacement[..])
                    .colour(Colour::MEASURED),
            )
            .span(0.0, HOLD_B, "hold");
    for n in 1..=3 {
        let Some(fit) = creep.fit(n) else { continue };
        let (x, y): (Vec<f64>, Vec<f64>) =
            (0..=240).map(|k| long * f64::from(k) / 240.0).map(|t| (t, fit.sum.at(t))).unzip();
        plot = plot.series(Series::line(format!("n = {n}"), x, y).colour(Colour::Hue(n - 1)));
    }
    section.figure(plot, "Within the hold the curves lie on each other; beyond it they part.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_exponentials_are_told_of_the_relaxation_and_the_slow_rates_of_the_creep_are_not() {
        assert_eq!(row_05_terms().unwrap().decided(), 2);
        let creep = rebuilt_creep();
        let said = doubts(creep.fit(3).unwrap(), HOLD_B, RelaxationType::TypeI);
        assert!(!said.is_empty());
        let said = doubts(creep.fit(2).unwrap(), HOLD_B, RelaxationType::TypeI).join("; ");
        assert!(said.contains("v2 is not identifiable"), "{said}");
    }
}
