//! A ball on a specimen that relaxes, carried by a cantilever, by brute force: sums over all that happened before, and
//! bisection. It shares nothing with the recurrences of `palpate::afm::hereditary`.

/// Tip, specimen and cantilever, in SI units.
pub struct Ball {
    /// Radius, m.
    pub radius: f64,
    /// Reduced modulus at once, Pa.
    pub reduced_modulus: f64,
    /// Spring constant, N/m.
    pub spring: f64,
    /// Constant pull while in contact, N.
    pub pull: f64,
    /// Relaxation function, 1 at 0.
    pub relaxation: fn(f64) -> f64,
}

/// A way of the piezo: time, s, and way, m, 0 at the touch.
pub struct Way {
    /// Time, s.
    pub time: Vec<f64>,
    /// Way of the piezo, m.
    pub z: Vec<f64>,
    /// First sample of the way back.
    pub leaves: usize,
}

impl Way {
    /// Through corners of (time, way), `interval` s apart; the last leg goes back.
    #[must_use]
    pub fn through(corners: &[(f64, f64)], interval: f64) -> Self {
        let end = corners[corners.len() - 1].0;
        let turn = corners[corners.len() - 2].0;
        let time: Vec<f64> =
            (0..=(end / interval).round() as usize).map(|k| k as f64 * interval).collect();
        let at = |t: f64| {
            let next = corners.iter().position(|c| c.0 >= t - 1e-9).unwrap_or(1).max(1);
            let ((t0, z0), (t1, z1)) = (corners[next - 1], corners[next]);
            z0 + (z1 - z0) * (t - t0) / (t1 - t0)
        };
        let z = time.iter().map(|t| at(*t)).collect();
        let leaves = time.iter().position(|t| *t > turn + 1e-9).unwrap_or(time.len());
        Self { time, z, leaves }
    }
}

impl Ball {
    fn elastic(&self, depth: f64) -> f64 {
        4.0 / 3.0 * self.reduced_modulus * self.radius.sqrt() * depth.max(0.0).powf(1.5)
    }

    /// Force at every sample, N.
    #[must_use]
    pub fn forces(&self, way: &Way) -> Vec<f64> {
        let count = way.time.len();
        let (mut depth, mut elastic, mut force) =
            (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let touch = -self.pull / self.spring;
        let mut first = 0;
        let mut lost = false;
        // The relaxation of what happened between two samples, seen from a third.
        let since = |n: usize, j: usize| {
            (self.relaxation)(way.time[n] - 0.5 * (way.time[j] + way.time[j - 1]))
        };
        for n in 1..count {
            if n < way.leaves && way.z[n] <= touch {
                first = n;
                continue;
            }
            if n < way.leaves {
                let held: f64 =
                    (first + 1..n).map(|j| since(n, j) * (elastic[j] - elastic[j - 1])).sum();
                let (mut low, mut high) = (0.0, way.z[n] - touch + 1e-6);
                for _ in 0..100 {
                    let middle = 0.5 * (low + high);
                    let contact = held + since(n, n) * (self.elastic(middle) - elastic[n - 1]);
                    let bent = self.spring * (way.z[n] - middle);
                    if contact - self.pull > bent { high = middle } else { low = middle }
                }
                (depth[n], elastic[n]) = (low, self.elastic(low));
                force[n] = self.spring * (way.z[n] - low);
                continue;
            }
            // As large as at sample j: what Ting's integral leaves, force and depth.
            let as_at = |j: usize| {
                let contact: f64 =
                    (first + 1..=j).map(|i| since(n, i) * (elastic[i] - elastic[i - 1])).sum();
                let now = way.z[n] - (contact - self.pull) / self.spring;
                let to = |i: usize| if i == n { now } else { depth[i] };
                let left: f64 = (j + 1..=n).map(|i| since(n, i) * (to(i) - depth[i - 1])).sum();
                (left, contact)
            };
            lost |= as_at(first).0 < 0.0;
            if lost {
                continue;
            }
            let (mut low, mut high) = (first, way.leaves - 1);
            while high - low > 1 {
                let middle = usize::midpoint(low, high);
                if as_at(middle).0 < 0.0 { high = middle } else { low = middle }
            }
            let (a, b) = (as_at(low), as_at(high));
            let part = if b.0 >= 0.0 { 1.0 } else { a.0 / (a.0 - b.0) };
            force[n] = a.1 + part * (b.1 - a.1) - self.pull;
            depth[n] = way.z[n] - force[n] / self.spring;
        }
        force
    }
}
