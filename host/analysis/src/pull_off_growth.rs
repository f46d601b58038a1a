//! Growth of a pull-off with the speed of the retreat: F = F0 (1 + (v/v0)^n) (Gent and Schultz 1972; Maugis and
//! Barquins 1978).

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::pull_off::PullOff;
use super::rates::Estimate;
use palpate_fit::by_differences::least_squares;
use palpate_fit::least_squares::Effort;

/// Speeds within this ratio are the same.
const SAME_SPEED: f64 = 1.1;
/// Parameters of the law.
const PARAMETERS: usize = 3;
/// Fewest speeds that a line of two parameters can be tested with.
const LINE: usize = 3;
/// Level of the intervals by which a parameter is called identifiable.
const LEVEL: f64 = 0.95;

/// Pull-offs at one speed.
#[derive(Clone, Debug, PartialEq)]
pub struct AtSpeed {
    /// Mean speed of the indenter while the specimen pulls, mm/s.
    pub speed_mm_per_s: f64,
    /// How many pull-offs.
    pub count: usize,
    /// Pull-off force, N: mean, with the standard error from the scatter of several.
    pub force_n: Estimate,
    /// Work of adhesion, mJ: the same.
    pub work_mj: Estimate,
    /// Displacement of the separation, mm: the same.
    pub separation_mm: Estimate,
}

/// F = F0 (1 + (v/v0)^n).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Force at rest F0, N.
    pub force_n: (f64, f64),
    /// Speed v0 at which it has doubled, mm/s.
    pub speed_mm_per_s: (f64, f64),
    /// Exponent n.
    pub exponent: (f64, f64),
}

impl Law {
    /// Force at a speed, mm/s.
    #[must_use]
    pub fn at(&self, speed: f64) -> f64 {
        self.force_n.0 * (1.0 + (speed / self.speed_mm_per_s.0).powf(self.exponent.0))
    }
}

/// How pull-offs grow with the speed.
#[derive(Clone, Debug)]
pub struct Growth {
    /// Each speed, the slowest first.
    pub speeds: Vec<AtSpeed>,
    /// d ln F / d ln v over all speeds, with the standard error from the scatter about the line; none for fewer
    /// than three speeds.
    pub slope: Option<(f64, f64)>,
    /// The law, or why it is not identifiable.
    pub law: Result<Law, String>,
}

/// Compares pull-offs at their speeds; none where there are fewer than two speeds.
#[must_use]
pub fn growth(found: &[PullOff]) -> Option<Growth> {
    let mut found: Vec<&PullOff> = found.iter().collect();
    found.sort_by(|a, b| a.speed_mm_per_s.total_cmp(&b.speed_mm_per_s));
    let speeds: Vec<AtSpeed> = found
        .chunk_by(|a, b| b.speed_mm_per_s <= SAME_SPEED * a.speed_mm_per_s)
        .map(at_speed)
        .collect();
    (speeds.len() >= 2).then(|| Growth { slope: slope(&speeds), law: law(&speeds), speeds })
}

fn at_speed(group: &[&PullOff]) -> AtSpeed {
    let mean = |of: &dyn Fn(&PullOff) -> f64, error: f64| {
        let count = group.len() as f64;
        let mean = group.iter().map(|pull| of(pull)).sum::<f64>() / count;
        if group.len() == 1 {
            return (mean, Some(error));
        }
        let square: f64 = group.iter().map(|pull| (of(pull) - mean).powi(2)).sum();
        (mean, Some((square / (count - 1.0) / count).sqrt()))
    };
    let only = group[0];
    AtSpeed {
        speed_mm_per_s: mean(&|pull| pull.speed_mm_per_s, 0.0).0,
        count: group.len(),
        force_n: mean(&|pull| pull.force_n, only.force_error_n),
        work_mj: mean(&|pull| pull.work_mj, only.work_error_mj),
        separation_mm: if group.len() == 1 {
            (only.separation_mm, None)
        } else {
            mean(&|pull| pull.separation_mm, 0.0)
        },
    }
}

/// The line of ln F over ln v.
fn slope(speeds: &[AtSpeed]) -> Option<(f64, f64)> {
    if speeds.len() < LINE {
        return None;
    }
    let points: Vec<(f64, f64)> =
        speeds.iter().map(|s| (s.speed_mm_per_s.ln(), s.force_n.0.ln())).collect();
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    let rest: f64 = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sum();
    let left = rest / (count - 2.0) / spread;
    // A line through all points says nothing of errors that the means have in themselves.
    let own = |(s, p): (&AtSpeed, &(f64, f64))| {
        let relative = s.force_n.1.unwrap_or(0.0) / s.force_n.0;
        ((p.0 - x) / spread * relative).powi(2)
    };
    let means: f64 = speeds.iter().zip(&points).map(own).sum();
    Some((slope, left.max(means).sqrt()))
}

