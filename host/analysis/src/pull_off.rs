//! How an adhesive contact comes off: pull-off force, work of adhesion, separation.

use std::ops::RangeInclusive;

/// A recording as three columns: time, s, displacement, mm, and force, N.
pub(super) struct Sampled<'a> {
    pub(super) time: &'a [f64],
    pub(super) x: &'a [f64],
    pub(super) force: &'a [f64],
}

/// A contact that came off. Forces count from that after the separation, a pull being positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PullOff {
    /// Sample of the largest pull.
    pub sample: usize,
    /// Largest pull, N.
    pub force_n: f64,
    /// Its standard error from the noise of that sample and of the force after the separation, N.
    pub force_error_n: f64,
    /// Displacement there, mm.
    pub displacement_mm: f64,
    /// Displacement at which the pull has gone, mm; negative is above the nominal touch.
    pub separation_mm: f64,
    /// Work of adhesion, mJ: the area under the pull over displacement.
    pub work_mj: f64,
    /// Its standard error from the noise, mJ.
    pub work_error_mj: f64,
    /// Mean speed of the indenter while the specimen pulls, mm/s.
    pub speed_mm_per_s: f64,
    /// Force after the separation, N, as recorded.
    pub zero_n: f64,
}

/// Samples after the separation that tell its force.
const SAMPLES_AFTER: usize = 5;
/// Part of the way out from the separation on that belongs to the end of the way out.
const STANDING: f64 = 0.01;
/// Standard error of a median over that of a mean, normal noise.
const MEDIAN: f64 = 1.253;

/// What a pull shows that lasts over `samples`; the next press begins at `end`. `pressed` is the sign of a
/// pressing force, `noise` the deviation of the force, N.
pub(super) fn pull_off(
    path: &Sampled,
    samples: RangeInclusive<usize>,
    end: usize,
    noise: f64,
    pressed: f64,
) -> Option<PullOff> {
    let (first, last) = (*samples.start(), *samples.end());
    let (zero_n, zero_error) = zero(path, last..=end.min(path.time.len()) - 1, noise);
    let pull = |k: usize| (zero_n - path.force[k]) * pressed;
    let sample = samples.max_by(|&a, &b| pull(a).total_cmp(&pull(b)))?;
    let lasts = path.time[last] - path.time[first];
    let way = path.x[first] - path.x[last];
    if lasts <= 0.0 || way <= 0.0 || pull(sample) <= 0.0 {
        return None;
    }
    let mut work_mj = 0.0;
    let mut square = 0.0;
    for k in first + 1..=last {
        work_mj += 0.5 * (pull(k) + pull(k - 1)) * (path.x[k - 1] - path.x[k]);
        let next = (k + 1).min(last);
        square += (0.5 * (path.x[k - 1] - path.x[next])).powi(2);
    }
    // From zero force to the first sample of the pull the force falls along a line.
    if first > 0 && pull(first - 1) < 0.0 {
        let part = pull(first) / (pull(first) - pull(first - 1));
        work_mj += 0.5 * pull(first) * part * (path.x[first - 1] - path.x[first]);
    }
    Some(PullOff {
        sample,
        force_n: pull(sample),
        force_error_n: noise.hypot(zero_error),
        displacement_mm: path.x[sample],
        separation_mm: path.x[last],
        work_mj,
        work_error_mj: (noise * square.sqrt()).hypot(zero_error * way),
        speed_mm_per_s: way / lasts,
        zero_n,
    })
}

/// Force off the specimen and its standard error, N: the median from the separation to the end of the way
/// out; the recorded zero where that has too few samples.
fn zero(path: &Sampled, after: RangeInclusive<usize>, noise: f64) -> (f64, f64) {
    let least = after.clone().map(|k| path.x[k]).fold(f64::INFINITY, f64::min);
    let farthest = least + STANDING * (path.x[*after.start()] - least);
    let out = after.clone().find(|&k| path.x[k] <= farthest).unwrap_or(*after.start());
    let mut values = path.force[*after.start()..=out].to_vec();
    if values.len() < SAMPLES_AFTER {
        return (0.0, noise);
    }
    let middle = values.len() / 2;
    let median = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    (median, MEDIAN * noise / (values.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_of_pull_over_a_drifted_zero_has_its_height_and_area() {
        // Pull grows to 2 N over 0.4 mm and falls to none over 0.6 mm, at 0.5 mm/s; the zero is 0.1 N.
        let (time, x): (Vec<f64>, Vec<f64>) =
            (0..=400).map(|k| (0.01 * f64::from(k), 0.2 - 0.005 * f64::from(k))).unzip();
        let force: Vec<f64> = x
            .iter()
            .map(|x| {
                let way = -x;
                let pull = if way < 0.4 { way / 0.4 * 2.0 } else { (1.0 - way) / 0.6 * 2.0 };
                0.1 - if way < 1.0 { pull } else { 0.0 }
            })
            .collect();
        let path = Sampled { time: &time, x: &x, force: &force };
        let found = pull_off(&path, 41..=240, time.len(), 0.01, 1.0).unwrap();
        assert!((found.force_n - 2.0).abs() < 1e-9 && (found.zero_n - 0.1).abs() < 1e-12);
        assert!((found.work_mj - 1.0).abs() < 1e-4, "{}", found.work_mj);
        assert!((found.displacement_mm + 0.4).abs() < 1e-9);
        assert!((found.separation_mm + 1.0).abs() < 1e-9);
        assert!((found.speed_mm_per_s - 0.5).abs() < 1e-9);
        // Over 200 samples of 5 µm the noise of one sample, and that of the zero over the whole way.
        let error = (0.01 * 0.005 * 200f64.sqrt()).hypot(1.253 * 0.01 / 159f64.sqrt() * 0.995);
        assert!((found.work_error_mj / error - 1.0).abs() < 0.02, "{}", found.work_error_mj);
    }
}
