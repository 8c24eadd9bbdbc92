//! Multipliers of an orbit: eigenvalues of the monodromy M but for those that are 1 by the time and the integrals.

use super::linear::{Columns, Complex, SingularValues, eigenvalues};
use super::newton::length;

/// Singular values of M − 1 that are taken for zeros, over its size. The first bound serves with which the multipliers add up to
/// the trace of M. Where neighbours part by much, as next to a mass, small values are no zeros.
const KERNEL: [f64; 4] = [1e-7, 1e-9, 1e-11, 1e-13];

/// How far that sum may be from the trace, relative.
const TRACE: f64 = 1e-5;

/// Multipliers that are nearer to each other meet: two that do are known to the root of the round-off.
const TOGETHER: f64 = 1e-3;

/// Which part of M its other multipliers are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kernel {
    /// Singular values of M − 1 that are no zeros.
    pub rank: usize,
    /// Vectors of its kernel in its image.
    pub inside: usize,
}

/// Multipliers that are 1 by the time and the integrals, and the others.
#[derive(Clone, Debug)]
pub(super) struct Multipliers {
    pub kernel: Kernel,
    pub trivial: usize,
    pub others: Vec<Complex>,
}

impl Multipliers {
    /// Those of a monodromy; else the size of M − 1.
    pub fn of(monodromy: &Columns) -> Result<Self, f64> {
        let parts = SingularValues::of(&less_one(monodromy));
        let size = parts.values[0].max(1.0);
        let trace: f64 = (0..monodromy.len()).map(|i| monodromy[i][i]).sum();
        let found = KERNEL.iter().find_map(|part| {
            let rank = parts.values.iter().filter(|value| **value > part * size);
            let all = Self::reduced(monodromy, &parts, (rank.count(), None))?;
            let sum = all.trivial as f64 + all.others.iter().map(|of| of.re).sum::<f64>();
            let scale = 1.0 + all.others.iter().map(|of| of.modulus()).sum::<f64>();
            ((sum - trace).abs() <= TRACE * scale).then_some(all)
        });
        found.ok_or(size)
    }

    /// Those of a monodromy whose kernel is as that of its neighbours: at a bifurcation one more multiplier is 1.
    pub fn with(monodromy: &Columns, kernel: Kernel) -> Option<Self> {
        let parts = SingularValues::of(&less_one(monodromy));
        Self::reduced(monodromy, &parts, (kernel.rank, Some(kernel.inside)))
    }

    fn reduced(
        monodromy: &Columns,
        parts: &SingularValues,
        (rank, inside): (usize, Option<usize>),
    ) -> Option<Self> {
        let (matrix, inside) = reduced(monodromy, parts, (rank, inside));
        let others = eigenvalues(&matrix)?;
        Some(Self {
            kernel: Kernel { rank, inside },
            trivial: monodromy.len() - others.len(),
            others,
        })
    }
}

fn less_one(monodromy: &Columns) -> Columns {
    let mut less = monodromy.clone();
    (0..less.len()).for_each(|i| less[i][i] -= 1.0);
    less
}

/// M in the image of M − 1, given its singular values of which so many are no zeros, but for its own vectors in that image.
/// How many these are where that is not known.
fn reduced(
    monodromy: &Columns,
    parts: &SingularValues,
    (rank, inside): (usize, Option<usize>),
) -> (Columns, usize) {
    let d = monodromy.len();
    // The image of M − 1 is what all integrals leave; in it lie those of the kernel that are no motion across leaves.
    let image = &parts.left[..rank];
    let project = |v: &Vec<f64>| -> Vec<f64> {
        image
            .iter()
            .map(|u| u.iter().zip(v).map(|(a, b)| a * b).sum())
            .collect()
    };
    let own: Columns = parts.right[rank..].iter().map(project).collect();
    let found = SingularValues::of(&own);
    let whole = found.values.iter().filter(|value| **value > 0.5).count();
    let inside = inside.unwrap_or(whole).min(found.left.len());
    let kept: Columns = found.left[..inside].to_vec();
    let basis = complement(&kept, rank);
    // Its vectors in the state's coordinates.
    let basis: Columns = basis
        .iter()
        .map(|own| {
            let mut v = vec![0.0; d];
            for (part, u) in own.iter().zip(image) {
                v.iter_mut().zip(u).for_each(|(v, u)| *v += part * u);
            }
            v
        })
        .collect();
    let columns = basis
        .iter()
        .map(|v| {
            let mut moved = vec![0.0; d];
            for (part, column) in v.iter().zip(monodromy) {
                moved
                    .iter_mut()
                    .zip(column)
                    .for_each(|(m, c)| *m += part * c);
            }
            basis
                .iter()
                .map(|w| w.iter().zip(&moved).map(|(a, b)| a * b).sum())
                .collect()
        })
        .collect();
    (columns, inside)
}

