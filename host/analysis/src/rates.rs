//! One specimen at several loading rates: specific stiffness, surface strain, latent strain rate, whether
//! the asymptotes agree and how far the peak stiffens (chapter 5).
//!
//! Section 5.4.1 writes ε = k_s σ in passing; (5.7) has it right and is what is computed: ε = σ / k_s.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

use super::controlled::{ForceControlled, displacement_controlled};
use super::geometry::{Faces, Geometry, GeometryError};
use palpate_fit::consistency::{Consistency, consistency};
use palpate_fit::exponentials::{self, Fit, Normalisation, Options, Parameter, Prepared};
use palpate_trace::{
    DISPLACEMENT, FORCE, Kind, Segment, SignalError, Trace, force_noise, segments,
};

/// Displacements that differ by less than this, relatively, are the same.
const SAME_DISPLACEMENT: f64 = 0.02;
/// Samples before and after over which the peak is averaged; it may be the first five of the hold.
const REACH: usize = 2;

/// A value with its standard error, where it has one.
pub type Estimate = (f64, Option<f64>);

/// One loading and the hold after it.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name of the trace.
    pub trace: String,
    /// Samples of the loading and of the hold.
    pub loading: std::ops::Range<usize>,
    /// Samples of the hold.
    pub hold: std::ops::Range<usize>,
    /// Rate of the loading, mm/s.
    pub rate_mm_per_s: f64,
    /// Displacement of the hold, mm.
    pub displacement_mm: f64,
    /// Largest force of the loading, N: mean of five samples.
    pub peak_n: Estimate,
    /// Standard deviation of the noise of the force, N, where it can be told.
    pub noise_n: Option<f64>,
    /// F(t) in the hold; its scale is the asymptote (5.3).
    pub fit: Fit,
    /// v1, 1/s.
    pub v1: Estimate,
    /// Asymptotic force, N.
    pub asymptote_n: Estimate,
    /// Nominal area of contact in the hold, mm² (5.5).
    pub area_mm2: f64,
    /// Equilibrium strain (5.8), compression positive.
    pub equilibrium_strain: f64,
    /// k_s of this run, Pa (5.6).
    pub stiffness_pa: Estimate,
}

/// Strains of one run over time, compression positive.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Time, s.
    pub time: Vec<f64>,
    /// Strain of the contact surface from the force (5.7).
    pub surface: Vec<f64>,
    /// Equilibrium strain of the displacement (5.8).
    pub equilibrium: Vec<f64>,
    /// Latent strain rate −v1 (ε − ε_e), 1/s (5.1).
    pub latent_rate: Vec<f64>,
}

/// A straight line over the logarithm of the loading rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// Slope, N for ten times the rate, with its standard error: from those of the values where all have
    /// one, else from the scatter about the line.
    pub slope_n: Estimate,
    /// Chance of so steep a slope if the rate made no difference: normal where the values have standard
    /// errors, else Student's t.
    pub p_value: f64,
    /// Whether the values lie on the line within their standard errors, where they have them.
    pub off_line: Option<OffLine>,
}

/// How far values lie off a line, by their standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffLine {
    /// Sum of the squared deviations, in standard errors.
    pub chi_square: f64,
    /// Values less two.
    pub degrees_of_freedom: usize,
    /// Chance of so large a sum if the values lay on the line but for their errors.
    pub p_value: f64,
}

/// Runs at one displacement.
#[derive(Clone, Debug)]
pub struct Group {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Places of its runs in the study.
    pub runs: Vec<usize>,
    /// Whether the asymptotes agree within their standard errors (5.4.2).
    pub asymptotes: Option<Consistency>,
    /// Asymptote over the rate; three different rates or more.
    pub asymptote_trend: Option<Trend>,
    /// Whether the peaks agree within their standard errors.
    pub peaks: Option<Consistency>,
    /// Peak over the rate: stiffening (5.4.3).
    pub peak_trend: Option<Trend>,
}

