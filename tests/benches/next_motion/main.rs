//! In how many experiments recordings with several names come to one: by the motion that is proposed, by the best of the menu, and by
//! motions by chance.
//!
//! `cargo bench -p palpate-tests --bench next_motion -- --seeds 2,5`

#[path = "../missing_effect/share.rs"]
mod share;

use clap::Parser;
use palpate::criticism::diagnose::{Diagnosis, Verdict, diagnose};
use palpate::criticism::next_motion::{RigFile, best_of_menu, by_chance, propose};
use palpate::effects::LIBRARY;
use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Model, Separation};
use palpate::practice::{Choice, Truth, hide, record};
use palpate::trace::{FORCE, Trace};
use share::Share;

/// Makes practice sets, keeps their first three recordings, and goes on with one experiment after the other.
#[derive(Parser)]
struct Call {
    /// Seeds of the practice sets, for every effect each.
    #[arg(long, value_delimiter = ',', default_value = "2,5")]
    seeds: Vec<u64>,
    /// Only this effect.
    #[arg(long)]
    effect: Option<String>,
    /// Only this way to choose a motion: proposed, menu or chance.
    #[arg(long)]
    only: Option<String>,
    /// Given by `cargo bench`.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Misfit that an effect leaves, in noises.
const SIZE: f64 = 0.3;
/// Recordings at the outset.
const AT_FIRST: usize = 3;
/// Most experiments.
const MOST: usize = 4;
/// Ways to choose the next motion.
const WAYS: [&str; 3] = ["proposed", "menu", "chance"];

/// A data set with several names.
struct Open {
    effect: &'static str,
    model: Model,
    traces: Vec<Trace>,
    truth: Truth,
    diagnosis: Diagnosis,
    /// What is proposed at first: how many pairs of names it distinguishes, and of how many.
    distinguishes: Option<(usize, usize)>,
}

/// What became of it.
struct Course {
    /// Experiments until one name was left; none where it was not after the last.
    experiments: Option<usize>,
    /// Whether that name was the right one.
    right: bool,
}

fn main() {
    let call = Call::parse();
    let effects = LIBRARY.iter().map(|effect| effect.name);
    let effects = effects.filter(|name| call.effect.as_ref().is_none_or(|only| only == name));
    let pairs = effects.flat_map(|effect| call.seeds.iter().map(move |seed| (effect, *seed)));
    let open: Vec<Open> = pairs.filter_map(|(effect, seed)| open(effect, seed)).collect();
    let some = |open: &&Open| open.distinguishes.is_some_and(|(pairs, _)| pairs > 0);
    let all = |open: &&Open| open.distinguishes.is_some_and(|(pairs, of)| pairs == of);
    println!(
        "{} sets of three recordings with several names: a motion that distinguishes some of them for {}, all of them for {}\n",
        open.len(),
        open.iter().filter(some).count(),
        open.iter().filter(all).count()
    );
    for way in WAYS.iter().filter(|way| call.only.as_ref().is_none_or(|only| only == *way)) {
        let courses: Vec<Course> = open.iter().map(|open| course(open, way)).collect();
        count(way, &open, &courses);
    }
}

/// The first recordings of a practice set, where they leave several names.
fn open(effect: &'static str, seed: u64) -> Option<Open> {
    let practice = hide(&Choice::Named(vec![effect.to_owned()]), SIZE, seed).ok()?;
    let mut traces = practice.traces;
    traces.truncate(AT_FIRST);
    let law = BaseLaw::fung(2, Separation::Clamp);
    let base = fit(law, &Data::of(&traces, FORCE).ok()?).ok()?;
    let model = Model::of(&law, FORCE, &base.values, &base.standard_errors);
    let diagnosis = diagnose(&model, &traces).ok()?;
    if diagnosis.verdict != Verdict::Ambiguous {
        return None;
    }
    let proposed = propose(&model, &diagnosis, &traces, &RigFile::default()).ok()?;
    let distinguishes =
        proposed.motion.map(|motion| (motion.foreseen.told(), motion.foreseen.apart.len()));
    let truth = practice.truth;
    Some(Open { effect, model, traces, truth, diagnosis, distinguishes })
}

/// One experiment after the other until one name is left.
fn course(open: &Open, way: &str) -> Course {
    let (mut traces, mut diagnosis) = (open.traces.clone(), open.diagnosis.clone());
    print!("{way:9} {:32}", open.effect);
    for experiment in 1..=MOST {
        let limits = RigFile::default();
        let motion = match way {
            "proposed" => propose(&open.model, &diagnosis, &traces, &limits)
                .map(|proposed| proposed.motion.map(|motion| motion.trace)),
            "menu" => best_of_menu(&open.model, &diagnosis, &traces, &limits),
            _ => by_chance(&open.model, &diagnosis, &traces, (&limits, experiment as u64)),
        };
        let Ok(Some(motion)) = motion else { break };
        let Ok(recorded) = record(&open.truth, &traces, &motion) else { break };
        traces.push(recorded);
        let Ok(after) = diagnose(&open.model, &traces) else { break };
        diagnosis = after;
        print!("  {}", names(&diagnosis));
        if diagnosis.verdict == Verdict::Named {
            let right = diagnosis.found.steps[0].effect == open.effect;
            println!();
            return Course { experiments: Some(experiment), right };
        }
    }
    println!();
    Course { experiments: None, right: false }
}

fn names(diagnosis: &Diagnosis) -> String {
    let steps = diagnosis.found.steps.iter().map(|step| step.credible.join("|"));
    format!("{:?} {}", diagnosis.verdict, steps.collect::<Vec<_>>().join(" + "))
}

fn count(way: &str, open: &[Open], courses: &[Course]) {
    let pairs: Vec<(&Open, &Course)> = open.iter().zip(courses).collect();
    let in_one = |course: &Course| course.experiments == Some(1);
    let of = |keeps: &dyn Fn(usize, usize) -> bool| -> Vec<&Course> {
        let kept = pairs
            .iter()
            .filter(|(open, _)| open.distinguishes.is_some_and(|(pairs, of)| keeps(pairs, of)));
        kept.map(|(_, course)| *course).collect()
    };
    let share = |of: &[&Course]| Share::count(of.iter().map(|course| in_one(course)));
    println!("\n{way}");
    println!(
        "  one name after one motion, where some can be distinguished  {}",
        share(&of(&|pairs, _| pairs > 0))
    );
    println!(
        "  one name after one motion, where all can be distinguished   {}",
        share(&of(&|pairs, of| pairs == of))
    );
    let decided = courses.iter().filter(|course| course.experiments.is_some());
    println!(
        "  the right one                                               {}",
        Share::count(decided.map(|course| course.right))
    );
    let by =
        |most: usize| courses.iter().filter(|it| it.experiments.is_some_and(|n| n <= most)).count();
    let after: Vec<String> = (1..=MOST).map(|most| by(most).to_string()).collect();
    println!("  one name after at most 1, 2, … of {} sets: {}\n", courses.len(), after.join(", "));
}
