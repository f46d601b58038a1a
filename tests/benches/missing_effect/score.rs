//! What the answers are worth.

use std::collections::BTreeMap;

use palpate::trace::Trace;
use palpate_tests::hidden::{DataSet, LawKind, Truth};

use super::answer::{Answer, Step, answer};
use super::cpu::timed;
use super::groups::{Group, Kind};
use super::share::Share;

/// One data set with its answer.
pub struct Outcome {
    /// Group and number: the name of its folder.
    pub name: String,
    /// What was hidden.
    pub truth: Truth,
    group: &'static str,
    kind: Kind,
    answer: Result<Answer, String>,
    /// Of the processor.
    seconds: f64,
}

impl Outcome {
    /// The header of [`Outcome::line`].
    pub const HEADER: &str = "set,truth,law,form,R,noise_rms,verdict,names,credible_sets,ranking,heldout_over_noise,heldout_of_steps,fresh_of_steps,noise_found_over_true,cpu_seconds";

    /// Diagnoses a set.
    pub fn of(group: &Group, index: usize, set: &DataSet, fresh: &[Trace]) -> Self {
        let (answer, seconds) = timed(|| answer(set, fresh));
        Self {
            name: format!("{}-{index:04}", group.name),
            truth: set.truth.clone(),
            group: group.name,
            kind: group.kind,
            answer,
            seconds,
        }
    }

    /// All of it as one line of CSV; names within a field are parted by spaces, sets by `|`.
    pub fn line(&self) -> String {
        let hidden = &self.truth.hidden;
        let each = |part: fn(&palpate_tests::hidden::Hidden) -> String| {
            hidden.iter().map(part).collect::<Vec<_>>().join(" | ").replace('"', "'")
        };
        let (truth, law) = (each(|h| h.effect.clone()), each(|h| format!("{:?}", h.kind)));
        let form = each(|h| h.form.to_owned());
        let start = format!(
            "{},{truth},{law},\"{form}\",{:.4},{:.4e}",
            self.name, self.truth.r, self.truth.noise_rms
        );
        let end = format!("{:.3}", self.seconds);
        let answer = match &self.answer {
            Ok(answer) => answer,
            Err(error) => {
                return format!("{start},error,\"{}\",,,,,,,{end}", error.replace('"', "'"));
            }
        };
        let sets: Vec<_> = answer.steps.iter().map(|step| step.credible_set.join(" ")).collect();
        let first = answer.steps.first();
        let ranking = first.map(|step| step.ranking[..step.ranking.len().min(5)].join(" "));
        let rms = |of: fn(&Step) -> [f64; 2]| {
            let each = answer.steps.iter().map(of).map(|[a, b]| format!("{a:.4e} {b:.4e}"));
            each.collect::<Vec<_>>().join(" | ")
        };
        format!(
            "{start},{},{},{},{},{},{},{},{:.3},{end}",
            answer.verdict,
            self.names().join(" "),
            sets.join(" | "),
            ranking.unwrap_or_default(),
            self.held_out().map_or_else(String::new, |ratio| format!("{ratio:.3}")),
            rms(|step| step.heldout_rms),
            rms(|step| step.fresh_rms),
            answer.noise_rms / self.truth.noise_rms,
        )
    }

    fn verdict(&self) -> &str {
        self.answer.as_ref().map_or("error", |answer| &answer.verdict)
    }

    fn names(&self) -> Vec<&str> {
        let steps = self.answer.iter().flat_map(|answer| &answer.steps);
        steps.map(|step| &step.effect[..]).collect()
    }

    fn first_truth(&self) -> &str {
        self.truth.hidden.first().map_or("nothing", |hidden| &hidden.effect)
    }

    /// The first name, or the verdict where there is none.
    fn first_name(&self) -> &str {
        self.names().first().copied().unwrap_or_else(|| self.verdict())
    }

    fn first_right(&self) -> bool {
        self.first_name() == self.first_truth()
    }

    fn alarm(&self) -> bool {
        self.verdict() != "adequate"
    }

