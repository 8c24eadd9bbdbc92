//! Elimination of small dense matrices, W of them side by side.
//!
//! The dimension is a constant `D` where that pays, and [`ANY`] otherwise: `D` = `ANY` reads it from
//! the number of rows.

mod inverse;

use leafwise_expression::kernel::apart;

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

/// P A = L U of W matrices by partial pivoting; the reciprocals of the pivots stand on the diagonal. Of 2 × 2 and
/// 3 × 3 matrices the inverses themselves: a solve then does not wait for one quotient after the other.
///
/// Near the identity every pivot is the largest of its column where it stands: all lanes are then
/// eliminated at once, without a search. A lane where one is not is eliminated alone.
#[derive(Clone, Debug)]
pub(crate) struct Factors<const W: usize, M = Vec<[f64; W]>> {
    entries: M,
    /// The row that was exchanged with row k before column k was eliminated.
    exchanges: Vec<[usize; W]>,
    exchanged: [bool; W],
    /// Of a lane with exchanges: whether it would be near the identity without them.
    near: [bool; W],
    kept: Vec<[f64; W]>,
    single: Vec<f64>,
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
        }
    }

    /// Factors `matrix`, row-major, in the lanes of `wanted`; the others keep their factors. Returns
    /// where a wanted matrix is singular or not finite.
    #[inline(always)]
    pub(crate) fn factor<const D: usize>(
        &mut self,
        matrix: &[[f64; W]],
        wanted: &[bool; W],
    ) -> [bool; W] {
        if is_inverted::<D>() {
            return self.invert::<D>(matrix, wanted);
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
        let in_place = eliminate::<D, W>(entries, d);
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
                self.exchanged[w] = !in_place[w];
                singular[w] = !in_place[w] && !self.factor_alone(matrix, w);
            }
        }
        singular
    }

    /// Whether every pivot of a lane lies between 1/2 and 2, rows as they stand. A change of units,
    /// S⁻¹AS with S diagonal, does not change the pivots.
    #[inline(always)]
    pub(crate) fn is_near_identity<const D: usize>(&self, lane: usize) -> bool {
        if is_inverted::<D>() {
            return self.near[lane];
        }
        let d = dimension::<D>(self.exchanges.len());
        let entries = &self.entries.as_ref()[..d * d];
        let mut near = true;
        for k in 0..d {
            near &= is_near_one(entries[k * (d + 1)][lane]);
        }
        if self.exchanged[lane] {
            self.near[lane]
        } else {
            near
        }
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
    fn factor_alone(&mut self, matrix: &[[f64; W]], lane: usize) -> bool {
        let d = self.exchanges.len();
        let a = &mut self.single;
        let load = |a: &mut Vec<f64>| {
            for (value, entry) in a.iter_mut().zip(matrix) {
                *value = entry[lane] + 0.0;
            }
        };
        load(a);
        eliminate::<ANY, 1>(a.as_chunks_mut().0, d);
        self.near[lane] = (0..d).all(|k| is_near_one(a[k * (d + 1)]));
        load(a);
        for k in 0..d {
            let largest = |best: usize, row: usize| {
                if a[row * d + k].abs() > a[best * d + k].abs() {
                    row
                } else {
                    best
                }
            };
            let pivot = (k + 1..d).fold(k, largest);
            self.exchanges[k][lane] = pivot;
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
    fn invert<const D: usize>(&mut self, matrix: &[[f64; W]], wanted: &[bool; W]) -> [bool; W] {
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
        for row in 1..d {
            let (known, rest) = right.split_at_mut(row * columns);
            for (entry, known) in entries[row * d..].iter().zip(known.chunks_exact(columns)) {
                for (value, known) in rest[..columns].iter_mut().zip(known) {
                    *value -= entry[0] * known;
                }
            }
        }
        for row in (0..d).rev() {
            let (rest, known) = right.split_at_mut((row + 1) * columns);
            let rest = &mut rest[row * columns..];
            let entries = &entries[row * d + row..][..d - row];
            for (entry, known) in entries[1..].iter().zip(known.chunks_exact(columns)) {
                for (value, known) in rest.iter_mut().zip(known) {
                    *value -= entry[0] * known;
                }
            }
            rest.iter_mut().for_each(|value| *value *= entries[0][0]);
        }
    }
}

/// value − factor·other.
///
/// A number and no place to write it: the compiler keeps what it knows of the places of one call, that they are not
/// those it reads, for the calls of later rounds of an unrolled loop, which read what earlier ones wrote
/// (llvm/llvm-project#79137 is one of its kind).
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

/// Elimination without exchanges; `true` where partial pivoting would have made none either.
///
/// Rows that a column does not reach are left as they are: of long systems that couple few coordinates
/// most are such.
#[inline(always)]
fn eliminate<const D: usize, const W: usize>(a: &mut [[f64; W]], d: usize) -> [bool; W] {
    let d = dimension::<D>(d);
    let a = &mut a[..d * d];
    let mut in_place = [true; W];
    for k in 0..d {
        let pivot = a[k * d + k];
        let reciprocal = pivot.map(|pivot| 1.0 / pivot);
        for w in 0..W {
            in_place[w] &= reciprocal[w].is_finite() && reciprocal[w] != 0.0;
        }
        a[k * d + k] = reciprocal;
        let (above, below) = a.split_at_mut((k + 1) * d);
        let pivots = &above[k * d + k + 1..][..d - k - 1];
        let may_skip = D == ANY && is_finite(pivots);
        for row in below.chunks_exact_mut(d) {
            let mut factor = row[k];
            for w in 0..W {
                in_place[w] &= factor[w].abs() <= pivot[w].abs();
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
    in_place
}

#[cfg(test)]
mod tests {
    use super::{ANY, Factors, Rows};

    /// Solves one system in lane 1 of 2, the other lane's being the identity.
    fn solve<const D: usize>(a: &[f64], r: &[f64]) -> Option<Vec<f64>> {
        let d = r.len();
        let unit = |at: usize| f64::from(u8::from(at.is_multiple_of(d + 1)));
        let matrix: Vec<[f64; 2]> = a.iter().enumerate().map(|(at, v)| [unit(at), *v]).collect();
        let mut right: Vec<[f64; 2]> = r.iter().map(|v| [*v, *v]).collect();
        let mut factors = Factors::<2>::new(d);
        let singular = factors.factor::<D>(&matrix, &[true; 2]);
        assert!(!singular[0]);
        factors.solve::<D>(&mut right);
        assert!(right.iter().zip(r).all(|(solved, r)| solved[0] == *r));
        (!singular[1]).then(|| right.iter().map(|v| v[1]).collect())
    }

    #[test]
    fn solves_with_a_zero_leading_entry() {
        let a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0];
        let r = [7.0, 3.0, 6.0];
        // The residual of elimination with pivoting, and of the inverse: a few roundings of entries up to 7.
        for found in [solve::<3>(&a, &r), solve::<ANY>(&a, &r)] {
            for (found, expected) in found.expect("regular").iter().zip([1.0, 2.0, 3.0]) {
                assert!((found - expected).abs() <= 8.0 * f64::EPSILON, "{found}");
            }
        }
    }

    #[test]
    fn refuses_matrices_that_are_singular_or_not_finite() {
        for a in [[1.0, 2.0, 2.0, 4.0], [0.0; 4], [1.0, f64::NAN, 0.0, 1.0]] {
            assert_eq!(solve::<2>(&a, &[1.0, 1.0]), None, "{a:?}");
        }
    }

    /// Rows that are left out are not told from rows from which nothing is subtracted.
    #[test]
    fn zeros_are_left_out_without_changing_a_bit() {
        const D: usize = 6;
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut solved = 0;
        for sparsity in [-1.0, -0.5, 0.0, 0.5] {
            for _ in 0..100 {
                let entry = |_| if random() < sparsity { 0.0 } else { random() };
                let mut a: Vec<f64> = (0..D * D).map(entry).collect();
                let r: Vec<f64> = (0..D).map(|_| random()).collect();
                let bits = |z: Option<Vec<f64>>| z.map(|z| z.iter().map(|z| z.to_bits()).collect());
                let both = |a: &[f64]| -> [Option<Vec<u64>>; 2] {
                    [bits(solve::<D>(a, &r)), bits(solve::<ANY>(a, &r))]
                };
                let [whole, left_out] = both(&a);
                assert_eq!(whole, left_out);
                solved += usize::from(whole.is_some());
                a[3] = f64::INFINITY;
                let [whole, left_out] = both(&a);
                assert_eq!(whole, left_out);
            }
        }
        assert!(solved > 200, "{solved}");
    }

    /// By the formula for 2 × 2, in units that force exchanges or do not.
    #[test]
    fn the_sign_of_the_determinant_and_nearness_do_not_depend_on_units() {
        let entries = [-3.0_f64, -1.0, -0.2, 0.0, 0.2, 1.0, 3.0];
        let mut counts = [0, 0];
        for at in 0..7_usize.pow(4) {
            let [a, b, c, d] = std::array::from_fn(|k| entries[at / 7_usize.pow(k as u32) % 7]);
            let determinant: f64 = a * d - b * c;
            if determinant.abs() < 1e-12 {
                continue;
            }
            let near = |pivot: f64| pivot > 0.5 && pivot < 2.0;
            let is_near = near(a) && near(d - b * c / a);
            for unit in [1.0, libm::exp2(40.0), libm::exp2(-40.0)] {
                let mut factors = Factors::<1>::new(2);
                let matrix = [[a], [b * unit], [c / unit], [d]];
                let [singular] = factors.factor::<ANY>(&matrix, &[true]);
                assert!(!singular);
                let positive = factors.has_positive_determinant(0);
                assert_eq!(positive, determinant > 0.0, "{a} {b} {c} {d} in {unit}");
                assert_eq!(
                    factors.is_near_identity::<ANY>(0),
                    is_near,
                    "{a} {b} {c} {d}"
                );
                counts[usize::from(is_near)] += 1;
            }
        }
        assert!(counts[0] > 100 && counts[1] > 100);
    }

    #[test]
    fn columns_are_solved_to_the_bits_of_each_alone() {
        let at = |k: usize| libm::sin(1.0 + (k * k % 37) as f64);
        for exchanges in [false, true] {
            const D: usize = 5;
            let unit = |k: usize| if k.is_multiple_of(D + 1) { 9.0 } else { 0.0 };
            let entry = |k: usize| [at(k) + if exchanges { 0.0 } else { unit(k) }];
            let matrix: Vec<[f64; 1]> = (0..D * D).map(entry).collect();
            let mut factors = Factors::<1>::new(D);
            assert_eq!(factors.factor::<ANY>(&matrix, &[true]), [false]);
            assert_eq!(factors.exchanged, [exchanges]);
            for columns in 1..10 {
                let right: Vec<f64> = (0..D * columns).map(|k| at(k + 100)).collect();
                let mut together = right.clone();
                factors.solve_columns(&mut together, columns);
                for column in 0..columns {
                    let of = |all: &[f64]| -> Vec<[f64; 1]> {
                        (0..D).map(|row| [all[row * columns + column]]).collect()
                    };
                    let mut alone = of(&right);
                    factors.solve::<ANY>(&mut alone);
                    assert_eq!(alone, of(&together), "column {column} of {columns}");
                }
            }
        }
    }

    /// A of D×D near the identity and away from it, r: every lane's solution has the bits of its own.
    fn check_lanes<const D: usize, const W: usize, M: Rows<W>, S: Rows<1>>() {
        let lane = |at: usize, w: usize| libm::sin(1.0 + (at * at % 37 + 5 * w) as f64);
        for size in [0.1, 1.0] {
            let unit = |at: usize| f64::from(u8::from(at.is_multiple_of(D + 1)));
            let entry = |at: usize, w: usize| unit(at) + size * lane(at, w);
            let matrix: Vec<[f64; W]> = (0..D * D)
                .map(|at| std::array::from_fn(|w| entry(at, w)))
                .collect();
            let right: [[f64; W]; D] =
                std::array::from_fn(|at| std::array::from_fn(|w| lane(at + 100, w)));
            let mut factors = Factors::<W, M>::new(D);
            assert_eq!(factors.factor::<D>(&matrix, &[true; W]), [false; W]);
            let mut together = right;
            factors.solve::<D>(&mut together);
            for w in 0..W {
                let own: Vec<[f64; 1]> = matrix.iter().map(|row| [row[w]]).collect();
                let mut factors = Factors::<1, S>::new(D);
                assert_eq!(factors.factor::<D>(&own, &[true]), [false]);
                let mut alone = right.map(|row| [row[w]]);
                factors.solve::<D>(&mut alone);
                assert_eq!(
                    together.map(|row| row[w].to_bits()),
                    alone.map(|row| row[0].to_bits()),
                    "lane {w} of {W}, {D} equations"
                );
                // What the equations give, to the roundings of an elimination whose multipliers are at most 1.
                for row in 0..D {
                    let products = (0..D).map(|k| own[row * D + k][0] * alone[k][0]);
                    let defect = (products.sum::<f64>() - right[row][w]).abs();
                    let largest = alone.iter().fold(1.0, |m: f64, [v]| m.max(v.abs()));
                    let allowed = 64.0 * (D * D) as f64 * f64::EPSILON * largest;
                    assert!(
                        defect <= allowed,
                        "{defect:e} in lane {w} of {W}, {D} equations"
                    );
                }
            }
        }
    }

    #[test]
    fn lanes_are_solved_to_the_bits_of_each_alone() {
        macro_rules! check {
            ($($d:literal),*) => {$(
                check_lanes::<$d, 2, [[f64; 2]; $d * $d], [[f64; 1]; $d * $d]>();
                check_lanes::<$d, 4, [[f64; 4]; $d * $d], [[f64; 1]; $d * $d]>();
                check_lanes::<$d, 8, [[f64; 8]; $d * $d], [[f64; 1]; $d * $d]>();
                check_lanes::<$d, 8, Vec<[f64; 8]>, Vec<[f64; 1]>>();
            )*};
        }
        check!(2, 3, 4, 5, 6, 8);
    }

    /// Lanes that are not wanted keep the factors they have.
    #[test]
    fn other_lanes_keep_their_factors() {
        let mut factors = Factors::<2>::new(1);
        factors.factor::<1>(&[[2.0, 4.0]], &[true, true]);
        factors.factor::<1>(&[[8.0, 8.0]], &[true, false]);
        let mut right = [[1.0, 1.0]];
        factors.solve::<1>(&mut right);
        assert_eq!(right, [[0.125, 0.25]]);
    }

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
