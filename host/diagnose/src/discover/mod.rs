//! A formula for what no effect of the library explains.
//!
//! - [`reach`]: the quantities that a term may depend on.
//! - [`shape`]: how; `curves`: in any shape. `place`: where in the chain. [`grammar`]: every combination.
//! - `blocks`: the means on which the search goes. `climb`: the search over all terms; `simplify`: from a free curve to laws near it;
//!   `vary`: from a law to one that changes with a second quantity.
//! - [`formula`]: a term that was found, with the evidence for it.
//! - [`surface`]: what the residual depends on without any law: one quantity, or two together.
//! - [`causes`]: what such a term can come from.

mod blocks;
pub mod causes;
mod climb;
mod curves;
pub mod formula;
pub mod grammar;
mod place;
pub mod reach;
pub mod shape;
mod simplify;
pub mod surface;
mod vary;

use self::climb::{Climb, Climbed};
use self::formula::{Formula, formulas};
use self::grammar::{Grammar, Term};
use self::reach::{QUANTITIES, Reach};
use self::surface::{Surface, surfaces};
use crate::criticism::adequacy::{LEVEL, adequacy};
use crate::criticism::dependence::{Dependence, dependences};
use crate::criticism::diagnose::{DiagnoseError, Diagnosis, Verdict, diagnose};
use crate::criticism::evidence::Refused;
use crate::criticism::explore::explored;
use crate::criticism::fitted::Fitted;
use crate::criticism::outside::Outside;
use crate::criticism::residuals::Residuals;
use crate::criticism::search::{Found, Search};
use palpate_fit::data::Data;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::Candidate;
use palpate_model::{Model, Rung};
use palpate_trace::{Trace, block_means};

/// What was looked for, and what came of it.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// What the library says.
    pub diagnosis: Diagnosis,
    /// What came of it.
    pub outcome: Outcome,
    /// How the residual of the model without formula depends on each quantity, the strongest first.
    pub dependences: Vec<Dependence>,
    /// How it depends on pairs of them, those that predict traces left out best first.
    pub surfaces: Vec<Surface>,
    /// The model without formula, and with each formula: names, errors of the fit and on traces left out.
    pub ladder: Vec<Rung>,
    /// The model with all formulas.
    pub model: Fitted,
    /// Standard errors of its parameters.
    pub standard_errors: Vec<Option<f64>>,
    /// What was tried last and refused.
    pub refused: Vec<Refused>,
    /// Terms of the grammar that these traces can show.
    pub terms: usize,
    /// Whether the formulas stand beside effects of the library that the diagnosis kept.
    pub beside_library: bool,
}

/// What came of a search for a formula.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// Only noise is left: there is nothing to find a formula for.
    Adequate,
    /// The library explains it.
    Library,
    /// Formulas, the strongest first; beside effects of the library where it has a name for most of what is missing.
    Formulas(Vec<Formula>),
    /// No term of the grammar predicts traces left out.
    Nothing,
}

/// Looks for formulas of what a model lacks on a data set and the library does not explain.
///
/// # Errors
/// When the model or the traces are not usable.
pub fn discover(
    model: &Model,
    traces: &[Trace],
    signal_unit: &str,
) -> Result<Discovery, DiagnoseError> {
    let diagnosis = diagnose(model, traces)?;
    let all = Data::of_model(model, traces)?;
    let base = diagnosis.found.base.clone();
    let whitening = diagnosis.noise.whitening.clone();
    let chain = base.chain.clone();
    let whole = Problem::new(&chain, &all, &whitening, None);
    let (swing, vibration) = match &diagnosis.outside {
        Some(Outside::Swing(swing)) => (Some(1.0 / swing.frequency_hz), None),
        Some(Outside::Vibration(it)) => (None, Some(1.0 / it.frequency_hz)),
        _ => (None, None),
    };
    // A mean over more than a period of a swing shows nothing of it.
    let shown = swing.is_none() && vibration.is_none();
    let blocks = if shown { blocks::of(&whole, &base, &diagnosis.noise) } else { None };
    // Without them a long recording is searched on means of its rests alone.
    let at_rest = if blocks.is_none() { block_means(traces) } else { None };
    let thinned = at_rest.as_deref().map(|traces| Data::of_model(model, traces)).transpose()?;
    let samples =
        thinned.as_ref().map_or(whole, |data| Problem::new(&chain, data, &whitening, None));
    let data = samples.data();
    let few = blocks.as_ref().map(|blocks| blocks.data(data));
    let searched = few.as_ref().unwrap_or(data);
    let white = Whitening::none();
    let rows = few.is_some().then(|| Problem::new(&chain, data, &white, None));
    let problem = match blocks.as_ref().zip(few.as_ref()) {
        Some((blocks, few)) => samples.on_weighted_means(blocks, few),
        None => samples.with_chain(&chain),
    };
    let left = Residuals::new(&chain, &base.values, data);
    let (dependences, surfaces) = (dependences(&left), surfaces(&left));
    let mut discovery = Discovery {
        outcome: match diagnosis.verdict {
            Verdict::Adequate => Outcome::Adequate,
            Verdict::Named | Verdict::Ambiguous => Outcome::Library,
            Verdict::Unknown => Outcome::Nothing,
        },
        dependences,
        surfaces,
        ladder: Vec::new(),
        standard_errors: diagnosis.standard_errors.clone(),
        model: diagnosis.found.model().clone(),
        refused: Vec::new(),
        terms: 0,
        beside_library: false,
        diagnosis,
    };
    let known = discovery.diagnosis.verdict != Verdict::Unknown;
    let library = &discovery.diagnosis.found;
    let last = samples.with_chain(&library.model().chain);
    let rest = adequacy(&last, &library.model().point, &whitening);
    if known && (library.steps.is_empty() || rest.p_value >= LEVEL) {
        return Ok(discovery);
    }
    let residuals = left.values();
    let reach = |quantity| Reach::of(quantity, data, &left.predicted, &residuals);
    let mut reaches: Vec<Option<Reach>> = QUANTITIES.iter().map(reach).collect();
    for (quantity, reach) in QUANTITIES.iter().zip(&mut reaches) {
        let Some(reach) = reach else { continue };
        match quantity.symbol {
            CLOCK => reach.periods.extend(swing.or(vibration)),
            // A vibration that sets in with the recording has the same phase in each.
            TIME => reach.periods.extend(vibration),
            _ => (),
        }
    }
    let grammar = Grammar::new(&reaches, signal_unit);
    let candidates: Vec<Candidate> =
        grammar.terms.iter().map(|term| term.candidate.clone()).collect();
    let search = Search {
        data: searched,
        candidates: &candidates,
        whitening: &whitening,
        problem: &problem,
        samples: &samples,
        options: &discovery.diagnosis.options,
        rows: rows.as_ref(),
    };
    let powers = vary::quantities(reach);
    let climb = Climb { search: &search, grammar: &grammar, powers: &powers };
    let Climbed { found, varied } = match known {
        // The library has the name; what it leaves may have a formula.
        true => climb.from(library.model()),
        false => best_climb(&climb, library, discovery.diagnosis.noise.level),
    };
    if known && found.steps.is_empty() {
        return Ok(discovery);
    }
    let terms = [&grammar.terms[..], &varied].concat();
    discovery.terms = grammar.terms.len();
    discovery.take(&found, &terms, &problem, searched);
    Ok(discovery)
}

