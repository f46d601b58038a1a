//! What a law or an effect declares of each of its parameters.

use std::borrow::Cow;

/// One parameter of a law: its name, unit, meaning and the values that physics allows.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name in model files and tables: `v1`.
    pub name: Cow<'static, str>,
    /// Unit, empty for a pure number.
    pub unit: Cow<'static, str>,
    /// What it means, in a few words.
    pub meaning: Cow<'static, str>,
    /// Smallest value that makes sense.
    pub lower: f64,
    /// Largest value that makes sense; equal to the smallest where the parameter is not fitted.
    pub upper: f64,
    /// Whether physics itself forbids what is beyond these values.
    pub bounded: bool,
}
