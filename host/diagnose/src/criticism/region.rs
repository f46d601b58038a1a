//! The regions of a recording in which errors are counted.

use palpate_trace::{Kind, segments};

/// A region of a recording, from its motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Region {
    /// Before the first touch.
    Approach,
    /// Displacement grows.
    Loading,
    /// The first quarter of a hold.
    EarlyHold,
    /// The rest of a hold.
    LateHold,
    /// Displacement falls.
    Unloading,
    /// Off the specimen after a touch.
    After,
}

impl Region {
    /// Every region, in the order of a press.
    pub const ALL: [Self; 6] = [
        Self::Approach,
        Self::Loading,
        Self::EarlyHold,
        Self::LateHold,
        Self::Unloading,
        Self::After,
    ];

    /// Name in tables and answers.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Approach => "approach",
            Self::Loading => "loading",
            Self::EarlyHold => "early hold",
            Self::LateHold => "late hold",
            Self::Unloading => "unloading",
            Self::After => "after",
        }
    }

    /// Where that is, in a sentence.
    pub(super) fn place(self) -> &'static str {
        match self {
            Self::Approach => "in the approach",
            Self::Loading => "in the loading",
            Self::EarlyHold => "in the early hold",
            Self::LateHold => "in the late hold",
            Self::Unloading => "in the unloading",
            Self::After => "after the release",
        }
    }
}

/// Share of a hold's time that counts as early.
const EARLY: f64 = 0.25;

/// The region of each sample of a motion.
#[must_use]
pub fn regions(time: &[f64], displacement: &[f64]) -> Vec<Region> {
    let mut found = vec![Region::Approach; time.len()];
    for segment in segments(time, displacement) {
        let range = segment.range;
        match segment.kind {
            Kind::Approach => found[range].fill(Region::Approach),
            Kind::Load => found[range].fill(Region::Loading),
            Kind::Unload => found[range].fill(Region::Unloading),
            Kind::After => found[range].fill(Region::After),
            Kind::Hold => {
                let begin = time[range.start];
                let early = begin + EARLY * (time[range.end - 1] - begin);
                for index in range {
                    found[index] =
                        if time[index] <= early { Region::EarlyHold } else { Region::LateHold };
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_passes_every_region_in_order() {
        let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        let place = |t: f64| match t {
            t if t < 1.0 => -0.5,
            t if t < 2.0 => -0.5 + 4.5 * (t - 1.0),
            t if t < 6.0 => 4.0,
            t if t < 7.0 => 4.0 - 4.5 * (t - 6.0),
            _ => -0.5,
        };
        let displacement: Vec<f64> = time.iter().map(|&t| place(t)).collect();
        let mut seen = regions(&time, &displacement);
        let early = seen.iter().filter(|r| **r == Region::EarlyHold).count();
        let late = seen.iter().filter(|r| **r == Region::LateHold).count();
        assert!((early as f64 / (early + late) as f64 - EARLY).abs() < 0.01);
        seen.dedup();
        assert_eq!(seen, Region::ALL);
    }
}
