//! Fits Fung's law to a recording, and prints what it found.
//!
//! `cargo run --package palpate --example fit -- tests/traces/press.csv`

use palpate::{DataSet, Error, Law};

/// The recording that comes with the project.
const PRESS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/traces/press.csv");

fn main() -> Result<(), Error> {
    fit(std::env::args().nth(1).as_deref().unwrap_or(PRESS))
}

fn fit(recording: &str) -> Result<(), Error> {
    let set = DataSet::read(recording)?;
    let fit = palpate::fit(Law::fung().terms(2), &set).run()?;
    let fitted = fit.fitted();
    for ((parameter, value), error) in
        fitted.parameters().iter().zip(&fitted.values).zip(&fitted.standard_errors)
    {
        let error = error.map_or("not determined".to_owned(), |error| format!("± {error:.2e}"));
        println!("{:<3} {value:>9.4} {error} {}", parameter.name, parameter.unit);
    }
    println!("R² {:.4}, residual {:.4} N RMS", fitted.r_squared, fitted.rms());
    for warning in fit.warnings() {
        println!("beware: {warning}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::fit(super::PRESS).unwrap();
    }
}
