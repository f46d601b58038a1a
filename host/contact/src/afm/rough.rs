//! What a rough surface does to a force curve, by Monte Carlo.
//!
//! Asperities stand on the specimen: so many per area, of Gaussian heights, each a ball of its own radius (Greenwood and
//! Williamson 1966). The tip touches those that reach it (Greenwood and Tripp 1967), each by Hertz, and the specimen below sinks
//! in as a whole by Hertz, in series: F = Σ f(d − δ(F) − r²/(2R) + h). Every trial draws another place of the surface. Its
//! curve is read as one reads a smooth one, from the line F^(2/3) over d, which gives an apparent modulus and contact point.

use std::f64::consts::PI;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal, Poisson, Uniform};
use rayon::prelude::*;

use super::{AfmError, within};
use crate::{Elastic, Tip};

/// A rough specimen under a round tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    /// The specimen.
    pub specimen: Elastic,
    /// Radius of the tip, m.
    pub radius_m: f64,
    /// Deepest depth of a smooth specimen's curve, m; all curves go to its force.
    pub depth_m: f64,
    /// Standard deviation of the heights, m.
    pub rms_m: f64,
    /// Asperities per m².
    pub density_per_m2: f64,
    /// Radius of an asperity, m.
    pub asperity_m: f64,
    /// Trials.
    pub trials: usize,
}

/// One place of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Apparent modulus over the true one.
    pub modulus_ratio: f64,
    /// Apparent contact point, m above the mean surface.
    pub contact_m: f64,
    /// Asperities that bear at the largest force.
    pub touching: usize,
}

/// Mean, standard deviation and the middle 90 % of a figure over the trials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation.
    pub deviation: f64,
    /// From the fifth to the ninety-fifth hundredth.
    pub middle: (f64, f64),
}

/// The spread of every figure over the trials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spreads {
    /// Apparent modulus over the true one.
    pub modulus_ratio: Spread,
    /// Apparent contact point, m above the mean surface.
    pub contact_m: Spread,
    /// Asperities that bear at the largest force.
    pub touching: Spread,
}

impl Spreads {
    /// The spreads over trials; there are two at least.
    #[must_use]
    pub fn of(trials: &[Trial]) -> Self {
        Self {
            modulus_ratio: spread(trials, |trial| trial.modulus_ratio),
            contact_m: spread(trials, |trial| trial.contact_m),
            touching: spread(trials, |trial| trial.touching as f64),
        }
    }
}

/// Forces, as parts of the largest, at which a curve is read.
const READ: [f64; 12] = [0.08, 0.16, 0.24, 0.32, 0.40, 0.48, 0.56, 0.64, 0.72, 0.80, 0.90, 1.0];
/// Heights beyond so many deviations are not waited for.
const HIGHEST: f64 = 4.5;
/// Most asperities in one trial, on average.
const MAX_ASPERITIES: f64 = 1e5;

impl Rough {
    /// All trials, in order; the same on any number of threads.
    ///
    /// # Errors
    /// [`AfmError::Range`] for what cannot be.
    pub fn run(&self, seed: u64) -> Result<Vec<Trial>, AfmError> {
        within("the modulus (Pa)", self.specimen.modulus_pa, 1e-3, 1e13)?;
        within("Poisson's ratio", self.specimen.poisson_ratio, -0.99, 0.5)?;
        within("the tip's radius (nm)", self.radius_m * 1e9, 0.1, 1e9)?;
        within("the depth (nm)", self.depth_m * 1e9, 1e-3, 1e9)?;
        within("the roughness (nm)", self.rms_m * 1e9, 0.0, self.radius_m * 1e9)?;
        within("the asperities' radius (nm)", self.asperity_m * 1e9, 0.1, 1e9)?;
        within("the number of trials", self.trials as f64, 2.0, 1e6)?;
        within("the number of asperities under the tip", self.expected(), 30.0, MAX_ASPERITIES)?;
        let trial = |number| self.trial(seed, number);
        Ok((0..self.trials as u64).into_par_iter().map(trial).collect())
    }

    /// Square of the distance from the axis within which an asperity may come to bear, m².
    fn reach2(&self) -> f64 {
        2.0 * self.radius_m * (3.0 * self.depth_m + 2.0 * HIGHEST * self.rms_m)
    }

    fn expected(&self) -> f64 {
        self.density_per_m2 * PI * self.reach2()
    }

