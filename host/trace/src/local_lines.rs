//! A course without its noise: at each sample a straight line over as many neighbours as agree with it. Corners stay, because lines
//! over the samples before and over those after are tried as well (the intersection of confidence intervals; Goldenshluger and
//! Nemirovski, Math. Methods Statist. 6 (1997) 135; Katkovnik, IEEE Trans. Signal Process. 47 (1999) 2567).

/// Numbers of neighbours to a side that are tried in turn.
const REACHES: [usize; 11] = [2, 3, 5, 8, 12, 18, 27, 41, 62, 93, 140];
/// Standard errors within which lines over more and more neighbours agree.
const AGREE: f64 = 2.5;
/// Standard deviations that a sample is hardly ever off: the first line agrees with it within these.
const FAR: f64 = 4.0;

/// Which neighbours a line goes through.
#[derive(Clone, Copy)]
enum Side {
    Before,
    After,
    Both,
}

/// The values without noise of this standard deviation, which is the same for all of them and independent from sample to sample.
#[must_use]
pub(super) fn smoothed(time: &[f64], values: &[f64], deviation: f64) -> Vec<f64> {
    let best = |k: usize| {
        let sides = [Side::Both, Side::Before, Side::After];
        let lines = sides.into_iter().map(|side| widest(time, values, deviation, k, side));
        lines.min_by(|a, b| a.variance.total_cmp(&b.variance)).map_or(values[k], |it| it.value)
    };
    (0..values.len()).map(best).collect()
}

/// What a line says at a sample.
#[derive(Clone, Copy)]
struct Said {
    value: f64,
    /// Its variance, over that of one sample.
    variance: f64,
}

/// The line over most neighbours of all that agree with those over fewer.
fn widest(time: &[f64], values: &[f64], deviation: f64, k: usize, side: Side) -> Said {
    let mut sums = Sums::default();
    sums.add(0.0, values[k]);
    let mut said = Said { value: values[k], variance: 1.0 };
    let (mut least, mut most) = (values[k] - FAR * deviation, values[k] + FAR * deviation);
    let mut from = 1;
    for reach in REACHES {
        for away in from..=reach {
            let (before, after) = (k.checked_sub(away), k + away);
            let outside = match side {
                Side::Before => before.is_none(),
                Side::After => after >= values.len(),
                Side::Both => before.is_none() || after >= values.len(),
            };
            if outside {
                return said;
            }
            if let (Some(j), Side::Before | Side::Both) = (before, side) {
                sums.add(time[j] - time[k], values[j]);
            }
            if matches!(side, Side::After | Side::Both) {
                sums.add(time[after] - time[k], values[after]);
            }
        }
        from = reach + 1;
        let Some(line) = sums.line() else { return said };
        let error = AGREE * deviation * line.variance.sqrt();
        least = least.max(line.value - error);
        most = most.min(line.value + error);
        if least > most {
            return said;
        }
        said = line;
    }
    said
}

/// Sums over samples, their times counted from the one at hand.
#[derive(Default)]
struct Sums {
    count: f64,
    t: f64,
    tt: f64,
    y: f64,
    ty: f64,
}

impl Sums {
    fn add(&mut self, t: f64, y: f64) {
        self.count += 1.0;
        self.t += t;
        self.tt += t * t;
        self.y += y;
        self.ty += t * y;
    }

    /// The straight line at the sample at hand; none where all times are the same.
    fn line(&self) -> Option<Said> {
        let size = self.count * self.tt - self.t * self.t;
        let value = (self.tt * self.y - self.t * self.ty) / size;
        (size > 0.0 && value.is_finite()).then_some(Said { value, variance: self.tt / size })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_corners_come_back_as_they_are() {
        let time: Vec<f64> =
            (0..600).map(|k| 0.01 * f64::from(k) + 1e-3 * f64::from(k % 3)).collect();
        let course = |t: f64| (3.0 * t - 2.0).clamp(0.0, 5.0);
        let values: Vec<f64> = time.iter().map(|&t| course(t)).collect();
        for deviation in [0.0, 1e-6] {
            let found = smoothed(&time, &values, deviation);
            let worst = found.iter().zip(&values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-5, "{worst:e}");
        }
    }

    #[test]
    fn short_courses_stay() {
        for count in 0..3 {
            let time: Vec<f64> = (0..count).map(f64::from).collect();
            assert_eq!(smoothed(&time, &time, 0.1), time);
        }
    }
}
