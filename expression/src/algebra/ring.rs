//! The differential ring in which Hamilton–Jacobi coefficients are computed exactly.

use rustc_hash::FxHashMap;

use super::generator::{Atom, Generator};
use super::monomial::{Monomial, Symbol};
use super::packed;
use super::polynomial::{Coefficient, CoefficientRing, Polynomial};
use crate::arithmetic::{
    AlgebraError, Arithmetic, binary_derivative, function_derivative, simple_value,
    simple_value_of_two,
};
use crate::expression::{Binary, Function, Side};
use crate::function::Parity;
use crate::rational::Rational;
use crate::reach::Reach;
use crate::table::Lookup;

/// ℚ(parameters)[x₁^±, …, x_d^±, generators]: Laurent polynomials in the state variables and in
/// adjoined functions of the state ([`Generator`]), closed under ∂/∂xᵢ.
///
/// Sums are collected, so cancellation is exact and zero is recognized wherever the generators'
/// relations decide it. What they do not decide is not refused: it stays a sum of terms.
#[derive(Clone, Debug)]
pub struct Ring {
    variables: usize,
    generators: Vec<Generator>,
    /// The variables that each generator depends on.
    reaches: Vec<Reach>,
    /// Whether each generator has a value at every state.
    are_everywhere: Vec<bool>,
    pub(super) symbols: FxHashMap<Generator, Symbol>,
    atoms: Vec<Atom>,
    atom_symbols: FxHashMap<Atom, Symbol>,
    derivatives: FxHashMap<(Symbol, usize), Polynomial>,
    pub(super) has_relations: bool,
    /// Products of terms that may still be formed.
    remaining: u64,
    /// The limit that was reached.
    refusal: Option<AlgebraError>,
}

/// Products of terms that any ring may form: a minute where they are formed one by one.
const MOST_PRODUCTS: u64 = 1 << 28;

/// The largest size of an exponent: sums of a few of them fit a machine word.
pub(super) const LARGEST_EXPONENT: u32 = 32_767;

impl Ring {
    /// The ring over `variables` state variables, with no generator yet. It forms 2²⁸ products of terms
    /// at most, then refuses.
    pub fn new(variables: usize) -> Self {
        Self {
            variables,
            generators: Vec::new(),
            reaches: Vec::new(),
            are_everywhere: Vec::new(),
            symbols: FxHashMap::default(),
            atoms: Vec::new(),
            atom_symbols: FxHashMap::default(),
            derivatives: FxHashMap::default(),
            has_relations: false,
            remaining: MOST_PRODUCTS,
            refusal: None,
        }
    }

    /// The same for at most `products` products of terms. Once they are spent every further product
    /// is 0, so that a computation that grows too long soon ends: who sets a limit asks
    /// [`refusal`](Self::refusal) before taking a result.
    pub fn limited(variables: usize, products: u64) -> Self {
        Self {
            remaining: products,
            ..Self::new(variables)
        }
    }

    /// Allows at most `products` further products of terms, whatever was refused before.
    pub fn allow(&mut self, products: u64) {
        self.remaining = products;
        self.refusal = None;
    }

    /// Whether so many products of terms may be formed; none may after a refusal.
    pub(super) fn spend(&mut self, products: usize) -> bool {
        self.remaining = self.remaining.saturating_sub(products as u64);
        if self.remaining == 0 {
            self.refuse(AlgebraError::ExpansionTooLong);
        }
        self.refusal.is_none()
    }

    /// Whether exponents of this size may occur; none may after a refusal.
    pub(super) fn admits(&mut self, exponent: u32) -> bool {
        if exponent > LARGEST_EXPONENT {
            self.refuse(AlgebraError::ExpandedExponent);
        }
        self.refusal.is_none()
    }

    fn refuse(&mut self, reason: AlgebraError) {
        self.refusal.get_or_insert(reason);
    }

    /// `result`, unless a limit was reached on the way to it.
    fn unless_refused<T>(&self, result: T) -> Result<T, AlgebraError> {
        match &self.refusal {
            None => Ok(result),
            Some(reason) => Err(reason.clone()),
        }
    }

    /// The number d of state variables.
    pub fn variables(&self) -> usize {
        self.variables
    }

    /// The variable xᵢ.
    pub fn variable(&self, index: usize) -> Polynomial {
        debug_assert!(index < self.variables);
        Polynomial::symbol(index as Symbol)
    }

