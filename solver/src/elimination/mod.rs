//! Elimination of small dense matrices, W of them side by side.
//!
//! The dimension is a constant `D` where that pays, and [`ANY`] otherwise: `D` = `ANY` reads it from
//! the number of rows.

mod inverse;
#[cfg(test)]
mod tests;

use leafwise_expression::kernel::apart;

use super::columns::substitute;
use inverse::{by_cofactors, is_inverted, is_near_one, multiply};

/// A dimension that is known at run time only.
pub(crate) const ANY: usize = 0;

/// The dimension `D`, or `rows` where that is [`ANY`].
#[inline(always)]
pub(crate) fn dimension<const D: usize>(rows: usize) -> usize {
    if D == ANY { rows } else { D }
}

/// Rows of W numbers: inline where their number is known when this is compiled.
pub(crate) trait Rows<const W: usize>:
    AsRef<[[f64; W]]> + AsMut<[[f64; W]]> + Clone + Send + 'static
{
    /// So many rows of zeros; a type with a number of its own has that.
    fn zeros(rows: usize) -> Self;
    /// The rows, to be put back: inline ones as a copy, which may stay in registers meanwhile, others moved.
    fn take(&mut self) -> Self;
}

impl<const W: usize, const N: usize> Rows<W> for [[f64; W]; N] {
    fn zeros(rows: usize) -> Self {
        debug_assert_eq!(rows, N, "the type's number of rows");
        [[0.0; W]; N]
    }

    #[inline(always)]
    fn take(&mut self) -> Self {
        *self
    }
}

impl<const W: usize> Rows<W> for Vec<[f64; W]> {
    fn zeros(rows: usize) -> Self {
        vec![[0.0; W]; rows]
    }

    #[inline(always)]
    fn take(&mut self) -> Self {
        std::mem::take(self)
    }
}

/// P A = L U of W matrices; the reciprocals of the pivots stand on the diagonal. Of 2 × 2 and
/// 3 × 3 matrices the inverses themselves: a solve then does not wait for one quotient after the other.
///
/// Near the identity, where every pivot lies between 1/2 and 2, rows stay as they stand. All lanes are then
/// eliminated at once, without a search. A change of units, S⁻¹AS with S diagonal, changes no pivot. A lane that is
/// not near is eliminated alone, by partial pivoting of its rows over Σ_j |a_rj| s_j, with the sizes s of the
/// unknowns. That is as independent of units (R. Skeel, *Scaling for numerical stability in Gaussian elimination*, J.
/// ACM 26 (1979)).
#[derive(Clone, Debug)]
pub(crate) struct Factors<const W: usize, M = Vec<[f64; W]>> {
    entries: M,
    /// The row that was exchanged with row k before column k was eliminated.
    exchanges: Vec<[usize; W]>,
    /// Whether a lane is eliminated alone, with exchanges.
    exchanged: [bool; W],
    near: [bool; W],
    kept: Vec<[f64; W]>,
    single: Vec<f64>,
    /// Weights that a row's entries are multiplied by where pivots are chosen, and the sizes of the unknowns.
    weights: Vec<f64>,
    sizes: Vec<f64>,
}

impl<const W: usize, M: Rows<W>> Factors<W, M> {
    /// Room for d × d matrices.
    pub(crate) fn new(d: usize) -> Self {
        Self {
            entries: M::zeros(d * d),
            exchanges: vec![[0; W]; d],
            exchanged: [false; W],
            near: [false; W],
            kept: vec![[0.0; W]; if W > 1 { d * d } else { 0 }],
            single: vec![0.0; d * d],
            weights: vec![1.0; d],
            sizes: vec![1.0; d],
        }
    }

    /// Factors `matrix`, row-major, in the lanes of `wanted`; the others keep their factors. `sizes` are those of the
    /// unknowns; none where all are of one size. Returns where a wanted matrix is singular or not finite.
    #[inline(always)]
    pub(crate) fn factor<const D: usize>(
        &mut self,
        matrix: &[[f64; W]],
        sizes: &[[f64; W]],
        wanted: &[bool; W],
    ) -> [bool; W] {
        if is_inverted::<D>() {
            return self.invert::<D>(matrix, sizes, wanted);
        }
        let d = dimension::<D>(self.exchanges.len());
        let (entries, matrix) = (&mut self.entries.as_mut()[..d * d], &matrix[..d * d]);
        let all = wanted.iter().all(|wanted| *wanted);
        if !all {
            self.kept.copy_from_slice(entries);
        }
        if D == ANY {
            unsigned(entries, matrix);
        } else {
            for (entry, value) in entries.iter_mut().zip(matrix) {
                *entry = *value;
                apart::<W>();
            }
        }
        let near = eliminate::<D, W>(entries, d);
        if !all {
            for (entry, kept) in entries.iter_mut().zip(&self.kept) {
                for w in 0..W {
                    entry[w] = if wanted[w] { entry[w] } else { kept[w] };
                }
            }
        }
        let mut singular = [false; W];
        for w in 0..W {
            if wanted[w] {
                (self.near[w], self.exchanged[w]) = (near[w], !near[w]);
                singular[w] = !near[w] && !self.factor_alone(matrix, sizes, w);
            }
        }
        singular
    }

