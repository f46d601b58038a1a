//! Laws of the user's own: an expression over what is known at every sample.

use exmex::{Express, FlatEx};

use super::{Hereditary, Scene};

/// What an expression may speak of, with its meaning.
pub const VARIABLES: [(&str, &str); 10] = [
    ("t", "time since the trace began, s"),
    ("t_set", "time since the data set began, s"),
    ("x", "compression, mm"),
    ("v", "velocity, mm/s"),
    ("a", "acceleration, mm/s²"),
    ("T", "temperature above the reference, K"),
    ("n", "loadings completed before this one"),
    ("x_max", "largest compression so far, mm"),
    ("N", "elastic response, N; at the stage of elasticity"),
    ("F", "force, N; at the stages of contact and sensor"),
];

/// Longest expression, characters.
pub const MAX_LAW_CHARS: usize = 2000;

/// An expression with its parameters, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    compiled: FlatEx<f64>,
    /// Where each variable of the compiled expression, in its order, comes from.
    slots: Vec<Slot>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    Variable(usize),
    Parameter(usize),
}

/// What is wrong with an expression, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}\n  {text}\n  {}{}", " ".repeat(*.at), "^".repeat((*.length).max(1)))]
pub struct ExpressionError {
    /// The expression.
    pub text: String,
    /// Where the fault begins, in characters from 0.
    pub at: usize,
    /// How many characters it has.
    pub length: usize,
    /// What is wrong.
    pub message: String,
}

/// What is known at one sample.
struct Sample<'a> {
    scene: &'a Scene<'a>,
    k: usize,
    /// Compression, elastic response or force at hand.
    x: f64,
    elastic: f64,
    force: f64,
}

impl Sample<'_> {
    fn value(&self, variable: usize) -> f64 {
        let (scene, k) = (self.scene, self.k);
        match VARIABLES[variable].0 {
            "t" => scene.since[k],
            "t_set" => scene.set_time(k),
            "x" => self.x,
            "v" => scene.velocity[k],
            "a" => scene.acceleration[k],
            "T" => scene.warmth(k),
            "n" => scene.loadings[k],
            "x_max" => scene.largest[k],
            "N" => self.elastic,
            _ => self.force,
        }
    }
}

impl Expression {
    /// Reads an expression in which `parameters` may occur beside the [`VARIABLES`].
    ///
    /// # Errors
    /// When it does not parse or speaks of something unknown, with the place.
    pub fn parse(text: &str, parameters: &[&str]) -> Result<Self, ExpressionError> {
        let fault = |at: usize, length: usize, message: String| ExpressionError {
            text: text.into(),
            at,
            length,
            message,
        };
        if text.chars().nth(MAX_LAW_CHARS).is_some() {
            let shown: String = text.chars().take(40).collect();
            let message = format!("longer than {MAX_LAW_CHARS} characters");
            return Err(ExpressionError { text: shown + "…", at: 0, length: 40, message });
        }
        let compiled = FlatEx::<f64>::parse(text).map_err(|error| {
            let (at, length) = broken(text);
            fault(at, length, format!("not an expression: {}", error.msg()))
        })?;
        let slot = |name: &String| {
            let known = |(known, _): &(&str, &str)| known == name;
            if let Some(index) = parameters.iter().position(|parameter| parameter == name) {
                Ok(Slot::Parameter(index))
            } else if let Some(index) = VARIABLES.iter().position(known) {
                Ok(Slot::Variable(index))
            } else {
                let names: Vec<&str> =
                    parameters.iter().copied().chain(VARIABLES.map(|(name, _)| name)).collect();
                let message = format!("`{name}` is unknown; known here: {}", names.join(", "));
                Err(fault(place_of(text, name), name.chars().count(), message))
            }
        };
        let slots = compiled.var_names().iter().map(slot).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { text: text.into(), compiled, slots })
    }

    /// The expression as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Adds the expression, mm, to the compression.
    pub fn add(&self, scene: &Scene, parameters: &[f64], x: &mut [f64]) {
        self.over(parameters, x, |k, x| Sample { scene, k, x, elastic: 0.0, force: 0.0 });
    }

    /// Adds the expression, N, to the elastic response.
    pub fn add_to_elastic(
        &self,
        scene: &Scene,
        parameters: &[f64],
        x: &[f64],
        elastic: &mut [f64],
    ) {
        self.over(parameters, elastic, |k, elastic| Sample {
            scene,
            k,
            x: x[k],
            elastic,
            force: 0.0,
        });
    }

    /// Adds the expression, N, to the force; x is the commanded displacement here.
    pub fn add_to_force(&self, scene: &Scene, parameters: &[f64], force: &mut [f64]) {
        let x = &scene.motion.displacement;
        self.over(parameters, force, |k, force| Sample { scene, k, x: x[k], elastic: 0.0, force });
    }

    /// Multiplies the rates of relaxation by one plus the expression, but never by less than 0.
    pub fn change_rates(
        &self,
        scene: &Scene,
        parameters: &[f64],
        x: &[f64],
        relaxation: &mut Hereditary,
    ) {
        let mut factor = relaxation.rate_factor.take().unwrap_or_else(|| vec![1.0; x.len()]);
        let sample = |k, _| Sample { scene, k, x: x[k], elastic: 0.0, force: 0.0 };
        let mut change = vec![0.0; x.len()];
        self.over(parameters, &mut change, sample);
        for (factor, change) in factor.iter_mut().zip(change) {
            *factor *= (1.0 + change).max(0.0);
        }
        relaxation.rate_factor = Some(factor);
    }

    /// Adds the expression to every value; where it has no finite value, nothing is added.
    fn over<'a>(
        &self,
        parameters: &[f64],
        values: &mut [f64],
        sample: impl Fn(usize, f64) -> Sample<'a>,
    ) {
        let mut given = vec![0.0; self.slots.len()];
        for (k, value) in values.iter_mut().enumerate() {
            let at = sample(k, *value);
            for (given, slot) in given.iter_mut().zip(&self.slots) {
                *given = match *slot {
                    Slot::Variable(index) => at.value(index),
                    Slot::Parameter(index) => parameters[index],
                };
            }
            if let Ok(change) = self.compiled.eval(&given)
                && change.is_finite()
            {
                *value += change;
            }
        }
    }
}

