//! Products of dense matrices and substitutions with triangular ones, a strip of columns at a time.

/// Columns of a strip: as many sums as stay in registers.
const WIDEST: usize = 8;

/// Work on W columns side by side, whatever is done to the others.
trait Strip {
    fn strip<const W: usize>(&mut self, first: usize);
}

/// Strips of all columns, the last as wide as what is left.
fn in_strips(columns: usize, work: &mut impl Strip) {
    let mut first = 0;
    while columns - first >= WIDEST {
        work.strip::<WIDEST>(first);
        first += WIDEST;
    }
    match columns - first {
        1 => work.strip::<1>(first),
        2 => work.strip::<2>(first),
        3 => work.strip::<3>(first),
        4 => work.strip::<4>(first),
        5 => work.strip::<5>(first),
        6 => work.strip::<6>(first),
        7 => work.strip::<7>(first),
        _ => {}
    }
}

/// W numbers from a place on.
#[inline(always)]
fn from<const W: usize>(numbers: &[f64], at: usize) -> &[f64; W] {
    numbers[at..].first_chunk().expect("a strip of a row")
}

/// W places from a place on.
#[inline(always)]
fn from_mut<const W: usize>(numbers: &mut [f64], at: usize) -> &mut [f64; W] {
    numbers[at..].first_chunk_mut().expect("a strip of a row")
}

/// Product A B of an m × n and an n × `columns` matrix, row-major. Each entry is summed from its first product on.
///
/// # Panics
/// When `a` or `b` has fewer rows than `out` and A's columns ask for.
pub fn product(a: &[f64], b: &[f64], columns: usize, out: &mut [f64]) {
    let inner = b.len() / columns;
    in_strips(
        columns,
        &mut Product {
            a,
            b,
            inner,
            columns,
            out,
        },
    );
}

struct Product<'a> {
    a: &'a [f64],
    b: &'a [f64],
    inner: usize,
    columns: usize,
    out: &'a mut [f64],
}

impl Strip for Product<'_> {
    fn strip<const W: usize>(&mut self, first: usize) {
        let (inner, columns) = (self.inner, self.columns);
        for (row, out) in self.out.chunks_exact_mut(columns).enumerate() {
            // Minus zero: the first product itself, with its sign where it is zero.
            let (mut sums, mut at) = ([-0.0; W], first);
            for factor in &self.a[row * inner..][..inner] {
                let others = from::<W>(self.b, at);
                for w in 0..W {
                    sums[w] += factor * others[w];
                }
                at += columns;
            }
            *from_mut(out, first) = sums;
        }
    }
}

/// U⁻¹ L⁻¹ R in place of R, d × `columns`, row-major. Below the diagonal of `factors` stands L, with a diagonal of
/// ones. From the diagonal on stands U, with the reciprocals of its diagonal.
pub(super) fn substitute(factors: &[f64], d: usize, right: &mut [f64], columns: usize) {
    in_strips(
        columns,
        &mut Substitution {
            factors,
            d,
            columns,
            right,
        },
    );
}

struct Substitution<'a> {
    factors: &'a [f64],
    d: usize,
    columns: usize,
    right: &'a mut [f64],
}

impl Substitution<'_> {
    /// A strip of a row of R less those of the rows from `known` on, each by its factor.
    #[inline(always)]
    fn less<const W: usize>(&self, at: usize, factors: &[f64], mut known: usize) -> [f64; W] {
        let mut values = *from::<W>(self.right, at);
        for factor in factors {
            let others = from::<W>(self.right, known);
            for w in 0..W {
                values[w] -= factor * others[w];
            }
            known += self.columns;
        }
        values
    }
}

impl Strip for Substitution<'_> {
    fn strip<const W: usize>(&mut self, first: usize) {
        let (d, columns) = (self.d, self.columns);
        for row in 1..d {
            let at = row * columns + first;
            let values = self.less::<W>(at, &self.factors[row * d..][..row], first);
            *from_mut(self.right, at) = values;
        }
        for row in (0..d).rev() {
            let at = row * columns + first;
            let factors = &self.factors[row * d + row..][..d - row];
            let mut values = self.less::<W>(at, &factors[1..], at + columns);
            for value in &mut values {
                *value *= factors[0];
            }
            *from_mut(self.right, at) = values;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::product;

    /// Sums of products one after the other, in strips of every width; a zero keeps the sign of its only product.
    #[test]
    fn products_have_the_bits_of_sums_one_by_one() {
        let number = |at: usize| libm::sin(1.0 + (at * at % 37) as f64);
        for inner in 1..4 {
            for columns in 1..20 {
                let a: Vec<f64> = (0..2 * inner).map(number).collect();
                let b: Vec<f64> = (0..inner * columns).map(|at| number(at + 50)).collect();
                let mut out = vec![f64::NAN; 2 * columns];
                product(&a, &b, columns, &mut out);
                for (at, found) in out.iter().enumerate() {
                    let (i, k) = (at / columns, at % columns);
                    let terms = (0..inner).map(|j| a[i * inner + j] * b[j * columns + k]);
                    let expected = terms.reduce(|sum, term| sum + term);
                    assert_eq!(Some(*found), expected, "{at} of 2 × {inner} × {columns}");
                }
            }
        }
        let mut out = [1.0];
        product(&[-1.0], &[0.0], 1, &mut out);
        assert!(out[0].is_sign_negative());
    }
}
