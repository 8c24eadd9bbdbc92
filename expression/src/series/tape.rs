//! Taylor coefficients of a formula along a curve x(h) = Σ xₖ hᵏ, extended order by order.

use rustc_hash::FxHashMap;

use super::lookups::LookupSeries;
use crate::arithmetic::{AlgebraError, Arithmetic, binary_derivative, function_derivative};
use crate::expression::{Binary, Expression, Function, Side};
use crate::rational::Rational;
use crate::special::Special;
use crate::table::Lookup;

/// A node of a [`Tape`].
pub type TapeIndex = usize;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Step {
    Constant(Rational),
    Pi,
    Parameter(usize),
    Variable(usize),
    Combination(Vec<(Rational, TapeIndex)>),
    Product(TapeIndex, TapeIndex),
    Quotient(TapeIndex, TapeIndex),
    /// g = f(u); the derivative node d = f′(u) stands beside it, see [`Tape::derivatives`].
    Function(Function, TapeIndex),
    /// g = uᵃ with an exponent that is constant along the curve; d = a g/u.
    Power(TapeIndex, TapeIndex),
    /// g = f(u, v); its partial derivatives stand beside it, see [`Tape::partials`].
    Binary(Binary, TapeIndex, TapeIndex),
    /// A table, or one of its derivatives, at a point.
    Lookup(Lookup, Vec<TapeIndex>),
    /// v where c is of this side: along the curve, where it begins.
    Kept(Side, TapeIndex, TapeIndex),
}

/// Formulas as a list of operations with common subexpressions shared, ready to be expanded in
/// Taylor coefficients over any [`Arithmetic`].
///
/// Every elementary function obeys one rule: with d = f′(u),
/// g₀ = f(u₀) and k gₖ = Σ_{j=1..k} j uⱼ d_{k−j}; d needs only lower orders of g.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    steps: Vec<Step>,
    known: FxHashMap<Step, TapeIndex>,
    derivatives: FxHashMap<TapeIndex, TapeIndex>,
    partials: FxHashMap<TapeIndex, [TapeIndex; 2]>,
}

impl Tape {
    /// An empty tape.
    pub fn new() -> Self {
        Self::default()
    }

    /// Records a formula and returns its node.
    ///
    /// # Errors
    /// [`AlgebraError`] for a division by zero or an exponent that depends on variables.
    pub fn record(&mut self, expression: &Expression) -> Result<TapeIndex, AlgebraError> {
        expression.evaluate_in(self, &mut |tape: &mut Self, index| Ok(tape.variable(index)))
    }

    /// The node of the variable xᵢ.
    pub fn variable(&mut self, index: usize) -> TapeIndex {
        self.push(Step::Variable(index))
    }

    fn push(&mut self, step: Step) -> TapeIndex {
        if let Some(&at) = self.known.get(&step) {
            return at;
        }
        let at = self.steps.len();
        self.known.insert(step.clone(), at);
        self.steps.push(step);
        at
    }

    fn is_constant(&self, at: TapeIndex) -> bool {
        match &self.steps[at] {
            Step::Constant(_) | Step::Pi | Step::Parameter(_) => true,
            Step::Variable(_) => false,
            Step::Combination(terms) => terms.iter().all(|(_, t)| self.is_constant(*t)),
            Step::Product(a, b)
            | Step::Quotient(a, b)
            | Step::Power(a, b)
            | Step::Binary(_, a, b)
            | Step::Kept(_, a, b) => self.is_constant(*a) && self.is_constant(*b),
            Step::Function(_, u) => self.is_constant(*u),
            Step::Lookup(_, point) => point.iter().all(|u| self.is_constant(*u)),
        }
    }
}

impl Arithmetic for Tape {
    type Element = TapeIndex;