/// All runs of one specimen.
#[derive(Clone, Debug)]
pub struct Study {
    /// Its geometry.
    pub geometry: Geometry,
    /// Every loading with its hold, in the order of the traces.
    pub runs: Vec<Run>,
    /// v1, 1/s: mean over the runs, each weighing by its standard error where all have one.
    pub v1: Estimate,
    /// k_s, Pa: the same.
    pub stiffness_pa: Estimate,
    /// Whether the runs agree on v1, and on k_s.
    pub agreement: (Option<Consistency>, Option<Consistency>),
    /// Runs at each displacement.
    pub groups: Vec<Group>,
}

/// Why loading rates cannot be compared.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum RatesError {
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error(transparent)]
    Controlled(#[from] ForceControlled),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error("{trace}: no hold follows a loading in it; loading rates need load and hold")]
    NoRun { trace: String },
    #[error("{trace}, hold from {from_s:.3} s: {source}")]
    Fit { trace: String, from_s: f64, source: exponentials::Error },
}

/// Compares the loadings of several traces of one specimen, `terms` exponentials in each hold (5.3 has
/// one).
///
/// # Errors
/// When a trace lacks displacement, force or geometry, was force controlled, or has no hold after a
/// loading.
pub fn rates(traces: &[Trace], terms: usize, faces: Faces) -> Result<Study, RatesError> {
    let mut runs = Vec::new();
    let mut geometry = None;
    for trace in traces {
        displacement_controlled(trace)?;
        let own = Geometry::of(&trace.head.specimen, faces, &trace.label())?;
        let before = runs.len();
        let displacement = trace.changing(DISPLACEMENT)?;
        let force = trace.changing(FORCE)?;
        let found = segments(&trace.time, displacement);
        for pair in found.windows(2) {
            if pair[0].kind == Kind::Load && pair[1].kind == Kind::Hold {
                runs.push(run(trace, displacement, force, pair, terms, &own)?);
            }
        }
        if runs.len() == before {
            return Err(RatesError::NoRun { trace: trace.label() });
        }
        geometry = Some(own);
    }
    let geometry = geometry.ok_or_else(|| RatesError::NoRun { trace: "nothing".into() })?;
    let (v1, v1_agreement) = pooled(&runs, |run| run.v1);
    let (stiffness_pa, stiffness_agreement) = pooled(&runs, |run| run.stiffness_pa);
    let groups = groups(&runs);
    let agreement = (v1_agreement, stiffness_agreement);
    Ok(Study { geometry, v1, stiffness_pa, agreement, groups, runs })
}

fn run(
    trace: &Trace,
    displacement: &[f64],
    force: &[f64],
    pair: &[Segment],
    terms: usize,
    geometry: &Geometry,
) -> Result<Run, RatesError> {
    let (loading, hold) = (pair[0].range.clone(), pair[1].range.clone());
    let failed =
        |source| RatesError::Fit { trace: trace.label(), from_s: trace.time[hold.start], source };
    let options = Options { terms, normalisation: Normalisation::Asymptotic, ..Options::default() };
    let prepared = Prepared::new(&trace.elapsed(hold.clone()), &options).map_err(failed)?;
    let fit = prepared.fit(&force[hold.clone()]).map_err(failed)?;
    let estimate =
        |parameter| (fit.value(parameter).unwrap_or(f64::NAN), fit.standard_error(parameter));
    let held = &displacement[hold.clone()];
    let displacement_mm = held.iter().sum::<f64>() / held.len() as f64;
    let area_mm2 = geometry.area_mm2(displacement_mm);
    let equilibrium_strain = geometry.equilibrium_strain(displacement_mm);
    let asymptote_n = estimate(Parameter::Scale);
    let per_newton = 1e6 / (area_mm2 * equilibrium_strain);
    let noise = force_noise(trace).ok().map(|noise| noise.standard_deviation);
    Ok(Run {
        trace: trace.label(),
        rate_mm_per_s: pair[0].rate_mm_per_s,
        displacement_mm,
        peak_n: (
            peak(&force[loading.start..(hold.start + 2 * REACH + 1).min(hold.end)]),
            noise.map(|noise| noise / ((2 * REACH + 1) as f64).sqrt()),
        ),
        noise_n: noise,
        v1: estimate(Parameter::Rate(1)),
        asymptote_n,
        area_mm2,
        equilibrium_strain,
        stiffness_pa: (
            asymptote_n.0 * per_newton,
            asymptote_n.1.map(|error| error * per_newton.abs()),
        ),
        fit,
        loading,
        hold,
    })
}

