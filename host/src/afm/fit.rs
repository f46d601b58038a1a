//! Baseline, contact point, modulus and adhesion of a force curve.
//!
//! The approach is fitted as a whole: F = b0 + b1 z + f(z − z0), f the force of tip and cantilever in series
//! ([`Law`]). So the noise stays on the force alone, where it is, and does not enter the depth; and the standard errors of
//! the contact point and the modulus include that of the baseline. They know nothing of the errors of spring constant,
//! sensitivity and tip radius, which come on top.

use std::f64::consts::PI;
use std::ops::Range;

use super::curve::ForceCurve;
use super::hold::{self, Relaxed};
use super::law::Law;
use super::least::{Fitted, least_squares};
use super::pressure::modulus_factor;
use super::{AfmError, Estimate, within};
use crate::contact::Tip;
use crate::grasp::PressureLaw;

/// What is known of tip and specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The tip.
    pub tip: Tip,
    /// Poisson's ratio of the specimen.
    pub poisson_ratio: f64,
    /// Pressure of the contact; Hertz's by default.
    pub pressure: PressureLaw,
}

/// The approach, fitted.
#[derive(Clone, Debug)]
pub struct CurveFit {
    /// Force of the baseline at the contact point, N.
    pub offset_n: f64,
    /// Tilt of the baseline, N per m of the piezo's way.
    pub tilt_n_per_m: f64,
    /// Where the straight cantilever would touch, m, on the piezo's way.
    pub contact_m: Estimate,
    /// Young's modulus, Pa; none where the curve does not tell it.
    pub modulus_pa: Option<Estimate>,
    /// Why it does not.
    pub no_modulus: Option<String>,
    /// Pull of adhesion during the approach, N, where the curve shows a jump into contact.
    pub approach_pull_n: Option<Estimate>,
    /// Noise of the force out of contact, N.
    pub noise_n: f64,
    /// Root mean square of what the fit leaves, N.
    pub residual_rms_n: f64,
    /// Samples fitted, and outliers of the baseline left out.
    pub samples: usize,
    /// Outliers of the baseline that were left out.
    pub left_out: usize,
    /// Depth at the end of the approach, m.
    pub depth_m: f64,
    /// Force there, N.
    pub force_n: f64,
    /// Slope of force over the piezo's way there, over the spring constant: 1 for a rigid specimen.
    pub slope_over_spring: Option<f64>,
    /// Tip, reduced modulus and pull that were fitted, by Hertz's law.
    pub law: Law,
    /// What the retreat says of adhesion; none without a retreat.
    pub retreat: Option<Retreat>,
    /// What the hold says of relaxation, or why nothing; none without a hold.
    pub hold: Option<Result<Relaxed, String>>,
}

/// Adhesion on the way back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retreat {
    /// Largest pull below the baseline, N.
    pub pull_off_n: f64,
    /// Noise there, N.
    pub noise_n: f64,
    /// Whether the pull stands out of the noise five times.
    pub adheres: bool,
    /// Energy that the pull takes, J.
    pub energy_j: f64,
    /// Work of adhesion, J/m², if the contact is that of Derjaguin, Muller and Toporov, F = 2πwR; round tips only.
    pub work_dmt: Option<f64>,
    /// The same if it is that of Johnson, Kendall and Roberts, F = 3/2 πwR.
    pub work_jkr: Option<f64>,
    /// Tabor's number with 0.3 nm between the atoms: below 0.1 the first holds, above 5 the second.
    pub tabor: Option<f64>,
}

/// Fewest samples of an approach.
const LEAST: usize = 30;
/// Above this slope over spring constant the specimen bends less than a ninth of what the cantilever does.
const RIGID: f64 = 0.9;
/// No contact is stiffer than the cantilever alone, whose slope is 1; beyond this it is no error of the reading.
const IMPOSSIBLE: f64 = 1.05;
/// Relative standard error above which a modulus is not told.
const VAGUE: f64 = 0.5;
/// Part of the way, from the far end, that is certainly baseline for a start.
const FAR: f64 = 0.2;
/// Deviations beyond which a sample of the baseline is an outlier.
const OUTLIER: f64 = 5.0;
/// A jump into contact is fitted where it lowers the criterion (BIC) by this.
const EVIDENT: f64 = 10.0;
/// Distance between atoms at rest, m, in Tabor's number.
const ATOMS: f64 = 0.3e-9;

