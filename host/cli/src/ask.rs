//! The commands as functions over data in memory, for programs that link the library: same options, same numbers, same
//! words where something is wrong. Nothing here prints, reads or writes a file.
//!
//! Options are given as on the command line, `["--terms", "auto"]`; those that name files do not exist here.

use std::sync::Arc;

use clap::Parser;
use clap::error::ErrorKind;

pub use super::answer::Answer;
pub use super::decompose::{Channels, Decomposed};
pub use super::simulate::{Course, Simulated, motion};
use super::{Failure, add, compare, decompose, diagnose, discover, drop, explore, fit, grasp};
use super::{hide, plan, relaxation, segment, simulate};
use palpate_contact::grasp::hand::Hand;
use palpate_diagnose::practice::Practice;
use palpate_model::Model;
use palpate_present::summary::NextCommand;
use palpate_trace::Trace;

/// Traces of one specimen in one set-up, in order of recording; never copied unless an option changes them.
pub type Set = Arc<Vec<Trace>>;

/// What a question gives.
pub type Asked = Result<Box<dyn Answer>, Failure>;

/// `palpate fit`: the law of that name, or every law, `--all`, without one.
///
/// # Errors
/// As the command.
pub fn fit(law: Option<&str>, traces: Set, options: &[String]) -> Asked {
    let all = law.is_none().then(|| "--all".to_owned());
    let options: Vec<String> = options.iter().cloned().chain(all).collect();
    fit::ask(&parsed(&options)?, law, traces)
}

/// `palpate compare`.
///
/// # Errors
/// As the command.
pub fn compare(model: Model, traces: Set, options: &[String]) -> Asked {
    compare::ask(&parsed(options)?, model, traces)
}

/// `palpate diagnose`.
///
/// # Errors
/// As the command.
pub fn diagnose(model: Model, traces: Set, options: &[String]) -> Asked {
    diagnose::ask(&parsed(options)?, model, traces, next())
}

/// `palpate explore`; the answer has the model.
///
/// # Errors
/// As the command.
pub fn explore(model: Model, traces: Set, options: &[String]) -> Asked {
    explore::ask(&parsed(options)?, model, traces, next())
}

/// `palpate discover`; the answer has the model, with the formulas as candidates.
///
/// # Errors
/// As the command.
pub fn discover(model: Model, traces: Set, options: &[String]) -> Asked {
    discover::ask(&parsed(options)?, model, traces, next())
}

/// `palpate add`; the answer has the model.
///
/// # Errors
/// As the command.
pub fn add(effect: &str, model: &Model, traces: Set, options: &[String]) -> Asked {
    add::ask(&parsed(options)?, effect, model, traces)
}

/// `palpate drop`; the answer has the model.
///
/// # Errors
/// As the command.
pub fn drop(effect: &str, model: &Model, traces: Set, options: &[String]) -> Asked {
    drop::ask(&parsed(options)?, effect, model, traces)
}

/// `palpate decompose`, with the relaxation function of a model, or with that of eq. 3.6 without one.
///
/// # Errors
/// As the command.
pub fn decompose(
    model: Option<&Model>,
    traces: Set,
    options: &[String],
) -> Result<Decomposed, Failure> {
    decompose::ask(&parsed(options)?, model, traces)
}

/// `palpate segment`.
///
/// # Errors
/// As the command.
pub fn segment(traces: Set) -> Asked {
    segment::ask(traces)
}

/// `palpate relaxation`.
///
/// # Errors
/// As the command.
pub fn relaxation(traces: Set, options: &[String]) -> Asked {
    relaxation::ask(&parsed(options)?, traces)
}

/// `palpate simulate` over a course of that name.
///
/// # Errors
/// As the command.
pub fn simulate(
    model: &Model,
    course: Course,
    name: &str,
    options: &[String],
) -> Result<Simulated, Failure> {
    simulate::ask(&parsed(options)?, model, course, name)
}

/// `palpate plan`, with the relaxation function of a model where one is given.
///
/// # Errors
/// As the command.
pub fn plan(model: Option<&Model>, options: &[String]) -> Asked {
    plan::ask(&parsed(options)?, model)
}

/// `palpate hide`, without a folder.
///
/// # Errors
/// As the command.
pub fn hide(options: &[String]) -> Result<Practice, Failure> {
    hide::ask(&parsed(options)?)
}

/// `palpate grasp surface`.
///
/// # Errors
/// As the command.
pub fn grasp_surface(options: &[String]) -> Asked {
    grasp::surface::ask(&parsed(options)?)
}