    fn trial(&self, seed: u64, number: u64) -> Trial {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number);
        let count = Poisson::new(self.expected()).map_or(0.0, |law| law.sample(&mut random));
        let height = Normal::new(0.0, self.rms_m).ok();
        let place = Uniform::new(0.0, self.reach2()).ok();
        // How high the asperity stands relative to the tip at its place, m; all places in a circle are equally likely.
        let mut tops: Vec<f64> = (0..count as usize)
            .map(|_| {
                let height = height.map_or(0.0, |law| law.sample(&mut random));
                let r2 = place.map_or(0.0, |law| law.sample(&mut random));
                height - r2 / (2.0 * self.radius_m)
            })
            .collect();
        tops.sort_by(|a, b| b.total_cmp(a));
        self.read(&tops)
    }

    /// The curve over these tops, read as that of a smooth specimen.
    fn read(&self, tops: &[f64]) -> Trial {
        let e = self.specimen.reduced_modulus();
        let smooth = Tip::Paraboloid { radius_m: self.radius_m };
        let largest = smooth.force(e, self.depth_m);
        let points = READ.map(|part| {
            let force = part * largest;
            let below = self.depth_m * part.powf(2.0 / 3.0);
            (self.approach(tops, force) + below, force.powf(2.0 / 3.0))
        });
        let count = points.len() as f64;
        let mean = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / count, m.1 + p.1 / count));
        let (mut both, mut own) = (0.0, 0.0);
        for (d, y) in points {
            both += (d - mean.0) * (y - mean.1);
            own += (d - mean.0).powi(2);
        }
        let slope = both / own;
        let apparent = slope.powf(1.5) / (4.0 / 3.0 * self.radius_m.sqrt());
        let reached = self.approach(tops, largest);
        Trial {
            modulus_ratio: apparent / e,
            contact_m: mean.1 / slope - mean.0,
            touching: tops.partition_point(|top| *top + reached > 0.0),
        }
    }

    /// How far the tip has come to the mean surface when the asperities, highest first, bear a force, m.
    fn approach(&self, tops: &[f64], force: f64) -> f64 {
        let asperity = Tip::Paraboloid { radius_m: self.asperity_m };
        let e = self.specimen.reduced_modulus();
        // Force borne and its slope, 2 E* a for each asperity.
        let borne = |d: f64| {
            let touching = tops.iter().take_while(|top| **top + d > 0.0);
            touching.fold((0.0, 0.0), |(sum, slope), top| {
                let radius = asperity.contact_radius(top + d);
                (sum + asperity.force(e, top + d), slope + 2.0 * e * radius)
            })
        };
        let mut d = -tops.first().copied().unwrap_or(0.0);
        let mut step = self.depth_m.max(self.rms_m);
        while borne(d).0 < force && step.is_finite() {
            d += step;
            step *= 2.0;
        }
        // Newton's method on an increasing convex function from above: it never passes the root.
        for _ in 0..60 {
            let (sum, slope) = borne(d);
            let step = (sum - force) / slope;
            d -= step;
            if step.abs() <= 1e-12 * self.depth_m {
                break;
            }
        }
        d
    }
}

/// The spread of a figure over trials; there are two at least.
#[must_use]
pub fn spread(trials: &[Trial], figure: impl Fn(&Trial) -> f64) -> Spread {
    let mut values: Vec<f64> = trials.iter().map(figure).collect();
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let at = |part: f64| values[((part * (count - 1.0)).round() as usize).min(values.len() - 1)];
    Spread { mean, deviation: (square / (count - 1.0)).sqrt(), middle: (at(0.05), at(0.95)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gel(rms_m: f64) -> Rough {
        Rough {
            specimen: Elastic { modulus_pa: 5e3, poisson_ratio: 0.5 },
            radius_m: 2.5e-6,
            depth_m: 5e-7,
            rms_m,
            density_per_m2: 4e13,
            asperity_m: 1e-7,
            trials: 60,
        }
    }

    #[test]
    fn roughness_softens_the_apparent_modulus_and_raises_the_contact_point() {
        let read = |rms_m| {
            let trials = gel(rms_m).run(3).unwrap();
            (spread(&trials, |t| t.modulus_ratio), spread(&trials, |t| t.contact_m))
        };
        let ((fine, fine_contact), (coarse, coarse_contact)) = (read(2e-9), read(8e-8));
        assert!(fine.mean < 1.0, "asperities are soft by themselves: {fine:?}");
        assert!(coarse.mean < fine.mean && coarse.deviation > 2.0 * fine.deviation, "{coarse:?}");
        assert!(coarse_contact.mean > fine_contact.mean + 1e-8, "{coarse_contact:?}");
    }

    #[test]
    fn many_low_asperities_are_a_smooth_surface() {
        let dense = Rough { density_per_m2: 4e15, asperity_m: 1e-6, trials: 4, ..gel(1e-10) };
        let ratio = spread(&dense.run(1).unwrap(), |t| t.modulus_ratio);
        // The series of layer and whole closes slowly, with the power −2/5 of the density.
        assert!((0.96..1.0).contains(&ratio.mean), "{ratio:?}");
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let run = || gel(5e-8).run(7).unwrap();
        assert_eq!(alone.install(run), three.install(run));
    }
}
