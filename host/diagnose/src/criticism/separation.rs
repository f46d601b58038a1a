//! How far a recording that nobody has made yet would set the members of a credible set apart (T-optimality, Atkinson and
//! Fedorov 1975): the least misfit that a wrong member would leave in it, after it was refitted.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::fitted::Fitted;
use palpate_fit::data::Data;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;
use palpate_model::Chain;
use palpate_trace::{Column, DISPLACEMENT, TEMPERATURE, Trace};

/// Sum of squares over the noise below which a recording does not tell members apart.
pub const TELLS: f64 = 10.0;

/// Sum of squares over the noise above which two members are told apart for sure.
const SURE: f64 = 500.0;

/// Members of a credible set beside what they were fitted to.
#[derive(Clone, Copy, Debug)]
pub struct Rivals<'a> {
    /// The models, the best first.
    pub members: &'a [&'a Fitted],
    /// The signal that they predict.
    pub signal: &'a str,
    /// Temperature from which effects count it, °C.
    pub reference_temperature: Option<f64>,
    /// The traces that they were fitted to.
    pub traces: &'a [Trace],
    /// The noise, at the rate of the recording.
    pub whitening: &'a Whitening,
}

/// What the members say of a recording.
#[derive(Clone, Debug)]
pub struct Foreseen {
    /// For every two members, the predicted misfit, in sums of squares over the noise, of the one if the other is right: the less
    /// of both ways.
    pub apart: Vec<f64>,
    /// The signal that each member predicts.
    pub predicted: Vec<Vec<f64>>,
}

impl Foreseen {
    /// That of the two members that are told apart least; infinite for one member.
    #[must_use]
    pub fn separates(&self) -> f64 {
        self.apart.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Pairs of members that are told apart beyond the noise.
    #[must_use]
    pub fn told(&self) -> usize {
        self.apart.iter().filter(|apart| **apart > TELLS).count()
    }

    /// What a recording is worth: each pair counts until it is told apart for sure.
    #[must_use]
    pub fn worth(&self) -> f64 {
        self.apart.iter().map(|apart| apart.min(SURE)).sum::<f64>()
            + self.separates().min(1e6) * 1e-6
    }
}

/// How a recording would be made.
#[derive(Clone, Copy, Debug, Default)]
pub struct Condition {
    /// Seconds of rest before it.
    pub rest: f64,
    /// Temperature above the reference, K.
    pub warmer: f64,
}

impl Rivals<'_> {
    /// A motion as a recording after the others, without its signal.
    #[must_use]
    pub fn trace(&self, time: Vec<f64>, displacement: Vec<f64>, under: Condition) -> Trace {
        let columns = vec![Column { name: DISPLACEMENT.into(), values: displacement }];
        let mut trace = Trace { time, columns, ..Trace::default() };
        if let Some(reference) = self.reference_temperature {
            trace.set_column(TEMPERATURE, vec![reference + under.warmer; trace.len()]);
        }
        let end =
            self.traces.last().and_then(|last| Some(last.head.setup.start_s? + last.duration()));
        trace.head.setup.start_s = end.map(|end| end + under.rest);
        trace
    }

    /// What the members say of a recording after all others; none where it has no usable motion.
    #[must_use]
    pub fn foresee(&self, trace: Trace) -> Option<Foreseen> {
        let set: Vec<Trace> = self.traces.iter().cloned().chain([trace]).collect();
        let all = Data::of_motions(&set, self.signal).ok()?;
        let all = all.with_reference(self.reference_temperature);
        let own = set.len() - 1;
        let predicted: Vec<Vec<f64>> = self
            .members
            .iter()
            .map(|member| signal_of(&member.chain, &member.values, &all, own))
            .collect();
        let refits: Vec<Refit> = self
            .members
            .iter()
            .map(|member| Refit::of(member, &all, own, self.whitening))
            .collect();
        let mut apart = Vec::new();
        for (i, one) in predicted.iter().enumerate() {
            for (j, other) in predicted.iter().enumerate().skip(i + 1) {
                let difference: Vec<f64> = one.iter().zip(other).map(|(a, b)| a - b).collect();
                let stretches = refits[i].whitened(&difference, self.whitening);
                apart.push(refits[i].leaves(&stretches).min(refits[j].leaves(&stretches)));
            }
        }
        apart.iter().all(|apart| apart.is_finite()).then_some(Foreseen { apart, predicted })
    }
}

