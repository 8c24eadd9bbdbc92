//! Generators adjoined to the polynomials: functions of the state, and constants of the parameters.

use super::polynomial::{Coefficient, Polynomial};
use crate::expression::{Binary, Function, Side};
use crate::rational::Rational;
use crate::table::Lookup;

/// A function of the state adjoined to the ring. Its derivative is again in the ring. A relation,
/// where it has one, fixes a normal form.
///
/// | generator | relation used as a rewriting rule | exponents |
/// |---|---|---|
/// | `Inverse(u)` = 1/u, u with several terms and leading term 1·m | m·g → 1 − (u − m)·g | ≥ 0 |
/// | `Root(u, q)` = u^(1/q) | g^q → u | 0 … q−1 |
/// | `Power(u, a)` = uᵃ, a a function of the parameters | none | any |
/// | `Kept(side, u, 1)` | g² → g | 0, 1 |
/// | any other `Kept(side, u, v)`, linear in v | none | any |
/// | `Function(cos, u)` | cos² → 1 − sin² | 0, 1 |
/// | `Function(cosh, u)` | cosh² → 1 + sinh² | 0, 1 |
/// | `Function(exp, u)` | none: e^{−u} is the exponent −1 | any |
/// | any other `Function(f, u)` | none | any |
/// | `Binary(f, u, v)` | none | any |
/// | `Lookup(f, u)` | none | any |
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Generator {
    /// 1/u.
    Inverse(Polynomial),
    /// u^(1/q).
    Root(Polynomial, u16),
    /// uᵃ with an exponent that depends on parameters.
    Power(Polynomial, Coefficient),
    /// f(u).
    Function(Function, Polynomial),
    /// f(u, v).
    Binary(Binary, Polynomial, Polynomial),
    /// A table, or one of its derivatives, at a point.
    Lookup(Lookup, Vec<Polynomial>),
    /// v where u is of this side of 0, 0 elsewhere, of u and v.
    Kept(Side, Polynomial, Polynomial),
}

impl Generator {
    /// The argument u, of a table its first one.
    pub fn argument(&self) -> &Polynomial {
        match self {
            Self::Lookup(_, point) => &point[0],
            Self::Inverse(u)
            | Self::Root(u, _)
            | Self::Power(u, _)
            | Self::Function(_, u)
            | Self::Binary(_, u, _)
            | Self::Kept(_, u, _) => u,
        }
    }

    /// The polynomials that it is a function of: u, and v where there is one.
    pub fn arguments(&self) -> impl Iterator<Item = &Polynomial> {
        let others = match self {
            Self::Kept(_, _, value) | Self::Binary(_, _, value) => std::slice::from_ref(value),
            Self::Lookup(_, point) => &point[1..],
            _ => &[],
        };
        [self.argument()].into_iter().chain(others)
    }
}

/// A constant of the coefficient field: a parameter, π, or a function of such.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Atom {
    /// The parameter with this index.
    Parameter(usize),
    /// π.
    Pi,
    /// 1/c for a c of several terms.
    Inverse(Coefficient),
    /// c^r, r not an integer.
    RationalPower(Coefficient, Rational),
    /// c^d with a d that depends on parameters.
    Power(Coefficient, Coefficient),
    /// f(c).
    Function(Function, Coefficient),
    /// f(c, d).
    Binary(Binary, Coefficient, Coefficient),
    /// A table, or one of its derivatives, at a point.
    Lookup(Lookup, Vec<Coefficient>),
}