    /// The generator behind a symbol, `None` for a variable.
    pub fn generator(&self, symbol: Symbol) -> Option<&Generator> {
        (symbol as usize)
            .checked_sub(self.variables)
            .map(|at| &self.generators[at])
    }

    /// The constant behind a symbol of a [`Coefficient`].
    pub fn atom(&self, symbol: Symbol) -> &Atom {
        &self.atoms[symbol as usize]
    }

    fn adjoin(&mut self, generator: Generator) -> Symbol {
        if let Some(&symbol) = self.symbols.get(&generator) {
            return symbol;
        }
        let symbol = Symbol::try_from(self.variables + self.generators.len())
            .expect("fewer than 2^32 symbols");
        self.has_relations |= matches!(
            generator,
            Generator::Inverse(_)
                | Generator::Root(..)
                | Generator::Kept(..)
                | Generator::Function(Function::Cos | Function::Cosh, _)
        );
        let reaches: Vec<Reach> = generator.arguments().map(|u| self.reach_of(u)).collect();
        let reach = Reach::union(&reaches);
        self.are_everywhere
            .push(self.has_value_everywhere(&generator));
        self.symbols.insert(generator.clone(), symbol);
        self.generators.push(generator);
        self.reaches.push(reach);
        symbol
    }

    fn atom_symbol(&mut self, atom: Atom) -> Coefficient {
        let next = Symbol::try_from(self.atoms.len()).expect("fewer than 2^32 constants");
        let symbol = *self.atom_symbols.entry(atom.clone()).or_insert(next);
        if symbol == next {
            self.atoms.push(atom);
        }
        Coefficient::symbol(symbol)
    }

    /// The variables that a polynomial depends on.
    fn reach_of(&self, f: &Polynomial) -> Reach {
        let symbols = f.terms().iter().flat_map(|(m, _)| m.factors());
        let reaches: Vec<Reach> = symbols
            .map(
                |&(symbol, _)| match (symbol as usize).checked_sub(self.variables) {
                    None => Reach::variable(symbol),
                    Some(at) => self.reaches[at].clone(),
                },
            )
            .collect();
        Reach::union(&reaches)
    }

    /// ∂f/∂x_v.
    ///
    /// # Errors
    /// [`AlgebraError`] when a generator's derivative does not exist, such as that of 1/0, or past a
    /// limit of the ring.
    pub fn derivative(
        &mut self,
        f: &Polynomial,
        variable: usize,
    ) -> Result<Polynomial, AlgebraError> {
        let mut parts = Vec::new();
        let mut plain = Vec::new();
        for (monomial, coefficient) in f.terms() {
            for &(symbol, exponent) in monomial.factors() {
                let rest = || monomial.shifted(symbol, -1);
                let factor = || coefficient.scaled(&Rational::from_integer(exponent.into()));
                if symbol as usize == variable {
                    plain.push((rest(), factor()));
                } else if (symbol as usize)
                    .checked_sub(self.variables)
                    .is_some_and(|at| self.reaches[at].may_contain(variable as u32))
                {
                    let inner = self.generator_derivative(symbol, variable)?;
                    if !inner.is_zero() {
                        self.spend(inner.terms().len());
                        parts.push((Rational::one(), self.times_term(&inner, &rest(), &factor())));
                    }
                }
            }
        }
        let mut sum = Polynomial::sorted(plain);
        if !parts.is_empty() {
            parts.push((Rational::one(), sum));
            sum = self.combine(&parts);
        }
        let sum = self.normalize(sum);
        self.unless_refused(sum)
    }

    /// f·(c·m), 0 after a refusal.
    pub(super) fn times_term(
        &mut self,
        f: &Polynomial,
        m: &Monomial,
        c: &Coefficient,
    ) -> Polynomial {
        let exponent = f.largest_exponent() + m.largest_exponent().max(c.largest_exponent());
        if !self.admits(exponent) {
            return Polynomial::zero();
        }
        f.times_term(m, c)
    }

    /// ∇f.
    ///
    /// # Errors
    /// Those of [`Ring::derivative`].
    pub fn gradient(&mut self, f: &Polynomial) -> Result<Vec<Polynomial>, AlgebraError> {
        (0..self.variables).map(|v| self.derivative(f, v)).collect()
    }

