//! Silicone with four gauges in it, and what an indenter does to it at once.

use std::f64::consts::PI;

use shared::adaptation::Relaxation;
use shared::pipeline::GAUGES;
use shared::wire::Settings;

use super::{SensorError, Silicone, within};
use crate::{HertzField, Tip, bonded_layer_factor};

/// An indenter of given tip radius, a paraboloid (Fig. 8.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indenter {
    /// Radius of the tip, mm.
    pub radius_mm: f64,
}

impl Indenter {
    /// The sharp one.
    pub const SHARP: Self = Self { radius_mm: 0.5 };
    /// The blunt one.
    pub const BLUNT: Self = Self { radius_mm: 5.0 };
}

/// A fingertip: a layer of silicone on a rigid base, gauges lying flat in it, all measuring along x.
#[derive(Clone, Debug, PartialEq)]
pub struct Fingertip {
    /// What it is made of.
    pub silicone: Silicone,
    /// Thickness of the whole, mm.
    pub thickness_mm: f64,
    /// How much silicone lies above the gauges, mm: the top layer.
    pub cover_mm: f64,
    /// Where the gauges lie, x and y, mm.
    pub gauges_mm: [[f64; 2]; GAUGES],
    /// Part of the strain around it that a gauge takes up.
    pub transfer: f64,
    /// Part w of a reading that follows stress instead of strain.
    pub stress_share: f64,
    /// Beyond this a reading is cut off, µε: where the converter is at its rail.
    pub limit_ustrain: f64,
    /// Standard deviation of a reading, µε.
    pub noise_ustrain: f64,
}

/// Half the distance between neighbouring gauges, mm.
const HALF_PITCH: f64 = 3.0;
/// Deepest dent, as a part of the silicone above the gauges: the tip does not reach them.
pub(super) const DEEPEST: f64 = 0.9;

impl Fingertip {
    /// A fingertip with both layers equally thick, gauges at the corners of a square of 6 mm, cut off where the converter
    /// of a device that was never set is.
    ///
    /// `transfer` (0.08), `stress_share` (0.7) and the noise (0.1 µε) are assumptions: foil gauges in silicone differ.
    ///
    /// # Errors
    /// [`SensorError::Range`] for a thickness outside 1 to 100 mm.
    pub fn new(silicone: Silicone, thickness_mm: f64) -> Result<Self, SensorError> {
        within("the thickness (mm)", thickness_mm, 1.0, 100.0)?;
        let rail = 2f64.powi(23) * Settings::DEFAULT.calibration[0].gain;
        let h = HALF_PITCH;
        Ok(Self {
            silicone,
            thickness_mm,
            cover_mm: 0.5 * thickness_mm,
            gauges_mm: [[h, h], [-h, h], [-h, -h], [h, -h]],
            transfer: 0.08,
            stress_share: 0.7,
            limit_ustrain: rail,
            noise_ustrain: 0.1,
        })
    }

    /// The relaxation function of the readings: that of the silicone with shares less by `stress_share`.
    #[must_use]
    pub fn relaxation_of_readings(&self) -> Relaxation {
        let Relaxation { c1, v1, c2, v2 } = self.silicone.relaxation;
        Relaxation { c1: self.stress_share * c1, v1, c2: self.stress_share * c2, v2 }
    }

