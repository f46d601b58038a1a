//! Laws of the user's own: an expression over what is known at every sample.

mod evaluation;
mod function;
mod memory;
mod parser;
mod token;

pub use self::memory::low_pass;

use std::ops::Range;

use self::evaluation::{BLOCK, Evaluation, Operand};
use self::parser::Step;
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
    /// In postfix order.
    program: Vec<Step>,
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

/// What an expression is added to, with the compressions x, mm, where it is not they.
#[derive(Clone, Copy)]
enum Target<'a> {
    Compression,
    Elastic(&'a [f64]),
    Rates(&'a [f64]),
    Force(&'a [f64]),
}

impl Target<'_> {
    /// A variable at the samples of a block, of whose values at hand these are known; written into an empty column.
    fn variable(
        self,
        index: usize,
        scene: &Scene,
        samples: Range<usize>,
        values: &[f64],
        mut column: Vec<f64>,
    ) -> Operand {
        match (VARIABLES[index].0, self) {
            ("t", _) => column.extend(&scene.since[samples]),
            ("t_set", _) => column.extend(samples.map(|k| scene.set_time(k))),
            ("v", _) => column.extend(&scene.velocity[samples]),
            ("a", _) => column.extend(&scene.acceleration[samples]),
            ("T", _) => column.extend(samples.map(|k| scene.warmth(k))),
            ("n", _) => column.extend(&scene.loadings[samples]),
            ("x_max", _) => column.extend(&scene.largest[samples]),
            ("x", Self::Elastic(x) | Self::Rates(x) | Self::Force(x)) => {
                column.extend(&x[samples]);
            }
            ("x", Self::Compression) | ("N", Self::Elastic(_)) | ("F", Self::Force(_)) => {
                column.extend(values);
            }
            _ => return Operand::Same(0.0),
        }
        Operand::Each(column)
    }
}

impl Expression {
    /// Reads an expression in which `parameters` may occur beside the [`VARIABLES`].
    ///
    /// # Errors
    /// When it does not parse or speaks of something unknown, with the place.
    pub fn parse(text: &str, parameters: &[&str]) -> Result<Self, ExpressionError> {
        if text.chars().nth(MAX_LAW_CHARS).is_some() {
            let shown: String = text.chars().take(40).collect();
            let message = format!("longer than {MAX_LAW_CHARS} characters");
            return Err(ExpressionError { text: shown + "…", at: 0, length: 40, message });
        }
        let program = parser::parse(text, parameters).map_err(|fault| ExpressionError {
            text: text.into(),
            at: fault.at,
            length: fault.length,
            message: fault.message,
        })?;
        Ok(Self { text: text.into(), program })
    }

    /// Whether its value depends on the force.
    #[must_use]
    pub fn follows_force(&self) -> bool {
        self.program.iter().any(|step| matches!(step, Step::Variable(k) if VARIABLES[*k].0 == "F"))
    }

    /// The expression as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Adds the expression, mm, to the compression.
    pub fn add(&self, scene: &Scene, parameters: &[f64], x: &mut [f64]) {
        self.over(scene, parameters, Target::Compression, x);
    }

    /// Adds the expression, N, to the elastic response.
    pub fn add_to_elastic(
        &self,
        scene: &Scene,
        parameters: &[f64],
        x: &[f64],
        elastic: &mut [f64],
    ) {
        self.over(scene, parameters, Target::Elastic(x), elastic);
    }

    /// Adds the expression, N, to the force; x is the commanded displacement here.
    pub fn add_to_force(&self, scene: &Scene, parameters: &[f64], force: &mut [f64]) {
        self.over(scene, parameters, Target::Force(&scene.motion.displacement), force);
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
        let mut change = vec![0.0; x.len()];
        self.over(scene, parameters, Target::Rates(x), &mut change);
        for (factor, change) in factor.iter_mut().zip(change) {
            *factor *= (1.0 + change).max(0.0);
        }
        relaxation.rate_factor = Some(factor);
    }

    /// Adds the expression to every value; where it has no finite value, nothing is added.
    fn over(&self, scene: &Scene, parameters: &[f64], target: Target, values: &mut [f64]) {
        let mut evaluation = Evaluation::of(self);
        let time = &scene.motion.time;
        for (block, values) in values.chunks_mut(BLOCK).enumerate() {
            let samples = block * BLOCK..block * BLOCK + values.len();
            let intervals = samples.clone().map(|k| time[k] - time[k.saturating_sub(1)]);
            let variable =
                |index, column| target.variable(index, scene, samples.clone(), values, column);
            let change = evaluation.run(parameters, variable, &intervals);
            let add = |(value, change): (&mut f64, f64)| {
                if change.is_finite() {
                    *value += change;
                }
            };
            match &change {
                Operand::Same(change) => {
                    values.iter_mut().for_each(|value| add((value, *change)));
                }
                Operand::Each(column) => {
                    values.iter_mut().zip(column.iter().copied()).for_each(add);
                }
            }
            evaluation.recycle(change);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its values at two samples, in the order of the values given of each variable.
    fn values(text: &str, k: f64, known: impl Fn(&str) -> [f64; 2]) -> [f64; 2] {
        let expression = Expression::parse(text, &["k"]).unwrap();
        let variable = |index: usize, mut column: Vec<f64>| {
            column.extend(known(VARIABLES[index].0));
            Operand::Each(column)
        };
        match Evaluation::of(&expression).run(&[k], variable, &[0.0, 0.1].into_iter()) {
            Operand::Same(value) => [value; 2],
            Operand::Each(column) => [column[0], column[1]],
        }
    }

    /// Its value where x = 3, v = −2, a = 2, every other variable 0, and k = 5.
    fn value(text: &str) -> f64 {
        let known = |name: &str| match name {
            "x" => [3.0, 7.0],
            "v" => [-2.0, 1.0],
            "a" => [2.0, -9.0],
            _ => [0.0, 0.5],
        };
        values(text, 5.0, known)[0]
    }

    #[test]
    fn precedence_is_that_of_mathematics() {
        assert_eq!(value("-a^2"), -4.0);
        assert_eq!(value("exp(-((x - 1) / a)^2)"), (-1.0_f64).exp());
        assert_eq!(value("2^-1"), 0.5);
        assert_eq!(value("2^3^2"), 512.0);
        assert_eq!(value("-2^-2"), -0.25);
        assert_eq!(value("2 * -x"), -6.0);
        assert_eq!(value("1 - 2 - 3"), -4.0);
        assert_eq!(value("1 - 2 + 3"), 2.0);
        assert_eq!(value("12 / 2 / 3"), 2.0);
        assert_eq!(value("12 / 2 * 3"), 18.0);
        assert_eq!(value("2 + 3 * 4^2 / 8"), 8.0);
        assert_eq!(value("-x * a^2 + +k"), -7.0);
        assert_eq!(value("(v)^2"), 4.0);
        assert_eq!(value("--x"), 3.0);
    }

    #[test]
    fn functions_constants_and_numbers_have_their_values() {
        assert_eq!(value("max(min(x, a), -1) + abs(v)"), 4.0);
        assert_eq!(value("atan2(0, -1) - PI"), 0.0);
        assert_eq!(value("ln(E) + log10(1e3) + .5 + 2.5e-1"), 4.75);
        assert_eq!(value("sign(v) + signum(0 * x)"), -1.0);
        assert_eq!(value("TAU / π"), 2.0);
        assert_eq!(value("tanh(t)"), 0.0);
    }

    /// The values over a press to 2 mm and back at 1 mm/s, a sample each 0.1 s.
    fn over_a_press(text: &str) -> Vec<f64> {
        let time: Vec<f64> = (0..41).map(|k| 0.1 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| 2.0 - (t - 2.0_f64).abs()).collect();
        let expression = Expression::parse(text, &["k"]).unwrap();
        let mut evaluation = Evaluation::of(&expression);
        let mut found = Vec::new();
        // In blocks: what is remembered goes on from one to the next.
        for x in x.chunks(16) {
            let variable = |index: usize, mut column: Vec<f64>| {
                if VARIABLES[index].0 != "x" {
                    return Operand::Same(1.0);
                }
                column.extend(x);
                Operand::Each(column)
            };
            match evaluation.run(&[0.7], variable, &x.iter().map(|_| 0.1)) {
                Operand::Same(value) => found.extend(x.iter().map(|_| value)),
                Operand::Each(column) => found.extend(column),
            }
        }
        found
    }

    #[test]
    fn functions_with_a_memory_remember_the_stretch() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} for {b}");
        let peak = over_a_press("peak(x)");
        close(peak[5], 0.5);
        close(peak[40], 2.0);
        let total = over_a_press("total(x)");
        close(total[20], 2.0);
        close(total[40], 4.0);
        // A ramp behind a low pass: t − τ (1 − e^(−t/τ)).
        let lag = over_a_press("lag(x, k)");
        for k in [1, 7, 20] {
            let t = 0.1 * f64::from(k);
            close(lag[k as usize], t - 0.7 * (1.0 - (-t / 0.7_f64).exp()));
        }
        let since = over_a_press("since(x - 1.05)");
        close(since[10], 0.0);
        close(since[20], 0.9 + 0.1);
        close(since[40], 0.0);
        // A play of 0.35 to either side: it follows on the way in, stays over 0.7 mm at the turn, and follows on the way out.
        let play = over_a_press("play(x, k / 2)");
        close(play[3], 0.0);
        close(play[20], 2.0 - 0.35);
        close(play[26], 2.0 - 0.35);
        close(play[33], 0.7 + 0.35);
        // Two of the same name do not share what they keep.
        close(over_a_press("peak(x) - peak(-x)")[40], 2.0);
        close(over_a_press("lag(x, 0)")[13], 1.3);
    }

    fn fault(text: &str) -> ExpressionError {
        Expression::parse(text, &["k", "place"]).map(|_| ()).unwrap_err()
    }

    #[test]
    fn errors_point_into_the_expression() {
        let unknown = fault("k * abs(x) * speed");
        assert_eq!((unknown.at, unknown.length), (13, 5));
        assert!(unknown.message.contains("`speed` is unknown"), "{unknown}");
        let places = [
            ("k * (x + 1", 4),
            ("k * x) + 1", 5),
            ("k * § x", 4),
            ("k * x +", 7),
            ("k * * x", 4),
            ("k ** x", 3),
            ("π k", 2),
            ("min(x, )", 7),
            ("", 0),
        ];
        for (text, at) in places {
            assert_eq!(fault(text).at, at, "{text}: {}", fault(text));
        }
    }

    #[test]
    fn errors_are_told_in_the_terms_of_who_wrote_it() {
        let told = [
            ("k * tnah(v)", "no function `tnah`; did you mean `tanh`?"),
            ("k * x * plcae", "did you mean `place`?"),
            ("k * tanh v", "`tanh` is a function: write `tanh(...)`"),
            ("2 x", "an operator is missing before `x`"),
            ("k (x + 1)", "`k` is no function; a product is written `k * (...)`"),
            ("k ** x", "a power is written `^`"),
            ("2,5 * x", "decimals are written with a point"),
            ("min(x)", "`min` takes two values, not 1"),
            ("lag(x)", "`lag` takes two values, not 1"),
            ("peek(x)", "did you mean `peak`?"),
            ("tanh(x, v)", "`tanh` takes one value, not 2"),
            ("k * (x + 1", "never closed"),
            ("1.2.3", "an operator is missing before `0.3`"),
        ];
        for (text, part) in told {
            let message = fault(text).message;
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn a_long_nest_is_refused_not_overflown() {
        let nest = format!("{}x{}", "(".repeat(900), ")".repeat(900));
        assert!(fault(&nest).message.contains("nested too deeply"));
        let signs = format!("{}x", "-".repeat(1_900));
        assert!(fault(&signs).message.contains("nested too deeply"));
        let sum = vec!["x"; 500].join(" + ");
        assert_eq!(value(&sum), 1_500.0);
        assert!(fault(&vec!["x"; 501].join(" + ")).message.contains("longer than 2000 characters"));
    }

    #[test]
    fn the_name_of_a_parameter_is_not_taken_for_something_else() {
        for name in ["x", "E", "tanh"] {
            let message = Expression::parse("1", &[name]).map(|_| ()).unwrap_err().message;
            assert!(message.contains(name), "{message}");
        }
    }
}
