//! `palpate effects`.

use super::Failure;
use super::output::{Output, print_json, print_sections, write_report};
use crate::criticism::signature::signature;
use crate::effects::{EffectError, find};
use crate::summary::{effect_figures, effect_json, effect_section, library_json, library_section};

/// Show the library of effects, or one effect in depth.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate effects
  palpate effects mullins
  palpate effects mullins --report mullins.html    with a picture of what it leaves in a residual
  palpate effects --json | jq -r '.effects[].name'")]
pub struct Args {
    /// An effect; all where absent
    name: Option<String>,
    #[command(flatten)]
    result: Output,
}

/// Prints the library, or one effect.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files([""; 0])?;
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
    if args.result.json { print_json(&effect_json(effect)) } else { print_sections(&[section]) }
}

fn all(result: &Output) -> Result<(), Failure> {
    let section = library_section();
    if let Some(path) = &result.report {
        let about = "what a base law can lack";
        write_report(path, "The library of effects", about, Vec::new(), vec![section.clone()])?;
    }
    if result.json { print_json(&library_json()) } else { print_sections(&[section]) }
}