    fn generator_derivative(
        &mut self,
        symbol: Symbol,
        variable: usize,
    ) -> Result<Polynomial, AlgebraError> {
        if let Some(known) = self.derivatives.get(&(symbol, variable)) {
            return Ok(known.clone());
        }
        let generator = self.generators[symbol as usize - self.variables].clone();
        if let Generator::Kept(side, u, v) = &generator {
            let inner = self.derivative(v, variable)?;
            let result = self.kept(*side, u, &inner)?;
            self.derivatives.insert((symbol, variable), result.clone());
            return Ok(result);
        }
        if let Generator::Binary(function, u, v) = &generator {
            let mut parts = Vec::with_capacity(2);
            for (by, argument) in [u, v].into_iter().enumerate() {
                let inner = self.derivative(argument, variable)?;
                if !inner.is_zero() {
                    let outer = binary_derivative(self, *function, [u, v], by)?;
                    parts.push((Rational::one(), self.multiply(&outer, &inner)));
                }
            }
            let result = self.combine(&parts);
            self.derivatives.insert((symbol, variable), result.clone());
            return Ok(result);
        }
        if let Generator::Lookup(lookup, point) = &generator {
            let mut sum = Vec::with_capacity(point.len());
            for (axis, u) in point.iter().enumerate() {
                let inner = self.derivative(u, variable)?;
                if let Some(slope) = lookup.derivative(axis).filter(|_| !inner.is_zero()) {
                    let outer = self.look_up(slope, point)?;
                    sum.push((Rational::one(), self.multiply(&outer, &inner)));
                }
            }
            let result = self.combine(&sum);
            self.derivatives.insert((symbol, variable), result.clone());
            return Ok(result);
        }
        let inner = self.derivative(generator.argument(), variable)?;
        let result = if inner.is_zero() {
            Polynomial::zero()
        } else {
            let g = Polynomial::symbol(symbol);
            let outer = match &generator {
                Generator::Inverse(_) => {
                    let square = self.multiply(&g, &g);
                    self.negate(&square)
                }
                Generator::Root(u, q) => {
                    let quotient = self.divide(&g, u)?;
                    self.scale(&Rational::new(1, i64::from(*q)), &quotient)
                }
                Generator::Power(u, exponent) => {
                    let quotient = self.divide(&g, u)?;
                    quotient.times_term(&Monomial::one(), exponent)
                }
                Generator::Function(function, u) => function_derivative(self, *function, u, &g)?,
                // Differentiated above.
                Generator::Kept(..) | Generator::Binary(..) | Generator::Lookup(..) => {
                    Polynomial::zero()
                }
            };
            self.multiply(&outer, &inner)
        };
        self.derivatives.insert((symbol, variable), result.clone());
        Ok(result)
    }

    /// 1/c in the field of the parameters.
    fn coefficient_inverse(&mut self, c: &Coefficient) -> Result<Coefficient, AlgebraError> {
        match c.terms() {
            [] => Err(AlgebraError::DivisionByZero),
            [(m, r)] => Ok(Coefficient::term(m.inverse(), r.recip())),
            _ => Ok(self.atom_symbol(Atom::Inverse(c.clone()))),
        }
    }

    /// 1/f: an inverse monomial, or a Laurent monomial times an adjoined inverse of a primitive
    /// polynomial, its powers ≥ 0, with leading coefficient 1.
    fn inverse(&mut self, f: &Polynomial) -> Result<Polynomial, AlgebraError> {
        self.unless_refused(())?;
        let content = f.content();
        let Some((leading, coefficient)) = f.leading() else {
            return Err(AlgebraError::DivisionByZero);
        };
        let unit = self.coefficient_inverse(coefficient)?;
        let outer = self.inverse_monomial(&content, unit.clone())?;
        if f.terms().len() == 1 {
            return self.unless_refused(outer);
        }
        // The leading coefficient is 1 by construction; where the parameters' inverse is an opaque
        // constant the product does not collapse by itself, so it is set.
        let below = content.inverse();
        let leading = leading.multiply(&below);
        let scaled = self.times_term(f, &below, &unit);
        let others = scaled.terms().iter().filter(|(m, _)| *m != leading);
        let primitive = Polynomial::collect(others.cloned().chain([(leading.clone(), one())]));
        let inverse = Polynomial::symbol(self.adjoin(Generator::Inverse(primitive)));
        let inverse = self.multiply(&outer, &inverse);
        self.unless_refused(inverse)
    }