    fn constant(&mut self, value: &Rational) -> TapeIndex {
        self.push(Step::Constant(value.clone()))
    }
    fn pi(&mut self) -> TapeIndex {
        self.push(Step::Pi)
    }
    fn parameter(&mut self, index: usize) -> TapeIndex {
        self.push(Step::Parameter(index))
    }
    fn is_zero(&self, element: &TapeIndex) -> bool {
        matches!(&self.steps[*element], Step::Constant(c) if c.is_zero())
    }
    fn as_rational(&self, element: &TapeIndex) -> Option<Rational> {
        match &self.steps[*element] {
            Step::Constant(c) => Some(c.clone()),
            _ => None,
        }
    }
    fn combine(&mut self, terms: &[(Rational, TapeIndex)]) -> TapeIndex {
        let mut constant = Rational::zero();
        let mut sums: Vec<(Rational, TapeIndex)> = Vec::new();
        for (c, t) in terms {
            if let Some(value) = self.as_rational(t) {
                constant += &(c * &value);
            } else if let Some(known) = sums.iter_mut().find(|(_, s)| s == t) {
                known.0 += c;
            } else {
                sums.push((c.clone(), *t));
            }
        }
        sums.retain(|(c, _)| !c.is_zero());
        match sums.as_slice() {
            [] => return self.constant(&constant),
            [(c, t)] if c.is_one() && constant.is_zero() => return *t,
            _ => {}
        }
        if !constant.is_zero() {
            let one = self.constant(&Rational::one());
            sums.push((constant, one));
        }
        self.push(Step::Combination(sums))
    }
    fn multiply(&mut self, a: &TapeIndex, b: &TapeIndex) -> TapeIndex {
        match (self.as_rational(a), self.as_rational(b)) {
            (Some(c), _) => self.combine(&[(c, *b)]),
            (_, Some(c)) => self.combine(&[(c, *a)]),
            _ => self.push(Step::Product(*a.min(b), *a.max(b))),
        }
    }
    fn divide(&mut self, a: &TapeIndex, b: &TapeIndex) -> Result<TapeIndex, AlgebraError> {
        match self.as_rational(b) {
            Some(c) if c.is_zero() => Err(AlgebraError::DivisionByZero),
            Some(c) => Ok(self.combine(&[(c.recip(), *a)])),
            None if self.is_zero(a) => Ok(*a),
            None => Ok(self.push(Step::Quotient(*a, *b))),
        }
    }
    fn power(&mut self, a: &TapeIndex, b: &TapeIndex) -> Result<TapeIndex, AlgebraError> {
        if !self.is_constant(*b) {
            return Err(AlgebraError::VariableExponent);
        }
        if let Some(exponent) = self.as_rational(b).and_then(|r| r.to_i64()) {
            return self.integer_power(a, exponent);
        }
        let at = self.push(Step::Power(*a, *b));
        if !self.derivatives.contains_key(&at) {
            let quotient = self.divide(&at, a)?;
            let derivative = self.multiply(b, &quotient);
            self.derivatives.insert(at, derivative);
        }
        Ok(at)
    }
    fn apply_two(
        &mut self,
        function: Binary,
        a: &TapeIndex,
        b: &TapeIndex,
    ) -> Result<TapeIndex, AlgebraError> {
        let at = self.push(Step::Binary(function, *a, *b));
        if !self.is_constant(at) && !self.partials.contains_key(&at) {
            let mut partial = |by| binary_derivative(self, function, [a, b], by);
            let partials = [partial(0)?, partial(1)?];
            self.partials.insert(at, partials);
        }
        Ok(at)
    }
    fn kept(
        &mut self,
        side: Side,
        c: &TapeIndex,
        v: &TapeIndex,
    ) -> Result<TapeIndex, AlgebraError> {
        match self.as_rational(c) {
            Some(number) if side.has(&number) => Ok(*v),
            Some(_) => Ok(self.zero()),
            None if self.is_zero(v) => Ok(*v),
            None => Ok(self.push(Step::Kept(side, *c, *v))),
        }
    }
    fn look_up(&mut self, lookup: Lookup, point: &[TapeIndex]) -> Result<TapeIndex, AlgebraError> {
        Ok(self.push(Step::Lookup(lookup, point.to_vec())))
    }
    fn apply(&mut self, function: Function, a: &TapeIndex) -> Result<TapeIndex, AlgebraError> {
        let step = Step::Function(function, *a);
        let known = self.known.contains_key(&step);
        let at = self.push(step);
        // The node exists before its derivative is recorded: sine and cosine name each other.
        let has_formula = !matches!(function, Function::Special(..));
        if !known && has_formula && !self.is_constant(*a) {
            let derivative = function_derivative(self, function, a, &at)?;
            self.derivatives.insert(at, derivative);
        }
        Ok(at)
    }
}

