//! Which effects could explain what a model leaves, without refitting: the score test.
//!
//! The sensitivity of the prediction to each strength is whitened like the noise and projected off the
//! model's own derivatives; what is left of it is compared with the whitened residual. The largest
//! score over the whole library is judged against what noise alone would give, by simulation.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::tail::log_tail;
use palpate_fit::data::Data;
use palpate_fit::levels::LevelSums;
use palpate_fit::problem::Problem;
use palpate_fit::watch;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::{Candidate, Form};
use palpate_model::{Chain, Elasticity, History, Scene};

/// One law of one candidate with its shapes at one point of their grid.
#[derive(Clone, Debug)]
pub struct Direction {
    /// Which candidate.
    pub candidate: usize,
    /// Which of its laws.
    pub form: usize,
    /// The shapes.
    pub shapes: Vec<f64>,
    /// Its columns among all sensitivities, one for each strength.
    pub columns: std::ops::Range<usize>,
    /// Part of its size that the projection leaves, 0 to 1.
    pub left: f64,
    /// Logarithm of the chance of such a score under noise alone.
    pub log_chance: f64,
    /// Predicted fall of the whitened sum of squares.
    pub gain: f64,
    /// Predicted strengths.
    pub strengths: Vec<f64>,
    /// Predicted change of the coordinates of the model.
    pub shift: Vec<f64>,
}

/// What the screen found.
#[derive(Clone, Debug)]
pub struct Screen {
    /// Every direction, in the order of the candidates.
    pub directions: Vec<Direction>,
    /// Chance under noise alone of a score as large as the largest of each candidate, over the whole
    /// library; 1 for candidates that cannot be tested.
    pub chance: Vec<f64>,
    /// Projected sensitivities against each other: cosines between columns.
    pub cosines: DMatrix<f64>,
    /// Inner products of the projected sensitivities with the residual of each part of the data: parts
    /// × columns.
    pub scores: DMatrix<f64>,
}

impl Screen {
    /// The least chance of all candidates.
    #[must_use]
    pub fn least_chance(&self) -> f64 {
        self.chance.iter().copied().fold(1.0, f64::min)
    }

    /// The chance on which a step of a candidate rests: its own up to a level, beyond that the least of all. An effect far from zero
    /// strength shows in no score; its step rests on the misfit that the others show.
    #[must_use]
    pub fn chance_of_step(&self, candidate: usize, level: f64) -> f64 {
        let own = self.chance[candidate];
        if own > level { self.least_chance() } else { own }
    }

    /// Effects that it could not test, with the reason.
    #[must_use]
    pub fn untestable(&self, candidates: &[Candidate]) -> Vec<(String, String)> {
        let absorbed = |index: usize| {
            let mut own = self.directions.iter().filter(|direction| direction.candidate == index);
            own.all(|direction| direction.left < ABSORBED)
        };
        let reason = |index: usize, candidate: &Candidate| match candidate.missing {
            Some(missing) => Some(missing),
            None if absorbed(index) => {
                Some("absorbed by the model's own parameters on these traces")
            }
            None => None,
        };
        let untestable = |(index, candidate): (usize, &Candidate)| {
            Some((candidate.name.clone(), reason(index, candidate)?.to_owned()))
        };
        candidates.iter().enumerate().filter_map(untestable).collect()
    }
}

/// Draws of the null distribution.
pub const DRAWS: usize = 4000;
/// Seed of the draws.
pub const SEED: u64 = 11;
/// Samples whose products are taken at a time.
const AT_A_TIME: usize = 4096;
/// Part of a sensitivity below which the model's own parameters have absorbed it.
pub const ABSORBED: f64 = 0.004;

