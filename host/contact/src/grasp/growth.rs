//! How the limit surface of a held grasp changes (6.4.5): under a constant force the body creeps and its
//! contact grows; under a constant compression the force relaxes and the surface shrinks with it.

use super::body::Body;
use super::contact::{Contact, Shape};
use super::pressure::PressureLaw;
use palpate_model::{Branch, HereditaryState, Model, Relaxation, Response};

/// A held grasp at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Time since the hold began, s.
    pub time: f64,
    /// Compression, mm.
    pub compression: f64,
    /// Normal force N, N.
    pub normal: f64,
}

/// What the contact of a held grasp carries at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grown {
    /// The grasp.
    pub held: Held,
    /// Its contact.
    pub shape: Shape,
    /// Largest tangential force, N: μN in every direction.
    pub force: f64,
    /// Largest moment, N mm.
    pub moment: f64,
}

/// A base law with its numbers: what a grasp needs of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What makes a force of a compression.
    pub response: Response,
}

/// Creep under a constant force: δ(t) = D (1 + Σ ci e^(−vi t)) (eqs 6.1, 6.2). `settled` is D, mm; the shares
/// ci of Type I are negative.
#[must_use]
pub fn creep(times: &[f64], settled: f64, shares: &[Branch], normal: f64) -> Vec<Held> {
    let compression = |time: f64| {
        let decaying = |branch: &Branch| branch.share * (-branch.rate * time).exp();
        settled * (1.0 + shares.iter().map(decaying).sum::<f64>())
    };
    times.iter().map(|&time| Held { time, compression: compression(time), normal }).collect()
}

/// Relaxation under a constant compression: N(t) = N g(t) (eq. 3.4), `normal` being N at the start.
#[must_use]
pub fn relaxation(times: &[f64], g: &Relaxation, normal: f64, compression: f64) -> Vec<Held> {
    times.iter().map(|&time| Held { time, compression, normal: normal * g.at(time) }).collect()
}

/// Longest step of a creep, as a part of the time since it began, and the first step, s.
const STEP: (f64, f64) = (0.004, 1e-3);

impl Material {
    /// Of the base law of a model; effects are left out.
    ///
    /// # Errors
    /// In words, when the model cannot be run or has no stiffness.
    pub fn of(model: &Model) -> Result<Self, String> {
        let (law, parameters) = model.law()?;
        let response = law.response(&parameters);
        if response.p <= 0.0 {
            return Err("the model has no stiffness: nothing is held with it".into());
        }
        Ok(Self { response })
    }

    /// Creep under a constant force that is there at once, N, at these times, s, the first one 0 or later and
    /// growing: the compression that keeps the law at the force.
    #[must_use]
    pub fn creep(&self, times: &[f64], normal: f64) -> Vec<Held> {
        let mut state = HereditaryState::default();
        let mut compression = self.response.sudden_compression(normal);
        let _ = self.response.begin(&mut state, compression);
        let mut now = 0.0;
        let at = |&time: &f64| {
            while now < time {
                let step = (STEP.0 * now).max(STEP.1).min(time - now);
                compression = self.response.keeping(&state, step, normal, compression);
                let _ = self.response.advance(&mut state, step, compression);
                now = if time - now <= step { time } else { now + step };
            }
            Held { time, compression, normal }
        };
        times.iter().map(at).collect()
    }

    /// Relaxation under a compression that is there at once, mm.
    #[must_use]
    pub fn relaxation(&self, times: &[f64], compression: f64) -> Vec<Held> {
        let mut state = HereditaryState::default();
        let mut normal = self.response.begin(&mut state, compression);
        let mut now = 0.0;
        let at = |&time: &f64| {
            if time > now {
                normal = self.response.advance(&mut state, time - now, compression);
                now = time;
            }
            Held { time, compression, normal }
        };
        times.iter().map(at).collect()
    }
}

/// What the contact carries over a hold. Where the body does not touch, nothing is in the result.
///
/// `friction` is the coefficient μ.
#[must_use]
pub fn growth(body: &Body, law: PressureLaw, friction: f64, course: &[Held]) -> Vec<Grown> {
    let mut last: Option<Contact> = None;
    let grown = |held: &Held| {
        let shape = body.contact(held.compression)?;
        let contact = match &last {
            Some(contact) => contact.reshaped(shape),
            None => Contact::new(shape, law),
        }
        .ok()?;
        let force = friction * held.normal.max(0.0);
        let moment = force * contact.arm();
        last = Some(contact);
        Some(Grown { held: *held, shape, force, moment })
    };
    course.iter().filter_map(grown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_model::{BaseLaw, Separation};

    fn material(terms: usize, parameters: &[f64]) -> Material {
        let law = BaseLaw::fung(terms, Separation::Clamp);
        Material { response: law.response(parameters) }
    }

    fn sushi() -> Material {
        material(2, &[0.0687, 0.9, 0.2472, 0.2676, 3.981, 0.5325])
    }

    #[test]
    fn one_exponential_creeps_as_its_closed_form() {
        // c0 u + c1 x = F with x' = −v x + u' has u = F (1 − c1 e^(−c0 v t)) / c0.
        let linear = material(1, &[0.5, 0.0, 0.4, 2.0]);
        let times = [0.0, 0.1, 0.7, 3.0, 20.0];
        for held in linear.creep(&times, 1.5) {
            let exact = 1.5 * (1.0 - 0.4 * (-0.6 * 2.0 * held.time).exp()) / 0.6 / 0.5;
            assert!((held.compression / exact - 1.0).abs() < 1e-5, "{held:?}: {exact}");
        }
    }

    #[test]
    fn a_creeping_block_turns_harder_while_its_tangential_force_stays() {
        let block = Body::Block { length: 40.0, width: 25.0, height: 50.0, poisson: 0.48 };
        let times: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
        let law = PressureLaw::new(4.0).unwrap();
        let grown = growth(&block, law, 0.7, &sushi().creep(&times, 2.0));
        assert_eq!(grown.len(), 100);
        for pair in grown.windows(2) {
            assert!(pair[1].moment > pair[0].moment && pair[1].force == pair[0].force);
        }
    }

    #[test]
    fn a_relaxing_grasp_loses_force_and_moment_alike() {
        let block = Body::Block { length: 40.0, width: 25.0, height: 50.0, poisson: 0.48 };
        let times = [0.0, 1.0, 60.0];
        let grown = growth(&block, PressureLaw::HERTZ, 0.7, &sushi().relaxation(&times, 12.0));
        let left = grown[2].force / grown[0].force;
        assert!(
            (left - Relaxation::new(&[0.2472, 0.2676], &[3.981, 0.5325]).at(60.0)).abs() < 1e-12
        );
        assert!((grown[2].moment / grown[0].moment - left).abs() < 1e-12);
    }

    #[test]
    fn a_ball_that_does_not_touch_carries_nothing() {
        let held = [Held { time: 0.0, compression: 0.0, normal: 1.0 }];
        let ball = Body::Sphere { radius: 9.0 };
        assert!(growth(&ball, PressureLaw::HERTZ, 0.7, &held).is_empty());
    }
}
