//! Effects of a model file as parts of a chain, and back.

use std::sync::Arc;

use super::{Setting, meant};
use crate::{
    Act, Applied, Chain, Expression, ExpressionError, Model, Parameter, Span, StoredEffect,
    StoredParameter,
};

/// Why an effect of a model file cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum EffectError {
    #[error("{0}")]
    Base(String),
    #[error("no effect is called `{0}`{like}; `palpate effects` lists them all", like = meant(.0))]
    Unknown(String),
    #[error("`{effect}` has no law `{law}`; it has: {known}")]
    UnknownLaw { effect: String, law: String, known: String },
    #[error("`{effect}`: {parameter} is missing")]
    Missing { effect: String, parameter: String },
    #[error("`{effect}` has no parameter `{parameter}`")]
    UnknownParameter { effect: String, parameter: String },
    #[error("`{effect}`: {parameter} = {value} is not a number that it can have")]
    Value { effect: String, parameter: String, value: f64 },
    #[error(
        "`{0}` is the name of an effect already, of the library or of the program; give yours another"
    )]
    Taken(String),
    #[error("`{0}`: a law of one's own takes both `stage` and `expression`")]
    Half(String),
    #[error("`{0}`: a law of one's own takes at least one parameter, its strength first")]
    NoStrength(String),
    #[error("`{effect}`: {source}")]
    Expression { effect: String, source: ExpressionError },
}

/// The chain of a model over a data set, with the values of its parameters.
///
/// # Errors
/// When the base law or an effect of the model is not what it can be.
pub fn chain_of(model: &Model, setting: &Setting) -> Result<(Chain, Vec<f64>), EffectError> {
    let (base, mut values) = model.law_of(&setting.laws).map_err(EffectError::Base)?;
    let scales = &setting.scales;
    let mut chain = Chain::new(base.over(Span::of(scales.interval, scales.set_duration)));
    for stored in &model.effects {
        let (effect, own) = applied(stored, setting)?;
        chain.effects.push(effect);
        values.extend(own);
    }
    Ok((chain, values))
}

/// An effect of a model file as a part of a chain, with the values of its parameters.
///
/// # Errors
/// When it is not what it can be.
pub fn applied(
    stored: &StoredEffect,
    setting: &Setting,
) -> Result<(Applied, Vec<f64>), EffectError> {
    let effect = if stored.stage.is_some() || stored.expression.is_some() {
        own(stored, setting)?
    } else {
        declared(stored, setting)?
    };
    let name = || stored.name.clone();
    let value = |parameter: &Parameter| {
        let missing =
            || EffectError::Missing { effect: name(), parameter: parameter.name.to_string() };
        match stored.parameters.get(parameter.name.as_ref()) {
            Some(stored) if stored.value.is_finite() => Ok(stored.value),
            Some(stored) => Err(EffectError::Value {
                effect: name(),
                parameter: parameter.name.to_string(),
                value: stored.value,
            }),
            // A trace that the model has not seen has no zero of its own yet.
            None if effect.each_trace > 0 => Ok(0.0),
            None => Err(missing()),
        }
    };
    let values = effect.parameters.iter().map(value).collect::<Result<Vec<_>, _>>()?;
    let known = |name: &String| effect.parameters.iter().any(|p| p.name == name.as_str());
    if let Some(parameter) =
        stored.parameters.keys().find(|name| !known(name) && effect.each_trace == 0)
    {
        return Err(EffectError::UnknownParameter { effect: name(), parameter: parameter.clone() });
    }
    Ok((effect, values))
}

/// An effect that is declared: in the library, or by the program.
fn declared(stored: &StoredEffect, setting: &Setting) -> Result<Applied, EffectError> {
    let effect = setting.effects.find(&stored.name);
    let effect = effect.ok_or_else(|| EffectError::Unknown(stored.name.clone()))?;
    let wanted = stored.law.as_deref().unwrap_or(effect.laws[0].name);
    let law = effect.laws.iter().find(|law| law.name == wanted).ok_or_else(|| {
        let known: Vec<&str> = effect.laws.iter().map(|law| law.name).collect();
        EffectError::UnknownLaw {
            effect: stored.name.clone(),
            law: wanted.into(),
            known: known.join(", "),
        }
    })?;
    Ok(law.applied(effect, setting))
}

/// A law of the user's own.
fn own(stored: &StoredEffect, setting: &Setting) -> Result<Applied, EffectError> {
    let name = || stored.name.clone();
    let (Some(stage), Some(text)) = (stored.stage, &stored.expression) else {
        return Err(EffectError::Half(name()));
    };
    if setting.effects.find(&stored.name).is_some() {
        return Err(EffectError::Taken(name()));
    }
    if stored.parameters.is_empty() {
        return Err(EffectError::NoStrength(name()));
    }
    let names: Vec<&str> = stored.parameters.keys().map(String::as_str).collect();
    let expression = Expression::parse(text, &names)
        .map_err(|source| EffectError::Expression { effect: name(), source })?;
    let parameter = |(name, stored): (&String, &StoredParameter)| Parameter {
        name: name.clone().into(),
        unit: stored.unit.clone().into(),
        meaning: "".into(),
        lower: stored.lower.unwrap_or(f64::NEG_INFINITY),
        upper: stored.upper.unwrap_or(f64::INFINITY),
        bounded: true,
    };
    Ok(Applied {
        name: name(),
        law: "own".into(),
        stage,
        strengths: 1,
        each_trace: 0,
        parameters: stored.parameters.iter().map(parameter).collect(),
        act: Act::Own(Arc::new(expression)),
    })
}

/// The effects of a chain for a model file, with the values and standard errors of all parameters of
/// the chain.
#[must_use]
pub fn store(chain: &Chain, values: &[f64], standard_errors: &[Option<f64>]) -> Vec<StoredEffect> {
    let stored = |(index, effect): (usize, &Applied)| {
        let range = chain.range(index);
        let parameter = |(place, parameter): (usize, &Parameter)| {
            let mut stored =
                StoredParameter::fitted(parameter, values[place], standard_errors[place]);
            if matches!(effect.act, Act::Own(_)) {
                stored.lower = Some(parameter.lower).filter(|bound| bound.is_finite());
                stored.upper = Some(parameter.upper).filter(|bound| bound.is_finite());
            }
            (parameter.name.to_string(), stored)
        };
        let own = match &effect.act {
            Act::Own(expression) => Some(expression.text().to_owned()),
            _ => None,
        };
        StoredEffect {
            name: effect.name.clone(),
            law: own.is_none().then(|| effect.law.clone()),
            stage: own.is_some().then_some(effect.stage),
            expression: own,
            meaning: None,
            parameters: range.zip(&effect.parameters).map(parameter).collect(),
        }
    };
    chain.effects.iter().enumerate().map(stored).collect()
}
