//! Code in single assignment: each operation has a result of its own.

use rustc_hash::FxHashMap;

use super::operation::{Action, Location, Operation, Source};
use crate::analytic::{FunctionPair, Member};
use crate::elementary::NearZero;
use crate::kernel::code::{Code, Instruction};
use crate::vector::{Number, Traceable};

/// Arguments of functions that a program serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arguments {
    /// All.
    Any,
    /// Those of pairs of functions near 0, by formulas in the place of calls.
    NearZero,
}

/// A bound of what a program is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    /// The row of the program's own numbers that holds the largest size found, 0 at first.
    pub(super) row: u32,
    /// Bound that the size must be below.
    pub(super) bound: f64,
    /// The row that holds this bound.
    pub(super) bound_row: u32,
}

/// Operations with the numbers that they read beside slots.
#[derive(Debug, Default)]
pub(super) struct Assignment {
    pub(super) operations: Vec<Operation>,
    pub(super) own: Vec<f64>,
    pub(super) limits: Vec<Limit>,
    /// The outputs of the code.
    pub(super) outputs: Vec<Source>,
}

/// The values of a pair of functions, and which of them results of the code are already.
type Values = ([Source; 2], [bool; 2]);

impl Assignment {
    /// The code with its slots resolved.
    pub(super) fn new(code: &Code, arguments: Arguments) -> Self {
        let mut current: Vec<Source> = (0..code.slots as u32).map(Source::Slot).collect();
        let mut own = Self::default();
        let mut pairs: FxHashMap<(Source, [&str; 2]), Values> = FxHashMap::default();
        for &instruction in &code.instructions {
            let [a, b] = instruction.operands().map(|slot| current[slot as usize]);
            let near = formulas(&instruction).filter(|_| arguments == Arguments::NearZero);
            let result = match near {
                None => own.push(Operation::new(Action::of(instruction), [a, b, b])),
                Some((pair, member, near)) => {
                    let key = (a, pair.names);
                    let known = pairs.get(&key).copied();
                    // Of a function that the code takes twice each has a result of its own.
                    let known = known.filter(|(_, taken)| !taken[member as usize]);
                    let (values, mut taken) =
                        known.unwrap_or_else(|| (own.expand(a, &near()), [false; 2]));
                    taken[member as usize] = true;
                    pairs.insert(key, (values, taken));
                    values[member as usize]
                }
            };
            current[instruction.output() as usize] = result;
        }
        for &slot in &code.outputs {
            let source = current[slot as usize];
            own.outputs.push(source);
            if let Some(result) = source.result() {
                own.operations[result].output = Some(Location::Slot(slot));
            }
        }
        own
    }

    fn push(&mut self, operation: Operation) -> Source {
        self.operations.push(operation);
        Source::Result(self.operations.len() as u32 - 1)
    }

    /// The formulas of a pair at an argument; returns both values.
    fn expand(&mut self, argument: Source, near: &NearZero) -> [Source; 2] {
        let first = self.operations.len();
        for &(operation, operands) in &near.operations {
            let action = match operation {
                Traceable::Add => Action::Add,
                Traceable::Subtract => Action::Subtract,
                Traceable::Multiply => Action::Multiply,
                Traceable::TimesPlus => Action::TimesPlus,
                Traceable::TimesFrom => Action::TimesFrom,
                Traceable::And => Action::And,
            };
            let operands = operands.map(|number| self.source(number, argument, first));
            self.push(Operation::new(action, operands));
        }
        let row = self.limit(near.bound);
        let size = self.source(near.size, argument, first);
        let largest = Source::Own(row);
        self.push(Operation {
            output: Some(Location::Own(row)),
            ..Operation::new(Action::Larger, [size, largest, largest])
        });
        near.values
            .map(|number| self.source(number, argument, first))
    }

    /// A number of formulas whose operations begin with the number `first`.
    fn source(&mut self, number: Number, argument: Source, first: usize) -> Source {
        match number {
            Number::Argument => argument,
            Number::Result(result) => Source::Result((first + result) as u32),
            Number::Constant(value) => {
                let bits = value.to_bits();
                let limits = &self.limits;
                let is_limit = |row: usize| limits.iter().any(|limit| limit.row as usize == row);
                let rows = self.own.iter().enumerate();
                let mut same = rows.filter(|(row, own)| own.to_bits() == bits && !is_limit(*row));
                let known = same.next().map(|(row, _)| row);
                Source::Own(known.unwrap_or_else(|| self.row(value)) as u32)
            }
        }
    }

    /// The row of the sizes that are to be below a bound.
    fn limit(&mut self, bound: f64) -> u32 {
        let known = self.limits.iter().find(|limit| limit.bound == bound);
        if let Some(limit) = known {
            return limit.row;
        }
        let [row, bound_row] = [0.0, bound].map(|value| self.row(value) as u32);
        self.limits.push(Limit {
            row,
            bound,
            bound_row,
        });
        row
    }

    fn row(&mut self, value: f64) -> usize {
        self.own.push(value);
        self.own.len() - 1
    }
}

/// A member of a pair of functions, and what makes the pair's formulas.
type Formulas = (&'static FunctionPair, Member, fn() -> NearZero);

/// The formulas near 0 of the pair that an instruction takes a function of.
fn formulas(instruction: &Instruction) -> Option<Formulas> {
    let (pair, member) = instruction.pair()?;
    Some((pair, member, pair.near_zero?))
}

/// Whether formulas may take the place of calls.
pub(super) fn has_formulas(code: &Code) -> bool {
    let mut instructions = code.instructions.iter();
    instructions.any(|instruction| formulas(instruction).is_some())
}
