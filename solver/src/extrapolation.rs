//! Where to start a solve: polynomial extrapolation of earlier solutions.

use super::elimination::{ANY, dimension};

/// Coordinates that are differenced together: their temporaries stay in the fastest cache.
const CHUNK: usize = 256;

/// Backward differences of the displacements d_k = y_k − x_k of W trajectories, side by side.
///
/// The predictor of order q is Σ_{j<q} ∇ʲd_k, and ∇^q d_k is its error one step ago. The order moves
/// to a neighbour where that error is smaller; it grows from nothing as the history does.
#[derive(Clone, Debug)]
pub struct Extrapolation<const W: usize = 1> {
    dimension: usize,
    /// ∇⁰d_k, ∇¹d_k, …, a row for each coordinate.
    differences: Vec<[f64; W]>,
    levels: usize,
    /// Steps recorded since the history was cleared, at most the levels.
    filled: [usize; W],
    order: [usize; W],
}

/// The levels that pay for smooth solutions of few coordinates. Differences of order q amplify the
/// round-off of the solutions by 2^q: a thousand units in the last place at most.
pub(super) const DEPTH: usize = 12;

impl<const W: usize> Extrapolation<W> {
    /// No history; predictors up to the order `levels` − 1.
    pub fn new(dimension: usize, levels: usize) -> Self {
        Self {
            dimension,
            differences: vec![[0.0; W]; dimension * levels],
            levels,
            filled: [0; W],
            order: [0; W],
        }
    }

    /// Whether a lane has no history: it predicts 0.
    pub fn is_cold(&self, lane: usize) -> bool {
        self.order[lane] == 0
    }

    /// Forgets a lane's history.
    pub fn clear(&mut self, lane: usize) {
        self.filled[lane] = 0;
        self.order[lane] = 0;
    }

    /// Writes the predicted displacements of the next step, 0 without history.
    pub fn predict(&self, displacement: &mut [[f64; W]]) {
        self.predict_in::<ANY>(displacement);
    }

    /// The same in the constant dimension D, or in [`ANY`].
    #[inline(always)]
    pub(crate) fn predict_in<const D: usize>(&self, displacement: &mut [[f64; W]]) {
        let d = dimension::<D>(self.dimension);
        let displacement = &mut displacement[..d];
        displacement.fill([0.0; W]);
        let mut own = [[0.0; W]; D];
        let sums = if D == ANY {
            &mut *displacement
        } else {
            &mut own[..]
        };
        let highest = self.order.iter().fold(0, |m, order| m.max(*order));
        for (j, level) in self
            .differences
            .chunks_exact(d.max(1))
            .take(highest)
            .enumerate()
        {
            let takes: [bool; W] = std::array::from_fn(|w| j < self.order[w]);
            for (sum, difference) in sums.iter_mut().zip(level) {
                for w in 0..W {
                    sum[w] += if takes[w] { difference[w] } else { 0.0 };
                }
            }
        }
        if D != ANY {
            displacement.copy_from_slice(&own);
        }
    }

    /// Records the displacements of a step in the lanes that took it; uses `displacement` up.
    pub fn record(&mut self, displacement: &mut [[f64; W]], took: &[bool; W]) {
        self.record_in::<ANY>(displacement, took);
    }

    /// The same in the constant dimension D, or in [`ANY`].
    #[inline(always)]
    pub(crate) fn record_in<const D: usize>(
        &mut self,
        displacement: &mut [[f64; W]],
        took: &[bool; W],
    ) {
        // A lane alone need not be selected.
        if W == 1 && !took[0] {
            return;
        }
        let took = if W == 1 { &[true; W] } else { took };
        let last = self.levels - 1;
        let highest = |order: usize| (order + 1).min(last);
        let top = self
            .order
            .iter()
            .fold(0, |top, order| top.max(highest(*order)));
        let mut errors = [[0.0_f64; W]; 3];
        let d = dimension::<D>(self.dimension);
        // What is carried from level to level stays in registers.
        let mut own = [[0.0; W]; D];
        own.copy_from_slice(&displacement[..D]);
        for start in (0..d).step_by(CHUNK) {
            let carried = if D == ANY {
                &mut displacement[start..d.min(start + CHUNK)]
            } else {
                &mut own[..]
            };
            for j in 0..=top {
                let level = &mut self.differences[j * d + start..][..carried.len()];
                let size = push(level, carried, took);
                for w in 0..W {
                    // ∇^q for q = order − 1, order, order + 1.
                    let neighbour = (j + 1).wrapping_sub(self.order[w]);
                    if neighbour < 3 {
                        errors[neighbour][w] = errors[neighbour][w].max(size[w]);
                    }
                }
            }
        }
        for w in 0..W {
            if took[w] {
                let order = self.order[w];
                let filled = (self.filled[w] + 1).min(highest(order) + 1);
                let [lower, own, higher] = errors.map(|error| error[w]);
                self.filled[w] = filled;
                self.order[w] = if order == 0 || order + 1 < filled && higher < own {
                    (order + 1).min(last.max(1))
                } else if order > 1 && lower < own {
                    order - 1
                } else {
                    order
                };
            }
        }
    }

