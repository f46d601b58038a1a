//! Pulled sideways until it slides: the rim of the contact slips first (6.3, 8.1).
//!
//! A tip is pressed on the fingertip and then pulled along x with a force that grows to the friction of the whole contact.
//! What still sticks is a disc of radius a ∛(1 − Q/μN) within the contact of radius a (Cattaneo, Mindlin); outside of it the
//! surface slips. The surface is no mirror: it holds by nubs, as a fingerprint does, one to each square of the ridges'
//! period. When the disc shrinks past a nub, that nub lets go, and the part of its share of the friction by which sticking
//! is stronger than sliding is lost within two milliseconds. The share follows Hertz's pressure where the nub is. Once all have let go the tip
//! slides, and all nubs catch and let go together, one period after the other.

use super::fingertip::wave_through_contact;
use super::{Fingertip, Indenter, SensorError, Stroke, Touch, clock, feel, within};

/// How to press and pull.
#[derive(Clone, Debug, PartialEq)]
pub struct Slip {
    /// With what.
    pub indenter: Indenter,
    /// Depth that is held, mm.
    pub depth_mm: f64,
    /// Where, x and y, mm.
    pub place_mm: [f64; 2],
    /// From nub to nub, mm.
    pub period_mm: f64,
    /// Friction coefficient of sticking.
    pub friction: f64,
    /// The part of its friction that a nub loses when it lets go.
    pub lost: f64,
    /// Time from rest at the depth to the pull, s.
    pub hold_s: f64,
    /// Time in which the pull grows to the friction, s.
    pub pull_s: f64,
    /// Speed of the slide that follows, mm/s.
    pub speed_mm_per_s: f64,
    /// How far it slides, mm.
    pub distance_mm: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

/// A pull and what was felt of it.
#[derive(Clone, Debug)]
pub struct SlipResult {
    /// The readings; the head says when the tip touched, when the rim began to slip and when all slid.
    pub touch: Touch,
    /// Radius of the contact, mm.
    pub contact_mm: f64,
    /// When each nub let go before the slide, s, in order.
    pub let_go_s: Vec<f64>,
    /// When the whole contact began to slide, s.
    pub slides_s: f64,
}

/// Rest before the press, s; how far off the tip starts, mm; how fast it comes, mm/s; how long a nub takes to let go, s.
const REST_S: f64 = 0.5;
const OFF_MM: f64 = 0.2;
const PRESS_MM_PER_S: f64 = 10.0;
const LETTING_GO_S: f64 = 0.002;

impl Slip {
    /// A blunt tip 0.3 mm deep beside the first gauge, nubs of 0.5 mm, friction 0.7 of which 15 % is lost, pulled for 1 s
    /// after 2 s of hold, then 4 mm at 10 mm/s, at 1 kHz.
    #[must_use]
    pub const fn beside_first_gauge(fingertip: &Fingertip) -> Self {
        let [x, y] = fingertip.gauges_mm[0];
        Self {
            indenter: Indenter::BLUNT,
            depth_mm: 0.3,
            place_mm: [x - 2.5, y],
            period_mm: 0.5,
            friction: 0.7,
            lost: 0.15,
            hold_s: 2.0,
            pull_s: 1.0,
            speed_mm_per_s: 10.0,
            distance_mm: 4.0,
            rate_hz: 1000.0,
        }
    }

    /// Presses, pulls, slides.
    ///
    /// # Errors
    /// [`SensorError`] for what cannot be done so.
    pub fn run(&self, fingertip: &Fingertip, seed: u64) -> Result<SlipResult, SensorError> {
        self.check()?;
        let down_s = REST_S + (OFF_MM + self.depth_mm) / PRESS_MM_PER_S;
        let pull_s = down_s + self.hold_s;
        let slides_s = pull_s + self.pull_s;
        let end_s = slides_s + self.distance_mm / self.speed_mm_per_s;
        let time = clock(end_s, self.rate_hz)?;
        let contact_mm = (self.indenter.radius_mm * self.depth_mm).sqrt();
        let friction_n = self.friction * fingertip.elastic_force(self.indenter, self.depth_mm);
        let nubs: Vec<Nub> = self
            .nubs(contact_mm, friction_n)
            .into_iter()
            .map(|(share_of_pull, lost_n)| Nub {
                at_s: pull_s + share_of_pull * self.pull_s,
                lost_n,
            })
            .collect();
        let slid = |t: f64| (t - slides_s).max(0.0) * self.speed_mm_per_s;
        let pull = |t: f64| {
            let grown = friction_n * ((t - pull_s) / self.pull_s).clamp(0.0, 1.0);
            let lost: f64 = nubs
                .iter()
                .map(|nub| nub.lost_n * ((t - nub.at_s) / LETTING_GO_S).clamp(0.0, 1.0))
                .sum();
            grown - lost + self.catching(friction_n, slid(t))
        };
        let depth = |t: f64| ((t - REST_S) * PRESS_MM_PER_S - OFF_MM).clamp(-OFF_MM, self.depth_mm);
        let stroke = Stroke {
            depth_mm: time.iter().map(|t| depth(*t)).collect(),
            place_mm: time
                .iter()
                .map(|t| [self.place_mm[0] + slid(*t), self.place_mm[1]])
                .collect(),
            pull_n: time.iter().map(|t| pull(*t)).collect(),
            time,
        };
        let name = format!("a pull of {} s until it slides", self.pull_s);
        let mut touch = feel(fingertip, self.indenter, &stroke, &name, seed)?;
        let mut let_go_s: Vec<f64> = nubs.iter().map(|nub| nub.at_s).collect();
        let_go_s.sort_by(f64::total_cmp);
        if let Some(first) = let_go_s.first() {
            touch.happened("slip", *first);
        }
        touch.happened("slide", slides_s);
        Ok(SlipResult { touch, contact_mm, let_go_s, slides_s })
    }

