//! Sliding over a fingerprint: ridges make a vibration of frequency speed over period.

use std::f64::consts::TAU;

use super::fingertip::wave_through_contact;
use super::{
    Channels, Fingertip, Indenter, SensorError, Spectrum, Stroke, Touch, channels, clock, feel,
    spectrum, within,
};

/// A fingerprint: waves on the surface, crests across x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ridges {
    /// From crest to crest, mm.
    pub period_mm: f64,
    /// From trough to crest, mm; 0 is a smooth fingertip.
    pub height_mm: f64,
}

/// A tip that slides along x from one end of a stretch to the other, over the middle of it at half time.
#[derive(Clone, Debug, PartialEq)]
pub struct Slide {
    /// With what.
    pub indenter: Indenter,
    /// On what.
    pub ridges: Ridges,
    /// Depth below the mean surface, mm.
    pub depth_mm: f64,
    /// Speed, mm/s.
    pub speed_mm_per_s: f64,
    /// How far, mm.
    pub distance_mm: f64,
    /// Along which y, mm.
    pub y_mm: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

impl Slide {
    /// 0.1 mm deep over 16 mm at 20 mm/s, above the first two gauges, over ridges of 0.5 mm and 0.1 mm height, with the
    /// sharp tip, at 4 kHz.
    #[must_use]
    pub const fn over_first_gauges(fingertip: &Fingertip) -> Self {
        Self {
            indenter: Indenter::SHARP,
            ridges: Ridges { period_mm: 0.5, height_mm: 0.1 },
            depth_mm: 0.1,
            speed_mm_per_s: 20.0,
            distance_mm: 16.0,
            y_mm: fingertip.gauges_mm[0][1],
            rate_hz: 4000.0,
        }
    }
}

/// A slide and what was felt of it.
#[derive(Clone, Debug)]
pub struct SlideResult {
    /// The readings.
    pub touch: Touch,
    /// FA and SA of the first gauge.
    pub channels: Channels,
    /// Spectrum of FA of the first gauge.
    pub spectrum: Spectrum,
    /// Speed over period, Hz.
    pub expected_hz: f64,
    /// Frequency, Hz, and amplitude, µε, of the highest line of FA above half the expected frequency: below it is the
    /// passing of the tip as a whole. The line is as wide as speed over the stretch in which a gauge feels the tip.
    pub line: Option<(f64, f64)>,
    /// What the ridges' wave keeps of its height through the contact; less than one because the contact covers a part of
    /// the wave, and of either sign.
    pub through_contact: f64,
}

impl Slide {
    /// Slides over a fingertip.
    ///
    /// The surface is taken as slightly wavy: the contact stays whole, and the ridges raise the depth by their wave averaged
    /// over it.
    ///
    /// # Errors
    /// [`SensorError`] for what cannot be done so.
    pub fn run(&self, fingertip: &Fingertip, seed: u64) -> Result<SlideResult, SensorError> {
        self.check()?;
        let time = clock(self.distance_mm / self.speed_mm_per_s, self.rate_hz)?;
        let contact_mm = (self.indenter.radius_mm * self.depth_mm).sqrt();
        let Ridges { period_mm, height_mm } = self.ridges;
        let through_contact = wave_through_contact(contact_mm, period_mm);
        let x = |t: f64| self.speed_mm_per_s * t - 0.5 * self.distance_mm;
        let wave = |t: f64| 0.5 * height_mm * through_contact * (TAU * x(t) / period_mm).cos();
        let stroke = Stroke {
            depth_mm: time.iter().map(|t| self.depth_mm + wave(*t)).collect(),
            place_mm: time.iter().map(|t| [x(*t), self.y_mm]).collect(),
            time,
            pull_n: Vec::new(),
        };
        let name = format!("a slide at {} mm/s over ridges of {period_mm} mm", self.speed_mm_per_s);
        let touch = feel(fingertip, self.indenter, &stroke, &name, seed)?;
        let [channels, ..] = channels(&touch.trace, &fingertip.settings())?;
        let spectrum = spectrum(&channels.fa, self.rate_hz);
        let expected_hz = self.speed_mm_per_s / period_mm;
        let line = spectrum.line_above(0.5 * expected_hz);
        Ok(SlideResult { touch, channels, spectrum, expected_hz, line, through_contact })
    }

    fn check(&self) -> Result<(), SensorError> {
        within("the rate (Hz)", self.rate_hz, 10.0, 1e5)?;
        within("the depth (mm)", self.depth_mm, 1e-6, 1e3)?;
        within("the speed (mm/s)", self.speed_mm_per_s, 1e-3, 1e4)?;
        within("the distance (mm)", self.distance_mm, 0.1, 1e4)?;
        let slowest = self.speed_mm_per_s / (0.45 * self.rate_hz);
        within("the period of the ridges (mm)", self.ridges.period_mm, slowest, 1e3)?;
        within("the height of the ridges (mm)", self.ridges.height_mm, 0.0, self.depth_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Silicone;

    fn fingertip() -> Fingertip {
        Fingertip::new(Silicone::of("7:3".parse().unwrap()), 4.0).unwrap()
    }

    #[test]
    fn ridges_hum_at_speed_over_period_whatever_the_speed() {
        for speed_mm_per_s in [10.0, 20.0, 40.0] {
            let slide = Slide { speed_mm_per_s, ..Slide::over_first_gauges(&fingertip()) };
            let result = slide.run(&fingertip(), 1).unwrap();
            let (frequency, amplitude) = result.line.unwrap();
            assert!((frequency * 0.5 / speed_mm_per_s - 1.0).abs() < 0.02, "{frequency}");
            assert!(amplitude > 1.0, "{amplitude}");
        }
    }

    #[test]
    fn a_smooth_fingertip_does_not_hum() {
        let ridges = Ridges { period_mm: 0.5, height_mm: 0.0 };
        let smooth = Slide { ridges, ..Slide::over_first_gauges(&fingertip()) };
        let rough = Slide::over_first_gauges(&fingertip());
        let at_40 = |slide: &Slide| {
            let spectrum = slide.run(&fingertip(), 1).unwrap().spectrum;
            let near = spectrum.frequency_hz.partition_point(|f| *f < 40.0 - 1e-9);
            spectrum.amplitude[near]
        };
        assert!(at_40(&smooth) < 0.01 * at_40(&rough));
    }
}
