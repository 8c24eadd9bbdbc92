//! Stages and slopes of several trajectories, and one correction of the stages.

use std::sync::Arc;

use leafwise_expression::vector::Register;
use leafwise_expression::{Kernel, Workspace};

use super::solution::Start;
use super::sums::{Columns, block, block_mut, by_blocks, sum_of_lanes, sums};
use crate::evaluator::Evaluator;
use crate::runge_kutta::smooth_map::{MapAt, SideBySide};
use crate::runge_kutta::tableau::Tableau;

/// The start of the stages of a solve.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum From {
    /// On the polynomial of the last step.
    Polynomial,
    /// At z.
    State,
    /// Where they stand.
    Standing,
}

/// So many operations on stages side by side count as one: they take the time of one of a kernel for one point.
const TOGETHER: usize = 4;

/// W lanes, the first s of which are stages; the others stay at z.
pub(super) struct Lanes<const W: usize> {
    pub(super) field: StageField<W>,
    /// s.
    pub(super) stages: usize,
    /// τ a_ij, and τ ∫₁^{1+c_i} ℓ_j; 0 beyond s.
    pub(super) matrix: Box<Columns<W>>,
    onward: Box<Columns<W>>,
    /// τ b_j.
    weights: [f64; W],
    /// F(Z_j) of each trajectory's last solve, a row a coordinate, and whether there was one.
    pub(super) slopes: Vec<[f64; W]>,
    pub(super) is_known: Vec<bool>,
    /// 1/(|z_c| + max_i |Z_i − z|_c), of the solve at hand.
    pub(super) inverse_sizes: Vec<f64>,
    /// Whether a step is followed from z by parts where it is not found at once. If so, A of the whole step (`full`),
    /// and Z_i − z of a part (`ways`), a row a coordinate.
    pub(super) follows: bool,
    pub(super) full: Box<Columns<W>>,
    pub(super) ways: Vec<[f64; W]>,
    pub(super) evaluations: u64,
    /// Operations of one evaluation and its sums, as they count.
    pub(super) work: u64,
}

/// F at the stages, a row a coordinate.
pub(super) enum StageField<const W: usize> {
    Kernel(Arc<Kernel>, Workspace),
    Numbers {
        evaluator: Box<dyn Evaluator>,
        stages: Vec<[f64; W]>,
        slopes: Vec<[f64; W]>,
    },
}

impl<const W: usize> StageField<W> {
    fn of(field: SideBySide, dimension: usize) -> Self {
        match field {
            SideBySide::Kernel(kernel, workspace) => Self::Kernel(kernel, workspace),
            SideBySide::Numbers(evaluator) => Self::Numbers {
                evaluator,
                stages: vec![[0.0; W]; dimension],
                slopes: vec![[0.0; W]; dimension],
            },
        }
    }

    /// Operations of one evaluation at one point, where it is a kernel.
    fn work(&self) -> u64 {
        match self {
            Self::Kernel(kernel, _) => kernel.step_operations().work(),
            Self::Numbers { .. } => 0,
        }
    }

    /// Operations of all evaluations that the numbers count themselves.
    pub(super) fn operations(&self) -> u64 {
        match self {
            Self::Kernel(..) => 0,
            Self::Numbers { evaluator, .. } => evaluator.operations().unwrap_or(0),
        }
    }

    #[inline(always)]
    fn evaluate(&mut self) {
        match self {
            Self::Kernel(kernel, workspace) => {
                kernel.evaluate_own_rows::<W>(workspace);
            }
            Self::Numbers {
                evaluator,
                stages,
                slopes,
            } => {
                let values = evaluator.values(stages.as_flattened(), slopes.as_flattened_mut());
                if values.is_err() {
                    slopes.fill([f64::NAN; W]);
                }
            }
        }
    }

    /// The rows of the stages, those of what is read beside them, and of the slopes of the last evaluation.
    #[inline(always)]
    pub(super) fn rows_mut(&mut self) -> (&mut [[f64; W]], &[[f64; W]]) {
        match self {
            Self::Kernel(kernel, workspace) => kernel.rows_mut::<W>(workspace),
            Self::Numbers { stages, slopes, .. } => (stages, slopes),
        }
    }
}

