//! Whether the fibres of a quadratic map are orbits of linear symmetries.
//!
//! The forms that commute with every x_k have linear flows that J does not see. Where the directions in which they move
//! a point make up the kernel of DJ there, they do so almost everywhere. Then a Gauss method, which commutes with them,
//! takes fibres to fibres. Ranks are those at a point of whole numbers modulo a large prime.

use leafwise_expression::Rational;

/// 2⁶¹ − 1.
const PRIME: u64 = (1 << 61) - 1;

fn times(a: u64, b: u64) -> u64 {
    (u128::from(a) * u128::from(b) % u128::from(PRIME)) as u64
}

fn plus(a: u64, b: u64) -> u64 {
    (a + b) % PRIME
}

fn minus(a: u64) -> u64 {
    (PRIME - a) % PRIME
}

fn inverse(a: u64) -> u64 {
    let (mut power, mut exponent, mut found) = (a, PRIME - 2, 1);
    while exponent > 0 {
        if exponent % 2 == 1 {
            found = times(found, power);
        }
        power = times(power, power);
        exponent /= 2;
    }
    found
}

/// A rational number modulo the prime; `None` where it is too long.
fn residue(value: &Rational) -> Option<u64> {
    let numerator = Rational::from(1) * value * Rational::from(value.denominator());
    let denominator = Rational::from(value.denominator()).to_i64()?;
    let whole = |v: i64| v.rem_euclid(PRIME as i64) as u64;
    Some(times(
        whole(numerator.to_i64()?),
        inverse(whole(denominator)),
    ))
}

/// Independent vectors in echelon form.
#[derive(Default)]
struct Echelon {
    rows: Vec<(usize, Vec<u64>)>,
}

impl Echelon {
    fn add(&mut self, mut vector: Vec<u64>) {
        for (pivot, row) in &self.rows {
            let factor = minus(vector[*pivot]);
            if factor != 0 {
                subtract(&mut vector, factor, row);
            }
        }
        if let Some(pivot) = vector.iter().position(|v| *v != 0) {
            let scale = inverse(vector[pivot]);
            vector.iter_mut().for_each(|v| *v = times(*v, scale));
            self.rows.push((pivot, vector));
        }
    }

    /// A basis of the vectors on which all these vanish.
    fn kernel(mut self, width: usize) -> Vec<Vec<u64>> {
        for k in (0..self.rows.len()).rev() {
            let (pivot, row) = self.rows[k].clone();
            for (_, other) in &mut self.rows[..k] {
                let factor = minus(other[pivot]);
                if factor != 0 {
                    subtract(other, factor, &row);
                }
            }
        }
        let mut is_bound = vec![false; width];
        self.rows
            .iter()
            .for_each(|(pivot, _)| is_bound[*pivot] = true);
        let free = (0..width).filter(|at| !is_bound[*at]);
        free.map(|at| {
            let mut vector = vec![0; width];
            vector[at] = 1;
            for (pivot, row) in &self.rows {
                vector[*pivot] = minus(row[at]);
            }
            vector
        })
        .collect()
    }
}

/// v ← v + factor·row.
fn subtract(vector: &mut [u64], factor: u64, row: &[u64]) {
    for (v, row) in vector.iter_mut().zip(row) {
        if *row != 0 {
            *v = plus(*v, times(factor, *row));
        }
    }
}

/// Dimensions at a general point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimensions {
    /// Of the image of DJ.
    pub image: usize,
    /// Of the kernel of DJ.
    pub kernel: usize,
    /// Of the directions of linear symmetries.
    pub orbits: usize,
}

/// Those of `copies` copies of forms S_k on v coordinates under Ω; `None` where their numbers are too long.
pub fn dimensions(
    v: usize,
    matrices: &[Vec<Rational>],
    omega: &[Rational],
    copies: usize,
) -> Option<Dimensions> {
    let residues = |matrix: &[Rational]| matrix.iter().map(residue).collect::<Option<Vec<u64>>>();
    let matrices: Option<Vec<Vec<u64>>> = matrices.iter().map(|m| residues(m)).collect();
    let (matrices, omega) = (matrices?, residues(omega)?);
    let product = |a: &[u64], b: &[u64]| {
        let mut out = vec![0; v * v];
        for i in 0..v {
            for k in 0..v {
                for j in 0..v {
                    let term = times(a[i * v + k], b[k * v + j]);
                    out[i * v + j] = plus(out[i * v + j], term);
                }
            }
        }
        out
    };
    // The T with T Ω S_k = S_k Ω T.
    let mut equations = Echelon::default();
    for matrix in &matrices {
        let (right, left) = (product(&omega, matrix), product(matrix, &omega));
        for i in 0..v {
            for j in 0..v {
                let mut equation = vec![0; v * v];
                for k in 0..v {
                    let (first, second) = (i * v + k, k * v + j);
                    equation[first] = plus(equation[first], right[k * v + j]);
                    equation[second] = plus(equation[second], minus(left[i * v + k]));
                }
                equations.add(equation);
            }
        }
    }
    let all = equations.kernel(v * v);
    let mut symmetric = Echelon::default();
    for i in 0..v {
        for j in 0..i {
            // Σ_t c_t (T_ij − T_ji) = 0.
            let row = all.iter();
            symmetric.add(
                row.map(|t| plus(t[i * v + j], minus(t[j * v + i])))
                    .collect(),
            );
        }
    }
    let symmetric: Vec<Vec<u64>> = symmetric
        .kernel(all.len())
        .iter()
        .map(|parts| {
            let mut sum = vec![0; v * v];
            for (part, t) in parts.iter().zip(&all) {
                subtract(&mut sum, *part, t);
            }
            sum
        })
        .collect();
    // Whole numbers that have nothing to do with one another.
    let mut state = 1_u64;
    let points: Vec<Vec<u64>> = (0..copies)
        .map(|_| {
            let numbers = (0..v).map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) % 1_000_003 + 1
            });
            numbers.collect()
        })
        .collect();
    let apply = |matrix: &[u64], z: &[u64]| -> Vec<u64> {
        let rows = matrix.chunks_exact(v);
        rows.map(|row| {
            row.iter()
                .zip(z)
                .fold(0, |sum, (a, b)| plus(sum, times(*a, *b)))
        })
        .collect()
    };
    let transposed = |matrix: &[u64]| -> Vec<u64> {
        let places = (0..v).flat_map(|i| (0..v).map(move |j| j * v + i));
        places.map(|at| matrix[at]).collect()
    };
    let n = v * copies;
    let mut image = Echelon::default();
    for matrix in &matrices {
        image.add(points.iter().flat_map(|z| apply(matrix, z)).collect());
    }
    let mut orbits = Echelon::default();
    for a in 0..copies {
        for t in &symmetric {
            let mut direction = vec![0; n];
            direction[a * v..][..v].copy_from_slice(&apply(&omega, &apply(t, &points[a])));
            orbits.add(direction);
        }
        for b in 0..a {
            for t in &all {
                let mut direction = vec![0; n];
                let forward = apply(&omega, &apply(t, &points[b]));
                let backward = apply(&omega, &apply(&transposed(t), &points[a]));
                direction[a * v..][..v].copy_from_slice(&forward);
                direction[b * v..][..v].copy_from_slice(&backward);
                orbits.add(direction);
            }
        }
    }
    Some(Dimensions {
        image: image.rows.len(),
        kernel: n - image.rows.len(),
        orbits: orbits.rows.len(),
    })
}
