//! Any exponential in the common coordinates: by quintic Hermite interpolation in u = ln v where they are tabulated, computed where the
//! coordinates are values at nodes.

use super::basis::Coordinates;
use super::nodes::reflect;
use crate::many_exp::exp;

/// All exponentials between two rates.
#[derive(Clone, Debug)]
pub(super) struct Table<const R: usize> {
    source: Source<R>,
    /// u of the slowest rate.
    pub lowest: f64,
    /// u of the fastest rate.
    pub highest: f64,
}

/// Where exponentials come from.
#[derive(Clone, Debug)]
enum Source<const R: usize> {
    /// Exponentials at evenly spaced u; between them a polynomial that agrees with value, first and
    /// second derivative at both ends.
    Tabulated { nodes: Coordinates<R>, inverse_spacing: f64 },
    /// Values at these times, s, each times its root, in a mirror.
    Exact(Box<[[f64; R]; 3]>),
}

/// One exponential.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exponential<const R: usize> {
    /// Coordinates of e^(−v t).
    pub value: [f64; R],
    /// Its derivative in u = ln v.
    pub slope: [f64; R],
}

impl<const R: usize> Table<R> {
    pub fn new(nodes: Coordinates<R>, lowest: f64, highest: f64, spacing: f64) -> Self {
        let source = Source::Tabulated { nodes, inverse_spacing: 1.0 / spacing };
        Self { source, lowest, highest }
    }

    /// Of values at these times, s, each times its root, in a mirror; between two u.
    pub fn exact(
        times: [f64; R],
        roots: [f64; R],
        mirror: [f64; R],
        (lowest, highest): (f64, f64),
    ) -> Self {
        Self { source: Source::Exact(Box::new([times, roots, mirror])), lowest, highest }
    }

    /// The exponential of rate e^u; u within the limits.
    #[inline]
    pub fn at(&self, u: f64) -> Exponential<R> {
        match &self.source {
            Source::Tabulated { nodes, inverse_spacing } => {
                between(nodes, *inverse_spacing, (u - self.lowest) * inverse_spacing)
            }
            Source::Exact(nodes) => at_nodes(nodes, u.exp()),
        }
    }

    /// Rates for a coarse search, evenly spaced in u.
    pub fn coarse(&self, count: usize) -> Vec<f64> {
        let step = (self.highest - self.lowest) / (count - 1) as f64;
        (0..count).map(|index| (self.lowest + step * index as f64).min(self.highest)).collect()
    }
}

/// The exponential of a rate, 1/s, at nodes.
fn at_nodes<const R: usize>([times, roots, mirror]: &[[f64; R]; 3], rate: f64) -> Exponential<R> {
    let (mut value, mut slope) = ([0.0; R], [0.0; R]);
    for k in 0..R {
        let turns = rate * times[k];
        value[k] = roots[k] * exp(-turns);
        slope[k] = -turns * value[k];
    }
    reflect(&mut value, mirror);
    reflect(&mut slope, mirror);
    Exponential { value, slope }
}

/// The exponential at a place between tabulated ones.
#[inline]
fn between<const R: usize>(
    nodes: &Coordinates<R>,
    inverse_spacing: f64,
    place: f64,
) -> Exponential<R> {
    let node = (place.max(0.0) as usize).min(nodes.len() - 2);
    let x = place - node as f64;
    let (values, slopes) = hermite(x);
    let [a, b] = [&nodes[node], &nodes[node + 1]];
    let mut value = [0.0; R];
    let mut slope = [0.0; R];
    for k in 0..R {
        let parts = [a[0][k], a[1][k], a[2][k], b[0][k], b[1][k], b[2][k]];
        value[k] = parts[0] * values[0]
            + parts[1] * values[1]
            + parts[2] * values[2]
            + (parts[3] * values[3] + parts[4] * values[4] + parts[5] * values[5]);
        slope[k] = parts[0] * slopes[0]
            + parts[1] * slopes[1]
            + parts[2] * slopes[2]
            + (parts[3] * slopes[3] + parts[4] * slopes[4] + parts[5] * slopes[5]);
    }
    for value in &mut slope {
        *value *= inverse_spacing;
    }
    Exponential { value, slope }
}

/// Quintic Hermite weights at x in 0..1 of (value, slope, curvature) at 0 and at 1, and their
/// derivatives in x.
#[inline]
fn hermite(x: f64) -> ([f64; 6], [f64; 6]) {
    let x2 = x * x;
    let x3 = x2 * x;
    let x4 = x2 * x2;
    let x5 = x4 * x;
    let rise = 10.0 * x3 - 15.0 * x4 + 6.0 * x5;
    let rise_slope = 30.0 * (x2 - 2.0 * x3 + x4);
    (
        [
            1.0 - rise,
            x - 6.0 * x3 + 8.0 * x4 - 3.0 * x5,
            0.5 * x2 - 1.5 * x3 + 1.5 * x4 - 0.5 * x5,
            rise,
            -4.0 * x3 + 7.0 * x4 - 3.0 * x5,
            0.5 * x3 - x4 + 0.5 * x5,
        ],
        [
            -rise_slope,
            1.0 - 18.0 * x2 + 32.0 * x3 - 15.0 * x4,
            x - 4.5 * x2 + 6.0 * x3 - 2.5 * x4,
            rise_slope,
            -12.0 * x2 + 28.0 * x3 - 15.0 * x4,
            1.5 * x2 - 4.0 * x3 + 2.5 * x4,
        ],
    )
}
