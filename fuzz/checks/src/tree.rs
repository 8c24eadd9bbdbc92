//! Formulas as trees, drawn from bytes and printed as the program reads them.

use std::fmt;

use leafwise::expression::Function;

use crate::source::Source;

/// A formula over numbered variables.
#[derive(Clone, Debug)]
pub enum Tree {
    /// A decimal.
    Number(f64),
    /// π.
    Pi,
    /// xᵢ.
    Variable(usize),
    /// Σ of the terms, each with its sign.
    Sum(Vec<(bool, Tree)>),
    /// Π of the factors.
    Product(Vec<Tree>),
    /// a / b.
    Quotient(Box<Tree>, Box<Tree>),
    /// a^(n/d).
    Power(Box<Tree>, i32, i32),
    /// a^b.
    General(Box<Tree>, Box<Tree>),
    /// −a.
    Negate(Box<Tree>),
    /// f(a).
    Apply(Function, Box<Tree>),
    /// a where c > 0, b elsewhere, of c, a and b.
    If(Box<[Tree; 3]>),
}

impl Tree {
    /// a + b.
    pub fn plus(self, other: Tree) -> Tree {
        match self {
            Tree::Sum(mut terms) => {
                terms.push((false, other));
                Tree::Sum(terms)
            }
            first => Tree::Sum(vec![(false, first), (false, other)]),
        }
    }

    /// c·a.
    pub fn times(self, factor: f64) -> Tree {
        Tree::Product(vec![Tree::Number(factor), self])
    }

    /// aⁿ.
    pub fn to(self, exponent: i32) -> Tree {
        Tree::Power(self.into(), exponent, 1)
    }

    /// f(a).
    pub fn under(self, function: Function) -> Tree {
        Tree::Apply(function, self.into())
    }

    /// c + a.
    pub fn shifted(self, by: f64) -> Tree {
        Tree::Sum(vec![(false, Tree::Number(by)), (false, self)])
    }

    /// 1/a.
    pub fn inverse(self) -> Tree {
        Tree::Quotient(Tree::Number(1.0).into(), self.into())
    }

    /// The formula with these names.
    pub fn text(&self, names: &[&str]) -> String {
        let mut text = String::new();
        self.write(&mut text, names);
        text
    }

    fn write(&self, text: &mut String, names: &[&str]) {
        match self {
            Self::Number(value) if value.is_sign_negative() => {
                text.push_str(&format!("({value:?})"))
            }
            Self::Number(value) => text.push_str(&format!("{value:?}")),
            Self::Pi => text.push_str("pi"),
            Self::Variable(index) => text.push_str(names[*index]),
            Self::Sum(terms) => {
                text.push('(');
                for (at, (is_negative, term)) in terms.iter().enumerate() {
                    text.push_str(match (at, is_negative) {
                        (0, false) => "",
                        (0, true) => "-",
                        (_, false) => " + ",
                        (_, true) => " - ",
                    });
                    term.write(text, names);
                }
                text.push(')');
            }
            Self::Product(factors) => {
                text.push('(');
                for (at, factor) in factors.iter().enumerate() {
                    if at > 0 {
                        text.push('*');
                    }
                    factor.write(text, names);
                }
                text.push(')');
            }
            Self::Quotient(above, below) => {
                text.push('(');
                above.write(text, names);
                text.push('/');
                below.write(text, names);
                text.push(')');
            }
            Self::Power(base, numerator, denominator) => {
                text.push('(');
                base.write(text, names);
                text.push_str(&match denominator {
                    1 => format!("^({numerator}))"),
                    _ => format!("^({numerator}/{denominator}))"),
                });
            }
            Self::General(base, exponent) => {
                text.push('(');
                base.write(text, names);
                text.push('^');
                exponent.write(text, names);
                text.push(')');
            }
            Self::Negate(operand) => {
                text.push_str("(-");
                operand.write(text, names);
                text.push(')');
            }
            Self::Apply(function, argument) => {
                text.push_str(function.name());
                text.push('(');
                argument.write(text, names);
                text.push(')');
            }
            Self::If(parts) => {
                let [c, a, b] = &**parts;
                for (before, part) in [("if(", c), (" > 0, ", a), (", ", b)] {
                    text.push_str(before);
                    part.write(text, names);
                }
                text.push(')');
            }
        }
    }

    /// A tree of at most this depth over so many variables.
    pub fn drawn(source: &mut Source<'_>, depth: usize, variables: usize) -> Tree {
        if depth == 0 {
            return Self::leaf(source, variables);
        }
        let inner = |source: &mut Source<'_>| Self::drawn(source, depth - 1, variables);
        match source.below(12) {
            0 => Self::leaf(source, variables),
            1 | 2 => {
                let count = 2 + source.below(2);
                let term = |_| (source.chance(96), inner(source));
                Tree::Sum((0..count).map(term).collect())
            }
            3 | 4 => {
                let count = 2 + source.below(2);
                Tree::Product((0..count).map(|_| inner(source)).collect())
            }
            5 => {
                // A denominator away from 0 more often than not.
                let above = inner(source);
                let mut below = inner(source);
                if source.chance(128) {
                    below = below.shifted(source.decimal(-4.0, 4.0));
                }
                Tree::Quotient(above.into(), below.into())
            }
            6 => {
                let shift = match source.chance(40) {
                    true => source.pick(&[10.0, -100.0, 1000.0]),
                    false => source.decimal(-4.0, 4.0),
                };
                let base = inner(source).shifted(shift);
                Tree::Power(base.into(), source.below(13) as i32 - 4, 1)
            }
            7 => {
                let base = inner(source).shifted(source.decimal(0.0, 6.0));
                let numerator = source.below(11) as i32 - 5;
                Tree::Power(base.into(), numerator, source.pick(&[2, 3, 5]))
            }
            8 if source.chance(64) => Tree::General(inner(source).into(), inner(source).into()),
            8 => Tree::If([inner(source), inner(source), inner(source)].into()),
            9 => Tree::Negate(inner(source).into()),
            _ => {
                let function = source.pick(&Function::ALL);
                inner(source).under(function)
            }
        }
    }

    fn leaf(source: &mut Source<'_>, variables: usize) -> Tree {
        match source.below(16) {
            0 => Tree::Pi,
            1 => Tree::Number(source.pick(&[0.0, 1.0, 1e30, 1e-30, 1e-320, 1e300, 1000.0])),
            2..=5 => Tree::Number(source.decimal(-4.0, 4.0)),
            _ => Tree::Variable(source.below(variables)),
        }
    }
}

impl fmt::Display for Tree {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text(&NAMES))
    }
}

/// Names of variables where nothing else is said.
pub const NAMES: [&str; 4] = ["x", "y", "z", "w"];
