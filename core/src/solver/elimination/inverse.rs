//! Inverses of 2 × 2 and 3 × 3 matrices.

use super::{ANY, Factors, Rows, is_near_one};

impl<const W: usize, M: Rows<W>> Factors<W, M> {
    /// The inverse of a small matrix: by cofactors where it is near the identity, by elimination of a lane
    /// alone elsewhere.
    #[inline(always)]
    pub(super) fn invert<const D: usize>(
        &mut self,
        matrix: &[[f64; W]],
        wanted: &[bool; W],
    ) -> [bool; W] {
        let matrix = &matrix[..D * D];
        let (inverse, near) = by_cofactors::<D, W>(matrix);
        let entries = &mut self.entries.as_mut()[..D * D];
        for (entry, value) in entries.iter_mut().zip(&inverse) {
            for w in 0..W {
                entry[w] = if wanted[w] { value[w] } else { entry[w] };
            }
        }
        let mut singular = [false; W];
        for w in 0..W {
            if wanted[w] {
                self.near[w] = near[w];
                singular[w] = !near[w] && !self.invert_alone::<D>(matrix, w);
            }
        }
        singular
    }

    /// One lane's inverse by elimination with exchanges; `false` where a pivot is zero or not finite.
    #[cold]
    fn invert_alone<const D: usize>(&mut self, matrix: &[[f64; W]], lane: usize) -> bool {
        if !self.factor_alone(matrix, lane) {
            return false;
        }
        let mut factors = Factors::<1>::new(D);
        for (entry, row) in factors.entries.iter_mut().zip(self.entries.as_ref()) {
            *entry = [row[lane]];
        }
        for (exchange, row) in factors.exchanges.iter_mut().zip(&self.exchanges) {
            *exchange = [row[lane]];
        }
        factors.exchanged = [true];
        for column in 0..D {
            let mut unit = [[0.0]; D];
            unit[column] = [1.0];
            factors.solve::<ANY>(&mut unit);
            for (row, [value]) in unit.iter().enumerate() {
                self.entries.as_mut()[row * D + column][lane] = *value;
            }
        }
        self.near[lane] = false;
        true
    }
}

/// Whether matrices of the dimension D are inverted.
pub(super) const fn is_inverted<const D: usize>() -> bool {
    D == 2 || D == 3
}

/// A⁻¹ = adj A/det A of 2 × 2 and 3 × 3 matrices, and where the pivots of A, rows as they stand, all lie between
/// 1/2 and 2: elsewhere it may have lost digits.
#[inline(always)]
fn by_cofactors<const D: usize, const W: usize>(a: &[[f64; W]]) -> ([[f64; W]; 9], [bool; W]) {
    let mut inverse = [[0.0; W]; 9];
    let mut near = [false; W];
    for w in 0..W {
        let at = |row: usize, column: usize| a[row % D * D + column % D][w];
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

#[cfg(test)]
mod tests {
    use crate::solver::elimination::Factors;

    /// Near the identity by cofactors, whatever the units of the second coordinate: A⁻¹(A z) = z to the roundings
    /// of two products of three, over a determinant above 1/8.
    #[test]
    fn small_matrices_are_inverted_in_any_units() {
        let values = [-0.3, 0.0, 0.2, 0.45];
        let unit = libm::exp2(40.0);
        let mut near = 0;
        for at in 0..4_usize.pow(6) {
            let value = |k: u32| values[at / 4_usize.pow(k) % 4];
            let a = [
                [1.0 + value(0), value(1) * unit, value(2)],
                [value(3) / unit, 1.0, value(4) / unit],
                [value(5), -value(1) * unit, 1.0 + value(2)],
            ];
            let flat: Vec<[f64; 1]> = a.iter().flatten().map(|v| [*v]).collect();
            let mut factors = Factors::<1>::new(3);
            let [singular] = factors.factor::<3>(&flat, &[true]);
            if singular || !factors.is_near_identity::<3>(0) {
                continue;
            }
            near += 1;
            let z = [1.0, -2.0 / unit, 3.0];
            let product = |row: &[f64; 3]| row.iter().zip(z).map(|(a, z)| a * z).sum();
            let mut right = a.each_ref().map(|row| [product(row)]);
            factors.solve::<3>(&mut right);
            for (found, expected) in right.iter().zip(z) {
                let error = (found[0] - expected).abs() / expected.abs();
                assert!(error <= 256.0 * f64::EPSILON, "{a:?}: {error:e}");
            }
        }
        assert!(near > 1000, "{near} are near the identity");
    }
}
