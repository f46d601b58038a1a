//! A base law and an effect of one's own: a tissue that stiffens exponentially, on a drive whose teeth push.
//!
//! `cargo run --package palpate --example own`; [`docs/new-law.md`](../../../docs/new-law.md) and [`docs/new-effect.md`](../../../docs/new-effect.md)
//! explain the declarations.

mod declared;

use palpate::fit::data::Data;
use palpate::fit::whole_motion::predict;
use palpate::model::{BaseLaw, Chain, Separation};
use palpate::trace::FORCE;
use palpate::{DataSet, Effects, Elastic, Kernel, Law, Laws};

use declared::{EXPONENTIAL, TEETH};

/// The motions of a recording, with what such a specimen would answer to them: p, α, shares, rates, amplitude and pitch.
const SPECIMEN: [f64; 8] = [0.15, 0.2, 0.26, 0.24, 4.2, 0.55, 0.05, 0.9];

/// The recording that comes with the project.
const PRESS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/traces/press.csv");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let motions = DataSet::read(PRESS)?.traces().to_vec();
    let data = Data::of_motions(&motions, FORCE)?;
    let elastic = Elastic { law: &EXPONENTIAL, gauge: None };
    let law = BaseLaw::fung(2, Separation::Clamp).with(elastic, Kernel::EXPONENTIALS);
    let chain = Chain::new(law).with(TEETH.laws[0].applied(&TEETH, &data.setting()));
    let mut recorded = motions.clone();
    for (trace, force) in recorded.iter_mut().zip(predict(&chain, &SPECIMEN, &data)) {
        // A hundredth of a newton of noise, evenly spread and the same in every run.
        let noise = (0u32..)
            .map(|k| (f64::from(k.wrapping_mul(2_654_435_761) >> 8) / 16_777_216.0 - 0.5) * 0.034);
        trace.set_column(
            FORCE,
            force.iter().zip(noise).map(|(force, noise)| force + noise).collect(),
        );
    }
    let set = DataSet::from(recorded);

    let laws = Laws::library().with_elastic(&EXPONENTIAL);
    let ranking = palpate::rank(&set).laws(laws.clone()).run()?;
    println!("best law: {}", ranking.places[0].fit.chain.base.short_name());
    let fit = palpate::fit(Law::fung().elastic(elastic), &set).run()?;
    let found = palpate::diagnose(fit.model(), &set)
        .laws(laws)
        .effects(Effects::library().with(&TEETH))
        .run()?;
    println!("{}: {}", found.verdict().word(), found.effects().join(", "));
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::main().unwrap();
    }
}
