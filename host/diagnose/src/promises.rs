//! What every law of the library promises, asked of a law of one's own: on a press with a hold and on four cycles.

use crate::practice::session::{SPECIMEN, two_traces};
use palpate_fit::data::{Data, DataError};
use palpate_fit::whole_motion::predict;
use palpate_model::effects::units::powers;
use palpate_model::effects::{EffectError, applied};
use palpate_model::{Chain, Stage, StoredEffect};
use palpate_trace::{DISPLACEMENT, FORCE, TANGENTIAL, TEMPERATURE, Trace};

/// Change of the prediction, over the largest force, that counts as none.
const NOTHING: f64 = 1e-9;
/// Samples by which velocity and acceleration look ahead.
const AHEAD: usize = 4;
/// Other base units than mm, s, N and K: how many of them make one.
const OTHER: [f64; 4] = [1.7, 0.6, 2.3, 1.3];
/// Energy that a cycle may give back, over what it dissipates, for rounding.
const GIVEN: f64 = 1e-3;

/// One promise, and whether it is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Promise {
    /// What is promised.
    pub what: &'static str,
    /// What was found.
    pub found: Kept,
}

/// Whether a promise is kept.
#[derive(Clone, Debug, PartialEq)]
pub enum Kept {
    /// It is.
    Yes,
    /// It is not, for this reason.
    No(String),
    /// It was not asked, for this reason.
    NotAsked(String),
}

/// Why a law cannot be asked.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ContractError {
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("`{0}` is of the library, which keeps its promises by its own tests")]
    OfLibrary(String),
}

/// Asks a law of one's own, at the values of its parameters, for every promise.
///
/// # Errors
/// When it is no law of one's own, or is not what it can be.
pub fn contract(law: &StoredEffect) -> Result<Vec<Promise>, ContractError> {
    if law.expression.is_none() {
        return Err(ContractError::OfLibrary(law.name.clone()));
    }
    let case = Case::of(law)?;
    let promise = |what, found| Promise { what, found };
    Ok(vec![
        promise("at strength 0 it changes nothing", case.vanishes()),
        promise("at its values it changes the prediction", case.acts()),
        promise("it depends on nothing that comes later", case.is_causal()?),
        promise("it is the same in other units", case.keeps_units()?),
        promise("a closed cycle gives no energy", case.is_passive()),
    ])
}

/// A law beside the base law over the traces.
struct Case {
    law: StoredEffect,
    traces: Vec<Trace>,
    values: Vec<f64>,
    bare: Vec<Vec<f64>>,
    with: Vec<Vec<f64>>,
}

impl Case {
    fn of(law: &StoredEffect) -> Result<Self, ContractError> {
        let traces = two_traces();
        let values: Vec<f64> = law.parameters.values().map(|parameter| parameter.value).collect();
        let mut case =
            Self { law: law.clone(), traces, values, bare: Vec::new(), with: Vec::new() };
        case.bare = case.predicted(&case.traces, None)?;
        case.with = case.predicted(&case.traces, Some(&case.values))?;
        Ok(case)
    }

    /// What the base law predicts for traces, alone or with the law at these values.
    fn predicted(
        &self,
        traces: &[Trace],
        values: Option<&[f64]>,
    ) -> Result<Vec<Vec<f64>>, ContractError> {
        self.predicted_beside(traces, &SPECIMEN.1, values)
    }

    fn predicted_beside(
        &self,
        traces: &[Trace],
        base: &[f64],
        values: Option<&[f64]>,
    ) -> Result<Vec<Vec<f64>>, ContractError> {
        let data = Data::of_motions(traces, FORCE)?;
        let chain = Chain::new(SPECIMEN.0);
        let Some(values) = values else { return Ok(predict(&chain, base, &data)) };
        let (law, _) = applied(&self.law, &data.setting())?;
        Ok(predict(&chain.with(law), &[base, values].concat(), &data))
    }

    /// Largest force.
    fn force(&self) -> f64 {
        self.bare.iter().flatten().fold(0.0, |most: f64, force| most.max(force.abs()))
    }

    fn vanishes(&self) -> Kept {
        let mut values = self.values.clone();
        values[0] = 0.0;
        let Ok(found) = self.predicted(&self.traces, Some(&values)) else {
            return Kept::No("it cannot be evaluated there".into());
        };
        let most = largest_difference(&found, &self.bare);
        if most <= NOTHING * self.force() {
            return Kept::Yes;
        }
        let strength = self.law.parameters.keys().next().map_or("", String::as_str);
        Kept::No(format!("with {strength} = 0 the force still changes by up to {most:.3e} N"))
    }

    fn acts(&self) -> Kept {
        if largest_difference(&self.with, &self.bare) > NOTHING * self.force() {
            return Kept::Yes;
        }
        Kept::No("it changes nothing on a press with a hold and four cycles".into())
    }

    /// The end of each motion is another: what was before may not change.
    fn is_causal(&self) -> Result<Kept, ContractError> {
        let mut other = self.traces.clone();
        for trace in &mut other {
            let half = trace.len() / 2;
            let Some(column) = trace.columns.iter_mut().find(|it| it.name == DISPLACEMENT) else {
                continue;
            };
            let from = column.values[half];
            for (k, x) in column.values[half..].iter_mut().enumerate() {
                *x = from - 0.002 * k as f64;
            }
        }
        let found = self.predicted(&other, Some(&self.values))?;
        // The second trace remembers the first, so only the first is asked.
        let (now, then) = (&found[0], &self.with[0]);
        let until = (now.len() / 2).saturating_sub(AHEAD);
        let early =
            now[..until].iter().zip(then).position(|(a, b)| (a - b).abs() > NOTHING * self.force());
        Ok(match early {
            None => Kept::Yes,
            Some(k) => Kept::No(format!(
                "at {:.3} s the prediction changes with a motion that differs from {:.3} s on",
                self.traces[0].time[k],
                self.traces[0].time[now.len() / 2],
            )),
        })
    }

