//! `palpate grasp`: what a contact carries before it slips; one file for each subcommand.

mod friction;
mod growth;
mod margin;
mod plan;
mod surface;
mod watch;

pub use friction::GraspFrictionAnswer;
pub use growth::{GraspGrowthAnswer, GrownAnswer};
pub use margin::{GraspMarginAnswer, MarginHistoryAnswer, SlipAnswer};
pub use plan::{
    BalanceAnswer, BalancedAnswer, FingerAnswer, GraspForecastAnswer, GraspPlanAnswer,
    InstantAnswer, LeastAnswer, UnbalancedAnswer,
};
pub use surface::{
    ContactAnswer, ContactShapeAnswer, GraspLoadAnswer, GraspSurfaceAnswer, SurfacePointAnswer,
};
pub use watch::{GraspHoldAnswer, GraspState, GraspWatchAnswer};
