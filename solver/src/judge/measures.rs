//! Sizes of corrections, and what they are measured against.

use super::ROUND_OFF;
use super::numbers::{Doubles, at_most, relative_size, scale_beside};

/// max that keeps NaN.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// max of a and b, which counts only where it is a number.
#[inline(always)]
pub fn at_least(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// |size|/(scale + |size|), 0 for 0: a component that has no scale yet counts as 1.
#[inline(always)]
pub fn relative(size: f64, scale: f64) -> f64 {
    relative_size(&mut Doubles, &size, &scale)
}

/// max_i |b_i|/s_i over max_i |a_i|/s_i with the size s_i = |x_i| + |a_i| of each coordinate. A pair holds the first
/// term a_i and the last term b_i of a coordinate's series. The ratio is the same in any units, also where a
/// coordinate turns. It is 0 where every b_i is, no number where one is none, and infinite where a coordinate with
/// b_i ≠ 0 has no size.
pub fn ratio_in_own_units(x: &[f64], pairs: impl Iterator<Item = [f64; 2]>) -> f64 {
    let (mut first, mut last) = (0.0, 0.0);
    for (x, [a, b]) in x.iter().zip(pairs) {
        let size = x.abs() + a.abs();
        if size != 0.0 {
            first = larger(first, a.abs() / size);
            last = larger(last, b.abs() / size);
        } else if b != 0.0 {
            return f64::INFINITY;
        }
    }
    if last == 0.0 { 0.0 } else { last / first }
}

/// Round-off that the others leave in a component of the solution of D δ = r, in any units. They put N s into the
/// components at first hand and N² s at second, N = |D − 1|. All of N s is left where the others are calm, and
/// N s · N s/N² s where D − 1 is large, and D⁻¹ as small.
pub fn settled(first_hand: f64, second_hand: f64) -> f64 {
    if second_hand > first_hand {
        first_hand * (first_hand / second_hand)
    } else {
        first_hand
    }
}

/// Σ_k |m_k v_k|: what a row of a Jacobian makes of a state's round-off.
pub fn reach(row: &[f64], values: &[f64]) -> f64 {
    row.iter().zip(values).map(|(m, v)| (m * v).abs()).sum()
}

/// Rows that are measured side by side: one after the other each waits for the maximum before it.
const SIDE_BY_SIDE: usize = 8;

/// max |v_k|, NaN where one is.
pub fn largest(values: &[f64]) -> f64 {
    let (blocks, rest) = values.as_chunks::<SIDE_BY_SIDE>();
    let mut lanes = [0.0; SIDE_BY_SIDE];
    for block in blocks {
        for (lane, v) in lanes.iter_mut().zip(block) {
            *lane = larger(*lane, v.abs());
        }
    }
    let rest = rest.iter().map(|v| v.abs());
    lanes.into_iter().chain(rest).fold(0.0, larger)
}

/// The size of a state and of what is added to it, as far as a solve's iterates agree on it.
///
/// Corrections are judged against the state and its change. An iterate that is far off may have a change so large
/// that every correction is small beside it. So a change counts up to the size of the state, of the change that a
/// solve starts from, and of the smallest change of two iterates.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    size: f64,
    smallest: f64,
    has_begun: bool,
}

impl Allowed {
    /// For a state of this size, its change included that a solve starts from.
    #[inline(always)]
    pub const fn new(size: f64) -> Self {
        Self {
            size,
            smallest: f64::INFINITY,
            has_begun: false,
        }
    }

    /// Takes in the size of an iterate's change.
    #[inline(always)]
    pub fn take(&mut self, change: f64) {
        self.smallest = at_most(self.smallest, change);
        if self.has_begun {
            self.size = at_least(self.size, self.smallest);
        }
        self.has_begun = true;
    }

    /// The size itself.
    #[inline(always)]
    pub fn size(&self) -> f64 {
        self.size
    }

    /// |state| + |change| + `reached`, the change as far as it serves as a scale.
    #[inline(always)]
    pub fn scale(&self, state: f64, change: f64, reached: f64) -> f64 {
        scale_beside(&mut Doubles, [&state, &change.abs(), &self.size, &reached])
    }
}

/// Whether y and the increment Δ are of one step from x: |y − x − Δ/2| ≤ |Δ|, but for round-off. Sizes are taken as a
/// whole, or each coordinate in units of what it is and moves by. The points β̂(L(y)) and α̂(L(y)) lie to both sides
/// of y, or the first at y, but for an even part of second order. A solution farther off is not the one that begins
/// at y = x.
pub fn is_between(x: &[f64], y: &[f64], increment: &[f64]) -> bool {
    let (mut away, mut moved, mut state) = ([0.0; 2], [0.0; 2], 0.0);
    for ((x, y), change) in x.iter().zip(y).zip(increment) {
        let (way, off) = ((y - x).abs(), (y - x - 0.5 * change).abs());
        let own = x.abs() + way + change.abs();
        for (at, unit) in [1.0, own].into_iter().enumerate() {
            if unit > 0.0 {
                moved[at] = larger(moved[at], change.abs() / unit);
            }
            if unit != 0.0 {
                away[at] = larger(away[at], off / unit);
            }
        }
        state = larger(state, x.abs());
    }
    away[0] <= moved[0] + ROUND_OFF * state || away[1] <= moved[1] + ROUND_OFF
}

