//! The commanded motion of one recording: rests and moves with rounded corners.
//!
//! At a corner the speed follows sin², so that acceleration and jerk are finite.

/// Displacement, speed and acceleration at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// Displacement, mm, positive into the specimen.
    pub x: f64,
    /// Speed, mm/s.
    pub speed: f64,
    /// Acceleration, mm/s².
    pub acceleration: f64,
}

/// A rest or a move, from a time on.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from_s: f64,
    lasts_s: f64,
    from_mm: f64,
    to_mm: f64,
}

/// A motion over time.
#[derive(Clone, Debug)]
pub struct Course {
    legs: Vec<Leg>,
    /// Time that a corner takes, s.
    corner_s: f64,
}

impl Course {
    /// At rest at a place.
    #[must_use]
    pub fn at_rest(x: f64, rest_s: f64, corner_s: f64) -> Self {
        Self { legs: vec![Leg { from_s: 0.0, lasts_s: rest_s, from_mm: x, to_mm: x }], corner_s }
    }

    /// Stays where it is.
    pub fn stay(&mut self, rest_s: f64) {
        let x = self.last().to_mm;
        self.legs.push(Leg { from_s: self.lasts_s(), lasts_s: rest_s, from_mm: x, to_mm: x });
    }

    /// Goes to a place at a speed in mm/s; the way is at least `speed` times the time of a corner.
    pub fn go(&mut self, to_mm: f64, speed: f64) {
        let from_mm = self.last().to_mm;
        let lasts_s = (to_mm - from_mm).abs() / speed + self.corner_s;
        self.legs.push(Leg { from_s: self.lasts_s(), lasts_s, from_mm, to_mm });
    }

    /// Duration, s.
    #[must_use]
    pub fn lasts_s(&self) -> f64 {
        self.last().from_s + self.last().lasts_s
    }

    fn last(&self) -> &Leg {
        self.legs.last().expect("a course begins at rest")
    }

    /// The motion at a time, s; before and after, it rests at its ends.
    #[must_use]
    pub fn at(&self, time: f64) -> State {
        let after = self.legs.partition_point(|leg| leg.from_s <= time);
        let leg = &self.legs[after.saturating_sub(1)];
        let way = leg.to_mm - leg.from_mm;
        if way == 0.0 {
            return State { x: leg.from_mm, ..State::default() };
        }
        let since = (time - leg.from_s).clamp(0.0, leg.lasts_s);
        let left = leg.lasts_s - since;
        let speed = way / (leg.lasts_s - self.corner_s);
        if since < self.corner_s {
            let start = self.corner(speed, since);
            State { x: leg.from_mm + start.x, ..start }
        } else if left < self.corner_s {
            let end = self.corner(speed, left);
            State { x: leg.to_mm - end.x, speed: end.speed, acceleration: -end.acceleration }
        } else {
            State {
                x: leg.from_mm + speed * (since - 0.5 * self.corner_s),
                speed,
                acceleration: 0.0,
            }
        }
    }

    /// From rest to a speed.
    fn corner(&self, speed: f64, since: f64) -> State {
        use std::f64::consts::PI;
        let turn = PI / self.corner_s;
        let (sin, cos) = (turn * since).sin_cos();
        State {
            x: 0.5 * speed * (since - sin / turn),
            speed: 0.5 * speed * (1.0 - cos),
            acceleration: 0.5 * speed * turn * sin,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_and_acceleration_are_the_slopes_of_the_motion() {
        let mut course = Course::at_rest(-0.5, 0.7, 0.04);
        course.go(8.0, 60.0);
        course.stay(1.0);
        course.go(-0.5, 20.0);
        let step = 1e-6;
        for k in 0..400 {
            let time = f64::from(k) * course.lasts_s() / 400.0;
            let (before, now, after) =
                (course.at(time - step), course.at(time), course.at(time + step));
            assert!(((after.x - before.x) / (2.0 * step) - now.speed).abs() < 1e-3);
            let slope = (after.speed - before.speed) / (2.0 * step);
            assert!((slope - now.acceleration).abs() < 0.2, "{time}: {slope}");
        }
        assert_eq!(course.at(99.0).x, -0.5);
    }
}
