//! What a diagnosis costs: as the information in the traces, not as their rows; counted in samples that a model predicts, so that
//! the machine does not matter.

use std::sync::Arc;

use palpate::criticism::diagnose::diagnose;
use palpate::criticism::fitted::Fitted;
use palpate::criticism::held_out::held_out;
use palpate::effects::candidates;
use palpate::fit::data::Data;
use palpate::fit::least_squares::Effort;
use palpate::fit::problem::Problem;
use palpate::fit::watch::{Watch, under};
use palpate::fit::whitening::Whitening;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Model, Separation};
use palpate::trace::{DISPLACEMENT, FORCE, Trace};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);
/// Largest exponent of the cost in rows.
const EXPONENT: f64 = 1.05;

/// Presses with a hold of ten seconds each at a rate, Hz: a law, a drag that it lacks, and white noise.
fn presses(traces: usize, rate: f64) -> Vec<Trace> {
    let normal = Normal::new(0.0, 0.01).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let press = |k: usize| {
        let deep = 3.0 + (k % 5) as f64;
        let speed = 4.0 + 3.0 * (k % 4) as f64;
        let time: Vec<f64> = (0..(10.0 * rate) as usize).map(|k| k as f64 / rate).collect();
        let course = |t: &f64| (speed * (t - 1.0)).min(deep).min(deep - speed * (t - 7.0));
        let x: Vec<f64> = time.iter().map(|t| course(t).max(-0.5)).collect();
        let (mut states, mut before) = ([0.0f64; 2], 0.0);
        let mut last = x[0];
        let force = x.iter().map(|&x| {
            let elastic = 0.2 * x.max(0.0).powf(1.7);
            for (state, rate_of) in states.iter_mut().zip([4.0, 0.5]) {
                *state = *state * (-rate_of / rate).exp() + elastic - before;
            }
            before = elastic;
            let drag = if x > 0.0 { 0.02 * (x - last) * rate } else { 0.0 };
            last = x;
            let relaxed = 0.5 * elastic + 0.25 * (states[0] + states[1]);
            relaxed.max(0.0) + drag + normal.sample(&mut random)
        });
        let force: Vec<f64> = force.collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    };
    (0..traces).map(press).collect()
}

/// Samples that are predicted to diagnose a set.
fn cost_of_diagnosis(traces: &[Trace]) -> f64 {
    let base = fit(LAW, &Data::of(traces, FORCE).unwrap()).unwrap();
    let model = Model::of(&LAW, FORCE, &base.values, &base.standard_errors);
    let seen = Arc::new(Watch::default());
    let diagnosis = under(&seen, || diagnose(&model, traces).unwrap()).unwrap();
    assert!(!diagnosis.found.steps.is_empty(), "the drag is found");
    seen.evaluations() as f64
}

#[test]
fn a_diagnosis_costs_hardly_more_at_a_higher_rate() {
    let (slow, fast) = (presses(6, 200.0), presses(6, 3200.0));
    let (slow, fast) = (cost_of_diagnosis(&slow), cost_of_diagnosis(&fast));
    let ratio = fast / slow;
    let said = format!("{fast} for {slow} evaluations, {ratio} times, for 16 times the rows");
    assert!(ratio < 16f64.powf(EXPONENT), "{said}");
    // Most is done on means, whose number follows the motion.
    assert!(ratio < 4.0, "{said}");
}

/// Samples that are predicted to leave traces out of a model in which each has a zero of its own.
fn cost_of_leaving_out(traces: usize) -> f64 {
    let traces = presses(traces, 20.0);
    let data = Data::of(&traces, FORCE).unwrap();
    let base = fit(LAW, &data).unwrap();
    let mut library = candidates(&data.setting(), &[]).unwrap().into_iter();
    let zeros = library.find(|candidate| candidate.name == "zero-shift").unwrap();
    let chain = base.chain.with(zeros.forms[0].applied.clone());
    let mut values = base.values.clone();
    values.resize(chain.parameters().len(), 0.0);
    let white = Whitening::none();
    let problem = Problem::new(&chain, &data, &white, None);
    let fitted = Fitted::new(&problem, &problem.point(&values), Effort::QUICK);
    let seen = Arc::new(Watch::default());
    let held_out = under(&seen, || held_out(&problem, &fitted)).unwrap().unwrap();
    assert_eq!(held_out.squares.len(), traces.len(), "each trace has its error");
    assert!(held_out.rms > fitted.rms());
    seen.evaluations() as f64
}

#[test]
fn leaving_out_each_of_many_traces_costs_hardly_more_than_each_of_few() {
    let ratio = cost_of_leaving_out(104) / cost_of_leaving_out(13);
    assert!(ratio < 8f64.powf(EXPONENT), "{ratio} times the evaluations for 8 times the traces");
}
