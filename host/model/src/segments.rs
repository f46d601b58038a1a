//! The latency models inside the specimen: segments between the contact and the plane of symmetry, each of
//! which relaxes towards its own equilibrium (4.2.3, 7.4.1).
//!
//! The contact moves the first node; a segment that is compressed more than its equilibrium expands and so
//! moves the next node. What counts at the contact is the first segment alone: with m segments of equal
//! length its latent compression Y = L (ε1 − x/L) follows Y' = (m − 1) x' − ν |Y|^n sgn Y, which is the
//! base law `latency-power` with c0 = 1/m, and `latency` for n = 1.

use super::growth::Growth;

/// Towards which strain a segment relaxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Equilibrium {
    /// All towards that of the whole, x/L (4.2.3): exact for n = 1, where the segments stay together.
    Common,
    /// Each towards the displacement of its outer node over the length from there inwards (7.4.1).
    OwnNode,
}

/// What halving every interval may still move a node by, of the largest compression.
const RESOLVED: f64 = 1e-7;
/// Most parts of one interval.
const MOST_PARTS: usize = 256;

/// A specimen as segments of equal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segments {
    /// Number m of segments.
    pub count: usize,
    /// Rate ν, 1/s, at which a latent compression of 1 mm relaxes.
    pub rate: f64,
    /// Power n of the latent compression that its rate of change follows.
    pub exponent: f64,
    /// Towards which strain a segment relaxes.
    pub equilibrium: Equilibrium,
}

impl Segments {
    /// Displacement of each node, mm, at each time, s, while the contact (node 1) goes along `x`, mm, from
    /// rest, straight between samples; one vector for each node from the contact inwards. The last segment
    /// ends at the plane of symmetry, which does not move.
    ///
    /// Inner nodes move along curves between samples: intervals are halved, and extrapolated, until that
    /// moves no node by more than 1e-7 of the largest compression.
    #[must_use]
    pub fn displacements(&self, time: &[f64], x: &[f64]) -> Vec<Vec<f64>> {
        let largest = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let (mut coarse, mut before) = (self.at_parts(time, x, 1), None::<Vec<Vec<f64>>>);
        let mut parts = 1;
        loop {
            parts *= 2;
            let fine = self.at_parts(time, x, parts);
            let mut better = fine.clone();
            let mut moved: f64 = 0.0;
            for (node, better) in better.iter_mut().enumerate() {
                for (k, better) in better.iter_mut().enumerate() {
                    *better += (fine[node][k] - coarse[node][k]) / 3.0;
                    let last = before.as_ref().map_or(f64::INFINITY, |before| before[node][k]);
                    moved = moved.max((*better - last).abs());
                }
            }
            // Not a number stays one.
            if moved <= RESOLVED * largest || moved.is_nan() || parts == MOST_PARTS {
                return better;
            }
            (coarse, before) = (fine, Some(better));
        }
    }

    /// The nodes at each time, with every interval in so many parts.
    fn at_parts(&self, time: &[f64], x: &[f64], parts: usize) -> Vec<Vec<f64>> {
        let (time, x) = (divided(time, parts), divided(x, parts));
        let mut nodes = vec![x.clone()];
        for segment in 1..self.count {
            let outer = &nodes[segment - 1];
            let latent = self.latent(segment, &time, outer, &x);
            let share = self.share(segment);
            let inner = outer.iter().zip(&latent).zip(&x).map(|((u, latent), x)| {
                let even = match self.equilibrium {
                    Equilibrium::Common => x / self.count as f64,
                    Equilibrium::OwnNode => u * share,
                };
                u - even - latent / self.count as f64
            });
            let inner = inner.collect();
            nodes.push(inner);
        }
        nodes.into_iter().map(|node| node.into_iter().step_by(parts).collect()).collect()
    }

    /// Latent compression Y of the first segment, mm: L (ε1 − x/L).
    #[must_use]
    pub fn at_contact(&self, time: &[f64], x: &[f64]) -> Vec<f64> {
        self.latent(1, time, x, x)
    }

    /// Part of its outer node's displacement that a segment takes at equilibrium.
    fn share(&self, segment: usize) -> f64 {
        1.0 / (self.count - segment + 1) as f64
    }

