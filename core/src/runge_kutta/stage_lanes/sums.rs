//! Σ_j m_j f_j over lanes: the columns of a matrix times the slopes of the stages.

use leafwise_expression::vector::Register;

/// A matrix by columns: entry i of column j belongs to lane i. Its columns lie in whole lines of the cache.
#[repr(align(64))]
pub(super) struct Columns<const W: usize>(pub [[f64; W]; W]);

impl<const W: usize> Columns<W> {
    /// `factor` times a row-major s × s matrix; 0 beyond s.
    pub(super) fn of(matrix: &[f64], s: usize, factor: f64) -> Box<Self> {
        let mut columns = Box::new(Self([[0.0; W]; W]));
        for (i, row) in matrix.chunks_exact(s).enumerate() {
            for (column, entry) in columns.0.iter_mut().zip(row) {
                column[i] = factor * entry;
            }
        }
        columns
    }
}

/// Sums that do not wait for one another, of every fourth column.
const PARTS: usize = 4;

/// z_c + Σ_j m_j f_cj of K coordinates c over the lanes of a register from `first` on, the sums alone where z `IS_ZERO`. A column is
/// read once for all K.
///
/// Loops alone here and wherever it is called: closures and iterators are compiled for the baseline where they are not inlined.
#[inline(always)]
pub(super) fn sums<R: Register, const W: usize, const K: usize, const IS_ZERO: bool>(
    z: &[f64; K],
    columns: &Columns<W>,
    slopes: &[[f64; W]; K],
    first: usize,
) -> [R; K] {
    let mut parts = [[R::splat(0.0); PARTS]; K];
    for j in 0..W {
        let column = R::load(&columns.0[j][first..]);
        for c in 0..K {
            let slope = R::splat(slopes[c][j]);
            parts[c][j % PARTS] = match j < PARTS {
                true => column * slope,
                false => column.times_plus(slope, parts[c][j % PARTS]),
            };
        }
    }
    let mut all = [R::splat(0.0); K];
    for c in 0..K {
        let [a, b, c_, d] = parts[c];
        all[c] = match W {
            1 => a,
            2 => a + b,
            _ => (a + b) + (c_ + d),
        };
        if !IS_ZERO {
            all[c] = R::splat(z[c]) + all[c];
        }
    }
    all
}

/// Runs `$block` for blocks of K coordinates from c on: as many as have their sums in registers `$r`, and 2 and 1 at the end.
macro_rules! by_blocks {
    ($r:ident, $n:expr, $c:ident, $k:ident => $block:expr) => {{
        let mut $c = 0;
        while $r::LANES == 8 && $c + 4 <= $n {
            const $k: usize = 4;
            $block;
            $c += 4;
        }
        while $c + 2 <= $n {
            const $k: usize = 2;
            $block;
            $c += 2;
        }
        if $c < $n {
            const $k: usize = 1;
            $block;
        }
    }};
}

pub(super) use by_blocks;

/// K neighbours from `at` on.
#[inline(always)]
pub(super) fn block<T, const K: usize>(rows: &[T], at: usize) -> &[T; K] {
    rows[at..].first_chunk().expect("a block of rows")
}

/// The same, to write.
#[inline(always)]
pub(super) fn block_mut<T, const K: usize>(rows: &mut [T], at: usize) -> &mut [T; K] {
    rows[at..].first_chunk_mut().expect("a block of rows")
}

/// The sum over the lanes, of halves first.
#[inline(always)]
pub(super) fn sum_of_lanes<const W: usize>(lanes: &[f64; W]) -> f64 {
    let mut sums = *lanes;
    let mut count = W;
    while count > 1 {
        count /= 2;
        for lane in 0..count {
            sums[lane] += sums[lane + count];
        }
    }
    sums[0]
}
