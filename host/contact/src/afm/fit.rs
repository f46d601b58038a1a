//! Baseline, contact point, modulus, relaxation and adhesion of a force curve.
//!
//! The curve is fitted as a whole, way in, pauses and way back, by the hereditary contact law of tip and cantilever in series
//! ([`super::hereditary`]) over a tilted baseline; so a force that relaxes is not taken for one that adheres. Where the tip
//! adheres on the way back, which Ting's law does not know, only the baseline of the way back counts. The noise stays on the
//! force alone, where it is, and does not enter the depth; and the standard errors of the contact point and the modulus
//! include those of baseline and relaxation. They know nothing of the errors of spring constant, sensitivity and tip radius,
//! which come on top.

use std::f64::consts::PI;
use std::ops::Range;

use super::curve::ForceCurve;
use super::hold::{self, Relaxed};
use super::identify::{CONTACT, Found, OFFSET, Samples, Start, TILT};
use super::law::Law;
use super::pressure::modulus_factor;
use super::{AfmError, Estimate, within};
use crate::Tip;
use crate::grasp::PressureLaw;
use palpate_model::Relaxation;

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

/// One exponential of the relaxation function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponential {
    /// Share of the modulus at once.
    pub share: Estimate,
    /// Rate, 1/s.
    pub rate: Estimate,
}

/// A pause of the piezo.
#[derive(Clone, Debug)]
pub struct Held {
    /// Its samples.
    pub range: Range<usize>,
    /// What it says of relaxation, or why nothing.
    pub relaxed: Result<Relaxed, String>,
}

/// The curve, fitted.
#[derive(Clone, Debug)]
pub struct CurveFit {
    /// Force of the baseline at the contact point, N.
    pub offset_n: f64,
    /// Tilt of the baseline, N per m of the piezo's way.
    pub tilt_n_per_m: f64,
    /// Where the straight cantilever would touch, m, on the piezo's way.
    pub contact_m: Estimate,
    /// Young's modulus at once, E(0), Pa; none where the curve does not tell it.
    pub modulus_pa: Option<Estimate>,
    /// Young's modulus that remains, E(∞), Pa; none where nothing relaxes or the curve does not tell it.
    pub equilibrium_modulus_pa: Option<Estimate>,
    /// What of E(0) relaxes, the fastest first; empty where no relaxation is evident.
    pub relaxation: Vec<Exponential>,
    /// Whether the way back was fitted too, and not its baseline alone.
    pub follows_back: bool,
    /// Drag of the medium on the cantilever, N: pushing on the way in, pulling on the way back; none without a way back.
    pub drag_n: Option<f64>,
    /// Why it does not.
    pub no_modulus: Option<String>,
    /// Pull of adhesion during the approach, N, where the curve shows a jump into contact.
    pub approach_pull_n: Option<Estimate>,
    /// Noise of the force out of contact, N.
    pub noise_n: f64,
    /// Root mean square of what the fit leaves, N.
    pub residual_rms_n: f64,
    /// Samples fitted.
    pub samples: usize,
    /// Outliers of the baseline that were left out.
    pub left_out: usize,
    /// Depth where the force is largest, m.
    pub depth_m: f64,
    /// Largest force of the fit, N.
    pub force_n: f64,
    /// Slope of force over the piezo's way at the end of the way in, over the spring constant: 1 for a rigid specimen.
    pub slope_over_spring: Option<f64>,
    /// Tip, reduced modulus and pull that were fitted, by Hertz's law.
    pub law: Law,
    /// What the retreat says of adhesion; none without a retreat.
    pub retreat: Option<Retreat>,
    /// The pauses, in order.
    pub holds: Vec<Held>,
    /// Baseline at each sample, N.
    pub baseline_n: Vec<f64>,
    /// Fitted force of the contact at each sample, N; none on a way back that was not fitted.
    pub contact_n: Vec<Option<f64>>,
}

