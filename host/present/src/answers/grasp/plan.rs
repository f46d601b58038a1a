//! `palpate grasp plan`: several fingers on one object.

use palpate_contact::grasp::balance::Share;
use palpate_contact::grasp::{Balance, BalanceError, Hand, Instant, Least};
use serde::Serialize;

use crate::answers::finite;
use crate::summary::{Forecast, HandPlan};

/// How a hand is to grasp an object.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspPlanAnswer {
    /// Version of this answer.
    pub palpate_grasp_plan: u32,
    /// Rank of the grasp matrix, 0 to 6: the number of components of force and moment that the contacts make.
    pub rank: usize,
    /// Largest share of the friction, of a mean normal force of 1 N, that stays unused at every contact while the hand
    /// squeezes without a load.
    pub reserve: f64,
    /// Whether any force and moment can be resisted by gripping hard enough.
    pub force_closed: bool,
    /// Margin asked for: how many times the load must be held.
    pub margin_asked: f64,
    /// What was made least.
    pub least: LeastAnswer,
    /// The least grip with that margin; its value in N.
    #[serde(rename = "least_grip_N")]
    pub least_grip_n: BalanceAnswer,
    /// How many times the load could be as the fingers press now; null where the file states no normal forces.
    pub now: Option<BalanceAnswer>,
    /// How the grip goes on; null where no time was given to look ahead, or where there is no grip.
    pub forecast: Option<GraspForecastAnswer>,
}

/// What is made least.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum LeastAnswer {
    /// The sum of the normal forces.
    Sum,
    /// The largest normal force.
    Largest,
}

/// Forces that balance a load, or why there are none.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum BalanceAnswer {
    /// Forces that balance it.
    Balanced(BalancedAnswer),
    /// There are none.
    Unbalanced(UnbalancedAnswer),
}

/// Forces that balance a load.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct BalancedAnswer {
    /// The normal force that was made least, N, or the factor of the load; null where it is not finite.
    pub value: Option<f64>,
    /// The value cannot be better than this; null where it is not finite.
    pub bound: Option<f64>,
    /// What each finger does.
    pub fingers: Vec<FingerAnswer>,
}

/// No forces balance a load.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct UnbalancedAnswer {
    /// Always null.
    pub value: (),
    /// Why there is no value.
    pub reason: String,
}

/// What one finger does to the object.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FingerAnswer {
    /// Name of the finger.
    pub finger: String,
    /// Normal force, N.
    #[serde(rename = "normal_N")]
    pub normal_n: f64,
    /// Tangential force along x and y of the contact, N.
    #[serde(rename = "tangential_N")]
    pub tangential_n: [f64; 2],
    /// Moment about the normal, N mm.
    #[serde(rename = "moment_Nmm")]
    pub moment_nmm: f64,
    /// Share of what the contact can carry that is in use: it slips at 1; null where the finger does not press.
    pub used: Option<f64>,
}

/// How a grip goes on over time.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspForecastAnswer {
    /// From when it is looked ahead, s since the grasp was made.
    pub from_s: f64,
    /// Until when it is looked ahead, s since the grasp was made.
    pub until_s: f64,
    /// When it slips, s since the grasp was made; null where it does not.
    pub slips_after_s: Option<f64>,
    /// When the margin falls below the one asked for, s since the grasp was made; null where it does not.
    pub below_margin_after_s: Option<f64>,
    /// Factor by which to strengthen the grip now so that it keeps the margin asked for; null where no grip up to a
    /// thousand times as strong does.
    pub tighten_by: Option<f64>,
    /// Grip and margin over time.
    pub course: Vec<InstantAnswer>,
}

/// Grip and margin at one time.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct InstantAnswer {
    /// Time since the grasp was made, s.
    pub time_s: f64,
    /// Normal force of each finger, N.
    #[serde(rename = "normal_N")]
    pub normal_n: Vec<f64>,
    /// The load could be so many times as large; null where it can be as large as one likes.
    pub margin: Option<f64>,
}

impl GraspPlanAnswer {
    /// The plan of a hand.
    #[must_use]
    pub fn of(hand: &Hand, plan: &HandPlan) -> Self {
        Self {
            palpate_grasp_plan: 1,
            rank: plan.closure.rank,
            reserve: plan.closure.reserve,
            force_closed: plan.closure.is_force_closed(),
            margin_asked: plan.margin,
            least: plan.least.into(),
            least_grip_n: BalanceAnswer::of(hand, &plan.grip),
            now: plan.now.as_ref().map(|(found, _)| BalanceAnswer::of(hand, found)),
            forecast: plan.forecast.as_ref().map(GraspForecastAnswer::from),
        }
    }
}

impl From<Least> for LeastAnswer {
    fn from(least: Least) -> Self {
        match least {
            Least::Sum => Self::Sum,
            Least::Largest => Self::Largest,
        }
    }
}

impl BalanceAnswer {
    fn of(hand: &Hand, found: &Result<Balance, BalanceError>) -> Self {
        match found {
            Ok(found) => Self::Balanced(BalancedAnswer::of(hand, found)),
            Err(error) => {
                Self::Unbalanced(UnbalancedAnswer { value: (), reason: error.to_string() })
            }
        }
    }
}

impl BalancedAnswer {
    fn of(hand: &Hand, found: &Balance) -> Self {
        let fingers = hand.fingers.iter().zip(&found.shares);
        Self {
            value: finite(found.value),
            bound: finite(found.bound),
            fingers: fingers.map(|(finger, share)| FingerAnswer::of(&finger.name, share)).collect(),
        }
    }
}

impl FingerAnswer {
    fn of(name: &str, share: &Share) -> Self {
        Self {
            finger: name.to_owned(),
            normal_n: share.normal,
            tangential_n: share.load.force,
            moment_nmm: share.load.moment,
            used: finite(share.used),
        }
    }
}

impl From<&Forecast> for GraspForecastAnswer {
    fn from(forecast: &Forecast) -> Self {
        Self {
            from_s: forecast.from,
            until_s: forecast.until(),
            slips_after_s: forecast.slips,
            below_margin_after_s: forecast.below_margin,
            tighten_by: forecast.tighten,
            course: forecast.course.iter().map(InstantAnswer::from).collect(),
        }
    }
}

impl From<&Instant> for InstantAnswer {
    fn from(instant: &Instant) -> Self {
        Self {
            time_s: instant.time,
            normal_n: instant.normals.clone(),
            margin: finite(instant.margin),
        }
    }
}
