//! Singular values and eigenvalues of small matrices.

/// A matrix by its columns.
pub(super) type Columns = Vec<Vec<f64>>;

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A = U Σ Vᵀ of n columns, U and V by their columns; Σ falls.
pub(super) struct SingularValues {
    pub left: Columns,
    pub values: Vec<f64>,
    pub right: Columns,
}

/// Sweeps over all pairs of columns, at most.
const SWEEPS: usize = 60;

impl SingularValues {
    /// One-sided Jacobi rotations, accurate for small values too (J. Demmel, K. Veselić, SIAM J. Matrix Anal. Appl. 13 (1992)).
    pub fn of(columns: &Columns) -> Self {
        let (mut a, n) = (columns.clone(), columns.len());
        let mut right: Columns = (0..n).map(|j| unit(n, j)).collect();
        for _ in 0..SWEEPS {
            let mut largest = 0.0_f64;
            for i in 0..n {
                for j in i + 1..n {
                    let [x, y, z] = [dot(&a[i], &a[i]), dot(&a[j], &a[j]), dot(&a[i], &a[j])];
                    let size = libm::sqrt(x * y);
                    if size == 0.0 || z.abs() <= f64::EPSILON * size {
                        continue;
                    }
                    largest = largest.max(z.abs() / size);
                    let zeta = (y - x) / (2.0 * z);
                    let t = zeta.signum() / (zeta.abs() + libm::sqrt(1.0 + zeta * zeta));
                    let c = 1.0 / libm::sqrt(1.0 + t * t);
                    for matrix in [&mut a, &mut right] {
                        rotate(matrix, (i, j), (c, c * t));
                    }
                }
            }
            if largest <= 4.0 * f64::EPSILON {
                break;
            }
        }
        let values: Vec<f64> = a
            .iter()
            .map(|column| libm::sqrt(dot(column, column)))
            .collect();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|i, j| values[*j].total_cmp(&values[*i]));
        let scaled = |at: usize| -> Vec<f64> {
            let inverse = if values[at] > 0.0 {
                1.0 / values[at]
            } else {
                0.0
            };
            a[at].iter().map(|entry| entry * inverse).collect()
        };
        Self {
            left: order.iter().map(|at| scaled(*at)).collect(),
            values: order.iter().map(|at| values[*at]).collect(),
            right: order.iter().map(|at| right[*at].clone()).collect(),
        }
    }

    /// The x of least norm that makes |A x − b| least, without values below `part` of the largest.
    pub fn solve(&self, b: &[f64], part: f64) -> Vec<f64> {
        let mut x = vec![0.0; self.right.len()];
        let least = part * self.values.first().copied().unwrap_or(0.0);
        for ((left, value), right) in self.left.iter().zip(&self.values).zip(&self.right) {
            if *value > least {
                let along = dot(left, b) / value;
                x.iter_mut().zip(right).for_each(|(x, v)| *x += along * v);
            }
        }
        x
    }
}

fn unit(n: usize, j: usize) -> Vec<f64> {
    let mut e = vec![0.0; n];
    e[j] = 1.0;
    e
}

