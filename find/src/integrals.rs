//! First integrals: polynomials in the variables and functions, and products of powers of Darboux polynomials.

use leafwise_expression::algebra::{Symbol, relations};
use leafwise_expression::{Arithmetic, Expression, Function, Polynomial, Rational, Ring};

use crate::candidates::{monomials, symbols_of};
use crate::error::FindError;
use crate::field::RingField;
use crate::potential::combination;

/// An integral with the direction of its gradient: ∇I = `gradient`/`divisor`.
#[derive(Clone, Debug)]
pub(crate) struct Integral {
    pub formula: Expression,
    pub gradient: Vec<Polynomial>,
    pub divisor: Polynomial,
}

impl Integral {
    pub fn of_polynomial(ring: &mut Ring, f: &Polynomial) -> Result<Self, FindError> {
        Ok(Self {
            formula: ring.formula(f),
            gradient: ring.gradient(f)?,
            divisor: ring.one(),
        })
    }
}

/// Variables up to which ln x_i stands beside x_i.
const MOST_LOGARITHMS: usize = 6;

/// A basis of the integrals of degree 1 … `degree`: L_f I = 0 is linear in their coefficients. They are polynomials in the variables, the
/// functions in f, and ln x_i where f_i has the factor x_i.
pub(crate) fn integrals(
    field: &mut RingField,
    degree: usize,
) -> Result<Vec<Polynomial>, FindError> {
    let mut symbols = symbols_of(&mut field.ring, &field.f)?;
    if field.dimension() <= MOST_LOGARITHMS {
        for i in 0..field.dimension() {
            if field.has_factor(i) {
                let x = field.ring.variable(i);
                symbols.extend(field.ring.apply(Function::Ln, &x)?.symbols());
            }
        }
        symbols.sort_unstable();
        symbols.dedup();
    }
    let zero = Polynomial::zero();
    eigen(field, &symbols, degree, &zero)
}

/// A basis of the P of degree 1 … `degree` with L_f P = K P.
fn eigen(
    field: &mut RingField,
    symbols: &[Symbol],
    degree: usize,
    cofactor: &Polynomial,
) -> Result<Vec<Polynomial>, FindError> {
    let functions = monomials(&mut field.ring, symbols, degree)?;
    let mut columns = Vec::with_capacity(functions.len());
    for function in &functions {
        let along = field.along(function)?;
        let product = field.ring.multiply(cofactor, function);
        columns.push(vec![field.ring.subtract(&along, &product)]);
    }
    let solutions = relations(&columns, &[]).solutions();
    let directions = solutions.map_or_else(Vec::new, |s| s.directions);
    let ring = &mut field.ring;
    let mut found: Vec<Polynomial> = (directions.iter())
        .map(|direction| combination(ring, direction, &functions))
        .collect();
    found.sort_by_key(|f| f.terms().len());
    Ok(found)
}

/// Integrals Π Pₖ^nₖ of polynomials with L_f Pₖ = Kₖ Pₖ and Σ nₖ Kₖ = 0. Cofactors K that are tried are multiples of div f, of
/// Σ f_i/x_i where every f_i has the factor x_i, and those of the variables themselves.
pub(crate) fn products(field: &mut RingField, degree: usize) -> Result<Vec<Integral>, FindError> {
    let d = field.dimension();
    let symbols: Vec<Symbol> = (0..d as Symbol).collect();
    let mut darboux: Vec<(Polynomial, Polynomial)> = Vec::new();
    let mut cofactors = Vec::new();
    if let Some(rates) = field.rates() {
        for (i, rate) in rates.iter().enumerate() {
            darboux.push((field.ring.variable(i), rate.clone()));
        }
        cofactors.push(field.ring.combine(&with_one(&rates)));
    }
    let mut slopes = Vec::new();
    for (i, f) in field.f.iter().enumerate() {
        slopes.push(field.ring.derivative(f, i)?);
    }
    cofactors.push(field.ring.combine(&with_one(&slopes)));
    cofactors.retain(|cofactor| !cofactor.is_zero());
    for cofactor in &cofactors {
        for ratio in [(1, 3), (1, 2), (2, 3), (1, 1)] {
            let cofactor = field.ring.scale(&Rational::new(ratio.0, ratio.1), cofactor);
            for polynomial in eigen(field, &symbols, degree, &cofactor)? {
                // A monomial is a product of variables, which are there.
                if polynomial.terms().len() > 1 {
                    darboux.push((polynomial, cofactor.clone()));
                }
            }
        }
    }
    let columns: Vec<Vec<Polynomial>> = darboux.iter().map(|(_, k)| vec![k.clone()]).collect();
    let solutions = relations(&columns, &[]).solutions();
    let directions = solutions.map_or_else(Vec::new, |s| s.directions);
    let factors: Vec<Polynomial> = darboux.into_iter().map(|(p, _)| p).collect();
    let mut found = Vec::new();
    for direction in directions {
        if let Some(integral) = power_product(&mut field.ring, &factors, &direction)? {
            found.push(integral);
        }
    }
    Ok(found)
}