    /// unit / content, where factors that are roots, inverses, cosines or hyperbolic cosines go
    /// through their relations rather than to negative exponents.
    fn inverse_monomial(
        &mut self,
        content: &Monomial,
        unit: Coefficient,
    ) -> Result<Polynomial, AlgebraError> {
        let mut plain = Monomial::one();
        let mut factors = Vec::new();
        for &(symbol, exponent) in content.factors() {
            match self.generator(symbol).cloned() {
                Some(Generator::Root(u, q)) => {
                    // 1/g^e = g^(q−e)/u.
                    let below = self.inverse(&u)?;
                    let above =
                        Polynomial::term(Monomial::power(symbol, i32::from(q) - exponent), one());
                    factors.push(self.multiply(&above, &below));
                }
                Some(Generator::Inverse(u)) => {
                    factors.push(self.integer_power(&u, exponent.into())?);
                }
                Some(Generator::Function(Function::Cos | Function::Cosh, _)) => {
                    let base = Polynomial::symbol(symbol);
                    // A single cosine: 1/cos is adjoined as a generator of its own.
                    let inverse = Polynomial::symbol(self.adjoin(Generator::Inverse(base)));
                    factors.push(self.integer_power(&inverse, exponent.into())?);
                }
                Some(Generator::Kept(..)) => {
                    // 1/g has no value where g is 0, which it is on one side: it cancels nothing.
                    let base = Polynomial::symbol(symbol);
                    let minus = Coefficient::from_rational(&Rational::from_integer(-1));
                    let inverse = Polynomial::symbol(self.adjoin(Generator::Power(base, minus)));
                    factors.push(self.integer_power(&inverse, exponent.into())?);
                }
                _ => plain = plain.shifted(symbol, -exponent),
            }
        }
        let mut result = Polynomial::term(plain, unit);
        for factor in factors {
            result = self.multiply(&result, &factor);
        }
        Ok(result)
    }

    /// Whether a symbol has a value at every state.
    fn is_everywhere(&self, symbol: Symbol) -> bool {
        let generator = (symbol as usize).checked_sub(self.variables);
        generator.is_none_or(|at| self.are_everywhere[at])
    }

    /// Whether a constant has a value whatever the parameters are.
    fn is_plain(&self, atom: Symbol) -> bool {
        matches!(self.atom(atom), Atom::Parameter(_) | Atom::Pi)
    }

    /// Whether a generator has a value at every state: 1 on a side of what has one.
    fn has_value_everywhere(&self, generator: &Generator) -> bool {
        let Generator::Kept(_, c, value) = generator else {
            return false;
        };
        let mut factors = c.terms().iter().flat_map(|(m, _)| m.factors());
        let constants = c.terms().iter().flat_map(|(_, c)| c.terms());
        let mut atoms = constants.flat_map(|(m, _)| m.factors());
        *value == Polynomial::constant(one())
            && factors.all(|&(symbol, exponent)| exponent > 0 && self.is_everywhere(symbol))
            && atoms.all(|&(atom, exponent)| exponent > 0 && self.is_plain(atom))
    }

    /// v where c is of this side, of a v that stands behind the seam as a whole.
    fn kept_inside(&mut self, side: Side, c: &Polynomial, v: Polynomial) -> Polynomial {
        let one = Polynomial::constant(one());
        if v == one && side == Side::Below {
            // 1 − g of the other side.
            let above = self.adjoin(Generator::Kept(Side::Above, c.clone(), one.clone()));
            return self.subtract(&one, &Polynomial::symbol(above));
        }
        Polynomial::symbol(self.adjoin(Generator::Kept(side, c.clone(), v)))
    }

    fn constant_function(
        &mut self,
        function: Function,
        c: &Coefficient,
    ) -> Result<Coefficient, AlgebraError> {
        if let Some(value) = c.as_constant() {
            let is_outside = match function {
                Function::Ln | Function::Log10 | Function::Log2 | Function::Sqrt => {
                    value.is_negative()
                }
                _ => false,
            };
            if is_outside {
                return Err(AlgebraError::OutsideDomain {
                    function: function.name(),
                    argument: value.to_string(),
                });
            }
            if let Some(simple) = simple_value(function, &value)? {
                return Ok(Coefficient::constant(simple));
            }
        }
        if function == Function::Sqrt {
            return Ok(self.atom_symbol(Atom::RationalPower(c.clone(), Rational::new(1, 2))));
        }
        Ok(self.atom_symbol(Atom::Function(function, c.clone())))
    }