    /// Whether every pivot of a lane lies between 1/2 and 2, rows as they stand.
    #[inline(always)]
    pub(crate) fn is_near_identity(&self, lane: usize) -> bool {
        self.near[lane]
    }

    /// Whether the determinant of a lane's matrix is positive: its pivots' and exchanges' signs.
    pub(crate) fn has_positive_determinant(&self, lane: usize) -> bool {
        let d = self.exchanges.len();
        let entries = self.entries.as_ref();
        let negative = (0..d).filter(|k| entries[k * (d + 1)][lane] < 0.0);
        let exchanges = self.exchanges.iter().enumerate();
        let exchanged = exchanges.filter(|(k, row)| self.exchanged[lane] && row[lane] != *k);
        (negative.count() + exchanged.count()).is_multiple_of(2)
    }

    /// One lane with exchanges of rows; `false` where a pivot is zero or not finite.
    #[cold]
    fn factor_alone(&mut self, matrix: &[[f64; W]], sizes: &[[f64; W]], lane: usize) -> bool {
        let d = self.exchanges.len();
        for (value, entry) in self.single.iter_mut().zip(matrix) {
            *value = entry[lane] + 0.0;
        }
        self.weigh(sizes, lane);
        let (a, weights) = (&mut self.single, &mut self.weights);
        for k in 0..d {
            let weighted = |row: usize| a[row * d + k].abs() * weights[row];
            let largest = |best: usize, row: usize| {
                if weighted(row) > weighted(best) {
                    row
                } else {
                    best
                }
            };
            let pivot = (k + 1..d).fold(k, largest);
            self.exchanges[k][lane] = pivot;
            weights.swap(pivot, k);
            // Whole rows, the multipliers in them too: as one permutation from the start.
            for column in 0..d {
                a.swap(pivot * d + column, k * d + column);
            }
            let reciprocal = 1.0 / a[k * d + k];
            if !reciprocal.is_finite() || reciprocal == 0.0 {
                return false;
            }
            a[k * d + k] = reciprocal;
            let (above, below) = a.split_at_mut((k + 1) * d);
            let pivots = above[k * d + k + 1..].as_chunks::<1>().0;
            let may_skip = is_finite(pivots);
            for row in below.chunks_exact_mut(d) {
                let factor = row[k] * reciprocal;
                row[k] = factor;
                if may_skip && factor == 0.0 {
                    continue;
                }
                for (entry, pivot) in row[k + 1..].iter_mut().zip(pivots) {
                    *entry -= factor * pivot[0];
                }
            }
        }
        for (entry, value) in self.entries.as_mut().iter_mut().zip(a) {
            entry[lane] = *value;
        }
        true
    }

    /// The weights of the rows: 1/Σ_j |a_rj| s_j. An unknown without a size has that of what the others put into it,
    /// Σ_k |a_jk| s_k.
    fn weigh(&mut self, sizes: &[[f64; W]], lane: usize) {
        let d = self.exchanges.len();
        self.weights.fill(1.0);
        if sizes.is_empty() {
            return;
        }
        let (a, own, weights) = (&self.single, &mut self.sizes, &mut self.weights);
        let sum = |row: usize, sizes: &[f64]| {
            let entries = a[row * d..][..d].iter().zip(sizes);
            entries
                .map(|(entry, size)| (entry * size).abs())
                .sum::<f64>()
        };
        for (own, size) in own.iter_mut().zip(sizes) {
            *own = size[lane].abs();
        }
        for (row, weight) in weights.iter_mut().enumerate() {
            *weight = if own[row] == 0.0 {
                sum(row, own)
            } else {
                own[row]
            };
        }
        own.copy_from_slice(weights);
        for (row, weight) in weights.iter_mut().enumerate() {
            let inverse = 1.0 / sum(row, own);
            *weight = if inverse.is_finite() { inverse } else { 1.0 };
        }
    }

    /// A⁻¹ r in place of r, in every lane.
    #[inline(always)]
    pub(crate) fn solve<const D: usize>(&self, right: &mut [[f64; W]]) {
        let d = dimension::<D>(self.exchanges.len());
        let (right, entries) = (&mut right[..d], &self.entries.as_ref()[..d * d]);
        if is_inverted::<D>() {
            return multiply(entries, right);
        }
        for lane in 0..W {
            if self.exchanged[lane] {
                self.exchange(right, lane);
            }
        }
        for row in 1..d {
            let (known, rest) = right.split_at_mut(row);
            let entries = &entries[row * d..][..row];
            for (entry, known) in entries.iter().zip(known) {
                rest[0] = less(&rest[0], entry, known);
            }
        }
        for row in (0..d).rev() {
            let (rest, known) = right.split_at_mut(row + 1);
            let entries = &entries[row * d + row..][..d - row];
            for (entry, known) in entries[1..].iter().zip(known) {
                rest[row] = less(&rest[row], entry, known);
            }
            for w in 0..W {
                rest[row][w] *= entries[0][w];
            }
        }
    }

