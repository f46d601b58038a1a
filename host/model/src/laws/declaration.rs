//! What a base law declares.

use std::fmt;

use crate::base_law::{BaseLaw, Constants};
use crate::coordinate::Coordinate;
use crate::response::Form;
use crate::{MAX_TERMS, Parameter};

/// A family of base laws: what stands the same whatever its options.
///
/// It is a `static`; everything that the program knows of a law stands here. Two families are the same where their names are.
pub struct Family {
    /// Name in answers, model files and on the command line.
    pub name: &'static str,
    /// What it is, for one who meets it for the first time.
    pub meaning: &'static str,
    /// The law as a formula.
    pub formula: &'static str,
    /// Where it comes from: equations of the dissertation, or a reference.
    pub source: &'static str,
    /// Its springs and dampers in a line or a few, for a font of fixed width.
    pub drawing: &'static str,
    /// What the memory acts on.
    pub form: Form,
    /// Whether the response settles late to its input (creep) instead of relaxing from it.
    pub retarded: bool,
    /// Whether the rate of a branch is the same whatever its state.
    pub linear_memory: bool,
    /// The options that it has.
    pub takes: &'static [LawOption],
    /// What one term is called, and several.
    pub term: [&'static str; 2],
    /// Least exponent q of its power law.
    pub least_q: f64,
    /// Shape of the elastic response where no parameter gives it: 0 for a force in proportion to the compression.
    pub shape: f64,
    /// Its parameters with these options, in the order of model files.
    pub parameters: fn(&BaseLaw) -> Vec<LawParameter>,
    /// The constants that all laws share, from at least as many values as it has parameters.
    pub constants: fn(&BaseLaw, &[f64]) -> Constants,
    /// Its parameters from those constants.
    pub values: fn(&BaseLaw, &Constants) -> Vec<f64>,
    /// Where a fit starts, the best first.
    pub starts: fn(&BaseLaw, &Beginning) -> Vec<Constants>,
}

/// An option that a family may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawOption {
    /// A number of exponentials or branches.
    Terms,
    /// Another elastic response than the power law, whose shape is a parameter; without it the shape is given.
    Elastic,
    /// Another relaxation than exponentials.
    Relaxation,
    /// A number of segments in place of the share c0.
    Segments,
    /// A given exponent n.
    Exponent,
    /// A specimen that cannot leave: the law is stated for tension too.
    Bonded,
}

/// One parameter of a base law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawParameter {
    /// Name in model files and tables: `v1`.
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// What it means, in a few words.
    pub meaning: &'static str,
    /// Smallest and largest value that makes sense.
    pub range: (f64, f64),
    /// The coordinate that stands for it in a search: each has one of its own.
    pub coordinate: Coordinate,
    /// Whether it lies on a bound where the coordinate does; a stiffness scales all forces and has no bound of its own.
    pub bounded: bool,
}

/// What the search for a law may start from.
#[derive(Clone, Debug)]
pub struct Beginning {
    /// Fung's law (or the kernel asked for) with the forces that fit best, for several shapes, best first.
    pub linear: Vec<Constants>,
    /// Largest compression of the data, mm.
    pub reference: f64,
    /// Largest size of the signal, N.
    pub force: f64,
    /// Largest speed, mm/s.
    pub speed: f64,
}

/// Values above zero.
pub const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);

impl Family {
    /// Whether it has this option.
    #[must_use]
    pub const fn takes(&self, option: LawOption) -> bool {
        let mut rest = self.takes;
        while let [first, others @ ..] = rest {
            if *first as u8 == option as u8 {
                return true;
            }
            rest = others;
        }
        false
    }
}

impl PartialEq for Family {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl LawParameter {
    /// A parameter whose bound is that of its coordinate.
    #[must_use]
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        range: (f64, f64),
        coordinate: Coordinate,
    ) -> Self {
        Self { name, unit, meaning, range, coordinate, bounded: true }
    }

    /// This one, which scales all forces.
    #[must_use]
    pub const fn scaling(self) -> Self {
        Self { bounded: false, ..self }
    }

    /// One of these for each of the first `terms` branches.
    #[must_use]
    pub fn each(
        names: &[&'static str; MAX_TERMS],
        terms: usize,
        of: impl Fn(&'static str, usize) -> Self,
    ) -> Vec<Self> {
        names[..terms].iter().zip(1..).map(|(name, branch)| of(name, branch)).collect()
    }
}

impl From<LawParameter> for Parameter {
    fn from(declared: LawParameter) -> Self {
        let (lower, upper) = declared.range;
        Self {
            name: declared.name.into(),
            unit: declared.unit.into(),
            meaning: declared.meaning.into(),
            lower,
            upper,
            bounded: true,
        }
    }
}

/// One spring and one damper, with the coordinates that stand for them.
pub(super) fn spring_and_damper(spring: Coordinate, damper: Coordinate) -> Vec<LawParameter> {
    let (k, eta) = ("stiffness of the spring", "damping of the damper");
    vec![
        LawParameter::new("k", "N/mm", k, POSITIVE, spring).scaling(),
        LawParameter::new("eta", "N·s/mm", eta, POSITIVE, damper),
    ]
}

/// A divisor that is not zero.
pub(crate) fn divisor(number: f64) -> f64 {
    number.max(f64::MIN_POSITIVE.sqrt())
}
