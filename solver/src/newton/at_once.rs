//! A step of one or two evaluations as one kernel, with all that it is judged by.

use leafwise_expression::Kernel;
use leafwise_expression::kernel::{Sequence, Value};

use crate::judge::{Numbers, relative_size, scale_beside};

/// Kernel of a whole step from x + low: a Newton correction, then further corrections by the same Jacobian. The
/// Newton correction takes the `start` of its solve and the kernel of an iteration. Each further one takes the kernel
/// of an iteration without a Jacobian. These have so many `bases`. Inputs are x, low and the solution before, d each;
/// outputs whether the Jacobian is plain and one [`Corrected`] an evaluation. For 2 or 3 coordinates.
///
/// Every number has the bits that it has step by step, as long as all are finite.
pub(super) fn at_once(start: &Kernel, full: &Kernel, further: &[&Kernel], bases: usize) -> Kernel {
    let d = full.inputs();
    let kernels = [&[start, full], further].concat();
    let mut own = Writer(Sequence::new(3 * d, &kernels));
    let mut input = 0..3 * d;
    let [x, low, last] = std::array::from_fn(|_| -> Vec<Value> {
        let indices = input.by_ref().take(d);
        indices.map(|index| own.0.input(index)).collect()
    });

    let odd = own.0.evaluate(start, &x);
    let away = own.each([&last, &x], Sequence::subtract);
    let displacement = own.each([&away, &odd], Sequence::add);
    let y = own.each([&x, &displacement], Sequence::add);
    let mut allowed = own.sums_of_sizes(&x, &displacement);

    let ends = own.0.evaluate(full, &y);
    let (ends, jacobians) = ends.split_at(bases + 2 * d);
    let (target, rest) = jacobians.split_at(d * d);
    let (change, guard) = rest.split_at(d * d);
    let (inverse, near) = own.inverse(target);
    let slope = own.slope(target);
    let mut outputs = vec![near];

    let (mut y, mut ends, mut guard) = (y, ends.to_vec(), guard.to_vec());
    let mut before: Option<Vec<Value>> = None;
    for evaluation in 0..=further.len() {
        if evaluation > 0 {
            ends = own.0.evaluate(further[evaluation - 1], &y);
            guard = ends.split_off(bases + 2 * d);
        }
        let (base, rest) = ends.split_at(bases);
        let base = if base.is_empty() { &y } else { base };
        let (offset, increment) = rest.split_at(d);
        let away = own.each([&x, base], Sequence::subtract);
        let away = own.each([&away, offset], Sequence::subtract);
        let residual = own.each([&away, &low], Sequence::add);
        let correction = own.product(&inverse, &residual);
        let sizes = own.sizes(increment);
        let sums = own.sums_of_sizes(&y, &correction);
        let reached = own.product(&slope, &sums);
        if let Some(grown) = before {
            let smallest = own.each([&grown, &sizes], Sequence::smaller);
            allowed = own.each([&allowed, &smallest], Sequence::larger);
        }
        let scale = scale_beside(&mut own, [&x, &sizes, &allowed, &reached]);
        before = Some(sizes);
        let size = relative_size(&mut own, &correction, &scale);
        let size = own.largest(&size);
        let solution = own.each([&y, &correction], Sequence::add);
        let first_order = own.product(change, &correction);
        let increment = own.each([increment, &first_order], Sequence::add);
        let added = own.each([&increment, &low], Sequence::add);
        let (new, rest) = own.two_sums(&x, &added);
        let plain = own.each([&x, &increment], Sequence::add);
        let finite = own.zero(&[&new[..], &plain, &[size]].concat());
        let (first, behind) = guard.split_at(guard.len() / 2);
        let guards = [first, behind].map(|side| {
            let sizes = own.sizes(side);
            own.largest(&sizes)
        });
        outputs.extend([finite, size]);
        outputs.extend(guards);
        outputs.extend([new, rest, solution.clone(), scale, increment].concat());
        y = solution;
    }
    own.0.kernel(&outputs)
}