/// Largest mean of five neighbouring samples, by size.
fn peak(force: &[f64]) -> f64 {
    let width = (2 * REACH + 1).min(force.len());
    force
        .windows(width)
        .map(|part| part.iter().sum::<f64>() / width as f64)
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(f64::NAN)
}

/// Mean over the runs, and whether they agree.
fn pooled(runs: &[Run], of: impl Fn(&Run) -> Estimate) -> (Estimate, Option<Consistency>) {
    let values: Vec<f64> = runs.iter().map(|run| of(run).0).collect();
    let errors: Option<Vec<f64>> = runs.iter().map(|run| of(run).1).collect();
    let test = errors.as_ref().and_then(|errors| consistency(&values, errors));
    let estimate = match (test, &errors) {
        (Some(test), _) => (test.mean, Some(test.standard_error)),
        (None, Some(errors)) if values.len() == 1 => (values[0], Some(errors[0])),
        _ => (values.iter().sum::<f64>() / values.len() as f64, None),
    };
    (estimate, test)
}

fn groups(runs: &[Run]) -> Vec<Group> {
    let mut places: Vec<Vec<usize>> = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        let x = run.displacement_mm;
        let same = |group: &&mut Vec<usize>| {
            let other = runs[group[0]].displacement_mm;
            (other - x).abs() <= SAME_DISPLACEMENT * other.abs().max(x.abs())
        };
        match places.iter_mut().find(same) {
            Some(group) => group.push(index),
            None => places.push(vec![index]),
        }
    }
    let group = |places: Vec<usize>| {
        let of = |estimate: fn(&Run) -> Estimate| -> Vec<Estimate> {
            places.iter().map(|&place| estimate(&runs[place])).collect()
        };
        let decades: Vec<f64> =
            places.iter().map(|&place| runs[place].rate_mm_per_s.abs().log10()).collect();
        let (asymptotes, peaks) = (of(|run| run.asymptote_n), of(|run| run.peak_n));
        Group {
            displacement_mm: runs[places[0]].displacement_mm,
            asymptotes: agreement(&asymptotes),
            asymptote_trend: trend(&decades, &asymptotes),
            peaks: agreement(&peaks),
            peak_trend: trend(&decades, &peaks),
            runs: places,
        }
    };
    places.into_iter().map(group).collect()
}

/// Values and their standard errors, where all have one.
fn split(estimates: &[Estimate]) -> (Vec<f64>, Option<Vec<f64>>) {
    let errors: Option<Vec<f64>> = estimates.iter().map(|estimate| estimate.1).collect();
    let told = |errors: &Vec<f64>| errors.iter().all(|error| *error > 0.0 && error.is_finite());
    (estimates.iter().map(|estimate| estimate.0).collect(), errors.filter(told))
}

/// Whether values agree within their standard errors.
fn agreement(estimates: &[Estimate]) -> Option<Consistency> {
    let (values, errors) = split(estimates);
    consistency(&values, &errors?)
}

