//! Integrals over stretches of a line, by the rule of Gauss and Legendre.

use std::num::NonZeroUsize;

use gauss_quad::GaussLegendre;

/// Nodes and weights on the stretch from 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct Rule(Vec<(f64, f64)>);

impl Rule {
    /// For what is smooth from end to end.
    pub(crate) fn smooth(nodes: NonZeroUsize) -> Self {
        let pairs = GaussLegendre::new(nodes);
        Self(pairs.iter().map(|(x, weight)| (0.5 * (1.0 + x), 0.5 * weight)).collect())
    }

    /// For what may end in a root or a logarithm at either end, or have a pole close behind it: the
    /// substitution x = t⁴ (35 − 84 t + 70 t² − 20 t³) is flat there and draws the nodes to the ends.
    pub(crate) fn flat_ended(nodes: NonZeroUsize) -> Self {
        let bent = |(t, weight): (f64, f64)| {
            let x = t.powi(4) * (35.0 + t * (-84.0 + t * (70.0 - 20.0 * t)));
            (x, weight * 140.0 * (t * (1.0 - t)).powi(3))
        };
        Self(Self::smooth(nodes).0.into_iter().map(bent).collect())
    }

    /// Nodes and weights on the stretch from `from` to `to`.
    pub(crate) fn on(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let length = to - from;
        self.0.iter().map(move |(x, weight)| (from + length * x, length * weight))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_and_logarithms_at_the_ends_are_integrated() {
        let rule = Rule::flat_ended(const { NonZeroUsize::new(48).unwrap() });
        let integral =
            |f: fn(f64) -> f64| -> f64 { rule.on(0.0, 2.0).map(|(x, w)| w * f(x)).sum() };
        assert!((integral(f64::sqrt) - 2f64.powf(1.5) / 1.5).abs() < 1e-12);
        assert!((integral(|x| (2.0 - x).cbrt()) - 0.75 * 2f64.powf(4.0 / 3.0)).abs() < 1e-11);
        assert!((integral(|x| x * x.ln()) - (2.0 * 2f64.ln() - 1.0)).abs() < 1e-12);
    }
}
