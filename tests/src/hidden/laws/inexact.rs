//! Base laws that are slightly other than `fung` with two exponentials, and nothing else: what the
//! refitted base leaves of them is no effect. The strength is the part that the other law takes.

use std::f64::consts::PI;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::relaxation::Branches;
use super::{Recipe, Setting, one};
use crate::hidden::random::{even, log_even, sign};
use crate::hidden::specimen::{Act, Base};

/// Largest compression of the planned motions, mm.
const FULL_STROKE: f64 = 12.0;

/// Another elastic response in words, and as a function of x that is one at 12 mm.
type Curve = (&'static str, Vec<(&'static str, f64)>, Box<dyn Fn(f64) -> f64>);

/// Relaxation times, s, and their weights, which sum to one.
type Spectrum = (&'static str, Vec<(&'static str, f64)>, Vec<(f64, f64)>);

fn curve(random: &mut ChaCha8Rng) -> Curve {
    let curves = [polynomial, exponential, neo_hooke, sine, kinked];
    curves[random.random_range(0..curves.len())](random)
}

/// u (1 + a u + b u² + c u³) over its value at full stroke, u = x/12 mm.
fn polynomial(random: &mut ChaCha8Rng) -> Curve {
    let [a, b, c] = [(); 3].map(|()| StandardNormal.sample(random));
    let of = move |x: f64| {
        let u = x / FULL_STROKE;
        u * (3.0 + u * (a + u * (b + u * c)))
    };
    let full: f64 = of(FULL_STROKE);
    let scale = if full.abs() > 0.3 { 1.0 / full } else { 1.0 };
    (
        "polynomial of fourth degree",
        vec![("a", a), ("b", b), ("c", c)],
        Box::new(move |x| scale * of(x)),
    )
}

/// e^(x/l) − 1.
fn exponential(random: &mut ChaCha8Rng) -> Curve {
    let length = log_even(random, 3.0, 12.0);
    let full = (FULL_STROKE / length).exp_m1();
    ("exponential", vec![("l_mm", length)], Box::new(move |x| (x / length).exp_m1() / full))
}

/// A block of height h under uniaxial compression: λ⁻² − λ, λ = 1 − x/h.
fn neo_hooke(random: &mut ChaCha8Rng) -> Curve {
    let height = even(random, 20.0, 40.0);
    let of = move |x: f64| {
        let stretch = 1.0 - x / height;
        stretch.powi(-2) - stretch
    };
    let full = of(FULL_STROKE);
    ("Neo-Hooke block", vec![("h_mm", height)], Box::new(move |x| of(x) / full))
}

/// u + a sin(π u) with u = x/12 mm: softer or stiffer half way.
fn sine(random: &mut ChaCha8Rng) -> Curve {
    let bend = sign(random) * even(random, 0.1, 0.3);
    let of = move |x: f64| x / FULL_STROKE + bend * (PI * x / FULL_STROKE).sin();
    ("straight line with half a sine", vec![("a", bend)], Box::new(of))
}

/// Two stiffnesses with a rounded corner.
fn kinked(random: &mut ChaCha8Rng) -> Curve {
    let (at, width) = (even(random, 2.0, 7.0), even(random, 0.5, 2.0));
    let soft = move |x: f64| width * ((x - at) / width).exp().ln_1p();
    let of = move |x: f64| soft(x) - soft(0.0);
    let full = of(FULL_STROKE);
    ("two stiffnesses", vec![("x_mm", at), ("w_mm", width)], Box::new(move |x| of(x) / full))
}

fn spectrum(random: &mut ChaCha8Rng) -> Spectrum {
    let spectra = [power_law, stretched, modes, log_normal];
    let (name, inner, all) = spectra[random.random_range(0..spectra.len())](random);
    let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
    (name, inner, all.into_iter().map(|(time, weight)| (time, weight / sum)).collect())
}

/// Times four a decade from 10^`from` to 10^`to` s.
fn times(from: i32, to: i32) -> impl Iterator<Item = f64> {
    (4 * from..=4 * to).map(|k| 10f64.powf(0.25 * f64::from(k)))
}

/// t^(−β) between a hundredth of a second and some thousand.
fn power_law(random: &mut ChaCha8Rng) -> Spectrum {
    let beta = even(random, 0.05, 0.35);
    let all = times(-2, 3).map(|time| (time, time.powf(-beta))).collect();
    ("power law", vec![("beta", beta)], all)
}

/// e^(−(t/τ)^β), its spectrum of rates by Pollard's integral.
fn stretched(random: &mut ChaCha8Rng) -> Spectrum {
    let (beta, tau) = (even(random, 0.35, 0.65), log_even(random, 0.3, 3.0));
    let all = times(-4, 4).map(|time| (tau * time, rates_of_stretched(beta, 1.0 / time) / time));
    ("stretched exponential", vec![("beta", beta), ("tau_s", tau)], all.collect())
}