/// The line through three points or more whose places differ, each weighing by its standard error where
/// all have one.
fn trend(x: &[f64], estimates: &[Estimate]) -> Option<Trend> {
    let (y, errors) = split(estimates);
    let degrees_of_freedom = x.len().checked_sub(2).filter(|degrees| *degrees > 0)?;
    let weights: Vec<f64> = match &errors {
        Some(errors) => errors.iter().map(|error| error.powi(-2)).collect(),
        None => vec![1.0; y.len()],
    };
    let sum = |of: &dyn Fn(usize) -> f64| (0..x.len()).map(|k| weights[k] * of(k)).sum::<f64>();
    let weight = sum(&|_| 1.0);
    let (mx, my) = (sum(&|k| x[k]) / weight, sum(&|k| y[k]) / weight);
    let square = sum(&|k| (x[k] - mx).powi(2));
    // Rates within one per cent of each other are one rate.
    let finite = x.iter().chain(&y).all(|value| value.is_finite());
    if !finite || square < weight * 0.004f64.powi(2) {
        return None;
    }
    let slope = sum(&|k| (x[k] - mx) * (y[k] - my)) / square;
    let left = sum(&|k| (y[k] - my - slope * (x[k] - mx)).powi(2));
    let two_sided = |sf: f64| 2.0 * sf;
    if errors.is_some() {
        let error = square.sqrt().recip();
        let normal = Normal::standard();
        let off_line = ChiSquared::new(degrees_of_freedom as f64).ok().map(|spread| OffLine {
            chi_square: left,
            degrees_of_freedom,
            p_value: spread.sf(left),
        });
        let p_value = two_sided(normal.sf((slope / error).abs()));
        return Some(Trend { slope_n: (slope, Some(error)), p_value, off_line });
    }
    let error = (left / degrees_of_freedom as f64 / square).sqrt();
    let student = StudentsT::new(0.0, 1.0, degrees_of_freedom as f64).ok()?;
    let p_value = if error > 0.0 { two_sided(student.sf((slope / error).abs())) } else { 0.0 };
    Some(Trend { slope_n: (slope, Some(error)), p_value, off_line: None })
}

impl Study {
    /// Strains of one run over loading and hold, from the pooled v1 and k_s.
    ///
    /// None if the trace is not the run's own or lost a column.
    #[must_use]
    pub fn course(&self, run: &Run, trace: &Trace) -> Option<Course> {
        let (force, displacement) = (trace.force()?, trace.displacement()?);
        let samples = run.loading.start..run.hold.end;
        let touching = samples
            .filter(|&k| k < trace.len())
            .filter_map(|k| Some((k, self.geometry.stress_pa(force[k], displacement[k])?)));
        let mut course = Course {
            time: Vec::new(),
            surface: Vec::new(),
            equilibrium: Vec::new(),
            latent_rate: Vec::new(),
        };
        for (k, stress) in touching {
            let surface = stress / self.stiffness_pa.0;
            let equilibrium = self.geometry.equilibrium_strain(displacement[k]);
            course.time.push(trace.time[k]);
            course.surface.push(surface);
            course.equilibrium.push(equilibrium);
            course.latent_rate.push(-self.v1.0 * (surface - equilibrium));
        }
        Some(course)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use palpate_trace::Shape;

    /// A cylinder whose surface runs ahead of the equilibrium by a share of every change and comes back
    /// at v1 = 0.5/s; k_s = 35 kPa.
    fn pressed(rate: f64, noise: f64, drift: f64, seed: u64) -> Trace {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, noise).unwrap();
        let geometry = Geometry::Cylinder { radius_mm: 25.0, height_mm: 30.0, poisson: 0.48 };
        let time: Vec<f64> = (0..2400).map(|k| 0.005 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| (rate * (t - 0.1)).clamp(0.0, 6.0)).collect();
        let mut ahead = 0.0;
        let force = (0..x.len())
            .map(|k| {
                let step = if k == 0 { 0.0 } else { x[k] - x[k - 1] } / 30.0;
                ahead = ahead * (-0.5f64 * 0.005).exp() + 0.4 * step;
                let strain = x[k] / 30.0 + ahead + drift * rate.log10() * (x[k] / 6.0);
                3.5e4 * strain * geometry.area_mm2(x[k]) * 1e-6 + normal.sample(&mut random)
            })
            .collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.head.specimen.shape = Some(Shape::Cylinder);
        trace.head.specimen.radius_mm = Some(25.0);
        trace.head.specimen.height_mm = Some(30.0);
        trace.head.specimen.poisson_ratio = Some(0.48);
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    }