/// The size of a correction, component by component and as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CorrectionSize {
    component: f64,
    largest: f64,
    state: f64,
    way: f64,
}

impl CorrectionSize {
    /// Takes in a component's correction and the scale it is judged against, the size of the state
    /// there and of what is added to it.
    pub fn take(&mut self, correction: f64, scale: f64) {
        self.component = larger(self.component, relative(correction, scale));
        self.largest = larger(self.largest, correction.abs());
        self.state = larger(self.state, scale);
    }

    /// [`take`](Self::take) of many components.
    pub fn take_rows(&mut self, corrections: &[f64], scales: &[f64]) {
        let (blocks, rest) = corrections.as_chunks::<SIDE_BY_SIDE>();
        let (block_scales, rest_scales) = scales.as_chunks::<SIDE_BY_SIDE>();
        if !blocks.is_empty() {
            let [mut component, mut largest, mut state] = [[0.0; SIDE_BY_SIDE]; 3];
            for (block, scales) in blocks.iter().zip(block_scales) {
                for w in 0..SIDE_BY_SIDE {
                    component[w] = larger(component[w], relative(block[w], scales[w]));
                    largest[w] = larger(largest[w], block[w].abs());
                    state[w] = larger(state[w], scales[w]);
                }
            }
            self.component = component.into_iter().fold(self.component, larger);
            self.largest = largest.into_iter().fold(self.largest, larger);
            self.state = state.into_iter().fold(self.state, larger);
        }
        for (correction, scale) in rest.iter().zip(rest_scales) {
            self.take(*correction, *scale);
        }
    }

    /// Takes in how far a component moved so far, against the same scale.
    pub fn take_way(&mut self, way: f64, scale: f64) {
        self.way = larger(self.way, relative(way, scale));
    }

    /// The largest relative way of a component, at most 1.
    pub fn way(&self) -> f64 {
        self.way
    }

    /// The largest relative correction of a component, at most 1; NaN where one is not finite.
    pub fn component(&self) -> f64 {
        self.component
    }

    /// The largest correction over the largest scale.
    pub fn norm(&self) -> f64 {
        if self.largest == 0.0 {
            0.0
        } else {
            self.largest / self.state
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::LARGEST_REMAINDER;
    use super::{Allowed, CorrectionSize, is_between, largest, relative};

    /// Rows side by side have the size of rows one after the other, and the largest of them, wherever one is no
    /// number.
    #[test]
    fn rows_are_measured_alike_side_by_side() {
        for length in 0..40 {
            for bad in 0..=length {
                let value = |i: usize| match i == bad {
                    true => f64::NAN,
                    false => libm::sin(7.3 * i as f64 + length as f64),
                };
                let corrections: Vec<f64> = (0..length).map(value).collect();
                let scales: Vec<f64> = (0..length).map(|i| libm::exp(value(i + 3))).collect();
                let (mut one_by_one, mut together) =
                    (CorrectionSize::default(), CorrectionSize::default());
                for (correction, scale) in corrections.iter().zip(&scales) {
                    one_by_one.take(*correction, *scale);
                }
                together.take_rows(&corrections, &scales);
                let bits = |size: CorrectionSize| {
                    [size.component, size.largest, size.state].map(|v| (v.is_nan(), v.max(0.0)))
                };
                assert_eq!(bits(together), bits(one_by_one), "{length} rows, {bad}");
                let expected = corrections.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                let found = largest(&corrections);
                assert_eq!(found.is_nan(), bad < length);
                assert!(found.is_nan() || found == expected, "{length} rows");
            }
        }
    }

    /// A few of the smallest numbers are no remainder, and a size in its digits is measured as without them.
    #[test]
    fn numbers_without_digits_are_negligible() {
        let tiny = f64::from_bits(40);
        assert!(relative(tiny, 2.0 * tiny) <= LARGEST_REMAINDER);
        assert_eq!(relative(1e-280, 1e-270), 1e-280 / (1e-270 + 1e-280));
    }

    /// Beside an iterate's change of 1e30 a correction of 1e10 is not small.
    #[test]
    fn the_change_of_an_iterate_far_off_is_no_scale() {
        let mut allowed = Allowed::new(2.0);
        for change in [0.5, 1e30, 1e25] {
            allowed.take(change);
            let scale = allowed.scale(0.0, change, 0.0);
            assert!(scale <= 2048.0, "{scale}");
        }
        // Where two iterates agree on a change that is larger than the state, it is the scale.
        let mut allowed = Allowed::new(1e-20);
        allowed.take(0.1);
        allowed.take(0.1);
        assert_eq!(allowed.scale(0.0, 0.1, 0.0), 0.1);
    }

    #[test]
    fn a_solution_far_from_state_and_increment_is_reported() {
        let x = [1.0, -2.0];
        assert!(is_between(&x, &[1.1, -2.0], &[0.2, 0.0]));
        assert!(is_between(&x, &x, &[0.2, 0.0]));
        assert!(is_between(&x, &x, &[0.0, 0.0]));
        assert!(!is_between(&x, &[3.0, -2.0], &[0.2, 0.0]));
        assert!(!is_between(&x, &[f64::NAN, -2.0], &[0.2, 0.0]));
    }
}