    /// Names beyond the truth count as wrong too when they stand alone.
    fn wrong_single_name(&self) -> bool {
        self.verdict() == "named" && self.names().len() == 1 && !self.first_right()
    }

    fn within_three(&self) -> bool {
        let step = self.answer.as_ref().ok().and_then(|answer| answer.steps.first());
        step.is_some_and(|step| {
            let first = step.ranking.iter().take(3).chain(&step.credible_set);
            first.into_iter().any(|name| name == self.first_truth())
        })
    }

    /// Size of the first credible set, and whether the truth is in it; none without a name.
    fn credible(&self) -> Option<(usize, bool)> {
        let step = self.answer.as_ref().ok()?.steps.first()?;
        let set = &step.credible_set;
        Some((set.len(), set.iter().any(|name| name == self.first_truth())))
    }

    fn all_named(&self) -> bool {
        let names = self.names();
        self.truth.hidden.iter().all(|hidden| names.contains(&&hidden.effect[..]))
    }

    /// Whether every step is so.
    fn every(&self, step: fn(&Step) -> bool) -> bool {
        self.answer.iter().flat_map(|answer| &answer.steps).all(step)
    }

    /// Error on traces left out after the last step, over the true noise.
    fn held_out(&self) -> Option<f64> {
        let last = self.answer.as_ref().ok()?.steps.last()?;
        Some(last.heldout_rms[1] / self.truth.noise_rms)
    }
}

/// Prints every measure that the outcomes allow, and what must be reached.
pub fn print(all: &[Outcome]) {
    let mut groups: Vec<&str> = all.iter().map(|outcome| outcome.group).collect();
    groups.dedup();
    println!("{:<22}{:<34}{:<34}must reach", "group", "measure", "share, 95 % interval");
    for group in &groups {
        let of_group: Vec<&Outcome> = all.iter().filter(|o| o.group == *group).collect();
        print_group(group, &of_group);
    }
    let no_effect =
        [LawKind::Outside, LawKind::OutsideMore, LawKind::Beyond, LawKind::Inexact].map(Kind::One);
    let inside = all.iter().filter(|o| !no_effect.contains(&o.kind));
    let unknown = Share::count(inside.map(|o| o.verdict() == "unknown"));
    row("all inside", "wrong unknown", unknown, "at most 2 %");
    print_errors(all);
    for group in &groups {
        print_confusion(group, all);
    }
}

fn row(group: &str, measure: &str, share: Share, goal: &str) {
    if share.of > 0 {
        println!("{group:<22}{measure:<34}{:<34}{goal}", share.to_string());
    }
}

fn print_group(name: &str, all: &[&Outcome]) {
    let share = |is: fn(&Outcome) -> bool| Share::count(all.iter().map(|outcome| is(outcome)));
    match all[0].kind {
        Kind::Null => {
            let goal = if name.starts_with("null-flicker") { "at most 2 %" } else { "at most 1 %" };
            row(name, "false alarm", share(Outcome::alarm), goal);
        }
        Kind::One(LawKind::Outside | LawKind::OutsideMore | LawKind::Beyond) => {
            print_verdicts(name, all);
            row(name, "unknown", share(|o| o.verdict() == "unknown"), "95 %");
        }
        Kind::One(LawKind::Inexact) => print_inexact(name, all),
        Kind::One(LawKind::Reference) => {
            let goal = if name == "reference-0.1" { "95 %" } else { "99 %" };
            row(name, "first name right", share(Outcome::first_right), goal);
            print_beside(name, all);
            print_credible(name, all);
            print_held_out(name, all, 1.05);
        }
        Kind::One(LawKind::Foreign | LawKind::ForeignMore) | Kind::Crosstalk => {
            row(name, "first name right", share(Outcome::first_right), "95 %");
            row(name, "within the first three", share(Outcome::within_three), "98 %");
            print_beside(name, all);
            print_credible(name, all);
            print_held_out(name, all, 1.15);
        }
        Kind::Pair => {
            row(name, "both named", share(Outcome::all_named), "90 %");
            print_held_out(name, all, 1.05);
        }
        Kind::Short => {
            row(name, "wrong single name", share(Outcome::wrong_single_name), "at most 5 %");
        }
    }
    let mean = all.iter().map(|outcome| outcome.seconds).sum::<f64>() / all.len() as f64;
    let longest = all.iter().map(|outcome| outcome.seconds).fold(0.0, f64::max);
    println!(
        "{name:<22}{:<34}mean {mean:.2} s, longest {longest:.2} s",
        "processor time per diagnosis"
    );
}

