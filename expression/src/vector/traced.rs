//! A register that writes down what is done to it: formulas as data, for code that is written at run time.

use std::cell::{Cell, RefCell};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use super::register::Register;

/// A number of a formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Number {
    /// The formula's argument.
    Argument,
    /// The same for every argument.
    Constant(f64),
    /// The result of the operation of this number.
    Result(usize),
}

/// An operation, as that of a [`Register`] of the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Traceable {
    Add,
    Subtract,
    Multiply,
    TimesPlus,
    TimesFrom,
    And,
}

/// Operations in their order.
#[derive(Debug, Default)]
pub(crate) struct Tape {
    operations: RefCell<Vec<(Traceable, [Number; 3])>>,
    limit: Cell<Option<(Number, f64)>>,
}

impl Tape {
    /// The formula's argument.
    pub(crate) fn argument(&self) -> Traced<'_> {
        Traced {
            tape: Some(self),
            number: Number::Argument,
        }
    }

    /// The operations, with their operands; an operation of two repeats its second.
    pub(crate) fn operations(self) -> Vec<(Traceable, [Number; 3])> {
        self.operations.into_inner()
    }

    /// Condition on the formula's argument: a number, and the bound that it must be below.
    pub(crate) fn limit(&self) -> Option<(Number, f64)> {
        self.limit.get()
    }
}

/// A number on its tape; constants are on none.
#[derive(Clone, Copy)]
pub(crate) struct Traced<'a> {
    tape: Option<&'a Tape>,
    pub(crate) number: Number,
}

impl Traced<'_> {
    fn operate(self, operation: Traceable, b: Self, c: Self) -> Self {
        let tape = [self, b, c].iter().find_map(|own| own.tape);
        let mut operations = tape.expect(OF_CONSTANTS).operations.borrow_mut();
        operations.push((operation, [self.number, b.number, c.number]));
        Self {
            tape,
            number: Number::Result(operations.len() - 1),
        }
    }
}

const OF_CONSTANTS: &str = "formulas fold what is made of constants alone";
const BRANCHES: &str = "a formula is traced where it needs no bits of its argument";

macro_rules! operator {
    ($trait:ident, $method:ident, $name:ident) => {
        impl $trait for Traced<'_> {
            type Output = Self;

            fn $method(self, b: Self) -> Self {
                self.operate(Traceable::$name, b, b)
            }
        }
    };
}

operator!(Add, add, Add);
operator!(Sub, sub, Subtract);
operator!(Mul, mul, Multiply);

impl Div for Traced<'_> {
    type Output = Self;

    fn div(self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }
}

/// That a number is below a bound: taken for true, and written down.
#[derive(Clone, Copy)]
pub(crate) struct Below<'a> {
    number: Traced<'a>,
    bound: f64,
}

impl BitAnd for Below<'_> {
    type Output = Self;

    fn bitand(self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }
}

impl BitOr for Below<'_> {
    type Output = Self;

    fn bitor(self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }
}

impl<'a> Register for Traced<'a> {
    type Mask = Below<'a>;
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self {
            tape: None,
            number: Number::Constant(value),
        }
    }

    fn load(_: &[f64]) -> Self {
        unreachable!("{BRANCHES}")
    }

    fn store(self, _: &mut [f64]) {
        unreachable!("{BRANCHES}")
    }

    fn times_plus(self, b: Self, c: Self) -> Self {
        self.operate(Traceable::TimesPlus, b, c)
    }

    fn times_from(self, b: Self, c: Self) -> Self {
        self.operate(Traceable::TimesFrom, b, c)
    }

    fn larger(self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }

    fn largest(self) -> f64 {
        unreachable!("{BRANCHES}")
    }

    fn less(self, b: Self) -> Below<'a> {
        let Number::Constant(bound) = b.number else {
            unreachable!("{BRANCHES}")
        };
        Below {
            number: self,
            bound,
        }
    }

    fn equal(self, _: Self) -> Below<'a> {
        unreachable!("{BRANCHES}")
    }

    fn is_odd(self) -> Below<'a> {
        unreachable!("{BRANCHES}")
    }

    fn select(_: Below<'a>, _: Self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }

    fn all(mask: Below<'a>) -> bool {
        let limit = Some((mask.number.number, mask.bound));
        mask.number.tape.expect(OF_CONSTANTS).limit.set(limit);
        true
    }

    fn and(self, b: Self) -> Self {
        self.operate(Traceable::And, b, b)
    }

    fn or(self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }

    fn xor(self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }

    fn add_bits(self, _: Self) -> Self {
        unreachable!("{BRANCHES}")
    }

    fn up<const K: u32>(self) -> Self {
        unreachable!("{BRANCHES}")
    }

    fn down<const K: u32>(self) -> Self {
        unreachable!("{BRANCHES}")
    }
}
