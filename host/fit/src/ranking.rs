//! Every base law on the same data: which predicts best what it has not seen, and whose parameters are the
//! same in every set-up (chapter 3's argument).

use std::cmp::Ordering;

use rayon::prelude::*;

use super::data::{Data, DataError};
use super::whole_motion::{MotionFit, fit, held_out, over_traces, refit};
use palpate_model::{BaseLaw, Elastic, Family, Gauge, Kernel, LawOption, Laws, Separation};
use palpate_trace::{Kind, Noise, Trace, pooled_noise, segments};

/// All laws, best first.
pub struct Ranking {
    /// One place for each law.
    pub places: Vec<Place>,
    /// The set-ups that parameters are compared between.
    pub setups: Vec<Setup>,
    /// The noise of the signal, where it can be told without a model.
    pub noise: Option<Noise>,
}

/// One law in the ranking.
pub struct Place {
    /// Its fit to all traces together.
    pub fit: MotionFit,
    /// Root mean square error over traces left out in turn; none for a single trace.
    pub held_out: Option<f64>,
    /// How its parameters move between the set-ups; empty for a single set-up.
    pub spreads: Vec<ParameterSpread>,
}

/// Traces that were recorded alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Their largest compression, mm.
    pub compression: f64,
    /// Their fastest loading, mm/s.
    pub rate: f64,
    /// Which traces of the set.
    pub traces: Vec<usize>,
}

impl Place {
    /// Median over the parameters of their relative deviation between the set-ups; none for one set-up.
    #[must_use]
    pub fn typical_deviation(&self) -> Option<f64> {
        let mut deviations: Vec<f64> = self
            .spreads
            .iter()
            .map(ParameterSpread::relative_deviation)
            .filter(|deviation| deviation.is_finite())
            .collect();
        deviations.sort_by(f64::total_cmp);
        deviations.get(deviations.len() / 2).copied()
    }
}

/// One parameter over the set-ups.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSpread {
    /// Name of the parameter.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Value in each set-up, in their order.
    pub values: Vec<f64>,
}

impl ParameterSpread {
    /// Mean over the set-ups.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// Sample standard deviation over the set-ups, over the mean's size.
    #[must_use]
    pub fn relative_deviation(&self) -> f64 {
        let mean = self.mean();
        let square: f64 = self.values.iter().map(|value| (value - mean).powi(2)).sum();
        (square / (self.values.len() as f64 - 1.0)).sqrt() / mean.abs()
    }

    /// Smallest and largest value.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        self.values.iter().fold(start, |(least, most), &value| (least.min(value), most.max(value)))
    }

    /// Largest value over the smallest, in size: 100 is two orders of magnitude.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        let sizes = || self.values.iter().map(|value| value.abs());
        sizes().fold(0.0, f64::max) / sizes().fold(f64::INFINITY, f64::min)
    }
}

/// Set-ups are the same within this part of compression and of rate.
const ALIKE: (f64, f64) = (0.02, 0.1);

/// Fits every law with so many exponentials where it has a choice, and ranks them by the error on traces
/// left out in turn, for a single trace by the Bayesian information criterion.
///
/// Fung's law is tried with each kernel of relaxation, with each elastic response where the heads say how
/// long the specimen is, and with the best of both.
///
/// # Errors
/// When the traces cannot be fitted.
pub fn rank(
    known: &Laws,
    traces: &[Trace],
    signal: &str,
    terms: usize,
    separation: Separation,
) -> Result<Ranking, DataError> {
    let data = Data::of(traces, signal)?.with_separation(separation);
    let setups = setups(traces);
    let apart = apart(traces, &setups);
    let places = |laws: Vec<BaseLaw>| {
        let place = |law| {
            let fit = fit(law, &data)?;
            let left_out = if traces.len() > 1 { held_out(&fit, &data) } else { Vec::new() };
            let held_out = over_traces(&left_out, &data);
            Ok(Place { spreads: between(&fit, &apart, signal)?, fit, held_out })
        };
        laws.into_par_iter().map(place).collect::<Result<Vec<_>, DataError>>()
    };
    let mut places_found = places(laws(known, traces, terms, separation))?;
    places_found.sort_by(better);
    if let Some(law) = combined(&places_found) {
        places_found.extend(places(vec![law])?);
        places_found.sort_by(better);
    }
    Ok(Ranking { places: places_found, setups, noise: pooled_noise(traces, signal) })
}

