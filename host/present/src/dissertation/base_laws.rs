//! Chapter 2: the models that compete, and chapter 3's argument between them.

use rayon::prelude::*;

use super::Chapter;
use super::simulated::noisy;
use palpate_fit::data::Data;
use palpate_fit::ranking::ParameterSpread;
use palpate_fit::whole_motion::{MotionFit, fit};
use palpate_model::{
    BaseLaw, Branch, Family, Growth, Hereditary, HereditaryState, Hold, LawOption, Motion, Move,
    Parameter, Profile, Separation, Step,
};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use palpate_trace::{Column as TraceColumn, DISPLACEMENT, FORCE, Trace};

/// A soft specimen that is none of the rivals: N(x) = a x + b x³, N/mm and N/mm³, no power of x.
const STIFFNESS: (f64, f64) = (0.08, 0.0012);
/// Its shares relax at rates spread over five decades, as a power of time does, and not by two exponentials;
/// share of each, and slowest and fastest rate, 1/s.
const SHARES: f64 = 0.055;
const MODES: (f64, f64, usize) = (0.003, 300.0, 11);
/// Rates grow with this power of the state, so that displacement and time are not separate.
const GROWTH: f64 = 0.25;
/// Standard deviation of the noise of the force, N, and its seed.
const NOISE: f64 = 0.01;
const SEED: u64 = 21;
/// Compressions, mm, and speeds, mm/s, of the set-ups.
const SETUPS: ([f64; 3], [f64; 3]) = ([4.0, 8.0, 12.0], [5.0, 20.0, 80.0]);
/// The laws whose parameters are compared.
const COMPARED: [&Family; 4] =
    [Family::KELVIN_VOIGT, Family::MAXWELL, Family::GENERALIZED_MAXWELL, Family::FUNG];

/// The chapter.
#[must_use]
pub fn chapter() -> Chapter {
    let found = fitted(&setups());
    let section = Section::new("Springs, dampers and what came after")
        .paragraph(
            "Kelvin–Voigt (eq. 2.3) and Maxwell (eq. 2.4) are one spring and one damper, side by side or in a \
             row; the generalised Maxwell model has more of them; Fung's law (eq. 2.1) separates what the \
             compression does from what time does. All are base laws of `palpate fit`, with the two latency \
             models (chapters 4 and 7) and creep (chapter 6).",
        )
        .figure(press_figure(), "A press to 4 mm, a hold and a release by each law, with the parameters of Table 3.4 or like them.")
        .paragraph(format!(
            "The text's reason to prefer Fung's law: the numbers of springs and dampers move with the set-up, \
             by two orders of magnitude or more, Fung's by a few per cent. Here one specimen is pressed to 4, 8 \
             and 12 mm at 5, 20 and 80 mm/s, with noise of {NOISE} N, and every law is fitted to each press. The \
             specimen is none of the rivals: its elastic response is no power of the compression, it relaxes \
             at {} rates over five decades, and faster where it is pressed more, so that displacement and time \
             are not separate.",
            MODES.2
        ))
        .table(spread_table(&found))
        .table(misfit_table(&found))
        .callout(Callout::Finding, "What follows", what_follows(&found));
    Chapter {
        title: "Chapter 2: models that compete",
        comparisons: Vec::new(),
        sections: vec![section],
    }
}

/// A law fitted to each press by itself.
struct Fitted {
    law: BaseLaw,
    /// Its parameters over the set-ups.
    spreads: Vec<ParameterSpread>,
    /// Root mean square residual of each press, N.
    rms: Vec<f64>,
}

impl Fitted {
    /// Largest residual of a press, in the standard deviation of the noise.
    fn worst_misfit(&self) -> f64 {
        self.rms.iter().copied().fold(0.0, f64::max) / NOISE
    }
}

fn fitted(traces: &[Trace]) -> Vec<Fitted> {
    let one = |family: &&'static Family| {
        let law = BaseLaw::new(family, 2, Separation::Clamp);
        let fits: Vec<MotionFit> = traces
            .iter()
            .filter_map(|trace| fit(law, &Data::of(std::slice::from_ref(trace), FORCE).ok()?).ok())
            .collect();
        let spread = |(k, parameter): (usize, Parameter)| ParameterSpread {
            name: parameter.name.into(),
            unit: parameter.unit.into(),
            values: fits.iter().map(|fit| fit.values[k]).collect(),
        };
        let spreads = law.parameters().into_iter().enumerate().map(spread).collect();
        Fitted { law, spreads, rms: fits.iter().map(MotionFit::rms).collect() }
    };
    COMPARED.par_iter().map(one).collect()
}

