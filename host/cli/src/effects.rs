//! `palpate effects`.

use std::path::{Path, PathBuf};

use super::Failure;
use super::output::{Output, print_json, print_sections, write_report};
use palpate_diagnose::criticism::signature::signature;
use palpate_diagnose::promises::{Kept, contract};
use palpate_model::effects::{EffectError, find, read_laws};
use palpate_present::answers::{self, ContractAnswer, EffectAnswer, LibraryAnswer};
use palpate_present::summary::{contract_section, effect_figures, effect_section, library_section};

/// Show the library of effects, or one effect in depth.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate effects
  palpate effects mullins
  palpate effects mullins --report mullins.html    with a picture of what it leaves in a residual
  palpate effects --check laws.toml                laws of your own, asked what the library promises
  palpate effects --json | jq -r '.effects[].name'")]
pub struct Args {
    /// An effect; all where absent
    name: Option<String>,
    /// Ask the laws in this file, or in the files of this folder, for what every law of the library promises
    #[arg(long, value_name = "LAWS.toml", conflicts_with = "name")]
    check: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// Prints the library, or one effect.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.check)?;
    if let Some(path) = &args.check {
        return check(path, &args.result);
    }
    let Some(name) = &args.name else { return all(&args.result) };
    let effect = find(name).ok_or_else(|| Failure::input(EffectError::Unknown(name.clone())))?;
    let signature = signature(effect).map_err(Failure::work)?;
    let section = effect_section(&signature);
    if let Some(path) = &args.result.report {
        let drawn = effect_figures(&signature)
            .into_iter()
            .fold(section.clone(), |section, figure| section.figure(figure, ""));
        write_report(path, effect.name, effect.meaning, Vec::new(), vec![drawn])?;
    }
    if args.result.json {
        print_json(&answers::json(&EffectAnswer::from(effect)))
    } else {
        print_sections(&[section])
    }
}

fn all(result: &Output) -> Result<(), Failure> {
    let section = library_section();
    if let Some(path) = &result.report {
        let about = "what a base law can lack";
        write_report(path, "The library of effects", about, Vec::new(), vec![section.clone()])?;
    }
    if result.json {
        print_json(&answers::json(&LibraryAnswer::whole()))
    } else {
        print_sections(&[section])
    }
}

/// Asks laws of one's own for every promise; what is not kept is a failure.
fn check(path: &Path, result: &Output) -> Result<(), Failure> {
    let mut found = Vec::new();
    for law in read_laws(path).map_err(Failure::input)? {
        let promises = contract(&law).map_err(Failure::input)?;
        found.push((law, promises));
    }
    let sections =
        found.iter().map(|(law, promises)| contract_section(law, promises)).collect::<Vec<_>>();
    let name = path.display().to_string();
    let kept = |(law, promises): &(_, Vec<_>)| ContractAnswer::of(law, promises);
    let json = || answers::json(&found.iter().map(kept).collect::<Vec<_>>());
    result.give("Laws of one's own", &name, vec![name.clone()], &sections, json)?;
    let broken = found.iter().flat_map(|(_, promises)| promises);
    match broken.filter(|promise| matches!(promise.found, Kept::No(_))).count() {
        0 => Ok(()),
        1 => Err(Failure::Work(miette::miette!("one promise is not kept"))),
        count => Err(Failure::Work(miette::miette!("{count} promises are not kept"))),
    }
}