/// The Taylor coefficients of every node of a tape known so far.
#[derive(Clone, Debug)]
pub struct TaylorState<E> {
    coefficients: Vec<Vec<E>>,
    /// The coefficients of f′(u), f″(u), … of each special function f(u).
    towers: FxHashMap<TapeIndex, Vec<Vec<E>>>,
    /// The coefficients of tables and their derivatives, each at a point.
    lookups: LookupSeries<E>,
    order: usize,
}

impl<E: Clone + std::fmt::Debug> TaylorState<E> {
    /// No order known yet.
    pub fn new(tape: &Tape) -> Self {
        Self {
            coefficients: vec![Vec::new(); tape.steps.len()],
            towers: FxHashMap::default(),
            lookups: LookupSeries::default(),
            order: 0,
        }
    }

    /// Computes the coefficients of the next order k (0 at the first call) of all nodes. The k-th coefficient of the
    /// variable xᵢ is `variable(arithmetic, i)`.
    ///
    /// # Errors
    /// Fails with [`AlgebraError`] when a function or quotient has no value at the curve's start. Fails with it, too,
    /// past a limit of the arithmetic.
    pub fn extend<A: Arithmetic<Element = E>>(
        &mut self,
        tape: &Tape,
        arithmetic: &mut A,
        mut variable: impl FnMut(&mut A, usize) -> E,
    ) -> Result<(), AlgebraError> {
        let k = self.order;
        for at in 0..tape.steps.len() {
            let coefficient = match &tape.steps[at] {
                Step::Variable(index) => variable(arithmetic, *index),
                Step::Constant(_) | Step::Pi | Step::Parameter(_) if k > 0 => arithmetic.zero(),
                Step::Constant(c) => arithmetic.constant(c),
                Step::Pi => arithmetic.pi(),
                Step::Parameter(index) => arithmetic.parameter(*index),
                Step::Combination(terms) => {
                    let terms: Vec<_> = terms
                        .iter()
                        .map(|(c, t)| (c.clone(), self.coefficients[*t][k].clone()))
                        .collect();
                    arithmetic.combine(&terms)
                }
                Step::Product(a, b) => self.product(arithmetic, *a, *b, k),
                Step::Quotient(a, b) => {
                    let first = (Rational::one(), self.coefficients[*a][k].clone());
                    let below = &self.coefficients[*b][1..];
                    let products: Vec<_> = (below.iter().zip(self.coefficients[at].iter().rev()))
                        .map(|(bj, g)| (-Rational::one(), bj, g))
                        .collect();
                    let above = arithmetic.combine_products(&[first], &products);
                    arithmetic.divide(&above, &self.coefficients[*b][0])?
                }
                Step::Function(f, u) if k == 0 => {
                    arithmetic.apply(*f, &self.coefficients[*u][0])?
                }
                Step::Power(u, exponent) if k == 0 => {
                    arithmetic.power(&self.coefficients[*u][0], &self.coefficients[*exponent][0])?
                }
                Step::Binary(f, u, v) if k == 0 => arithmetic.apply_two(
                    *f,
                    &self.coefficients[*u][0],
                    &self.coefficients[*v][0],
                )?,
                Step::Binary(_, u, v) => match tape.partials.get(&at) {
                    None => arithmetic.zero(),
                    Some([by_u, by_v]) => {
                        let parts = [(*u, *by_u), (*v, *by_v)]
                            .map(|(u, d)| self.quadrature(arithmetic, u, d, k));
                        let [of_u, of_v] = parts;
                        arithmetic.add(&of_u, &of_v)
                    }
                },
                Step::Lookup(..) if k > 0 && tape.is_constant(at) => arithmetic.zero(),
                Step::Lookup(lookup, point) => {
                    let own = (*lookup, &point[..]);
                    let nodes = &self.coefficients;
                    self.lookups.coefficient(arithmetic, nodes, own, k)?
                }
                Step::Kept(side, c, v) => {
                    arithmetic.kept(*side, &self.coefficients[*c][0], &self.coefficients[*v][k])?
                }
                Step::Function(Function::Special(special, order), u) if !tape.is_constant(*u) => {
                    self.special(arithmetic, (at, *u), (*special, *order), k)?
                }
                Step::Function(_, u) | Step::Power(u, _) => match tape.derivatives.get(&at) {
                    None => arithmetic.zero(),
                    Some(d) => self.quadrature(arithmetic, *u, *d, k),
                },
            };
            self.coefficients[at].push(coefficient);
            if let Some(refusal) = arithmetic.refusal() {
                return Err(refusal.clone());
            }
        }
        self.order += 1;
        Ok(())
    }

