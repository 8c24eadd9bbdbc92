//! Jacobi's identity of affine tensors.

use leafwise_expression::Rational;

/// Jacobi's identity B(c, c) = 0 of {x_i, x_j} = c_ij0 + Σ_k c_ijk x_k. Coefficients stand in the order of the pairs i < j, those of a pair
/// together, the constant first.
#[derive(Clone, Debug)]
pub(crate) struct Identity {
    count: usize,
    /// B has the terms ± a[left] b[right] in the component `into`.
    terms: Vec<Product>,
}

#[derive(Clone, Copy, Debug)]
struct Product {
    into: usize,
    left: usize,
    right: usize,
    is_negative: bool,
}

/// The place of c_ijm with m = 0 for the constant, m = k + 1 for x_k, and whether its sign is that of c_jim.
fn place(d: usize, i: usize, j: usize, m: usize) -> Option<(usize, bool)> {
    let pair = |i: usize, j: usize| i * (2 * d - i - 1) / 2 + (j - i - 1);
    match i.cmp(&j) {
        std::cmp::Ordering::Less => Some((pair(i, j) * (d + 1) + m, false)),
        std::cmp::Ordering::Greater => Some((pair(j, i) * (d + 1) + m, true)),
        std::cmp::Ordering::Equal => None,
    }
}

impl Identity {
    /// That of d variables: Σ_cyc Σ_l c_il^m c_jk^l for all i < j < k and m.
    pub fn of(d: usize) -> Self {
        let mut identity = Self {
            count: 0,
            terms: Vec::new(),
        };
        for i in 0..d {
            for j in i + 1..d {
                for k in j + 1..d {
                    for m in 0..=d {
                        identity.add(d, [i, j, k], m);
                    }
                }
            }
        }
        identity
    }

    fn add(&mut self, d: usize, [i, j, k]: [usize; 3], m: usize) {
        for l in 0..d {
            for (first, p, q) in [(i, j, k), (j, k, i), (k, i, j)] {
                let (left, right) = (place(d, first, l, m), place(d, p, q, l + 1));
                if let (Some((left, one)), Some((right, other))) = (left, right) {
                    self.terms.push(Product {
                        into: self.count,
                        left,
                        right,
                        is_negative: one != other,
                    });
                }
            }
        }
        self.count += 1;
    }

    /// Whether the identity holds.
    pub fn holds(&self, c: &[Rational]) -> bool {
        let mut identity = vec![Rational::zero(); self.count];
        for term in &self.terms {
            if c[term.left].is_zero() || c[term.right].is_zero() {
                continue;
            }
            let product = &c[term.left] * &c[term.right];
            identity[term.into] += &if term.is_negative { -product } else { product };
        }
        identity.iter().all(Rational::is_zero)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// {x, y} = z and cyclic holds, {x, y} = z, {y, z} = x + y alone does not.
    #[test]
    fn the_identity_of_so3_holds_and_that_of_another_tensor_does_not() {
        let identity = Identity::of(3);
        let number = Rational::from_integer;
        let mut c = vec![Rational::zero(); 12];
        for (i, j, k, value) in [(0, 1, 2, 1), (1, 2, 0, 1), (0, 2, 1, -1)] {
            let (at, is_negative) = place(3, i, j, k + 1).expect("a pair");
            c[at] = number(if is_negative { -value } else { value });
        }
        assert!(identity.holds(&c));
        let (at, _) = place(3, 0, 2, 1).expect("a pair");
        c[at] = number(1);
        assert!(!identity.holds(&c));
    }
}
