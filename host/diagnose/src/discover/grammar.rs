//! The grammar of laws: what a term may depend on, how, and where in the chain it acts. Every combination is a law of one's own.

use std::sync::Arc;

use super::curves::{Knots, curves};
use super::reach::{Kind, QUANTITIES, Quantity, Reach};
use palpate_model::effects::{Candidate, Form};
use palpate_model::{Act, Applied, Expression, Parameter, Stage};

/// How a term depends on its quantity.
#[derive(Debug)]
pub struct Shape {
    /// What it is, in words that the quantity follows.
    pub name: &'static str,
    family: Family,
    /// What such a term does; names in braces stand for its parameters, `{c}` for the quantity.
    pub words: &'static str,
    /// Its value as an expression; `{c}` stands for the quantity. Of a free curve what it is multiplied by.
    pub(super) text: &'static str,
    /// The power of the quantity's unit that its value has.
    power: i32,
    /// Its parameters.
    parameters: &'static [ShapeParameter],
    /// Largest size over a range, for parameters of that size.
    size: fn(&Reach) -> f64,
    /// Whether it is tried of quantities that change from trace to trace rather than within one.
    slow: bool,
}

/// Shapes that suit the same quantities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    /// Linear in the quantity.
    Straight,
    /// Bent alike over the whole range.
    Curve,
    /// Away from 0.
    Decay,
    /// With a place or a period in the range.
    Local,
    /// Of what was before.
    Memory,
    /// A curve of any shape.
    Free,
}

/// A parameter of a shape.
#[derive(Debug)]
struct ShapeParameter {
    name: &'static str,
    unit: Unit,
    grid: fn(&Reach) -> Vec<f64>,
    bounds: fn(&Reach) -> (f64, f64),
}

/// Unit of a parameter of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    /// That of the quantity.
    Quantity,
    /// A pure number.
    Number,
    /// s.
    Seconds,
}

/// Where a term acts.
#[derive(Debug)]
pub(super) struct Place {
    pub(super) stage: Stage,
    /// What the term is multiplied by.
    pub(super) factor: &'static str,
    /// Unit of what it adds to there, with the factor taken out; none for that of the signal.
    pub(super) unit: Option<&'static str>,
    /// Size of a term that is small but clear, and of one that is the most that makes sense.
    pub(super) sizes: fn(&Reach) -> (f64, f64),
    /// Symbols of the quantities it may depend on.
    of: &'static [&'static str],
}

const PLACE: ShapeParameter = ShapeParameter {
    name: "place",
    unit: Unit::Quantity,
    grid: |reach| reach.at(&[0.1, 0.25, 0.4, 0.55, 0.7, 0.85]),
    bounds: |reach| (reach.least, reach.most),
};

const WIDTH: ShapeParameter = ShapeParameter {
    name: "width",
    unit: Unit::Quantity,
    grid: |reach| vec![0.04 * reach.span(), 0.15 * reach.span()],
    bounds: |reach| (0.002 * reach.span(), 2.0 * reach.span()),
};

const SCALE: ShapeParameter = ShapeParameter {
    name: "scale",
    unit: Unit::Quantity,
    grid: |reach| [0.02, 0.08, 0.3].map(|part| part * reach.span()).to_vec(),
    bounds: |reach| (0.001 * reach.span(), 20.0 * reach.span()),
};

const ONE: fn(&Reach) -> f64 = |_| 1.0;