/// One correction of a step at once: its judgement, and the vectors that it makes.
pub(super) struct Corrected<'own, const W: usize> {
    /// 0 where all is finite, else no number.
    pub(super) finite: [f64; W],
    /// The size of the correction.
    pub(super) size: [f64; W],
    /// The largest entries of the guard's two sides.
    pub(super) guard: [[f64; W]; 2],
    /// The state behind the step, and what rounding took from it.
    pub(super) new: [&'own [[f64; W]]; 2],
    /// y corrected.
    pub(super) solution: &'own [[f64; W]],
    /// Scale that the correction was judged against, component by component.
    pub(super) scale: &'own [[f64; W]],
    /// The step's increment.
    pub(super) increment: &'own [[f64; W]],
}

/// Outputs of one correction beside its vectors.
const SCALARS: usize = 4;

/// The vectors of a correction.
const VECTORS: usize = 5;

impl<'own, const W: usize> Corrected<'own, W> {
    /// That of this number, of the outputs of a step in d coordinates.
    #[inline(always)]
    pub(super) fn of(rows: &'own [[f64; W]], number: usize, d: usize) -> Self {
        let each = SCALARS + VECTORS * d;
        let (scalars, vectors) = rows[1 + number * each..][..each].split_at(SCALARS);
        let vector = |at: usize| &vectors[at * d..][..d];
        Self {
            finite: scalars[0],
            size: scalars[1],
            guard: [scalars[2], scalars[3]],
            new: [vector(0), vector(1)],
            solution: vector(2),
            scale: vector(3),
            increment: vector(4),
        }
    }
}

/// Vectors and matrices of a sequence.
struct Writer(Sequence);

/// Vectors, component by component.
impl Numbers for Writer {
    type Number = Vec<Value>;

    fn known(&mut self, value: f64, beside: &Vec<Value>) -> Vec<Value> {
        vec![self.0.number(value); beside.len()]
    }

    fn magnitude(&mut self, a: &Vec<Value>) -> Vec<Value> {
        self.sizes(a)
    }

    fn add(&mut self, a: &Vec<Value>, b: &Vec<Value>) -> Vec<Value> {
        self.each([a, b], Sequence::add)
    }

    fn multiply(&mut self, a: &Vec<Value>, b: &Vec<Value>) -> Vec<Value> {
        self.each([a, b], Sequence::multiply)
    }

    fn divide(&mut self, a: &Vec<Value>, b: &Vec<Value>) -> Vec<Value> {
        self.each([a, b], Sequence::divide)
    }

    fn smaller(&mut self, a: &Vec<Value>, b: &Vec<Value>) -> Vec<Value> {
        self.each([a, b], Sequence::smaller)
    }
}

type Binary = fn(&mut Sequence, Value, Value) -> Value;