/// Fits a force curve.
///
/// # Errors
/// [`AfmError::Short`], [`AfmError::NoContact`], [`AfmError::Range`] for options that cannot be.
pub fn fit(curve: &ForceCurve, options: &Options) -> Result<CurveFit, AfmError> {
    check(curve, options)?;
    let approach = Approach::new(curve, options.tip)?;
    let start = approach.start();
    let all: Vec<usize> = (0..approach.z.len()).collect();
    let first = approach.best(&start, &all);
    let noise = approach.noise(&first, &all);
    let kept: Vec<usize> =
        all.iter().copied().filter(|&i| !approach.is_outlier(&first, i, noise)).collect();
    let left_out = all.len() - kept.len();
    let found = if left_out > 0 { approach.best(&start, &kept) } else { first };
    let noise = approach.noise(&found, &kept);
    let mut fit = approach.result(&found, noise, options);
    if fit.force_n < OUTLIER * noise {
        return Err(AfmError::NoContact { curve: curve.label.clone() });
    }
    (fit.samples, fit.left_out) = (kept.len(), left_out);
    let retract = curve.segments.retract.clone().filter(|range| range.len() >= LEAST);
    fit.retreat = retract.map(|range| retreat(curve, range, options, &fit));
    fit.hold = curve.segments.hold.clone().map(|range| hold::relaxed(curve, range, &fit));
    Ok(fit)
}

fn check(curve: &ForceCurve, options: &Options) -> Result<(), AfmError> {
    within("Poisson's ratio", options.poisson_ratio, -0.99, 0.5)?;
    match options.tip {
        Tip::Paraboloid { radius_m } | Tip::Sphere { radius_m } => {
            within("the tip's radius (nm)", radius_m * 1e9, 0.1, 1e9)?;
        }
        Tip::Cone { half_angle_rad } => {
            within("the half angle (degrees)", half_angle_rad.to_degrees(), 1.0, 89.0)?;
            if options.pressure != PressureLaw::HERTZ {
                return Err(AfmError::ConeWithPressure);
            }
        }
    }
    if let Some(k) = curve.spring_n_per_m {
        within("the spring constant (N/m)", k, 1e-6, 1e6)?;
    }
    Ok(())
}

/// The approach in numbers about one: ways over the whole way, forces over the whole range of force.
struct Approach {
    z: Vec<f64>,
    force: Vec<f64>,
    /// Way at 0 and whole way, m; range of force, N.
    from: f64,
    way: f64,
    range: f64,
    tip: Tip,
    spring: Option<f64>,
}

/// Coordinates: offset, tilt, contact point, and ln of the reduced modulus over that of the start; last, perhaps, the pull.
struct Start {
    point: [f64; 4],
    reduced_modulus: f64,
}

struct Found {
    fitted: Fitted,
    reduced_modulus: f64,
    criterion: f64,
}

impl Found {
    fn point(&self) -> &[f64] {
        &self.fitted.solution.point
    }
}

