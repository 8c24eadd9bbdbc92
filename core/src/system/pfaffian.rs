//! Inverses of antisymmetric matrices, by Pfaffians.

use std::collections::BTreeMap;

use leafwise_expression::{AlgebraError, Arithmetic, Rational};

/// An antisymmetric matrix by its entries above the diagonal; those that are absent are 0.
#[derive(Clone, Debug)]
pub(super) struct Antisymmetric<E> {
    pub size: usize,
    pub above: BTreeMap<(usize, usize), E>,
}

/// A⁻¹ = P / Pf(A).
#[derive(Clone, Debug)]
pub(super) struct Inverse<E> {
    /// Pf(A), whose square is det(A).
    pub pfaffian: E,
    /// P above the diagonal, its entries that are recognized as 0 left out.
    pub above: BTreeMap<(usize, usize), E>,
}

/// The most minors that are formed: of 16 rows with no zeros there are half as many.
const MOST_MINORS: usize = 1 << 16;

impl<E: Clone> Antisymmetric<E> {
    /// Inverse by Pfaffian minors, P_ij = (−1)^(i+j) Pf(A without i, j) for i < j. It is `None` where the Pfaffian is
    /// recognized as 0, as it is for an odd size.
    ///
    /// # Errors
    /// [`AlgebraError::ExpansionTooLong`] past 2¹⁶ minors. A limit that the algebra has reached is its error too.
    pub fn inverse<A: Arithmetic<Element = E>>(
        &self,
        algebra: &mut A,
    ) -> Result<Option<Inverse<E>>, AlgebraError> {
        if self.size > 64 {
            return Err(AlgebraError::ExpansionTooLong);
        }
        if self.size % 2 == 1 {
            return Ok(None);
        }
        let mut minors = Minors {
            matrix: self,
            known: BTreeMap::new(),
        };
        let all = u64::MAX >> (64 - self.size.max(1)) as u32;
        let all = if self.size == 0 { 0 } else { all };
        let Some(pfaffian) = minors.pfaffian(algebra, all)? else {
            return Ok(None);
        };
        let mut above = BTreeMap::new();
        for i in 0..self.size {
            for j in i + 1..self.size {
                if let Some(minor) = minors.pfaffian(algebra, all & !(1 << i) & !(1 << j))? {
                    let is_even = (i + j) % 2 == 0;
                    let entry = if is_even {
                        minor
                    } else {
                        algebra.negate(&minor)
                    };
                    above.insert((i, j), entry);
                }
            }
        }
        match algebra.refusal() {
            Some(refusal) => Err(refusal.clone()),
            None => Ok(Some(Inverse { pfaffian, above })),
        }
    }
}

struct Minors<'a, E> {
    matrix: &'a Antisymmetric<E>,
    /// The Pfaffians of sets of rows, `None` for 0.
    known: BTreeMap<u64, Option<E>>,
}

impl<E: Clone> Minors<'_, E> {
    /// The Pfaffian of some rows and columns, Σ_j ± a_ij Pf(without i, j) along the first of them.
    fn pfaffian<A: Arithmetic<Element = E>>(
        &mut self,
        algebra: &mut A,
        rows: u64,
    ) -> Result<Option<E>, AlgebraError> {
        if rows == 0 {
            return Ok(Some(algebra.one()));
        }
        if let Some(known) = self.known.get(&rows) {
            return Ok(known.clone());
        }
        if self.known.len() == MOST_MINORS {
            return Err(AlgebraError::ExpansionTooLong);
        }
        let first = rows.trailing_zeros() as usize;
        let others = rows & !(1 << first);
        let mut products = Vec::new();
        let (mut left, mut sign) = (others, Rational::one());
        while left != 0 {
            let j = left.trailing_zeros() as usize;
            left &= left - 1;
            if let Some(entry) = self.matrix.above.get(&(first, j))
                && let Some(minor) = self.pfaffian(algebra, others & !(1 << j))?
            {
                products.push((sign.clone(), entry, minor));
            }
            sign = -sign;
        }
        let products: Vec<_> = (products.iter())
            .map(|(sign, entry, minor)| (sign.clone(), *entry, minor))
            .collect();
        let sum = (!products.is_empty()).then(|| algebra.sum_of_products(&products));
        let sum = sum.filter(|sum| !algebra.is_zero(sum));
        self.known.insert(rows, sum.clone());
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use leafwise_expression::{Polynomial, Ring};
    use nalgebra::DMatrix;

    use super::*;

    fn whole(
        ring: &Ring,
        entries: &BTreeMap<(usize, usize), Polynomial>,
        size: usize,
    ) -> DMatrix<f64> {
        let mut whole = DMatrix::zeros(size, size);
        for (&(i, j), entry) in entries {
            let value = ring.as_rational(entry).expect("a number").to_f64();
            whole[(i, j)] = value;
            whole[(j, i)] = -value;
        }
        whole
    }

    /// A P = Pf 1 and Pf² = det, over whole numbers from −3 to 3, of which every seventh matrix or so is singular.
    #[test]
    fn the_inverse_is_one() {
        let mut digits = 0_u64;
        let mut next = || {
            digits = digits
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (digits >> 33) as i64 % 7 - 3
        };
        let mut singular = 0;
        for case in 0..300 {
            let size = 2 + 2 * (case % 4);
            let mut ring = Ring::new(0);
            let mut above = BTreeMap::new();
            for i in 0..size {
                for j in i + 1..size {
                    let number = next();
                    if number != 0 {
                        above.insert((i, j), ring.constant(&Rational::from_integer(number)));
                    }
                }
            }
            let matrix = Antisymmetric { size, above };
            let a = whole(&ring, &matrix.above, size);
            // A whole number, below 3⁸ 8! in size, but for what elimination rounds.
            let determinant = a.determinant();
            match matrix.inverse(&mut ring).expect("few minors") {
                None => {
                    assert!(determinant.abs() < 1e-4, "{determinant}");
                    singular += 1;
                }
                Some(inverse) => {
                    let pfaffian = ring
                        .as_rational(&inverse.pfaffian)
                        .expect("a number")
                        .to_f64();
                    assert!((pfaffian * pfaffian - determinant).abs() < 1e-4);
                    let product = a * whole(&ring, &inverse.above, size);
                    assert_eq!(product, DMatrix::identity(size, size) * pfaffian);
                }
            }
        }
        assert!((1..150).contains(&singular), "{singular}");
    }

    #[test]
    fn odd_sizes_have_no_inverse_and_long_expansions_end() {
        let mut ring = Ring::new(0);
        let one = ring.one();
        let dense = |size: usize| Antisymmetric {
            size,
            above: (0..size)
                .flat_map(|i| (i + 1..size).map(move |j| (i, j)))
                .map(|at| (at, one.clone()))
                .collect(),
        };
        assert!(dense(5).inverse(&mut ring).expect("odd").is_none());
        assert!(dense(12).inverse(&mut ring).expect("short").is_some());
        for size in [40, 70] {
            let refused = dense(size).inverse(&mut ring);
            assert_eq!(refused.err(), Some(AlgebraError::ExpansionTooLong));
        }
    }
}
