//! Lie algebras known by name.

/// (i, j, [(coefficient, k), …]): {x_i, x_j} = Σ coefficient·x_k.
pub type StructureEntry = (usize, usize, &'static [(i64, usize)]);

/// A Lie algebra with a basis in which it is written.
#[derive(Clone, Copy, Debug)]
pub struct LieAlgebra {
    /// The name a scene uses.
    pub name: &'static str,
    /// The usual names of the coordinates, in the order of the scene's variables.
    pub coordinates: &'static [&'static str],
    /// The nonzero entries.
    pub bracket: &'static [StructureEntry],
    /// Description of the algebra, in one line.
    pub summary: &'static str,
}

/// {l_i, l_j} = −ε_ijk l_k and {l_i, p_j} = −ε_ijk p_k: rotations and translations of space.
const EUCLIDEAN: &[StructureEntry] = &[
    (0, 1, &[(-1, 2)]),
    (1, 2, &[(-1, 0)]),
    (2, 0, &[(-1, 1)]),
    (0, 4, &[(-1, 5)]),
    (1, 5, &[(-1, 3)]),
    (2, 3, &[(-1, 4)]),
    (0, 5, &[(1, 4)]),
    (1, 3, &[(1, 5)]),
    (2, 4, &[(1, 3)]),
];

