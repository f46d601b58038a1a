//! How often a formula is found for what the library lacks, on data sets of the independent simulator.
//!
//! `cargo bench -p palpate-tests --bench discover -- --sets 78 --only beyond`: every effect at every size once.

#[path = "../missing_effect/cpu.rs"]
mod cpu;
#[path = "../missing_effect/share.rs"]
mod share;

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;
use palpate::discover::{Discovery, Outcome, discover};
use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Model, Separation};
use palpate_tests::hidden::laws::beyond::{BEYOND, Beyond, beyond};
use palpate_tests::hidden::laws::{CROSSTALK, EFFECTS};
use palpate_tests::hidden::{DataSet, Day, LawKind, NoiseKind, Scenario, folder, generate};
use share::Share;

/// Looks for formulas on simulated data sets and counts.
#[derive(Parser)]
struct Call {
    /// Data sets in each group.
    #[arg(long, default_value_t = 15)]
    sets: usize,
    /// Begin with this set of each group.
    #[arg(long, default_value_t = 0)]
    from: usize,
    /// Only the group of this name: beyond, null, library.
    #[arg(long)]
    only: Option<String>,
    /// Only this effect beyond the library.
    #[arg(long)]
    effect: Option<String>,
    /// Write the sets to this folder, and look for nothing.
    #[arg(long)]
    dump: Option<PathBuf>,
    /// Seed of all data sets.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Given by `cargo bench`.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What is hidden in the sets of a group.
const GROUPS: [&str; 3] = ["beyond", "null", "library"];
/// Misfits that the effects are scaled to, in noises, each in turn.
const R: [f64; 3] = [1.0, 2.0, 4.0];
/// Draws of a specimen until the effect reaches its misfit.
const DRAWS: u64 = 8;

/// What became of one set.
struct Told {
    effect: String,
    r: f64,
    outcome: &'static str,
    /// Error on traces left out, over the noise: of the base law, and after each formula, or with the effects of the library.
    ladder: Vec<f64>,
    /// The terms that were found.
    terms: Vec<String>,
    /// Whether all quantities that the effect depends on are named.
    named: bool,
    /// Name of the library's first effect.
    library: Option<String>,
    seconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let call = Call::parse();
    for (place, group) in GROUPS.iter().enumerate() {
        if call.only.as_ref().is_some_and(|only| only != group) {
            continue;
        }
        let sets = (call.from..call.from + call.sets).map(|index| {
            let seed = (call.seed << 40) ^ ((place as u64) << 32) ^ ((index as u64) << 10);
            (index, set(group, index, seed, call.effect.as_deref()))
        });
        if let Some(folder) = &call.dump {
            for (index, set) in sets {
                folder::write_traces(&folder.join(format!("{group}-{index:04}")), &set)?;
            }
            continue;
        }
        let told: Vec<Told> = sets
            .map(|(_, set)| {
                let told = told(&set);
                println!("{}", line(&told));
                told
            })
            .collect();
        count(group, &told);
    }
    Ok(())
}

fn set(group: &str, index: usize, seed: u64, effect: Option<&str>) -> DataSet {
    let r = R[index % R.len()];
    let library = || EFFECTS.iter().filter(|effect| effect.name != CROSSTALK);
    let hidden = match group {
        "beyond" => {
            let name = effect.unwrap_or(BEYOND[index % BEYOND.len()].name);
            vec![(name.to_owned(), LawKind::Beyond)]
        }
        "library" => {
            // A stride that has no divisor in common with their number, so that a short run meets every stage.
            let name = library().nth(11 * index % library().count()).map(|effect| effect.name);
            vec![(name.unwrap_or_default().to_owned(), LawKind::Reference)]
        }
        _ => Vec::new(),
    };
    let scenario = |draw| Scenario {
        seed: seed + draw,
        hidden: hidden.clone(),
        r: if hidden.is_empty() { 0.0 } else { r },
        noise: NoiseKind::Correlated,
        day: Day::Usual,
    };
    let mut sets = (0..DRAWS).map(|draw| generate(&scenario(draw)));
    sets.find(|set| set.truth.reaches(r)).unwrap_or_else(|| generate(&scenario(0)))
}

fn told(set: &DataSet) -> Told {
    let law = BaseLaw::fung(2, Separation::Clamp);
    let signal = set.truth.signal;
    let base = fit(law, &Data::of(&set.traces, signal).expect("usable traces")).expect("a fit");
    let model = Model::of(&law, signal, &base.values, &base.standard_errors);
    let (found, seconds) =
        cpu::timed(|| discover(&model, &set.traces, "N").expect("a usable model"));
    let hidden = set.truth.hidden.first();
    let rung = |rms: Option<f64>| rms.map_or(f64::NAN, |rms| rms / set.truth.noise_rms);
    let library = &found.diagnosis.found;
    let ladder: Vec<f64> = match found.outcome {
        Outcome::Library => {
            library.evidence.iter().map(|it| rung(it.left_out().map(|it| it.rms))).collect()
        }
        _ => found.ladder.iter().map(|it| rung(it.heldout_rms)).collect(),
    };
    let steps = &library.steps;
    Told {
        effect: hidden.map_or("nothing".into(), |hidden| hidden.effect.clone()),
        r: set.truth.r,
        outcome: match found.outcome {
            Outcome::Adequate => "adequate",
            Outcome::Library => "library",
            Outcome::Formulas(_) => "formula",
            Outcome::Nothing => "nothing",
        },
        ladder,
        terms: expressions(&found).iter().map(|(name, _)| name.clone()).collect(),
        named: hidden.and_then(|it| beyond(&it.effect)).is_some_and(|it| names_all(it, &found)),
        library: steps.first().map(|step| step.effect.clone()),
        seconds,
    }
}

/// The names and expressions of the formulas.
fn expressions(found: &Discovery) -> Vec<(String, String)> {
    let Outcome::Formulas(formulas) = &found.outcome else { return Vec::new() };
    let pair = |it: &palpate::discover::formula::Formula| {
        let name = it.term.candidate.name.clone();
        (name, it.law.expression.clone().unwrap_or_default())
    };
    formulas.iter().map(pair).collect()
}

/// Whether the formulas speak of every quantity that an effect depends on.
fn names_all(effect: &Beyond, found: &Discovery) -> bool {
    let expressions = expressions(found);
    let symbols: Vec<&str> = expressions
        .iter()
        .flat_map(|(_, text)| text.split(|c: char| !c.is_alphanumeric() && c != '_'))
        .collect();
    effect.depends_on.iter().all(|any| any.iter().any(|symbol| symbols.contains(symbol)))
}

fn line(told: &Told) -> String {
    let ladder: Vec<String> = told.ladder.iter().map(|rung| format!("{rung:.2}")).collect();
    format!(
        "{:18} R {:.1} {:9} {:24} {} {:5.1} s  library: {}  {}",
        told.effect,
        told.r,
        told.outcome,
        ladder.join(" → "),
        if told.named { "named" } else { "     " },
        told.seconds,
        told.library.as_deref().unwrap_or("–"),
        told.terms.join("; "),
    )
}

fn count(group: &str, all: &[Told]) {
    println!("\n{group}: {} sets", all.len());
    let share = |of: &dyn Fn(&Told) -> bool| Share::count(all.iter().map(of));
    println!("  a formula                              {}", share(&Told::has_formula));
    match group {
        "beyond" => {
            count_beyond(all);
            for r in R {
                let own: Vec<&Told> =
                    all.iter().filter(|told| (told.r / r - 1.0).abs() < 0.1).collect();
                println!(" at R = {r}: {} sets", own.len());
                count_beyond(own);
            }
        }
        "library" => {
            let first = share(&|told| told.library.as_ref() == Some(&told.effect));
            println!("  the library's name comes first         {first}");
        }
        _ => {}
    }
    let mut seconds: Vec<f64> = all.iter().map(|told| told.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    if let (Some(most), Some(middle)) = (seconds.last(), seconds.get(seconds.len() / 2)) {
        println!("  processor, median and most             {middle:.1} s, {most:.1} s\n");
    }
}

fn count_beyond<'a>(all: impl IntoIterator<Item = &'a Told>) {
    let all: Vec<&Told> = all.into_iter().collect();
    let share = |of: &dyn Fn(&Told) -> bool| Share::count(all.iter().map(|told| of(told)));
    let found = all.iter().filter(|told| told.has_formula());
    println!(
        "  within 1.15 noises, by a formula       {}",
        share(&|it| it.has_formula() && it.within(1.15))
    );
    println!("  within 1.15, also by the library       {}", share(&|it| it.within(1.15)));
    println!(
        "  within 1.5 noises, by a formula        {}",
        share(&|it| it.has_formula() && it.within(1.5))
    );
    println!("  within 1.5, also by the library        {}", share(&|it| it.within(1.5)));
    println!("  all true quantities named              {}", share(&|told| told.named));
    println!(
        "  the same, of sets with a formula       {}",
        Share::count(found.map(|told| told.named))
    );
}

impl Told {
    fn has_formula(&self) -> bool {
        self.outcome == "formula"
    }

    /// Whether traces left out are predicted to within so many noises.
    fn within(&self, noises: f64) -> bool {
        self.ladder.last().is_some_and(|error| *error <= noises)
    }
}
