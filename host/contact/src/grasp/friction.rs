//! Friction of a contact from a recorded slide: the coefficient μ and the exponent k of the pressure.
//!
//! While a contact slides its load lies on the limit surface, μN times a body that depends on k. So for the
//! right k every sample asks for the same μ, whatever its mix of tangential force and moment; for another k
//! samples with much moment ask for more or less than samples with little. Without a mix there is no k: a slide
//! along a line determines μ alone, a turn on the spot μ times the arm.

use rayon::prelude::*;

use super::body::Body;
use super::contact::{Contact, Load};
use super::margin::margin;
use super::pressure::PressureLaw;

/// A sample of a slide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliding {
    /// Normal force, N.
    pub normal: f64,
    /// Compression, mm; of no account for a contact of a fixed size.
    pub compression: f64,
    /// Tangential force and moment.
    pub load: Load,
}

/// Friction as a slide shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Coefficient μ with its standard error, that of k included.
    pub coefficient: (f64, f64),
    /// Exponent k, and the least and largest that the slide allows (95 %); none where it does not determine it.
    pub exponent: Option<(f64, f64, f64)>,
    /// Standard deviation of what single samples say of μ.
    pub scatter: f64,
    /// Samples used.
    pub samples: usize,
    /// Least and largest share of the moment in the load of a sample: 0 a slide along a line, 1 a turn on the
    /// spot.
    pub moment_share: (f64, f64),
}

/// Why a slide shows no friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrictionError {
    /// Too few samples.
    #[error("{0} samples of a slide in contact are too few: at least 10 are needed")]
    TooFew(usize),
    /// Nothing pulls.
    #[error("nothing pulls or turns in the slide, so there is no friction to determine")]
    NoLoad,
}

/// Fewest samples, and most that are looked at.
const MIN_SAMPLES: usize = 10;
const MAX_SAMPLES: usize = 400;
/// Steps of 1/k from uniform (0) to a cone (1), and their refinement.
const STEPS: usize = 24;
const REFINED: usize = 5;
/// Twice the rise of the sum of squares, of its mean, within which k may lie (χ² of one parameter, 95 %).
const RISE: f64 = 3.84;
/// Halvings of the way to an end of the range of 1/k.
const EDGE_HALVINGS: u32 = 12;
/// A range of 1/k wider than this does not determine k.
const MAX_EXPONENT_RANGE: f64 = 0.7;

/// Identifies μ and k of a contact that slides at every one of these samples; `law` is taken where they tell no
/// k.
///
/// # Errors
/// [`FrictionError`].
pub fn friction(
    body: &Body,
    law: PressureLaw,
    samples: &[Sliding],
) -> Result<Friction, FrictionError> {
    let thin = samples.len().div_ceil(MAX_SAMPLES).max(1);
    let used: Vec<Sliding> = samples
        .iter()
        .step_by(thin)
        .copied()
        .filter(|sample| sample.normal > 0.0 && body.contact(sample.compression).is_some())
        .collect();
    if used.len() < MIN_SAMPLES {
        return Err(FrictionError::TooFew(used.len()));
    }
    if used.iter().all(|sample| sample.load == Load::default()) {
        return Err(FrictionError::NoLoad);
    }
    let at = |inverse: f64| said(body, law_of(inverse), &used);
    let coarse: Vec<(f64, Said)> = (0..=STEPS)
        .into_par_iter()
        .map(|k| k as f64 / STEPS as f64)
        .map(|inverse| (inverse, at(inverse)))
        .collect();
    let least = |points: &[(f64, Said)]| {
        points.iter().copied().min_by(|a, b| a.1.square.total_cmp(&b.1.square))
    };
    let mut best = least(&coarse).unwrap_or((0.5, at(0.5)));
    let mut step = 1.0 / STEPS as f64;
    for _ in 0..REFINED {
        step *= 0.4;
        let near = [best.0 - step, best.0, best.0 + step].map(|w| w.clamp(0.0, 1.0));
        let found: Vec<(f64, Said)> = near.par_iter().map(|&w| (w, at(w))).collect();
        best = least(&found).unwrap_or(best);
    }
    let count = used.len() as f64;
    let variance = best.1.square / (count - 2.0);
    // What a perfect recording leaves is rounding.
    let allowed = best.1.square + RISE * variance.max(1e-12 * best.1.mean.powi(2));
    let excess = |inverse: f64| at(inverse).square - allowed;
    let ends = (edge(&excess, best.0, 0.0), edge(&excess, best.0, 1.0));
    let told = ends.1 - ends.0 < MAX_EXPONENT_RANGE;
    let chosen = if told { best.1 } else { said(body, law, &used) };
    let of_k = if told { 0.25 * (at(ends.1).mean - at(ends.0).mean).abs() } else { 0.0 };
    let scatter = (chosen.square / (count - 1.0)).sqrt();
    let law = |w: f64| law_of(w).exponent();
    Ok(Friction {
        coefficient: (chosen.mean, (scatter * scatter / count + of_k * of_k).sqrt()),
        exponent: told.then(|| (law(best.0), law(ends.1), law(ends.0))),
        scatter,
        samples: used.len(),
        moment_share: chosen.moment_share,
    })
}