fn misfit_table(found: &[Fitted]) -> Table {
    let columns = vec![
        Column::text("law"),
        Column::number("least residual", "of the noise"),
        Column::number("largest residual", "of the noise"),
    ];
    let mut table = Table::new("What each law leaves in a press fitted by itself", columns);
    for fitted in found {
        let least = fitted.rms.iter().copied().fold(f64::INFINITY, f64::min) / NOISE;
        table = table.row([
            fitted.law.name().to_owned(),
            significant(least, 3),
            significant(fitted.worst_misfit(), 3),
        ]);
    }
    table
}

/// The nine presses.
fn setups() -> Vec<Trace> {
    let (compressions, speeds) = SETUPS;
    let pairs = compressions.into_iter().flat_map(|x| speeds.into_iter().map(move |v| (x, v)));
    pairs
        .zip(0..)
        .map(|((compression, speed), number)| {
            let motion = press(compression, speed);
            let force = noisy(specimen(&motion), NOISE, SEED + number);
            let column = |name: &str, values| TraceColumn { name: name.into(), values };
            let columns =
                vec![column(DISPLACEMENT, motion.displacement.into_owned()), column(FORCE, force)];
            Trace { time: motion.time.into_owned(), columns, ..Trace::default() }
        })
        .collect()
}

/// The force of the specimen, N.
fn specimen(motion: &Motion) -> Vec<f64> {
    let (slowest, fastest, modes) = MODES;
    let rate = |k: usize| slowest * (fastest / slowest).powf(k as f64 / (modes - 1) as f64);
    let branches = (0..modes).map(|k| Branch { share: SHARES, rate: rate(k) }).collect();
    let mut hereditary = Hereditary::linear(branches, Separation::Clamp);
    hereditary.growth = Growth::Power(GROWTH, 1.0);
    let elastic = |x: &f64| STIFFNESS.0 * x + STIFFNESS.1 * x.powi(3);
    let elastic: Vec<f64> = motion.displacement.iter().map(elastic).collect();
    let mut force = Vec::new();
    hereditary.run(&motion.time, &elastic, None, &mut HereditaryState::default(), &mut force);
    force
}

fn press(compression: f64, speed: f64) -> Motion<'static> {
    Profile {
        version: 1,
        rate_hz: 200.0,
        start_mm: 0.0,
        speed_mm_per_s: speed,
        acceleration_mm_per_s2: None,
        repeat: 1,
        steps: vec![
            Step::Hold(Hold { hold_s: 0.2 }),
            Step::Move(Move { to_mm: compression, speed_mm_per_s: None }),
            Step::Hold(Hold { hold_s: 4.5 }),
            Step::Move(Move { to_mm: 0.0, speed_mm_per_s: None }),
            Step::Hold(Hold { hold_s: 0.5 }),
        ],
    }
    .motion()
}

/// Parameters of each law for the figure: a stiffness of 0.25 N/mm, times about a second.
const EXAMPLES: [(&Family, &[f64]); 7] = [
    (Family::KELVIN_VOIGT, &[0.25, 0.02]),
    (Family::MAXWELL, &[0.25, 0.25]),
    (Family::GENERALIZED_MAXWELL, &[0.12, 0.065, 0.065, 0.016, 0.13]),
    (Family::FUNG, &[0.125, 1.0, 0.2527, 0.2628, 3.7184, 0.5005]),
    (Family::LATENCY, &[0.125, 1.0, 0.4845, 1.2]),
    (Family::LATENCY_POWER, &[0.125, 1.0, 0.3, 0.3, 3.0]),
    (Family::CREEP, &[0.06, 1.0, -0.25, -0.25, 3.0, 0.3]),
];