impl Writer {
    /// a ∘ b, component by component.
    fn each(&mut self, [a, b]: [&[Value]; 2], operation: Binary) -> Vec<Value> {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| operation(&mut self.0, *a, *b)).collect()
    }

    /// |a|, component by component.
    fn sizes(&mut self, a: &[Value]) -> Vec<Value> {
        a.iter().map(|a| self.0.magnitude(*a)).collect()
    }

    /// |a| + |b|, component by component.
    fn sums_of_sizes(&mut self, a: &[Value], b: &[Value]) -> Vec<Value> {
        let (a, b) = (self.sizes(a), self.sizes(b));
        self.each([&a, &b], Sequence::add)
    }

    /// The largest, 0 of none.
    fn largest(&mut self, values: &[Value]) -> Value {
        let largest = values.iter().copied();
        let largest = largest.reduce(|largest, value| self.0.larger(largest, value));
        largest.unwrap_or_else(|| self.0.number(0.0))
    }

    /// |D − 1|.
    fn slope(&mut self, target: &[Value]) -> Vec<Value> {
        let (zero, one) = (self.0.number(0.0), self.0.number(1.0));
        let d = target.len().isqrt();
        let unit: Vec<Value> = (0..d * d)
            .map(|at| if at % (d + 1) == 0 { one } else { zero })
            .collect();
        let rest = self.each([target, &unit], Sequence::subtract);
        self.sizes(&rest)
    }

    /// Σ 0·v: 0 where all are finite.
    fn zero(&mut self, values: &[Value]) -> Value {
        let zero = self.0.number(0.0);
        let zeros = self.each([values, &vec![zero; values.len()]], Sequence::multiply);
        let sum = zeros.into_iter().reduce(|sum, zero| self.0.add(sum, zero));
        sum.unwrap_or(zero)
    }

    /// As [`two_sum`](crate::compensation::two_sum).
    fn two_sums(&mut self, a: &[Value], b: &[Value]) -> (Vec<Value>, Vec<Value>) {
        let sum = self.each([a, b], Sequence::add);
        let back = self.each([&sum, a], Sequence::subtract);
        let rest = self.each([&sum, &back], Sequence::subtract);
        let of_a = self.each([a, &rest], Sequence::subtract);
        let of_b = self.each([b, &back], Sequence::subtract);
        let rest = self.each([&of_a, &of_b], Sequence::add);
        (sum, rest)
    }

    /// A matrix times a vector.
    fn product(&mut self, matrix: &[Value], vector: &[Value]) -> Vec<Value> {
        let rows = matrix.chunks_exact(vector.len());
        rows.map(|row| {
            let products = self.each([row, vector], Sequence::multiply);
            let sum = products.into_iter();
            let sum = sum.reduce(|sum, product| self.0.add(sum, product));
            sum.unwrap_or_else(|| self.0.number(0.0))
        })
        .collect()
    }

    /// pq − rs.
    fn minor(&mut self, [p, q, r, s]: [Value; 4]) -> Value {
        let (first, second) = (self.0.multiply(p, q), self.0.multiply(r, s));
        self.0.subtract(first, second)
    }

    /// The inverse of a 2 × 2 or 3 × 3 matrix by cofactors, and a number that is positive where its pivots lie between
    /// 1/2 and 2.
    fn inverse(&mut self, a: &[Value]) -> (Vec<Value>, Value) {
        let d = a.len().isqrt();
        let at = |row: usize, column: usize| a[row % d * d + column % d];
        let one = self.0.number(1.0);
        let minor = self.minor([at(0, 0), at(1, 1), at(0, 1), at(1, 0)]);
        let mut minors = vec![one, at(0, 0), minor];
        let inverse = if d == 2 {
            let reciprocal = self.0.divide(one, minor);
            let (b, c) = (self.0.negate(at(0, 1)), self.0.negate(at(1, 0)));
            let entries = [at(1, 1), b, c, at(0, 0)];
            self.each([&entries, &[reciprocal; 4]], Sequence::multiply)
        } else {
            // Rows and columns in a cycle give each cofactor its sign.
            let cofactors: Vec<Value> = (0..9)
                .map(|place| {
                    let (row, column) = (place % 3 + 1, place / 3 + 1);
                    self.minor([
                        at(row, column),
                        at(row + 1, column + 1),
                        at(row, column + 1),
                        at(row + 1, column),
                    ])
                })
                .collect();
            let first = [cofactors[0], cofactors[3], cofactors[6]];
            let determinant = self.product(&a[..3], &first)[0];
            minors.push(determinant);
            let reciprocal = self.0.divide(one, determinant);
            self.each([&cofactors, &[reciprocal; 9]], Sequence::multiply)
        };
        let near = self.near(&minors);
        (inverse, near)
    }

    /// A number that is positive where the quotient of each and the one before it lies between 1/2 and 2.
    fn near(&mut self, minors: &[Value]) -> Value {
        let (half, two) = (self.0.number(0.5), self.0.number(2.0));
        let mut least: Option<Value> = None;
        for pair in minors.windows(2) {
            let (low, high) = (
                self.0.multiply(half, pair[0]),
                self.0.multiply(two, pair[0]),
            );
            let (above, below) = (
                self.0.subtract(pair[1], low),
                self.0.subtract(high, pair[1]),
            );
            let own = self.0.smaller(above, below);
            least = Some(least.map_or(own, |least| self.0.smaller(least, own)));
        }
        least.unwrap_or(half)
    }
}
