//! Where in the chain a term acts, and what it may depend on there.

use super::reach::{Kind, Quantity, Reach};
use super::shape::{
    ALWAYS, DRAG, Factor, Family, LEAVING, MOVING, PRESSING, SPEED, Shape, TURNING, VELOCITY,
};
use palpate_model::Stage;

/// Where a term acts.
#[derive(Debug)]
pub(super) struct Place {
    pub stage: Stage,
    /// What the term is multiplied by.
    pub factor: &'static str,
    /// Unit of what it adds to there, with the factor taken out; none for that of the signal.
    pub unit: Option<&'static str>,
    /// Size of a term that is small but clear, and of one that is the most that makes sense.
    pub sizes: fn(&Reach) -> (f64, f64),
    /// Symbols of the quantities it may depend on.
    pub of: &'static [&'static str],
}

impl Place {
    /// What a term of a quantity may be multiplied by here: what depends on the motion through a place or a force may depend on its
    /// direction and its speed.
    pub fn factors(&self, quantity: &Quantity) -> &'static [&'static Factor] {
        match (quantity.kind, self.stage) {
            (Kind::Fast, Stage::Sensor | Stage::Contact) => {
                &[&ALWAYS, &PRESSING, &LEAVING, &TURNING, &VELOCITY, &SPEED, &DRAG]
            }
            (Kind::Fast, _) => &[&ALWAYS, &PRESSING, &LEAVING, &TURNING],
            (Kind::Rate, _) if quantity.symbol == "v" => &[&ALWAYS, &PRESSING],
            // A drive may vibrate.
            (_, Stage::Sensor) if matches!(quantity.symbol, "t" | "t_set") => &[&ALWAYS, &MOVING],
            _ => &[&ALWAYS],
        }
    }

    /// Whether a shape is tried here: a switch adds to a force, anything else to the elastic response is a part of it.
    pub fn takes(&self, shape: &Shape) -> bool {
        let adds = self.factor.is_empty();
        match self.stage {
            Stage::Sensor => true,
            Stage::Elasticity => adds == (shape.family == Family::Switch),
            _ => shape.family != Family::Switch,
        }
    }
}

/// Every place.
pub(super) const PLACES: [Place; 6] = [
    Place {
        stage: Stage::Sensor,
        factor: "",
        unit: None,
        sizes: |reach| (0.01 * reach.force, 10.0 * reach.force),
        of: &[
            "x",
            "v",
            "F",
            "t",
            "since(x)",
            "since((0.5 - abs(sign(v))) * total(abs(v)))",
            "total(abs(v))",
            "t_set",
            "T",
            "n",
            "x_max",
            "sign(v)",
            "abs(v)",
            "a",
            "F * v",
            "x * v",
            "x * sign(v)",
            "x * T",
            "x * n",
            "x * t_set",
            "v * T",
            "v * n",
        ],
    },
    Place {
        stage: Stage::Contact,
        factor: "F * ",
        unit: Some(""),
        sizes: |_| (0.01, 100.0),
        of: &["x", "v", "t", "since(x)", "t_set", "T", "n", "x_max", "sign(v)", "abs(v)"],
    },
    Place {
        stage: Stage::Elasticity,
        factor: "N * ",
        unit: Some(""),
        sizes: |_| (0.01, 100.0),
        of: &["x", "v", "t", "T", "n", "t_set", "x_max", "abs(v)"],
    },
    Place {
        stage: Stage::Elasticity,
        factor: "",
        unit: None,
        sizes: |reach| (0.01 * reach.force, 10.0 * reach.force),
        of: &["x"],
    },
    Place {
        stage: Stage::Motion,
        factor: "",
        unit: Some("mm"),
        sizes: |reach| (0.002 * reach.compression, reach.compression),
        of: &["x", "v", "t", "T", "n", "t_set", "sign(v)"],
    },
    Place {
        stage: Stage::Relaxation,
        factor: "",
        unit: Some(""),
        sizes: |_| (0.05, 1e3),
        of: &["x", "v", "since(x)", "T", "n", "t_set", "x_max", "sign(v)"],
    },
];