fn print_verdicts(name: &str, all: &[&Outcome]) {
    for verdict in ["adequate", "named", "ambiguous", "unknown", "error"] {
        let share = Share::count(all.iter().map(|outcome| outcome.verdict() == verdict));
        if share.are > 0 {
            row(name, &format!("verdict {verdict}"), share, "");
        }
    }
}

/// What is said beyond the one effect that is hidden.
fn print_beside(name: &str, all: &[&Outcome]) {
    print_verdicts(name, all);
    let several = Share::count(all.iter().map(|outcome| outcome.names().len() > 1));
    row(name, "a second effect beside it", several, "at most 5 %");
    let unknown = Share::count(all.iter().map(|outcome| outcome.verdict() == "unknown"));
    row(name, "wrong unknown", unknown, "at most 2 %");
}

/// Verdicts, and the names that do not predict.
fn print_inexact(name: &str, all: &[&Outcome]) {
    let share = |is: &dyn Fn(&Outcome) -> bool| Share::count(all.iter().map(|outcome| is(outcome)));
    print_verdicts(name, all);
    row(name, "names an effect", share(&|o| !o.names().is_empty()), "");
    let kept = share(&|o| !o.every(Step::lowers_held_out));
    row(name, "a step does not lower held-out", kept, "0");
    let false_names = share(&|o| !o.every(Step::lowers_fresh));
    row(name, "a step does not predict fresh", false_names, "0");
}

fn print_credible(name: &str, all: &[&Outcome]) {
    let sets: Vec<(usize, bool)> = all.iter().filter_map(|outcome| outcome.credible()).collect();
    row(name, "credible set holds the truth", Share::count(sets.iter().map(|set| set.1)), "95 %");
    if !sets.is_empty() {
        let size = sets.iter().map(|set| set.0).sum::<usize>() as f64 / sets.len() as f64;
        println!("{name:<22}{:<34}{size:<34.2}at most 1.5", "its mean size");
    }
}

fn print_held_out(name: &str, all: &[&Outcome], limit: f64) {
    let mut ratios: Vec<f64> = all.iter().filter_map(|outcome| outcome.held_out()).collect();
    ratios.sort_by(f64::total_cmp);
    let within = Share::count(ratios.iter().map(|ratio| *ratio <= limit));
    row(name, &format!("held-out error within {limit}"), within, "");
    if let Some(median) = ratios.get(ratios.len() / 2) {
        println!("{name:<22}{:<34}{median:<34.3}{limit}", "its median over the noise");
    }
}

fn print_errors(all: &[Outcome]) {
    for outcome in all {
        if let Err(error) = &outcome.answer {
            println!("{}: {error}", outcome.name);
        }
    }
}

/// For each truth how many were named first right, and what the others were called.
fn print_confusion(group: &str, all: &[Outcome]) {
    let mut rows: BTreeMap<String, BTreeMap<&str, usize>> = BTreeMap::new();
    for outcome in all.iter().filter(|outcome| outcome.group == group) {
        let truth = outcome.truth.effects().collect::<Vec<_>>().join(" + ");
        *rows.entry(truth).or_default().entry(outcome.first_name()).or_default() += 1;
    }
    println!("\n{group}: truth, then what was named first (or the verdict)");
    for (truth, named) in rows {
        let mut named: Vec<(&str, usize)> = named.into_iter().collect();
        named.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let named: Vec<String> = named.iter().map(|(name, n)| format!("{name} {n}")).collect();
        let truth = if truth.is_empty() { "nothing" } else { &truth };
        println!("  {truth:<54}{}", named.join(", "));
    }
}