/// Screens the candidates against what the problem leaves at `point`.
#[must_use]
pub fn screen(
    problem: &Problem,
    data: &Data,
    point: &[f64],
    whitening: &Whitening,
    candidates: &[Candidate],
) -> Screen {
    let mut directions = directions(candidates);
    let base = point.len();
    let size = base + directions.last().map_or(0, |d| d.columns.end);
    let (gram, along) = gram(problem, data, point, whitening, candidates, &directions, size);
    let samples = problem.rows() as f64;
    let floor = if whitening.is_guess() { 0.0 } else { 1.0 };
    let projected = Projected::new(&gram, base, samples, floor);
    for direction in &mut directions {
        let positive = candidates[direction.candidate].forms[direction.form].positive;
        projected.judge(direction, positive);
    }
    for d in &directions {
        tracing::trace!(
            "score: {} ({}) {:?}: left {:.3}, gain {:.1}, strengths {:?}, log chance {:.1}",
            candidates[d.candidate].name,
            candidates[d.candidate].forms[d.form].applied.law,
            d.shapes,
            d.left,
            d.gain,
            &d.strengths[..d.strengths.len().min(3)],
            d.log_chance
        );
    }
    let cosines = projected.cosines();
    let chance = chances(&directions, candidates, &cosines);
    let scores = projected.scores(&along, base);
    Screen { directions, chance, cosines, scores }
}

/// Every law at every point of its grid that these data can show.
fn directions(candidates: &[Candidate]) -> Vec<Direction> {
    let mut found = Vec::new();
    let mut next = 0;
    for (index, candidate) in candidates.iter().enumerate() {
        if candidate.missing.is_some() {
            continue;
        }
        for (number, form) in candidate.forms.iter().enumerate() {
            for shapes in form.grid.clone() {
                let columns = next..next + form.applied.strengths;
                next = columns.end;
                found.push(Direction {
                    candidate: index,
                    form: number,
                    shapes,
                    columns,
                    left: 0.0,
                    log_chance: 0.0,
                    gain: 0.0,
                    strengths: Vec::new(),
                    shift: Vec::new(),
                });
            }
        }
    }
    found
}

/// Fewest parts that data are taken apart into, to see whether they agree.
const FEWEST_PARTS: usize = 24;

/// Inner products of the model's derivatives, all sensitivities and the residual, whitened; and those of
/// each part of the data with its residual. A part is a trace, or a section of one where there are few.
fn gram(
    problem: &Problem,
    data: &Data,
    point: &[f64],
    whitening: &Whitening,
    candidates: &[Candidate],
    directions: &[Direction],
    size: usize,
) -> (DMatrix<f64>, Vec<DVector<f64>>) {
    let base = point.len();
    let parameters = problem.declared(point);
    let mut probes: Vec<Probe> = directions
        .iter()
        .map(|direction| {
            let form = &candidates[direction.candidate].forms[direction.form];
            Probe::new(problem.chain, form, &direction.shapes, &parameters)
        })
        .collect();
    let mut gram = DMatrix::zeros(size + 1, size + 1);
    let mut sums = whitening.levels().map(|levels| LevelSums::zeros(size + 1, levels.traces()));
    let pieces = FEWEST_PARTS.div_ceil(data.pieces.len());
    let mut along: Vec<DVector<f64>> = vec![];
    let (mut index, mut history, mut force) = (0, History::default(), Vec::new());
    watch::stage("stretches screened", data.pieces.len());
    problem.derivatives(point, |piece, mut residual, derivatives| {
        let place = index;
        index += 1;
        watch::done();
        if watch::ended() {
            return;
        }
        let scene = data.scene(piece);
        let predicted: Vec<f64> = residual.iter().zip(piece.measured).map(|(r, y)| r + y).collect();
        let mut columns: Vec<(usize, Vec<f64>)> = derivatives;
        let law = problem.chain.base;
        let shape = law.constants(&parameters).shape;
        let law = (law.elastic, law.separation);
        let mut elasticity = Elasticity::at(law, shape, &piece.motion.displacement);
        if problem.chain.yields() {
            // Where the set-up comes to, a term changes little.
            problem.chain.run(&parameters, &scene, &mut history, &mut elasticity, &mut force);
        }
        let sensitivities: Vec<Vec<(usize, Vec<f64>)>> = probes
            .par_iter_mut()
            .map(|probe| {
                probe.sensitivities(&scene, piece.trace, &predicted, &mut elasticity.nearby())
            })
            .collect();
        for (direction, found) in directions.iter().zip(sensitivities) {
            let first = base + direction.columns.start;
            columns.extend(found.into_iter().map(|(place, column)| (first + place, column)));
        }
        watch::evaluated(scene.len() * (columns.len() - 1));
        columns.par_iter_mut().for_each(|(_, column)| problem.whiten_at(place, column));
        problem.whiten_residual(place, &mut residual);
        residual.iter_mut().for_each(|r| *r = -*r);
        columns.push((size, residual));
        if let Some(sums) = &mut sums {
            sums.add(piece.trace, &problem.unit_level(place), &columns, &[], 0);
        }
        let residual = columns.last().map(|(_, residual)| residual.clone()).unwrap_or_default();
        for range in problem.parts(place, pieces) {
            let mut part = DVector::zeros(size);
            for (place, column) in &columns[..columns.len() - 1] {
                let products = column[range.clone()].iter().zip(&residual[range.clone()]);
                part[*place] = products.map(|(a, b)| a * b).sum::<f64>();
            }
            along.push(part);
        }
        // A few thousand samples at a time: a long trace has many more than fit beside their products.
        let mut products = DMatrix::zeros(columns.len(), columns.len());
        for begin in (0..scene.len()).step_by(AT_A_TIME) {
            let end = (begin + AT_A_TIME).min(scene.len());
            let entries = columns.iter().flat_map(|(_, column)| &column[begin..end]).copied();
            let part = DMatrix::from_iterator(end - begin, columns.len(), entries);
            products += part.transpose() * &part;
        }
        for (i, (row, _)) in columns.iter().enumerate() {
            for (j, (column, _)) in columns.iter().enumerate() {
                gram[(*row, *column)] += products[(i, j)];
            }
        }
    });
    gram[(size, size)] += problem.unseen();
    if let Some((levels, sums)) = whitening.levels().zip(sums) {
        gram -= levels.explained(&sums);
    }
    (gram, along)
}

