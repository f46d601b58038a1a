//! Press, hold, release (Figs 8.3, 8.4).

use shared::pipeline::GAUGES;

use super::{
    Channels, Fingertip, Indenter, SensorError, Stroke, Touch, channels, clock, feel, within,
};
use palpate_model::{Hold, Motion, Move, Profile, Step};
use palpate_trace::GAUGES as NAMES;

/// How to press: down at a speed until the fingertip would, without relaxing, bear a force; hold; up; wait.
#[derive(Clone, Debug, PartialEq)]
pub struct Press {
    /// With what.
    pub indenter: Indenter,
    /// Force that a press too fast to relax would reach, N.
    pub force_n: f64,
    /// Where, x and y, mm.
    pub place_mm: [f64; 2],
    /// Speed of the indenter, mm/s.
    pub speed_mm_per_s: f64,
    /// How long it stays down, s.
    pub hold_s: f64,
    /// How long is waited after the release, s.
    pub after_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

impl Press {
    /// A press of 0.2 N over the first gauge of a fingertip, at 20 mm/s, held for 4 s, with 6 s after, at 1 kHz.
    #[must_use]
    pub const fn over_first_gauge(fingertip: &Fingertip, indenter: Indenter) -> Self {
        Self {
            indenter,
            force_n: 0.2,
            place_mm: fingertip.gauges_mm[0],
            speed_mm_per_s: 20.0,
            hold_s: 4.0,
            after_s: 6.0,
            rate_hz: 1000.0,
        }
    }
}

/// What one gauge felt of a press, µε.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Reading of largest size.
    pub peak: f64,
    /// Reading at the end of the hold.
    pub end_of_hold: f64,
    /// When it was first cut off, s since the press began; none if it never was.
    pub saturated_after_s: Option<f64>,
    /// Reading when the indenter has just left.
    pub left: f64,
    /// How long until half of that was gone, s; none if that is not seen before the end.
    pub half_recovered_s: Option<f64>,
    /// Largest FA in size.
    pub peak_fa: f64,
}

/// A press and what was felt of it.
#[derive(Clone, Debug)]
pub struct PressResult {
    /// Depth that was held, mm.
    pub depth_mm: f64,
    /// Largest force, N: less than was asked for by what relaxed on the way.
    pub peak_force_n: f64,
    /// The readings.
    pub touch: Touch,
    /// FA and SA of each gauge, as the device makes them.
    pub channels: [Channels; GAUGES],
    /// In figures.
    pub felt: [Felt; GAUGES],
}

/// Rest before the press, s, and how far off the indenter starts, mm.
const REST_S: f64 = 0.5;
const OFF_MM: f64 = 1.0;

impl Press {
    /// Presses a fingertip.
    ///
    /// # Errors
    /// [`SensorError`] for what cannot be pressed so.
    pub fn run(&self, fingertip: &Fingertip, seed: u64) -> Result<PressResult, SensorError> {
        within("the force (N)", self.force_n, 1e-9, 1e3)?;
        within("the speed (mm/s)", self.speed_mm_per_s, 1e-3, 1e4)?;
        within("the hold (s)", self.hold_s, 1e-3, 1e5)?;
        within("the time after (s)", self.after_s, 1e-3, 1e5)?;
        within("the rate (Hz)", self.rate_hz, 10.0, 1e5)?;
        let depth_mm = fingertip.depth_of_force(self.indenter, self.force_n);
        let travel = 2.0 * (depth_mm + OFF_MM) / self.speed_mm_per_s;
        // For its check of the number of samples.
        clock(REST_S + travel + self.hold_s + self.after_s, self.rate_hz)?;
        let motion = self.motion(depth_mm);
        let stroke = Stroke {
            place_mm: vec![self.place_mm; motion.time.len()],
            time: motion.time.into_owned(),
            depth_mm: motion.displacement.into_owned(),
            pull_n: Vec::new(),
        };
        self.felt(fingertip, depth_mm, &stroke, seed)
    }

