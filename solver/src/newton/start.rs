//! Where a step's solve starts.

use std::sync::Arc;

use leafwise_expression::{Kernel, Workspace, kernel::apart};

use crate::elimination::dimension;
use crate::extrapolation::{DEPTH, Extrapolation};

/// One number of each lane.
type Row<const W: usize> = [f64; W];

/// The start of the solve for y_{k+1}, as its displacement y − x.
pub(super) enum Start<const W: usize> {
    /// y_k and the odd part of the solution's series, 2 Σ_{k odd} tᵏ Y_k. Where there is no y_k, x and half of that.
    /// Where that is far off, y = x, where its branch begins.
    Series {
        kernel: Arc<Kernel>,
        workspace: Workspace,
        /// y_k.
        last: Vec<Row<W>>,
        /// Whether there is one.
        is_known: [bool; W],
    },
    /// Extrapolation of the displacements of earlier steps.
    Extrapolated(Extrapolation<W>),
}

/// Largest part of a coordinate by which half of the odd part may move it, on average over those that are not 0. Where
/// it moves them farther, it may be a series that does not converge. What that leads to, an end outside the chart also,
/// says nothing of the solution that begins at x.
const NEAR: f64 = 0.25;

/// The displacement of a lane without a solution before it.
#[cold]
fn begin<const W: usize>(x: &[Row<W>], odd: &[Row<W>], displacement: &mut [Row<W>], w: usize) {
    let (mut moved, mut coordinates) = (0.0, 0.0);
    for (x, odd) in x.iter().zip(odd) {
        let (size, half) = (x[w].abs(), 0.5 * odd[w].abs());
        if size != 0.0 {
            moved += if half < size { half / size } else { 1.0 };
            coordinates += 1.0;
        }
    }
    let is_near = moved <= NEAR * coordinates && odd.iter().all(|odd| odd[w].is_finite());
    for (row, odd) in displacement.iter_mut().zip(odd) {
        row[w] = if is_near { 0.5 * odd[w] } else { 0.0 };
    }
}

impl<const W: usize> Start<W> {
    /// By the series where there is one, its coefficients not yet prepared.
    pub(super) fn new(series: Option<&Arc<Kernel>>, dimension: usize) -> Self {
        match series {
            None => Self::Extrapolated(Extrapolation::new(dimension, DEPTH)),
            Some(kernel) => Self::Series {
                kernel: Arc::clone(kernel),
                workspace: kernel.workspace(W),
                last: vec![[0.0; W]; dimension],
                is_known: [false; W],
            },
        }
    }

    /// Writes the displacements from x.
    #[inline(always)]
    pub(super) fn predict<const D: usize>(&mut self, x: &[Row<W>], displacement: &mut [Row<W>]) {
        match self {
            Self::Extrapolated(extrapolation) => extrapolation.predict_in::<D>(displacement),
            Self::Series {
                kernel,
                workspace,
                last,
                is_known,
            } => {
                let d = dimension::<D>(last.len());
                let odd = &kernel.evaluate_rows(workspace, x)[..d];
                let last = &last[..d];
                let mut zero = [0.0; W];
                for i in 0..d {
                    for w in 0..W {
                        displacement[i][w] = (last[i][w] - x[i][w]) + odd[i][w];
                        // 0·v is 0 where v is finite, and no number elsewhere.
                        zero[w] += 0.0 * displacement[i][w];
                    }
                    apart::<W>();
                }
                for w in 0..W {
                    if !is_known[w] || zero[w].is_nan() {
                        begin(x, odd, displacement, w);
                    }
                }
            }
        }
    }

    /// Records the solutions y of the lanes that took a step from x; `room` holds d rows.
    #[inline(always)]
    pub(super) fn record<const D: usize>(
        &mut self,
        x: &[Row<W>],
        y: &[Row<W>],
        room: &mut [Row<W>],
        took: &[bool; W],
    ) {
        match self {
            Self::Extrapolated(extrapolation) => {
                for (displacement, (x, y)) in room.iter_mut().zip(x.iter().zip(y)) {
                    for w in 0..W {
                        displacement[w] = y[w] - x[w];
                    }
                }
                extrapolation.record_in::<D>(room, took);
            }
            Self::Series { last, is_known, .. } => {
                let d = dimension::<D>(last.len());
                for (last, y) in last[..d].iter_mut().zip(y) {
                    *last = *y;
                    apart::<W>();
                }
                *is_known = *took;
            }
        }
    }

    /// Whether a lane's start follows a solution before it.
    pub(super) fn is_known(&self, lane: usize) -> bool {
        match self {
            Self::Extrapolated(_) => true,
            Self::Series { is_known, .. } => is_known[lane],
        }
    }

    /// y_k where the start is the series beside it, nothing elsewhere.
    #[inline(always)]
    pub(super) fn last(&self) -> &[Row<W>] {
        match self {
            Self::Series { last, .. } => last,
            Self::Extrapolated(_) => &[],
        }
    }

    /// The same where it is known in every lane.
    #[inline(always)]
    pub(super) fn last_known(&self) -> Option<&[Row<W>]> {
        match self {
            Self::Series { last, is_known, .. } if is_known.iter().all(|known| *known) => {
                Some(last)
            }
            _ => None,
        }
    }

    /// Records the solutions of all lanes, where there is a series.
    #[inline(always)]
    pub(super) fn take_solution(&mut self, y: &[Row<W>]) {
        if let Self::Series { last, .. } = self {
            for (last, y) in last[..y.len()].iter_mut().zip(y) {
                *last = *y;
                apart::<W>();
            }
        }
    }

    /// Forgets a lane's history.
    pub(super) fn clear(&mut self, lane: usize) {
        match self {
            Self::Extrapolated(extrapolation) => extrapolation.clear(lane),
            Self::Series { is_known, .. } => is_known[lane] = false,
        }
    }

    /// A lane's history as numbers.
    pub(super) fn memory(&self, lane: usize, into: &mut Vec<f64>) {
        match self {
            Self::Extrapolated(extrapolation) => extrapolation.memory(lane, into),
            Self::Series { last, is_known, .. } => {
                into.push(f64::from(u8::from(is_known[lane])));
                into.extend(
                    last.iter()
                        .map(|row| if is_known[lane] { row[lane] } else { 0.0 }),
                );
            }
        }
    }

    /// How many numbers [`memory`](Self::memory) writes.
    pub(super) fn memory_len(&self) -> usize {
        match self {
            Self::Extrapolated(extrapolation) => extrapolation.memory_len(),
            Self::Series { last, .. } => 1 + last.len(),
        }
    }

    /// Restores what [`memory`](Self::memory) wrote.
    pub(super) fn restore(&mut self, lane: usize, memory: &[f64]) {
        match self {
            Self::Extrapolated(extrapolation) => extrapolation.restore(lane, memory),
            Self::Series { last, is_known, .. } => {
                is_known[lane] = memory[0] != 0.0;
                for (row, value) in last.iter_mut().zip(&memory[1..]) {
                    row[lane] = *value;
                }
            }
        }
    }
}