impl Approach {
    fn new(curve: &ForceCurve, tip: Tip) -> Result<Self, AfmError> {
        let range = curve.segments.approach.clone();
        let short =
            || AfmError::Short { curve: curve.label.clone(), samples: range.len(), least: LEAST };
        if range.len() < LEAST {
            return Err(short());
        }
        let (z, force) = (&curve.piezo_m[range.clone()], &curve.force_n[range.clone()]);
        let extent = |values: &[f64]| {
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
                (low.min(x), high.max(x))
            })
        };
        let ((from, to), (least, most)) = (extent(z), extent(force));
        if to <= from || most <= least {
            return Err(short());
        }
        let (way, span) = (to - from, most - least);
        Ok(Self {
            z: z.iter().map(|z| (z - from) / way).collect(),
            force: force.iter().map(|force| force / span).collect(),
            from,
            way,
            range: span,
            tip,
            spring: curve.spring_n_per_m,
        })
    }

    /// Baseline by a robust line through the far end; contact where a line with a power of the way beyond it fits best.
    fn start(&self) -> Start {
        let far: Vec<usize> = (0..self.z.len()).filter(|&i| self.z[i] <= FAR).collect();
        let pick = |values: &[f64]| far.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        let line = RobustLine::through(&pick(&self.z), &pick(&self.force));
        let rest: Vec<f64> =
            self.z.iter().zip(&self.force).map(|(z, force)| force - line.at(*z)).collect();
        let mut best = (f64::INFINITY, 0.5);
        for contact in (10..99).map(|percent| f64::from(percent) * 0.01) {
            for power in [1.0, self.tip.exponent()] {
                let shape = |z: f64| (z - contact).max(0.0).powf(power);
                let (mut top, mut bottom) = (0.0, 0.0);
                for (z, force) in self.z.iter().zip(&rest) {
                    top += shape(*z) * force;
                    bottom += shape(*z).powi(2);
                }
                let factor = (top / bottom.max(f64::MIN_POSITIVE)).max(0.0);
                let miss = self.z.iter().zip(&rest).map(|(z, f)| (f - factor * shape(*z)).powi(2));
                let miss: f64 = miss.sum();
                if miss < best.0 {
                    best = (miss, contact);
                }
            }
        }
        let contact = best.1;
        let last = rest.len() - (rest.len() / 50).max(1);
        let end = rest[last..].iter().sum::<f64>() / (rest.len() - last) as f64;
        let force = (end * self.range).max(1e-3 * self.range);
        let beyond = (1.0 - contact) * self.way;
        let bent = self.spring.map_or(0.0, |k| force / k);
        let depth = (beyond - bent).max(0.05 * beyond);
        let reduced_modulus = force / self.tip.force(1.0, depth);
        Start { point: [line.offset, line.slope, contact, 0.0], reduced_modulus }
    }

    /// Without a pull of adhesion, or with one where that is evident.
    fn best(&self, start: &Start, kept: &[usize]) -> Found {
        let without = self.fitted(start, kept, None);
        let lowest = kept.iter().map(|&i| self.force[i] - start.point[0]).fold(0.0, f64::min);
        let with = self.fitted(start, kept, Some(-lowest));
        if with.criterion + EVIDENT < without.criterion { with } else { without }
    }

    fn fitted(&self, start: &Start, kept: &[usize], pull: Option<f64>) -> Found {
        let mut point = start.point.to_vec();
        let mut bounds = vec![(-1e12, 1e12), (-1e6, 1e6), (-0.5, 1.0), (-14.0, 14.0)];
        if let Some(pull) = pull {
            point.push(pull);
            bounds.push((0.0, 2.0));
        }
        let residuals = |point: &[f64]| {
            let law = self.law(point, start.reduced_modulus);
            kept.iter().map(|&i| self.predicted(point, &law, i) - self.force[i]).collect()
        };
        let fitted = least_squares(&bounds, &point, kept.len(), residuals);
        let count = kept.len() as f64;
        let cost = fitted.solution.normal.cost.max(f64::MIN_POSITIVE);
        let criterion = count * (cost / count).ln() + point.len() as f64 * count.ln();
        Found { fitted, reduced_modulus: start.reduced_modulus, criterion }
    }

    fn law(&self, point: &[f64], reduced_modulus: f64) -> Law {
        Law {
            tip: self.tip,
            reduced_modulus: reduced_modulus * point[3].exp(),
            adhesion_n: point.get(4).map_or(0.0, |pull| pull * self.range),
        }
    }

    fn predicted(&self, point: &[f64], law: &Law, i: usize) -> f64 {
        let contact = law.force((self.z[i] - point[2]) * self.way, self.spring);
        point[0] + point[1] * self.z[i] + contact / self.range
    }

    fn rest(&self, found: &Found, i: usize) -> f64 {
        let law = self.law(found.point(), found.reduced_modulus);
        self.force[i] - self.predicted(found.point(), &law, i)
    }

    /// Whether a sample lies before the touch, a little off from it.
    fn is_before(&self, found: &Found, i: usize) -> bool {
        self.z[i] < found.point()[2] - 0.02
    }

    /// Deviation of the baseline's samples, robust, N.
    fn noise(&self, found: &Found, kept: &[usize]) -> f64 {
        let before = kept.iter().filter(|&&i| self.is_before(found, i));
        let mut sizes: Vec<f64> = before.map(|&i| self.rest(found, i).abs()).collect();
        if sizes.is_empty() {
            return found.fitted.rms * self.range;
        }
        sizes.sort_by(f64::total_cmp);
        sizes[sizes.len() / 2] * MAD * self.range
    }

    fn is_outlier(&self, found: &Found, i: usize, noise: f64) -> bool {
        self.is_before(found, i) && (self.rest(found, i) * self.range).abs() > OUTLIER * noise
    }

    fn result(&self, found: &Found, noise_n: f64, options: &Options) -> CurveFit {
        let (point, errors) = (found.point(), &found.fitted.standard_errors);
        let law = self.law(point, found.reduced_modulus);
        let contact = self.from + point[2] * self.way;
        let force_n = law.force((1.0 - point[2]) * self.way, self.spring);
        let v = options.poisson_ratio;
        let value = law.reduced_modulus * (1.0 - v * v) * modulus_factor(options.pressure);
        let modulus = Estimate { value, standard_error: value * errors[3] };
        let slope_over_spring = self.spring.map(|k| self.end_slope(point[2]) / k);
        let no_modulus = reason(&modulus, slope_over_spring);
        CurveFit {
            offset_n: (point[0] + point[1] * point[2]) * self.range,
            tilt_n_per_m: point[1] * self.range / self.way,
            contact_m: Estimate { value: contact, standard_error: errors[2] * self.way },
            modulus_pa: no_modulus.is_none().then_some(modulus),
            no_modulus,
            approach_pull_n: point.get(4).map(|pull| Estimate {
                value: pull * self.range,
                standard_error: errors[4] * self.range,
            }),
            noise_n,
            residual_rms_n: found.fitted.rms * self.range,
            samples: 0,
            left_out: 0,
            depth_m: (1.0 - point[2]) * self.way - self.spring.map_or(0.0, |k| force_n / k),
            force_n,
            slope_over_spring,
            law,
            retreat: None,
            hold: None,
        }
    }

    /// Slope of force over way in the last half of the contact, N/m.
    fn end_slope(&self, contact: f64) -> f64 {
        let deep = 0.5 * (1.0 + contact.clamp(0.0, 0.98));
        let inside = (0..self.z.len()).filter(|&i| self.z[i] >= deep);
        let (x, y): (Vec<f64>, Vec<f64>) = inside.map(|i| (self.z[i], self.force[i])).unzip();
        RobustLine::through(&x, &y).slope * self.range / self.way
    }
}