    fn rational_power(
        &mut self,
        f: &Polynomial,
        exponent: &Rational,
    ) -> Result<Polynomial, AlgebraError> {
        if let Some(integer) = exponent.to_i64() {
            return self.integer_power(f, integer);
        }
        let too_large = || AlgebraError::ExponentTooLarge {
            exponent: exponent.to_string(),
        };
        if f.is_zero() {
            return if exponent.is_negative() {
                Err(AlgebraError::DivisionByZero)
            } else {
                Ok(Polynomial::zero())
            };
        }
        if let Some(c) = f.as_constant() {
            let atom = self.atom_symbol(Atom::RationalPower(c, exponent.clone()));
            return Ok(Polynomial::constant(atom));
        }
        let q = i64::try_from(exponent.denominator()).map_err(|_| too_large())?;
        let p = i64::try_from(exponent.numerator()).map_err(|_| too_large())?;
        if q > 4096 {
            return Err(too_large());
        }
        // f^(p/q) = f^w g^r with p = w q + r, 0 ≤ r < q.
        let (whole, rest) = (p.div_euclid(q), p.rem_euclid(q));
        let root = self.adjoin(Generator::Root(f.clone(), q as u16));
        let integer = self.integer_power(f, whole)?;
        let fraction = Polynomial::term(Monomial::power(root, rest as i32), one());
        let power = self.multiply(&integer, &fraction);
        self.unless_refused(power)
    }
}

/// A product as two: of the powers that have a value everywhere, and of the others.
fn split(product: &Monomial, is_everywhere: impl Fn(Symbol) -> bool) -> (Monomial, Monomial) {
    let (mut outside, mut inside) = (Monomial::one(), Monomial::one());
    for &(symbol, exponent) in product.factors() {
        let part = if exponent > 0 && is_everywhere(symbol) {
            &mut outside
        } else {
            &mut inside
        };
        *part = part.shifted(symbol, exponent);
    }
    (outside, inside)
}

fn one() -> Coefficient {
    Coefficient::from_rational(&Rational::one())
}

/// Whether the leading term's leading rational coefficient is negative: the sign that odd and even
/// functions pull out of their argument.
fn has_negative_lead(f: &Polynomial) -> bool {
    f.terms()
        .last()
        .and_then(|(_, c)| c.terms().last())
        .is_some_and(|(_, r)| r.is_negative())
}

impl Arithmetic for Ring {
    type Element = Polynomial;

    fn constant(&mut self, value: &Rational) -> Polynomial {
        Polynomial::constant(Coefficient::from_rational(value))
    }

    fn pi(&mut self) -> Polynomial {
        Polynomial::constant(self.atom_symbol(Atom::Pi))
    }

    fn parameter(&mut self, index: usize) -> Polynomial {
        Polynomial::constant(self.atom_symbol(Atom::Parameter(index)))
    }

    fn is_zero(&self, element: &Polynomial) -> bool {
        element.is_zero()
    }

    fn refusal(&self) -> Option<&AlgebraError> {
        self.refusal.as_ref()
    }

    fn as_rational(&self, element: &Polynomial) -> Option<Rational> {
        element.as_constant().and_then(|c| c.as_constant())
    }

    fn is_expanded(&self) -> bool {
        true
    }

    fn combine(&mut self, terms: &[(Rational, Polynomial)]) -> Polynomial {
        let one = Polynomial::constant(one());
        let products: Vec<_> = terms.iter().map(|(c, f)| (c.clone(), f, &one)).collect();
        packed::sum_of_products(&products).unwrap_or_else(|| Polynomial::combine(terms))
    }

    fn multiply(&mut self, a: &Polynomial, b: &Polynomial) -> Polynomial {
        self.sum_of_products(&[(Rational::one(), a, b)])
    }

    fn sum_of_products(&mut self, terms: &[(Rational, &Polynomial, &Polynomial)]) -> Polynomial {
        for (_, a, b) in terms {
            let may = self.admits(a.largest_exponent() + b.largest_exponent());
            if !may || !self.spend(a.terms().len() * b.terms().len()) {
                return Polynomial::zero();
            }
        }
        let sum = packed::sum_of_products(terms).unwrap_or_else(|| {
            let products = terms.iter().map(|(c, a, b)| (c.clone(), a.product(b)));
            Polynomial::combine(&products.collect::<Vec<_>>())
        });
        self.normalize(sum)
    }

    fn divide(&mut self, a: &Polynomial, b: &Polynomial) -> Result<Polynomial, AlgebraError> {
        let inverse = self.inverse(b)?;
        let quotient = self.multiply(a, &inverse);
        self.unless_refused(quotient)
    }

