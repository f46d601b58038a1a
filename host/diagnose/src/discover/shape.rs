//! The shapes in which a term may depend on its quantity.

use std::f64::consts::{PI, TAU};

use super::reach::{Kind, Quantity, Reach};

/// How a term depends on its quantity.
#[derive(Debug)]
pub struct Shape {
    /// What it is, in words that the quantity follows.
    pub name: &'static str,
    pub(super) family: Family,
    /// What such a term does; names in braces stand for its parameters, `{c}` for the quantity.
    pub words: &'static str,
    /// Its value as an expression; `{c}` stands for the quantity.
    pub(super) text: &'static str,
    /// The same at one value of the quantity, with the values of its parameters; none for what depends on what was before.
    pub(super) value: Option<fn(f64, &[f64]) -> f64>,
    /// The power of the quantity's unit that its value has.
    pub(super) power: i32,
    /// Its parameters.
    pub(super) parameters: &'static [ShapeParameter],
    /// Largest size over a range, for parameters of that size.
    pub(super) size: fn(&Reach) -> f64,
    /// Whether it is tried of quantities that change from trace to trace rather than within one.
    slow: bool,
}

/// Shapes that suit the same quantities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Linear in the quantity.
    Straight,
    /// Bent alike over the whole range.
    Curve,
    /// Away from 0.
    Decay,
    /// The same from the touch on, with nothing off the specimen.
    ContactDecay,
    /// With a place in the range.
    Local,
    /// With one place on the way up and another on the way down.
    Switch,
    /// With a period in the range.
    Wave,
    /// The same with a jump in each period.
    Sawtooth,
    /// A wave that dies away.
    DyingWave,
    /// Of what was before.
    Memory,
    /// Of the square of what was before.
    SquareMemory,
    /// Of what wears something down that recovers.
    Wearing,
    /// A curve of any shape.
    Free,
}

/// A parameter of a shape.
#[derive(Debug)]
pub(super) struct ShapeParameter {
    pub name: &'static str,
    pub unit: Unit,
    /// Where it is started.
    pub grid: fn(&Reach) -> Vec<f64>,
    pub bounds: fn(&Reach) -> (f64, f64),
}

/// Unit of a parameter of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// That of the quantity.
    Quantity,
    /// A pure number.
    Number,
    /// s.
    Seconds,
}

const PLACE: ShapeParameter = ShapeParameter {
    name: "place",
    unit: Unit::Quantity,
    grid: |reach| reach.places.clone(),
    bounds: |reach| (reach.least, reach.most),
};

const WIDTH: ShapeParameter = ShapeParameter {
    name: "width",
    unit: Unit::Quantity,
    grid: |reach| vec![0.04 * reach.span(), 0.15 * reach.span()],
    bounds: |reach| (0.002 * reach.span(), 2.0 * reach.span()),
};

/// That of a step, which may be a jump.
const EDGE: ShapeParameter = ShapeParameter {
    grid: |reach| vec![0.02 * reach.span()],
    bounds: |reach| (1e-5 * reach.span(), 2.0 * reach.span()),
    ..WIDTH
};

const SCALE: ShapeParameter = ShapeParameter {
    name: "scale",
    unit: Unit::Quantity,
    grid: |reach| [0.02, 0.08, 0.3].map(|part| part * reach.span()).to_vec(),
    bounds: |reach| (0.001 * reach.span(), 20.0 * reach.span()),
};

const PERIOD: ShapeParameter = ShapeParameter {
    name: "period",
    unit: Unit::Quantity,
    grid: |reach| reach.periods.clone(),
    bounds: |reach| {
        let shortest = reach.periods.iter().fold(reach.span(), |least, period| least.min(*period));
        ((0.5 * shortest).min(0.01 * reach.span()), 2.0 * reach.span())
    },
};

const PHASE: ShapeParameter = ShapeParameter {
    name: "phase",
    unit: Unit::Number,
    grid: |_| vec![0.0, 0.5 * PI],
    bounds: |_| (-7.0, 7.0),
};

const SHARPNESS: ShapeParameter = ShapeParameter {
    name: "sharpness",
    unit: Unit::Number,
    grid: |_| vec![0.95],
    bounds: |_| (0.2, 0.999),
};

const DELAY: ShapeParameter = ShapeParameter {
    name: "time",
    unit: Unit::Seconds,
    grid: |reach| reach.times.to_vec(),
    bounds: |reach| (0.2 * reach.times[0], 20.0 * reach.times[3]),
};

const LEVEL: ShapeParameter = ShapeParameter {
    name: "level",
    unit: Unit::Quantity,
    grid: |reach| [0.1, 0.5].map(|part| part * reach.size()).to_vec(),
    bounds: |reach| (1e-3 * reach.size(), 50.0 * reach.size()),
};

const ORDER: ShapeParameter = ShapeParameter {
    name: "order",
    unit: Unit::Number,
    grid: |_| vec![1.3],
    bounds: |_| (0.3, 4.0),
};

