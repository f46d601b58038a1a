//! Everything that depends on the times and limits alone, and the fit of one trace with it.

use super::basis::{Basis, Projection, Spanned};
use super::covariance::{Described, describe};
use super::family::Family;
use super::fit::{ExponentialSum, Fit, MOST_PARAMETERS, Normalisation, Note, Options, Parameter};
use super::means::Means;
use super::nodes::on_nodes;
use super::point::{Problem, Signs};
use super::profile::{Interval, interval};
use super::refine::{Cholesky, Refined, touching};
use super::search::{Fewer, Found, Grids, search};
use super::table::Table;
use super::vector::dot;
use super::{Error, MOST_TERMS};

/// N smaller than this share of the signal's root mean square is rounding.
const ZERO: f64 = 1e-9;

/// Fits of one set of times; the implementors differ in how many coordinates they work with.
pub(super) trait Engine: std::fmt::Debug + Send + Sync {
    /// Fits `terms` exponentials, which were prepared.
    fn fit(&self, values: &[f64], terms: usize) -> Result<Fit, Error>;

    /// Profile-likelihood interval of one parameter of a fit to the same values.
    fn profile(
        &self,
        values: &[f64],
        fit: &Fit,
        parameter: Parameter,
        level: f64,
    ) -> Result<Interval, Error>;
}

/// An engine of `R` coordinates.
#[derive(Clone, Debug)]
pub(super) struct Core<const R: usize> {
    basis: Basis<R>,
    table: Table<R>,
    grids: [Grids<R>; MOST_TERMS],
    options: Options,
    sampling: Sampling,
}

/// The samples behind the times that an engine works on.
#[derive(Clone, Debug)]
pub(super) struct Sampling {
    /// How they are taken together; none where each stands for itself.
    pub means: Option<Means>,
    /// Samples with a weight above 0.
    pub samples: usize,
    /// Times since the first sample, s, and roots of the weights, empty where all are 1, of samples on which the sum of squares is taken
    /// in the end; none where the coordinates tell it.
    pub exact: Option<(Vec<f64>, Vec<f64>)>,
}

impl Sampling {
    /// Weighted sum of squares that a sum of exponentials leaves of all samples; none where the coordinates tell it.
    fn left(&self, values: &[f64], sum: &ExponentialSum) -> Option<f64> {
        if let Some(means) = &self.means {
            return Some(means.left(values, |time| sum.at(time)));
        }
        let (times, roots) = self.exact.as_ref()?;
        let square = |(k, (time, value)): (usize, (&f64, &f64))| {
            let root = roots.get(k).copied().unwrap_or(1.0);
            (root * (value - sum.at(*time))).powi(2)
        };
        Some(times.iter().zip(values).enumerate().map(square).sum())
    }
}

impl<const R: usize> Core<R> {
    /// Prepares fits of up to as many exponentials as the options say, on at most `R` coordinates.
    pub fn new(
        family: &Family,
        spanned: &Spanned,
        roots: Vec<f64>,
        sampling: Sampling,
        options: &Options,
    ) -> Self {
        let (basis, coordinates) = Basis::new(family, spanned, roots);
        let lowest = family.rates[0].ln();
        let highest = lowest + family.spacing * (family.rates.len() - 1) as f64;
        let table = Table::new(coordinates, lowest, highest, family.spacing);
        let grids = Default::default();
        Self { basis, table, grids, options: options.clone(), sampling }
    }

    /// Prepares a single fit on these times since the first sample, s; none where `R` coordinates are not enough.
    pub fn for_one(
        times: &[f64],
        roots: Vec<f64>,
        limits: (f64, f64),
        sampling: Sampling,
        options: &Options,
    ) -> Option<Self> {
        let (basis, table) = on_nodes(times, roots, limits)?;
        let grids = Default::default();
        Some(Self { basis, table, grids, options: options.clone(), sampling })
    }

    fn fit_terms<const N: usize>(&self, values: &[f64]) -> Result<Fit, Error> {
        let projection = self.project(values)?;
        let problem = self.problem(&projection);
        let mut refined = self.search::<N>(&problem).signed;
        let described = describe(&problem, &refined, self.options.normalisation);
        // Not relative to the amplitudes: those of rates that coincide are large and cancel.
        let size = dot(problem.target, problem.target).sqrt() / self.basis.constant_norm;
        let amount = described.scale.abs();
        if amount.is_nan() || amount <= ZERO * size {
            let place = match self.options.normalisation {
                Normalisation::Initial => "at the first sample",
                Normalisation::Asymptotic => "in the limit of long times",
            };
            return Err(Error::ZeroScale { place });
        }
        if let Some(left) = self.sampling.left(values, &described.sum()) {
            refined.point.rss = left;
        }
        Ok(self.report(&projection, &refined, &described))
    }

    fn problem<'a>(&'a self, projection: &'a Projection<R>) -> Problem<'a, R> {
        let target = &projection.coordinates;
        Problem {
            table: &self.table,
            target,
            outside: projection.outside,
            constant_norm: self.basis.constant_norm,
            signs: signs(&self.options, target[0]),
        }
    }

    /// The global minimum of `N` terms, by way of those of fewer.
    fn search<const N: usize>(&self, problem: &Problem<R>) -> Found<N, R> {
        let fewer = || match N {
            4 => Fewer::from(&self.search::<3>(problem)),
            3 => Fewer::from(&self.search::<2>(problem)),
            2 => Fewer::from(&self.search::<1>(problem)),
            _ => Fewer::default(),
        };
        let grids = &self.grids[N - 1];
        search(problem, grids, (self.sampling.samples - (2 * N + 1)) as f64, fewer)
    }

