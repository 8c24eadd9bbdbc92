//! Structure constants, of a system's tensor and of quadratic forms.

use std::collections::BTreeMap;

use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};

use crate::forms::{Forms, product, sum};

/// The nonzero c_k of one bracket.
pub type Row = BTreeMap<usize, Rational>;

/// c_ij^k as rational numbers: {x_i, x_j} = Σ_k c_ij^k x_k.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants {
    dimension: usize,
    rows: Vec<Row>,
}

impl Constants {
    /// None but 0.
    pub fn zero(dimension: usize) -> Self {
        Self {
            dimension,
            rows: vec![Row::new(); dimension * dimension],
        }
    }

    /// d.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The c_k of {x_i, x_j}.
    pub fn bracket(&self, i: usize, j: usize) -> &Row {
        &self.rows[i * self.dimension + j]
    }

    fn set(&mut self, i: usize, j: usize, row: Row) {
        let opposite = row.iter().map(|(k, c)| (*k, -c)).collect();
        self.rows[i * self.dimension + j] = row;
        self.rows[j * self.dimension + i] = opposite;
    }

    /// Those of forms under {z_a, z_b} = Ω_ab; `None` where brackets are no sums of the forms.
    pub fn of_forms(forms: &Forms, omega: &[Rational]) -> Option<Self> {
        let (n, d) = (forms.coordinates(), forms.count());
        let matrices: Vec<_> = (0..d).map(|k| forms.matrix(k)).collect();
        let basis = Basis::of(&matrices)?;
        let mut constants = Self::zero(d);
        for i in 0..d {
            for j in i + 1..d {
                let bracket = form_bracket(n, &matrices[i], &matrices[j], omega);
                constants.set(i, j, basis.coefficients(&bracket)?);
            }
        }
        Some(constants)
    }
}

/// S_i Ω S_j − S_j Ω S_i, the form of {x_i, x_j}.
pub fn form_bracket(n: usize, s: &[Rational], t: &[Rational], omega: &[Rational]) -> Vec<Rational> {
    let forward = product(n, &product(n, s, omega), t);
    let backward = product(n, &product(n, t, omega), s);
    sum(&forward, &backward, &-Rational::one())
}

/// Vectors that are independent, reduced: each with a pivot where all others are 0.
struct Basis {
    /// Reduced vectors, with what they are of the given ones.
    reduced: Vec<(usize, Vec<Rational>, Vec<Rational>)>,
}

impl Basis {
    /// `None` where the vectors depend on one another.
    fn of(vectors: &[Vec<Rational>]) -> Option<Self> {
        let mut basis = Self {
            reduced: Vec::new(),
        };
        for (k, vector) in vectors.iter().enumerate() {
            let mut own = vec![Rational::from_integer(0); vectors.len()];
            own[k] = Rational::one();
            let mut vector = vector.clone();
            for (pivot, other, parts) in &basis.reduced {
                let factor = -&vector[*pivot];
                vector = sum(&vector, other, &factor);
                own = sum(&own, parts, &factor);
            }
            let pivot = vector.iter().position(|v| !v.is_zero())?;
            let scale = vector[pivot].recip();
            let scaled = |v: &[Rational]| v.iter().map(|v| v * &scale).collect::<Vec<_>>();
            let (vector, own) = (scaled(&vector), scaled(&own));
            for (_, other, parts) in &mut basis.reduced {
                let factor = -&other[pivot];
                *other = sum(other, &vector, &factor);
                *parts = sum(parts, &own, &factor);
            }
            basis.reduced.push((pivot, vector, own));
        }
        Some(basis)
    }

    /// Coefficients of a vector as a combination of the given vectors, those that are not 0; `None` where it is no
    /// combination of them.
    fn coefficients(&self, vector: &[Rational]) -> Option<Row> {
        let mut rest = vector.to_vec();
        let mut found = vec![Rational::from_integer(0); self.reduced.len()];
        for (pivot, own, parts) in &self.reduced {
            let factor = rest[*pivot].clone();
            rest = sum(&rest, own, &-&factor);
            found = sum(&found, parts, &factor);
        }
        if rest.iter().any(|v| !v.is_zero()) {
            return None;
        }
        let found = found.into_iter().enumerate();
        Some(found.filter(|(_, c)| !c.is_zero()).collect())
    }
}

/// The constants of a linear tensor, in units of a function λ of the parameters.
#[derive(Clone, Debug)]
pub struct LinearTensor {
    /// The ring that λ is of.
    pub ring: Ring,
    /// λ.
    pub unit: Polynomial,
    /// c_ij^k / λ.
    pub constants: Constants,
}

impl LinearTensor {
    /// Those of a system's tensor; λ is 1 where all are numbers. What else it is, in words, where it is not linear or its
    /// constants are not multiples of one another.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an entry has no normal form.
    pub fn of(system: &SystemFormulas) -> Result<Result<Self, String>, BuildError> {
        let d = system.dimension();
        let mut ring = Ring::new(d);
        let mut found: Vec<([usize; 3], Polynomial)> = Vec::new();
        for (&(i, j), entry) in system.tensor() {
            let value = entry.evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))?;
            let name = || {
                let [first, second] = [i, j].map(|at| &system.variables()[at]);
                format!("{{{first}, {second}}}")
            };
            for (monomial, coefficient) in value.terms() {
                match monomial.factors() {
                    &[(symbol, 1)] if ring.generator(symbol).is_none() => {
                        let c = Polynomial::constant(coefficient.clone());
                        found.push(([i, j, symbol as usize], c));
                    }
                    _ => return Ok(Err(format!("{} is not linear in the variables", name()))),
                }
            }
        }
        let numbers = found.iter().all(|(_, c)| ring.as_rational(c).is_some());
        let unit = match found.first() {
            Some((_, first)) if !numbers => first.clone(),
            _ => ring.one(),
        };
        let mut rows = vec![Row::new(); d * d];
        for ([i, j, k], c) in found {
            let ratio = ring.divide(&c, &unit)?;
            let Some(ratio) = ring.as_rational(&ratio) else {
                let [i, j] = [i, j].map(|at| &system.variables()[at]);
                return Ok(Err(format!(
                    "{{{i}, {j}}} is not a rational multiple of the other brackets"
                )));
            };
            if !ratio.is_zero() {
                rows[i * d + j].insert(k, ratio);
            }
        }
        let mut constants = Constants::zero(d);
        for i in 0..d {
            for j in i + 1..d {
                constants.set(i, j, std::mem::take(&mut rows[i * d + j]));
            }
        }
        Ok(Ok(Self {
            ring,
            unit,
            constants,
        }))
    }
}
