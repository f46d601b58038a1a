//! What of a model holds of a press that stands still.

use shared::adaptation;

use palpate_model::effects::find;
use palpate_model::{Model, Relaxation, Stage};
use palpate_report::number::{significant, typographic};

/// A law as far as it speaks of a signal without its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// How it relaxes.
    pub relaxation: Relaxation,
    /// Effects of the model that are not in it: they act on what is not known here.
    pub left_out: Vec<String>,
}

/// Why a model does not foretell a hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum LawError {
    #[error("{0}")]
    Model(String),
    #[error(
        "a hold of {law} is no sum of exponentials, so the signal alone does not determine how it goes on"
    )]
    Form { law: String },
    #[error("its effect `{0}` changes how it relaxes by what the gauges do not measure; drop it")]
    Effect(String),
}

impl Law {
    /// That of a model.
    ///
    /// # Errors
    /// [`LawError`] where its hold does not follow from the signal alone.
    pub fn of(model: &Model) -> Result<Self, LawError> {
        let (law, values) = model.law().map_err(LawError::Model)?;
        let relaxation =
            law.relaxation(&values).ok_or_else(|| LawError::Form { law: law.in_words() })?;
        let mut left_out = Vec::new();
        for effect in &model.effects {
            let stage = effect.stage.or_else(|| find(&effect.name).map(|effect| effect.stage));
            match stage {
                None => {
                    return Err(LawError::Model(format!("no effect is called `{}`", effect.name)));
                }
                Some(Stage::Relaxation) => return Err(LawError::Effect(effect.name.clone())),
                Some(_) => left_out.push(effect.name.clone()),
            }
        }
        Ok(Self { relaxation, left_out })
    }

    /// That of a device's filter.
    #[must_use]
    pub fn of_filter(filter: &adaptation::Relaxation) -> Self {
        let relaxation = Relaxation::new(&[filter.c1, filter.c2], &[filter.v1, filter.v2]);
        Self { relaxation, left_out: Vec::new() }
    }

    /// The relaxation function as a formula.
    #[must_use]
    pub fn formula(&self) -> String {
        let parts =
            self.relaxation.branches.iter().map(|branch| {
                format!(" + {} e^(−{} t)", digits(branch.share), digits(branch.rate))
            });
        format!("g(t) = {}{}", digits(self.relaxation.equilibrium()), parts.collect::<String>())
    }
}

fn digits(value: f64) -> String {
    typographic(&significant(value, 3))
}