impl CurveFit {
    /// The longest pause.
    #[must_use]
    pub fn longest_hold(&self) -> Option<&Held> {
        self.holds.iter().max_by_key(|held| held.range.len())
    }
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
const MIN_APPROACH_SAMPLES: usize = 30;
/// Above this slope over spring constant the specimen bends less than a ninth of what the cantilever does.
const RIGID: f64 = 0.9;
/// No contact is stiffer than the cantilever alone, whose slope is 1; beyond this it is no error of the reading.
const IMPOSSIBLE: f64 = 1.05;
/// Relative standard error above which a modulus is not told.
const VAGUE: f64 = 0.5;
/// Part of the way, from the far end, that is certainly baseline for a start.
const BASELINE_SHARE: f64 = 0.2;
/// Deviations beyond which a sample of the baseline is an outlier.
const OUTLIER: f64 = 5.0;
/// Most exponentials of a specimen whose pause or way back tells of them, and where neither does.
pub const TERMS: usize = 3;
const TERMS_OF_AN_APPROACH: usize = 1;
/// Samples beyond which blocks are averaged for the fit.
const MANY: usize = 8000;
/// Distance between atoms at rest, m, in Tabor's number.
const ATOMS: f64 = 0.3e-9;

/// Fits a force curve.
///
/// # Errors
/// [`AfmError::Short`], [`AfmError::NoContact`], [`AfmError::Range`] for options that cannot be.
pub fn fit(curve: &ForceCurve, options: &Options) -> Result<CurveFit, AfmError> {
    check(curve, options)?;
    let retract =
        curve.segments.retract.clone().filter(|range| range.len() >= MIN_APPROACH_SAMPLES);
    let back = retract.map(|range| Back::of(curve, range));
    let mut scaled = Scaled::of(curve, options.tip, back.as_ref())?;
    let start = scaled.start(back.is_some());
    let first = scaled.first(&start);
    let noise = scaled.noise(&first);
    let left_out = scaled.leave_out(&first, noise);
    let slope = scaled.end_slope(first.point()[CONTACT]);
    let start = Start { terms: scaled.most_terms(slope), ..start };
    let samples = &scaled.samples;
    let thin = (samples.z.len() > MANY).then(|| samples.thinned(MANY));
    let found = thin.as_ref().unwrap_or(samples).identify(&start);
    let noise = scaled.noise(&found);
    let mut fit = scaled.result(&found, noise, slope, options);
    if fit.force_n < OUTLIER * noise {
        return Err(AfmError::NoContact { curve: curve.label.clone() });
    }
    fit.left_out = left_out;
    fit.retreat = back.map(|back| back.adhesion(options, &fit));
    let pauses = curve.segments.pauses.iter();
    fit.holds = pauses
        .map(|range| Held {
            range: range.clone(),
            relaxed: hold::relaxed(curve, range.clone(), &fit),
        })
        .collect();
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

/// A curve in numbers about one.
struct Scaled<'a> {
    curve: &'a ForceCurve,
    samples: Samples,
    /// Way at 0, m.
    from: f64,
}

impl<'a> Scaled<'a> {
    fn of(curve: &'a ForceCurve, tip: Tip, back: Option<&Back>) -> Result<Self, AfmError> {
        let range = curve.segments.approach.clone();
        let short = || AfmError::Short {
            curve: curve.label.clone(),
            samples: range.len(),
            least: MIN_APPROACH_SAMPLES,
        };
        if range.len() < MIN_APPROACH_SAMPLES {
            return Err(short());
        }
        let (z, force) = (&curve.piezo_m[range.clone()], &curve.force_n[range.clone()]);
        let from = z[0];
        let to = z.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (least, most) = force
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &f| (a.min(f), b.max(f)));
        if to <= from || most <= least {
            return Err(short());
        }
        let (way, span) = (to - from, most - least);
        let end = back.map_or(range.end, |back| back.range.end);
        let paused = |k: usize| curve.segments.pauses.iter().any(|pause| pause.contains(&k));
        let sense = |k: usize| match (k >= range.end, paused(k)) {
            (true, _) => -1.0,
            (false, true) => 0.0,
            (false, false) => 1.0,
        };
        let follows_back = back.is_some_and(|back| !back.adheres);
        let counts = |k: usize| {
            k >= range.start && back.is_none_or(|b| k < range.end || follows_back || k >= b.far)
        };
        let all = range.start..end;
        let samples = Samples {
            time: curve.time_s[all.clone()].to_vec(),
            z: curve.piezo_m[all.clone()].iter().map(|z| (z - from) / way).collect(),
            force: curve.force_n[all.clone()].iter().map(|force| force / span).collect(),
            sense: all.clone().map(sense).collect(),
            counts: all.map(counts).collect(),
            leaves: range.len(),
            follows_back,
            way,
            range: span,
            tip,
            spring: curve.spring_n_per_m,
        };
        Ok(Self { curve, samples, from })
    }

