//! A grasp with several contacts, in words, tables and pictures.

use nalgebra::Vector3;

use super::margin_words;
use palpate_contact::grasp::hand::{Hand, Instant};
use palpate_contact::grasp::{Balance, BalanceError, Closure, Least};
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};

/// What was found of a hand.
#[derive(Clone, Debug)]
pub struct HandPlan {
    /// Whether any load can be resisted.
    pub closure: Closure,
    /// How many times the load must be held.
    pub margin: f64,
    /// What was made least.
    pub least: Least,
    /// The least grip with that margin.
    pub grip: Result<Balance, BalanceError>,
    /// How many times the load could be as the fingers press now, and how hard they do, N.
    pub now: Option<(Result<Balance, BalanceError>, Vec<f64>)>,
    /// What becomes of it.
    pub forecast: Option<Forecast>,
}

/// A grip over time.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Since when it has been held, s, and how long it is looked ahead, s.
    pub from: f64,
    /// How long it is looked ahead, s.
    pub lasts: f64,
    /// Grip and margin.
    pub course: Vec<Instant>,
    /// When it slips, s since the grasp was made; none where it does not.
    pub slips: Option<f64>,
    /// When the margin falls below the one that was asked for, s.
    pub below_margin: Option<f64>,
    /// By how many times to strengthen the grip now; none where nothing helps.
    pub tighten: Option<f64>,
}

impl Forecast {
    /// Until when it is looked ahead, s since the grasp was made.
    #[must_use]
    pub fn until(&self) -> f64 {
        self.from + self.lasts
    }
}

/// Closure, least grip, margin and forecast.
#[must_use]
pub fn plan_sections(hand: &Hand, plan: &HandPlan) -> Vec<Section> {
    let mut section = Section::new("The grasp").callout(
        if plan.closure.is_force_closed() { Callout::Finding } else { Callout::Warning },
        "Closure",
        closure_words(&plan.closure),
    );
    match &plan.grip {
        Ok(grip) => {
            section = section.callout(Callout::Finding, "Least grip", grip_words(plan, grip));
            section = section.table(share_table(hand, "Least grip", grip));
        }
        Err(error) => {
            let words = format!("{error}: the object cannot be held like this, however hard.");
            section = section.callout(Callout::Warning, "Least grip", words);
        }
    }
    if let Some((now, normals)) = &plan.now {
        let kind = match now {
            Ok(found) if found.value > 1.0 => Callout::Finding,
            Err(BalanceError::Unlimited) => Callout::Finding,
            _ => Callout::Warning,
        };
        section = section.callout(kind, "As it grips now", now_words(now));
        if let Ok(found) = now {
            let title = "As it grips now, at the largest load that it holds";
            section = section.table(share_table(hand, title, found));
        }
        section = pictured(section, hand, normals);
    } else if let Ok(grip) = &plan.grip {
        let normals: Vec<f64> = grip.shares.iter().map(|share| share.normal).collect();
        section = pictured(section, hand, &normals);
    }
    let mut sections = vec![section];
    if let Some(forecast) = &plan.forecast {
        sections.push(forecast_section(hand, plan, forecast));
    }
    sections
}

fn closure_words(closure: &Closure) -> String {
    match (closure.rank, closure.is_force_closed()) {
        (6, true) => format!(
            "Force-closed: gripped hard enough it resists any force and moment. Squeezed by itself, every contact keeps at least {} N of friction for each newton of mean normal force.",
            significant(closure.reserve, 3)
        ),
        (6, false) => "Not force-closed: the contacts cannot squeeze the object without a load, so it resists only some loads.".into(),
        (rank, _) => format!(
            "Not force-closed: the contacts make {rank} of the 6 components of force and moment; against the others nothing helps."
        ),
    }
}

fn grip_words(plan: &HandPlan, grip: &Balance) -> String {
    let what = match plan.least {
        Least::Sum => "The normal forces must be together at least",
        Least::Largest => "The largest normal force must be at least",
    };
    let margin = if plan.margin == 1.0 {
        "to hold the load".into()
    } else {
        format!("to hold the load with a margin of {}", significant(plan.margin, 4))
    };
    format!("{what} {} N {margin}.", significant(grip.value, 5))
}

fn now_words(now: &Result<Balance, BalanceError>) -> String {
    match now {
        Ok(found) if found.value > 1.0 => format!(
            "It holds: the load could be {} times as large before a finger that presses no harder slips.",
            margin_words(found.value)
        ),
        Ok(found) => format!(
            "It slips: no more than {} of the load can be held with fingers that press no harder.",
            percent(found.value, 3)
        ),
        Err(BalanceError::Unlimited) => {
            "It holds: this load is carried however large it is.".into()
        }
        Err(error) => format!("It slips: {error}."),
    }
}

