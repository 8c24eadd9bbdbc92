//! Inverses of 2 × 2 and 3 × 3 matrices.

use leafwise_expression::kernel::apart;

/// Whether matrices of the dimension D are inverted.
pub(super) const fn is_inverted<const D: usize>() -> bool {
    D == 2 || D == 3
}

/// A⁻¹ = adj A/det A of 2 × 2 and 3 × 3 matrices, and in which lanes A is near the identity. There the pivots of A,
/// rows as they stand, all lie between 1/2 and 2. Elsewhere the inverse may have lost digits.
#[inline(always)]
pub(super) fn by_cofactors<const D: usize, const W: usize>(
    a: &[[f64; W]],
) -> ([[f64; W]; 9], [bool; W]) {
    let mut inverse = [[0.0; W]; 9];
    let mut near = [false; W];
    let mut entries = [[0.0; W]; 9];
    for (entry, a) in entries[..D * D].iter_mut().zip(a) {
        *entry = *a;
        apart::<W>();
    }
    for w in 0..W {
        let at = |row: usize, column: usize| entries[row % D * D + column % D][w];
        let minor = at(0, 0) * at(1, 1) - at(0, 1) * at(1, 0);
        // The pivots are a₀₀, minor/a₀₀ and det/minor.
        near[w] = is_near_one(at(0, 0)) && minor > 0.5 * at(0, 0) && minor < 2.0 * at(0, 0);
        if D == 2 {
            let reciprocal = 1.0 / minor;
            inverse[0][w] = at(1, 1) * reciprocal;
            inverse[1][w] = -at(0, 1) * reciprocal;
            inverse[2][w] = -at(1, 0) * reciprocal;
            inverse[3][w] = at(0, 0) * reciprocal;
        } else {
            // Rows and columns in a cycle give each cofactor its sign.
            let cofactor = |row: usize, column: usize| {
                at(row + 1, column + 1) * at(row + 2, column + 2)
                    - at(row + 1, column + 2) * at(row + 2, column + 1)
            };
            let determinant =
                at(0, 0) * cofactor(0, 0) + at(0, 1) * cofactor(0, 1) + at(0, 2) * cofactor(0, 2);
            near[w] &= determinant > 0.5 * minor && determinant < 2.0 * minor;
            let reciprocal = 1.0 / determinant;
            for row in 0..D {
                for column in 0..D {
                    inverse[row * D + column][w] = cofactor(column, row) * reciprocal;
                }
            }
        }
    }
    (inverse, near)
}

/// A⁻¹ r in place of r.
#[inline(always)]
pub(super) fn multiply<const W: usize>(inverse: &[[f64; W]], right: &mut [[f64; W]]) {
    let d = right.len();
    let mut given = [[0.0; W]; 3];
    given[..d].copy_from_slice(right);
    for (value, row) in right.iter_mut().zip(inverse.chunks_exact(d)) {
        for w in 0..W {
            let products = row.iter().zip(&given).map(|(entry, r)| entry[w] * r[w]);
            value[w] = products.reduce(|sum, product| sum + product).unwrap_or(0.0);
        }
    }
}

/// Whether a pivot lies between 1/2 and 2.
#[inline(always)]
pub(super) fn is_near_one(pivot: f64) -> bool {
    pivot > 0.5 && pivot < 2.0
}