    /// Everything in other base units: the prediction must be the same but for the unit of the force.
    fn keeps_units(&self) -> Result<Kept, ContractError> {
        let mut values = Vec::new();
        for (name, stored) in &self.law.parameters {
            let Some(powers) = powers(&stored.unit) else {
                return Ok(Kept::NotAsked(format!(
                    "the unit `{}` of {name} is none of mm, s, N, K and their products",
                    stored.unit
                )));
            };
            let factors = OTHER.iter().zip(powers).map(|(factor, power)| factor.powf(power));
            values.push(factors.fold(stored.value, |value, factor| value * factor));
        }
        let [length, time, force, warmth] = OTHER;
        let mut other = self.traces.clone();
        for trace in &mut other {
            trace.time.iter_mut().for_each(|t| *t *= time);
            let begin = &mut trace.head.setup.start_s;
            *begin = begin.map(|start| start * time);
            for column in &mut trace.columns {
                let factor = match column.name.as_str() {
                    DISPLACEMENT => length,
                    FORCE | TANGENTIAL => force,
                    TEMPERATURE => warmth,
                    _ => 1.0,
                };
                column.values.iter_mut().for_each(|value| *value *= factor);
            }
        }
        let [p, q, c1, c2, v1, v2] = SPECIMEN.1;
        let base = [p * force / length.powf(q + 1.0), q, c1, c2, v1 / time, v2 / time];
        let found = self.predicted_beside(&other, &base, Some(&values))?;
        let back: Vec<Vec<f64>> =
            found.iter().map(|trace| trace.iter().map(|f| f / force).collect()).collect();
        let most = largest_difference(&back, &self.with) / self.force();
        Ok(if most < 1e-6 {
            Kept::Yes
        } else {
            Kept::No(format!(
                "in other units the same motion gives a force that differs by {:.2} % of the largest: a unit is wrong, or a \
                 number in the expression has one",
                100.0 * most
            ))
        })
    }

    /// Work done by what the law adds to the force over the cycles of the second trace, which begin and end off the specimen.
    fn is_passive(&self) -> Kept {
        if let Some(stage @ (Stage::Motion | Stage::Relaxation | Stage::Sensor)) = self.law.stage {
            return Kept::NotAsked(format!(
                "at the stage of {} it is no force of its own",
                stage.name()
            ));
        }
        let place = self.traces[1].displacement().unwrap_or_default();
        let own: Vec<f64> = self.with[1].iter().zip(&self.bare[1]).map(|(a, b)| a - b).collect();
        let work = |force: &[f64]| -> f64 {
            let pair = |k: usize| 0.5 * (force[k] + force[k - 1]) * (place[k] - place[k - 1]);
            (1..force.len()).map(pair).sum()
        };
        let (added, whole) = (work(&own), work(&self.bare[1]));
        if added >= -GIVEN * whole.abs() {
            return Kept::Yes;
        }
        Kept::No(format!("four cycles give back {:.3e} mJ more than they take", -added))
    }
}

fn largest_difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(stage: Stage, expression: &str, parameters: &[(&str, f64, &str)]) -> StoredEffect {
        let parameters = parameters.iter().map(|(name, value, unit)| {
            let text = format!("value = {value}\nunit = \"{unit}\"");
            ((*name).to_owned(), toml::from_str(&text).unwrap())
        });
        StoredEffect {
            name: "mine".into(),
            law: None,
            stage: Some(stage),
            expression: Some(expression.into()),
            meaning: None,
            parameters: parameters.collect(),
        }
    }

    /// Which promises are broken, by their place.
    fn broken(law: &StoredEffect) -> Vec<usize> {
        let promises = contract(law).unwrap();
        let no = |(k, it): (usize, &Promise)| matches!(it.found, Kept::No(_)).then_some(k);
        promises.iter().enumerate().filter_map(no).collect()
    }

    #[test]
    fn a_sound_law_keeps_every_promise() {
        let drag = law(Stage::Contact, "c * v", &[("c", 0.01, "N s/mm")]);
        assert_eq!(broken(&drag), [0_usize; 0]);
        let teeth = law(
            Stage::Contact,
            "k * sin(TAU * x / period)",
            &[("k", 0.02, "N"), ("period", 0.8, "mm")],
        );
        assert_eq!(broken(&teeth), [0_usize; 0]);
    }

    #[test]
    fn what_breaks_a_promise_is_told() {
        let offset = law(Stage::Contact, "k * x + 0.1", &[("k", 0.02, "N/mm")]);
        assert_eq!(broken(&offset), [0, 3]);
        let useless = law(Stage::Contact, "k * 0", &[("k", 0.02, "N")]);
        assert_eq!(broken(&useless), [1]);
        let unit = law(Stage::Contact, "k * v", &[("k", 0.01, "N")]);
        assert_eq!(broken(&unit), [3]);
        let engine = law(Stage::Contact, "k * v", &[("k", -0.01, "N s/mm")]);
        assert_eq!(broken(&engine), [4]);
    }
}
