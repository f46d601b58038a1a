//! Fits Fung's law to a recording, and prints what it found.
//!
//! `cargo run --example fit -- tests/traces/press.csv`

use palpate::{DataSet, Error, Law};

fn main() -> Result<(), Error> {
    let set =
        DataSet::read(std::env::args().nth(1).as_deref().unwrap_or("tests/traces/press.csv"))?;
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