    /// Latent compression of a segment whose outer node moves along `outer`, mm.
    fn latent(&self, segment: usize, time: &[f64], outer: &[f64], x: &[f64]) -> Vec<f64> {
        let count = self.count as f64;
        let growth = Growth::Power(self.exponent - 1.0, 1.0);
        let drive = |k: usize| match self.equilibrium {
            Equilibrium::Common if segment == 1 => (count - 1.0) * x[k],
            Equilibrium::Common => -x[k],
            Equilibrium::OwnNode => count * (1.0 - self.share(segment)) * outer[k],
        };
        let mut latent = 0.0;
        let mut before = 0.0;
        (0..time.len())
            .map(|k| {
                let change = drive(k) - before;
                before += change;
                if k == 0 {
                    latent += change;
                } else {
                    latent = growth.driven(latent, change, self.rate * (time[k] - time[k - 1]));
                }
                latent
            })
            .collect()
    }
}

/// Straight lines between values, each in so many parts.
fn divided(values: &[f64], parts: usize) -> Vec<f64> {
    let between = |pair: &[f64]| {
        let (from, to) = (pair[0], pair[1]);
        (0..parts).map(move |part| from + (to - from) * part as f64 / parts as f64)
    };
    let mut all: Vec<f64> = values.windows(2).flat_map(between).collect();
    all.extend(values.last());
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radau::radau;
    use crate::{BaseLaw, Family, Motion, Separation};
    use nalgebra::DVector;

    /// A press at 20 mm/s to 4 mm, held, half released, held.
    fn press(rate: f64) -> (Vec<f64>, Vec<f64>) {
        let course = [(0.0, 0.0), (0.2, 4.0), (5.0, 4.0), (5.1, 2.0), (10.0, 2.0)];
        let at = |time: f64| {
            let next = course.iter().position(|(t, _)| *t >= time).unwrap_or(4).max(1);
            let ((t0, x0), (t1, x1)) = (course[next - 1], course[next]);
            x0 + (x1 - x0) * ((time - t0) / (t1 - t0)).clamp(0.0, 1.0)
        };
        let time: Vec<f64> = (0..=(10.0 * rate) as usize).map(|k| k as f64 / rate).collect();
        let x = time.iter().map(|&t| at(t)).collect();
        (time, x)
    }

    #[test]
    fn the_force_of_m_segments_is_that_of_the_closed_law_with_c0_one_over_m() {
        let (time, x) = press(500.0);
        for (exponent, rate) in [(1.0, 0.8), (5.0, 0.002)] {
            let segments = Segments { count: 8, rate, exponent, equilibrium: Equilibrium::OwnNode };
            let law = BaseLaw {
                segments: Some(8),
                exponent: Some(exponent),
                ..BaseLaw::new(Family::LATENCY_POWER, 1, Separation::Bonded)
            };
            let motion =
                Motion { time: (&time).into(), displacement: (&x).into(), rest_before: None };
            // Stiffness 1 N/mm at equilibrium: 8 N/mm at once.
            let force = law.predict(&[8.0, 0.0, rate], &[motion]).remove(0);
            let latent = segments.at_contact(&time, &x);
            for ((force, latent), x) in force.iter().zip(&latent).zip(&x) {
                assert!((force - (x + latent)).abs() < 1e-9, "{force} against {}", x + latent);
            }
        }
    }

    #[test]
    fn the_last_node_comes_to_rest_where_the_strain_is_even() {
        let (mut time, mut x) = press(100.0);
        for later in 1..=6 {
            time.push(1e3 * f64::from(later));
            x.push(2.0);
        }
        for equilibrium in [Equilibrium::Common, Equilibrium::OwnNode] {
            let nodes = Segments { count: 5, rate: 1.0, exponent: 1.0, equilibrium }
                .displacements(&time, &x);
            for (node, course) in nodes.iter().enumerate() {
                let even = 2.0 * (1.0 - node as f64 / 5.0);
                assert!((course[time.len() - 1] - even).abs() < 1e-9, "{equilibrium:?} {node}");
            }
        }
    }

    #[test]
    fn with_a_common_equilibrium_a_linear_specimen_keeps_its_length() {
        let (time, x) = press(200.0);
        let segments =
            Segments { count: 6, rate: 0.7, exponent: 1.0, equilibrium: Equilibrium::Common };
        let nodes = segments.displacements(&time, &x);
        // The last segment ends at the plane of symmetry whatever the others do.
        let last = segments.latent(6, &time, &nodes[5], &x);
        for k in 0..time.len() {
            let end = nodes[5][k] - x[k] / 6.0 - last[k] / 6.0;
            assert!(end.abs() < 1e-12, "{end}");
        }
    }

    #[test]
    fn late_in_a_hold_the_force_settles_as_segments_grow_in_number_where_n_exceeds_one() {
        let (time, x) = press(1000.0);
        let at = |count: usize, exponent: f64, rate: f64| {
            let segments = Segments { count, rate, exponent, equilibrium: Equilibrium::OwnNode };
            segments.at_contact(&time, &x)[4999]
        };
        let change = |count| (at(2 * count, 5.0, 0.002) / at(count, 5.0, 0.002) - 1.0).abs();
        assert!(
            change(8) < 0.1 && change(64) < 0.01 * change(8) + 1e-3,
            "{} {}",
            change(8),
            change(64)
        );
        // The linear model has no such limit: the number of segments is a property of the specimen.
        assert!((at(16, 1.0, 0.3) / at(8, 1.0, 0.3) - 15.0 / 7.0).abs() < 1e-9);
    }

    /// A press to 50 mm in half a second, held, half released, held.
    fn deep_press(rate: f64) -> (Vec<f64>, Vec<f64>) {
        let (time, x) = press(rate);
        let times = time.iter().map(|t| 2.5 * t).collect();
        (times, x.iter().map(|x| 12.5 * x).collect())
    }

    /// Rates at which the largest latent compression relaxes, 1/s: within the hold, and within samples.
    const PACES: [f64; 2] = [0.5, 30.0];
    const EXPONENTS: [f64; 7] = [1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 9.0];

    #[test]
    fn the_power_law_is_that_of_a_stiff_integrator_up_to_50_mm() {
        let (time, x) = deep_press(100.0);
        let (p, q, c0) = (0.1, 0.4, 0.125);
        for exponent in EXPONENTS {
            for pace in PACES {
                let rate = pace / 350f64.powf(exponent - 1.0);
                let law = BaseLaw {
                    exponent: Some(exponent),
                    ..BaseLaw::new(Family::LATENCY_POWER, 1, Separation::Clamp)
                };
                let motion =
                    Motion { time: (&time).into(), displacement: (&x).into(), rest_before: None };
                let force = law.predict(&[p, q, c0, rate], &[motion]).remove(0);
                let largest = force.iter().copied().fold(0.0, f64::max);
                let mut latent = DVector::from_element(1, 0.0);
                for k in 1..time.len() {
                    let speed = (x[k] - x[k - 1]) / (time[k] - time[k - 1]);
                    let right = |_: f64, y: &DVector<f64>| {
                        let relaxing = rate * y[0].signum() * y[0].abs().powf(exponent);
                        DVector::from_element(1, (1.0 / c0 - 1.0) * speed - relaxing)
                    };
                    latent = radau(&right, &latent, (time[k - 1], time[k]), 8);
                    let elastic = p / (q + 1.0) * x[k].powf(q + 1.0);
                    let exact = elastic / x[k] * (c0 * (x[k] + latent[0])).max(0.0);
                    assert!(
                        (force[k] - exact).abs() < 1e-6 * largest,
                        "n = {exponent}, {pace}/s, {} s: {} N for {exact} N",
                        time[k],
                        force[k]
                    );
                }
            }
        }
    }

    #[test]
    fn the_nodes_are_those_of_a_stiff_integrator_up_to_50_mm() {
        let count = 8;
        let (time, x) = deep_press(40.0);
        for exponent in EXPONENTS {
            for pace in PACES {
                let rate = pace / 350f64.powf(exponent - 1.0);
                let nodes = Segments { count, rate, exponent, equilibrium: Equilibrium::OwnNode }
                    .displacements(&time, &x);
                let mut inner = DVector::zeros(count - 1);
                for k in 1..time.len() {
                    // What a segment is compressed beyond its equilibrium moves the node after it.
                    let right = |at: f64, inner: &DVector<f64>| {
                        let part = (at - time[k - 1]) / (time[k] - time[k - 1]);
                        let contact = x[k - 1] + part * (x[k] - x[k - 1]);
                        let speed = |node: usize| {
                            let outer = if node == 0 { contact } else { inner[node - 1] };
                            let even = outer / (count - node) as f64;
                            let latent = count as f64 * (outer - inner[node] - even);
                            rate * latent.signum() * latent.abs().powf(exponent) / count as f64
                        };
                        DVector::from_iterator(count - 1, (0..count - 1).map(speed))
                    };
                    inner = radau(&right, &inner, (time[k - 1], time[k]), 8);
                    for (node, exact) in inner.iter().enumerate() {
                        assert!(
                            (nodes[node + 1][k] - exact).abs() < 2e-5,
                            "n = {exponent}, {pace}/s, {} s: node {} at {} mm for {exact} mm",
                            time[k],
                            node + 2,
                            nodes[node + 1][k]
                        );
                    }
                }
            }
        }
    }
}