/// Why a modulus is not told, if it is not.
fn reason(modulus: &Estimate, slope_over_spring: Option<f64>) -> Option<String> {
    if let Some(slope) = slope_over_spring.filter(|slope| *slope > RIGID) {
        let mut words = format!(
            "the force grows with {slope:.2} times the spring constant: the cantilever bends as far as the piezo moves, and the specimen hardly at all; take a stiffer cantilever"
        );
        if slope > IMPOSSIBLE {
            words +=
                ". Above 1 it cannot be: sensitivity, spring constant or height are not calibrated";
        }
        return Some(words);
    }
    let vague = modulus.standard_error / modulus.value;
    let told = vague.is_finite() && vague <= VAGUE;
    (!told).then(|| "its standard error is above half of it: press deeper".into())
}

/// Median of the size of a normal deviate to its standard deviation.
const MAD: f64 = 1.482_602_218_505_602;

/// A straight line by Huber's weights, which outliers do not bend.
struct RobustLine {
    offset: f64,
    slope: f64,
    noise: f64,
}

impl RobustLine {
    fn through(x: &[f64], y: &[f64]) -> Self {
        let mut line = Self { offset: 0.0, slope: 0.0, noise: f64::INFINITY };
        for _ in 0..20 {
            let weight = |i: usize| {
                let off = (y[i] - line.at(x[i])).abs();
                if off > 1.345 * line.noise { 1.345 * line.noise / off } else { 1.0 }
            };
            let weights: Vec<f64> = (0..x.len()).map(weight).collect();
            let sum =
                |f: &dyn Fn(usize) -> f64| -> f64 { (0..x.len()).map(|i| weights[i] * f(i)).sum() };
            let whole = sum(&|_| 1.0).max(f64::MIN_POSITIVE);
            let (mean_x, mean_y) = (sum(&|i| x[i]) / whole, sum(&|i| y[i]) / whole);
            let spread = sum(&|i| (x[i] - mean_x).powi(2));
            let both = sum(&|i| (x[i] - mean_x) * (y[i] - mean_y));
            line.slope = if spread > 0.0 { both / spread } else { 0.0 };
            line.offset = mean_y - line.slope * mean_x;
            let mut sizes: Vec<f64> = (0..x.len()).map(|i| (y[i] - line.at(x[i])).abs()).collect();
            sizes.sort_by(f64::total_cmp);
            line.noise = sizes.get(sizes.len() / 2).map_or(0.0, |middle| middle * MAD);
        }
        line
    }