    /// The samples at which the piezo moves in.
    fn moving(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.samples.leaves).filter(|&k| self.samples.sense[k] > 0.0)
    }

    /// Baseline by a robust line through the far end; contact where a line with a power of the way beyond it fits best.
    fn start(&self, drag: bool) -> Start {
        let (z, force): (Vec<f64>, Vec<f64>) =
            self.moving().map(|k| (self.samples.z[k], self.samples.force[k])).unzip();
        let far = z.partition_point(|z| *z <= BASELINE_SHARE).max(2).min(z.len());
        let line = RobustLine::through(&z[..far], &force[..far]);
        let rest: Vec<f64> = z.iter().zip(&force).map(|(z, force)| force - line.at(*z)).collect();
        let mut best = (f64::INFINITY, 0.5);
        for contact in (10..99).map(|percent| f64::from(percent) * 0.01) {
            for power in [1.0, self.samples.tip.exponent()] {
                let shape = |z: f64| (z - contact).max(0.0).powf(power);
                let (mut top, mut bottom) = (0.0, 0.0);
                for (z, force) in z.iter().zip(&rest) {
                    top += shape(*z) * force;
                    bottom += shape(*z).powi(2);
                }
                let factor = (top / bottom.max(f64::MIN_POSITIVE)).max(0.0);
                let miss = z.iter().zip(&rest).map(|(z, f)| (f - factor * shape(*z)).powi(2));
                let miss: f64 = miss.sum();
                if miss < best.0 {
                    best = (miss, contact);
                }
            }
        }
        let contact = best.1;
        let last = rest.len() - (rest.len() / 50).max(1);
        let end = rest[last..].iter().sum::<f64>() / (rest.len() - last) as f64;
        let force = (end * self.samples.range).max(1e-3 * self.samples.range);
        let beyond = (1.0 - contact) * self.samples.way;
        let bent = self.samples.spring.map_or(0.0, |k| force / k);
        let depth = (beyond - bent).max(0.05 * beyond);
        let reduced_modulus = force / self.samples.tip.force(1.0, depth);
        let (offset, tilt) = (line.offset, line.slope);
        Start { offset, tilt, contact, reduced_modulus, drag, terms: 0 }
    }

    /// A first fit, to see the baseline by: that of the way in alone, without memory.
    fn first(&mut self, start: &Start) -> Found {
        let counted = self.samples.counts.clone();
        for (k, counts) in self.samples.counts.iter_mut().enumerate() {
            *counts &= self.samples.sense[k] > 0.0;
        }
        let found = self.samples.simplest(&Start { drag: false, ..*start });
        self.samples.counts = counted;
        found
    }

    /// Force that a fit leaves at a sample, over the range, out of contact.
    fn rest(&self, found: &Found, k: usize) -> f64 {
        let point = found.point();
        self.samples.force[k] - point[OFFSET] - point[TILT] * self.samples.z[k] - found.drag()
    }

    /// Samples before the touch, a little off from it.
    fn before(&self, found: &Found) -> Vec<usize> {
        let touch = found.point()[CONTACT] - 0.02;
        self.moving()
            .take_while(|&k| self.samples.z[k] < touch)
            .filter(|&k| self.samples.counts[k])
            .collect()
    }

    /// Deviation of the baseline's samples, robust, N.
    fn noise(&self, found: &Found) -> f64 {
        let before = self.before(found).into_iter();
        let mut sizes: Vec<f64> = before.map(|k| self.rest(found, k).abs()).collect();
        if sizes.is_empty() {
            return found.rms() * self.samples.range;
        }
        sizes.sort_by(f64::total_cmp);
        sizes[sizes.len() / 2] * MAD * self.samples.range
    }

    /// Leaves out what lies off the baseline before the touch; says how many samples.
    fn leave_out(&mut self, found: &Found, noise: f64) -> usize {
        let before = self.before(found).into_iter();
        let off = |k: &usize| (self.rest(found, *k) * self.samples.range).abs() > OUTLIER * noise;
        let outliers: Vec<usize> = before.filter(off).collect();
        for &k in &outliers {
            self.samples.counts[k] = false;
        }
        outliers.len()
    }

    /// Most exponentials that the curve can tell.
    fn most_terms(&self, slope: f64) -> usize {
        let rigid = self.samples.spring.is_some_and(|k| slope / k > RIGID);
        match (rigid, self.samples.follows_back || !self.curve.segments.pauses.is_empty()) {
            (true, _) => 0,
            (false, true) => TERMS,
            (false, false) => TERMS_OF_AN_APPROACH,
        }
    }

    fn result(&self, found: &Found, noise_n: f64, end_slope: f64, options: &Options) -> CurveFit {
        let samples = &self.samples;
        let (point, law) = (found.point(), found.law(samples));
        let relaxation: Relaxation = found.relaxation();
        let contact = samples.contact(law, &relaxation, point[CONTACT]);
        let largest = (0..samples.leaves).max_by(|&a, &b| contact[a].total_cmp(&contact[b]));
        let largest = largest.unwrap_or(0);
        let force_n = contact[largest] * samples.range;
        let v = options.poisson_ratio;
        let value = law.reduced_modulus * (1.0 - v * v) * modulus_factor(options.pressure);
        let modulus = Estimate { value, standard_error: value * found.modulus_error() };
        let slope_over_spring = samples.spring.map(|k| end_slope / k);
        let no_modulus = reason(&modulus, slope_over_spring);
        let told = no_modulus.is_none();
        let (share, relative) = found.equilibrium();
        let remains = Estimate { value: value * share, standard_error: value * share * relative };
        let relaxes = !relaxation.branches.is_empty() && told && relative <= VAGUE;
        let estimate = |(value, standard_error): (f64, f64)| Estimate { value, standard_error };
        let begin = self.curve.segments.approach.start;
        let place = |i: usize| i.checked_sub(begin).filter(|k| *k < samples.z.len());
        let all = 0..self.curve.time_s.len();
        let followed = |k: &usize| *k < samples.leaves || samples.follows_back;
        CurveFit {
            offset_n: (point[OFFSET] + point[TILT] * point[CONTACT]) * samples.range,
            tilt_n_per_m: point[TILT] * samples.range / samples.way,
            contact_m: Estimate {
                value: self.from + point[CONTACT] * samples.way,
                standard_error: found.error(CONTACT) * samples.way,
            },
            modulus_pa: told.then_some(modulus),
            equilibrium_modulus_pa: relaxes.then_some(remains),
            relaxation: found
                .terms()
                .into_iter()
                .map(|[share, rate]| Exponential { share: estimate(share), rate: estimate(rate) })
                .collect(),
            follows_back: samples.follows_back,
            drag_n: (samples.leaves < samples.z.len()).then(|| found.drag() * samples.range),
            no_modulus,
            approach_pull_n: found.pull(samples).map(|(pull, error)| Estimate {
                value: pull * samples.range,
                standard_error: error * samples.range,
            }),
            noise_n,
            residual_rms_n: found.rms() * samples.range,
            samples: samples.counts.iter().filter(|counts| **counts).count(),
            left_out: 0,
            depth_m: (samples.z[largest] - point[CONTACT]) * samples.way
                - samples.spring.map_or(0.0, |k| force_n / k),
            force_n,
            slope_over_spring,
            law,
            retreat: None,
            holds: Vec::new(),
            baseline_n: all
                .clone()
                .map(|i| {
                    let z = (self.curve.piezo_m[i] - self.from) / samples.way;
                    let drag = place(i).map_or(0.0, |k| found.drag() * samples.sense[k]);
                    (point[OFFSET] + point[TILT] * z + drag) * samples.range
                })
                .collect(),
            contact_n: all
                .map(|i| Some(contact[place(i).filter(followed)?] * samples.range))
                .collect(),
        }
    }

    /// Slope of force over way in the last half of the contact, where the piezo last moved in, N/m.
    fn end_slope(&self, contact: f64) -> f64 {
        let moves = |k: &usize| self.samples.sense[*k] > 0.0;
        let end = (0..self.samples.leaves).rev().find(moves).map_or(0, |k| k + 1);
        let begin = (0..end).rev().find(|k| !moves(k)).map_or(0, |k| k + 1);
        let contact = contact.clamp(0.0, 0.98).max(self.samples.z[begin]);
        let deep = 0.5 * (self.samples.z[end.max(1) - 1] + contact);
        let inside = (begin..end).filter(|&k| self.samples.z[k] >= deep);
        let (x, y): (Vec<f64>, Vec<f64>) =
            inside.map(|k| (self.samples.z[k], self.samples.force[k])).unzip();
        RobustLine::through(&x, &y).slope * self.samples.range / self.samples.way
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

/// The way back.
struct Back {
    range: Range<usize>,
    /// First sample of its far end, which tells its baseline.
    far: usize,
    noise: f64,
    /// Largest pull below the baseline of the far end, N, and the energy that all of it takes, J.
    pull_off_n: f64,
    energy_j: f64,
    adheres: bool,
}

impl Back {
    fn of(curve: &ForceCurve, range: Range<usize>) -> Self {
        let (z, force) = (&curve.piezo_m[range.clone()], &curve.force_n[range.clone()]);
        let far = z.len() - z.len() / 4;
        let line = RobustLine::through(&z[far..], &force[far..]);
        let pulls: Vec<f64> = z.iter().zip(force).map(|(z, force)| line.at(*z) - force).collect();
        let pull_off_n = pulls.iter().copied().fold(0.0, f64::max);
        let counted = |pull: f64| if pull > 3.0 * line.noise { pull } else { 0.0 };
        let energy_j = (1..z.len())
            .map(|i| 0.5 * (counted(pulls[i]) + counted(pulls[i - 1])) * (z[i] - z[i - 1]).abs())
            .sum();
        let adheres = pull_off_n > OUTLIER * line.noise;
        Self { far: range.start + far, range, noise: line.noise, pull_off_n, energy_j, adheres }
    }

    fn adhesion(self, options: &Options, fit: &CurveFit) -> Retreat {
        let radius = match options.tip {
            Tip::Paraboloid { radius_m } | Tip::Sphere { radius_m } if self.adheres => {
                Some(radius_m)
            }
            _ => None,
        };
        let work_dmt = radius.map(|radius| self.pull_off_n / (2.0 * PI * radius));
        let told = fit.modulus_pa.is_some();
        let tabor = radius.zip(work_dmt).filter(|_| told).map(|(radius, work)| {
            (radius * (work / fit.law.reduced_modulus).powi(2) / ATOMS.powi(3)).cbrt()
        });
        Retreat {
            pull_off_n: self.pull_off_n,
            noise_n: self.noise,
            adheres: self.adheres,
            energy_j: self.energy_j,
            work_dmt,
            work_jkr: work_dmt.map(|work| work * 4.0 / 3.0),
            tabor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Elastic;
    use crate::afm::simulate::Practice;
    use palpate_model::Relaxation;

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
        let held = found.holds[0].relaxed.as_ref().unwrap();
        // The cantilever lets the depth grow a little while the force falls, which slows it by a few per cent.
        let terms = held.exponentials.sum.terms.iter();
        let largest = terms.max_by(|a, b| a.coefficient.total_cmp(&b.coefficient)).unwrap();
        assert!((1.5..3.5).contains(&largest.rate), "{largest:?}");
        assert!(held.power.rms <= held.linear.rms * 1.001);
        assert!(held.linear.equilibrium.value < 1.0 && held.linear.rate.value > 1.0);
    }
}
