//! An expression over the samples of a stretch, a block of them at a time: each step of its program is taken once for a block.

use super::Expression;
use super::function::{OfTwo, Pairs};
use super::memory::{Kept, Memory};
use super::parser::Step;

/// Samples of a block: few enough to stay near the processor, many enough that the steps of the program cost little.
pub(super) const BLOCK: usize = 256;

/// A value at every sample of a block.
#[derive(Debug)]
pub(super) enum Operand {
    /// The same at all.
    Same(f64),
    /// One for each.
    Each(Vec<f64>),
}

/// An expression on its way through a stretch.
pub(super) struct Evaluation<'a> {
    program: &'a [Step],
    stack: Vec<Operand>,
    /// Columns that are free to be written to.
    free: Vec<Vec<f64>>,
    /// Of each function with a memory, in the order of the program.
    kept: Vec<Option<Kept>>,
}

impl<'a> Evaluation<'a> {
    /// At the beginning of a stretch.
    pub fn of(expression: &'a Expression) -> Self {
        let memories = expression.program.iter().filter(|step| matches!(step, Step::Remember(_)));
        let kept = vec![None; memories.count()];
        Self { program: &expression.program, stack: Vec::new(), free: Vec::new(), kept }
    }

    /// Its value at each sample of the next block. `variable` writes a variable into an empty column; `intervals` are those since the
    /// sample before, s, one a sample.
    pub fn run(
        &mut self,
        parameters: &[f64],
        variable: impl Fn(usize, Vec<f64>) -> Operand,
        intervals: &(impl Iterator<Item = f64> + Clone),
    ) -> Operand {
        let mut memories = 0;
        for step in self.program {
            let value = match *step {
                Step::Number(number) => Operand::Same(number),
                Step::Parameter(index) => Operand::Same(parameters[index]),
                Step::Variable(index) => variable(index, self.column()),
                Step::One(apply) => {
                    let mut value = self.pop();
                    apply(value.as_mut());
                    value
                }
                Step::Two(apply) => {
                    let second = self.pop();
                    let first = self.pop();
                    self.joined(first, second, apply)
                }
                Step::Remember((memory, values)) => {
                    let own = if values == 2 { self.pop() } else { Operand::Same(0.0) };
                    let value = self.pop();
                    memories += 1;
                    self.followed(memories - 1, memory, (value, own), intervals.clone())
                }
            };
            self.stack.push(value);
        }
        self.pop()
    }

    /// Takes back a value that is no longer needed.
    pub fn recycle(&mut self, value: Operand) {
        if let Operand::Each(column) = value {
            self.free.push(column);
        }
    }

    fn pop(&mut self) -> Operand {
        self.stack.pop().unwrap_or(Operand::Same(0.0))
    }

    fn column(&mut self) -> Vec<f64> {
        let mut column = self.free.pop().unwrap_or_else(|| Vec::with_capacity(BLOCK));
        column.clear();
        column
    }

    fn joined(&mut self, first: Operand, second: Operand, apply: OfTwo) -> Operand {
        let (mut first, mut second) = (first, second);
        match (&mut first, &mut second) {
            (Operand::Same(a), Operand::Each(column)) => {
                apply(Pairs::FirstSame(*a, column));
                return second;
            }
            (first, Operand::Same(b)) => apply(Pairs::SecondSame(first.as_mut(), *b)),
            (Operand::Each(column), Operand::Each(other)) => apply(Pairs::Columns(column, other)),
        }
        self.recycle(second);
        first
    }

    fn followed(
        &mut self,
        number: usize,
        memory: Memory,
        (value, own): (Operand, Operand),
        intervals: impl Iterator<Item = f64>,
    ) -> Operand {
        let mut column = self.column();
        let kept = &mut self.kept[number];
        for (k, interval) in intervals.enumerate() {
            column.push(memory.follow(kept, value.at(k), own.at(k), interval));
        }
        self.recycle(value);
        self.recycle(own);
        Operand::Each(column)
    }
}

impl Operand {
    fn as_mut(&mut self) -> &mut [f64] {
        match self {
            Self::Same(value) => std::slice::from_mut(value),
            Self::Each(column) => column,
        }
    }

    fn at(&self, sample: usize) -> f64 {
        match self {
            Self::Same(value) => *value,
            Self::Each(column) => column[sample],
        }
    }
}
