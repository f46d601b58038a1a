//! From words to a program in postfix order, with the precedence of mathematics: `^` before the sign,
//! the sign before `*` and `/`, these before `+` and `-`; `^` from the right, all else from the left.

use super::VARIABLES;
use super::function::{CONSTANTS, ONE, OfOne, OfTwo, TWO, every, names, negate, of, power};
use super::memory::{MEMORIES, Memory};
use super::token::{Fault, Token, Word, tokens};

/// One step of a program over a stack of values.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    Number(f64),
    /// By its place in [`VARIABLES`].
    Variable(usize),
    /// By its place among the parameters.
    Parameter(usize),
    One(OfOne),
    Two(OfTwo),
    /// With a memory, of one value or two.
    Remember((Memory, usize)),
}

/// Deepest nesting of an expression: parentheses, functions, signs.
const MAX_NESTING: usize = 100;
/// Binding of a sign before a value: above `*`, below `^`.
const SIGN: u8 = 5;
/// Letters by which a name may differ from one that is meant.
const MAX_MISSPELT_LETTERS: usize = 2;

/// Reads an expression in which `parameters` may occur.
pub(super) fn parse(text: &str, parameters: &[&str]) -> Result<Vec<Step>, Fault> {
    if let Some(taken) = parameters.iter().find(|name| is_taken(name)) {
        let message = format!("a parameter cannot be called `{taken}`: that has a meaning here");
        return Err(Fault { at: 0, length: 1, message });
    }
    let tokens = tokens(text)?;
    let end = text.chars().count();
    let mut parser = Parser { tokens: &tokens, next: 0, end, parameters, program: Vec::new() };
    parser.expression(0, 0)?;
    match parser.peek() {
        None => Ok(parser.program),
        Some(token) => Err(after_a_value(token)),
    }
}

/// Whether a name is that of a variable, a constant or a function.
fn is_taken(name: &str) -> bool {
    VARIABLES.iter().any(|(known, _)| *known == name)
        || of(&CONSTANTS, name).is_some()
        || names().contains(&name)
}

struct Parser<'a> {
    tokens: &'a [Token],
    next: usize,
    /// Length of the text, in characters.
    end: usize,
    parameters: &'a [&'a str],
    program: Vec<Step>,
}