    /// Projects a trace, refusing one that cannot be fitted.
    fn project(&self, values: &[f64]) -> Result<Projection<R>, Error> {
        let projection = match &self.sampling.means {
            Some(means) => {
                let (means, within) = means.of(values);
                let on_means = self.basis.project(&means);
                Projection { outside: on_means.outside + within, ..on_means }
            }
            None => self.basis.project(values),
        };
        let total = dot(&projection.coordinates, &projection.coordinates) + projection.outside;
        if !total.is_finite() {
            return Err(match values.iter().position(|value| !value.is_finite()) {
                Some(sample) => Error::ValueNotFinite { sample },
                None => Error::Magnitude,
            });
        }
        if variation(&projection) <= f64::MIN_POSITIVE.max(1e-30 * total) {
            let constant = values.iter().all(|value| *value == values[0]);
            return Err(if constant || total > 1e-200 {
                Error::ConstantSignal
            } else {
                Error::Magnitude
            });
        }
        Ok(projection)
    }

    fn report<const N: usize>(
        &self,
        projection: &Projection<R>,
        refined: &Refined<N, R>,
        described: &Described<N>,
    ) -> Fit {
        let point = &refined.point;
        let free = usize::from(point.face.constant)
            + point.face.terms.iter().filter(|free| **free).count()
            + refined.curvature.directions.count;
        let degrees = self.sampling.samples - free;
        let variance = point.rss / degrees as f64;
        let mut covariance = described.covariance;
        for row in covariance.iter_mut().take(2 + 2 * N) {
            for value in row.iter_mut().take(2 + 2 * N) {
                *value *= variance;
            }
        }
        let mut determined = [true; MOST_PARAMETERS];
        let mut notes = Vec::new();
        self.notes(refined, described, &mut notes, &mut determined);
        if described.scale * described.scale < 9.0 * covariance[0][0] {
            notes.push(Note::ScaleNearZero);
        }
        Fit {
            sum: described.sum(),
            notes,
            rss: point.rss,
            residual_rms: (point.rss / self.sampling.samples as f64).sqrt(),
            noise: variance.sqrt(),
            r_squared: 1.0 - point.rss / variation(projection),
            samples: self.sampling.samples,
            free,
            degrees_of_freedom: degrees,
            stop: refined.stop,
            iterations: refined.iterations,
            covariance,
            determined,
            normalisation: self.options.normalisation,
            correlated: None,
        }
    }

    /// What is held at a bound or not determined, and which parameters lose their standard error.
    fn notes<const N: usize>(
        &self,
        refined: &Refined<N, R>,
        described: &Described<N>,
        notes: &mut Vec<Note>,
        determined: &mut [bool; MOST_PARAMETERS],
    ) {
        let point = &refined.point;
        let curvature = &refined.curvature;
        let mut undetermined = |parameter: Parameter| {
            if let Some(place) = parameter.place(N) {
                determined[place] = false;
            }
        };
        if self.options.normalisation == Normalisation::Asymptotic {
            undetermined(Parameter::Coefficient(0));
        }
        if !point.face.constant {
            notes.push(Note::ConstantAtZero);
            undetermined(Parameter::Coefficient(0));
        }
        for (k, i) in described.order.into_iter().enumerate() {
            let term = k + 1;
            if !point.face.terms[i] {
                notes.push(Note::Vanishes { term });
                undetermined(Parameter::Coefficient(term));
                undetermined(Parameter::Rate(term));
                continue;
            }
            if curvature.directions.of[i].is_none() {
                let middle = 0.5 * (self.table.lowest + self.table.highest);
                let slow = point.u[i] < middle;
                notes.push(if slow { Note::AtSlowest { term } } else { Note::AtFastest { term } });
                undetermined(Parameter::Rate(term));
            }
            // The order is descending: the slower neighbour is next.
            if i > 0 && point.face.terms[i - 1] && touching(&point.u, i - 1) {
                notes.push(Note::Coincide { first: term, second: term + 1 });
                undetermined(Parameter::Coefficient(term));
                undetermined(Parameter::Coefficient(term + 1));
            }
        }
        if Cholesky::new(&curvature.hessian, curvature.directions.count).is_none() {
            notes.push(Note::Singular);
            for i in 1..=N {
                undetermined(Parameter::Coefficient(i));
                undetermined(Parameter::Rate(i));
            }
        }
    }
}

impl<const R: usize> Engine for Core<R> {
    fn fit(&self, values: &[f64], terms: usize) -> Result<Fit, Error> {
        match terms {
            1 => self.fit_terms::<1>(values),
            2 => self.fit_terms::<2>(values),
            3 => self.fit_terms::<3>(values),
            _ => self.fit_terms::<4>(values),
        }
    }

    fn profile(
        &self,
        values: &[f64],
        fit: &Fit,
        parameter: Parameter,
        level: f64,
    ) -> Result<Interval, Error> {
        let projection = self.project(values)?;
        let problem = self.problem(&projection);
        interval(&problem, fit, self.options.normalisation, parameter, level).ok_or_else(|| {
            let terms = fit.sum.terms.len();
            Error::NoSuchParameter { terms, parameter: parameter.to_string() }
        })
    }
}

/// Sum of squares about the mean.
fn variation<const R: usize>(projection: &Projection<R>) -> f64 {
    let rest = &projection.coordinates[1..];
    rest.iter().map(|value| value * value).sum::<f64>() + projection.outside
}

/// Signs of the amplitudes of a signal with this mean, up to a positive factor.
fn signs(options: &Options, mean: f64) -> Signs {
    let orientation = if mean < 0.0 { -1.0 } else { 1.0 };
    Signs {
        terms: orientation * options.sign.number(),
        constant: match options.normalisation {
            Normalisation::Initial => orientation * options.constant_sign.number(),
            Normalisation::Asymptotic => 0.0,
        },
    }
}
