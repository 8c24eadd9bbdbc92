//! Linear brackets known by name: {x_i, x_j} = −Σ_k c_ij^k x_k, the paper's sign.

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
    /// What it is, in one line.
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
pub const LIE_ALGEBRAS: [LieAlgebra; 6] = [
    LieAlgebra {
        name: "so3",
        coordinates: &["x1", "x2", "x3"],
        bracket: &[(0, 1, &[(-1, 2)]), (1, 2, &[(-1, 0)]), (2, 0, &[(-1, 1)])],
        summary: "rotations of space: {x1,x2} = -x3 and cyclic",
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
    use super::*;

    /// Σ over cyclic (i,j,k) of Σ_l c_ij^l c_lk^m, exactly.
    #[test]
    fn every_algebra_satisfies_the_jacobi_identity() {
        for algebra in &LIE_ALGEBRAS {
            let d = algebra.dimension();
            let mut c = vec![vec![vec![0_i64; d]; d]; d];
            for &(i, j, terms) in algebra.bracket {
                for &(coefficient, k) in terms {
                    assert_eq!(c[i][j][k], 0, "{} lists an entry twice", algebra.name);
                    c[i][j][k] = coefficient;
                    c[j][i][k] = -coefficient;
                }
            }
            for i in 0..d {
                for j in 0..d {
                    for k in 0..d {
                        for m in 0..d {
                            let sum: i64 = [(i, j, k), (j, k, i), (k, i, j)]
                                .iter()
                                .flat_map(|&(a, b, e)| (0..d).map(move |l| (a, b, e, l)))
                                .map(|(a, b, e, l)| c[a][b][l] * c[l][e][m])
                                .sum();
                            assert_eq!(sum, 0, "{} at {i},{j},{k}", algebra.name);
                        }
                    }
                }
            }
        }
    }
}