/// The Lie algebras a scene may name.
pub const LIE_ALGEBRAS: [LieAlgebra; 11] = [
    LieAlgebra {
        name: "so3",
        coordinates: &["x1", "x2", "x3"],
        bracket: &[(0, 1, &[(-1, 2)]), (1, 2, &[(-1, 0)]), (2, 0, &[(-1, 1)])],
        summary: "rotations of space: {x1,x2} = -x3 and cyclic; with {H,x} a spin, s' = s × (-∂H/∂s), with {x,H} a body, m' = m × ω, ω = ∂H/∂m",
    },
    LieAlgebra {
        name: "se3",
        coordinates: &["l1", "l2", "l3", "p1", "p2", "p3"],
        bracket: EUCLIDEAN,
        summary: "rigid motions of space: {l1,l2} = -l3, {l1,p2} = -p3 and cyclic",
    },
    LieAlgebra {
        name: "e3",
        coordinates: &["m1", "m2", "m3", "gamma1", "gamma2", "gamma3"],
        bracket: EUCLIDEAN,
        summary: "se3 in the names of the heavy top",
    },
    LieAlgebra {
        name: "so4",
        coordinates: &["m12", "m13", "m14", "m23", "m24", "m34"],
        bracket: &[
            (0, 1, &[(1, 3)]),
            (0, 2, &[(1, 4)]),
            (0, 3, &[(-1, 1)]),
            (0, 4, &[(-1, 2)]),
            (1, 2, &[(1, 5)]),
            (1, 3, &[(1, 0)]),
            (1, 5, &[(-1, 2)]),
            (2, 4, &[(1, 0)]),
            (2, 5, &[(1, 1)]),
            (3, 4, &[(1, 5)]),
            (3, 5, &[(-1, 4)]),
            (4, 5, &[(1, 3)]),
        ],
        summary: "rotations in four dimensions, entries of the antisymmetric matrix: {m12,m13} = m23",
    },
    LieAlgebra {
        name: "so5",
        coordinates: &[
            "m12", "m13", "m14", "m15", "m23", "m24", "m25", "m34", "m35", "m45",
        ],
        bracket: &[
            (0, 1, &[(1, 4)]),
            (0, 2, &[(1, 5)]),
            (0, 3, &[(1, 6)]),
            (0, 4, &[(-1, 1)]),
            (0, 5, &[(-1, 2)]),
            (0, 6, &[(-1, 3)]),
            (1, 2, &[(1, 7)]),
            (1, 3, &[(1, 8)]),
            (1, 4, &[(1, 0)]),
            (1, 7, &[(-1, 2)]),
            (1, 8, &[(-1, 3)]),
            (2, 3, &[(1, 9)]),
            (2, 5, &[(1, 0)]),
            (2, 7, &[(1, 1)]),
            (2, 9, &[(-1, 3)]),
            (3, 6, &[(1, 0)]),
            (3, 8, &[(1, 1)]),
            (3, 9, &[(1, 2)]),
            (4, 5, &[(1, 7)]),
            (4, 6, &[(1, 8)]),
            (4, 7, &[(-1, 5)]),
            (4, 8, &[(-1, 6)]),
            (5, 6, &[(1, 9)]),
            (5, 7, &[(1, 4)]),
            (5, 9, &[(-1, 6)]),
            (6, 8, &[(1, 4)]),
            (6, 9, &[(1, 5)]),
            (7, 8, &[(1, 9)]),
            (7, 9, &[(-1, 8)]),
            (8, 9, &[(1, 7)]),
        ],
        summary: "rotations in five dimensions, entries of the antisymmetric matrix: {m12,m13} = m23",
    },
    LieAlgebra {
        name: "su3",
        coordinates: &["a12", "a13", "a23", "s12", "s13", "s23", "h1", "h2"],
        bracket: &[
            (0, 1, &[(1, 2)]),
            (0, 2, &[(-1, 1)]),
            (0, 3, &[(-2, 6)]),
            (0, 4, &[(1, 5)]),
            (0, 5, &[(-1, 4)]),
            (0, 6, &[(2, 3)]),
            (0, 7, &[(-1, 3)]),
            (1, 2, &[(1, 0)]),
            (1, 3, &[(1, 5)]),
            (1, 4, &[(-2, 6), (-2, 7)]),
            (1, 5, &[(-1, 3)]),
            (1, 6, &[(1, 4)]),
            (1, 7, &[(1, 4)]),
            (2, 3, &[(1, 4)]),
            (2, 4, &[(-1, 3)]),
            (2, 5, &[(-2, 7)]),
            (2, 6, &[(-1, 5)]),
            (2, 7, &[(2, 5)]),
            (3, 4, &[(1, 2)]),
            (3, 5, &[(1, 1)]),
            (3, 6, &[(-2, 0)]),
            (3, 7, &[(1, 0)]),
            (4, 5, &[(1, 0)]),
            (4, 6, &[(-1, 1)]),
            (4, 7, &[(-1, 1)]),
            (5, 6, &[(1, 2)]),
            (5, 7, &[(-2, 2)]),
        ],
        summary: "a_jk = E_jk - E_kj, s_jk = i(E_jk + E_kj), h1 = i(E_11 - E_22), h2 = i(E_22 - E_33): {a12,a13} = a23",
    },
    LieAlgebra {
        name: "sp4",
        coordinates: &[
            "q1q1", "q1q2", "q1p1", "q1p2", "q2q2", "q2p1", "q2p2", "p1p1", "p1p2", "p2p2",
        ],
        bracket: &[
            (0, 2, &[(-2, 0)]),
            (0, 5, &[(-2, 1)]),
            (0, 7, &[(-4, 2)]),
            (0, 8, &[(-2, 3)]),
            (1, 2, &[(-1, 1)]),
            (1, 3, &[(-1, 0)]),
            (1, 5, &[(-1, 4)]),
            (1, 6, &[(-1, 1)]),
            (1, 7, &[(-2, 5)]),
            (1, 8, &[(-1, 2), (-1, 6)]),
            (1, 9, &[(-2, 3)]),
            (2, 3, &[(1, 3)]),
            (2, 5, &[(-1, 5)]),
            (2, 7, &[(-2, 7)]),
            (2, 8, &[(-1, 8)]),
            (3, 4, &[(2, 1)]),
            (3, 5, &[(1, 2), (-1, 6)]),
            (3, 6, &[(1, 3)]),
            (3, 7, &[(-2, 8)]),
            (3, 8, &[(-1, 9)]),
            (4, 6, &[(-2, 4)]),
            (4, 8, &[(-2, 5)]),
            (4, 9, &[(-4, 6)]),
            (5, 6, &[(-1, 5)]),
            (5, 8, &[(-1, 7)]),
            (5, 9, &[(-2, 8)]),
            (6, 8, &[(-1, 8)]),
            (6, 9, &[(-2, 9)]),
        ],
        summary: "second moments of two degrees of freedom: {q1q1,q1p1} = -2 q1q1, as {q,p} = -1 has it",
    },
    LieAlgebra {
        name: "gl2",
        coordinates: &["e11", "e12", "e21", "e22"],
        bracket: &[
            (0, 1, &[(-1, 1)]),
            (0, 2, &[(1, 2)]),
            (1, 2, &[(-1, 0), (1, 3)]),
            (1, 3, &[(-1, 1)]),
            (2, 3, &[(1, 2)]),
        ],
        summary: "two by two matrices: {e_ij,e_kl} = -d_jk e_il + d_li e_kj",
    },
    LieAlgebra {
        name: "se2",
        coordinates: &["l", "p1", "p2"],
        bracket: &[(0, 1, &[(-1, 2)]), (0, 2, &[(1, 1)])],
        summary: "rigid motions of the plane: {l,p1} = -p2, {l,p2} = p1",
    },
    LieAlgebra {
        name: "sl2",
        coordinates: &["h", "e", "f"],
        bracket: &[(0, 1, &[(-2, 1)]), (0, 2, &[(2, 2)]), (1, 2, &[(-1, 0)])],
        summary: "traceless two by two matrices: {h,e} = -2e, {h,f} = 2f, {e,f} = -h",
    },
    LieAlgebra {
        name: "heisenberg",
        coordinates: &["q", "p", "z"],
        bracket: &[(0, 1, &[(-1, 2)])],
        summary: "the Heisenberg algebra: {q,p} = -z, z central",
    },
];