const GAP: ShapeParameter = ShapeParameter {
    name: "gap",
    unit: Unit::Quantity,
    grid: |reach| [0.05, 0.1, 0.17, 0.26].map(|part| part * reach.span()).to_vec(),
    bounds: |reach| (0.0, 0.5 * reach.span()),
};

/// Part of its range from which on a displacement below 0 is off the specimen.
const OFF: f64 = 0.02;

const ONE: fn(&Reach) -> f64 = |_| 1.0;

/// Every shape but free curves.
pub const SHAPES: [Shape; 15] = [
    Shape {
        name: "proportional to",
        family: Family::Straight,
        words: "grows by {size} with the {c}",
        text: "{c}",
        value: Some(|c, _| c),
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
        value: Some(|c, _| c * c),
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
        value: Some(|c, at| (c / at[0]).tanh()),
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
        value: Some(|c, at| (-c / at[0]).exp()),
        power: 0,
        parameters: &[SCALE],
        size: ONE,
        slow: true,
    },
    Shape {
        name: "decaying in contact with",
        family: Family::ContactDecay,
        words: "is {size} at the touch and fades over {scale} of the {c}",
        text: "sign(max(0, {c})) * exp(-max(0, {c}) / scale)",
        value: Some(|c, at| if c > 0.0 { (-c / at[0]).exp() } else { 0.0 }),
        power: 0,
        parameters: &[SCALE],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "bump at one",
        family: Family::Local,
        words: "is a bump of {size} where the {c} is {place}, {width} wide",
        text: "exp(-(({c} - place) / width)^2)",
        value: Some(|c, at| (-((c - at[0]) / at[1]).powi(2)).exp()),
        power: 0,
        parameters: &[PLACE, WIDTH],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "periodic in",
        family: Family::Wave,
        words: "repeats every {period} of the {c}, {size} high",
        text: "sin(2 * PI * {c} / period + phase)",
        value: Some(|c, at| (TAU * c / at[0] + at[1]).sin()),
        power: 0,
        parameters: &[PERIOD, PHASE],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "dying wave over",
        family: Family::DyingWave,
        words: "repeats every {period} of the {c}, {size} high at first, and dies away over {scale} of it",
        text: "exp(-{c} / scale) * sin(2 * PI * {c} / period + phase)",
        value: Some(|c, at| (-c / at[2]).exp() * (TAU * c / at[0] + at[1]).sin()),
        power: 0,
        parameters: &[
            PERIOD,
            PHASE,
            ShapeParameter { grid: |reach| vec![0.15 * reach.span()], ..SCALE },
        ],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "sawtooth in",
        family: Family::Sawtooth,
        words: "rises and falls back every {period} of the {c}, {size} high",
        // The sum of sharpness^k sin(k w)/k: a sawtooth whose corners are a little rounded, so that a fit can move them.
        text: "atan(sharpness * sin(2 * PI * {c} / period + phase) / (1 - sharpness * cos(2 * PI * {c} / period + phase))) * 2 / PI",
        value: Some(|c, at| {
            let (sine, cosine) = (TAU * c / at[0] + at[1]).sin_cos();
            2.0 / PI * (at[2] * sine / (1.0 - at[2] * cosine)).atan()
        }),
        power: 0,
        parameters: &[PERIOD, PHASE, SHARPNESS],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "step at one",
        family: Family::Local,
        words: "is a step of {size} where the {c} passes {place}",
        text: "0.5 * (1 + tanh(({c} - place) / width))",
        value: Some(|c, at| 0.5 * (1.0 + ((c - at[0]) / at[1]).tanh())),
        power: 0,
        parameters: &[PLACE, EDGE],
        size: ONE,
        slow: true,
    },
    Shape {
        name: "switched at one",
        family: Family::Switch,
        words: "is {size} from where the {c} rises past {place} + {gap} to where it falls past {place} - {gap}",
        text: "0.5 * (1 + tanh((play({c}, gap) - place) / width))",
        value: None,
        power: 0,
        parameters: &[
            PLACE,
            ShapeParameter { grid: |reach| vec![0.05 * reach.span()], ..EDGE },
            GAP,
        ],
        size: ONE,
        slow: false,
    },
    Shape {
        name: "from one on proportional to",
        family: Family::Local,
        words: "begins where the {c} passes {place} and grows by {size}",
        text: "max(0, {c} - place)",
        value: Some(|c, at| (c - at[0]).max(0.0)),
        power: 1,
        parameters: &[PLACE],
        size: |reach| 0.5 * reach.span(),
        slow: false,
    },
    Shape {
        name: "behind",
        family: Family::Memory,
        words: "follows the {c} with a delay of {time}, by {size}",
        text: "lag({c}, time)",
        value: None,
        power: 1,
        parameters: &[DELAY],
        size: |reach| reach.size(),
        slow: false,
    },
    Shape {
        name: "behind the square of",
        family: Family::SquareMemory,
        words: "follows the square of the {c} with a delay of {time}, by {size}",
        text: "lag({c}^2, time)",
        value: None,
        power: 2,
        parameters: &[DELAY],
        size: |reach| reach.size().powi(2),
        slow: false,
    },
    Shape {
        name: "worn by",
        family: Family::Wearing,
        words: "wears off with the {c}, half of it at {level} in the long run, recovers within {time}, and is {size} where all is worn off",
        // dy/dt = (u (1 - y) - y)/time, u = (c/level)^order.
        text: "lag((max(0, {c}) / level)^order / (1 + (max(0, {c}) / level)^order), time / (1 + (max(0, {c}) / level)^order))",
        value: None,
        power: 0,
        parameters: &[LEVEL, ORDER, DELAY],
        size: ONE,
        slow: false,
    },
];

