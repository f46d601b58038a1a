//! The questions: each takes traces or a model and the options of the command, and answers while the interpreter is free.

use std::path::PathBuf;
use std::sync::Arc;

use palpate::cli::ask::{self, Asked, Course, Set};
use palpate::grasp::hand::Hand;
use palpate::model::{ForceProfile, Model as Inner};
use pyo3::prelude::*;

use crate::answer::Answer;
use crate::data::DataSet;
use crate::error::{failed, wrong};
use crate::model::Model;
use crate::parts::Parts;
use crate::work::work;

/// How progress is told.
type Tell<'py> = Option<Bound<'py, PyAny>>;

fn asked(
    py: Python<'_>,
    tell: Tell<'_>,
    question: impl FnOnce() -> Asked + Send + 'static,
) -> PyResult<Answer> {
    let found = work(py, tell.as_ref(), question)?.map_err(|failure| failed(&failure))?;
    Ok(Answer { found: found.into() })
}

fn set(data: &Bound<'_, DataSet>) -> Set {
    data.get().set.clone()
}

fn inner(model: &Bound<'_, Model>) -> Inner {
    model.get().inner.clone()
}

/// A question of a model beside traces.
fn of_model(
    py: Python<'_>,
    question: fn(Inner, Set, &[String]) -> Asked,
    model: &Bound<'_, Model>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    let (model, data) = (inner(model), set(data));
    asked(py, tell, move || question(model, data, &options))
}

#[pyfunction]
pub fn fit(
    py: Python<'_>,
    law: Option<String>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    let data = set(data);
    asked(py, tell, move || ask::fit(law.as_deref(), data, &options))
}

#[pyfunction]
pub fn compare(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    of_model(py, ask::compare, model, data, options, tell)
}

#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    of_model(py, ask::diagnose, model, data, options, tell)
}

#[pyfunction]
pub fn explore(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    of_model(py, ask::explore, model, data, options, tell)
}

#[pyfunction]
pub fn discover(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    of_model(py, ask::discover, model, data, options, tell)
}

#[pyfunction]
pub fn add(
    py: Python<'_>,
    effect: String,
    model: &Bound<'_, Model>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    let (model, data) = (inner(model), set(data));
    asked(py, tell, move || ask::add(&effect, &model, data, &options))
}

#[pyfunction]
pub fn drop(
    py: Python<'_>,
    effect: String,
    model: &Bound<'_, Model>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    let (model, data) = (inner(model), set(data));
    asked(py, tell, move || ask::drop(&effect, &model, data, &options))
}

#[pyfunction]
pub fn segment(py: Python<'_>, data: &Bound<'_, DataSet>, tell: Tell<'_>) -> PyResult<Answer> {
    let data = set(data);
    asked(py, tell, move || ask::segment(data))
}

#[pyfunction]
pub fn relaxation(
    py: Python<'_>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    let data = set(data);
    asked(py, tell, move || ask::relaxation(data, &options))
}

#[pyfunction]
pub fn plan(
    py: Python<'_>,
    model: Option<Bound<'_, Model>>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<Answer> {
    let model = model.as_ref().map(inner);
    asked(py, tell, move || ask::plan(model.as_ref(), &options))
}

/// The answer, and its parts as arrays.
#[pyfunction]
pub fn decompose(
    py: Python<'_>,
    model: Option<Bound<'_, Model>>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
    tell: Tell<'_>,
) -> PyResult<(Answer, Parts)> {
    let (model, data) = (model.as_ref().map(inner), set(data));
    let found = work(py, tell.as_ref(), move || ask::decompose(model.as_ref(), data, &options))?;
    let found = Arc::new(found.map_err(|failure| failed(&failure))?);
    Ok((Answer { found: found.clone() }, Parts { found }))
}

/// A simulated trace, and what is to be said of it.
type Simulated = (DataSet, Vec<String>);

fn simulated(
    py: Python<'_>,
    model: Inner,
    course: Course,
    name: String,
    options: Vec<String>,
) -> PyResult<Simulated> {
    let found = work(py, None, move || ask::simulate(&model, course, &name, &options))?;
    let found = found.map_err(|failure| failed(&failure))?;
    Ok((vec![found.trace].into(), found.remarks))
}

/// Over the motion of the first trace.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    motion: &Bound<'_, DataSet>,
    options: Vec<String>,
) -> PyResult<Simulated> {
    let trace = motion.get().trace(0)?.clone();
    let name = trace.label();
    simulated(py, inner(model), Course::Motion(trace.into()), name, options)
}

/// Over the motion of a trace or a profile that is read.
#[pyfunction]
pub fn simulate_file(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    path: PathBuf,
    options: Vec<String>,
) -> PyResult<Simulated> {
    let motion = ask::motion(&path).map_err(|failure| failed(&failure))?;
    let name = path.display().to_string();
    simulated(py, inner(model), Course::Motion(motion.into()), name, options)
}

/// Under a controlled force, by a profile that is read.
#[pyfunction]
pub fn simulate_force(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    path: PathBuf,
    options: Vec<String>,
) -> PyResult<Simulated> {
    let force = ForceProfile::read(&path).map_err(wrong)?;
    let name = path.display().to_string();
    simulated(py, inner(model), Course::Force(force), name, options)
}

#[pyfunction]
pub fn grasp_surface(py: Python<'_>, options: Vec<String>) -> PyResult<Answer> {
    asked(py, None, move || ask::grasp_surface(&options))
}

#[pyfunction]
pub fn grasp_growth(
    py: Python<'_>,
    model: Option<Bound<'_, Model>>,
    options: Vec<String>,
) -> PyResult<Answer> {
    let model = model.as_ref().map(inner);
    asked(py, None, move || ask::grasp_growth(model, &options))
}

#[pyfunction]
pub fn grasp_margin(
    py: Python<'_>,
    model: Option<Bound<'_, Model>>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
) -> PyResult<Answer> {
    let (model, data) = (model.as_ref().map(inner), set(data));
    asked(py, None, move || ask::grasp_margin(model.as_ref(), data, &options))
}

/// From the slide of the first trace.
#[pyfunction]
pub fn grasp_friction(
    py: Python<'_>,
    data: &Bound<'_, DataSet>,
    options: Vec<String>,
) -> PyResult<Answer> {
    let data = set(data);
    asked(py, None, move || ask::grasp_friction(&data[0], &options))
}

/// Of the hand in a file.
#[pyfunction]
pub fn grasp_plan(
    py: Python<'_>,
    hand: PathBuf,
    model: Option<Bound<'_, Model>>,
    options: Vec<String>,
) -> PyResult<Answer> {
    let model = model.as_ref().map(inner);
    let name = hand.display().to_string();
    let hand = Hand::read(&hand).map_err(wrong)?;
    asked(py, None, move || ask::grasp_plan(hand, name, model, &options))
}
