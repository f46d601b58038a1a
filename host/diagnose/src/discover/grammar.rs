//! The grammar of laws: what a term may depend on, how, and where in the chain it acts. Every combination is a law of one's own.

use std::sync::Arc;

use super::curves::{Knots, curve};
use super::place::{PLACES, Place};
use super::reach::{QUANTITIES, Quantity, Reach};
use super::shape::{
    ALWAYS, CURVE, DRAG, Factor, Family, LEAVING, MOVING, PRESSING, SHAPES, Shape, ShapeParameter,
    TURNING, Unit, VELOCITY,
};
use palpate_model::effects::{Candidate, Form};
use palpate_model::{Act, Applied, Expression, Parameter, Stage};

/// A term of the grammar: where it acts, what it depends on, and how.
#[derive(Clone, Debug)]
pub struct Term {
    /// Where in the chain it acts.
    pub stage: Stage,
    /// How it depends on its quantity.
    pub shape: &'static Shape,
    /// What that is multiplied by.
    pub factor: &'static Factor,
    /// The quantity.
    pub quantity: &'static Quantity,
    /// The law with starts, as a search takes it.
    pub candidate: Candidate,
    /// Where a free curve is told its value; none of other shapes.
    pub(super) knots: Option<Knots>,
    /// The quantity with a power of which it changes; none where it does not.
    pub varies: Option<&'static Quantity>,
}

impl Term {
    /// What it is, in words: shape, quantity and factor.
    #[must_use]
    pub fn name(&self) -> String {
        let varies =
            self.varies.map_or_else(String::new, |by| format!(" by a power of {}", by.name));
        format!("{} {}{}{varies}", self.shape.name, self.quantity.name, self.factor.name)
    }

    /// What it does, in words in which names in braces stand for its parameters.
    #[must_use]
    pub fn words(&self) -> String {
        let varies = self.varies.map_or_else(String::new, |by| {
            format!(", and changes with the power {{power}} of the {}", by.name)
        });
        self.shape.words.replace("{c}", self.quantity.name) + self.factor.words + &varies
    }

    /// The name of the term and of its place in the chain.
    pub(super) fn full_name(&self) -> String {
        format!("{} ({})", self.name(), self.stage.name())
    }

    /// Whether another depends on the same quantity at the same stage.
    pub(super) fn acts_like(&self, other: &Self) -> bool {
        self.stage == other.stage && self.quantity == other.quantity
    }

    /// The same, multiplied by the same.
    pub(super) fn beside(&self, other: &Self) -> bool {
        self.acts_like(other) && self.factor == other.factor
    }
}

/// Every term that a data set can show.
#[derive(Debug)]
pub struct Grammar {
    /// The terms; first those that are screened, then those that a free curve may be told by.
    pub terms: Vec<Term>,
    /// How many are screened.
    pub screened: usize,
}

impl Grammar {
    /// `reaches` are those of [`QUANTITIES`], none where a quantity does not vary.
    #[must_use]
    pub fn new(reaches: &[Option<Reach>], signal_unit: &str) -> Self {
        let (mut screened, mut more) = (Vec::new(), Vec::new());
        for place in &PLACES {
            for (quantity, reach) in QUANTITIES.iter().zip(reaches) {
                let Some(reach) = reach.as_ref().filter(|_| place.of.contains(&quantity.symbol))
                else {
                    continue;
                };
                for factor in place.factors(quantity) {
                    let made = Made { place, factor, quantity, reach, signal_unit };
                    let suits = |shape: &&Shape| {
                        shape.suits(quantity, reach)
                            && shape.goes_with(factor)
                            && place.takes(shape)
                    };
                    for shape in SHAPES.iter().filter(suits) {
                        let to = if on_grid(shape, factor) { &mut screened } else { &mut more };
                        to.extend(made.term(shape));
                    }
                    if CURVE.goes_with(factor) && place.takes(&CURVE) {
                        screened.extend(curve(&made));
                    }
                }
            }
        }
        let count = screened.len();
        screened.append(&mut more);
        Self { terms: screened, screened: count }
    }
}

/// Whether a shape with a factor is screened from a grid of starts; else a free curve or a wave leads to it.
fn on_grid(shape: &Shape, factor: &Factor) -> bool {
    use Family::{ContactDecay, Decay, Local, Sawtooth, Straight, Wave};
    let in_a_film = *factor == VELOCITY || *factor == DRAG;
    let one_way = *factor == PRESSING || *factor == LEAVING;
    match shape.family {
        Sawtooth => false,
        _ if *factor == ALWAYS => true,
        Wave if *factor == MOVING => true,
        Straight => *factor == PRESSING,
        ContactDecay if in_a_film => true,
        Decay | ContactDecay => *factor == LEAVING,
        Wave => one_way,
        Local => (one_way || *factor == TURNING) && shape.power == 0,
        _ => false,
    }
}

