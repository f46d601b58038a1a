//! Chapter 2: the models that compete, and chapter 3's argument between them.

use super::Chapter;
use crate::fit::ranking::{ParameterSpread, spreads};
use crate::model::{BaseLaw, Family, Hold, Motion, Move, Profile, Separation, Step};
use crate::report::number::significant;
use crate::report::{Axis, Callout, Colour, Column, Panels, Plot, Section, Series, Table};
use crate::trace::{Column as TraceColumn, DISPLACEMENT, FORCE, Trace};

/// A soft specimen that obeys eq. 2.1: mean shares and rates of Table 3.4 at 12 mm, N(x) ∝ x².
const SPECIMEN: [f64; 6] = [0.03, 1.0, 0.2527, 0.2628, 3.7184, 0.5005];
/// Compressions, mm, and speeds, mm/s, of the set-ups.
const SETUPS: ([f64; 3], [f64; 3]) = ([4.0, 8.0, 12.0], [5.0, 20.0, 80.0]);
/// The laws whose parameters are compared.
const FAMILIES: [Family; 4] =
    [Family::KelvinVoigt, Family::Maxwell, Family::GeneralizedMaxwell, Family::Fung];

/// The chapter.
#[must_use]
pub fn chapter() -> Chapter {
    let traces: Vec<Trace> = setups().collect();
    let found: Vec<(BaseLaw, Vec<ParameterSpread>)> = FAMILIES
        .iter()
        .map(|&family| {
            let law = BaseLaw::new(family, 2, Separation::Clamp);
            (law, spreads(law, &traces, FORCE).unwrap_or_default())
        })
        .collect();
    let section = Section::new("Springs, dampers and what came after")
        .paragraph(
            "Kelvin–Voigt (eq. 2.3) and Maxwell (eq. 2.4) are one spring and one damper, side by side or in a \
             row; the generalised Maxwell model has more of them; Fung's law (eq. 2.1) separates what the \
             compression does from what time does. All are base laws of `palpate fit`, with the two latency \
             models (chapters 4 and 7) and creep (chapter 6).",
        )
        .figure(press_figure(), "A press to 4 mm, a hold and a release by each law, with the parameters of Table 3.4 or like them.")
        .paragraph(
            "The text's reason to prefer Fung's law: the numbers of springs and dampers move with the set-up, \
             by two orders of magnitude or more, Fung's by a few per cent. Here one specimen that obeys eq. \
             2.1 is pressed to 4, 8 and 12 mm at 5, 20 and 80 mm/s, and every law is fitted to each press.",
        )
        .table(spread_table(&found))
        .callout(
            Callout::Finding,
            "The argument holds, and what it shows",
            format!(
                "Largest over smallest value among the nine set-ups, the worst parameter of each law: {}. \
                 A law drifts because something is missing from it: here that the stiffness grows with \
                 compression. `palpate fit --all` makes the same comparison on your own traces, where no law \
                 is exact.",
                found
                    .iter()
                    .map(|(law, spreads)| format!("{} {}", law.name(), worst_in_words(spreads)))
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
        );
    Chapter {
        title: "Chapter 2: models that compete",
        comparisons: Vec::new(),
        sections: vec![section],
    }
}

/// The nine presses.
fn setups() -> impl Iterator<Item = Trace> {
    let (compressions, speeds) = SETUPS;
    compressions.into_iter().flat_map(move |compression| {
        speeds.into_iter().map(move |speed| {
            let motion = press(compression, speed);
            let law = BaseLaw::fung(2, Separation::Clamp);
            let force = law.predict(&SPECIMEN, std::slice::from_ref(&motion)).remove(0);
            let column = |name: &str, values| TraceColumn { name: name.into(), values };
            let columns =
                vec![column(DISPLACEMENT, motion.displacement.into_owned()), column(FORCE, force)];
            Trace { time: motion.time.into_owned(), columns, ..Trace::default() }
        })
    })
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
fn example(family: Family) -> Vec<f64> {
    match family {
        Family::KelvinVoigt => vec![0.25, 0.02],
        Family::Maxwell => vec![0.25, 0.25],
        Family::GeneralizedMaxwell => vec![0.12, 0.065, 0.065, 0.016, 0.13],
        Family::Fung => vec![0.125, 1.0, 0.2527, 0.2628, 3.7184, 0.5005],
        Family::Latency => vec![0.125, 1.0, 0.4845, 1.2],
        Family::LatencyPower => vec![0.125, 1.0, 0.3, 0.3, 3.0],
        Family::Creep => vec![0.06, 1.0, -0.25, -0.25, 3.0, 0.3],
    }
}

fn press_figure() -> Panels {
    let motion = press(4.0, 20.0);
    let draw = |families: &[Family]| {
        let mut plot = Plot::new("", Axis::new("time", "s"), Axis::new("force", "N")).height(190.0);
        for (index, &family) in families.iter().enumerate() {
            let law = BaseLaw::new(family, 2, Separation::Clamp);
            let force = law.predict(&example(family), std::slice::from_ref(&motion)).remove(0);
            let time = motion.time.to_vec();
            plot = plot.series(Series::line(family.name(), time, force).colour(Colour::Hue(index)));
        }
        plot
    };
    let (linear, bent): (Vec<Family>, Vec<Family>) =
        Family::ALL.into_iter().partition(|family| family.is_linear());
    Panels::new("")
        .summary("Force over time of every base law in the same press")
        .plot(draw(&linear))
        .plot(draw(&bent))
}

fn worst(spreads: &[ParameterSpread]) -> Option<f64> {
    spreads.iter().map(ParameterSpread::ratio).max_by(f64::total_cmp)
}

fn worst_in_words(spreads: &[ParameterSpread]) -> String {
    match worst(spreads) {
        Some(ratio) if ratio.is_finite() => significant(ratio, 3),
        Some(_) => "without limit (a branch vanishes)".into(),
        None => "not fitted".into(),
    }
}

fn spread_table(found: &[(BaseLaw, Vec<ParameterSpread>)]) -> Table {
    let columns = vec![
        Column::text("law"),
        Column::text("parameter"),
        Column::number("smallest", ""),
        Column::number("largest", ""),
        Column::number("largest / smallest", ""),
        Column::text("unit"),
    ];
    let mut table = Table::new("The same specimen in nine set-ups", columns);
    for (law, spreads) in found {
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
    fn springs_and_dampers_drift_between_set_ups_and_fungs_parameters_do_not() {
        let traces: Vec<Trace> = setups().collect();
        let ratio = |family| {
            let law = BaseLaw::new(family, 2, Separation::Clamp);
            worst(&spreads(law, &traces, FORCE).unwrap()).unwrap()
        };
        assert!(ratio(Family::Fung) < 1.05, "{}", ratio(Family::Fung));
        for family in [Family::KelvinVoigt, Family::Maxwell, Family::GeneralizedMaxwell] {
            assert!(ratio(family) > 2.0, "{} {}", family.name(), ratio(family));
        }
    }
}
