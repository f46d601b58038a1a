//! What an elastic response declares.

use std::fmt;

use crate::coordinate::Coordinate;
use crate::laws::LawParameter;

/// An elastic response: how the force of a sudden displacement grows with it.
///
/// It is a `static`. Two are the same where their names are.
pub struct ElasticLaw {
    /// Name in answers, model files and on the command line.
    pub name: &'static str,
    /// What it is, for one who meets it for the first time.
    pub meaning: &'static str,
    /// The law as a formula.
    pub formula: &'static str,
    /// What it is a function of.
    pub acts: Acts,
    /// Its parameters in the order of model files, the stiffness first, for a least exponent q and the coordinate of the stiffness.
    pub parameters: fn(f64, Coordinate) -> Vec<LawParameter>,
    /// Stiffness p and shape of these values.
    pub constants: fn(&[f64]) -> (f64, f64),
    /// The values of this stiffness p and shape.
    pub values: fn(f64, f64) -> Vec<f64>,
    /// Bounds of the shape on data that reach so far; none where there is no shape.
    pub bounds: fn(&Reach) -> Option<(f64, f64)>,
    /// Shapes from which a search starts.
    pub starts: fn(&Reach) -> Vec<f64>,
}

/// What an elastic response is a function of.
#[derive(Clone, Copy)]
pub enum Acts {
    /// Force, N, of a unit stiffness with a shape at a displacement, mm.
    OnDisplacement(fn(f64, f64) -> f64),
    /// Force of a unit stiffness, N, of an incompressible solid; the heads say how long the specimen is.
    OnStretch {
        /// With a shape at a stretch λ along the axis, positive in tension.
        pulled: fn(f64, f64) -> f64,
        /// With a shape at a shear strain γ.
        sheared: Shear,
    },
}

/// A law of the stretch in shear.
#[derive(Clone, Copy)]
pub enum Shear {
    /// It has a force of its own.
    Own(fn(f64, f64) -> f64),
    /// It cannot be told from another law there, which is to be taken.
    As(&'static ElasticLaw),
}

/// How far data reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Least exponent q of the power law.
    pub least_q: f64,
    /// Largest displacement, mm.
    pub largest: f64,
    /// Largest deformation J = I1 − 3, above 0.
    pub invariant: f64,
}

impl ElasticLaw {
    /// Force of a unit stiffness with a shape at a shear strain; 0 for a law of the displacement.
    pub(super) fn in_shear(&self, shape: f64, strain: f64) -> f64 {
        match self.acts {
            Acts::OnStretch { sheared: Shear::Own(response), .. } => response(shape, strain),
            _ => 0.0,
        }
    }

    /// The law that has the same force in shear, where there is one.
    #[must_use]
    pub const fn same_in_shear(&self) -> Option<&'static Self> {
        match self.acts {
            Acts::OnStretch { sheared: Shear::As(law), .. } => Some(law),
            _ => None,
        }
    }

    /// Whether it takes the gauge of a specimen.
    #[must_use]
    pub const fn needs_gauge(&self) -> bool {
        matches!(self.acts, Acts::OnStretch { .. })
    }
}

impl PartialEq for ElasticLaw {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for ElasticLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}