/// The law by weighted least squares. Its errors grow by what it leaves beyond those of the means. It is
/// identifiable where the 95 % intervals (Student's t) tell F0 and v0 to a factor of ten and n from zero.
fn law(speeds: &[AtSpeed]) -> Result<Law, String> {
    let count = speeds.len();
    if count <= PARAMETERS {
        return Err(format!(
            "{count} speeds are too few for its three parameters and their errors: it takes {} at least",
            PARAMETERS + 1
        ));
    }
    let (slowest, fastest) = (speeds[0].speed_mm_per_s, speeds[count - 1].speed_mm_per_s);
    let middle = (slowest * fastest).sqrt();
    let least = speeds.iter().map(|s| s.force_n.0).fold(f64::INFINITY, f64::min);
    // Repeats that agree by chance must not outweigh all other speeds.
    let errors: Vec<f64> = speeds.iter().map(|s| s.force_n.1.unwrap_or(0.0)).collect();
    let typical = (errors.iter().map(|e| e * e).sum::<f64>() / count as f64).sqrt();
    let weight = |k: usize| 1.0 / errors[k].max(typical).max(1e-9 * least);
    let shape = |point: &[f64], speed: f64| {
        let (force, place) = (least * point[0].exp(), middle * point[1].exp());
        force * (1.0 + (speed / place).powf(point[2]))
    };
    let residuals = |point: &[f64]| -> Vec<f64> {
        let miss =
            |(k, s): (usize, &AtSpeed)| (shape(point, s.speed_mm_per_s) - s.force_n.0) * weight(k);
        speeds.iter().enumerate().map(miss).collect()
    };
    let bounds = [(-20.0, 5.0), (-20.0, 20.0), (0.01, 5.0)];
    let cost = |point: &[f64]| residuals(point).iter().map(|r| r * r).sum::<f64>();
    let starts = [0.1, 0.2, 0.4, 0.7, 1.0].into_iter().flat_map(|exponent| {
        [-4.0, -2.0, 0.0, 2.0].map(|place| {
            let grown = 1.0 + (slowest / (middle * f64::exp(place))).powf(exponent);
            [-grown.ln(), place, exponent]
        })
    });
    let fitted = starts
        .map(|start| least_squares(&bounds, &start, count, Effort::FULL, residuals))
        .min_by(|a, b| cost(&a.solution.point).total_cmp(&cost(&b.solution.point)))
        .ok_or("no start")?;
    let point = &fitted.solution.point;
    // `least_squares` scales by what is left; where that is less than the errors of the means, they count.
    let scale = 1.0 / fitted.rms.clamp(f64::MIN_POSITIVE, 1.0);
    let errors: Vec<f64> = fitted.standard_errors.iter().map(|e| e * scale).collect();
    let student =
        StudentsT::new(0.0, 1.0, (count - PARAMETERS) as f64).map_err(|e| e.to_string())?;
    let wide = student.inverse_cdf(0.5 + 0.5 * LEVEL);
    let told = |k: usize, most: f64| wide * errors[k] < most;
    let factor = 10f64.ln();
    let mut vague = Vec::new();
    for (k, name, most) in [(0, "F0", factor), (1, "v0", factor), (2, "n", point[2])] {
        let bound = point[k] <= bounds[k].0 + 1e-9 || point[k] >= bounds[k].1 - 1e-9;
        if bound || !told(k, most) {
            vague.push(name);
        }
    }
    if !vague.is_empty() {
        return Err(format!(
            "{count} speeds from {slowest:.3} to {fastest:.3} mm/s do not determine {}",
            vague.join(", ")
        ));
    }
    let (force, place) = (least * point[0].exp(), middle * point[1].exp());
    Ok(Law {
        force_n: (force, force * errors[0]),
        speed_mm_per_s: (place, place * errors[1]),
        exponent: (point[2], errors[2]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pull-offs by the law with 1 % of scatter that is the same on every run, five at each speed.
    fn pulls(speeds: &[f64], law: impl Fn(f64) -> f64) -> Vec<PullOff> {
        let wobble = |k: usize| 0.01 * ((k * 7919 % 101) as f64 / 29.0 - 1.74);
        let one = |(k, speed): (usize, f64)| PullOff {
            sample: 0,
            force_n: law(speed) * (1.0 + wobble(k)),
            force_error_n: 0.001,
            displacement_mm: -0.5,
            separation_mm: -1.0,
            work_mj: 1.0,
            work_error_mj: 0.01,
            speed_mm_per_s: speed,
            zero_n: 0.0,
        };
        speeds.iter().flat_map(|s| [*s; 5]).enumerate().map(one).collect()
    }

    #[test]
    fn the_law_is_found_within_its_errors_where_the_speeds_tell_it() {
        let truth = |v: f64| 0.5 * (1.0 + (v / 0.02).powf(0.45));
        let speeds = [0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0];
        let found = growth(&pulls(&speeds, truth)).unwrap();
        assert_eq!(found.speeds.len(), 9);
        assert!(found.speeds.iter().all(|speed| speed.count == 5));
        let law = found.law.unwrap();
        for ((value, error), truth) in
            [(law.force_n, 0.5), (law.speed_mm_per_s, 0.02), (law.exponent, 0.45)]
        {
            assert!((value - truth).abs() < 3.0 * error, "{value} ± {error} for {truth}");
            assert!(error < 0.3 * truth, "{value} ± {error}");
        }
    }

    #[test]
    fn a_bare_power_has_a_slope_and_no_law() {
        let found = growth(&pulls(&[0.01, 0.1, 1.0, 10.0], |v| 2.0 * v.powf(0.3))).unwrap();
        let (slope, error) = found.slope.unwrap();
        assert!((slope - 0.3).abs() < 3.0 * error && error < 0.02, "{slope} ± {error}");
        let why = found.law.unwrap_err();
        assert!(why.contains("F0"), "{why}");
    }

    #[test]
    fn too_few_speeds_are_said_to_be_so() {
        let found = growth(&pulls(&[0.01, 0.1, 1.0], |v| 1.0 + v)).unwrap();
        assert!(found.law.unwrap_err().contains("3 speeds are too few"));
        assert!(growth(&pulls(&[0.01], |v| 1.0 + v)).is_none());
    }
}