/// How strongly an operator binds on its left and on its right, and what it does.
fn operator(sign: char) -> Option<(u8, u8, OfTwo)> {
    Some(match sign {
        '+' => (1, 2, |pairs| every(pairs, |a, b| a + b)),
        '-' => (1, 2, |pairs| every(pairs, |a, b| a - b)),
        '*' => (3, 4, |pairs| every(pairs, |a, b| a * b)),
        '/' => (3, 4, |pairs| every(pairs, |a, b| a / b)),
        '^' => (7, 6, power),
        _ => return None,
    })
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<&'a Token> {
        self.tokens.get(self.next)
    }

    fn fault<T>(&self, token: Option<&Token>, message: impl Into<String>) -> Result<T, Fault> {
        let (at, length) = token.map_or((self.end, 1), |token| (token.at, token.length));
        Err(Fault { at, length, message: message.into() })
    }

    /// A value and the operators after it that bind at least so strongly.
    fn expression(&mut self, binding: u8, depth: usize) -> Result<(), Fault> {
        if depth > MAX_NESTING {
            return self.fault(self.peek(), "nested too deeply");
        }
        self.value(depth)?;
        while let Some(Token { word: Word::Sign(sign), .. }) = self.peek() {
            let Some((_, right, apply)) = operator(*sign).filter(|(left, ..)| *left >= binding)
            else {
                break;
            };
            self.next += 1;
            self.expression(right, depth + 1)?;
            self.program.push(Step::Two(apply));
        }
        Ok(())
    }

    fn value(&mut self, depth: usize) -> Result<(), Fault> {
        let Some(token) = self.peek() else {
            return self.fault(None, "a value is missing at the end");
        };
        self.next += 1;
        match &token.word {
            Word::Number(number) => self.program.push(Step::Number(*number)),
            Word::Name(name) => self.name(token, name, depth)?,
            Word::Sign('(') => {
                self.expression(0, depth + 1)?;
                self.close(token)?;
            }
            Word::Sign('+') => self.expression(SIGN, depth + 1)?,
            Word::Sign('-') => {
                self.expression(SIGN, depth + 1)?;
                self.program.push(Step::One(negate));
            }
            Word::Sign('*') if self.tokens.get(self.next.wrapping_sub(2)).is_some_and(is_times) => {
                return self.fault(Some(token), "a power is written `^`");
            }
            Word::Sign(sign) => {
                return self.fault(Some(token), format!("a value is missing before `{sign}`"));
            }
        }
        Ok(())
    }

    /// The closing parenthesis of one that was opened.
    fn close(&mut self, opened: &Token) -> Result<(), Fault> {
        match self.peek() {
            Some(Token { word: Word::Sign(')'), .. }) => {
                self.next += 1;
                Ok(())
            }
            None => self.fault(Some(opened), "this parenthesis is never closed"),
            Some(token) => Err(after_a_value(token)),
        }
    }

    /// A parameter, a variable, a constant or a function with its values.
    fn name(&mut self, token: &Token, name: &str, depth: usize) -> Result<(), Fault> {
        let called = matches!(self.peek(), Some(Token { word: Word::Sign('('), .. }));
        let variable = VARIABLES.iter().position(|(known, _)| *known == name);
        let value = self.parameters.iter().position(|known| *known == name);
        let value = value.map(Step::Parameter).or(variable.map(Step::Variable));
        let value = value.or_else(|| of(&CONSTANTS, name).map(Step::Number));
        let function = of(&ONE, name).map(Step::One).or_else(|| of(&TWO, name).map(Step::Two));
        let function = function.or_else(|| of(&MEMORIES, name).map(Step::Remember));
        match (value, function) {
            (Some(_), _) if called => self.fault(
                Some(token),
                format!("`{name}` is no function; a product is written `{name} * (...)`"),
            ),
            (Some(step), _) => {
                self.program.push(step);
                Ok(())
            }
            (None, Some(step)) if called => self.call(token, name, step, depth),
            (None, Some(_)) => {
                self.fault(Some(token), format!("`{name}` is a function: write `{name}(...)`"))
            }
            (None, None) if called => self.fault(Some(token), unknown_function(name)),
            (None, None) => self.fault(Some(token), self.unknown(name)),
        }
    }

    fn call(&mut self, token: &Token, name: &str, step: Step, depth: usize) -> Result<(), Fault> {
        let wanted = match step {
            Step::One(_) => 1,
            Step::Remember((_, values)) => values,
            _ => 2,
        };
        let opened = &self.tokens[self.next];
        self.next += 1;
        let mut given = 0;
        if !matches!(self.peek(), Some(Token { word: Word::Sign(')'), .. })) {
            loop {
                self.expression(0, depth + 1)?;
                given += 1;
                if !matches!(self.peek(), Some(Token { word: Word::Sign(','), .. })) {
                    break;
                }
                self.next += 1;
            }
        }
        self.close(opened)?;
        if given != wanted {
            let values = if wanted == 1 { "one value" } else { "two values" };
            return self.fault(Some(token), format!("`{name}` takes {values}, not {given}"));
        }
        self.program.push(step);
        Ok(())
    }

    fn unknown(&self, name: &str) -> String {
        let variables = VARIABLES.map(|(name, _)| name);
        let known = [self.parameters, &variables].concat();
        let meant = nearest(name, &[known.as_slice(), &names()].concat());
        let hint = meant.map_or_else(String::new, |meant| format!(" (did you mean `{meant}`?)"));
        format!("`{name}` is unknown{hint}; known here: {}", known.join(", "))
    }
}

fn is_times(token: &Token) -> bool {
    token.word == Word::Sign('*')
}

/// What stands where an operator should.
fn after_a_value(token: &Token) -> Fault {
    let message = match &token.word {
        Word::Sign(')') => "this parenthesis closes nothing".into(),
        Word::Sign(',') => {
            "a comma parts the values of a function; decimals are written with a point".into()
        }
        Word::Sign(sign) => format!("an operator is missing before `{sign}`"),
        Word::Name(name) => format!("an operator is missing before `{name}`"),
        Word::Number(number) => format!("an operator is missing before `{number}`"),
    };
    Fault { at: token.at, length: token.length, message }
}

fn unknown_function(name: &str) -> String {
    match nearest(name, &names()) {
        Some(meant) => format!("no function `{name}`; did you mean `{meant}`?"),
        None => format!("no function `{name}`; there are: {}", names().join(", ")),
    }
}

/// The known name that differs least from one, where it differs by a letter or two and less than by half.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let most = MAX_MISSPELT_LETTERS.min(name.chars().count() / 2);
    known
        .iter()
        .map(|&known| (strsim::osa_distance(&name.to_lowercase(), &known.to_lowercase()), known))
        .filter(|(distance, _)| *distance <= most)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, known)| known)
}