/// Runs a chain with one more effect beside the chain itself.
struct Probe {
    chain: Chain,
    /// Parameters of the chain with each strength in turn at its typical size.
    points: Vec<Vec<f64>>,
    histories: Vec<History>,
    typical: f64,
    each_trace: usize,
    /// Whether the effect acts on the prediction itself.
    last: bool,
}

impl Probe {
    fn new(chain: &Chain, form: &Form, shapes: &[f64], parameters: &[f64]) -> Self {
        let strengths = form.applied.strengths;
        let at = |raised: usize| {
            let own = (0..strengths).map(|k| if k == raised { form.typical } else { 0.0 });
            parameters.iter().copied().chain(own).chain(shapes.iter().copied()).collect()
        };
        let chain = chain.with(form.applied.clone());
        Self {
            last: chain.ends_with_last(),
            chain,
            points: (0..strengths).map(at).collect(),
            histories: vec![History::default(); strengths],
            typical: form.typical,
            each_trace: form.applied.each_trace,
        }
    }

    /// What each strength changes over one stretch, per unit of it: the strength and its column. `base`
    /// is what the chain predicts without the effect.
    fn sensitivities(
        &mut self,
        scene: &Scene,
        trace: usize,
        base: &[f64],
        elasticity: &mut Elasticity,
    ) -> Vec<(usize, Vec<f64>)> {
        let own = trace * self.each_trace..(trace + 1) * self.each_trace;
        let places = if self.each_trace > 0 { own } else { 0..self.points.len() };
        let mut found = Vec::with_capacity(places.len());
        for place in places {
            let Some(point) = self.points.get(place) else { continue };
            let mut force = Vec::new();
            if self.last {
                force.extend_from_slice(base);
                self.chain.run_last(point, scene, &mut self.histories[place], &mut force);
            } else {
                let history = &mut self.histories[place];
                self.chain.run(point, scene, history, elasticity, &mut force);
            }
            for (force, base) in force.iter_mut().zip(base) {
                *force = (*force - base) / self.typical;
            }
            found.push((place, force));
        }
        found
    }
}

/// The sensitivities with the model's own derivatives taken off them.
struct Projected {
    /// Inner products of the projected sensitivities.
    products: DMatrix<f64>,
    /// Their inner products with the residual.
    along: DVector<f64>,
    /// Inner products before the projection.
    whole: DVector<f64>,
    /// How the model's coordinates answer to each strength.
    answers: DMatrix<f64>,
    /// How the model's coordinates still want to move.
    rest: DVector<f64>,
    /// Variance of a whitened residual: at least one where the noise is known.
    dispersion: f64,
}

