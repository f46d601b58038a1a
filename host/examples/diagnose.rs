//! Hides a physical effect in simulated recordings, then asks which one Fung's law lacks.
//!
//! `cargo run --package palpate --example diagnose`

use palpate::practice::hidden::{Choice, hide};
use palpate::{DataSet, Law};

/// Size of the misfit that the effect leaves, over the noise, and the seed of specimen, effect and noise.
const HIDDEN: (f64, u64) = (5.0, 7);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let practice = hide(&Choice::Named(vec!["mullins".into()]), HIDDEN.0, HIDDEN.1)?;
    let set = DataSet::from(practice.traces);
    let fit = palpate::fit(Law::fung().terms(2), &set).run()?;
    let found = palpate::diagnose(fit.model(), &set)
        .on_progress(|stage| eprint!("\r{} {}/{}   ", stage.what, stage.done, stage.of))
        .run()?;
    eprintln!();
    println!("{}: {}", found.verdict().word(), found.effects().join(", "));
    for rung in found.better().map(|model| model.ladder.as_slice()).unwrap_or_default() {
        println!("{:<10} {:.4} N RMS", rung.add, rung.fitted_rms);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::main().unwrap();
    }
}
