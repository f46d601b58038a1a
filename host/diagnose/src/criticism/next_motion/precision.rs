//! The motion after which wanted parameters are known best: of least variance for one (c-optimal), of the least determinant of their
//! covariance for several (D-optimal), beside what the recordings at hand say already (Atkinson, Donev and Tobias 2007).

use nalgebra::DMatrix;

use super::{Aim, BEFORE, Best, Rig, RigFile, best_motion};
use crate::criticism::diagnose::Diagnosis;
use crate::criticism::fitted::Fitted;
use crate::criticism::separation::Rivals;
use palpate_fit::data::{Data, DataError};
use palpate_fit::problem::Problem;
use palpate_fit::uncertainty;
use palpate_fit::whitening::Whitening;
use palpate_fit::whole_motion::declared_uncertainty;
use palpate_model::{Chain, Model};
use palpate_trace::{Trace, block_means};

/// How well a wanted parameter is known, before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct Precision {
    /// Its name, with the effect that it is of.
    pub name: String,
    /// Its value, in its unit.
    pub value: f64,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Standard error from the recordings at hand; none where they do not determine it.
    pub now: Option<f64>,
    /// Standard error that is foreseen once the motion is recorded too.
    pub then: Option<f64>,
    /// The same with the best motion of the menu; none also where none of the menu lies within the limits.
    pub of_menu: Option<f64>,
}

/// A motion for wanted parameters.
#[derive(Clone, Debug)]
pub struct Informing {
    /// The parameters, as they were asked for.
    pub parameters: Vec<Precision>,
    /// What the rig may do.
    pub rig: Rig,
    /// The recording as it is to be made, without its signal.
    pub trace: Trace,
    /// The signal that the model predicts for it.
    pub predicted: Vec<f64>,
    /// Motions that were weighed.
    pub weighed: usize,
}

/// Why no motion is proposed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum InformingError {
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("the model has no free parameter `{name}`; it has {known}")]
    Unknown { name: String, known: String },
    #[error("no motion lies within the limits of the rig")]
    Limits,
}

/// Every parameter of a model.
const ALL: &str = "all";

/// The motion after which the parameters of these names are known best, in the last model of a diagnosis; `all` is all.
///
/// # Errors
/// When the traces are not usable, a name is that of no free parameter, or no motion lies within the limits.
pub fn inform(
    model: &Model,
    diagnosis: &Diagnosis,
    traces: &[Trace],
    limits: &RigFile,
    wanted: &[String],
) -> Result<Informing, InformingError> {
    let means = block_means(traces);
    let scales = Data::of_model(model, traces)?.scales();
    let rig = limits.beside(&scales);
    let searched = means.as_deref().unwrap_or(traces);
    let data = Data::of_model(model, searched)?;
    let of_rows = Whitening::new(diagnosis.noise.level, &[], 0.0, 1);
    let white = Whitening::none();
    let member = diagnosis.found.model();
    let names = names(&member.chain);
    let aim = Wanted {
        member,
        rivals: Rivals {
            members: &[member],
            signal: &diagnosis.signal,
            reference_temperature: data.reference_temperature,
            traces: searched,
            whitening: if means.is_some() { &of_rows } else { &diagnosis.noise.whitening },
        },
        problem: &Problem::new(&member.chain, &data, &white, None),
        places: places(wanted, &names, member)?,
    };
    let now = aim.errors(&aim.member.curvature()).0;
    let Best { trace, foreseen, of_menu, weighed } =
        best_motion(&aim, &scales, &rig).ok_or(InformingError::Limits)?;
    let parameter = |(k, place): (usize, &usize)| Precision {
        name: names[*place].0.clone(),
        unit: names[*place].1.clone(),
        value: member.values[*place],
        now: now[k],
        then: foreseen.errors[k],
        of_menu: of_menu.as_ref().and_then(|it| it.errors[k]),
    };
    let parameters = aim.places.iter().enumerate().map(parameter).collect();
    Ok(Informing { parameters, rig, trace, predicted: foreseen.predicted, weighed })
}

