//! Friction of a rectangular contact whose pressure varies along its length (eq. 6.10).
//!
//! Across the width the pressure is the same, so that integral is taken in closed form; the one along the
//! length is split where the integrand is not smooth: in the middle and at the centre of rotation.

use std::num::NonZeroUsize;
use std::sync::LazyLock;

use super::pressure::PressureLaw;
use super::quadrature::Rule;

/// Along the length.
static LENGTH: LazyLock<Rule> =
    LazyLock::new(|| Rule::flat_ended(const { NonZeroUsize::new(48).unwrap() }));
/// Across the width, seen from far away.
static WIDTH: LazyLock<Rule> =
    LazyLock::new(|| Rule::smooth(const { NonZeroUsize::new(14).unwrap() }));
/// From so many half diagonals on a centre of rotation is far away.
const FAR_DIAGONALS: f64 = 4.0;

/// A rectangular contact with its pressure.
#[derive(Clone, Debug)]
pub(super) struct Rectangle {
    half_length: f64,
    half_width: f64,
    law: PressureLaw,
    /// Pressure in the middle over the mean pressure.
    constant: f64,
}

/// ∫ (r − c)/|r − c| dy and ∫ r·(r − c)/|r − c| dy over the width, divided by it.
type Across = ([f64; 2], f64);

impl Rectangle {
    pub(super) fn new(length: f64, width: f64, law: PressureLaw) -> Self {
        let constant = law.strip_constant();
        Self { half_length: 0.5 * length, half_width: 0.5 * width, law, constant }
    }

    /// ∫ p (r − c)/|r − c| dA and ∫ p r·(r − c)/|r − c| dA about a centre of rotation c, for a normal force
    /// of 1.
    pub(super) fn about(&self, centre: [f64; 2]) -> Across {
        let far =
            centre[0].hypot(centre[1]) > FAR_DIAGONALS * self.half_length.hypot(self.half_width);
        let (mut along, mut moment) = ([0.0, 0.0], 0.0);
        for pair in self.breaks(centre[0]).windows(2) {
            for (x, weight) in LENGTH.on(pair[0], pair[1]) {
                let shape = self.law.shape((x / self.half_length).abs());
                let weight = weight * self.constant * shape / (2.0 * self.half_length);
                let ([across_x, across_y], turn) =
                    if far { self.far(x, centre) } else { self.near(x, centre) };
                along[0] += weight * across_x;
                along[1] += weight * across_y;
                moment += weight * turn;
            }
        }
        (along, moment)
    }

    /// Places along the length between which the integrand is smooth.
    fn breaks(&self, centre: f64) -> Vec<f64> {
        let mut breaks = vec![-self.half_length, 0.0, self.half_length];
        if centre.abs() < self.half_length {
            breaks.push(centre);
        }
        breaks.sort_by(f64::total_cmp);
        breaks
    }

    /// In closed form.
    fn near(&self, x: f64, centre: [f64; 2]) -> Across {
        let width = 2.0 * self.half_width;
        let x_off = x - centre[0];
        // The edges as seen from the centre of rotation.
        let (low, high) = (-self.half_width - centre[1], self.half_width - centre[1]);
        let (to_low, to_high) = (x_off.hypot(low), x_off.hypot(high));
        // ∫ dy/|r − c|, and the same times the square of x_off, which goes to zero with it.
        let inverse = if x_off == 0.0 {
            0.0
        } else if low * high > 0.0 {
            (width * (low + high) / (high * to_low + low * to_high)).asinh()
        } else {
            (high / x_off.abs()).asinh() - (low / x_off.abs()).asinh()
        };
        let lengthwise = x_off * inverse;
        let crosswise = width * (low + high) / (to_low + to_high);
        let square = 0.5 * (high * to_high - low * to_low - x_off * lengthwise);
        let moment = x * lengthwise + centre[1] * crosswise + square;
        ([lengthwise / width, crosswise / width], moment / width)
    }

    /// By quadrature: from far away the closed form would be a small difference of large numbers.
    fn far(&self, x: f64, centre: [f64; 2]) -> Across {
        let x_off = x - centre[0];
        let (mut along, mut moment) = ([0.0, 0.0], 0.0);
        for (share, weight) in WIDTH.on(-1.0, 1.0) {
            let y = self.half_width * share;
            let y_off = y - centre[1];
            let weight = 0.5 * weight / x_off.hypot(y_off);
            along[0] += weight * x_off;
            along[1] += weight * y_off;
            moment += weight * (x * x_off + y * y_off);
        }
        (along, moment)
    }
}