    /// The coefficient of order k of a node.
    pub fn coefficient(&self, node: TapeIndex, k: usize) -> &E {
        &self.coefficients[node][k]
    }

    fn product<A: Arithmetic<Element = E>>(
        &self,
        arithmetic: &mut A,
        a: TapeIndex,
        b: TapeIndex,
        k: usize,
    ) -> E {
        let mut products = Vec::with_capacity(k + 1);
        if a == b {
            // u² = Σ_{j<k−j} 2 uⱼ u_{k−j} + u_{k/2}².
            let u = &self.coefficients[a];
            for j in 0..k.div_ceil(2) {
                products.push((Rational::from_integer(2), &u[j], &u[k - j]));
            }
            if k.is_multiple_of(2) {
                products.push((Rational::one(), &u[k / 2], &u[k / 2]));
            }
        } else {
            for j in 0..=k {
                let (x, y) = (&self.coefficients[a][j], &self.coefficients[b][k - j]);
                if !arithmetic.is_zero(x) && !arithmetic.is_zero(y) {
                    products.push((Rational::one(), x, y));
                }
            }
        }
        arithmetic.combine_products(&[], &products)
    }

    /// The coefficient of order k of f(u), f a special function: f⁽ⁱ⁾(u) has one of order k − i by that of f⁽ⁱ⁺¹⁾(u) of an
    /// order lower, from f⁽ᵏ⁾(u₀) on.
    fn special<A: Arithmetic<Element = E>>(
        &mut self,
        arithmetic: &mut A,
        (at, u): (TapeIndex, TapeIndex),
        (special, order): (Special, u8),
        k: usize,
    ) -> Result<E, AlgebraError> {
        let too_high = || AlgebraError::DerivativeTooHigh {
            function: special.name(),
        };
        let highest = u8::try_from(k).ok().and_then(|k| order.checked_add(k));
        let function = Function::Special(special, highest.ok_or_else(too_high)?);
        let first = arithmetic.apply(function, &self.coefficients[u][0])?;
        let mut tower = self.towers.remove(&at).unwrap_or_default();
        tower.push(vec![first]);
        for level in (0..k).rev() {
            let next = self.integral(arithmetic, u, &tower[level], k - level);
            match level {
                0 => {
                    self.towers.insert(at, tower);
                    return Ok(next);
                }
                _ => tower[level - 1].push(next),
            }
        }
        Err(too_high())
    }

    /// (1/k) Σ_{j=1..k} j uⱼ d_{k−j}.
    fn quadrature<A: Arithmetic<Element = E>>(
        &self,
        arithmetic: &mut A,
        u: TapeIndex,
        d: TapeIndex,
        k: usize,
    ) -> E {
        self.integral(arithmetic, u, &self.coefficients[d], k)
    }

    /// The same of given coefficients d.
    fn integral<A: Arithmetic<Element = E>>(
        &self,
        arithmetic: &mut A,
        u: TapeIndex,
        d: &[E],
        k: usize,
    ) -> E {
        let mut products = Vec::with_capacity(k);
        for j in 1..=k {
            let (x, y) = (&self.coefficients[u][j], &d[k - j]);
            if !arithmetic.is_zero(x) && !arithmetic.is_zero(y) {
                products.push((Rational::new(j as i64, k as i64), x, y));
            }
        }
        arithmetic.combine_products(&[], &products)
    }
}