impl Projected {
    fn new(gram: &DMatrix<f64>, base: usize, samples: f64, floor: f64) -> Self {
        let size = gram.nrows() - 1;
        let count = size - base;
        let own = gram.view((0, 0), (base, base)).into_owned();
        let cross = gram.view((0, base), (base, count)).into_owned();
        let scale = own.diagonal().map(|v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(base, base, |i, j| {
            let value = own[(i, j)] * scale[i] * scale[j];
            if i == j { value.max(1.0) * (1.0 + 1e-10) } else { value }
        });
        let solve = |right: &DMatrix<f64>| {
            let mut inner = right.clone();
            for (mut row, scale) in inner.row_iter_mut().zip(scale.iter()) {
                row *= *scale;
            }
            let mut found = match scaled.clone().cholesky() {
                Some(factor) => factor.solve(&inner),
                None => DMatrix::zeros(right.nrows(), right.ncols()),
            };
            for (mut row, scale) in found.row_iter_mut().zip(scale.iter()) {
                row *= *scale;
            }
            found
        };
        let answers = solve(&cross);
        let residual = gram.view((0, size), (base, 1)).into_owned();
        let rest = solve(&residual).column(0).into_owned();
        let sensitivities = gram.view((base, base), (count, count)).into_owned();
        let whole = sensitivities.diagonal();
        let products = sensitivities - cross.tr_mul(&answers);
        let along = gram.view((base, size), (count, 1)).column(0) - cross.tr_mul(&rest);
        let squares = gram[(size, size)] - residual.column(0).dot(&rest);
        let dispersion = (squares / (samples - base as f64)).max(floor).max(f64::MIN_POSITIVE);
        Self { products, along, whole, answers, rest, dispersion }
    }

    /// Score, predicted gain and predicted strengths of a direction.
    fn judge(&self, direction: &mut Direction, positive: bool) {
        let columns = direction.columns.clone();
        let count = columns.len();
        let left = |k: usize| {
            (self.products[(k, k)].max(0.0) / self.whole[k].max(f64::MIN_POSITIVE)).sqrt()
        };
        direction.left = columns.clone().map(left).fold(0.0, f64::max);
        direction.strengths = vec![0.0; count];
        direction.shift = vec![0.0; self.rest.len()];
        if direction.left < ABSORBED {
            return;
        }
        let products = self.products.view((columns.start, columns.start), (count, count));
        let along = self.along.rows(columns.start, count);
        let Some(strengths) = solve_positive_definite(&products.into_owned(), &along.into_owned())
        else {
            return;
        };
        if positive && count == 1 && strengths[0] <= 0.0 {
            return;
        }
        let gain = strengths.dot(&along) / self.dispersion;
        direction.gain = gain;
        direction.log_chance = log_tail(gain, count, positive && count == 1);
        let answer = self.answers.columns(columns.start, count);
        let shift = &self.rest - answer * &strengths;
        direction.strengths = strengths.as_slice().to_vec();
        direction.shift = shift.as_slice().to_vec();
    }

    /// What each part of the data says of each sensitivity beside the model's own derivatives.
    fn scores(&self, along: &[DVector<f64>], base: usize) -> DMatrix<f64> {
        let count = self.answers.ncols();
        let mut scores = DMatrix::zeros(along.len(), count);
        for (part, along) in along.iter().enumerate() {
            let own = self.answers.tr_mul(&along.rows(0, base));
            let score = along.rows(base, count) - own;
            scores.row_mut(part).copy_from(&score.transpose());
        }
        scores
    }

    fn cosines(&self) -> DMatrix<f64> {
        let size = self.products.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt());
        DMatrix::from_fn(size.len(), size.len(), |i, j| {
            if i == j { 1.0 } else { self.products[(i, j)] / (size[i] * size[j]) }
        })
    }
}

/// Solves with a matrix in units where its diagonal is one.
fn solve_positive_definite(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = matrix.diagonal().map(|v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.nrows(), |i, j| {
        let value = matrix[(i, j)] * scale[i] * scale[j];
        if i == j { value.max(1.0) * (1.0 + 1e-9) } else { value }
    });
    Some(scaled.cholesky()?.solve(&right.component_mul(&scale)).component_mul(&scale))
}