fn press_figure() -> Panels {
    let motion = press(4.0, 20.0);
    let draw = |bends: bool| {
        let mut plot = Plot::new("", Axis::new("time", "s"), Axis::new("force", "N")).height(190.0);
        let drawn = EXAMPLES.iter().filter(|(family, _)| family.takes(LawOption::Elastic) == bends);
        for (index, (family, values)) in drawn.enumerate() {
            let law = BaseLaw::new(family, 2, Separation::Clamp);
            let force = law.predict(values, std::slice::from_ref(&motion)).remove(0);
            let time = motion.time.to_vec();
            plot = plot.series(Series::line(family.name, time, force).colour(Colour::Hue(index)));
        }
        plot
    };
    Panels::new("")
        .summary("Force over time of every base law in the same press")
        .plot(draw(false))
        .plot(draw(true))
}

fn worst(spreads: &[ParameterSpread]) -> Option<f64> {
    spreads.iter().map(ParameterSpread::ratio).max_by(f64::total_cmp)
}

/// Ratio from which on a parameter counts as two orders of magnitude apart.
const TWO_ORDERS: f64 = 100.0;
/// A law leaves more than the noise if its residuals exceed the noise by this factor somewhere.
const MISFIT: f64 = 1.1;

/// What the nine set-ups say of the text's argument.
fn what_follows(found: &[Fitted]) -> String {
    let ratio = |fitted: &Fitted| worst(&fitted.spreads).unwrap_or(f64::NAN);
    let list = |fitted: Vec<&Fitted>| {
        fitted.iter().map(|fitted| fitted.law.name()).collect::<Vec<_>>().join(", ")
    };
    let drifts: Vec<String> = found
        .iter()
        .map(|fitted| format!("{} {}", fitted.law.name(), worst_in_words(&fitted.spreads)))
        .collect();
    let far: Vec<&Fitted> = found.iter().filter(|fitted| ratio(fitted) >= TWO_ORDERS).collect();
    let far = if far.is_empty() {
        "None reaches the two orders of magnitude of the text here.".to_owned()
    } else {
        format!("The two orders of magnitude of the text are reached by {}.", list(far))
    };
    let steadiest = found.iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let missing: Vec<&Fitted> =
        found.iter().filter(|fitted| fitted.worst_misfit() > MISFIT).collect();
    let missing = if missing.is_empty() {
        "Every law leaves no more than the noise, so that its drift is that of parameters which a press does not identify.".to_owned()
    } else {
        format!(
            "More than the noise is left by {}: a parameter that drifts there says that something is missing from the law, not that the specimen changed.",
            list(missing)
        )
    };
    format!(
        "Largest over smallest value among the nine set-ups, the worst parameter of each law: {}. {far} The \
         steadiest is {}. {missing} `palpate fit --all` makes the same comparison on your own traces.",
        drifts.join(", "),
        steadiest.map_or("none", |fitted| fitted.law.name()),
    )
}

fn worst_in_words(spreads: &[ParameterSpread]) -> String {
    match worst(spreads) {
        Some(ratio) if ratio.is_finite() => significant(ratio, 3),
        Some(_) => "without limit (a branch vanishes)".into(),
        None => "not fitted".into(),
    }
}

fn spread_table(found: &[Fitted]) -> Table {
    let columns = vec![
        Column::text("law"),
        Column::text("parameter"),
        Column::number("smallest", ""),
        Column::number("largest", ""),
        Column::number("largest / smallest", ""),
        Column::text("unit"),
    ];
    let mut table = Table::new("The same specimen in nine set-ups", columns);
    for Fitted { law, spreads, .. } in found {
        for spread in spreads {
            let (least, most) = spread.range();
            let ratio = spread.ratio();
            table = table.row([
                law.name().to_owned(),
                spread.name.clone(),
                significant(least, 3),
                significant(most, 3),
                if ratio.is_finite() { significant(ratio, 3) } else { "–".into() },
                spread.unit.clone(),
            ]);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_specimen_is_none_of_the_rivals_and_the_words_follow_the_numbers() {
        let found = fitted(&setups());
        assert_eq!(found.len(), COMPARED.len());
        for fitted in &found {
            assert_eq!(fitted.rms.len(), 9, "{}", fitted.law.name());
        }
        // No law is exact for it: each leaves more than the noise in some press.
        assert!(found.iter().all(|fitted| fitted.worst_misfit() > MISFIT));
        let words = what_follows(&found);
        let far = found.iter().any(|f| worst(&f.spreads).unwrap() >= TWO_ORDERS);
        assert_eq!(words.contains("None reaches"), !far, "{words}");
    }
}