    /// The settings of a device that knows this silicone.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings { relaxation: self.relaxation_of_readings(), ..Settings::DEFAULT }
    }

    /// Force at a depth, mm, if nothing relaxes, N.
    #[must_use]
    pub fn elastic_force(&self, indenter: Indenter, depth_mm: f64) -> f64 {
        let tip = Tip::Paraboloid { radius_m: indenter.radius_mm * 1e-3 };
        let chi = (indenter.radius_mm * depth_mm.max(0.0)).sqrt() / self.thickness_mm;
        let elastic = self.silicone.elastic;
        tip.force(elastic.reduced_modulus(), depth_mm * 1e-3)
            * bonded_layer_factor(chi, elastic.poisson_ratio)
    }

    /// Depth, mm, at which a force, N, is reached if nothing relaxes; 0 for no force.
    #[must_use]
    pub fn depth_of_force(&self, indenter: Indenter, force_n: f64) -> f64 {
        if force_n <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, self.thickness_mm);
        while self.elastic_force(indenter, high) < force_n {
            high *= 2.0;
        }
        // Halving 60 times leaves the last bit.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.elastic_force(indenter, middle) < force_n {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// What each gauge would read, µε, if nothing relaxed nor was cut off, with the indenter at a depth, mm, and a place
    /// (x, y), mm. Tension is positive: right below an indenter the silicone is stretched sideways.
    #[must_use]
    pub fn elastic_readings(
        &self,
        indenter: Indenter,
        depth_mm: f64,
        place_mm: [f64; 2],
    ) -> [f64; GAUGES] {
        if depth_mm <= 0.0 {
            return [0.0; GAUGES];
        }
        let tip = Tip::Paraboloid { radius_m: indenter.radius_mm * 1e-3 };
        let force = self.elastic_force(indenter, depth_mm);
        let field = HertzField::of_force(force, tip.contact_radius(depth_mm * 1e-3));
        let elastic = self.silicone.elastic;
        let (modulus, v) = (elastic.modulus_pa, elastic.poisson_ratio);
        self.gauges_mm.map(|[x, y]| {
            let (dx, dy) = (x - place_mm[0], y - place_mm[1]);
            let r = dx.hypot(dy);
            let stress = field.stress(r * 1e-3, self.cover_mm * 1e-3, v);
            let radial = (stress.radial - v * (stress.hoop + stress.axial)) / modulus;
            let hoop = (stress.hoop - v * (stress.radial + stress.axial)) / modulus;
            // Share of the radial direction in that of the gauge, cos² of the angle between them.
            let along = if r > 0.0 { (dx / r).powi(2) } else { 0.5 };
            1e6 * self.transfer * (radial * along + hoop * (1.0 - along))
        })
    }

    /// What a force along x, N, at a place of the surface adds to each gauge's reading at once, µε: Cerruti's solution for a
    /// point force on a half space that keeps its volume.
    #[must_use]
    pub fn readings_of_pull(&self, pull_n: f64, place_mm: [f64; 2]) -> [f64; GAUGES] {
        let modulus = self.silicone.elastic.modulus_pa;
        self.gauges_mm.map(|[x, y]| {
            let [dx, dy, z] = [x - place_mm[0], y - place_mm[1], self.cover_mm].map(|d| 1e-3 * d);
            let r2 = dx * dx + dy * dy + z * z;
            // σ = −3 Q x (r ⊗ r) / (2π R⁵); Hooke's law along x with ν = 1/2.
            let along = dx * dx - 0.5 * (dy * dy + z * z);
            let strain = -3.0 * pull_n * dx * along / (2.0 * PI * modulus * r2.powf(2.5));
            1e6 * self.transfer * strain
        })
    }

    /// Checks what a caller may have set.
    ///
    /// # Errors
    /// [`SensorError::Range`] names what is out of range.
    pub fn check(&self) -> Result<(), SensorError> {
        within("the silicone above the gauges (mm)", self.cover_mm, 0.1, self.thickness_mm)?;
        within("the transfer", self.transfer, 1e-6, 1.0)?;
        within("the share of stress", self.stress_share, 0.0, 1.0)?;
        within("the limit (ustrain)", self.limit_ustrain, 1.0, 32_767.0)?;
        within("the noise (ustrain)", self.noise_ustrain, 0.0, 1e4)
    }
}

/// How deep the fingerprint's ridges still reach through a contact of a radius: a wave cos(2πx/λ) averaged over a Hertzian
/// pressure, 3 (sin q − q cos q)/q³ with q = 2πa/λ. Negative where the contact covers crest and trough the other way round.
pub(super) fn wave_through_contact(contact_radius: f64, period: f64) -> f64 {
    let q = 2.0 * PI * contact_radius / period;
    if q < 1e-2 { 1.0 - q * q / 10.0 } else { 3.0 * (q.sin() - q * q.cos()) / q.powi(3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fingertip(composition: &str, thickness_mm: f64) -> Fingertip {
        Fingertip::new(Silicone::of(composition.parse().unwrap()), thickness_mm).unwrap()
    }

    #[test]
    fn the_depth_of_a_force_gives_that_force() {
        let tip = fingertip("7:3", 4.0);
        for force in [1e-6, 0.01, 0.3] {
            let depth = tip.depth_of_force(Indenter::BLUNT, force);
            assert!((tip.elastic_force(Indenter::BLUNT, depth) / force - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_sharp_tip_strains_the_gauge_below_more_than_a_blunt_one_of_equal_force() {
        for (composition, thickness) in super::super::TABLE_8_2 {
            let tip = fingertip(composition, thickness);
            let reading = |indenter| {
                let depth = tip.depth_of_force(indenter, 0.2);
                tip.elastic_readings(indenter, depth, tip.gauges_mm[0])[0]
            };
            let (sharp, blunt) = (reading(Indenter::SHARP), reading(Indenter::BLUNT));
            assert!(
                sharp > 1.1 * blunt && blunt > 0.0,
                "{composition} {thickness}: {sharp} {blunt}"
            );
        }
    }

    #[test]
    fn gauges_that_lie_alike_to_the_indenter_read_alike() {
        let tip = fingertip("5:5", 4.0);
        let readings = tip.elastic_readings(Indenter::SHARP, 0.5, [0.0, 0.0]);
        for reading in readings {
            assert!((reading / readings[0] - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_wide_contact_does_not_feel_a_narrow_wave() {
        assert!((wave_through_contact(1e-6, 1.0) - 1.0).abs() < 1e-6);
        assert!(
            (wave_through_contact(0.00999 / (2.0 * PI), 1.0)
                - wave_through_contact(0.01001 / (2.0 * PI), 1.0))
            .abs()
                < 1e-6
        );
        assert!(wave_through_contact(1.6, 0.5).abs() < 0.01);
        // The wave weighted with √(1 − r²) over the disc, by the midpoint rule.
        let (mut sum, mut weight) = (0.0, 0.0);
        for i in 0..400 {
            for k in 0..400 {
                let (x, y) = (f64::from(i) / 200.0 - 0.9975, f64::from(k) / 200.0 - 0.9975);
                let p = (1.0 - x * x - y * y).max(0.0).sqrt();
                sum += p * (2.0 * PI * x / 1.7).cos();
                weight += p;
            }
        }
        assert!((wave_through_contact(1.0, 1.7) - sum / weight).abs() < 1e-4);
    }
}
