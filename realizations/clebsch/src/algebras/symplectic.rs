//! sp(2m)* by 2m copies of ℝ^{2m} with signs: y_ab = Σ σ z_a z_b, the quadratic functions of (q₁ … q_m, p₁ … p_m).
//!
//! A symmetric matrix X = Σ σ z zᵀ has such z in its eigenvectors, as many of either sign as X has eigenvalues: the motion keeps
//! these numbers. Fibres are the orbits of O(k, 2m − k) on copies.

use std::sync::Arc;

use leafwise_expression::Rational;

use crate::algebra::{Algebra, canonical};
use crate::forms::{Forms, Product};

/// The largest m.
const MOST: usize = 4;

/// 2m of it.
const WIDTH: usize = 2 * MOST;

/// sp(2) to sp(8), with y_aa = z_a² and y_aa = ½ z_a², and sp(2) as so(2, 1), y = (¼(q² + p²), ¼(q² − p²), ½qp).
pub fn algebras() -> Vec<Algebra> {
    let names = ["sp(2)", "sp(4)", "sp(6)", "sp(8)"];
    let mut algebras = Vec::new();
    for (name, m) in names.into_iter().zip(1..) {
        for halves in [1, 2] {
            algebras.push(algebra(name, m, halves));
        }
    }
    let table: [&[(i64, usize, usize)]; 3] = [
        &[(1, 0, 0), (1, 1, 1)],
        &[(1, 0, 0), (-1, 1, 1)],
        &[(2, 0, 1)],
    ];
    algebras.push(Algebra {
        name: "so(2, 1)",
        forms: Forms::of_table(2, 4, &table),
        section: Arc::new(|y, z, signs| {
            let matrix = [
                2.0 * (y[0] + y[1]),
                2.0 * y[2],
                2.0 * y[2],
                2.0 * (y[0] - y[1]),
            ];
            copies(&matrix, z, signs);
            Ok(())
        }),
        ..algebra("sp(2)", 1, 1)
    });
    algebras
}

/// sp(2m) with y_aa = z_a²/halves.
fn algebra(name: &'static str, m: usize, halves: i64) -> Algebra {
    let n = 2 * m;
    let places = (0..n).flat_map(move |a| (a..n).map(move |b| (a, b)));
    let rows = places.clone().map(|(a, b)| {
        let factor = if a == b { halves } else { 1 };
        vec![Product {
            factor: Rational::new(1, factor),
            places: [a, b],
        }]
    });
    let pairs: Vec<_> = (0..m).map(|a| (a, m + a)).collect();
    Algebra {
        name,
        forms: Forms::new(n, rows.collect()),
        omega: canonical(n, &pairs, 1),
        copies: n,
        is_signed: true,
        section: Arc::new(move |y, z, signs| {
            let mut matrix = [0.0; WIDTH * WIDTH];
            for ((a, b), y) in places.clone().zip(y) {
                let entry = if a == b { halves as f64 * y } else { *y };
                matrix[a * n + b] = entry;
                matrix[b * n + a] = entry;
            }
            copies(&matrix[..n * n], z, signs);
            Ok(())
        }),
        settle: None,
        groups: &[],
    }
}

/// The z and σ with X = Σ σ z zᵀ of a symmetric matrix, √|λ| times its eigenvectors, by Jacobi's rotations.
fn copies(matrix: &[f64], z: &mut [f64], signs: &mut [f64]) {
    let n = signs.len();
    let mut matrix = matrix.to_vec();
    let vectors = z;
    vectors.fill(0.0);
    vectors.iter_mut().step_by(n + 1).for_each(|one| *one = 1.0);
    let turn = |rows: &mut [f64], (i, j): (usize, usize), [c, s]: [f64; 2]| {
        for k in 0..n {
            let (a, b) = (rows[i * n + k], rows[j * n + k]);
            rows[i * n + k] = c * a - s * b;
            rows[j * n + k] = s * a + c * b;
        }
    };
    for _ in 0..SWEEPS {
        for i in 0..n {
            for j in i + 1..n {
                let off = matrix[i * n + j];
                if off == 0.0 {
                    continue;
                }
                // tan 2φ = 2x_ij/(x_jj − x_ii), φ the smaller one.
                let half = 0.5 * (matrix[j * n + j] - matrix[i * n + i]) / off;
                let root = half.abs() + libm::hypot(half, 1.0);
                let tangent = if half < 0.0 { -1.0 / root } else { 1.0 / root };
                let c = 1.0 / libm::hypot(tangent, 1.0);
                let turned = [c, tangent * c];
                turn(&mut matrix, (i, j), turned);
                for k in 0..n {
                    let (a, b) = (matrix[k * n + i], matrix[k * n + j]);
                    matrix[k * n + i] = turned[0] * a - turned[1] * b;
                    matrix[k * n + j] = turned[1] * a + turned[0] * b;
                }
                turn(vectors, (i, j), turned);
            }
        }
    }
    for (a, sign) in signs.iter_mut().enumerate() {
        let eigenvalue = matrix[a * n + a];
        *sign = if eigenvalue < 0.0 { -1.0 } else { 1.0 };
        let length = libm::sqrt(eigenvalue.abs());
        vectors[a * n..][..n].iter_mut().for_each(|z| *z *= length);
    }
}

/// Sweeps of rotations: they converge quadratically.
const SWEEPS: usize = 12;
