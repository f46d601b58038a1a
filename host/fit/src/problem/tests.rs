use super::Problem;
use super::slopes::smooth_jumps;
use crate::data::Data;
use crate::fold::Fold;
use crate::whitening::Whitening;
use crate::whole_motion::predict;
use palpate_model::effects::candidates;
use palpate_model::{BaseLaw, Chain, Separation};
use palpate_trace::{Column, DISPLACEMENT, FORCE, Trace};

#[test]
fn a_sample_that_a_step_moves_across_a_jump_follows_its_neighbours() {
    let smoothed = |mut differences: Vec<f64>| {
        smooth_jumps(&mut differences, 1e-4);
        differences
    };
    assert_eq!(smoothed(vec![1e-6, 0.02, 3e-6]), [1e-6, 2e-6, 3e-6]);
    assert_eq!(smoothed(vec![0.0, -0.02]), [0.0, 0.0]);
    for smooth in [vec![1e-3, 2e-3, 1e-3], vec![0.0, 9e-5, 0.0], vec![0.02, 0.02, 0.0]] {
        assert_eq!(smoothed(smooth.clone()), smooth);
    }
}

/// Two presses with holds, one after the other.
fn traces() -> Vec<Trace> {
    [3.0, 2.0]
        .into_iter()
        .enumerate()
        .map(|(trace, deep)| {
            let time: Vec<f64> = (0..240).map(|k| 0.025 * f64::from(k)).collect();
            let course = |t: &f64| (4.0 * t - 1.0).min(deep).min(20.0 - 4.0 * t);
            let x: Vec<f64> = time.iter().map(course).collect();
            let force = x.iter().map(|x: &f64| 0.3 * x.max(0.0).powf(1.5)).collect();
            let mut trace_of = Trace {
                time,
                columns: vec![
                    Column { name: DISPLACEMENT.into(), values: x },
                    Column { name: FORCE.into(), values: force },
                ],
                ..Trace::default()
            };
            trace_of.head.setup.start_s = Some(9.0 * trace as f64);
            trace_of
        })
        .collect()
}

#[test]
fn derivatives_beside_any_effect_are_those_of_the_whole_chain() {
    let traces = traces();
    let data = Data::of(&traces, FORCE).unwrap();
    let white = Whitening::none();
    let base = Chain::new(BaseLaw::fung(2, Separation::Clamp));
    let mut carried = 0;
    for candidate in candidates(&data.setting(), &[]).unwrap() {
        for form in candidate.forms.iter().filter(|_| candidate.missing.is_none()) {
            let chain = base.with(form.applied.clone());
            let problem = Problem::new(&chain, &data, &white, None);
            let strengths = std::iter::repeat_n(form.typical, form.applied.strengths);
            let shapes = form.grid[0].iter().copied();
            let point: Vec<f64> = [0.4, 0.3, 0.2, 0.6, 1.2, -0.7]
                .into_iter()
                .chain(strengths)
                .chain(shapes)
                .collect();
            carried += usize::from(problem.run_at(&point).carried.is_some());
            let at = |j: usize, step: f64| {
                let mut moved = point.clone();
                moved[j] += step;
                predict(&chain, &problem.declared(&moved), &data)
            };
            let steps = problem.steps(&point);
            let mut found: Vec<Vec<Vec<f64>>> = Vec::new();
            problem.derivatives(&point, |piece, residual, columns| {
                let index = found.len();
                let force: Vec<f64> =
                    residual.iter().zip(piece.measured).map(|(r, y)| r + y).collect();
                let expected = &at(0, 0.0)[index];
                assert!(distance(&force, expected) < 1e-11, "{}", form.applied.law);
                let mut all = vec![Vec::new(); point.len()];
                for (j, column) in columns {
                    all[j] = column;
                }
                found.push(all);
            });
            for j in 0..point.len() {
                let (here, there) = (at(j, 0.0), at(j, steps[j]));
                for (piece, columns) in found.iter().enumerate() {
                    // What belongs to another trace alone has no column.
                    if columns[j].is_empty() {
                        continue;
                    }
                    let slope: Vec<f64> = here[piece]
                        .iter()
                        .zip(&there[piece])
                        .map(|(a, b)| (b - a) / steps[j])
                        .collect();
                    let off = distance(&columns[j], &slope);
                    let size = slope.iter().map(|s| s * s).sum::<f64>().sqrt();
                    assert!(
                        off < 1e-3 * size + 1e-5,
                        "{} ({}) coordinate {j}: off by {off:.1e} of {size:.1e}",
                        candidate.name,
                        form.applied.law
                    );
                }
            }
        }
    }
    assert!(carried > 20, "{carried}");
}

#[test]
fn traces_left_out_have_the_same_errors_where_no_more_is_run() {
    let traces = traces();
    let data = Data::of(&traces, FORCE).unwrap();
    let white = Whitening::none();
    let chain = Chain::new(BaseLaw::fung(2, Separation::Clamp));
    let problem = Problem::new(&chain, &data, &white, None);
    let point = [0.4, 0.3, 0.2, 0.6, 1.2, -0.7];
    for trace in 0..2 {
        let others = problem.leaving_out(Fold::alone(trace));
        let all = others.apart(&point).1;
        let found = others.left_out_squares(&point);
        assert_eq!((found.len(), found[0].1), (1, all[0].samples));
        assert!((found[0].0 - all[0].square).abs() < 1e-12 * all[0].square);
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