    fn at(&self, x: f64) -> f64 {
        self.offset + self.slope * x
    }
}

/// The pull below the baseline of the retreat's far end.
fn retreat(curve: &ForceCurve, range: Range<usize>, options: &Options, fit: &CurveFit) -> Retreat {
    let (z, force) = (&curve.piezo_m[range.clone()], &curve.force_n[range]);
    let far = z.len() - z.len() / 4;
    let line = RobustLine::through(&z[far..], &force[far..]);
    let pulls: Vec<f64> = z.iter().zip(force).map(|(z, force)| line.at(*z) - force).collect();
    let pull_off_n = pulls.iter().copied().fold(0.0, f64::max);
    let counted = |pull: f64| if pull > 3.0 * line.noise { pull } else { 0.0 };
    let energy_j = (1..z.len())
        .map(|i| 0.5 * (counted(pulls[i]) + counted(pulls[i - 1])) * (z[i] - z[i - 1]).abs())
        .sum();
    let adheres = pull_off_n > OUTLIER * line.noise;
    let radius = match options.tip {
        Tip::Paraboloid { radius_m } | Tip::Sphere { radius_m } if adheres => Some(radius_m),
        _ => None,
    };
    let work_dmt = radius.map(|radius| pull_off_n / (2.0 * PI * radius));
    let told = fit.modulus_pa.is_some();
    let tabor = radius.zip(work_dmt).filter(|_| told).map(|(radius, work)| {
        (radius * (work / fit.law.reduced_modulus).powi(2) / ATOMS.powi(3)).cbrt()
    });
    Retreat {
        pull_off_n,
        noise_n: line.noise,
        adheres,
        energy_j,
        work_dmt,
        work_jkr: work_dmt.map(|work| work * 4.0 / 3.0),
        tabor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::afm::simulate::Practice;
    use crate::contact::Elastic;
    use crate::model::Relaxation;

    fn options(tip: Tip) -> Options {
        Options { tip, poisson_ratio: 0.5, pressure: PressureLaw::HERTZ }
    }

    fn fitted(practice: &Practice, seed: u64) -> Result<CurveFit, AfmError> {
        let curve = ForceCurve::of(&practice.curve(seed).unwrap()).unwrap();
        fit(&curve, &options(practice.tip))
    }

    #[test]
    fn every_shape_of_tip_finds_the_modulus_and_the_contact_point() {
        for tip in [
            Tip::Paraboloid { radius_m: 2.5e-6 },
            Tip::Sphere { radius_m: 2.5e-6 },
            Tip::Cone { half_angle_rad: 0.6 },
        ] {
            let baseline = [3e-9, 5e-5];
            let practice = Practice { tip, baseline, ..Practice::gel() };
            let found = fitted(&practice, 4).unwrap();
            let modulus = found.modulus_pa.unwrap();
            assert!((modulus.value / 5e3 - 1.0).abs() < 4.0 * modulus.standard_error / 5e3);
            assert!(modulus.standard_error < 100.0, "{tip:?}: {modulus:?}");
            let contact = found.contact_m;
            assert!(contact.value.abs() < 4.0 * contact.standard_error, "{tip:?}: {contact:?}");
            assert!((found.tilt_n_per_m / 5e-5 - 1.0).abs() < 0.2, "{}", found.tilt_n_per_m);
            assert!((found.noise_n / 2e-11 - 1.0).abs() < 0.2, "{}", found.noise_n);
        }
    }

    #[test]
    fn a_pull_is_found_both_ways_and_none_where_there_is_none() {
        let practice = Practice { pull_n: 3e-10, ..Practice::gel() };
        let found = fitted(&practice, 2).unwrap();
        let pull = found.approach_pull_n.unwrap();
        assert!((pull.value - 3e-10).abs() < 4.0 * pull.standard_error, "{pull:?}");
        let retreat = found.retreat.unwrap();
        assert!(retreat.adheres && (retreat.pull_off_n / 3e-10 - 1.0).abs() < 0.25, "{retreat:?}");
        let found = fitted(&Practice::gel(), 2).unwrap();
        assert!(found.approach_pull_n.is_none() && !found.retreat.unwrap().adheres);
    }

    #[test]
    fn a_specimen_that_is_too_stiff_and_a_curve_without_contact_are_said_to_be_so() {
        let specimen = Elastic { modulus_pa: 1e9, poisson_ratio: 0.5 };
        let found = fitted(&Practice { specimen, ..Practice::gel() }, 1).unwrap();
        assert_eq!(found.modulus_pa, None);
        assert!(found.no_modulus.unwrap().contains("stiffer cantilever"));
        let trace = Practice::gel().curve(1).unwrap();
        let mut curve = ForceCurve::of(&trace).unwrap();
        curve.segments.approach = 0..200;
        let error = fit(&curve, &options(Practice::gel().tip)).unwrap_err();
        assert!(matches!(error, AfmError::NoContact { .. }), "{error}");
    }

    #[test]
    fn outliers_of_the_baseline_are_left_out() {
        let mut curve = ForceCurve::of(&Practice::gel().curve(6).unwrap()).unwrap();
        for i in [20, 90, 133] {
            curve.force_n[i] += 2e-9;
        }
        let found = fit(&curve, &options(Practice::gel().tip)).unwrap();
        assert_eq!(found.left_out, 3);
        assert!((found.modulus_pa.unwrap().value / 5e3 - 1.0).abs() < 0.05);
    }

    #[test]
    fn a_hold_gives_the_rates_that_it_was_made_with() {
        let relaxation = Relaxation::new(&[0.3], &[2.0]);
        let practice = Practice { relaxation, hold_s: 4.0, noise_n: 1e-12, ..Practice::gel() };
        let found = fitted(&practice, 3).unwrap();
        let held = found.hold.unwrap().unwrap();
        // The cantilever lets the depth grow a little while the force falls, which slows it by a few per cent.
        let terms = held.exponentials.sum.terms.iter();
        let largest = terms.max_by(|a, b| a.coefficient.total_cmp(&b.coefficient)).unwrap();
        assert!((1.5..3.5).contains(&largest.rate), "{largest:?}");
        assert!(held.power.rms <= held.linear.rms * 1.001);
        assert!(held.linear.equilibrium.value < 1.0 && held.linear.rate.value > 1.0);
    }
}