/// Names and units of all parameters of a chain, in order.
fn names(chain: &Chain) -> Vec<(String, String)> {
    let base = chain.base.parameters().into_iter();
    let own = base.map(|it| (it.name.to_string(), it.unit.to_string()));
    let effects = chain.effects.iter().flat_map(|effect| {
        let name = |it: &palpate_model::Parameter| {
            (format!("{}: {}", effect.name, it.name), it.unit.to_string())
        };
        effect.parameters.iter().map(name)
    });
    own.chain(effects).collect()
}

/// Where the wanted parameters stand; an effect's also without the effect, where that is enough.
fn places(
    wanted: &[String],
    names: &[(String, String)],
    member: &Fitted,
) -> Result<Vec<usize>, InformingError> {
    let held = member.held();
    let free: Vec<usize> = (0..names.len()).filter(|&place| !held[place]).collect();
    if wanted.iter().any(|name| name == ALL) {
        return Ok(free);
    }
    let is = |place: &usize, name: &str| {
        let known = &names[*place].0;
        known == name || known.rsplit(": ").next() == Some(name)
    };
    let place = |name: &String| {
        free.iter().copied().find(|place| is(place, name)).ok_or_else(|| {
            let known: Vec<&str> = free.iter().map(|&place| names[place].0.as_str()).collect();
            InformingError::Unknown { name: name.clone(), known: known.join(", ") }
        })
    };
    wanted.iter().map(place).collect()
}

/// Parameters of a model that are wanted.
struct Wanted<'a> {
    member: &'a Fitted,
    rivals: Rivals<'a>,
    problem: &'a Problem<'a>,
    /// Their places among all.
    places: Vec<usize>,
}

/// What a recording would tell.
struct Known {
    predicted: Vec<f64>,
    errors: Vec<Option<f64>>,
    /// Minus half the logarithm of the determinant of the covariance.
    worth: f64,
}

/// What a parameter that is not determined takes off the worth of a motion: more than any precision can give.
const UNDETERMINED: f64 = 1e3;

impl Wanted<'_> {
    /// Standard errors of the wanted parameters at a curvature, and what that is worth.
    fn errors(&self, curvature: &DMatrix<f64>) -> (Vec<Option<f64>>, f64) {
        let known = uncertainty(curvature, &self.member.held(), self.member.variance());
        let (errors, correlation) = declared_uncertainty(self.problem, &self.member.point, &known);
        let errors: Vec<Option<f64>> = self.places.iter().map(|&place| errors[place]).collect();
        let told: Vec<(usize, f64)> = self
            .places
            .iter()
            .zip(&errors)
            .filter_map(|(it, error)| Some((*it, (*error)?)))
            .collect();
        let block =
            DMatrix::from_fn(told.len(), told.len(), |i, j| correlation[(told[i].0, told[j].0)]);
        let together = block.symmetric_eigenvalues().iter().map(|v| v.max(1e-12).ln()).sum::<f64>();
        let alone = told.iter().map(|(_, error)| error.ln()).sum::<f64>();
        let lacking = (errors.len() - told.len()) as f64;
        (errors, -alone - 0.5 * together - UNDETERMINED * lacking)
    }
}

impl Aim for Wanted<'_> {
    type Foreseen = Known;

    fn trace(&self, time: Vec<f64>, displacement: Vec<f64>) -> Trace {
        self.rivals.trace(time, displacement, BEFORE)
    }

    fn foresee(&self, trace: Trace) -> Option<Known> {
        let (predicted, curvature) = self.rivals.curvature_with(trace)?;
        let (errors, worth) = self.errors(&curvature);
        Some(Known { predicted, errors, worth })
    }

    fn worth(foreseen: &Known) -> f64 {
        foreseen.worth
    }

    fn largest_signal(foreseen: &Known) -> f64 {
        foreseen.predicted.iter().fold(0.0, |most: f64, y| most.max(y.abs()))
    }
}