/// Every shape.
pub const SHAPES: [Shape; 12] = [
    Shape {
        name: "proportional to",
        family: Family::Straight,
        words: "grows by {size} with the {c}",
        text: "{c}",
        power: 1,
        parameters: &[],
        size: |reach| reach.size(),
        slow: true,
    },
    Shape {
        name: "square of",
        family: Family::Curve,
        words: "grows with the square of the {c}, by {size}",
        text: "{c}^2",
        power: 2,
        parameters: &[],
        size: |reach| reach.size().powi(2),
        slow: true,
    },
    Shape {
        name: "saturating with",
        family: Family::Curve,
        words: "grows with the {c} and levels off at {size} beyond {scale}",
        text: "tanh({c} / scale)",
        power: 0,
        parameters: &[SCALE],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "decaying with",
        family: Family::Decay,
        words: "is {size} where the {c} is 0 and fades over {scale} of it",
        text: "exp(-{c} / scale)",
        power: 0,
        parameters: &[SCALE],
        size: ONE,
        slow: true,
    },
    Shape {
        name: "bump at one",
        family: Family::Local,
        words: "is a bump of {size} where the {c} is {place}, {width} wide",
        text: "exp(-(({c} - place) / width)^2)",
        power: 0,
        parameters: &[PLACE, WIDTH],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "bump while pressing at one",
        family: Family::Local,
        words: "is a bump of {size} where the {c} is {place}, {width} wide, while pressing",
        text: "0.5 * (1 + sign(v)) * exp(-(({c} - place) / width)^2)",
        power: 0,
        parameters: &[PLACE, WIDTH],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "bump against the motion at one",
        family: Family::Local,
        words: "is against the motion, {size} where the {c} is {place}, {width} wide",
        text: "sign(v) * exp(-(({c} - place) / width)^2)",
        power: 0,
        parameters: &[PLACE, WIDTH],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "periodic in",
        family: Family::Local,
        words: "repeats every {period} of the {c}, {size} high",
        text: "sin(2 * PI * {c} / period + phase)",
        power: 0,
        parameters: &[
            ShapeParameter {
                name: "period",
                unit: Unit::Quantity,
                grid: |reach| reach.periods.clone(),
                bounds: |reach| (0.01 * reach.span(), 2.0 * reach.span()),
            },
            ShapeParameter {
                name: "phase",
                unit: Unit::Number,
                grid: |_| vec![0.0, 0.5 * std::f64::consts::PI],
                bounds: |_| (-7.0, 7.0),
            },
        ],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "step at one",
        family: Family::Local,
        words: "is a step of {size} where the {c} passes {place}",
        text: "0.5 * (1 + tanh(({c} - place) / width))",
        power: 0,
        parameters: &[PLACE, ShapeParameter { grid: |reach| vec![0.02 * reach.span()], ..WIDTH }],
        size: ONE,
        slow: true,
    },
    Shape {
        name: "from one on proportional to",
        family: Family::Local,
        words: "begins where the {c} passes {place} and grows by {size}",
        text: "max(0, {c} - place)",
        power: 1,
        parameters: &[PLACE],
        size: |reach| 0.5 * reach.span(),
        slow: false,
    },
    Shape {
        name: "while pressing proportional to",
        family: Family::Straight,
        words: "grows by {size} with the {c}, and only while pressing",
        text: "0.5 * (1 + sign(v)) * {c}",
        power: 1,
        parameters: &[],
        size: |reach| reach.size(),
        slow: false,
    },
    Shape {
        name: "behind",
        family: Family::Memory,
        words: "follows the {c} with a delay of {time}, by {size}",
        text: "lag({c}, time)",
        power: 1,
        parameters: &[ShapeParameter {
            name: "time",
            unit: Unit::Seconds,
            grid: |reach| reach.times.to_vec(),
            bounds: |reach| (0.2 * reach.times[0], 20.0 * reach.times[3]),
        }],
        size: |reach| reach.size(),
        slow: false,
    },
];

/// Every place.
const PLACES: [Place; 5] = [
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
            "total(abs(v))",
            "t_set",
            "T",
            "n",
            "x_max",
            "sign(v)",
            "abs(v)",
            "a",
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
        of: &["x", "v", "t", "since(x)", "t_set", "T", "n", "x_max", "sign(v)"],
    },
    Place {
        stage: Stage::Elasticity,
        factor: "N * ",
        unit: Some(""),
        sizes: |_| (0.01, 100.0),
        of: &["x", "v", "t", "T", "n", "t_set", "x_max"],
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

impl Shape {
    /// A curve of any shape, multiplied by a factor.
    pub(super) const fn free(
        name: &'static str,
        words: &'static str,
        factor: &'static str,
    ) -> Self {
        Self {
            name,
            family: Family::Free,
            words,
            text: factor,
            power: 0,
            parameters: &[],
            size: |_| 1.0,
            slow: true,
        }
    }

    /// Whether it is a curve of any shape.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.family == Family::Free
    }
}