fn with_one(parts: &[Polynomial]) -> Vec<(Rational, Polynomial)> {
    let parts = parts.iter();
    parts.map(|part| (Rational::one(), part.clone())).collect()
}

/// Π Pₖ^nₖ with integers nₖ in the ratio of `exponents`: ∇ ln I = Σ nₖ ∇Pₖ/Pₖ.
fn power_product(
    ring: &mut Ring,
    factors: &[Polynomial],
    exponents: &[Rational],
) -> Result<Option<Integral>, FindError> {
    let scale = exponents.iter().fold(Rational::one(), |scale, exponent| {
        &scale * &Rational::from((exponent * &scale).denominator())
    });
    let mut chosen = Vec::new();
    for (factor, exponent) in factors.iter().zip(exponents) {
        let Some(power) = (exponent * &scale).to_i64() else {
            return Ok(None);
        };
        if power != 0 {
            chosen.push((factor, power));
        }
    }
    let Some(&(_, first)) = chosen.first() else {
        return Ok(None);
    };
    let sign = first.signum();
    let d = ring.variables();
    // Σ nₖ ∇Pₖ Π_{l ≠ k} P_l over Π P_l, times I = Π Pₖ^nₖ.
    let mut gradient = vec![Polynomial::zero(); d];
    for &(factor, power) in &chosen {
        let mut others = ring.constant(&Rational::from_integer(sign * power));
        for &(other, _) in &chosen {
            if other != factor {
                others = ring.multiply(&others, other);
            }
        }
        for (i, slope) in gradient.iter_mut().enumerate() {
            let derivative = ring.derivative(factor, i)?;
            let part = ring.multiply(&others, &derivative);
            *slope = ring.add(slope, &part);
        }
    }
    // I = A/B; ∇I = gradient · Π P^(n−1) = gradient · Π_{n>1} P^(n−1) / Π_{n<0} P^(1−n), where n = 1 leaves nothing.
    let (mut above, mut below) = (Vec::new(), Vec::new());
    let mut divisor = ring.one();
    for &(factor, power) in &chosen {
        let power = sign * power;
        let whole = power_formula(ring, factor, power.unsigned_abs());
        match power > 0 {
            true => above.push(whole),
            false => below.push(whole),
        }
        for _ in 0..(1 - power).max(0) {
            divisor = ring.multiply(&divisor, factor);
        }
        for _ in 0..(power - 1).max(0) {
            for slope in &mut gradient {
                *slope = ring.multiply(slope, factor);
            }
        }
    }
    let formula = match below.is_empty() {
        true => Expression::Product(above),
        false => Expression::Quotient(
            Box::new(Expression::Product(above)),
            Box::new(Expression::Product(below)),
        ),
    };
    Ok(Some(Integral {
        formula,
        gradient,
        divisor,
    }))
}

fn power_formula(ring: &Ring, factor: &Polynomial, power: u64) -> Expression {
    let base = ring.formula(factor);
    match i64::try_from(power) {
        Ok(1) | Err(_) => base,
        Ok(power) => Expression::Power(
            Box::new(base),
            Box::new(Expression::Constant(Rational::from_integer(power))),
        ),
    }
}