    fn study(drift: f64) -> Study {
        let speeds = [20.0, 40.0, 60.0, 80.0, 100.0];
        let traces: Vec<Trace> =
            (0..5).map(|k| pressed(speeds[k], 0.05, drift, k as u64)).collect();
        rates(&traces, 1, Faces::One).unwrap()
    }

    #[test]
    fn stiffness_rate_and_asymptotes_come_back() {
        let found = study(0.0);
        let (v1, error) = found.v1;
        assert!((v1 - 0.5).abs() < 4.0 * error.unwrap(), "{v1}");
        let (stiffness, error) = found.stiffness_pa;
        assert!((stiffness - 3.5e4).abs() < 4.0 * error.unwrap() + 1e-3 * stiffness, "{stiffness}");
        let group = &found.groups[0];
        assert!(group.asymptotes.unwrap().p_value > 1e-3);
        assert!(found.runs.windows(2).all(|pair| pair[0].rate_mm_per_s < pair[1].rate_mm_per_s));
        let stiffening = group.peak_trend.unwrap();
        assert!(stiffening.slope_n.0 > 0.0 && stiffening.p_value < 0.05, "{stiffening:?}");
    }

    #[test]
    fn a_rise_that_is_not_straight_is_shown_by_the_standard_errors_of_the_peaks() {
        // Printed of a simulated silicone: χ² 72 for 4 degrees of freedom, and no straight line.
        let decades = [20.0f64, 40.0, 60.0, 80.0, 100.0].map(f64::log10);
        let peaks =
            [(21.122, 0.024), (21.286, 0.024), (21.329, 0.022), (21.381, 0.023), (21.338, 0.023)]
                .map(|(peak, error)| (peak, Some(error)));
        let found = trend(&decades, &peaks).unwrap();
        assert!(found.slope_n.0 > 0.0 && found.p_value < 1e-10, "{found:?}");
        assert!(agreement(&peaks).unwrap().p_value < 1e-12);
        assert_eq!(found.off_line.unwrap().degrees_of_freedom, 3);
        // Without errors there is the scatter alone, which five runs cannot tell from chance.
        let bare = peaks.map(|(peak, _)| (peak, None));
        let scattered = trend(&decades, &bare).unwrap();
        assert!(scattered.p_value > 0.01 && scattered.off_line.is_none(), "{scattered:?}");
    }

    #[test]
    fn equal_peaks_show_no_trend() {
        let decades = [20.0f64, 50.0, 100.0].map(f64::log10);
        let peaks = [(5.01, Some(0.02)), (4.99, Some(0.02)), (5.0, Some(0.02))];
        assert!(trend(&decades, &peaks).unwrap().p_value > 0.1);
    }

    #[test]
    fn asymptotes_that_depend_on_the_rate_are_told() {
        let group = &study(0.02).groups[0];
        assert!(group.asymptotes.unwrap().p_value < 1e-6);
        assert!(group.asymptote_trend.unwrap().p_value < 1e-3);
    }

    #[test]
    fn the_surface_runs_ahead_and_comes_back_to_the_equilibrium() {
        let trace = pressed(100.0, 0.0, 0.0, 1);
        let found = rates(std::slice::from_ref(&trace), 1, Faces::One).unwrap();
        let course = found.course(&found.runs[0], &trace).unwrap();
        let peak = course.surface.iter().copied().fold(0.0, f64::max);
        assert!(peak > 1.3 * 0.2, "{peak}");
        let last = course.time.len() - 1;
        assert!((course.surface[last] - course.equilibrium[last]).abs() < 1e-3);
        assert!(course.latent_rate.iter().all(|rate| *rate < 1e-3));
    }
}