impl<const W: usize> Lanes<W> {
    pub(super) fn new(
        (field, tableau, time_step, count, follows): (MapAt<'_>, &Tableau, f64, usize, bool),
    ) -> Option<Self> {
        let (s, n) = (tableau.stages(), field.map.outputs());
        let field = StageField::of(field.side_by_side(W)?, n);
        let columns = |matrix: &[f64]| Columns::of(matrix, s, time_step);
        let mut weights = [0.0; W];
        for (weight, b) in weights.iter_mut().zip(&tableau.weights) {
            *weight = time_step * b;
        }
        Some(Self {
            stages: s,
            matrix: columns(&tableau.matrix),
            full: columns(&tableau.matrix),
            ways: vec![[0.0; W]; if follows { n } else { 0 }],
            onward: columns(Tableau::gauss_onward(s)),
            weights,
            slopes: vec![[0.0; W]; count * n],
            is_known: vec![false; count],
            inverse_sizes: vec![0.0; n],
            follows,
            evaluations: 0,
            work: {
                let of_stage = field.work() + (2 * s * n + 6 * n) as u64;
                (s as u64 * of_stage).div_ceil(TOGETHER.min(W) as u64)
            },
            field,
        })
    }

    /// Evaluates F at the stages.
    #[inline(always)]
    pub(super) fn evaluate(&mut self) {
        self.field.evaluate();
    }

    /// Writes the stages that a solve begins at.
    #[inline(always)]
    pub(super) fn begin<R: Register>(&mut self, at: usize, from: From, start: Start<'_>) {
        let (z, n) = (start.point, start.point.len());
        let (rows, _) = self.field.rows_mut();
        let (stages, beside) = rows.split_at_mut(n);
        for c in 0..beside.len() {
            beside[c] = [start.beside[c]; W];
        }
        match from {
            From::Standing => {}
            From::State => {
                for c in 0..n {
                    stages[c] = [z[c]; W];
                }
            }
            From::Polynomial => {
                let slopes = &self.slopes[at * n..][..n];
                by_blocks!(R, n, c, K => {
                    let (z, slopes) = (block::<_, K>(z, c), block(slopes, c));
                    let stages: &mut [_; K] = block_mut(stages, c);
                    for first in (0..W).step_by(R::LANES) {
                        let begun: [R; K] = sums::<R, W, K, false>(z, &self.onward, slopes, first);
                        for c in 0..K {
                            begun[c].store(&mut stages[c][first..]);
                        }
                    }
                });
            }
        }
    }

    /// Keeps the slopes of the last evaluation and writes their sum; whether it is finite.
    #[inline(always)]
    pub(super) fn end(&mut self, at: usize, change: &mut [f64]) -> bool {
        let n = change.len();
        let (_, slopes) = self.field.rows_mut();
        let (slopes, own) = (&slopes[..n], &mut self.slopes[at * n..][..n]);
        let mut zero = 0.0;
        for c in 0..n {
            own[c] = slopes[c];
            let mut products = self.weights;
            for lane in 0..W {
                products[lane] *= slopes[c][lane];
            }
            change[c] = sum_of_lanes(&products);
            // 0·v is 0 where v is finite, and no number elsewhere.
            zero += 0.0 * change[c];
        }
        zero == 0.0
    }

    /// Corrects the stages by the slopes, of a z that may be 0; returns the largest component in units of its coordinate.
    #[inline(always)]
    pub(super) fn correct<R: Register, const IS_ZERO: bool>(&mut self, z: &[f64]) -> f64 {
        let (stages, slopes) = self.field.rows_mut();
        let n = z.len();
        let mut most = R::splat(0.0);
        by_blocks!(R, n, c, K => {
            let (z, slopes) = (block::<_, K>(z, c), block(slopes, c));
            let inverse: &[f64; K] = block(&self.inverse_sizes, c);
            let stages: &mut [_; K] = block_mut(stages, c);
            for first in (0..W).step_by(R::LANES) {
                let next: [R; K] = sums::<R, W, K, IS_ZERO>(z, &self.matrix, slopes, first);
                for c in 0..K {
                    let correction = next[c] - R::load(&stages[c][first..]);
                    most = (correction.abs() * R::splat(inverse[c])).larger(most);
                    next[c].store(&mut stages[c][first..]);
                }
            }
        });
        most.largest()
    }

    /// Does the same, and measures the coordinates anew; `whole` is the largest way from z, in the same units.
    #[inline(always)]
    pub(super) fn correct_measuring<R: Register, const IS_ZERO: bool>(
        &mut self,
        start: Start<'_>,
        whole: &mut f64,
    ) -> f64 {
        let (stages, slopes) = self.field.rows_mut();
        let n = start.point.len();
        let mut most = R::splat(0.0);
        by_blocks!(R, n, c, K => {
            let (z, slopes) = (block::<_, K>(start.point, c), block(slopes, c));
            let sizes: &[f64; K] = block(start.sizes, c);
            let inverse: &mut [f64; K] = block_mut(&mut self.inverse_sizes, c);
            let stages: &mut [_; K] = block_mut(stages, c);
            let mut corrections = [[0.0; W]; K];
            let mut ways = [R::splat(0.0); K];
            for first in (0..W).step_by(R::LANES) {
                let next: [R; K] = sums::<R, W, K, IS_ZERO>(z, &self.matrix, slopes, first);
                for c in 0..K {
                    let correction = next[c] - R::load(&stages[c][first..]);
                    correction.store(&mut corrections[c][first..]);
                    let way = match IS_ZERO {
                        true => next[c],
                        false => next[c] - R::splat(z[c]),
                    };
                    ways[c] = way.abs().larger(ways[c]);
                    next[c].store(&mut stages[c][first..]);
                }
            }
            for c in 0..K {
                let way = ways[c].largest();
                inverse[c] = 1.0 / (sizes[c].abs() + way + f64::MIN_POSITIVE);
                let way = way * inverse[c];
                *whole = if way > *whole { way } else { *whole };
                for first in (0..W).step_by(R::LANES) {
                    let correction = R::load(&corrections[c][first..]).abs();
                    most = (correction * R::splat(inverse[c])).larger(most);
                }
            }
        });
        most.largest()
    }
}