fn share_table(hand: &Hand, title: &str, balance: &Balance) -> Table {
    let columns = vec![
        Column::text("finger"),
        Column::number("normal force", "N"),
        Column::number("tangential force", "N"),
        Column::number("moment", "N mm"),
        Column::text("of its friction in use"),
    ];
    let mut table = Table::new(title, columns);
    for (finger, share) in hand.fingers.iter().zip(&balance.shares) {
        let used = share.used;
        table = table.row([
            finger.name.clone(),
            significant(share.normal, 4),
            significant(share.load.tangential(), 4),
            significant(share.load.moment, 3),
            if used.is_finite() { percent(used, 4) } else { "does not press".into() },
        ]);
    }
    let off = (balance.value - balance.bound).abs() / balance.value.abs().max(f64::MIN_POSITIVE);
    // What rounding leaves is no figure to print.
    let off = if off <= CERTAIN { CERTAIN } else { off };
    table.note(format!(
        "Certified to {} of the value by a bound from the other side.",
        significant(off, 1)
    ))
}

/// Part of the value that a certificate is told to, at best.
const CERTAIN: f64 = 1e-7;

fn forecast_section(hand: &Hand, plan: &HandPlan, forecast: &Forecast) -> Section {
    let mut columns = vec![Column::number("time", "s")];
    columns.extend(hand.fingers.iter().map(|finger| Column::number(finger.name.clone(), "N")));
    columns.push(Column::number("margin", ""));
    let mut table = Table::new("Normal forces and margin while it is held", columns);
    for instant in forecast.course.iter().step_by(4) {
        let mut row = vec![significant(instant.time, 4)];
        row.extend(instant.normals.iter().map(|normal| significant(*normal, 4)));
        row.push(margin_words(instant.margin));
        table = table.row(row);
    }
    let (time, margin): (Vec<f64>, Vec<f64>) =
        forecast.course.iter().map(|instant| (instant.time, instant.margin)).unzip();
    let mut plot = Plot::new(
        "Margin while it is held",
        Axis::new("time since the grasp was made", "s"),
        Axis::new("margin: the load could be so many times as large", ""),
    )
    .summary("Margin over time, with slip at one")
    .series(Series::line("margin", time, margin).colour(Colour::MODEL))
    .level(1.0, "slip");
    if plan.margin != 1.0 {
        plot = plot.level(plan.margin, "asked for");
    }
    if let Some(slips) = forecast.slips {
        plot = plot.mark(slips, "slips");
    }
    let kind = if forecast.slips.is_some() { Callout::Warning } else { Callout::Finding };
    Section::new("While it is held")
        .callout(kind, "Forecast", forecast_words(plan, forecast))
        .table(table)
        .figure(plot, "")
}

fn forecast_words(plan: &HandPlan, forecast: &Forecast) -> String {
    let Forecast { from, slips, below_margin, tighten, .. } = forecast;
    let until = significant(forecast.until(), 4);
    let slip = match slips {
        Some(time) if *time <= *from => "It slips now.".to_owned(),
        Some(time) => format!("Held on like this it slips after {} s.", significant(*time, 4)),
        None => format!("Held on like this it does not slip before {until} s."),
    };
    let margin = significant(plan.margin, 4);
    let below = match below_margin {
        _ if plan.margin == 1.0 => String::new(),
        Some(time) if *time <= *from => format!(" Its margin is below {margin} now."),
        Some(time) => {
            format!(" Its margin falls below {margin} after {} s.", significant(*time, 4))
        }
        None => format!(" Its margin stays above {margin}."),
    };
    let more = match tighten {
        Some(1.0) => format!(" It need not be tightened for a margin of {margin} until {until} s."),
        Some(factor) => format!(
            " Tightened now by {}, to {} times its force, it keeps a margin of {margin} until {until} s.",
            percent(factor - 1.0, 3),
            significant(*factor, 4)
        ),
        None => format!(
            " No grip up to a thousand times as strong keeps a margin of {margin} until {until} s."
        ),
    };
    slip + &below + &more
}

/// The hand from three sides, each with axes of its own.
fn pictured(section: Section, hand: &Hand, normals: &[f64]) -> Section {
    let reach = hand.fingers.iter().map(|finger| finger.pose.position.norm()).fold(1.0, f64::max);
    let hardest = normals.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let load = Vector3::from(hand.load.force);
    let views = [("x", "y", [0, 1]), ("x", "z", [0, 2]), ("y", "z", [1, 2])];
    views.into_iter().fold(section, |section, (across, up, [a, b])| {
        let axis = |name: &str| Axis::new(name.to_owned(), "mm");
        let mut plot = Plot::new("", axis(across), axis(up))
            .summary(format!("The fingers on the object, {up} over {across}"))
            .height(280.0);
        for (index, (finger, normal)) in hand.fingers.iter().zip(normals).enumerate() {
            let at = finger.pose.position;
            let from = at - finger.pose.axes[2] * (0.6 * reach * normal / hardest);
            let (x, y) = (vec![from[a], at[a]], vec![from[b], at[b]]);
            let line =
                Series::line(finger.name.clone(), x, y).colour(Colour::Hue(index)).width(3.0);
            let touch = Series::points("", vec![at[a]], vec![at[b]]).colour(Colour::Hue(index));
            plot = plot.series(line).series(touch);
        }
        if let Some(direction) = load.try_normalize(0.0) {
            let to = direction * (0.6 * reach);
            let line = Series::line("load", vec![0.0, to[a]], vec![0.0, to[b]]);
            plot = plot.series(line.colour(Colour::Muted).width(3.0));
        }
        let words = if a + b == 1 {
            "Each finger from where it comes to where it touches, as long as it presses; the load from the middle."
        } else {
            ""
        };
        section.figure(plot, words)
    })
}
