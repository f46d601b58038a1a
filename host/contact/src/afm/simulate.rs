//! Practice curves of a known specimen.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::curve::SPRING;
use super::hereditary::Contact;
use super::law::Law;
use super::{AfmError, within};
use crate::{Elastic, Tip};
use palpate_model::Relaxation;
use palpate_trace::{Control, DISPLACEMENT, FORCE, Head, Trace};

/// A force curve to be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Practice {
    /// The specimen.
    pub specimen: Elastic,
    /// Its relaxation (eq. 3.3); no exponentials for one without memory.
    pub relaxation: Relaxation,
    /// The tip.
    pub tip: Tip,
    /// Spring constant, N/m.
    pub spring_n_per_m: f64,
    /// How far off the piezo starts, m.
    pub off_m: f64,
    /// How far it goes beyond the touch, m.
    pub beyond_m: f64,
    /// Its speed, m/s.
    pub speed_m_per_s: f64,
    /// How long it stays, s; 0 for no hold.
    pub hold_s: f64,
    /// Pull of adhesion, N, both ways.
    pub pull_n: f64,
    /// Force out of contact, N, and its tilt, N per m of way.
    pub baseline: [f64; 2],
    /// Standard deviation of the force, N.
    pub noise_n: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

/// Most samples.
const MAX_SAMPLES: f64 = 1e6;

impl Practice {
    /// A gel of 5 kPa under a ball of 2.5 µm on a cantilever of 0.05 N/m: 1 µm off, 1 µm beyond, 4 µm/s, noise of 20 pN.
    #[must_use]
    pub fn gel() -> Self {
        Self {
            specimen: Elastic { modulus_pa: 5e3, poisson_ratio: 0.5 },
            relaxation: Relaxation::new(&[], &[]),
            tip: Tip::Paraboloid { radius_m: 2.5e-6 },
            spring_n_per_m: 0.05,
            off_m: 1e-6,
            beyond_m: 1e-6,
            speed_m_per_s: 4e-6,
            hold_s: 0.0,
            pull_n: 0.0,
            baseline: [0.0, 0.0],
            noise_n: 2e-11,
            rate_hz: 1000.0,
        }
    }

    /// The curve as a trace, with the noise of a seed: way of the piezo, 0 at the touch, and force.
    ///
    /// # Errors
    /// [`AfmError::Range`] for what cannot be.
    pub fn curve(&self, seed: u64) -> Result<Trace, AfmError> {
        self.check()?;
        let (time, z) = self.motion();
        let law = Law {
            tip: self.tip,
            reduced_modulus: self.specimen.reduced_modulus(),
            adhesion_n: self.pull_n,
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let noise = Normal::new(0.0, self.noise_n).ok();
        let mut contact = Contact::new(law, &self.relaxation, Some(self.spring_n_per_m));
        let leaves = self.there_s() + self.hold_s;
        let force = time.iter().zip(&z).map(|(&time, &z)| {
            let [offset, tilt] = self.baseline;
            let noise = noise.map_or(0.0, |normal| normal.sample(&mut random));
            contact.follow(time, z, time > leaves) + offset + tilt * z + noise
        });
        let force = force.collect();
        let mut head = Head {
            version: Some(1),
            name: Some("a simulated force curve".into()),
            computed_by: Some("palpate afm simulate".into()),
            control: Some(Control::Displacement),
            ..Head::default()
        };
        let seed = toml::Value::Integer(i64::try_from(seed).unwrap_or(i64::MAX));
        head.setup.other.insert(SPRING.into(), self.spring_n_per_m.into());
        head.setup.other.insert("simulated".into(), true.into());
        head.setup.other.insert("seed".into(), seed);
        let mut trace = Trace { head, time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, z.iter().map(|z| z * 1e3).collect());
        trace.set_column(FORCE, force);
        Ok(trace)
    }

    fn check(&self) -> Result<(), AfmError> {
        within("the modulus (Pa)", self.specimen.modulus_pa, 1e-3, 1e13)?;
        within("Poisson's ratio", self.specimen.poisson_ratio, -0.99, 0.5)?;
        within("the spring constant (N/m)", self.spring_n_per_m, 1e-6, 1e6)?;
        within("the way off the specimen (nm)", self.off_m * 1e9, 0.1, 1e9)?;
        within("the way beyond the touch (nm)", self.beyond_m * 1e9, 0.1, 1e9)?;
        within("the speed (um/s)", self.speed_m_per_s * 1e6, 1e-6, 1e6)?;
        within("the hold (s)", self.hold_s, 0.0, 1e5)?;
        within("the pull (pN)", self.pull_n * 1e12, 0.0, 1e12)?;
        within("the noise (pN)", self.noise_n * 1e12, 0.0, 1e12)?;
        let duration = 2.0 * (self.off_m + self.beyond_m) / self.speed_m_per_s + self.hold_s;
        within("the number of samples", duration * self.rate_hz, 10.0, MAX_SAMPLES)
    }

    /// When the piezo is nearest, s.
    fn there_s(&self) -> f64 {
        (self.off_m + self.beyond_m) / self.speed_m_per_s
    }

    /// Time, s, and way of the piezo, m.
    fn motion(&self) -> (Vec<f64>, Vec<f64>) {
        let there = self.there_s();
        let end = 2.0 * there + self.hold_s;
        let way = |t: f64| {
            let down = self.speed_m_per_s * t.min(there);
            let up = self.speed_m_per_s * (t - there - self.hold_s).max(0.0);
            down - up - self.off_m
        };
        let time = (0..=(end * self.rate_hz).round() as usize).map(|k| k as f64 / self.rate_hz);
        let time: Vec<f64> = time.collect();
        let z = time.iter().map(|t| way(*t)).collect();
        (time, z)
    }
}