/// An orthonormal basis of what is at right angles to orthonormal vectors.
pub(super) fn complement(vectors: &Columns, dimension: usize) -> Columns {
    let mut all: Columns = vectors.clone();
    while all.len() < dimension {
        let candidates = (0..dimension).map(|j| {
            let mut v = vec![0.0; dimension];
            v[j] = 1.0;
            for _ in 0..2 {
                for u in &all {
                    let along: f64 = u.iter().zip(&v).map(|(a, b)| a * b).sum();
                    v.iter_mut().zip(u).for_each(|(v, u)| *v -= along * u);
                }
            }
            v
        });
        let longest = candidates.max_by(|a, b| length(a).total_cmp(&length(b)));
        let Some(mut v) = longest else { break };
        let size = length(&v);
        v.iter_mut().for_each(|entry| *entry /= size);
        all.push(v);
    }
    all.split_off(vectors.len())
}

/// The discriminant of the n sums s = μ + 1/μ of multiplier pairs, over their sizes. It is the determinant of the power sums
/// p_{i+j}, each half of that over all multipliers. Real pairs and those on the unit circle have a real s.
pub(super) fn discriminant(multipliers: &[Complex]) -> f64 {
    let n = multipliers.len() / 2;
    if n < 2 {
        return 1.0;
    }
    let sums: Vec<Complex> = multipliers
        .iter()
        .map(|of| {
            let square = of.modulus() * of.modulus();
            Complex {
                re: of.re + of.re / square,
                im: of.im - of.im / square,
            }
        })
        .collect();
    let size = sums.iter().fold(1.0_f64, |most, s| most.max(s.modulus()));
    let mut powers = vec![Complex { re: 0.5, im: 0.0 }; sums.len()];
    let sums: Vec<Complex> = sums.into_iter().map(|s| s.over(size)).collect();
    let mut moments = Vec::new();
    for _ in 0..2 * n - 1 {
        moments.push(powers.iter().map(|power| power.re).sum::<f64>());
        let pairs = powers.iter_mut().zip(&sums);
        pairs.for_each(|(power, s)| *power = power.times(*s));
    }
    determinant((0..n).map(|i| moments[i..i + n].to_vec()).collect())
}

/// The determinant of a matrix by its rows, with pivots.
fn determinant(mut rows: Vec<Vec<f64>>) -> f64 {
    let n = rows.len();
    let mut product = 1.0;
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs()));
        let pivot = pivot.unwrap_or(k);
        if pivot != k {
            rows.swap(pivot, k);
            product = -product;
        }
        product *= rows[k][k];
        if rows[k][k] == 0.0 {
            return 0.0;
        }
        let (head, tail) = rows.split_at_mut(k + 1);
        for row in tail {
            let factor = row[k] / head[k][k];
            let pairs = row.iter_mut().zip(&head[k]);
            pairs.for_each(|(entry, own)| *entry -= factor * own);
        }
    }
    product
}

/// Whether the two multipliers in the upper half plane that are nearest to each other are on the unit circle.
pub(super) fn meet_on_the_circle(multipliers: &[Complex]) -> bool {
    let upper: Vec<&Complex> = multipliers.iter().filter(|of| of.im > 0.0).collect();
    let pairs = (0..upper.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let near = pairs.filter(|(i, j)| {
        let [a, b] = [upper[*i], upper[*j]];
        libm::hypot(a.re - b.re, a.im - b.im) < TOGETHER
    });
    let mut near = near.map(|(i, j)| upper[i].modulus().max(upper[j].modulus()));
    near.any(|size| (size - 1.0).abs() < TOGETHER)
}