/// (1/π) ∫ e^(−u r) e^(−r^β cos πβ) sin(r^β sin πβ) dr from 0 on, over r = e^y.
fn rates_of_stretched(beta: f64, u: f64) -> f64 {
    const STEP: f64 = 0.01;
    let (sin, cos) = (PI * beta).sin_cos();
    let at = |k: i32| {
        let r = (STEP * f64::from(k)).exp();
        let power = r.powf(beta);
        r * (-u * r - power * cos).exp() * (power * sin).sin()
    };
    (-4000..=3000).map(at).filter(|value| value.is_finite()).sum::<f64>() * STEP / PI
}

/// Three or four exponentials.
fn modes(random: &mut ChaCha8Rng) -> Spectrum {
    let count = random.random_range(3..=4);
    let all = (0..count).map(|k| {
        let decade = -1.3 + 2.8 * (f64::from(k) + even(random, 0.2, 0.8)) / f64::from(count);
        (10f64.powf(decade), even(random, 0.5, 1.5))
    });
    ("three or four exponentials", vec![("count", f64::from(count))], all.collect())
}

/// Times spread normally in their logarithm.
fn log_normal(random: &mut ChaCha8Rng) -> Spectrum {
    let (tau, width) = (log_even(random, 0.3, 3.0), even(random, 0.8, 2.5));
    let all = times(-4, 5).map(|time| (time, (-0.5 * ((time / tau).ln() / width).powi(2)).exp()));
    ("log-normal spectrum", vec![("tau_s", tau), ("width", width)], all.collect())
}

/// N → (1 − s) N + s N(12) h(x).
fn bent(base: Base, of: impl Fn(f64) -> f64 + 'static, s: f64) -> Act {
    let full = base.elastic(FULL_STROKE);
    Act::Elastic(Box::new(move |_, x, n| (1.0 - s) * n + s * full * of(x.max(0.0))))
}

/// The branches of the base give a part of their force to others.
fn shared(base: Base, spectrum: &[(f64, f64)], s: f64) -> Act {
    let mut others = Branches::new(spectrum.iter().map(|(time, _)| 1.0 / time).collect());
    let weights: Vec<f64> = spectrum.iter().map(|(_, weight)| *weight).collect();
    let relaxing = base.shares[0] + base.shares[1];
    Act::Specimen(Box::new(move |now, elastic, force| {
        let own = force - (1.0 - relaxing) * elastic;
        let forces = others.advance(now.step, elastic);
        let other: f64 = forces.iter().zip(&weights).map(|(force, weight)| force * weight).sum();
        force + s * (relaxing * other - own)
    }))
}

fn recipe(
    form: &'static str,
    inner: Vec<(&'static str, f64)>,
    act: Box<dyn Fn(f64) -> Vec<Act>>,
) -> Recipe {
    Recipe { form, inner, unit: "", guess: 0.05, most: 1.0, act }
}

/// Another elastic response.
pub fn elastic(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let base = setting.base;
    let (form, inner, of) = curve(random);
    let of = std::rc::Rc::new(of);
    let act = move |s| {
        let of = std::rc::Rc::clone(&of);
        one(bent(base, move |x| of(x), s))
    };
    recipe(form, inner, Box::new(act))
}

/// Another spectrum of relaxation.
pub fn relaxation(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let base = setting.base;
    let (form, inner, spectrum) = spectrum(random);
    recipe(form, inner, Box::new(move |s| one(shared(base, &spectrum, s))))
}

/// Both.
pub fn both(setting: &Setting, random: &mut ChaCha8Rng) -> Recipe {
    let (elastic, relaxation) = (elastic(setting, random), relaxation(setting, random));
    let inner = elastic.inner.into_iter().chain(relaxation.inner).collect();
    let act = move |s| {
        let mut acts = (elastic.act)(s);
        acts.extend((relaxation.act)(s));
        acts
    };
    recipe("another elastic response and another spectrum", inner, Box::new(act))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spectrum_of_the_stretched_exponential_is_its_own() {
        // β = 1/2 has the closed form u^(−3/2) e^(−1/(4u))/(2 √π).
        for u in [0.05, 0.3, 1.0, 7.0] {
            let known = f64::powf(u, -1.5) * (-0.25 / u).exp() / (2.0 * PI.sqrt());
            let found = rates_of_stretched(0.5, u);
            assert!((found / known - 1.0).abs() < 1e-3, "{u}: {found} {known}");
        }
        let beta: f64 = 0.4;
        let weights: Vec<(f64, f64)> =
            times(-5, 5).map(|time| (time, rates_of_stretched(beta, 1.0 / time) / time)).collect();
        let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
        for t in [0.1_f64, 1.0, 5.0] {
            let value: f64 = weights.iter().map(|(time, w)| w / sum * (-t / time).exp()).sum();
            assert!((value - (-t.powf(beta)).exp()).abs() < 5e-3, "{t}: {value}");
        }
    }
}