/// Where an excess that is not above zero `inside` becomes so on the way `to` there; `to` where it does not.
fn edge(excess: &impl Fn(f64) -> f64, inside: f64, to: f64) -> f64 {
    if excess(to) <= 0.0 {
        return to;
    }
    let (mut inside, mut outside) = (inside, to);
    for _ in 0..EDGE_HALVINGS {
        let middle = 0.5 * (inside + outside);
        if excess(middle) <= 0.0 { inside = middle } else { outside = middle }
    }
    0.5 * (inside + outside)
}

fn law_of(inverse: f64) -> PressureLaw {
    PressureLaw::new(inverse.recip()).unwrap_or(PressureLaw::UNIFORM)
}

/// What samples say of μ for one pressure law.
#[derive(Clone, Copy, Debug)]
struct Said {
    mean: f64,
    /// Sum of squared deviations.
    square: f64,
    moment_share: (f64, f64),
}

fn said(body: &Body, law: PressureLaw, samples: &[Sliding]) -> Said {
    let first = samples.iter().find_map(|s| Contact::new(body.contact(s.compression)?, law).ok());
    let mut said = Vec::with_capacity(samples.len());
    let mut moment_share = (f64::INFINITY, 0.0f64);
    for sample in samples {
        let contact = first.as_ref().zip(body.contact(sample.compression));
        let Some(Ok(contact)) = contact.map(|(first, shape)| first.reshaped(shape)) else {
            continue;
        };
        let turning = sample.load.moment.abs() / contact.arm();
        let share = turning / turning.hypot(sample.load.tangential()).max(f64::MIN_POSITIVE);
        moment_share = (moment_share.0.min(share), moment_share.1.max(share));
        said.push(margin(&contact, sample.normal, &sample.load).factor.recip());
    }
    let count = said.len().max(1) as f64;
    let mean = said.iter().sum::<f64>() / count;
    let square = said.iter().map(|mu| (mu - mean).powi(2)).sum();
    Said { mean, square, moment_share }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::super::contact::{Motion, Shape};
    use super::*;

    const PAD: Body = Body::Fixed(Shape::Rectangle { length: 30.0, width: 20.0 });

    /// A slide of μ 0.6 and k 4 whose turn per speed runs over this range, 1/mm, with noise of the load.
    fn slide(turns: (f64, f64), noise: f64) -> Vec<Sliding> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let normal = Normal::new(0.0, noise).unwrap();
        let law = PressureLaw::new(4.0).unwrap();
        let contact = Contact::new(PAD.contact(0.0).unwrap(), law).unwrap();
        (0..300)
            .map(|k| {
                let part = f64::from(k) / 299.0;
                let turn = turns.0 + part * (turns.1 - turns.0);
                let pressed = 2.0 + part;
                let motion = Motion { velocity: [1.0, 0.3], turn };
                let load = contact.slipping(&motion).times(0.6 * pressed);
                let force = load.force.map(|force| force + normal.sample(&mut random));
                let moment = load.moment + 10.0 * normal.sample(&mut random);
                Sliding { normal: pressed, compression: 0.0, load: Load { force, moment } }
            })
            .collect()
    }

    #[test]
    fn a_slide_that_turns_more_and_more_tells_friction_and_pressure() {
        let found = friction(&PAD, PressureLaw::HERTZ, &slide((0.0, 0.5), 0.005)).unwrap();
        let (mu, error) = found.coefficient;
        assert!((mu - 0.6).abs() < 4.0 * error && error < 0.01, "{found:?}");
        let (k, low, high) = found.exponent.unwrap();
        assert!(low < k && k < high && high - low < 2.0, "{found:?}");
        // Within twice the range of 95 %.
        assert!((k - 4.0).abs() < high - low + 0.05, "{found:?}");
        let exact = friction(&PAD, PressureLaw::HERTZ, &slide((0.0, 0.5), 0.0)).unwrap();
        assert!((exact.coefficient.0 - 0.6).abs() < 1e-4, "{exact:?}");
        assert!((exact.exponent.unwrap().0 - 4.0).abs() < 0.05, "{exact:?}");
    }

    #[test]
    fn a_slide_along_a_line_tells_no_pressure() {
        let found = friction(&PAD, PressureLaw::HERTZ, &slide((0.0, 0.0), 0.005)).unwrap();
        assert!((found.coefficient.0 - 0.6).abs() < 4.0 * found.coefficient.1, "{found:?}");
        assert_eq!(found.exponent, None);
        let few = friction(&PAD, PressureLaw::HERTZ, &[]);
        assert_eq!(few, Err(FrictionError::TooFew(0)));
    }
}
