//! Where to begin a base law anew beside effects: while it was alone it may have taken on what is theirs, and from there no search leads
//! back.

use palpate_model::Chain;

use super::problem::Problem;
use super::start::{Wanted, starts};

/// Points of the problem's chain to search from: its effects as they are at a point, and the base law where a fit of it alone begins to
/// what they leave of the signal.
#[must_use]
pub fn base_anew(problem: &Problem, point: &[f64]) -> Vec<Vec<f64>> {
    let base = Chain::new(problem.chain.base);
    let alone = problem.with_chain(&base);
    let (of_base, of_effects) = point.split_at(base.base.count());
    let parts = problem.predict(point).into_iter().zip(alone.predict(of_base));
    let left: Vec<Vec<f64>> = parts
        .zip(&problem.data().pieces)
        .map(|((all, base), piece)| {
            let own = all.iter().zip(&base).map(|(all, base)| all - base);
            piece.measured.iter().zip(own).map(|(measured, own)| measured - own).collect()
        })
        .collect();
    let data = problem.data().with_measured(&left);
    let starts = starts(&base.base, &data, &[], Wanted::Likely);
    starts.iter().map(|start| [&alone.point(start), of_effects].concat()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Data;
    use crate::least_squares::{Effort, minimise_with};
    use crate::whitening::Whitening;
    use crate::whole_motion::predict;
    use palpate_model::effects::candidates;
    use palpate_model::{BaseLaw, Separation};
    use palpate_trace::{Column, DISPLACEMENT, FORCE, Trace};

    #[test]
    fn a_base_law_that_took_on_a_damper_gives_it_back() {
        let press = |(deep, speed): (f64, f64)| {
            let time: Vec<f64> = (0..1200).map(|k| 0.005 * f64::from(k)).collect();
            let at =
                |t: &f64| (speed * (t - 0.5)).min(deep).min(deep - speed * (t - 4.0)).max(-1.0);
            let column = |name: &str, values| Column { name: name.into(), values };
            let x: Vec<f64> = time.iter().map(at).collect();
            let pressed = x.iter().map(|x| x.max(0.0)).collect();
            let columns = vec![column(DISPLACEMENT, x), column(FORCE, pressed)];
            Trace { time, columns, ..Trace::default() }
        };
        let traces = [(4.0, 5.0), (8.0, 10.0), (8.0, 20.0), (12.0, 20.0)].map(press);
        let data = Data::of(&traces, FORCE).expect("a data set");
        let found = candidates(&data.setting(), &[]).expect("a library");
        let drag = found.iter().find(|it| it.name == "viscous-drag").expect("a damper");
        let law = BaseLaw::fung(2, Separation::Clamp);
        let chain = Chain::new(law).with(drag.forms[0].applied.clone());
        let force = predict(&chain, &[0.2, 0.66, 0.31, 0.16, 4.4, 0.4, 0.043], &data);
        let data = data.with_measured(&force);
        let white = Whitening::none();
        let problem = Problem::new(&chain, &data, &white, None);
        // As the law alone is fitted: a rate of 300/s stands for the damper.
        let absorbed = problem.point(&[1.1, 0.66, 0.85, 0.05, 305.0, 1.2, 0.0]);
        let from = |start: &[f64]| minimise_with(&problem, start, Effort::QUICK);
        let stuck = from(&absorbed);
        let anew = base_anew(&problem, &stuck.point);
        let costs = anew.iter().map(|start| from(start).normal.cost);
        let least = costs.fold(f64::INFINITY, f64::min);
        assert!(least < 1e-3 * stuck.normal.cost, "{least} for {}", stuck.normal.cost);
    }
}