impl Rivals<'_> {
    /// What the first member says of a recording after all others, and the curvature of a fit to all and that; none where it has no
    /// usable motion.
    pub(super) fn curvature_with(&self, trace: Trace) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let member = self.members.first()?;
        let set: Vec<Trace> = self.traces.iter().cloned().chain([trace]).collect();
        let all = Data::of_motions(&set, self.signal).ok()?;
        let all = all.with_reference(self.reference_temperature);
        let own = set.len() - 1;
        let predicted = signal_of(&member.chain, &member.values, &all, own);
        let (curvature, _) = curvature_with(member, &all, own, self.whitening);
        curvature.iter().all(|value| value.is_finite()).then_some((predicted, curvature))
    }
}

/// The curvature of a fit to the data of a member and to the recording with index `own`, whose stretches come with it.
fn curvature_with(
    member: &Fitted,
    all: &Data,
    own: usize,
    noise: &Whitening,
) -> (DMatrix<f64>, Vec<Stretch>) {
    let white = Whitening::none();
    let problem = Problem::new(&member.chain, all, &white, None);
    let mut curvature = member.curvature();
    let mut stretches = Vec::new();
    problem.derivatives(&member.point, |piece, residual, mut columns| {
        if piece.trace != own {
            return;
        }
        columns.iter_mut().for_each(|(_, column)| noise.apply(column));
        for (i, column) in &columns {
            for (j, other) in &columns {
                curvature[(*i, *j)] += dot(column, other);
            }
        }
        stretches.push(Stretch { samples: residual.len(), columns });
    });
    (curvature, stretches)
}

/// What a chain says of the recording with index `own`.
pub(super) fn signal_of(chain: &Chain, values: &[f64], all: &Data, own: usize) -> Vec<f64> {
    let white = Whitening::none();
    let problem = Problem::new(chain, all, &white, None);
    let mut found = Vec::new();
    problem.each_piece(&[problem.point(values)], |piece, forces| {
        if piece.trace == own {
            found.extend_from_slice(&forces[0]);
        }
    });
    found
}

/// A stretch of the recording.
struct Stretch {
    samples: usize,
    /// The whitened derivatives of a prediction, each with the coordinate that it belongs to.
    columns: Vec<(usize, Vec<f64>)>,
}

/// What a member can take up of a difference in a recording: it would be refitted to the data that it has and to that.
struct Refit {
    stretches: Vec<Stretch>,
    /// Cholesky factor of the scaled curvature, and the scale; none where it is singular.
    factor: Option<Cholesky<f64, Dyn>>,
    scale: DVector<f64>,
}

impl Refit {
    fn of(member: &Fitted, all: &Data, own: usize, noise: &Whitening) -> Self {
        let (curvature, stretches) = curvature_with(member, all, own, noise);
        let size = member.point.len();
        let scale = curvature.diagonal().map(|v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(size, size, |i, j| {
            curvature[(i, j)] * scale[i] * scale[j] + if i == j { 1e-9 } else { 0.0 }
        });
        Self { stretches, factor: scaled.cholesky(), scale }
    }

    /// A difference, whitened stretch by stretch.
    fn whitened(&self, difference: &[f64], noise: &Whitening) -> Vec<Vec<f64>> {
        let mut begin = 0;
        let stretch = |stretch: &Stretch| {
            let mut own = difference[begin..begin + stretch.samples].to_vec();
            begin += stretch.samples;
            noise.apply(&mut own);
            own
        };
        self.stretches.iter().map(stretch).collect()
    }

    /// The sum of squares that is left of a whitened difference after the refit.
    fn leaves(&self, difference: &[Vec<f64>]) -> f64 {
        let mut along = DVector::zeros(self.scale.len());
        for (stretch, own) in self.stretches.iter().zip(difference) {
            for (i, column) in &stretch.columns {
                along[*i] += dot(column, own);
            }
        }
        let right = along.component_mul(&self.scale);
        let taken = self.factor.as_ref().map_or(0.0, |factor| right.dot(&factor.solve(&right)));
        (difference.iter().map(|own| squares(own)).sum::<f64>() - taken).max(0.0)
    }
}

/// Sum of squares.
pub(super) fn squares(values: &[f64]) -> f64 {
    dot(values, values)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
