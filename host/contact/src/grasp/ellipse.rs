//! Friction of a circular or elliptical contact.
//!
//! The length of a vector is a quarter of the integral of its projections, |w| = ¼ ∮ |w·e| dφ. With it the
//! friction ∫ p |v + ω × r| dA (eqs 6.7, 6.8 as a work) needs the pressure only as seen along a line, and
//! that is the same for every line once its length is measured in half widths of the contact. What is left
//! is one integral over the direction, without the singularity at the centre of rotation.

use std::f64::consts::{FRAC_PI_2, PI};
use std::num::NonZeroUsize;
use std::sync::{Arc, LazyLock};

use super::pressure::PressureLaw;
use super::quadrature::Rule;

/// Over the angle between two places where the integrand is not smooth.
static ANGLE: LazyLock<Rule> =
    LazyLock::new(|| Rule::flat_ended(const { NonZeroUsize::new(40).unwrap() }));
/// Over a chord of the contact.
static CHORD: LazyLock<Rule> =
    LazyLock::new(|| Rule::flat_ended(const { NonZeroUsize::new(48).unwrap() }));

/// Pressure of the unit disc as seen along a line, for a normal force of 1.
#[derive(Debug)]
pub(super) struct Projection {
    /// At places z = sin β with equal steps of β from 0 to π/2.
    knots: Vec<Knot>,
}

/// Two functions of the place and their slopes along β.
#[derive(Clone, Copy, Debug)]
struct Knot {
    balance: (f64, f64),
    lever: (f64, f64),
}

const STEPS: usize = 384;

impl Projection {
    pub(super) fn new(law: PressureLaw) -> Self {
        let scale = law.circular_constant() / PI;
        let knot = |step: usize| {
            let beta = FRAC_PI_2 * step as f64 / STEPS as f64;
            let (z, half_chord) = if step == STEPS { (1.0, 0.0) } else { beta.sin_cos() };
            // Over the chord at z: y is the way along it, from its middle to its end.
            let (mut density, mut beyond, mut lever) = (0.0, 0.0, 0.0);
            for (y, weight) in CHORD.on(0.0, 1.0) {
                let rest = half_chord * half_chord * (1.0 - y) * (1.0 + y);
                let radius = (1.0 - rest).sqrt();
                let pressure = weight * scale * law.shape(radius);
                density += pressure;
                beyond += pressure * y * (half_chord * y).atan2(z);
                lever += pressure * y * y;
            }
            let slope = 2.0 * half_chord * 2.0 * half_chord * density;
            Knot {
                balance: (1.0 - 4.0 * half_chord.powi(2) * beyond, slope),
                lever: (4.0 * half_chord.powi(3) * lever, -z * slope),
            }
        };
        Self { knots: (0..=STEPS).map(knot).collect() }
    }

    /// For a line across the contact at 0 ≤ z ≤ 1 half widths from the middle: the force on the side of the
    /// middle less that beyond, and the moment of both about the middle, in half widths.
    fn at(&self, z: f64) -> (f64, f64) {
        let place = z.min(1.0).asin() / FRAC_PI_2 * STEPS as f64;
        let index = (place as usize).min(STEPS - 1);
        let (t, step) = (place - index as f64, FRAC_PI_2 / STEPS as f64);
        let (a, b) = (&self.knots[index], &self.knots[index + 1]);
        let between = |a: (f64, f64), b: (f64, f64)| {
            let change = b.0 - a.0;
            let (begin, end) = (a.1 * step - change, b.1 * step - change);
            a.0 + t * (change + (1.0 - t) * (begin * (1.0 - t) - end * t))
        };
        (between(a.balance, b.balance), between(a.lever, b.lever))
    }
}

/// An elliptical contact with its pressure.
#[derive(Clone, Debug)]
pub(super) struct Ellipse {
    semi_axes: [f64; 2],
    projection: Arc<Projection>,
}

impl Ellipse {
    pub(super) fn new(semi_axes: [f64; 2], law: PressureLaw) -> Self {
        Self { semi_axes, projection: Arc::new(Projection::new(law)) }
    }

    /// With other semi-axes and the same pressure law.
    pub(super) fn resized(&self, semi_axes: [f64; 2]) -> Self {
        Self { semi_axes, projection: Arc::clone(&self.projection) }
    }

    /// ∫ p (r − c)/|r − c| dA and ∫ p r·(r − c)/|r − c| dA about a centre of rotation c, for a normal force
    /// of 1.
    pub(super) fn about(&self, centre: [f64; 2]) -> ([f64; 2], f64) {
        let [a, b] = self.semi_axes;
        let (mut along, mut moment) = ([0.0, 0.0], 0.0);
        for pair in self.breaks(centre).windows(2) {
            for (angle, weight) in ANGLE.on(pair[0], pair[1]) {
                // Lines across the contact whose normal has this angle; one passes the centre of rotation.
                let (sin, cos) = angle.sin_cos();
                let half_width = (a * cos).hypot(b * sin);
                let z = (centre[0] * cos + centre[1] * sin) / half_width;
                let (balance, lever) =
                    if z >= 1.0 { (1.0, 0.0) } else { self.projection.at(z.max(0.0)) };
                along[0] -= 0.5 * weight * balance * cos;
                along[1] -= 0.5 * weight * balance * sin;
                moment += 0.5 * weight * half_width * lever;
            }
        }
        (along, moment)
    }

    /// Angles of normals between which the integrand is smooth, over the half turn in which the centre of
    /// rotation lies on their side of the middle.
    fn breaks(&self, centre: [f64; 2]) -> Vec<f64> {
        let [a, b] = self.semi_axes;
        // On the contact drawn out to a unit disc the line passes the middle at distance · cos(turned).
        let (x, y) = (centre[0] / a, centre[1] / b);
        let (distance, towards) = (x.hypot(y), y.atan2(x));
        let mut turned = vec![-FRAC_PI_2, 0.0, FRAC_PI_2];
        if distance > 1.0 {
            // Beyond these the line passes the contact by.
            let tangent = distance.recip().acos();
            turned.extend([-tangent, tangent]);
        }
        if a != b {
            // The width of a long ellipse changes fast about an axis.
            turned.extend([0.0, FRAC_PI_2].map(|axis| {
                let angle = (axis - towards).rem_euclid(PI);
                if angle > FRAC_PI_2 { angle - PI } else { angle }
            }));
        }
        turned.sort_by(f64::total_cmp);
        let normal = |turned: f64| {
            let (sin, cos) = (towards + turned).sin_cos();
            // Less than a quarter turn from the normal on the disc.
            towards + turned + (a * sin * cos - b * sin * cos).atan2(b * cos * cos + a * sin * sin)
        };
        turned.into_iter().map(normal).collect()
    }
}