/// Chance under noise alone of a score as large as each candidate's largest, anywhere in the library.
fn chances(directions: &[Direction], candidates: &[Candidate], cosines: &DMatrix<f64>) -> Vec<f64> {
    let tested: Vec<&Direction> = directions.iter().filter(|d| d.left >= ABSORBED).collect();
    let mut least = vec![0.0; candidates.len()];
    for direction in &tested {
        least[direction.candidate] = direction.log_chance.min(least[direction.candidate]);
    }
    let columns: Vec<usize> = tested.iter().flat_map(|d| d.columns.clone()).collect();
    let size = columns.len();
    if size == 0 {
        return vec![1.0; candidates.len()];
    }
    let root = root_of(&DMatrix::from_fn(size, size, |i, j| cosines[(columns[i], columns[j])]));
    // Where each direction's columns stand among the tested, and how to weigh several strengths.
    let mut first = 0;
    let places: Vec<Place> = tested
        .iter()
        .map(|direction| {
            let count = direction.columns.len();
            let place = first;
            first += count;
            let positive = candidates[direction.candidate].forms[direction.form].positive;
            let inverse = (count > 1).then(|| {
                let start = direction.columns.start;
                cosines.view((start, start), (count, count)).into_owned().pseudo_inverse(1e-9).ok()
            });
            Place {
                first: place,
                count,
                positive: positive && count == 1,
                inverse: inverse.flatten(),
            }
        })
        .collect();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let normals = DMatrix::from_fn(size, DRAWS, |_, _| StandardNormal.sample(&mut random));
    let null: Vec<f64> = (0..DRAWS)
        .step_by(DRAWN_AT_A_TIME)
        .collect::<Vec<usize>>()
        .into_par_iter()
        .flat_map_iter(|begin| {
            let count = DRAWN_AT_A_TIME.min(DRAWS - begin);
            let scores = &root * normals.columns(begin, count);
            (0..count)
                .map(|k| most_extreme(&places, scores.column(k).as_slice()))
                .collect::<Vec<_>>()
        })
        .collect();
    let chance = |&least: &f64| {
        if least >= 0.0 {
            return 1.0;
        }
        let as_extreme = null.iter().filter(|&&drawn| drawn <= least).count();
        (as_extreme + 1) as f64 / (DRAWS + 1) as f64
    };
    least.iter().map(chance).collect()
}

/// Draws whose scores are taken at a time.
const DRAWN_AT_A_TIME: usize = 64;
/// What is added to the variance of every score: of columns that are nearly the same, hardly anything is left to tell apart.
const RIDGE: f64 = 1e-9;

/// A matrix that, times its transpose, is this correlation.
fn root_of(correlation: &DMatrix<f64>) -> DMatrix<f64> {
    let size = correlation.nrows();
    let ridged = correlation + DMatrix::identity(size, size) * RIDGE;
    if let Some(factor) = ridged.cholesky() {
        return factor.unpack();
    }
    let eigen = correlation.clone().symmetric_eigen();
    DMatrix::from_fn(size, size, |i, j| {
        eigen.eigenvectors[(i, j)] * eigen.eigenvalues[j].max(0.0).sqrt()
    })
}

/// Where the columns of a direction stand among those tested.
struct Place {
    first: usize,
    count: usize,
    positive: bool,
    /// How several strengths are weighed.
    inverse: Option<DMatrix<f64>>,
}

/// The least chance, as a logarithm, of scores over the library. A chance falls as its score grows: of all directions with as many
/// strengths only the largest needs one.
fn most_extreme(places: &[Place], scores: &[f64]) -> f64 {
    let mut largest: Vec<(usize, bool, f64)> = Vec::new();
    for Place { first, count, positive, inverse } in places {
        let own = &scores[*first..first + count];
        let gain = match inverse {
            Some(inverse) => {
                let own = DVector::from_column_slice(own);
                own.dot(&(inverse * &own))
            }
            None if *positive && own[0] <= 0.0 => continue,
            None => own[0].powi(2),
        };
        match largest.iter_mut().find(|known| (known.0, known.1) == (*count, *positive)) {
            Some(known) => known.2 = known.2.max(gain),
            None => largest.push((*count, *positive, gain)),
        }
    }
    let chance = |&(count, positive, gain): &(usize, bool, f64)| log_tail(gain, count, positive);
    largest.iter().map(chance).fold(0.0, f64::min)
}