    /// A lane's history as numbers.
    pub fn memory(&self, lane: usize, into: &mut Vec<f64>) {
        into.push(self.filled[lane] as f64);
        into.push(self.order[lane] as f64);
        let valid = self.filled[lane] * self.dimension;
        for (at, difference) in self.differences.iter().enumerate() {
            into.push(if at < valid { difference[lane] } else { 0.0 });
        }
    }

    /// How many numbers [`Extrapolation::memory`] writes.
    pub fn memory_len(&self) -> usize {
        2 + self.differences.len()
    }

    /// Restores what [`Extrapolation::memory`] wrote.
    pub fn restore(&mut self, lane: usize, memory: &[f64]) {
        self.filled[lane] = (memory[0] as usize).min(self.levels);
        self.order[lane] = (memory[1] as usize).min(self.filled[lane]);
        for (difference, value) in self.differences.iter_mut().zip(&memory[2..]) {
            difference[lane] = *value;
        }
    }
}

/// Replaces ∇ʲd_{k−1} by ∇ʲd_k and what is carried, ∇ʲd_k, by ∇ʲ⁺¹d_k; returns max |∇ʲd_k|.
#[inline(always)]
fn push<const W: usize>(
    level: &mut [[f64; W]],
    carried: &mut [[f64; W]],
    took: &[bool; W],
) -> [f64; W] {
    let mut size = [0.0_f64; W];
    for (slot, value) in level.iter_mut().zip(carried) {
        for w in 0..W {
            let (before, now) = (slot[w], value[w]);
            slot[w] = if took[w] { now } else { before };
            value[w] = now - before;
            size[w] = size[w].max(now.abs());
        }
    }
    size
}

#[cfg(test)]
mod tests {
    use super::Extrapolation;

    /// Σ_{j<q} ∇ʲ continues polynomials of degree below q: of integers, exactly.
    #[test]
    fn polynomials_are_continued_exactly() {
        let value = |k: i32, degree: u32| f64::from(k.pow(degree) - 3 * k + 1);
        let mut history = Extrapolation::<2>::new(1, 8);
        for k in 0..20 {
            let mut predicted = [[0.0; 2]];
            history.predict(&mut predicted);
            let now = [[value(k, 2), value(k, 4)]];
            if k >= 10 {
                assert_eq!(predicted, now, "at {k}");
            }
            history.record(&mut now.clone(), &[true; 2]);
        }
    }

    /// A lane's predictions depend on its own history alone, and survive as numbers.
    #[test]
    fn lanes_are_apart_and_restored() {
        let value = |k: i32| libm::sin(0.3 * f64::from(k));
        let mut single = Extrapolation::<1>::new(1, 12);
        let mut pair = Extrapolation::<2>::new(1, 12);
        for k in 0..40 {
            let (mut a, mut b) = ([[0.0]], [[0.0; 2]]);
            single.predict(&mut a);
            pair.predict(&mut b);
            assert_eq!(a[0][0].to_bits(), b[0][1].to_bits(), "at {k}");
            single.record(&mut [[value(k)]], &[true]);
            // The neighbour fails now and then, and is rough.
            pair.record(&mut [[f64::from(k % 5), value(k)]], &[k % 7 != 3, true]);
            if k % 7 == 3 {
                pair.clear(0);
            }
            let (mut memory, mut other) = (Vec::new(), Vec::new());
            single.memory(0, &mut memory);
            pair.memory(1, &mut other);
            assert_eq!(memory, other);
            let mut fresh = Extrapolation::<1>::new(1, 12);
            fresh.restore(0, &memory);
            single = fresh;
        }
    }
}
