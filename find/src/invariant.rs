//! Affine tensors that the motion carries along: L_f J = 0, linear in the coefficients of J, whatever H is.
//!
//! Every Hamiltonian field preserves its tensor. Of most equations few tensors are left, and none is a proof that no affine bracket exists.

use std::collections::BTreeMap;

use leafwise_expression::algebra::Monomial;
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational};

use crate::constant::pairs;
use crate::field::RingField;
use crate::modular::{Row, null_space};

/// A basis of the J_ij = c_ij0 + Σ_k c_ijk x_k with L_f J = 0. Coefficients stand in the order of the pairs i < j, those of a pair together, the
/// constant first. `None` where fractions are too long.
pub(crate) fn invariant_tensors(
    field: &mut RingField,
) -> Result<Option<Vec<Vec<Rational>>>, AlgebraError> {
    let columns = columns(field)?;
    let mut rows: BTreeMap<(usize, &Monomial, &Monomial), Row> = BTreeMap::new();
    for (at, column) in columns.iter().enumerate() {
        for (component, element) in column.iter().enumerate() {
            for (monomial, coefficient) in element.terms() {
                for (constant, number) in coefficient.terms() {
                    let row = rows.entry((component, monomial, constant)).or_default();
                    row.push((at, number.clone()));
                }
            }
        }
    }
    let mut rows: Vec<Row> = rows.into_values().collect();
    // Short equations first: they decide unknowns without filling others.
    rows.sort_by_key(Vec::len);
    Ok(null_space(&rows, columns.len()))
}

/// L_f J of each coefficient: of J = φ ∂_i ∧ ∂_j it is (f·∇φ) ∂_i ∧ ∂_j − φ (∂_i f ∧ ∂_j + ∂_i ∧ ∂_j f).
fn columns(field: &mut RingField) -> Result<Vec<Vec<Polynomial>>, AlgebraError> {
    let d = field.dimension();
    let pairs = pairs(d);
    let RingField { ring, f } = field;
    let mut slopes = Vec::with_capacity(d);
    for f in f.iter() {
        slopes.push(ring.gradient(f)?);
    }
    let one = Rational::one();
    let mut columns = Vec::new();
    for &(i, j) in &pairs {
        let carried: Vec<Polynomial> = (pairs.iter())
            .map(|&(a, b)| {
                let mut terms = Vec::new();
                for (row, other, sign) in [(a, b, one.clone()), (b, a, -&one)] {
                    if other == j {
                        terms.push((-&sign, slopes[row][i].clone()));
                    }
                    if other == i {
                        terms.push((sign.clone(), slopes[row][j].clone()));
                    }
                }
                ring.combine(&terms)
            })
            .collect();
        columns.push(carried.clone());
        for k in 0..d {
            let x = ring.variable(k);
            let mut column: Vec<Polynomial> = carried
                .iter()
                .map(|entry| ring.multiply(&x, entry))
                .collect();
            for (entry, pair) in column.iter_mut().zip(&pairs) {
                if *pair == (i, j) {
                    *entry = ring.add(entry, &f[k]);
                }
            }
            columns.push(column);
        }
    }
    Ok(columns)
}