/// The quantity in which a swing through all traces is a wave.
const CLOCK: &str = "t_set";

/// The time in a trace.
const TIME: &str = "t";

/// Error on traces left out, in noises, from which on nothing can predict much better.
const CLOSE: f64 = 1.05;
/// Part of what the library leaves beyond the noise, as mean squares, below which a formula alone leaves little.
const LITTLE: f64 = 0.1;

/// The climb from the model without effects; or from what the library explains of it, where that predicts traces left out better by
/// more than its uncertainty over the traces: an effect of the library that was named for want of a better one is no part of a formula.
fn best_climb(climb: &Climb, library: &Found, noise: f64) -> Climbed {
    let alone = climb.from(&library.base);
    let last_left_out = |it: &Found| it.evidence.last().and_then(|it| it.left_out().cloned());
    let left_out = |it: &Climbed| last_left_out(&it.found);
    let beyond_noise = |rms: f64| rms * rms - noise * noise;
    let close = left_out(&alone).is_some_and(|alone| {
        let of_library = last_left_out(library).map_or(0.0, |it| LITTLE * beyond_noise(it.rms));
        alone.rms <= CLOSE * noise || beyond_noise(alone.rms) <= of_library
    });
    if library.steps.is_empty() || close || climb.search.leaves_noise(alone.found.model()) {
        return alone;
    }
    let beside = climb.from(library.model());
    let better = match (left_out(&beside), left_out(&alone)) {
        (Some(beside), Some(alone)) => beside.gain(&alone).exceeds(1.0),
        _ => false,
    };
    let first = alone.found.steps.is_empty();
    if !beside.found.steps.is_empty() && (first || better) { beside } else { alone }
}

impl Discovery {
    /// The model with the formulas as candidates, and with the effects of the library beside which they stand.
    #[must_use]
    pub fn with_candidates(&self, model: &Model, data: &Data, unit: &str) -> Model {
        let Outcome::Formulas(formulas) = &self.outcome else { return model.clone() };
        let mut with = match self.beside_library {
            true => explored(model, &self.diagnosis, data, unit),
            false => model.clone(),
        };
        for Formula { law, .. } in formulas {
            with.candidates.retain(|candidate| candidate.name != law.name);
            with.candidates.push(law.clone());
        }
        with
    }

    fn take(&mut self, found: &Found, terms: &[Term], problem: &Problem, data: &Data) {
        let given = self.diagnosis.found.base.chain.effects.len();
        self.beside_library = found.base.chain.effects.len() > given;
        self.refused.clone_from(&found.refused);
        let held_out = |index: usize| found.evidence.get(index)?.left_out().map(|it| it.rms);
        let rung = |add: &str, index: usize, fitted: &Fitted| Rung {
            add: add.into(),
            fitted_rms: fitted.rms(),
            heldout_rms: held_out(index),
        };
        let base = &found.base;
        let own = base.chain.effects.last().map_or(base.chain.base.name(), |effect| &effect.name);
        self.ladder = vec![rung(own, 0, base)];
        if found.steps.is_empty() {
            return;
        }
        let formulas = formulas(found, terms, problem, data, &self.diagnosis);
        for (index, (formula, fitted)) in formulas.iter().zip(&found.models).enumerate() {
            self.ladder.push(rung(&formula.name, index + 1, fitted));
        }
        self.model = found.model().clone();
        let last = problem.with_chain(&self.model.chain);
        self.standard_errors = self.model.standard_errors(&last, true);
        self.outcome = Outcome::Formulas(formulas);
    }
}