    fn power(&mut self, a: &Polynomial, b: &Polynomial) -> Result<Polynomial, AlgebraError> {
        let exponent = b.as_constant().ok_or(AlgebraError::VariableExponent)?;
        if let Some(rational) = exponent.as_constant() {
            return self.rational_power(a, &rational);
        }
        // a^(c + k) = a^c a^k for the integer part k of the exponent's rational term.
        let whole = exponent
            .terms()
            .iter()
            .find(|(m, _)| m.is_one())
            .and_then(|(_, r)| if r.is_integer() { r.to_i64() } else { None })
            .unwrap_or(0);
        let fraction = Coefficient::combine(&[
            (Rational::one(), exponent),
            (Rational::from_integer(-whole), one()),
        ]);
        let integer = self.integer_power(a, whole)?;
        let power = match a.as_constant() {
            Some(c) => Polynomial::constant(self.atom_symbol(Atom::Power(c, fraction))),
            None => Polynomial::symbol(self.adjoin(Generator::Power(a.clone(), fraction))),
        };
        let power = self.multiply(&integer, &power);
        self.unless_refused(power)
    }

    fn apply_two(
        &mut self,
        function: Binary,
        a: &Polynomial,
        b: &Polynomial,
    ) -> Result<Polynomial, AlgebraError> {
        if let (Some(x), Some(y)) = (self.as_rational(a), self.as_rational(b))
            && let Some(simple) = simple_value_of_two(function, &x, &y)?
        {
            return Ok(self.constant(&simple));
        }
        if let (Some(c), Some(d)) = (a.as_constant(), b.as_constant()) {
            return Ok(Polynomial::constant(
                self.atom_symbol(Atom::Binary(function, c, d)),
            ));
        }
        let generator = Generator::Binary(function, a.clone(), b.clone());
        Ok(Polynomial::symbol(self.adjoin(generator)))
    }
    fn look_up(
        &mut self,
        lookup: Lookup,
        point: &[Polynomial],
    ) -> Result<Polynomial, AlgebraError> {
        let constants: Option<Vec<_>> = point.iter().map(Polynomial::as_constant).collect();
        Ok(match constants {
            Some(point) => Polynomial::constant(self.atom_symbol(Atom::Lookup(lookup, point))),
            None => Polynomial::symbol(self.adjoin(Generator::Lookup(lookup, point.to_vec()))),
        })
    }

    /// Linear in v, whose factors that have a value everywhere stand outside.
    fn kept(
        &mut self,
        side: Side,
        c: &Polynomial,
        v: &Polynomial,
    ) -> Result<Polynomial, AlgebraError> {
        if let Some(number) = self.as_rational(c) {
            return Ok(match side.has(&number) {
                true => v.clone(),
                false => Polynomial::zero(),
            });
        }
        let mut parts = Vec::with_capacity(v.terms().len());
        for (monomial, coefficient) in v.terms() {
            let (outside, inside) = split(monomial, |symbol| self.is_everywhere(symbol));
            for (constants, number) in coefficient.terms() {
                let (known, unsure) = split(constants, |symbol| self.is_plain(symbol));
                let outside =
                    Polynomial::term(outside.clone(), Coefficient::term(known, number.clone()));
                let inside =
                    Polynomial::term(inside.clone(), Coefficient::term(unsure, Rational::one()));
                let part = self.kept_inside(side, c, inside);
                parts.push((Rational::one(), self.multiply(&outside, &part)));
            }
        }
        let sum = self.combine(&parts);
        self.unless_refused(sum)
    }

    fn apply(&mut self, function: Function, a: &Polynomial) -> Result<Polynomial, AlgebraError> {
        if let Some(c) = a.as_constant() {
            return Ok(Polynomial::constant(self.constant_function(function, &c)?));
        }
        if function == Function::Sqrt {
            return self.rational_power(a, &Rational::new(1, 2));
        }
        let parity = function.parity();
        if (parity.is_some() || function == Function::Exp) && has_negative_lead(a) {
            let positive = a.scaled(&-Rational::one());
            let value = self.apply(function, &positive)?;
            return match parity {
                Some(Parity::Even) => Ok(value),
                Some(Parity::Odd) => Ok(self.negate(&value)),
                None => self.inverse(&value),
            };
        }
        // The partner of a cosine stands in its relation.
        match function {
            Function::Cos => drop(self.adjoin(Generator::Function(Function::Sin, a.clone()))),
            Function::Cosh => drop(self.adjoin(Generator::Function(Function::Sinh, a.clone()))),
            _ => {}
        }
        Ok(Polynomial::symbol(
            self.adjoin(Generator::Function(function, a.clone())),
        ))
    }
}