/// Every family; Fung's law with every kernel, and with every elastic response.
fn laws(known: &Laws, traces: &[Trace], terms: usize, separation: Separation) -> Vec<BaseLaw> {
    let families = known.families().iter();
    let families = families
        .filter(|family| separation != Separation::Bonded || family.takes(LawOption::Bonded))
        .map(|family| BaseLaw::new(family, terms, separation));
    let fung = BaseLaw::fung(terms, separation);
    let kernels = known.kernels().iter().filter(|kernel| !kernel.is_exponentials());
    let kernels = kernels.map(|kernel| fung.with(Elastic::POWER, kernel));
    let gauge = Gauge::of(traces).ok();
    let elastic = known.elastic().iter().filter_map(|&law| match law.needs_gauge() {
        true => gauge.map(|gauge| Elastic::stretch(law, gauge)),
        false => Some(Elastic { law, gauge: None }),
    });
    let elastic = elastic
        .filter(|elastic| *elastic != Elastic::POWER)
        .map(|elastic| fung.with(elastic, Kernel::EXPONENTIALS));
    families.chain(kernels).chain(elastic).filter(|law| law.check().is_ok()).collect()
}

/// Fung's law with the best elastic response and the best kernel, where each by itself is better than the
/// law as it is.
fn combined(places: &[Place]) -> Option<BaseLaw> {
    let better: Vec<BaseLaw> = places
        .iter()
        .map(|place| place.fit.chain.base)
        .filter(|law| law.family == Family::FUNG)
        .take_while(|law| (law.elastic, law.kernel) != (Elastic::POWER, Kernel::EXPONENTIALS))
        .collect();
    let elastic = better.iter().find(|law| law.elastic != Elastic::POWER)?;
    let kernel = better.iter().find(|law| !law.kernel.is_exponentials())?;
    Some(elastic.with(elastic.elastic, kernel.kernel))
}

/// By the error on traces left out, else by the information criterion.
fn better(a: &Place, b: &Place) -> Ordering {
    match (a.held_out, b.held_out) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        _ => a.fit.bic().total_cmp(&b.fit.bic()),
    }
}

/// The traces of each set-up.
fn apart(traces: &[Trace], setups: &[Setup]) -> Vec<Vec<Trace>> {
    let own = |setup: &Setup| setup.traces.iter().map(|&k| traces[k].clone()).collect();
    setups.iter().map(own).collect()
}

/// How the parameters of a law move between the set-ups, each refitted from the fit to all of them; empty for
/// a single set-up.
fn between(
    all: &MotionFit,
    setups: &[Vec<Trace>],
    signal: &str,
) -> Result<Vec<ParameterSpread>, DataError> {
    if setups.len() < 2 {
        return Ok(Vec::new());
    }
    let fits = setups
        .iter()
        .map(|own| {
            let data = Data::of(own, signal)?.with_separation(all.chain.base.separation);
            refit(&all.chain, &all.values, &data)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let spread = |(k, parameter): (usize, palpate_model::Parameter)| ParameterSpread {
        name: parameter.name.into(),
        unit: parameter.unit.into(),
        values: fits.iter().map(|fit| fit.values[k]).collect(),
    };
    Ok(all.chain.base.parameters().into_iter().enumerate().map(spread).collect())
}

/// Traces of the same compression and loading rate together; where all are alike, each by itself.
fn setups(traces: &[Trace]) -> Vec<Setup> {
    let mut setups: Vec<Setup> = Vec::new();
    for (index, trace) in traces.iter().enumerate() {
        let Some(own) = setup(index, trace) else { continue };
        let alike = |a: f64, b: f64, part: f64| (a - b).abs() <= part * a.abs().max(b.abs());
        let same = |known: &&mut Setup| {
            alike(known.compression, own.compression, ALIKE.0)
                && alike(known.rate, own.rate, ALIKE.1)
        };
        match setups.iter_mut().find(same) {
            Some(known) => known.traces.push(index),
            None => setups.push(own),
        }
    }
    if setups.len() == 1 {
        return traces.iter().enumerate().filter_map(|(k, trace)| setup(k, trace)).collect();
    }
    setups.sort_by(|a, b| a.compression.total_cmp(&b.compression).then(a.rate.total_cmp(&b.rate)));
    setups
}

/// The set-up of one trace; none where it never reaches the specimen.
fn setup(index: usize, trace: &Trace) -> Option<Setup> {
    let displacement = trace.displacement()?;
    let compression = displacement.iter().copied().fold(0.0, f64::max);
    let rate = segments(&trace.time, displacement)
        .iter()
        .filter(|segment| segment.kind == Kind::Load)
        .map(|segment| segment.rate_mm_per_s)
        .fold(0.0, f64::max);
    (compression > 0.0).then(|| Setup { compression, rate, traces: vec![index] })
}