/// What a term is made of beside its shape.
pub(super) struct Made<'a> {
    pub place: &'a Place,
    pub factor: &'static Factor,
    pub quantity: &'static Quantity,
    pub reach: &'a Reach,
    pub signal_unit: &'a str,
}

impl Made<'_> {
    /// The term of a shape with a strength and the shape's own parameters.
    fn term(&self, shape: &'static Shape) -> Option<Term> {
        let own_unit = self.quantity.unit.unwrap_or(self.signal_unit);
        let strength = self.strength("size", shape);
        let parameter = |parameter: &ShapeParameter| {
            let (lower, upper) = (parameter.bounds)(self.reach);
            let unit = match parameter.unit {
                Unit::Quantity => own_unit,
                Unit::Number => "",
                Unit::Seconds => "s",
            };
            Parameter {
                name: parameter.name.into(),
                unit: unit.to_owned().into(),
                meaning: "".into(),
                lower,
                upper,
                bounded: false,
            }
        };
        let parameters: Vec<Parameter> =
            std::iter::once(strength).chain(shape.parameters.iter().map(parameter)).collect();
        let symbol = match self.quantity.symbol.contains(' ') {
            true => format!("({})", self.quantity.symbol),
            false => self.quantity.symbol.to_owned(),
        };
        let text = format!(
            "size * {}{}{}",
            self.place.factor,
            self.factor.text,
            shape.text.replace("{c}", &symbol)
        );
        let names: Vec<&str> = parameters.iter().map(|parameter| &parameter.name[..]).collect();
        let expression = Expression::parse(&text, &names).ok()?;
        Some(self.of(shape, (parameters, 1), expression, grid(shape, self.reach), None))
    }

    /// A strength of a shape of this name.
    pub fn strength(&self, name: &str, shape: &Shape) -> Parameter {
        let own_unit = self.quantity.unit.unwrap_or(self.signal_unit);
        let unit = per(self.place.unit.unwrap_or(self.signal_unit), own_unit, shape.power);
        let unit = per(&unit, "mm/s", self.factor.speeds);
        let most = (self.place.sizes)(self.reach).1 / self.size(shape);
        Parameter {
            name: name.to_owned().into(),
            unit: unit.into(),
            meaning: "strength".into(),
            lower: -most,
            upper: most,
            bounded: false,
        }
    }

    /// Largest size of what a strength of a shape is multiplied by.
    fn size(&self, shape: &Shape) -> f64 {
        let speeds = self.reach.fastest.powi(self.factor.speeds);
        (speeds * (shape.size)(self.reach)).max(f64::MIN_POSITIVE)
    }

    /// A term with these parameters, the strengths first, and these starts of the others.
    pub fn of(
        &self,
        shape: &'static Shape,
        (parameters, strengths): (Vec<Parameter>, usize),
        expression: Expression,
        grid: Vec<Vec<f64>>,
        knots: Option<Knots>,
    ) -> Term {
        let stage = self.place.stage;
        let mut term = Term {
            stage,
            shape,
            factor: self.factor,
            quantity: self.quantity,
            candidate: Candidate { name: String::new(), forms: Vec::new(), missing: None },
            knots,
            varies: None,
        };
        let name = term.full_name();
        let applied = Applied {
            name: name.clone(),
            law: "own".into(),
            stage,
            strengths,
            each_trace: 0,
            parameters,
            act: Act::Own(Arc::new(expression)),
        };
        let typical = (self.place.sizes)(self.reach).0 / self.size(shape);
        let form = Form { applied, typical, positive: false, grid };
        term.candidate = Candidate { name, forms: vec![form], missing: None };
        term
    }
}

/// Every combination of the starting values of a shape's parameters.
fn grid(shape: &Shape, reach: &Reach) -> Vec<Vec<f64>> {
    shape.parameters.iter().fold(vec![Vec::new()], |points, parameter| {
        let values = (parameter.grid)(reach);
        let longer = |point: &Vec<f64>| {
            let point = point.clone();
            values.clone().into_iter().map(move |value| [&point[..], &[value]].concat())
        };
        points.iter().flat_map(longer).collect()
    })
}

/// The unit of something over a power of another unit.
fn per(unit: &str, other: &str, power: i32) -> String {
    if other.is_empty() || power == 0 {
        return unit.to_owned();
    }
    let other = if other.contains(['/', ' ']) { format!("({other})") } else { other.to_owned() };
    let raised = if power == 2 { format!("{other}²") } else { other };
    format!("{}/{raised}", if unit.is_empty() { "1" } else { unit })
}