/// Where a name stands in an expression by itself, in characters.
fn place_of(text: &str, name: &str) -> usize {
    let part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let alone = |at: &usize| {
        !part(text[..*at].chars().next_back()) && !part(text[at + name.len()..].chars().next())
    };
    let at = text.match_indices(name).map(|(at, _)| at).find(alone).unwrap_or(0);
    text[..at].chars().count()
}

/// Where an expression that does not parse is broken: an unpaired parenthesis, a character that no
/// expression has, two values without an operator between, or its end.
fn broken(text: &str) -> (usize, usize) {
    let mut open = Vec::new();
    for (at, c) in text.chars().enumerate() {
        match c {
            '(' => open.push(at),
            ')' if open.pop().is_none() => return (at, 1),
            c if c.is_alphanumeric() || " _.+-*/^(),<>=!&|%".contains(c) => {}
            _ => return (at, 1),
        }
    }
    if let Some(at) = open.pop() {
        return (at, 1);
    }
    // The shortest beginning that cannot be continued by a value and closing parentheses.
    let characters: Vec<char> = text.chars().collect();
    let continued = |end: usize| {
        let begin: String = characters[..end].iter().collect();
        let depth = begin.matches('(').count().saturating_sub(begin.matches(')').count());
        let close = ")".repeat(depth);
        ["", "1", "+1", "(1)"]
            .iter()
            .any(|next| FlatEx::<f64>::parse(&format!("{begin}{next}{close}")).is_ok())
    };
    match (1..=characters.len()).find(|&end| !continued(end)) {
        Some(end) => (end - 1, 1),
        None => (characters.len(), 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_point_into_the_expression() {
        let at = |text: &str| Expression::parse(text, &["k"]).map(|_| ()).unwrap_err();
        let unknown = at("k * abs(x) * speed");
        assert_eq!((unknown.at, unknown.length), (13, 5));
        assert!(unknown.message.contains("`speed` is unknown"), "{unknown}");
        assert_eq!(at("k * (x + 1").at, 4);
        assert_eq!(at("k * x) + 1").at, 5);
        assert_eq!(at("k * § x").at, 4);
        assert_eq!(at("k * x +").at, 7);
        assert_eq!(at("k * * x").at, 4);
    }
}
