//! A base law and an effect of one's own: a tissue that stiffens exponentially, on a drive whose teeth push.
//!
//! `cargo run --package palpate --example own`; [`docs/new-law.md`](../../docs/new-law.md) and [`docs/new-effect.md`](../../docs/new-effect.md)
//! explain the declarations.

use std::f64::consts::TAU;

use palpate::effects::{Count, Effect, Law as EffectLaw, Needs, Role, Shape, Sign, Strength};
use palpate::fit::data::Data;
use palpate::fit::whole_motion::predict;
use palpate::model::covariate::Covariate;
use palpate::model::elastic::{Acts, ElasticLaw};
use palpate::model::laws::{LawParameter, POSITIVE};
use palpate::model::{Act, BaseLaw, Chain, Coordinate, Separation, Stage};
use palpate::trace::FORCE;
use palpate::{DataSet, Effects, Elastic, Kernel, Law, Laws};

/// Fung's exponential: the stiffness grows in proportion to the force.
static EXPONENTIAL: ElasticLaw = ElasticLaw {
    name: "exponential",
    meaning: "stiffens in proportion to the force, as soft tissue does",
    formula: "p (e^(αx) − 1)/α",
    acts: Acts::OnDisplacement(|alpha, x| (alpha * x.max(0.0)).exp_m1() / alpha),
    parameters: |_, stiffness| {
        let (p, alpha) = ("stiffness at the first touch", "growth of the stiffness");
        vec![
            LawParameter::new("p", "N/mm", p, POSITIVE, stiffness).scaling(),
            LawParameter::new("alpha", "1/mm", alpha, POSITIVE, Coordinate::Shape),
        ]
    },
    constants: |values| (values[0], values[1]),
    values: |p, shape| vec![p, shape],
    bounds: |reach| Some((1e-3 / reach.largest, 20.0 / reach.largest)),
    starts: |reach| [0.1, 1.0, 3.0, 8.0].map(|times| times / reach.largest).to_vec(),
};

/// Force of a rack and pinion under the specimen.
static TEETH: Effect = Effect {
    name: "teeth",
    stage: Stage::Contact,
    meaning: "The teeth of the drive push once for each pitch.",
    signature: "Repeats with the displacement, the same in both directions.",
    against: Covariate::Displacement,
    confused_with: &["backlash"],
    experiment: "The same stroke without a specimen.",
    needs: Needs::Nothing,
    laws: &[EffectLaw {
        name: "reference",
        formula: "F → F + a sin(2π x/λ)",
        strength: Strength {
            name: "amplitude",
            unit: "N",
            meaning: "largest push",
            sign: Sign::Either,
            typical: |scales| 0.01 * scales.force,
            most: |scales| scales.force,
            count: Count::Fixed(&[]),
        },
        shapes: &[Shape {
            name: "pitch",
            unit: "mm",
            meaning: "from tooth to tooth",
            grid: |_| (0..10).map(|k| 0.5 + 0.1 * f64::from(k)).collect(),
            role: Role::Fitted(|_| (0.3, 3.0)),
        }],
        act: Act::Force(|scene, parameters, _, force| {
            for (force, x) in force.iter_mut().zip(scene.motion.displacement.iter()) {
                *force += parameters[0] * (TAU * x / parameters[1]).sin();
            }
        }),
    }],
};

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