impl LieAlgebra {
    /// The algebra of this name.
    pub fn find(name: &str) -> Option<&'static Self> {
        LIE_ALGEBRAS.iter().find(|algebra| algebra.name == name)
    }

    /// Its dimension.
    pub fn dimension(&self) -> usize {
        self.coordinates.len()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::LIE_ALGEBRAS;

    /// The matrix with the entries 1 and s at two places.
    fn two(n: usize, one: (usize, usize), s: i64, other: (usize, usize)) -> DMatrix<i64> {
        let mut matrix = DMatrix::zeros(n, n);
        matrix[one] += 1;
        matrix[other] += s;
        matrix
    }

    /// E_ij − E_ji.
    fn rotation(n: usize, i: usize, j: usize) -> DMatrix<i64> {
        two(n, (i, j), -1, (j, i))
    }

    /// E_ij.
    fn unit(n: usize, i: usize, j: usize) -> DMatrix<i64> {
        two(n, (i, j), 0, (i, j))
    }

    fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
        (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
    }

    /// i A of a real matrix A, with a complex number x + iy as ((x, −y), (y, x)).
    fn times_i(a: &DMatrix<i64>) -> DMatrix<i64> {
        a.kronecker(&rotation(2, 1, 0))
    }

    /// Rotations and translations of space as 4 × 4 matrices.
    fn euclidean() -> Vec<DMatrix<i64>> {
        let rotations = [(2, 1), (0, 2), (1, 0)].map(|(i, j)| rotation(4, i, j));
        let translations = (0..3).map(|i| unit(4, i, 3));
        rotations.into_iter().chain(translations).collect()
    }

    /// A faithful representation, a matrix a coordinate.
    fn matrices(name: &str) -> Vec<DMatrix<i64>> {
        match name {
            "so3" => euclidean()[..3].to_vec(),
            "se3" | "e3" => euclidean(),
            "so4" => pairs(4).map(|(i, j)| rotation(4, i, j)).collect(),
            "so5" => pairs(5).map(|(i, j)| rotation(5, i, j)).collect(),
            "su3" => {
                let real = DMatrix::identity(2, 2);
                let a = pairs(3).map(|(i, j)| rotation(3, i, j).kronecker(&real));
                let s = pairs(3).map(|(i, j)| times_i(&two(3, (i, j), 1, (j, i))));
                let h = (0..2).map(|i| times_i(&two(3, (i, i), -1, (i + 1, i + 1))));
                a.chain(s).chain(h).collect()
            }
            // z' = J S z for the quadratic form with the Hessian S.
            "sp4" => {
                let j = rotation(2, 0, 1).kronecker(&DMatrix::identity(2, 2));
                let products = (0..4).flat_map(|a| (a..4).map(move |b| (a, b)));
                products
                    .map(|(a, b)| &j * two(4, (a, b), 1, (b, a)))
                    .collect()
            }
            "gl2" => (0..4).map(|k| unit(2, k / 2, k % 2)).collect(),
            "se2" => vec![rotation(3, 1, 0), unit(3, 0, 2), unit(3, 1, 2)],
            "sl2" => vec![two(2, (0, 0), -1, (1, 1)), unit(2, 0, 1), unit(2, 1, 0)],
            "heisenberg" => vec![unit(3, 0, 1), unit(3, 1, 2), unit(3, 0, 2)],
            other => panic!("no matrices of {other}"),
        }
    }

    /// {x_i, x_j} = −Σ c_ij^k x_k with [e_i, e_j] = Σ c_ij^k e_k, in a faithful representation.
    #[test]
    fn every_algebra_is_one_of_matrices() {
        for algebra in &LIE_ALGEBRAS {
            let basis = matrices(algebra.name);
            assert_eq!(basis.len(), algebra.dimension(), "{}", algebra.name);
            for (i, j) in pairs(basis.len()) {
                let commutator = &basis[i] * &basis[j] - &basis[j] * &basis[i];
                let mut sum = DMatrix::zeros(commutator.nrows(), commutator.ncols());
                for &(a, b, terms) in algebra.bracket {
                    let sign = match (a, b) {
                        _ if (a, b) == (i, j) => 1,
                        _ if (a, b) == (j, i) => -1,
                        _ => continue,
                    };
                    for &(coefficient, k) in terms {
                        sum -= &basis[k] * (sign * coefficient);
                    }
                }
                assert_eq!(sum, commutator, "{} at {i},{j}", algebra.name);
            }
        }
    }
}