/// `palpate grasp growth`, by a model or by shares and rates.
///
/// # Errors
/// As the command.
pub fn grasp_growth(model: Option<Model>, options: &[String]) -> Asked {
    grasp::growth::ask(&parsed(options)?, model.map(named))
}

/// `palpate grasp margin`; with a model also the margin once settled.
///
/// # Errors
/// As the command.
pub fn grasp_margin(model: Option<&Model>, traces: Set, options: &[String]) -> Asked {
    grasp::margin::ask(&parsed(options)?, model, traces)
}

/// `palpate grasp friction`.
///
/// # Errors
/// As the command.
pub fn grasp_friction(trace: &Trace, options: &[String]) -> Asked {
    grasp::friction::ask(&parsed(options)?, trace)
}

/// `palpate grasp plan` of a hand of that name; the model is of the fingers that name none.
///
/// # Errors
/// As the command.
pub fn grasp_plan(hand: Hand, name: String, model: Option<Model>, options: &[String]) -> Asked {
    grasp::plan::ask(&parsed(options)?, hand, model.map(named), name)
}

/// A model as a file would be called.
fn named(model: Model) -> (Model, String) {
    (model, "model.toml".into())
}

/// The options of one command alone.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Alone<O: clap::Args> {
    #[command(flatten)]
    options: O,
}

/// What options mean.
fn parsed<O: clap::Args>(options: &[String]) -> Result<O, Failure> {
    let alone = Alone::try_parse_from(options).map_err(|error| refused(&error))?;
    Ok(alone.options)
}

/// What is wrong with options, without how the command would be called.
pub(super) fn refused(error: &clap::Error) -> Failure {
    let text = error.render().to_string();
    let what = text.split("\n\n").next().unwrap_or_default();
    let what = what.strip_prefix("error: ").unwrap_or(what).trim().replace("\n  ", " ");
    match error.kind() {
        ErrorKind::UnknownArgument => Failure::Input(miette::miette!("no such option: {what}")),
        _ => Failure::Input(miette::miette!("{what}")),
    }
}

/// What commands would call model and traces.
fn next() -> NextCommand {
    NextCommand { model: "model.toml".into(), traces: "traces/".into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_trace::read_set;

    fn press() -> Set {
        let top = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        Arc::new(read_set(&[top.join("../../tests/traces/press.csv")]).unwrap())
    }

    fn words(options: &[&str]) -> Vec<String> {
        options.iter().map(|&word| word.into()).collect()
    }

    fn refused<T>(outcome: Result<T, Failure>) -> String {
        outcome.err().expect("it is refused").words()
    }

    #[test]
    fn options_mean_what_they_mean_on_the_command_line() {
        let found = fit(Some("fung"), press(), &words(&["--terms", "1"])).unwrap();
        assert_eq!(found.json()["terms"], 1);
        assert!(found.model().unwrap().is_some());
        let wrong = refused(fit(Some("fung"), press(), &words(&["--terms", "9"])));
        assert!(wrong.contains("'9'") && wrong.contains("1 to 4, or auto"), "{wrong}");
        let wrong = refused(fit(Some("fung"), press(), &words(&["--term", "2"])));
        assert!(wrong.contains("no such option") && wrong.contains("--term"), "{wrong}");
        let wrong = refused(fit(Some("fang"), press(), &[]));
        assert!(wrong.contains("no law `fang`"), "{wrong}");
        let wrong = refused(fit(None, press(), &words(&["--segments", "3"])));
        assert!(wrong.contains("--all") && wrong.contains("--segments"), "{wrong}");
    }

    #[test]
    fn traces_are_shared_unless_an_option_changes_them() {
        let traces = press();
        let found = fit(Some("fung"), traces.clone(), &[]).unwrap();
        assert_eq!(Arc::strong_count(&traces), 2);
        let tared = fit(Some("fung"), traces.clone(), &words(&["--tare"])).unwrap();
        assert_eq!(Arc::strong_count(&traces), 2);
        assert_ne!(found.json()["tared"], tared.json()["tared"]);
    }

    #[test]
    fn a_simulated_trace_names_its_course() {
        let traces = press();
        let model = fit(Some("fung"), traces.clone(), &[]).unwrap().model().unwrap().unwrap();
        let course = Course::Motion(traces[0].clone().into());
        let found = simulate(&model, course, "a press", &[]).unwrap();
        assert_eq!(found.trace.head.name.as_deref(), Some("simulated over a press"));
        assert_eq!(found.trace.len(), traces[0].len());
    }
}