/// A curve of any shape.
pub(super) static CURVE: Shape = Shape {
    name: "curve over",
    family: Family::Free,
    words: "follows a free curve over the {c}, up to {size}",
    text: "",
    value: None,
    power: 0,
    parameters: &[],
    size: ONE,
    slow: true,
};

impl Shape {
    /// Whether it is a curve of any shape.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.family == Family::Free
    }

    /// Whether it is tried with a factor: a switch depends by itself on the way in which its quantity changes, and what is there only while
    /// the tip moves, whichever way, is a vibration.
    pub(super) fn goes_with(&self, factor: &Factor) -> bool {
        match self.family {
            Family::Switch => *factor == ALWAYS,
            Family::Wave => true,
            _ => *factor != MOVING,
        }
    }

    /// Whether a quantity can be tried in it.
    pub(super) fn suits(&self, quantity: &Quantity, reach: &Reach) -> bool {
        use Family::{
            ContactDecay, Curve, Decay, DyingWave, Memory, SquareMemory, Straight, Switch, Wearing,
        };
        let leaves = quantity.symbol == "x" && reach.least < -OFF * reach.span();
        let fits = match self.family {
            ContactDecay => leaves,
            // An exponential of what goes far below 0 is no decay.
            Decay => !leaves && reach.least >= -0.1 * reach.span(),
            DyingWave => reach.least >= -0.1 * reach.span(),
            Wearing => quantity.kind == Kind::Fast || reach.least >= 0.0,
            _ => true,
        };
        if !fits {
            return false;
        }
        match quantity.kind {
            Kind::Fast => self.family != DyingWave,
            Kind::Clock => !matches!(self.family, Memory | SquareMemory | Wearing | Switch),
            // A wave is tried only where one was seen.
            Kind::Slow => self.slow || self.family == Family::Wave && !reach.periods.is_empty(),
            Kind::Rate => matches!(self.family, Straight | Curve | Decay | Memory | Wearing),
            Kind::Plain => matches!(self.family, Straight | Memory | Wearing),
        }
    }
}

/// What a term is multiplied by.
#[derive(Debug, PartialEq, Eq)]
pub struct Factor {
    /// What follows the name of the shape and its quantity.
    pub name: &'static str,
    /// What follows the words of the shape.
    pub words: &'static str,
    /// As an expression that ends before what it is multiplied by.
    pub(super) text: &'static str,
    /// The power of a velocity that its unit is.
    pub(super) speeds: i32,
}

/// Nothing more.
pub const ALWAYS: Factor = Factor { name: "", words: "", text: "", speeds: 0 };
/// Only while the tip goes in.
pub const PRESSING: Factor = Factor {
    name: " while pressing",
    words: ", and only while pressing",
    text: "0.5 * (1 + sign(v)) * ",
    speeds: 0,
};
/// Only while the tip goes out.
pub const LEAVING: Factor = Factor {
    name: " while leaving",
    words: ", and only while leaving",
    text: "max(0, -sign(v)) * ",
    speeds: 0,
};
/// Only while the tip moves.
pub const MOVING: Factor = Factor {
    name: " while moving",
    words: ", and only while the tip moves",
    text: "abs(sign(v)) * ",
    speeds: 0,
};
/// With the sign of the motion.
pub const TURNING: Factor = Factor {
    name: " with the direction",
    words: ", and turns over with the direction of the motion",
    text: "sign(v) * ",
    speeds: 0,
};
/// Times the velocity.
pub const VELOCITY: Factor = Factor {
    name: " times velocity",
    words: ", for each unit of velocity",
    text: "v * ",
    speeds: 1,
};
/// Times the speed.
pub const SPEED: Factor = Factor {
    name: " times speed",
    words: ", for each unit of speed either way",
    text: "abs(v) * ",
    speeds: 1,
};
/// Times the velocity and the speed: the drag of a fluid in turbulence.
pub const DRAG: Factor = Factor {
    name: " times velocity and speed",
    words: ", for each unit of speed squared, and turns over with the direction of the motion",
    text: "v * abs(v) * ",
    speeds: 2,
};