    /// Each nub: how far the pull has grown when it lets go, as a share of the friction, and what it then loses, N.
    fn nubs(&self, contact_mm: f64, friction_n: f64) -> Vec<(f64, f64)> {
        let a = contact_mm;
        let reach = (a / self.period_mm).ceil() as i32;
        // Off the middle by no simple fraction of the period, so that no two lie equally far out.
        let along = |k: i32, off: f64| (f64::from(k) + off) * self.period_mm;
        let mut places = Vec::new();
        for i in -reach..=reach {
            for k in -reach..=reach {
                let r = along(i, 0.37).hypot(along(k, 0.21));
                if r < a {
                    places.push(r);
                }
            }
        }
        let pressure = |r: f64| (1.0 - (r / a).powi(2)).sqrt();
        let whole: f64 = places.iter().map(|r| pressure(*r)).sum();
        let lost = |r: f64| self.lost * friction_n * pressure(r) / whole;
        places.iter().map(|r| (1.0 - (r / a).powi(3), lost(*r))).collect()
    }

    /// What the nubs hold together while they slide, N: caught again within nine tenths of a period, let go in the last.
    fn catching(&self, friction_n: f64, slid_mm: f64) -> f64 {
        let contact_mm = (self.indenter.radius_mm * self.depth_mm).sqrt();
        let together = wave_through_contact(contact_mm, self.period_mm).abs();
        let phase = (slid_mm / self.period_mm).fract();
        let caught = (phase / 0.9).min((1.0 - phase) / 0.1);
        self.lost * friction_n * together * caught
    }

    fn check(&self) -> Result<(), SensorError> {
        within("the rate (Hz)", self.rate_hz, 10.0, 1e5)?;
        within("the depth (mm)", self.depth_mm, 1e-3, 1e3)?;
        within("the friction coefficient", self.friction, 1e-3, 10.0)?;
        within("the part that is lost", self.lost, 0.0, 1.0)?;
        within("the hold (s)", self.hold_s, 1e-3, 1e5)?;
        within("the time of the pull (s)", self.pull_s, 1e-3, 1e5)?;
        within("the speed (mm/s)", self.speed_mm_per_s, 1e-3, 1e4)?;
        within("the distance (mm)", self.distance_mm, 1e-3, 1e4)?;
        let contact_mm = (self.indenter.radius_mm * self.depth_mm).sqrt();
        within("the period of the nubs (mm)", self.period_mm, contact_mm / 50.0, contact_mm)
    }
}

/// When a nub lets go, s, and what of the pull is lost with it, N.
struct Nub {
    at_s: f64,
    lost_n: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Silicone;

    #[test]
    fn nubs_let_go_from_the_rim_inwards_and_lose_what_friction_has_too_much() {
        let fingertip = Fingertip::new(Silicone::of("7:3".parse().unwrap()), 4.0).unwrap();
        let slip = Slip::beside_first_gauge(&fingertip);
        let nubs = slip.nubs(1.22, 2.0);
        let lost: f64 = nubs.iter().map(|nub| nub.1).sum();
        assert!(nubs.len() > 10 && (lost / (0.15 * 2.0) - 1.0).abs() < 1e-12, "{lost}");
        let result = slip.run(&fingertip, 1).unwrap();
        assert!(result.let_go_s.is_sorted() && result.let_go_s[0] > 2.5);
        assert!(result.let_go_s.last().unwrap() <= &result.slides_s);
        // The weakest are those of the rim, and they are the first.
        let first = nubs.iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        assert!(nubs.iter().all(|nub| nub.1 >= first.1));
    }

    #[test]
    fn a_gauge_reads_a_pull_as_the_sum_over_forces_side_by_side() {
        // Far off, a couple of forces is the derivative of one; and a pull towards a gauge compresses what is before it.
        let fingertip = Fingertip::new(Silicone::of("7:3".parse().unwrap()), 4.0).unwrap();
        let before = fingertip.readings_of_pull(0.1, [-3.0, 3.0])[0];
        let behind = fingertip.readings_of_pull(0.1, [9.0, 3.0])[0];
        assert!(before < 0.0 && (before + behind).abs() < 1e-9 * before.abs());
        assert_eq!(fingertip.readings_of_pull(0.1, [3.0, 3.0])[0], 0.0);
    }
}