/// A term of the grammar: where it acts, what it depends on, and how.
#[derive(Clone, Debug)]
pub struct Term {
    /// Where in the chain it acts.
    pub stage: Stage,
    /// How it depends on its quantity.
    pub shape: &'static Shape,
    /// The quantity.
    pub quantity: &'static Quantity,
    /// The law with starts, as a search takes it.
    pub candidate: Candidate,
    /// Where a free curve is told its value; none of other shapes.
    pub(super) knots: Option<Knots>,
}

/// Every term that a data set can show; `reaches` are those of [`QUANTITIES`], none where a quantity does not vary.
#[must_use]
pub fn terms(reaches: &[Option<Reach>], signal_unit: &str) -> Vec<Term> {
    let mut found = Vec::new();
    for place in &PLACES {
        for (quantity, reach) in QUANTITIES.iter().zip(reaches) {
            let Some(reach) = reach.as_ref().filter(|_| place.of.contains(&quantity.symbol)) else {
                continue;
            };
            let shapes = SHAPES.iter().filter(|shape| suits(shape, quantity, reach));
            found.extend(
                shapes.filter_map(|shape| term(place, shape, quantity, reach, signal_unit)),
            );
            found.extend(curves(place, quantity, reach, signal_unit));
        }
    }
    found
}

/// Whether a quantity is tried in a shape.
fn suits(shape: &Shape, quantity: &Quantity, reach: &Reach) -> bool {
    // An exponential of what goes far below 0 is no decay.
    if shape.family == Family::Decay && reach.least < -0.1 * reach.span() {
        return false;
    }
    match quantity.kind {
        Kind::Fast => true,
        Kind::Clock => shape.family != Family::Memory,
        Kind::Slow => shape.slow,
        Kind::Rate => shape.family != Family::Local,
        Kind::Plain => matches!(shape.family, Family::Straight | Family::Memory),
    }
}

fn term(
    place: &Place,
    shape: &'static Shape,
    quantity: &'static Quantity,
    reach: &Reach,
    signal_unit: &str,
) -> Option<Term> {
    let own_unit = quantity.unit.unwrap_or(signal_unit);
    let (typical, most) = (place.sizes)(reach);
    let size = (shape.size)(reach).max(f64::MIN_POSITIVE);
    let strength = Parameter {
        name: "size".into(),
        unit: per(place.unit.unwrap_or(signal_unit), own_unit, shape.power).into(),
        meaning: "strength".into(),
        lower: -most / size,
        upper: most / size,
        bounded: false,
    };
    let parameter = |parameter: &ShapeParameter| {
        let (lower, upper) = (parameter.bounds)(reach);
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
    let symbol = match quantity.symbol.contains(' ') {
        true => format!("({})", quantity.symbol),
        false => quantity.symbol.to_owned(),
    };
    let text = format!("size * {}{}", place.factor, shape.text.replace("{c}", &symbol));
    let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_ref()).collect();
    let expression = Expression::parse(&text, &names).ok()?;
    let name = format!("{} {} ({})", shape.name, quantity.name, place.stage.name());
    let applied = Applied {
        name: name.clone(),
        law: "own".into(),
        stage: place.stage,
        strengths: 1,
        each_trace: 0,
        parameters,
        act: Act::Own(Arc::new(expression)),
    };
    let form = Form { applied, typical: typical / size, positive: false, grid: grid(shape, reach) };
    let candidate = Candidate { name, forms: vec![form], missing: None };
    Some(Term { stage: place.stage, shape, quantity, candidate, knots: None })
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
pub(super) fn per(unit: &str, other: &str, power: i32) -> String {
    if other.is_empty() || power == 0 {
        return unit.to_owned();
    }
    let other = if other.contains(['/', ' ']) { format!("({other})") } else { other.to_owned() };
    let raised = if power == 2 { format!("{other}²") } else { other };
    format!("{}/{raised}", if unit.is_empty() { "1" } else { unit })
}