    fn motion(&self, depth_mm: f64) -> Motion<'static> {
        let go = |to_mm| Step::Move(Move { to_mm, speed_mm_per_s: None });
        let stay = |hold_s| Step::Hold(Hold { hold_s });
        Profile {
            version: 1,
            rate_hz: self.rate_hz,
            start_mm: -OFF_MM,
            speed_mm_per_s: self.speed_mm_per_s,
            acceleration_mm_per_s2: None,
            repeat: 1,
            steps: vec![
                stay(REST_S),
                go(depth_mm),
                stay(self.hold_s),
                go(-OFF_MM),
                stay(self.after_s),
            ],
        }
        .motion()
    }

    fn felt(
        &self,
        fingertip: &Fingertip,
        depth_mm: f64,
        stroke: &Stroke,
        seed: u64,
    ) -> Result<PressResult, SensorError> {
        let name = format!(
            "a press of {} N, tip radius {} mm, on {} mm of silicone",
            self.force_n, self.indenter.radius_mm, fingertip.thickness_mm
        );
        let touch = feel(fingertip, self.indenter, stroke, &name, seed)?;
        let channels = channels(&touch.trace, &fingertip.settings())?;
        let down_s = REST_S + (depth_mm + OFF_MM) / self.speed_mm_per_s + self.hold_s;
        let felt = std::array::from_fn(|gauge| felt(&touch, &channels[gauge], gauge, down_s));
        let force = touch.trace.force().unwrap_or_default();
        let peak_force_n = force.iter().copied().fold(0.0, f64::max);
        Ok(PressResult { depth_mm, peak_force_n, touch, channels, felt })
    }
}

/// One gauge's press in figures; the indenter goes up at `up_s`.
fn felt(touch: &Touch, channels: &Channels, gauge: usize, up_s: f64) -> Felt {
    let time = &touch.trace.time;
    let readings = touch.trace.column(NAMES[gauge]).unwrap_or_default();
    let largest = |values: &[f64]| {
        values.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
    };
    let at = |instant: f64| time.partition_point(|t| *t <= instant).saturating_sub(1);
    let left = touch.left_at_s.map_or(readings.len() - 1, at);
    let residual = readings[left];
    let half = (left..readings.len()).find(|&k| readings[k].abs() <= 0.5 * residual.abs());
    Felt {
        peak: largest(readings),
        end_of_hold: readings[at(up_s)],
        saturated_after_s: touch.saturated_from_s[gauge].map(|since| since - REST_S),
        left: residual,
        half_recovered_s: half.map(|k| time[k] - time[left]),
        peak_fa: largest(&channels.fa),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Silicone;

    fn pressed(indenter: Indenter) -> PressResult {
        let fingertip = Fingertip::new(Silicone::of("5:5".parse().unwrap()), 4.0).unwrap();
        Press::over_first_gauge(&fingertip, indenter).run(&fingertip, 1).unwrap()
    }

    #[test]
    fn a_sharp_tip_saturates_the_gauge_a_blunt_one_does_not_and_both_creep_after_release() {
        let (sharp, blunt) = (pressed(Indenter::SHARP), pressed(Indenter::BLUNT));
        assert!(sharp.felt[0].saturated_after_s.unwrap() < 0.3);
        assert_eq!(blunt.felt[0].saturated_after_s, None);
        for felt in [sharp.felt[0], blunt.felt[0]] {
            assert!(felt.left > 0.02 * felt.peak, "{felt:?}");
            assert!((0.05..5.0).contains(&felt.half_recovered_s.unwrap()), "{felt:?}");
        }
    }

    #[test]
    fn fa_answers_the_press_and_dies_out_in_the_hold() {
        let blunt = pressed(Indenter::BLUNT);
        let fa = &blunt.channels[0].fa;
        assert!(fa[4500].abs() < 0.02 * blunt.felt[0].peak_fa, "{}", fa[4500]);
        assert!(blunt.felt[0].peak_fa > 0.05 * blunt.felt[0].peak);
    }
}
