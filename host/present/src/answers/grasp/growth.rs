//! `palpate grasp growth`: a limit surface that grows under creep or shrinks under relaxation.

use palpate_contact::grasp::Grown;
use serde::Serialize;

/// What a held contact carries over time.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspGrowthAnswer {
    /// Version of this answer.
    pub palpate_grasp_growth: u32,
    /// The contact at each time of the hold at which the body touches.
    pub course: Vec<GrownAnswer>,
}

/// What a held contact carries at one time.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GrownAnswer {
    /// Time since the hold began, s.
    pub time_s: f64,
    /// Compression, mm.
    pub compression_mm: f64,
    /// Normal force, N.
    #[serde(rename = "normal_N")]
    pub normal_n: f64,
    /// Area of the contact, mm².
    pub area_mm2: f64,
    /// Largest tangential force, in every direction, N.
    #[serde(rename = "largest_force_N")]
    pub largest_force_n: f64,
    /// Largest moment about the normal, N mm.
    #[serde(rename = "largest_moment_Nmm")]
    pub largest_moment_nmm: f64,
}

impl From<&[Grown]> for GraspGrowthAnswer {
    fn from(grown: &[Grown]) -> Self {
        Self { palpate_grasp_growth: 1, course: grown.iter().map(GrownAnswer::from).collect() }
    }
}

impl From<&Grown> for GrownAnswer {
    fn from(grown: &Grown) -> Self {
        Self {
            time_s: grown.held.time,
            compression_mm: grown.held.compression,
            normal_n: grown.held.normal,
            area_mm2: grown.shape.area(),
            largest_force_n: grown.force,
            largest_moment_nmm: grown.moment,
        }
    }
}