    #[cold]
    fn exchange(&self, right: &mut [[f64; W]], lane: usize) {
        for (k, exchange) in self.exchanges.iter().enumerate() {
            let other = exchange[lane];
            let (a, b) = (right[k][lane], right[other][lane]);
            (right[k][lane], right[other][lane]) = (b, a);
        }
    }
}

impl<const W: usize, M: Rows<W>> Factors<W, M> {
    /// The inverse of a small matrix: by cofactors where it is near the identity, by elimination of a lane
    /// alone elsewhere.
    #[inline(always)]
    fn invert<const D: usize>(
        &mut self,
        matrix: &[[f64; W]],
        sizes: &[[f64; W]],
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
                singular[w] = !near[w] && !self.invert_alone::<D>(matrix, sizes, w);
            }
        }
        singular
    }

    /// One lane's inverse by elimination with exchanges; `false` where a pivot is zero or not finite.
    #[cold]
    fn invert_alone<const D: usize>(
        &mut self,
        matrix: &[[f64; W]],
        sizes: &[[f64; W]],
        lane: usize,
    ) -> bool {
        if !self.factor_alone(matrix, sizes, lane) {
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
        true
    }
}

impl<M: Rows<1>> Factors<1, M> {
    /// A⁻¹ R in place of R, d rows of so many columns: the bits of [`solve`](Self::solve) in each.
    pub(crate) fn solve_columns(&self, right: &mut [f64], columns: usize) {
        let (d, entries) = (self.exchanges.len(), self.entries.as_ref());
        if self.exchanged[0] {
            for (k, [other]) in self.exchanges.iter().enumerate() {
                for column in 0..columns {
                    right.swap(k * columns + column, other * columns + column);
                }
            }
        }
        substitute(entries.as_flattened(), d, right, columns);
    }
}

/// value − factor·other.
///
/// Returns a number and takes no place to write it. The compiler keeps what it knows of the places of one call, that
/// they are not those it reads. It keeps that for the calls of later rounds of an unrolled loop, which read what
/// earlier ones wrote (llvm/llvm-project#79137 is one of its kind).
#[inline(always)]
fn less<const W: usize>(value: &[f64; W], factor: &[f64; W], other: &[f64; W]) -> [f64; W] {
    std::array::from_fn(|w| value[w] - factor[w] * other[w])
}

/// `matrix` with every zero positive. No subtraction of an elimination makes a negative one of it, so
/// that subtracting zeros changes no entry and may be left out.
#[inline(always)]
fn unsigned<const W: usize>(entries: &mut [[f64; W]], matrix: &[[f64; W]]) {
    for (entry, value) in entries.iter_mut().zip(matrix) {
        for w in 0..W {
            entry[w] = value[w] + 0.0;
        }
    }
}

/// Whether zero times each entry is zero.
#[inline(always)]
fn is_finite<const W: usize>(row: &[[f64; W]]) -> bool {
    row.iter().flatten().all(|entry| entry.is_finite())
}

/// Elimination without exchanges; `true` where every pivot lies between 1/2 and 2.
///
/// Rows that a column does not reach are left as they are: of long systems that couple few coordinates
/// most are such.
#[inline(always)]
fn eliminate<const D: usize, const W: usize>(a: &mut [[f64; W]], d: usize) -> [bool; W] {
    let d = dimension::<D>(d);
    let a = &mut a[..d * d];
    let mut near = [true; W];
    for k in 0..d {
        let pivot = a[k * d + k];
        let reciprocal = pivot.map(|pivot| 1.0 / pivot);
        for w in 0..W {
            near[w] &= is_near_one(pivot[w]);
        }
        a[k * d + k] = reciprocal;
        let (above, below) = a.split_at_mut((k + 1) * d);
        let pivots = &above[k * d + k + 1..][..d - k - 1];
        let may_skip = D == ANY && is_finite(pivots);
        for row in below.chunks_exact_mut(d) {
            let mut factor = row[k];
            for w in 0..W {
                factor[w] *= reciprocal[w];
            }
            row[k] = factor;
            if may_skip && factor == [0.0; W] {
                continue;
            }
            for (entry, pivot) in row[k + 1..].iter_mut().zip(pivots) {
                *entry = less(entry, &factor, pivot);
            }
        }
    }
    near
}
