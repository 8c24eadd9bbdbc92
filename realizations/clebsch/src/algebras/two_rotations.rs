//! so(4)* = so(3)* × so(3)* by two of Hopf's maps a and b: y = (a + b, a − b).
//!
//! Brackets are {y_i, y_j} = ε y_k within the first three, {y_i, y_{3+j}} = ε y_{3+k}, {y_{3+i}, y_{3+j}} = ε y_k.

use std::sync::Arc;

use leafwise_expression::Rational;

use super::rotations;
use crate::algebra::{Algebra, canonical};
use crate::forms::{Forms, Product};

/// so(4).
pub fn algebra() -> Algebra {
    let one = rotations::algebra().forms;
    let half = |product: &Product, first: usize, sign: i64| Product {
        factor: &product.factor * &Rational::from_integer(sign),
        places: product.places.map(|at| first + at),
    };
    let row = |k: usize, sign: i64| -> Vec<Product> {
        let products = &one.rows()[k];
        let first = products.iter().map(|product| half(product, 0, 1));
        let second = products.iter().map(|product| half(product, 4, sign));
        first.chain(second).collect()
    };
    let rows = [1, -1].map(|sign| (0..3).map(move |k| (k, sign)));
    let rows = rows.into_iter().flatten().map(|(k, sign)| row(k, sign));
    Algebra {
        name: "so(4)",
        forms: Forms::new(8, rows.collect()),
        omega: canonical(8, &[(0, 2), (1, 3), (4, 6), (5, 7)], -1),
        copies: 1,
        is_signed: false,
        section: Arc::new(|y, z, _| {
            let mut a = [0.0; 3];
            let mut b = [0.0; 3];
            for i in 0..3 {
                a[i] = 0.5 * (y[i] + y[3 + i]);
                b[i] = 0.5 * (y[i] - y[3 + i]);
            }
            z[..4].copy_from_slice(&rotations::section(&a));
            z[4..].copy_from_slice(&rotations::section(&b));
            Ok(())
        }),
        settle: None,
        groups: &[4],
    }
}