fn rotate(columns: &mut Columns, (i, j): (usize, usize), (c, s): (f64, f64)) {
    let (head, tail) = columns.split_at_mut(j);
    for (x, y) in head[i].iter_mut().zip(&mut tail[0]) {
        (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
    }
}

/// A complex number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// |z|.
    pub fn modulus(self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// The argument in (−π, π].
    pub fn argument(self) -> f64 {
        libm::atan2(self.im, self.re)
    }

    pub(super) fn times(self, b: Self) -> Self {
        Self {
            re: self.re * b.re - self.im * b.im,
            im: self.re * b.im + self.im * b.re,
        }
    }

    fn plus(self, b: Self) -> Self {
        Self {
            re: self.re + b.re,
            im: self.im + b.im,
        }
    }

    fn minus(self, b: Self) -> Self {
        Self {
            re: self.re - b.re,
            im: self.im - b.im,
        }
    }

    fn conjugate(self) -> Self {
        Self {
            re: self.re,
            im: -self.im,
        }
    }

    pub(super) fn over(self, b: f64) -> Self {
        Self {
            re: self.re / b,
            im: self.im / b,
        }
    }

    fn root(self) -> Self {
        let r = self.modulus();
        let re = libm::sqrt(((r + self.re) / 2.0).max(0.0));
        let im = libm::sqrt(((r - self.re) / 2.0).max(0.0));
        Self {
            re,
            im: if self.im < 0.0 { -im } else { im },
        }
    }
}

/// Steps for one eigenvalue, at most.
const STEPS: usize = 100;

/// The eigenvalues of a square matrix by its columns: QR steps with shifts on its Hessenberg form, in complex numbers.
/// `None` where they do not converge.
pub(super) fn eigenvalues(columns: &Columns) -> Option<Vec<Complex>> {
    let mut n = columns.len();
    let mut a: Vec<Vec<Complex>> = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| Complex {
                    re: columns[j][i],
                    im: 0.0,
                })
                .collect()
        })
        .collect();
    // Hessenberg: entries below the subdiagonal go by rotations of rows and columns.
    for k in 0..n.saturating_sub(2) {
        for i in (k + 2..n).rev() {
            let turn = rotation(a[i - 1][k], a[i][k]);
            turn_rows(&mut a, i - 1, turn, 0);
            turn_columns(&mut a, i - 1, turn, n);
        }
    }
    let mut found = Vec::new();
    let mut tried = 0;
    while n > 0 {
        if n == 1 {
            found.push(a[0][0]);
            break;
        }
        let small = |a: &Vec<Vec<Complex>>, k: usize| {
            let size = a[k][k].modulus() + a[k - 1][k - 1].modulus();
            a[k][k - 1].modulus() <= f64::EPSILON * size
        };
        if small(&a, n - 1) {
            found.push(a[n - 1][n - 1]);
            n -= 1;
            tried = 0;
            continue;
        }
        tried += 1;
        if tried > STEPS {
            return None;
        }
        let first = (1..n - 1).rev().find(|k| small(&a, *k)).unwrap_or(0);
        // The eigenvalue of the last two rows that is nearer to the last entry; another one now and then.
        let [p, q, r, s] = [
            a[n - 2][n - 2],
            a[n - 2][n - 1],
            a[n - 1][n - 2],
            a[n - 1][n - 1],
        ];
        let half = p.minus(s).over(2.0);
        let root = half.times(half).plus(q.times(r)).root();
        let near = [half.plus(root), half.minus(root)];
        let near = if near[0].modulus() < near[1].modulus() {
            near[0]
        } else {
            near[1]
        };
        let shift = match tried % 11 {
            10 => s.plus(Complex {
                re: r.modulus(),
                im: 0.0,
            }),
            _ => s.plus(near),
        };
        for (k, row) in a.iter_mut().enumerate().take(n).skip(first) {
            row[k] = row[k].minus(shift);
        }
        let mut turns = Vec::new();
        for k in first..n - 1 {
            let turn = rotation(a[k][k], a[k + 1][k]);
            turn_rows(&mut a, k, turn, k);
            turns.push(turn);
        }
        for (k, turn) in (first..n - 1).zip(turns) {
            turn_columns(&mut a, k, turn, (k + 2).min(n));
        }
        for (k, row) in a.iter_mut().enumerate().take(n).skip(first) {
            row[k] = row[k].plus(shift);
        }
    }
    found.sort_by(|a, b| b.modulus().total_cmp(&a.modulus()));
    Some(found)
}

/// c and s with (c, s; −s̄, c)(x, y)ᵀ = (r, 0)ᵀ.
fn rotation(x: Complex, y: Complex) -> (f64, Complex) {
    let length = libm::hypot(x.modulus(), y.modulus());
    if y.modulus() == 0.0 || length == 0.0 {
        return (1.0, Complex { re: 0.0, im: 0.0 });
    }
    let size = x.modulus();
    let phase = match size > 0.0 {
        true => x.over(size),
        false => Complex { re: 1.0, im: 0.0 },
    };
    (size / length, phase.times(y.conjugate()).over(length))
}

fn turn_rows(a: &mut [Vec<Complex>], k: usize, (c, s): (f64, Complex), from: usize) {
    let (head, tail) = a.split_at_mut(k + 1);
    for (x, y) in head[k].iter_mut().zip(&mut tail[0]).skip(from) {
        let scaled = |z: Complex| Complex {
            re: c * z.re,
            im: c * z.im,
        };
        let [above, below] = [*x, *y];
        *x = scaled(above).plus(s.times(below));
        *y = scaled(below).minus(s.conjugate().times(above));
    }
}

/// The rotation's adjoint from the right.
fn turn_columns(a: &mut [Vec<Complex>], k: usize, (c, s): (f64, Complex), rows: usize) {
    for row in a.iter_mut().take(rows) {
        let scaled = |z: Complex| Complex {
            re: c * z.re,
            im: c * z.im,
        };
        let [left, right] = [row[k], row[k + 1]];
        row[k] = scaled(left).plus(s.conjugate().times(right));
        row[k + 1] = scaled(right).minus(s.times(left));
    }
}
